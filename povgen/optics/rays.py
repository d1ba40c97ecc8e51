"""Bundles of rays: straight lines before and behind the windows, the spot they make, and where they converge.

The coordinates are the scenes': x right, y up, z away from the eye, and z = 0 in the middle of the first window. All
lengths are in one unit, in scenes the tile. There are no angles: a direction is a vector (dx, dy, dz).

Rays with dz > 0 run away from the eye, as a camera's do. Rays with dz < 0 run with the light, towards the eye. Both
take the same paths: `window_trace`.
"""

from __future__ import annotations  # help() then says ArrayLike

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from numbers import Complex, Real
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics import ray_path
from povgen.optics.equations import Complexes, real
from povgen.optics.faces import Booleans, Floats, Indices
from povgen.optics.opening import Opening
from povgen.optics.trace import CHUNK, End, Rays
from povgen.optics.values import Values

LARGEST = 1e4  # coordinate of a point, tiles: more is perhaps in another unit
MOST = 10**8  # rays of a spot: their points need 2 GB
AT_ONCE = 4 * 10**7  # rays of a bundle: they need 2 GB
# the greatest error of the transverse part of a traced ray's unit direction: that of light that comes from behind
PRECISION = 1e-11


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

    The graphics library (`Scene.trace(..., device="gl")`) does not say the faces: `faces` is then empty. Its positions
    and directions have the precision of numbers of 32 bits.

    If the paths were kept, `corners`, `media`, `glass` and `met` are their points: `ray_path`. Otherwise they
    are empty.
    """

    windows: NDArray[np.int32]
    corners: Floats
    media: Floats
    glass: Floats
    met: Indices

    @property
    def length(self) -> Floats:
        """The optical path length of each ray (...), tiles, from its start to its end: `ray_path.length`."""
        return ray_path.length(*self._path[:2], self.met)

    @property
    def jones(self) -> Complexes:
        """What the faces do to the field of each ray's light, (..., 2, 2): `ray_path.jones`; 0 for absorbed light."""
        passes = (self.end != End.ABSORBED)[..., None, None]
        return np.where(passes, ray_path.jones(*self._path), 0)

    def table(self) -> dict[str, NDArray[Any]]:
        """Return a table of all corners of the paths: `ray_path.table`."""
        return ray_path.table(*self._path[:2], self.met)

    @property
    def _path(self) -> tuple[Floats, Floats, Floats, Indices]:
        if not self.corners.shape[-2]:
            raise ValueError("the paths were not kept; allowed: rays of trace(..., path=True)")
        return self.corners, self.media, self.glass, self.met

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

    _precision = PRECISION


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


def _rms(steps: Complexes) -> float:
    return float(np.sqrt(np.mean(abs(steps) ** 2)))
