"""Find rays whose path POV-Ray's rounding decides: where they end does not say whether the scene is right."""

from math import pi

import numpy as np

from povgen.measure.probes import Directions, Floats, Mask
from povgen.optics.rays import Bundle
from povgen.scene import survey

# Tiles. POV-Ray ignores a face that is nearer than this to the face that the ray met last.
MIN_DISTANCE = 1e-6
# Radians. POV-Ray stores vertices to 1e-7 tiles, which tilts the faces of N prisms, each 2.4/N tiles wide, by N times
# this angle.
TILT_PER_PRISM = 1e-7


def decided_by_rounding(scene: Directions, direction: Floats) -> Mask:
    """Return which of the eye's rays POV-Ray's rounding can send elsewhere, (n,).

    `direction` (n, 3) are unit vectors. Each ray is compared with 16 neighbouring rays. Before the sheets they
    run at a distance of MIN_DISTANCE from this ray. Their directions are turned by TILT_PER_PRISM times N. A ray counts
    if a neighbouring ray takes another path, or leaves in a direction more than 5e-4 rad away. A ray also counts if it
    meets two faces, one after the other, at points within MIN_DISTANCE of each other, as at an edge.
    """
    max_faces, rays = survey.max_trace_level(scene), scene.camera.along(direction)
    path = scene.trace(rays, max_faces, path=True)
    sensitive = np.zeros(len(direction), bool)
    front = rays.position + direction * ((scene.z2 - 0.51 * scene.depth) / direction[:, 2:])
    across = np.cross(direction, (0, 1, 0))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = np.cross(direction, across)
    for n in range(16):
        angle = n * pi / 8
        # five times the angle, so that all combinations of displacement and turn occur
        turn = scene.prisms * TILT_PER_PRISM * np.exp(5j * angle)
        turned = direction + turn.real * across + turn.imag * other
        displaced = front + MIN_DISTANCE * np.array([np.cos(angle), np.sin(angle), 0])
        neighbour = scene.trace(Bundle(displaced, turned), max_faces)
        sensitive |= (neighbour.faces != path.faces).any(1) | (neighbour.end != path.end)
        sensitive |= np.linalg.norm(neighbour.direction - path.direction, axis=1) > 5e-4
    apart = np.linalg.norm(np.diff(path.corners, axis=1), axis=2)  # NaN after the end
    return np.asarray(sensitive | ((apart < MIN_DISTANCE) & (path.met[:, 1:] > 0) & (path.met[:, :-1] > 0)).any(1))
