"""Draw predicted positions on a picture, and add strips with texts: the legend, and the caption."""

import re
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from itertools import combinations, islice, pairwise
from math import ceil
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from povgen.optics import apparent
from povgen.optics.prism import Prism
from povgen.rendering.views import views
from povgen.scene.scene import Scene, object_images
from povgen.scene.scenes import AxialScene
from povgen.settings import Rendering
from povgen.video.captions import Caption, captions
from povgen.video.outline import outlines
from povgen.video.text import DARK, LEGIBLE, MAX_TEXT, STRIP, TEXT, text_width, write

HALO = (255, 255, 255, 210)  # red, green, blue, opacity: the pale edge of lines and marks
# Okabe and Ito's yellow, blue and vermilion, which colour-blind readers can distinguish
P_COLOUR, ALPHA_COLOUR, R_COLOUR = (240, 228, 66, 255), (0, 114, 178, 255), (213, 94, 0, 255)
GHOST_COLOUR = (0, 158, 115, 255)  # Okabe and Ito's bluish green
IMAGE_COLOUR = (225, 0, 196, 255)  # of the predicted image
# Of the line about which a sheet mirrors or turns light. The curve of an object's predicted positions at all alpha has
# this colour too. No scene has both.
LINE_COLOUR = R_COLOUR
POINT_COLOUR = (238, 238, 238, 255)  # of the points L and E: object and eye, projected onto the plane z = 0
EDGE = (*DARK, 255)  # of points
DIRECT_COLOUR = EDGE  # of what is seen without sheets
# of the dots on the objects of a room: text and colour
THROUGH, DIRECTLY = ("seen through windows", P_COLOUR), ("seen directly", POINT_COLOUR)
OUTLINES = {  # for each name in `Scene.outlines`: its text in the legend, its colour, and the colour of its edge
    "predicted_image": ("predicted image", IMAGE_COLOUR, EDGE),
    "direct_image": ("piece as seen without sheets", DIRECT_COLOUR, HALO),
}
MARGIN = 0.015  # at each side of a strip of text, as a fraction of the picture's width
LINES = 4  # of a strip of text, at most
SAMPLE = 1.7  # width of a dot or line in a strip with the space after it, in units of the text's height
GAP = 1.4  # between two texts of a strip, in units of the text's height
FINER = 3  # discs are drawn this many times as large, and reduced
ROWS = 270  # rows of a picture whose discs are drawn at a time, so that large pictures need little additional memory

Colour = tuple[int, int, int, int]
Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Curve = Callable[[Reals], tuple[Complexes, NDArray[np.bool_]]]  # parameters to points, and whether these are visible


def annotated(
    picture: NDArray[np.uint8],
    scene: Scene,
    rendering: Rendering,
    caption: Caption | None = None,
    said: Sequence[tuple[str, Colour]] | None = None,
    sketch: Callable[[int, int], NDArray[np.uint8]] | None = None,
) -> NDArray[np.uint8]:
    """Return the scene's picture with an overlay, its legend and a caption, as `rendering` asks.

    Pictures are (height, width, 3) bytes. The legend is in a strip above the picture, the caption in a strip below it:
    they cover no part of the picture. Their heights are even numbers of pixels. Without `caption`, the caption is made
    for this scene alone. A frame of a movie needs `caption`, because it depends on all scenes of the movie. It also
    needs `said`, the entries of the legend, which `common_legend` returns. Without `said`, they are those of the
    function `legend`. Outlines of the pieces, and the line of a sheet, are drawn on the picture too. `sketch` draws the
    side view, the last strip.
    """
    height, width, _ = picture.shape
    texts = caption or captions([scene], rendering)[0]
    said = legend(scene, rendering) if said is None else said
    above = strip([Item(text, text, colour) for text, colour in said], width, height, texts.size)
    below = strip([Item(*pair) for pair in zip(texts.texts, texts.widest, strict=True)], width, height, texts.size)
    made = np.empty((len(above) + height + len(below), width, 3), np.uint8)
    made[: len(above)], made[len(above) + height :] = above, below
    shown = made[len(above) : len(above) + height]
    shown[:] = picture
    mark(shown, scene, rendering)
    return np.concatenate((made, sketch(width, height))) if sketch else made


