"""The camera: for each pixel of a picture, the position that it shows, and the ray from the eye to this position.

A position is a complex number x + iy in the plane z = 0, in tiles from the first window's centre: x points right and y
up. z points away from the eye, which is at z = -z2.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.rays import Bundle
from povgen.scene.model import EyeAndWindows

Size = tuple[int, int]  # width and height, pixels


def pixels(scene: EyeAndWindows, size: Size) -> NDArray[np.complex128]:
    """Return the positions of the pixels' centres, (height, width)."""
    width, height = size
    pixels_per_tile = height / scene.view
    x, y = np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5
    return np.asarray((x + 1j * y[:, None]) / pixels_per_tile, np.complex128)


def bundle(scene: EyeAndWindows, size: Size) -> Bundle:
    """Return a ray from the eye for each pixel: (height, width) rays. The first row is the top one."""
    return through(scene, pixels(scene, size))


def through(scene: EyeAndWindows, position: ArrayLike) -> Bundle:
    """Return rays from the eye through positions in the plane z = 0."""
    offset = np.asarray(position) - scene.E
    return along(scene, np.stack((offset.real, offset.imag, np.full(offset.shape, float(scene.z2))), -1))


def along(scene: EyeAndWindows, direction: ArrayLike) -> Bundle:
    """Return rays from the eye with these directions (..., 3): x, y, z of any length, z > 0 away from the eye."""
    return Bundle(np.array([scene.E.real, scene.E.imag, -scene.z2]), np.asarray(direction))


def rays(scene: EyeAndWindows, size: Size) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Return which pixels show the window, (height, width), and the unit directions of these pixels' rays, (n, 3).

    A pixel shows the window if its ray passes the frame's opening in two planes: at the frame's front, and at z = 0.
    """
    position = pixels(scene, size)
    front = scene.E + (position - scene.E) * (1 - scene.depth / 2 / scene.z2)
    half = scene.aperture / 2
    inside = (_reach(position) < half) & (_reach(front) < half)
    return inside, bundle(scene, size).direction[inside]


def window(scene: EyeAndWindows, size: Size) -> tuple[slice, slice]:
    """Return the rows and the columns of the pixels that show the window. Raises IndexError if there are none."""
    inside, _ = rays(scene, size)
    y, x = np.argwhere(inside)[[0, -1]].T
    return slice(y[0], y[1] + 1), slice(x[0], x[1] + 1)


def _reach(position: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the larger of |x| and |y|."""
    return np.asarray(np.maximum(abs(position.real), abs(position.imag)))
