"""From scenes to frames: each frame is rendered once and then kept in the cache."""

import re
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from io import BytesIO
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL.PngImagePlugin import PngImageFile

from povgen import stopping
from povgen.errors import InputError, PovrayError, TransientError, shown
from povgen.files import temporary_folder
from povgen.rendering import cache, gl_runner, gl_scene, light, povray, survey_cache
from povgen.rendering.parallel import Runner, cores, default_workers, thread_pool
from povgen.rendering.views import frames_of
from povgen.rendering.volumes import volumes
from povgen.scene.presets import pieces
from povgen.scene.scene import Scene
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering

AHEAD = 4  # frames in the pool for each worker: one is rendered, and others wait, or are there before an earlier one
SHOWN_FAILURES = 3  # the greatest number of failed frames that a message describes


def _cached_or_rendered(scene: Scene, rendering: Rendering, source: str, runner: Runner) -> bytes:
    """Return the bytes of the frame's file. Raises PovrayError, whose message states the scene's parameters."""
    rendering = rendering.through(scene.pupil, scene.polarised)
    path = cache.frame_path(source, rendering)
    if frame := cache.read(path):
        return frame
    cache.made()  # raises an error before anything is rendered
    with named(scene, source), temporary_folder() as folder:
        frame = runner.run(source, rendering, folder).read_bytes()
        if not is_whole(frame, rendering.size, rendering.is_light):
            raise TransientError("the picture is not whole (is the disk full?)")
    cache.store(frame, path)
    return frame


@contextmanager
def named(scene: Scene, source: str) -> Iterator[None]:
    """Add to the message of a PovrayError where the fault is, and the scene's parameters. `source` is its text."""
    try:
        yield
    except PovrayError as error:
        given = scene.model_dump(exclude_unset=True).items()
        values = ", ".join(f"{key} = {shown(value)}" for key, value in given) or "the default values"
        raise povray.placed(error, source, pieces(scene).values(), f"the frame with {values}") from None


def is_whole(frame: bytes, size: tuple[int, int], is_light: bool = False) -> bool:
    """Return whether this is a frame of this size that can be decoded: a PNG file, or linear light if `is_light`."""
    try:
        picture = light.unpacked(frame, size) if is_light else read_png(frame)
    except (OSError, SyntaxError, ValueError):  # what Pillow raises
        return False
    return picture.shape == (size[1], size[0], 3)


def render_all(
    scenes: Sequence[Scene],
    rendering: Rendering,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    runner: Runner | None = None,
    part: Callable[[float], None] | None = None,
) -> Generator[list[bytes], None, None]:
    """Yield a list of frames for each scene, those of `frames_of`.

    The lists are in the order of the scenes. A frame is the bytes of a PNG file, or, if `rendering.is_light`, the bytes
    that `light.unpacked` takes.

    `done` is called after each scene that has not failed. `workers` frames are rendered at once by `runner`. The
    default runner is the renderer on this machine. Only the default runner calls `part`, with the fraction of a frame
    that was rendered since the last call of `part`. The runner is stopped at the end.

    If the renderer is killed or hangs, the other frames are still rendered, but no further list is yielded. Then a
    TransientError is raised. It says how many scenes failed, and why the first SHOWN_FAILURES of them failed. Any other
    error ends the rendering at once. Finished frames stay in the cache. At the end, the cache is trimmed to its limit.
    """
    cache.check()
    most, stopping.keeps_frames = cache.max_bytes(), True
    rendering = rendering.suited(any(scene.has_prisms for scene in scenes))
    failures = []
    shown = [frames_of(scene, rendering) for scene in scenes]
    every = list(chain(*shown))
    to_text, runner, workers = renderer_of(every, rendering, runner, workers, part)
    try:
        with thread_pool(runner, workers) as pool:
            survey_cache.make(every)
            begun = _begun(every, rendering, runner, pool, AHEAD * workers, to_text)
            for group in shown:
                pngs, faults = [], []
                for scene, (source, frame) in zip(group, begun, strict=False):
                    try:
                        frame.result()
                        # from the cache, unless another process has just removed it there
                        pngs.append(_cached_or_rendered(scene, rendering, source, runner))
                    except TransientError as fault:
                        faults.append(str(fault))
                failures += faults[:1]
                if not faults:
                    done()
                    if not failures:
                        yield pngs
        if failures:
            said = f"{len(failures)} of {len(scenes)} frames failed." if len(scenes) > 1 else ""
            if len(failures) < len(scenes):
                said += " The other frames are kept."
            if len(failures) > SHOWN_FAILURES:
                said += f" The first {SHOWN_FAILURES} failures:"
            raise TransientError("\n".join(filter(None, [said, *failures[:SHOWN_FAILURES]])))
    finally:
        cache.trim(most)


