"""The light of a source that comes through a scene's windows to a screen: its power per area, by traced rays."""

from __future__ import annotations  # help() then says ArrayLike

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

from povgen.errors import input_errors, shown
from povgen.inputs.fields import PictureSize
from povgen.objects.card import Card
from povgen.optics.equations import Complexes, Floats, real
from povgen.optics.faces import Booleans, Indices
from povgen.optics.opening import Opening
from povgen.optics.rays import LARGEST, MOST, Bundle, Traced, checked_count
from povgen.optics.trace import CHUNK, End
from povgen.optics.values import Values
from povgen.rendering.frames import read_png
from povgen.rendering.light import linear
from povgen.scene.presets import AxialScene
from povgen.scene.scene import Scene, checked_scene


@dataclass(frozen=True, eq=False, repr=False)
class Irradiance(Values):
    """The power per area on a screen, in units of the source's intensity per square tile.

    The intensity is the power per solid angle, straight ahead of the source. Arrays are (height, width), of a card
    (height, width, 3): red, green and blue. The first row is the top one; x is to the right, as the eye sees it.
    """

    designed: Floats  # by light on the designed path
    stray: Floats  # by all other light from the windows
    error: Floats  # the standard error of the sum of both, NaN for one ray
    extent: tuple[float, float, float, float]  # left, right, bottom and top of the screen, tiles
    entering: Floats  # the power that meets the windows, a number, or three of a card
    leaving: Floats  # the part of it that leaves them towards the screen's plane, also beside the screen

    def __repr__(self) -> str:
        height, width = self.error.shape[:2]
        passes = 100 * self.leaving.sum() / self.entering.sum()
        return f"Irradiance of {width}x{height} pixels by {passes:.3g} % of the light that enters"

    @property
    def total(self) -> Floats:
        """The sum of designed and stray light."""
        return self.designed + self.stray


@input_errors()
def irradiance(
    scene: Scene,
    source: ArrayLike | Card,
    z: float,
    *,
    diameter: float = 0,
    extent: Sequence[float] = (-2, 2, -2, 2),
    size: str | Sequence[int] = (64, 64),
    count: int = 1_000_000,
    seed: int = 1,
) -> Irradiance:
    """Return the irradiance on a screen at z by a source whose light passes the scene's windows.

    The source is a point (x, y, z) that shines equally in all directions; with a `diameter`, the middle of a disc,
    parallel to the screen, that shines as the cosine of the angle to z (Lambert); or a `Card`, of which each point
    shines so, by its picture's light, to the side of the picture. A card that is white has the intensity 1. Lengths
    are in tiles. `extent` is left, right, bottom and top of the screen, and `size` its width and height in pixels. All
    windows must be on one side of the screen. If the source is on the same side of them as the screen, the screen shows
    the light that comes back.

    `count` rays are traced to random points of the windows; `seed` is that of the random numbers. Light that no window
    meets first is left out, and objects neither stop light nor shine. Light that passes one window of a preset and
    misses the next one is lost; in a room it goes on. With the scene's `fresnel`, partial reflections count. Raises
    InputError for numbers that are not allowed, for a scene without windows or with polarisers, for a screen between
    windows, and, in a preset with several windows, for a source whose z is between those of the first and the last.
    """
    scene, rng = checked_scene(scene), np.random.default_rng(checked_count("seed", seed, 10**9, 0))
    count, (width, height) = checked_count("count", count, MOST), PictureSize(size=size).size
    z, diameter, left, right, bottom, top = _checked("z, diameter, extent", (z, diameter, *np.ravel(extent)), 6)
    if not (left < right and bottom < top):
        raise ValueError(f"extent = {shown(extent)}: allowed: left < right, bottom < top")
    _check_scene(scene, source, diameter, z)
    colours = 3 if isinstance(source, Card) else 1
    sums, squares = np.zeros((2, 2 * height * width, colours))  # of rays' powers: first of designed light
    power = np.zeros((2, colours))  # that enters, that leaves
    for start in range(0, count, CHUNK):
        rays, light, window = _emitted(scene.openings, source, diameter, min(CHUNK, count - start), rng)
        traced = scene.trace(rays, partial=rng if scene.fresnel else None)
        light *= (traced.windows[:, :1] == window[:, None]) / count
        at, arrives = _on(traced, z)
        power += light.sum(0), light[arrives].sum(0)
        column = np.floor((at.real - left) / (right - left) * width)
        row = np.floor((top - at.imag) / (top - bottom) * height)
        hit = arrives & (0 <= column) & (column < width) & (0 <= row) & (row < height)
        pixel = ((row + height * ~traced.designed) * width + column)[hit].astype(int)
        for colour, part in enumerate(light[hit].T):
            sums[:, colour] += np.bincount(pixel, part, len(sums))
            squares[:, colour] += np.bincount(pixel, part**2, len(sums))
    if not power[0].any():
        raise ValueError(
            f"source = {shown(source)}: none of its light enters a window; allowed: a point outside the windows' "
            "frames, a card that faces a window"
        )
    every = slice(None) if colours == 3 else 0
    parts, squares = (each.reshape(2, height, width, -1)[..., every] for each in (sums, squares))
    with np.errstate(invalid="ignore"):  # one ray has no error
        error = np.sqrt(np.maximum(squares.sum(0) - parts.sum(0) ** 2 / count, 0) * count / np.float64(count - 1))
    pixel_area = (right - left) / width * (top - bottom) / height
    designed, stray, error = (each / pixel_area for each in (*parts, error))
    return Irradiance(designed, stray, error, (left, right, bottom, top), *power[:, every])


