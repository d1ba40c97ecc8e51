"""Compare what follows from traced paths with formulas, and fits with the scenes of their points, for `verify`."""

import re
from collections.abc import Iterator
from importlib.util import find_spec
from math import cos, pi, radians, sin

import numpy as np

from povgen.files import temporary_folder
from povgen.measure.fit import fit
from povgen.measure.measured import Measured
from povgen.measure.probes import Size
from povgen.optics.polarisation import reflection
from povgen.optics.rays import Bundle
from povgen.rendering import povray
from povgen.rendering.frames import read_png
from povgen.scene.polarisers import passed
from povgen.scene.presets import Chess
from povgen.scene.room import Room
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering

ANGLES = (0, 0), (0, 90), (30, -45)  # of the polariser and the analyser
PHOTOGRAPHS, POINTS, NOISE = 200, 12, 0.01  # noise: tiles
# povgen's own sheets in a text
OWN = r"^(union \{\n  (Shape|object \{ ProfileSheet).*?^\}|object \{ (Profile)?Sheet\([^\n]*\}).*?$"
# In povgen's texts the ends of prisms are in the frame, or black. Cut ends reflect light. So both texts get black ends.
BLACK = """difference {
  box { -<1.001, 1.001, 0.99>, <1.001, 1.001, 0.99> } box { -<0.999, 0.999, 1>, <0.999, 0.999, 1> }
  scale Tile*<Window, Window, FrameDepth>/2 pigment { rgb 0 } finish { ambient 0 diffuse 0 }
}"""


def checks() -> Iterator[Measured]:
    """Measure everything. Solids are left out without povgen[parts]."""
    if find_spec("manifold3d") and find_spec("trimesh"):
        yield solids(Chess(prisms=30, alpha=50, z1=3, error={"facets": 0.5, "turn": 1, "tilt_x": 3, "seed": 3}))
    yield diffraction(Chess(sheet="single", prisms=6, gap=0.2))
    yield polarisers(Chess(prisms=300, alpha=66, z2=150, view=0.5))
    yield from intervals(Chess(sheet="ideal", alpha=66, z1=3, z2=7, eye=(0.3, 0.1)))


def diffraction(scene: Chess, count: int = 20_000) -> Measured:
    """Compare the diffraction pattern by traced lengths of rays along z, through one sheet, with that of a grating.

    N prisms of height h and pitch p have a slit's pattern times that of N lines (Born and Wolf, section 8.6.1).
    """
    edge, prism = scene.aperture / 2, scene.prism
    y = np.linspace(-edge, edge, count)
    light = scene.trace(Bundle(np.stack((0 * y, y, 0 * y - 4), -1), (0, 0, 1)), path=True)
    light = light[light.designed]
    wavelength, sine = prism.pitch / 40, np.linspace(-0.05, 0.05, 200)
    path = (light.length - light.position[:, 2])[:, None] - light.position[:, 1:2] * sine
    pattern = abs(np.exp(2j * pi / wavelength * path).mean(0)) ** 2
    step, lines = pi * prism.pitch * sine / wavelength, scene.prisms
    formula = (np.sinc(prism.height * sine / wavelength) * np.sin(lines * step) / (lines * np.sin(step))) ** 2
    what = f"diffraction by {lines} prisms, by traced lengths: intensity against a grating's, worst"
    return Measured("detailed", what, abs(pattern - formula).max(), 2e-4)


def polarisers(scene: Chess) -> Measured:
    """Compare the light that passes polarisers and default prisms along z with a closed form.

    A sheet is diag(t_s^2 r_s, t_p^2 r_p) in the axes along and across its ridges (docs/beyond.md).
    """
    n = scene.index
    slant = sin(radians(45))  # of the facets
    outside, base = (reflection(*at) for at in ((1, n, slant), (n, 1, cos(radians(45) + np.arcsin(slant / n)))))
    sheet = np.diag([(1 - r**2) * total for r, total in zip(outside, base, strict=True)])
    half = radians(scene.alpha) / 2
    turn = np.array([[cos(half), -sin(half)], [sin(half), cos(half)]])
    window, worst = turn @ sheet @ turn.T @ sheet, 0.0
    size = (64, 48)
    designed = scene.trace(scene.rays(size)).designed
    for polariser, analyser in ANGLES:
        found = passed(scene.replace(polariser=polariser, analyser=analyser), size)[designed]
        behind, before = (np.array([cos(radians(a)), sin(radians(a))]) for a in (polariser, analyser))
        worst = max(worst, float(abs(found - abs(before @ window @ behind) ** 2 / 2).max()))
    what = f"polarisers: light that passes along z against the closed form, worst of {len(ANGLES)}"
    return Measured("detailed", what, worst, 1e-3)


