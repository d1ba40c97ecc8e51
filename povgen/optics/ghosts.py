"""The ghosts of lenses: images formed by light that leaves the glass through a lens not opposite the one it enters.

Points, slopes and lengths are as in `apparent`. Matrices are as in `paraxial`. `order` and `middle` are as for
`paraxial.small_angles`.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import product
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from povgen.optics.faces import Sheet
from povgen.optics.paraxial import free, layer, over_a_period, solved, transfer
from povgen.optics.profile import Profile

_SLOPES = np.linspace(-0.6, 0.6, 31)  # across the ridges: `_usual_slope` chooses one of these for a `Ghost`
_ROUNDS = 3  # iterations: a ghost's matrix depends on its slopes, and the slopes on the matrix


@lru_cache(10_000)
def shares(profile: Profile, slope: float) -> Mapping[int, float]:
    """Return the fractions of light that take the designed path (order 0) and the paths of ghosts (other orders).

    The keys are the orders, as for `small_angles`. Orders without light are left out. The light fills a period. Before
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

    # for each sheet: how many cells farther across its ridges a ray from the eye leaves the glass than it enters it
    orders: tuple[int, ...]
    position: complex  # where the eye sees the point, in the plane of the window
    # the fraction of light that takes this path: the product of the sheets' `shares`. If the arrays of a sheet differ
    # in pitch, it holds near the middle of the window
    share: float


def ghosts(L: complex, E: complex, z1: float, z2: float, sheets: Sequence[Sheet], most: int = 1) -> list[Ghost]:
    """Return the ghosts of a point L behind one window with these sheets, the brightest first.

    L and the eye E are x + iy. z1 and z2 are the distances of L and of E from the plane z = 0 of the sheets. The order
    of each sheet is from -most to most. The list is empty if a sheet consists of prisms.
    """
    found: list[Ghost] = []
    profiles = [sheet.shape.scaled(1.0) for sheet in sheets if isinstance(sheet.shape, Profile)]
    if len(profiles) < len(sheets):
        return found
    for orders in product(range(-most, most + 1), repeat=len(sheets)):
        if not any(orders):
            continue
        middles = [_usual_slope(*each) for each in zip(profiles, orders, strict=True)]
        s, share = complex(np.nan), 0.0
        for _ in range(_ROUNDS):
            total = transfer(sheets, orders, middles) @ free(z2)
            if not np.isfinite(total).all():  # no light takes this path
                s = complex(np.nan)
                break
            x, y, sx, sy, _ = total @ (E.real, E.imag, 0, 0, 1)
            to = np.array(L - (x + 1j * y) - z1 * (sx + 1j * sy))
            s = complex(solved(total[:2, 2:4], z1 * total[2:4, 2:4], to))
            if not np.isfinite(s):
                break
            share, ray = 1.0, np.array([0, 0, s.real, s.imag, 1])
            for k, sheet in enumerate(sheets):
                across = float(-np.sin(sheet.angle) * ray[2] + np.cos(sheet.angle) * ray[3])
                share *= shares(profiles[k], round(across, 2)).get(orders[k], 0.0)
                ray, middles[k] = layer(sheet, orders[k], middles[k]) @ ray, across
        if np.isfinite(s) and share > 0:
            found.append(Ghost(orders, E + z2 * s, share))
    return sorted(found, key=lambda ghost: -ghost.share)


@lru_cache(100)
def _usual_slope(profile: Profile, order: int) -> float:
    """Return the slope across the ridges at which the greatest share of light takes the path with this order."""
    return float(max(_SLOPES, key=lambda slope: shares(profile, round(float(slope), 2)).get(order, 0.0)))
