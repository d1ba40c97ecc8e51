"""How long rendering takes, before it begins.

The numbers are CPU seconds of the machine in docs/speed.md. On that machine, POV-Ray takes about 2 s for a picture of
640x480 pixels through 2x100 prisms, without antialiasing. On another machine, and for another scene, rendering can take
half or twice as long. The renderer gl was measured without a GPU.
"""

from collections.abc import Sequence

from povgen.rendering.parallel import cores
from povgen.rendering.views import views
from povgen.scene.scenes import Scene
from povgen.settings import Rendering

# CPU seconds: for each picture, for each ray, and in addition for each window of glass that a ray passes
COSTS = {"povray": (0.05, 1.3e-6, 9e-6), "gl": (0.03, 2e-7, 5e-7)}
# With POV-Ray's own antialiasing, a pixel has on average 1 + this * depth^2 rays: without and through prisms.
MORE_RAYS = 0.35, 0.8
LONG = 60.0  # seconds of wall time


def cpu_seconds(scenes: Sequence[Scene], rendering: Rendering) -> float:
    """Return about how many CPU seconds these pictures take. Equal ones are rendered once."""
    return sum(_cpu_seconds(scene, rendering) for scene in {*scenes})


def _cpu_seconds(scene: Scene, rendering: Rendering) -> float:
    sampling = rendering.suited(scene.has_prisms)
    width, height = rendering.size
    rays = float(sampling.rays)
    if rendering.renderer == "povray":
        antialias, more = sampling.antialias, MORE_RAYS[scene.has_prisms]
        rays = 1 + more * antialias[2] ** 2 if isinstance(antialias, tuple) else sampling.supersampling**2
    picture, ray, glass = COSTS[rendering.renderer]
    layered = sum(sheet.layers > 0 for sheet in scene.sheets)
    inside = min(1.0, height / width * (scene.aperture / scene.view) ** 2)  # the first window's part of the picture
    return len(views(scene, rendering)) * (picture + width * height * rays * (ray + layered * inside * glass))


def describe(scenes: Sequence[Scene], rendering: Rendering) -> str:
    """Return in words what these pictures are, and how long they take if none is in the cache."""
    seconds, count = cpu_seconds(scenes, rendering), len({*scenes})
    width, height = rendering.size
    what, each = ("a picture", "") if len(scenes) == 1 else (f"{len(scenes)} frames", " each")  # a shard can have none
    differing = f", {count} of them different," if count < len(scenes) else ""
    where = " without a GPU" if rendering.renderer == "gl" else ""
    one = _rounded(seconds / max(count, 1))
    return (
        f"{what}{differing} of {width}x{height} pixels, about {one} CPU seconds{each}, without "
        f"those in the cache: about {duration(seconds / cores())} on {cores()} cores{where}"
    )


def duration(seconds: float) -> str:
    """Return a time as text: seconds with one significant digit, minutes or hours with two."""
    if seconds < LONG:
        return f"{_rounded(seconds, 1)} s"
    return f"{_rounded(seconds / 60)} min" if seconds < 3600 else f"{_rounded(seconds / 3600)} h"


def _rounded(number: float, digits: int = 2) -> str:
    """Return a number as text without an exponent, rounded to this number of significant digits."""
    return f"{float(f'{number:.{digits}g}'):.15g}"


def is_long(scenes: Sequence[Scene], rendering: Rendering) -> bool:
    """Whether these pictures take more than a minute, if none is in the cache."""
    return cpu_seconds(scenes, rendering) / cores() > LONG
