"""Where the eye sees a point through any list of windows, on numpy arrays.

Points are complex numbers x + iy: x points right and y up, as the eye sees them. z points away from the eye. Lengths
are in any one unit. A ray from the eye E has the slope s = (dx + i dy)/dz. It crosses the first window, a distance
z2 from the eye, at P = E + z2 s. A point L behind the last window appears at P if the ray meets L.

A window whose effect on place and slope is linear has a ray-transfer matrix. It maps (X, Y, sx, sy, 1), a ray's place
and slope before the window, to the same behind it. The windows' matrices and those of the distances between them are
multiplied. For other windows only `Element.slope` is known: the slope behind the window, for each ray. Newton's method,
from many starts, then finds the ray to L.

Prisms of finite size have a matrix for small angles. Across the ridges (the prisms' long edges) a sheet reverses the
slope of light, as if in the sheet's middle plane. Along the ridges it acts as a slab of glass: it shifts light sideways
by -g times the component of the slope along the ridges (`Prism.slab_shift`). Other shifts depend on the point at which
a ray enters a prism, and are zero on average. docs/sheets.md has the derivation.

The matrix of another profile, such as an array of lenses, is fitted to rays on its designed path: `small_angles`.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import product
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.equations import Complexes, Floats
from povgen.optics.faces import Booleans, Sheet
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile
from povgen.optics.trace import End, Rays, trace

Matrix = NDArray[np.float64]  # (..., 5, 5)
Indices = NDArray[np.intp]
# The search starts from rays whose projections onto the planes x-z and y-z have these angles to the normal.
_ANGLES = np.radians(np.linspace(-84, 84, 25))
_STEPS = 60  # of Newton's method
# The matrix of a profile is fitted to rays. Their slopes across the ridges are FAN_SIDE values that differ by at most
# FAN from a middle one. For each of these slopes, there are rays at FAN_SIDE places of a period.
FAN, FAN_SIDE = 0.1, 41
_SLOPES = np.linspace(-0.6, 0.6, 31)  # across the ridges: `_usual_slope` chooses one of these for a `Ghost`
_WIDTH = 61.0  # of the sheet through which rays are traced, periods; odd, so that a cell is in the middle
_ROUNDS = 3  # a ghost's matrix depends on its slopes, and these on the matrix: so many iterations
_PRECISION = 1e-11  # a path is found if it misses L by at most this, relative to the distances


class Element(Protocol):
    """What a window does to a ray from the eye."""

    @property
    def aperture(self) -> float:
        """The side of the square window."""

    @property
    def transfer(self) -> Matrix | None:
        """The ray-transfer matrix, or None if there is none."""

    def layers_at(self, z: float, window: int) -> tuple[Sheet, ...]:
        """Return the sheets of prisms or lenses of window number `window`, which stands at z, the near one first."""

    def slope(self, slope: ArrayLike, place: ArrayLike) -> Complexes:
        """Return the slope behind a window without thickness, NaN if no light passes. Arguments are x + iy."""


# The nearest to the eye comes first. Each has its distance from the window before it; the first, from the eye.
Windows = Sequence[tuple[float, Element]]


def free(distance: float) -> Matrix:
    """Return the matrix of free propagation over a distance."""
    total = np.eye(5)
    total[[0, 1], [2, 3]] = distance
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
    bend: float = 0.0  # for arrays of different pitch: deviation grows by bend times the distance from the middle

    def scaled(self, pitch: float) -> "SmallAngles":
        """Return the same for a sheet that is larger by the factor `pitch`."""
        lengths = ("slab_shift", "shift", "offset", "reach")
        return self._replace(**{name: pitch * getattr(self, name) for name in lengths}, bend=self.bend / pitch)


def small_angles(shape: Prism | Profile, order: int = 0, middle: float = 0.0) -> SmallAngles:
    """Return what a sheet of this shape does to light on its designed path.

    For a profile, rays whose slopes across the ridges are within FAN of `middle` are traced, and straight lines are
    fitted to their slopes and places behind the sheet. So the result contains the spherical aberration of these rays.
    With an `order` other than 0, the result is for a *ghost*: for rays that leave the glass `order` cells above the
    cell in which they enter it. It is NaN if there are no such rays.
    """
    if isinstance(shape, Prism):
        return SmallAngles(shape.slab_shift, reach=shape.reach) if not order else SmallAngles(*[np.nan] * 7)
    found = _fitted(shape.scaled(1.0), order, round(middle, 2))
    if shape.is_mismatched:
        beside = _fitted(shape.scaled(1.0), order, round(middle, 2), 1)
        found = found._replace(bend=beside.deviation - found.deviation)
    return found.scaled(shape.pitch)


def slope_error(shape: Prism | Profile, slope: complex) -> float:
    """Return the RMS difference between the slopes of light behind a sheet and the slope by `small_angles`.

    `slope` is the slope of the light before the sheet, along the ridges + i across. The light fills a period, and
    takes the designed path. NaN if none takes it; 0 for prisms.
    """
    if isinstance(shape, Prism):
        return 0.0
    does = small_angles(shape)
    rays, taken = _traced(shape.scaled(1.0), _places(FAN_SIDE), np.full(FAN_SIDE, slope))
    taken &= rays.orders[:, 0] == 0
    if not taken.any():
        return np.nan
    x, y, z = rays.direction[taken].T
    expected = slope.real + 1j * (does.factor * slope.imag + does.deviation)
    return float(np.sqrt(np.mean(abs((x + 1j * y) / z - expected) ** 2)))


@lru_cache(10_000)
def shares(profile: Profile, slope: float) -> dict[int, float]:
    """Return the fractions of light that take the designed path (order 0) and the paths of ghosts (other orders).

    The keys are the orders, as for `small_angles`. The light fills a period. It has this slope across the ridges, and
    none along them. Light on other paths is left out.
    """
    count = 200
    rays, taken = _traced(profile.scaled(1.0), _places(count), np.full(count, 1j * slope))
    orders, counts = np.unique(rays.orders[taken, 0], return_counts=True)
    return {int(order): number / count for order, number in zip(orders, counts, strict=True)}


def field(profile: Profile) -> float:
    """Return the slope up to which more light takes the designed path than the path of any ghost.

    For confocal lenses of equal focal lengths f in glass it is about n p/(4 f), with the pitch p.
    """
    for slope in np.arange(0, 1, 0.002):
        found = shares(profile.scaled(1.0), float(slope))
        if found and max(found.values()) > found.get(0, 0.0):
            break
    return float(slope)


class Ghost(NamedTuple):
    """An image of a point, formed by light that leaves the glass through a lens not opposite the one it enters."""

    # for each sheet: by how many cells a ray from the eye leaves the glass above the cell where it enters
    orders: tuple[int, ...]
    position: complex  # where the eye sees the point, in the plane of the window
    share: float  # the fraction of light that takes this path: the product of the sheets' `shares`


def ghosts(L: complex, E: complex, z1: float, z2: float, sheets: Sequence[Sheet], most: int = 1) -> list[Ghost]:
    """Return the ghosts of a point behind one window with these sheets, the brightest first.

    L, E and the distances z1 and z2 are as for `position`. The orders are from -most to most. Sheets of prisms have no
    ghosts.
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
            s = complex(_solved(total[:2, 2:4], z1 * total[2:4, 2:4], to))
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


