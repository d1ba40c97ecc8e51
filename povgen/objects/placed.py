"""What stands in a scene has a name, a place and turns."""

from typing import Annotated

import numpy as np
from pydantic import Field

from povgen.optics.pose import Floats, Pose
from povgen.validation import Model

_LINE = [0, 1, 3, 2, 0, 4, 5, 1, 5, 7, 3, 7, 6, 2, 6, 4]  # corners of a box: the bits say which end along x, y and z
Extent = tuple[tuple[float, float, float], tuple[float, float, float]]
Coordinate = Annotated[float, Field(ge=-10_000, le=10_000)]
Turn = Annotated[float, Field(ge=-3600, le=3600)]
Length = Annotated[float, Field(ge=0.01, le=1000)]


class Placed(Model):
    """A name, a place in tiles, and three turns in degrees (`optics.pose`): roll first, then pitch, then yaw."""

    name: Annotated[str, Field(pattern="^([A-Za-z][A-Za-z0-9_]{0,30})?$")] = Field(
        default="", description="its name, a letter and then letters, digits or _; by default its kind and a number"
    )
    x: Coordinate = Field(default=0, description="x of its place, to the right, -10000 to 10000 tiles")
    y: Coordinate = Field(default=0, description="y of its place, upwards, -10000 to 10000 tiles")
    z: Coordinate = Field(default=0, description="z of its place, away from the eye, -10000 to 10000 tiles")
    yaw: Turn = Field(default=0, description="turn about y, z towards x, after pitch, degrees")
    pitch: Turn = Field(default=0, description="turn about x, y towards z: the top away from the eye, degrees")
    roll: Turn = Field(default=0, description="turn about z, x towards y: counter-clockwise for the eye, degrees")

    @property
    def pose(self) -> Pose:
        """The place and the turns."""
        return Pose(self.x, self.y, self.z, self.yaw, self.pitch, self.roll)

    @property
    def box(self) -> Extent:
        """The room that it takes: the lower and the upper corner of a box, in its own coordinates."""
        raise NotImplementedError

    @property
    def edges(self) -> Floats:
        """A line along all edges of the box, in the scene: its corners, (16, 3)."""
        lower, upper = np.array(self.box)
        own = np.array([np.where([n & 1, n & 2, n & 4], upper, lower) for n in _LINE])
        return np.asarray(own @ self.pose.axes + self.pose.place)
