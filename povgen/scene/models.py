"""Scenes: their parameters, with units and ranges. A scene never changes. Variants are copies.

Lengths are in tiles (the side of a floor tile), angles in degrees. The plane z = 0 is midway between the sheets. Points
in it are complex numbers x + iy, from the window's centre: x points right and y up, as the eye sees them.
"""

from cmath import isfinite
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import combinations, pairwise
from math import hypot, radians, remainder
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self, TypeVar

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    model_validator,
)

from povgen import limits
from povgen.errors import InputError, shown
from povgen.model import as_pair
from povgen.optics.prism import Prism
from povgen.scene.pieces import PIECES, Piece, PieceFile, as_piece, radius
from povgen.scene.windows import WINDOW, ParametersOfSheets, Placed, SheetName, Window, Windows
from povgen.sheets import SHEETS
from povgen.sheets.law import Law
from povgen.sheets.prisms import PRISMS
from povgen.sheets.sheet import Ideal, Sheet

if TYPE_CHECKING:  # numpy is slow to load
    from numpy.typing import ArrayLike

    from povgen.optics import aim
    from povgen.optics.rotation import Booleans, Complexes, Floats

T = TypeVar("T")
APERTURE = 3.0  # the default side of the window, tiles
VIEW = 3.7  # the default height of the picture in the plane z = 0, tiles, if it shows the whole window frame
MAX_VIEW = 100
PEDESTAL_EDGE = 0.03  # how far a pedestal extends beyond the piece's foot, tiles
MAX_DEPTH = 100  # of the sheets, tiles
MAX_DISTANCE = 5e6  # POV-Ray's units; its own limit is 10 million
Z1 = Annotated[float, Field(gt=0, le=5000)]
Aside = Annotated[float, Field(ge=-10, le=10)]


Point = Annotated[tuple[Aside, Aside], BeforeValidator(as_pair)]


def _listed(value: object) -> object:
    """Accept an array or another collection as a list, and a collection of a single value in place of this value."""
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
    """Return a piece's name, or its file's text."""
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
    from PIL import ImageColor

    try:
        parts = ImageColor.getrgb(colour)
        if len(parts) > 3 or max(parts) > 255:
            raise ValueError
    except ValueError:
        raise ValueError("should be a colour's name or code, and opaque") from None
    return parts[0] / 255, parts[1] / 255, parts[2] / 255


# one value, or one for each object
OneOrMore = Annotated[
    Annotated[T, Tag("one")] | Annotated[tuple[T, ...], Field(min_length=1, max_length=50), Tag("several")],
    Discriminator(_kind),
    BeforeValidator(_listed),
]
PieceValue = Annotated[Piece, BeforeValidator(_piece)]
Colour = Annotated[str, AfterValidator(_colour)]


