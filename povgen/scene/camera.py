"""The camera: for each pixel of a picture, the position that it shows, and the ray from the eye to this position.

A position in the rectangle that the picture shows is a complex number x + iy, in tiles from the rectangle's middle,
along the picture's sides: x to the right and y up.
"""

from typing import Any, NamedTuple

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


def rays(
    scene: Any,  # noqa: ANN401  (an `EyeAndWindows`, whose module imports this one)
    size: Size,
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Return which pixels show the window, (height, width), and the unit directions of these pixels' rays, (n, 3).

    A pixel shows the window if its ray passes the frame's opening in two planes: at the frame's front, and at z = 0.
    """
    position = scene.middle + scene.camera.pixels(size)
    front = scene.E + (position - scene.E) * (1 - scene.depth / 2 / scene.z2)
    half = scene.aperture / 2
    inside = (_reach(position) < half) & (_reach(front) < half)
    return inside, scene.camera.rays(size).direction[inside]


def window(scene: Any, size: Size) -> tuple[slice, slice]:  # noqa: ANN401  (as for `rays`)
    """Return the rows and the columns of the pixels that show the window. Raises IndexError if there are none."""
    inside, _ = rays(scene, size)
    y, x = np.argwhere(inside)[[0, -1]].T
    return slice(y[0], y[1] + 1), slice(x[0], x[1] + 1)


def _reach(position: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the larger of |x| and |y|."""
    return np.asarray(np.maximum(abs(position.real), abs(position.imag)))
