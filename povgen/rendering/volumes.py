"""Chess pieces as distance fields: the distance to the piece's surface at each point of a grid.

The live view and the renderer gl draw pieces by these fields.

POV-Ray finds where the grid's lines meet the surface (templates/probes/crossings.pov.j2), so a piece's only description
is its own text. Finished fields are kept in the cache. Those of povgen's own pieces are in the file SHIPPED, so they
need no POV-Ray.
"""

import base64
import functools
import hashlib
import inspect
import json
import lzma
import sys
import zlib
from collections.abc import Mapping, Sequence
from concurrent.futures import as_completed
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError, PovrayError
from povgen.files import temporary_folder
from povgen.inputs.pieces import FILE_RADIUS, PIECES, PieceFile
from povgen.progress import bar
from povgen.rendering import cache, povray
from povgen.rendering.parallel import default_workers, thread_pool
from povgen.scene.sdl import to_crossings
from povgen.settings import Rendering

GRID = (72, 160, 72)  # points along x, y and z
MOST = 2.0  # distances up to this many voxels are stored
# JSON: each piece's field, by the SHA-256 of the text for POV-Ray. `make povgen/rendering/volumes.xz` writes it.
SHIPPED = Path(__file__).with_name("volumes.xz")
MAX_CROSSINGS = 1 << 24  # bytes of the file in which POV-Ray writes where lines meet surfaces; povgen's have below 2 MB

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Volume(NamedTuple):
    """A piece's distance field. `povgen/liveview/pieceShape.js` reads it."""

    place: tuple[float, float, float, float]  # the first point, from the foot's centre, and the side of a voxel, tiles
    # A byte for each point is 128 + 127 * distance / most, at least 1 and at most 255. The distance is below 0 inside.
    # x changes fastest, z slowest. `encoded` says how they are stored.
    data: str
    most: float = MOST  # the distance, in voxels, for which the byte is 255; the same byte means greater distances


def _kept(piece: str | PieceFile) -> tuple[str, str, Volume | None]:
    """Return the text for POV-Ray, the distance field's key in the cache, and the field if it is there or shipped.

    The key of a shipped field is empty. Raises PovrayError if the field is not shipped and POV-Ray is missing, because
    POV-Ray's version belongs to the key.
    """
    source = to_crossings(piece, GRID, FILE_RADIUS, povray.DATA)
    if shipped := _shipped().get(_hash(source)):
        return source, "", shipped
    try:
        version = povray.version()
    except PovrayError as error:
        raise PovrayError(f"{error}\n  the shape of the piece {str(piece)!r} is measured by POV-Ray") from None
    key = "\0".join((version, *povray.library_files(), _code(), source))
    values = cache.load_values(key)
    return source, key, Volume(tuple(values["place"]), values["data"]) if values else None


def _hash(source: str) -> str:
    return hashlib.sha256(source.encode()).hexdigest()


@functools.cache
def _shipped() -> dict[str, Volume]:
    """Return the fields of povgen's own pieces, by the hash of the text that POV-Ray measured."""
    with lzma.open(SHIPPED) as file:
        return {key: Volume(tuple(values["place"]), values["data"]) for key, values in json.load(file).items()}


def ship(path: Path = SHIPPED) -> None:
    """Measure povgen's own pieces, and write their distance fields to a file, by default SHIPPED."""
    sources = {piece: to_crossings(piece, GRID, FILE_RADIUS, povray.DATA) for piece in PIECES}
    runner = povray.Runner()
    made = {_hash(source): _measured(piece, source, runner, 100)._asdict() for piece, source in sources.items()}
    path.write_bytes(lzma.compress(json.dumps(made).encode()))


@functools.cache
def _code() -> str:
    """Return the text of this module. A field that other code made is not used."""
    return inspect.getsource(sys.modules[__name__])


