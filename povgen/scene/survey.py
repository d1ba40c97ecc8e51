"""Where the rays from a scene's eye go in its prisms, and the max_trace_level that POV-Ray needs for them.

POV-Ray shows only rays that meet fewer faces than max_trace_level. The designed path leads, in each sheet of prisms,
through one slanted facet, to the base, and through the other slanted facet. Through lenses it leads in at a lens, and
out at the lens opposite.
"""

from typing import NamedTuple

import numpy as np

from povgen.limits import MAX_FACES, MAX_LOST_FRACTION
from povgen.optics import trace
from povgen.optics.camera import Vector
from povgen.optics.faces import Floats, Indices
from povgen.optics.opening import Opening
from povgen.optics.paths import DesignedLight
from povgen.optics.rays import Bundle, Traced
from povgen.optics.window_trace import trace_windows
from povgen.scene.scene import Scene


class Survey(NamedTuple):
    """The result of tracing rays from the eye through the windows of prisms."""

    # the least max_trace_level, with a margin, at which each window of prisms loses at most MAX_LOST_FRACTION of its
    # rays; at least 5, and enough for the designed path
    trace_level: int
    # the fraction of the rays into a window's frame that are on the designed path and meet no later window: that of
    # the window of prisms with the greatest
    designed: float


class Inputs(NamedTuple):
    """Everything on which a survey depends. Objects do not matter."""

    openings: tuple[Opening, ...]
    eye: Vector
    side: int  # the rays to each window are side^2


def inputs(scene: Scene, side: int = 60) -> Inputs:
    """Return everything on which a scene's survey depends."""
    # the sides of frames do not end rays: pictures show them
    return Inputs(tuple(opening._replace(rim=0.0) for opening in scene.openings), scene.camera.eye, side)


def survey(scene: Scene, side: int = 60) -> Survey:
    """Return the survey of a scene with prisms."""
    return of_inputs(inputs(scene, side))


known: dict[Inputs, Survey] = {}  # `warn` and the rendering need those of all frames of a movie
MOST_KNOWN = 60_000  # as many as the longest movie needs if it is stereo


def of_inputs(given: Inputs) -> Survey:
    """Return the survey for these inputs. It is made only if it is not known."""
    if given not in known:
        keep(given, _traced(given))
    return known[given]


def keep(given: Inputs, found: Survey) -> None:
    """Put a survey into `known`. If `known` is full, it is emptied first."""
    if len(known) >= MOST_KNOWN:
        known.clear()
    known[given] = found


def _traced(given: Inputs) -> Survey:
    """Trace rays from the eye to each window of prisms: those that the designed light of other windows leads to it.

    So a window of which the eye sees little, because it is far behind others, counts as much as the nearest one. Rays
    are aimed at each window. A window's rays are those aimed at the one through which the eye sees most of it, by the
    solid angle. If there are few, others beside these are taken.
    """
    openings, eye, side = given
    glass = [opening.sheet.glass for opening in openings]
    level, designed = max(5, 1 + sum(len(trace.path_of(layer.shape)) for layers in glass for layer in layers)), 0.0
    rng, light = np.random.default_rng(1), DesignedLight(openings)

    def met(places: Floats) -> Indices:
        """Return the windows that rays to these places (n, 3) meet, (windows, n)."""
        return np.stack([leg.window for leg in light.walk(Bundle(eye, places - eye))])

    aims = [_aims(opening, eye, side, rng) for opening in openings]
    passed = [met(places) for places, *_ in aims]
    for number in (number for number, layers in enumerate(glass) if layers):
        several = [np.flatnonzero((each == number).any(0)) for each in passed]
        (places, cells, _), some = max(zip(aims, several, strict=True), key=lambda pair: pair[0][2][pair[1]].sum())
        chosen = places[some]
        if 0 < len(some) < side**2 / 4:
            some = np.resize(some, side**2)
            chosen = places[some] + (rng.uniform(-0.5, 0.5, (side**2, 1, 2)) @ cells[some])[:, 0]
            chosen = chosen[(met(chosen) == number).any(0)]
        if len(chosen):
            found = trace_windows(Bundle(eye, chosen - eye), openings, MAX_FACES)
            level = max(level, _level(found))
            designed = max(designed, float((found.designed & (found.last == number)).mean()))
    return Survey(level, designed)


def _aims(opening: Opening, eye: Vector, side: int, rng: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Return side^2 places (n, 3) in the front opening of a window's frame.

    Also return the sides (n, 2, 3) of their cells, and how large these are for the eye (n,), steradians. In each cell
    there is a random place, the same each time. Regularly spaced places would make moire with the prisms.
    """
    own, _ = opening.pose.own(np.array([eye]), np.zeros((1, 3)))
    cells = (np.indices((side, side)).reshape(2, -1).T + rng.uniform(size=(side**2, 2))) / side - 0.5
    size = np.array(opening.outline[:2])
    front = np.full(side**2, np.copysign(opening.frame / 2, own[0, 2]))
    places = np.column_stack((cells * size, front))
    places, _ = opening.pose.scene(places, places)
    across, along = opening.pose.axes[:2] * size[:, None] / side
    way = places - eye
    seen = abs(way @ np.cross(across, along)) / np.linalg.norm(way, axis=1) ** 3
    return places, np.broadcast_to((across, along), (side**2, 2, 3)), seen


def _level(found: Traced) -> int:
    """Return the least trace level that loses few rays, of those that neither a frame nor a black top stops."""
    faces = found.count[(found.count > 0) & ~np.isin(found.end, (trace.End.FRAME, trace.End.ABSORBED))]
    # 0.75 is a margin: pictures can lose a larger fraction than this sample
    lost = max(1, int(0.75 * MAX_LOST_FRACTION * len(faces)))
    return int(np.sort(faces)[-lost]) + 1 if len(faces) else 0


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
