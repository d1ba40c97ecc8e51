"""Reflection losses and polarisation of light, on numpy arrays.

By default, the ray trace and the pictures leave both out: a surface refracts all light or reflects all light. Here
a face follows the Fresnel equations (Born and Wolf, Principles of Optics, section 1.5). `ray_path.jones` returns the
Jones matrices of traced rays.

Directions (..., 3) are (dx, dy, dz): x right, y up, z away from the eye. s is the polarisation perpendicular to the
plane of incidence, p the one within it. Phases are those of waves exp(-i omega t). Jones vectors are amplitudes along
two axes: the first is the x axis, projected onto the plane of the wave, and the second is perpendicular to it, upwards.
For light along z they are x and y as the eye sees them. The square of an amplitude is a power.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.equations import Complexes, Floats

Vectors = NDArray[np.float64]


def reflection(n1: ArrayLike, n2: ArrayLike, cosine: ArrayLike) -> tuple[Complexes, Complexes]:
    """Return the amplitudes r_s and r_p that are reflected on the way from the index n1 to n2: the Fresnel equations.

    `cosine` is that of the angle of incidence. At normal incidence r_p = -r_s. The share 1 - |r|^2 of the power passes.
    In total internal reflection |r| = 1, and p is ahead of s by the retardance d = arg(r_s/r_p). With the angle of
    incidence i, it obeys
    tan(d/2) = cos(i) sqrt(sin(i)^2 - (n2/n1)^2)/sin(i)^2.
    """
    cosine = np.asarray(cosine, complex)
    behind = np.sqrt(1 - np.divide(n1, n2) ** 2 * (1 - cosine**2))  # positive imaginary: the wave decays in the air
    r_s = (n1 * cosine - n2 * behind) / (n1 * cosine + n2 * behind)
    r_p = (n2 * cosine - n1 * behind) / (n2 * cosine + n1 * behind)
    return r_s, r_p


def transmission(jones: ArrayLike, angle: ArrayLike | None = None) -> Floats:
    """Return the share of the power that passes: for unpolarised light, or linearly polarised at an angle to x.

    `jones` are Jones matrices (..., 2, 2). The angle is in radians, counter-clockwise as the eye sees it. It
    broadcasts with the matrices' first axes.
    """
    if angle is None:
        return (np.abs(jones) ** 2).sum((-1, -2)) / 2
    before = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    return (np.abs(np.asarray(jones) @ before[..., None]) ** 2).sum((-1, -2))


def axes(k: Vectors) -> Vectors:
    """Return the axes of the Jones vectors, (..., 3, 2), of light with the unit directions k."""
    first = np.array([1.0, 0, 0]) - k * k[..., :1]
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack((first, np.cross(k, first) * np.where(k[..., 2:] > 0, 1, -1)), axis=-1)
