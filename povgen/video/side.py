"""A view of a scene from the side or from above, to scale: eye, windows, objects, images, and light to the eye."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from povgen.inputs.pieces import PieceFile
from povgen.objects.piece import Piece
from povgen.objects.scene_object import SceneObject
from povgen.objects.sphere import Sphere
from povgen.optics.faces import Floats
from povgen.optics.paths import Paths
from povgen.scene.presets import AxialScene
from povgen.scene.scene import Scene, is_empty, paths
from povgen.video.text import LEGIBLE, MAX_TEXT, STRIP, TEXT, text_width, write

MOST = 0.5  # height of the view at most, as a fraction of the picture's height
SMALLER = 0.8  # size of a name that does not fit otherwise, as a multiple of the usual one
CLEAR, APART = 0.2, 0.6  # least distance of a name from a line, and of a name's end from another name, in its size
# how much worse a place is where a name covers rays from the eye, or is as near to another thing, in lines of text
COVERS, UNCLEAR = 1.5, 10.0
HEADS = (0.14, 0.27, 0.4)  # where light to each point has its arrowhead: parts of the way from there to the first bend
FINER = 3  # the lines are drawn on a grid of pixels that is finer by this factor, for smooth edges
FARTHEST = 4  # what is farther from the eye than this multiple of the farthest window's distance is left out
HIGHEST = 2  # an image is left out if it reaches farther from the z axis than this multiple of the rest
ARROW = 1.2  # height of the arrow that stands for a piece from a file, tiles
RAYS = 9  # from the eye, through the middle row or column of the picture of a room
# Points beside the eye to which light runs: x + iy, in units of the first window's width. The two directions differ, so
# that rays without a common point seem to have none from the side and from above.
ASIDE = 0.45 * np.exp(1j * np.radians((45, 165)))
LIGHT, BESIDE, RAY = (255, 226, 170), (224, 128, 52), (110, 116, 128)
SHEET, OBJECT, IMAGE = (86, 180, 233), (230, 159, 0), (240, 228, 66)  # Okabe and Ito's colours
OTHER = (130, 135, 145)  # objects without a point, such as pedestals
EYE = ((1, 1, (255, 255, 255)), (0.55, 0.55, (60, 110, 170)), (0.45, 0.3, (10, 10, 14)))  # discs: place, radius, colour

Colour = tuple[int, int, int]


class Extent(NamedTuple):
    """What a view shows: least and greatest z, and heights in the view, tiles: y, and from above -x."""

    first: float
    last: float
    low: float
    high: float
    from_above: bool

    def at(self, points: ArrayLike) -> Floats:
        """Return z and the height of points (..., 3) in the view, (..., 2)."""
        points = np.asarray(points)
        return np.stack((points[..., 2], -points[..., 0] if self.from_above else points[..., 1]), -1)


class Thing(NamedTuple):
    """What is drawn: a line, or a mark, which is an arrow, or a disc if its radius is more than the arrow's length."""

    name: str
    points: Floats  # (n, 3), corners of a line; of a mark its place, the arrow's end and a point of the disc's rim
    colour: Colour
    is_mark: bool = False
    source: Floats | None = None  # where its light begins, (3,)

    @property
    def around(self) -> Floats:
        """Points (n, 3) of which no part of it is outside."""
        if not self.is_mark:
            return self.points
        place, tip, rim = self.points
        across = np.linalg.norm(rim - place) * np.array([1, (tip == place).all(), 1])
        return np.stack((place - across, place + across, tip))


