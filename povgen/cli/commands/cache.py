"""povgen cache."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.errors import InputError


def command(
    what: Annotated[str, typer.Argument(metavar="info|clear", help="tell of the frames that are kept, or remove them")],
) -> None:
    """The frames that are kept, up to POVGEN_CACHE_SIZE GiB (2) in POVGEN_CACHE: the least recently used go first.

    And what povgens that were killed left, in that folder and among temporary files.
    """
    from povgen.rendering import cache

    if what not in ("info", "clear"):
        raise InputError(f"{what!r}: allowed: info or clear")
    cache.check()
    if what == "clear":
        print(f"removed {_kinds(cache.trim(-1))} from {cache.folder()}")
        if swept := cache.remove_leftovers():
            print(f"removed {swept} folders that killed povgens left")
    else:
        files = cache.by_last_use()
        size = sum(size for _, size, _ in files) / 2**30
        kinds = _kinds([path for _, _, path in files])
        print(f"{kinds}, {size:.3f} of {cache.max_bytes() / 2**30:g} GiB, in {cache.folder()}")
        if left := cache.leftover_sizes():
            print(f"{len(left)} folders that killed povgens left, {sum(left) / 2**30:.3f} GiB")


def _kinds(files: list[Path]) -> str:
    frames = sum(path.suffix == ".png" for path in files)
    return f"{frames} frames and {len(files) - frames} ray traces"
