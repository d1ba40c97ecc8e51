"""Draw on a frame: a caption with the scene's parameters, and an overlay with predicted positions and its key."""

from collections.abc import Callable, Iterable
from itertools import pairwise
from math import ceil, radians
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from povgen.optics import aim, paraxial, rotation
from povgen.scene.models import Scene
from povgen.settings import Rendering
from povgen.sheets.prisms import PRISMS

HALO = (0, 0, 0, 170)  # red, green, blue, opacity
# Okabe and Ito's yellow, sky blue and vermilion, which colour-blind readers can distinguish
P_COLOUR, ALPHA_COLOUR, R_COLOUR = (240, 228, 66, 255), (86, 180, 233, 255), (213, 94, 0, 255)
IMAGE_COLOUR = (225, 0, 196, 255)  # of the predicted image, in templates/chess.pov.j2
# Height of text, as a fraction of the picture's height. In a small picture it is higher, to be at least LEGIBLE pixels
# high, but not higher than MAX_TEXT.
TEXT, MAX_TEXT, LEGIBLE = 0.041, 0.05, 12
MARGIN = 0.015  # at each side of a strip of text, as a fraction of the picture's width
SYMBOLS = {"alpha": "α", "nu": "ν", "z1": "z₁", "z2": "z₂"}
FONT = Path(__file__).with_name("NotoSans.ttf")  # NotoSans.txt says where it is from
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
    if colours := key(scene, rendering):
        _strip(picture, [Item(text, text, colour) for text, colour in colours], at_top=True)
    if rendering.caption:
        texts = (f"{_symbol(name)} = {value}" for name, value in facts(scene).items())
        several, windows = len(scene.distances) > 1, len(scene.places)
        widest = (_widest_text(name, several, windows) for name in facts(scene))
        _strip(picture, [Item(*texts) for texts in zip(texts, widest, strict=True)], at_top=False)
    return picture


def facts(scene: Scene) -> dict[str, str]:
    """Return what the caption says: alpha, z1, z2, r, nu and M, as text. Windows in series have their z in place of r.

    For several objects a value is a range. nu and M are predictions for prisms of the scene's size (`Scene.nu_and_M`).
    """
    z1 = np.array(scene.distances)
    texts = {"z1": _range(z1, ".4g"), "z2": _number(scene.z2, ".4g"), "r": _range(rotation.r(z1, scene.z2))}
    other = not (scene.rotates or scene.is_empty or scene.sheet == "single")
    if scene.window or other:  # r is for a single window that rotates light
        del texts["r"]
    if scene.window:
        texts = {"z": ", ".join(_number(z, ".4g") for z in scene.places), **texts}
    if scene.rotates:
        nu, M = scene.nu_and_M(z1)
        texts = {**_values(scene), **texts, "nu": f"{_range(nu, '.1f')}°", "M": _range(M)}
    if other:
        texts = {**_values(scene), **texts}
    return texts


def _symbol(name: str) -> str:
    """Return what a caption calls a value: focal_length is two words."""
    return SYMBOLS.get(name, name.replace("_", " "))


def _values(scene: Scene) -> dict[str, str]:
    """Return the numbers of the sheets' parameters, as text: for each name those of all windows that have it."""
    found: dict[str, list[str]] = {}
    for sheet in scene.sheets:
        numbers = [each for each in sheet.parameters if each.kind == "number" and each not in PRISMS]
        for each in numbers:
            x = sheet.values[each.name]
            unit = each.unit.replace("degrees", "°").replace(" a ", "/")
            text = f"{x:z.1f}{unit}" if unit.startswith("°") else _number(x, ".3g")
            found.setdefault(each.name, []).append(text)
        for name, x in sheet.values.get("parameter", {}).items():
            found.setdefault(name, []).append(_number(x, ".3g"))
    return {name: ", ".join(texts) for name, texts in found.items()}


def _range(values: Reals, form: str = ".3g") -> str:
    """Return the least and the greatest number as text, and '?' if one is NaN (nu at the pole)."""
    numbers = values[~np.isnan(values)]
    ends = dict.fromkeys(_number(end, form) for end in (numbers.min(), numbers.max())) if len(numbers) else ()
    unknown = "?" if len(numbers) < len(values) else ""
    return ", ".join(filter(None, [" to ".join(ends), unknown]))


def _number(value: float, form: str) -> str:
    if np.isinf(value):
        return "infinite"
    text = f"{value:z{form}}"  # z: 0.0 in place of -0.0
    return f"{float(text):g}" if "g" in form else text  # 5000 in place of 5e+03


class Item(NamedTuple):
    """A text, the widest text that can stand there (its width is reserved), and the colour of its swatch, if any."""

    text: str
    widest: str
    colour: Colour | None = None


def key(scene: Scene, rendering: Rendering) -> list[tuple[str, Colour]]:
    """Return what the key along the upper edge says: a text for each colour that is drawn on the picture.

    A picture without a caption and an overlay has no key.
    """
    two = scene.rotates
    texts = []
    if rendering.overlay and scene.objects:
        texts.append(("predicted position", P_COLOUR))
    if rendering.overlay:
        texts.append(("constant α" if two else "z₁ varies", ALPHA_COLOUR))
    if rendering.overlay and two and len(scene.objects) == 1 and not scene.window:
        texts.append(("constant r", R_COLOUR))
    if rendering.annotated and getattr(scene, "predicted_image", False):
        texts.append(("predicted image", IMAGE_COLOUR))
    return texts


