"""Output files: checks before any work is done, atomic writes, and work folders that are removed at the end.

povgen writes a file in a work folder, and moves the complete file to its final name. Each process locks a lock file in
its work folder. If a process is killed, its work folder remains, but the lock is released. Therefore the next process
can lock this file: it then knows that the folder is a leftover, and removes it.
"""

import errno
import fcntl
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path
from secrets import token_hex
from typing import TypeVar

from povgen import stopping
from povgen.errors import InputError, shown

Result = TypeVar("Result")
WORK_PREFIX = ".povgen-"  # a work folder's name begins with this
LOCK_FILE = "lock"  # in each work folder; the process that uses the folder holds a lock on it
REMOVALS = 3
NO_ROOM = errno.ENOSPC, errno.EDQUOT, errno.EFBIG  # of a disk, of a user's quota, and of ulimit -f
NO_INODES = "no inodes left, which means too many files (df -i)"
MARK = b"povgen's folder for unfinished files: it may be removed when no process holds a lock on this file\n"


def own_folder(name: str) -> Path:
    """Return povgen's folder 'templates' or 'movies': beside the package in a checkout, in it where it is installed."""
    return next(folder for parent in Path(__file__).parents[:2] if (folder := parent / name).is_dir())


def in_home(path: Path) -> Path:
    """Return the path with a user's home folder in place of ~ at its start, if there is such a user."""
    try:
        return path.expanduser()
    except RuntimeError:
        return path


def as_path(path: object, suffixes: Iterable[str], option: str) -> Path:
    """Return a Path, with the home folder in place of ~. Raises InputError, which names the option, for no path.

    Also raises it if the path has none of these suffixes, which are in lower case, such as .png.
    """
    try:
        path = in_home(Path(path))  # type: ignore[arg-type]  # any object: what is no path raises TypeError
    except TypeError:
        raise InputError(f"{option} = {shown(path)}: should be a path; allowed: {', '.join(suffixes)}") from None
    name = f"{option} = {str(path)!r}"
    if path.suffix.lower() not in suffixes:
        if path.name.lower() in suffixes:
            raise InputError(f"{name}: an ending without a name; allowed: NAME{path.name}")
        raise InputError(f"{name}: not a kind that povgen writes; allowed: {', '.join(suffixes)}")
    return path


def checked_output(
    path: str | Path, suffixes: Iterable[str], option: str = "output", inputs: Iterable[str | Path | int] = ()
) -> Path:
    """Return the path if a file with one of these suffixes can be written there, and is none of the inputs.

    The inputs are paths or descriptors of the files that povgen reads. Raises InputError, which names the option that
    states the path.
    """
    path = as_path(path, suffixes, option)
    name = f"{option} = {str(path)!r}"
    for given in inputs:
        if _is_same(path, given):
            raise InputError(f"{name}: povgen reads this file; allowed: another file")
    with _refused(name, "a file in a folder that can be written to"):
        if path.exists() and not (path.is_file() and os.access(path, os.W_OK)):
            raise ValueError("it exists and cannot be written to")
        tempfile.TemporaryFile(dir=path.resolve().parent).close()
    return path


def check_new_folder(path: Path, longest: str) -> None:
    """Raise InputError if the missing folder of this output, or a file named `longest` in it, cannot be made."""
    with _refused(f"output = {str(path)!r}", "a file in a folder that can be written to, or in a new one there"):
        with suppress(FileNotFoundError):
            os.lstat(path.parent)  # raises for a name that is too long
        with suppress(FileNotFoundError):
            os.lstat(path.parent.parent / longest)  # likewise; this folder is in the same file system
        tempfile.TemporaryFile(dir=path.parent.resolve().parent).close()


@contextmanager
def _refused(name: str, allowed: str) -> Iterator[None]:
    """Raise InputError, which begins with `name` and says what is allowed, in place of an error of the system."""
    try:
        yield
    except (OSError, RuntimeError, ValueError) as error:  # RuntimeError: links in a circle; ValueError: NUL in a name
        raise InputError(f"{name}: {getattr(error, 'strerror', error)}; allowed: {allowed}") from None


def _is_same(path: Path, other: str | Path | int) -> bool:
    """Return whether both are the same file, perhaps through links. `other` can be a descriptor."""
    try:
        return os.path.samefile(path, other if isinstance(other, int) else in_home(Path(other)))
    except (OSError, ValueError):  # one of them does not exist; ValueError: NUL in a name
        return False


class Removed(FileNotFoundError):
    """Somebody has removed a folder while povgen worked in it."""

    def __init__(self, folder: Path) -> None:
        super().__init__(errno.ENOENT, "removed while povgen used it", str(folder))


