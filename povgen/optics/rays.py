"""Bundles of rays through any list of windows: where the rays go, the spot they make, and where they converge.

The coordinates are the scenes': x right, y up, z away from the eye, and z = 0 in the middle of the first window. All
lengths are in one unit, in scenes the tile. There are no angles: a direction is a vector (dx, dy, dz).

Rays with dz > 0 run away from the eye, as a camera's do. Rays with dz < 0 run with the light, towards the eye. Both
take the same paths. `trace.trace` follows rays through prisms. An ideal sheet bends them where they meet it.
"""

from __future__ import annotations  # help() then says ArrayLike

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from numbers import Complex, Real
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics import ray_path
from povgen.optics.apparent import Element, nearest_rays
from povgen.optics.equations import Complexes, real
from povgen.optics.faces import Booleans, Floats, GlassSheet, Indices
from povgen.optics.outline import Outline
from povgen.optics.pose import Pose
from povgen.optics.ray_path import Event, Steps
from povgen.optics.trace import CHUNK, End, Rays, trace
from povgen.optics.values import Values

# A law states the slope behind an ideal sheet for each slope before it. Of light, which comes from behind, only the
# slope behind is known. The slope before the sheet is searched for: first from the slope behind it, then from these.
_STARTS = (0, *(size * np.exp(0.25j * np.pi * n) for size in (0.3, 1.5) for n in range(8)))
LARGEST = 1e4  # coordinate of a point, tiles: more is perhaps in another unit
MOST = 10**8  # rays of a spot: their points need 2 GB
AT_ONCE = 4 * 10**7  # rays of a bundle: they need 2 GB
MOST_FACES = 100_000
PART = 16384  # rays that are followed at once through ideal sheets: their arrays stay in the processor's cache
MOST_CROSSINGS = 100  # of windows, by one ray
AWAY = 5e-5  # tiles: so far behind a sheet a ray that leaves it starts, for another tracer
Bent = tuple[Indices, Floats, Floats, int]  # rays that an ideal sheet has bent: numbers, positions, directions, window
# the greatest error of the transverse part of a traced ray's unit direction: that of light that comes from behind
_PRECISION = 1e-11


class Opening(NamedTuple):
    """A window: where its opening stands, what is in it, how deep its frame is, and its outline."""

    pose: Pose
    sheet: Element
    frame: float = 0.0  # extent of the frame along the window's normal; `deep` makes it hold prisms or lenses
    own_outline: Outline | None = None  # None: a square, with the sheet's side
    framed: bool = True  # whether a frame is seen; without it, prisms or lenses have black edges

    @property
    def outline(self) -> Outline:
        """The opening's outline."""
        return self.own_outline or Outline(self.sheet.aperture, self.sheet.aperture)

    @property
    def edge(self) -> Floats:
        """Points of the outline, (n, 3), the first of which is the last."""
        turn = np.linspace(0, 2 * np.pi, 65 if self.outline.is_round else 5) + np.pi / 4
        x, y = (part if self.outline.is_round else np.sign(part) for part in (np.cos(turn), np.sin(turn)))
        own = np.stack((x * self.outline.width / 2, y * self.outline.height / 2, 0 * x), -1)
        return np.asarray(own @ self.pose.axes + self.pose.place)

    @property
    def deep(self) -> Opening:
        """The window with a frame that is at least as deep as its prisms or lenses."""
        sheets = self.sheet.glass
        depth = sheets[-1].centre - sheets[0].centre + sheets[0].shape.length if sheets else 0.0
        return self._replace(frame=max(self.frame, depth))


class Convergence(NamedTuple):
    """Where rays are closest together, in a plane parallel to the sheets. Lengths are in the unit of the rays."""

    x: float  # middle of the rays in this plane; x and y are NaN for parallel rays
    y: float
    z: float  # of the plane; infinite for parallel rays
    rms: float  # distance of the rays from the middle, in this plane


