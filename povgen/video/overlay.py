"""Draw on a frame: a caption with the scene's parameters, and an overlay with predicted positions."""

from collections.abc import Callable, Iterable
from itertools import pairwise
from math import ceil, radians

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from povgen.optics import paraxial, rotation
from povgen.optics.prism import Prism
from povgen.scene.models import Scene
from povgen.settings import Rendering

HALO = (0, 0, 0, 170)  # red, green, blue, opacity
# Okabe and Ito's yellow, sky blue and vermilion, which colour-blind readers can distinguish
P_COLOUR, ALPHA_COLOUR, R_COLOUR = (240, 228, 66, 255), (86, 180, 233, 255), (213, 94, 0, 255)
# Height of the caption's text: the least height in pixels, and the usual height as a fraction of the picture's height.
MIN_TEXT, TEXT = 12, 0.05
ROWS = 64  # rows blended at a time, so that large pictures need little additional memory

Colour = tuple[int, int, int, int]
Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Curve = Callable[[Reals], tuple[Complexes, NDArray[np.bool_]]]  # parameters to points, and whether these are visible


def annotated(picture: NDArray[np.uint8], scene: Scene, rendering: Rendering) -> NDArray[np.uint8]:
    """Return a copy of the scene's picture, with an overlay and a caption if `rendering` says so.

    Pictures are (height, width, 3) bytes.
    """
    picture = picture.copy()
    if rendering.overlay:
        _overlay(scene, picture)
    if rendering.caption:
        _caption(scene, picture)
    return picture


def facts(scene: Scene) -> dict[str, str]:
    """Return what the caption says: alpha, z1, z2, r, nu and M, as text.

    For several objects a value is a range. nu and M are predictions for the size of the scene's prisms
    (`Scene.nu_and_M`).
    """
    z1 = np.array(scene.distances)
    texts = {"z1": _range(z1), "z2": f"{scene.z2:g}", "r": _range(rotation.r(z1, scene.z2))}
    if scene.sheet in ("detailed", "ideal"):
        nu, M = scene.nu_and_M(z1)
        texts = {"alpha": f"{scene.alpha:.4g}°", **texts, "nu": f"{_range(nu, '.1f')}°", "M": _range(M)}
    return texts


def _range(values: Reals, form: str = ".3g") -> str:
    """Return the least and the greatest number as text, and '?' if one is NaN (nu at the pole)."""
    numbers = values[~np.isnan(values)]
    ends = dict.fromkeys(_number(end, form) for end in (numbers.min(), numbers.max())) if len(numbers) else ()
    return ", ".join([" to ".join(ends)] * bool(ends) + ["?"] * (len(numbers) < len(values)))


def _number(value: float, form: str) -> str:
    return "infinite" if np.isinf(value) else f"{value + 0:{form}}"


