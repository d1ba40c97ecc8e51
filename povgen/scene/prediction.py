"""What follows from a scene's parameters: where its rays go, POV-Ray's settings, and warnings.

The designed path leads, in each sheet, through one slanted facet, to the base, and through the other slanted facet. All
other light is stray light. The limits are in limits.py.
"""

from cmath import rect
from collections.abc import Iterator
from dataclasses import replace
from math import ceil, hypot, inf, radians, sqrt
from typing import TYPE_CHECKING, NamedTuple

from povgen.optics.prism import Prism
from povgen.scene.limits import (
    MAX_CAMERA_ERROR,
    MAX_CELLS,
    MAX_CONDITION,
    MAX_ERROR,
    MAX_FACES,
    MAX_LOST_FRACTION,
    MIN_ALPHA,
    MIN_DESIGNED_FRACTION,
    MIN_PIXELS_PER_PRISM,
    RADII,
)
from povgen.scene.models import OTHER_SHEETS, Scene
from povgen.settings import Rendering

if TYPE_CHECKING:
    from povgen.optics import trace
    from povgen.optics.rotation import Complexes, Floats


class Survey(NamedTuple):
    """The result of tracing rays from the eye through a window of prisms."""

    # the least max_trace_level with which POV-Ray loses few of the rays to each window of prisms (MAX_LOST_FRACTION)
    trace_level: int
    designed: float  # the fraction of the rays to the last window that are on the designed path


# sheets, alpha and the windows behind the first one, z2, E, side of the windows, prism, number of rays
SurveyInputs = tuple[tuple[str, ...], float, tuple[tuple[float, float], ...], float, complex, float, Prism, int]
surveys: dict[SurveyInputs, Survey] = {}  # finished surveys, by their inputs


def survey(scene: Scene, side: int = 60) -> Survey:
    """Follow side^2 rays from the eye through a scene's prisms. Objects behind the prisms do not matter."""
    inputs = surveyed(scene, side)
    if inputs not in surveys:
        surveys[inputs] = _survey(*inputs)
    return surveys[inputs]


def surveyed(scene: Scene, side: int = 60) -> SurveyInputs:
    """Return everything on which a scene's survey depends."""
    return scene.sheets, scene.alpha, scene.behind, scene.z2, scene.E, scene.aperture, scene.prism, side


def prism_sheets(scene: Scene) -> "tuple[trace.Sheet, ...]":
    """Return the sheets of prisms in a scene, the nearest to the eye first."""
    return _sheets(scene.sheets, scene.alpha, scene.behind, scene.prism)


def _sheets(
    sheets: tuple[str, ...], alpha: float, behind: tuple[tuple[float, float], ...], prism: Prism
) -> "tuple[trace.Sheet, ...]":
    from povgen.optics import trace  # slow to load, and only prisms need it

    if "single" in sheets:
        return (trace.Sheet(0.0, 0.0),)
    first = sheets.count("ideal")
    turns = [radians(alpha), *(turn for _, turn in behind)]
    z = sum(distance for distance, _ in behind[:first])
    return tuple(replace(sheet, centre=sheet.centre + z) for sheet in trace.pair(turns[first], prism, behind[first:]))


def _survey(
    sheets: tuple[str, ...],
    alpha: float,
    behind: tuple[tuple[float, float], ...],
    z2: float,
    E: complex,
    window: float,
    prism: Prism,
    side: int,
) -> Survey:
    """Trace rays from the eye to each window of prisms. Each of these windows is given its own rays.

    So a window of which the eye sees little, because it is far behind others, counts as much as the nearest one. The
    trace level is the greatest that one of them needs. The rays to the last window give the fraction on the designed
    path.
    """
    import numpy as np

    from povgen.optics import trace

    glass = _sheets(sheets, alpha, behind, prism)
    level, designed = max(5, 3 * len(glass) + 1), 0.0  # the designed path meets three faces of each sheet
    first = sheets.count("ideal")
    distance = [z2, *(distance for distance, _ in behind)]
    for number in range(first, len(sheets)):
        P = _crossings_up_to(number, radians(alpha), behind, z2, E, window, side)
        count = P.shape[1]
        if not count:  # other windows hide this one
            designed = 0.0
            continue
        # rays start at the eye, or at the last ideal window
        start, end = P[first - 1] if first else np.full(count, E), P[first]
        origin = np.column_stack((start.real, start.imag, np.full(count, sum(distance[1:first]) if first else -z2)))
        direction = np.column_stack(((end - start).real, (end - start).imag, np.full(count, distance[first])))
        found = trace.trace(origin, direction, glass, window, prism)
        level = max(level, _level(origin, direction, found, glass, window, prism))
        designed = float(found.designed.mean())
    return Survey(level, designed)