class Scene(ParametersOfSheets):
    """What all scenes share: the eye, the windows and the sheets in them. The parameters of the sheets come first."""

    z2: Annotated[float, Field(gt=0, le=150)] = Field(
        6, description="distance from the sheets to the eye, up to 150 tiles; the default spheres move with it"
    )
    sheet: SheetName = Field(
        "detailed",
        description=f"model of the sheets: {', '.join(f'{kind.name} ({kind.title})' for kind in SHEETS.values())}",
    )
    window: Windows = Field((), description=WINDOW)
    fresnel: bool = Field(
        False, description="partial reflection at every face of the prisms; takes seven to nine times as long"
    )
    aperture: Annotated[float, Field(ge=0.5, le=10)] = Field(
        APERTURE,
        description="side of the square window, 0.5 to 10 tiles; in chess, the floor with all that stands on it moves "
        "with the lower edge",
    )
    view: Annotated[float, Field(ge=0.1, le=MAX_VIEW)] = Field(
        VIEW,
        description=f"height of the picture in the plane of the sheets, 0.1 to {MAX_VIEW} tiles "
        f"(default: {VIEW}, or more if the first window's frame is larger)",
    )
    eye: Point = Field(
        (0, 0),
        description="the eye E as X,Y from the window's centre, to the right and up, -10 to 10 tiles; the objects and "
        "the window stay, and the window stays in the middle of the picture",
    )
    background: Literal["sky", "transparent", "black", "white"] = Field(
        "sky", description="what is behind the scene: sky, transparent (PNG only), black or white"
    )

    if TYPE_CHECKING:  # the fields that come from the sheets' parameters

        def __getattr__(self, name: str) -> Any: ...  # noqa: ANN401

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

    @property
    def distances(self) -> tuple[float, ...]:
        """z1 of every object, tiles."""
        return tuple(z1 for _, z1 in self.objects)

    @property
    def radii(self) -> tuple[float, ...]:
        """The radius of every object, tiles: of a piece that of its foot."""
        return (0.0,) * len(self.objects)

    @property
    def E(self) -> complex:
        """The eye, projected onto z = 0."""
        return complex(*self.eye)

    @property
    def prism(self) -> Prism:
        """The shape of the prisms. Lengths are in tiles."""
        return Prism(self.aperture / self.prisms, self.index, self.base_angle, self.gap, self.aspect)

    @cached_property
    def windows(self) -> tuple[Placed, ...]:
        """The windows, the nearest to the eye first, each with its sheet."""

        def sheet(window: Scene | Window) -> Sheet:
            kind = SHEETS[window.sheet or self.sheet]
            own = {each.name: getattr(window, each.name) for each in kind.parameters}
            return kind({name: getattr(self, name) if x is None else x for name, x in own.items()}, self.aperture)

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
    def alphas(self) -> tuple[float, ...]:
        """The angle by which each window rotates light about its normal, degrees."""
        return tuple(sheet.values.get("alpha", 0.0) for sheet in self.sheets)

    @property
    def places(self) -> tuple[float, ...]:
        """z of each window, midway between its sheets, tiles."""
        return tuple(window.z for window in self.windows)

    @property
    def behind(self) -> tuple[tuple[float, float], ...]:
        """The windows behind the first one, as in `rotation.depth`: (distance from the one before, alpha, radians)."""
        turns = [radians(alpha) for alpha in self.alphas[1:]]
        return tuple((b - a, turn) for (a, b), turn in zip(pairwise(self.places), turns, strict=True))

    @property
    def elements(self) -> "aim.Windows":
        """The windows as in `optics.aim`."""
        return [(b - a, sheet) for (a, b), sheet in zip(pairwise((-self.z2, *self.places)), self.sheets, strict=True)]

    @property
    def prisms_by_window(self) -> tuple[Prism, ...]:
        """The shape of the prisms in each window. Those of an ideal sheet have no size."""
        return tuple(self.prism if sheet.layers else Prism(0.0) for sheet in self.sheets)

    @property
    def ideal(self) -> tuple[Ideal, ...]:
        """The ideal sheets, the first one first. They are nearer to the eye than windows of prisms."""
        return tuple(sheet for sheet in self.sheets if isinstance(sheet, Ideal))

    @property
    def has_prisms(self) -> bool:
        """Whether the sheets of a window consist of prisms."""
        return any(sheet.layers for sheet in self.sheets)

    @property
    def is_empty(self) -> bool:
        """Whether no window has a sheet."""
        return {sheet.name for sheet in self.sheets} == {"none"}

    @property
    def sheets_depth(self) -> float:
        """Extent along z of the sheets in a window of prisms, tiles; 0 without prisms. Its middle is the window's z."""
        return max(sheet.depth for sheet in self.sheets)

    @property
    def depth(self) -> float:
        """Extent of the window frame along z, tiles: a tenth of the window's side, or more if the sheets need more."""
        return max(self.aperture / 10, 1.02 * self.sheets_depth)

    @property
    def default_view(self) -> float:
        """Height of the picture in the plane z = 0 that shows the first window's whole frame, tiles; at least VIEW.

        This holds for pictures of 4:3 or wider.
        """
        front, slant = -self.depth / 2, min(self.rim, self.depth)
        reach = 0.0
        for out, z in ((0.6, front), (0.75, front + 0.25 * slant), (1, front + 0.5 * slant)):  # frame.pov.j2
            scale = self.z2 / (self.z2 + z)  # from the plane z to the plane z = 0, seen from the eye
            for eye, shape in ((self.E.imag, 1), (self.E.real, 4 / 3)):
                reach = max(reach, (scale * (self.aperture / 2 + out * self.rim) + (scale - 1) * abs(eye)) / shape)
        return VIEW if 2 * reach <= VIEW else min(MAX_VIEW, 1.03 * 2 * reach)

    def apparent_position(
        self, L: "ArrayLike", z1: "ArrayLike", alpha: "ArrayLike | None" = None, near: "ArrayLike" = 0
    ) -> "Complexes":
        """Return where the eye sees a point, in the plane z = 0: eq. 7, or for prisms the paraxial prediction.

        Several windows act as in `rotation.depth`. L (complex) and z1 are in tiles. alpha, in degrees, replaces the
        first window's own if all windows rotate light. `near` is for sheets without a ray-transfer matrix: the
        distance, in tiles, at which light may pass the point (`aim.position`). Arrays broadcast.
        """
        import numpy  # slow to load, and few scenes need a prediction

        from povgen.optics import aim, paraxial, rotation

        if not self.rotates:
            return aim.position(L, self.E, z1, self.elements, near)
        turn = numpy.radians(self.alpha if alpha is None else alpha)
        if self.has_prisms:
            return paraxial.apparent_position(L, self.E, z1, self.z2, turn, self.prisms_by_window, self.behind)
        return rotation.apparent_position(L, self.E, z1, self.z2, turn, self.behind)

    def visible(
        self, L: "ArrayLike", z1: "ArrayLike", alpha: "ArrayLike | None" = None, near: "ArrayLike" = 0
    ) -> "Booleans":
        """Return whether light from a point reaches the eye through the windows, by the prediction.

        The light must pass inside each window frame's front and back, and inside each window at the middle planes of
        its sheets, where the prediction turns it. Arguments as for `apparent_position`.
        """
        import numpy

        from povgen.optics import aim, paraxial

        turn = numpy.radians(self.alpha if alpha is None else alpha)

        def around(k: int, z: float) -> "Sequence[Complexes]":
            """Where light crosses the planes at a distance z before window k and behind it."""
            if not self.rotates:
                before, slope, behind, after = followed[k]
                return before - z * slope, behind + z * after
            distance = self.behind[k - 1][0] if k else self.z2
            found = []
            for passed, at in ((k, distance - z), (k + 1, z)):
                if not passed:
                    found.append(self.E + slope_at_eye * at)
                    continue
                A, B = paraxial.depths(at, self.z2, turn, self.prisms_by_window[:passed], self.behind[: passed - 1])
                found.append(self.E + A * slope_at_eye + B * slope_at_eye.conjugate())
            return found

        with numpy.errstate(invalid="ignore"):
            slope_at_eye = (self.apparent_position(L, z1, alpha, near) - self.E) / self.z2
            followed = [] if self.rotates else aim.follow(slope_at_eye, self.E, self.elements)
            crossed: list[Complexes] = []
            for k, sheet in enumerate(self.sheets):
                middle = self.prism.separation / 2 if sheet.layers == 2 else 0.0  # |z| of a sheet's middle plane
                for z in (self.depth / 2, middle):
                    crossed += around(k, z)
        half = self.aperture / 2
        return numpy.all([(abs(point.real) < half) & (abs(point.imag) < half) for point in crossed], axis=0)

    def nu_and_M(self, z1: "ArrayLike") -> tuple["Floats", "Floats"]:
        """Return the angle nu, degrees, through which the windows show an object turned, and its magnification M.

        They are eqs. 8 and 9, corrected, or for prisms of finite size or several windows those of `paraxial.nu_and_M`.
        Let s be the sum of all alphas, reduced to -180 to 180 degrees. Of all equivalent angles, nu is the one within
        180 degrees of s/2. nu is NaN at the pole, and for a mirrored object. Both are NaN if a window does not rotate
        light: then it can distort an object. z1 is in tiles; arrays broadcast.
        """
        import numpy

        from povgen.optics import paraxial, rotation

        if self.is_empty:
            straight = numpy.add(self.z2 + self.places[-1], z1)
            return numpy.zeros(straight.shape)[()], self.z2 / straight
        if not self.rotates:
            return (nothing := numpy.full(numpy.shape(z1), numpy.nan)[()]), nothing
        alpha = remainder(sum(self.alphas), 360)
        if not self.window and not self.has_prisms:
            r = rotation.r(z1, self.z2)
            nu, M = rotation.nu(r, radians(self.alpha)), rotation.M(r, radians(self.alpha))
        else:
            nu, M = paraxial.nu_and_M(z1, self.z2, radians(self.alpha), self.prisms_by_window, self.behind)
        return alpha / 2 + numpy.remainder(numpy.degrees(nu) - alpha / 2 + 180, 360) - 180, M

    @property
    def tile(self) -> int:
        """POV-Ray's units per tile."""
        return limits.units_per_tile(self.prism.pitch if self.has_prisms else 1)

    def _check_clear(self, what: str, z1: float, nearest: float) -> None:
        if z1 <= nearest:
            raise ValueError(
                f"z1 = {z1:g}: {what} would touch the window frame around the sheets, whose back is at "
                f"z = {self.places[-1] + self.depth / 2:.4g} tiles; allowed: z1 > {nearest:.4g}"
            )
        if z1 > self.farthest:
            raise ValueError(
                f"z1 = {z1:g}: beyond POV-Ray's range with {self.prisms} prisms; allowed: z1 <= {self.farthest:.4g}"
            )

    @property
    def farthest(self) -> float:
        """The greatest z1, tiles."""
        return MAX_DISTANCE / self.tile - self.places[-1]

    @model_validator(mode="after")
    def _check_prisms_and_eye(self) -> Self:
        least = self.prism.least_aspect
        if self.aspect == 2:
            raise ValueError("aspect = 2: no light would take the designed path; allowed: below 2")
        if self.aspect <= least:
            raise ValueError(
                f"aspect = {self.aspect:g}: the slanted facets of prisms with index = {self.index:g} and "
                f"base_angle = {self.base_angle:g} would cross; allowed: {least:.4g} < aspect < 2"
            )
        if self.sheets_depth > MAX_DEPTH:
            raise ValueError(
                f"prisms = {self.prisms}: with this shape of the prisms and aperture = {self.aperture:g} the sheets "
                f"would be {self.sheets_depth:.4g} tiles deep; allowed: up to {MAX_DEPTH} tiles, as with more prisms"
            )
        nearest = self.depth / 2 + 0.01
        if self.z2 <= nearest:
            raise ValueError(f"z2 = {self.z2:g}: the eye would be inside the window frame; allowed: z2 > {nearest:.4g}")
        return self

    @model_validator(mode="after")
    def _show_whole_frame(self) -> Self:
        if "view" not in self.model_fields_set:
            object.__setattr__(self, "view", self.default_view)  # the model is frozen
        return self

    @model_validator(mode="after")
    def _check_sheets(self) -> Self:
        # a law is checked even if no window has it
        for number, window in enumerate((self, *self.window), 1):
            text, parameters = (
                getattr(self, name) if getattr(window, name) is None else getattr(window, name)
                for name in ("law", "parameter")
            )
            try:
                Law(text, parameters)
            except ValueError as error:
                where = f"window {number}, law" if number > 1 else "law"
                raise ValueError(f"{where} = {shown(text)}: {error}") from None
        for sheet in self.sheets:
            if sheet.name == "single" and self.window:
                raise ValueError("sheet = 'single': not with several windows; allowed: any other sheet")
        for number, window in enumerate(self.window, 2):
            for name in (parameter.name for parameter in PRISMS):
                if getattr(window, name) not in (None, getattr(self, name)):
                    raise ValueError(
                        f"window {number}, {name} = {getattr(window, name)}: differs from that of the first window, "
                        f"{getattr(self, name)}; allowed: the same"
                    )
        return self

    @model_validator(mode="after")
    def _check_windows(self) -> Self:
        for number, (before, z) in enumerate(pairwise(self.places), 2):
            least = before + self.depth + 0.01
            if z <= least:
                raise ValueError(
                    f"window {number}, z = {z:g}: its frame would touch that of the window before, at z = {before:g}; "
                    f"allowed: z > {least:.4g}"
                )
        if any(sheet.layers for sheet in self.sheets[: len(self.ideal)]):
            raise ValueError(
                "window: an ideal one behind one of prisms, but the camera simulates ideal sheets, and its rays meet "
                "them before all prisms; allowed: ideal windows first"
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
        2, description="distance from the sheets to the piece's axis, up to 5000 tiles; one, or one for each piece"
    )
    x: OneOrMore[Aside] = Field(
        0,
        description="x of the piece, from the window's centre to the right, -10 to 10 tiles; "
        "one, or one for each piece",
    )
    piece: OneOrMore[PieceValue] = Field(
        "knight",
        description=f"the chess piece: {', '.join(PIECES)}, or a file that declares Piece in POV-Ray's language; "
        "one, or one for each piece",
    )
    color: OneOrMore[Colour] = Field(
        "#e7b56f",
        description="colour of the piece's wood: a name, or a code such as #c87529; one, or one for each piece",
    )
    pedestal: Annotated[float, Field(ge=0, le=10)] = Field(
        0.8,
        description="height of the pedestals on which the pieces stand, 0 to 10 tiles; the pieces move with it; "
        "0: they stand on the floor",
    )
    predicted_image: bool = Field(
        False, description="show also the predicted image of the piece, in the plane of the sheets"
    )

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
        return tuple((complex(piece.x, self.floor + self.pedestal), piece.z1) for piece in self.pieces)

    @property
    def radii(self) -> tuple[float, ...]:
        return tuple(piece.radius for piece in self.pieces)

    @property
    def floor(self) -> float:
        """Height of the floor, on which window frame and pedestals stand, relative to the window's centre, tiles."""
        return -(self.aperture / 2 + self.rim)

    def apparent_steps(self, z1: float) -> tuple[complex, complex]:
        """Return the predicted image of a step of one tile to the right and of one up, at z1.

        It is in the plane z = 0, or in the plane of the last ideal window.
        """
        from povgen.optics import rotation

        last = len(self.ideal) - 1
        scale = rotation.depth(0, self.z2, radians(self.alpha), self.behind[:last]) / self.z2 if last > 0 else 1
        right, up = ((complex(self.apparent_position(self.E + step, z1)) - self.E) * scale for step in (1, 1j))
        return right, up

    @model_validator(mode="after")
    def _check_pieces(self) -> Self:
        values = {name: getattr(self, name) for name in ("piece", "x", "z1", "color")}
        counts = {name: len(value) for name, value in values.items() if isinstance(value, tuple)}
        if len(set(counts.values())) > 1:
            given = ", ".join(f"{count} values of {name}" for name, count in counts.items())
            raise ValueError(f"{given}: allowed: one value of each, or equal numbers of values")
        if self.eye[1] <= self.floor:
            raise ValueError(
                f"eye = {self.eye[0]:g},{self.eye[1]:g}: the eye would be under the floor; allowed: Y > {self.floor:g}"
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
                    f"overlap; allowed: at least {least:.4g} tiles apart{' along x or z' if self.pedestal else ''}"
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
        if self.predicted_image and not self.window and self.z2 in self.distances and abs(self.alpha) == 180:
            raise ValueError(
                f"predicted_image = true: at alpha = {self.alpha:g} and z1 = z2 = {self.z2:g} the piece appears at "
                "infinity (the pole of eq. 7); allowed: any other alpha or z1"
            )
        if self.predicted_image and self.window:
            for z1 in self.distances:
                if not all(map(isfinite, self.apparent_steps(z1))):
                    raise ValueError(
                        f"predicted_image = true: at z1 = {z1:g} and z2 = {self.z2:g} these windows show the piece at "
                        "infinity (Z = 0); allowed: any other alpha, z1 or z2"
                    )
        return self


class Spheres(Scene):
    """Coloured spheres on a line perpendicular to the sheets (figure 6). L is where the line crosses z = 0."""

    name: ClassVar[str] = "spheres"
    subject: ClassVar[str] = (
        "spheres on a line perpendicular to ray-rotating Dove-prism sheets, seen through the sheets"
    )

    z1: OneOrMore[Z1] | None = Field(
        None,
        description="distance from the sheets to a sphere, up to 5000 tiles; one for each sphere "
        "(default 2^n z2, n = -5..5, if the sphere is clear of the sheets)",
    )
    line: Point = Field(
        (-0.8, 0),
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
        """Return the radius of the sphere at z1, tiles. At alpha = 0 farther spheres look larger: none is hidden."""
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


def pieces(scene: Scene) -> dict[str, str | PieceFile]:
    """Return the pieces that a scene shows, by their names."""
    return {str(standing.piece): standing.piece for standing in scene.pieces} if isinstance(scene, Chess) else {}


def piece_files(scenes: Iterable[Scene]) -> set[str]:
    """Return the paths of the files that declare the scenes' pieces."""
    return {piece.path for scene in scenes for piece in pieces(scene).values() if isinstance(piece, PieceFile)}


SCENES = {scene.name: scene for scene in (Chess, Spheres)}
