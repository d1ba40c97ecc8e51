"""What follows from a scene: what becomes of its rays, what POV-Ray has to be told, and what a picture will not show.

The limits are those of `limits`, as the stability maps found them.
"""

from cmath import rect
from collections.abc import Iterator
from math import ceil, hypot, inf, radians, sqrt
from typing import NamedTuple

from povgen.scene.limits import (
    MAX_CAMERA_ERROR,
    MAX_CELLS,
    MAX_CONDITION,
    MAX_CORRECTION,
    MAX_FACES,
    MAX_LOST_FRACTION,
    MIN_ALPHA,
    MIN_DESIGNED_FRACTION,
    MIN_PIXELS_PER_PRISM,
)
from povgen.scene.models import Scene
from povgen.settings import Rendering


class Survey(NamedTuple):
    """What becomes of the rays that the eye sends through a window of prisms."""

    trace_level: int  # the least max_trace_level that loses no more than MAX_LOST_FRACTION
    designed: float  # the fraction on the designed path


surveys: dict[tuple, Survey] = {}  # those that are known, by what they follow from


def survey(scene: Scene, side: int = 60) -> Survey:
    """What becomes of side^2 rays that the eye sends through a scene's prisms, whatever is behind them."""
    rays = surveyed(scene, side)
    if rays not in surveys:
        surveys[rays] = _survey(*rays)
    return surveys[rays]


def surveyed(scene: Scene, side: int = 60) -> tuple:
    """All that a scene's survey follows from."""
    return (scene.sheet, scene.alpha, scene.z2, scene.E, scene.window, scene.prisms, scene.air_gap, side)


def _survey(
    sheet: str, alpha: float, z2: float, E: complex, window: float, prisms: int, gap: float, side: int
) -> Survey:
    """Trace rays through a window of prisms, each to a random place of a square of its own.

    They are the same every time. Pixels, which lie in rows, would alias with prisms that do.
    """
    import numpy as np

    from povgen.optics import trace  # numpy is slow to load, and only prisms need it

    places = np.indices((side, side)) + np.random.default_rng(1).uniform(size=(2, side, side))
    x, y = (places.reshape(2, -1) / side - 0.5) * window
    direction = np.column_stack((x - E.real, y - E.imag, np.full(len(x), z2)))
    eye = np.array([[E.real, E.imag, -z2]])
    glass = trace.sheets(sheet, radians(alpha), window, prisms, gap)
    found = trace.trace(eye, direction, glass, window, prisms, gap)
    faces = np.where(found.end == trace.End.FRAME, 0, found.count)
    # 0.8: what a picture loses may be a little more than the sample
    lost = int(0.8 * MAX_LOST_FRACTION * len(x))
    unfinished = found.end == trace.End.UNFINISHED
    if unfinished.sum() >= lost:  # the level is among them
        longer = trace.trace(eye, direction[unfinished], glass, window, prisms, gap, MAX_FACES)
        faces[unfinished] = np.where(longer.end == trace.End.FRAME, 0, longer.count)
    return Survey(max(5, int(np.sort(faces)[-lost]) + 1), float(found.designed.mean()))


def max_trace_level(scene: Scene) -> int:
    """How many surfaces POV-Ray follows a ray through: 6 prism faces on the designed path, more for stray light.

    A probe may have a level of its own (`trace_level`).
    """
    return getattr(scene, "trace_level", None) or (survey(scene).trace_level if scene.sheets_depth else 5)


def camera_cells(scene: Scene) -> int:
    """Cells a side in which the ideal sheet's camera interpolates view directions, MAX_CELLS at most.

    The least number that keeps MAX_CAMERA_ERROR, unless a probe has its own (`grid`); see camera.pov.j2.
    """
    if grid := getattr(scene, "grid", None):
        return grid
    return ceil(min(MAX_CELLS, max(1, sqrt(grid_error(scene, 1) / MAX_CAMERA_ERROR)))) if scene.E else 1


