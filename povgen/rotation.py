"""The mathematics of ray rotation (sections 3 and 4 of the paper), on numpy arrays.

Angles are in radians. alpha > 0 turns the transverse direction of light that travels from the object to the
eye counter-clockwise, as the eye sees it. Points of the sheet's plane are complex numbers x + iy, x to the
right and y up for the eye. The object L is a distance z1 behind the sheet, the eye E a distance z2 before it,
and r = z2/z1 (eq. 3) runs from 0 to infinity.

At the pole, r exp(i alpha) = -1, no light from L reaches E: P and 1 - P are the complex infinity (inf + 0j) there.
"""

import numpy as np


def P(r, alpha):
    """Where light from L = 0 crosses the sheet on its way to E = 1: 1 / (1 + r exp(i alpha)), eq. 7.

    r and alpha broadcast against each other; returns a complex array of their shape.
    """
    r, alpha = np.broadcast_arrays(np.asarray(r, float), np.asarray(alpha, float))
    near = r <= 1
    # P(r, alpha) = 1 - P(1/r, -alpha): so the denominator's r is never above 1, and r = infinity has its limit
    with np.errstate(divide="ignore"):
        s = np.where(near, r, 1 / r)
    angle = np.where(near, alpha, -alpha)
    return _divide(np.where(near, 1, s * np.exp(1j * angle)), _denominator(s, angle))


def one_minus_P(r, alpha):
    """E - P for L = 0, E = 1: the apparent position of L as the eye sees it, to scale with E - L. Shapes as P."""
    with np.errstate(divide="ignore"):
        return P(np.divide(1, np.asarray(r, float)), -np.asarray(alpha, float))


def apparent_position(L, E, z1, z2, alpha):
    """Where light from L crosses the sheet on its way to E, both anywhere: E + (L - E) (1 - P), from eq. 7.

    Perspective with a complex depth. L and E are complex, z1 >= 0 and z2 > 0 in the unit of L and E; all broadcast.
    """
    with np.errstate(divide="ignore"):
        r = np.divide(z2, np.asarray(z1, float))
    return E + (np.asarray(L) - E) * one_minus_P(r, alpha)


def nu(r, alpha):
    """Angle, radians, through which an object appears turned about E: arg(1 - P). NaN at the pole.

    Erratum: eq. 8 prints arg(P), the angle at L; the text beside it, and every picture, say the angle at E.
    """
    image = one_minus_P(r, alpha)
    return np.where(np.isinf(image), np.nan, np.angle(image))


def M(r, alpha):
    """How much larger an object appears than it would in the plane of the sheet: |1 - P|. Infinite at the pole.

    Erratum: eq. 9 prints |P|, which would vanish, not become 1, for an object that touches the sheet.
    """
    return np.abs(one_minus_P(r, alpha))


def _denominator(r, alpha):
    """1 + r exp(i alpha) without cancellation near the pole, by way of d = alpha -+ pi."""
    d = alpha - np.copysign(np.pi, alpha)
    return (1 - r) - r * (2j * np.sin(d / 2) * np.exp(0.5j * d))


def _divide(a, b):
    pole = b == 0
    return np.where(pole, complex(np.inf, 0), a / np.where(pole, 1, b))