def extent(scenes: Collection[Scene], aside: float = 0.0) -> Extent:
    """Return what a view shows that has the eyes, windows, objects and images of all these scenes.

    It is from above if there is more to see along x than along y: by the windows' places and where they face, then by
    the eyes, then by all things. The eyes of a stereo pair stand `aside`, tiles, to the left and to the right.
    """
    poses = [opening.pose for scene in scenes for opening in scene.openings]
    facing = np.array([pose.place + way * pose.axes[2] for pose in poses for way in (-1, 1)]).reshape(-1, 3)
    eyes, right = (np.array([getattr(scene.camera, part) for scene in scenes]) for part in ("eye", "right"))
    around = [thing.around for scene in scenes for thing in _shown(scene)[0]]
    things = np.array([*eyes, *(ends for points in around for ends in (points.min(0), points.max(0)))])
    # what is equally spread but for rounding does not decide
    spread = [np.round(np.ptp(points, axis=0), 6) for points in (facing, eyes, things) if len(points)]
    from_above = bool([x for x, _, _ in spread] > [y for _, y, _ in spread])
    seen = Extent(0, 0, 0, 0, from_above).at([*things, *(eyes - aside * right), *(eyes + aside * right)])
    (first, low), (last, high) = ((float(z), float(h)) for z, h in (seen.min(0), seen.max(0)))
    return Extent(first, max(last, first + 0.1), low - 0.1, high + 0.1, from_above)


def side_view(scene: Scene, width: int, height: int, shows: Extent | None = None) -> NDArray[np.uint8]:
    """Return a strip with the view for a picture of this size. Its height is even, and at most MOST of the picture's.

    z points to the right, y up; in a view from above the left is up. `shows` is what is shown, in a movie that of all
    its scenes; by default it is that of this scene. Warm lines are light from the objects to the eye (`Scene.images`),
    and from a single object also to points beside the eye. Thin lines continue it to a virtual image. In a room, grey
    lines are rays from the eye. Objects beyond FARTHEST are left out, and the text says how many.
    """
    drawing = Drawing(shows or extent([scene]), width, height)
    things, farther, note = _shown(scene)
    if not isinstance(scene, AxialScene):
        drawing.fan(scene, width / height)
    images = [thing.points[0, 2] for thing in things if thing.colour == IMAGE]
    light = [*_light(scene, [thing.source for thing in things if thing.source is not None])]
    parts = dict(zip(dict.fromkeys(tuple(corners[0]) for _, corners in light), HEADS, strict=False))
    for colour, corners in light:
        if len(images) == 1 and len(corners) > 2 and (z := images[0]) > 0:
            eye, bend = corners[:2]
            drawing.line([bend, eye + (z - eye[2]) / (bend[2] - eye[2]) * (bend - eye)], BESIDE, 0.4)
        drawing.line(corners, colour)
        eye, bend = FINER * drawing.pixels(corners[:2])
        drawing.head(bend, eye + parts[tuple(corners[0])] * (bend - eye), 3, colour)
    for thing in sorted(things, key=lambda thing: thing.colour != OTHER):  # a pedestal does not cover its piece
        drawing.thing(thing)
    title = ("from above" if drawing.shows.from_above else "from the side") + f", {farther} farther" * (farther > 0)
    # windows from the eye on, so that their names stand in this order, and what has no image last
    order = sorted(things, key=lambda thing: thing.colour == OTHER)
    names = {thing.name: drawing.pixels(thing.around) for thing in order}
    above = {thing.name for thing in things if thing.colour == SHEET}
    # below the title if there is place, so that it does not move in a movie, or near the first window
    first = {note: names[things[0].name]} if note else {}
    return drawing.labelled(title, first | {"eye": drawing.eye(scene)} | names, above, note)


