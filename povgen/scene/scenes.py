"""Scenes: their parameters, with units and ranges. A scene never changes. Variants are copies.

Lengths are in tiles (the side of a floor tile), angles in degrees. The plane z = 0 is midway between the sheets of the
first window. Points in it are complex numbers x + iy, from this window's centre: x points right and y up, as the eye
sees them. z points away from the eye, which is at z = -z2. z1 is the distance of an object from the middle plane of the
last window.
"""

from cmath import isfinite
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from itertools import combinations, islice, pairwise
from math import hypot, inf, radians, remainder
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self, TypeAlias, TypeVar

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike
from PIL import ImageColor
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    model_validator,
)

from povgen import limits
from povgen.errors import InputError, at_least, at_most, input_errors, one_line, shown
from povgen.optics import apparent, equations, glasses
from povgen.optics.equations import Booleans, Complexes, Floats
from povgen.optics.ghosts import Ghost, ghosts
from povgen.optics.prism import Prism
from povgen.optics.rays import AT_ONCE, Bundle, Spot, Traced, checked_count, joined, pencil, spot, trace_windows
from povgen.record import Record, info
from povgen.scene import camera, pictures
from povgen.scene.pictures import Picture
from povgen.scene.pieces import PIECES, Piece, PieceFile, as_piece, radius
from povgen.scene.recorded import scenes
from povgen.scene.windows import (
    WINDOW,
    ParametersOfSheets,
    Placed,
    SheetName,
    Window,
    Windows,
    as_windows,
    has_glass,
    replaced_by,
)
from povgen.settings import as_size
from povgen.sheets import SHEETS
from povgen.sheets.law_grammar import Law
from povgen.sheets.layered import Layered
from povgen.sheets.lenticular import Lenticular
from povgen.sheets.parameters import INDEX, WAVELENGTH, design_index
from povgen.sheets.prisms import SHAPE, PrismPair, Prisms, shape_of
from povgen.sheets.profile import ProfileFile
from povgen.sheets.sheet import Ideal, Sheet
from povgen.validation import Model, as_flag, as_pair

T = TypeVar("T")
APERTURE = 3.0  # the default side of the window, tiles
VIEW = 3.7  # the default height of the picture in the plane z = 0, tiles, if it shows the whole window frame
MAX_VIEW = 100
PEDESTAL_EDGE = 0.03  # how far a pedestal extends beyond the piece's foot, tiles
MAX_DEPTH = 100  # of the sheets, tiles
MAX_DISTANCE = 5e6  # POV-Ray's units; its own limit is 10 million
MAX_SIDE = 16384  # of a picture, pixels
Side = Annotated[int, Field(ge=1, le=MAX_SIDE)]
Z1 = Annotated[float, Field(gt=0, le=5000)]
MAX_ASIDE = 10  # tiles
Aside = Annotated[float, Field(ge=-MAX_ASIDE, le=MAX_ASIDE)]


def _listed(value: object) -> object:
    """Return an array or another collection as a list, but one of a single value as this value. Other values stay."""
    value = value.tolist() if hasattr(value, "tolist") else value  # numpy's
    if isinstance(value, Collection) and not isinstance(value, (str, bytes, Mapping)):
        value = list(value)
        return value[0] if len(value) == 1 else value
    return value


def _kind(value: object) -> str:
    return "several" if isinstance(value, (list, tuple)) else "one"


def _tuple(value: T | tuple[T, ...]) -> tuple[T, ...]:
    return value if isinstance(value, tuple) else (value,)


def _piece(value: object) -> str | PieceFile:
    """Return a piece's name, or the `PieceFile` of its file. Raises ValueError for other values."""
    piece = as_piece(value)
    if not isinstance(piece, (str, PieceFile)):
        raise ValueError("should be a name or a file")
    return piece


def _colour(value: str) -> str:
    """Check a colour's name or code."""
    rgb(value)
    return value


