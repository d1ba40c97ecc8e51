"""The record in a file: how povgen made it, so that it can be made again.

A record is its format and checksum, and then JSON. It is in a part of a PNG file (iTXt), in an attribute of an EXR
file's header, in a GIF's comment, in a box of an MP4 file (uuid), in a tag of a WebM file, in a part (PVGN) of a WebP
file, in a comment of a PDF file or of a text (`COMMENTS`), and under a name of JSON, which is an attribute of a netCDF
file. `save` writes it into every other
file that povgen makes. A file can be a stranger's: every value in it is checked, and nothing is run.
"""

import json
import os
import re
import shlex
import stat
import struct
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Annotated, Any, ParamSpec, TypeVar

from pydantic import AfterValidator, Field

from povgen.citation import CITE, HOME
from povgen.errors import InputError, shown
from povgen.files import in_home, write
from povgen.settings import Note, Rendering
from povgen.validation import Model
from povgen.version import __version__

T = TypeVar("T")
P = ParamSpec("P")
FORMAT = 1  # of records; a povgen that cannot read a new kind of record says so
MAX_BYTES = 2**24  # of a record
MAX_FRAMES = 30000  # as many as a movie's spec can have
MAX_PICTURES = 4  # decoded, each can need 134 MB
MOST_ITEMS = 20  # of a list in a call's text
MAX_VALUES = 1000  # of any other list or table in a record: povgen's have up to about 50
# the format, and the checksum of the rest; the rest is on the next line, or on the same one, or is a value of JSON
FIRST_LINE = re.compile(rb'povgen record ([0-9]{1,9}) ([0-9a-f]{8})(?:\n| |":)')
NAME = b"povgen"  # of the part that holds a record
# how these files begin
PNG, EXR, GIF, WEBM = b"\x89PNG\r\n\x1a\n", b"v/1\x01", b"GIF8", b"\x1aE\xdf\xa3"
RIFF, PDF, GLB = b"RIFF", b"%PDF", b"glTF"
NETCDF = b"\x89HDF", b"CDF"
# the texts of which a comment, at the end, is the record: by their endings, what stands before and after it
COMMENTS = {
    **dict.fromkeys((".csv", ".txt", ".obj"), (b"# ", b"\n")),
    **dict.fromkeys((".svg", ".html"), (b"<!-- ", b" -->\n")),
    **dict.fromkeys((".pov", ".inc"), (b"// ", b"\n")),
}
# the files of pictures, by their endings: what they are called, and how many bits a colour can have, the default first
PICTURES = {".png": ("a PNG file", (8, 16)), ".exr": ("an EXR file", (32,))}
DRAWINGS = (".png", ".svg", ".pdf")  # the files of charts and figures
SRGB = (b"sRGB", b"\0"), (b"gAMA", struct.pack(">I", 45455))  # parts of a PNG file that say which light its bytes mean
MP4_TYPE = b"uuid" + bytes.fromhex("b3c9d0a15e0f4a0f9a4d706f7667656e")  # of a box that is no standard's
WEBP_TYPE = b"PVGN"  # of a part that is no standard's
SEGMENT, TAGS, TAG, TARGETS = b"\x18\x53\x80\x67", b"\x12\x54\xc3\x67", b"\x73\x73", b"\x63\xc0"  # WebM's elements
SIMPLE_TAG, TAG_NAME, TAG_STRING = b"\x67\xc8", b"\x45\xa3", b"\x44\x87"
# how povgen's files without a record begin: captions, and the pages and tables of earlier versions
OWN = re.compile(
    rb'<!DOCTYPE html>.{,200}<meta name="generator" content="povgen |(error,)?quantity,value\n|series,'
    rb"|method,antialias,width,height,CPU s,|!\[[^\n]*\]\(figure[1-6]\.png\)\n",
    re.DOTALL,
)
KINDS = "a PNG, EXR, MP4, WebM, WebP, GIF, SVG, PDF, CSV, JSON, HTML, OBJ, GLB, netCDF or .pov file that povgen wrote"