class Drawing:
    """A view that is being drawn. Lengths are in tiles, but the text's `size` and `solid` are in pixels."""

    def __init__(self, shows: Extent, width: int, height: int) -> None:
        self.shows = shows
        self.size = size = min(max(TEXT * height, min(LEGIBLE, MAX_TEXT * height)), width / 13)
        wide, high = shows.last - shows.first, shows.high - shows.low
        self.scale = min((width - 3 * size) / wide, (MOST * height - 3.8 * size) / high)
        rows = 2 * int(min(self.scale * high + 4.4 * size, MOST * height) / 2)
        left = (width - self.scale * wide) / 2 - self.scale * shows.first
        # names above windows need more room than those below objects
        self.origin = left, (rows + 0.6 * size) / 2 + self.scale * (shows.high + shows.low) / 2
        self.image = Image.new("RGB", (FINER * width, FINER * rows), STRIP)
        self.draw = ImageDraw.Draw(self.image)
        self.thick = FINER * max(1.0, height / 160)
        self.solid: list[Floats] = []  # points (n, 2) that names do not cover
        self.thin: list[Floats] = []  # those that they cover only if there is no other place

    def pixels(self, points: ArrayLike) -> Floats:
        """Return the places in the strip, (..., 2), of points (..., 3)."""
        return np.asarray(self.origin + self.shows.at(points) * (self.scale, -self.scale))

    def line(self, points: ArrayLike, colour: Colour, times: float = 1) -> None:
        """Draw a line through points (n, 3)."""
        corners = self.pixels(points)
        width = max(1, round(times * self.thick))
        self.draw.line([*map(tuple, FINER * corners)], fill=colour, width=width, joint="curve")
        (self.thin if colour == RAY or times < 0.5 else self.solid).append(_along(corners))

    def disc(self, middle: Floats, radius: float, colour: Colour) -> None:
        """Draw a disc. Lengths are in pixels of the finer grid."""
        x, y = middle
        self.draw.ellipse([x - radius, y - radius, x + radius, y + radius], fill=colour)

    def head(self, start: Floats, tip: Floats, times: float, colour: Colour) -> Floats:
        """Draw the head of an arrow and return the middle of its base. Points are in pixels of the finer grid."""
        length = max(float(np.linalg.norm(tip - start)), 1e-9)
        x, y = min(times * self.thick, length / 1.6) * (tip - start) / length
        base = tip - 1.6 * np.array([x, y])
        self.draw.polygon([*map(tuple, (tip, base + (-y, x), base - (-y, x)))], fill=colour)
        return base

    def thing(self, thing: Thing) -> None:
        """Draw a line or a mark. Images are thicker than objects, so that an object does not hide its image."""
        times = {SHEET: 1.1, IMAGE: 2}.get(thing.colour, 1)
        if not thing.is_mark:
            self.line(thing.points, thing.colour, times)
            if thing.colour == OTHER:
                corners = FINER * self.pixels(thing.points)
                for a, b, c in zip(corners, corners[1:], corners[2:], strict=False):
                    if (a != c).any():  # three corners of a face
                        self.draw.polygon([*map(tuple, (a, b, c, a + c - b))], fill=OTHER)
                middle, edges = corners.mean(0), _along(corners)
                self.solid += [(middle + part * (edges - middle)) / FINER for part in (0.3, 0.6)]
            return
        place, tip, _ = FINER * self.pixels(thing.points)
        radius = max(FINER * self.scale * float(np.linalg.norm(thing.points[2] - thing.points[0])), 2 * self.thick)
        length = float(np.linalg.norm(tip - place))
        if length <= radius:
            self.disc(place, radius + (times - 1) * self.thick, thing.colour)
        else:
            base = self.head(place, tip, 4, thing.colour)
            self.draw.line([*place, *base], fill=thing.colour, width=round((1 + times) * self.thick))
        self.solid += [self.pixels(thing.around), _along(np.array([place, tip])) / FINER]

    def fan(self, scene: Scene, ratio: float) -> None:
        """Draw rays from the eye through the picture's middle row, or from the side its middle column."""
        first, last, low, high, _ = self.shows
        across = np.linspace(-0.49, 0.49, RAYS) * scene.camera.height * (ratio if self.shows.from_above else 1j)
        legs = paths(scene).walk(scene.camera.through(across))
        for n in range(RAYS):
            run = [leg for leg in legs if np.isfinite(leg.start[n]).all()]
            far = min(run[-1].length[n], 2 * (last - first + high - low))
            self.line([*(leg.start[n] for leg in run), run[-1].start[n] + far * run[-1].direction[n]], RAY, 0.7)

    def eye(self, scene: Scene) -> Floats:
        """Draw an eye that looks to the picture's middle. Light ends on its cornea. Return its corners, pixels."""
        place, ahead = FINER * self.pixels([scene.camera.eye, scene.camera.middle])
        radius = 0.5 * FINER * self.size
        way = radius * (ahead - place) / max(float(np.linalg.norm(ahead - place)), 1e-9)
        for far, large, colour in EYE:
            self.disc(place - far * way, large * radius, colour)
        self.solid.append((place - way + radius * np.array([[-1, -1], [1, 1]])) / FINER)
        return self.solid[-1]

    def labelled(self, title: str, names: Mapping[str, Floats], above: Collection[str], note: str) -> NDArray[np.uint8]:
        """Return the strip, with `title` in its corner, and names below or `above` points (n, 2), pixels.

        The name `note` is below the title if there is place. No name is on or near lines or other names. One without a
        place is left out. One that covers rays from the eye interrupts them.
        """
        image = self.image.reduce(FINER)
        draw, edge = ImageDraw.Draw(image), max(1, round(self.size / 12))
        write(draw, 0.3 * self.size, 0.9 * self.size, title, self.size, edge, dark=False)
        taken = [(np.zeros(2), np.array([0.6 + text_width(title), 1.4]) * self.size)]  # lower and upper corners
        solid, every = np.concatenate(self.solid), np.concatenate([*self.solid, *self.thin])
        things = {name: _along(around) for name, around in names.items()}
        for name, around in names.items():
            others = [things[other] for other, points in names.items() if points is not around]
            places = _places(around, text_width(name), self.size, name in above)
            options = sorted(
                (worse + covers + unclear, *place, covers, unclear)
                for worse, *place in places
                for covers, unclear in product((0, COVERS), (0, UNCLEAR))
            )
            if name == note:
                options.insert(0, (0, 0.3 * self.size, 2.1 * self.size, self.size, 0, UNCLEAR))
            for _, left, middle, size, covers, unclear in options:
                half = np.array([text_width(name, size), 1.2]) * size / 2
                margin = half + (0.3 * size, 0.1 * size)
                centre = np.clip((left + half[0], middle), margin, image.size - margin)
                box, aside = (centre - half, centre + half), (APART * size, 0)
                if (
                    box[0][0] > 0
                    and not any(((box[0] - aside < upper) & (lower < box[1] + aside)).all() for lower, upper in taken)
                    and _gap(box, solid if covers else every) > CLEAR * size
                    and (unclear or all(_gap(box, things[name]) + 0.1 * size < _gap(box, points) for points in others))
                ):
                    taken.append(box)
                    draw.rectangle([*box[0], *box[1]], fill=STRIP)
                    write(draw, box[0][0], centre[1], name, size, edge, dark=False)
                    break
        return np.asarray(image)


