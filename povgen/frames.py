"""From scenes to frames: each is rendered once, in a work folder of its own, and then kept in the cache."""

import os
import re
from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing
from itertools import islice
from pathlib import Path
from typing import Protocol

import numpy as np

from povgen import cache, povray
from povgen.errors import ChanceError, InputError, PovrayError, validated
from povgen.rendering import Rendering
from povgen.scenes import Scene
from povgen.source import to_pov

# A POV-Ray process sleeps about 0.65 s whatever its frame costs: so many of them keep a core busy.
WORKERS_PER_CORE = 8
# Frames under way for each worker: one is rendered while the next waits.
AHEAD = 2


class Runner(Protocol):
    """What renders scenes' texts for one render, as povray.Runner, here or elsewhere."""

    def run(self, source: str, rendering: Rendering, folder: Path) -> Path:
        """The picture, made in a work folder of its own. Raises PovrayError."""

    def stop(self) -> None:
        """End at once all that it runs, and run nothing more."""


def default_workers() -> int:
    """How many POV-Ray processes run at once."""
    return WORKERS_PER_CORE * len(os.sched_getaffinity(0))


def render_png(scene: Scene, rendering: Rendering | None = None) -> Path:
    """The scene's frame, a PNG in the cache, rendered unless it is there already.

    Raises PovrayError, which names the scene's parameters.
    """
    return _frame(scene, rendering or validated(Rendering, {}), to_pov(scene), povray.run)


def _frame(scene: Scene, rendering: Rendering, source: str, run: Callable[[str, Rendering, Path], Path]) -> Path:
    frame = cache.place("\0".join([povray.version(), *povray.command("povray", rendering), source]))
    if not cache.find(frame):
        with cache.work() as folder:
            try:
                rendered = run(source, rendering, folder)
                if not cache.whole(rendered):
                    raise ChanceError("POV-Ray's picture is not whole (is the disk full?)")
                cache.keep(rendered, frame)
            except PovrayError as error:
                values = ", ".join(f"{key} = {value}" for key, value in scene.model_dump(exclude_none=True).items())
                raise type(error)(f"{error}\n  in the frame with {values}") from None
    return frame


def render_all(
    scenes: Sequence[Scene],
    rendering: Rendering,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    runner: Runner | None = None,
) -> Generator[Path, None, None]:
    """The frames of many scenes in their order, rendered `workers` at a time; calls `done` as each is handed out.

    `runner` renders, in place of POV-Rays here; it is stopped at the end.

    Where POV-Ray is killed or hangs, the other frames go on; then PovrayError names those that failed. Any other fault
    ends it at once. The frames that are finished stay in the cache, which at the end is trimmed to its limit.
    """
    most = cache.limit()
    runner = runner or povray.Runner()
    workers = workers or default_workers()
    pool = ThreadPoolExecutor(workers)
    todo, failures = iter(scenes), []
    frames: deque[Future[Path]] = deque()
    running: set[Future[Path]] = set()
    try:
        for number in range(len(scenes)):
            while True:
                running = {frame for frame in running if not frame.done()}
                # texts are made in this thread: rays are traced for them in Python, which a signal interrupts only here
                for scene in islice(todo, AHEAD * workers - len(running)):
                    frames.append(pool.submit(_frame, scene, rendering, to_pov(scene), runner.run))
                    running.add(frames[-1])
                if frames[0].done():
                    break
                wait(running, return_when=FIRST_COMPLETED)
            try:
                path = frames.popleft().result()
            except ChanceError as fault:
                failures.append(f"frame {number}: {fault}")
            else:
                done()
                if not failures:
                    yield path
        if failures:
            others = f"{len(failures)} of {len(scenes)} frames failed; the others are kept\n"
            raise ChanceError((others if len(scenes) > 1 else "") + "\n".join(failures))
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        runner.stop()
        pool.shutdown()
        cache.trim(most)


def shard(scenes: list[Scene], part: str) -> list[Scene]:
    """Every n-th of a movie's scenes, from the i-th on; the part is "i/n". Raises InputError."""
    found = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", part)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise InputError(f"shard = {part!r}: allowed: i/n, whole numbers, i from 1 to n")
    return scenes[int(found[1]) - 1 :: int(found[2])]


def render(scene: Scene, **options) -> np.ndarray:
    """The scene's picture, (height, width, 3) bytes of red, green and blue.

    Options: those of `Rendering`.
    """
    rendering = validated(Rendering, options)
    return picture(render_png(scene, rendering), scene, rendering)


def png(scene: Scene, rendering: Rendering) -> bytes:
    """The scene's picture as a PNG file's bytes."""
    with closing(render_all([scene], rendering)) as frames:
        frame = next(frames)
    if not rendering.annotated:
        return frame.read_bytes()
    from povgen import encode

    return encode.png(picture(frame, scene, rendering))


def picture(frame: Path, scene: Scene, rendering: Rendering) -> np.ndarray:
    """The scene's frame as an array, with the caption and overlay that the rendering asks for."""
    try:
        plain = read(frame)
    except FileNotFoundError:  # another povgen has cleared the cache
        plain = read(render_png(scene, rendering))
    if not rendering.annotated:
        return plain
    from povgen.annotate import annotated

    return annotated(plain, scene, rendering)


def read(frame: Path) -> np.ndarray:
    """A frame's picture, (height, width, 3) bytes of red, green and blue."""
    import imageio.v3 as iio

    return iio.imread(frame)[..., :3]
