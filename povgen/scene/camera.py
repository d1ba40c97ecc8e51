"""The pixels of a picture that show the window, and the eye's rays to them."""

import numpy as np
from numpy.typing import NDArray

from povgen.optics.camera import Size
from povgen.scene.presets import AxialScene


def rays(scene: AxialScene, size: Size) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Return which pixels show the window, (height, width), and the unit directions of these pixels' rays, (n, 3).

    A pixel shows the window if its ray passes the frame's opening in two planes: at the frame's front, and at z = 0.
    """
    position = scene.middle + scene.camera.pixels(size)
    front = scene.E + (position - scene.E) * (1 - scene.depth / 2 / scene.z2)
    half = scene.aperture / 2
    inside = (_reach(position) < half) & (_reach(front) < half)
    return inside, scene.camera.rays(size).direction[inside]


def window(scene: AxialScene, size: Size) -> tuple[slice, slice]:
    """Return the rows and the columns of the pixels that show the window. Raises IndexError if there are none."""
    inside, _ = rays(scene, size)
    y, x = np.argwhere(inside)[[0, -1]].T
    return slice(y[0], y[1] + 1), slice(x[0], x[1] + 1)


def _reach(position: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the larger of |x| and |y|."""
    return np.asarray(np.maximum(abs(position.real), abs(position.imag)))