class Record(Model):
    """How povgen made a file. That of a file which shows no scene has no frames: its command says all."""

    povgen: str = Field(description="povgen's version")
    cite: str = Field(default="", description="povgen's address, and what to cite")
    command: str | None = Field(
        default=None, description="the shell's command, or the call of povgen's function in Python"
    )
    renderer: str = Field(default="", description="the renderer's version: POV-Ray's, or the device that drew")
    rendering: Annotated[Rendering, AfterValidator(Rendering.in_default_time)] = Field(
        default=Rendering(), description="how the scenes were rendered, without the time limit"
    )
    title: str | None = Field(default=None, description="a movie's title")
    frame_rate: Annotated[float, Field(ge=0.1, le=120)] | None = Field(
        default=None, description="a movie's frames a second, 0.1 to 120"
    )
    notes: Annotated[tuple[Note, ...], Field(max_length=MAX_FRAMES)] = Field(
        default=(), description="each frame's note, if a movie has several"
    )
    pieces: dict[str, str] = Field(default={}, description="the text of each file that declares a piece or a profile")
    pictures: dict[str, str] = Field(default={}, description="PNG files of sky and floor in base 64, if small")
    frames: Annotated[tuple[dict[str, Any], ...], Field(min_length=1, max_length=MAX_FRAMES)] = Field(
        default=(),
        description=f"each frame's scene, 1 to {MAX_FRAMES}: the first with all parameters, the others with those that "
        "differ from the first's",
    )

    @property
    def stated(self) -> dict[str, Any]:
        """What the record states, as JSON has it."""
        return self.model_dump(mode="json", exclude_unset=True)

    @property
    def values(self) -> Iterator[dict[str, Any]]:
        """All values of each frame: the scene's name, as `scene`, and its parameters."""
        first = self.frames[0]
        for frame in self.frames:
            yield {**first, **frame} if frame.get("scene", first.get("scene")) == first.get("scene") else frame

    def __bytes__(self) -> bytes:
        """The record as it is in a file. Raises InputError if it is too large."""
        text = json.dumps(self.stated).encode()
        if len(text) > MAX_BYTES:
            size = f"{len(text) / 2**20:.1f} MiB with the text of all pieces"
            raise InputError(f"frames: the record of how the file was made has {size}; allowed: {MAX_BYTES >> 20} MiB")
        return _headed(text)


def _headed(text: bytes) -> bytes:
    return b"povgen record %d %08x\n" % (FORMAT, zlib.crc32(text)) + text


_in_use: ContextVar[tuple[dict[str, str], dict[Any, Any]] | None] = ContextVar("_in_use", default=None)


@contextmanager
def in_use(record: Record) -> Iterator[None]:
    """Let the texts in a record stand for the files that scenes name. Meanwhile no such file is read."""
    token = _in_use.set(({**record.pieces, **record.pictures}, {}))
    try:
        yield
    finally:
        _in_use.reset(token)


def held(name: str, make: Callable[[str, str], T]) -> T | None:
    """Return `make(name, text)`, made once, for the text that the record in use has under a name.

    Return None if no record is in use. Raises ValueError if it has no such text.
    """
    if not (used := _in_use.get()):
        return None
    texts, made = used
    if name not in texts:
        raise ValueError(
            f"not in the record, which holds pieces, profiles and up to {MAX_PICTURES} pictures, of 4 MiB together"
        )
    if (make, name) not in made:
        made[make, name] = make(name, texts[name])
    found: T = made[make, name]
    return found


