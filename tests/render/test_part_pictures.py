"""A file of `povgen part`, read back and put into POV-Ray's scene, bends light as povgen's own text does."""

import re

import numpy as np
import pytest
from conftest import some

from povgen import Chess, Floor, Piece, Rendering, Room, Window, part, to_pov
from povgen.rendering import frames, povray

SIZE = (160, 120)
ERRORS = {"facets": 0.5, "pitches": 0.02, "turn": 1, "tilt_x": 3, "far_tilt_y": -2, "seed": 3}
TILTED = Window(
    sheet="detailed", prisms=30, alpha=70, outline="round", height=2, x=0.3, z=1, yaw=30, pitch=9, roll=5, frame=False
)
WEDGES = {"sheet": "profile", "profile": "wedges", "arrangement": "single", "periods": 20, "z1": 4}
SCENES = [
    Chess(prisms=30, alpha=50, z1=3, error=ERRORS),
    Room([TILTED, Piece(z=5, y=-1), Floor(y=-2)]),
    Chess(**WEDGES),
    Chess(prisms=30, sheet="single"),
]
# povgen's own sheets in a text
OWN = r"^(union \{\n  (Shape|object \{ ProfileSheet).*?^\}|object \{ (Profile)?Sheet\([^\n]*\}).*?$"
# In povgen's texts the ends of prisms are in the frame, or black. Cut ends reflect light. So both texts get black ends.
BLACK = """difference {
  box { -<1.001, 1.001, 0.99>, <1.001, 1.001, 0.99> } box { -<0.999, 0.999, 1>, <0.999, 0.999, 1> }
  scale Tile*<Window, Window, FrameDepth>/2 pigment { rgb 0 } finish { ambient 0 diffuse 0 }
}"""


def meshes(path, tile, index):
    """Return the solids of a .obj file in POV-Ray's language. The indices of two sheets differ, as in povgen's text."""
    points, faces = [], {}
    for line in path.read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "o":
            own = faces[words[0]] = []
        elif kind == "v":
            points.append([float(word) for word in words[:3]])
        elif kind == "f":
            own.append([int(word.partition("/")[0]) - 1 for word in words])
    text = ""
    for number, own in enumerate(faces.values()):
        used, corners = np.unique(own, return_inverse=True)
        places = np.array(points)[used] * (1, 1, -1) / tile
        lists = [
            f"{len(rows)}, {', '.join('<{:.9g}, {:.9g}, {:.9g}>'.format(*row) for row in rows)}"
            for rows in (places, corners.reshape(-1, 3))
        ]
        text += f"mesh2 {{ vertex_vectors {{ {lists[0]} }} face_indices {{ {lists[1]} }} texture {{ GlassTexture }}\n"
        text += f"interior {{ ior {index}*{1 + 1e-6 * number} }} no_shadow scale Tile }}\n"
    return text


@pytest.mark.parametrize("scene", some(SCENES, 1), ids=["errors", "room", "wedges", "single"])
def test_a_part_makes_the_picture_of_the_scene(scene, tmp_path):
    own = to_pov(scene, size=SIZE)
    own = own.replace("Edge(Window1_Width,", "Edge(0.999*Window1_Width,") if isinstance(scene, Room) else own + BLACK
    without, count = re.subn(OWN, "", own, flags=re.M | re.S)
    assert count == (1 if isinstance(scene, Room) else len(scene.sheets[0].glass))
    both = own, without + meshes(part(scene, tmp_path / "part.obj", 80), 80, scene.sheets[0].shape.index)
    wanted, found = (
        frames.read_png(povray.run(text, Rendering(size=SIZE, antialias="off"), tmp_path)).astype(int) for text in both
    )
    # rays that pass by an edge can differ
    assert (abs(found - wanted).max(-1) <= 2).mean() > 0.997
