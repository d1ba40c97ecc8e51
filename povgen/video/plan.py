"""A plan of a room, from above or from the side, to scale: the eye, the windows, the objects, and rays of light."""

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from povgen.objects.scene_object import SceneObject
from povgen.optics.faces import Floats
from povgen.optics.paths import Leg
from povgen.optics.rays import Opening
from povgen.scene.scene import Scene, object_images, paths
from povgen.video.text import LEGIBLE, MAX_TEXT, STRIP, TEXT, text_width, write

LEAST, MOST = 0.38, 0.6  # height of the plan, as a fraction of the picture's height
FINER = 3  # the lines are drawn on a grid of pixels that is finer by this factor, for smooth edges
FARTHEST = 4  # objects that are farther from the eye than this multiple of the windows' distance are left out
RAYS = 9  # from the eye, through the picture's middle row or column
RAY, SEEN = (140, 147, 160), (240, 228, 66)  # a ray from the eye, and light from an object to the eye
SHEET, OBJECT = (86, 180, 233), (230, 159, 0)  # Okabe and Ito's colours
NAME = 0.8  # size of names, as a multiple of the usual size of text
EDGES = [(a, b) for a in range(8) for b in range(8) if a < b and (a ^ b).bit_count() == 1]  # of a box

Named = Sequence[tuple[str, Floats]]


class Plan(NamedTuple):
    """What a plan shows: least and greatest z, and heights in the view, tiles: y, and from above -x."""

    first: float
    last: float
    low: float
    high: float
    from_above: bool

    def at(self, points: Floats) -> Floats:
        """Return z and the height of points (..., 3) in the view, (..., 2)."""
        return np.stack((points[..., 2], -points[..., 0] if self.from_above else points[..., 1]), -1)


def extent(scenes: Collection[Scene], aside: float = 0.0) -> Plan:
    """Return what a plan shows that has the eyes, windows and objects of all these scenes.

    It is from above if the windows, and where they face, are spread more along x than along y. The eyes of a stereo
    pair stand `aside`, tiles, to the left and to the right of a scene's eye.
    """
    windows = [opening.pose for scene in scenes for opening in scene.openings]
    facing = np.array([pose.place + way * pose.axes[2] for pose in windows for way in (-1, 1)]).reshape(-1, 3)
    eyes = [np.add(scene.camera.eye, way * aside * np.array(scene.camera.right)) for scene in scenes for way in (-1, 1)]
    objects = [_corners(each) for scene in scenes for each in _near(scene)]
    every = np.concatenate([*map(_outline, (each for scene in scenes for each in scene.openings)), *objects, eyes])
    # as far as they are equally spread but for rounding, the other things decide
    spread = [np.round(np.ptp(points, axis=0), 6) for points in (facing, every) if len(points)]
    from_above = bool([x for x, _, _ in spread] > [y for _, y, _ in spread])
    seen = Plan(0, 0, 0, 0, from_above).at(every)
    (first, low), (last, high) = ((float(z), float(h)) for z, h in (seen.min(0), seen.max(0)))
    return Plan(first, max(last, first + 0.1), low - 0.1, high + 0.1, from_above)