class _Lines(Values):
    """The base class of rays outside the windows. Each ray is a straight line."""

    position: Floats
    direction: Floats
    _precision = 1e-15  # the greatest error of the transverse part of a unit direction

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the bundle, such as (height, width) if there is a ray for each pixel."""
        return self.position.shape[:-1]

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {' x '.join(map(str, self.shape)) or 1} rays>"

    def __len__(self) -> int:
        """Return the length of the first axis, as numpy does."""
        return len(self.position[..., 0])

    @property
    def slope(self) -> Complexes:
        """(dx + i dy)/dz of each ray, without a unit. It is the same whichever way the ray runs; infinite if dz = 0."""
        return (self.direction[..., 0] + 1j * self.direction[..., 1]) / self.direction[..., 2]

    def at(self, z: float) -> Complexes:
        """Return where the rays, extended both ways, cross the plane z: x + iy, in the unit of z."""
        return self.position[..., 0] + 1j * self.position[..., 1] + (z - self.position[..., 2]) * self.slope

    def convergence(self) -> Convergence:
        """Return where the rays, extended both ways, are closest together: where they make the smallest spot.

        Its size is the RMS distance of the rays from their mean, in a plane z = constant. For an image that is not
        sharp, the spot is the circle of least confusion. Raises ValueError for fewer than two rays.
        """
        slope, place = self.slope.ravel(), self.at(0).ravel()
        if len(slope) < 2:
            raise ValueError(f"{len(slope)} rays; allowed: two or more")
        ds, dP = slope - slope.mean(), place - place.mean()
        square = np.vdot(ds, ds).real
        if square <= np.sum((10 * self._precision * (1 + abs(slope))) ** 2):
            return Convergence(np.nan, np.nan, np.inf, float(np.sqrt(np.mean(abs(dP) ** 2))))
        z = -np.vdot(ds, dP).real / square
        middle = place.mean() + z * slope.mean()
        return Convergence(float(middle.real), float(middle.imag), float(z), _rms(dP + z * ds))

    def __getitem__(self, which: Any) -> Self:  # noqa: ANN401  (what numpy takes)
        """Return some of the rays, as rays[rays.designed], or rays[row, column] for the ray of a pixel."""
        some = which if isinstance(which, tuple) else (which,)
        np.broadcast_to(False, self.shape)[some]  # raises IndexError for more axes than those of the rays
        axes = len(self.shape)
        end = [slice(None)] if any(each is ... for each in some) else []
        return type(self)(**{name: values[(*some, *end * (values.ndim - axes))] for name, values in vars(self).items()})


class Bundle(_Lines):
    """Rays: where they start, and their directions.

    `position` is (x, y, z) in tiles, `direction` (dx, dy, dz) of any length, which becomes a unit vector. Both are
    arrays (..., 3), and broadcast. Raises ValueError for anything else, for numbers that are not finite, and for a
    direction without length.
    """

    def __init__(self, position: ArrayLike, direction: ArrayLike) -> None:
        start, along = _numbers("position", position), _numbers("direction", direction)
        for name, values in (("position", start), ("direction", along)):
            if not values.ndim or values.shape[-1] != 3:
                raise ValueError(f"{name}: an array of the shape {values.shape}; allowed: (..., 3), x, y and z")
            if not np.isfinite(values).all():
                raise ValueError(f"{name}: not finite; allowed: finite numbers")
        if not along.any(-1).all():
            raise ValueError("direction: 0, 0, 0; allowed: a direction with a length")
        # copies: the caller may change the given arrays
        try:
            self.position, along = map(np.array, np.broadcast_arrays(start, along))
        except ValueError:
            raise ValueError(
                f"position and direction: the shapes {start.shape} and {along.shape} do not broadcast"
            ) from None
        along /= abs(along).max(-1, keepdims=True, initial=0)  # squares of the components are in range
        self.direction = along / np.linalg.norm(along, axis=-1, keepdims=True)


def _numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        return real(name, values)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name}: allowed: an array of real numbers") from None


@dataclass(eq=False, repr=False)
class Traced(_Lines, Rays):
    """Where and how the rays of a bundle end. All arrays begin with the bundle's shape.

    `position` (..., 3), in tiles, is where a ray leaves the last window, or ends; `direction` (..., 3) is its last
    direction, a unit vector; `end` says how it ends. A ray is `designed` if it leaves on the path for which the sheets
    are made: through all ideal sheets and, in each sheet of prisms, through one slanted facet, to the base, and through
    the other slanted facet. `faces` (..., most) are the prisms' faces that the ray has met, in their order, and `count`
    is their number. A ray enters a sheet of lenses by one lens and leaves it by another. `orders` (..., sheets) says by
    how many cells the second lens is above the one opposite the first: 0 on the designed path. `light` and `reflected`
    are as in `trace.Rays`. `windows` (..., crossings) are the numbers of the windows that the ray meets, in their
    order, and -1 after the last, or where a ray starts in a frame behind its sheet.

    If the paths were kept, `corners`, `media` and `met` are their points: `ray_path`. Otherwise they are empty.
    """

    windows: NDArray[np.int32]
    corners: Floats
    media: Floats
    met: Indices

    @property
    def length(self) -> Floats:
        """The optical path length of each ray (...), tiles, from its start to its end: `ray_path.length`."""
        return ray_path.length(*self._path)

    @property
    def jones(self) -> Complexes:
        """What the faces do to the field of each ray's light, (..., 2, 2): `ray_path.jones`."""
        return ray_path.jones(*self._path)

    def table(self) -> dict[str, NDArray[Any]]:
        """Return a table of all corners of the paths: `ray_path.table`."""
        return ray_path.table(*self._path)

    @property
    def _path(self) -> tuple[Floats, Floats, Indices]:
        if not self.corners.shape[-2]:
            raise ValueError("the paths were not kept; allowed: rays of trace(..., path=True)")
        return self.corners, self.media, self.met

    @property
    def last(self) -> NDArray[np.int32]:
        """The number of the last window that each ray has met (...), or -1."""
        last = np.full(self.shape, -1, np.int32)
        for number in np.moveaxis(self.windows, -1, 0):
            last = np.where(number < 0, last, number)
        return last

    def met_each_in_turn(self, forward: Booleans, count: int) -> Booleans:
        """Return which rays have met every window on their way, if `count` windows stand one behind the other.

        `forward` says which rays came from the side of window 0. A ray that returns meets them again.
        """
        if not self.windows.shape[-1]:
            return np.zeros(self.shape, bool)
        first, last, back = self.windows[..., 0], self.last, self.end == End.BACK
        begins = np.where(forward, first == 0, first == count - 1)
        ends = np.where(forward == back, last == 0, last == count - 1)
        misses = (abs(np.diff(self.windows)) != 1) & (self.windows >= 0)[..., 1:]
        return np.asarray(begins & ends & ~misses.any(-1))

    _precision = _PRECISION


