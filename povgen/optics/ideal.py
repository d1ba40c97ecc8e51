"""Other ideal sheets, as maps of light's direction, on numpy arrays.

An ideal sheet has no thickness. Light leaves it where it has met it, in another direction. Each map takes directions
(..., 3) of any length and returns directions of the same length. x points right and y up, as the eye sees them, and z
points away from the eye. A direction with z < 0 is light, which runs towards the eye. A direction with z > 0 runs away
from the eye, as a camera's rays do. It gets the inverse map, because a reversed ray retraces its path: if light in the
direction d leaves in the direction e, then -e leaves in the direction -d. Light that does not pass the sheet has the
direction NaN.

Rotation about the normal is `rotation.rotate`. One sheet of Dove prisms, which mirrors light's transverse direction
about any line in the sheet, is `rotation.mirror`; it is its own inverse. Both let light pass in every direction.
`position_by_rotation` and `position_by_refraction` return where light from an object crosses a sheet on its way to the
eye. With a factor of the slope it is `rotation.apparent_position` for z1/|factor| in place of z1 and alpha =
arg(factor), and with a mirror it is `paraxial.mirrored_position` for prisms of no size.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.rotation import Complexes, Floats

Directions = NDArray[np.float64]

_quiet = np.errstate(divide="ignore", invalid="ignore")  # light that does not pass is NaN, and complex NaN would warn


def rotate_about(direction: ArrayLike, axis: ArrayLike, alpha: float) -> Directions:
    """Return the directions (..., 3) behind a sheet that rotates light by alpha (radians) about an axis.

    The axis (3,) has any direction and length (Hamilton, Sundar and Courtial, J. Opt. 12, 095101, 2010). alpha is
    positive if the rotation is counter-clockwise for somebody who looks along the axis: for the axis (0, 0, 1) it is
    that of `rotation.rotate`. The new direction is d cos(alpha) + (a x d) sin(alpha) + a (a.d) (1 - cos(alpha)), with
    the unit vector a (Rodrigues' formula). Light passes if the rotation leaves the sign of z as it is. Raises
    ValueError for the axis (0, 0, 0).
    """
    d, R = np.asarray(direction, float), _rotation(axis, alpha)
    turned = np.where(d[..., 2:] > 0, d @ R, d @ R.T)
    return np.where(turned[..., 2:] * d[..., 2:] > 0, turned, np.nan)


@_quiet
def refract(direction: ArrayLike, ratio: complex) -> Directions:
    """Return the directions (..., 3) behind an interface of media with a real or complex ratio of refractive indices.

    The ratio n1/n2 is the index on the object's side, divided by that on the eye's side. The transverse part x + iy of
    light's unit direction is multiplied by the ratio: its modulus scales the sine of the angle to the normal (Snell's
    law), and its argument turns the plane of incidence, like alpha (Sundar, Hamilton and Courtial 2009). A ratio of -1
    is negative refraction. Light passes if the new sine is less than 1; otherwise it is totally reflected. Raises
    ValueError for the ratio 0.
    """
    d, length, t = _parts(direction, ratio, "ratio")
    t = t / length
    rest = 1 - np.abs(t) ** 2
    z = np.copysign(np.sqrt(np.where((rest > 0) & (d[..., 2] != 0), rest, np.nan)), d[..., 2])
    return _direction(t, z, length)


@_quiet
def scale_slope(direction: ArrayLike, factor: complex) -> Directions:
    """Return the directions (..., 3) behind a sheet that multiplies the slope (x + iy)/|z| of light by a factor.

    With a real factor this is Snell's law with tangents in place of sines, the law of confocal lenslet arrays (Courtial
    2008): for lenslets with the focal length f1 on the object's side and f2 on the eye's, the factor is -f1/f2. An
    argument of the factor turns light, like alpha. Light passes in every direction, except parallel to the sheet. Real
    lenslets have a limited field. Raises ValueError for the factor 0.
    """
    d, length, t = _parts(direction, factor, "factor")
    z = np.where(d[..., 2] == 0, np.nan, d[..., 2])
    return _direction(t, z, length / np.hypot(np.abs(t), z))


@_quiet
def position_by_rotation(
    L: ArrayLike, E: ArrayLike, z1: ArrayLike, z2: ArrayLike, axis: ArrayLike, alpha: float, near: ArrayLike = 0
) -> Complexes:
    """Return where light from L to E crosses a sheet that rotates light about an axis: `rotate_about`.

    L and E are complex, z1 > 0 and z2 > 0 are the distances of the object behind and of the eye in front of the sheet,
    all in one unit and finite. They broadcast. Light can reach the eye on up to three paths. The result is the crossing
    with the least of max(|x|, |y|): a square window round 0 that shows any of them shows this one. It is NaN if there
    is no path. Raises ValueError for the axis (0, 0, 0).

    At a caustic two paths become one; beyond it, both are gone. Then a path that passes L at a distance of up to `near`
    also counts: a large object can be seen although its middle is not.

    A camera's ray with the direction v = (slope, 1) has the direction R^-1 v behind the sheet, with the rotation matrix
    R. The vector from the crossing to L is K v, where K = ((-z2, 0, Re(L - E)), (0, -z2, Im(L - E)), (0, 0, z1)). Light
    runs along it if K v is a positive multiple of R^-1 v: v is an eigenvector of R K with a positive eigenvalue. Close
    to a caustic, two of the three are complex. The real part of their slope is that of the ray that passes close to L.
    """
    D, eye, after, before, most = _rays(L, E, z1, z2, near)
    R, K = _rotation(axis, alpha), np.zeros((*D.shape[:-1], 3, 3))
    K[..., 0, 0] = K[..., 1, 1] = -before[..., 0]
    K[..., :, 2] = np.concatenate((D.real, D.imag, after), axis=-1)
    values, v = np.linalg.eig(R @ K)
    x, y, z = np.moveaxis(np.where(abs(v[..., 2:, :]) > 1e-9, v, np.nan), -2, 0)  # not parallel to the sheet
    s = (x / z).real + 1j * (y / z).real
    ray = np.stack((s.real, s.imag, np.ones_like(s.real)), axis=-1) @ R
    miss = abs(before * s + after * (ray[..., 0] + 1j * ray[..., 1]) / ray[..., 2] - D)
    # rounding can make a real eigenvalue complex if two are nearly equal
    real = abs(values.imag) <= 1e-7 * values.real
    return _nearest(np.where((ray[..., 2] > 0) & (real | (miss <= most)), eye + before * s, np.nan))


@_quiet
def position_by_refraction(
    L: ArrayLike, E: ArrayLike, z1: ArrayLike, z2: ArrayLike, ratio: complex, near: ArrayLike = 0
) -> Complexes:
    """Return where light from L to E crosses an interface with a ratio of refractive indices: `refract`.

    Arguments and result as for `position_by_rotation`. Raises ValueError for the ratio 0.

    Let t be the angle of the eye's ray to the normal, and t' that of the ray behind the interface: sin t = |ratio|
    sin t'. The ray's slope s at the eye has |s| = tan t, and L - E = Z s with the complex depth Z = z2 + z1 (tan t'/
    tan t) exp(-i arg(ratio)). So |Z| tan t = |L - E| is an equation for t alone. The derivative of its left side is 0
    where w = (z2 tan t)/(z1 tan t') solves w^4 + c w^3 + c q w + q = 0, with c = cos(arg(ratio)) and q = (|ratio|
    z2/z1)^2. That is at most twice, and there are the caustics. The solutions, between these points, are found by
    bisection of an angle p. It is 0 for light along the normal, and 90 degrees where the greater of t and t' is.
    """
    if ratio == 0:
        raise ValueError("ratio = 0; allowed: any other")
    D, eye, after, before, most = _rays(L, E, z1, z2, near)
    size, turn = abs(ratio), np.conj(ratio) / abs(ratio)
    least = min(1, size)

    def ray(p: Floats) -> tuple[Complexes, Floats]:
        """Return Z, and by how much the ray passes on the far side of L, seen from E."""
        c = (least * np.cos(p)) ** 2
        cos2, behind = c + (1 - least**2), c + (size**2 - least**2)  # cos^2 t, and cos^2 t' times |ratio|^2
        Z = before + after * turn * np.sqrt(cos2 / behind)
        return Z, abs(Z) * least * np.sin(p) / np.sqrt(cos2) - abs(D)

    c, q, companion = turn.real, (size * before / after) ** 2, np.zeros((*D.shape[:-1], 4, 4))
    companion[..., 0, :] = -np.concatenate((c + 0 * q, 0 * q, c * q, q), axis=-1)
    companion[..., [1, 2, 3], [0, 1, 2]] = 1
    w = np.linalg.eigvals(companion)
    square = (np.where(w.real > 0, w.real, np.nan) * after / before) ** 2  # (tan t/tan t')^2
    turning = np.arcsin(np.sqrt((size**2 - square) / (1 - square)) / least)
    p = np.sort(np.concatenate((0 * q, np.nan_to_num(turning), 0 * q + np.pi / 2), axis=-1))
    beyond = ray(p)[1] > 0
    found = beyond[..., 1:] != beyond[..., :-1]
    start, end = p[..., :-1], p[..., 1:]
    for _ in range(60):
        middle = (start + end) / 2
        not_yet = (ray(middle)[1] > 0) == beyond[..., :-1]
        start, end = np.where(not_yet, middle, start), np.where(not_yet, end, middle)
    exact = np.where(found, eye + D * before / ray((start + end) / 2)[0], np.nan)
    Z, off = ray(p[..., 1:-1])
    close = (abs(off) <= most) & (p[..., 1:-1] > 0) & ~found[..., 1:] & ~found[..., :-1]
    return _nearest(
        np.concatenate((exact, np.where(close, eye + (D + D / abs(D) * off) * before / Z, np.nan)), axis=-1)
    )


def _rotation(axis: ArrayLike, alpha: float) -> NDArray[np.float64]:
    """Return the matrix (3, 3) that turns light's directions by alpha about an axis (3,)."""
    a = np.asarray(axis, float)
    if not a.any():
        raise ValueError("axis = (0, 0, 0); allowed: any other")
    a = a / np.abs(a).max()  # so that no square becomes 0 or overflows
    a = a / np.linalg.norm(a)
    c, across = np.cos(alpha), np.cross(a, np.eye(3)).T
    return np.array(c * np.eye(3) + np.sin(alpha) * across + (1 - c) * np.outer(a, a))


