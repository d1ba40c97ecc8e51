"""Make a picture that compares scenes side by side: `python docs/panels.py NAME -o FILE.png`."""

from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from povgen import Chess, Scene, Spheres, render
from povgen.measure.opengl import OpenGLView
from povgen.optics.faces import GlassSheet
from povgen.optics.prism import Prism
from povgen.optics.trace import trace
from povgen.paper import agreement
from povgen.rendering.light import mixed
from povgen.scene.camera import window
from povgen.settings import Rendering
from povgen.video import encode
from povgen.video.caption_texts import Caption
from povgen.video.overlay import annotated
from povgen.video.side import side_view
from povgen.video.text import DARK, STRIP, TEXT, text_width, write

# of a panel, of two tall ones, and of a picture with one
SIZE, TALL, NARROW, WIDE = (480, 480), (520, 720), (340, 720), (968, 410)
VIEW = 3.5  # tiles
PART, TIMES = 40, 4  # side of the part that is magnified, pixels, and how many times larger it is
GAP = 8  # between two panels, pixels
LETTERS = 24  # height of the text on a picture and below it, pixels
FINER = 4  # lines are drawn on a grid of pixels that is finer by this factor, for smooth edges
ORANGE, BLUE = (213, 94, 0), (0, 72, 140)
PAPER, GLASS = (232, 236, 240), (190, 213, 236)  # of a drawing
# colours and widths of a line from a name to a place, and of one from a name on dark ground
LEADER, PALE_LEADER = (("white", 5), (DARK, 2)), ((STRIP, 5), ("white", 2))
DARK_GROUND = 130  # below this mean of a picture's bytes, names are white
Point = tuple[float, float]  # of a picture, pixels
Picture = NDArray[np.uint8]


class Panel(NamedTuple):
    """A scene and its caption, and what is drawn on it. Places are in the plane z = 0, tiles."""

    scene: Scene
    text: str
    line: Sequence[complex] = ()
    dashes: Sequence[Sequence[complex]] = ()  # the ends of each
    names: Mapping[str, tuple[complex, ...]] = {}  # the middle of each, and the ends of the lines from it
    magnify: complex | None = None  # the middle of the part that is shown larger, at the left
    overlay: bool = False
    side_view: bool = False  # below all panels
    section: str = ""  # the prisms' tops, in a drawing of a prism below the panel
    brighter: float = 1  # factor of the light in the window
    rays: int = 1  # how many times as many rays along each side of a pixel as usual
    size: tuple[int, int] = SIZE


CHESS = Chess(view=VIEW)
FAR = CHESS.replace(alpha=90, z1=15)
ASIDE = CHESS.replace(x=-0.6)  # from E, so that the knight hides neither E nor the curves
LINE = Spheres(alpha=120, view=VIEW, line=(-0.7, 0.45), eye=(0.65, 0.45), z1=[6 * 2.0**n for n in range(-3, 4)])
ENDS = {"near": (LINE.L - 0.42 - 0.3j,), "far": (LINE.E + 0.45 - 0.3j,)}
# where the circle's other points are: a sphere would have to stand at a negative z1
REST = LINE.L + (LINE.E - LINE.L) / (1 + np.exp(1j * np.radians(LINE.alpha)) / np.tan(np.linspace(-1.5, -0.07, 28)))
ACROSS = (-1.4 + 0j, 1.4 + 0j)  # at the height of the eye
BUILT = Chess(alpha=66, z1=10, z2=10, aperture=2, view=2.4, background="black", floor="none")
FINE = CHESS.replace(z1=2.5)
PREDICTED = CHESS.replace(predicted_image=True)
IMAGE = {"predicted image": (0.7 - 1.1j, 0.48 - 0.65j)}
OUTLINED = CHESS.replace(alpha=40, direct_image=True)
DIRECT = {"without sheets": (-0.78 + 0.92j, 0.01 + 0.51j)}
EMPTY = {"sheet": "none", "window": "sheet=none,z=2"}
TWO = CHESS.replace(sheet="ideal", alpha=120, window="alpha=120,z=2", z2=8, eye=(0.6, 0.1))
MANY_RAYS = 1025  # a pixel
PUPIL = Chess(sheet="ideal", alpha=0, z1=3, pupil=0.3, view=3.3)
PLACES = {"king": -3, "queen": -1.8, "bishop": -0.6, "knight": 0.6, "rook": 1.8, "pawn": 3}
PIECES = Chess(
    sheet="none",
    piece=[*PLACES],
    x=[*PLACES.values()],
    z1=8,
    aperture=5,
    pedestal=0.8,
    eye=(0, 0.66),
    view=1.54,
    look=(0, -0.09),
)
WHITE = Chess(
    z1=8,
    z2=8,
    color="white",
    floor="none",
    pedestal=0.3,
    background="black",
    view=2.5,
    look=(-0.05, -0.05),
    glass="N-SF11",
    wavelength="white",
)
POLARISED = Chess(prisms=1000, background="white", floor="none", view=3.3, polariser=0, analyser=0)
CROSSED = POLARISED.replace(analyser=90)


