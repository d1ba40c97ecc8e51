"""From scenes to frames: each is rendered once, in a work folder of its own, and then kept in the cache."""

import os
import re
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np

from povgen import cache, povray
from povgen.errors import ChanceError, InputError, PovrayError, validated
from povgen.rendering import Rendering
from povgen.scenes import Scene
from povgen.source import to_pov

# A POV-Ray process sleeps about 0.65 s whatever its frame costs: so many of them keep a core busy.
WORKERS_PER_CORE = 8

Run = Callable[[str, Rendering, Path], Path]  # as povray.run


def default_workers() -> int:
    """How many POV-Ray processes run at once."""
    return WORKERS_PER_CORE * len(os.sched_getaffinity(0))


def render_png(scene: Scene, rendering: Rendering | None = None, run: Run | None = None) -> Path:
    """The scene's frame, a PNG in the cache, rendered (by `run`, or povray.run) unless it is there already.

    Raises PovrayError, which names the scene's parameters.
    """
    rendering = rendering or validated(Rendering, {})
    source = to_pov(scene)
    frame = cache.place("\0".join([povray.version(), *povray.command("povray", rendering), source]))
    if not cache.find(frame):
        with cache.work() as folder:
            try:
                rendered = (run or povray.run)(source, rendering, folder)
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
    run: Run | None = None,
    stop: Callable[[], None] = povray.stop,
) -> Generator[Path, None, None]:
    """The frames of many scenes in their order, rendered `workers` at a time; calls `done` as each is handed out.

    `run` renders in place of povray.run, and `stop` ends, at once, all that it began.

    Where POV-Ray is killed or hangs, the other frames go on; then PovrayError names those that failed. Any other fault
    ends it at once. The frames that are finished stay in the cache, which at the end is trimmed to its limit.
    """
    most = cache.limit()
    pool = ThreadPoolExecutor(workers or default_workers())
    failures = []
    try:
        for number, frame in enumerate([pool.submit(render_png, scene, rendering, run) for scene in scenes]):
            try:
                path = frame.result()
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
        stop()
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
