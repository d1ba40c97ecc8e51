"""Reflection losses and polarisation of light on the designed path, on numpy arrays.

By default, the ray trace and the pictures leave both out: a surface refracts all light or reflects all light. Here
every face follows the Fresnel equations (Born and Wolf, Principles of Optics, section 1.5). Light that is reflected at
a slanted facet is lost. So the results are for light that has met no face but the designed three of each sheet.

Directions (..., 3) are (dx, dy, dz): x right, y up, z away from the eye. s is the polarisation perpendicular to the
plane of incidence, p the one within it. Phases are those of waves exp(-i omega t). Jones vectors are amplitudes along
two axes: the first is the x axis, projected onto the plane of the wave, and the second is perpendicular to it, upwards.
For light along z they are x and y as the eye sees them. The square of an amplitude is a power.
"""

from collections.abc import Sequence
from math import cos, radians, sin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.equations import Complexes, Floats
from povgen.optics.prism import Prism

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


@np.errstate(invalid="ignore")  # a complex NaN would warn
def mean_transmission(direction: ArrayLike, angles: Sequence[float], prism: Prism) -> Floats:
    """Return the share of light that passes the designed path if it is unpolarised again after every face.

    This is what POV-Ray computes. Directions (..., 3) and `angles` are as for `jones`. In each sheet light meets both
    facets at the same angle, and leaves with the component of its direction across the ridges reversed. The share is
    NaN where `jones` is.
    """
    k = np.asarray(direction, float)
    k = k / np.linalg.norm(k, axis=-1, keepdims=True)
    slant, passes = radians(prism.base_angle), np.ones(k.shape[:-1])
    for angle in angles:
        across = np.array([-sin(angle), cos(angle), 0])
        r_s, r_p = reflection(1, prism.index, sin(slant) * np.abs(k[..., 2]) - cos(slant) * (k @ across))
        passes = passes * (1 - (np.abs(r_s) ** 2 + np.abs(r_p) ** 2) / 2) ** 2
        k = k - 2 * (k @ across)[..., None] * across
    return np.where(np.isfinite(jones(direction, angles, prism)).all((-1, -2)), passes, np.nan)[()]


@np.errstate(invalid="ignore")  # a complex NaN would warn
def jones(direction: ArrayLike, angles: Sequence[float], prism: Prism) -> Complexes:
    """Return the Jones matrices (..., 2, 2) of the designed path through sheets, for light in directions (..., 3).

    `angles` are those between the sheets' ridges and the x axis, radians, in the order in which light meets the sheets:
    (0, alpha/2) for light that runs towards the eye through the two sheets of alpha. A matrix is NaN if light does not
    enter or leave by the slanted facets, or if the base does not reflect it totally. The common phase of the path in
    glass is left out.
    """
    k = np.asarray(direction, float)
    k = k / np.linalg.norm(k, axis=-1, keepdims=True)
    field = axes(k).astype(complex)  # (..., 3, 2): the field of each of the two input polarisations
    c, s = cos(radians(prism.base_angle)), sin(radians(prism.base_angle))
    n = prism.index
    forward = np.where(k[..., 2:] > 0, 1, -1)
    for angle in angles:
        turn = np.array([[cos(angle), sin(angle), 0], [-sin(angle), cos(angle), 0], [0, 0, 1]])
        k, field = k @ turn.T, turn @ field
        along = np.concatenate((0 * forward, c + 0 * forward, s * forward), axis=-1)  # normal of the facet of the exit
        k, field = _face(k, field, along * [1, -1, 1], 1, n)
        k, field = _face(k, field, np.array([0, -1.0, 0]), n, 1, total=True)
        k, field = _face(k, field, along, n, 1)
        k, field = k @ turn, turn.T @ field
    return np.swapaxes(axes(k), -1, -2) @ field


def transmission(jones: ArrayLike, angle: ArrayLike | None = None) -> Floats:
    """Return the share of the power that passes: for unpolarised light, or linearly polarised at an angle to x.

    `jones` are Jones matrices (..., 2, 2). The angle is in radians, counter-clockwise as the eye sees it. It
    broadcasts with the matrices' first axes.
    """
    if angle is None:
        return (np.abs(jones) ** 2).sum((-1, -2)) / 2
    before = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    return (np.abs(np.asarray(jones) @ before[..., None]) ** 2).sum((-1, -2))


def retardance(prism: Prism) -> float:
    """Return by how much p is ahead of s behind the base, radians, for light along z: `reflection` has the formula."""
    J = jones([0.0, 0.0, -1.0], [0.0], prism)
    return float(np.angle(J[0, 0] / J[1, 1]))


def _face(
    k: Vectors, field: Complexes, normal: Vectors, n1: float, n2: float, total: bool = False
) -> tuple[Vectors, Complexes]:
    """Return unit directions and fields behind a face that refracts, or that reflects totally.

    The normal is on the side of the face to which light runs before it is bent. The result is NaN for light that runs
    to the other side. With `total` it is also NaN for light that is not reflected totally, otherwise for light that is.
    """
    cosine = (k * normal).sum(-1, keepdims=True)
    s = np.cross(k, normal)
    size = np.linalg.norm(s, axis=-1, keepdims=True)
    s = np.where(size > 1e-12, s / np.maximum(size, 1e-300), [1.0, 0, 0])  # along the normal, s is any direction
    square = 1 - (n1 / n2) ** 2 * (1 - cosine**2)
    if total:
        after = k - 2 * cosine * normal
    else:
        after = n1 / n2 * k + (np.sqrt(square) - n1 / n2 * cosine) * normal
    after = np.where((cosine > 0) & ((square < 0) == total), after, np.nan)
    amplitudes = reflection(n1, n2, np.clip(cosine, 0, 1))
    if not total:
        amplitudes = tuple(np.sqrt(np.maximum(1 - np.abs(r) ** 2, 0)) for r in amplitudes)
    out = np.zeros_like(field)
    for r, before, behind in zip(amplitudes, (s, np.cross(k, s)), (s, np.cross(after, s)), strict=True):
        out = out + (r * behind)[..., None] * (before[..., None] * field).sum(-2, keepdims=True)
    return after, out


def axes(k: Vectors) -> Vectors:
    """Return the axes of the Jones vectors, (..., 3, 2), of light with the unit directions k."""
    first = np.array([1.0, 0, 0]) - k * k[..., :1]
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack((first, np.cross(k, first) * np.where(k[..., 2:] > 0, 1, -1)), axis=-1)
