"""Where methods fail, as the stability maps found it (docs/accuracy.md): limits for scenes to keep, or to be warned of.

`povgen verify --stability` measures each anew and fails where one no longer holds.
"""

from collections.abc import Iterator
from math import atan, degrees, hypot, radians, sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from povgen.rendering import Rendering
    from povgen.scenes import Scene

# (a) Largest condition number of the apparent position at which it is predicted: to 1 and to 2 pixels of 1280x960.
CONDITION = {"ideal": 400, "detailed": 3}
# (b) Most prisms at which no more than 1 in 10,000 rays on the proper path goes astray.
PRISMS = 3000
# (c) Widths of the air gap, in units of the pitch, between which it matters little: narrower POV-Ray misses it.
GAP = (1e-4, 0.09)
# (d) max_trace_level from which at most LOST of the window's pixels stay black though their light comes through, for
# an eye as near as so many tiles.
LOST = 0.05
LEVELS = {"detailed": {0: 53, 2: 46, 3: 41, 6: 33, 60: 7}, "single": {0: 27, 60: 5}}
# (e) Field angle of the window's farthest corner, degrees, up to which a quarter of the pixels shows rotated light.
FIELD = 25
# (f) Error of the ideal sheet's camera off the axis, pixels of 1280x960, times cells^2 z2; and what it may be.
GRID = 340
GRID_ERROR = 0.03
# (g) Pixels per prism below which a picture without antialiasing resolves no prisms: its pixels are a random sample.
PIXELS_PER_PRISM = 1.2
# (h) alpha, degrees, below which parallel prisms make dark bands.
PARALLEL = 3


def trace_level(sheet: str, z2: float) -> int:
    """The least max_trace_level for a model of the sheets seen from z2; 5, POV-Ray's own, without glass."""
    return next((level for near, level in reversed(LEVELS.get(sheet, {}).items()) if z2 >= near), 5)


def grid_cells(z2: float) -> int:
    """The least number of cells a side for the ideal sheet's camera off the axis."""
    return round(sqrt(GRID / GRID_ERROR / z2) + 0.5)


def units_per_tile(prisms: int) -> int:
    """POV-Ray's tolerances are fixed in its own units: the finer the prisms, the larger the scene."""
    return max(1000, prisms)


def warnings(scene: "Scene", rendering: "Rendering | None" = None) -> Iterator[tuple[str, str]]:
    """What a picture of the scene will not show right: the parameter to blame, and the limit in words."""
    prisms = scene.sheet in ("detailed", "single")
    half = scene.window / 2
    corner = degrees(atan(hypot(half + abs(scene.E.real), half + abs(scene.E.imag)) / scene.z2))
    if prisms and corner > FIELD:
        text = f"z2 = {scene.z2:g}: the window's corner is seen at {corner:.0f} degrees; beyond {FIELD} degrees"
        yield "z2", f"{text} less than a quarter of the window shows rotated light, the rest is stray light"
    if scene.sheet == "detailed" and abs(scene.alpha) < PARALLEL:
        text = f"alpha = {scene.alpha:.3g}: below {PARALLEL} degrees the prisms of the two sheets"
        yield "alpha", f"{text} lie so nearly parallel that they make dark bands"
    if getattr(scene, "ghost", False):
        from povgen import rotation  # numpy is slow to load

        condition = rotation.condition(scene.z2 / scene.z1, radians(scene.alpha))
        if condition > CONDITION[scene.sheet]:
            text = f"ghost = true: at alpha = {scene.alpha:g} and z1 = {scene.z1:g} the piece is magnified"
            limit = f"beyond {CONDITION[scene.sheet]} the prediction for this sheet is off by pixels"
            yield "ghost", f"{text} {condition:.3g} times; {limit}"
    if prisms and rendering and rendering.antialias is None:
        pixels = scene.window / scene.view_height * rendering.size[1] / scene.prisms
        if pixels < PIXELS_PER_PRISM:
            text = f"prisms = {scene.prisms}: a prism is {pixels:.2g} pixels wide; below {PIXELS_PER_PRISM} pixels,"
            yield "prisms", f"{text} without antialiasing, the picture resolves no prisms and is noise"
