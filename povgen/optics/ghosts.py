"""The ghosts of lenses: images formed by light that leaves the glass through a lens not opposite the one it enters.

The *order* of light in a sheet is how many cells farther across the ridges it leaves the glass than it enters it.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from povgen.optics.equations import Complexes
from povgen.optics.faces import GlassSheet
from povgen.optics.paraxial import over_a_period
from povgen.optics.profile import Profile
from povgen.optics.trace import on_path, trace

_SIDE = 120  # side^2 rays from the eye to the whole window show which ghosts there are, and where
_NEAREST = 200  # the most rays to which the position of a ghost is fitted: those that end nearest to the point
_PATCH = 4  # pitches: the side of the square in which the share of a ghost is measured


@lru_cache(10_000)
def shares(profile: Profile, slope: float) -> Mapping[int, float]:
    """Return the fractions of light that take the designed path (order 0) and the paths of ghosts (other orders).

    The keys are the orders. Orders without light are left out. The light fills a period. Before
    the sheet it has the given slope across the ridges, and none along them. Light on other paths is not counted.
    """
    count = 200
    rays, taken = over_a_period(profile, 1j * slope, count)
    orders, counts = np.unique(rays.orders[taken, 0], return_counts=True)
    found = zip(orders.tolist(), counts.tolist(), strict=True)
    return MappingProxyType({order: number / count for order, number in found})


def field(profile: Profile) -> float:
    """Return the slope at which a ghost begins to take more light than the designed path.

    The slope is that across the ridges before the sheet. Multiples of 0.002 are tried, from 0 to 0.998. The result is
    0.998 if no ghost takes more light. For confocal lenses of equal focal lengths f in glass it is about n p/(4 f),
    with the pitch p and the index n, if f is 3 p or more.
    """
    for slope in np.arange(0, 1, 0.002):
        found = shares(profile.scaled(1.0), float(slope))
        if found and max(found.values()) > found.get(0, 0.0):
            break
    return float(slope)


class Ghost(NamedTuple):
    """An image of a point, formed by light that leaves the glass through a lens not opposite the one it enters."""

    orders: tuple[int, ...]  # in each sheet, of a ray from the eye
    position: complex  # where the eye sees the point, in the plane of the window
    share: float  # of the rays from the eye to a square of _PATCH pitches at the position: how many take this path


def ghosts(
    L: complex, E: complex, z1: float, z2: float, sheets: Sequence[GlassSheet], window: float, least: float
) -> list[Ghost]:
    """Return the ghosts of a point L behind one window with these sheets, the brightest first.

    L and the eye E are x + iy. z1 and z2 are the distances of L and of E from the plane z = 0 of the sheets, and
    `window` is the window's side. Ghosts with a share below `least` are left out. The list is empty if a sheet consists
    of prisms. Rays are traced from the eye to the whole window. For each combination of orders, a linear function of
    their places in L's plane is fitted to their places in the window. Its value at L is the ghost's position.
    """
    found: list[Ghost] = []
    shapes = [sheet.shape for sheet in sheets if isinstance(sheet.shape, Profile)]
    if len(shapes) < len(sheets):
        return found

    def behind(P: Complexes) -> tuple[NDArray[np.int64], Complexes]:
        """Return the orders (rays, sheets) of rays from the eye to P (rays), and where they cross the plane of L.

        Rays on other paths than those of ghosts and of designed light have the orders 0.
        """
        direction = np.column_stack((P.real - E.real, P.imag - E.imag, np.full(len(P), z2)))
        rays = trace([[E.real, E.imag, -z2]], direction, tuple(sheets), window, sum(len(p.path) for p in shapes) + 1)
        x, y, _ = (rays.position + rays.direction * ((z1 - rays.position[:, 2:]) / rays.direction[:, 2:])).T
        return np.where(on_path(rays, shapes)[:, None], rays.orders, 0), x + 1j * y

    cells = np.indices((_SIDE, _SIDE)).reshape(2, -1).T + np.random.default_rng(1).uniform(size=(_SIDE**2, 2))
    square = (cells / _SIDE - 0.5) @ np.array([1, 1j])
    pitch = max(shape.pitch for shape in shapes)
    P, patch = window * square, _PATCH * pitch * square[::10]
    taken, place = behind(P)
    for orders, count in zip(*np.unique(taken, axis=0, return_counts=True), strict=True):
        if not orders.any() or count < 4:
            continue
        mine = np.flatnonzero((taken == orders).all(1))
        off = place[mine] - L
        nearest = np.argsort(abs(off))[:_NEAREST]
        if abs(off[nearest[0]]) > window / 10:  # this light does not come from near L
            continue
        basis = np.column_stack((np.ones(len(nearest)), off[nearest].real, off[nearest].imag))
        position = complex(np.linalg.lstsq(basis, P[mine[nearest]], rcond=None)[0][0])
        here, ends = behind(position + patch)
        same = (here == orders).all(1)
        if abs(ends[same] - L).min(initial=np.inf) < pitch and same.mean() >= least:
            found.append(Ghost(tuple(orders.tolist()), position, float(same.mean())))
    return sorted(found, key=lambda ghost: -ghost.share)
