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
from povgen.optics.faces import Booleans, GlassSheet
from povgen.optics.paraxial import Matrix, free, small_angles, solved
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile

Indices = NDArray[np.intp]
# The search starts from rays whose projections onto the planes x-z and y-z have these angles to the normal.
_ANGLES = np.radians(np.linspace(-84, 84, 25))
_CELLS = 96  # of a net over the first window, in a row
_MARGIN = 0.3  # in `_may_meet`
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

    @property
    def glass(self) -> tuple[GlassSheet, ...]:
        """A window's sheets of prisms or lenses, the nearest to the eye first: `sheets.Sheet.glass`."""

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


def position(
    L: ArrayLike, E: complex, z1: ArrayLike, windows: Windows, near: ArrayLike = 0, depth: float = 0.0
) -> Complexes:
    """Return where in the plane of the first window the eye sees a point L, a distance z1 behind the last window.

    L is complex. L, z1 and `near` broadcast. The result is NaN if there is no path, or if every ray leads to L.

    If all windows have a matrix, there is at most one path. The result is the complex infinity (inf + 0j) if L appears
    at infinity: the determinant of the equations for P is then at most 1e-14 of its terms.

    If a window has no matrix, paths are searched for. There can be several. Paths that pass inside the frames of all
    windows (`passes`, with the frames' `depth`) are preferred to others. Of several, the result is the position with
    the least max(|x|, |y|). The search can miss paths that leave the eye at more than 87 degrees to the normal, and
    paths through a detail of a law that is narrower than about a hundredth of the window. At a caustic two paths merge,
    and on one side of it there are none. On that side a large object can be seen in part, although its middle cannot.
    So a path also counts if it passes L, in L's plane, at a distance of at most `near`, and closer than neighbouring
    paths do. If it passes inside the frames too, a path to L is preferred, and otherwise the closest to L.
    """
    place, after, near = np.broadcast_arrays(np.asarray(L, complex), np.asarray(z1, float), real("near", near, 0))
    distance, total = windows[0][0], matrix(windows)
    with np.errstate(all="ignore"):  # infinite and NaN results
        if total is None:
            s = _search(place.ravel(), E, after.ravel(), windows, near.ravel(), depth).reshape(place.shape)
        else:
            x, y, sx, sy, _ = np.moveaxis(total @ (E.real, E.imag, 0, 0, 1), -1, 0)
            to = place - (x + 1j * y) - after * (sx + 1j * sy)
            s = solved(total[..., :2, 2:4], after[..., None, None] * total[..., 2:4, 2:4], to)
        return np.where(np.isinf(s), complex(np.inf, 0), E + distance * s)[()]


def passes(slope: ArrayLike, E: ArrayLike, windows: Windows, depth: float) -> Booleans:
    """Return whether rays that leave the eye with these slopes pass inside the frames of all windows.

    A ray must pass inside a frame's front and back, and inside the middle planes of its sheets, where the prediction
    turns it. `depth` is the frames' extent along z.
    """
    crossed: list[Complexes] = []
    with np.errstate(invalid="ignore"):
        for (before, s, behind, after), (_, window) in zip(follow(slope, E, windows), windows, strict=True):
            layers = window.glass
            for z in (depth / 2, layers[-1].centre if layers else 0.0):
                crossed += before - z * s, behind + z * after
        return np.asarray(np.all([_far(point) < windows[0][1].aperture / 2 for point in crossed], axis=0))


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


def _search(L: Complexes, E: complex, z1: Floats, windows: Windows, near: Floats, depth: float) -> Complexes:
    """Return the slopes at the eye, (n,), of rays to L (n,): see `position`."""

    def miss(s: Complexes, target: Indices) -> Complexes:
        *_, P, behind = follow(s, E, windows)[-1]
        return P + z1[target] * behind - L[target]

    starts, targets = [], []
    for net, P, behind in _nets(E, windows):
        for distance in np.unique(z1):
            some = np.flatnonzero(z1 == distance)
            for s, target in _starts(net, P + distance * behind, L[some]):
                starts.append(s)
                targets.append(some[target])
    s, target = np.concatenate([*starts, []]), np.concatenate([*targets, np.empty(0, int)])
    exact = (_PRECISION * (abs(L - E) + z1 + windows[0][0]))[target]
    enough = np.maximum(exact, near[target])
    s, off = nearest_rays(s, target, miss, enough)
    s, off, target, exact = (each[off <= enough] for each in (s, off, target, exact))
    best = np.full(len(L), complex(np.nan, np.nan))
    off = np.where(off <= exact, 0, off)
    order = np.lexsort((_far(E + windows[0][0] * s), off, ~passes(s, E, windows, depth)))[::-1]
    best[target[order]] = s[order]  # of several with the same target, the last one stays
    return best


def _far(place: Complexes) -> Floats:
    """Return the half side of the square round 0 that a point is on."""
    return np.maximum(abs(place.real), abs(place.imag))


def _nets(E: complex, windows: Windows) -> Iterator[tuple[Complexes, Complexes, Complexes]]:
    """Yield nets of rays, (rows, columns): their slopes at the eye, and place and slope behind the last window."""
    net = _net(_ANGLES, _ANGLES)
    yield net, *follow(net, E, windows)[-1][2:]
    half = windows[0][1].aperture / 2
    x = y = np.linspace(-1.1, 1.1, _CELLS + 1) * half
    while True:
        net = (x + 1j * y[:, None] - E) / windows[0][0]
        followed = follow(net, E, windows)
        yield net, *followed[-1][2:]
        # a finer net where the rays of a cell may pass all windows
        cells = np.all([_may_meet(place, 0, half) for place, *_ in followed], axis=0)
        rows, columns = (np.flatnonzero(cells.any(axis)) for axis in (1, 0))
        if not cells.any() or max(np.ptp(rows), np.ptp(columns)) > _CELLS / 2:
            return
        x, y = (np.linspace(x[k[0]], x[k[-1] + 1], _CELLS + 1) for x, k in ((x, columns), (y, rows)))


