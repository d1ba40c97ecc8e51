"""The outline of a window: a rectangle or an ellipse, in the window's own coordinates. All lengths are in one unit."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]


class Outline(NamedTuple):
    """A rectangle with these sides along x and y, or the ellipse in it."""

    width: float
    height: float
    is_round: bool = False

    def excludes(self, x: Floats, y: Floats) -> Booleans:
        """Return which points of the window's plane are outside. x and y are (n,)."""
        if self.is_round:
            return np.asarray(np.hypot(x / self.width, y / self.height) > 0.5)
        return np.asarray((abs(x) > self.width / 2) | (abs(y) > self.height / 2))

    def passage(self, position: Floats, direction: Floats, depth: float) -> tuple[Floats, Floats]:
        """Return how far along rays (n, 3) the space within the outline, of this extent along z, begins and ends.

        The ray does not meet this space if the first number is greater, or NaN.
        """
        half = np.array([self.width, self.height, depth]) / 2
        ends = (half - position) / direction, (-half - position) / direction
        begins, last = np.minimum(*ends), np.maximum(*ends)
        if self.is_round:
            p, d = position[:, :2] / half[:2], direction[:, :2] / half[:2]
            a, b, c = (d * d).sum(1), (p * d).sum(1), (p * p).sum(1) - 1
            root = np.sqrt(b * b - a * c)  # NaN: the ray passes by
            near, far = (-b - root) / a, (-b + root) / a
            along = a < 1e-30  # parallel to z
            near, far = np.where(along, np.where(c <= 0, -np.inf, np.nan), near), np.where(along, np.inf, far)
            return np.maximum(begins[:, 2], near), np.minimum(last[:, 2], far)
        return np.fmax.reduce(begins, 1), np.fmin.reduce(last, 1)
