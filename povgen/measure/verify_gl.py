"""Compare what the live view's shaders draw with the ray trace, eq. 7 and POV-Ray's pictures: `povgen verify --gl`.

OpenGL draws, without a browser: `opengl.OpenGLView`. CPU seconds of both renderers are measured in one run.
"""

from collections.abc import Iterator, Sequence
from statistics import median
from typing import Any

import numpy as np

from povgen.measure import probes, verify_rooms
from povgen.measure.compare import window_rays
from povgen.measure.measured import SMALL, Measured, px
from povgen.measure.opengl import OpenGLView
from povgen.measure.probes import Directions, Mask, Positions, Size
from povgen.measure.results import results
from povgen.measure.speed import drawn_sample, picture_error, sample
from povgen.measure.targets import NOT_FOUND, other_targets, series_targets, targets
from povgen.measure.verify import PROFILES
from povgen.measure.verify_rooms import SAME, SHADOW_RAYS, SKY, WINDOW_FRAME
from povgen.rendering.flip import CONVERGED, flip, flip_evaluator
from povgen.rendering.light import Picture
from povgen.scene import camera
from povgen.scene.presets import AxialScene, Chess, Spheres
from povgen.scene.sdl import to_pov
from povgen.settings import PUPIL_RAYS
from povgen.video.still import render

PICTURE = (320, 240)  # pictures are compared at this size
RAYS = 64  # a pixel: `PACE.RAYS` in povgen/liveview/scheduling.js
PRISM_SCENES: tuple[dict[str, Any], ...] = (
    {},
    {"alpha": 35, "prisms": 400},
    {"alpha": 90, "eye": (0.5, -0.5)},
    {"alpha": 180, "prisms": 400, "z2": 3},
    {"alpha": 140, "prisms": 25, "eye": (0, 3), "z2": 8},
    {"alpha": -20, "prisms": 200, "z2": 3},
    {"alpha": 66, "index": 1.7, "base_angle": 40},
    {"alpha": 66, "gap": 0.1, "aspect": 0.9},
    {"sheet": "single", "prisms": 1, "z2": 9},
    {"error": {"index": 0.1, "far_index": -0.05, "base_angle": 5, "far_base_angle": -3}},
    {"z2": 9, "error": {"turn": 2, "tilt_x": 9, "tilt_y": -2, "far_tilt_x": -1, "far_tilt_y": -9, "separation": 0.1}},
    {"alpha": 120, "window": "alpha=120,z=2", "z2": 8},
    {"alpha": 60, "window": ("alpha=-35,z=1", "alpha=100,z=2.5"), "prisms": 400, "eye": (0.3, 0.2)},
    {
        "alpha": 60,
        "window": ("alpha=75,z=1.5,prisms=40,index=1.7,base_angle=40,gap=0.05", "z=3,sheet=single,prisms=70"),
    },
)
SCENES: tuple[AxialScene, ...] = (
    Chess(),
    Chess(alpha=140, z1=3, piece="queen", eye=(0.4, 0.3)),
    Chess(alpha=25, piece=("rook", "king"), x=(-0.5, 0.5), z1=(1.5, 3), color=("#e7b56f", "#5a3a22")),
    Spheres(),
    Spheres(alpha=110, z1=(2, 6)),
    Chess(alpha=120, window="alpha=120,z=2", z2=8, eye=(0.6, 0.1)),
)
OTHER_SCENES = (
    Chess(sheet="axis", axis=(0.3, 1, 0.2), alpha=15),
    Chess(sheet="refraction", ratio=0.3, alpha=40, z2=4, eye=(0.5, 0.2)),
    Chess(sheet="lenslets", ratio=1.5, alpha=180, eye=(0.2, 0.3)),
    Chess(sheet="mirror", alpha=70),
)


def checks() -> Iterator[Measured]:
    """Measure everything. Raises InputError if this system cannot draw with OpenGL, or has no flip-evaluator."""
    flip_evaluator()
    yield from directions()
    for kind, profiles in PROFILES.items():
        yield from directions(profiles, sheets=kind, least=99)
    yield from positions()
    for sheet in ("none", "ideal", "detailed"):
        yield from pictures(sheet, [scene.replace(sheet=sheet) for scene in SCENES])
    yield from pictures("other ideal sheets", OTHER_SCENES)
    yield from pupils()
    yield from verify_rooms.checks()
    yield from costs()


