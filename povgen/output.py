"""Files that the user asks for: refused early where they cannot be, and under their names only when whole."""

import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO

from povgen import stopping
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
        with suppress(OSError), _owned(left):
            shutil.rmtree(left)
    folder = None
    try:
        with ExitStack() as stack:
            while True:
                with stopping.lock:
                    stopping.check()
                    made = tempfile.TemporaryDirectory(prefix=WORK, dir=parent, ignore_cleanup_errors=True)
                    folder = Path(stack.enter_context(made))
                    stopping.folders.add(str(folder))
                with suppress(FileNotFoundError, BlockingIOError):  # another povgen came upon it before it was owned
                    stack.enter_context(_owned(folder))
                    break
            yield folder
    finally:
        stopping.folders.discard(str(folder))


def _owned(folder: Path) -> IO[str]:
    """A file to keep open for as long as the folder is one's own.

    Raises BlockingIOError while it is another's, FileNotFoundError once it has been removed.
    """
    lock = open(folder / LOCK, "a")  # made where it is missing: who was to make it, or to remove all, may be dead
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not os.fstat(lock.fileno()).st_nlink:
            raise FileNotFoundError(folder)
    except BaseException:
        lock.close()
        raise
    return lock


def save(data: bytes, output: Path) -> None:
    """Write a file that bears its name only when it is whole. What a link leads to is written, not the link."""
    output = output.resolve()
    with work_folder(output.parent) as folder:
        part = folder / "part"
        part.write_bytes(data)
        part.replace(output)