def mark(shown: NDArray[np.uint8], scene: Scene, rendering: Rendering) -> None:
    """Draw outlines, the line of a sheet and, if `rendering` asks for it, the overlay on the scene's picture."""
    if isinstance(scene, AxialScene):
        lines = [_outline(scene, outline, shown) for outline in scene.outlines]
        if rendering.annotated and scene.sheets[0].line:
            lines.append(_sheet_line(scene, *scene.sheets[0].line[1:], shown))
        if rendering.overlay:
            _overlay(scene, shown, lines)
    elif rendering.overlay:
        for (_, colour), places in marks(scene).items():
            for place in places:
                _dot(shown, _pixels(np.array([place]), scene, shown), 1.1 * max(len(shown) / 180, 2), colour)


class Item(NamedTuple):
    """A text, the widest text that can stand there (its width is reserved), and the colour of its dot or line."""

    text: str
    widest: str
    colour: Colour | None = None


def marks(scene: Scene) -> dict[tuple[str, Colour], list[complex]]:
    """Return where the eye sees a room's objects, in the picture's plane: for each text and colour of the legend.

    An object that is seen several times has several marks.
    """
    found: dict[tuple[str, Colour], list[complex]] = {THROUGH: [], DIRECTLY: []}
    for image in (image for _, images in object_images(scene) for image in images):
        found[THROUGH if image.windows else DIRECTLY].append(image.position)
    return {kind: places for kind, places in found.items() if places}


def legend(scene: Scene, rendering: Rendering) -> list[tuple[str, Colour]]:
    """Return what the legend above the picture says: a text for each kind of mark or line on the picture.

    If the picture has no caption, note, side view or overlay, `rendering.annotated` is false, and there is no legend.
    """
    if not isinstance(scene, AxialScene):
        return [*marks(scene)] if rendering.overlay else []
    two = scene.rotates
    texts = []
    if rendering.overlay and positions(scene):
        texts.append(("predicted P" if len(scene.objects) == 1 else "predicted positions", P_COLOUR))
    if rendering.overlay and ghosts(scene):
        texts.append(("predicted ghosts", GHOST_COLOUR))
    if rendering.overlay:
        texts.append((f"{'P' if len(scene.objects) == 1 else 'positions'} at all distances z₁", ALPHA_COLOUR))
    if rendering.overlay and two and len(scene.objects) == 1 and not scene.window:
        texts.append(("P at all α", R_COLOUR))
    if rendering.annotated and scene.sheets[0].line:
        texts.append((scene.sheets[0].line[0], LINE_COLOUR))
    if rendering.overlay:
        names = {"L": "object", "E": "eye"}
        if letters := [name for name in _named(scene) if name in names]:
            things = " and ".join(names[name] for name in letters)
            texts.append((f"{', '.join(letters)}: {things}, projected", POINT_COLOUR))
    if rendering.annotated:
        texts += [OUTLINES[name][:2] for name in scene.outlines]
    return texts


def common_legend(scenes: Iterable[Scene], rendering: Rendering) -> list[tuple[str, Colour]]:
    """Return the common legend of a movie's frames, or of the two pictures of a stereo pair: the entries of all.

    Then all strips are equally high, even if a point is in the window in some frames only.
    """
    shown = (view for scene in scenes for view in views(scene, rendering))
    return list(dict.fromkeys(item for view in shown for item in legend(view, rendering)))


