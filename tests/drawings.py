"""Overlays, captions and side views of some scenes, as they were when somebody last looked at them: in tests/data.

`python tests/drawings.py` draws them again: look at them.
"""

from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from povgen import Chess, Eye, Piece, Room, Ruler, Sphere, Spheres, Window
from povgen.settings import Rendering
from povgen.video import overlay, side

DATA = Path(__file__).with_name("data")
SIZE = (400, 300)
SCENES = {
    "ideal": Chess(sheet="ideal", alpha=66, z1=2),
    "windows": Chess(sheet="ideal", alpha=120, window="alpha=120,z=2", z2=8, z1=2, predicted_image=True),
    "axis": Chess(sheet="axis", axis=(0.2, 1, 0), alpha=20, piece="king", eye=(0.4, 0.3)),
    "lens": Chess(sheet="lens", piece="rook"),
    "spheres": Spheres(sheet="detailed", alpha=40, prisms=30, view=1.5),
    "room": Room(
        [Window(name="left", alpha=90, x=-1.75), Window(x=1.75, yaw=20), Piece(x=-1.6, y=-0.85, z=2.5)]
        + [Sphere(x=3.9, radius=0.3), Ruler(y=-1.5, z=1)],
        eye=Eye(y=0.5, z=-9, view=7),
    ),
}


def file(name):
    return DATA / f"drawing-{name}.png"


def drawn(name):
    """Return what is drawn on a grey picture of the scene, with the strips above and below it."""
    scene = SCENES[name]
    rendering = Rendering(size=SIZE, overlay=True, caption="full")
    grey = np.full((SIZE[1], SIZE[0], 3), 120, np.uint8)
    return overlay.annotated(grey, scene, rendering, sketch=partial(side.side_view, scene))


if __name__ == "__main__":
    for each in SCENES:
        Image.fromarray(drawn(each)).save(file(each), optimize=True)
