"""The mathematics of ray rotation (sections 2 to 4 of the paper), on numpy arrays that broadcast.

Angles are in radians. The ray-rotation angle alpha is positive if light on its way from the object to the eye is
turned counter-clockwise, as the eye sees it. Points in the plane of the sheet are complex numbers x + iy: x points
right and y up, as the eye sees them, and z points away from the eye. The object L is a distance z1 behind the sheet.
The eye E is a distance z2 in front of the sheet. z1 and z2 are finite. Light from L to E crosses the sheet at P, a
Möbius transform of r exp(i alpha). The ratio r = z2/z1 is from 0 to infinity. Equations 5 to 9 are for L = 0 and E =
1.

At r exp(i alpha) = -1, the pole of eq. 7, no light from L reaches E. There P and 1 - P are the complex infinity
(inf + 0j). A double cannot be exactly pi: for r = 1, the double nearest to pi is treated as the pole. Near the pole no
digits are lost by cancellation. `condition` returns the factor by which errors of r and alpha grow there.

alpha, r and distances are real. Complex numbers raise TypeError. Negative r or distances raise ValueError, unless the
docstring allows them. Angles beyond 10 pi raise ValueError, because they are probably in degrees. NaN gives NaN.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Results are arrays, or numpy scalars if all arguments are scalars. For type checkers they are Any, as in numpy.
Floats = Any
Complexes = Any
Booleans = Any

# The windows behind the first one, in the order in which an eye looks through them. Each is the pair of its distance
# from the window before it, and its alpha.
Windows = Iterable[tuple[ArrayLike, ArrayLike]]
# In the sum for Z (see `depth`), each complex term has a relative error of some 1e-16. A sum smaller than ROUNDING
# times the sum of the terms' absolute values counts as 0.
ROUNDING = 1e-14
LARGEST_ANGLE = 10 * np.pi


def r(z1: ArrayLike, z2: ArrayLike) -> Floats:
    """Return eq. 3: the ratio of distances z2/z1. It is infinite for z1 = 0, and NaN if z2 = 0 as well."""
    z1, z2 = real("z1", z1, 0), real("z2", z2, 0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.divide(z2, z1)


def P(r: ArrayLike, alpha: ArrayLike) -> Complexes:
    """Return eq. 7: 1/(1 + r exp(i alpha)), the point where light from L = 0 to E = 1 crosses the sheet."""
    r, alpha, touching = _checked(r, alpha)
    return np.where(touching, 0, _divide(1, _sum(1.0, np.where(touching, 1, r), alpha)))[()]


def one_minus_P(r: ArrayLike, alpha: ArrayLike) -> Complexes:
    """Return E - P for L = 0 and E = 1.

    For any L and E, the eye sees L at E + (L - E) (1 - P), with P of eq. 7.
    """
    r, alpha, touching = _checked(r, alpha)
    finite = np.where(touching, 1, r)
    return np.where(touching, 1, _divide(finite, _sum(finite, 1.0, -alpha)))[()]


def nu(r: ArrayLike, alpha: ArrayLike) -> Floats:
    """Return eq. 8, corrected: arg(1 - P), the angle through which an object appears turned about E. NaN at the pole.

    At r = 0, where 1 - P = 0, the result is the limit, alpha. Erratum: the paper prints arg(P), the angle at L. The
    text next to eq. 8, and the paper's pictures, show the angle at E.
    """
    r, alpha, touching = _checked(r, alpha)
    inverse = _sum(np.where(touching, 1, r), np.where(touching, 0, 1.0), -alpha)  # a positive multiple of 1/(1 - P)
    return np.where(inverse == 0, np.nan, -np.angle(inverse))[()]


def M(r: ArrayLike, alpha: ArrayLike) -> Floats:
    """Return eq. 9, corrected: |1 - P|, the magnification compared with the same object in the plane of the sheet.

    M is infinite at the pole. Erratum: the paper prints |P|, which is 0 for an object that touches the sheet. There the
    magnification is 1.
    """
    return np.abs(one_minus_P(r, alpha))


def condition(r: ArrayLike, alpha: ArrayLike) -> Floats:
    """Return the condition number of P with respect to r exp(i alpha): |1 - P|.

    A relative error of 1e-16 in r, or an error of 1e-16 radians in alpha, causes a relative error of P. This is 1e-16
    times the condition number. The condition number of 1 - P is |P|.
    """
    return M(r, alpha)


def depth(z1: ArrayLike, z2: ArrayLike, alpha: ArrayLike, behind: Windows = ()) -> Complexes:
    """Return the complex depth Z: for light from L that reaches E, L - E = Z s with its slope s at the eye.

    The slope is s = (dx + i dy)/dz.
    z2 is the distance from the eye to the first window, alpha the angle of this window, and z1 the distance from the
    last window to the object. `behind` are the windows between the first one and the object, the nearest to the eye
    first: pairs (d, alpha), where d is the distance from the window before. For windows of alpha_1 ... alpha_n, d_k
    apart,
    Z = z2 + d_1 exp(-i alpha_1) + d_2 exp(-i (alpha_1 + alpha_2)) + ... + z1 exp(-i (alpha_1 + ... + alpha_n)).
    For one window Z = z2 + z1 exp(-i alpha), without cancellation. For several windows a Z as small as the rounding
    errors, ROUNDING times the sum of the distances, is given as 0. Distances of either sign are allowed.
    """
    Z, behind = real("z1", z1), tuple(behind)
    size = abs(Z)
    for distance, turn in reversed([(z2, alpha), *behind]):
        distance = real("distance", distance)
        Z, size = _sum(distance, Z, -radians("alpha", turn)), size + abs(distance)
    return np.where(abs(Z) <= ROUNDING * size, 0, Z)[()] if behind else Z


def curl(z1: ArrayLike, z2: ArrayLike, alpha: ArrayLike, theta: ArrayLike = 0, behind: Windows = ()) -> Floats:
    """Return the curl of the directions of light from a point L, on the eye's side of the windows.

    The unit vectors along this light form a vector field. The result is for a place at a distance z2 from the first
    window, at which theta is the angle between the light and the normal. There the curl is parallel to the light. The
    result is its component along the light, in 1/length: -(1 + cos^2 theta) Im Z/|Z|^2, with Z of `depth`. Its sign
    follows the right-hand rule, although the axes x, y, z are left-handed.
    For one window that is (1 + cos^2 theta) z1 sin(alpha)/|Z|^2. Where the curl is not 0, no surface is perpendicular
    to the light: it has no wave fronts (docs/beyond.md). NaN if Z = 0.

    Derivation, for L = 0: let 1/Z = u + iv. V = (ux - vy, vx + uy, 1) points along the light, with |V| = 1/cos(theta).
    d(1/Z)/dz2 = -1/Z^2 gives V . curl V = v (2 + tan^2 theta), and v = -Im Z/|Z|^2. The unit vector V/|V| is constant
    along the light, so its curl is parallel to it.
    """
    Z = depth(z1, real("z2", z2, 0), alpha, behind)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return (1 + np.cos(radians("theta", theta)) ** 2) * np.divide(-np.imag(Z) / np.abs(Z), np.abs(Z))


def apparent_position(
    L: ArrayLike, E: ArrayLike, z1: ArrayLike, z2: ArrayLike, alpha: ArrayLike, behind: Windows = ()
) -> Complexes:
    """Return where light from L to E crosses the first window: P = E + (L - E) z2/Z, with Z of `depth`.

    For one window this is E + (L - E) (1 - P), with P of eq. 7. L and E are complex. z1 >= 0 and z2 > 0 are finite. All
    are in one unit. At the pole, Z = 0, the result is the complex infinity. For L = E it is NaN there, because the eye
    then sees L in every direction.
    """
    z1, z2 = real("z1", z1, 0), real("z2", z2, 0)
    L, E = doubles(L, E)
    return E + _divide((L - E) * z2, depth(z1, z2, alpha, behind))


def object_position(
    P: ArrayLike, E: ArrayLike, z1: ArrayLike, z2: ArrayLike, alpha: ArrayLike, behind: Windows = ()
) -> Complexes:
    """Return the point L at which an object appears at P: the inverse of `apparent_position`.

    P and E are complex. z1 >= 0 and z2 > 0 are finite. All are in one unit. At the pole L is E for every P.
    """
    z1, z2 = real("z1", z1, 0), real("z2", z2, 0)
    P, E = doubles(P, E)
    with np.errstate(invalid="ignore"):  # complex NaN would warn
        return E + (P - E) * depth(z1, z2, alpha, behind) / z2


def rotate(direction: ArrayLike, alpha: ArrayLike) -> Floats:
    """Return the directions (..., 3) of light after a sheet that rotates it by alpha.

    A direction with z < 0 runs towards the eye: its transverse part x + iy is multiplied by exp(i alpha). A direction
    with z > 0 runs away from the eye, as a camera's rays do: it is turned by -alpha, because a reversed ray retraces
    its path. Raises ValueError for light parallel to the sheet, z = 0.
    """
    direction = real("direction", direction)
    if (direction[..., 2] == 0).any():
        raise ValueError("direction: z = 0, parallel to the sheet; allowed: any other z")
    sense = np.where(direction[..., 2] > 0, -1, 1)
    return _with_transverse(direction, _transverse(direction) * np.exp(1j * sense * radians("alpha", alpha)))


def mirror(direction: ArrayLike, angle: ArrayLike) -> Floats:
    """Return the directions (..., 3) of light after one sheet of infinitely fine Dove prisms.

    `angle` is the angle between the prisms' ridges and the x axis. The transverse part d = x + iy is mirrored about the
    ridges: it becomes exp(2i angle) conj(d).
    """
    direction = real("direction", direction)
    return _with_transverse(direction, np.exp(2j * radians("angle", angle)) * _transverse(direction).conj())


def real(name: str, values: ArrayLike, least: float = -np.inf) -> NDArray[np.float64]:
    """Return the values of a parameter as floats.

    Raises TypeError if they are complex or no numbers, and ValueError if one is less than `least`.
    """
    values = np.asarray(values)
    if values.dtype.kind not in "iuf":
        fault = "is complex" if np.iscomplexobj(values) else "has other values than numbers"
        raise TypeError(f"{name} {fault}; allowed: real numbers")
    values = values.astype(float)
    if (values < least).any():
        raise ValueError(f"{name} = {np.nanmin(values):g}; allowed: {least:g} or more")
    return values


def doubles(*places: ArrayLike) -> tuple[NDArray[Any], ...]:
    """Return places as real or complex numbers of double precision. Differences of whole numbers could overflow."""
    return tuple(place.astype(np.result_type(place, float)) for place in map(np.asarray, places))


def radians(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return the values of an angle as floats. Raises what `real` raises, and ValueError for angles beyond 10 pi."""
    values = real(name, values)
    if (np.abs(values) > LARGEST_ANGLE).any():
        raise ValueError(f"{name} = {values[np.abs(values) > LARGEST_ANGLE][0]:g}; allowed: -10 pi to 10 pi, radians")
    return values