def measured(scene: Chess) -> str:
    """Return by how much the piece is turned: measured, and as predicted for these sheets."""
    (found,) = agreement.pieces([scene])
    sheets = "ideal sheet" if scene.sheet == "ideal" else "100 prisms"
    return f"{sheets}: {found.nu:.1f}°, predicted {scene.nu_and_M(scene.z1)[0]:.1f}°"


PANELS: dict[str, list[Panel]] = {
    "prisms": [
        Panel(
            Chess(prisms=12, z1=2.5, view=4.14),  # the frame, though nearer, looks as large as the others'
            "α = 66°: 12 prisms in each sheet",
            names={"inside of the frame": (-0.76 - 1.63j, -1.64 - 1.165j)},
        ),
        Panel(FINE, "100 prisms", names={"stray light": (-0.93 + 1.24j, -1.1 + 0.5j)}, magnify=0.05 - 0.69j),
        Panel(FINE.replace(sheet="ideal"), "infinitely many: the ideal sheet"),
    ],
    "prediction": [
        Panel(PREDICTED, "measured", names=IMAGE),  # the text is that of `measured`
        Panel(PREDICTED.replace(sheet="ideal"), "measured", names=IMAGE),
    ],
    "single": [
        Panel(CHESS.replace(sheet="none"), "without a sheet"),
        Panel(
            CHESS.replace(sheet="single"),
            "one sheet: what is far is upside down",
            ACROSS,
            names={
                "mirror line": (0.9 + 0.25j, 0.9 + 0.03j),
                "near knight:": (0.85 - 0.38j,),
                "taller": (0.85 - 0.57j, 0.15 - 0.7j),
                "stray light": (-0.9 - 0.62j, -0.75 - 1.05j),
            },
        ),
    ],
    "black-tops": [
        Panel(CHESS, "clear prisms", names={"stray light": (-0.75 + 1.2j, -1.05 + 0.7j)}, section="clear"),
        Panel(CHESS.replace(tops="black"), "black tops: most stray light is absorbed", section="black"),
    ],
    "ideal": [
        Panel(
            ASIDE.replace(sheet="none"),
            "without sheets",
            names={
                "eye": (0.38 + 0.15j,),
                "foot as seen": (0.5 - 0.68j,),
                "foot, projected": (0.2 - 1.02j, -0.56 - 0.87j),
            },
            overlay=True,
        ),
        Panel(
            ASIDE.replace(sheet="ideal"),
            "α = 66°: foot where the curves cross",
            names={"all z₁": (0.75 - 0.05j, 0.11 - 0.2j), "all α": (-1.15 - 0.35j, -0.95 - 0.66j)},
            overlay=True,
        ),
    ],
    "real-image": [
        Panel(CHESS.replace(sheet="none"), "without sheets"),
        Panel(CHESS.replace(sheet="ideal", alpha=180), "α = 180°: rays meet in front of the sheets", side_view=True),
    ],
    "imaging": [
        Panel(TWO.replace(**EMPTY), "two windows without sheets", names={"window 2": (0.3 + 0.9j, 0.3 + 1.25j)}),
        Panel(
            TWO, "α = 120° each: upright real image", names={"window 2": (-0.75 + 0.9j, -1.1 + 1.36j)}, side_view=True
        ),
    ],
    "far": [
        Panel(FAR.replace(sheet="none"), "without sheets", ACROSS, names={"horizon": (-1.1 + 0.25j, -1.1 + 0.03j)}),
        Panel(
            FAR.replace(sheet="ideal"),
            "α = 90°: the horizon is vertical",
            (-1.4j, 1.4j),
            names={"horizon": (0.55 - 1.1j, 0.03 - 1.1j)},
        ),
    ],
    "spheres": [
        Panel(
            LINE.replace(sheet="none"),
            "without sheets: spheres on a line",
            names={**ENDS, "far spheres are made larger": (-0.45j,)},
            overlay=True,
        ),
        Panel(
            LINE.replace(sheet="ideal"),
            "α = 120°: they appear on a circle",
            dashes=REST.reshape(-1, 2),
            names={
                **ENDS,
                "no sphere": (0.58j,),
                "all z₁": (-0.3 + 0.1j, -0.76 - 0.1j),
                "predicted": (-0.3j, -0.03 - 0.66j),
            },
            overlay=True,
        ),
    ],
    "refraction": [
        Panel(OUTLINED.replace(sheet="ideal"), "light turned by 40°: 1.05 × as large", names=DIRECT),
        Panel(OUTLINED.replace(sheet="refraction", ratio=0.4), "refracted too: 0.77 × as large", names=DIRECT),
    ],
    "pieces": [
        Panel(
            PIECES, "", names={name: (6 / 14 * x - 0.71j, 6 / 14 * x - 0.71j) for name, x in PLACES.items()}, size=WIDE
        )
    ],
    "lenticular": [
        Panel(BUILT.replace(prisms=1000), "Dove prisms, α = 66°: sharp", rays=2),
        Panel(BUILT.replace(sheet="lenticular", lenses=1000), "cylindrical lenses, f/3: blurred", rays=2),
        Panel(
            BUILT.replace(sheet="lenticular", lenses=1000, f_number=6),
            "lenses, f/6: sharper, but with ghosts",
            names={
                "ghosts": (-0.75 + 0j, -0.62 + 0.6j, -0.58 - 0.55j),
                "two more": (0.7 + 0.16j, 0.7 + 0.45j, 0.66 - 0.72j),
            },
            rays=2,
        ),
    ],
}
# the pictures of docs/light.md and docs/tolerances.md
OTHERS: dict[str, list[Panel]] = {
    "white": [
        Panel(
            WHITE.replace(sheet="lenticular", lenses=1500, f_number=6),
            "white light through lenses: blurred, ghosts",
            names={
                "ghost": (0.19 + 0.82j, -0.17 + 0.61j),
                "another ghost": (0.38 - 1.2j, -0.03 - 0.94j),
                "enlarged × 4": (-0.545 - 0.47j,),
            },
            magnify=-0.04 - 0.085j,
            size=TALL,
            rays=2,
        ),
        Panel(
            WHITE.replace(prisms=1500, look=(0.25, -0.05)),
            "through prisms: sharp",
            names={"stray light": (0.52 + 0.8j, 0.07 + 0.68j)},
            size=NARROW,
            rays=2,
        ),
    ],
    "polarised": [
        Panel(
            POLARISED,
            "parallel: 34 % of designed light passes",
            names={"stray light": (-0.95 + 0.5j, -0.52 + 1.1j)},
            rays=3,
        ),
        Panel(CROSSED, "crossed: 1.5 % of designed light passes", rays=3),
        Panel(
            CROSSED,
            "crossed, 6 × brighter: mostly stray light",
            names={
                "designed light": (-0.92 - 0.25j, -0.13 - 0.4j),
                "stray light": (0.3 - 1.4j, -0.45 - 1.28j, 0.08 - 0.97j, 0.85 - 1.1j),
            },
            brighter=6,
            rays=3,
        ),
    ],
    "pupil": [
        Panel(PUPIL, "α = 0°: knight sharp"),
        Panel(PUPIL.replace(alpha=90), "α = 90°: no focus makes it sharp"),
        Panel(PUPIL.replace(alpha=180), "α = 180°: knight sharp"),
    ],
}