def _check_scene(scene: Scene, source: ArrayLike | Card, diameter: float, z: float) -> None:
    """Raise ValueError for what `irradiance` refuses about the scene, and about the places of source and screen."""
    if diameter < 0 or (diameter and isinstance(source, Card)):
        raise ValueError(f"diameter = {diameter:g}: allowed: 0 or more, and 0 for a card")
    if not scene.openings:
        raise ValueError("scene: no windows; allowed: a scene with a window")
    if scene.polarised:
        raise ValueError("polariser, analyser: light is unpolarised here; allowed: a scene without them")
    if isinstance(scene, AxialScene):
        start = source.pose.z if isinstance(source, Card) else _checked("source", source, 3)[2]
        if len(scene.places) > 1 and 0 <= start <= scene.places[-1]:
            raise ValueError(f"source: z = {start:g}: between or beside the windows; allowed: another z, or a room")
    if len({bool(opening.pose.z < z) for opening in scene.openings}) > 1:
        raise ValueError(f"z = {z:g}: between the windows; allowed: all windows on one side of the screen")
    for opening in scene.openings:
        sizes = opening.outer.width, opening.outer.height, opening.deep.frame
        depth = abs(opening.pose.axes[:, 2]) @ sizes / 2  # half of its extent along z
        if abs(z - opening.pose.z) < depth:
            raise ValueError(f"z = {z:g}: within a window's frame; allowed: {depth:.3g} tiles or more from its middle")


def _checked(name: str, values: Any, count: int) -> Any:  # noqa: ANN401
    """Return finite numbers, so many of them. Raises ValueError."""
    found = real(name, values)
    if found.shape != (count,) or not (abs(found) <= LARGEST).all():
        raise ValueError(f"{name} = {shown(values)}: allowed: {count} numbers from -{LARGEST:g} to {LARGEST:g}, tiles")
    return found.tolist()


def _emitted(
    openings: Sequence[Opening], source: ArrayLike | Card, diameter: float, count: int, rng: Generator
) -> tuple[Bundle, Floats, Indices]:
    """Return rays to random points of the windows, the power of each times their number (n, c), and its window (n,).

    The points are where light enters: on the side of the window's frame that faces the source.
    """
    areas = np.array([opening.outline.width * opening.outline.height for opening in openings])
    window = rng.choice(len(openings), count, p=areas / areas.sum())
    u, v = rng.uniform(-0.5, 0.5, (2, count))
    start, light, facing = _source(source, diameter, count, rng)
    way, solid = np.empty((count, 3)), np.empty(count)
    for w, opening in enumerate(openings):
        some, outline, axes = window == w, opening.outline, opening.pose.axes
        x, y = u[some] * outline.width, v[some] * outline.height
        side = opening.deep.frame / 2 * np.sign((start[some] - opening.pose.place) @ axes[2])
        way[some] = opening.pose.place + np.stack((x, y, side), -1) @ axes - start[some]
        solid[some] = areas.sum() * abs(way[some] @ axes[2]) * ~outline.excludes(x, y)
    far = np.linalg.norm(way, axis=1)
    if isinstance(source, Card) or diameter:
        solid *= (way @ facing / far).clip(0) if isinstance(source, Card) else abs(way[:, 2]) / far
    return Bundle(start, way), light * (solid / far**3)[:, None], window  # in steradians


def _source(source: ArrayLike | Card, diameter: float, count: int, rng: Generator) -> tuple[Floats, Floats, Floats]:
    """Return random points of a source (n, 3), the light of each (n, c), and a card's normal (3,)."""
    u, v = rng.uniform(size=(2, count))
    if isinstance(source, Card):
        pixels = read_png(source.picture.file.content)
        wide, high = source.size
        at = source.pose.place + np.stack((wide * (u - 0.5), high * (0.5 - v)), -1) @ source.pose.axes[:2]
        rows, columns = (v * len(pixels)).astype(int), (u * len(pixels[0])).astype(int)
        return at, linear(pixels[rows, columns]).astype(float), -source.pose.axes[2]
    place = _checked("source", source, 3)
    disc = diameter / 2 * np.sqrt(u) * np.exp(2j * np.pi * v)
    return place + np.stack((disc.real, disc.imag, 0 * u), -1), np.ones((count, 1)), np.zeros(3)


def _on(traced: Traced, z: float) -> tuple[Complexes, Booleans]:
    """Return where rays cross the plane z, x + iy (n,), and which rays that leave the windows do."""
    with np.errstate(divide="ignore", invalid="ignore"):
        away = (z - traced.position[:, 2]) * np.sign(traced.direction[:, 2])
        return traced.at(z), (traced.end <= End.BACK) & (away > 0)
