"""Probes: scenes for measuring. Their colours encode numbers, which are decoded from the rendered pixels.

A position in the picture is a complex number x + iy: tiles in the plane z = 0, x to the right, y up.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from povgen.files import temporary_folder
from povgen.optics.prism import Prism
from povgen.rendering import light, povray
from povgen.rendering.parallel import thread_pool
from povgen.scene.presets import AxialScene, Chess
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Numbers = NDArray[Any]  # real or complex
Mask = NDArray[np.bool_]
Size = tuple[int, int]  # width and height, pixels

APERTURE, VIEW = 2.4, 3.85  # side of the probes' window, and height of their picture in the plane z = 0, tiles


class _Probe(AxialScene):
    """A window in front of something whose colours encode numbers. It allows values that other scenes refuse.

    The window is smaller than that of other scenes, because the limits of the methods were measured with this size.
    """

    is_coded: ClassVar[bool] = True  # otherwise what is behind the window is white
    rim: ClassVar[float] = 0.13
    aperture: float = APERTURE
    view: float = VIEW

    prisms: int = 100
    z2: float = 6
    alpha: float = 66
    gap: float = Prism.gap
    trace_level: int | None = None  # None: the level that povgen sets for the scene
    grid: int | None = None  # cells of the ideal sheet's camera; None: as many as povgen sets for the scene

    def default_view(self, shape: float = 4 / 3) -> float:  # noqa: ARG002
        return VIEW

    @property
    def objects(self) -> tuple[tuple[complex, float], ...]:
        return ()


class Directions(_Probe):
    """Surroundings, infinitely far away, whose colours encode the direction in which they are seen."""

    name: ClassVar[str] = "probes/directions"
    subject: ClassVar[str] = "directions of the light that comes through the window"


class Positions(_Probe):
    """A square parallel to the sheets, with its centre at L. Its colours encode the position relative to L."""

    name: ClassVar[str] = "probes/positions"
    subject: ClassVar[str] = "a square whose colours encode positions on it"
    z1: float = 2
    L: complex = 0j
    extent: float = Field(default=0.3, description="half the square's side, tiles")

    @property
    def objects(self) -> tuple[tuple[complex, float], ...]:
        return ((self.L, self.z1),)

    @property
    def radii(self) -> tuple[float, ...]:
        return (self.extent,)


class Light(Positions):
    """A white square parallel to the sheets, with its centre at L, in front of black."""

    is_coded: ClassVar[bool] = False


class White(Directions):
    """White surroundings, infinitely far away, for the share of their light that reaches the eye through the window."""

    is_coded: ClassVar[bool] = False


class PiecePositions(Chess):
    """A chess piece alone. Its colours encode the position relative to the centre of its foot."""

    name: ClassVar[str] = "probes/piece"
    subject: ClassVar[str] = "a chess piece whose colours encode positions on it"
    extent: ClassVar[float] = 2.0
    z1: float = 2
    piece: str = "knight"


def brightness(scene: Light | White, size: Size) -> Floats:
    """Render a probe, and return how bright its pixels are, (height, width): 1 for white."""
    (colours,) = _colours([scene], size)
    return np.asarray(colours[..., 0])


def decoded(scenes: Sequence[AxialScene], size: Size) -> Iterator[Floats]:
    """Render probes, and yield the numbers that the pixels of each probe encode, (height, width, 3).

    The probes keep their order. The numbers are x, y and z of directions, or of positions in tiles. They are NaN where
    a pixel encodes nothing. Raises PovrayError if a probe cannot be rendered.
    """
    for scene, colours in zip(scenes, _colours(scenes, size), strict=True):
        numbers = np.where(colours.any(-1, keepdims=True), (colours - 0.5) / 0.49, np.nan)
        yield numbers * float(getattr(scene, "extent", 1))


def _colours(scenes: Sequence[AxialScene], size: Size) -> Iterator[Floats]:
    """Render probes, and yield their colours, (height, width, 3), from 0 to 1."""

    def rendered(source: str) -> Floats:
        with temporary_folder() as folder:
            return light.read(runner.run(source, picture, folder), size).astype(float)

    runner, picture = povray.Runner(), povray.Band(size, Rendering().timeout, is_light=False)
    with thread_pool(runner) as pool:
        yield from pool.map(rendered, map(to_pov, scenes))


@dataclass(frozen=True)
class ApparentObject:
    """Where an object appears, and how it is turned, scaled and sheared.

    A step d on the object, a complex number in tiles, is seen as a step a d + b conj(d).
    """

    position: complex
    a: complex
    b: complex


def locate(position: Complexes, on_object: Complexes, radius: float) -> ApparentObject | None:
    """Return where the point 0 of an object appears, or None if too little of the object is visible.

    `position` (n,) holds the pixels' positions in the picture. `on_object` (n,) holds the position on the object, in
    tiles, that each pixel shows, or NaN. Only pixels that show a position within `radius` of 0 count. Prisms cut the
    object into slices, and stray light shows parts of it elsewhere. Therefore a linear function is fitted to the
    pixels. The fit starts where the pixels are densest, and drops pixels with large errors.
    """
    near = abs(on_object) < radius
    position, on_object = position[near], on_object[near]
    if len(position) < 12:
        return None
    centre, reach = _densest(position)
    for _ in range(20):
        inside = abs(position - centre) < reach
        if inside.sum() < 12:
            return None
        x, y = (position[inside] - centre) / reach, on_object[inside]
        c, rank = fitted(np.column_stack((np.ones(len(x)), x, x.conj())), y)
        if rank < 3:  # the pixels lie on a line
            return None
        c /= (1, reach, reach)
        # the fitted function maps positions in the picture to positions on the object: invert it
        size = abs(c[1]) ** 2 - abs(c[2]) ** 2
        a, b = c[1].conj() / size, -c[2] / size
        step = -a * c[0] - b * c[0].conj()
        centre = centre + step
        # on the object `radius` is a circle, which appears as an ellipse: pixels from outside it would bias the fit
        reach = 0.8 * radius * abs(abs(a) - abs(b))
        if abs(step) < 1e-6 * reach:
            break
    return ApparentObject(complex(centre), complex(a), complex(b))


def fitted(basis: Numbers, values: Numbers, rounds: int = 5) -> tuple[Numbers, int]:
    """Fit values (n,) by a linear combination of basis (n, k). Drop pixels with large errors, such as stray light.

    Return the coefficients (k,), and the basis's rank for the pixels that are kept.
    """
    kept = np.ones(len(values), bool)
    for _ in range(rounds):
        found, _, rank, _ = np.linalg.lstsq(basis[kept], values[kept], rcond=None)
        off = abs(values - basis @ found)
        kept = off <= 4 * np.median(off[kept]) + 1e-12
    return found, int(rank)


def _densest(position: Complexes) -> tuple[complex, float]:
    """Return the centre and the radius of the region where positions are densest. It holds about half of them."""
    centre, kept = complex(np.median(position.real), np.median(position.imag)), position
    for _ in range(30):
        distance = abs(position - centre)
        kept = position[distance <= np.median(distance)]
        new = complex(np.median(kept.real), np.median(kept.imag))
        if new == centre:
            break
        centre = new
    return centre, 1.5 * float(np.median(abs(kept - centre)))
