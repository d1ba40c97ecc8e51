"""Make a picture of the gallery that compares scenes side by side: `python docs/panels.py NAME -o FILE.png`."""

from argparse import ArgumentParser
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from povgen import Chess, Scene, Spheres, render
from povgen.paper import agreement
from povgen.settings import Rendering
from povgen.video import encode
from povgen.video.captions import Caption
from povgen.video.overlay import Item, annotated, legend, strip
from povgen.video.side import side_view
from povgen.video.text import DARK, STRIP, text_width, write

SIZE, WIDE = (480, 480), (968, 480)  # of a panel, and of a picture with one, pixels
VIEW = 3.5  # tiles
TIMES = 5  # how many times larger the magnified part is
GAP = 8  # between two panels, pixels
LETTERS = 22  # height of the text on a picture, pixels
Picture = NDArray[np.uint8]


class Panel(NamedTuple):
    """A scene and its caption, and what is drawn on it. Places are in the plane z = 0, tiles."""

    scene: Scene
    text: str
    line: tuple[complex, complex] | None = None
    names: dict[str, tuple[complex, complex]] = {}  # the middle of each, and where the line from it ends
    magnify: bool = False
    overlay: bool = False
    side_view: bool = False  # below all panels
    section: str = ""  # what the section of a prism, drawn at the lower left, says of the top face
    size: tuple[int, int] = SIZE


CHESS = Chess(view=VIEW)
FAR = CHESS.replace(alpha=90, z1=15)
LINE = Spheres(alpha=120, view=VIEW)
ACROSS = (-1.4 + 0j, 1.4 + 0j)  # at the height of the eye
MIRROR = {"mirror line": (0.9 + 0.25j, 0.9 + 0.03j)}
BUILT = Chess(alpha=66, z1=10, z2=10, view=3.4)
FINE = CHESS.replace(z1=2.5)
PREDICTED = CHESS.replace(predicted_image=True)
OUTLINED = CHESS.replace(alpha=40, direct_image=True)
EMPTY = {"sheet": "none", "window": "sheet=none,z=2"}
TWO = CHESS.replace(sheet="ideal", alpha=120, window="alpha=120,z=2", z2=8, eye=(0.6, 0.1))
PUPIL = Chess(sheet="ideal", alpha=0, z1=3, pupil=0.3, view=3.3)
PLACES = {"king": -3, "queen": -1.8, "bishop": -0.6, "knight": 0.6, "rook": 1.8, "pawn": 3}
PIECES = Chess(
    sheet="none", piece=[*PLACES], x=[*PLACES.values()], z1=8, aperture=5, pedestal=0.8, eye=(0, 0.66), view=1.8
)


def measured(scene: Chess) -> str:
    """Return by how much the piece is turned: measured, and as predicted for these sheets."""
    (found,) = agreement.pieces([scene])
    sheets = "ideal sheet" if scene.sheet == "ideal" else "100 prisms"
    return f"{sheets}: turned by {found.nu:.1f}°, predicted {scene.nu_and_M(scene.z1)[0]:.1f}°"


