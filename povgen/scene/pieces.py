"""Chess pieces: povgen's own, and those that a user declares in a file."""

import os
import re
import stat
from dataclasses import field
from pathlib import Path

from pydantic import model_serializer
from pydantic.dataclasses import dataclass

# Radius of each piece's foot, tiles. The foot must not touch the window frame.
PIECES = {"pawn": 0.36, "rook": 0.40, "knight": 0.40, "bishop": 0.40, "queen": 0.43, "king": 0.43}
FILE_RADIUS = 0.5  # tiles; a piece from a file must stay within this distance of its axis
MAX_BYTES = 2**20  # of a file


@dataclass(frozen=True)
class PieceFile:
    """A file that declares `Piece` in POV-Ray's scene description language, and its text."""

    path: str
    text: str = field(repr=False)

    @property
    def names(self) -> list[str]:
        """What the file declares."""
        return sorted(set(re.findall(r"#\s*(?:declare|local|macro)\s+(\w+)", _code(self.text), flags=re.ASCII)))

    @model_serializer
    def __str__(self) -> str:
        return self.path.encode(errors="backslashreplace").decode()  # a path can have bytes that are no text


Piece = str | Path | PieceFile  # as a user gives it


def as_piece(value: object) -> object:
    """Read the file if the value is text but no name of a piece. Raises ValueError if that file declares no `Piece`."""
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    return value if not isinstance(value, str) or value in PIECES else PieceFile(value, _text(value))


def from_folder(value: object, folder: str | Path) -> object:
    """Return a piece, or a list of pieces, so that a file's relative path starts in the folder."""
    if isinstance(value, list):
        return [from_folder(each, folder) for each in value]
    return str(Path(folder, value)) if isinstance(value, str) and value not in PIECES else value


def radius(piece: str | PieceFile) -> float:
    """Return the radius of a piece's foot, tiles."""
    return FILE_RADIUS if isinstance(piece, PieceFile) else PIECES[piece]


def _text(path: str) -> str:
    """Return the text of a file that declares `Piece`. Its lines end with a line feed."""
    try:
        # without O_NONBLOCK, opening a FIFO would wait
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise ValueError("should be a name or a regular file")
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise ValueError(f"should be a name or a file, but: {error.strerror}") from None
    if len(data) > MAX_BYTES:
        raise ValueError(f"should be a file of at most {MAX_BYTES} bytes")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("should be a file in UTF-8") from None
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    code = _code(text)
    if found := re.search(r"#\s*default\b|\blight_source\b", code):
        raise ValueError(f"should be a file without {found[0]!r}, which would change the rest of the scene")
    if "\0" in text or not re.search(r"#\s*declare\s+Piece\s*=", code):
        raise ValueError("should be a file that declares Piece, as in '#declare Piece = sphere { 0.5*y, 0.5 }'")
    return text.removesuffix("\n") + "\n"


def _code(text: str) -> str:
    """Return the text without its comments, which can be nested, and strings. Raises ValueError if one does not end."""
    code, at, depth, opened = "", 0, 0, 0
    while found := re.compile(r"/\*|\*/" if depth else r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*', re.DOTALL).search(text, at):
        if not depth:
            code, opened = f"{code}{text[at : found.start()]} ", found.start()
        depth += {"/*": 1, "*/": -1}.get(found[0], 0)
        at = found.end()
    if depth:
        line = text.count("\n", 0, opened) + 1
        raise ValueError(f"should be a file whose comments end, but that in line {line} does not")
    return code + text[at:]
