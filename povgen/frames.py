"""From scenes to frames: each is rendered once, in a work folder of its own, and then kept in the cache."""

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256
from pathlib import Path

import numpy as np
import platformdirs

from povgen import povray
from povgen.errors import PovrayError, validated
from povgen.rendering import Rendering
from povgen.scenes import Scene
from povgen.source import to_pov

# A POV-Ray process sleeps about 0.65 s whatever its frame costs: so many of them keep a core busy.
WORKERS_PER_CORE = 8


def cache_folder() -> Path:
    """Where frames are kept: the folder POVGEN_CACHE or else the user's cache folder."""
    return Path(os.environ.get("POVGEN_CACHE") or platformdirs.user_cache_path("povgen"))


def default_workers() -> int:
    """How many POV-Ray processes run at once."""
    return WORKERS_PER_CORE * len(os.sched_getaffinity(0))


def render_png(scene: Scene, rendering: Rendering | None = None) -> Path:
    """The scene's frame, a PNG in the cache, rendered unless it is there already.

    Raises PovrayError, which names the scene's parameters.
    """
    rendering = rendering or Rendering()
    source = to_pov(scene)
    key = "\0".join([povray.version(), *povray.command("povray", rendering), source])
    name = sha256(key.encode()).hexdigest()
    frame = cache_folder() / name[:2] / f"{name}.png"
    if not frame.is_file():
        frame.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="work-", dir=cache_folder()) as folder:
            try:
                os.replace(povray.run(source, rendering, Path(folder)), frame)
            except PovrayError as error:
                values = ", ".join(f"{key} = {value}" for key, value in scene.model_dump(exclude_none=True).items())
                raise PovrayError(f"{error}\n  in the frame with {values}") from None
    return frame


def render_all(
    scenes: Sequence[Scene], rendering: Rendering, workers: int | None = None, done: Callable[[], object] = lambda: None
) -> Iterator[Path]:
    """The frames of many scenes in their order, rendered `workers` at a time; calls `done` as each is handed out.

    Raises PovrayError at the first frame that fails; the frames finished by then stay in the cache.
    """
    workers = workers or default_workers()

    pool = ThreadPoolExecutor(workers)
    try:
        for path in pool.map(lambda scene: render_png(scene, rendering), scenes):
            done()
            yield path
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        povray.stop()
        pool.shutdown()


def render(scene: Scene, **options) -> np.ndarray:
    """The scene's picture, (height, width, 3) bytes of red, green and blue.

    Options: those of `Rendering`.
    """
    rendering = validated(Rendering, options)
    return picture(render_png(scene, rendering), scene, rendering)


def png(scene: Scene, rendering: Rendering) -> bytes:
    """The scene's picture as a PNG file's bytes."""
    frame = render_png(scene, rendering)
    if not rendering.annotated:
        return frame.read_bytes()
    from povgen import encode

    return encode.png(picture(frame, scene, rendering))


def picture(frame: Path, scene: Scene, rendering: Rendering) -> np.ndarray:
    """The scene's frame as an array, with the caption and overlay that the rendering asks for."""
    if not rendering.annotated:
        return read(frame)
    from povgen.annotate import annotated

    return annotated(read(frame), scene, rendering)


def read(frame: Path) -> np.ndarray:
    """A frame's picture, (height, width, 3) bytes of red, green and blue."""
    import imageio.v3 as iio

    return iio.imread(frame)[..., :3]