def intervals(scene: Chess) -> Iterator[Measured]:
    """Count how many of the stated 95 % intervals hold the true value, of fits to points with noise."""
    rng = np.random.default_rng(5)
    places = rng.uniform(-1, 1, (POINTS, 2))
    seen = scene.apparent_position(places[:, 0] + 1j * places[:, 1], scene.z1)
    points, start = np.stack((seen.real, seen.imag), -1), scene.replace(alpha=60, z1=2.5)
    fits = (fit(start, places, points + rng.normal(0, NOISE, points.shape), noise=NOISE) for _ in range(PHOTOGRAPHS))
    names = ("alpha", "z1")
    hits = [[abs(f.values[name] - getattr(scene, name)) < 1.96 * f.errors[name] for name in names] for f in fits]
    for name, share in zip(names, 100 * np.mean(hits, 0), strict=True):
        what = f"fit to {PHOTOGRAPHS} photographs: 95 % intervals of {name} that hold the true value ({share:.1f} %)"
        yield Measured("ideal", f"{what}: difference from 94.5 %", abs(share - 94.5), 4.5, "%")


def solids(scene: Chess | Room, size: Size = (160, 120)) -> Measured:
    """Compare POV-Ray's picture of the scene with one whose sheets are the solids that `part` writes."""
    from povgen.measure.part import part  # needs povgen[parts]

    own = to_pov(scene, size=size)
    own = own.replace("Edge(Window1_Width,", "Edge(0.999*Window1_Width,") if isinstance(scene, Room) else own + BLACK
    without = re.sub(OWN, "", own, flags=re.M | re.S)
    with temporary_folder() as folder:
        meshes = _meshes(part(scene, folder / "part.obj", 80).read_text(), 80, scene.sheets[0].glass[0].shape.index)
        pictures = [
            read_png(povray.run(text, Rendering(size=size, antialias="off"), folder)).astype(int)
            for text in (own, without, without + meshes)
        ]
    wanted, bare, found = pictures
    sheets = abs(bare - wanted).max(-1) > 2  # where they change the picture
    same = (abs(found - wanted).max(-1) <= 2) & sheets.any()
    return Measured("detailed", "solids of a part: pixels like the scene's", 100 * same.mean(), 99.7, "%", least=True)


def _meshes(text: str, tile: float, index: float) -> str:
    """Return the solids of a .obj file in POV-Ray's language. The indices of two sheets differ, as in povgen's text."""
    points: list[list[float]] = []
    solids: list[list[list[int]]] = []
    for kind, *words in (line.split() for line in text.splitlines() if line):
        if kind == "o":
            solids.append([])
        elif kind == "v":
            points.append([float(word) for word in words[:3]])
        elif kind == "f":
            solids[-1].append([int(word.partition("/")[0]) - 1 for word in words])
    made = ""
    for number, faces in enumerate(solids):
        places = np.array(points) * (1, 1, -1) / tile
        used, corners = np.unique(faces, return_inverse=True)
        lists = [
            f"{len(rows)}, {', '.join('<{:.9g}, {:.9g}, {:.9g}>'.format(*row) for row in rows)}"
            for rows in (places[used], corners.reshape(-1, 3))
        ]
        made += f"mesh2 {{ vertex_vectors {{ {lists[0]} }} face_indices {{ {lists[1]} }} texture {{ GlassTexture }}\n"
        made += f"interior {{ ior {index}*{1 + 1e-6 * number} }} no_shadow scale Tile }}\n"
    return made