def _measured(piece: str | PieceFile, source: str, runner: povray.Runner, timeout: float) -> Volume:
    """Return a piece's distance field, by POV-Ray.

    Raises PovrayError, and InputError for too many surfaces, and for a piece without an inside: empty, flat, open or
    thin.
    """
    with temporary_folder() as folder:
        try:
            picture = runner.run(source, Rendering(size=(32, 32), antialias="off", timeout=timeout), folder)
        except PovrayError as error:
            raise povray.placed(error, source, [piece], f"the shape of the piece {str(piece)!r}") from None
        with picture.with_name(povray.DATA).open() as data:
            text = data.read(MAX_CROSSINGS)
    name = f"piece = {str(piece)!r}"
    if len(text) == MAX_CROSSINGS:
        raise InputError(f"{name}: too many surfaces for the live view and for gl; allowed: a simpler piece")
    try:
        numbers = np.array(text.replace("\n", ",").rstrip(",").split(","), float)
        place, met = numbers[:4], numbers[4:].reshape(-1, 4)
        distance = distances(met) if len(met) else np.empty(0)
    except (IndexError, ValueError):
        raise InputError(f"{name}: its text writes into {povray.DATA}; allowed: objects and declarations") from None
    if not (distance < 0).any():
        least = f"no solid part thicker than {place[3]:.2g} tiles, within {FILE_RADIUS:g} tiles of its axis"
        raise InputError(f"{name}: {least}; allowed: a closed piece that is thick enough")
    field = np.clip(np.round(128 + 127 * distance / MOST), 1, 255).astype(np.uint8).transpose(2, 1, 0)
    x, y, z, side = place.tolist()
    return Volume((x, y, z, side), encoded(field))


def encoded(field: Bytes) -> str:
    """Return a field's bytes (z, y, x) as text: differences modulo 256, compressed with zlib, in base 64.

    In the first half along z they are from the byte of the point before, in the second from that of the mirrored
    point: most pieces have two equal halves.
    """
    half = len(field) // 2
    steps = np.diff(field, axis=0, prepend=np.uint8(0))
    steps[half:] = field[half:] - field[half - 1 :: -1]
    made = zlib.compressobj(9, memLevel=6)  # less memory makes shorter blocks, and here less in all
    return base64.b64encode(made.compress(steps.tobytes()) + made.flush()).decode()


