"""Files that the user asks for: refused early where they cannot be, and under their names only when whole."""

import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from povgen.errors import InputError

WORK, LOCK = ".povgen-", "lock"  # what folders for unfinished files begin with, and the file that their owner locks


def checked_output(path: Path, suffixes: Iterable[str]) -> Path:
    """The path, if a file of one of these kinds can be written there; what is there stays. Raises InputError."""
    name = f"output = {str(path)!r}"
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{name}: not a kind that povgen writes; allowed: {', '.join(suffixes)}")
    try:
        if path.exists() and not (path.is_file() and os.access(path, os.W_OK)):
            raise ValueError("it is there and cannot be written to")
        with tempfile.TemporaryFile(dir=path.resolve().parent):
            return path
    except (OSError, RuntimeError, ValueError) as error:  # RuntimeError: links in a circle, ValueError: a NUL in a name
        reason = getattr(error, "strerror", error)
        raise InputError(f"{name}: {reason}; allowed: a file in a folder that can be written to") from None


def checked_folder(path: Path) -> Path:
    """The path of a folder, made if it is not there, if files can be written into it. Raises InputError."""
    try:
        path.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except (OSError, ValueError) as error:
        name = f"output = {str(path)!r}"
        reason = getattr(error, "strerror", error)
        raise InputError(f"{name}: {reason}; allowed: a folder that can be written to") from None


@contextmanager
def work_folder(parent: Path) -> Iterator[Path]:
    """A folder for unfinished files, removed at the end; those of povgens that were killed are removed first."""
    for left in parent.glob(f"{WORK}*"):
        with suppress(OSError), open(left / LOCK) as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # refused while its owner lives
            shutil.rmtree(left)
    with tempfile.TemporaryDirectory(prefix=WORK, dir=parent, ignore_cleanup_errors=True) as made:
        folder = Path(made)
        with open(folder / "new", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            (folder / "new").rename(folder / LOCK)  # nobody finds it before it is locked
            yield folder


def save(data: bytes, output: Path) -> None:
    """Write a file that bears its name only when it is whole. What a link leads to is written, not the link."""
    output = output.resolve()
    with work_folder(output.parent) as folder:
        part = folder / "part"
        part.write_bytes(data)
        part.replace(output)