def differing(frames: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return frames as a Record holds them, from all values of each frame."""
    first = frames[0]

    def part(frame: dict[str, Any]) -> dict[str, Any]:
        if frame["scene"] != first["scene"]:
            return frame
        return {name: value for name, value in frame.items() if value != first[name]}

    return [first, *map(part, frames[1:])]


_call: ContextVar[str | None] = ContextVar("_call", default=None)


def recorded_call(function: Callable[P, T]) -> Callable[P, T]:
    """Make the call of a function the command in the records of the files that it writes.

    Lists of scenes or numbers are shortened to MOST_ITEMS, and values to 1000 characters.
    """

    @wraps(function)
    def called(*arguments: P.args, **options: P.kwargs) -> T:
        texts = [*map(_as_code, arguments), *(f"{name}={_as_code(value)}" for name, value in options.items())]
        token = _call.set(_call.get() or f"povgen.{function.__qualname__}({', '.join(texts)})")
        try:
            return function(*arguments, **options)
        finally:
            _call.reset(token)

    return called


def _as_code(value: object) -> str:
    if (isinstance(value, list) or getattr(value, "ndim", 0)) and len(value) > MOST_ITEMS:  # type: ignore[arg-type]
        return f"{shown([*value[:MOST_ITEMS]], 1000)[:-1]}, ...]"  # type: ignore[index]
    return shown(str(value) if isinstance(value, Path) else value, 1000)


def command() -> str | None:
    """Return the command that a shell's user gave, if this process is povgen's command line, or the call in Python."""
    program = Path(sys.argv[0]) if sys.argv else Path()
    if program.name != "povgen" and program.parts[-2:] != ("povgen", "__main__.py"):
        return _call.get()
    text = shlex.join(["povgen", *sys.argv[1:]])
    return text.encode(errors="backslashreplace").decode()  # an argument can have bytes that are no text


def info(path: str | Path) -> Record:
    """Return the record in a file that povgen wrote: how the file was made.

    Raises InputError, which names the file, if it has no record, or one that is damaged or a newer povgen's.
    """
    try:
        path = in_home(Path(path))
    except TypeError:
        raise InputError(f"path = {shown(path)}: should be a path; allowed: {KINDS}") from None
    name = repr(str(path))
    try:
        found = _found(path)
    except (OSError, ValueError) as error:  # ValueError: NUL in the name
        raise InputError(f"{name}: {getattr(error, 'strerror', error)}; allowed: {KINDS}") from None
    if found is None:
        why = "an STL file has no room for a" if path.suffix.lower() == ".stl" else "without a"
        raise InputError(f"{name}: {why} record of how it was made; allowed: {KINDS}")
    form, checksum, text = found
    if form > FORMAT:
        raise InputError(f"{name}: the record of a newer povgen, of format {form}; allowed: up to {FORMAT}")
    try:
        values, end = json.JSONDecoder().raw_decode(text)  # what follows belongs to the file
    except (ValueError, RecursionError):  # RecursionError: thousands of brackets
        values, end = None, 0
    if not isinstance(values, dict) or zlib.crc32(text[:end].encode("latin-1")) != checksum:
        raise InputError(f"{name}: its record is damaged; allowed: {KINDS}")
    try:
        _check_lengths(values)
        return Record(**values)
    except InputError as error:
        raise InputError(f"{name}: its record: {error}") from None


def check_unasked(files: Iterable[Path], sign: Path | None = None) -> None:
    """Raise InputError if one of these files, which the user did not name, exists and povgen did not write it.

    The file's record or its beginning shows whether povgen wrote it. If povgen always writes all of these files
    together, `sign` is the one that shows it for those that have neither.
    """
    for path in files:
        if os.path.lexists(path) and not (_is_own(path) or sign and _is_own(sign)):
            raise InputError(f"output: {str(path)!r} exists, and povgen did not write it; allowed: another output")


def _is_own(path: Path) -> bool:
    try:
        if _found(path):
            return True
        with path.open("rb") as file:
            return OWN.match(file.read(1000)) is not None
    except (OSError, ValueError):  # such as no regular file
        return False


def _found(path: Path) -> tuple[int, int, str] | None:
    """Return a record's format, its checksum and the text that begins with its JSON; None for a file without one.

    The record is found by its first line, wherever it is in the file. Raises OSError if the file cannot be
    read, and ValueError for what is no regular file.
    """
    if not stat.S_ISREG(os.stat(path).st_mode):  # to open a FIFO would wait
        raise ValueError("no regular file")
    with open(path, "rb") as file:
        head = file.read(12)
        is_binary = head.startswith((PNG, EXR, GIF, WEBM, RIFF, PDF, GLB, *NETCDF)) or head[4:8] == b"ftyp"
        if not head or not (is_binary or path.suffix.lower() in (*COMMENTS, ".json")):
            return None
        with mmap(file.fileno(), 0, access=ACCESS_READ) as data:
            first = FIRST_LINE.search(data)
            if first and head.startswith(GIF):  # a comment is divided into blocks of up to 255 bytes
                blocks, at = bytearray(), first.start() - 1
                while at < len(data) and data[at]:
                    blocks += data[at + 1 : at + 1 + data[at]]
                    at += 1 + data[at]
                text = bytes(blocks[len(first[0]) :])
            elif first:
                text = data[first.end() : first.end() + MAX_BYTES]
            return (int(first[1]), int(first[2], 16), text.decode("latin-1")) if first else None


def _check_lengths(values: dict[str, Any]) -> None:
    """Raise InputError for a list or a table with too many values: pydantic would keep an error for each wrong one."""
    longest = {"frames": MAX_FRAMES, "notes": MAX_FRAMES, "pieces": MAX_FRAMES, "pictures": MAX_PICTURES}
    waiting: list[tuple[str, object, int]] = [("record", values, MAX_VALUES)]
    while waiting:
        name, part, most = waiting.pop()
        if not isinstance(part, (list, dict)):
            continue
        if len(part) > most:
            raise InputError(f"{shown(name)}: {len(part)} values; allowed: up to {most}")
        pairs = part.items() if isinstance(part, dict) else ((name, value) for value in part)
        waiting += [(key, x, longest.get(key, MAX_VALUES) if part is values else MAX_VALUES) for key, x in pairs]


# ---- Writing


_of_scene: ContextVar[Record | None] = ContextVar("_of_scene", default=None)


@contextmanager
def saved_with(record: Record) -> Iterator[None]:
    """Let this be the record of files that `save` writes."""
    token = _of_scene.set(record)
    try:
        yield
    finally:
        _of_scene.reset(token)


def save(made: bytes | Path, output: Path) -> None:
    """Write a file as `files.write` does. All of povgen's files are written here.

    Data get a record, that of `saved_with` or one without frames, if they have none and the format has room for
    one. An STL file has room for HOME alone. A path is of a file that has its record.
    """
    if isinstance(made, bytes) and not FIRST_LINE.search(made):
        made = _with_record(made, output.suffix.lower())
    write(made, output)


def _with_record(made: bytes, suffix: str) -> bytes:
    """Return the data of a file with this ending, with a record."""
    record = bytes(_of_scene.get() or Record(povgen=__version__, cite=CITE, command=command()))
    line = record.replace(b"\n", b" ")
    if suffix in COMMENTS:
        before, after = COMMENTS[suffix]
        if suffix in (".svg", ".html"):  # a comment there cannot have --
            line = _headed(record.split(b"\n", 1)[1].replace(b"--", rb"-\u002d")).replace(b"\n", b" ")
        return made + before + line + after
    if suffix == ".json":
        return as_object(record)[:-1] + b"," + made.lstrip()[1:]
    if made.startswith(PNG):  # behind the header
        return made[:33] + _png_part(b"iTXt", NAME + bytes(5) + record) + made[33:]
    if made.startswith(PDF):  # behind the table of objects, which states their places
        start = made.rindex(b"startxref")
        return made[:start] + b"% " + line + b"\n" + made[start:]
    if made.startswith(GLB):  # a header, and then JSON, with spaces at its end
        end = 20 + int.from_bytes(made[12:16], "little")
        tree = b'{"extras":' + as_object(record) + b"," + made[21:end]
        tree += b" " * (-len(tree) % 4)
        rest = struct.pack("<I", len(tree)) + made[16:20] + tree + made[end:]
        return made[:8] + struct.pack("<I", 12 + len(rest)) + rest
    return f"povgen {__version__}, {HOME}".ljust(80).encode() + made[80:] if suffix == ".stl" else made


def as_object(record: bytes) -> bytes:
    """Return a record as an object of JSON."""
    return b'{"%b":%b}' % (*record.split(b"\n", 1),)


def in_png(png: bytes, record: Record) -> bytes:
    """Return a PNG file's pixels as a PNG file that says that they are sRGB, and has the record."""
    parts, start = [], len(PNG)
    while start < len(png):
        (length,) = struct.unpack_from(">I", png, start)
        parts.append((png[start + 4 : start + 8], png[start + 8 : start + 8 + length]))
        start += 12 + length
    header, *others = [part for part in parts if part[0] in (b"IHDR", b"IDAT", b"IEND")]
    return png_of([header, *SRGB, (b"iTXt", NAME + bytes(5) + bytes(record)), *others])


def png_of(parts: Iterable[tuple[bytes, bytes]]) -> bytes:
    """Return the PNG file that consists of parts, each a name and its data."""
    return PNG + b"".join(_png_part(name, data) for name, data in parts)


def _png_part(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def into_movie(movie: Path, record: Record) -> None:
    """Write a record into an MP4, WebM or WebP file, at its end."""
    data = bytes(record)
    with movie.open("r+b") as file:
        if movie.suffix == ".webm":
            tag = _element(SIMPLE_TAG, _element(TAG_NAME, NAME.upper()) + _element(TAG_STRING, data))
            tags = _element(TAGS, _element(TAG, _element(TARGETS, b"") + tag))
            place = file.read(2**10).index(SEGMENT) + len(SEGMENT)
            file.seek(place)
            size = int.from_bytes(file.read(8)) + len(tags)  # ffmpeg writes the Segment's size with 8 bytes
            file.seek(place)
            file.write(size.to_bytes(8))
        elif movie.suffix == ".webp":
            tags = WEBP_TYPE + struct.pack("<I", len(data)) + data + bytes(len(data) % 2)
            size = file.seek(0, os.SEEK_END) + len(tags) - 8
            file.seek(4)
            file.write(struct.pack("<I", size))
        else:
            tags = struct.pack(">I", 4 + len(MP4_TYPE) + len(data)) + MP4_TYPE + data
        file.seek(0, os.SEEK_END)
        file.write(tags)


def _element(kind: bytes, data: bytes) -> bytes:
    """Return an element of a WebM file."""
    return kind + (1 << 56 | len(data)).to_bytes(8) + data