def unless_removed(work: Callable[[], Result], warn: Callable[[], object] = lambda: None) -> Result:
    """Return the result of `work`. If it raises Removed, call `warn` and then `work` again, up to REMOVALS times."""
    for _ in range(REMOVALS):
        with suppress(Removed):
            return work()
        warn()
    return work()


@contextmanager
def output_folder(path: Path) -> Iterator[Path]:
    """Make a folder if it is missing, and yield its path. After an error, remove it if it was made here and is empty.

    Raises InputError if no file can be written into it.
    """
    new = not os.path.lexists(path)
    try:
        path = in_home(path)
        with _refused(f"output = {str(path)!r}", "a folder that can be written to"):
            path.mkdir(exist_ok=True)
            tempfile.TemporaryFile(dir=path).close()
        yield path
    except BaseException:
        if new:
            with suppress(OSError):  # it is not empty
                path.rmdir()
        raise


@contextmanager
def work_folder(parent: Path) -> Iterator[Path]:
    """Yield a new folder for unfinished files, and remove it at the end. Remove leftovers in `parent` first.

    Raises Removed in place of any other error if the folder, or `parent`, has been removed meanwhile.
    """
    remove_leftovers(parent)
    with ExitStack() as held, ExitStack() as made:  # the lock is held until the folder has been removed
        folder = parent
        try:
            folder = _locked_folder(parent, held, made)
            yield folder
        except Exception as error:
            if not os.path.lexists(folder):
                raise Removed(folder) from None
            if isinstance(error, OSError) and error.errno in NO_ROOM:
                no_inodes = error.errno == errno.ENOSPC and _has_no_inodes(parent)
                error.strerror = NO_INODES if no_inodes else error.strerror
                error.filename = error.filename or str(parent)
            raise


def _locked_folder(parent: Path, held: ExitStack, made: ExitStack) -> Path:
    """Return a new folder. `made` removes the folder when it is closed, and `held` then releases the lock."""
    while True:
        with stopping.lock:
            stopping.check()
            folder = parent / f"{WORK_PREFIX}{token_hex(4)}"
            stopping.folders.add(str(folder))  # before it exists: a signal's handler can raise its exception anywhere
            try:
                folder.mkdir(mode=0o700)
            except FileExistsError:  # another process's
                stopping.folders.discard(str(folder))
                continue
            except BaseException:
                _forget(folder)
                raise
        made.callback(_forget, folder)
        # another process may have removed the folder before it was locked: then make another folder
        with suppress(FileNotFoundError, BlockingIOError):
            opened = held.enter_context(_opened(folder))
            made.callback(_remove_locked, folder, opened)
            lock = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
            held.callback(os.close, lock)
            _lock(lock)
            os.write(lock, MARK)
            return folder


def is_full(folder: Path, size: int = 2**16) -> bool:
    """Return whether a folder's file system has no room for `size` bytes, or for one more file."""
    disk = os.statvfs(folder)
    return disk.f_bavail * disk.f_frsize < size or _has_no_inodes(folder)


def _has_no_inodes(folder: Path) -> bool:
    """Return whether a folder's file system can hold no more files. Some file systems have no such limit."""
    disk = os.statvfs(folder)
    return disk.f_files > 0 and not disk.f_favail


def _forget(folder: Path) -> None:
    """If a work folder has been removed, take it off the list of folders that povgen removes when it is stopped."""
    if not os.path.lexists(folder):
        stopping.folders.discard(str(folder))


def temporary_folder() -> AbstractContextManager[Path]:
    """Return a work folder in the system's folder for temporary files."""
    return work_folder(Path(tempfile.gettempdir()))


def remove_leftovers(parent: Path) -> int:
    """Remove the work folders that killed processes left in a folder. Return their number."""
    removed = sum(_remove_locked(folder, opened) for folder, opened in _leftovers(parent))
    # a process that was killed before it made the lock file left an empty folder: rmdir removes only empty folders
    for folder in parent.glob(f"{WORK_PREFIX}*"):
        with suppress(OSError), _opened(folder) as opened:  # another process removes it, or another user owns it
            if _is_new(folder, opened):
                os.rmdir(folder)
    return removed


def leftover_sizes(parent: Path) -> list[int]:
    """Return the size, in bytes, of each work folder that a killed process left in a folder."""
    return [
        sum(os.lstat(name, dir_fd=inside).st_size for _, _, names, inside in os.fwalk(dir_fd=opened) for name in names)
        for _, opened in _leftovers(parent)
    ]


def _leftovers(parent: Path) -> Iterator[tuple[Path, int]]:
    """Yield each work folder that a killed process left, with its descriptor. It is locked until the next is yielded.

    Such a folder belongs to this user. Its lock file contains povgen's mark, and no process holds a lock on this file.
    """
    for folder in list(parent.glob(f"{WORK_PREFIX}*")):
        with suppress(OSError), ExitStack() as stack:  # not a leftover: it is locked, or is no work folder of this user
            opened = stack.enter_context(_opened(folder))
            lock = os.open(LOCK_FILE, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=opened)  # a FIFO would block
            stack.callback(os.close, lock)
            if os.fstat(opened).st_uid == os.geteuid() and _is_marked(folder, opened, lock):
                _lock(lock)
                if _is_marked(folder, opened, lock):  # check again: the file may have changed before it was locked
                    yield folder, opened


