"""Where the eye sees a point through any list of windows, on numpy arrays.

Points are complex numbers x + iy: x points right and y up, as the eye sees them. z points away from the eye. All
lengths have the same unit. A ray from the eye E has the slope s = (dx + i dy)/dz. It crosses the first window, a
distance z2 from the eye, at P = E + z2 s. A point L behind the last window appears at P if the ray meets L.

A window has a ray-transfer matrix (5, 5) if place and slope behind it are linear functions of those before it, plus
constants. The matrix maps (X, Y, sx, sy, 1), a ray's place and slope before the window, to those behind the window. The
windows' matrices and those of the distances between them are multiplied. The matrices of prisms and lenses are in
`paraxial`. For other windows only `Element.slope` is known: the slope behind the window, for each ray. If there is such
a window, the ray to L is found by the Levenberg-Marquardt method, from many starts.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.equations import Complexes, Floats, real
from povgen.optics.faces import Sheet
from povgen.optics.paraxial import Matrix, free, small_angles, solved
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile

Indices = NDArray[np.intp]
# The search starts from rays whose projections onto the planes x-z and y-z have these angles to the normal.
_ANGLES = np.radians(np.linspace(-84, 84, 25))
_STEPS = 60  # of the search
_PRECISION = 1e-11  # a path is found if it misses L by at most this fraction of the distances in the scene


class Element(Protocol):
    """What a window does to a ray from the eye."""

    @property
    def aperture(self) -> float:
        """The side of the square window."""

    @property
    def transfer(self) -> Matrix | None:
        """The ray-transfer matrix (..., 5, 5), or None if there is none."""

    def layers_at(self, z: float, window: int) -> tuple[Sheet, ...]:
        """Return a window's sheets of prisms or lenses, the nearest to the eye first: `sheets.Sheet.layers_at`."""

    def slope(self, slope: ArrayLike, place: ArrayLike) -> Complexes:
        """Return the slope behind a window without thickness, NaN if no light passes.

        Slopes are (dx + i dy)/dz. The place is X + iY, from the window's centre.
        """


# The window nearest to the eye comes first. Each has its distance from the window before it, or from the eye.
Windows = Sequence[tuple[float, Element]]


def matrix(windows: Windows) -> Matrix | None:
    """Return the matrix from the eye to behind the last window, or None if a window has none."""
    total = np.eye(5)
    for distance, window in windows:
        if window.transfer is None:
            return None
        total = window.transfer @ free(distance) @ total
    return total


