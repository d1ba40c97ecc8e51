"""Frames as measuring instruments: scenes whose colours are numbers, and what they say, pixel by pixel.

Places in the picture are complex numbers, tiles in the plane z = 0, as in `scenes`.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import ClassVar

import numpy as np
from pydantic import Field

from povgen.errors import PovrayError
from povgen.files import temporary_folder
from povgen.optics import prism, trace
from povgen.rendering import povray
from povgen.rendering.parallel import thread_pool
from povgen.scene.models import Chess, Scene
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering


class Linear(Rendering):
    """A frame in 16-bit colours that are proportional to POV-Ray's own, every pixel one ray."""

    file: ClassVar[str] = "frame.ppm"
    format: ClassVar[tuple[str, ...]] = ("+FP16", "File_Gamma=1.0")

    def __init__(self, size: tuple[int, int]):
        super().__init__(size=size, antialias="off")


class _Instrument(Scene):
    """A window before something coded. Sheets and eye may be what no picture would have."""

    prisms: int = 100
    z2: float = 6
    alpha: float = 66
    E: complex = 0j
    gap: float = prism.AIR_GAP  # air between prisms, in units of their pitch
    trace_level: int | None = None  # as the scene needs
    grid: int | None = None  # cells of the ideal sheet's camera, as it needs

    @property
    def air_gap(self) -> float:
        return self.gap

    @property
    def distances(self) -> tuple[float, ...]:
        return ()


class Directions(_Instrument):
    """The surroundings tell from which direction light comes."""

    name: ClassVar[str] = "instruments/directions"
    subject: ClassVar[str] = "directions of the light that comes through the window"


class Positions(_Instrument):
    """A square parallel to the sheets, its centre at L, tells from which place light comes."""

    name: ClassVar[str] = "instruments/positions"
    subject: ClassVar[str] = "a square whose colours are places on it"
    z1: float
    L: complex = 0j
    extent: float = Field(0.3, description="half the square's side, tiles")

    @property
    def distances(self) -> tuple[float, ...]:
        return (self.z1,)


class Piece(Chess):
    """A chess piece alone, whose colours are the places on it."""

    name: ClassVar[str] = "instruments/piece"
    subject: ClassVar[str] = "a chess piece whose colours are places on it"
    extent: ClassVar[float] = 2.0


def frames(scenes: Iterable[Scene], size: tuple[int, int]) -> Iterator[np.ndarray]:
    """What the scenes' pixels say, (height, width, 3): directions, or tiles from L; NaN where nothing coded is seen."""
    rendering = Linear(size)

    def measure(scene: Scene, source: str) -> np.ndarray:
        with temporary_folder() as folder:
            colours = _read(runner.run(source, rendering, folder))
        return np.where(colours.any(-1, keepdims=True), (colours - 0.5) / 0.49, np.nan) * getattr(scene, "extent", 1)

    scenes, runner = list(scenes), povray.Runner()
    with thread_pool(runner) as pool:
        yield from pool.map(measure, scenes, map(to_pov, scenes))


def _read(path: Path) -> np.ndarray:
    """A 16-bit PPM's colours, 0 to 1."""
    data = path.read_bytes()
    header = re.match(rb"P6\s(?:#.*\n)*(\d+) (\d+)\s(?:#.*\n)*65535\n", data)
    if header is None:
        raise PovrayError("POV-Ray's picture is not whole (is the disk full?)")
    width, height = int(header[1]), int(header[2])
    return np.frombuffer(data, ">u2", offset=header.end()).reshape(height, width, 3) / 65535


def pixels(size: tuple[int, int]) -> np.ndarray:
    """Where the pixels' centres are, (height, width)."""
    width, height = size
    tile = height / Scene.view_height
    x, y = np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5
    return (x + 1j * y[:, None]) / tile