def grid_error(scene: Scene, cells: int) -> float:
    """The most by which the ideal sheet's camera shows an object aside, for an eye aside: pixels of 1280x960.

    POV-Ray interpolates between unit vectors. Within a triangle whose longest side is d that tells the direction to a
    place up to d^2 sin(2 field angle)/(8 z2) tiles aside (docs/sheets.md); it errs by |P| times that where it is seen.
    """
    half = scene.window / 2
    x, y = abs(scene.E.real), abs(scene.E.imag)
    nearest, farthest = hypot(max(0, x - half), max(0, y - half)), hypot(x + half, y + half)
    tangent = min(max(1, nearest / scene.z2), farthest / scene.z2)  # sin(2 angle) is greatest at 45 degrees
    aside = 2 * (scene.window / cells) ** 2 * 2 * tangent / (1 + tangent**2) / (8 * scene.z2)
    return aside * max((_P(scene, z1) for z1 in scene.distances), default=1) / scene.view_height * 960


def _P(scene: Scene, z1: float) -> float:
    """|P| of eq. 7, as `rotation.P`, without numpy, which is slow to load."""
    inverse = abs(1 + rect(scene.z2 / z1, radians(scene.alpha)))
    return 1 / inverse if inverse else inf


def warnings(scene: Scene, rendering: Rendering | None = None) -> Iterator[tuple[str, str]]:
    """What a picture of the scene will not show right: the parameter to blame, and the limit in words."""
    glass = scene.sheet in ("detailed", "single")
    if glass and (designed := survey(scene).designed) < MIN_DESIGNED_FRACTION:
        eye = f" and the eye at {scene.E:g}" if scene.E else ""
        text = f"z2 = {scene.z2:g}{eye}: {100 * designed:.0f} % of the window shows light on the prisms' designed path"
        yield (
            "z2",
            f"{text}, the rest is stray light; below {100 * MIN_DESIGNED_FRACTION:.0f} % little of the scene is seen",
        )
    if scene.sheet == "detailed" and abs((scene.alpha + 180) % 360 - 180) < MIN_ALPHA:
        text = f"alpha = {scene.alpha:.3g}: within {MIN_ALPHA} degrees of 0 the prisms of the two sheets"
        yield "alpha", f"{text} lie so nearly parallel that they make dark bands"
    yield from _prediction(scene, rendering)
    if glass and rendering and rendering.antialias is None:
        pixels = scene.window / scene.view_height * rendering.size[1] / scene.prisms
        if pixels < MIN_PIXELS_PER_PRISM:
            text = f"prisms = {scene.prisms}: a prism is {pixels:.2g} pixels wide; below {MIN_PIXELS_PER_PRISM} pixels,"
            yield "prisms", f"{text} without antialiasing, the picture is noise"


def _prediction(scene: Scene, rendering: Rendering | None) -> Iterator[tuple[str, str]]:
    """Where the predicted image, the overlay and the caption can no longer be trusted, for the worst of the objects."""
    two = scene.sheet in ("detailed", "ideal")
    shows = {
        "predicted_image": getattr(scene, "predicted_image", False),
        "overlay": rendering and rendering.overlay,
        "caption": rendering and rendering.caption and two,
    }
    names = [name for name, shown in shows.items() if shown]
    if not names or scene.sheet == "none":
        return
    import numpy as np

    from povgen.optics import rotation

    z1, alpha = np.array(scene.distances), radians(scene.alpha)
    with np.errstate(all="ignore"):
        if scene.sheet == "ideal":
            found = rotation.condition(scene.z2 / z1, alpha)
            # for an eye aside the camera may err by a pixel before that
            right = found / grid_error(scene, camera_cells(scene)) if scene.E else np.inf
            limit = np.broadcast_to(np.fmin(MAX_CONDITION, right), found.shape)
            what, size = "the object is magnified", "{:.3g} times"
        else:
            thin = rotation.apparent_position(scene.L, scene.E, z1, scene.z2, alpha)
            # what enters one sheet at a prism's edge leaves it half a pitch off
            moved = (
                scene.apparent_position(scene.L, z1) - thin
                if two
                else scene.pitch / 2 * np.divide(scene.z2, scene.z2 - z1)
            )
            found = np.nan_to_num(abs(moved), nan=np.inf) / scene.view_height * 960
            limit = np.full(len(found), MAX_CORRECTION)
            what, size = "the prisms' size moves the object", "by {:.3g} pixels of 1280x960"
    worst = np.argmax(found / limit)
    if found[worst] > limit[worst]:
        where = f"alpha = {scene.alpha:g} and " * two + f"z1 = {z1[worst]:g}"
        much = size.format(found[worst]) if np.isfinite(found[worst]) else "infinitely"
        text = f"{', '.join(names)}: at {where} {what} {much}; beyond {limit[worst]:.3g}"
        yield names[0], f"{text} its prediction is off by pixels"
