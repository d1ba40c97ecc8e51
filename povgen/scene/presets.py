"""The presets `Chess` and `Spheres`, and what is computed from them. A scene never changes. Variants are copies.

Here are their own parameters. Those of the eye and the windows are in `eye_and_windows`, those of all scenes (sky,
pupil) in `scene`, the ranges of z1 and x in `povgen.inputs.fields`. z1 is the distance of an object from the middle
plane of the last window.
"""

from __future__ import annotations  # help() then says ArrayLike

from cmath import isfinite
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import combinations
from math import hypot
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self, TypeVar

from numpy.typing import ArrayLike
from pydantic import BeforeValidator, Field, model_validator

from povgen.errors import InputError, at_least, input_errors, shown
from povgen.inputs import pictures
from povgen.inputs.fields import (
    Z1,
    Aside,
    Colour,
    OneOrMore,
    PictureFile,
    PieceValue,
    Point,
    as_tuple,
)
from povgen.inputs.pieces import PIECES, PieceFile, radius
from povgen.objects.floor import Floor
from povgen.objects.pedestal import Pedestal
from povgen.objects.piece import Piece
from povgen.objects.scene_object import SceneObject
from povgen.objects.sphere import Sphere
from povgen.optics.rays import AT_ONCE, Bundle, Spot, checked_count, joined, pencil, spot
from povgen.scene import checks
from povgen.scene.files import files_in
from povgen.scene.predictions import Predicted
from povgen.scene.room import Room
from povgen.scene.scene import SCENES as SCENES
from povgen.scene.scene import Scene as Scene
from povgen.scene.scene import checked_scene, classes
from povgen.scene.scene import recorded as recorded
from povgen.scene.windows import WINDOW_NUMBER, as_windows, with_numbers
from povgen.sheets import SHEETS
from povgen.sheets.profile import ProfileFile
from povgen.validation import Model, as_flag

AnyModel = TypeVar("AnyModel", bound=Model)
PEDESTAL_EDGE = 0.03  # how far a pedestal extends beyond the piece's foot, tiles


class Standing(NamedTuple):
    """A piece on its pedestal. Lengths are in tiles."""

    piece: str | PieceFile
    x: float
    z1: float
    color: str
    radius: float  # of the foot


def components(field: str, count: int) -> list[str]:
    """Return the names of the numbers in a list: x, y and z of a place or a direction, otherwise 1, 2, ..."""
    return [*"xyz"[:count]] if field in ("eye", "look", "line", "axis") else [str(n) for n in range(1, count + 1)]


class AxialScene(Predicted):
    """A scene whose windows stand one behind the other on one axis."""

    in_turn: ClassVar[bool] = True
    if TYPE_CHECKING:  # each scene defines L of its first object, and L and z1 of every one; L is projected onto z = 0

        @property
        def L(self) -> complex: ...

        @property
        def objects(self) -> tuple[tuple[complex, float], ...]: ...

    @property
    def pieces(self) -> tuple[Standing, ...]:
        """Every chess piece."""
        return ()

    def component(self, name: str) -> tuple[str, int] | None:
        """Return the field and the place in it of a number in a list, such as ("eye", 1) for eye_y, or None."""
        field, _, which = name.rpartition("_")
        listed = getattr(self, field) if field in type(self).model_fields and field != "window" else None
        names = components(field, len(listed)) if isinstance(listed, tuple) else []
        return (field, names.index(which)) if which in names else None

    def with_numbers(self, values: Mapping[str, Any]) -> Self:
        changes: dict[str, Any] = {}
        windows = {name: value for name, value in values.items() if WINDOW_NUMBER.fullmatch(name)}
        for name, value in values.items():
            if component := self.component(name):
                field, place = component
                point = changes.get(field, getattr(self, field))
                changes[field] = (*point[:place], value, *point[place + 1 :])
            elif name not in windows:
                changes[name] = value
        if windows:
            changes["window"] = with_numbers(as_windows(changes.get("window", self.window)), windows)
        return self.replace(**changes)

    @property
    def distances(self) -> tuple[float, ...]:
        """z1 of every object: its distance from the middle plane of the last window, tiles."""
        return tuple(z1 for _, z1 in self.objects)

    @property
    def radii(self) -> tuple[float, ...]:
        """The radius of every object, tiles. The radius of a piece is that of its foot."""
        return (0.0,) * len(self.objects)

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
        radius = self.aperture / 2 if radius is None else radius
        return joined(pencil(self.openings, point, count, middle, radius, seed))

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
        parts = pencil(self.openings, point, count, middle, radius, seed)
        return spot((self.trace(rays) for rays in parts), z, as_flag("stray", stray))

    @model_validator(mode="after")
    def _check_eye_and_windows(self) -> Self:
        if (angle := SHEETS[self.sheet].angle) is not None and "alpha" not in self.model_fields_set:
            object.__setattr__(self, "alpha", angle)  # the model is frozen
        checks.check(self)
        if "view" not in self.model_fields_set:
            object.__setattr__(self, "view", self.default_view())
        return self


