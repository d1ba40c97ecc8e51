"""Files: checks of outputs before any work is done, atomic writes, temporary folders, and what a user's files hold."""

import errno
import os
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from secrets import token_hex

from povgen.errors import InputError, shown
from povgen.stopping import lock, removed

PREFIX = "povgen-"  # of the names of temporary folders; those of unfinished files also begin with a dot
NO_ROOM = errno.ENOSPC, errno.EDQUOT, errno.EFBIG  # of a disk, of a user's quota, and of ulimit -f


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


@contextmanager
def output_folder(path: Path) -> Iterator[Path]:
    """Make a folder if it is missing, and yield its path. After an error, remove it if it was made here and is empty.

    Raises InputError if no file can be written into it.
    """
    path = in_home(path)
    with removed(path, os.rmdir) if not os.path.lexists(path) else nullcontext():  # rmdir removes empty folders alone
        with _refused(f"output = {str(path)!r}", "a folder that can be written to"):
            path.mkdir(exist_ok=True)
            tempfile.TemporaryFile(dir=path).close()
        yield path


@contextmanager
def temporary_folder(parent: Path | None = None) -> Iterator[Path]:
    """Yield a new folder in another, by default in the system's for temporary files, and remove it at the end."""
    parent = parent or Path(tempfile.gettempdir())
    folder = parent / f"{PREFIX}{token_hex(8)}"
    with removed(folder, shutil.rmtree):
        try:
            with lock:  # not after a signal has ended povgen
                folder.mkdir(mode=0o700)
            yield folder
        except OSError as error:
            if error.errno in NO_ROOM:
                error.filename = error.filename or str(parent)
            raise


def is_full(folder: Path, size: int = 2**16) -> bool:
    """Return whether a folder's file system has no room for `size` bytes."""
    disk = os.statvfs(folder)
    return disk.f_bavail * disk.f_frsize < size


def read_bytes(path: str, most: int) -> bytes:
    """Return a regular file's content. Raises ValueError if it has more than `most` bytes or cannot be read."""
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):  # to open a FIFO would wait
            raise ValueError("should be a name or a regular file")
        with open(path, "rb") as file:
            data = file.read(most + 1)
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


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Yield the path for a new file, which replaces the target at the end. After an error the target stays."""
    part = target.with_name(f".{PREFIX}{token_hex(8)}")
    with removed(part, os.unlink):
        yield part
        part.replace(target)


def write(made: bytes | Path, output: Path) -> None:
    """Write data, or copy a file, to the output atomically: an older file stays in place until the new one is complete.

    If the output is a link, the file that it points to is replaced. The new file gets the mode of the old file, and its
    group if the system permits this. Raises OSError, which names the output.
    """
    target = output.resolve()
    try:
        with replacing(target) as part:
            if isinstance(made, bytes):
                part.write_bytes(made)
            else:
                shutil.copyfile(made, part)
            with suppress(FileNotFoundError):  # there is no old file
                before = target.stat()
                with suppress(PermissionError):
                    os.chown(part, -1, before.st_gid)
                same_group = part.stat().st_gid == before.st_gid
                part.chmod(stat.S_IMODE(before.st_mode) & ~(0 if same_group else stat.S_IRWXG))
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(output)) from None
