"""Chess pieces: povgen's own, and those that a user declares in a file."""

import os
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import field
from functools import lru_cache
from itertools import chain, islice, tee
from pathlib import Path
from typing import NamedTuple

from pydantic import model_serializer
from pydantic.dataclasses import dataclass

from povgen.files import read_bytes, read_text
from povgen.scene import mesh

# Radius of each piece's foot, tiles. The foot must not touch the window frame.
PIECES = {"pawn": 0.36, "rook": 0.40, "knight": 0.40, "bishop": 0.40, "queen": 0.43, "king": 0.43}
FILE_RADIUS = 0.5  # tiles; a piece from a file must stay within this distance of its axis
MAX_BYTES = 2**20  # of a file

# The text of a piece becomes a part of the scene, inside braces. Inside braces, POV-Ray itself refuses cameras, fog,
# global settings and the like. `declared` refuses what else could change the rest of the scene: lights, defaults, and a
# brace that closes povgen's. It also refuses to write and to read files, because a text could write a file and include
# it.
#
# A token as POV-Ray's tokenizer reads it: a line comment, the start of a block comment, a string, a number, a
# directive, a name, or any other character.
TOKEN = re.compile(
    r"""//[^\n]*|/\*|"(?:\\.|[^"\\\n])*"|(?:\d+(?:\.\d*)?|\.\d+)(?:[eE](?:[-+\d]\d*)?)?|(?:\#[ \t]*)?[A-Za-z_]\w*|\S""",
    re.ASCII,
)
CONTROL = re.compile("[\0-\x08\x0e-\x1f\x7f-\x9f]")  # control characters: in a message, they would act on a terminal
# Each bracket, and each directive with a body, must be closed by its own end inside the one around it. In a macro,
# `1) #end` would let POV-Ray go on after the macro; `#if (0) { #end }` would close povgen's brace.
LOOPS, CONDITIONS = ("#while", "#for", "#switch", "#macro"), ("#if", "#ifdef", "#ifndef")
ENDS = {"{": "}", "(": ")", "[": "]", **dict.fromkeys((*LOOPS, *CONDITIONS), "#end")}
PARTS = ("#else", "#elseif", "#case", "#range")
OTHERS = ("#break", "#declare", "#local", "#undef", "#version", "#include", "#debug", "#warning", "#error")
DIRECTIVES = {*LOOPS, *CONDITIONS, *PARTS, *OTHERS, "#end"}
# POV-Ray's own files that contain only declarations. HF_Square and its like, and Parse_String, are macros in them that
# write files: these are refused.
INCLUDES = [
    *("chars.inc", "colors.inc", "consts.inc", "finish.inc", "functions.inc", "glass.inc", "golds.inc", "ior.inc"),
    *("math.inc", "metals.inc", "rand.inc", "shapes.inc", "shapes2.inc", "stones.inc", "stones1.inc", "stones2.inc"),
    *("textures.inc", "transforms.inc", "woodmaps.inc", "woods.inc"),
]
REFUSED = re.compile(r"light_source|light_group|HF\w*|Parse_String|OwnPiece\w*")  # OwnPiece: povgen's names of pieces


@dataclass(frozen=True)
class PieceFile:
    """A user's file of a piece, and a text that declares `Piece` in POV-Ray's scene description language.

    The text is that of the file. For a mesh file, povgen makes the text.
    """

    path: str
    text: str = field(repr=False)
    options: str = ""  # of a mesh: its size and placing, as the user wrote them
    note: str = field(default="", repr=False)  # what a user should know of a mesh
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
    value = os.path.expanduser(value)
    if found := mesh.split(value):
        path, kind, options = found
        text, note = mesh.text_and_note(read_bytes(path, mesh.MAX_BYTES), kind, options, FILE_RADIUS)
        return PieceFile(path, text, value.removeprefix(path), note, True)
    return PieceFile(value, _text(value))


def from_folder(value: object, folder: str | Path, names: Collection[str] = PIECES) -> object:
    """Return a value, or a list of values, so that a file's relative path starts in the folder.

    Text in `names`, and what is no text, stays as it is.
    """
    if isinstance(value, list):
        return [from_folder(each, folder, names) for each in value]
    return str(Path(folder, os.path.expanduser(value))) if isinstance(value, str) and value not in names else value


def radius(piece: str | PieceFile) -> float:
    """Return the radius of a piece's foot, tiles."""
    return FILE_RADIUS if isinstance(piece, PieceFile) else PIECES[piece]