def _along(corners: Floats) -> Floats:
    """Return points (m, 2) along lines through corners (n, 2)."""
    steps = np.linspace(0, 1, 25).reshape(-1, *[1] * corners.ndim)
    return (corners[:-1] + steps * np.diff(corners, axis=0)).reshape(-1, 2)


def _gap(box: tuple[Floats, Floats], points: Floats) -> float:
    """Return the distance from a box, its lower and upper corner, to the nearest of points (n, 2)."""
    return float(np.linalg.norm(points - np.clip(points, *box), axis=1).min())


def _places(
    around: Floats, relative: float, most: float, is_above: bool
) -> Iterator[tuple[float, float, float, float]]:
    """Yield places for a name near things: how bad each is, in lines, its left edge, its middle and its size.

    `relative` is its width in units of its size, and `most` the greatest size.
    """
    (left, top), (right, bottom) = around.min(0), around.max(0)
    for size in (most, SMALLER * most):
        wide, wrong, small = relative * size, 3.5, 5.0 * (size < most)  # the wrong side of its thing, a small name
        for y, worse in ((top + bottom) / 2, 1.4), (top + 0.6 * size, 1.8), (bottom - 0.6 * size, 1.8):
            yield worse + 1.6 * is_above + small, right + 0.4 * size, y, size
            yield worse + 1.6 * is_above + small + 0.2, left - 0.4 * size - wide, y, size
        for lines, aside in product(np.arange(0, 4.5, 0.5), (0, 0.35, -0.35, 0.6, -0.6, 1.2, -1.2)):
            x, worse = (left + right - wide) / 2 + aside * wide, lines + 10 * aside**2 + small
            yield worse + wrong * is_above, x, bottom + (0.85 + lines) * size, size
            yield worse + wrong * (not is_above), x, top - (0.85 + lines) * size, size