def layer(sheet: Sheet, order: int = 0, middle: float = 0.0) -> Matrix:
    """Return the matrix of a sheet in paraxial approximation. Prisms mirror the slope about the ridges.

    `order` and `middle` are those of `small_angles`: they select a ghost of lenses.
    """
    does = small_angles(sheet.shape, order, middle)
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


def transfer(sheets: Iterable[Sheet], orders: Sequence[int] = (0, 0), middles: Sequence[float] = (0.0, 0.0)) -> Matrix:
    """Return the matrix of sheets, the nearest to the eye first.

    It maps the ray before them to the ray behind them. The place of each of these rays is where it, continued straight,
    crosses the plane z = 0. `orders` and `middles` have, for each sheet, the `order` and `middle` of
    `small_angles`: they select a ghost of lenses.
    """
    total, z = np.eye(5), 0.0
    for sheet, order, middle in zip(sheets, orders, middles, strict=False):
        total, z = layer(sheet, order, middle) @ free(sheet.centre - z) @ total, sheet.centre
    return free(-z) @ total


@lru_cache(1000)
def _fitted(profile: Profile, order: int, middle: float, cell: int = 0) -> SmallAngles:
    """Return the result of `small_angles` for one cell of a profile with the pitch 1. Cell 0 is in the middle."""
    # across the ridges many slopes, and along them one; at each slope, rays at many places within a period
    slope = np.repeat(np.linspace(middle - FAN, middle + FAN, FAN_SIDE), FAN_SIDE)
    place, along = np.tile(_places(FAN_SIDE) + cell, FAN_SIDE), FAN / 4
    rays, taken = _traced(profile, place, along + 1j * slope)
    taken &= rays.orders[:, 0] == order
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


