"""Rays through any list of windows, each of which stands anywhere.

The coordinates are those of `rays`. `trace.trace` follows rays through prisms. An ideal sheet bends them where they
meet it.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen.optics import ray_path
from povgen.optics.apparent import Element, nearest_rays
from povgen.optics.equations import Complexes
from povgen.optics.faces import Booleans, Floats, GlassSheet, Indices
from povgen.optics.opening import Opening
from povgen.optics.ray_path import Event, Steps
from povgen.optics.rays import PRECISION, Bundle, Traced, checked_count
from povgen.optics.trace import End, Rays, trace

# A law states the slope behind an ideal sheet for each slope before it. Of light, which comes from behind, only the
# slope behind is known. The slope before the sheet is searched for: first from the slope behind it, then from these.
_STARTS = (0, *(size * np.exp(0.25j * np.pi * n) for size in (0.3, 1.5) for n in range(8)))
MOST_FACES = 100_000
PART = 16384  # rays that are followed at once through ideal sheets: their arrays stay in the processor's cache
MOST_CROSSINGS = 100  # of windows, by one ray
_SURFACE = 1e-9  # tiles: a ray that starts so near a frame's surface, and runs away from it, does not meet it
AWAY = 5e-5  # tiles: so far behind a sheet a ray that leaves it starts, for another tracer
# follows rays (n, 3) through a window of prisms or lenses, in its coordinates, as `trace.trace` does
Follow = Callable[[Floats, Floats, Opening, Indices], Rays]
Bent = tuple[Indices, Floats, Floats, int]  # rays that an ideal sheet has bent: numbers, positions, directions, window


def trace_windows(
    rays: Bundle,
    windows: Iterable[Opening],
    most: int = 60,
    partial: np.random.Generator | None = None,
    path: bool = False,
    follow: Follow | None = None,
) -> Traced:
    """Follow a bundle through windows that stand anywhere and do not overlap.

    A ray passes the nearest window that it meets, then the nearest that it meets behind this one, and so on. Paths run
    both ways: a ray that meets an ideal sheet from behind takes the path of a ray from the front, backwards. A ray ends
    where it meets no further window (`End.BESIDE` if it has met none), after `most` faces of prisms or lenses, from 1
    to MOST_FACES, and after MOST_CROSSINGS windows. `partial` is as for `trace.trace`. With `path`, the rays' paths are
    kept. `follow` takes the place of `trace.trace`, without `partial` and `path`; the result then has no `faces`.
    Raises ValueError for arguments of other types, for rays that start in glass, or between the two sheets of a window,
    and for more paths than `ray_path.MOST` allows.
    """
    if not isinstance(rays, Bundle):
        raise ValueError(f"rays: {type(rays).__name__}; allowed: a Bundle, such as of rays() or pencil()")
    windows = list(windows)
    for window in windows:
        if not isinstance(window, Opening):
            raise ValueError(f"windows: {type(window).__name__}; allowed: each an Opening")
    if not isinstance(partial, (np.random.Generator, type(None))):
        raise ValueError(f"partial = {partial!r}: allowed: a numpy.random.Generator, or None")
    most = checked_count("max_faces", most, MOST_FACES)
    way = _way(rays, windows, most, partial, path, follow=follow)
    n = len(way.rays.end)
    met = np.stack(way.met, 1) if way.met else np.empty((n, 0), np.int32)
    kept: Any = np.empty((n, 0, 3)), np.empty((n, 0)), np.empty((n, 0)), np.empty((n, 0), int)
    if path:
        kept = ray_path.assembled(rays.position.reshape(n, 3), way.rays.position, way.events)
    return Traced(
        *(values.reshape((*rays.shape, *values.shape[1:])) for values in (*vars(way.rays).values(), met, *kept))
    )


def paths(rays: Bundle, windows: Iterable[Opening], most: int) -> list[tuple[Indices, Floats, Floats]]:
    """Follow a bundle as `trace_windows` does. Return the rays behind the first ideal sheet that each passes ...

    For each number of ideal sheets passed, from 1, these are the numbers of the rays (n,) in the flat bundle, in their
    order, and their positions and directions (n, 3). A position is AWAY behind the sheet.
    """
    windows = list(windows)
    bent: list[Bent] = []
    way = _way(rays, windows, most, bent=bent)
    count = np.zeros(len(way.rays.end), int)
    legs: list[list[tuple[Indices, Floats, Floats]]] = []
    for i, position, direction, w in bent:
        normal = windows[w].pose.axes[2]
        position = position + AWAY * np.sign(direction @ normal)[:, None] * normal
        for leg in np.unique(count[i]):
            some = count[i] == leg
            legs += [[] for _ in range(len(legs), leg + 1)]
            legs[leg].append((i[some], position[some], direction[some]))
        count[i] += 1
    found = []
    for parts in legs:
        i, position, direction = (np.concatenate(each) for each in zip(*parts, strict=True))
        order = np.argsort(i, kind="stable")
        found.append((i[order], position[order], direction[order]))
    return found


def _way(
    rays: Bundle,
    windows: Sequence[Opening],
    most: int,
    partial: np.random.Generator | None = None,
    path: bool = False,
    bent: list[Bent] | None = None,
    follow: Follow | None = None,
) -> "_Way":
    """Return rays that have been followed to their ends."""
    sheets = [window.sheet.glass for window in windows]
    n, layers = int(np.prod(rays.shape)), sum(map(len, sheets))
    position, direction = (values.reshape(n, 3) for values in (rays.position, rays.direction))
    found = Rays.starting(position, direction, most if layers and not follow else 0, layers)
    found.end[:], found.designed[:] = End.BESIDE, True
    way = _Way(found, [window.deep for window in windows], sheets, most, partial, path, bent, follow)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for first in range(0, n, at_once := max(n, 1) if layers else PART):
            way.run(np.arange(first, min(first + at_once, n)))
    found.designed &= found.end == End.THROUGH
    return way


@dataclass
class _Way:
    """Rays under way from window to window. i are the indices of rays, and w is the number of a window."""

    rays: Rays
    windows: Sequence[Opening]
    sheets: Sequence[Sequence[GlassSheet]]  # of prisms or lenses, in each window
    most: int
    partial: np.random.Generator | None
    path: bool
    bent: list[Bent] | None  # the rays that ideal sheets have bent, if they are asked for
    follow: Follow | None  # None: `trace.trace`
    met: list[NDArray[np.int32]] = field(default_factory=list)  # the windows that the rays have met, one after another
    events: list[Event] = field(default_factory=list)  # what rays have met, if their paths are kept

    def run(self, i: Indices) -> None:
        """Follow each of these rays to its end."""
        last = np.full(len(i), -1)
        for crossing in range(MOST_CROSSINGS + 1):
            found = nearest(self.windows, taken(self.rays.position, i), taken(self.rays.direction, i), last)
            some = found[0] >= 0
            i, met, distance, rim = i[some], found[0][some], found[1][some], found[2][some]
            if not len(i) or crossing == MOST_CROSSINGS:
                self.rays.end[i] = End.UNFINISHED
                return
            if crossing == len(self.met):
                self.met.append(np.full(len(self.rays.end), -1, np.int32))
            self.met[crossing][i] = met
            numbers = [w for w in range(len(self.windows)) if (met == w).any()]
            each = [(w, met == w) for w in numbers]
            leaving = [self.cross(i[some], w, distance[some], rim[some], self.met[crossing]) for w, some in each]
            i, last = np.concatenate(leaving), np.repeat(numbers, [*map(len, leaving)])

    def cross(self, i: Indices, w: int, distance: Floats, rim: Booleans, met: NDArray[np.int32]) -> Indices:
        """Take rays to a window at this distance, to its `rim` or through it. Return those that leave it."""
        window = self.windows[w]
        position, direction = window.pose.own(taken(self.rays.position, i), taken(self.rays.direction, i))
        position += distance[:, None] * direction
        outside = distance > 0
        beside = rim | (outside & (abs(position[:, 2]) < (1 - 1e-9) * window.frame / 2))
        ends = np.where(beside, End.FRAME, End.THROUGH).astype(np.uint8)
        # some rays start in the frame, behind the sheet: they only leave the frame
        front, back = self.reach(w, direction[:, 2] > 0)
        along = position[:, 2] * np.sign(direction[:, 2])
        ahead = ~beside & (outside | (along <= front))
        if (inside := ~beside & ~ahead & (along < back)).any():
            ray = int(i[np.argmax(inside)])
            raise ValueError(
                f"ray {ray} from {self.rays.position[ray]}: inside the sheets of window {w + 1}; allowed: outside"
            )
        skipped = i[~beside & ~ahead]
        met[skipped], self.rays.designed[skipped] = -1, False
        if self.sheets[w]:
            self.through_glass(i, w, ahead, position, direction, ends)
        else:
            self.bend(ahead, window, position, direction, ends)
            passed = np.flatnonzero(ahead & (ends == End.THROUGH))
        way = (np.copysign(window.frame / 2, direction[:, 2]) - position[:, 2]) / direction[:, 2]
        beyond = window.outline.excludes(*(position + np.maximum(way, 0)[:, None] * direction)[:, :2].T)
        ends[(ends == End.THROUGH) & beyond] = End.FRAME
        framed = np.flatnonzero((ends == End.FRAME) & ~beside)
        _, wall = window.outline.passage(taken(position, framed), taken(direction, framed), np.inf)
        position, direction = window.pose.scene(position, direction)
        if self.path and not self.sheets[w] and not np.all(window.sheet.transfer == np.eye(5)):
            kind, air = np.full(len(passed), ray_path.IDEAL), np.ones(len(passed))
            self.events.append(Event(i[passed], taken(position, passed), air, air, kind))
        if self.bent is not None and not self.sheets[w]:
            self.bent.append((i[passed], taken(position, passed), taken(direction, passed), w))
        # the face or the sheet that such a ray was taken to is before the frame's wall, or behind it
        position[framed] += np.where(np.isfinite(wall), wall, 0)[:, None] * direction[framed]
        # numpy sets whole vectors in four times as long
        for array, values in zip((self.rays.position, self.rays.direction), (position, direction), strict=True):
            for numbers, new in zip(array.T, values.T, strict=True):
                numbers[i] = new
        leaves = ends <= End.BACK
        ends ^= leaves & (self.rays.end[i] == End.BACK)  # light that is sent back twice goes on
        self.rays.end[i] = ends
        return i[leaves]

    def reach(self, w: int, forward: Booleans) -> tuple[Floats, Floats]:
        """Return where a window's sheets begin and end, measured along z in the directions of rays."""
        sheets, side = self.sheets[w], self.windows[w].sheet.aperture
        if not sheets:
            return np.zeros(len(forward)), np.zeros(len(forward))
        first, last = sheets[0].centre - sheets[0].reach(side), sheets[-1].centre + sheets[-1].reach(side)
        front, back = np.where(forward, first, -last), np.where(forward, last, -first)
        return front + 1e-9 * side, back - 1e-9 * side  # a ray may start where another has left the sheets

    def bend(self, ahead: Booleans, window: Opening, position: Floats, direction: Floats, ends: Any) -> None:  # noqa: ANN401
        """Bend the rays `ahead` at an ideal sheet. Changes the arrays, which are in the window's coordinates."""
        sheet, forward = window.sheet, direction[:, 2] > 0
        x, y, _ = (direction / direction[:, 2:]).T
        X, Y = position[:, 0] - position[:, 2] * x, position[:, 1] - position[:, 2] * y
        np.copyto(position.T, (X, Y, np.zeros(len(X))), where=ahead)
        inside = ahead & ~window.outline.excludes(X, Y)
        ends[ahead & ~inside] = End.FRAME
        before, place, after = x + 1j * y, X + 1j * Y, np.empty(len(x), complex)
        for way, slope in ((forward, sheet.slope), (~forward, lambda *ray: slope_of_light(sheet, *ray))):
            if len(some := np.flatnonzero(inside & way)):
                after[some] = slope(before[some], place[some])
        passes = inside & np.isfinite(after)
        ends[inside & ~passes] = End.BLOCKED
        size = np.where(forward, 1, -1) / np.sqrt(1 + after.real**2 + after.imag**2)
        np.copyto(direction.T, (after.real * size, after.imag * size, size), where=passes)

    def through_glass(
        self,
        i: Indices,
        w: int,
        ahead: Booleans,
        position: Floats,
        direction: Floats,
        ends: Any,  # noqa: ANN401
    ) -> None:
        """Follow the rays `ahead` through glass. Changes the arrays, which are in the window's coordinates."""
        rays, window, sheets = self.rays, self.windows[w], tuple(self.sheets[w])
        first = sum(map(len, self.sheets[:w]))
        j, some = i[ahead], np.flatnonzero(ahead)
        met = rays.count[j]  # faces, before this window
        most = self.most - met
        steps = Steps.empty(len(j), int(most.max(initial=0))) if self.path else None
        start = position[some], direction[some]
        if self.follow:
            after = self.follow(*start, window, most)
        else:
            after = trace(*start, sheets, window.outline, most, window.frame, self.partial, steps)
        position[some], direction[some], ends[some] = after.position, after.direction, after.end
        for count in np.unique(met):
            rays.faces[j[met == count], count:] = after.faces[met == count, : self.most - count]
        rays.count[j] += after.count
        rays.light[j] *= after.light
        rays.reflected[j] |= after.reflected
        rays.designed[j] &= after.designed
        rays.orders[j, first : first + len(sheets)] += after.orders
        if steps:
            for step in range(after.count.max(initial=0)):
                n = np.flatnonzero(after.count > step)
                places, _ = window.pose.scene(steps.place[n, step], direction[some[n]])
                behind, glass, faces = steps.behind[n, step], steps.glass[n, step], after.faces[n, step]
                self.events.append(Event(j[n], places, behind, glass, faces.astype(int)))


