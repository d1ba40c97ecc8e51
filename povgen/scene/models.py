"""What a scene is made of: parameters with their units and ranges. A scene never changes; variants are copies.

Lengths are in tiles (the side of a floor tile), angles in degrees. Points of the sheets' plane z = 0 are complex,
x + iy from the window's centre, x to the right and y up for the eye.
"""

from math import radians, remainder
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from povgen.optics import prism
from povgen.scene import limits

# Radius of each piece's foot, tiles: it must stand clear of the sheets.
PIECES = {"pawn": 0.38, "rook": 0.40, "knight": 0.40, "bishop": 0.40, "queen": 0.43, "king": 0.43}
Piece = Literal[*PIECES]  # type: ignore[valid-type]
Sheet = Literal["detailed", "ideal", "single", "none"]
FARTHEST = 5e6  # POV-Ray sees 10 million of its units far
Z1 = Annotated[float, Field(gt=0, le=5000)]
Offset = Annotated[float, Field(ge=-10, le=10)]


def _pair(value: Any) -> Any:
    return value.split(",") if isinstance(value, str) else value


def _listed(value: Any) -> Any:
    return (value,) if isinstance(value, (int, float, str)) else value


class Scene(BaseModel):
    """What every scene has: the eye, the window and the sheets in it."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    alpha: Annotated[float, Field(ge=-360, le=360)] = Field(
        66, description="ray-rotation angle alpha, -360 to 360 degrees"
    )
    z2: Annotated[float, Field(gt=0, le=150)] = Field(
        6, description="distance from the sheets to the eye, up to 150 tiles"
    )
    sheet: Sheet = Field(
        "detailed", description="model of the sheets: detailed, ideal, single (one sheet of prisms) or none"
    )
    prisms: Annotated[int, Field(ge=1, le=limits.MAX_PRISMS)] = Field(
        100, description=f"Dove prisms to the window's side, in each sheet, 1 to {limits.MAX_PRISMS}"
    )

    name: ClassVar[str]
    subject: ClassVar[str]
    window: ClassVar[float] = 2.4  # side of the square aperture
    rim: ClassVar[float] = 0.13  # width of its frame
    view_height: ClassVar[float] = 3.85  # of the picture, in the plane z = 0

    if TYPE_CHECKING:  # what each scene has in its own way: the object L and the eye E in the plane z = 0, and every z1

        @property
        def L(self) -> complex: ...

        @property
        def E(self) -> complex: ...

        @property
        def distances(self) -> tuple[float, ...]: ...

    @property
    def sheets_depth(self) -> float:
        """Extent of the sheets along z; they are centred on z = 0."""
        sheets = {"detailed": 2, "single": 1}.get(self.sheet, 0)
        return prism.thickness(self.pitch, sheets) if sheets else 0.0

    @property
    def pitch(self) -> float:
        """Of the prisms, tiles."""
        return self.window / self.prisms

    @property
    def depth(self) -> float:
        """Extent of the frame along z: at least that of two sheets of 100 prisms, so that all models share a frame."""
        return max(0.24, 1.02 * self.sheets_depth)

    def apparent_position(self, L, z1, alpha=None):
        """Where a point is seen, in the plane z = 0: eq. 7, and for prisms the paraxial prediction. Arrays broadcast.

        L complex and z1 in tiles; alpha, degrees, takes the place of the scene's own.
        """
        import numpy  # slow to load, and few scenes need a prediction

        from povgen.optics import paraxial, rotation

        alpha = numpy.radians(self.alpha if alpha is None else alpha)
        match self.sheet:
            case "detailed":
                return paraxial.apparent_position(L, self.E, z1, self.z2, alpha, self.pitch)
            case "single":
                return paraxial.mirrored_position(L, self.E, z1, self.z2, self.pitch)
            case "none":
                alpha = 0
        return rotation.apparent_position(L, self.E, z1, self.z2, alpha)

    def visible(self, L, z1, alpha=None):
        """Whether light from a point reaches the eye through the window, as predicted; see `apparent_position`.

        It must pass the frame's front and back and, between them, the middle planes of the sheets, which turn it.
        """
        import numpy

        turn = numpy.exp(-1j * numpy.radians(self.alpha if alpha is None else alpha))
        with numpy.errstate(invalid="ignore"):
            # of the ray before the sheets, and behind them
            slope = (self.apparent_position(L, z1, alpha) - self.E) / self.z2
            behind = {"single": slope.conjugate(), "none": slope}.get(self.sheet, turn * slope)
            middle = max(0, self.sheets_depth - prism.thickness(self.pitch, 1)) / 2  # of a sheet, from z = 0
            crossed = [self.E + slope * (self.z2 - z) for z in (self.depth / 2, middle)]
            crossed += [L - behind * (z1 - z) for z in (self.depth / 2, middle)]
        half = self.window / 2
        return numpy.all([(abs(place.real) < half) & (abs(place.imag) < half) for place in crossed], axis=0)

    def nu_and_M(self, z1):
        """The angle nu, degrees, through which two sheets show an object turned, and its magnification M.

        Eqs. 8 and 9, corrected; for prisms of finite size as in `paraxial.nu_and_M`. nu lies within 180 degrees of
        the middle of 0 and alpha, NaN where there is none. z1 in tiles; arrays broadcast.
        """
        import numpy

        from povgen.optics import paraxial, rotation

        alpha = remainder(self.alpha, 360)
        if self.sheet == "ideal":
            r = rotation.r(z1, self.z2)
            nu, M = rotation.nu(r, radians(self.alpha)), rotation.M(r, radians(self.alpha))
        else:
            nu, M = paraxial.nu_and_M(z1, self.z2, radians(self.alpha), self.pitch)
        return alpha / 2 + numpy.remainder(numpy.degrees(nu) - alpha / 2 + 180, 360) - 180, M

    @property
    def air_gap(self) -> float:
        """Air between prisms, in units of their pitch."""
        return prism.AIR_GAP

    @property
    def tile(self) -> int:
        """POV-Ray's units in a tile."""
        return limits.units_per_tile(self.prisms if self.sheets_depth else 1)

    def _check_clear(self, what: str, z1: float, nearest: float) -> None:
        if z1 <= nearest:
            raise ValueError(
                f"z1 = {z1:g}: {what} would stand in the sheets, whose frame ends {self.depth / 2:.4g} tiles behind "
                f"z = 0; allowed: z1 > {nearest:.4g}"
            )
        if z1 > self.farthest:
            raise ValueError(
                f"z1 = {z1:g}: with {self.prisms} prisms POV-Ray does not see so far; "
                f"allowed: z1 <= {self.farthest:.4g}"
            )

    @property
    def farthest(self) -> float:
        """The greatest z1, tiles."""
        return FARTHEST / self.tile

    @model_validator(mode="after")
    def _check_eye(self):
        nearest = self.depth / 2 + 0.01
        if self.z2 <= nearest:
            raise ValueError(f"z2 = {self.z2:g}: the eye would be in the sheets' frame; allowed: z2 > {nearest:.4g}")
        return self


