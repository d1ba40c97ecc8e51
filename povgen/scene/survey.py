"""Where the rays from a scene's eye go in its prisms, and the max_trace_level that POV-Ray needs for them.

POV-Ray shows only rays that meet fewer faces than max_trace_level. The designed path leads, in each sheet of prisms,
through one slanted facet, to the base, and through the other slanted facet. Through lenses it leads in at a lens, and
out at the lens opposite.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

from povgen.limits import MAX_FACES, MAX_LOST_FRACTION
from povgen.optics import apparent, trace
from povgen.optics.equations import Complexes, Floats
from povgen.optics.faces import GlassSheet
from povgen.optics.rays import Bundle, Opening, trace_windows
from povgen.scene.scene import Scene
from povgen.scene.scenes import AxialScene
from povgen.scene.windows import Placed


class Survey(NamedTuple):
    """The result of tracing rays from the eye through the windows of prisms."""

    # the least max_trace_level, with a margin, at which each window of prisms loses at most MAX_LOST_FRACTION of its
    # rays; at least 5, and enough for the designed path
    trace_level: int
    designed: float  # the fraction of the rays into the last window's frame that are on the designed path


class SurveyInputs(NamedTuple):
    """Everything on which a survey depends. Objects behind the prisms do not matter."""

    windows: tuple[Placed, ...]
    z2: float
    E: complex
    aperture: float
    depth: float  # extent of the windows' frames along z, tiles
    side: int  # the grid of rays to each window of prisms is side x side, or finer


class RoomInputs(NamedTuple):
    """Everything on which the survey of a room depends."""

    openings: tuple[Opening, ...]
    eye: tuple[float, float, float]


def inputs(scene: Scene, side: int = 60) -> SurveyInputs | RoomInputs:
    """Return everything on which a scene's survey depends."""
    if not isinstance(scene, AxialScene):
        return RoomInputs(tuple(scene.openings), scene.camera.eye)
    return SurveyInputs(scene.windows, scene.z2, scene.E, scene.aperture, scene.depth, side)


def prism_sheets(windows: tuple[Placed, ...]) -> tuple[GlassSheet, ...]:
    """Return the sheets of prisms in windows, the nearest to the eye first."""
    return tuple(layer for number, window in enumerate(windows) for layer in window.sheet.layers_at(window.z, number))


def survey(scene: Scene, side: int = 60) -> Survey:
    """Return the survey of a scene with prisms."""
    return of_inputs(inputs(scene, side))


known: dict[SurveyInputs | RoomInputs, Survey] = {}  # `warn` and the rendering need those of all frames of a movie
MOST_KNOWN = 60_000  # as many as the longest movie needs if it is stereo


def of_inputs(given: SurveyInputs | RoomInputs) -> Survey:
    """Return the survey for these inputs. It is made only if it is not known."""
    if given not in known:
        keep(given, _of_room(given) if isinstance(given, RoomInputs) else _traced(given))
    return known[given]


def keep(given: SurveyInputs | RoomInputs, found: Survey) -> None:
    """Put a survey into `known`. If `known` is full, it is emptied first."""
    if len(known) >= MOST_KNOWN:
        known.clear()
    known[given] = found


def _of_room(given: RoomInputs, count: int = 3600) -> Survey:
    """Trace rays from the eye to random points of each window of prisms, through all windows that are in the way."""
    layers = [layer for opening in given.openings for layer in opening.sheet.layers_at(0.0, 0)]
    level, designed = max(5, 1 + sum(len(trace.path_of(layer.shape)) for layer in layers)), 0.0
    rng = np.random.default_rng(1)
    for opening in given.openings:
        if not opening.sheet.layers_at(0.0, 0):
            continue
        points = rng.uniform(-0.5, 0.5, (count, 3)) * (*opening.outline[:2], 0)
        places, _ = opening.pose.scene(points, points)
        found = trace_windows(Bundle(given.eye, places - given.eye), given.openings, MAX_FACES)
        faces = np.where(found.end == trace.End.FRAME, 0, found.count)
        lost = max(1, int(0.8 * MAX_LOST_FRACTION * (found.count > 0).sum()))  # 0.8 is a margin, as in `_level`
        level = max(level, int(np.sort(faces)[-lost]) + 1)
        designed = max(designed, float(found.designed.mean()))
    return Survey(min(level, MAX_FACES), designed)