def _places(count: int) -> Floats:
    """Return evenly spaced places in a period whose middle is 0."""
    return (np.arange(count) + 0.5) / count - 0.5


def _traced(profile: Profile, place: Floats, slope: Complexes) -> tuple[Rays, Booleans]:
    """Trace rays through a sheet of a profile with the pitch 1. Return them, and whether each takes the profile's path.

    On this path, a ray meets the edges `profile.path` in this order, and no others, in the same cell or in several.
    `place` is across the ridges, in the middle plane. Slopes are along the ridges + i across.
    """
    z = np.full(place.shape, -profile.half)
    origin = np.column_stack((z * slope.real, place + z * slope.imag, z))
    direction = np.column_stack((slope.real, slope.imag, np.ones(place.shape)))
    steps = len(profile.path)
    rays = trace(origin, direction, (Sheet(0.0, 0.0, profile),), _WIDTH, steps + 1)
    taken = (rays.end == End.THROUGH) & (rays.count == steps) & (rays.faces[:, :steps] == profile.path).all(1)
    return rays, taken


def matrix(windows: Windows) -> Matrix | None:
    """Return the matrix from the eye to behind the last window, or None if a window has none."""
    total = np.eye(5)
    for distance, window in windows:
        if window.transfer is None:
            return None
        total = window.transfer @ free(distance) @ total
    return total


def follow(slope: ArrayLike, E: ArrayLike, windows: Windows) -> list[tuple[Complexes, Complexes, Complexes, Complexes]]:
    """Follow rays from the eye with this slope. Return place and slope before and behind each window."""
    s, P = np.asarray(slope, complex), np.asarray(E, complex)
    found = []
    for distance, window in windows:
        P = P + distance * s
        before = P, s
        if window.transfer is not None:
            ray = np.stack(np.broadcast_arrays(P.real, P.imag, s.real, s.imag, 1.0))
            X, Y, sx, sy, _ = np.moveaxis(np.einsum("...ij,j...->...i", window.transfer, ray), -1, 0)
            P, s = X + 1j * Y, sx + 1j * sy
        else:
            s = window.slope(s, P)
        found.append((*before, P, s))
    return found


