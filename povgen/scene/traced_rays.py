"""The rays of a picture of a room with ideal windows, for POV-Ray's camera of single rays.

povgen follows the ray of each pixel through all windows. POV-Ray draws what each part of it ends on: the eye's ray, and
the ray behind each ideal window that it passes. Ideal windows have the colour HOLD_OUT. So objects before, between and
behind the windows are seen as they are, and real prisms bend the rays by themselves.
"""

from collections.abc import Iterator, Sequence
from hashlib import sha256
from itertools import pairwise
from pickle import dumps, loads
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from povgen.inputs import pictures
from povgen.inputs.hdr import Light
from povgen.inputs.pictures import File
from povgen.limits import MAX_FACES
from povgen.optics.camera import Camera, Size
from povgen.optics.equations import Floats
from povgen.optics.faces import Indices
from povgen.optics.opening import Opening
from povgen.optics.window_trace import paths
from povgen.sheets.none import NoSheet
from povgen.version import __version__

HOLD_OUT = (0.37109375, 0.171875, 0.6171875)  # of ideal windows: light that 16 bits hold; nothing else has it
COLUMNS = 1000  # of POV-Ray's picture
BAND = 1000 * COLUMNS  # rays that POV-Ray gets at once: it needs 0.3 GB for them
AT_ONCE = 200_000  # rays that are traced at once
PART = 200_000  # vectors that become text at once


class Rays(NamedTuple):
    """All that the rays of a picture depend on, but for its size."""

    openings: tuple[Opening, ...]
    camera: Camera
    tile: int  # POV-Ray's units per tile


class Found(NamedTuple):
    """Rays: first the eye's rays of all pixels, then those behind the first ideal window of each, and so on."""

    size: Size
    pixel: NDArray[np.int64]  # number of the ray's pixel, (n,)
    position: Floats  # where it starts, (n, 3), tiles
    direction: Floats  # (n, 3)

    @classmethod
    def of(cls, rays: Rays, size: Size) -> "Found":
        """Follow the rays of a picture of this size."""
        pixels = rays.camera.pixels(size).ravel()
        legs: list[list[tuple[Indices, Floats, Floats]]] = []
        for first in range(0, len(pixels), AT_ONCE):
            eyes = rays.camera.through(pixels[first : first + AT_ONCE])
            there = (np.arange(len(eyes)), eyes.position, eyes.direction)
            for leg, (i, position, direction) in enumerate([there, *paths(eyes, rays.openings, MAX_FACES)]):
                legs += [[] for _ in range(len(legs), leg + 1)]
                legs[leg].append((first + i, position, direction))
        return cls(size, *map(np.concatenate, zip(*(part for leg in legs for part in leg), strict=True)))

    def bands(self, tile: int) -> Iterator[tuple[int, int, bytes]]:
        """Yield how many rays POV-Ray gets at once, in how many rows of COLUMNS rays, and their table as text.

        The last row is filled with copies of the last ray. `tile` is POV-Ray's units per tile.
        """
        for first in range(0, len(self.pixel), BAND):
            count = min(BAND, len(self.pixel) - first)
            rows = -(-count // COLUMNS)
            some = first + np.minimum(np.arange(rows * COLUMNS), count - 1)
            yield count, rows, _table(self.position[some], self.direction[some], tile)

    def picture(self, light: Light) -> Light:
        """Return the picture (height, width, 3) from what each ray ends on: (n, 3), linear light.

        A pixel has the light of its first ray that does not end on an ideal window. It is black if there is none.
        """
        count = self.size[0] * self.size[1]
        made, open_ = np.zeros((count, 3), np.float32), np.ones(count, bool)
        held = np.all(abs(light - np.array(HOLD_OUT, np.float32)) < 5e-4, axis=1)
        for part in self.parts:
            pixel = self.pixel[part]
            shown = open_[pixel] & ~held[part]
            made[pixel[shown]] = light[part][shown]
            open_[pixel[shown]] = False
        return made.reshape(self.size[1], self.size[0], 3)

    @property
    def parts(self) -> list[slice]:
        """The eye's rays, those behind the first ideal window of each, and so on."""
        starts = np.flatnonzero(np.concatenate(([True], np.diff(self.pixel) < 0, [True]))).tolist()
        return [slice(*ends) for ends in pairwise(starts)]

    def legs(self, tile: int) -> Iterator[bytes]:
        """Yield a table for each of `parts`. It has a ray for each pixel: the eye's, where the part has none."""
        position, direction = (values[self.parts[0]].copy() for values in (self.position, self.direction))
        for part in self.parts:
            at = self.pixel[part]
            here, along = position.copy(), direction.copy()
            here[at], along[at] = self.position[part], self.direction[part]
            yield _table(here, along, tile)


def file(openings: Sequence[Opening], camera: Camera, tile: int) -> File | None:
    """Return the file of a room's rays, which `pictures.used` finds in a text: the rays are traced when it is used.

    None without ideal sheets: POV-Ray's own camera then shows the room.
    """
    if all(opening.sheet.glass or isinstance(opening.sheet, NoSheet) for opening in openings):
        return None
    # not of the pickled bytes: those of equal sheets differ if one of them has already computed its matrix
    known = repr([__version__, _numbers(camera), tile, *map(_stated, openings)])
    openings = tuple(opening._replace(rim=0.0) for opening in openings)  # POV-Ray finds what meets the frames' sides
    return pictures.kept(f"rays-{sha256(known.encode()).hexdigest()}.inc", dumps(Rays(openings, camera, tile)))


def _stated(opening: Opening) -> list[object]:
    """Return all that a ray through a window depends on. A profile's file counts by its text."""
    sheet: Any = opening.sheet
    values = sorted((name, _numbers(getattr(value, "text", value))) for name, value in sheet.values.items())
    return [_numbers((opening.pose, opening.frame, opening.outline, sheet.aperture)), sheet.name, values]


def _numbers(value: object) -> object:
    """Return numbers, alone or in tuples, as floating-point numbers: a default can be a whole number. Others stay."""
    if isinstance(value, tuple):
        return [*map(_numbers, value)]
    return float(value) if isinstance(value, (int, float)) else value


def of_file(content: bytes) -> Rays:
    """Return the rays of a file that `file` has made."""
    found = loads(content)
    assert isinstance(found, Rays)
    return found


def _table(position: Floats, direction: Floats, tile: int) -> bytes:
    """Return triangles in POV-Ray's language, one for each ray: its centre and its normal are the ray's."""
    start = np.where(abs(direction[:, :1]) < 0.6, (1.0, 0, 0), (0, 1.0, 0))
    u = np.cross(direction, start)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(direction, u)
    sides = u, -u / 2 - np.sqrt(0.75) * v, -u / 2 + np.sqrt(0.75) * v  # the normal is that of a left-handed system
    corners = np.stack([tile * (position + side) for side in sides], 1).reshape(-1, 3)
    count = len(position)
    vectors, faces = _listed(b"%.3f", corners), _listed(b"%d", np.arange(3 * count).reshape(-1, 3))
    return b"vertex_vectors {%d%s}\nface_indices {%d%s}\n" % (3 * count, vectors, count, faces)


def _listed(form: bytes, vectors: NDArray[Any]) -> bytes:
    """Return `,<a,b,c>` for each of the vectors (n, 3), whose numbers are written in this form."""
    parts = (vectors[n : n + PART] for n in range(0, len(vectors), PART))
    return b"".join(b",<%b,%b,%b>" % (form, form, form) * len(part) % tuple(part.ravel().tolist()) for part in parts)