def taken(vectors: Floats, i: Indices) -> Floats:
    """Return some of the vectors (n, 3). In memory, their x come first: numpy takes a quarter of the time."""
    return vectors.T.take(i, 1).T


def nearest(
    windows: Sequence[Opening], position: Floats, direction: Floats, last: Indices
) -> tuple[Indices, Floats, Booleans]:
    """Return the window that each ray (n, 3) meets first, or -1, how far away it is, or infinity, and if it is the rim.

    The rim is what is seen of a frame from outside. `last` (n,) is the window that each ray has just left, or -1. A
    straight ray does not meet it again.
    """
    met, distance, rim = np.full(len(last), -1), np.full(len(last), np.inf), np.zeros(len(last), bool)
    for w, window in enumerate(windows):
        some = np.flatnonzero(last != w)
        own = window.pose.own(taken(position, some), taken(direction, some))
        begins, ends = window.outer.passage(*own, window.frame)
        closer = np.flatnonzero((begins <= ends) & (ends >= 0) & (begins < distance[some]))
        begins, framed = np.maximum(begins[closer], 0), np.zeros(len(closer), bool)
        if window.rim:
            start, way = (taken(values, closer) for values in own)
            framed = window.outline.excludes(*(start + begins[:, None] * way)[:, :2].T)
            meets = ~framed | (ends[closer] > _SURFACE)
            closer, begins, framed = closer[meets], begins[meets], framed[meets]
        i = some[closer]
        met[i], distance[i], rim[i] = w, begins, framed
    return met, distance, rim