def directions(
    scenes: Sequence[dict[str, Any]] = PRISM_SCENES, size: Size = SMALL, sheets: str = "prisms", least: float = 99.8
) -> Iterator[Measured]:
    """Compare the directions in which the shader's rays leave the sheets with the exact ray trace.

    `scenes` are parameters of `Directions`. `sheets` names their kind in the result. `least` is the bound, in percent,
    for all rays that leave.
    """
    view, designed, leaving = OpenGLView(Directions()), [], []
    for values in scenes:
        scene = Directions(**{"sheet": "detailed", **values})
        view.set(scene)
        read = view.readout(size)
        rays, ray = window_rays(scene, size), read["ray"]
        off = np.linalg.norm(ray[rays.inside][:, :3] - rays.traced.direction, axis=1)
        same = (off < 1e-3) & (ray[rays.inside][:, 3] == rays.traced.end)
        designed.append(100 * same[rays.leaves & rays.traced.designed].mean())
        leaving.append(100 * same[rays.leaves].mean())
    kind = f"{sheets}, worst of {len(scenes)} scenes"
    what = "rays on the designed path within 1e-3 rad of the ray trace"
    yield Measured("gl", f"{what}, {kind}", np.min(designed), 99.9, "%", least=True)
    what = "all rays that leave, within 1e-3 rad of the ray trace"
    yield Measured("gl", f"{what}, {kind}", np.min(leaving), least, "%", least=True)


def positions(count: int = 20, size: Size = SMALL) -> Iterator[Measured]:
    """Compare where the shader's ideal sheets show points with the formulas, such as eq. 7 for a single window."""
    view, half = OpenGLView(Directions()), count // 2
    one = [*targets("ideal", half, seed=7, E=0j), *targets("ideal", half, seed=8, E=0.3 - 0.4j)]
    several = [scene for n in (2, 3) for scene in series_targets("ideal", n, half, seed=9, E=0.3 - 0.2j)]
    for what, scenes in (
        ("ideal: apparent position against eq. 7", one),
        ("2 and 3 ideal windows: apparent position against the complex depth", several),
        ("other ideal sheets: apparent position", [scene for several in other_targets().values() for scene in several]),
    ):
        off = [px(abs(_seen(view, scene, size) - scene.apparent_position(scene.L, scene.z1))) for scene in scenes]
        yield Measured("gl", f"{what}, {len(scenes)} points, worst", np.max(off), 0.1, "px")


def _seen(view: OpenGLView, scene: Positions, size: Size) -> complex:
    """Return where the shader shows the point L of a scene. NaN if too little around it is seen."""
    view.set(Directions(**scene.model_dump(include=set(Directions.model_fields))))
    read = {name: numbers.astype(float) for name, numbers in view.readout(size).items()}
    ray, origin = read["ray"], read["shown"][..., 1:]
    # where each pixel's ray crosses the plane of the point, relative to the point
    slope = (ray[..., 0] + 1j * ray[..., 1]) / ray[..., 2]
    last = scene.places[-1]
    shown = origin[..., 0] + 1j * origin[..., 1] + slope * (last + scene.z1 - origin[..., 2]) - scene.L
    inside = camera.rays(scene, size)[0] & (abs(origin[..., 2] - last) < 1e-3)  # through all windows
    pixels = scene.camera.pixels(size)[inside]
    return (probes.locate(pixels, shown[inside], scene.extent) or NOT_FOUND).position


def pictures(
    kind: str, scenes: Sequence[AxialScene], shown: Size = SMALL, size: Size = PICTURE, antialias: str = CONVERGED
) -> Iterator[Measured]:
    """Compare the shader's pictures with POV-Ray's: what each pixel shows, and how the converged pictures look.

    What pixels show is compared in pictures of the size `shown`; converged pictures have `size` and this antialiasing.
    """
    same, difference = [], []
    detailed = kind == "detailed"
    for scene, converged in zip(scenes, rendered(scenes, size, antialias), strict=True):
        view = OpenGLView(scene)
        same.append(100 * shows_the_same(view, scene, shown).mean())
        picture = view.picture(size, RAYS)
        difference.append(picture_error(picture, converged, scene)[1] if detailed else flip(picture, converged).mean())
    what, most = f"{kind}, worst of {len(scenes)} scenes", 0.08 if detailed else 0.05
    yield Measured("gl", f"pixels that show the same as POV-Ray's: {what}", np.min(same), 99.5, "%", least=True)
    where = "in the window, " if detailed else ""
    yield Measured("gl", f"mean FLIP against POV-Ray's converged picture: {where}{what}", np.max(difference), most)