def position(L: ArrayLike, E: complex, z1: ArrayLike, windows: Windows, near: ArrayLike = 0) -> Complexes:
    """Return where in the plane of the first window the eye sees a point L, a distance z1 behind the last window.

    L is complex. L, z1 and `near` broadcast. Light can reach the eye on several paths. The result is the position with
    the least max(|x|, |y|). A square window round 0 that shows any of these positions shows this one. The result is NaN
    if there is no path, and infinite if L appears at infinity.

    At a caustic two paths merge. Beyond it, neither exists. There a large object can be seen in part, although its
    middle cannot. So a path counts too if it misses L by at most `near`, and by less than neighbouring paths do.
    """
    place, after, near = np.broadcast_arrays(np.asarray(L, complex), np.asarray(z1, float), np.asarray(near, float))
    distance, total = windows[0][0], matrix(windows)
    with np.errstate(all="ignore"):  # infinite and NaN results
        if total is None:
            s = _search(place.ravel(), E, after.ravel(), windows, near.ravel()).reshape(place.shape)
        else:
            x, y, sx, sy, _ = np.moveaxis(total @ (E.real, E.imag, 0, 0, 1), -1, 0)
            to = place - (x + 1j * y) - after * (sx + 1j * sy)
            s = _solved(total[..., :2, 2:4], after[..., None, None] * total[..., 2:4, 2:4], to)
        return (E + distance * s)[()]


def depths(z1: ArrayLike, windows: Windows) -> tuple[Complexes, Complexes]:
    """Return A and B: if the slope at the eye changes by a small step s, L moves by A s + B conj(s).

    For windows that rotate light, and an eye at E, L - E = A s + B conj(s) for every ray. Without thickness B = 0, and
    A is the complex depth Z of `equations.depth`. At |A| = |B| the light of a point meets the eye's plane in a line, or
    not at all. NaN if a window has no matrix.
    """
    z1, total = np.asarray(z1, float), matrix(windows)
    if total is None:
        return (nothing := np.full(z1.shape, np.nan)[()]), nothing
    near, far = total[..., :2, 2:4], z1[..., None, None] * total[..., 2:4, 2:4]
    size = (abs(near) + abs(far)).max((-2, -1), keepdims=True)
    (a, b), (c, d) = np.moveaxis(np.where(abs(near + far) <= 1e-14 * size, 0, near + far), (-2, -1), (0, 1))
    return ((a + d + 1j * (c - b)) / 2)[()], ((a - d + 1j * (c + b)) / 2)[()]


def nu_and_M(z1: ArrayLike, windows: Windows) -> tuple[Floats, Floats]:
    """Return the angle nu, radians, through which an object appears turned, and its magnification M.

    With A and B of `depths`, a short step d on the object appears as a d + b conj(d) in the plane of the first window:
    a = z2 conj(A)/(|A|^2 - |B|^2) and b = -z2 B/(|A|^2 - |B|^2). Then nu = arg(a). The magnification depends on the
    direction of d: it is between |a| - |b| and |a| + |b|, and M is the mean |a|. For sheets without thickness that
    rotate light, nu and M are eqs. 8 and 9, corrected (docs/errata.md). If |b| > |a|, the object appears mirrored:
    nu is NaN, and M is |b|. If |A| = |B|, nu is NaN and M is infinite.
    """
    A, B = depths(z1, windows)
    with np.errstate(divide="ignore", invalid="ignore"):
        M = windows[0][0] * np.maximum(abs(A), abs(B)) / abs(abs(A) ** 2 - abs(B) ** 2)
    M = np.where(abs(abs(A) - abs(B)) <= 1e-14 * (abs(A) + abs(B)), np.inf, M)
    return np.where(abs(A) > abs(B), -np.angle(A), np.nan)[()], M[()]


def infinite_z1(windows: Windows) -> Floats:
    """Return the distances z1 > 0 at which objects appear at infinity; none if a window has no matrix.

    z1 solves a quadratic equation, |A|^2 - |B|^2 = 0 with A and B of `depths`. Of complex solutions, the real part is a
    result: there |A|^2 - |B|^2 is closest to 0.
    """
    total = matrix(windows)
    if total is None:
        return np.empty(0)
    (a, b), (c, d) = total[:2, 2:4]
    (p, q), (r, t) = total[2:4, 2:4]
    roots = np.roots([p * t - q * r, a * t + d * p - b * r - c * q, a * d - b * c])
    return roots.real[roots.real > 0]


