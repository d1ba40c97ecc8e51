"""The frames that are kept: each a PNG file under the name of what it was rendered from."""

import errno
import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager
from hashlib import sha256
from pathlib import Path

import platformdirs

from povgen.errors import InputError
from povgen.output import work_folder

DEFAULT_SIZE = 2.0  # GiB


def folder() -> Path:
    """Where frames are kept: the folder POVGEN_CACHE or else the user's cache folder."""
    kept = Path(os.environ.get("POVGEN_CACHE") or platformdirs.user_cache_path("povgen"))
    if not kept.is_absolute() and "POVGEN_CACHE" not in os.environ:  # a user without a home
        kept = Path(tempfile.gettempdir(), f"povgen-{os.getuid()}")
    try:
        return kept.absolute()
    except FileNotFoundError:
        reason = "the current folder has been removed; allowed: a path from / on"
        raise InputError(f"POVGEN_CACHE = {str(kept)!r}: {reason}") from None


def limit() -> float:
    """How many bytes the frames may take: POVGEN_CACHE_SIZE, in GiB. Raises InputError where that is no number."""
    text = os.environ.get("POVGEN_CACHE_SIZE") or str(DEFAULT_SIZE)
    try:
        size = float(text)
    except ValueError:
        size = -1
    if not 0 <= size < 1e9:
        raise InputError(f"POVGEN_CACHE_SIZE = {text!r}: allowed: GiB, from 0 to below 1e9")
    return size * 2**30


def place(key: str) -> Path:
    """The file of the frame that was rendered from what the key tells."""
    name = sha256(key.encode()).hexdigest()
    return folder() / name[:2] / f"{name}.png"


def find(frame: Path) -> bool:
    """Whether the frame is there and whole; what is damaged is removed. Marks it as used now."""
    try:
        if whole(frame):
            os.utime(frame, ns=(time.time_ns(), frame.stat().st_mtime_ns))
            return True
        frame.unlink()
    except FileNotFoundError:
        pass
    return False


def keep(rendered: Path, frame: Path) -> None:
    """Give a picture its place in the cache, whole or not at all."""
    frame.parent.mkdir(exist_ok=True)
    os.replace(rendered, frame)


def work() -> AbstractContextManager[Path]:
    """A folder to render in, on the cache's file system. Raises OSError where it cannot be."""
    kept = folder()
    try:
        kept.mkdir(parents=True, exist_ok=True)
        if not os.access(kept, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    except OSError as error:
        hint = f"{error.strerror} (the folder for frames; POVGEN_CACHE names another)"
        raise OSError(error.errno, hint, str(kept)) from None
    return work_folder(kept)


def whole(png: Path) -> bool:
    """Whether a file is a PNG from beginning to end: each of its chunks carries a checksum."""
    from PIL import Image

    try:
        with Image.open(png, formats=["PNG"]) as image:
            image.verify()
        return True
    except FileNotFoundError:
        raise
    except (OSError, SyntaxError, ValueError):  # what Pillow raises
        return False


def frames() -> list[tuple[float, int, Path]]:
    """Each frame's time of last use, size in bytes, and path; the least recently used first."""
    return sorted(_frames())


def _frames() -> Iterator[tuple[float, int, Path]]:
    for path in folder().glob("??/*.png"):
        try:
            status = path.stat()
        except FileNotFoundError:  # another povgen has just removed it
            continue
        yield status.st_atime, status.st_size, path


def trim(most: float) -> int:
    """Remove the least recently used frames until the others take no more than `most` bytes; returns how many."""
    kept = frames()
    total, removed = sum(size for _, size, _ in kept), 0
    for _, size, path in kept:
        if total <= most:
            break
        path.unlink(missing_ok=True)
        total -= size
        removed += 1
    return removed