def _rays(L: ArrayLike, E: ArrayLike, *lengths: ArrayLike) -> tuple[Any, ...]:
    """Return L - E, E and lengths as arrays (..., 1)."""
    place, eye, *others = np.broadcast_arrays(*(np.asarray(x)[..., None] for x in (L, E, *lengths)))
    return place - eye, eye, *others


def _nearest(P: Complexes) -> Complexes:
    """Return, of the points (..., n), the one with the least of max(|x|, |y|). Points can be NaN."""
    far = np.nan_to_num(np.maximum(abs(P.real), abs(P.imag)), nan=np.inf)
    return np.take_along_axis(P, far.argmin(-1)[..., None], -1)[..., 0][()]


def _parts(direction: ArrayLike, factor: complex, name: str) -> tuple[Directions, Directions, Complexes]:
    """Return directions, their lengths, and their transverse part times the factor, for z > 0 divided by it."""
    if factor == 0:
        raise ValueError(f"{name} = 0; allowed: any other")
    d = np.asarray(direction, float)
    t = (d[..., 0] + 1j * d[..., 1]) * np.where(d[..., 2] > 0, 1 / complex(factor), factor)
    return d, np.linalg.norm(d, axis=-1), t


def _direction(t: Complexes, z: Directions, length: Directions) -> Directions:
    """Return directions from transverse parts and z, times a length; NaN in all components where z is NaN."""
    t = np.where(np.isnan(z), np.nan, t)
    return np.stack((t.real, np.where(np.isnan(z), np.nan, t.imag), z), axis=-1) * length[..., None]