def _caption(scene: Scene, picture: NDArray[np.uint8]) -> None:
    """Darken a strip along the lower edge and write the caption there, in 1 to 3 lines so that it is legible."""
    texts = [f"{name} = {value}" for name, value in facts(scene).items()]
    widest_texts = [_widest_text(name, len(scene.distances) > 1) for name in facts(scene)]
    height, width, _ = picture.shape

    def widths(font: ImageFont.FreeTypeFont | ImageFont.ImageFont) -> Reals:
        pairs = zip(texts, widest_texts, strict=True)
        return np.array([max(font.getlength(text + "  ") for text in pair) for pair in pairs])

    for lines in (1, 2, 3):
        rows = np.array_split(np.arange(len(texts)), lines)
        widest = max(widths(ImageFont.load_default(100))[row].sum() for row in rows)
        size = min(max(TEXT * height, MIN_TEXT), 0.97 * width * 100 / widest)
        if size >= max(MIN_TEXT, 0.6 * TEXT * height):
            break
    font = ImageFont.load_default(size)
    step = round(1.4 * size)
    strip = Image.fromarray(picture[-len(rows) * step :] // 5)
    draw = ImageDraw.Draw(strip)
    for line, row in enumerate(rows):
        place = (width - widths(font)[row].sum() + font.getlength("  ")) / 2
        for n in row:
            draw.text((place, (line + 0.5) * step), texts[n], "white", font, anchor="lm")
            place += widths(font)[n]
    picture[-len(rows) * step :] = np.asarray(strip)


def _widest_text(name: str, several: bool) -> str:
    """Return a text as wide as the space that each frame reserves for a value. So a movie's caption does not move."""
    number = "0.0000" if name == "M" else "-00.00"  # at least as wide as "infinite"
    spans = several and name in ("z1", "r", "nu", "M")
    unit = "°" if name in ("alpha", "nu") else ""
    return f"{name} = {number}{f' to {number}' * spans}{', ?' * (spans and name == 'nu')}{unit}"


def _overlay(scene: Scene, picture: NDArray[np.uint8]) -> None:
    """Draw the predicted positions, and under them the curves along which these positions move."""
    height, width, _ = picture.shape
    tile = height / scene.view
    thick = max(height / 180, 1.5)
    step = max(0.5, np.sqrt(0.2 * thick))  # pixels between discs: so close together they look like a smooth line

    def pixels(points: Complexes) -> Complexes:
        return np.asarray((width / 2 - 0.5 + points.real * tile) + 1j * (height / 2 - 0.5 - points.imag * tile))

    curves = [(pixels(np.concatenate([*parts, []])), colour) for parts, colour in loci(scene, step / tile)]
    _discs(picture, np.concatenate([points for points, _ in curves]), 1.1 * thick, HALO)
    for points, colour in curves:
        _discs(picture, points, thick / 2, colour)
    for place in positions(scene):
        for radius, colour in ((2.6, HALO), (2.0, P_COLOUR), (1.0, HALO)):
            _discs(picture, pixels(np.array([place])), radius * thick, colour)


def _discs(picture: NDArray[np.uint8], points: Complexes, radius: float, colour: Colour) -> None:
    """Blend a colour over discs with smooth edges. Their centres x + iy and their radius are in pixels."""
    if not len(points):
        return
    reach = ceil(radius + 0.5)
    rows, columns = (
        slice(max(0, int(ends.min()) - reach), min(size, int(ends.max()) + reach + 2))
        for ends, size in zip((points.imag, points.real), picture.shape, strict=False)
    )
    part = picture[rows, columns]
    # for each pixel, the square of its distance from the nearest point
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
    """Return the predicted positions of the scene's objects (a piece's foot) in the plane z = 0, in tiles.

    Objects that the window frame hides from the eye are left out.
    """
    return [complex(scene.apparent_position(L, z1)) for L, z1 in scene.objects if scene.visible(L, z1)]


def loci(scene: Scene, step: float = 0.005) -> list[tuple[list[Complexes], Colour]]:
    """Return the curves along which predicted positions move, each as its visible parts and its colour.

    The first curves are for constant alpha, one for each L: z1 changes along them. If there is a single object, the
    second curve is for constant r: alpha changes along it. A part is an array of points of the plane z = 0, in tiles,
    at most `step` apart. It ends where the window frame begins to hide the object.
    """
    alpha, prism = radians(scene.alpha), scene.prism if scene.sheet == "detailed" else Prism(0.0)
    ends = scene.depth / 2, 1e4 * scene.z2
    infinite = {"single": [scene.z2], "none": []}.get(scene.sheet, paraxial.infinite_z1(scene.z2, alpha, prism).real)

    def constant_alpha(L: complex) -> Curve:
        return lambda z1: (scene.apparent_position(L, z1), scene.visible(L, z1))

    curves = [
        (_visible_parts(scene, constant_alpha(L), ends, infinite, step), ALPHA_COLOUR)
        for L in dict.fromkeys(L for L, _ in scene.objects) or [scene.L]
    ]
    if len(scene.objects) == 1 and scene.sheet in ("detailed", "ideal"):
        z1 = scene.distances[0]
        far = np.degrees(paraxial.infinite_alpha(z1, scene.z2, prism).real)

        def constant_r(alpha: Reals) -> tuple[Complexes, NDArray[np.bool_]]:
            return scene.apparent_position(scene.L, z1, alpha), scene.visible(scene.L, z1, alpha)

        curves.append((_visible_parts(scene, constant_r, (-180, 180), (-far, far), step), R_COLOUR))
    return curves


def _visible_parts(
    scene: Scene, curve: Curve, ends: tuple[float, float], infinite: Iterable[float], step: float
) -> list[Complexes]:
    """Return the visible parts of a curve between two parameters.

    `infinite` contains the parameters at which the curve can pass through infinity. Points are denser close to these
    parameters, and no part extends across them.
    """
    shares = np.geomspace(1e-14, 0.5, 320)
    shares = np.concatenate((shares, 1 - shares[::-1]))
    parts = []
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for start, end in pairwise(sorted({*ends, *(at for at in infinite if ends[0] < at < ends[1])})):
            parameter = start + (end - start) * shares
            for _ in range(60):
                place, visible = curve(parameter)
                front = scene.E + (place - scene.E) * (1 - scene.depth / 2 / scene.z2)
                outside = np.maximum(abs(front.real), abs(front.imag)) - scene.aperture / 2
                gap = abs(np.diff(place))
                # between two points that are far apart add one, unless both are far outside the window's opening
                coarse = (gap > step) & (np.minimum(outside[:-1], outside[1:]) < 2 * gap)
                if not coarse.any():
                    break
                between = (parameter[:-1] + parameter[1:])[coarse] / 2
                parameter = np.insert(parameter, np.flatnonzero(coarse) + 1, between)
            parts += [place[run] for run in np.ma.clump_unmasked(np.ma.array(place, mask=~visible))]
    return parts
