"""What `povgen check` tests: whether each part that povgen needs is there and works."""

from collections.abc import Callable, Iterator
from pathlib import Path

from povgen.cli.report import message_of
from povgen.errors import InputError, PovrayError
from povgen.files import temporary_folder
from povgen.rendering import cache, frames, povray, sandbox
from povgen.scene.models import Chess
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering
from povgen.video import encode

TINY = Rendering(size=(64, 48), antialias=None)


def faults(report: Callable[[str], object]) -> Iterator[str]:
    """Test each part, report the result as a line of text, and yield the names of the parts that fail."""
    with temporary_folder() as folder:
        frame = folder / "frame.png"
        for name, test, remedy in (
            ("POV-Ray", povray.version, "install it: apt-get install povray"),
            ("cache", _cache, "make the folder writable, or name another in POVGEN_CACHE"),
            ("sandbox", _sandbox, "report it as an issue of povgen"),
            ("limits", _limits, "install util-linux, or a shell"),
            (
                "frame",
                lambda: _frame(frame),
                "read POV-Ray's message; reinstall it: apt-get install --reinstall povray",
            ),
            ("encoder", lambda: _encode(frame), "reinstall it: pip install --force-reinstall 'imageio[ffmpeg]'"),
        ):
            try:
                report(f"ok     {name}: {test()}")
            except (InputError, PovrayError, OSError, RuntimeError) as error:
                report(f"FAULT  {name}: {message_of(error)}\n       remedy: {remedy}")
                yield name


def _cache() -> str:
    with cache.work_folder():
        return str(cache.folder())


def _sandbox() -> str:
    """Return which sandbox POV-Ray runs in. A kernel without Landlock is no fault, but the user should know."""
    version = sandbox.version()
    return f"Landlock {version}" if version else "none: this system has no Landlock; render only scenes that you trust"


def _limits() -> str:
    """Return which limits POV-Ray runs under. It is no fault if one is missing, but the user should know."""
    if missing := povray.missing_protection():
        return f"set by a shell, because setpriv and prlimit (util-linux) are missing; {'; '.join(missing)}"
    return "time, memory and size of files; POV-Ray ends when povgen ends"


def _frame(frame: Path) -> str:
    with temporary_folder() as folder:
        povray.run(to_pov(Chess(sheet="detailed")), TINY, folder).rename(frame)
    return "a chess piece seen through two sheets of 100 prisms, 64x48 pixels"


def _encode(frame: Path) -> str:
    import imageio_ffmpeg

    encode.encode([frames.read_png(frame)] * 3, frame.with_name("movie.mp4"), 10, {})
    return f"ffmpeg {imageio_ffmpeg.get_ffmpeg_version()}"
