"""How long rendering takes, before it begins: small pictures of up to three of the scenes are rendered and timed."""

from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

from povgen.errors import PovrayError
from povgen.files import temporary_folder
from povgen.rendering.frames import named, renderer_of
from povgen.rendering.parallel import Runner, cores, cpu_seconds, thread_pool
from povgen.rendering.views import frames_of
from povgen.scene.scene import Scene
from povgen.settings import PUPIL_RAYS, Rendering

SIZES = (64, 48), (160, 120), (480, 360)  # of the small pictures; the third one if the second costs too little
ENOUGH = 0.05  # CPU seconds that pictures of two sizes have to differ by, for each scene
OUTPUT = 1.5e-7  # CPU seconds for a pixel of a finished picture: decoding, drawing and encoding
POLARISED = 1.6e-5  # CPU seconds for each ray whose Jones matrix is found
WAIT = 0.65  # seconds that POV-Ray sleeps during each frame
LONG = 60.0  # seconds of wall time
# upper bounds of the CPU seconds of a ray, also with partial reflections
DEAREST = {"povray": 1e-4, "gl": 1e-6}


class Cost(NamedTuple):
    """What frames cost on average, CPU seconds."""

    start: float  # of povgen, until it begins the first frame
    text: float  # to trace the rays that find its trace level, and to write its text
    picture: float  # for each picture; of gl for each process that draws
    ray: float  # for each ray


class Estimate(NamedTuple):
    """How long rendering takes, with povgen's start: CPU seconds, and seconds of wall time."""

    cpu: float
    wall: float