def _crossings_up_to(
    number: int, alpha: float, behind: tuple[tuple[float, float], ...], z2: float, E: complex, window: float, side: int
) -> "Complexes":
    """Return where rays from the eye cross the windows up to this one (0: the first), (number + 1, rays).

    These are the rays that cross all of them, by the equations for sheets without thickness. A rectangle of the first
    window, which contains the points where they cross it, is divided into side^2 smaller ones, or into more if
    otherwise fewer rays than that would cross all windows. There is a random point in each, the same each time.
    Regularly spaced points would make moire with the prisms.
    """
    import numpy as np

    from povgen.optics import series

    half = window / 2
    # A ray through P crosses a window at E + scale (P - E): what is seen through the window is a turned square.
    scale = series.crossings(E + 1, E, z2, alpha, behind[:number]) - E
    inverse = 1 / np.where(abs(scale) < 1e-9, 1e-9, scale)
    middle, reach = E - E * inverse, half * (abs(inverse.real) + abs(inverse.imag))
    low = np.array([(middle.real - reach).max(), (middle.imag - reach).max()])
    high = np.array([(middle.real + reach).min(), (middle.imag + reach).min()])
    if (low >= high).any():
        return np.empty((number + 1, 0), complex)
    for n in (side, 2 * side, 4 * side):
        parts = np.indices((n, n)) + np.random.default_rng(1).uniform(size=(2, n, n))
        x, y = low[:, None] + (high - low)[:, None] * parts.reshape(2, -1) / n
        P = series.crossings(x + 1j * y, E, z2, alpha, behind[:number])
        P = P[:, (np.maximum(abs(P.real), abs(P.imag)) <= half).all(0)]
        if P.shape[1] >= side**2:
            break
    return P


def _level(
    origin: "Floats",
    direction: "Floats",
    found: "trace.Rays",
    glass: "tuple[trace.Sheet, ...]",
    window: float,
    prism: Prism,
) -> int:
    """Return the least trace level that loses few of the traced rays. Rays that reach no prism do not count."""
    import numpy as np

    from povgen.optics import trace

    reached = found.count > 0
    faces = np.where(found.end == trace.End.FRAME, 0, found.count)
    # 0.8 is a margin: pictures can lose a larger fraction than this sample
    lost = max(1, int(0.8 * MAX_LOST_FRACTION * reached.sum()))
    unfinished = found.end == trace.End.UNFINISHED
    if unfinished.sum() >= lost:  # too many rays met more faces than the first trace follows: follow these further
        longer = trace.trace(origin[unfinished], direction[unfinished], glass, window, prism, MAX_FACES)
        faces[unfinished] = np.where(longer.end == trace.End.FRAME, 0, longer.count)
    return int(np.sort(faces)[-lost]) + 1


def max_trace_level(scene: Scene) -> int:
    """Return POV-Ray's max_trace_level (5 or more). Rays that meet as many faces are not shown.

    A probe (a scene for measuring) can set it with `trace_level`.
    """
    level: int | None = getattr(scene, "trace_level", None)
    return level or (survey(scene).trace_level if scene.has_prisms else 5)


def camera_cells(scene: Scene) -> int:
    """Return the number of cells across the window in which the ideal sheet's camera interpolates view directions.

    This is the least number that keeps the error below MAX_CAMERA_ERROR, and at most MAX_CELLS. A probe can set it with
    `grid`. See camera/ideal.pov.j2. For an eye on the axis, the interpolation in the whole window is exact. But the
    part of it that shows a second window is no rectangle.
    """
    grid: int | None = getattr(scene, "grid", None)
    if grid:
        return grid
    if scene.sheet in OTHER_SHEETS:
        return _cells_of_other_sheet(scene)
    return (
        ceil(min(MAX_CELLS, max(1, sqrt(grid_error(scene, 1) / MAX_CAMERA_ERROR))))
        if scene.E or scene.simulated > 1
        else 1
    )


def grid_error(scene: Scene, cells: int) -> float:
    """Return the greatest error of an object's position in the ideal sheet's camera, in pixels of 1280x960.

    This is for an eye off the axis, or several windows; otherwise the interpolation is exact. POV-Ray interpolates
    between unit vectors at the corners of triangles. A ray then has the direction that belongs to another point, up to
    d^2 sin(2 field angle)/(8 z2) tiles away, for a triangle with the longest side d (docs/sheets.md). An object appears
    displaced by |P| times this distance, or for several windows |z1/Z| times.
    """
    half = scene.aperture / 2
    x, y = abs(scene.E.real), abs(scene.E.imag)
    nearest, farthest = hypot(max(0, x - half), max(0, y - half)), hypot(x + half, y + half)
    tangent = min(max(1, nearest / scene.z2), farthest / scene.z2)  # sin(2 angle) is greatest at 45 degrees
    displaced = 2 * (scene.aperture / cells) ** 2 * 2 * tangent / (1 + tangent**2) / (8 * scene.z2)
    return displaced * max((_P(scene, z1) for z1 in scene.distances), default=1) / scene.view * 960


