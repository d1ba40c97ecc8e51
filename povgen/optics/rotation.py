"""The mathematics of ray rotation (sections 2 to 4 of the paper), on numpy arrays that broadcast.

Angles are in radians. alpha > 0 turns the transverse direction of light that travels from the object to the
eye counter-clockwise, as the eye sees it. Points of the sheet's plane are complex numbers x + iy, x to the
right and y up for the eye; z points away from the eye. The object L is a distance z1 behind the sheet, the eye E
a distance z2 before it, P is where the light from L to E crosses the sheet; r = z2/z1 runs from 0 to infinity.
Equations 5 to 9 are for L = 0, E = 1.

At the pole, r exp(i alpha) = -1, no light from L reaches E: P and 1 - P are the complex infinity (inf + 0j) there.
As no number is pi, the one next to it counts as pi for r = 1. Near the pole nothing cancels; what errors of r and alpha
do there is told by `condition`.

alpha, r and distances are real: complex ones raise TypeError, negative r and distances ValueError. NaN gives NaN.
"""

import numpy as np


def p1(z1, theta):
    """Length of the ray's projection between L and P, for a ray at an angle theta to the sheet's normal: eq. 1."""
    return np.multiply(z1, np.tan(theta))


def p2(z2, theta):
    """Length of the ray's projection between P and E: eq. 2, for the sheet leaves theta as it is."""
    return np.multiply(z2, np.tan(theta))


