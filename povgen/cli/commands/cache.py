"""The command povgen cache."""

from errno import EACCES
from pathlib import Path

import click

from povgen.cli.field_options import Command
from povgen.errors import InputError, one_line
from povgen.progress import counted, tell
from povgen.rendering import cache


@click.command("cache", cls=Command)
@click.argument("what", metavar="info|clear", help="print what the cache holds, or empty it")
def command(what: str) -> None:
    """Print what the cache holds, or empty it.

    The cache keeps frames, ray traces and the shapes of your own pieces for later runs. POVGEN_CACHE names its folder.
    It holds up to POVGEN_CACHE_SIZE GiB (default 2). If it is full, the least recently used files are removed.
    """
    if what not in ("info", "clear"):
        raise InputError(f"{what!r}: allowed: info or clear")
    cache.check()
    if what == "clear":
        found, removed = [path for _, _, path in cache.by_last_use()], cache.trim(-1)
        tell(f"removed {_counts(removed)} from {one_line(str(cache.folder()))}")
        # a movie that is being made can have written a removed file again
        if kept := sum(path.exists() for path in {*found} - {*removed}):
            raise PermissionError(EACCES, f"files that could not be removed: {kept}", str(cache.folder()))
    else:
        files = cache.by_last_use()
        size = sum(size for _, size, _ in files) / 2**30
        counts = _counts([path for _, _, path in files])
        tell(f"{counts}, {size:.3f} of {cache.max_bytes() / 2**30:g} GiB, in {one_line(str(cache.folder()))}")


def _counts(files: list[Path]) -> str:
    frames = sum(path.suffix in (".png", ".light") for path in files)
    return f"{counted(frames, 'frame')}, {len(files) - frames} ray traces and pieces"
