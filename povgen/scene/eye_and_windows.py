"""The eye and the windows of `Chess` and `Spheres`: parameters with units and ranges, and what follows from them.

Lengths are in tiles (the side of a floor tile), angles in degrees. The plane z = 0 is midway between the sheets of the
first window. Points in it are complex numbers x + iy, from this window's centre: x points right and y up, as the eye
sees them. z points away from the eye, which is at z = -z2.
"""

from collections.abc import Iterable
from functools import cached_property
from itertools import pairwise
from math import radians
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field

from povgen.inputs.fields import Point
from povgen.objects.sheet_fields import ParametersOfSheets, SheetName
from povgen.optics import apparent
from povgen.optics.camera import Camera
from povgen.optics.opening import Opening
from povgen.optics.pose import Pose
from povgen.optics.prism import Prism
from povgen.scene.scene import Scene
from povgen.scene.windows import WINDOW, FurtherWindow, Windows, as_windows, replaced_by
from povgen.sheets import SHEETS
from povgen.sheets.prisms import SHAPE, shape_of
from povgen.sheets.sheet import Ideal, Sheet

APERTURE = 3.0  # the default side of the window, tiles
VIEW = 3.7  # the default height of the picture in the plane z = 0, tiles, if it shows the whole window frame
MAX_VIEW = 100
Angle = Annotated[float, Field(ge=-360, le=360)] | Literal["none"]


class EyeAndWindows(Scene, ParametersOfSheets):
    """The eye, the windows and the sheets in them: what `Chess` and `Spheres` share. Those of the sheets come first."""

    z2: Annotated[float, Field(gt=0, le=150)] = Field(
        default=6, description="distance from the sheets to the eye, up to 150 tiles; the default spheres move with it"
    )
    sheet: SheetName = Field(
        default="detailed",
        description=f"model of the sheets: {', '.join(SHEETS)}",
    )
    window: Windows = Field(default=(), description=WINDOW)
    aperture: Annotated[float, Field(ge=0.5, le=10)] = Field(
        default=APERTURE,
        description="side of the square window, 0.5 to 10 tiles; in chess, the floor with all on it moves with the "
        "lower edge",
    )
    view: Annotated[float, Field(ge=0.1, le=MAX_VIEW)] = Field(
        default=VIEW,
        description=f"height of the picture in the plane of the sheets, 0.1 to {MAX_VIEW} tiles "
        f"(default: {VIEW}, or more if the first window's frame is larger or the picture narrow)",
    )
    eye: Point = Field(
        default=(0, 0),
        description="the eye E as X,Y from the window's centre, to the right and up, -10 to 10 tiles; the objects and "
        "the window stay, and the picture still shows the same part of the plane of the sheets",
    )
    look: Point = Field(
        default=(0, 0),
        description="X,Y of the point in the picture's middle, in the plane of the sheets, -10 to 10 tiles",
    )
    polariser: Angle = Field(
        default="none",
        description="a polariser behind the last window: degrees counter-clockwise from x, as the eye sees it, or none",
    )
    analyser: Angle = Field(default="none", description="a polariser in front of the first window, likewise")
    if TYPE_CHECKING:  # the names of changes are those of the parameters

        @property
        def replace(self) -> type[Self]: ...

    @property
    def polarised(self) -> bool:
        return (self.polariser, self.analyser) != ("none", "none")

    @property
    def E(self) -> complex:
        """The eye, projected onto z = 0."""
        return complex(*self.eye)

    @property
    def prism(self) -> Prism:
        """The shape of the prisms in the first window. Lengths are in tiles. Windows behind it can have others."""
        return shape_of(self.values_of(self, (*SHAPE, "tops")), self.aperture / self.prisms)

    @property
    def parameter_sets(self) -> "tuple[EyeAndWindows | FurtherWindow, ...]":
        """What states the parameters of each window, the first one first: the scene, and each further `Window`."""
        return self, *self.window

    def values_of(self, window: "EyeAndWindows | FurtherWindow", names: Iterable[str]) -> dict[str, Any]:
        """Return parameters of one of `parameter_sets`. What it does not state is the first window's."""
        return {name: getattr(self, name) if (own := getattr(window, name)) is None else own for name in names}

    @cached_property
    def sheets(self) -> tuple[Sheet, ...]:
        """The sheet in each window, that of the window nearest to the eye first."""

        def sheet(window: EyeAndWindows | FurtherWindow) -> Sheet:
            kind = SHEETS[window.sheet or self.sheet]
            return kind(self.values_of(window, [each.name for each in kind.parameters]), self.aperture)

        return tuple(map(sheet, self.parameter_sets))

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
        return (0.0, *(window.z for window in self.window))

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
        return [(b - a, sheet) for (a, b), sheet in zip(pairwise((-self.z2, *self.places)), self.sheets, strict=True)]

    @property
    def camera(self) -> Camera:
        return Camera((*self.eye, -self.z2), (*self.look, 0), (1, 0, 0), (0, 1, 0), self.view)

    @property
    def middle(self) -> complex:
        return complex(*self.look)

    def seen_from(self, aside: complex, moved: complex = 0) -> Self:
        eye, look = ((round(z.real, 12), round(z.imag, 12)) for z in (self.E + aside, self.middle + moved))
        return self.replace(eye=eye, look=look, view=self.view)

    @property
    def ideal(self) -> tuple[Ideal, ...]:
        """The ideal sheets, the first window's first."""
        return tuple(sheet for sheet in self.sheets if isinstance(sheet, Ideal))

    @property
    def openings(self) -> list[Opening]:
        """The windows as in `optics.opening`."""
        return [
            Opening(Pose(z=z), sheet, self.depth, rim=self.rim)
            for z, sheet in zip(self.places, self.sheets, strict=True)
        ]

    @property
    def depth(self) -> float:
        """Extent of the window frame along z, tiles: a tenth of the window's side, or more if the sheets need more."""
        return max(self.aperture / 10, 1.02 * max(sheet.depth for sheet in self.sheets))

    def default_view(self, shape: float = 4 / 3) -> float:
        """Height of the picture in the plane z = 0 that shows the first window's whole frame, tiles.

        The picture is `shape` times as wide as high, or wider. The view is at least VIEW, and at most MAX_VIEW even if
        the frame needs more.
        """
        front, slant = -self.depth / 2, min(self.rim, self.depth)
        reach = 0.0
        for out, z in ((0.6, front), (0.75, front + 0.25 * slant), (1, front + 0.5 * slant)):  # window_frame.pov.j2
            scale = self.z2 / (self.z2 + z)  # from the plane z to the plane z = 0, seen from the eye
            for eye, sides in ((self.E.imag, 1), (self.E.real, shape)):
                reach = max(reach, (scale * (self.aperture / 2 + out * self.rim) + (scale - 1) * abs(eye)) / sides)
        return VIEW if 2 * reach <= VIEW else min(MAX_VIEW, 1.03 * 2 * reach)

    def fitted(self, size: tuple[int, int]) -> Self:
        """Return the scene with its default view for a picture of this size: a narrow one has a margin at each side."""
        if "view" in self.model_fields_set or (shape := size[0] / size[1]) >= 1:
            return self
        return self.replace(view=self.default_view(0.9 * shape))

    def _replaced_by(self, changes: dict[str, object]) -> set[str]:
        if "window" not in changes:
            return replaced_by(changes, self.window)
        changes["window"] = windows = as_windows(changes["window"])  # once: they can be given as an iterator
        return replaced_by(changes, windows)