def _net(x: Floats, y: Floats) -> Complexes:
    """Return slopes of rays. x and y are the angles of their projections, onto x-z and y-z, to the normal."""
    return np.tan(np.clip(x, -1.55, 1.55)) + 1j * np.tan(np.clip(y, -1.55, 1.55))[:, None]


def _starts(net: Complexes, image: Complexes, L: Complexes) -> Iterator[tuple[Complexes, Indices]]:
    """Yield slopes from which to search, and the indices of their targets in L (n,).

    `image` (rows, columns): where the net's rays meet the targets' plane.
    """
    # In each cell that may show the target: interpolated between the slopes at its corners. If no light passes one of
    # them, it is the corner whose ray passes the target most closely.
    target, j, k = np.nonzero(_may_meet(image, L[:, None, None], 0))
    corners = np.array([j, j, j + 1, j + 1]), np.array([k, k + 1, k, k + 1])
    off, slopes = image[corners] - L[target], net[corners]
    a, b = (off[1] + off[3] - off[0] - off[2]) / 2, (off[2] + off[3] - off[0] - off[1]) / 2
    middle, size = off.mean(0), _cross(a, b)
    p, q = (np.clip(part / size, -0.5, 0.5) + 0.5 for part in (_cross(b, middle), _cross(middle, a)))
    inside = slopes[0] + p * (slopes[1] - slopes[0]) + q * (slopes[2] - slopes[0])
    closest = slopes[np.nan_to_num(abs(off), nan=np.inf).argmin(0), np.arange(len(target))]
    yield np.where(np.isfinite(inside), inside, closest), target
    # rays that pass the target more closely than their neighbours
    every = len(net) // len(_ANGLES)
    net, image = net[::every, ::every], image[::every, ::every]
    off = np.nan_to_num(abs(image - L[:, None, None]), nan=np.inf)
    framed = np.pad(off, ((0, 0), (1, 1), (1, 1)), constant_values=np.inf)
    least = _of_cells(np.minimum, _of_cells(np.minimum, framed))  # of the ray and its neighbours
    lowest = np.nonzero(np.isfinite(off) & (off == least))
    yield net[lowest[1:]], lowest[0]


def _may_meet(image: Complexes, to: Complexes | complex, half: float) -> Booleans:
    """Return in which cells of a net, (..., rows - 1, columns - 1), a ray may pass within a square round a point `to`.

    `image` (..., rows, columns) is where the net's rays meet the plane of the square. `half` is half its side. A cell's
    rays are assumed to be in the smallest rectangle around those of its corners, enlarged by _MARGIN of its sides.
    """
    meets: Booleans = np.array(True)
    for part, at in ((image.real, np.real(to)), (image.imag, np.imag(to))):
        low, high = _of_cells(np.fmin, part), _of_cells(np.fmax, part)
        more = half + _MARGIN * (high - low)
        meets = meets & (low - more <= at) & (at <= high + more)
    return meets


def _of_cells(function: Callable[[Floats, Floats], Floats], x: Floats) -> Floats:
    """Combine the values at the corners of each cell of a net."""
    x = function(x[..., 1:], x[..., :-1])
    return function(x[..., 1:, :], x[..., :-1, :])


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

    def values(s: Complexes, target: Indices) -> tuple[Complexes, ...]:
        """Return the misses and the columns of their Jacobian: one call of `miss` is faster than three."""
        h = 1e-7 * (1 + abs(s))
        f, right, up = miss(s + h * np.array([[0], [1], [1j]]), target)
        return f, (right - f) / h, (up - f) / h

    s = s.copy()
    f, a, b = values(s, target)
    damping, earlier = np.full(len(s), 1e-3), abs(f)
    active = np.flatnonzero(np.isfinite(f))
    for number in range(1, _STEPS + 1):
        if not len(active):
            break
        at, value, right, up = s[active], f[active], a[active], b[active]
        aa, bb, ab = abs(right) ** 2, abs(up) ** 2, (right.conj() * up).real
        ga, gb = (right.conj() * value).real, (up.conj() * value).real
        more = damping[active]
        p, r = aa * (1 + more), bb * (1 + more)
        size = p * r - ab**2
        step = -(r * ga - ab * gb) / size - 1j * (p * gb - ab * ga) / size
        step = np.where(np.isfinite(step), step, 0)
        new = values(at + step, target[active])
        better = abs(new[0]) < abs(value)
        moved = active[better]
        s[moved] += step[better]
        f[moved], a[moved], b[moved] = (each[better] for each in new)
        damping[active] = np.where(better, more * 0.1, np.maximum(more, 1e-8) * 8)
        size = abs(step) / (1 + abs(at))
        going = (size > np.where(better, 1e-15, 1e-10)) & (damping[active] < 1e8) & (f[active] != 0)
        active = active[going]
        if number % 20 == 0:
            distance = abs(f[active])
            halved = (distance < earlier[active] / 2) | (distance <= enough[active])
            earlier[active], active = distance, active[halved]
    return s, np.nan_to_num(abs(f), nan=np.inf)