def infinite_alpha(z1: ArrayLike, z2: ArrayLike, shape: Prism | Profile) -> Complexes:
    """Return the alpha from 0 to pi, radians, at which two sheets that mirror show an object at infinity (|A| = |B|).

    It is complex if there is no real one. At -alpha, the object is at infinity too.
    """
    g, apart = small_angles(shape).slab_shift, shape.separation
    near, far = np.subtract(z2, (apart + g) / 2), np.subtract(z1, (apart + g) / 2)
    return np.emath.arccos(((apart - g) ** 2 - near**2 - far**2) / (2 * near * far))


def _real(a: ArrayLike, b: ArrayLike) -> Matrix:
    """Return the real matrices (..., 2, 2) of the maps a s + b conj(s)."""
    a, b = np.broadcast_arrays(np.asarray(a, complex), np.asarray(b, complex))
    rows = np.array([[a.real + b.real, b.imag - a.imag], [a.imag + b.imag, a.real - b.real]])
    return np.moveaxis(rows, (0, 1), (-2, -1))


def _solved(first: Floats, second: Floats, to: Complexes) -> Complexes:
    """Return the slopes s (...) with (first + second) s = `to` (...), for maps (..., 2, 2).

    A map of rank 1 gives infinity for a `to` outside its range. A map that is 0 gives NaN for `to` = 0, and otherwise
    infinity. Entries as small as rounding errors count as 0.
    """
    size = abs(first) + abs(second)
    maps = np.where(abs(first + second) <= 1e-14 * size.max((-2, -1), keepdims=True), 0, first + second)
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
        s[singular] = np.where(off <= 1e-13 * abs(to[singular]), reached, complex(np.inf, 0))
    return s


def _search(L: Complexes, E: complex, z1: Floats, windows: Windows, near: Floats) -> Complexes:
    """Return the slopes at the eye, (n,), of rays to L (n,): see `position`."""

    def miss(s: Complexes, target: Indices) -> Complexes:
        *_, P, behind = follow(s, E, windows)[-1]
        return P + z1[target] * behind - L[target]

    nets = [_net(_ANGLES, _ANGLES)]
    passing = np.isfinite(follow(nets[0], E, windows)[-1][-1])
    if passing.any() and not passing.all():  # a finer net where light passes
        rows, columns = (np.flatnonzero(passing.any(axis)) for axis in (1, 0))
        step = _ANGLES[1] - _ANGLES[0]
        nets.append(_net(*(np.linspace(_ANGLES[i[0]] - step, _ANGLES[i[-1]] + step, 25) for i in (columns, rows))))
    places = np.linspace(-0.55, 0.55, 25) * windows[0][1].aperture  # a net of rays through the first window
    nets.append((places + 1j * places[:, None] - E) / windows[0][0])
    starts, targets = [], []
    for net in nets:
        *_, P, behind = follow(net, E, windows)[-1]
        for s, target in _starts(net, P + z1[:, None, None] * behind - L[:, None, None]):
            starts.append(s)
            targets.append(target)
    s, target = np.concatenate(starts), np.concatenate(targets)
    enough = np.maximum(_PRECISION * (abs(L - E) + z1 + windows[0][0]), near)[target]
    s, off = newton(s, target, miss, enough)
    found = off <= enough
    far = np.maximum(abs((E + windows[0][0] * s).real), abs((E + windows[0][0] * s).imag))
    # of all found paths the nearest to the window's middle
    best = np.full(len(L), complex(np.nan, np.nan))
    order = np.argsort(np.where(found, far, np.inf))[::-1]
    order = order[found[order]]
    best[target[order]] = s[order]
    return best


def _net(x: Floats, y: Floats) -> Complexes:
    """Return slopes of rays. x and y are the angles of their projections, onto x-z and y-z, to the normal."""
    return np.tan(np.clip(x, -1.55, 1.55)) + 1j * np.tan(np.clip(y, -1.55, 1.55))[:, None]


