"""What sheets of glass share: they consist of equal prisms or lenses of a finite size."""

from functools import cached_property
from typing import ClassVar

from povgen.optics import faces, paraxial, trace
from povgen.optics.paraxial import Matrix
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile
from povgen.sheets.sheet import Sheet


class Layered(Sheet):
    """One sheet with ridges along x, or a pair, whose sheet near the eye is turned by alpha/2 about the normal."""

    counted: ClassVar[str]  # the parameter that says how many prisms or lenses there are across the window

    @property
    def pitch(self) -> float:
        """The distance from one prism or lens to the next, tiles."""
        return self.aperture / float(self.values[self.counted])

    @property
    def shape(self) -> Prism | Profile:
        """The cross-section. Lengths are in tiles. Raises ValueError if there is no such shape."""
        raise NotImplementedError

    @property
    def depth(self) -> float:
        return self.shape.thickness(self.layers)

    @cached_property
    def transfer(self) -> Matrix:
        return paraxial.transfer(self.glass)

    @property
    def glass(self) -> tuple[faces.GlassSheet, ...]:
        if self.layers == 1:
            return (faces.GlassSheet(0.0, 0.0, self.shape),)
        return trace.pair(self.alpha, self.shape)