def renderer_of(
    scenes: Sequence[Scene],
    rendering: Rendering,
    runner: Runner | None,
    workers: int | None,
    part: Callable[[float], None] | None = None,
) -> tuple[Callable[[Scene], str], Runner, int]:
    """Return a function from a scene to its text, a runner that renders such texts, and how many it renders at once."""
    if rendering.renderer == "povray":
        if runner is None:
            if rendering.is_light:
                light.exr()  # raises an error before anything is rendered
            povray.warn_of(piece for scene in scenes for piece in pieces(scene).values())
        workers = workers or default_workers()
        at_once = max(1, min(workers, len(scenes)))  # a shard can have no scenes
        threads = cores() // max(1, len(scenes))  # the frames share the cores equally
        return _to_pov, runner or povray.Runner(threads, part, at_once), workers

    workers = workers or max(1, min(gl_runner.at_once(), len(scenes)))  # a shard can have no scenes
    runner = runner or gl_runner.Runner(workers, part)
    shown = {name: piece for scene in scenes for name, piece in pieces(scene).items()}
    shapes = volumes(shown, timeout=rendering.timeout)

    def to_text(scene: Scene) -> str:
        return gl_scene.to_text(scene, shapes, survey_cache.found(scene, store=True), clipped=not rendering.is_light)

    return to_text, runner, workers


def drawn_by(renderer: str) -> str:
    """Return the version of POV-Ray, or the device with which the renderer gl draws.

    Raises PovrayError if POV-Ray is missing or too old, and InputError if the renderer gl cannot be used.
    """
    return gl_runner.device() if renderer == "gl" else f"POV-Ray {povray.version()}"


def _to_pov(scene: Scene) -> str:
    return to_pov(scene, found=survey_cache.found(scene, store=True))


def _begun(
    scenes: Sequence[Scene],
    rendering: Rendering,
    runner: Runner,
    pool: ThreadPoolExecutor,
    at_once: int,
    to_text: Callable[[Scene], str],
) -> Iterator[tuple[str, Future[None]]]:
    """Yield each scene's text and a future, which ends when the frame is in the cache. `at_once` frames are ahead."""

    def into_cache(scene: Scene, source: str) -> None:  # the frame does not wait in memory for those before it
        _cached_or_rendered(scene, rendering, source, runner)

    ahead: deque[tuple[str, Future[None]]] = deque()
    for scene in scenes:
        # to_text runs in this thread: it traces rays in Python, and Ctrl-C interrupts only this thread
        source = to_text(scene)
        ahead.append((source, pool.submit(into_cache, scene, source)))
        if len(ahead) == at_once:
            yield ahead.popleft()
    yield from ahead


def missing(scenes: Sequence[Scene], rendering: Rendering) -> int:
    """Return how many frames of the scenes are not in the cache. A scene can have several frames."""
    rendering = rendering.suited(any(scene.has_prisms for scene in scenes))
    every = list(chain(*(frames_of(scene, rendering) for scene in scenes)))
    to_text, *_ = renderer_of(every, rendering, None, 1)
    return sum(
        not cache.frame_path(to_text(scene), rendering.through(scene.pupil, scene.polarised)).is_file()
        for scene in every
    )


def shard(scenes: list[Scene], part: str) -> list[Scene]:
    """Return every n-th of a movie's scenes, from the i-th on, counted from 1. `part` is "i/n". Raises InputError."""
    found = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", part)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise InputError(f"shard = {part!r}: allowed: i/n, whole numbers, i from 1 to n")
    return scenes[int(found[1]) - 1 :: int(found[2])]


def read_png(frame: Path | bytes) -> NDArray[np.uint8]:
    """Read a PNG file or its bytes. Return the picture: (height, width, 3) bytes of red, green and blue, read-only."""
    with PngImageFile(BytesIO(frame) if isinstance(frame, bytes) else frame) as image:
        return np.asarray(image)[..., :3]  # no copy: it would take a third of the time that decoding takes