def panel(shown: Panel, look: Mapping[str, Any]) -> Picture:
    """Return the scene's picture with its caption and what is drawn on it. `look` are options of `render`."""
    scene = shown.scene
    width, height = shown.size

    def pixels(z: complex) -> Point:
        z -= scene.middle
        return width / 2 + z.real * height / scene.view, height / 2 - z.imag * height / scene.view

    plain = scene.replace(predicted_image=False) if isinstance(scene, Chess) else scene
    size = shown.rays * width, shown.rays * height
    # povgen's own number of rays leaves streaks where a pupil blurs much
    large = OpenGLView(plain).picture(size, MANY_RAYS) if plain.pupil else _rendered(plain, size=size, **look)
    starts = [*product(range(shown.rays), repeat=2)]
    parts = [large[row :: shown.rays, column :: shown.rays] for row, column in starts]
    picture = mixed(parts, [np.eye(3) / len(starts)] * len(starts))
    if shown.brighter != 1:
        opening = picture[window(scene, shown.size)]
        opening[:] = mixed([opening], [shown.brighter * np.eye(3)])
    image = Image.fromarray(picture)
    if shown.line:
        _lines(image, [[*map(pixels, shown.line)]], ("white", 6), (ORANGE, 3))
    _lines(image, [[*map(pixels, ends)] for ends in shown.dashes], *LEADER)
    if shown.magnify is not None:
        _magnify(image, scene.replace(view=scene.view * PART / height, look=shown.magnify), pixels(shown.magnify), look)
    for name, places in shown.names.items():
        _name(image, name, *map(pixels, places))
    text = measured(plain) if shown.text == "measured" else shown.text
    texts = [text] if text else []
    caption = Caption(texts, texts, LETTERS / (TEXT * height))
    rendering = Rendering(size=shown.size, caption="short", overlay=shown.overlay)
    made = annotated(np.asarray(image), scene, rendering, caption, said=[])
    return np.concatenate((made, _section(shown.section, width))) if shown.section else made


