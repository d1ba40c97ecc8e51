"""A view of a scene from the side or from above, to scale: the eye, the windows, the objects, and their images."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from povgen.optics import apparent
from povgen.optics.series import image_depth, image_distance
from povgen.scene.scenes import MAX_ASIDE, Chess, Scene
from povgen.video.text import LEGIBLE, MAX_TEXT, STRIP, TEXT, text_width, write

HEIGHT = 0.38  # of the side view, as a fraction of the picture's height
FINER = 3  # the lines are drawn on so much a finer grid, for smooth edges
FARTHEST = 4  # what is farther from the windows than this multiple of z2 is left out
LINE, RAY, OTHER_RAYS = (130, 135, 145), (230, 235, 245), (190, 200, 220)
SHEET, OBJECT, IMAGE = (86, 180, 233), (230, 159, 0), (240, 228, 66)  # Okabe and Ito's colours
ARROW = 1.2  # height of the arrow that stands for a piece, tiles
# where the other rays end: so far from the eye, in apertures. The directions differ: then rays without a common point
# have none in any view.
ASIDE = 0.45 * np.exp(1j * np.radians((45, 165)))


def images(scene: Scene) -> list[float]:
    """Return z of the image of each object, tiles: NaN where light from the object never comes together.

    For ideal sheets, of which prisms are an approximation, and for others that have a ray-transfer matrix. z < 0 is
    before the first window: a real image.
    """
    if not scene.rotates:
        return [_image_of_slopes(scene, z1) for z1 in scene.distances]
    found = image_distance(np.array(scene.distances), np.radians(scene.alphas[0]), scene.behind)
    return [float(z) for z in np.atleast_1d(found)]


def _image_of_slopes(scene: Scene, z1: float) -> float:
    """Return z of the image by a single sheet that multiplies slopes by a real number, and adds one times the place."""
    matrix = scene.sheets[0].transfer if len(scene.sheets) == 1 else None
    if matrix is None:
        return float("nan")
    of_place, of_slope = matrix[2:4, 0:2], matrix[2:4, 2:4]
    alike = [np.allclose(part, part[0, 0] * np.eye(2), atol=1e-9) for part in (of_place, of_slope)]
    with np.errstate(divide="ignore"):  # an image at infinity
        return float(z1 * of_slope[0, 0] / (1 + z1 * of_place[0, 0])) if all(alike) else float("nan")


class Extent(NamedTuple):
    """What a side view shows: least and greatest z, and up to which distance from the z axis, tiles.

    If the eye moves only sideways, the view is from above, because from the side nothing would move.
    """

    first: float
    last: float
    reach: float
    from_above: bool


class Shown(NamedTuple):
    """An object in a side view."""

    L: complex
    z: float
    radius: float
    z1: float
    image: float  # z of its image, NaN if there is none


def extent(scenes: Collection[Scene], aside: float = 0.0) -> Extent:
    """Return what shows the objects and images of all these scenes.

    The eyes of a stereo pair stand `aside`, tiles, to the left and to the right of a scene's eye.
    """
    eyes = {scene.E for scene in scenes}
    from_above = len(eyes) > 1 == len({E.imag for E in eyes})
    ends, heights = [0.0], [0.1]
    for scene in scenes:
        shown, there = _shown(scene)
        ends += [-scene.z2, *scene.places, *(each.z for each in shown), *there]
        places = scene.E - aside, scene.E + aside, *(each.L for each in shown)
        heights += [scene.aperture / 2, *(abs(_height(place, from_above)) for place in places)]
    return Extent(min(ends), max(ends), max(heights), from_above)


def _height(place: complex, from_above: bool) -> float:
    """Return how high a place is in the view, tiles: y, and from above -x."""
    return -place.real if from_above else place.imag


def _shown(scene: Scene) -> tuple[list[Shown], list[float]]:
    """Return the objects that are not beyond FARTHEST, and z of their images that are not."""
    most, last = FARTHEST * scene.z2, scene.places[-1]
    found = zip(scene.objects, scene.radii, images(scene), strict=True)
    shown = [Shown(L, last + z1, radius, z1, image) for (L, z1), radius, image in found if z1 <= most]
    return shown, [each.image for each in shown if -most <= each.image <= last + most]


def side_view(scene: Scene, width: int, height: int, shows: Extent | None = None) -> NDArray[np.uint8]:
    """Return a strip with the side view for a picture of this size. Its height is even.

    z points to the right, y up; in a view from above the left is up. Objects beyond FARTHEST, and their images, are
    left out, and the text says how many. `shows` is the extent if it is not that of this scene alone: that of a movie.
    """
    shown, there = _shown(scene)
    shows = shows or extent([scene])
    first, last, reach, from_above = shows
    rows = 2 * round(HEIGHT * height / 2)
    size = max(TEXT * height, min(LEGIBLE, MAX_TEXT * height))
    scale = min((width - 6 * size) / (last - first), (rows - 3.4 * size) / (2 * reach))
    left = (width - scale * (last - first)) / 2 - scale * first
    middle = rows / 2

    def at(z: float, place: complex) -> tuple[float, float]:
        return FINER * (left + scale * z), FINER * (middle - scale * _height(place, from_above))

    image = Image.new("RGB", (FINER * width, FINER * rows), STRIP)
    draw = ImageDraw.Draw(image)
    thick = FINER * max(1, round(height / 240))
    draw.line([at(first, scene.E), at(last, scene.E)], fill=LINE, width=thick // 2)
    if len(shown) == 1 and (scene.rotates or there):
        for eye, points in _rays(scene, shown[0], from_above)[::-1]:
            colour = RAY if eye == scene.E else OTHER_RAYS
            (z, end), (window, start) = points[:2]
            if (beyond := abs(_height(end, from_above))) > reach:  # there the texts stand
                near = abs(_height(start, from_above))
                part = (reach - near) / (beyond - near)
                points[0] = window + part * (z - window), start + part * (end - start)
            draw.line([at(z, place) for z, place in points], fill=colour, width=thick, joint="curve")
    half = scene.aperture / 2
    for z in scene.places:
        draw.line([at(z, -half * (1 + 1j)), at(z, half * (1 + 1j))], fill=SHEET, width=2 * thick)
    upright = isinstance(scene, Chess) and not from_above
    for each in shown:
        _object(draw, at(each.z, each.L), FINER * scale, each.radius, upright, OBJECT, thick)
        if each.image in there:
            _object(draw, at(each.image, each.L), FINER * scale, each.radius, upright, IMAGE, thick)
    x, y = at(-scene.z2, scene.E)
    draw.ellipse([x - 3 * thick, y - 3 * thick, x + 3 * thick, y + 3 * thick], fill="white")
    image = image.reduce(FINER)
    draw = ImageDraw.Draw(image)
    write(draw, 0.3 * size, 0.9 * size, "from above" if from_above else "from the side", size)
    numbers = [(z, f"window {n}" if n == 1 else str(n)) for n, z in enumerate(scene.places, 1)]
    windows = numbers if scene.window else [(0.0, "sheets")]
    for names, aside in ((windows, -1), (_names(scene, shown, there, last), 1)):
        labels = [(left + scale * z, text) for z, text in names]
        _labels(draw, labels, middle + aside * (scale * (reach if aside > 0 else half) + 0.9 * size), size, width)
    return np.asarray(image)


def _names(scene: Scene, shown: Sequence[Shown], there: Sequence[float], last: float) -> list[tuple[float, str]]:
    """Return the texts below the side view, each with the z to which it belongs: of the eye, the objects and the image.

    `there` is z of the images that are shown, and `last` the greatest z.
    """
    names = [(-scene.z2, "eye")]
    names += [(each.z, "object" if len(shown) == 1 else "objects") for each in shown[-1:]]
    names += [(z, "real image" if z < 0 else "virtual image") for z in there[:1]]
    if len(shown) < len(scene.objects):
        names.append((last, f"{len(scene.objects) - len(shown)} farther"))
    elif scene.rotates and all(np.isnan(each.image) for each in shown):
        nearest = image_depth(scene.distances[0], np.radians(scene.alphas[0]), scene.behind).real
        names.append((float(nearest), "no common point of rays"))
    return names


def _rays(scene: Scene, shown: Shown, from_above: bool = False) -> list[tuple[complex, list[tuple[float, complex]]]]:
    """Return where rays from an object end, at the eye and beside it, and z and x + iy of the corners of each.

    The rays begin at the upper end of a piece, and in a view from above at its foot. A ray that does not pass all
    windows is left out.
    """
    z1 = shown.z1
    tip = shown.L + 1j * (ARROW if isinstance(scene, Chess) and not from_above else 0)
    found = []
    for way in (0, *ASIDE):
        step = complex(way) * scene.aperture
        eye = complex(_moved(scene.E.real, step.real), _moved(scene.E.imag, step.imag))
        seen = scene.replace(eye=(eye.real, eye.imag), view=scene.view)
        if not bool(seen.visible(tip, z1)):
            continue
        slope = (complex(seen.apparent_position(tip, z1)) - eye) / scene.z2
        corners = [(-scene.z2, eye)]
        for z, (before, _, _, _) in zip(scene.places, apparent.follow(slope, eye, seen.elements), strict=True):
            corners.append((z, complex(before)))
        found.append((eye, [*corners, (shown.z, tip)]))
    return found


def _moved(place: float, step: float) -> float:
    """Return a coordinate of an eye after a step, or after the opposite step if an eye cannot be so far aside."""
    return place + step if abs(place + step) <= MAX_ASIDE else place - step


def _object(
    draw: ImageDraw.ImageDraw,
    place: tuple[float, float],
    scale: float,
    radius: float,
    upright: bool,
    colour: tuple[int, int, int],
    thick: int,
) -> None:
    """Draw a piece as an arrow that stands on the place, or a sphere around it."""
    x, y = place
    if upright:
        top, head = y - ARROW * scale, 4 * thick
        draw.line([(x, y), (x, top + head)], fill=colour, width=2 * thick)
        draw.polygon([(x, top), (x - head, top + 1.6 * head), (x + head, top + 1.6 * head)], fill=colour)
    else:
        half = max(radius * scale, 2 * thick)
        draw.ellipse([x - half, y - half, x + half, y + half], fill=colour)


def _labels(
    draw: ImageDraw.ImageDraw, labels: Sequence[tuple[float, str]], middle: float, size: float, width: int
) -> None:
    """Write texts below their places. Those that would overlap move apart, and all stay within the picture."""
    labels = sorted(labels, key=lambda each: each[0])  # of two at the same place the first one is on the left
    widths = [size * text_width(text) for _, text in labels]
    starts = [x - wide / 2 for (x, _), wide in zip(labels, widths, strict=True)]
    gap, margin = 0.7 * size, 0.3 * size
    for _ in range(100):  # a pair that is too near moves apart by equal steps
        starts = [min(max(x, margin), width - margin - wide) for x, wide in zip(starts, widths, strict=True)]
        for n, wide in enumerate(widths[:-1]):
            short = max(starts[n] + wide + gap - starts[n + 1], 0)
            starts[n], starts[n + 1] = starts[n] - short / 2, starts[n + 1] + short / 2
    for start, (_, text) in zip(starts, labels, strict=True):
        write(draw, start, middle, text, size)
