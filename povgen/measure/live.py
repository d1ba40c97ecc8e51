"""Compare the live view with the exact ray trace, with eq. 7 and with POV-Ray's pictures: `povgen verify --live`.

The view runs in a Chromium that draws without a GPU. Chromium's and POV-Ray's CPU seconds are measured in one run.
"""

from collections.abc import Iterator, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from povgen.measure import probes
from povgen.measure.browser import View, chromium
from povgen.measure.measured import SMALL, Measured, px
from povgen.measure.probes import Directions, Mask, Positions, Size
from povgen.measure.speed import cpu_seconds, picture_error
from povgen.measure.targets import NOT_FOUND, other_targets, series_targets, targets
from povgen.optics.trace import End
from povgen.rendering.flip import CONVERGED, flip
from povgen.scene import camera, survey
from povgen.scene.models import Chess, Scene, Spheres
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering

if TYPE_CHECKING:
    from povgen.measure.browser import Browser

PICTURE = (320, 240)  # pictures are compared at this size
RAYS = 64  # a pixel: `PACE.RAYS` in templates/live/scheduling.js
SHADOW_RAYS = 13  # through the same point, for soft shadows: each asks for one of the sun's lights
SAME = 15  # of 255: two pixels of floor or frame whose colours differ by less show the same
SKY, OBJECT = 0, 3  # templates/live/objects.glsl
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
    {"alpha": 120, "window": "alpha=120,z=2", "z2": 8},
    {"alpha": 60, "window": ("alpha=-35,z=1", "alpha=100,z=2.5"), "prisms": 400, "eye": (0.3, 0.2)},
)
SCENES: tuple[Scene, ...] = (
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
    """Measure everything. Raises InputError if no browser can show the view."""
    with chromium() as browser:
        yield from directions(View(browser, Directions(sheet="detailed")))
        yield from positions(View(browser, Directions(sheet="ideal"), other_targets()["law"]))
        for sheet in ("none", "ideal", "detailed"):
            yield from pictures(browser, sheet, [scene.replace(sheet=sheet) for scene in SCENES])
        yield from pictures(browser, "other ideal sheets", OTHER_SCENES)
        yield cost(View(browser, Chess()))


def directions(view: View, scenes: tuple[dict[str, Any], ...] = PRISM_SCENES, size: Size = SMALL) -> Iterator[Measured]:
    """Compare the directions in which the view's rays leave the sheets with the exact ray trace."""
    designed, leaving = [], []
    for values in scenes:
        scene = Directions(**{"sheet": "detailed", **values})
        view.set(scene)
        read = view.readout(size)
        inside, direction = camera.rays(scene, size)
        trace_level = survey.max_trace_level(scene)
        found = probes.traced(scene, direction, trace_level)
        seen = (found.end <= End.BACK) & (found.count < trace_level)
        off = np.linalg.norm(read["ray"][inside][:, :3] - found.direction, axis=1)
        same = (off < 1e-3) & (read["ray"][inside][:, 3] == found.end)
        designed.append(100 * same[seen & found.designed].mean())
        leaving.append(100 * same[seen].mean())
    kind = f"worst of {len(scenes)} scenes"
    what = "rays on the designed path within 1e-3 rad of the ray trace"
    yield Measured("live", f"{what}, {kind}", np.min(designed), 99.8, "%", least=True)
    what = "all rays that leave, within 1e-3 rad of the ray trace"
    yield Measured("live", f"{what}, {kind}", np.min(leaving), 99, "%", least=True)


def positions(view: View, count: int = 20, size: Size = SMALL) -> Iterator[Measured]:
    """Compare where the view's ideal sheets show points with eq. 7, or what takes its place."""
    half = count // 2
    one = [*targets("ideal", half, seed=7, E=0j), *targets("ideal", half, seed=8, E=0.3 - 0.4j)]
    several = [scene for n in (2, 3) for scene in series_targets("ideal", n, half, seed=9, E=0.3 - 0.2j)]
    for what, scenes in (
        ("ideal: apparent position against eq. 7", one),
        ("2 and 3 ideal windows: apparent position against the complex depth", several),
        ("other ideal sheets: apparent position", [scene for several in other_targets().values() for scene in several]),
    ):
        off = [px(abs(_seen(view, scene, size) - scene.apparent_position(scene.L, scene.z1))) for scene in scenes]
        yield Measured("live", f"{what}, {len(scenes)} points, worst", np.max(off), 0.3, "px")


def _seen(view: View, scene: Positions, size: Size) -> complex:
    """Return where the view shows the point L of a scene. NaN if too little around it is seen."""
    view.set(Directions(**scene.model_dump(include=set(Directions.model_fields))))
    read = {name: numbers.astype(float) for name, numbers in view.readout(size).items()}
    ray, origin = read["ray"], read["shown"][..., 1:]
    # where each pixel's ray crosses the plane of the point, relative to the point
    slope = (ray[..., 0] + 1j * ray[..., 1]) / ray[..., 2]
    last = scene.places[-1]
    shown = origin[..., 0] + 1j * origin[..., 1] + slope * (last + scene.z1 - origin[..., 2]) - scene.L
    inside = camera.rays(scene, size)[0] & (abs(origin[..., 2] - last) < 1e-3)  # through all windows
    pixels = camera.pixels(scene, size)[inside]
    return (probes.locate(pixels, shown[inside], scene.extent) or NOT_FOUND).position


def pictures(browser: "Browser", kind: str, scenes: Sequence[Scene]) -> Iterator[Measured]:
    """Compare the view's pictures with POV-Ray's: what each pixel shows, and how the converged pictures look."""
    same, difference = [], []
    detailed = kind == "detailed"
    for scene in scenes:
        view = View(browser, scene)
        same.append(100 * shows_the_same(view, scene).mean())
        converged, picture = rendered(scene, PICTURE, CONVERGED).astype(np.uint8), view.picture(PICTURE, RAYS)
        difference.append(picture_error(picture, converged, scene)[1] if detailed else flip(picture, converged).mean())
        view.page.close()
    what, least, most = f"{kind}, worst of {len(scenes)} scenes", 97 if detailed else 99.5, 0.07 if detailed else 0.05
    yield Measured("live", f"pixels that show the same as POV-Ray's: {what}", np.min(same), least, "%", least=True)
    where = "in the window, " if detailed else ""
    yield Measured("live", f"mean FLIP against POV-Ray's converged picture: {where}{what}", np.max(difference), most)


def shows_the_same(view: View, scene: Scene) -> Mask:
    """Return for each pixel, with one ray, whether the view shows the same as POV-Ray: the sky, a piece, or else.

    POV-Ray shows the sky where white instead of black behind the scene changes the picture, and a piece where the
    piece's colour does. Elsewhere are floor and frame, spheres, and lost rays: there the colours are compared.
    """
    plain = rendered(scene, SMALL)
    found = view.picture(SMALL, SHADOW_RAYS, part=0)
    read = view.readout(SMALL)["shown"][..., 0]
    white, black = (rendered(scene.replace(background=background), SMALL) for background in ("white", "black"))
    povray_shows, view_shows = {SKY: abs(white - black)}, {SKY: read == SKY}
    if isinstance(scene, Chess):
        without = rendered(scene.replace(color="#ff8000"), SMALL)
        for k in range(len(scene.pieces)):
            other = tuple("#008000" if n == k else "#ff8000" for n in range(len(scene.pieces)))
            povray_shows[OBJECT + k] = abs(rendered(scene.replace(color=other), SMALL) - without)
            view_shows[OBJECT + k] = read == OBJECT + k
    agrees, named = np.ones(read.shape, bool), np.zeros(read.shape, bool)
    for thing, change in povray_shows.items():
        shown = change.max(-1) > 2
        agrees &= shown == view_shows[thing]
        named |= shown
    return np.asarray(agrees & (named | (abs(found - plain).max(-1) < SAME)))


def rendered(scene: Scene, size: Size, antialias: str = "off") -> NDArray[np.int_]:
    """Return POV-Ray's picture, (height, width, 3)."""
    return cpu_seconds(to_pov(scene), Rendering(size=size, antialias=antialias))[1].astype(int)


def cost(view: View, size: Size = SMALL, rounds: int = 5) -> Measured:
    """Compare the CPU seconds of one frame with POV-Ray's, one ray a pixel, in turns."""
    scene = Chess()
    text, rendering = to_pov(scene), Rendering(size=size, antialias="off")
    view.set(scene)
    view.picture(size, 1)  # the first frame compiles the shaders
    povray, live = [], []
    for _ in range(rounds):
        povray.append(cpu_seconds(text, rendering)[0])
        live.append(view.measured(size, 1)[0])
    ours, theirs = median(live), median(povray)
    what = f"CPU seconds of a detailed frame of {size[0]}x{size[1]} ({ours:.2f}) / POV-Ray's ({theirs:.2f})"
    return Measured("live", what, ours / theirs, 1.5)
