"""Compare what the live view draws in a browser with what OpenGL draws by the same shaders: `povgen verify --live`.

The view runs in a Chromium that draws without a GPU. `povgen verify --gl` compares the shaders with
the ray trace, eq. 7 and POV-Ray.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from povgen.measure.browser import View, chromium
from povgen.measure.measured import Measured
from povgen.measure.opengl import OpenGLView
from povgen.measure.probes import Size
from povgen.measure.verify_gl import RAYS
from povgen.measure.verify_rooms import SHADOW_RAYS
from povgen.rendering.flip import flip
from povgen.scene.presets import AxialScene, Chess, Spheres

SIZE = (320, 240)
SCENES: tuple[AxialScene, ...] = (
    Chess(),
    Chess(sheet="ideal", piece=("rook", "king"), x=(-0.5, 0.5), z1=(1.5, 3), color=("#e7b56f", "#5a3a22")),
    Chess(sheet="single", tops="black", prisms=30, eye=(0.4, 0.3)),
    Spheres(sheet="axis", axis=(0.3, 1, 0.2), alpha=15),
    Chess(sheet="law", law="x - k*X*z, y, z", parameter={"k": 0.1}, background="white"),
    Chess(sheet="lenticular", f_number=4, lenses=30),
    Chess(alpha=50, window=("alpha=75,z=2", "alpha=20,z=4,sheet=detailed,index=1.7"), sheet="ideal", z2=8),
)


def checks() -> Iterator[Measured]:
    """Measure everything. Raises InputError if Chromium or OpenGL cannot draw, or flip-evaluator is not installed."""
    with chromium() as browser:
        yield from same([(View(browser, scene), OpenGLView(scene)) for scene in SCENES])


def same(pairs: Sequence[tuple[View, OpenGLView]], size: Size = SIZE) -> Iterator[Measured]:
    """Compare the rays and the pictures of several views with those of OpenGL."""
    rays, pixels, difference = [], [], []
    for view, drawn in pairs:
        ours, theirs = drawn.readout(size), view.readout(size)
        near = np.linalg.norm((ours["ray"] - theirs["ray"])[..., :3], axis=-1) < 1e-3
        ends = (ours["ray"][..., 3] == theirs["ray"][..., 3]) & (ours["shown"][..., 0] == theirs["shown"][..., 0])
        rays.append(100 * (near & ends).mean())
        colours = [each.picture(size, SHADOW_RAYS, part=0).astype(int) for each in (drawn, view)]
        pixels.append(100 * (abs(colours[0] - colours[1]).max(-1) <= 2).mean())
        difference.append(flip(view.picture(size, RAYS), drawn.picture(size, RAYS)).mean())
    kind = f"worst of {len(pairs)} scenes"
    what = "rays that end as OpenGL's: on the same thing, within 1e-3 rad"
    yield Measured("live", f"{what}, {kind}", np.min(rays), 99.9, "%", least=True)
    what = "pixels with the colour of OpenGL's within 2 of 255, by rays through their centres"
    yield Measured("live", f"{what}, {kind}", np.min(pixels), 99.9, "%", least=True)
    yield Measured(
        "live", f"mean FLIP against OpenGL's picture, {RAYS} rays a pixel, {kind}", np.max(difference), 0.035
    )