PANELS: dict[str, list[Panel]] = {
    "prisms": [
        Panel(Chess(prisms=12, z1=2.5), "α = 66°: 12 prisms in each sheet"),
        Panel(FINE, "100 prisms", magnify=True),
        Panel(FINE.replace(sheet="ideal"), "infinitely many: the ideal sheet"),
    ],
    "prediction": [
        Panel(PREDICTED, "measured"),  # the text is that of `measured`
        Panel(PREDICTED.replace(sheet="ideal"), "measured"),
    ],
    "single": [
        Panel(CHESS.replace(sheet="none"), "without a sheet", ACROSS, MIRROR),
        Panel(
            CHESS.replace(sheet="single"),
            "one sheet: what is far is upside down",
            ACROSS,
            MIRROR,
        ),
    ],
    "black-tops": [
        Panel(CHESS, "clear prisms", names={"stray light": (-0.75 + 1.2j, -1.05 + 0.7j)}, section="clear top"),
        Panel(CHESS.replace(tops="black"), "black tops: most stray light is absorbed", section="black top"),
    ],
    "ideal": [
        Panel(CHESS.replace(sheet="none"), "without sheets", overlay=True),
        Panel(CHESS.replace(sheet="ideal"), "α = 66°: the foot appears where curves cross", overlay=True),
    ],
    "real-image": [
        Panel(CHESS.replace(sheet="none"), "without sheets"),
        Panel(CHESS.replace(sheet="ideal", alpha=180), "α = 180°: rays meet in front of the sheets", side_view=True),
    ],
    "imaging": [
        Panel(TWO.replace(**EMPTY), "two windows without sheets"),
        Panel(TWO, "each window turns rays by α = 120°", side_view=True),
    ],
    "far": [
        Panel(FAR.replace(sheet="none"), "without sheets", ACROSS, {"horizon": (-1.1 + 0.25j, -1.1 + 0.03j)}),
        Panel(
            FAR.replace(sheet="ideal"),
            "α = 90°: the horizon is vertical",
            (-1.4j, 1.4j),
            {"horizon": (0.55 - 1.1j, 0.03 - 1.1j)},
        ),
    ],
    "spheres": [
        Panel(LINE.replace(sheet="none"), "without sheets: spheres on a line", overlay=True),
        Panel(LINE.replace(sheet="ideal"), "α = 120°: they appear on a circle", overlay=True),
    ],
    "refraction": [
        Panel(OUTLINED.replace(sheet="ideal"), "light turned by 40°"),
        Panel(OUTLINED.replace(sheet="refraction", ratio=0.5), "and refracted, index behind / in front 0.5: smaller"),
    ],
    "pieces": [
        Panel(
            PIECES, "", names={name: (6 / 14 * x - 0.71j, 6 / 14 * x - 0.71j) for name, x in PLACES.items()}, size=WIDE
        )
    ],
    "lenticular": [
        Panel(BUILT.replace(prisms=150), "Dove prisms, α = 66°: sharp"),
        Panel(BUILT.replace(sheet="lenticular", lenses=150), "cylindrical lenses, f/3, same pitch: blurred"),
        Panel(
            BUILT.replace(sheet="lenticular", lenses=150, f_number=6),
            "cylindrical lenses, f/6: sharper, with ghosts",
            names={"ghost of the floor": (-0.55 - 1.2j, -0.9 - 0.55j)},
        ),
    ],
    "pupil": [
        Panel(PUPIL, "α = 0°: sharp"),
        Panel(PUPIL.replace(alpha=90), "α = 90°: sharp at no distance"),
        Panel(PUPIL.replace(alpha=180), "α = 180°: sharp"),
    ],
}


def panel(shown: Panel) -> Picture:
    """Return the scene's picture with its caption and what is drawn on it."""
    scene = shown.scene
    width, height = shown.size

    def pixels(z: complex) -> tuple[float, float]:
        return width / 2 + z.real * height / scene.view, height / 2 - z.imag * height / scene.view

    if shown.magnify:
        large = Image.fromarray(render(scene, size=(TIMES * width, TIMES * height), antialias="off"))
        image = large.reduce(TIMES)
        _magnified(image, large)
    else:
        plain = scene.replace(predicted_image=False) if isinstance(scene, Chess) else scene
        renderer = "gl" if scene.pupil else "povray"
        image = Image.fromarray(render(plain, size=shown.size, quality="high", renderer=renderer))
    draw = ImageDraw.Draw(image)
    if shown.line:
        ends = [pixels(z) for z in shown.line]
        draw.line(ends, fill="white", width=6)
        draw.line(ends, fill=(213, 94, 0), width=3)
    if shown.section:
        _section(draw, shown.section)
    for name, (place, end) in shown.names.items():
        _name(draw, name, pixels(place), pixels(end))
    text = measured(shown.scene.replace(predicted_image=False)) if shown.text == "measured" else shown.text
    texts = [text] if text else []
    made = annotated(np.asarray(image), scene, _rendering(shown), Caption(texts, texts))
    return made[len(_key(shown, width)) :]


