"""What measurements share: a measured value with its bound, picture sizes, and units."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from povgen.measure import probes

HD = (1280, 960)  # errors of position are given in pixels of this size
SMALL = (640, 480)


@dataclass(frozen=True)
class Measured:
    """A measured value and its bound: the least allowed value if `least`, otherwise the greatest."""

    sheet: str
    what: str
    value: float
    bound: float
    unit: str = ""
    least: bool = False

    @property
    def holds(self) -> bool:
        """Return whether the value is within its bound. NaN is not."""
        return bool(self.value >= self.bound if self.least else self.value <= self.bound)


def rms(values: ArrayLike) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def px(tiles: float, view: float = probes.VIEW) -> float:
    """Convert a length in the plane z = 0 from tiles to pixels of a picture of 1280x960 that is `view` tiles high."""
    return float(tiles * HD[1] / view)
