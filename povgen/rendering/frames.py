"""From scenes to frames: each is rendered once, in a work folder of its own, and then kept in the cache."""

import functools
import inspect
import json
import re
import struct
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from hashlib import sha256
from io import BytesIO
from itertools import islice
from pathlib import Path

import numpy as np

from povgen.errors import InputError, PovrayError, TransientError
from povgen.optics import prism, trace
from povgen.rendering import cache, povray
from povgen.rendering.parallel import Runner, default_workers, thread_pool
from povgen.scene import limits, prediction
from povgen.scene.models import Scene
from povgen.scene.sdl import template_of, to_pov
from povgen.settings import Rendering

# Frames under way for each worker: one is rendered while the next waits.
AHEAD = 2


def _made(scene: Scene, rendering: Rendering, source: str, runner: Runner) -> Path | bytes:
    """Where the cache keeps the frame, which is rendered unless it is there; or its PNG file, if it cannot be kept.

    Raises PovrayError, which names the scene's parameters.
    """
    frame = kept_at(source, rendering)
    if _found(frame, rendering):
        return frame
    png, kept = _rendered(scene, rendering, source, runner)
    return frame if kept else png


def kept_at(source: str, rendering: Rendering) -> Path:
    """Where the cache keeps the frame of a scene's text."""
    return cache.place("\0".join([povray.version(), *povray.command("povray", rendering), source]), ".png")


def _found(frame: Path, rendering: Rendering) -> bytes | None:
    """The PNG file that the cache keeps there, if it is whole."""
    width, height = rendering.size
    png = cache.find(frame, most=2**20 + 6 * width * height)  # twice its colours
    return png if png and whole(png, rendering.size) else None


def _rendered(scene: Scene, rendering: Rendering, source: str, runner: Runner) -> tuple[bytes, bool]:
    """The scene's PNG file, rendered now, and whether the cache keeps it."""
    with cache.work() as folder:
        try:
            picture = runner.run(source, rendering, folder)
            png = picture.read_bytes()  # once it is in the cache another povgen may remove it
            if not whole(png, rendering.size):
                raise TransientError("POV-Ray's picture is not whole (is the disk full?)")
            return png, cache.keep(picture, kept_at(source, rendering))
        except PovrayError as error:
            values = ", ".join(f"{key} = {value}" for key, value in scene.model_dump(exclude_none=True).items())
            origin = f"from {template_of(source, error.line)}, " if error.line else ""
            raise type(error)(f"{error}\n  {origin}in the frame with {values}") from None


def whole(png: bytes, size: tuple[int, int]) -> bool:
    """Whether this is a PNG file of 8-bit RGB and this size, and whole: each of its chunks carries a checksum."""
    from PIL import Image

    # first, for the size may be such that nobody could read it
    if not png.startswith(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + struct.pack(">IIBB", *size, 8, 2)):
        return False
    try:
        with Image.open(BytesIO(png), formats=["PNG"]) as image:
            image.verify()
        return True
    except (OSError, SyntaxError, ValueError):  # what Pillow raises
        return False


def known(scene: Scene, keep: bool = False) -> None:
    """Take the scene's survey (`prediction`) from the cache, for rays are slow to trace; or make it and keep it."""
    if not scene.sheets_depth:
        return
    rays = prediction.surveyed(scene)
    place = cache.place(f"{_tracing()}\0{rays}", ".json")
    data = cache.find(place, most=300)
    with suppress(ValueError, TypeError, KeyError):  # what is damaged, or not there
        survey = prediction.Survey(**json.loads(data or b"")["survey"])
        if data == _text(survey):
            prediction.surveys[rays] = survey
            return
    survey = prediction.survey(scene)
    if keep:
        with suppress(OSError), cache.work() as folder:
            part = folder / "survey"
            part.write_bytes(_text(survey))
            cache.keep(part, place)


def _text(survey: prediction.Survey) -> bytes:
    """A survey as it is kept, with a checksum."""
    values = survey._asdict()
    return json.dumps({"survey": values, "sha256": sha256(repr(values).encode()).hexdigest()}).encode()


@functools.cache
def _tracing() -> str:
    """What makes surveys, by its text: what another made is another's."""
    texts = [inspect.getsource(module) for module in (limits, prediction, prism, trace)]
    return sha256("\0".join(texts).encode()).hexdigest()


def render_all(
    scenes: Sequence[Scene],
    rendering: Rendering,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    runner: Runner | None = None,
) -> Generator[bytes, None, None]:
    """Yield the PNG file of each scene's frame, in the scenes' order. Call `done` after each.

    `workers` frames are rendered at once. `runner` renders them: POV-Ray on this machine unless another is given. It
    is stopped at the end.

    If POV-Ray is killed or hangs, the other frames are rendered all the same; then TransientError names the frames
    that failed. Any other error ends the rendering at once. Finished frames stay in the cache, which is trimmed to its
    limit at the end.
    """
    cache.check()
    most = cache.limit()
    runner = runner or povray.Runner()
    workers = workers or default_workers()
    failures = []
    try:
        with thread_pool(runner, workers) as pool:
            finished = _finished(scenes, rendering, runner, pool, AHEAD * workers)
            for number, (scene, (source, frame)) in enumerate(zip(scenes, finished, strict=True)):
                try:
                    png = frame.result()
                    if isinstance(png, Path):  # another povgen may just have removed it
                        png = _found(png, rendering) or _rendered(scene, rendering, source, runner)[0]
                except TransientError as fault:
                    failures.append(f"frame {number}: {fault}")
                else:
                    done()
                    if not failures:
                        yield png
        if failures:
            others = f"{len(failures)} of {len(scenes)} frames failed; the others are kept\n"
            raise TransientError((others if len(scenes) > 1 else "") + "\n".join(failures))
    finally:
        cache.trim(most)


def _finished(
    scenes: Sequence[Scene], rendering: Rendering, runner: Runner, pool: ThreadPoolExecutor, at_once: int
) -> Iterator[tuple[str, Future[Path | bytes]]]:
    """Yield each scene's text and its frame, in the scenes' order, as soon as that frame is finished.

    So many frames are in the pool at once, finished ones that wait for an earlier one not counted.
    """
    todo = iter(scenes)
    frames: deque[tuple[str, Future[Path | bytes]]] = deque()
    running: set[Future[Path | bytes]] = set()
    for _ in scenes:
        while True:
            running = {frame for frame in running if not frame.done()}
            # texts are made in this thread: they need ray traces in Python, which a signal can interrupt only here
            for scene in islice(todo, at_once - len(running)):
                known(scene, keep=True)
                source = to_pov(scene)
                frames.append((source, pool.submit(_made, scene, rendering, source, runner)))
                running.add(frames[-1][1])
            if frames[0][1].done():
                break
            wait(running, return_when=FIRST_COMPLETED)
        yield frames.popleft()


def shard(scenes: list[Scene], part: str) -> list[Scene]:
    """Every n-th of a movie's scenes, from the i-th on; the part is "i/n". Raises InputError."""
    found = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", part)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise InputError(f"shard = {part!r}: allowed: i/n, whole numbers, i from 1 to n")
    return scenes[int(found[1]) - 1 :: int(found[2])]


def read(frame: Path | bytes) -> np.ndarray:
    """The picture in a PNG file, or in its bytes: (height, width, 3) bytes of red, green and blue, read-only."""
    from PIL import Image

    with Image.open(BytesIO(frame) if isinstance(frame, bytes) else frame, formats=["PNG"]) as image:
        return np.asarray(image)[..., :3]  # a copy would take as long as a third of the decoding