class Chess(Scene):
    """A chess piece on a chessboard floor, seen through the window (figures 3 and 4). L is where the piece stands."""

    name: ClassVar[str] = "chess"
    subject: ClassVar[str] = "a chess piece seen through a window of ray-rotating Dove-prism sheets"
    floor: ClassVar[float] = -(Scene.window / 2 + Scene.rim)  # the window's frame stands on it

    z1: Z1 = Field(2, description="distance from the sheets to the piece's axis, up to 5000 tiles")
    offset: Annotated[tuple[Offset, Annotated[float, Field(ge=-10, lt=0)]], BeforeValidator(_pair)] = Field(
        (0, floor), description="L - E, X,Y from the eye to where the piece stands, -10 to 10 tiles, Y below 0"
    )
    piece: Piece = Field("knight", description=", ".join(PIECES))
    predicted_image: bool = Field(False, description="show the predicted piece in the plane of the sheets as well")

    @property
    def L(self) -> complex:
        """Where the piece stands: X to the right of the window's middle."""
        return complex(self.offset[0], self.floor)

    @property
    def E(self) -> complex:
        """The eye: -Y above the floor, before the window's middle."""
        return complex(0, self.floor - self.offset[1])

    @property
    def distances(self) -> tuple[float, ...]:
        """z1 of the piece, tiles."""
        return (self.z1,)

    @property
    def steps_seen(self) -> tuple[complex, complex]:
        """Where a step of one tile to the right is seen, and one up, at the piece's distance, in the plane z = 0."""
        right, up = (self.apparent_position(self.E + step, self.z1) - self.E for step in (1, 1j))
        return right, up

    @model_validator(mode="after")
    def _check_piece(self):
        self._check_clear(f"the {self.piece}", self.z1, self.depth / 2 + PIECES[self.piece])
        if self.predicted_image and self.sheet not in ("detailed", "ideal"):
            raise ValueError(
                f"predicted_image = true: it predicts what two sheets show, and sheet is {self.sheet!r}; "
                "allowed with sheet 'detailed' or 'ideal'"
            )
        if self.predicted_image and self.z1 == self.z2 and abs(self.alpha) == 180:
            raise ValueError(
                f"predicted_image = true: at alpha = {self.alpha:g} and z1 = z2 = {self.z1:g} the piece is seen at "
                "infinity (the pole of eq. 7); allowed: any other alpha or z1"
            )
        return self


