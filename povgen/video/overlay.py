"""Draw predicted positions on a picture, and say what the legend above it says."""

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from povgen.optics import apparent
from povgen.optics.prism import Prism
from povgen.rendering.views import views
from povgen.scene.presets import AxialScene
from povgen.scene.scene import Scene, object_images
from povgen.settings import Rendering
from povgen.video.caption_strips import HALO, Colour, Complexes, Item, discs, strip
from povgen.video.caption_texts import Caption, captions
from povgen.video.piece_outline import outlines
from povgen.video.text import DARK, LEGIBLE, TEXT, text_width, write

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

Reals = NDArray[np.float64]
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
    above = strip(legend_items(said), width, height, texts.size)
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


def legend_items(said: Iterable[tuple[str, Colour]]) -> list[Item]:
    """Return the legend's entries for the strip: each has a dot or a line of its colour."""
    return [Item(text, text, colour, colour in (P_COLOUR, GHOST_COLOUR, POINT_COLOUR)) for text, colour in said]


def common_legend(scenes: Iterable[Scene], rendering: Rendering) -> list[tuple[str, Colour]]:
    """Return the common legend of a movie's frames, or of the two pictures of a stereo pair: the entries of all.

    Then all strips are equally high, even if a point is in the window in some frames only.
    """
    shown = (view for scene in scenes for view in views(scene, rendering))
    return list(dict.fromkeys(item for view in shown for item in legend(view, rendering)))


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
    discs(picture, np.concatenate([[], *(points for points, _ in curves)]), 1.2 * thick, HALO)
    for points, colour in curves:
        discs(picture, points, thick / 2, colour)
    for place in ghosts(scene):
        discs(picture, pixels(np.array([place])), 1.5 * thick, HALO)
        discs(picture, pixels(np.array([place])), 0.9 * thick, GHOST_COLOUR)
    named = _named(scene)
    for place in positions(scene):
        _dot(picture, pixels(np.array([place])), (1.1 if several else 1.7) * max(thick, 2), P_COLOUR)
    for name, place in named.items():
        if name != "P":
            for radius, colour in ((1.3, EDGE), (0.9, POINT_COLOUR)):
                discs(picture, pixels(np.array([place])), radius * max(thick, 2), colour)
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
        discs(picture, points, radius * thick, colour)
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
    if outline == "direct_image" and len(points):  # it does not hide a small piece that is seen beside it
        thick = max(min(thick, np.ptp(points.imag) / 70), 1.0)
    _, line, edge = OUTLINES[outline]
    for radius, colour in ((1.25, edge), (0.7, line)):
        discs(picture, points, radius * thick, colour)
    return points


def _dot(picture: NDArray[np.uint8], place: Complexes, radius: float, colour: Colour) -> None:
    """Draw a dot with a dark and a pale edge. Its place (1,) and radius are in pixels."""
    for part, each in ((1.9 / 1.1, HALO), (1.5 / 1.1, EDGE), (1, colour)):
        discs(picture, place, part * radius, each)


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