_rendered = cache(render)  # a scene that two panels show takes minutes


def _lines(image: Image.Image, lines: Sequence[Sequence[Point]], *strokes: tuple[Any, float]) -> None:
    """Draw lines with smooth edges. Each stroke, a colour and a width, lies on those before."""
    for colour, width in strokes:
        mask = Image.new("L", (FINER * image.width, FINER * image.height))
        draw = ImageDraw.Draw(mask)
        for line in lines:
            draw.line([(FINER * x, FINER * y) for x, y in line], fill=255, width=round(FINER * width), joint="curve")
        image.paste(colour, mask=mask.reduce(FINER))


def _name(image: Image.Image, name: str, middle: Point, *ends: Point) -> None:
    """Write a name on a picture, white on dark ground, with lines from its edge to the `ends`."""
    reach = np.array((LETTERS * text_width(name) / 2 + 5, 0.6 * LETTERS))
    low, high = middle - reach, middle + reach
    dark = bool(np.mean(image.crop((*low, *high)).convert("L")) < DARK_GROUND)
    for end in ends:
        _lines(image, [[tuple(np.clip(end, low, high)), end]], *(PALE_LEADER if dark else LEADER))
    write(ImageDraw.Draw(image), low[0] + 5, middle[1], name, LETTERS, edge=2, dark=not dark)


