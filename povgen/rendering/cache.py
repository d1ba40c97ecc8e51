"""What is kept to be used again: files under the names of what they were made from, in a folder that is marked."""

import errno
import os
import re
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, suppress
from hashlib import sha256
from pathlib import Path

import platformdirs

from povgen import files
from povgen.errors import InputError

DEFAULT_SIZE = 2.0  # GiB
# A cache bears this file, which backup programs know: they leave its folder out. povgen puts it into no folder that
# holds anything else, and uses no folder without it.
TAG = "CACHEDIR.TAG"
MARK = b"""\
Signature: 8a477f597d28d172789f06886806bc55
# This folder is povgen's. It keeps rendered frames here, and removes those that have not been used for longest.
# What such a file is for: https://bford.info/cachedir/
"""
HINT = "the folder for frames; POVGEN_CACHE names another"


def folder() -> Path:
    """Where files are kept: the folder POVGEN_CACHE or else the user's cache folder.

    Raises InputError for a relative path where the current folder has been removed.
    """
    if named := os.environ.get("POVGEN_CACHE"):
        try:
            return Path(named).absolute()
        except FileNotFoundError:
            reason = "the current folder has been removed; allowed: a path from / on"
            raise InputError(f"POVGEN_CACHE = {named!r}: {reason}") from None
    with suppress(RuntimeError):  # of platformdirs, from 4.4 on, for a user without a home
        if (kept := platformdirs.user_cache_path("povgen")).is_absolute():
            return kept
    return _temporary()


def _temporary() -> Path:
    """The folder of a user without a home."""
    return Path(tempfile.gettempdir(), f"povgen-{os.geteuid()}")


def limit() -> float:
    """How many bytes the files may take: POVGEN_CACHE_SIZE, in GiB. Raises InputError where that is no number."""
    text = os.environ.get("POVGEN_CACHE_SIZE") or str(DEFAULT_SIZE)
    try:
        size = float(text)
    except ValueError:
        size = -1
    if not 0 <= size < 1e9:
        raise InputError(f"POVGEN_CACHE_SIZE = {text!r}: allowed: GiB, from 0 to below 1e9")
    return size * 2**30


def check() -> None:
    """Raises InputError for a limit that is no number and for a folder that povgen has not made.

    Raises PermissionError for a folder among temporary files that others can write to.
    """
    limit()
    kept = folder()
    try:
        status, names = os.lstat(kept), set(os.listdir(kept))
    except (FileNotFoundError, NotADirectoryError):  # `work` makes it, or tells
        return
    except OSError as error:
        raise OSError(error.errno, f"{error.strerror} ({HINT})", str(kept)) from None
    private = stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid() and not status.st_mode & 0o077
    if kept == _temporary() and not private:
        raise PermissionError(errno.EACCES, f"It is not this user's alone ({HINT})", str(kept))
    try:
        mark = _read(kept / TAG, len(MARK))
    except FileNotFoundError:
        mark = b""
    except OSError:
        mark = b"unreadable"
    # another povgen may be about to write the tag, or was killed before it did; it puts nothing else there before
    if mark != MARK and (mark or names - {TAG}):
        raise InputError(
            f"POVGEN_CACHE = {str(kept)!r}: a folder that holds other things and that povgen has not marked; "
            f"allowed: a new or an empty folder, or one that povgen has made and marked ({TAG})"
        )


def work() -> AbstractContextManager[Path]:
    """A folder to render in, on the cache's file system; makes the cache.

    Raises what `check` raises, and OSError where it cannot be.
    """
    kept = folder()
    try:
        kept.mkdir(mode=0o700 if kept == _temporary() else 0o777, parents=True, exist_ok=True)
        if not os.access(kept, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    except OSError as error:
        raise OSError(error.errno, f"{error.strerror} ({HINT})", str(kept)) from None
    check()
    # two that make the cache at once write the same
    tag = os.open(kept / TAG, os.O_WRONLY | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
    with open(tag, "wb") as file:
        if os.fstat(tag).st_size < len(MARK):
            file.write(MARK)
    return files.work_folder(kept)


def place(key: str, suffix: str) -> Path:
    """The file of what is made from what the key tells: a frame's ends in .png, a survey's in .json."""
    name = sha256(key.encode()).hexdigest()
    return folder() / name[:2] / f"{name}{suffix}"


def find(place: Path, most: int) -> bytes | None:
    """What a file holds, if it is there, can be read and is no larger than `most` bytes. Marks it as used now."""
    with suppress(OSError):
        return _read(place, most, used=True)
    return None


def _read(place: Path, most: int, used: bool = False) -> bytes:
    """The first bytes of a regular file. Raises OSError for what is none, a link included."""
    # what opens a FIFO would wait
    with open(os.open(place, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode) or used and status.st_size > most:
            raise OSError(errno.EINVAL, os.strerror(errno.EINVAL), str(place))
        if used:
            with suppress(PermissionError):  # another user's
                os.utime(file.fileno(), ns=(time.time_ns(), status.st_mtime_ns))
        return file.read(most)


def keep(part: Path, place: Path) -> bool:
    """Give a whole file its place. False where that cannot be, for something is there that is not povgen's."""
    with suppress(FileExistsError, NotADirectoryError, IsADirectoryError, PermissionError):
        place.parent.mkdir(exist_ok=True)
        mine = not place.parent.is_symlink() and (place.is_file() or not os.path.lexists(place))
        if mine and not place.is_symlink():
            os.replace(part, place)
            return True
    return False


def entries() -> list[tuple[float, int, Path]]:
    """Each file's time of last use, size in bytes, and path; the least recently used first."""
    found = list(_entries())
    now = time.time()
    # a time that is still to come says nothing of when it was used
    return sorted((used if used <= now else 0.0, size, path) for used, size, path in found)


def _entries() -> Iterator[tuple[float, int, Path]]:
    for shelf in _listed(folder()):
        if re.fullmatch("[0-9a-f]{2}", shelf.name) and shelf.is_dir(follow_symlinks=False):
            for entry in _listed(shelf):
                named = re.fullmatch(rf"{shelf.name}[0-9a-f]{{62}}\.(png|json)", entry.name)
                with suppress(FileNotFoundError):  # another povgen has just removed it
                    status = entry.stat(follow_symlinks=False)
                    if named and stat.S_ISREG(status.st_mode):
                        yield status.st_atime, status.st_size, Path(entry.path)


def _listed(parent: "Path | os.DirEntry[str]") -> "list[os.DirEntry[str]]":
    with suppress(FileNotFoundError, NotADirectoryError, PermissionError), os.scandir(parent) as entries:
        return list(entries)
    return []


def trim(most: float) -> list[Path]:
    """Remove the least recently used files until the others take no more than `most` bytes; returns those removed."""
    kept = entries()
    total, removed = sum(size for _, size, _ in kept), []
    for _, size, path in kept:
        if total <= most:
            break
        with suppress(FileNotFoundError, PermissionError):  # removed by another povgen, or another user's
            path.unlink()
            removed.append(path)
        total -= size
    return removed


def left() -> list[int]:
    """The size, in bytes, of each folder that a killed povgen left, here or among temporary files."""
    return [size for parent in _work_places() for size in files.left(parent)]


def sweep() -> int:
    """Remove the folders that killed povgens left, here or among temporary files; returns how many."""
    return sum(files.sweep(parent) for parent in _work_places())


def _work_places() -> list[Path]:
    return [folder(), Path(tempfile.gettempdir())]
