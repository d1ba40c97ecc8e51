"""The camera: for each pixel of a picture, the position that it shows, and the ray from the eye to this position.

A position in the rectangle that the picture shows is a complex number x + iy, in tiles from the rectangle's middle,
along the picture's sides: x to the right and y up.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.rays import Bundle

Size = tuple[int, int]  # width and height, pixels
Vector = tuple[float, float, float]


class Camera(NamedTuple):
    """The eye, and the rectangle that the picture shows: middle, unit vectors along its sides, height in tiles."""

    eye: Vector
    middle: Vector
    right: Vector
    up: Vector
    height: float

    def pixels(self, size: Size) -> NDArray[np.complex128]:
        """Return the positions of the pixels' centres, (height, width)."""
        width, height = size
        pixels_per_tile = height / self.height
        x, y = np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5
        return np.asarray((x + 1j * y[:, None]) / pixels_per_tile, np.complex128)

    def rays(self, size: Size) -> Bundle:
        """Return a ray from the eye for each pixel: (height, width) rays. The first row is the top one."""
        return self.through(self.pixels(size))

    def through(self, position: ArrayLike) -> Bundle:
        """Return rays from the eye through positions in the rectangle's plane."""
        place = np.asarray(position)[..., None]
        return self.along(place.real * self.right + place.imag * self.up + np.subtract(self.middle, self.eye))

    def position(self, point: ArrayLike) -> NDArray[np.complex128]:
        """Return where the eye sees points (..., 3) without windows, NaN if they are not before it."""
        way, normal = np.subtract(point, self.eye), np.cross(self.right, self.up)
        ahead = np.subtract(self.middle, self.eye)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = ahead @ normal / (way @ normal)
            there = np.where((part > 0) & np.isfinite(part), part, np.nan)[..., None] * way - ahead
        return np.asarray(there @ self.right + 1j * (there @ self.up))

    def along(self, direction: ArrayLike) -> Bundle:
        """Return rays from the eye with these directions (..., 3) of any length."""
        return Bundle(self.eye, direction)
