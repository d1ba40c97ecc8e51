"""The cache: a marked folder of finished frames, ray traces and distance fields.

A file is named after its key: a text that states what the file was made from. `frame_path` makes a frame's key. A ray
trace's key is made in survey_cache.py, a distance field's in volumes.py.
"""

import errno
import json
import os
import re
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import platformdirs

from povgen import files, settings
from povgen.errors import InputError
from povgen.rendering import gl_runner, povray
from povgen.settings import Rendering

DEFAULT_SIZE = 2.0  # GiB
CHECKSUM = 32  # bytes at the end of each file: SHA-256 of all that is before them
# Backup programs leave out a folder that holds this file. povgen writes it only into an empty folder, and uses no
# folder without it.
TAG = "CACHEDIR.TAG"
MARK = b"""\
Signature: 8a477f597d28d172789f06886806bc55
# This folder is povgen's. It keeps rendered frames here, and removes those that have not been used for longest.
# What such a file is for: https://bford.info/cachedir/
"""
STORED = re.compile(r"[0-9a-f]{64}\.(png|light|values)")
HINT = "povgen's cache; POVGEN_CACHE can name another folder"


def frame_path(source: str, rendering: Rendering) -> Path:
    """Return the path of a frame in the cache.

    The frame's key is POV-Ray's version, POV-Ray's command line, the user's own files that a piece can name, the
    scene's text, the picture's size, and the filter by which povgen reduces the picture. The number of threads does not
    matter: the command line is that for one thread. With the renderer gl, the key is the device, the code that draws,
    the antialiasing, the size and the scene's text. Raises InputError or PovrayError if the renderer is missing.
    """
    size, suffix = "{}x{}".format(*rendering.size), ".light" if rendering.is_light else ".png"
    if rendering.renderer == "gl":
        drawn = gl_runner.device(), gl_runner.CODE.read_text("utf-8")  # they decide what a picture looks like
        return path_for("\0".join(["gl", *drawn, rendering.sampling, size, source]), suffix)
    command = [*povray.command("povray", rendering), *povray.library_files()]
    return path_for("\0".join([povray.version(), *command, size, settings.FILTER, source]), suffix)


def path_for(key: str, suffix: str) -> Path:
    """Return the file named after the SHA-256 of a key. The suffix is .png or .light for a frame, otherwise .values."""
    name = sha256(key.encode()).hexdigest()
    return folder() / name[:2] / f"{name}{suffix}"


def folder() -> Path:
    """Return the cache's folder: POVGEN_CACHE, or else povgen's folder in the user's cache.

    For a user without a home it is a folder among temporary files. Raises InputError if POVGEN_CACHE is a relative path
    and the current folder has been removed.
    """
    if named := os.environ.get("POVGEN_CACHE"):
        try:
            return files.in_home(Path(named)).absolute()
        except FileNotFoundError:
            reason = "the current folder has been removed; allowed: an absolute path"
            raise InputError(f"POVGEN_CACHE = {named!r}: {reason}") from None
    with suppress(RuntimeError):  # platformdirs 4.4 and later raise it for a user without a home
        if (path := platformdirs.user_cache_path("povgen")).is_absolute():
            return path
    return _temporary()


def _temporary() -> Path:
    """Return the cache's folder for a user without a home."""
    return Path(tempfile.gettempdir(), f"povgen-{os.geteuid()}")


def max_bytes() -> float:
    """Return the limit of the cache's size, bytes, from POVGEN_CACHE_SIZE, GiB. Raises InputError if not allowed."""
    text = os.environ.get("POVGEN_CACHE_SIZE") or str(DEFAULT_SIZE)
    try:
        size = float(text)
    except ValueError:
        size = -1
    if not 0 <= size < 1e9:
        raise InputError(f"POVGEN_CACHE_SIZE = {text!r}: allowed: GiB, from 0 to below 1e9")
    return size * 2**30


