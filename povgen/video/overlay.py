"""What is drawn over a frame: a strip that tells its parameters, and where the equations have what is seen."""

from collections.abc import Callable, Iterable
from itertools import pairwise
from math import ceil, radians

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from povgen.optics import paraxial, rotation
from povgen.scene.models import Scene
from povgen.settings import Rendering

HALO = (0, 0, 0, 170)  # red, green, blue, opacity
# told apart by all eyes, and in grey: Okabe and Ito's yellow, sky blue and vermilion
P_COLOUR, ALPHA_COLOUR, R_COLOUR = (240, 228, 66, 255), (86, 180, 233, 255), (213, 94, 0, 255)
LEAST_TEXT, STRIP = 12, 0.05  # height of the text: pixels, and share of the picture's height
ROWS = 64  # blended at a time: large pictures need little memory more

Colour = tuple[int, int, int, int]


def annotated(picture: np.ndarray, scene: Scene, rendering: Rendering) -> np.ndarray:
    """The scene's picture, (height, width, 3) bytes, with the overlay and the caption that the rendering asks for."""
    picture = picture.copy()
    if rendering.overlay:
        _overlay(scene, picture)
    if rendering.caption:
        _caption(scene, picture)
    return picture


def facts(scene: Scene) -> dict[str, str]:
    """What the caption says: alpha, z1, z2, r, nu and M, as text; of several objects the least and the greatest.

    nu and M are predicted for prisms of the scene's size (`Scene.nu_and_M`).
    """
    z1 = np.array(scene.distances)
    told = {"z1": _range(z1), "z2": f"{scene.z2:g}", "r": _range(rotation.r(z1, scene.z2))}
    if scene.sheet in ("detailed", "ideal"):
        nu, M = scene.nu_and_M(z1)
        told = {"alpha": f"{scene.alpha:.4g}°", **told, "nu": f"{_range(nu, '.1f')}°", "M": _range(M)}
    return told


def _range(values: np.ndarray, form: str = ".3g") -> str:
    """The least and the greatest of the numbers; '?' for those that are none, as nu at the pole."""
    numbers = values[~np.isnan(values)]
    ends = dict.fromkeys(_number(end, form) for end in (numbers.min(), numbers.max())) if len(numbers) else ()
    return ", ".join([" to ".join(ends)] * bool(ends) + ["?"] * (len(numbers) < len(values)))


def _number(value: float, form: str) -> str:
    return "infinite" if np.isinf(value) else f"{value + 0:{form}}"