def _cells_of_other_sheet(scene: Scene) -> int:
    """Return the cells across the window that keep the camera's error below MAX_CAMERA_ERROR, at most MAX_CELLS.

    The error is computed in the middle of the diagonals of 16 cells across the window. It falls as their square. If
    light passes only between the corners of these cells, the number is MAX_CELLS. For an eye on the axis, the camera is
    exact with one cell if the map of directions is linear (axis, lenslets, mirror), because it leaves the directions at
    the window's four corners equally long.
    """
    import numpy as np

    n = 16
    side = np.linspace(-0.5, 0.5, n + 1) * scene.aperture
    if not scene.E and scene.sheet != "refraction" and np.isfinite(_behind_other_sheet(scene, side[[0, -1]])).all():
        return 1
    with np.errstate(invalid="ignore", divide="ignore"):
        corners = _behind_other_sheet(scene, side)
        right = _behind_other_sheet(scene, (side[1:] + side[:-1]) / 2)
        shown = corners[:-1, :-1] + corners[1:, 1:]
        off = np.linalg.norm((shown / shown[..., 2:] - right / right[..., 2:])[..., :2], axis=-1)
        slope = corners[..., :2] / corners[..., 2:]
        # how far an object's point moves if its apparent position moves by a tile: the least, over all directions
        steps = [np.diff(slope, axis=axis)[:n, :n] / (side[1] - side[0]) for axis in (1, 0)]
        worst = 0.0
        for z1 in scene.distances or (2 * scene.z2,):
            jacobian = z1 * np.stack(steps, -1) + np.eye(2)
            least = abs(np.linalg.det(jacobian)) / np.linalg.norm(jacobian, axis=(-2, -1))
            errors = z1 * off / np.maximum(least, 0.02)
            errors = errors[~np.isnan(errors)]  # NaN: no light passes there
            if not len(errors):
                fine = _behind_other_sheet(scene, np.linspace(-0.5, 0.5, MAX_CELLS + 1) * scene.aperture)
                return 1 if np.isnan(fine).all() else MAX_CELLS
            worst = max(worst, np.quantile(errors, 0.98, method="higher"))
    error = worst / scene.view * 960
    return ceil(min(MAX_CELLS, max(1, n * sqrt(error / MAX_CAMERA_ERROR))))


def _behind_other_sheet(scene: Scene, side: "Floats") -> "Floats":
    """Return the unit directions (n, n, 3), behind the sheet, of lines of sight. NaN: no light passes.

    They cross the window at the points of a grid, whose x and y are `side` (n,), tiles.
    """
    import numpy as np

    view = np.stack(np.broadcast_arrays(side - scene.E.real, side[:, None] - scene.E.imag, scene.z2), -1)
    bent = scene.bend(view)
    with np.errstate(invalid="ignore"):
        return np.asarray(bent / np.linalg.norm(bent, axis=-1, keepdims=True))


def _P(scene: Scene, z1: float) -> float:
    """Return |z1/Z|, which is |P| of eq. 7 for one window. Unlike `rotation` it does not need numpy, slow to load."""
    Z, turn = complex(scene.z2), 1 + 0j
    for distance, alpha in ((0, radians(scene.alpha)), *scene.behind):
        Z, turn = Z + distance * turn, turn * rect(1, -alpha)
    Z += z1 * turn
    return z1 / abs(Z) if Z else inf


def warnings(scene: Scene, rendering: Rendering | None = None) -> Iterator[tuple[str, str]]:
    """Yield, for each limit that a picture of the scene exceeds, the name of the parameter and a sentence."""
    glass = scene.has_prisms
    if glass and (designed := survey(scene).designed) < MIN_DESIGNED_FRACTION:
        eye = " and an eye at {:g},{:g}".format(*scene.eye) if scene.E else ""
        shape = {name: getattr(scene, name) for name in ("index", "base_angle", "gap", "aspect")}
        unusual = (f", {name} = {x:g}" for name, x in shape.items() if x != type(scene).model_fields[name].default)
        text = f"z2 = {scene.z2:g}{eye}{''.join(unusual)}: {100 * designed:.0f} % of the window shows light on the"
        text += " prisms' designed path,"
        least = f"{100 * MIN_DESIGNED_FRACTION:.0f} %"
        yield "z2", f"{text} the rest is stray light; below {least} little of the scene is visible"
    for sheet, alpha in zip(scene.sheets, scene.alphas, strict=True):
        if sheet != "detailed" or abs((alpha + 180) % 360 - 180) >= MIN_ALPHA:
            continue
        text = f"alpha = {alpha:.3g}: within {MIN_ALPHA} degrees of 0 the prisms of the two sheets are nearly"
        yield "alpha", f"{text} parallel and make dark bands (moire)"
    yield from _other_sheet(scene, rendering) if scene.sheet in OTHER_SHEETS else _prediction(scene, rendering)
    if glass and rendering and rendering.antialias is None:
        pixels = scene.aperture / scene.view * rendering.size[1] / scene.prisms
        if pixels < MIN_PIXELS_PER_PRISM:
            text = f"prisms = {scene.prisms}: a prism is {pixels:.2g} pixels wide; below {MIN_PIXELS_PER_PRISM} pixels,"
            yield "prisms", f"{text} without antialiasing, the picture is noise"