def _section(top: str, width: int) -> Picture:
    """Return a drawing of a Dove prism, with a "clear" or a "black" top, and of two paths of light through it."""
    image, prism = Image.new("RGB", (width, 128), PAPER), Prism(1.0)

    def pixels(places: Sequence[complex]) -> list[Point]:
        return [(56 * z.real + 160, 70 - 56 * z.imag) for z in places]

    base, tip, half = prism.length / 2, prism.top_length / 2, 0.5j * prism.height
    corners = pixels([-base - half, -tip + half, tip + half, base - half])
    ImageDraw.Draw(image).polygon(corners, fill=GLASS)
    _lines(image, [[*corners, corners[0]]], (DARK, 1.5))
    black = top == "black"
    designed, stray = pixels(_path(0, 0, 3)), pixels(_path(-0.13, -0.21, 3 if black else 5))
    for path, colour in ((designed, ORANGE), (stray[: -1 if black else None], BLUE)):
        _lines(image, [path], (colour, 3))
    if black:
        _lines(image, [corners[1:3]], ("black", 8))
    texts = {f"{top} top: {'absorbs' if black else 'reflects'}": (160, 18), "designed light": (374, designed[-1][1])}
    texts["stray light"] = (80, 113) if black else (344, 113)
    for text, middle in texts.items():
        _name(image, text, middle)
    return np.asarray(image)


def _path(height: float, slope: float, faces: int) -> list[complex]:
    """Return the places, in the section of a prism, where light starts, meets each of some faces, and is at last."""
    start, way, sheet = np.array([[0, height, 2.6]]), np.array([[0, slope, -1]]), GlassSheet(0, 0, Prism(1.0))
    # a trace of at most n faces ends on the n-th
    rays = [trace(start, way, (sheet,), 1, most=most) for most in range(1, faces + 1)]
    places = [start, *(ray.position for ray in rays), rays[-1].position + 0.45 * rays[-1].direction]
    return [complex(-z, y) for ((_, y, z),) in places]


def _magnify(image: Image.Image, part: Chess, middle: Point, look: Mapping[str, Any]) -> None:
    """Show a small part of a picture larger, rendered for its size, at the left edge."""
    (x, y), half, large = middle, PART / 2, PART * TIMES
    left, top = 44, round(y - large / 2)
    sides = [[(x - half, y + way * half), (left + large, y + way * large / 2)] for way in (-1, 1)]
    square = [(x + across * half, y + down * half) for across, down in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))]
    _lines(image, [*sides, square], (DARK, 5), ("white", 2))
    ImageDraw.Draw(image).rectangle([left - 2, top - 2, left + large + 1, top + large + 1], fill="white")
    image.paste(Image.fromarray(render(part, size=(large, large), **look)), (left, top))


def main() -> None:
    """Write the picture."""
    parser = ArgumentParser()
    parser.add_argument("name", choices=[*PANELS, *OTHERS])
    parser.add_argument("-o", dest="output", type=Path, required=True)
    given = parser.parse_args()
    panels = {**PANELS, **OTHERS}[given.name]
    look = {"quality": "high"} if given.name in PANELS else {"renderer": "gl", "antialias": "4x"}
    pictures = [panel(each, look) for each in panels]
    gap = np.full((len(pictures[0]), GAP, 3), STRIP, np.uint8)
    parts = [pictures[0], *(part for picture in pictures[1:] for part in (gap, picture))]
    rows = [np.concatenate(parts, axis=1)]
    if panels[-1].side_view:
        rows.append(side_view(panels[-1].scene, *(share * rows[0].shape[1] // 5 for share in (5, 4))))
    given.output.write_bytes(encode.png(np.concatenate(rows)))


if __name__ == "__main__":
    main()
