"""The outlines of chess pieces where the equations say that they appear, from the pieces' distance fields."""

from functools import lru_cache
from math import ceil
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from povgen.inputs.pieces import PieceFile
from povgen.rendering.volumes import MOST, Volume, decoded, volumes
from povgen.scene.presets import AxialScene

FINEST = 16  # points of an outline between two voxels, at most
_measuring = Lock()


def outlines(scene: AxialScene, step: float) -> NDArray[np.complex128]:
    """Return points of the outlines with which the pieces appear in the plane z = 0: x + iy, tiles, about `step` apart.

    Points that are not visible in the window are left out. Raises PovrayError if POV-Ray is missing and a piece is not
    povgen's.
    """
    found = []
    for piece, (L, z1) in zip(scene.pieces, scene.objects, strict=True):
        volume = _volume(piece.piece)
        size = abs(scene.apparent_position(L + 1, z1) - scene.apparent_position(L, z1)) * volume.place[3]
        times = ceil(np.fmin(size / step, FINEST))  # NaN: the piece appears at infinity
        place, visible = scene.seen(L + _outline(volume, times), z1)
        found.append(place[visible])
    return np.concatenate(found)


def _volume(piece: str | PieceFile) -> Volume:
    with _measuring:  # frames of a movie that are drawn at once have the same piece, which takes long to measure
        return _measured(piece)


@lru_cache(maxsize=16)
def _measured(piece: str | PieceFile) -> Volume:
    return volumes({"piece": piece})["piece"]


@lru_cache(maxsize=64)
def _outline(volume: Volume, times: int) -> NDArray[np.complex128]:
    """Return points of a piece's outline, at least about `times` a voxel: x + iy, tiles, from its foot's centre."""
    field = (decoded(volume.data).astype(float) - 128) * MOST / 127
    least = field.min(axis=0)  # along z: the distance of a line of sight from the surface, below 0 inside
    y, x = (np.arange(times * (n - 1) + 1) / times for n in least.shape)
    wide = np.array([np.interp(x, np.arange(least.shape[1]), row) for row in least])
    fine = np.array([np.interp(y, np.arange(least.shape[0]), column) for column in wide.T]).T
    points = []
    for axis in (0, 1):
        before, after = (np.moveaxis(fine, axis, 0)[part] for part in (slice(-1), slice(1, None)))
        along, across = np.nonzero((before < 0) != (after < 0))
        part = before[along, across] / (before[along, across] - after[along, across])
        place = (along + part) / times, across / times
        points.append(place[1 - axis] + 1j * place[axis])
    x0, y0, _, side = volume.place
    return np.asarray(x0 + 1j * y0 + side * np.concatenate(points), complex)
