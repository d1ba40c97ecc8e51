"""Where an object stands, and how it is turned.

The scene's coordinates are x right, y up and z away from the eye. An object has coordinates of its own. They are the
scene's if it is not turned. The three turns are about the object's middle, one after the other:

- roll, about z: it turns x towards y, which is counter-clockwise as the eye sees it;
- pitch, about x: it turns y towards z, so that the top goes away from the eye;
- yaw, about y: it turns z towards x, so that the right side comes to the eye.

Each is about the scene's axes.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Pose(NamedTuple):
    """A place, in tiles or any other unit, and three turns, in degrees."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0

    @property
    def place(self) -> Floats:
        """The middle of the object, (3,)."""
        return np.array(self[:3], float)

    @property
    @lru_cache(maxsize=256)  # noqa: B019  (a pose is a tuple of numbers)
    def axes(self) -> Floats:
        """The unit vectors along the object's own x, y and z: the rows of a matrix (3, 3). It cannot be changed."""
        angles = np.radians(self[3:])
        (cy, cp, cr), (sy, sp, sr) = np.cos(angles), np.sin(angles)
        yaw = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        pitch = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
        roll = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
        axes = (yaw @ pitch @ roll).T
        axes.setflags(write=False)
        return np.asarray(axes)

    def own(self, position: Floats, direction: Floats) -> tuple[Floats, Floats]:
        """Return positions and directions (n, 3) in the object's own coordinates."""
        # the other way round, (n, 3) @ (3, 3), numpy takes many times as long
        return (self.axes @ (position - self.place).T).T, (self.axes @ direction.T).T

    def scene(self, position: Floats, direction: Floats) -> tuple[Floats, Floats]:
        """Return positions and directions (n, 3), which are in the object's own coordinates, in the scene's."""
        return (self.axes.T @ position.T).T + self.place, (self.axes.T @ direction.T).T
