"""Dove prisms and the sheets made of them (section 2 of the paper). Lengths are in any one unit, angles in degrees.

The paper states neither the base angle nor the refractive index. povgen uses the usual values.
"""

from math import asin, cos, radians, sin, tan

INDEX = 1.5  # refractive index n
BASE_ANGLE = 45.0  # between the base and the slanted facets, degrees
AIR_GAP = 0.01  # air between neighbouring prisms, and between the two sheets, in units of the pitch


def aspect() -> float:
    """Return a prism's length divided by its height: 1 + cot(base angle - refraction angle) = 4.30.

    With this length the full aperture is used: a ray along z that enters at the top of the slanted facet just reaches
    the far end of the base.
    """
    return 1 + 1 / tan(_slope())


def slab_shift() -> float:
    """Return how much nearer a prism makes objects appear, divided by its height: 1.00.

    This holds for the component of light's direction along the ridges, for which the prism acts as a slab of glass. The
    shift is the path's extent along z, times 1 - 1/(n cos(slope)). (For a slab at right angles to the light the factor
    is 1 - 1/n.)
    """
    return (1 - 1 / (INDEX * cos(_slope()))) / tan(_slope())


def _slope() -> float:
    """Return the angle, radians, between the base and a ray in the glass that runs along z outside the prism."""
    return radians(BASE_ANGLE) - asin(sin(radians(BASE_ANGLE)) / INDEX)


def thickness(pitch: float, sheets: int) -> float:
    """Return the extent along z of one sheet, or of two parallel sheets and the air between them."""
    gap = AIR_GAP * pitch
    return sheets * (pitch - gap) * aspect() + (sheets - 1) * gap
