"""Dove prisms and the sheets made of them (section 2 of the paper). Lengths are in any one unit, angles in degrees.

The paper states neither the base angle nor the refractive index. povgen's defaults are the usual values.
"""

from dataclasses import dataclass, replace
from math import asin, cos, inf, radians, tan

MOST_DEVIATION = 4  # standard deviations: no single facet's angle and no single prism's height differs by more


@dataclass(frozen=True)
class Prism:
    """The shape of each prism in a sheet. The light runs along z, and the ridges lie along x.

    At full aperture (aspect = 1) a ray along z that enters at the top of the slanted facet just reaches the far end of
    the base, and every ray along z takes the designed path. A ray along z that enters at the height u leaves at the
    height aspect * `height` - u.
    """

    pitch: float  # from one prism to the next; a pitch of 0 is the limit of infinitely small prisms
    index: float = 1.5  # refractive index n, above 1
    base_angle: float = 45.0  # between the base and the slanted facets, degrees; below 90
    gap: float = 0.01  # air between neighbouring prisms, and between two sheets, in units of the pitch
    aspect: float = 1.0  # length, in units of the length at full aperture
    black: bool = False  # whether its top absorbs light

    def __post_init__(self) -> None:
        """Raise ValueError for a number outside its range. NaN is outside."""
        for name, allowed, inside in (
            ("pitch", "0 or more", 0 <= self.pitch < inf),
            ("index", "above 1", 1 < self.index < inf),
            ("base_angle", "above 0 and below 90", 0 < self.base_angle < 90),
            ("gap", "0 or more, and below 1", 0 <= self.gap < 1),
            ("aspect", "above 0", 0 < self.aspect < inf),
        ):
            if not inside:
                raise ValueError(f"{name} = {getattr(self, name):g}; allowed: {allowed}")

    @property
    def height(self) -> float:
        """From the base to the top."""
        return self.pitch * (1 - self.gap)

    @property
    def length(self) -> float:
        """Extent along z, at the base."""
        return self.height * self.aspect * self.full_aperture

    @property
    def top_length(self) -> float:
        """Extent along z, at the top."""
        return self.length - 2 * self.height / tan(radians(self.base_angle))

    @property
    def full_aperture(self) -> float:
        """Length divided by height at full aperture, cot(base angle) + cot(`_slope`): 4.30 for the defaults."""
        return 1 / tan(radians(self.base_angle)) + 1 / tan(self._slope)

    @property
    def least_aspect(self) -> float:
        """The aspect at which the slanted facets meet in a ridge: a shorter prism has no top."""
        return 2 / tan(radians(self.base_angle)) / self.full_aperture

    @property
    def slab_shift(self) -> float:
        """How much nearer a sheet makes objects appear, for the component of light's slope along the ridges.

        For this component a prism acts as a slab of glass. The shift is the path's extent along z in the glass, times
        1 - 1/(n cos(`_slope`)). This product depends on the base angle, but not on the index (docs/sheets.md).
        """
        return self.height * self.aspect * tan(radians(self.base_angle))

    @property
    def reach(self) -> float:
        """The farthest that light on the designed path is displaced across the ridges."""
        return self.height * max(0, min(self.aspect, 2 - self.aspect))

    @property
    def separation(self) -> float:
        """Distance between the middle planes of two parallel sheets: the air between the sheets is as wide as a gap."""
        return self.length + self.gap * self.pitch

    def with_length_kept(self, *, index: float | None = None, base_angle: float | None = None) -> "Prism":
        """Return a prism of the same length with another index or base angle. Its aspect is found."""
        other = replace(self, index=index or self.index, base_angle=base_angle or self.base_angle)
        return replace(other, aspect=self.aspect * (self.full_aperture / other.full_aperture))

    def thickness(self, sheets: int) -> float:
        """Extent along z of one sheet, or of two parallel sheets and the air between them."""
        return self.length + (sheets - 1) * self.separation

    @property
    def _slope(self) -> float:
        """Angle, radians, between the base and a ray in the glass that runs along z outside the prism.

        The ray's angle of incidence on the slanted facet is 90 degrees - base angle. Refraction turns the ray away from
        z by the angle of incidence minus the angle of refraction.
        """
        incidence = radians(90 - self.base_angle)
        return incidence - asin(cos(radians(self.base_angle)) / self.index)