@dataclass(frozen=True, eq=False, repr=False)
class Spot(Values):
    """A spot diagram: where the rays of a pencil cross a plane."""

    points: NDArray[np.complex128]  # x + iy (n,), tiles
    z: float  # of the plane, tiles
    share: float  # of the pencil's rays, 0 to 1: the others are lost, or stray light

    def __repr__(self) -> str:
        return f"<Spot: {len(self)} points at z = {self.z:g}, rms {self.rms:.3g} tiles>"

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    @property
    def centre(self) -> complex:
        """The mean of the points, x + iy, tiles; NaN if there are none."""
        return complex(self.points.mean()) if len(self.points) else complex(np.nan, np.nan)

    @property
    def rms(self) -> float:
        """The RMS distance of the points from the centre, tiles; NaN if there are none."""
        return _rms(self.points - self.centre) if len(self.points) else np.nan


def pencil(
    windows: Sequence[Opening], point: ArrayLike, count: int, middle: complex, radius: float, seed: int
) -> Iterator[Bundle]:
    """Yield `count` rays from a point (x, y, z) to random points of a disc, CHUNK at a time.

    Regular points would make moire with prisms. The disc's centre is `middle`, x + iy, in the plane of the window that
    is nearest to the point. `seed`, a whole number, is that of the random numbers. When the first bundle is taken,
    raises ValueError for a point between the windows, and for numbers outside their ranges.
    """
    start = _numbers("point", point)
    if start.shape != (3,) or not (abs(start) <= LARGEST).all():
        raise ValueError(f"point = {point!r}: allowed: x, y and z, from -{LARGEST:g} to {LARGEST:g}, in tiles")
    first, last = windows[0].pose.z, windows[-1].pose.z
    if first <= start[2] <= last:
        raise ValueError(f"point = {start}: between the windows; allowed: z < {first:g} or z > {last:g}")
    numbers = isinstance(radius, Real) and isinstance(middle, Complex) and bool not in (type(radius), type(middle))
    if not (numbers and 0 < radius <= LARGEST and abs(middle) <= LARGEST):
        raise ValueError(f"middle = {middle!r}, radius = {radius!r}: allowed: up to {LARGEST:g} tiles, radius above 0")
    middle, radius = complex(middle), float(radius)  # from any types of numbers
    rng = np.random.default_rng(checked_count("seed", seed, 10**9, 0))
    count = checked_count("count", count, MOST)
    z = last if start[2] > last else first
    for n in range(0, count, CHUNK):
        size, turn = rng.uniform(size=(2, min(CHUNK, count - n)))
        disc = middle + radius * np.sqrt(size) * np.exp(2j * np.pi * turn)
        yield Bundle(start, np.column_stack((disc.real, disc.imag, np.full(len(disc), z))) - start)