def pupils(size: Size = (160, 120)) -> Iterator[Measured]:
    """Compare the blur of a pupil with that of the formulas, and pictures through it with POV-Ray's."""
    scenes = [
        Chess(sheet="ideal", alpha=90, z1=10, z2=10, pupil=0.04),
        Chess(sheet="ideal", alpha=50, window=[{"z": 1.5, "alpha": -120}], z1=3, pupil=0.3, focus=5),
        Chess(alpha=90, pupil=0.3, focus=7.5),
    ]
    table = results(scenes[:2], "pupil_blur", "seen_blur", progress=False)
    off = abs(table["seen_blur"] / table["pupil_blur"] - 1).max()
    yield Measured("gl", "blur by the pupil, ideal: the ray trace against 1/f - 1/Z, worst of 2", 100 * off, 1, "%")
    same = [
        (abs(OpenGLView(scene).picture(size, PUPIL_RAYS).astype(int) - picture).max(-1) < SAME).mean()
        for scene, picture in zip(scenes, rendered(scenes, size), strict=True)
    ]
    what = f"pixels like POV-Ray's through a pupil, worst of {len(scenes)} scenes"
    yield Measured("gl", what, 100 * min(same), 99, "%", least=True)


def shows_the_same(view: OpenGLView, scene: AxialScene, size: Size) -> Mask:
    """Return for each pixel whether the shader shows the same as POV-Ray at its centre: the sky, a piece, or neither.

    POV-Ray shows the sky where white instead of black behind the scene changes the picture, and a piece where the
    piece's colour does. Elsewhere are floor and frame, spheres, and lost rays: there the colours are compared.
    """
    variants = [scene, scene.replace(background="white"), scene.replace(background="black")]
    count = 0
    if scene.pieces:
        # in each picture one piece is green and the others are orange; in the last picture all are orange
        count = len(scene.pieces)
        colours = [["#008000" if n == k else "#ff8000" for n in range(count)] for k in range(count + 1)]
        variants += [scene.model_copy(update={"color": tuple(several)}) for several in colours]
    plain, white, black, *coloured = (picture.astype(int) for picture in rendered(variants, size))
    found = view.picture(size, SHADOW_RAYS, part=0)
    read = view.readout(size)["shown"][..., 0]
    agrees, named = np.ones(read.shape, bool), np.zeros(read.shape, bool)
    first = WINDOW_FRAME + len(scene.openings)
    changes = {SKY: white - black} | {first + k: coloured[k] - coloured[-1] for k in range(count)}
    for thing, change in changes.items():
        shown = abs(change).max(-1) > 2
        agrees &= shown == (read == thing)
        named |= shown
    return np.asarray(agrees & (named | (abs(found - plain).max(-1) < SAME)))


def rendered(scenes: Sequence[AxialScene], size: Size, antialias: str = "off") -> list[Picture]:
    """Return POV-Ray's pictures of the scenes, several of which are rendered at once."""
    return render(scenes, size=size, antialias=antialias, progress=False)


def costs(size: Size = SMALL, rounds: int = 5) -> Iterator[Measured]:
    """Compare the CPU seconds of the renderer gl for a frame with POV-Ray's: one ray a pixel, measured alternately."""
    for sheet, most in (("detailed", 0.11), ("ideal", 0.3)):
        scene = Chess(sheet=sheet)
        text, view = to_pov(scene), OpenGLView(scene)
        view.picture(size, 1)  # the first frame compiles the shaders
        seconds = [(drawn_sample(view, "off", size)[0], sample(text, "off", size)[0]) for _ in range(rounds)]
        ours, theirs = (median(several) for several in zip(*seconds, strict=True))
        what = f"CPU seconds of a frame of {size[0]}x{size[1]}, {sheet} ({ours:.3f}) / POV-Ray's ({theirs:.2f})"
        yield Measured("gl", what, ours / theirs, most)