def slope_of_light(window: Element, behind: Complexes, place: Complexes) -> Complexes:
    """Return the slopes (n,) before an ideal sheet of light that has the slopes `behind` it; NaN where none passes."""
    matrix = window.transfer
    if matrix is not None and abs(np.linalg.det(matrix[2:4, 2:4])) > 1e-6:  # slope = A place + B (slope before) + c
        rest = np.stack((behind.real, behind.imag)) - matrix[2:4, :2] @ (place.real, place.imag) - matrix[2:4, 4:]
        x, y = np.linalg.solve(matrix[2:4, 2:4], rest)
        return np.asarray(x + 1j * y)
    found, aim = np.full(len(behind), complex(np.nan, np.nan)), _sine(behind)

    def miss(slope: Complexes, target: Indices) -> Complexes:
        return window.slope(slope, place[target]) - behind[target]

    def miss_sine(slope: Complexes, target: Indices) -> Complexes:
        return _sine(window.slope(slope, place[target])) - aim[target]

    left = np.arange(len(behind))
    # Many laws are linear in the slope. Others, such as that of refraction, are nearly linear in its sine.
    for start, off_by in ((behind, miss), *((start, miss_sine) for start in (behind, *_STARTS))):
        size = 1 + abs(behind[left])
        enough = PRECISION * (size if off_by is miss else np.ones(len(left)))
        slope, off = nearest_rays(np.broadcast_to(start, behind.shape)[left].astype(complex), left, off_by, enough)
        # the sines of very large slopes are all alike
        hit = (off <= enough) & (abs(miss(slope, left)) <= 1e-6 * size)
        found[left[hit]], left = slope[hit], left[~hit]
    return found


def _sine(slope: Complexes) -> Complexes:
    """Return the part of a unit direction across z. At grazing directions it changes little, and the slope much."""
    return np.asarray(slope / np.hypot(1, abs(slope)))