def _strip(picture: NDArray[np.uint8], items: list[Item], at_top: bool) -> None:
    """Darken a strip along an edge and write items there, in 1 to 3 lines.

    The text has the same height, relative to the picture, in all pictures. It is lower only if even 3 lines have too
    little room.
    """
    height, width, _ = picture.shape
    size = max(TEXT * height, min(LEGIBLE, MAX_TEXT * height))
    free = (1 - 2 * MARGIN) * width
    # the widths of items, each with the gap after it, in units of the text's height
    sample, gap = 1.7, 0.8
    widths = [max(_width(item.text), _width(item.widest)) + sample * bool(item.colour) + gap for item in items]
    for lines in (1, 2, 3):
        rows = np.array_split(np.arange(len(items)), lines)
        widest = max(np.take(widths, row).sum() for row in rows) - gap
        if size * widest <= free:
            break
    size = min(size, free / widest)
    step = round(1.5 * size)
    strip = picture[: lines * step] if at_top else picture[-lines * step :]
    image = Image.fromarray(strip // 5)
    draw = ImageDraw.Draw(image)
    samples = []
    for line, row in enumerate(rows):
        place, middle = (width - size * (np.take(widths, row).sum() - gap)) / 2, (line + 0.5) * step
        for n in row:
            colour = items[n].colour
            if colour:
                samples.append((place + size * np.linspace(0.2, sample - 0.6, 60) + 1j * middle, colour))
            _write(draw, place + size * sample * bool(colour), middle, items[n].text, size)
            place += size * widths[n]
    strip[:] = np.asarray(image)
    for points, colour in samples:
        _discs(strip, points.mean(keepdims=True) if colour == P_COLOUR else points, size / 8, colour)


def _width(text: str) -> float:
    """Return the width of a text, in units of its height."""
    return _font(100).getlength(text) / 100


def _write(draw: ImageDraw.ImageDraw, x: float, middle: float, text: str, size: float) -> None:
    """Write a text in white. x is its left edge, `middle` the middle of its letters' height, in pixels."""
    draw.text((x, middle + 0.36 * size), text, "white", _font(size), anchor="ls")


def _font(size: float) -> ImageFont.FreeTypeFont:
    # with the basic layout, places of letters do not depend on whether Pillow has Raqm
    return ImageFont.truetype(str(FONT), size, layout_engine=ImageFont.Layout.BASIC)


def _widest_text(name: str, several: bool, windows: int) -> str:
    """Return a text as wide as the space that each frame reserves for a value. So a movie's caption does not move."""
    number = {"alpha": "000.0", "nu": "-00.0", "M": "0.0000" if several else "infinite"}.get(name, "0.000")
    spans = several and name in ("z1", "r", "nu", "M")
    unit = "°" if name in ("alpha", "nu") else ""
    if name in ("alpha", "z"):  # of other parameters the space is that of one window
        number = ", ".join([number + unit * (name == "alpha")] * windows)
        unit = ""
    return f"{_symbol(name)} = {number}{f' to {number}' * spans}{', ?' * (spans and name == 'nu')}{unit}"


def _overlay(scene: Scene, picture: NDArray[np.uint8]) -> None:
    """Draw the predicted positions, and under them the curves along which these positions move."""
    height, width, _ = picture.shape
    tile = height / scene.view
    # thinner for several objects, which can be as small as their marks and as close as the line is wide
    thick = max(height / 180, 1.5) * (0.6 if len(scene.objects) > 1 else 1)
    step = max(0.5, np.sqrt(0.2 * thick))  # pixels between discs, which then look like a smooth line

    def pixels(points: Complexes) -> Complexes:
        return np.asarray((width / 2 - 0.5 + points.real * tile) + 1j * (height / 2 - 0.5 - points.imag * tile))

    curves = [(pixels(np.concatenate([*parts, []])), colour) for parts, colour in loci(scene, step / tile)]
    _discs(picture, np.concatenate([points for points, _ in curves]), 0.9 * thick, HALO)
    for points, colour in curves:
        _discs(picture, points, thick / 2, colour)
    for place in positions(scene):
        for radius, colour in ((1.7, HALO), (1.1, P_COLOUR)):  # small, so that spheres stay visible
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

    Objects that the window frame hides from the eye are left out. Where no light of an object's middle reaches the eye
    through one of the other sheets, but light of the object beside it does, the position is that of this light.
    """
    objects = [(L, z1, None, radius) for (L, z1), radius in zip(scene.objects, scene.radii, strict=True)]
    return [complex(scene.apparent_position(*each)) for each in objects if scene.visible(*each)]


def loci(scene: Scene, step: float = 0.005) -> list[tuple[list[Complexes], Colour]]:
    """Return the curves along which predicted positions move, each as its visible parts and its colour.

    The first curves are for constant alpha, one for each L: z1 changes along them. If there are a single object and a
    single window, the second curve is for constant r: alpha changes along it. A part is an array of points of the plane
    z = 0, in tiles, at most `step` apart. It ends where a window frame begins to hide the object.
    """
    alpha, prisms = radians(scene.alpha), scene.prisms_by_window
    ends = scene.depth / 2, 1e4 * scene.z2
    infinite = (
        paraxial.infinite_z1(scene.z2, alpha, prisms, scene.behind).real
        if scene.rotates
        else aim.infinite_z1(scene.elements)
    )

    def constant_alpha(L: complex) -> Curve:
        return lambda z1: (scene.apparent_position(L, z1), scene.visible(L, z1))

    curves = [
        (_visible_parts(scene, constant_alpha(L), ends, infinite, step), ALPHA_COLOUR)
        for L in dict.fromkeys(L for L, _ in scene.objects) or [scene.L]
    ]
    if len(scene.objects) == 1 and not scene.window and scene.rotates:
        z1 = scene.distances[0]
        far = np.degrees(paraxial.infinite_alpha(z1, scene.z2, prisms[0]).real)

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