def _checked(r: ArrayLike, alpha: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64], Booleans]:
    """Return r and alpha as floats, and whether the object touches the sheet: r is infinite, and alpha is not NaN."""
    r, alpha = real("r", r, 0), radians("alpha", alpha)
    return r, alpha, np.isinf(r) & ~np.isnan(alpha)


def _transverse(direction: Floats) -> Complexes:
    return direction[..., 0] + 1j * direction[..., 1]


def _with_transverse(direction: Floats, transverse: Complexes) -> Floats:
    d, z = np.broadcast_arrays(transverse, direction[..., 2])
    return np.stack((d.real, d.imag, z), axis=-1)


def _sum(a: Floats, b: Floats, alpha: Floats) -> Complexes:
    """Return a + b exp(i alpha), as (a - b) + 2b cos(alpha/2) exp(i alpha/2).

    a and b may be complex. If they are real, no digits are lost by cancellation.
    """
    half = alpha / 2
    cosine = np.cos(half)
    at_pi = np.abs(cosine) <= np.spacing(np.abs(half)) / 2  # alpha is the double nearest to an odd multiple of pi
    cosine = np.where(at_pi & (a == b), 0, cosine)
    return 2 * ((a - b) / 2 + b * (cosine * np.exp(1j * half)))  # 2b could overflow


def _divide(a: Complexes, b: Complexes) -> Complexes:
    """Return a/b; the complex infinity if only b is 0; NaN if both are 0."""
    pole = b == 0
    with np.errstate(invalid="ignore"):  # division by a complex NaN would warn
        ratio = a / np.where(pole, 1, b)
    return np.where(pole, np.where(a == 0, np.nan, complex(np.inf, 0)), ratio)[()]
