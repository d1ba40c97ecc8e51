"""What is drawn over a frame: a strip that tells its parameters, and where the equations have what is seen."""

import re
from math import radians

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from povgen import rotation
from povgen.rendering import Rendering
from povgen.scenes import Scene

FINENESS = 4  # lines are drawn so many times as large, and then made smaller
HALO = (0, 0, 0, 170)
# told apart by all eyes, and in grey: Okabe and Ito's yellow, sky blue and vermilion
P_COLOUR, ALPHA_COLOUR, R_COLOUR = (240, 228, 66, 255), (86, 180, 233, 255), (213, 94, 0, 255)
LEAST_TEXT, STRIP = 12, 0.05  # height of the text: pixels, and share of the picture's height


def annotated(picture: np.ndarray, scene: Scene, rendering: Rendering) -> np.ndarray:
    """The scene's picture, (height, width, 3) bytes, with the overlay and the caption that the rendering asks for."""
    image = Image.fromarray(picture)
    if rendering.overlay:
        image.paste(*_overlay(scene, image.size))
    if rendering.caption:
        _caption(scene, image)
    return np.asarray(image)


def facts(scene: Scene) -> dict[str, str]:
    """What the caption says: alpha, z1, z2, r, nu and M, as text; of several objects the first and the last."""
    z1 = np.array(scene.distances)
    r = rotation.r(z1, scene.z2)
    told = {"z1": _span(z1), "z2": f"{scene.z2:g}", "r": _span(r)}
    if scene.sheet in ("detailed", "ideal"):
        nu, M = (f(r, radians(scene.alpha)) for f in (rotation.nu, rotation.M))
        told = {"alpha": f"{scene.alpha:.4g}°", **told, "nu": f"{_span(np.degrees(nu), '.1f')}°", "M": _span(M)}
    return told


def _span(values: np.ndarray, form: str = ".3g") -> str:
    ends = dict.fromkeys(_number(value, form) for value in values[[0, -1]])
    return " to ".join(ends)


def _number(value: float, form: str) -> str:
    """A number as text, '?' where there is none, as for nu at the pole."""
    return "?" if np.isnan(value) else "infinite" if np.isinf(value) else f"{value + 0:{form}}"


def _caption(scene: Scene, image: Image.Image) -> None:
    """Darken a strip along the lower edge and write in it, in as many lines as keep it legible."""
    told = [f"{name} = {value}" for name, value in facts(scene).items()]
    # a movie's text stands still: each fact has the room of all numbers of its form
    room = [re.sub(r"(?<= )([\d.?-]+|infinite)", "-00.00", text) + "  " for text in told]
    width, height = image.size
    for lines in (1, 2, 3):
        rows = np.array_split(np.arange(len(told)), lines)
        font = ImageFont.load_default(100)
        widest = max(sum(font.getlength(room[n]) for n in row) for row in rows)
        size = min(max(STRIP * height, LEAST_TEXT), 0.97 * width * 100 / widest)
        if size >= LEAST_TEXT:
            break
    font = ImageFont.load_default(size)
    step = round(1.4 * size)
    top = height - len(rows) * step
    strip = image.crop((0, top, width, height)).point(lambda value: value // 5)
    image.paste(strip, (0, top))
    draw = ImageDraw.Draw(image)
    for line, row in enumerate(rows):
        place = (width - sum(font.getlength(room[n]) for n in row) + font.getlength("  ")) / 2
        for n in row:
            draw.text((place, top + (line + 0.5) * step), told[n], "white", font, anchor="lm")
            place += font.getlength(room[n])


def _overlay(scene: Scene, size: tuple[int, int]) -> tuple[Image.Image, tuple[int, int], Image.Image]:
    """What to paste for the predicted positions and the curves that they move on: an image, where, and its mask."""
    width, height = (FINENESS * pixels for pixels in size)
    layer = Image.new("RGBA", (width, height))
    draw = ImageDraw.Draw(layer)
    thick = max(height / 180, 1.5 * FINENESS)

    def pixel(place: np.ndarray) -> np.ndarray:
        tile = height / scene.view_height
        return np.stack((width / 2 + place.real * tile, height / 2 - place.imag * tile), -1)

    curves = loci(scene)
    for line, colour, wide in [*((line, HALO, 2.2) for line, _ in curves), *((*curve, 1) for curve in curves)]:
        points = pixel(line)
        # what lies far outside, near the pole, would be too large for the drawing
        far = ~(abs(points) < 4 * width).all(-1)
        for part in np.ma.clump_unmasked(np.ma.array(far, mask=far)):
            draw.line(_spaced(points[part], 2 * thick), colour, round(wide * thick), joint="curve")
    for place in positions(scene):
        if np.isfinite(place):
            x, y = pixel(np.array(place))
            for radius, colour in ((2.6, HALO), (2.0, P_COLOUR), (1.0, HALO)):
                reach = radius * thick
                if abs(x) < 2 * width and abs(y) < 2 * height:
                    draw.ellipse((x - reach, y - reach, x + reach, y + reach), colour)
    layer = layer.resize(size, Image.Resampling.BOX)
    return layer.convert("RGB"), (0, 0), layer.getchannel("A")


def _spaced(points: np.ndarray, least: float) -> list[tuple[float, float]]:
    """Points of a line some way apart, for where short pieces are joined it looks rough."""
    kept = [tuple(point) for point in points[:1]]
    for point in points[1:]:
        if np.hypot(*(point - kept[-1])) > least:
            kept.append(tuple(point))
    return [*kept, *(tuple(point) for point in points[-1:])]


def positions(scene: Scene) -> list[complex]:
    """Where the scene's objects (of a piece, its foot) are predicted, in the plane z = 0, tiles."""
    return [complex(scene.seen(scene.L, z1)) for z1 in scene.distances]


def loci(scene: Scene) -> list[tuple[np.ndarray, tuple[int, ...]]]:
    """Curves that apparent positions move on, in tiles, and their colours: as z1 changes (alpha constant), and, for a
    single object, as alpha changes (r constant)."""
    z1 = np.geomspace(scene.depth / 2, 1e4 * scene.z2, 721)
    curves: list[tuple[np.ndarray, tuple[int, ...]]] = [(scene.seen(scene.L, z1), ALPHA_COLOUR)]
    if len(scene.distances) == 1 and scene.sheet in ("detailed", "ideal"):
        curves.append((scene.seen(scene.L, scene.distances[0], np.arange(-180, 180.5, 0.5)), R_COLOUR))
    return curves