def _text(path: str) -> str:
    """Return the text of a file that declares `Piece`, as `checked` does."""
    return checked(read_text(path, MAX_BYTES))


def checked(text: str) -> str:
    """Return a piece's text in the form for a `PieceFile`: all lines, also the last, end with one line feed.

    Raises ValueError for a text that is too long, has control characters, declares no `Piece`, or could change the rest
    of the scene.
    """
    if len(text) > MAX_BYTES:
        raise ValueError(f"should be a file of at most {MAX_BYTES} bytes")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if found := CONTROL.search(text):
        raise _error(text, found.start(), f"the control character {found[0]!r}")
    if "Piece" not in declared(text):
        raise ValueError("should be a file that declares Piece, as in '#declare Piece = sphere { 0.5*y, 0.5 }'")
    return text.removesuffix("\n") + "\n"


class _Opened(NamedTuple):
    """A bracket, or a directive with a body, that is not closed yet."""

    token: str
    at: int  # in the text
    # whether #break may stand directly inside; it skips the rest of a loop, and must not skip the end of a bracket
    breaks: bool


@lru_cache(maxsize=64)
def declared(text: str) -> Sequence[str]:
    """Return the names that a piece's text declares. Raises ValueError if it could change the rest of the scene.

    The time is proportional to the text's length.
    """
    names, opened = set(), list[_Opened]()
    tokens, following, second = tee(chain(_tokens(text), [(len(text), "")] * 2), 3)
    for (at, token), (_, after), (_, then) in zip(
        tokens, islice(following, 1, None), islice(second, 2, None), strict=False
    ):
        if fault := _fault(token, after, then, opened[-1:]):
            raise _error(text, at, fault)
        if token in ENDS:
            around = bool(opened) and opened[-1].breaks
            opened.append(_Opened(token, at, token in LOOPS or token in CONDITIONS and around))
        elif token in ENDS.values():
            opened.pop()
        elif token in ("#declare", "#local"):
            names.add(after)
        if token == "#macro":
            names.add(after)
        elif token == "#for":
            names.add(then)
    if opened:
        raise _error(text, opened[-1].at, f"{opened[-1].token!r} is not closed")
    return sorted(names)


def _fault(token: str, after: str, then: str, around: Sequence[_Opened]) -> str:
    """Return what is wrong with a token, or "" if nothing is. `after` and `then` are the next two tokens.

    `around` has the innermost bracket or directive that is open, or nothing.
    """
    end = ENDS[around[0].token] if around else ""
    if token in ENDS.values() and token != end or token in PARTS and end != "#end":
        return f"{token!r}, but {around[0].token!r} is open" if around else f"{token!r}, but nothing is open"
    if token == "#break" and not (around and around[0].breaks):
        return "'#break' inside brackets, or outside a loop"
    if token == "#include" and (around or after.strip('"') not in INCLUDES):
        return f"'#include'; allowed, outside all brackets: {', '.join(INCLUDES)}"
    if token in ("#declare", "#local") and then not in ("=", "["):
        return f"{token!r} without a name and '='"
    if token[:1] == "#" and token not in DIRECTIVES or REFUSED.fullmatch(token):
        return f"{token!r}, which could change the rest of the scene"
    if f"#{token}" in DIRECTIVES and token != "version":
        return f"{token!r} without '#'"
    return ""


def words(text: str) -> set[str]:
    """Return the tokens of a piece's text, without comments. A string is one token, with its quotation marks."""
    return {token for _, token in _tokens(text)}


def _tokens(text: str) -> Iterator[tuple[int, str]]:
    """Yield the place of each token in the text, from 0, and the token. Comments, also nested ones, are left out.

    Raises ValueError for a comment or a string that does not end.
    """
    at = 0
    while found := TOKEN.search(text, at):
        at = found.end()
        token = found[0]
        if token == "/*":
            at = _comment_end(text, found.start())
        elif token == '"':
            raise _error(text, found.start(), "a string that does not end")
        elif not token.startswith("//"):
            yield found.start(), "#" + token[1:].strip() if token[0] == "#" else token


def _comment_end(text: str, start: int) -> int:
    """Return where the comment that starts there ends. Raises ValueError if it does not."""
    depth = 0
    for found in re.compile(r"/\*|\*/").finditer(text, start):
        depth += 1 if found[0] == "/*" else -1
        if not depth:
            return found.end()
    raise _error(text, start, "a comment that does not end")


def _error(text: str, at: int, fault: str) -> ValueError:
    line = text.count("\n", 0, at) + 1
    return ValueError(f"line {line}: {fault}; allowed: a file of objects and declarations")
