"""Chess pieces: povgen's own, and those that a user declares in a file."""

import os
import re
import tomllib
from collections.abc import Collection, Sequence
from dataclasses import field
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import model_serializer
from pydantic.dataclasses import dataclass

from povgen.files import read_bytes, read_text
from povgen.inputs import mesh
from povgen.record import held

PIECES: dict[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
FILE_RADIUS = 0.5  # tiles; a piece from a file must stay within this distance of its axis
MAX_BYTES = 2**20  # of a file

# The text of a piece becomes a part of the scene, inside the braces of a union: POV-Ray checks that it consists of
# objects and declarations. It can make a wrong picture, but no more: POV-Ray runs in a sandbox.
COMMENTS = re.compile(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)  # and strings
CONTROL = re.compile("[\0-\x08\x0e-\x1f\x7f-\x9f]")  # control characters: in a message, they would act on a terminal
DECLARED = re.compile(r"#[ \t]*(?:(?:declare|local|macro)\s+|for\s*\(\s*)([A-Za-z_]\w*)", re.ASCII)


@dataclass(frozen=True)
class PieceFile:
    """A user's file of a piece, and a text that declares `Piece` in POV-Ray's scene description language.

    The text is that of the file. For a mesh file, povgen makes the text.
    """

    path: str
    text: str = field(repr=False)
    options: str = ""  # of a mesh: its size and placing, as the user wrote them
    note: str = field(default="", repr=False, compare=False)  # what a user should know of a mesh
    is_mesh: bool = False

    @property
    def names(self) -> Sequence[str]:
        """What the file declares."""
        return ["Piece"] if self.is_mesh else declared(self.text)

    @model_serializer
    def __str__(self) -> str:
        return f"{self.path}{self.options}".encode(
            errors="backslashreplace"
        ).decode()  # a path can have bytes that are no text


Piece = str | Path | PieceFile  # as a user gives it


def as_piece(value: object) -> object:
    """Return the `PieceFile` of a path, which can have a mesh's options. Other values and names of pieces stay.

    Raises ValueError for a file that cannot be read or is too long. Raises ValueError for a file with a name such as
    model.stl that is no mesh, and for any other file that `checked` refuses.
    """
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if not isinstance(value, str) or value in PIECES:
        return value
    if recorded := held(value, _recorded):
        return recorded
    value = os.path.expanduser(value)
    if found := mesh.split(value):
        path, kind, options = found
        text, note = mesh.text_and_note(read_bytes(path, mesh.MAX_BYTES), kind, options, FILE_RADIUS)
        return PieceFile(path, text, value.removeprefix(path), note, True)
    return PieceFile(value, checked(read_text(value, MAX_BYTES)))


def _recorded(path: str, text: str) -> PieceFile:
    if not mesh.is_own(text):
        return PieceFile(path, checked(text))
    file = found[0] if (found := mesh.split(path)) else path
    return PieceFile(file, text, path.removeprefix(file), is_mesh=True)


def from_folder(value: object, folder: str | Path, names: Collection[str] = PIECES) -> object:
    """Return a value, or a list of values, so that a file's relative path starts in the folder.

    Text in `names`, and what is no text, stays as it is.
    """
    if isinstance(value, list):
        return [from_folder(each, folder, names) for each in value]
    return str(Path(folder, os.path.expanduser(value))) if isinstance(value, str) and value not in names else value


def radius(piece: str | PieceFile) -> float:
    """Return the radius of a piece's foot, tiles."""
    return FILE_RADIUS if isinstance(piece, PieceFile) else PIECES[piece]["radius"]


def checked(text: str) -> str:
    """Return a piece's text in the form for a `PieceFile`: all lines, also the last, end with one line feed.

    Raises ValueError for a text that is too long, has control characters, or declares no `Piece`.
    """
    if len(text) > MAX_BYTES:
        raise ValueError(f"should be a file of at most {MAX_BYTES} bytes")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if found := CONTROL.search(text):
        line = text.count("\n", 0, found.start()) + 1
        raise ValueError(
            f"line {line}: the control character {found[0]!r}; allowed: a file of objects and declarations"
        )
    if "Piece" not in declared(text):
        raise ValueError("should be a file that declares Piece, as in '#declare Piece = sphere { 0.5*y, 0.5 }'")
    return text.removesuffix("\n") + "\n"


def without_comments(text: str) -> str:
    """Return a piece's text without comments and strings."""
    return COMMENTS.sub(" ", text)


@lru_cache(maxsize=64)
def declared(text: str) -> Sequence[str]:
    """Return the names that a piece's text declares."""
    return sorted({*DECLARED.findall(without_comments(text))})