def joined(bundles: Iterable[Bundle]) -> Bundle:
    """Return the rays of several bundles of any shapes as one bundle (n,). Without bundles, it has no rays."""
    none = np.empty((0, 3))
    parts = [(bundle.position.reshape(-1, 3), bundle.direction.reshape(-1, 3)) for bundle in bundles]
    position, direction = zip((none, none), *parts, strict=True)
    return Bundle(np.concatenate(position), np.concatenate(direction))


def checked_count(name: str, value: object, most: int, least: int = 1) -> int:
    """Return a number, such as of rays. Raises ValueError if it is not a whole number from `least` to `most`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value <= most:
        raise ValueError(f"{name} = {value!r}: allowed: a whole number from {least} to {most}")
    return int(value)


def spot(traced: Iterable[Traced], z: float, stray: bool = False) -> Spot:
    """Return the spot diagram in the plane z of the designed rays, or with `stray` of all rays that end as THROUGH.

    Raises ValueError if z is not a finite number, and if there are no rays.
    """
    z = z.item() if isinstance(z, np.number) else z
    number = isinstance(z, (int, float)) and not isinstance(z, bool)
    if not (number and abs(z) <= float(np.finfo(float).max)):
        raise ValueError(f"z = {z!r}: allowed: a finite number, tiles")
    points, count = [], 0
    for rays in traced:
        points.append(rays[rays.end == End.THROUGH if stray else rays.designed].at(z).ravel())
        count += rays.end.size
    if not count:
        raise ValueError("0 rays; allowed: one or more")
    joined = np.concatenate(points)
    return Spot(joined, z, len(joined) / count)


def trace_windows(
    rays: Bundle,
    windows: Iterable[Opening],
    most: int = 60,
    partial: np.random.Generator | None = None,
    path: bool = False,
) -> Traced:
    """Follow a bundle through windows that stand anywhere and do not overlap.

    A ray passes the nearest window that it meets, then the nearest that it meets behind this one, and so on. Paths run
    both ways: a ray that meets an ideal sheet from behind takes the path of a ray from the front, backwards. A ray ends
    where it meets no further window (`End.BESIDE` if it has met none), after `most` faces of prisms or lenses, from 1
    to MOST_FACES, and after MOST_CROSSINGS windows. `partial` is as for `trace.trace`. With `path`, the rays' paths are
    kept. Raises ValueError for arguments of other types, for rays that start in glass, or between the two sheets of a
    window, and for more paths than `ray_path.MOST` allows.
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
    way = _way(rays, windows, most, partial, path)
    n = len(way.rays.end)
    met = np.stack(way.met, 1) if way.met else np.empty((n, 0), np.int32)
    kept: Any = np.empty((n, 0, 3)), np.empty((n, 0)), np.empty((n, 0), int)
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
) -> _Way:
    """Return rays that have been followed to their ends."""
    sheets = [window.sheet.glass for window in windows]
    n, layers = int(np.prod(rays.shape)), sum(map(len, sheets))
    position, direction = (values.reshape(n, 3) for values in (rays.position, rays.direction))
    found = Rays.starting(position, direction, most if layers else 0, layers)
    found.end[:], found.designed[:] = End.BESIDE, True
    way = _Way(found, [window.deep for window in windows], sheets, most, partial, path, bent)
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
    met: list[NDArray[np.int32]] = field(default_factory=list)  # the windows that the rays have met, one after another
    events: list[Event] = field(default_factory=list)  # what rays have met, if their paths are kept

    def run(self, i: Indices) -> None:
        """Follow each of these rays to its end."""
        last = np.full(len(i), -1)
        for crossing in range(MOST_CROSSINGS + 1):
            met, distance = nearest(self.windows, taken(self.rays.position, i), taken(self.rays.direction, i), last)
            i, distance, met = i[met >= 0], distance[met >= 0], met[met >= 0]
            if not len(i) or crossing == MOST_CROSSINGS:
                self.rays.end[i] = End.UNFINISHED
                return
            if crossing == len(self.met):
                self.met.append(np.full(len(self.rays.end), -1, np.int32))
            self.met[crossing][i] = met
            numbers = [w for w in range(len(self.windows)) if (met == w).any()]
            leaving = [self.cross(i[met == w], w, distance[met == w], self.met[crossing]) for w in numbers]
            i, last = np.concatenate(leaving), np.repeat(numbers, [*map(len, leaving)])

    def cross(self, i: Indices, w: int, distance: Floats, met: NDArray[np.int32]) -> Indices:
        """Take rays to a window at this distance, and through it. Return those that leave it."""
        window = self.windows[w]
        position, direction = window.pose.own(taken(self.rays.position, i), taken(self.rays.direction, i))
        position += distance[:, None] * direction
        outside = distance > 0
        beside = outside & (abs(position[:, 2]) < (1 - 1e-9) * window.frame / 2)
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
            framed = window.outline.excludes(*(position + way[:, None] * direction)[:, :2].T)
            ends[(ends == End.THROUGH) & framed] = End.FRAME
        position, direction = window.pose.scene(position, direction)
        if self.path and not self.sheets[w] and not np.all(window.sheet.transfer == np.eye(5)):
            kind = np.full(len(passed), ray_path.IDEAL)
            self.events.append(Event(i[passed], taken(position, passed), np.ones(len(passed)), kind))
        if self.bent is not None and not self.sheets[w]:
            self.bent.append((i[passed], taken(position, passed), taken(direction, passed), w))
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
        after = trace(position[some], direction[some], sheets, window.outline, most, window.frame, self.partial, steps)
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
                self.events.append(Event(j[n], places, steps.behind[n, step], after.faces[n, step].astype(int)))