def _broken(item: Item, most: float, size: float) -> list[Item]:
    """Return an item's lines. They are at most as wide as `most`, in units of the text's height, if no word is wider.

    The lines of all frames of a movie break after the same words: `Caption.widest` has the widest of each word. They
    are about equally wide.
    """
    width = most - SAMPLE * bool(item.colour)
    if text_width(item.widest, size) <= width:
        return [item]
    every = [_wrapped(item.widest, share * width, size) for share in np.linspace(1, 0.4, 25)]
    lines = [each for each in every if len(each) == len(every[0])][-1]
    if len(_words(item.text)) == len(_words(item.widest)):
        words = iter(_words(item.text))
        texts = [" ".join(islice(words, len(line))) for line in lines]
        texts[-1] = " ".join(filter(None, [texts[-1], *words]))
    else:  # another note
        texts = [" ".join(line) for line in _wrapped(item.text, width, size)]
        texts[len(lines) - 1 :] = [" ".join(texts[len(lines) - 1 :])]
        texts += [""] * (len(lines) - len(texts))
    colours = [item.colour, *[None] * (len(lines) - 1)]
    return [Item(text, " ".join(line), colour) for text, line, colour in zip(texts, lines, colours, strict=True)]


def _words(text: str) -> list[str]:
    """Return the words of a text. No line breaks at an equals sign."""
    return re.split("(?<!=) (?!=)", text)


def _wrapped(text: str, width: float, size: float) -> list[list[str]]:
    """Return the words of a text in lines that are at most so wide, if no word is wider."""
    lines: list[list[str]] = [[]]
    for word in _words(text):
        if lines[-1] and text_width(" ".join([*lines[-1], word]), size) > width:
            lines.append([])
        lines[-1].append(word)
    return lines


@lru_cache(16)  # all frames of a movie have the same
def _rows(widths: tuple[float, ...], most: float, most_lines: int) -> tuple[list[range], float]:
    """Divide items into lines. Return the numbers, from 0, of each line's items, and the width of the longest line.

    `widths` are those of the items, each with the gap after it. There are as few lines as possible with lines no wider
    than `most`, but at most `most_lines`. The items are divided so that the longest line is as short as possible.
    """
    for lines in range(1, min(most_lines, len(widths)) + 1):
        starts = ([*places, len(widths)] for places in combinations(range(1, len(widths)), lines - 1))
        every = ([range(a, b) for a, b in pairwise([0, *places])] for places in starts)
        widest, rows = min(
            ((max(sum(widths[n] for n in row) for row in way) - GAP, way) for way in every), key=itemgetter(0)
        )
        if widest <= most:
            break
    return rows, widest


def strip(items: list[Item], width: int, height: int, larger: float = 1, most: int = LINES) -> NDArray[np.uint8]:
    """Return a strip with items for a picture of this size, in 1 to `most` lines; without items, a strip without rows.

    The text's height is a fraction of the picture's height, times `larger`. In small pictures this fraction is greater,
    so that the text stays legible. An item that is wider than the picture is broken between words. If the items do not
    fit, the text is made smaller.
    """
    if not items:
        return np.empty((0, width, 3), np.uint8)
    size = larger * max(TEXT * height, min(LEGIBLE, MAX_TEXT * height))
    free = (1 - 2 * MARGIN) * width
    whole = items
    while True:
        several = [_broken(item, free / size, size) for item in whole]
        items = [part for parts in several for part in parts]
        # the widths of items, each with the gap after it, in units of the text's height
        widths = [text_width(item.widest, size) + SAMPLE * bool(item.colour) + GAP for item in items]
        # a part of a broken text has a line of its own
        whole_lines = [len(parts) > 1 for parts in several for _ in parts]
        needed = (max(wide, alone * free / size) for wide, alone in zip(widths, whole_lines, strict=True))
        rows, widest = _rows(tuple(needed), free / size, most)
        if widest <= free / size:
            break
        size *= 0.95  # smaller text breaks at other words
    step = 2 * ceil(0.8 * size)  # even, because a movie stores pixels in blocks of 2x2
    image = Image.new("RGB", (width, len(rows) * step), STRIP)
    draw = ImageDraw.Draw(image)
    samples = []
    for line, row in enumerate(rows):
        place, middle = (width - size * (np.take(widths, row).sum() - GAP)) / 2, (line + 0.5) * step
        for n in row:
            colour = items[n].colour
            if colour:
                samples.append((place + size * np.linspace(0.2, SAMPLE - 0.6, 60) + 1j * middle, colour))
            left = place + size * SAMPLE * bool(colour)
            if whole_lines[n]:  # it can be another text than the widest
                left += size * (text_width(items[n].widest, size) - text_width(items[n].text, size)) / 2
            write(draw, left, middle, items[n].text, size)
            place += size * widths[n]
    strip = np.array(image)
    for points, colour in samples:
        dot = colour in (P_COLOUR, GHOST_COLOUR, POINT_COLOUR)
        for radius, colour_ in ((0.24, HALO), (0.15, colour)):
            _discs(strip, points.mean(keepdims=True) if dot else points, radius * size * (1.3 if dot else 0.8), colour_)
    return strip