def _is_marked(folder: Path, opened: int, lock: int) -> bool:
    """Return whether a lock file contains povgen's mark, or is empty and the only file in a new folder.

    It is empty if povgen was killed before it wrote the mark.
    """
    text = os.pread(lock, len(MARK) + 1, 0) if stat.S_ISREG(os.fstat(lock).st_mode) else None
    return text == MARK or text == b"" and _is_new(folder, opened) and os.listdir(opened) == [LOCK_FILE]


@contextmanager
def _opened(folder: Path) -> Iterator[int]:
    """Yield a folder's descriptor. Raises OSError for anything that is not a folder, and for a link to a folder."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        yield opened
    finally:
        os.close(opened)


def _is_new(folder: Path, opened: int) -> bool:
    """Return whether a folder has the name, owner and mode that `_locked_folder` gives."""
    status = os.fstat(opened)
    named = re.fullmatch(re.escape(WORK_PREFIX) + "[a-z0-9_]{8}", folder.name)
    return bool(named) and status.st_uid == os.geteuid() and stat.S_IMODE(status.st_mode) == stat.S_IRWXU


def _lock(lock: int) -> None:
    """Lock a file. Raises BlockingIOError if another process has locked it, FileNotFoundError if it was removed."""
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    if not os.fstat(lock).st_nlink:
        raise FileNotFoundError


def _remove_locked(folder: Path, opened: int) -> bool:
    """Remove a work folder that this process has locked. Return whether this succeeded.

    The lock file is removed last: if another file cannot be removed, the folder is still marked.
    """
    try:
        with os.scandir(opened) as found:
            for entry in [entry for entry in found if entry.name != LOCK_FILE]:
                if entry.is_dir(follow_symlinks=False):
                    shutil.rmtree(entry.name, dir_fd=opened)
                else:
                    os.unlink(entry.name, dir_fd=opened)
        with suppress(FileNotFoundError):  # its process was killed before it made one
            os.unlink(LOCK_FILE, dir_fd=opened)
        os.rmdir(folder)
        return True
    except OSError:
        return False


def read_bytes(path: str, most: int) -> bytes:
    """Return a regular file's content. Raises ValueError if it has more than `most` bytes or cannot be read."""
    try:
        # without O_NONBLOCK, opening a FIFO would wait
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise ValueError("should be a name or a regular file")
            data = file.read(most + 1)
            if data is None:  # as /proc/kmsg, which waits for the next message
                raise ValueError("should be a name or a file that can be read at once")
    except OSError as error:
        raise ValueError(f"should be a name or a file, but: {error.strerror}") from None
    if len(data) > most:
        raise ValueError(f"should be a file of at most {most} bytes")
    return data


def read_text(path: str, most: int) -> str:
    """Return the text of a regular file in UTF-8, or else in Windows-1252, with line feeds at the ends of lines.

    Raises ValueError if it has more than `most` bytes, cannot be read, or is in UTF-16.
    """
    data = read_bytes(path, most)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in data:
            raise ValueError("should be a file in UTF-8") from None
        text = data.decode("cp1252", "replace")  # as older editors write Latin letters, and as POV-Ray allows
    return text.replace("\r\n", "\n").replace("\r", "\n")


def save(made: bytes | Path, output: Path, beside: Path | None = None) -> None:
    """Write data, or move a file, to the output atomically: an older file stays in place until the new one is complete.

    If the output is a link, the file that it points to is replaced. The new file gets the mode of the old file, and its
    owner and group if the system permits this. `beside` is a work folder in the output's folder, which several calls
    can share: in a folder of thousands of files, a new work folder for each call takes long. Raises OSError, which
    names the output.
    """
    target = output.resolve()
    try:
        shared = beside if beside and beside.parent == target.parent else None  # a link can lead to another folder
        with nullcontext(shared) if shared else work_folder(target.parent) as folder:
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
    with suppress(FileNotFoundError, PermissionError):  # there is no old file, or its folder cannot be searched
        before = target.stat()
        mode = stat.S_IMODE(before.st_mode)
        with suppress(PermissionError):  # only root may change the owner
            os.chown(part, before.st_uid, -1)
        try:
            os.chown(part, -1, before.st_gid)
        except PermissionError:  # the group differs: it gets only the rights of all other users
            mode = mode & ~stat.S_IRWXG | (mode & stat.S_IRWXO) << 3
        part.chmod(mode)