def taken(vectors: Floats, i: Indices) -> Floats:
    """Return some of the vectors (n, 3). In memory, their x come first: numpy takes a quarter of the time."""
    return vectors.T.take(i, 1).T


def nearest(windows: Sequence[Opening], position: Floats, direction: Floats, last: Indices) -> tuple[Indices, Floats]:
    """Return the window that each ray (n, 3) meets first, or -1, and how far away it is, or infinity.

    `last` (n,) is the window that each ray has just left, or -1. A straight ray does not meet it again.
    """
    met, distance = np.full(len(last), -1), np.full(len(last), np.inf)
    for w, window in enumerate(windows):
        some = np.flatnonzero(last != w)
        own = window.pose.own(taken(position, some), taken(direction, some))
        begins, ends = window.outline.passage(*own, window.frame)
        closer = (begins <= ends) & (ends >= 0) & (begins < distance[some])
        met[some[closer]], distance[some[closer]] = w, begins[closer]
    return met, np.maximum(distance, 0)


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
        enough = _PRECISION * (size if off_by is miss else np.ones(len(left)))
        slope, off = nearest_rays(np.broadcast_to(start, behind.shape)[left].astype(complex), left, off_by, enough)
        # the sines of very large slopes are all alike
        hit = (off <= enough) & (abs(miss(slope, left)) <= 1e-6 * size)
        found[left[hit]], left = slope[hit], left[~hit]
    return found


def _sine(slope: Complexes) -> Complexes:
    """Return the part of a unit direction across z. At grazing directions it changes little, and the slope much."""
    return np.asarray(slope / np.hypot(1, abs(slope)))


def _rms(steps: Complexes) -> float:
    return float(np.sqrt(np.mean(abs(steps) ** 2)))
