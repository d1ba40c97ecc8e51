"""Make a picture of docs/rooms.md, with lines on it: `python docs/room_pictures.py FILE.toml -o FILE.png`."""

from argparse import ArgumentParser
from pathlib import Path

import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.textpath import TextPath

from povgen import Eye, Room, fonts, render
from povgen.measure.plotting import IDEAL, PRISMS, Figure, save_drawing, style, withStroke
from povgen.optics.pose import Floats
from povgen.optics.rays import Bundle
from povgen.record import saved_with
from povgen.video.still import record_of

DPI = 100
INK, PALE = "#20242a", "#f4efe2"
CASED = [withStroke(linewidth=4, foreground="white")]
SQUARE = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (-1, -1, 0)])
STEEP = Eye(x=-0.2, y=10, z=-5, look_x=-0.5, look_y=0.1, view=4.8)


class Picture:
    """A room's picture, on which lines are drawn in space, as its eye sees them without windows."""

    def __init__(self, room: Room, size: tuple[int, int]) -> None:
        self.room, self.size = room, size
        width, height = size
        self.figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
        self.ax = self.figure.add_axes((0, 0, 1, 1))
        high = room.camera.height / 2
        self.ax.set(xlim=(-high * width / height, high * width / height), ylim=(-high, high))
        self.ax.axis("off")

    def seen(self, points: Floats) -> Floats:
        """Return where the eye sees points (n, 3), (n, 2)."""
        place = self.room.camera.position(points)
        return np.stack((place.real, place.imag), -1)

    def render(self, room: Room, larger: int = 1) -> Floats:
        size = self.size[0] * larger, self.size[1] * larger
        return render(room, size=size, renderer="gl", quality="high")

    def show(self, pixels: Floats, **look: float) -> None:
        self.ax.imshow(pixels, extent=(*self.ax.get_xlim(), *self.ax.get_ylim()), **look)

    def line(
        self, points: Floats, colour: str, width: float, dashes: str = "-", *, head: bool = False, zorder: float = 2
    ) -> None:
        """Draw a line through points (n, 3), with an arrowhead at its end if `head`."""
        seen = self.seen(points)
        self.ax.plot(*seen.T, dashes, color=colour, linewidth=width, path_effects=CASED, zorder=zorder)
        if head:
            look = {
                "arrowstyle": "-|>",
                "color": colour,
                "shrinkA": 0,
                "shrinkB": 0,
                "mutation_scale": 22,
                "linewidth": 0,
            }
            self.ax.annotate("", seen[-1] + 1e-3 * (seen[-1] - seen[-2]), seen[-2], arrowprops=look)

    def write(self, point: Floats, text: str, size: float = 13) -> None:
        """Write a text with its middle at a point (3,)."""
        self.ax.text(*self.seen(point), text, ha="center", va="center", fontsize=size, color=INK, path_effects=CASED)


def windows(picture: Picture) -> Floats:
    """Show the room's picture, with the edges of windows that have no frame. Return it without them."""
    pixels = picture.render(picture.room)
    picture.show(pixels)
    for opening in picture.room.openings:
        if not opening.rim:
            picture.line(opening.edge, PRISMS, 1.5)
    return pixels


def box(picture: Picture) -> None:
    """Also outline the knight and its pedestal where they stand."""
    with_knight, empty = windows(picture), picture.render(picture.room.replace(object=picture.room.object[:1]))
    # the image stands in front of the box, and hides its edges
    picture.show(np.dstack((with_knight, 255 * (with_knight != empty).any(-1).astype(np.uint8))), zorder=2.5)
    picture.line(picture.room.openings[0].edge[:2], PRISMS, 1.5, zorder=2.6)  # seen through the front, it ends there
    alone = picture.room.replace(window=(), object=picture.room.object[-2:])
    knight = (picture.render(alone, 4) != picture.render(alone.replace(object=()), 4)).any(-1)
    places = picture.room.camera.pixels(knight.shape[::-1])
    x, y = places[0].real, places[:, 0].imag
    picture.ax.contour(x, y, knight, [0.5], colors=INK, linewidths=4, zorder=3)
    picture.ax.contour(x, y, knight, [0.5], colors="white", linewidths=2.5, linestyles="dashed", zorder=3)
    picture.write(np.array((-0.55, 0.72, 0)), "the knight stands here", 18)
    picture.write(np.array((1.0, 1.48, 0)), "its image, in front of the box", 15)
    picture.line(np.array(((1.2, 1.33, 0), (1.0, 0.5, 0))), INK, 2)
    picture.write(np.array((0.44, -1.95, -1)), "near and far exchanged: the pedestal looks hollow", 13)
    picture.line(np.array(((0.75, -1.82, -1), (0.62, -1.5, -1))), INK, 2)
    picture.write(np.array((-1.4, -1.42, -1)), "each side: α = 180°", 13)