def _caption(scene: Scene, picture: np.ndarray) -> None:
    """Darken a strip along the lower edge and write in it, in as many lines as keep it legible."""
    told = [f"{name} = {value}" for name, value in facts(scene).items()]
    rooms = [_room(name, len(scene.distances) > 1) for name in facts(scene)]
    height, width, _ = picture.shape

    def widths(font) -> np.ndarray:
        return np.array([max(font.getlength(text + "  ") for text in pair) for pair in zip(told, rooms, strict=True)])

    for lines in (1, 2, 3):
        rows = np.array_split(np.arange(len(told)), lines)
        widest = max(widths(ImageFont.load_default(100))[row].sum() for row in rows)
        size = min(max(STRIP * height, LEAST_TEXT), 0.97 * width * 100 / widest)
        if size >= max(LEAST_TEXT, 0.6 * STRIP * height):
            break
    font = ImageFont.load_default(size)
    step = round(1.4 * size)
    strip = Image.fromarray(picture[-len(rows) * step :] // 5)
    draw = ImageDraw.Draw(strip)
    for line, row in enumerate(rows):
        place = (width - widths(font)[row].sum() + font.getlength("  ")) / 2
        for n in row:
            draw.text((place, (line + 0.5) * step), told[n], "white", font, anchor="lm")
            place += widths(font)[n]
    picture[-len(rows) * step :] = np.asarray(strip)


def _room(name: str, several: bool) -> str:
    """Text as wide as a fact is in any frame, but for very long numbers: so a movie's text stands still."""
    number = "0.0000" if name == "M" else "-00.00"  # no narrower than "infinite"
    spans = several and name in ("z1", "r", "nu", "M")
    unit = "°" if name in ("alpha", "nu") else ""
    return f"{name} = {number}{f' to {number}' * spans}{', ?' * (spans and name == 'nu')}{unit}"


def _overlay(scene: Scene, picture: np.ndarray) -> None:
    """Draw the curves that predicted positions move on, and over them the positions."""
    height, width, _ = picture.shape
    tile = height / scene.view_height
    thick = max(height / 180, 1.5)
    step = max(0.5, np.sqrt(0.2 * thick))  # between discs in a row, pixels: it looks like a line of this thickness

    def pixels(place) -> np.ndarray:
        return (width / 2 - 0.5 + place.real * tile) + 1j * (height / 2 - 0.5 - place.imag * tile)

    curves = [(pixels(np.concatenate([*pieces, []])), colour) for pieces, colour in loci(scene, step / tile)]
    _discs(picture, np.concatenate([points for points, _ in curves]), 1.1 * thick, HALO)
    for points, colour in curves:
        _discs(picture, points, thick / 2, colour)
    for place in positions(scene):
        for radius, colour in ((2.6, HALO), (2.0, P_COLOUR), (1.0, HALO)):
            _discs(picture, pixels(np.array([place])), radius * thick, colour)


def _discs(picture: np.ndarray, points: np.ndarray, radius: float, colour: Colour) -> None:
    """Blend a colour over all pixels within a radius of any of the points, x + iy in pixels, with smooth edges."""
    if not len(points):
        return
    reach = ceil(radius + 0.5)
    rows, columns = (
        slice(max(0, int(ends.min()) - reach), min(size, int(ends.max()) + reach + 2))
        for ends, size in zip((points.imag, points.real), picture.shape, strict=False)
    )
    part = picture[rows, columns]
    # squares of distances from the nearest point
    nearest = np.full(part.shape[:2], (radius + 0.5) ** 2, np.float32)
    for x, y in zip(points.real - columns.start, points.imag - rows.start, strict=True):
        down, right = (slice(max(0, int(c) - reach), max(0, int(c) + reach + 2)) for c in (y, x))
        there = nearest[down, right]
        dy, dx = (
            np.arange(s.start, s.start + n) - c for s, n, c in zip((down, right), there.shape, (y, x), strict=True)
        )
        np.minimum(there, (dy**2)[:, None] + dx**2, out=there)
    for top in range(0, len(part), ROWS):
        band = slice(top, top + ROWS)
        opacity = (radius + 0.5 - np.sqrt(nearest[band, :, None])).clip(0, 1) * (colour[3] / 255)
        part[band] = (part[band] * (1 - opacity) + opacity * colour[:3] + 0.5).astype(np.uint8)


def positions(scene: Scene) -> list[complex]:
    """Where the scene's objects (of a piece, its foot) are predicted, in the plane z = 0, tiles.

    Only of those whose light the window's frame lets through to the eye.
    """
    return [complex(scene.apparent_position(scene.L, z1)) for z1 in scene.distances if scene.visible(scene.L, z1)]


def loci(scene: Scene, step: float = 0.005) -> list[tuple[list[np.ndarray], Colour]]:
    """Curves that predicted positions move on: as z1 changes (alpha constant), and, for a single object, as alpha
    changes (r constant).

    Each in pieces, points of the plane z = 0 in tiles that are no farther apart than a step, and its colour. They end
    where the window's frame hides what is there.
    """
    alpha, pitch = radians(scene.alpha), scene.pitch if scene.sheet == "detailed" else 0
    ends = scene.depth / 2, 1e4 * scene.z2
    infinite = {"single": [scene.z2], "none": []}.get(scene.sheet, paraxial.infinite_z1(scene.z2, alpha, pitch).real)

    def of_alpha(z1):
        return scene.apparent_position(scene.L, z1), scene.visible(scene.L, z1)

    curves = [(_pieces(scene, of_alpha, ends, infinite, step), ALPHA_COLOUR)]
    if len(scene.distances) == 1 and scene.sheet in ("detailed", "ideal"):
        z1 = scene.distances[0]
        far = np.degrees(paraxial.infinite_alpha(z1, scene.z2, pitch).real)

        def of_r(alpha):
            return scene.apparent_position(scene.L, z1, alpha), scene.visible(scene.L, z1, alpha)

        curves.append((_pieces(scene, of_r, (-180, 180), (-far, far), step), R_COLOUR))
    return curves


def _pieces(scene: Scene, curve: Callable, ends: tuple, infinite: Iterable[float], step: float) -> list[np.ndarray]:
    """The visible pieces of a curve, which takes parameters between two ends to places and whether they are visible.

    Where `infinite` says, the curve may pass through infinity: it is sampled the more densely the nearer to there, and
    no piece reaches across.
    """
    shares = np.geomspace(1e-14, 0.5, 320)
    shares = np.concatenate((shares, 1 - shares[::-1]))
    pieces = []
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for start, end in pairwise(sorted({*ends, *(at for at in infinite if ends[0] < at < ends[1])})):
            parameter = start + (end - start) * shares
            for _ in range(60):
                place, visible = curve(parameter)
                front = scene.E + (place - scene.E) * (1 - scene.depth / 2 / scene.z2)
                outside = np.maximum(abs(front.real), abs(front.imag)) - scene.window / 2
                gap = abs(np.diff(place))
                # what lies between two points may be visible if they are not far outside of the frame's opening
                coarse = (gap > step) & (np.minimum(outside[:-1], outside[1:]) < 2 * gap)
                if not coarse.any():
                    break
                between = (parameter[:-1] + parameter[1:])[coarse] / 2
                parameter = np.insert(parameter, np.flatnonzero(coarse) + 1, between)
            pieces += [place[run] for run in np.ma.clump_unmasked(np.ma.array(place, mask=~visible))]
    return pieces
