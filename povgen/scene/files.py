"""A user's files: TOML files that state a room or a movie, and the files that the values of a scene name."""

import logging
import tomllib
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from povgen.errors import InputError, shown
from povgen.files import in_home
from povgen.inputs.pictures import Picture
from povgen.inputs.pieces import PIECES, PieceFile, from_folder
from povgen.scene.windows import window_table
from povgen.sheets.profile import NAMES, ProfileFile
from povgen.validation import Model

MAX_BYTES = 2**14  # the longest text; Python's TOML parser can take minutes for a much longer one
# the parameters that can be files, with their values that are none
FILES: dict[str, Collection[str]] = {
    "piece": PIECES,
    "profile": NAMES,
    "sky": ("mountains",),
    "floor": ("tiles", "none"),
    "file": ("tiles",),
}


def file_of(path: str | Path, own: Path | None = None) -> Path | int:
    """Return the file that a path names; 0, standard input, for the path "-".

    If there is no such file, the path is the name of one in the folder `own`, without .toml.
    """
    if str(path) == "-":
        return 0
    file = in_home(Path(path))
    return file if not own or file.suffix == ".toml" or file.exists() and not file.is_dir() else own / f"{path}.toml"


def text_of(path: object, what: str, allowed: str, own: Path | None = None) -> tuple[str, str, str | Path]:
    """Return the text in the `file_of` a path, how messages name it, and its folder.

    Raises InputError, which says that it is no `what`, and what is `allowed`.
    """
    if not isinstance(path, (str, Path)):
        raise InputError(f"{shown(path)}: no {what}; allowed: {allowed}")
    name = "standard input" if str(path) == "-" else str(path) or "''"
    try:
        file = file_of(path, own)
        with open(file, "rb", closefd=isinstance(file, Path)) as opened:
            data = opened.read(MAX_BYTES + 1) or b""  # None: standard input that does not wait for text
        if len(data) > MAX_BYTES:
            raise ValueError(f"longer than {MAX_BYTES} bytes")
        # some editors begin a file with a byte order mark
        return data.decode("utf-8-sig"), name, file.parent if isinstance(file, Path) else ""
    except (OSError, ValueError) as error:  # ValueError: too long, not UTF-8, or a NUL in the name
        reason = "not UTF-8" if isinstance(error, UnicodeError) else getattr(error, "strerror", error)
        raise InputError(f"{name}: no {what}: {reason}; allowed: {allowed}") from None


def table_of(text: object, name: str) -> dict[str, Any]:
    """Return the table that a text in TOML states. Raises InputError, whose message begins with `name`."""
    if not isinstance(text, str):
        raise InputError(f"{name}: not TOML: {shown(text)}; allowed: text")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # RecursionError: thousands of brackets
        raise InputError(f"{name}: not TOML: {error}") from None


def in_folder(values: Mapping[str, object], folder: str | Path) -> dict[str, object]:
    """Return a scene's values so that relative paths of files, also of windows and objects, start in the folder."""

    def moved(table: Mapping[str, object]) -> dict[str, object]:
        return {x: from_folder(value, folder, FILES[x]) if x in FILES else value for x, value in table.items()}

    def thing(value: object) -> object:
        with suppress(ValueError):  # the scene refuses it
            table = window_table(value)
            if isinstance(table, Mapping) and FILES.keys() & table.keys():
                return moved(table)
        return value

    found = moved(values)
    for name in {"window", "object"} & found.keys():
        given = found[name]
        found[name] = [*map(thing, given)] if isinstance(given, list) else thing(given)
    return found


def name_files_outside(folder: str | Path, name: str, values: tuple[object, ...]) -> None:
    """Warn of the files among values of the TOML file `name` that are not in the folder, also if a link leads there.

    The record in what povgen makes contains them, and somebody else may have written the TOML file.
    """
    for path in dict.fromkeys(Path(file.path).resolve() for file in files_in(values)):
        if not path.is_relative_to(Path(folder).resolve()):
            text = f"povgen: warning: {name} names a file outside its folder, {str(path)!r}"
            logging.getLogger("povgen").warning(f"{text}; what povgen makes can contain this file")


def files_in(value: object) -> Iterator[Picture | PieceFile | ProfileFile]:
    """Yield the files that a user gave as values of a scene, of its windows and of its objects."""
    if isinstance(value, (Picture, PieceFile, ProfileFile)):
        yield value
    elif isinstance(value, (Model, tuple)):
        for part in value:
            yield from files_in(part)  # of a model, part is a name and a value
