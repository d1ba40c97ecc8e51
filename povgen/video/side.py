"""A view of a scene from the side or from above, to scale: the eye, the windows, the objects, and their images."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from povgen.inputs.fields import MAX_ASIDE
from povgen.optics import apparent
from povgen.scene.scene import Scene
from povgen.scene.scenes import AxialScene
from povgen.video import plan
from povgen.video.plan import Plan
from povgen.video.text import LEGIBLE, MAX_TEXT, STRIP, TEXT, text_width, write

HEIGHT = 0.38  # of the side view, as a fraction of the picture's height
FINER = 3  # the lines are drawn on a grid of pixels that is finer by this factor, for smooth edges
FARTHEST = 4  # what is farther from the windows than this multiple of z2 is left out
HIGHEST = 2  # an image is left out if it reaches higher than this multiple of the highest object, or of the window
LINE, RAY, OTHER_RAYS = (130, 135, 145), (230, 235, 245), (190, 200, 220)
SHEET, OBJECT, IMAGE = (86, 180, 233), (230, 159, 0), (240, 228, 66)  # Okabe and Ito's colours
ARROW = 1.2  # height of the arrow that stands for a piece, tiles
# Where the other rays end, relative to the eye: x + iy, in units of the aperture. The two directions differ, so that
# rays without a common point seem to have none from the side and from above.
ASIDE = 0.45 * np.exp(1j * np.radians((45, 165)))


class Extent(NamedTuple):
    """What a side view shows: least and greatest z, and up to which distance from the z axis, tiles.

    If the eye moves only sideways, the view is from above, because from the side nothing would move.
    """

    first: float
    last: float
    reach: float
    from_above: bool


class Thing(NamedTuple):
    """An object, or its image, in a side view: x + iy of its points in the plane z, tiles."""

    from_above: bool
    is_disc: bool  # as spheres are, and from above the feet of pieces; otherwise it is an arrow
    z: float  # of an image NaN if light from the object never comes together, and infinite if it is parallel
    place: complex  # of a piece the centre of its foot, of a sphere its centre
    tip: complex  # of the arrow that stands for a piece
    rim: complex  # a point on the circle of a sphere, or of a piece's foot

    @property
    def radius(self) -> float:
        """The radius of the disc that is drawn, or 0 for an arrow."""
        return abs(self.rim - self.place) if self.is_disc else 0.0

    @property
    def heights(self) -> list[float]:
        """How high its ends are in the view."""
        middle = _height(self.place, self.from_above)
        if self.is_disc:
            return [middle - self.radius, middle + self.radius]
        return [middle, _height(self.tip, self.from_above)]


class Shown(NamedTuple):
    """An object in a side view."""

    thing: Thing
    image: Thing
    z1: float


def extent(scenes: Collection[Scene], aside: float = 0.0) -> Extent | Plan:
    """Return the extent of a side view that shows the eyes, windows, objects and images of all these scenes.

    Where a scene is a room, all have a plan in place of a side view. The eyes of a stereo pair stand `aside`, tiles, to
    the left and to the right of a scene's eye.
    """
    axial = [scene for scene in scenes if isinstance(scene, AxialScene)]
    return plan.extent(scenes, aside) if len(axial) < len(scenes) else _extent(axial, aside)


def _extent(scenes: Collection[AxialScene], aside: float) -> Extent:
    eyes = {scene.E for scene in scenes}
    from_above = len(eyes) > 1 == len({E.imag for E in eyes})
    ends, heights = [0.0], [0.1]
    for scene in scenes:
        shown, there = _shown(scene, from_above)
        drawn = [*(each.thing for each in shown), *there]
        ends += [-scene.z2, *scene.places, *(each.z + way * each.radius for each in drawn for way in (-1, 1))]
        high = [height for each in drawn for height in each.heights]
        high += [_height(place, from_above) for place in (scene.E - aside, scene.E + aside)]
        heights += [scene.aperture / 2, *map(abs, high)]
    return Extent(min(ends), max(ends), max(heights), from_above)


def _height(place: complex, from_above: bool) -> float:
    """Return how high a place is in the view, tiles: y, and from above -x."""
    return -place.real if from_above else place.imag


def image_of(scene: AxialScene, points: Sequence[complex], z1: float) -> tuple[float, NDArray[np.complex128]]:
    """Return z of the image of points at the distance z1, tiles, and the points' images (`apparent.image`).

    The image is that of ideal sheets, of which prisms are an approximation. Without an image z is NaN.
    """
    distances = np.diff((-scene.z2, *scene.places))
    windows = [(float(d), sheet.thin) for d, sheet in zip(distances, scene.sheets, strict=True)]
    return apparent.image(points, z1, windows)


def _shown(scene: AxialScene, from_above: bool = False) -> tuple[list[Shown], list[Thing]]:
    """Return the objects that are not too far (FARTHEST), and the images that are not too far or too high (HIGHEST).

    The images are those of ideal sheets, of which prisms are an approximation. Without sheets there are none.
    """
    most, last, is_chess = FARTHEST * scene.z2, scene.places[-1], bool(scene.pieces)
    shown, high = [], [scene.aperture / 2]
    for (L, z1), radius in zip(scene.objects, scene.radii, strict=True):
        if z1 <= most:
            points = [L, L + 1j * ARROW * is_chess, L + radius]
            z, places = image_of(scene, points, z1)
            look = from_above, from_above or not is_chess
            shown.append(Shown(Thing(*look, last + z1, *points), Thing(*look, z, *map(complex, places)), z1))
            high += map(abs, shown[-1].thing.heights)
    there = [each.image for each in shown if -most <= each.image.z <= last + most and not scene.is_empty]
    return shown, [each for each in there if max(map(abs, each.heights)) <= HIGHEST * max(high)]


def side_view(scene: Scene, width: int, height: int, shows: Extent | Plan | None = None) -> NDArray[np.uint8]:
    """Return a strip with the side view for a picture of this size. Its height is even.

    z points to the right, y up; in a view from above the left is up. Objects beyond FARTHEST, and their images, are
    left out, and the text says how many. `shows` is the extent that is shown, in a movie that of all its scenes.
    Without it, the extent is that of this scene. A room has a plan in place of a side view.
    """
    shows = shows or extent([scene])
    if isinstance(shows, Plan) or not isinstance(scene, AxialScene):
        assert isinstance(shows, Plan)  # `extent` of scenes with a room
        return plan.plan(scene, width, height, shows)
    return _side_view(scene, width, height, shows)


def _side_view(scene: AxialScene, width: int, height: int, shows: Extent) -> NDArray[np.uint8]:
    first, last, reach, from_above = shows
    shown, there = _shown(scene, from_above)
    rows = 2 * round(HEIGHT * height / 2)
    size = max(TEXT * height, min(LEGIBLE, MAX_TEXT * height))
    size = min(size, width / 12)  # else the margins of a narrow picture would leave no space
    scale = min((width - 6 * size) / (last - first), (rows - 3.4 * size) / (2 * reach))
    left = (width - scale * (last - first)) / 2 - scale * first
    middle = rows / 2

    def at(z: float, place: complex) -> tuple[float, float]:
        return FINER * (left + scale * z), FINER * (middle - scale * _height(place, from_above))

    image = Image.new("RGB", (FINER * width, FINER * rows), STRIP)
    draw = ImageDraw.Draw(image)
    thick = FINER * max(1, round(height / 240))
    draw.line([at(first, scene.E), at(last, scene.E)], fill=LINE, width=thick // 2)
    if len(shown) == 1:
        for eye, points in _rays(scene, shown[0])[::-1]:
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

    def show(each: Thing, colour: tuple[int, int, int], width: int) -> None:
        radius = FINER * scale * each.radius if each.is_disc else None
        _object(draw, at(each.z, each.place), at(each.z, each.tip)[1], radius, colour, width)

    for each in shown:
        if each.image in there:  # wider if the object covers it, so that both are seen
            place, other = ([part.z, *part.heights] for part in (each.thing, each.image))
            show(each.image, IMAGE, thick * (1 + bool(np.allclose(place, other, atol=1e-6))))
        show(each.thing, OBJECT, thick)
    x, y = at(-scene.z2, scene.E)
    draw.ellipse([x - 3 * thick, y - 3 * thick, x + 3 * thick, y + 3 * thick], fill="white")
    image = image.reduce(FINER)
    draw = ImageDraw.Draw(image)
    write(draw, 0.3 * size, 0.9 * size, "from above" if from_above else "from the side", size)
    numbers = [(z, f"window {n}" if n == 1 else str(n)) for n, z in enumerate(scene.places, 1)]
    sheet = scene.sheets[0]
    word = "window" if sheet.name == "none" else "sheets" if sheet.rotates or sheet.layers == 2 else "sheet"
    windows = numbers if scene.window else [(0.0, word)]
    for names, aside in ((windows, -1), (_names(scene, shown, there, last), 1)):
        labels = [(left + scale * z, text) for z, text in names]
        _labels(draw, labels, middle + aside * (scale * (reach if aside > 0 else half) + 0.9 * size), size, width)
    return np.asarray(image)


def _names(scene: AxialScene, shown: Sequence[Shown], there: Sequence[Thing], last: float) -> list[tuple[float, str]]:
    """Return the texts below the side view, each with the z to which it belongs: of the eye, the objects and the image.

    `there` are the images that are shown, and `last` is the greatest z.
    """
    names = [(-scene.z2, "eye")]
    names += [(each.thing.z, "object" if len(shown) == 1 else "objects") for each in shown[-1:]]
    for each in there[:1]:
        inside = any(abs(each.z - z) < 1e-6 for z in scene.places)
        kind = "image in a window" if inside else "real image" if each.z < 0 else "virtual image"
        names.append((each.z, kind))
    if len(shown) < len(scene.objects):
        names.append((last, f"{len(scene.objects) - len(shown)} farther"))
    found = [each.image.z for each in shown]
    if found and np.isnan(found).all():
        names.append((0.0, "no common point of rays"))
    elif found and not there and not scene.is_empty:
        names.append((0.0, "image at infinity" if np.isinf(found).all() else "image not in the view"))
    return names


def _rays(scene: AxialScene, shown: Shown) -> list[tuple[complex, list[tuple[float, complex]]]]:
    """Return rays from an object to the eye and to points beside the eye: for each, its end and its corners.

    An end is x + iy. The corners are (z, x + iy), from the end to the object. The rays begin at the upper end of a
    piece or at a sphere's centre, and in a view from above at a piece's foot. A ray that does not pass all windows is
    left out.
    """
    z1 = shown.z1
    tip = shown.thing.place if shown.thing.from_above else shown.thing.tip
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
        found.append((eye, [*corners, (shown.thing.z, tip)]))
    return found


def _moved(place: float, step: float) -> float:
    """Return a coordinate of an eye after a step, or after the opposite step if an eye cannot be so far aside."""
    return place + step if abs(place + step) <= MAX_ASIDE else place - step


def _object(
    draw: ImageDraw.ImageDraw,
    place: tuple[float, float],
    top: float,
    radius: float | None,
    colour: tuple[int, int, int],
    width: int,
) -> None:
    """Draw an arrow from a place to the height `top`, or if there is a radius a disc around the place."""
    x, y = place
    high = abs(top - y)
    if radius is None and high > 2 * width:
        head = np.copysign(min(4 * width, high / 1.6), y - top)
        draw.line([(x, y), (x, top + head)], fill=colour, width=2 * width)
        draw.polygon([(x, top), (x - head, top + 1.6 * head), (x + head, top + 1.6 * head)], fill=colour)
    else:  # a point is larger than to scale, and so is an arrow that is seen from its end
        half = max(radius or 0, 2 * width)
        draw.ellipse([x - half, y - half, x + half, y + half], fill=colour)


def _labels(
    draw: ImageDraw.ImageDraw, labels: Sequence[tuple[float, str]], middle: float, size: float, width: int
) -> None:
    """Write texts in a row at the height `middle`, each centred on its x. Texts that would overlap are moved apart.

    All stay within the picture, which has this width. If they do not fit, they are smaller. Lengths are in pixels.
    """
    labels = sorted(labels, key=lambda each: each[0])  # of two at the same place the first one is on the left
    relative = [text_width(text) for _, text in labels]
    size = min(size, width / (sum(relative) + 0.7 * (len(labels) - 1) + 0.61))  # the gaps and margins below
    widths = [size * wide for wide in relative]
    starts = [x - wide / 2 for (x, _), wide in zip(labels, widths, strict=True)]
    gap, margin = 0.7 * size, 0.3 * size
    for _ in range(100):  # a pair that is too near moves apart by equal steps
        starts = [min(max(x, margin), width - margin - wide) for x, wide in zip(starts, widths, strict=True)]
        for n, wide in enumerate(widths[:-1]):
            short = max(starts[n] + wide + gap - starts[n + 1], 0)
            starts[n], starts[n + 1] = starts[n] - short / 2, starts[n + 1] + short / 2
    for start, (_, text) in zip(starts, labels, strict=True):
        write(draw, start, middle, text, size)
