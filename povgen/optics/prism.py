"""Dove prisms and the sheets made of them (section 2 of the paper). Lengths in any one unit, angles in degrees.

The paper states neither the base angle nor the refractive index; these are the usual ones.
"""

from math import asin, cos, radians, sin, tan

INDEX = 1.5  # refractive index n
BASE_ANGLE = 45.0  # between the base and the slanted facets, degrees
AIR_GAP = 0.01  # air between neighbouring prisms, and between the two sheets, in units of the pitch


def aspect() -> float:
    """Length over height of a prism at full aperture: 1 + cot(base angle - refraction angle), 4.30.

    A ray along the prism that enters at the top of the slanted facet then just reaches the far end of the base.
    """
    return 1 + 1 / tan(_slope())


def slab_shift() -> float:
    """How much nearer the prism's glass brings what is seen through it, along its length, over its height: 1.00.

    As a slab of glass does: the path along z in the glass, times 1 - 1/n for a slab that light crosses at right angles.
    """
    return (1 - 1 / (INDEX * cos(_slope()))) / tan(_slope())


def _slope() -> float:
    """Angle, radians, between the base and a ray in the glass that runs along the prism outside."""
    return radians(BASE_ANGLE) - asin(sin(radians(BASE_ANGLE)) / INDEX)


def thickness(pitch: float, sheets: int) -> float:
    """How deep one sheet or two parallel sheets of prisms are, along their normal, for a given pitch."""
    gap = AIR_GAP * pitch
    return sheets * (pitch - gap) * aspect() + (sheets - 1) * gap
