"""A polariser behind the windows and an analyser before them: which part of each pixel's light they and the glass pass.

The light's field follows from the Jones matrix of the pixel's ray, by `optics.ray_path`: Fresnel's equations at each
face that the ray meets. Light of the objects is unpolarised. Both polarisers are ideal, and fill the windows' openings.
"""

from math import cos, radians, sin

import numpy as np

from povgen.optics.equations import Floats
from povgen.optics.rays import Bundle
from povgen.optics.trace import End
from povgen.scene.eye_and_windows import EyeAndWindows
from povgen.scene.scene import Scene

PLACES = 10  # rays in each pixel: n * n + 1 (docs/light.md says what is left)
AT_ONCE = 40_000  # rays that are traced at once


def passed(scene: Scene, size: tuple[int, int]) -> Floats:
    """Return the part of the light that passes on the way to each pixel of a picture of this size, (height, width).

    Without glass it is 1/2 for parallel polarisers, or for one alone. A ray that the windows turn back to the eye's
    side passes the analyser twice. What is seen beside the windows passes neither of the polarisers.
    """
    assert isinstance(scene, EyeAndWindows)
    rays = scene.rays(size)
    position, direction = rays.position.reshape(-1, 3), rays.direction.reshape(-1, 3)
    parts = [
        _passed(scene, Bundle(position[first : first + AT_ONCE], direction[first : first + AT_ONCE]))
        for first in range(0, len(position), AT_ONCE)
    ]
    return np.concatenate(parts).reshape(size[1], size[0])


def _passed(scene: EyeAndWindows, rays: Bundle) -> Floats:
    found = scene.trace(rays, path=True)
    before, behind = _axes(scene.analyser), _axes(scene.polariser)
    # from the eye to the object; light runs the other way, which transposes the matrix
    matrix = found.jones
    power = np.where((found.end == End.THROUGH)[:, None, None], behind @ matrix, matrix)
    power = np.where((found.end == End.BACK)[:, None, None], before @ matrix, power) @ before.T
    share = (abs(power) ** 2).sum((-1, -2)) / 2
    # beside the first opening, or on its frame; what has passed an empty window and misses the next one is behind it
    enters = (found.windows[:, 1:] >= 0).any(1) | (found.windows[:, :1] >= 0).any(1) & (found.end == End.BESIDE)
    outside = (found.count == 0) & (found.end != End.THROUGH) & ~enters
    return np.where(outside, 1.0, np.nan_to_num(share))


def _axes(angle: float | str) -> Floats:
    """Return the projection on a polariser's axis, (2, 2), or the identity if there is none."""
    if isinstance(angle, str):
        return np.eye(2)
    axis = np.array([cos(radians(angle)), sin(radians(angle))])
    return np.outer(axis, axis)