def plan(scene: Scene, width: int, height: int, shows: Plan) -> NDArray[np.uint8]:
    """Return a strip with the plan for a picture of this size. Its height is even.

    z points to the right, y up; in a view from above the left is up. `shows` is what is shown, in a movie that of all
    its scenes. Rays from the eye pass the picture's middle row, or from the side its middle column. Bright lines are
    light from the objects' points to the eye (`Scene.images`).
    """
    size = min(max(TEXT * height, min(LEGIBLE, MAX_TEXT * height)), width / 12)
    wide, high = shows.last - shows.first, shows.high - shows.low
    scale = min((width - 6 * size) / wide, (MOST * height - 3.4 * size) / high)
    rows = 2 * round(max(LEAST * height, scale * high + 3.4 * size) / 2)
    left, middle = (width - scale * wide) / 2 - scale * shows.first, rows / 2 + scale * (shows.high + shows.low) / 2
    image = Image.new("RGB", (FINER * width, FINER * rows), STRIP)
    draw = ImageDraw.Draw(image)
    thick = FINER * max(1, round(height / 300))

    def pixels(points: Floats) -> Floats:
        return np.asarray((left, middle) + shows.at(points) * (scale, -scale))

    def line(points: Floats, colour: tuple[int, int, int], times: float = 1) -> None:
        draw.line([*map(tuple, FINER * pixels(points))], fill=colour, width=round(times * thick), joint="curve")

    fan = np.linspace(-0.49, 0.49, RAYS) * scene.camera.height
    across = fan * width / height if shows.from_above else 1j * fan
    for ray in _followed(paths(scene).walk(scene.camera.through(across)), 2 * (wide + high)):
        line(ray, RAY, 0.7)
    for each in _near(scene):
        corners = _corners(each)
        for a, b in EDGES:
            line(corners[[a, b]], OBJECT)
    for opening in scene.openings:
        line(_outline(opening), SHEET, 2)
    for light in (image.corners for _, images in object_images(scene) for image in images):
        line(light, SEEN)
    eye = np.array(scene.camera.eye)
    x, y = FINER * pixels(eye)
    draw.ellipse([x - 3 * thick, y - 3 * thick, x + 3 * thick, y + 3 * thick], fill="white")
    image = image.reduce(FINER)
    windows = [(name, pixels(_outline(opening))) for name, opening in scene.named_openings.items()]
    things = [(each.name or each.called, pixels(_corners(each))) for each in _near(scene) if each.point is not None]
    title = "from above" if shows.from_above else "from the side"
    _write(image, title, [("eye", pixels(eye + np.zeros((1, 3)))), *windows, *things], things, size)
    return np.asarray(image)


def _write(image: Image.Image, title: str, names: Named, covered: Named, size: float) -> None:
    """Write a title into the corner, and names below or above things, where they do not hide other names or `covered`.

    Things are points (n, 2), in pixels.
    """
    draw = ImageDraw.Draw(image)
    write(draw, 0.3 * size, 0.9 * size, title, size)
    taken = [(0.0, 0.4 * size, text_width(title) * size, 1.4 * size)]  # left, upper, right and lower edges
    taken += [(*points.min(0), *points.max(0)) for _, points in covered]
    for name, points in names:
        (left, top), (right, bottom) = points.min(0), points.max(0)
        wide, high = text_width(name) * NAME * size, NAME * size
        x = min(max((left + right - wide) / 2, 0.3 * size), image.width - wide - 0.3 * size)
        below, above = bottom + 0.9 * high, top - 0.9 * high
        for y in (above, below) if top + bottom < image.height else (below, above):  # away from the middle first
            own = x, y - high / 2, x + wide, y + high / 2
            hides = any(own[0] < c and a < own[2] and own[1] < d and b < own[3] for a, b, c, d in taken)
            if not hides and own[1] > 0 and own[3] < image.height:
                taken.append(own)
                write(draw, x, y, name, high, edge=max(1, round(size / 12)), dark=False)
                break


def _near(scene: Scene) -> list[SceneObject]:
    """Return the objects that are not too far (FARTHEST), without those that take no room."""
    eye = np.array(scene.camera.eye)
    places = [opening.pose.place for opening in scene.openings] or [np.array(scene.camera.middle)]
    most = FARTHEST * max(np.linalg.norm(place - eye) for place in places)
    return [each for each in scene.contents if np.ptp(each.box) and np.linalg.norm(each.pose.place - eye) <= most]


def _corners(each: SceneObject) -> Floats:
    """Return the corners of an object's box, (8, 3)."""
    lower, upper = np.array(each.box)
    own = np.array([np.where([n & 1, n & 2, n & 4], upper, lower) for n in range(8)])
    return own @ each.pose.axes + each.pose.place


def _outline(opening: Opening) -> Floats:
    """Return points of a window's outline, (n, 3), the first of which is the last."""
    turn = np.linspace(0, 2 * np.pi, 65 if opening.outline.is_round else 5) + np.pi / 4
    x, y = (part if opening.outline.is_round else np.sign(part) for part in (np.cos(turn), np.sin(turn)))
    own = np.stack((x * opening.outline.width / 2, y * opening.outline.height / 2, 0 * x), -1)
    return own @ opening.pose.axes + opening.pose.place


def _followed(legs: Sequence[Leg], far: float) -> Iterator[Floats]:
    """Yield the corners (n, 3) of each ray, as far as it goes, or for the distance `far` beyond the last window."""
    for n in range(len(legs[0].start)):
        run = [leg for leg in legs if np.isfinite(leg.start[n]).all()]
        last = run[-1]
        end = last.start[n] + min(last.length[n], far) * last.direction[n]
        yield np.stack([*(leg.start[n] for leg in run), end])