def _rendering(shown: Panel) -> Rendering:
    return Rendering(size=shown.size, caption="short", overlay=shown.overlay)


def _key(shown: Panel, width: int) -> Picture:
    """Return the strip with the key of a panel's overlay, for a picture of this width."""
    return strip([Item(text, text, colour) for text, colour in legend(shown.scene, _rendering(shown))], width, SIZE[1])


def _name(draw: ImageDraw.ImageDraw, name: str, middle: tuple[float, float], end: tuple[float, float]) -> None:
    """Write a name on a picture, with a line from its upper or lower edge, or from its side, to a place, in pixels."""
    (x, y), half = middle, LETTERS * text_width(name) / 2
    reach = np.array((half + 5, 0.6 * LETTERS))
    start = np.clip(np.subtract(end, middle), -reach, reach) + middle
    if middle != end:
        for colour, width in (("white", 5), (DARK, 2)):
            draw.line([tuple(start), end], fill=colour, width=width)
    write(draw, x - half, y, name, LETTERS, edge=2)


def _section(draw: ImageDraw.ImageDraw, text: str) -> None:
    """Draw the section of a Dove prism, with the light's path, at the lower left of a picture."""
    left, right, top, base = 38, 178, 396, 438
    slant = base - top  # the facets have 45 degrees
    draw.rectangle([left - 14, top - 40, right + 14, base + 14], fill=(95, 104, 118))
    corners = [(left, base), (left + slant, top), (right - slant, top), (right, base)]
    draw.polygon(corners, fill=(150, 175, 200))
    y, middle = base - slant / 3, (left + right) / 2  # where light meets the facets, and the base
    draw.line(
        [(left - 14, y), (left + base - y, y), (middle, base), (right - base + y, y), (right + 14, y)],
        fill=(213, 94, 0),
        width=3,
    )
    draw.line(corners[1:3], fill="black" if text.startswith("black") else "white", width=6)
    write(draw, middle - 16 * text_width(text) / 2, top - 20, text, 16)


def _magnified(image: Image.Image, large: Image.Image) -> None:
    """Show a small part of a picture, from its larger copy, at the lower left, and label a patch of stray light."""
    left, top, side = 226, 316, 34
    bottom, right = SIZE[1] - 10, 10 + TIMES * side
    draw = ImageDraw.Draw(image)
    draw.line([(left, top), (10, bottom - TIMES * side)], fill="white", width=2)
    draw.line([(left + side, top + side), (right, bottom)], fill="white", width=2)
    draw.rectangle([left - 2, top - 2, left + side + 1, top + side + 1], outline="white", width=2)
    box = [TIMES * x for x in (left, top, left + side, top + side)]
    image.paste(large.crop(box), (10, bottom - TIMES * side))
    draw.rectangle([8, bottom - TIMES * side - 2, right + 1, bottom + 1], outline="white", width=2)
    _name(draw, "stray light", (112, 70), (90, 170))


def main() -> None:
    """Write the picture."""
    parser = ArgumentParser()
    parser.add_argument("name", choices=PANELS)
    parser.add_argument("-o", dest="output", type=Path, required=True)
    given = parser.parse_args()
    panels = PANELS[given.name]
    pictures = [panel(each) for each in panels]
    gap = np.full((len(pictures[0]), GAP, 3), STRIP, np.uint8)
    parts = [pictures[0], *(part for picture in pictures[1:] for part in (gap, picture))]
    joined = np.concatenate(parts, axis=1)
    keyed = panels[-1 if panels[-1].overlay else 0]  # through sheets an overlay has more lines
    rows = [_key(keyed, joined.shape[1]), joined]
    if panels[-1].side_view:
        rows.append(side_view(panels[-1].scene, joined.shape[1], 3 * joined.shape[1] // 5))
    given.output.write_bytes(encode.png(np.concatenate(rows)))


if __name__ == "__main__":
    main()