def _shown(scene: Scene) -> tuple[list[Thing], int, str]:
    """Return windows, images and objects of a scene, how many objects are too far, and what is said of an image.

    Objects that take no room, such as the floor, do not count.
    """
    eye = np.array(scene.camera.eye)
    places = [opening.pose.place for opening in scene.openings] or [np.array(scene.camera.middle)]
    most = FARTHEST * max(float(np.linalg.norm(place - eye)) for place in places)
    windows = [Thing(name, edge, SHEET) for name, edge in named_windows(scene)]
    solid = [each for each in scene.contents if np.ptp(each.box)]
    objects = [_object(each) for each in solid if np.linalg.norm(each.pose.place - eye) <= most]
    farther = sum(each.point is not None for each in solid) - sum(each.source is not None for each in objects)
    images: list[Thing] = []
    note = ""
    if isinstance(scene, AxialScene) and not is_empty(scene):
        high = HIGHEST * max(abs(thing.around[:, :2]).max() for thing in windows + objects)
        images, note = _images(scene, [thing for thing in objects if thing.is_mark], most, high)
    return windows + images + objects, farther, note


def named_windows(scene: Scene) -> list[tuple[str, Floats]]:
    """Return the name that a drawing gives each window, and points of its outline, (n, 3)."""
    names = [re.sub(r"^window(?=\d+$)", "window ", name) for name in scene.named_openings]
    if names == ["window 1"]:
        sheet = scene.sheets[0]
        names = ["window" if is_empty(scene) else "sheets" if sheet.rotates or sheet.layers == 2 else "sheet"]
    return [(name, opening.edge) for name, opening in zip(names, scene.openings, strict=True)]


def _images(scene: AxialScene, objects: Sequence[Thing], most: float, high: float) -> tuple[list[Thing], str]:
    """Return the images of objects, and what is said if there is none.

    The images are those of ideal sheets, of which prisms are an approximation. Images that are farther than `most` from
    the eye's plane or reach farther from the z axis than `high` are left out.
    """
    planes, found = [], []
    for _, mark, *_ in objects:
        z, points = scene.image_plane(mark[:, 0] + 1j * mark[:, 1], mark[0, 2] - scene.places[-1])
        inside = any(abs(z - place) < 1e-6 for place in scene.places)
        name = "image in a window" if inside else "real image" if z < 0 else "virtual image"
        image = Thing(name, np.stack((points.real, points.imag, np.full(3, z)), -1), IMAGE, is_mark=True)
        planes.append(z)
        if abs(z + scene.z2) <= most and abs(image.around[:, :2]).max() <= high:
            found.append(image)
    if found or not planes:
        return found, ""
    if np.isnan(planes).all():
        return [], "no common point of rays"
    return [], "image at infinity" if np.isinf(planes).all() else "image not in the view"


def _light(scene: Scene, sources: Sequence[Floats]) -> Iterator[tuple[Colour, Floats]]:
    """Yield light from points to the eye: its colour, and its corners (n, 3), from the eye.

    From a single point, light also runs through windows to points beside the eye.
    """
    if len(sources) == 1 and scene.openings:
        eye, right, up = (np.array(part) for part in (scene.camera.eye, scene.camera.right, scene.camera.up))
        for step in ASIDE * scene.openings[0].outline.width:
            camera = scene.camera._replace(eye=(*(eye + step.real * right + step.imag * up).tolist(),))
            (images,) = Paths(camera, scene.named_openings).images(sources)
            yield from ((BESIDE, image.corners) for image in images if image.windows)
    yield from ((LIGHT, image.corners) for images in paths(scene).images(sources) for image in images)


def _object(each: SceneObject) -> Thing:
    """Return what stands for an object: for a piece an arrow, for a sphere a disc, for any other one its box."""
    points, is_mark = each.edges, isinstance(each, (Piece, Sphere))
    if is_mark:
        width, tall, _ = each.box[1]
        height = 0 if isinstance(each, Sphere) else ARROW if isinstance(each.shape, PieceFile) else tall
        points = np.array([[0, 0, 0], [0, height, 0], [width, 0, 0]]) @ each.pose.axes + each.pose.place
    if each.point is None:
        return Thing(each.called, points, OTHER)
    return Thing(each.name or each.called, points, OBJECT, is_mark, points[1] if is_mark else each.point)