def follow(slope: ArrayLike, E: ArrayLike, windows: Windows) -> list[tuple[Complexes, Complexes, Complexes, Complexes]]:
    """Follow rays from the eye with this slope.

    Return for each window: the place and the slope before it, the place and the slope behind it.
    """
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

    L is complex. L, z1 and `near` broadcast. The result is NaN if there is no path, or if every ray leads to L.

    If all windows have a matrix, there is at most one path. The result is the complex infinity (inf + 0j) if L appears
    at infinity: the determinant of the equations for P is then at most 1e-14 of its terms.

    If a window has no matrix, paths are searched for. There can be several. The result is the position with the least
    max(|x|, |y|), so if any position is visible in a square window with its centre at 0, the result is. The search can
    miss paths that leave the eye at more than 87 degrees to the normal, and paths through a part of the window that a
    law leaves open, if it is narrower than about a hundredth of the window. At a caustic two paths merge, and on one
    side of it there are none. On that side a large object can be seen in part, although its middle cannot. So a path
    also counts if it passes L, in L's plane, at a distance of at most `near`, and closer than neighbouring paths do.
    """
    place, after, near = np.broadcast_arrays(np.asarray(L, complex), np.asarray(z1, float), real("near", near, 0))
    distance, total = windows[0][0], matrix(windows)
    with np.errstate(all="ignore"):  # infinite and NaN results
        if total is None:
            s = _search(place.ravel(), E, after.ravel(), windows, near.ravel()).reshape(place.shape)
        else:
            x, y, sx, sy, _ = np.moveaxis(total @ (E.real, E.imag, 0, 0, 1), -1, 0)
            to = place - (x + 1j * y) - after * (sx + 1j * sy)
            s = solved(total[..., :2, 2:4], after[..., None, None] * total[..., 2:4, 2:4], to)
        return np.where(np.isinf(s), complex(np.inf, 0), E + distance * s)[()]


def image(L: ArrayLike, z1: float, windows: Windows) -> tuple[float, Complexes]:
    """Return the image plane's z, measured from the first window, and the image points in this plane.

    L (n,) are points a distance z1 behind the last window. To the eye, their light runs as if it came from the image
    points (n,), whatever its slope. The image is virtual behind the first window (z > 0), and real before it. If the
    light of each point is parallel, z is infinite and the image points are NaN. If the light of a point does not come
    together, or if a window has no matrix, z and the image points are NaN. The distance of the first window from the
    eye does not matter.
    """
    points = np.asarray(L, complex)
    nowhere = np.full(points.shape, complex(np.nan, np.nan))
    (_, first), *others = windows
    total = matrix([(0.0, first), *others])
    if total is None or not np.isfinite(total).all():
        return np.nan, nowhere
    # rays with place p and slope s at the first window meet the points' plane at a p + b s + c
    a, b, c = (total[:2, part] + z1 * total[2:4, part] for part in (slice(2), slice(2, 4), 4))
    small = 1e-11 * (np.linalg.norm(b) + (1 + abs(z1)) * np.linalg.norm(a))
    if (1 + abs(z1)) * np.linalg.norm(a) <= small:
        return np.inf, nowhere
    # a ray with the slope s through the image point p crosses the first window at p - z s
    z = np.vdot(a, b) / np.vdot(a, a)
    if np.linalg.norm(b - z * a) > small or abs(np.linalg.det(a)) <= 1e-9 * np.linalg.norm(a) ** 2:
        return np.nan, nowhere
    x, y = np.linalg.solve(a, np.stack((points.real - c[0], points.imag - c[1])))
    return float(z), x + 1j * y


def depths(z1: ArrayLike, windows: Windows) -> tuple[Complexes, Complexes]:
    """Return A and B: if a ray's slope at the eye changes by a small ds, its end moves by A ds + B conj(ds).

    The end is in the plane of L, a distance z1 behind the last window. For windows that rotate light, L - E = A s + B
    conj(s) for a ray that reaches the eye E with the slope s. If these windows have no thickness, B = 0, and A is the
    complex depth Z of `equations.depth`. If |A| = |B|, the light of a point meets the eye's plane only along a line. If
    A = B = 0, it does so in only one point. A and B are NaN if a window has no matrix.
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

    nu is positive if the object appears turned counter-clockwise. M is the object's apparent size, in the plane of the
    first window, divided by its true size.

    With A and B of `depths`, a short step d on the object appears as p d + q conj(d) in the plane of the first window:
    p = z2 conj(A)/(|A|^2 - |B|^2) and q = -z2 B/(|A|^2 - |B|^2). Then nu = arg(p). The magnification depends on the
    direction of d: it is between ||p| - |q|| and |p| + |q|, and M is the mean |p|. For sheets without thickness that
    rotate light, nu and M are eqs. 8 and 9, corrected (docs/errata.md). If |q| > |p|, the object appears mirrored:
    nu is NaN, and M is |q|. If |A| = |B|, nu is NaN and M is infinite.
    """
    A, B = depths(z1, windows)
    with np.errstate(divide="ignore", invalid="ignore"):
        M = windows[0][0] * np.maximum(abs(A), abs(B)) / (abs(A) + abs(B)) / abs(abs(A) - abs(B))  # squares overflow
    M = np.where(abs(abs(A) - abs(B)) <= 1e-14 * (abs(A) + abs(B)), np.inf, M)
    return np.where(abs(A) > abs(B), -np.angle(A), np.nan)[()], M[()]


def infinite_z1(windows: Windows) -> Floats:
    """Return the values of z1 > 0, (n,), at which objects appear at infinity, or come closest to it.

    z1 solves a quadratic equation, |A|^2 - |B|^2 = 0 with A and B of `depths`. So n is at most 2. If the solutions are
    complex, no object appears at infinity. The result is then their real part, twice: there |A|^2 - |B|^2 is closest to
    0. The result is empty if no value is above 0, or if a window has no matrix.
    """
    total = matrix(windows)
    if total is None or not np.isfinite(total).all():  # NaN: no light takes a profile's designed path
        return np.empty(0)
    (a, b), (c, d) = total[:2, 2:4]
    (p, q), (r, t) = total[2:4, 2:4]
    roots = np.roots([p * t - q * r, a * t + d * p - b * r - c * q, a * d - b * c])
    return roots.real[roots.real > 0]


def infinite_alpha(z1: ArrayLike, z2: ArrayLike, shape: Prism | Profile) -> Complexes:
    """Return the alpha from 0 to pi, radians, at which a pair of sheets shows an object at infinity (|A| = |B|).

    The pair is that of `trace.pair`. Both sheets have the given shape, and mirror the slope of light about their
    ridges. z1 and z2 are measured from the middle of the pair. The result is complex if there is no real alpha. At
    -alpha, the object is at infinity too.
    """
    g, apart = small_angles(shape).slab_shift, shape.separation
    near, far = np.subtract(z2, (apart + g) / 2), np.subtract(z1, (apart + g) / 2)
    return np.emath.arccos(((apart - g) ** 2 - near**2 - far**2) / (2 * near * far))


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
    s, off = nearest_rays(s, target, miss, enough)
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
    """Yield slopes from which to search, and the indices of their targets.

    `image` (targets, rows, columns): the vectors, as complex numbers, by which the net's rays miss the targets.
    """
    # Three neighbouring rays meet the target's plane at the corners of a triangle. If the target is inside, or a little
    # outside, the start is interpolated between the slopes of the three.
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
def nearest_rays(
    s: Complexes, target: Indices, miss: Callable[[Complexes, Indices], Complexes], enough: Floats
) -> tuple[Complexes, Floats]:
    """Return the slopes of rays that pass their targets most closely, and the distances by which they miss them.

    s (n,) are the first slopes, and `target` (n,) the index of each ray's target. `miss(s, target)` returns the vectors
    from the targets to the rays, as complex numbers. `enough` (n,) are the distances that are small enough.

    The method is Levenberg-Marquardt. If no ray near the first one meets the target, the result is the ray that misses
    it least. The search for a ray ends early if its distance is more than `enough`, and twenty steps have not halved
    it. The distance is infinite if `miss` is NaN for the first slope.
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
        if number % 20 == 0:
            distance = abs(f[active])
            halved = (distance < earlier[active] / 2) | (distance <= enough[active])
            earlier[active], active = distance, active[halved]
    return s, np.nan_to_num(abs(f), nan=np.inf)
