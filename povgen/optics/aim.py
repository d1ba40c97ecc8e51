"""Where the eye sees a point through any list of windows, on numpy arrays.

Signs and units are as in `rotation`. A ray from the eye E has the slope s = (dx + i dy)/dz. It crosses the first
window, a distance z2 from the eye, at P = E + z2 s. A point L behind the last window appears at P if the ray meets L.

A window whose effect on place and slope is linear has a ray-transfer matrix. It maps (X, Y, sx, sy, 1) of a ray before
the window to that behind it. The windows' matrices and those of the distances between them are multiplied. Other
windows say which slope a ray gets, and L is found by Newton's method from several rays.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.prism import Prism
from povgen.optics.rotation import Complexes, Floats

Matrix = NDArray[np.float64]  # (5, 5)
# The rays from which the search starts: their angles to the normal, projected onto the planes of x and of y.
_ANGLES = np.radians(np.linspace(-84, 84, 25))
_STEPS = 60  # of Newton's method
_PRECISION = 1e-11  # of a found path: how far it passes L, relative to the distances


class Element(Protocol):
    """What a window does to a ray from the eye."""

    @property
    def transfer(self) -> Matrix | None:
        """The ray-transfer matrix, or None if there is none."""

    def slope(self, slope: ArrayLike, place: ArrayLike) -> Complexes:
        """Return the slope behind a window without thickness, NaN if no light passes. Arguments are x + iy."""


Windows = Sequence[tuple[float, Element]]  # the first one first: the distance from the window before, or from the eye


def pair(alpha: float, prism: Prism) -> Matrix:
    """Return the matrix of two sheets of prisms that rotate light by alpha (radians), in paraxial approximation.

    It is for the plane midway between them. As in `paraxial.depths`, they shorten the distances on both sides by h, and
    add (separation - slab_shift) exp(i alpha) conj(s) to the place.
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
    """Return, for each window, place and slope before it and behind it: of rays that leave the eye with this slope."""
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

    L is complex. L, z1 and `near` broadcast. Light can reach the eye on several paths. The result is that with the
    least of max(|x|, |y|): a square window round 0 that shows any of them shows this one. It is NaN if there is no
    path, and infinite if L appears at infinity.

    At a caustic two paths become one. Beyond it, both are gone. Then the path that passes L at the least distance
    counts, if this distance is up to `near`: a large object can be seen although its middle is not.
    """
    place, after, near = np.broadcast_arrays(np.asarray(L, complex), np.asarray(z1, float), np.asarray(near, float))
    distance, total = windows[0][0], matrix(windows)
    with np.errstate(all="ignore"):  # infinite and NaN results
        if total is None:
            s = _search(place.ravel(), E, after.ravel(), windows, near.ravel()).reshape(place.shape)
        else:
            start = total @ (E.real, E.imag, 0, 0, 1)
            to = place - complex(*start[:2]) - after * complex(*start[2:4])
            a, b, c, d = np.moveaxis(
                total[:2, 2:4] + after[..., None, None] * total[2:4, 2:4], (-2, -1), (0, 1)
            ).reshape(4, *after.shape)
            size, scale = a * d - b * c, abs(a * d) + abs(b * c)
            x, y = d * to.real - b * to.imag, a * to.imag - c * to.real
            rounding = 1e-14 * np.sqrt(scale) * abs(to)
            x, y = np.where(abs(x) <= rounding, 0, x), np.where(abs(y) <= rounding, 0, y)
            size = np.where(abs(size) <= 1e-14 * scale, 0, size)
            s = _quotient(x, size) + 1j * _quotient(y, size)
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


def _quotient(a: Floats, b: Floats) -> Floats:
    return np.where((a == 0) & (b != 0), 0.0, a / b)


def _search(L: Complexes, E: complex, z1: Floats, windows: Windows, near: Floats) -> Complexes:
    """Return the slopes at the eye, (n,), of rays to L (n,): see `position`."""

    def miss(s: Complexes, target: Any) -> Complexes:  # noqa: ANN401
        *_, P, behind = follow(s, E, windows)[-1]
        return P + z1[target] * behind - L[target]

    # A net of rays. L is close to a triangle of the net's image that contains it: its ray follows linearly.
    tan = np.tan(_ANGLES)
    net = tan + 1j * tan[:, None]
    *_, P, behind = follow(net, E, windows)[-1]
    image = P + z1[:, None, None] * behind - L[:, None, None]
    starts, targets = [], []
    for corners in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
        (i, j) = corners  # triangles below and above the diagonal of each cell
        a, b, c = (image[:, rows, columns] for rows, columns in ((i, i), (j, i), (i, j)))
        s0, s1, s2 = (np.broadcast_to(net[rows, columns], a.shape) for rows, columns in ((i, i), (j, i), (i, j)))
        u, v = b - a, c - a
        size = (u.conj() * v).imag
        p, q = -(a.conj() * v).imag / size, -(u.conj() * a).imag / size
        inside = (p > -0.3) & (q > -0.3) & (p + q < 1.3)
        starts.append((s0 + p * (s1 - s0) + q * (s2 - s0))[inside])
        targets.append(np.nonzero(inside)[0])
    # also the rays that pass L more closely than their neighbours
    off = np.nan_to_num(abs(image), nan=np.inf)
    framed = np.pad(off, ((0, 0), (1, 1), (1, 1)), constant_values=np.inf)
    n = len(tan)
    least = np.min([framed[:, 1 + i : 1 + i + n, 1 + j : 1 + j + n] for i in (-1, 0, 1) for j in (-1, 0, 1)], axis=0)
    lowest = np.isfinite(off) & (off == least)
    starts.append(np.broadcast_to(net, off.shape)[lowest])
    targets.append(np.nonzero(lowest)[0])
    s, target = np.concatenate(starts), np.concatenate(targets)
    s, off = _newton(s, target, miss)
    scale = abs(L - E) + z1 + windows[0][0]
    found = off <= np.maximum(_PRECISION * scale, near)[target]
    far = np.maximum(abs((E + windows[0][0] * s).real), abs((E + windows[0][0] * s).imag))
    # exact paths first where they are; of equally good ones the nearest to the window's middle
    best = np.full(len(L), complex(np.nan, np.nan))
    order = np.argsort(np.where(found, far, np.inf))[::-1]
    order = order[found[order]]
    best[target[order]] = s[order]
    return best


def _newton(s: Complexes, target: Any, miss: Any) -> tuple[Complexes, Floats]:  # noqa: ANN401
    """Return slopes that bring rays closer to their targets, and how far they pass them.

    It is Levenberg's and Marquardt's method: where a ray cannot meet its target, it passes it at the least distance.
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
        going = (abs(step) > 1e-15 * (1 + abs(at))) & (damping[active] < 1e8) & (f[active] != 0)
        active = active[going]
    return s, np.nan_to_num(abs(f), nan=np.inf)