def estimate(scenes: Sequence[Scene], rendering: Rendering) -> Estimate:
    """Return about how long these pictures take, if none is in the cache. Equal ones are rendered once.

    Raises what `frames.render_all` raises.
    """
    frames = _frames(scenes, rendering)
    if not frames:  # of a shard
        return Estimate(0.0, 0.0)
    some = [*dict.fromkeys(frames[n] for n in (0, len(frames) // 2, -1))]
    start, text, picture, ray = measured(some, rendering)
    gl, at_once = rendering.renderer == "gl", min(cores(), len(frames))
    single = picture * (at_once if gl else len(frames))  # each on one core
    polarised = POLARISED if any(scene.polarised for scene in frames) else 0
    shared = text + (OUTPUT + polarised) * rendering.size[0] * rendering.size[1]
    shared = shared * len(frames) + ray * rays(frames, rendering)
    return Estimate(start + single + shared, start + single / at_once + shared / cores() + (0.0 if gl else WAIT))


def _frames(scenes: Sequence[Scene], rendering: Rendering) -> list[Scene]:
    """Return the different frames of these pictures."""
    return [*dict.fromkeys(view for scene in dict.fromkeys(scenes) for view in frames_of(scene, rendering))]


def rays(frames: Sequence[Scene], rendering: Rendering) -> float:
    """Return about how many rays these frames have. POV-Ray's antialiasing adds rays where neighbours differ.

    Through prisms nearly all neighbours do. Without prisms those at edges do: their number grows as the width. The
    factors were fitted to docs/chart/frames.csv.
    """
    suited = rendering.suited(any(scene.has_prisms for scene in frames))
    width, height = suited.size
    if any(scene.pupil or scene.polarised for scene in frames):
        each = PUPIL_RAYS if suited.renderer == "gl" and not any(scene.polarised for scene in frames) else 1
        return width * height * len(frames) * each
    if suited.renderer == "gl":
        more = suited.rays - 1.0
    elif isinstance(suited.antialias, tuple):
        method, threshold, depth = suited.antialias
        more = (1 - threshold / 2) * (0.84 * depth**2 if method == 1 else 0.26 * 4**depth - 1)
    else:
        more = suited.supersampling**2 - 1
    edges = min(1, 120 / width) if isinstance(suited.antialias, tuple) and suited.renderer == "povray" else 1
    return width * height * sum(1 + more * (1 if scene.has_prisms else edges) for scene in frames)


def measured(scenes: Sequence[Scene], rendering: Rendering) -> Cost:
    """Return the mean cost of frames of these scenes, measured on small pictures. Raises as `estimate` does."""
    small = Rendering(renderer=rendering.renderer, bits=rendering.bits, timeout=rendering.timeout, antialias="off")
    to_text, runner, workers = renderer_of(scenes, small, None, None)

    def cpu(size: tuple[int, int]) -> float:
        """Return the mean CPU seconds of the scenes' pictures of this size."""
        before = _cpu(runner)
        asked = small.replace(size=size)
        for done in [pool.submit(_render, *each, runner, asked) for each in zip(scenes, texts, strict=True)]:
            done.result()
        return (_cpu(runner) - before) / len(scenes)

    with thread_pool(runner, workers) as pool:
        start = _cpu(runner)
        # the camera of ideal sheets is divided as finely as the whole picture needs
        fine = "ViewHeight/image_height", f"ViewHeight/{rendering.size[1]}"
        texts = [to_text(scene).replace(*fine) for scene in scenes]
        text = (_cpu(runner) - start) / len(scenes)
        # the first picture of a process of gl includes its start, which has no part in the cost of a ray
        base = 1 if small.renderer == "gl" else 0
        seconds = [cpu(size) for size in SIZES[:2]]
        if base or seconds[1] - seconds[0] < max(ENOUGH, seconds[0] / 4):  # measured times vary
            seconds.append(cpu(SIZES[2]))
    pixels = [width * height for width, height in SIZES]
    ray = max((seconds[-1] - seconds[base]) / (pixels[len(seconds) - 1] - pixels[base]), 0.0)
    return Cost(start, text, max(seconds[0] - ray * pixels[0], 0.0), ray)


def _render(scene: Scene, text: str, runner: Runner, rendering: Rendering) -> None:
    with named(scene, text), temporary_folder() as folder:
        runner.run(text, rendering, folder)


def _cpu(runner: Runner) -> float:
    """Return the CPU seconds of povgen and of the processes that have ended. Those of gl go on, and report theirs."""
    return cpu_seconds() + sum(getattr(runner, "cpu_seconds", ()))


def describe(scenes: Sequence[Scene], rendering: Rendering, found: Estimate) -> str:
    """Return in words what these pictures are, and how long they take if none is in the cache."""
    count = len({*scenes})
    width, height = rendering.size
    what, each = ("a picture", "") if len(scenes) == 1 else (f"{len(scenes)} frames", " each")  # a shard can have none
    differing = f", {count} of them different," if count < len(scenes) else ""
    return (
        f"{what}{differing} of {width}x{height} pixels, about {_rounded(found.cpu / max(count, 1))} CPU seconds{each}: "
        f"about {duration(found.wall)} on {cores()} cores if none is in the cache"
    )


def duration(seconds: float) -> str:
    """Return a time as text: seconds with one significant digit, minutes or hours with two."""
    if seconds < LONG:
        return f"{_rounded(seconds, 1)} s"
    return f"{_rounded(seconds / 60)} min" if seconds < 3600 else f"{_rounded(seconds / 3600)} h"


def _rounded(number: float, digits: int = 2) -> str:
    """Return a number as text without an exponent, rounded to this number of significant digits."""
    return f"{float(f'{number:.{digits}g}'):.15g}"


def if_long(scenes: Sequence[Scene], rendering: Rendering) -> str | None:
    """Return what `describe` says of these pictures if they take more than a minute, otherwise None.

    Small pictures are rendered only if these may take so long. If they fail, the result is None.
    """
    dearest = DEAREST[rendering.renderer] + (POLARISED if any(scene.polarised for scene in scenes) else 0)
    most = rays(_frames(scenes, rendering), rendering) * dearest
    with suppress(PovrayError):  # the pictures themselves say why they fail
        if most / cores() > LONG and (found := estimate(scenes, rendering)).wall > LONG:
            return describe(scenes, rendering, found)
    return None
