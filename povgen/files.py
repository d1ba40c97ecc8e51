"""Output files: checks before any work is done, atomic writes, and work folders that are removed in the end.

povgen writes a file in a work folder, and moves it to its name when it is complete. If povgen is killed, its work
folders stay. The next povgen finds and removes them: it can lock their lock files, because no process does any more.
"""

import fcntl
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path

from povgen import stopping
from povgen.errors import InputError

WORK_PREFIX = ".povgen-"  # of a work folder's name
LOCK_FILE = "lock"  # in each work folder; the process that uses the folder holds a lock on it
MARK = b"povgen's folder for unfinished files: it may be removed when no process holds a lock on this file\n"


def checked_output(path: Path, suffixes: Iterable[str]) -> Path:
    """Return the path if a file with one of these suffixes can be written there. Raises InputError if not."""
    name = f"output = {str(path)!r}"
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{name}: not a kind that povgen writes; allowed: {', '.join(suffixes)}")
    try:
        if path.exists() and not (path.is_file() and os.access(path, os.W_OK)):
            raise ValueError("it is there and cannot be written to")
        with tempfile.TemporaryFile(dir=path.resolve().parent):
            return path
    except (OSError, RuntimeError, ValueError) as error:  # RuntimeError: links in a circle; ValueError: NUL in a name
        reason = getattr(error, "strerror", error)
        raise InputError(f"{name}: {reason}; allowed: a file in a folder that can be written to") from None


def checked_folder(path: Path) -> Path:
    """Make a folder if it is not there, and return its path. Raises InputError if no file can be written into it."""
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
    """Yield a new folder for unfinished files, and remove it at the end. Leftovers in `parent` are removed first."""
    remove_leftovers(parent)
    with ExitStack() as held, ExitStack() as made:  # the lock is held until the folder has been removed
        while True:
            with stopping.lock:
                stopping.check()
                folder = Path(tempfile.mkdtemp(prefix=WORK_PREFIX, dir=parent))
                stopping.folders.add(str(folder))
            made.callback(_forget, folder)
            # another povgen may have removed the folder before it was locked
            with suppress(FileNotFoundError, BlockingIOError):
                opened = held.enter_context(_opened(folder))
                made.callback(_remove_locked, folder, opened)
                lock = os.open(LOCK_FILE, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600, dir_fd=opened)
                held.callback(os.close, lock)
                _lock(lock)
                os.write(lock, MARK)
                break
        yield folder


def _forget(folder: Path) -> None:
    """Take a work folder off the list that is removed when povgen is stopped, if it has been removed already."""
    if not os.path.lexists(folder):
        stopping.folders.discard(str(folder))


def temporary_folder() -> AbstractContextManager[Path]:
    """Return a work folder in the system's folder for temporary files."""
    return work_folder(Path(tempfile.gettempdir()))


def remove_leftovers(parent: Path) -> int:
    """Remove the work folders that killed povgens left in a folder. Return their number."""
    removed = sum(_remove_locked(folder, opened) for folder, opened in _leftovers(parent))
    for folder in parent.glob(f"{WORK_PREFIX}*"):  # povgen was killed before it made the lock file: nothing is in it
        with suppress(OSError), _opened(folder) as opened:
            if _is_new(folder, opened):
                os.rmdir(folder)
    return removed


def leftover_sizes(parent: Path) -> list[int]:
    """Return the size, in bytes, of each work folder that a killed povgen left in a folder."""
    return [
        sum(os.lstat(name, dir_fd=inside).st_size for _, _, names, inside in os.fwalk(dir_fd=opened) for name in names)
        for _, opened in _leftovers(parent)
    ]


def _leftovers(parent: Path) -> Iterator[tuple[Path, int]]:
    """Yield each work folder that a killed povgen left, with its descriptor. It is locked until the next is yielded.

    Such a folder is this user's. Its lock file has povgen's mark, and no process holds a lock on it.
    """
    for folder in list(parent.glob(f"{WORK_PREFIX}*")):
        with suppress(OSError), ExitStack() as stack:
            opened = stack.enter_context(_opened(folder))
            lock = os.open(LOCK_FILE, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=opened)  # a FIFO would block
            stack.callback(os.close, lock)
            if os.fstat(opened).st_uid == os.geteuid() and _is_marked(folder, opened, lock):
                _lock(lock)
                if _is_marked(folder, opened, lock):  # it may have changed before it was locked
                    yield folder, opened


def _is_marked(folder: Path, opened: int, lock: int) -> bool:
    """Whether a lock file holds povgen's mark, or is all that is in a new folder: povgen was killed before it wrote."""
    text = os.pread(lock, len(MARK) + 1, 0) if stat.S_ISREG(os.fstat(lock).st_mode) else None
    return text == MARK or text == b"" and _is_new(folder, opened) and os.listdir(opened) == [LOCK_FILE]


@contextmanager
def _opened(folder: Path) -> Iterator[int]:
    """Yield a folder's descriptor. Raises OSError for anything else, a link to a folder included."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        yield opened
    finally:
        os.close(opened)


def _is_new(folder: Path, opened: int) -> bool:
    """Whether a folder has the name, owner and mode that mkdtemp gives it."""
    status = os.fstat(opened)
    named = re.fullmatch(re.escape(WORK_PREFIX) + "[a-z0-9_]{8}", folder.name)
    return bool(named) and status.st_uid == os.geteuid() and stat.S_IMODE(status.st_mode) == stat.S_IRWXU


def _lock(lock: int) -> None:
    """Lock a file. Raises BlockingIOError if another process has locked it, FileNotFoundError if it was removed."""
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    if not os.fstat(lock).st_nlink:
        raise FileNotFoundError


def _remove_locked(folder: Path, opened: int) -> bool:
    """Remove a work folder, of which this process holds the lock. Return whether that succeeded.

    The lock file is removed last: if something else cannot be removed, the folder is still marked.
    """
    try:
        with os.scandir(opened) as found:
            for entry in [entry for entry in found if entry.name != LOCK_FILE]:
                if entry.is_dir(follow_symlinks=False):
                    shutil.rmtree(entry.name, dir_fd=opened)
                else:
                    os.unlink(entry.name, dir_fd=opened)
        with suppress(FileNotFoundError):
            os.unlink(LOCK_FILE, dir_fd=opened)
        os.rmdir(folder)
        return True
    except OSError:
        return False


def save(made: bytes | Path, output: Path) -> None:
    """Write data, or move a file, to the output atomically: until it is complete, an older file stays in place.

    If the output is a link, the file that it points to is replaced. The new file gets the old one's mode, and its owner
    and group if that is permitted. Raises OSError, which names the output.
    """
    target = output.resolve()
    try:
        with work_folder(target.parent) as folder:
            part = folder / "part"
            if isinstance(made, bytes):
                part.write_bytes(made)
            else:
                shutil.move(made, part)
            _copy_permissions(part, target)
            part.replace(target)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(output)) from None


def _copy_permissions(part: Path, target: Path) -> None:
    """Give a new file the mode, owner and group of the file that it replaces."""
    with suppress(FileNotFoundError, PermissionError):
        before = target.stat()
        mode = stat.S_IMODE(before.st_mode)
        with suppress(PermissionError):
            os.chown(part, before.st_uid, -1)
        try:
            os.chown(part, -1, before.st_gid)
        except PermissionError:  # the file gets another group, which may do no more than all other users
            mode = mode & ~stat.S_IRWXG | (mode & stat.S_IRWXO) << 3
        part.chmod(mode)