def star(picture: Picture) -> None:
    """Draw plain sheets, and a ray that goes round once. Number the sheets in its order, and extend both its ends."""
    floor = picture.render(picture.room.replace(window=()))
    picture.show(floor, alpha=0.3)
    found = picture.room.trace(Bundle((0.25, -1.629, -0.95), (-1, 0.455, 0)), path=True)
    ray, sheets = found.corners[:10], [picture.room.openings[n] for n in found.windows[:8]]
    parts = [(sheet.pose.place, sheet.edge) for sheet in sheets]
    parts += [(part.mean(0), part) for part in np.stack((ray[:-1], ray[1:]), 1)]
    for _, points in sorted(parts, key=lambda part: -part[0][2]):  # the nearest last
        if len(points) > 2:
            picture.ax.fill(*picture.seen(points).T, facecolor="#c8dcf078", edgecolor=PRISMS, linewidth=1, zorder=2)
            continue
        picture.line(points, IDEAL, 4, head=any(np.array_equal(points[1], end) for end in (ray[1], ray[-1])))
    for n, sheet in enumerate(sheets):
        picture.write(2.25 * sheet.pose.place + (0, 0.7, 0), str(n + 1), 20)
    along = (ray[1] - ray[0]) / np.linalg.norm(ray[1] - ray[0])
    for start, name, length in ((ray[1], "in, extended", 1.4), (ray[-1], "out, parallel", 0.9)):
        end = start + length * along
        picture.line(np.array((start, end)), INK, 2, "--")
        picture.write(end - (0.78, 0, 0), name, 18)
    picture.write(ray[:2].mean(0) - (0, 0, 0.3), "in", 18)
    picture.ax.plot(*picture.seen(ray[1:-1]).T, "o", color=IDEAL, markeredgecolor="white")


def turns(picture: Picture) -> None:
    """Draw each board before and after its turn, the axis, and the angle."""
    axes = {"roll": ("z", (0, 0, 1.8), (1.1, 0, 0)), "pitch": ("x", (1.6, 0, 0), (0, 1.1, 0))}
    axes["yaw"] = "y", (0, 1.2, 0), (1.1, 0, 0)
    for board in picture.room.object:
        (name, axis, side), place = axes[board.text], board.pose.place
        size = np.array((*board.size, 0)) / 2
        turned = [board.replace(**{board.text: angle}).pose.axes for angle in range(46)]
        picture.line(np.array((place - axis, place + axis)), PRISMS, 2, head=True)
        picture.write(place + 1.15 * np.array(axis), name, 22)
        picture.line(SQUARE * size + place, "#777777", 1.5, "--")
        arc = np.array([side @ each + place for each in turned])
        picture.line(np.array((arc[0], place)), "#777777", 1.5, "--")
        picture.line(np.array((place, arc[-1])), INK, 1.5)
        picture.ax.fill(
            *picture.seen(SQUARE * size @ turned[-1] + place).T, facecolor=(PALE, 0.7), edgecolor=INK, zorder=2
        )
        text = TextPath((0, 0), board.text, size=1.2 * size[1], prop=FontProperties(fname=fonts.BOLD))
        flat = text.vertices - (text.vertices.max(0) + text.vertices.min(0)) / 2
        outline = picture.seen(np.pad(flat, ((0, 0), (0, 1))) @ turned[-1] + place)
        picture.ax.add_patch(PathPatch(Outline(outline, text.codes), facecolor=INK, linewidth=0, zorder=2))
        if name == "z":  # it comes out in front
            picture.line(np.array((place - axis, place)), PRISMS, 2)
        picture.line(arc, IDEAL, 3, head=True)
        picture.write(1.25 * arc[22] - 0.25 * place, "45°", 22)


def main() -> None:
    """Write the picture."""
    parser = ArgumentParser()
    parser.add_argument("room", type=Path)
    parser.add_argument("-o", dest="output", type=Path, required=True)
    given = parser.parse_args()
    name, room = given.room.stem, Room.load(given.room, background=Room().background)
    if name == "star":  # from where all sheets are seen
        room = room.replace(eye=STEEP)
    with style(), saved_with(record_of([room])):
        picture = Picture(room, (1280, 400) if name == "turns" else (640, 480))
        {"box": box, "star": star, "turns": turns}.get(name, windows)(picture)
        save_drawing(picture.figure, given.output)


if __name__ == "__main__":
    main()
