"""The camera: which position each pixel of a picture shows, and which ray it follows.

A position is a complex number x + iy: tiles in the plane z = 0, x to the right, y up.
"""

import numpy as np
from numpy.typing import NDArray

from povgen.scene.models import Scene

Size = tuple[int, int]  # width and height, pixels


def pixels(scene: Scene, size: Size) -> NDArray[np.complex128]:
    """Return the positions of the pixels' centres, (height, width)."""
    width, height = size
    pixels_per_tile = height / scene.view
    x, y = np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5
    return np.asarray((x + 1j * y[:, None]) / pixels_per_tile, np.complex128)


def rays(scene: Scene, size: Size) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Return which pixels show the window, (height, width), and the unit directions of these pixels' rays, (n, 3).

    A pixel whose ray meets the window frame in front of the sheets does not show the window.
    """
    position = pixels(scene, size)
    front = scene.E + (position - scene.E) * (1 - scene.depth / 2 / scene.z2)
    half = scene.aperture / 2
    inside = (_reach(position) < half) & (_reach(front) < half)
    offset = position[inside] - scene.E
    direction = np.column_stack((offset.real, offset.imag, np.full(len(offset), float(scene.z2))))
    return inside, direction / np.linalg.norm(direction, axis=1, keepdims=True)


def window(scene: Scene, size: Size) -> tuple[slice, slice]:
    """Return the rows and the columns of the pixels that show the window."""
    inside, _ = rays(scene, size)
    y, x = np.argwhere(inside)[[0, -1]].T
    return slice(y[0], y[1] + 1), slice(x[0], x[1] + 1)


def _reach(position: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the larger of |x| and |y|."""
    return np.asarray(np.maximum(abs(position.real), abs(position.imag)))
