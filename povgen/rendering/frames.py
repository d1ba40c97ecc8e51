"""From scenes to frames: each frame is rendered once and then kept in the cache."""

import re
import struct
import zlib
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from io import BytesIO
from itertools import chain, islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL.PngImagePlugin import PngImageFile

from povgen.errors import InputError, PovrayError, TransientError, shown
from povgen.files import unless_removed
from povgen.record import PNG, png_parts
from povgen.rendering import cache, gl_runner, gl_scene, light, povray, surveys
from povgen.rendering.parallel import Runner, cores, default_workers, thread_pool
from povgen.rendering.views import views
from povgen.rendering.volumes import volumes
from povgen.scene.scenes import Scene, pieces
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering

AHEAD = 2  # frames in the pool for each worker: one is rendered while the next waits
BLOCK = 1 << 24  # bytes of a picture that are unpacked at once
SHOWN_FAILURES = 3  # the greatest number of failed frames that a message describes


def _cached_or_rendered(scene: Scene, rendering: Rendering, source: str, runner: Runner) -> Path | bytes:
    """Return the frame's path in the cache, or the bytes of its file if the cache cannot store the frame.

    Raises PovrayError, whose message states the scene's parameters.
    """
    path = cache.frame_path(source, rendering)
    png = _read(path, rendering)
    if png and is_whole(png, rendering.size, rendering.is_light):
        return path
    png, stored = _rendered(scene, rendering, source, runner)
    return path if stored else png


def _read(path: Path, rendering: Rendering) -> bytes | None:
    """Return the file at a path in the cache, or None if it is missing or larger than a frame can be."""
    width, height = rendering.size
    # the greatest size of a frame: 1 MiB, and for each pixel 6 bytes (its colour has 3), or 13 for linear light
    return cache.read(path, most=2**20 + (13 if rendering.is_light else 6) * width * height)


def _rendered(scene: Scene, rendering: Rendering, source: str, runner: Runner) -> tuple[bytes, bool]:
    """Render the scene and store the frame's file. Return the file's bytes, and whether the cache contains it now.

    If the cache is removed meanwhile, the scene is rendered again.
    """

    def render() -> tuple[bytes, bool]:
        with cache.work_folder() as folder:
            picture = runner.run(source, rendering, folder)
            png = picture.read_bytes()  # read now: once the file is in the cache, another process can remove it
            if not is_whole(png, rendering.size, rendering.is_light):
                raise TransientError("the picture is not whole (is the disk full?)")
            return png, cache.store(picture, cache.frame_path(source, rendering))

    with named(scene, source):
        return unless_removed(render)


@contextmanager
def named(scene: Scene, source: str) -> Iterator[None]:
    """Add to the message of a PovrayError where the fault is, and the scene's parameters. `source` is its text."""
    try:
        yield
    except PovrayError as error:
        given = scene.model_dump(exclude_unset=True).items()
        values = ", ".join(f"{key} = {shown(value)}" for key, value in given) or "the default values"
        message, origin = povray.message_and_origin(error, source, pieces(scene).values())
        origin = f"{origin}, in" if origin else "in"
        raise type(error)(f"{message}\n  {origin} the frame with {values}") from None


def is_whole(png: bytes, size: tuple[int, int], is_light: bool = False) -> bool:
    """Return whether this is a complete PNG file of 8-bit RGB and this size, whose pixels can be decoded.

    If `is_light`, return whether it is a complete frame of linear light (`light.unpacked`) of this size.
    """
    if is_light:
        try:
            return light.unpacked(png, size).size > 0
        except ValueError:
            return False
    width, height = size
    row = 1 + 3 * width  # bytes: the number of a filter, and three for each pixel
    try:
        parts = list(png_parts(png))
        packed = b"".join(data for name, data in parts if name == b"IDAT")
        count, highest_filter = _unpacked(packed, row, height * row)
    except (struct.error, ValueError, zlib.error):
        return False
    header = b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    framed = png.startswith(PNG) and (parts[0], parts[-1]) == (header, (b"IEND", b""))
    return framed and count == height * row and highest_filter <= 4