def _other_sheet(scene: Scene, rendering: Rendering | None) -> Iterator[tuple[str, str]]:
    """Yield a warning if no light passes through the window, and if the overlay cannot mark an object."""
    import numpy as np

    if np.isnan(_behind_other_sheet(scene, np.linspace(-0.5, 0.5, MAX_CELLS + 1) * scene.aperture)).all():
        by = {"axis": "axis and alpha", "refraction": "ratio, z2 and eye"}[scene.sheet]  # the others pass all light
        yield "sheet", f"sheet = {scene.sheet}: no light passes through the window, because of {by}"
    for (L, z1), radius in zip(scene.objects, scene.radii, strict=True) if rendering and rendering.overlay else ():
        if not np.isfinite(scene.apparent_position(L, z1, near=radius)):
            text = (
                f"overlay: at alpha = {scene.alpha:g} and z1 = {z1:g} the object has no mark: it appears at infinity,"
            )
            yield "overlay", f"{text} or none of its light reaches the eye"


def possible_error(scene: Scene, L: complex, z1: float, radius: float) -> float:
    """Return by how many pixels of 1280x960 the prediction for an object behind prisms can be wrong.

    L and z1 are the object's; its radius is in tiles. Infinite if the object appears at infinity.
    """
    from povgen.optics import paraxial

    alpha = radians(scene.alpha)
    if scene.sheet == "single":
        k, near = [1 / scene.prism.pitch + 0j], abs(scene.z2 - z1)
        M = scene.z2 / near if near else inf
    else:
        k = paraxial.frequencies(scene.z2, alpha, scene.prisms_by_window, scene.behind)
        A, B = paraxial.depths(z1, scene.z2, alpha, scene.prisms_by_window, scene.behind)
        M, near = float(scene.nu_and_M(z1)[1]), float(abs(abs(A) - abs(B)))
    if not near:
        return inf
    tangent = abs(complex(scene.apparent_position(L, z1)) - scene.E) / scene.z2
    apparent = min(max(M * radius, RADII[0]), RADII[1])
    error = paraxial.possible_error(k, scene.z2 / near, apparent, tangent, scene.z2, scene.prism)
    return error / scene.view * 960


def _prediction(scene: Scene, rendering: Rendering | None) -> Iterator[tuple[str, str]]:
    """Yield a warning for the worst object if the predicted image, overlay or caption is wrong by several pixels."""
    two = scene.sheet in ("detailed", "ideal")
    shows = {
        "predicted_image": getattr(scene, "predicted_image", False),
        "overlay": rendering and rendering.overlay,
        "caption": rendering and rendering.caption and two,
    }
    names = [name for name, shown in shows.items() if shown]
    if not names or scene.sheet == "none":
        return
    from povgen.optics import rotation

    found = []
    for (L, z1), radius in zip(scene.objects, scene.radii, strict=True):
        if scene.has_prisms:
            found.append((possible_error(scene, L, z1, radius), MAX_ERROR, z1, "the prisms' size"))
        else:  # up to MAX_CONDITION, the error is one pixel; so is that between the camera's cells
            Z = abs(rotation.depth(z1, scene.z2, radians(scene.alpha), scene.behind))
            M = float(scene.z2 / Z) if Z else inf
            cells = camera_cells(scene)
            error = max(M / MAX_CONDITION, grid_error(scene, cells) if cells > 1 else 0)
            found.append((error, 1, z1, f"the magnification of the object, {M:.3g} times"))
    error, limit, z1, cause = max(found, key=lambda each: each[0])
    if error > limit:
        where = f"alpha = {scene.alpha:g} and " * two + f"z1 = {z1:g}"
        much = f"by up to {error:.3g} pixels of 1280x960" if error < 1280 else "by more than the picture's width"
        yield names[0], f"{', '.join(names)}: at {where} the prediction can be wrong {much}, because of {cause}"
