"""Files that the user asks for: refused early where they cannot be, and under their names only when whole."""

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

# What folders for unfinished files begin with; in each a file that its owner locks, with this text.
WORK, LOCK = ".povgen-", "lock"
MARK = b"povgen's folder for unfinished files: it may be removed when no process holds a lock on this file\n"


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
    sweep(parent)
    with ExitStack() as held, ExitStack() as made:  # the lock is held until the folder has been removed
        while True:
            with stopping.lock:
                stopping.check()
                folder = Path(tempfile.mkdtemp(prefix=WORK, dir=parent))
                stopping.folders.add(str(folder))
            made.callback(_forget, folder)
            with suppress(FileNotFoundError, BlockingIOError):  # another povgen came upon it before it was locked
                opened = held.enter_context(_opened(folder))
                made.callback(_remove, folder, opened)
                lock = os.open(LOCK, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600, dir_fd=opened)
                held.callback(os.close, lock)
                _hold(lock)
                os.write(lock, MARK)
                break
        yield folder


def _forget(folder: Path) -> None:
    """A folder that is gone need not be removed when povgen is stopped; one that is still there must be."""
    if not os.path.lexists(folder):
        stopping.folders.discard(str(folder))


def temporary_folder() -> AbstractContextManager[Path]:
    """A work folder in the system's folder for temporary files."""
    return work_folder(Path(tempfile.gettempdir()))


def sweep(parent: Path) -> int:
    """Remove the work folders that killed povgens left in a folder; returns how many."""
    removed = sum(_remove(folder, opened) for folder, opened in _left(parent))
    for folder in parent.glob(f"{WORK}*"):  # killed before there was a lock: then it is empty
        with suppress(OSError), _opened(folder) as opened:
            if _fresh(folder, opened):
                os.rmdir(folder)
    return removed


def left(parent: Path) -> list[int]:
    """The size, in bytes, of each work folder that a killed povgen left in a folder."""
    return [
        sum(os.lstat(name, dir_fd=inside).st_size for _, _, names, inside in os.fwalk(dir_fd=opened) for name in names)
        for _, opened in _left(parent)
    ]


def _left(parent: Path) -> Iterator[tuple[Path, int]]:
    """The work folders of killed povgens, each with its descriptor, and locked until the next is asked for.

    Such a folder is this user's and has a lock file with povgen's mark, which no process holds.
    """
    for folder in list(parent.glob(f"{WORK}*")):
        with suppress(OSError), ExitStack() as stack:
            opened = stack.enter_context(_opened(folder))
            lock = os.open(LOCK, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=opened)  # a FIFO would block
            stack.callback(os.close, lock)

            def marked(folder: Path = folder, opened: int = opened, lock: int = lock) -> bool:
                text = os.pread(lock, len(MARK) + 1, 0) if stat.S_ISREG(os.fstat(lock).st_mode) else None
                # killed before it was marked: nothing else is there
                return text == MARK or text == b"" and _fresh(folder, opened) and os.listdir(opened) == [LOCK]

            if os.fstat(opened).st_uid == os.geteuid() and marked():
                _hold(lock)
                if marked():  # still, now that it is locked
                    yield folder, opened


@contextmanager
def _opened(folder: Path) -> Iterator[int]:
    """A folder's descriptor. Raises OSError for what is no folder, a link to one included."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        yield opened
    finally:
        os.close(opened)


def _fresh(folder: Path, opened: int) -> bool:
    """Whether a folder is as mkdtemp makes one for this user."""
    status = os.fstat(opened)
    named = re.fullmatch(re.escape(WORK) + "[a-z0-9_]{8}", folder.name)
    return bool(named) and status.st_uid == os.geteuid() and stat.S_IMODE(status.st_mode) == stat.S_IRWXU


def _hold(lock: int) -> None:
    """Lock a file. Raises BlockingIOError while another holds it, FileNotFoundError once it has been removed."""
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    if not os.fstat(lock).st_nlink:
        raise FileNotFoundError


def _remove(folder: Path, opened: int) -> bool:
    """Remove a work folder that is locked; the lock goes last, so that what cannot be removed is still marked."""
    try:
        with os.scandir(opened) as found:
            for entry in [entry for entry in found if entry.name != LOCK]:
                if entry.is_dir(follow_symlinks=False):
                    shutil.rmtree(entry.name, dir_fd=opened)
                else:
                    os.unlink(entry.name, dir_fd=opened)
        with suppress(FileNotFoundError):
            os.unlink(LOCK, dir_fd=opened)
        os.rmdir(folder)
        return True
    except OSError:
        return False


def save(made: bytes | Path, output: Path) -> None:
    """Write data, or move a file, to a name that it bears only when it is whole. What a link leads to is written.

    What is there keeps its mode, and its owner and group where that is permitted. Raises OSError that names the output.
    """
    target = output.resolve()
    try:
        with work_folder(target.parent) as folder:
            part = folder / "part"
            if isinstance(made, bytes):
                part.write_bytes(made)
            else:
                shutil.move(made, part)
            _permit(part, target)
            part.replace(target)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(output)) from None


def _permit(part: Path, target: Path) -> None:
    """Give a new file the mode, owner and group of the one whose place it takes."""
    with suppress(FileNotFoundError, PermissionError):
        before = target.stat()
        mode = stat.S_IMODE(before.st_mode)
        with suppress(PermissionError):
            os.chown(part, before.st_uid, -1)
        try:
            os.chown(part, -1, before.st_gid)
        except PermissionError:  # another group gets no more than all others
            mode = mode & ~stat.S_IRWXG | (mode & stat.S_IRWXO) << 3
        part.chmod(mode)