def _overlay(scene: AxialScene, picture: NDArray[np.uint8], lines: Sequence[Complexes]) -> None:
    """Draw the curves along which the predicted positions move. Then draw points on them.

    The points are the predicted positions, those of ghosts, and L and E with their letters, which avoid what is drawn,
    also `lines`, pixels.
    """
    height = len(picture)
    tile = height / scene.view
    # smaller if there are several objects: these can be small, and as near to each other as a line is wide
    several = len(scene.objects) > 1
    thick = max(height / 180, 1.5) * (0.6 if several else 1)
    step = max(0.5, np.sqrt(0.2 * thick))  # pixels between discs, which then look like a smooth line

    def pixels(points: Complexes) -> Complexes:
        return _pixels(points, scene, picture)

    curves = [(pixels(np.concatenate([*parts, []])), colour) for parts, colour in loci(scene, step / tile)]
    _discs(picture, np.concatenate([[], *(points for points, _ in curves)]), 1.2 * thick, HALO)
    for points, colour in curves:
        _discs(picture, points, thick / 2, colour)
    for place in ghosts(scene):
        _discs(picture, pixels(np.array([place])), 1.5 * thick, HALO)
        _discs(picture, pixels(np.array([place])), 0.9 * thick, GHOST_COLOUR)
    named = _named(scene)
    for place in positions(scene):
        _dot(picture, pixels(np.array([place])), (1.1 if several else 1.7) * max(thick, 2), P_COLOUR)
    for name, place in named.items():
        if name != "P":
            for radius, colour in ((1.3, EDGE), (0.9, POINT_COLOUR)):
                _discs(picture, pixels(np.array([place])), radius * max(thick, 2), colour)
    places = {name: complex(pixels(np.array([place]))[0]) for name, place in named.items()}
    drawn = np.concatenate([*lines, *(points for points, _ in curves), pixels(np.array([*positions(scene)], complex))])
    for name, place in places.items():
        drawn = _letter(picture, name, place, [other for other in places.values() if other != place], drawn)


def _sheet_line(scene: AxialScene, way: complex, picture: NDArray[np.uint8]) -> Complexes:
    """Draw and return the line in the first window about which its sheet mirrors or turns light."""
    thick = max(len(picture) / 180, 1.5)
    step = max(0.5, np.sqrt(0.2 * thick)) * scene.view / len(picture)
    half = scene.aperture / 2 * abs(way) / max(abs(way.real), abs(way.imag))
    points = _pixels(np.asarray(way / abs(way) * np.arange(-half, half, step), complex), scene, picture)
    for radius, colour in ((0.9, HALO), (0.5, LINE_COLOUR)):
        _discs(picture, points, radius * thick, colour)
    return points