def _traced(given: SurveyInputs) -> Survey:
    """Trace rays from the eye to each window of prisms. Each of these windows is given its own rays.

    So a window of which the eye sees little, because it is far behind others, counts as much as the nearest one. The
    trace level is the greatest that any of these windows needs. The rays into the last window's frame give the fraction
    on the designed path. Ideal windows always stand before the prisms. If there are any, the traced rays start at the
    last ideal one.
    """
    windows, z2, E, aperture, depth, side = given
    glass = prism_sheets(windows)
    faces = sum(len(trace.path_of(sheet.shape)) for sheet in glass)
    level, designed = max(5, faces + 1), 0.0
    first = len(windows) - sum(window.sheet.layers > 0 for window in windows)
    start_z = windows[first - 1].z if first else -z2
    # First rays to each window's middle plane, then rays into its frame. In a deep frame, these are different rays.
    targets = product(range(first, len(windows)), (0.0, depth))
    several = [_crossings_up_to(number, given._replace(depth=at)) for number, at in targets]
    # All are traced at once: this takes less time, because the number of steps is that of the longest path.
    start = np.concatenate([P[first - 1] if first else np.full(P.shape[1], E) for P in several])
    away = np.concatenate([P[first] for P in several]) - start
    origin = np.column_stack((start.real, start.imag, np.full(len(start), start_z)))
    direction = np.column_stack((away.real, away.imag, np.full(len(start), windows[first].z - start_z)))
    every = trace.trace(origin, direction, glass, aperture)
    ends = np.cumsum([P.shape[1] for P in several])
    for group in map(slice, [0, *ends], ends):
        if not len(origin[group]):  # other windows hide this one
            designed = 0.0
            continue
        level = max(level, _level(origin[group], direction[group], every[group], glass, aperture))
        designed = float(every[group].designed.mean())
    return Survey(level, designed)


def _crossings_up_to(number: int, given: SurveyInputs) -> Complexes:
    """Return the points (number + 1, rays) where rays from the eye cross the windows 0 to `number`.

    Only rays that cross the windows before `number`, and enter the frame of this one, are returned. Here the sheets
    have no thickness. The rays pass a rectangle in the plane of the first window. It contains all points through which
    such rays can pass. It is divided into side^2 cells, with one ray through each. If fewer than side^2 of these rays
    arrive, it is divided into 4 side^2 cells, and then into 16 side^2. There can still be fewer. In each cell there is
    a random point, the same each time. Regularly spaced points would make moire with the prisms.
    """
    windows, z2, E, aperture, depth, side = given
    half = aperture / 2
    elements, z = [], -z2
    for window in windows[: number + 1]:
        elements.append((window.z - z, window.sheet.thin))
        z = window.z

    def crossings(P: Complexes) -> Complexes:
        followed = apparent.follow((P - E) / z2, E, elements)
        place, slope, *_ = followed[-1]
        return np.stack([*(each for each, *_ in followed), place - depth / 2 * slope])  # the last: where it enters

    bounds = [*range(number), number + 1]  # the crossings that have to be within the window's square
    # rays through the front of the first window's frame can cross the plane z = 0 outside the window
    most = half if number else np.inf
    low, high = np.full(2, -most), np.full(2, most)
    if apparent.matrix(elements[:-1]) is not None:  # the crossings are linear functions of P
        origin = crossings(np.array([E]))[:, 0]
        steps = crossings(E + np.array([1, 1j])) - origin[:, None]
        for at, (a, b) in zip(origin[bounds], steps[bounds], strict=True):
            size = (a.conjugate() * b).imag
            if abs(size) < 1e-18:  # the eye sees a point, or a line, of this window
                continue
            inverse = np.array([[b.imag, -b.real], [-a.imag, a.real]]) / size
            middle = np.array([E.real, E.imag]) - inverse @ (at.real, at.imag)
            reach = half * abs(inverse).sum(1)
            low, high = np.maximum(low, middle - reach), np.minimum(high, middle + reach)
    if (low >= high).any():
        return np.empty((number + 1, 0), complex)
    for n in (side, 2 * side, 4 * side):
        parts = np.indices((n, n)) + np.random.default_rng(1).uniform(size=(2, n, n))
        x, y = low[:, None] + (high - low)[:, None] * parts.reshape(2, -1) / n
        P = crossings(x + 1j * y)
        P = P[:, (np.maximum(abs(P.real), abs(P.imag)) <= half)[bounds].all(0)]  # NaN: no light passes
        if P.shape[1] >= side**2:
            break
    return P[:-1]


def _level(
    origin: Floats,
    direction: Floats,
    found: trace.Rays,
    glass: tuple[GlassSheet, ...],
    window: float,
) -> int:
    """Return the least trace level that loses few of the traced rays. Rays that reach no prism do not count."""
    reached = found.count > 0
    faces = np.where(found.end == trace.End.FRAME, 0, found.count)
    # 0.8 is a margin: pictures can lose a larger fraction than this sample
    lost = max(1, int(0.8 * MAX_LOST_FRACTION * reached.sum()))
    unfinished = found.end == trace.End.UNFINISHED
    if unfinished.sum() >= lost:  # too many rays met more faces than the first trace follows: follow these further
        longer = trace.trace(origin[unfinished], direction[unfinished], glass, window, MAX_FACES)
        faces[unfinished] = np.where(longer.end == trace.End.FRAME, 0, longer.count)
    return int(np.sort(faces)[-lost]) + 1


def max_trace_level(scene: Scene, found: Survey | None = None) -> int:
    """Return POV-Ray's max_trace_level (5 or more). A ray that meets this many faces is black.

    `found` is the scene's survey; without it, rays are traced. Surveys leave partial reflection out. With
    partial reflection, POV-Ray follows a ray until it carries too little light (`limits.LEAST_LIGHT`), and the level is
    MAX_FACES. A probe (a scene for measuring) can set the level with `trace_level`.
    """
    level: int | None = getattr(scene, "trace_level", None)
    if level or not scene.has_prisms:
        return level or 5
    return MAX_FACES if scene.fresnel else (found or survey(scene)).trace_level