def _starts(net: Complexes, image: Complexes) -> Iterator[tuple[Complexes, Indices]]:
    """Yield slopes from which to search, and the numbers of their targets.

    `image` (targets, rows, columns): the vectors, as complex numbers, by which the net's rays miss the targets.
    """
    # for targets in a triangle of three neighbouring rays, or a little outside: the slope, interpolated in the triangle
    for i, j in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
        a, b, c = (image[:, rows, columns] for rows, columns in ((i, i), (j, i), (i, j)))
        u, v = b - a, c - a
        size = _cross(u, v)
        p, q = _cross(v, a) / size, _cross(a, u) / size
        inside = np.nonzero((p > -0.3) & (q > -0.3) & (p + q < 1.3))
        s0, s1, s2 = (net[rows, columns][inside[1:]] for rows, columns in ((i, i), (j, i), (i, j)))
        yield s0 + p[inside] * (s1 - s0) + q[inside] * (s2 - s0), inside[0]
    # rays that pass the target more closely than their neighbours
    off = np.nan_to_num(abs(image), nan=np.inf)
    _, n, m = off.shape
    framed = np.pad(off, ((0, 0), (1, 1), (1, 1)), constant_values=np.inf)
    rows = np.minimum(np.minimum(framed[:, :n], framed[:, 1 : n + 1]), framed[:, 2:])
    least = np.minimum(np.minimum(rows[..., :m], rows[..., 1 : m + 1]), rows[..., 2:])  # of the ray and its neighbours
    lowest = np.nonzero(np.isfinite(off) & (off == least))
    yield net[lowest[1:]], lowest[0]


def _cross(a: Complexes, b: Complexes) -> Floats:
    """Return the cross products of vectors that complex numbers stand for."""
    return np.asarray(a.real * b.imag - a.imag * b.real)


@np.errstate(all="ignore")  # infinite and NaN steps are not taken
def newton(
    s: Complexes, target: Indices, miss: Callable[[Complexes, Indices], Complexes], enough: Floats
) -> tuple[Complexes, Floats]:
    """Return slopes that bring rays closer to their targets, and the distances by which they miss them.

    Levenberg's and Marquardt's method: if no ray near the first one meets the target, the result is the ray that misses
    it least. A ray is given up if its distance is more than `enough`, and ten steps have not halved it.
    """
    s, f = s.copy(), miss(s, target)
    damping, earlier = np.full(len(s), 1e-3), abs(f)
    active = np.flatnonzero(np.isfinite(f))
    for number in range(1, _STEPS + 1):
        if not len(active):
            break
        at, value, aim = s[active], f[active], target[active]
        h = 1e-7 * (1 + abs(at))
        a, b = (miss(at + h, aim) - value) / h, (miss(at + 1j * h, aim) - value) / h  # the columns of the Jacobian
        aa, bb, ab = abs(a) ** 2, abs(b) ** 2, (a.conj() * b).real
        ga, gb = (a.conj() * value).real, (b.conj() * value).real
        more = damping[active]
        p, r = aa * (1 + more), bb * (1 + more)
        size = p * r - ab**2
        step = -(r * ga - ab * gb) / size - 1j * (p * gb - ab * ga) / size
        step = np.where(np.isfinite(step), step, 0)
        new = miss(at + step, aim)
        better = abs(new) < abs(value)
        s[active], f[active] = np.where(better, at + step, at), np.where(better, new, value)
        damping[active] = np.where(better, more * 0.1, np.maximum(more, 1e-8) * 8)
        size = abs(step) / (1 + abs(at))
        going = (size > np.where(better, 1e-15, 1e-10)) & (damping[active] < 1e8) & (f[active] != 0)
        active = active[going]
        if number % 10 == 0:
            distance = abs(f[active])
            closer = (distance < earlier[active] / 2) | (distance <= enough[active])
            earlier[active], active = distance, active[closer]
    return s, np.nan_to_num(abs(f), nan=np.inf)