def _outline(scene: AxialScene, outline: str, picture: NDArray[np.uint8]) -> Complexes:
    """Draw and return the pieces' outlines: where they are predicted, or where the eye sees them without sheets."""
    if outline == "direct_image":
        # the windows remain, without their sheets, because z1 is the distance from the last one
        empty = [{"z": window.z, "sheet": "none"} for window in scene.window]
        changes = {"sheet": "none", "window": empty, "predicted_image": False, "view": scene.view}
        scene = scene.model_copy(update=changes)
    thick = max(len(picture) / 260, 1.2)
    step = max(0.5, np.sqrt(0.2 * thick)) * scene.view / len(picture)
    points = _pixels(outlines(scene, step), scene, picture)
    _, line, edge = OUTLINES[outline]
    for radius, colour in ((1.25, edge), (0.7, line)):
        _discs(picture, points, radius * thick, colour)
    return points


def _dot(picture: NDArray[np.uint8], place: Complexes, radius: float, colour: Colour) -> None:
    """Draw a dot with a dark and a pale edge. Its place (1,) and radius are in pixels."""
    for part, each in ((1.9 / 1.1, HALO), (1.5 / 1.1, EDGE), (1, colour)):
        _discs(picture, place, part * radius, each)


def _pixels(points: Complexes, scene: Scene, picture: NDArray[np.uint8]) -> Complexes:
    """Return where points of the picture's plane, in tiles, are on the picture, in pixels: x + iy, y downwards."""
    height, width, _ = picture.shape
    tile, points = height / scene.camera.height, points - scene.middle
    return np.asarray((width / 2 - 0.5 + points.real * tile) + 1j * (height / 2 - 0.5 - points.imag * tile))


def _named(scene: AxialScene) -> dict[str, complex]:
    """Return the points of the plane z = 0 that have a letter and are in the window: L, E, and P of a single object."""
    points = {"L": scene.L, "E": scene.E} if scene.objects else {}
    if len(scene.objects) == 1:
        points |= dict(zip("P", positions(scene), strict=False))
    half = scene.aperture / 2
    return {name: z for name, z in points.items() if max(abs(z.real), abs(z.imag)) < half}


def _letter(
    picture: NDArray[np.uint8], name: str, place: complex, others: Sequence[complex], drawn: Complexes
) -> Complexes:
    """Write a point's letter beside it. Return what is `drawn` then.

    It is on the side that is away from the other points, or else where it covers least of what is drawn.
    """
    height, width, _ = picture.shape
    size = 1.3 * max(TEXT * min(height, width * 4 / 3), LEGIBLE)
    away = sum((place - other) / abs(place - other) ** 2 for other in others) or 1 - 1j
    turns = np.exp(1j * np.pi / 8 * np.array([0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6, 7, -7, 8]))
    middles = place + size * turns * away / abs(away)
    covered = [(abs(drawn - middle) < 0.75 * size).sum() for middle in middles]
    middle = complex(middles[np.argmin(covered)])
    left, top = round(middle.real - size), round(middle.imag - size)
    rows = slice(max(top, 0), max(round(top + 2 * size), 0))
    columns = slice(max(left, 0), max(round(left + 2 * size), 0))
    part = picture[rows, columns]
    if part.size:
        image = Image.fromarray(part)
        at = middle - complex(columns.start, rows.start) - size * text_width(name) / 2
        write(ImageDraw.Draw(image), at.real, at.imag, name, size, edge=max(1, round(size / 12)))
        part[:] = np.asarray(image)
    return np.append(drawn, middle + 0.4 * size * turns)


def _discs(picture: NDArray[np.uint8], points: Complexes, radius: float, colour: Colour) -> None:
    """Blend a colour over discs. Their centres x + iy and their radius are in pixels.

    For smooth edges they are drawn FINER times as large, and reduced.
    """
    reach = radius + 1
    for top in range(0, len(picture), ROWS):
        some = points[abs(points.imag - top - ROWS / 2) < ROWS / 2 + reach]
        if not len(some):
            continue
        left, right = (max(0, int(end)) for end in (some.real.min() - reach, some.real.max() + reach + 1))
        part = picture[top : top + ROWS, left:right]
        if not part.size:
            continue
        mask = Image.new("L", (FINER * part.shape[1], FINER * len(part)))
        draw = ImageDraw.Draw(mask)
        half = FINER * radius * (1 + 1j)
        for centre in FINER * (some - complex(left, top) + 0.5 + 0.5j):
            low, high = centre - half, centre + half - 1 - 1j
            draw.ellipse([round(x) for x in (low.real, low.imag, high.real, high.imag)], fill=colour[3])
        image = Image.fromarray(part)
        image.paste(colour[:3], mask=mask.reduce(FINER))
        part[:] = np.asarray(image)