def r(z1, z2):
    """The ratio of distances z2/z1 = p2/p1, eq. 3; infinite for z1 = 0, NaN if z2 = 0 as well."""
    z1, z2 = _real("z1", z1, 0), _real("z2", z2, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.divide(z2, z1)


def r_from_P(P, L=0, E=1):
    """The r for which light from L crosses the sheet at P on its way to E: |E - P|/|P - L|, eq. 4; 1 for P infinite."""
    infinite = np.isinf(P)
    P = np.where(infinite, 0, P)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(infinite, 1, np.divide(np.abs(np.subtract(E, P)), np.abs(np.subtract(P, L))))[()]


def E_minus_P(P, r, alpha):
    """The projection of the ray from P to E: r exp(i alpha) P, eq. 5; for P and r both finite."""
    return np.multiply(_real("r", r, 0), np.exp(1j * _real("alpha", alpha)) * P)


def E_from_P(P, r, alpha):
    """Where the ray that crosses the sheet at P meets the eye's plane: P (1 + r exp(i alpha)), eq. 6; P, r finite."""
    return P * _sum(1.0, _real("r", r, 0), _real("alpha", alpha))


def P(r, alpha):
    """Where light from L = 0 crosses the sheet on its way to E = 1: 1/(1 + r exp(i alpha)), eq. 7."""
    r, alpha, touching = _checked(r, alpha)
    return np.where(touching, 0, _divide(1, _sum(1.0, np.where(touching, 1, r), alpha)))[()]


def one_minus_P(r, alpha):
    """E - P for L = 0, E = 1: the apparent position of L as the eye sees it, to scale with E - L."""
    r, alpha, touching = _checked(r, alpha)
    finite = np.where(touching, 1, r)
    return np.where(touching, 1, _divide(finite, _sum(finite, 1.0, -alpha)))[()]


def nu(r, alpha):
    """Angle, radians, through which an object appears turned about E: arg(1 - P), eq. 8 corrected. NaN at the pole.

    Erratum: eq. 8 prints arg(P), the angle at L; the text beside it, and every picture, say the angle at E.
    """
    r, alpha, touching = _checked(r, alpha)
    inverse = _sum(np.where(touching, 1, r), np.where(touching, 0, 1.0), -alpha)  # 1/(1 - P) to scale
    return np.where(inverse == 0, np.nan, -np.angle(inverse))[()]


def M(r, alpha):
    """How much larger an object appears than in the plane of the sheet: |1 - P|, eq. 9 corrected. Infinite at the pole.

    Erratum: eq. 9 prints |P|, which would vanish, not become 1, for an object that touches the sheet.
    """
    return np.abs(one_minus_P(r, alpha))


def condition(r, alpha):
    """Condition number of P: its relative error over that of r exp(i alpha), which is |1 - P|; of 1 - P it is |P|.

    An error of 1e-16 in alpha, radians, or in r, relative, makes one of 1e-16 times this in P.
    """
    return M(r, alpha)


def apparent_position(L, E, z1, z2, alpha):
    """Where light from L crosses the sheet on its way to E, both anywhere: E + (L - E) (1 - P), from eq. 7.

    Perspective with a complex depth. L and E are complex, z1 >= 0 and z2 > 0, both finite, in their unit. At the pole
    the complex infinity, but for L = E, which is seen in every direction there: NaN.
    """
    z1, z2, alpha = _real("z1", z1, 0), _real("z2", z2, 0), _real("alpha", alpha)
    return np.asarray(E) + _divide(np.subtract(L, E) * z2, _sum(z2, z1, -alpha))


def object_position(P, E, z1, z2, alpha):
    """Where to put an object, a distance z1 behind the sheet, to see it at P: L of `apparent_position`.

    P and E are complex, z1 >= 0 and z2 > 0, both finite, in their unit. At the pole it is E, wherever P is.
    """
    z1, z2, alpha = _real("z1", z1, 0), _real("z2", z2, 0), _real("alpha", alpha)
    depth = _sum(z2, z1, -alpha)
    return np.asarray(E) + np.subtract(P, E) * depth / z2


def rotate(direction, alpha):
    """Directions (..., 3) of light after a sheet that rotates it by alpha: transverse part times exp(i alpha).

    Light towards the eye, of negative z, turns by alpha; light that runs the other way, as a camera's rays do, by
    -alpha: a reversed ray retraces itself. Raises ValueError for light along the sheet, z = 0, which does not cross it.
    """
    direction = _real("direction", direction)
    if (direction[..., 2] == 0).any():
        raise ValueError("direction: z = 0, along the sheet; allowed: any other z")
    sense = np.where(direction[..., 2] > 0, -1, 1)
    return _with_transverse(direction, _transverse(direction) * np.exp(1j * sense * _real("alpha", alpha)))


def mirror(direction, angle):
    """Directions (..., 3) of light after a sheet of infinitely fine Dove prisms that lie at an angle to the x axis.

    The transverse part is mirrored about the prisms: d becomes exp(2i angle) conj(d).
    """
    direction = _real("direction", direction)
    return _with_transverse(direction, np.exp(2j * _real("angle", angle)) * _transverse(direction).conj())


def _real(name, values, least=-np.inf):
    """Values as floats; raises TypeError if they are complex, ValueError if one is below `least`."""
    values = np.asarray(values)
    if np.iscomplexobj(values):
        raise TypeError(f"{name} is complex; allowed: real numbers")
    values = values.astype(float)
    if (values < least).any():
        raise ValueError(f"{name} = {np.nanmin(values):g}; allowed: {least:g} or more")
    return values


def _checked(r, alpha):
    """r and alpha as floats, and where the object touches the sheet, whatever the angle: r infinite, alpha not NaN."""
    r, alpha = _real("r", r, 0), _real("alpha", alpha)
    return r, alpha, np.isinf(r) & ~np.isnan(alpha)


def _transverse(direction):
    return direction[..., 0] + 1j * direction[..., 1]


def _with_transverse(direction, transverse):
    transverse, z = np.broadcast_arrays(transverse, direction[..., 2])
    return np.stack((transverse.real, transverse.imag, z), axis=-1)


def _sum(a, b, alpha):
    """a + b exp(i alpha) for a, b >= 0 without cancellation: (a - b) + 2b cos(alpha/2) exp(i alpha/2)."""
    half = alpha / 2
    cosine = np.cos(half)
    at_pi = np.abs(cosine) <= np.spacing(np.abs(half)) / 2  # the number next to an odd multiple of pi
    cosine = np.where(at_pi & (a == b), 0, cosine)
    return (a - b) + b * (2 * cosine * np.exp(1j * half))


def _divide(a, b):
    """a/b, the complex infinity where b is 0 and a is not, NaN where both are."""
    pole = b == 0
    with np.errstate(invalid="ignore"):  # NaN by a complex NaN warns
        ratio = a / np.where(pole, 1, b)
    return np.where(pole, np.where(a == 0, np.nan, complex(np.inf, 0)), ratio)[()]