def decoded(data: str, grid: Sequence[int] = GRID) -> Bytes:
    """Return the bytes (z, y, x) of an encoded field, as povgen/liveview/pieceShape.js does."""
    steps = np.frombuffer(zlib.decompress(base64.b64decode(data)), np.uint8).reshape(grid[::-1])
    front = np.cumsum(steps[: len(steps) // 2], axis=0, dtype=np.uint8)
    return np.concatenate((front, steps[len(front) :] + front[::-1]))


def _new(piece: str | PieceFile, source: str, key: str, runner: povray.Runner, timeout: float) -> Volume:
    """Measure a piece's distance field, keep it in the cache, and return it."""
    made = _measured(piece, source, runner, timeout)
    cache.store_values(key, made._asdict())
    return made


def distances(met: Floats) -> Floats:
    """Return the distance to the piece's surface at each point of the grid, in voxels, below 0 inside. Shape: GRID.

    `met` (n, 4) says where lines meet surfaces: the number of the line's axis (0 for x), the line's numbers along the
    two other axes, from 0, and the distance from the line's first point, in voxels. Surfaces of parts that are hidden
    inside the piece are ignored: a point is outside if nothing stands between it and the grid's border in one of the
    six directions along the axes.

    A surface that is flat near a point has the distance 1/sqrt(1/dx^2 + 1/dy^2 + 1/dz^2), where dx, dy and dz are the
    distances along the axes. Far from the surface the result is inaccurate: it is for points within MOST voxels.
    """
    lines = [_Lines(met[met[:, 0] == axis], axis) for axis in range(3)]
    outside = lines[0].free | lines[1].free | lines[2].free
    with np.errstate(divide="ignore"):
        distance = 1 / np.sqrt(sum(1 / axis.along(outside) ** 2 for axis in lines))
    return np.asarray(np.where(outside, distance, -distance))


class _Lines:
    """All lines along one axis, and where they meet surfaces.

    `free` (shape GRID) is true where a line meets no surface between the point and an end of the line. In `first` and
    `last`, this axis is the last one.
    """

    def __init__(self, met: Floats, axis: int) -> None:
        self.axis = axis
        i, j, place = met[:, 1].astype(int), met[:, 2].astype(int), met[:, 3]
        self.count = GRID[axis]
        others = [n for k, n in enumerate(GRID) if k != axis]
        # the first and the last place between point k and point k + 1 where a line meets a surface; infinite if none
        self.first = np.full((*others, self.count), np.inf)
        self.last = np.full((*others, self.count), -np.inf)
        k = np.clip(place.astype(int), 0, self.count - 1)
        np.minimum.at(self.first, (i, j, k), place)
        np.maximum.at(self.last, (i, j, k), place)
        points = np.arange(self.count)
        free = points <= self.first.min(-1, keepdims=True)
        free |= points >= self.last.max(-1, keepdims=True)
        self.free = np.moveaxis(free, -1, axis)

    def along(self, outside: Mask) -> Floats:
        """Return the distance along the axis to the nearest place where a line enters or leaves the piece."""
        side = np.moveaxis(outside, self.axis, -1)
        points = np.arange(self.count)
        leaves, enters = side[..., 1:] & ~side[..., :-1], side[..., :-1] & ~side[..., 1:]
        place = np.where(leaves, self.last[..., :-1], np.where(enters, self.first[..., :-1], np.inf))
        middle = points[:-1] + 0.5  # for a change that only lines along other axes show
        place = np.where((leaves | enters) & ~np.isfinite(place), middle, place)
        following, preceding = np.full(side.shape, np.inf), np.full(side.shape, -np.inf)
        following[..., :-1] = place
        preceding[..., 1:] = np.where(np.isfinite(place), place, -np.inf)
        following = np.minimum.accumulate(following[..., ::-1], -1)[..., ::-1]
        preceding = np.maximum.accumulate(preceding, -1)
        return np.moveaxis(np.minimum(following - points, points - preceding), -1, self.axis)


def volumes(
    pieces: Mapping[str, str | PieceFile],
    *,
    workers: int | None = None,
    timeout: float = Rendering().timeout,
    progress: bool = False,
) -> dict[str, Volume]:
    """Return the pieces' distance fields, by the same names: shipped, from the cache or new.

    Unless all are shipped, the cache is trimmed.
    `workers` pieces are measured at once, each in at most `timeout` seconds. Raises PovrayError, InputError for a piece
    without an inside or with too many surfaces, and what `cache.check` raises.
    """
    cache.check()
    kept = {name: _kept(piece) for name, piece in pieces.items()}
    made = {name: volume for name, (_, _, volume) in kept.items() if volume}
    new = [name for name in pieces if name not in made]
    povray.warn_of(pieces[name] for name in new)
    runner = povray.Runner(at_once=min(workers or default_workers(), max(1, len(new))))
    with thread_pool(runner, workers) as pool, bar("shapes", len(new), not (progress and new), "pieces") as done:
        fields = {pool.submit(_new, pieces[name], *kept[name][:2], runner, timeout): name for name in new}
        for field in as_completed(fields):
            made[fields[field]] = field.result()
            done()
    if any(key for _, key, _ in kept.values()):
        cache.trim(cache.max_bytes())
    return {name: made[name] for name in pieces}


def stored(shapes: Mapping[str, Volume]) -> dict[str, object]:
    """Return distance fields as the pages' scripts read them."""
    return {"grid": GRID, "pieces": {name: shape._asdict() for name, shape in shapes.items()}}