def positions(scene: AxialScene) -> list[complex]:
    """Return where the scene's objects are predicted to appear in the plane z = 0, in tiles.

    The position is that of a piece's foot, or of a sphere's middle.

    Objects that the window frame hides from the eye are left out. Through some sheets, such as `axis`, light
    from the foot or the middle may not reach the eye, although light from other points of the object does. Then the
    position is where the visible part appears.
    """
    objects = [(L, z1, None, radius) for (L, z1), radius in zip(scene.objects, scene.radii, strict=True)]
    return [complex(position) for position, visible in (scene.seen(*each) for each in objects) if visible]


@lru_cache(maxsize=4096)  # through lenses it takes half a second, and both the legend and the overlay need it
def ghosts(scene: AxialScene) -> list[complex]:
    """Return the predicted positions of the objects' ghosts through lenses (`Scene.ghosts`), in tiles."""
    return [ghost.position for L, z1 in scene.objects for ghost in scene.ghosts(L, z1)]


def loci(scene: AxialScene, step: float = 0.005) -> list[tuple[list[Complexes], Colour]]:
    """Return the curves along which predicted positions move, each as its visible parts and its colour.

    The first curves, one for each L, have constant alpha, and z1 changes along them. If there is a single object, and a
    single window that turns light about the normal, one more curve follows: along it alpha changes, and z1 is constant.
    A part is an array of points of the plane z = 0, at most `step` apart. It ends where a window frame begins to hide
    the object, and where the curve passes through infinity.
    """
    ends = scene.depth / 2, 1e4 * scene.z2
    infinite = apparent.infinite_z1(scene.elements)

    curves = [
        (_visible_parts(scene, partial(scene.seen, L), ends, infinite, step), ALPHA_COLOUR)
        for L in dict.fromkeys(L for L, _ in scene.objects) or [scene.L]
    ]
    if len(scene.objects) == 1 and not scene.window and scene.rotates:
        z1 = scene.distances[0]
        shape = scene.layered[0].shape if scene.layered else Prism(0.0)
        far = np.degrees(apparent.infinite_alpha(z1, scene.z2, shape).real)
        curves.append(
            (_visible_parts(scene, partial(scene.seen, scene.L, z1), (-180, 180), (-far, far), step), R_COLOUR)
        )
    return curves


def _visible_parts(
    scene: AxialScene, curve: Curve, ends: tuple[float, float], infinite: Iterable[float], step: float
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
            place, visible = curve(parameter)
            for _ in range(60):
                front = scene.E + (place - scene.E) * (1 - scene.depth / 2 / scene.z2)
                outside = np.maximum(abs(front.real), abs(front.imag)) - scene.aperture / 2
                gap = abs(np.diff(place))
                # Add a point between two neighbours that are more than `step` apart. It is not needed if both are far
                # outside the window's opening: farther than twice their distance from each other.
                coarse = (gap > step) & (np.minimum(outside[:-1], outside[1:]) < 2 * gap)
                if not coarse.any():
                    break
                between = (parameter[:-1] + parameter[1:])[coarse] / 2
                at, new = np.flatnonzero(coarse) + 1, curve(between)
                parameter = np.insert(parameter, at, between)
                place, visible = np.insert(place, at, new[0]), np.insert(visible, at, new[1])
            parts += [place[run] for run in np.ma.clump_unmasked(np.ma.array(place, mask=~visible))]
    return parts