def check() -> None:
    """Check the settings before any work is done.

    Raises InputError for a limit that is not allowed, for a folder that is not povgen's, and for a folder of another
    user that others can use. Raises OSError if the folder cannot be read.
    """
    max_bytes()
    path = folder()
    with _hinted():
        try:
            owner, names = path.stat(), set(os.listdir(path))
            mark = (path / TAG).read_bytes() if TAG in names else b""
        except FileNotFoundError:  # `made` makes it, or raises an error
            return
    if owner.st_uid != os.geteuid() and (owner.st_mode & stat.S_IWOTH or path == _temporary()):
        raise InputError(
            f"POVGEN_CACHE = {str(path)!r}: another user's folder, which others can use; "
            "allowed: a folder of your own, or one to which only some users can write"
        )
    # Another povgen may be about to write the mark, or was killed before it did. The mark is written before all else.
    if mark != MARK and (mark or names - {TAG}):
        raise InputError(
            f"POVGEN_CACHE = {str(path)!r}: a folder that holds other things and that povgen has not marked; "
            f"allowed: a new or an empty folder, or one that povgen has made and marked ({TAG})"
        )


@contextmanager
def _hinted() -> Iterator[None]:
    """Add to an error of the system the name of the cache's folder, and how another folder is named."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, f"{error.strerror} ({HINT})", str(folder())) from None


def made() -> Path:
    """Return the cache's folder, which is made and marked if it is missing. Raises OSError, and what `check` raises."""
    path = folder()
    with _hinted():
        path.mkdir(mode=0o700 if path == _temporary() else 0o777, parents=True, exist_ok=True)
        with suppress(FileNotFoundError):  # somebody has just removed it
            if not os.access(path, os.W_OK):
                code = errno.EROFS if os.statvfs(path).f_flag & os.ST_RDONLY else errno.EACCES
                raise OSError(code, os.strerror(code))
            check()
            if not (path / TAG).exists() or not (path / TAG).stat().st_size:
                (path / TAG).write_bytes(MARK)
    return path


def read(path: Path) -> bytes | None:
    """Return what `store` stored at a path, and note that it was used now. None if it is missing or damaged."""
    with suppress(OSError):
        stored = path.read_bytes()
        with suppress(OSError):  # another user's file, or the disk is read-only
            os.utime(path, ns=(time.time_ns(), path.stat().st_mtime_ns))
        data, checksum = stored[:-CHECKSUM], stored[-CHECKSUM:]
        if sha256(data).digest() == checksum:
            return data
    return None


def store(data: bytes, path: Path) -> None:
    """Write data to a path in the cache, atomically and with a checksum at the end. Raises what `made` raises."""
    made()
    with _hinted(), suppress(FileNotFoundError):
        path.parent.mkdir(exist_ok=True)
        with files.replacing(path) as part:
            part.write_bytes(data + sha256(data).digest())


def load_values(key: str) -> Any:  # noqa: ANN401  (as json.loads)
    """Return the values that `store_values` stored with this key. None if no undamaged file has this key."""
    text = read(path_for(key, ".values"))
    return None if text is None else json.loads(text)


def store_values(key: str, values: object) -> None:
    """Store values that JSON can represent, if povgen can write in the cache. Raises the InputError of `check`."""
    with suppress(OSError):  # a full or read-only disk: they are computed again next time
        store(json.dumps(values).encode(), path_for(key, ".values"))


def by_last_use() -> list[tuple[float, int, Path]]:
    """Return time of last use, bytes and path of each file that `store` may have put there, the least recent first."""
    found, now = [], time.time()
    for path in folder().glob("[0-9a-f][0-9a-f]/*"):
        if STORED.fullmatch(path.name) and path.name.startswith(path.parent.name) and not path.parent.is_symlink():
            with suppress(FileNotFoundError):  # another povgen has just removed it
                status = path.lstat()
                if stat.S_ISREG(status.st_mode):
                    # a time in the future does not say when the file was used
                    used = status.st_atime if status.st_atime <= now else 0.0
                    found.append((used, status.st_size, path))
    return sorted(found)


def trim(most: float) -> list[Path]:
    """Remove the least recently used files until the rest takes at most `most` bytes. Return the removed files.

    If `most` is below 0, every file is removed, even an empty one.
    """
    stored = by_last_use()
    total, removed = sum(size for _, size, _ in stored), []
    for _, size, path in stored:
        if total <= most:
            break
        with suppress(OSError):  # another user owns it, or the disk is read-only
            with suppress(FileNotFoundError):  # another povgen has removed it
                path.unlink()
                removed.append(path)
            total -= size
    return removed