def _unpacked(packed: bytes, row: int, most: int) -> tuple[int, int]:
    """Return the number of unpacked bytes, and the greatest filter number of a row.

    A row has `row` bytes. The first one is the number of the row's filter, by PNG's definition.
    A damaged file may unpack to more than memory holds. So it is unpacked in blocks, and unpacking ends soon after
    `most` bytes.
    """
    unpacker, count, highest = zlib.decompressobj(), 0, 0
    while count <= most and (block := unpacker.decompress(packed, BLOCK)):
        highest = max(highest, *block[-count % row :: row], 0)
        count += len(block)
        packed = unpacker.unconsumed_tail
    return count, highest


def render_all(
    scenes: Sequence[Scene],
    rendering: Rendering,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    runner: Runner | None = None,
    part: Callable[[float], None] | None = None,
) -> Generator[list[bytes], None, None]:
    """Yield a list of frames for each scene: one, or several for stereo or a transparent background.

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
    most = cache.max_bytes()
    rendering = rendering.suited(any(scene.has_prisms for scene in scenes))
    failures = []
    shown = [views(scene, rendering) for scene in scenes]
    every = list(chain(*shown))
    to_text, runner, workers = renderer_of(every, rendering, runner, workers, part)
    try:
        with thread_pool(runner, workers) as pool:
            surveys.make(every)
            finished = _finished(every, rendering, runner, pool, AHEAD * workers, to_text)
            for group in shown:
                pngs, faults = [], []
                for scene, (source, frame) in zip(group, finished, strict=False):
                    try:
                        png = frame.result()
                        if isinstance(png, Path):  # another process may just have removed the file
                            png = _read(png, rendering) or _rendered(scene, rendering, source, runner)[0]
                        pngs.append(png)
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
        return gl_scene.to_text(scene, shapes, surveys.found(scene, store=True), clipped=not rendering.is_light)

    return to_text, runner, workers


def _to_pov(scene: Scene) -> str:
    return to_pov(scene, found=surveys.found(scene, store=True))


def _finished(
    scenes: Sequence[Scene],
    rendering: Rendering,
    runner: Runner,
    pool: ThreadPoolExecutor,
    at_once: int,
    to_text: Callable[[Scene], str] = _to_pov,
) -> Iterator[tuple[str, Future[Path | bytes]]]:
    """Yield each scene's text and its frame, in the scenes' order, as soon as that frame is finished.

    At most `at_once` frames wait or run in the pool. Finished frames that wait for an earlier frame do not count.
    """
    todo = iter(scenes)
    frames: deque[tuple[str, Future[Path | bytes]]] = deque()
    running: set[Future[Path | bytes]] = set()
    for _ in scenes:
        while True:
            running = {frame for frame in running if not frame.done()}
            # to_text runs in this thread: it traces rays in Python, and Ctrl-C interrupts only this thread
            for scene in islice(todo, at_once - len(running)):
                source = to_text(scene)
                frames.append((source, pool.submit(_cached_or_rendered, scene, rendering, source, runner)))
                running.add(frames[-1][1])
            if frames[0][1].done():
                break
            wait(running, return_when=FIRST_COMPLETED)
        yield frames.popleft()


def missing(scenes: Sequence[Scene], rendering: Rendering) -> int:
    """Return how many frames of the scenes are not in the cache. A scene can have several frames."""
    rendering = rendering.suited(any(scene.has_prisms for scene in scenes))
    every = list(chain(*(views(scene, rendering) for scene in scenes)))
    to_text, *_ = renderer_of(every, rendering, None, 1)
    return sum(not cache.frame_path(to_text(scene), rendering).is_file() for scene in every)


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