def rays(scene: Scene, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Which pixels look through the window past the frame's front, (height, width); their unit directions, (n, 3)."""
    place = pixels(size)
    front = scene.E + (place - scene.E) * (1 - scene.depth / 2 / scene.z2)
    half = scene.window / 2
    inside = (_reach(place) < half) & (_reach(front) < half)
    offset = place[inside] - scene.E
    direction = np.column_stack((offset.real, offset.imag, np.full(len(offset), float(scene.z2))))
    return inside, direction / np.linalg.norm(direction, axis=1, keepdims=True)


def window(scene: Scene, size: tuple[int, int]) -> tuple[slice, slice]:
    """Rows and columns of the pixels that look through the window."""
    inside, _ = rays(scene, size)
    y, x = np.argwhere(inside)[[0, -1]].T
    return slice(y[0], y[1] + 1), slice(x[0], x[1] + 1)


def traced(scene: Scene, direction: np.ndarray, most: int = 60, origin: np.ndarray | None = None) -> trace.Rays:
    """The exact ray trace of a scene of prisms for rays from its eye, or from origins (n, 3), up to `most` faces each.

    A ray that meets the frame behind the sheets ends there.
    """
    sheets = trace.sheets(scene.sheet, radians(scene.alpha), scene.window, scene.prisms, scene.air_gap)
    if origin is None:
        origin = np.array([[scene.E.real, scene.E.imag, -scene.z2]])
    found = trace.trace(origin, direction, sheets, scene.window, scene.prisms, scene.air_gap, most)
    side = np.where(found.direction[:, 2] > 0, 0.5, -0.5) * scene.depth
    leaves = found.position + ((side - found.position[:, 2]) / found.direction[:, 2])[:, None] * found.direction
    free = found.end <= trace.End.BACK
    found.end[free & (abs(leaves[:, :2]).max(1) > scene.window / 2)] = trace.End.FRAME
    found.designed &= found.end == trace.End.THROUGH
    return found


def _reach(place: np.ndarray) -> np.ndarray:
    return np.maximum(abs(place.real), abs(place.imag))


@dataclass(frozen=True)
class Seen:
    """Where an object appears, and how a step d on it appears about there: as a d + b conj(d)."""

    place: complex
    a: complex
    b: complex

    @property
    def rotation(self) -> float:
        """Radians."""
        return float(np.angle(self.a))

    @property
    def magnification(self) -> float:
        return abs(self.a)


def locate(place: np.ndarray, told: np.ndarray, radius: float) -> Seen | None:
    """Where the point told as 0 appears, from pixels at `place` that tell places `told` on an object; None: nowhere.

    A pixel counts if what it tells is within `radius`. Stray light puts scraps of the object elsewhere and prisms
    cut it into slices: a fit of what is told, as a function of place, starts where most of these pixels are and
    drops what lies far from it.
    """
    near = abs(told) < radius
    place, told = place[near], told[near]
    if len(place) < 12:
        return None
    centre, reach = _densest(place)
    for _ in range(20):
        inside = abs(place - centre) < reach
        if inside.sum() < 12:
            return None
        x, y = (place[inside] - centre) / reach, told[inside]
        basis = np.column_stack((np.ones(len(x)), x, x.conj()))
        kept = np.ones(len(x), bool)
        for _ in range(5):
            fit = basis[kept]
            c, _, rank, _ = np.linalg.lstsq(fit, y[kept], rcond=None)
            if rank < 3:  # pixels in a line
                return None
            off = abs(y - basis @ c)
            kept = off <= 4 * np.median(off[kept]) + 1e-12
        c /= (1, reach, reach)
        size = abs(c[1]) ** 2 - abs(c[2]) ** 2
        a, b = c[1].conj() / size, -c[2] / size
        step = -a * c[0] - b * c[0].conj()
        centre = centre + step
        # what is cut off at the radius would pull the fit: stay within the ellipse that it is seen as
        reach = 0.8 * radius * abs(abs(a) - abs(b))
        if abs(step) < 1e-6 * reach:
            break
    return Seen(complex(centre), complex(a), complex(b))


def _densest(place: np.ndarray) -> tuple[complex, float]:
    """The middle of the crowd, and its extent: half of the places, those nearest to each other by median."""
    centre, kept = np.median(place.real) + 1j * np.median(place.imag), place
    for _ in range(30):
        distance = abs(place - centre)
        kept = place[distance <= np.median(distance)]
        new = np.median(kept.real) + 1j * np.median(kept.imag)
        if new == centre:
            break
        centre = new
    return centre, 1.5 * float(np.median(abs(kept - centre)))
