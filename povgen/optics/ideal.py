"""Other ideal sheets, as maps of light's direction, on numpy arrays.

An ideal sheet has no thickness. Light leaves it where it has met it, in another direction. Each map takes directions
(..., 3) of any length and returns directions of the same length. x points right and y up, as the eye sees them, and z
points away from the eye. A direction with z < 0 is light, which runs towards the eye. A direction with z > 0 runs away
from the eye, as a camera's rays do. It gets the inverse map, because a reversed ray retraces its path: if light in the
direction d leaves in the direction e, then -e leaves in the direction -d. Light that does not pass the sheet has the
direction NaN.

Rotation about the normal is `rotation.rotate`. One sheet of Dove prisms, which mirrors light's transverse direction
about any line in the sheet, is `rotation.mirror`; it is its own inverse. Both let light pass in every direction.
`apparent_position` takes all maps.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.rotation import Complexes

Directions = NDArray[np.float64]

_quiet = np.errstate(divide="ignore", invalid="ignore")  # light that does not pass is NaN, and complex NaN would warn


def rotate_about(direction: ArrayLike, axis: ArrayLike, alpha: float) -> Directions:
    """Return the directions (..., 3) behind a sheet that rotates light by alpha (radians) about an axis.

    The axis (3,) has any direction and length (Hamilton, Sundar and Courtial, ref. 21 of the paper). alpha is positive
    if the rotation is counter-clockwise for somebody who looks along the axis: for the axis (0, 0, 1) it is that of
    `rotation.rotate`. The new direction is d cos(alpha) + (a x d) sin(alpha) + a (a.d) (1 - cos(alpha)), with the unit
    vector a (Rodrigues' formula). Light passes if the rotation leaves the sign of z as it is. Raises ValueError for the
    axis (0, 0, 0).
    """
    d, a = np.asarray(direction, float), np.asarray(axis, float)
    if not a.any():
        raise ValueError("axis = (0, 0, 0); allowed: any other")
    a = a / np.abs(a).max()  # so that no square becomes 0 or overflows
    a = a / np.linalg.norm(a)
    c = np.cos(alpha)
    s = np.where(d[..., 2:] > 0, -1, 1) * np.sin(alpha)
    turned = d * c + np.cross(a, d) * s + a * ((d @ a)[..., None] * (1 - c))
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
def apparent_position(
    sheet: Callable[[Directions], Directions], L: ArrayLike, E: ArrayLike, z1: ArrayLike, z2: float
) -> Complexes:
    """Return where light from L to E crosses an ideal sheet. `sheet` is its map of directions.

    L and E are complex, z1 >= 0 and z2 > 0 are the distances of the object behind and of the eye in front of the sheet,
    all in one unit. L, E and z1 broadcast. Example: apparent_position(lambda d: refract(d, 1.5), 0.6, 0, 2, 6).

    The result solves L = P + z1 s', where the camera's ray from E to P has the slope s' behind the sheet: Newton's
    method, from the ray along the normal, with shorter steps where a step would lead beyond the range where light
    passes. For maps that are linear in the slope (`scale_slope`, `rotation.rotate`, `rotation.mirror`) the first step
    is exact. Light that is refracted by a ratio with an argument of more than 90 degrees, or rotated about an axis that
    is not the normal, can reach the eye on several paths; the result is one of them. NaN means that none was found.
    """
    L, E, z1 = np.broadcast_arrays(np.asarray(L, complex), np.asarray(E, complex), np.asarray(z1, float))

    def missed(s: Complexes) -> Complexes:
        """By how much camera rays with the slope s miss L; NaN where they do not pass."""
        d = sheet(np.stack((s.real, s.imag, np.ones(s.shape)), axis=-1))
        slope = d[..., :2] / d[..., 2:]
        return E + z2 * s + z1 * (slope[..., 0] + 1j * slope[..., 1]) - L

    size = 1 + np.abs(L - E) + z1 + z2
    s = np.zeros(L.shape, complex)
    for _ in range(60):
        off = missed(s)
        if not (np.abs(off) > 1e-13 * size).any():
            break
        # the derivatives a, b of `missed` = a ds + b conj(ds), from differences
        right, up = (missed(s + 1e-7 * step) - missed(s - 1e-7 * step) for step in (1, 1j))
        a, b = (right - 1j * up) / 4e-7, (right + 1j * up) / 4e-7
        step = -(a.conj() * off - b * off.conj()) / (np.abs(a) ** 2 - np.abs(b) ** 2)
        for _ in range(30):
            worse = ~(np.abs(missed(s + step)) <= np.abs(off))
            step = np.where(worse, step / 2, step)
            if not worse.any():
                break
        s = np.where(np.isfinite(step), s + step, s)
    return np.where(np.abs(missed(s)) < 1e-9 * size, E + z2 * s, np.nan)[()]


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
