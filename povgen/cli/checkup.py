"""What `povgen check` tests: whether each part that povgen needs is there and works."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from povgen import remedies
from povgen.errors import InputError, PovrayError, message_of
from povgen.files import temporary_folder
from povgen.rendering import cache, gl_runner, povray, sandbox
from povgen.scene.presets import Chess
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering
from povgen.video import encode

TINY = Rendering(size=(64, 48), antialias=None)
FILES, ROOM = 16, 2**16  # the number of files that `_room` writes, and the bytes in each


class Part(NamedTuple):
    """What povgen needs: a test of it, the remedy if it fails, and the parts without which it cannot be tested.

    An optional part may be missing.
    """

    name: str
    test: Callable[[], str]
    remedy: str
    needs: tuple[str, ...] = ()
    optional: bool = False


def faults(report: Callable[[str], object]) -> Iterator[str]:
    """Test each part, report the result as a line of text, and yield the names of the parts that fail.

    A part is not tested if a part that it needs has failed, because the reason would be the same.
    """
    failed: list[str] = []
    for part in PARTS:
        if missing := [name for name in part.needs if name in failed]:
            report(f"-      {part.name}: not tested, because it needs: {', '.join(missing)}")
            failed.append(part.name)
            continue
        try:
            report(f"ok     {part.name}: {part.test()}")
        except InputError as error:  # it says what is allowed
            if part.optional:
                report(f"-      {part.name}: {error}")
                continue
            report(f"FAULT  {part.name}: {error}")
        except (PovrayError, OSError, RuntimeError) as error:
            report(f"FAULT  {part.name}: {message_of(error)}\n       remedy: {part.remedy}")
        else:
            continue
        failed.append(part.name)
        yield part.name


def _room(parent: Path | None = None) -> str:
    """Make more and larger files in a folder than the small frame and movie need. Return the folder."""
    with temporary_folder(parent) as folder:
        for number in range(FILES):
            (folder / f"room{number}").write_bytes(bytes(ROOM))
        return str(folder.parent)


def _sandbox() -> str:
    """Return which sandbox POV-Ray runs in. A kernel without Landlock is no fault, but the user should know."""
    version = sandbox.version()
    return f"Landlock {version}" if version else "none: this system has no Landlock; render only scenes that you trust"


def _limits() -> str:
    """Return which limits POV-Ray runs under. It is no fault if one is missing, but the user should know."""
    if not povray.util_linux():
        missing = "setpriv and prlimit (util-linux) are missing: memory and the size of files are not limited"
        return f"time; {missing}, and if povgen is killed, POV-Ray runs on"
    return "time, memory and size of files; POV-Ray ends when povgen ends"


def _frame() -> str:
    with temporary_folder() as folder:
        povray.run(to_pov(Chess(sheet="detailed")), TINY, folder)
    return "a chess piece seen through two sheets of 100 prisms, 64x48 pixels"


def _encode() -> str:
    import imageio_ffmpeg

    with temporary_folder() as folder:
        encode.encode([np.zeros((48, 64, 3), np.uint8)] * 3, folder / "movie.mp4", 10)
    return f"ffmpeg {imageio_ffmpeg.get_ffmpeg_version()}, {imageio_ffmpeg.get_ffmpeg_exe()}"


PARTS = (
    Part("POV-Ray", lambda: povray.version(), f"install it: {remedies.system('povray')}"),
    Part("temporary files", _room, "make room in this folder, or name another in TMPDIR"),
    Part(
        "cache",
        lambda: _room(cache.made()),
        "make room in this folder and let povgen write there, or name another in POVGEN_CACHE",
    ),
    Part("sandbox", _sandbox, "report it as an issue of povgen"),
    Part("limits", _limits, "install util-linux, or a shell"),
    Part(
        "frame",
        _frame,
        "read POV-Ray's message; remove POV-Ray and install it again",
        ("POV-Ray", "temporary files", "sandbox", "limits"),
    ),
    Part(
        "renderer gl",  # POV-Ray does not need it
        lambda: gl_runner.device(),
        f"reinstall it: {remedies.pip()} install --force-reinstall moderngl; update the graphics driver",
        optional=True,
    ),
    Part("encoder", _encode, f"unset IMAGEIO_FFMPEG_EXE, or install ffmpeg: {encode.REMEDY}", ("temporary files",)),
)
