"""Where the eye sees a point through any list of windows, on numpy arrays.

Signs and units are as in `rotation`. A ray from the eye E has the slope s = (dx + i dy)/dz. It crosses the first
window, a distance z2 from the eye, at P = E + z2 s. A point L behind the last window appears at P if the ray meets L.

A window whose effect on place and slope is linear has a ray-transfer matrix. It maps (X, Y, sx, sy, 1), a ray's place
and slope before the window, to the same behind it. The windows' matrices and those of the distances between them are
multiplied. For other windows only the slope behind them is known for each ray. Newton's method, from many starts, finds
the ray to L.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.prism import Prism
from povgen.optics.rotation import Complexes, Floats

Matrix = NDArray[np.float64]  # (5, 5)
Indices = NDArray[np.intp]
# Start rays of the search: the angles to the normal of their projections onto the planes x-z and y-z.
_ANGLES = np.radians(np.linspace(-84, 84, 25))
_STEPS = 60  # of Newton's method
_PRECISION = 1e-11  # a path is found if it misses L by at most this, relative to the distances


class Element(Protocol):
    """What a window does to a ray from the eye."""

    @property
    def aperture(self) -> float:
        """The side of the square window."""

    @property
    def transfer(self) -> Matrix | None:
        """The ray-transfer matrix, or None if there is none."""

    def slope(self, slope: ArrayLike, place: ArrayLike) -> Complexes:
        """Return the slope behind a window without thickness, NaN if no light passes. Arguments are x + iy."""


# nearest to the eye first, each with its distance from the window before or the eye
Windows = Sequence[tuple[float, Element]]


def pair(alpha: float, prism: Prism) -> Matrix:
    """Return the matrix of two sheets of prisms that rotate light by alpha (radians), in paraxial approximation.

    The matrix refers to the plane midway between them. As in `paraxial.depths`, the pair shortens the distances on both
    sides by h, and adds (separation - slab_shift) exp(i alpha) conj(s) to the place.
    """
    h, turn = (prism.separation + prism.slab_shift) / 2, np.exp(-1j * alpha)
    b = (prism.separation - prism.slab_shift) / turn
    matrix = np.eye(5)
    matrix[:2, 2:4] = _real(-h * (1 + turn), b)
    matrix[2:4, 2:4] = _real(turn, 0)
    return matrix


def single(prism: Prism) -> Matrix:
    """Return the matrix of one sheet of prisms with ridges along x: it reverses the slope's y.

    For the slope along the ridges, the sheet acts as a slab of glass.
    """
    matrix = np.diag([1.0, 1, 1, -1, 1])
    matrix[0, 2] = -prism.slab_shift
    return matrix


def matrix(windows: Windows) -> Matrix | None:
    """Return the matrix from the eye to behind the last window, or None if a window has none."""
    total = np.eye(5)
    for distance, window in windows:
        if window.transfer is None:
            return None
        total = window.transfer @ _free(distance) @ total
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
            X, Y, sx, sy, _ = np.tensordot(window.transfer, ray, 1)
            P, s = X + 1j * Y, sx + 1j * sy
        else:
            s = window.slope(s, P)
        found.append((*before, P, s))
    return found


def position(L: ArrayLike, E: complex, z1: ArrayLike, windows: Windows, near: ArrayLike = 0) -> Complexes:
    """Return where in the plane of the first window the eye sees a point L, a distance z1 behind the last window.

    L is complex. L, z1 and `near` broadcast. Light can reach the eye on several paths. The result is the position with
    the least max(|x|, |y|). So a square window round 0 that shows any of these positions shows the result. It is NaN if
    there is no path, and infinite if L appears at infinity.

    At a caustic two paths become one. Beyond it, both are gone. A path that misses L by up to `near`, less than its
    neighbours do, counts too: a large object can be seen although its middle is not.
    """
    place, after, near = np.broadcast_arrays(np.asarray(L, complex), np.asarray(z1, float), np.asarray(near, float))
    distance, total = windows[0][0], matrix(windows)
    with np.errstate(all="ignore"):  # infinite and NaN results
        if total is None:
            s = _search(place.ravel(), E, after.ravel(), windows, near.ravel()).reshape(place.shape)
        else:
            start = total @ (E.real, E.imag, 0, 0, 1)
            to = place - complex(*start[:2]) - after * complex(*start[2:4])
            s = _solved(total[:2, 2:4], after[..., None, None] * total[2:4, 2:4], to)
        return (E + distance * s)[()]


def infinite_z1(windows: Windows) -> Floats:
    """Return the positive distances z1 at which objects can appear at infinity; none if a window has no matrix."""
    total = matrix(windows)
    if total is None:
        return np.empty(0)
    (a, b), (c, d) = total[:2, 2:4]
    (p, q), (r, t) = total[2:4, 2:4]
    roots = np.roots([p * t - q * r, a * t + d * p - b * r - c * q, a * d - b * c])
    return roots.real[(roots.real > 0) & (abs(roots.imag) < 1e-6 * abs(roots))]


def _free(distance: float) -> Matrix:
    total = np.eye(5)
    total[[0, 1], [2, 3]] = distance
    return total


def _real(a: complex, b: complex) -> Matrix:
    """Return the real matrix (2, 2) of the map a s + b conj(s)."""
    a, b = complex(a), complex(b)
    return np.array([[a.real + b.real, b.imag - a.imag], [a.imag + b.imag, a.real - b.real]])


def _solved(first: Floats, second: Floats, to: Complexes) -> Complexes:
    """Return the slopes s (...) with (first + second) s = `to` (...), for maps (..., 2, 2).

    If the map has rank 1, a `to` outside its range gives infinity. If the map is 0, `to` = 0 gives NaN, and any other
    infinity. Entries as small as rounding errors count as 0.
    """
    size = abs(first) + abs(second)
    maps = np.where(abs(first + second) <= 1e-14 * size.max((-2, -1), keepdims=True), 0, first + second)
    maps, right = np.broadcast_to(maps, (*to.shape, 2, 2)), np.stack((to.real, to.imag), -1)[..., None]
    (a, b), (c, d) = np.moveaxis(maps, (-2, -1), (0, 1))
    determinant = a * d - b * c
    singular = abs(determinant) <= 1e-14 * (abs(a * d) + abs(b * c))
    safe = np.where(singular[..., None, None], np.eye(2), np.nan_to_num(maps))
    slopes = np.linalg.solve(safe, np.nan_to_num(right))[..., 0]
    s = np.where(np.isnan(to) | np.isnan(determinant), np.nan, slopes[..., 0] + 1j * slopes[..., 1])
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
    s, off = _newton(s, target, miss)
    scale = abs(L - E) + z1 + windows[0][0]
    found = off <= np.maximum(_PRECISION * scale, near)[target]
    far = np.maximum(abs((E + windows[0][0] * s).real), abs((E + windows[0][0] * s).imag))
    # of all found paths the nearest to the window's middle
    best = np.full(len(L), complex(np.nan, np.nan))
    order = np.argsort(np.where(found, far, np.inf))[::-1]
    order = order[found[order]]
    best[target[order]] = s[order]
    return best


def _net(x: Floats, y: Floats) -> Complexes:
    """Return the slopes of rays at these angles, radians, in the planes of x and of y."""
    return np.tan(np.clip(x, -1.55, 1.55)) + 1j * np.tan(np.clip(y, -1.55, 1.55))[:, None]


def _starts(net: Complexes, image: Complexes) -> Iterator[tuple[Complexes, Indices]]:
    """Yield slopes from which to search, and the numbers of their targets.

    `image` (targets, rows, columns): the vectors, as complex numbers, by which the net's rays miss the targets.
    """
    # for targets in or near a triangle of the net's image: the slope, interpolated from the corners
    for i, j in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
        a, b, c = (image[:, rows, columns] for rows, columns in ((i, i), (j, i), (i, j)))
        s0, s1, s2 = (np.broadcast_to(net[rows, columns], a.shape) for rows, columns in ((i, i), (j, i), (i, j)))
        u, v = b - a, c - a
        size = (u.conj() * v).imag
        p, q = -(a.conj() * v).imag / size, -(u.conj() * a).imag / size
        inside = (p > -0.3) & (q > -0.3) & (p + q < 1.3)
        yield (s0 + p * (s1 - s0) + q * (s2 - s0))[inside], np.nonzero(inside)[0]
    # rays that pass the target more closely than their neighbours
    off = np.nan_to_num(abs(image), nan=np.inf)
    _, n, m = off.shape
    framed = np.pad(off, ((0, 0), (1, 1), (1, 1)), constant_values=np.inf)
    around = [framed[:, i : i + n, j : j + m] for i in range(3) for j in range(3)]
    lowest = np.isfinite(off) & (off == np.min(around, axis=0))
    yield np.broadcast_to(net, off.shape)[lowest], np.nonzero(lowest)[0]


def _newton(s: Complexes, target: Indices, miss: Callable[[Complexes, Indices], Complexes]) -> tuple[Complexes, Floats]:
    """Return slopes that bring rays closer to their targets, and the distances by which they miss them.

    Levenberg's and Marquardt's method: where no ray near it meets the target, the result is a ray that misses it least.
    """
    s, f = s.copy(), miss(s, target)
    damping = np.full(len(s), 1e-3)
    active = np.flatnonzero(np.isfinite(f))
    for _ in range(_STEPS):
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
    return s, np.nan_to_num(abs(f), nan=np.inf)