class Chess(AxialScene):
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
        values = [as_tuple(value) for value in (self.piece, self.x, self.z1, self.color)]
        count = max(map(len, values))
        shared = [value * count if len(value) == 1 else value for value in values]
        return tuple(Standing(piece, x, z1, color, radius(piece)) for piece, x, z1, color in zip(*shared, strict=True))

    @cached_property
    def contents(self) -> Sequence[SceneObject]:
        # without checks, which the scene's own ranges replace
        floor = [] if self.floor == "none" else [Floor.model_construct(y=self.floor_y, file=self.floor)]
        y, last = self.floor_y, self.places[-1]
        pedestals = [
            Pedestal.model_construct(
                x=each.x, y=y, z=last + each.z1, width=2 * (each.radius + PEDESTAL_EDGE), height=self.pedestal
            )
            for each in self.pieces
        ]
        pieces = [
            Piece.model_construct(x=each.x, y=y + self.pedestal, z=last + each.z1, piece=each.piece, color=each.color)
            for each in self.pieces
        ]
        return [*floor, *pieces, *(pedestals if self.pedestal else ())]

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
            checks.check_clear(self, what, z1, self.depth / 2 + foot + (PEDESTAL_EDGE if self.pedestal else 0))
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


class InRow(Sphere):
    """A sphere of a row, whose colour follows from its number."""

    share: float = Field(description="its number in the row, from 0, divided by that of all spheres")

    @property
    def numbers(self) -> tuple[float, ...]:
        return self.radius, self.share

    @property
    def colour(self) -> tuple[float, float, float]:
        return 0, 0, 0


class Spheres(AxialScene):
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

    @cached_property
    def contents(self) -> Sequence[SceneObject]:
        count, last = len(self.objects), self.places[-1]
        return [
            InRow.model_construct(x=L.real, y=L.imag, z=last + z1, radius=radius, share=number / count)
            for number, ((L, z1), radius) in enumerate(zip(self.objects, self.radii, strict=True))
        ]

    @property
    def L(self) -> complex:
        """Where the line of the spheres crosses the plane z = 0."""
        return complex(*self.line)

    @property
    def objects(self) -> tuple[tuple[complex, float], ...]:
        """L (projected onto z = 0) and z1 of every sphere, tiles."""
        if self.z1 is not None:
            return tuple((self.L, z1) for z1 in as_tuple(self.z1))
        nearest, farthest = self.nearest, checks.farthest(self)
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
            checks.check_clear(self, "the sphere", z1, nearest)
        return self


def pieces(scene: Scene) -> dict[str, str | PieceFile]:
    """Return the pieces that a scene shows, by their names."""
    return {str(each.shape): each.shape for each in scene.contents if each.shape}


def input_files(scenes: Iterable[Scene]) -> set[str]:
    """Return the paths of the files that the scenes show: pieces, profiles, and pictures."""
    return {file.path for scene in scenes for file in files_in(scene)}


def with_seen_files(scene: Scene) -> Scene:
    """Return the scene without the files that it does not show: a sky behind another background, unused profiles."""
    used = [sheet.values.get("profile") for sheet in scene.sheets]

    def seen(thing: AnyModel) -> AnyModel:
        """Return a scene or a window with the default profile in place of a file that no window uses."""
        file, fields = getattr(thing, "profile", None), type(thing).model_fields
        unused = isinstance(file, ProfileFile) and file not in used
        return thing.replace(profile=fields["profile"].default) if unused else thing

    changes: dict[str, object] = {} if scene.background == "sky" else {"sky": None}
    if windows := getattr(scene, "window", ()):
        changes["window"] = [*map(seen, windows)]
    return seen(scene.replace(**changes) if changes else scene)


def used_parameters(scene: Scene) -> set[str]:
    """Return the names of the sheets' parameters for which at least one window uses the scene's value."""
    if not isinstance(scene, AxialScene):
        return set()
    windows = zip((None, *scene.window), scene.sheets, strict=True)
    named = ((window, each.name) for window, sheet in windows for each in sheet.parameters)
    return {name for window, name in named if window is None or getattr(window, name) is None}


def checked_axial(scene: object, what: str) -> AxialScene:
    """Return a scene of Chess or Spheres. Raises InputError for another one: `what` is not for it."""
    if not isinstance(found := checked_scene(scene), AxialScene):
        kind = type(found).__name__
        raise InputError(f"scene = {shown(found)}: {what} is not for {kind}; allowed: {classes(AxialScene)}")
    return found


SCENES |= {scene.name: scene for scene in (Chess, Spheres, Room)}
