"""What sheets of prisms and lenses do to light at small angles.

Points are complex numbers x + iy, and a ray's slope is (dx + i dy)/dz, as in `apparent`. All lengths have the same
unit. A ray-transfer matrix maps (X, Y, sx, sy, 1), a ray's place and slope before a sheet, to its place and slope
behind the sheet.

Prisms of finite size have a matrix for small angles. The ridges are the long edges of the prisms. Across them a sheet
reverses the slope of light. The place of this reversal is the sheet's middle plane. Along the ridges the sheet acts as
a slab of glass: it shifts light sideways by -g times the component of the slope along the ridges (`Prism.slab_shift`).
Other shifts depend on the point at which a ray enters a prism, and are zero on average. docs/sheets.md has the
derivation.

Other sheets, such as arrays of lenses, have a `Profile`, their cross-section. Its matrix is fitted to rays on its
designed path: `small_angles`.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.equations import Complexes, Floats
from povgen.optics.faces import Booleans, GlassSheet
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile
from povgen.optics.trace import Rays, on_path, trace

Matrix = NDArray[np.float64]  # (..., 5, 5)
# The matrix of a profile is fitted to rays. Their slopes across the ridges are FAN_SIDE values from -FAN to FAN. For
# each of these slopes, there are rays at FAN_SIDE places of a period.
FAN, FAN_SIDE = 0.1, 41
_WIDTH = 61.0  # periods, odd: the width of the sheet through which rays that enter the middle period are traced


def free(distance: ArrayLike) -> Matrix:
    """Return the matrix (..., 5, 5) of free propagation over distances (...)."""
    total = np.broadcast_to(np.eye(5), (*np.shape(distance), 5, 5)).copy()
    total[..., 0, 2] = total[..., 1, 3] = distance
    return total


class SmallAngles(NamedTuple):
    """What a sheet does at small angles to light on its designed path, on average over a period.

    The place of a ray before and behind the sheet is where it, continued straight, crosses the sheet's middle plane.
    """

    # s and t are the components of a ray's slope along and across the ridges. Along the ridges, light is displaced by
    # -slab_shift*s. Across the ridges, it is displaced by shift*t + offset, and its slope becomes factor*t + deviation.
    slab_shift: float
    shift: float = 0.0
    offset: float = 0.0
    factor: float = -1.0
    deviation: float = 0.0
    reach: float = 0.0  # the greatest difference of a ray's displacement from shift*t + offset
    blur: float = 0.0  # the RMS difference of a ray's slope from factor*t + deviation
    bend: float = 0.0  # growth of deviation per distance from the sheet's middle, if its two faces differ in pitch

    def scaled(self, pitch: float) -> "SmallAngles":
        """Return the same for a sheet that is larger by the factor `pitch`."""
        lengths = ("slab_shift", "shift", "offset", "reach")
        return self._replace(**{name: pitch * getattr(self, name) for name in lengths}, bend=self.bend / pitch)


def small_angles(shape: Prism | Profile) -> SmallAngles:
    """Return what a sheet of this shape does to light on its designed path.

    For a profile, rays whose slopes across the ridges are at most FAN are traced, and straight lines are fitted to
    their slopes and places behind the sheet. So the fit includes the spherical aberration of these rays. If no ray
    takes the designed path, all numbers but `bend` are NaN.
    """
    if isinstance(shape, Prism):
        return SmallAngles(shape.slab_shift, reach=shape.reach)
    found = _fitted(shape.scaled(1.0))
    if shape.is_mismatched:
        left, right = (_fitted(shape.scaled(1.0), cell).deviation for cell in (-2, 2))
        found = found._replace(bend=(right - left) / 4)
    return found.scaled(shape.pitch)


def mean_slope(shape: Prism | Profile, slope: complex, place: float) -> tuple[complex, float]:
    """Return the mean slope of light behind a sheet, and the RMS difference of its slopes from their mean.

    `slope` is the slope of the light before the sheet, along the ridges + i across, and so is the result. The light
    fills a period. `place` is where it meets the sheet's middle plane: across the ridges, from the window's middle.
    Only rays on the designed path count. The results are NaN if there are none. Prisms reverse the slope exactly.
    """
    if isinstance(shape, Prism):
        return slope.conjugate(), 0.0
    if not np.isfinite(slope):
        return complex(np.nan, np.nan), np.nan
    # periods are alike unless the two faces of the sheet differ in pitch
    rays, taken = over_a_period(shape, slope, FAN_SIDE, round(place / shape.pitch) if shape.is_mismatched else 0)
    taken &= rays.orders[:, 0] == 0
    if not taken.any():
        return complex(np.nan, np.nan), np.nan
    x, y, z = rays.direction[taken].T
    slopes = (x + 1j * y) / z
    return complex(slopes.mean()), float(slopes.std())


def layer(sheet: GlassSheet) -> Matrix:
    """Return the matrix of a sheet in paraxial approximation. Prisms mirror the slope about the ridges.

    The places before and behind the sheet are those of `SmallAngles`, in its middle plane.
    """
    does = small_angles(sheet.shape)
    ridges, g = np.exp(2j * np.asarray(sheet.angle)), does.slab_shift
    across = 1j * np.exp(1j * np.asarray(sheet.angle))  # the unit vector
    found = np.broadcast_to(np.eye(5), (*ridges.shape, 5, 5)).copy()
    found[..., :2, 2:4] = _real((does.shift - g) / 2, -(does.shift + g) / 2 * ridges)
    found[..., 2:4, :2] = _real(does.bend / 2, -does.bend / 2 * ridges)
    found[..., 2:4, 2:4] = _real((1 + does.factor) / 2, (1 - does.factor) / 2 * ridges)
    for row, part in enumerate((does.offset * across, does.deviation * across)):
        found[..., 2 * row, 4], found[..., 2 * row + 1, 4] = part.real, part.imag
    if any(sheet.tilt):  # slopes are measured from the sheet's normal
        normal = sheet.axes[2]
        from_normal = np.eye(5)
        from_normal[2:4, 4] = -normal[:2] / normal[2]
        found = np.linalg.inv(from_normal) @ found @ from_normal
    return found


def transfer(sheets: Sequence[GlassSheet]) -> Matrix:
    """Return the matrix of sheets, the nearest to the eye first.

    It maps the ray before them to the ray behind them. The place of each of these rays is where it, continued straight,
    crosses the plane z = 0.
    """
    total, z = np.eye(5), 0.0
    for sheet in sheets:
        total, z = layer(sheet) @ free(sheet.centre - z) @ total, sheet.centre
    return free(-z) @ total


@lru_cache(1000)
def _fitted(profile: Profile, cell: int = 0) -> SmallAngles:
    """Return the result of `small_angles` for one cell of a profile with the pitch 1. Cell 0 is in the middle."""
    # across the ridges many slopes, and along them one; at each slope, rays at many places within a period
    slope = np.repeat(np.linspace(-FAN, FAN, FAN_SIDE), FAN_SIDE)
    place, along = np.tile(_places(FAN_SIDE) + cell, FAN_SIDE), FAN / 4
    rays, taken = _traced(profile, place, along + 1j * slope)
    taken &= rays.orders[:, 0] == 0
    if taken.sum() < 2 or np.ptp(slope[taken]) == 0:
        return SmallAngles(*[np.nan] * 7)
    behind = rays.direction[taken] / rays.direction[taken, 2:]
    place_behind = rays.position[taken] - rays.position[taken, 2:] * behind
    basis = np.column_stack((slope[taken], np.ones(taken.sum())))
    (factor, deviation), *_ = np.linalg.lstsq(basis, behind[:, 1], rcond=None)
    moved = place_behind[:, 1] - place[taken]
    (shift, offset), *_ = np.linalg.lstsq(basis, moved, rcond=None)
    slab = -(place_behind[:, 0] / along).mean()
    reach = abs(moved - basis @ (shift, offset)).max()
    blur = np.sqrt(np.mean((behind[:, 1] - basis @ (factor, deviation)) ** 2))
    return SmallAngles(*map(float, (slab, shift, offset, factor, deviation, reach, blur)))


def over_a_period(profile: Profile, slope: complex, count: int, cell: int = 0) -> tuple[Rays, Booleans]:
    """Trace `count` parallel rays that fill a period of a profile. Return them, and whether each takes its path.

    A ray takes the path if it meets the edges `profile.path`, in this order, and no others. The edges may be in several
    cells. `slope` is the rays' slope, along the ridges + i across. `cell` is the number of the period. It is 0 in the
    middle of the window. The positions of the result are in periods.
    """
    return _traced(profile.scaled(1.0), _places(count) + cell, np.full(count, slope))


def _places(count: int) -> Floats:
    """Return evenly spaced places in a period whose middle is 0."""
    return (np.arange(count) + 0.5) / count - 0.5


def _traced(profile: Profile, place: Floats, slope: Complexes) -> tuple[Rays, Booleans]:
    """Trace rays, as `over_a_period` does, through a sheet of a profile with the pitch 1.

    `place` is across the ridges, in the middle plane.
    """
    z = np.full(place.shape, -profile.half)
    origin = np.column_stack((z * slope.real, place + z * slope.imag, z))
    direction = np.column_stack((slope.real, slope.imag, np.ones(place.shape)))
    width = _WIDTH + 2 * round(abs(place).max())
    rays = trace(origin, direction, (GlassSheet(0.0, 0.0, profile),), width, len(profile.path) + 1)
    return rays, on_path(rays, [profile])


def _real(a: ArrayLike, b: ArrayLike) -> Matrix:
    """Return the real matrices (..., 2, 2) of the maps a s + b conj(s)."""
    a, b = np.broadcast_arrays(np.asarray(a, complex), np.asarray(b, complex))
    rows = np.array([[a.real + b.real, b.imag - a.imag], [a.imag + b.imag, a.real - b.real]])
    return np.moveaxis(rows, (0, 1), (-2, -1))


def solved(first: Floats, second: Floats, to: Complexes) -> Complexes:
    """Return the slopes s (...) with (first + second) s = `to` (...), for maps (..., 2, 2).

    A map of rank 1 gives infinity for a `to` outside its range, and otherwise the solution with the least |s|. A map
    that is 0 gives NaN for `to` = 0, and otherwise infinity. The two parts of the map are given separately, because
    their sizes tell which entries of the sum are only rounding errors. These count as 0.
    """
    size = (abs(first) + abs(second)).max((-2, -1), keepdims=True)
    maps = np.where(abs(first + second) <= 1e-14 * size, 0, first + second)
    maps, right = np.broadcast_to(maps, (*to.shape, 2, 2)), np.stack((to.real, to.imag), -1)[..., None]
    (a, b), (c, d) = np.moveaxis(maps, (-2, -1), (0, 1))
    determinant = a * d - b * c
    singular = abs(determinant) <= 1e-14 * (abs(a * d) + abs(b * c))
    known = np.isfinite(determinant)
    safe = np.where((singular | ~known)[..., None, None], np.eye(2), maps)
    slopes = np.linalg.solve(safe, np.nan_to_num(right))[..., 0]
    s = np.where(np.isnan(to) | ~known, np.nan, slopes[..., 0] + 1j * slopes[..., 1])
    if singular.any():
        inverse = np.linalg.pinv(maps[singular], rcond=1e-9)
        least = (inverse @ right[singular])[..., 0]
        off = np.linalg.norm((maps[singular] @ least[..., None] - right[singular])[..., 0], axis=-1)
        one_point = ~maps[singular].any((-2, -1)) & (abs(to[singular]) == 0)
        reached = np.where(one_point, np.nan, least[..., 0] + 1j * least[..., 1])
        there = np.linalg.norm(right[singular][..., 0], axis=-1)
        s[singular] = np.where(off <= 1e-13 * there, reached, complex(np.inf, 0))
    return s