def rgb(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue (sRGB, 0 to 1) of a colour's name or code. Raises ValueError for any other text."""
    try:
        parts = ImageColor.getrgb(colour)
        if len(parts) > 3 or max(parts) > 255:
            raise ValueError
    except ValueError:
        raise ValueError("should be a colour's name or code, and opaque") from None
    return parts[0] / 255, parts[1] / 255, parts[2] / 255


if TYPE_CHECKING:  # what is read; a user may give anything that becomes such a value, as an array or text
    Point = tuple[float, float] | Any
    OneOrMore: TypeAlias = T | tuple[T, ...] | Any
    PictureFile = Picture | Any
else:
    Point = Annotated[tuple[Aside, Aside], BeforeValidator(as_pair)]
    # one value, or one for each object
    OneOrMore = Annotated[
        Annotated[T, Tag("one")] | Annotated[tuple[T, ...], Field(min_length=1, max_length=50), Tag("several")],
        Discriminator(_kind),
        BeforeValidator(_listed),
    ]
    PictureFile = Picture
PieceValue = Annotated[Piece, BeforeValidator(_piece)]
Colour = Annotated[str, AfterValidator(_colour)]


@contextmanager
def _named(where: str) -> Iterator[None]:
    """Begin the message of a ValueError with the window that it is about."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{where}{error}") from None


def _index_of(window: "Scene | Window", where: str, wavelength: float) -> float | None:
    """Return the refractive index of a window's prisms, or None if the window uses that of the first window.

    `where` begins an error's message.
    """
    given: float | None = window.index
    if not has_glass(window):
        return given
    with _named(where):
        index = glasses.index(str(window.glass), wavelength * 1e-9)
    if "index" in window.model_fields_set and given != index:
        raise ValueError(f"{where}index = {given:g}, glass = {window.glass!r}: allowed: one of them")
    return index


def _for_no_glass(name: str, wavelength: float) -> str:
    return f"{name} = {wavelength:g}: needs a glass; allowed: with one, such as glass = BK7"


def _distances(z1: ArrayLike) -> Floats:
    """Return distances of objects as floats. Raises ValueError for one that is infinite or below 0."""
    checked = equations.real("z1", z1, 0)
    if (checked == inf).any():
        raise ValueError("z1 = inf; allowed: finite numbers, tiles")
    return checked


class _Picture(Model):
    size: Annotated[tuple[Side, Side], BeforeValidator(as_size)] = Field(
        description=f"WIDTHxHEIGHT, whole numbers of pixels from 1 to {MAX_SIDE}"
    )


class Scene(ParametersOfSheets):
    """What all scenes share: the eye, the windows and the sheets in them. The parameters of the sheets come first."""

    z2: Annotated[float, Field(gt=0, le=150)] = Field(
        default=6, description="distance from the sheets to the eye, up to 150 tiles; the default spheres move with it"
    )
    sheet: SheetName = Field(
        default="detailed",
        description=f"model of the sheets: {', '.join(SHEETS)}",
    )
    window: Windows = Field(default=(), description=WINDOW)
    wavelength: Annotated[float, Field(ge=180, le=10000)] = Field(
        default=WAVELENGTH,
        description="wavelength of light, for the index of a glass, 180 to 10000 nm; "
        "the picture's colours do not change",
    )
    fresnel: bool = Field(
        default=False, description="partial reflection at every face of the prisms; takes 4 to 13 times as long"
    )
    aperture: Annotated[float, Field(ge=0.5, le=10)] = Field(
        default=APERTURE,
        description="side of the square window, 0.5 to 10 tiles; in chess, the floor with all on it moves with the "
        "lower edge",
    )
    view: Annotated[float, Field(ge=0.1, le=MAX_VIEW)] = Field(
        default=VIEW,
        description=f"height of the picture in the plane of the sheets, 0.1 to {MAX_VIEW} tiles "
        f"(default: {VIEW}, or more if the first window's frame is larger)",
    )
    eye: Point = Field(
        default=(0, 0),
        description="the eye E as X,Y from the window's centre, to the right and up, -10 to 10 tiles; the objects and "
        "the window stay, and the window stays in the middle of the picture",
    )
    background: Literal["sky", "transparent", "black", "white"] = Field(
        default="sky", description="what is behind the scene: sky, transparent (PNG only), black or white"
    )

    sky: Annotated[PictureFile | None, BeforeValidator(pictures.sky)] = Field(
        default=None,
        description="mountains (povgen's own), or a picture of the surroundings: a PNG, JPEG, WebP, TIFF, HDR or EXR "
        "file, equirectangular, whose middle is straight ahead; with background = sky",
    )

    if TYPE_CHECKING:  # the names of changes are those of the parameters

        @property
        def replace(self) -> type[Self]: ...

    name: ClassVar[str]
    subject: ClassVar[str]
    rim: ClassVar[float] = 0.15  # width of the window frame's sides, tiles

    if (
        TYPE_CHECKING
    ):  # each scene defines L of its first object, and L and z1 of every object; L is projected onto z = 0

        @property
        def L(self) -> complex: ...

        @property
        def objects(self) -> tuple[tuple[complex, float], ...]: ...

    @classmethod
    def from_file(cls, path: object) -> Self:
        """Return the scene of a picture's file, with every parameter. It has the class that the file states.

        Raises InputError for a file that povgen did not write, for a movie, and for a scene of another class.
        """
        first, *others = cls.list_from_file(path)
        if others:
            raise InputError(
                f"{str(path)!r}: a movie of {len(others) + 1} frames; allowed: a picture, or list_from_file"
            )
        return first

    @classmethod
    def list_from_file(cls, path: object) -> list[Self]:
        """Return the scene of every frame of a movie's file, or the one of a picture's file, with every parameter.

        Raises InputError for a file that povgen did not write, and for scenes of another class.
        """
        _, scenes = recorded(path, cls)
        return scenes

    @property
    def distances(self) -> tuple[float, ...]:
        """z1 of every object: its distance from the middle plane of the last window, tiles."""
        return tuple(z1 for _, z1 in self.objects)

    @property
    def radii(self) -> tuple[float, ...]:
        """The radius of every object, tiles. The radius of a piece is that of its foot."""
        return (0.0,) * len(self.objects)

    @property
    def outlines(self) -> tuple[str, ...]:
        """The names of the parameters that draw an outline on the picture, and are true."""
        return ()

    @property
    def E(self) -> complex:
        """The eye, projected onto z = 0."""
        return complex(*self.eye)

    @property
    def prism(self) -> Prism:
        """The shape of the prisms in the first window. Lengths are in tiles. Windows behind it can have others."""
        return shape_of(self.values_of(self, SHAPE), self.aperture / self.prisms)

    @property
    def states(self) -> "tuple[Scene | Window, ...]":
        """What states the parameters of each window, the first one first: the scene, and each further `Window`."""
        return self, *self.window

    def values_of(self, window: "Scene | Window", names: Iterable[str]) -> dict[str, Any]:
        """Return parameters of one of `states`, by their names. What it does not state is the first window's."""
        return {name: getattr(self, name) if (own := getattr(window, name)) is None else own for name in names}

    @cached_property
    def windows(self) -> tuple[Placed, ...]:
        """The windows, the nearest to the eye first, each with its sheet."""

        def sheet(window: Scene | Window) -> Sheet:
            kind = SHEETS[window.sheet or self.sheet]
            return kind(self.values_of(window, [each.name for each in kind.parameters]), self.aperture)

        return (Placed(0.0, sheet(self)), *(Placed(window.z, sheet(window)) for window in self.window))

    @property
    def sheets(self) -> tuple[Sheet, ...]:
        """The sheets in each window, the first window first."""
        return tuple(window.sheet for window in self.windows)

    @property
    def rotates(self) -> bool:
        """Whether every window rotates light about its normal, as the paper's do."""
        return all(sheet.rotates for sheet in self.sheets)

    @property
    def used_parameters(self) -> set[str]:
        """The names of the sheets' parameters for which at least one window uses the scene's value."""
        windows = zip((None, *self.window), self.sheets, strict=True)
        named = ((window, each.name) for window, sheet in windows for each in sheet.parameters)
        return {name for window, name in named if window is None or getattr(window, name) is None}

    @property
    def only_rotates(self) -> bool:
        """Whether the sheets do no more than to rotate light about their normal. Windows may have none."""
        return all(sheet.rotates or sheet.name == "none" for sheet in self.sheets)

    @property
    def alphas(self) -> tuple[float, ...]:
        """The angle by which each window rotates light about its normal, degrees."""
        return tuple(sheet.values.get("alpha", 0.0) for sheet in self.sheets)

    @property
    def places(self) -> tuple[float, ...]:
        """z of each window, midway between its sheets, tiles."""
        return tuple(window.z for window in self.windows)

    @property
    def behind(self) -> tuple[tuple[float, float], ...]:
        """The windows behind the first one, as for `equations.depth`.

        Each is a pair: its distance from the window before it, tiles, and its alpha, radians.
        """
        turns = [radians(alpha) for alpha in self.alphas[1:]]
        return tuple((b - a, turn) for (a, b), turn in zip(pairwise(self.places), turns, strict=True))

    @property
    def elements(self) -> apparent.Windows:
        """The windows as in `optics.apparent`."""
        return self._elements(self.sheets)

    def _elements(self, sheets: tuple[Sheet, ...]) -> apparent.Windows:
        return [(b - a, sheet) for (a, b), sheet in zip(pairwise((-self.z2, *self.places)), sheets, strict=True)]

    def _with_alpha(self, alpha: ArrayLike | None) -> apparent.Windows:
        """Return the windows as in `optics.apparent`. `alpha`, in degrees, replaces that of the first window."""
        if alpha is None:
            return self.elements

        first, *others = self.sheets
        turned = type(first)({**first.values, "alpha": np.asarray(alpha, float)[()]}, first.aperture)
        return self._elements((turned, *others))

    @property
    def layered(self) -> tuple[Layered, ...]:
        """The sheets of prisms or lenses, the nearest to the eye first. Ideal ones stand before them."""
        return tuple(sheet for sheet in self.sheets if isinstance(sheet, Layered))

    @property
    def ideal(self) -> tuple[Ideal, ...]:
        """The ideal sheets, the first one first. They are nearer to the eye than windows of prisms."""
        return tuple(sheet for sheet in self.sheets if isinstance(sheet, Ideal))

    @property
    def has_prisms(self) -> bool:
        """Whether the sheets of a window consist of prisms, or of lenses."""
        return bool(self.layered)

    @property
    def is_empty(self) -> bool:
        """Whether no window has a sheet."""
        return {sheet.name for sheet in self.sheets} == {"none"}

    @property
    def sheets_depth(self) -> float:
        """The greatest extent along z of a window's sheets, tiles; 0 if all sheets are ideal.

        The middle of the sheets is at the window's z.
        """
        return max(sheet.depth for sheet in self.sheets)

    @property
    def depth(self) -> float:
        """Extent of the window frame along z, tiles: a tenth of the window's side, or more if the sheets need more."""
        return max(self.aperture / 10, 1.02 * self.sheets_depth)

    @property
    def default_view(self) -> float:
        """Height of the picture in the plane z = 0 that shows the first window's whole frame, tiles.

        This holds for pictures of 4:3 or wider. It is at least VIEW, and at most MAX_VIEW even if the frame needs more.
        """
        front, slant = -self.depth / 2, min(self.rim, self.depth)
        reach = 0.0
        for out, z in ((0.6, front), (0.75, front + 0.25 * slant), (1, front + 0.5 * slant)):  # frame.pov.j2
            scale = self.z2 / (self.z2 + z)  # from the plane z to the plane z = 0, seen from the eye
            for eye, shape in ((self.E.imag, 1), (self.E.real, 4 / 3)):
                reach = max(reach, (scale * (self.aperture / 2 + out * self.rim) + (scale - 1) * abs(eye)) / shape)
        return VIEW if 2 * reach <= VIEW else min(MAX_VIEW, 1.03 * 2 * reach)

    @input_errors()
    def apparent_position(
        self, L: ArrayLike, z1: ArrayLike, alpha: ArrayLike | None = None, near: ArrayLike = 0
    ) -> Complexes:
        """Return where the eye sees a point, in the plane z = 0: eq. 7, or what `apparent.position` finds.

        L (complex) and z1 are in tiles. alpha, in degrees, replaces the first window's own, if its sheet has an
        alpha. `near` is for sheets without a ray-transfer matrix: light that passes the point at up to this distance,
        in tiles, also counts. Arrays broadcast. The result is the complex infinity if the point appears at infinity. It
        is NaN if the eye sees the point in no direction, or in every direction. It is NaN if an argument is NaN, or L
        or alpha is infinite. Raises InputError for a z1 that is infinite or below 0.
        """
        z1, L, near = _distances(z1), np.asarray(L, complex), equations.real("near", near, 0)
        if alpha is not None:
            alpha = equations.real("alpha", alpha)
            alpha = np.where(np.isfinite(alpha), alpha, np.nan)[()]
        turns = 0 if alpha is None else alpha
        shape = np.broadcast_shapes(*map(np.shape, (L, z1, near, turns)))
        L = np.broadcast_to(np.where(np.isfinite(L) & ~np.isnan(near), L, np.nan), shape)
        if self.sheets[0].name == "ideal" and not self.window:  # no digits are lost near the pole
            turn = np.radians(self.alpha if alpha is None else np.fmod(alpha, 360))
            return equations.apparent_position(L, self.E, z1, self.z2, turn)
        elements = self._with_alpha(alpha)
        if alpha is not None and np.ndim(alpha) and apparent.matrix(elements) is None:
            # the search is for a single alpha
            return np.vectorize(self.apparent_position, otypes=[complex])(L, z1, alpha, near)
        return apparent.position(L, self.E, z1, elements, near, self.depth)

    def visible(self, L: ArrayLike, z1: ArrayLike, alpha: ArrayLike | None = None, near: ArrayLike = 0) -> Booleans:
        """Return whether light from a point reaches the eye through the windows, by the prediction.

        The light must pass inside each window frame's front and back, and inside each window at the middle planes of
        its sheets, where the prediction turns it. Arguments as for `apparent_position`.
        """
        return self.seen(L, z1, alpha, near)[1]

    def seen(
        self, L: ArrayLike, z1: ArrayLike, alpha: ArrayLike | None = None, near: ArrayLike = 0
    ) -> tuple[Complexes, Booleans]:
        """Return the apparent position of a point, and whether it is visible: `apparent_position` and `visible`."""
        position = self.apparent_position(L, z1, alpha, near)
        with np.errstate(invalid="ignore"):  # the position can be infinite
            slope = (position - self.E) / self.z2
        return position, apparent.passes(slope, self.E, self._with_alpha(alpha), self.depth)

    @input_errors()
    def ghosts(self, L: complex, z1: float, least: float = 0.05) -> list[Ghost]:
        """Return the ghosts of a point through a window of lenses: images by light that passes over to the next lens.

        L (complex) and z1 are in tiles. Ghosts with a share (`Ghost.share`, 0 to 1) below `least` are left out. So are
        ghosts whose position is outside the opening of the window's frame. The list is empty for several windows, for
        ideal sheets and Dove prisms, and for an L that is NaN or infinite. Raises InputError for a z1 that is infinite
        or below 0.
        """
        _distances(z1)
        if self.window or not self.layered or not isfinite(L):
            return []
        return ghosts(L, self.E, z1, self.z2, self.layered[0].layers_at(0.0, 0), self.aperture, least)

    @input_errors()
    def nu_and_M(self, z1: ArrayLike) -> tuple[Floats, Floats]:
        """Return the angle nu, degrees, through which the windows show an object turned, and its magnification M.

        For a single window with the sheet "ideal" they are eqs. 8 and 9, corrected (docs/errata.md). Otherwise they are
        those of `apparent.nu_and_M`. nu is positive if the object appears turned counter-clockwise. Let s be the sum of
        all alphas, reduced to -180 to 180 degrees. Of all equivalent angles, nu is the one within 180 degrees of s/2.
        At the pole nu is NaN and M is infinite. For a mirrored object nu is NaN. nu and M are NaN if a sheet does more
        than to rotate light about its normal, because it can distort an object. z1 is in tiles; arrays broadcast.
        Raises InputError for a z1 that is infinite or below 0.
        """
        z1 = _distances(z1)
        if not self.only_rotates:
            return (nothing := np.full(np.shape(z1), np.nan)[()]), nothing
        alpha = remainder(sum(self.alphas), 360)
        if self.sheets[0].name == "ideal" and not self.window:
            r = equations.r(z1, self.z2)
            nu, M = equations.nu(r, radians(self.alpha)), equations.M(r, radians(self.alpha))
        else:
            nu, M = apparent.nu_and_M(z1, self.elements)
        return alpha / 2 + np.remainder(np.degrees(nu) - alpha / 2 + 180, 360) - 180, M

    @input_errors()
    def rays(self, size: str | Sequence[int]) -> Bundle:
        """Return a ray from the eye for each pixel of a picture: `size` is its width and height, or text as '64x48'.

        The rays' positions, in tiles, and their unit directions are arrays (height, width, 3). The first row is the top
        one. Raises InputError for a width or a height that is not a whole number from 1 to MAX_SIDE, and for
        more than 40 million pixels.
        """
        width, height = _Picture(size=size).size
        if width * height > AT_ONCE:
            raise InputError(f"size = {width}x{height}: allowed: up to {AT_ONCE} rays at once")
        return camera.bundle(self, (width, height))

    @input_errors()
    def pencil(
        self, point: ArrayLike, count: int = 1000, middle: complex = 0, radius: float | None = None, seed: int = 1
    ) -> Bundle:
        """Return `count` rays from a point (x, y, z), in tiles, to random points of a disc in a window.

        The window is the one nearest to the point. Rays from a point behind the last window run towards the eye, as
        light does. A point before the first window has z < 0, and its rays run away from the eye. `middle` is the
        disc's centre, x + iy, and `radius` its radius, both in tiles. By default the disc is the largest that the
        window contains. The same `seed` gives the same rays. Raises InputError for a point between the windows, and for
        numbers outside their ranges.
        """
        count = checked_count("count", count, AT_ONCE)
        return joined(pencil(self.windows, point, count, middle, self.aperture / 2 if radius is None else radius, seed))

    @input_errors()
    def trace(self, rays: Bundle, max_faces: int = 60, partial: Generator | None = None) -> Traced:
        """Follow rays through the windows, exactly: through prisms and ideal sheets. Objects do not stop them.

        Positions are in tiles. A ray ends after it has met `max_faces` faces of prisms or lenses. If `partial`, a
        generator of random numbers, is given, a face that refracts light also reflects a part of it (`optics.trace`).
        Otherwise reflection is only total. Raises InputError for a ray that does not start outside the windows, or does
        not run towards them, and for a `max_faces` that is not a whole number from 1 to 100,000.
        """
        return trace_windows(rays, self.windows, self.aperture, self.depth, max_faces, partial)

    @input_errors()
    def spot(
        self,
        point: ArrayLike,
        z: float,
        count: int = 10_000,
        middle: complex = 0,
        radius: float | None = None,
        seed: int = 1,
        stray: bool = False,
    ) -> Spot:
        """Return the spot diagram of light from a point: where a `pencil` crosses the plane z, in tiles.

        The rays are extended both ways, so that the plane can be that of a virtual image. Only rays that leave on the
        designed path count. With `stray`, all rays that leave the last window on the far side count. Rays are traced a
        part at a time, so memory is needed for the points of the diagram only. Other arguments and errors are those of
        `pencil`. Raises InputError for a z that is not finite, too.
        """
        radius = self.aperture / 2 if radius is None else radius
        parts = pencil(self.windows, point, count, middle, radius, seed)
        return spot((self.trace(rays) for rays in parts), z, as_flag("stray", stray))

    @property
    def tile(self) -> int:
        """POV-Ray's units per tile."""
        return limits.units_per_tile(min((sheet.pitch for sheet in self.layered), default=1))

    def _check_clear(self, what: str, z1: float, nearest: float) -> None:
        if z1 <= nearest:
            raise ValueError(
                f"z1 = {z1:g}: {what} would touch the window frame around the sheets, whose back is at "
                f"z = {self.places[-1] + self.depth / 2:.4g} tiles; allowed: z1 > {at_least(nearest)}"
            )
        if z1 > self.farthest:
            counts = {sheet.values[sheet.counted]: sheet.counted for sheet in self.layered}
            what = f"with {max(counts)} {counts[max(counts)]}" if counts else f"behind z = {self.places[-1]:g}"
            raise ValueError(f"z1 = {z1:g}: beyond POV-Ray's range {what}; allowed: z1 <= {at_most(self.farthest)}")

    @property
    def farthest(self) -> float:
        """The greatest z1, tiles."""
        return MAX_DISTANCE / self.tile - self.places[-1]

    def _replaced_by(self, changes: dict[str, object]) -> set[str]:
        if "window" not in changes:
            return replaced_by(changes, self.window)
        changes["window"] = windows = as_windows(changes["window"])  # once: they can be given as an iterator
        return replaced_by(changes, windows)

    @model_validator(mode="after")
    def _find_indices(self) -> Self:
        """Set the index of named glasses for light. Checks, renderers and predictions then need the index alone."""
        object.__setattr__(self, "index", _index_of(self, "", self.wavelength))  # the model is frozen
        self.model_fields_set.discard("index" if self.glass != "none" else "")
        found: list[Window] = []
        for number, window in enumerate(self.window, 2):
            own = window.model_copy()
            if own.glass is None and own.index is not None:  # else it would get the first window's glass, and its index
                object.__setattr__(own, "glass", "none")
            if own.glass == "none" and own.index is None and has_glass(self):  # the first window's index is its glass's
                object.__setattr__(own, "index", INDEX.default)
            object.__setattr__(own, "index", _index_of(own, f"window {number}, ", self.wavelength))
            if has_glass(own):  # the index is found, not given
                own.model_fields_set.discard("index")
            found.append(own)
        object.__setattr__(self, "window", tuple(found))
        for name in ("wavelength", "design_wavelength") if not any(map(has_glass, (self, *found))) else ():
            if (value := getattr(self, name)) != WAVELENGTH:
                raise ValueError(_for_no_glass(name, value))
        return self

    @model_validator(mode="after")
    def _check_shapes(self) -> Self:
        for number, (window, sheet) in enumerate(zip(self.states, self.sheets, strict=True), 1):
            values, where = self.values_of(window, SHAPE), f"window {number}, " if number > 1 else ""
            with _named(where):
                if number > 1 and window.design_wavelength is not None and values["glass"] == "none":
                    raise ValueError(_for_no_glass("design_wavelength", window.design_wavelength))
                planned = Prism(1.0, design_index(values), values["base_angle"], aspect=values["aspect"])
            if number > 1 and not isinstance(sheet, Prisms):  # the first shape is checked even if no window has prisms
                continue
            if planned.aspect == 2:
                raise ValueError(f"{where}aspect = 2: no light would take the designed path; allowed: below 2")
            if planned.aspect <= (least := planned.least_aspect):
                raise ValueError(
                    f"{where}aspect = {planned.aspect:g}: the slanted facets of prisms with index = {planned.index:g} "
                    f"and base_angle = {planned.base_angle:g} would cross; allowed: {at_least(least)} < aspect < 2"
                )
        return self

    @model_validator(mode="after")
    def _check_depths_and_eye(self) -> Self:
        for number, sheet in enumerate(self.sheets, 1):
            where = f"window {number}, " if number > 1 else ""
            with _named(where):  # errors out of range, lenses of a shape that does not exist
                if isinstance(sheet, (PrismPair, Lenticular)):
                    sheet.check_errors()
                depth = sheet.depth
            if not sheet.is_exact and self.window:
                raise ValueError("error: only for a single window; allowed: no errors with --window")
            if depth > MAX_DEPTH:
                assert isinstance(sheet, Layered)  # others have no depth
                what = "prisms" if isinstance(sheet, Prisms) else "profile"
                raise ValueError(
                    f"{where}{sheet.counted} = {sheet.values[sheet.counted]}: with this shape of the {what} and "
                    f"aperture = {self.aperture:g} the sheets would be {depth:.4g} tiles deep; "
                    f"allowed: up to {MAX_DEPTH} tiles, as with more {sheet.counted}"
                )
        nearest = self.depth / 2 + 0.01
        if self.z2 <= nearest:
            raise ValueError(
                f"z2 = {self.z2:g}: the eye would be inside the window frame; allowed: z2 > {at_least(nearest)}"
            )
        return self

    @model_validator(mode="after")
    def _show_whole_frame(self) -> Self:
        if "view" not in self.model_fields_set:
            object.__setattr__(self, "view", self.default_view)  # the model is frozen
        return self

    @model_validator(mode="after")
    def _check_sheets(self) -> Self:
        # a law is checked even if no window has it
        for number, window in enumerate(self.states, 1):
            text, parameters = self.values_of(window, ("law", "parameter")).values()
            try:
                Law(text, parameters).check_divisions(parameters)
            except ValueError as error:
                where = f"window {number}, law" if number > 1 else "law"
                raise ValueError(f"{where} = {shown(text)}: {error}") from None
        return self

    @model_validator(mode="after")
    def _check_windows(self) -> Self:
        for number, (before, z) in enumerate(pairwise(self.places), 2):
            least = before + self.depth + 0.01
            if z <= least:
                raise ValueError(
                    f"window {number}, z = {z:g}: its frame would touch that of the window before, at z = {before:g}; "
                    f"allowed: z > {at_least(least)}"
                )
        if any(sheet.layers for sheet in self.sheets[: len(self.ideal)]):
            raise ValueError(
                "window: an ideal one behind one of prisms, but the camera simulates ideal sheets, and its rays meet "
                "them before all prisms; allowed: ideal windows, and those without sheets, first"
            )
        return self


class Standing(NamedTuple):
    """A piece on its pedestal. Lengths are in tiles."""

    piece: str | PieceFile
    x: float
    z1: float
    colour: tuple[float, float, float]  # red, green and blue (sRGB), 0 to 1
    radius: float  # of the foot


class Chess(Scene):
    """Chess pieces on pedestals, seen through the window (figures 3 and 4). L is the centre of a foot.

    Pedestals and window frame stand on a chessboard floor.

    Each of x, z1, piece and color is one value for all pieces, or a list with a value for each.
    """

    name: ClassVar[str] = "chess"
    subject: ClassVar[str] = "a chess scene seen through a window of ray-rotating Dove-prism sheets"

    z1: OneOrMore[Z1] = Field(
        default=2,
        description="distance from the sheets to the piece's axis, up to 5000 tiles; one, or one for each piece",
    )
    x: OneOrMore[Aside] = Field(
        default=0,
        description="x of the piece, from the window's centre to the right, -10 to 10 tiles; "
        "one, or one for each piece",
    )
    piece: OneOrMore[PieceValue] = Field(
        default="knight",
        description=f"the chess piece: {', '.join(PIECES)}, a file that declares Piece in POV-Ray's language, or a "
        "mesh (.stl, .obj, .ply or .glb), as model.stl,height=1.2,up=z; one, or one for each piece",
    )
    color: OneOrMore[Colour] = Field(
        default="#e7b56f",
        description="colour of the wood: a name, or a code such as #c87529; one, or one for each piece",
    )
    pedestal: Annotated[float, Field(ge=0, le=10)] = Field(
        default=0.8,
        description="height of the pieces' pedestals, 0 to 10 tiles; the pieces move with it; "
        "0: they stand on the floor",
    )
    floor: Annotated[PictureFile | Literal["tiles", "none"], BeforeValidator(pictures.floor)] = Field(
        default="tiles",
        description="the floor: tiles, none, or a picture's file, of which copies cover the floor, 2 tiles wide or as "
        "wood.jpg,width=4 says",
    )
    predicted_image: bool = Field(default=False, description="outline the piece where the equations predict it")
    direct_image: bool = Field(default=False, description="outline the piece as it is seen without sheets")

    @property
    def pieces(self) -> tuple[Standing, ...]:
        """Every piece."""
        values = [_tuple(value) for value in (self.piece, self.x, self.z1, self.color)]
        count = max(map(len, values))
        shared = [value * count if len(value) == 1 else value for value in values]
        return tuple(
            Standing(piece, x, z1, rgb(color), radius(piece)) for piece, x, z1, color in zip(*shared, strict=True)
        )

    @property
    def L(self) -> complex:
        """Centre of the first piece's foot, projected onto z = 0."""
        return self.objects[0][0]

    @property
    def objects(self) -> tuple[tuple[complex, float], ...]:
        """L (the centre of the foot, projected onto z = 0) and z1 of every piece, tiles."""
        return tuple((complex(piece.x, self.floor_y + self.pedestal), piece.z1) for piece in self.pieces)

    @property
    def radii(self) -> tuple[float, ...]:
        return tuple(piece.radius for piece in self.pieces)

    @property
    def outlines(self) -> tuple[str, ...]:
        return tuple(name for name in ("predicted_image", "direct_image") if getattr(self, name))

    @property
    def floor_y(self) -> float:
        """Height of the floor, on which window frame and pedestals stand, relative to the window's centre, tiles."""
        return -(self.aperture / 2 + self.rim)

    @model_validator(mode="after")
    def _check_pieces(self) -> Self:
        values = {name: getattr(self, name) for name in ("piece", "x", "z1", "color")}
        counts = {name: len(value) for name, value in values.items() if isinstance(value, tuple)}
        if len(set(counts.values())) > 1:
            given = ", ".join(f"{count} values of {name}" for name, count in counts.items())
            raise ValueError(f"{given}: allowed: one value of each, or equal numbers of values")
        if self.eye[1] <= self.floor_y:
            raise ValueError(
                f"eye = {self.eye[0]:g},{self.eye[1]:g}: the eye would be under the floor; "
                f"allowed: Y > {self.floor_y:g}"
            )
        for piece, _, z1, _, foot in self.pieces:
            what = "the piece" if isinstance(piece, PieceFile) else f"the {piece}"
            self._check_clear(what, z1, self.depth / 2 + foot + (PEDESTAL_EDGE if self.pedestal else 0))
        for one, other in combinations(self.pieces, 2):
            aside, behind = abs(one.x - other.x), abs(one.z1 - other.z1)
            # pedestals are square, feet are round
            apart = max(aside, behind) if self.pedestal else hypot(aside, behind)
            least = one.radius + other.radius + (2 * PEDESTAL_EDGE if self.pedestal else 0)
            if apart < least - 1e-9:  # for rounding errors
                raise ValueError(
                    f"two pieces, at x = {one.x:g}, z1 = {one.z1:g} and at x = {other.x:g}, z1 = {other.z1:g}, "
                    f"overlap; allowed: at least {at_least(least)} tiles apart"
                    f"{' along x or z' if self.pedestal else ''}"
                )
        return self

    @model_validator(mode="after")
    def _check_predicted_image(self) -> Self:
        other = [sheet.name for sheet in self.sheets if not sheet.rotates]
        if self.predicted_image and other:
            raise ValueError(
                f"predicted_image = true: the prediction is for two sheets, but sheet = {other[0]!r}; "
                "allowed: sheet = 'detailed' or 'ideal'"
            )
        for z1 in self.distances if self.predicted_image else ():
            if not isfinite(self.apparent_position(self.E + 1 + 1j, z1)):
                raise ValueError(
                    f"predicted_image = true: at alpha = {self.alpha:g}, z1 = {z1:g} and z2 = {self.z2:g} the piece "
                    "appears at infinity; allowed: any other alpha, z1 or z2"
                )
        return self


class Spheres(Scene):
    """Coloured spheres on a line perpendicular to the sheets (figure 6). L is where the line crosses z = 0."""

    name: ClassVar[str] = "spheres"
    subject: ClassVar[str] = (
        "spheres on a line perpendicular to ray-rotating Dove-prism sheets, seen through the sheets"
    )

    z1: OneOrMore[Z1] | None = Field(
        default=None,
        description="distance from the sheets to a sphere, up to 5000 tiles; one for each sphere "
        "(default 2^n z2, n = -5..5, if the sphere is clear of the sheets)",
    )
    line: Point = Field(
        default=(-0.8, 0),
        description="the line of the spheres as X,Y from the window's centre, to the right and up, -10 to 10 tiles",
    )

    @property
    def L(self) -> complex:
        """Where the line of the spheres crosses the plane z = 0."""
        return complex(*self.line)

    @property
    def objects(self) -> tuple[tuple[complex, float], ...]:
        """L (projected onto z = 0) and z1 of every sphere, tiles."""
        if self.z1 is not None:
            return tuple((self.L, z1) for z1 in _tuple(self.z1))
        nearest, farthest = self.nearest, self.farthest
        return tuple((self.L, z1) for n in range(-5, 6) if nearest < (z1 := 2.0**n * self.z2) <= farthest)

    @property
    def radii(self) -> tuple[float, ...]:
        return tuple(self.radius(z1) for z1 in self.distances)

    def radius(self, z1: float) -> float:
        """Return the radius of the sphere at z1, tiles.

        At alpha = 0, a farther sphere appears larger than a nearer one, so that no sphere is hidden completely.
        """
        growth: float = (z1 / self.z2) ** 0.1
        return min(0.085 * growth * (1 + z1 / self.z2), z1 / 6)

    @property
    def nearest(self) -> float:
        """The least z1 at which a sphere does not touch the window frame, tiles."""
        z1 = back = self.depth / 2
        for _ in range(30):  # converges, because a radius is at most a sixth of z1
            z1 = back + self.radius(z1)
        return z1

    @model_validator(mode="after")
    def _check_spheres(self) -> Self:
        nearest = self.nearest
        for z1 in self.distances:
            self._check_clear("the sphere", z1, nearest)
        return self


def checked_scene(scene: object) -> Scene:
    """Return the scene. Raises InputError if it is none."""
    if not isinstance(scene, Scene) or not hasattr(scene, "name"):  # `Scene` itself has no name
        raise InputError(f"scene = {shown(scene)}: should be a scene; allowed: Chess(...) or Spheres(...)")
    return scene


def checked_scenes(scenes: Iterable[object], most: int) -> list[Scene]:
    """Return the scenes as a list. Raises InputError for more than `most`, as of an endless generator, or for no scene.

    An empty list is allowed.
    """
    found = [checked_scene(scene) for scene in islice(scenes, most + 1)]
    if len(found) > most:
        raise InputError(f"more than {most} scenes; allowed: up to {most}")
    return found


def pieces(scene: Scene) -> dict[str, str | PieceFile]:
    """Return the pieces that a scene shows, by their names."""
    return {str(standing.piece): standing.piece for standing in scene.pieces} if isinstance(scene, Chess) else {}


def input_files(scenes: Iterable[Scene]) -> set[str]:
    """Return the paths of the files that the scenes show: pieces, profiles, and pictures of sky and floor."""
    found: set[str] = set()
    for scene in scenes:
        parts = [*pieces(scene).values(), scene.sky, getattr(scene, "floor", None)]
        found |= {part.path for part in parts if isinstance(part, (PieceFile, Picture))}
        found |= {profile.path for profile in profile_files(scene)}
    return found


def with_seen_files(scene: Scene) -> Scene:
    """Return the scene without the files that it does not show: a sky behind another background, unused profiles."""
    used = [sheet.values.get("profile") for sheet in scene.sheets]

    def unused(window: Scene | Window) -> bool:
        return isinstance(window.profile, ProfileFile) and window.profile not in used

    changes: dict[str, object] = {} if scene.background == "sky" else {"sky": None}
    if unused(scene):
        changes["profile"] = type(scene).model_fields["profile"].default
    if any(map(unused, scene.window)):
        changes["window"] = [window.replace(profile=None) if unused(window) else window for window in scene.window]
    return scene.model_copy(update=changes)


def profile_files(scene: Scene) -> list[ProfileFile]:
    """Return the files that state profiles of a scene's windows, also those that its sheets do not use."""
    return [window.profile for window in scene.states if isinstance(window.profile, ProfileFile)]


SCENES = {scene.name: scene for scene in (Chess, Spheres)}


def recorded(path: Any, kind: type[Scene] = Scene) -> tuple[Record, list[Any]]:  # noqa: ANN401  (any object)
    """Return the record in a file that povgen wrote, and the scene of every frame, of this class. Raises InputError."""
    record = info(path)
    known = {**SCENES, **({kind.name: kind} if hasattr(kind, "name") else {})}
    try:
        return record, scenes(record, {name: scene for name, scene in known.items() if issubclass(scene, kind)})
    except InputError as error:
        raise InputError(f"{str(path)!r}: its record, of povgen {one_line(record.povgen)[:20]}: {error}") from None