class Spheres(Scene):
    """Green spheres on one normal of the sheets, seen through the window (figure 6). L is where that normal is."""

    name: ClassVar[str] = "spheres"
    subject: ClassVar[str] = "spheres on one normal of ray-rotating Dove-prism sheets, seen through them"

    z1: Annotated[tuple[Z1, ...], BeforeValidator(_listed), Field(min_length=1, max_length=50)] | None = Field(
        None,
        description="distance from the sheets to a sphere, up to 5000 tiles, once for each sphere "
        "(default 2^n z2, n = -5..5, where clear of the sheets)",
    )
    offset: Annotated[tuple[Offset, Offset], BeforeValidator(_pair)] = Field(
        (-0.55, 0), description="L - E, X,Y from the eye to the spheres' normal, -10 to 10 tiles"
    )

    @property
    def L(self) -> complex:
        """The spheres' normal."""
        return complex(*self.offset)

    @property
    def E(self) -> complex:
        """The eye, before the window's centre."""
        return 0j

    @property
    def distances(self) -> tuple[float, ...]:
        """z1 of every sphere, tiles."""
        if self.z1:
            return self.z1
        nearest, farthest = self.nearest, self.farthest
        return tuple(z1 for n in range(-5, 6) if nearest < (z1 := 2.0**n * self.z2) <= farthest)

    def radius(self, z1: float) -> float:
        """Radius of the sphere at z1, tiles: at alpha = 0 the farther looks larger, so that none hides another."""
        return min(0.062 * (z1 / self.z2) ** 0.1 * (1 + z1 / self.z2), z1 / 4)

    @property
    def nearest(self) -> float:
        """The least z1 at which a sphere is clear of the sheets and their frame, tiles."""
        z1 = back = self.depth / 2
        for _ in range(30):  # converges: a radius grows by at most a quarter of z1
            z1 = back + self.radius(z1)
        return z1

    @model_validator(mode="after")
    def _check_spheres(self):
        nearest = self.nearest
        for z1 in self.distances:
            self._check_clear("the sphere", z1, nearest)
        return self


SCENES = {scene.name: scene for scene in (Chess, Spheres)}
