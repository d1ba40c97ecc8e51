"""Files that the user asks for: refused early where they cannot be, and under their names only when whole."""

import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from povgen.errors import InputError


def checked_output(path: Path, suffixes: Iterable[str]) -> Path:
    """The path, if a file of one of these kinds can be written there; what is there stays. Raises InputError."""
    name = f"output = {str(path)!r}"
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{name}: not a kind that povgen writes; allowed: {', '.join(suffixes)}")
    try:
        if path.exists() and not (path.is_file() and os.access(path, os.W_OK)):
            raise InputError(f"{name}: it is there and cannot be written to; allowed: a file's name")
        with tempfile.TemporaryFile(dir=path.parent):
            return path
    except OSError as error:
        raise InputError(f"{name}: {error.strerror}; allowed: a file in a folder that can be written to") from None


def checked_folder(path: Path) -> Path:
    """The path of a folder, made if it is not there, if files can be written into it. Raises InputError."""
    try:
        path.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError as error:
        name = f"output = {str(path)!r}"
        raise InputError(f"{name}: {error.strerror}; allowed: a folder that can be written to") from None


def save(data: bytes, output: Path) -> None:
    """Write a file that bears its name only when it is whole."""
    with tempfile.TemporaryDirectory(dir=output.parent, prefix=".povgen-") as folder:
        part = Path(folder) / "part"
        part.write_bytes(data)
        part.replace(output)
