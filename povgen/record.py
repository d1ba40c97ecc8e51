"""The record in a file: how povgen made it, so that it can be made again.

A record is a line with its format and checksum, and then JSON. It is in a part of a PNG file (iTXt), in an attribute of
an EXR file's header, in a GIF's comment, in a box of an MP4 file (uuid), in a tag of a WebM file, and in a part (PVGN)
of a WebP file. A file can be a stranger's: every value in it is checked, and nothing is run.
"""

import json
import os
import re
import shlex
import stat
import struct
import sys
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, BinaryIO

from pydantic import AfterValidator, Field

from povgen.errors import InputError, shown
from povgen.files import in_home
from povgen.settings import Rendering
from povgen.validation import Model

FORMAT = 1  # of records; a povgen that cannot read a new kind of record says so
MAX_BYTES = 2**24  # of a record
MAX_FRAMES = 30000  # as many as a movie's spec can have
MAX_PICTURES = 4  # decoded, each can need 134 MB
MAX_VALUES = 1000  # of any other list or table in a record: povgen's have up to about 50
FIRST_LINE = re.compile(rb"povgen record ([0-9]{1,9})(?: ([0-9a-f]{8}))?\n")
NAME = b"povgen"  # of the part that holds a record
PNG, EXR, GIF, WEBM = b"\x89PNG\r\n\x1a\n", b"v/1\x01", b"GIF8", b"\x1aE\xdf\xa3"  # how these files begin
SRGB = (b"sRGB", b"\0"), (b"gAMA", struct.pack(">I", 45455))  # parts of a PNG file that say which light its bytes mean
MP4_TYPE = b"uuid" + bytes.fromhex("b3c9d0a15e0f4a0f9a4d706f7667656e")  # of a box that is no standard's
RIFF, WEBP, WEBP_TYPE = b"RIFF", b"WEBP", b"PVGN"  # a WebP file's beginning, and a part that is no standard's
SEGMENT, TAGS, TAG, TARGETS, SIMPLE_TAG = 0x18538067, 0x1254C367, 0x7373, 0x63C0, 0x67C8  # WebM's elements
TAG_NAME, TAG_STRING = 0x45A3, 0x4487
# how povgen's other files begin: pages, tables, captions
OWN = re.compile(
    rb'<!DOCTYPE html>.{,200}<meta name="generator" content="povgen |(error,)?quantity,value\n|series,'
    rb"|method,antialias,width,height,CPU s,|!\[[^\n]*\]\(figure[1-6]\.png\)\n",
    re.DOTALL,
)
KINDS = "a PNG, EXR, MP4, WebM, WebP or GIF file that povgen wrote"


class Record(Model):
    """How povgen made a picture or a movie."""

    povgen: str = Field(description="povgen's version")
    renderer: str = Field(description="the renderer's version: POV-Ray's, or the device that drew")
    command: str | None = Field(default=None, description="the command, if a shell's command made the file")
    rendering: Annotated[Rendering, AfterValidator(Rendering.in_default_time)] = Field(
        description="how the scenes were rendered, without the time limit"
    )
    title: str | None = Field(default=None, description="a movie's title")
    frame_rate: Annotated[float, Field(ge=0.1, le=120)] | None = Field(
        default=None, description="a movie's frames a second, 0.1 to 120"
    )
    pieces: dict[str, str] = Field(default={}, description="the text of each file that declares a piece or a profile")
    pictures: dict[str, str] = Field(default={}, description="PNG files of sky and floor in base 64, if small")
    frames: Annotated[tuple[dict[str, Any], ...], Field(min_length=1, max_length=MAX_FRAMES)] = Field(
        description=f"each frame's scene, 1 to {MAX_FRAMES}: the first with all parameters, the others with those that "
        "differ from the first's"
    )

    @property
    def values(self) -> Iterator[dict[str, Any]]:
        """All values of each frame: the scene's name, as `scene`, and its parameters."""
        first = self.frames[0]
        for frame in self.frames:
            yield {**first, **frame} if frame.get("scene", first.get("scene")) == first.get("scene") else frame

    def __bytes__(self) -> bytes:
        """The record as it is in a file. Raises InputError if it is too large."""
        text = json.dumps(self.model_dump(mode="json")).encode()
        if len(text) > MAX_BYTES:
            size = f"{len(text) / 2**20:.1f} MiB with the text of all pieces"
            raise InputError(f"frames: the record of how the file was made has {size}; allowed: {MAX_BYTES >> 20} MiB")
        return b"povgen record %d %08x\n" % (FORMAT, zlib.crc32(text)) + text


def differing(frames: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return frames as a Record holds them, from all values of each frame."""
    first = frames[0]

    def part(frame: dict[str, Any]) -> dict[str, Any]:
        if frame["scene"] != first["scene"]:
            return frame
        return {name: value for name, value in frame.items() if value != first[name]}

    return [first, *map(part, frames[1:])]


def shell_command() -> str | None:
    """Return the command that a shell's user gave, if this process is povgen's command line."""
    program = Path(sys.argv[0]) if sys.argv else Path()
    if program.name != "povgen" and program.parts[-2:] != ("povgen", "__main__.py"):
        return None
    text = shlex.join(["povgen", *sys.argv[1:]])
    return text.encode(errors="backslashreplace").decode()  # an argument can have bytes that are no text


def info(path: str | Path) -> Record:
    """Return the record in a file that povgen wrote: how the file was made.

    Raises InputError, which names the file, if it has no record, or one that is damaged or a newer povgen's.
    """
    name, data = _name_and_data(path)
    if data is None:
        raise InputError(f"{name}: without a record of how it was made; allowed: {KINDS}")
    first = FIRST_LINE.match(data)
    if first and int(first[1]) > FORMAT:
        raise InputError(f"{name}: the record of a newer povgen, of format {int(first[1])}; allowed: up to {FORMAT}")
    text = data[first.end() :] if first else b""
    if not first or first[2] != b"%08x" % zlib.crc32(text):
        raise InputError(f"{name}: its record is damaged; allowed: {KINDS}")
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):  # RecursionError: thousands of brackets
        values = None
    if not isinstance(values, dict):
        raise InputError(f"{name}: its record is no JSON object; allowed: {KINDS}")
    try:
        _check_lengths(values)
        return Record(**values)
    except InputError as error:
        raise InputError(f"{name}: its record: {error}") from None


def check_unasked(files: Iterable[Path], sign: Path | None = None) -> None:
    """Raise InputError if one of these files, which the user did not name, exists and povgen did not write it.

    The file's record or its beginning shows whether povgen wrote it. If povgen always writes all of these files
    together, `sign` is the one that shows it for all.
    """
    for path in files:
        if os.path.lexists(path) and not _is_own(sign or path):
            raise InputError(f"output: {str(path)!r} exists, and povgen did not write it; allowed: another output")


def _is_own(path: Path) -> bool:
    try:
        if (data := _name_and_data(path)[1]) is not None:
            return FIRST_LINE.match(data) is not None
        with path.open("rb") as file:
            return OWN.match(file.read(1000)) is not None
    except (InputError, OSError):  # damaged, or no regular file
        return False


def _check_lengths(values: dict[str, Any]) -> None:
    """Raise InputError for a list or a table with too many values: pydantic would keep an error for each wrong one."""
    longest = {"frames": MAX_FRAMES, "pieces": MAX_FRAMES, "pictures": MAX_PICTURES}
    waiting: list[tuple[str, object, int]] = [("record", values, MAX_VALUES)]
    while waiting:
        name, part, most = waiting.pop()
        if not isinstance(part, (list, dict)):
            continue
        if len(part) > most:
            raise InputError(f"{shown(name)}: {len(part)} values; allowed: up to {most}")
        pairs = part.items() if isinstance(part, dict) else ((name, value) for value in part)
        waiting += [(key, x, longest.get(key, MAX_VALUES) if part is values else MAX_VALUES) for key, x in pairs]


def _name_and_data(path: str | Path) -> tuple[str, bytes | None]:
    """Return a file's name for messages and the bytes of its record, None if it has none. Raises InputError."""
    try:
        path = in_home(Path(path))
    except TypeError:
        raise InputError(f"path = {shown(path)}: should be a path; allowed: {KINDS}") from None
    name = repr(str(path))
    try:
        # without O_NONBLOCK, opening a FIFO would wait
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                return name, _data(file)
        reason = "no regular file"
    except OSError as error:
        reason = error.strerror or f"damaged: {error}"
    except (IndexError, struct.error):
        reason = "damaged: it ends too early"
    except ValueError as error:  # also a NUL in the name
        reason = f"damaged: {error}"
    raise InputError(f"{name}: {reason}; allowed: {KINDS}")


def _data(file: BinaryIO) -> bytes | None:
    """Return the record's bytes in a file, or None. Raises IndexError, ValueError or struct.error if it is damaged."""
    head = file.read(12)
    file.seek(0)
    if head.startswith(PNG):
        return _in_png(file)
    if head.startswith(EXR):
        return _in_exr(file)
    if head.startswith(GIF):
        return _in_gif(file)
    if head.startswith(WEBM):
        return _in_webm(file)
    if head.startswith(RIFF) and head[8:] == WEBP:
        return _in_webp(file)
    return _in_mp4(file) if head[4:8] == b"ftyp" else None


def _read(file: BinaryIO, size: int) -> bytes:
    """Return `size` bytes. Raises IndexError if the file has fewer, and ValueError if no record can have so many."""
    if not 0 <= size <= MAX_BYTES + 2**10:
        raise ValueError(f"its record of {size} bytes is too long")
    data = file.read(size)
    if len(data) < size:
        raise IndexError
    return data


# ---- PNG


def png_parts(png: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the name and the data of each part of a PNG file. Raises ValueError or struct.error for a damaged file."""
    start = 8
    while start < len(png) or start == 8:
        (length,) = struct.unpack_from(">I", png, start)
        name, data = png[start + 4 : start + 8], png[start + 8 : start + 8 + length]
        start += 12 + length
        if struct.unpack_from(">I", png, start - 4) != (zlib.crc32(name + data),):
            raise ValueError("a wrong checksum")
        yield name, data


def in_png(png: bytes, record: Record) -> bytes:
    """Return a PNG file's pixels as a PNG file that says that they are sRGB, and has the record."""
    header, *others = [part for part in png_parts(png) if part[0] in (b"IHDR", b"IDAT", b"IEND")]
    return png_of([header, *SRGB, (b"iTXt", NAME + bytes(5) + bytes(record)), *others])


def png_of(parts: Iterable[tuple[bytes, bytes]]) -> bytes:
    """Return the PNG file that consists of parts, each a name and its data."""
    return PNG + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in parts
    )


def _in_png(file: BinaryIO) -> bytes | None:
    file.seek(len(PNG))
    while head := file.read(8):
        length, name = struct.unpack(">I4s", head)
        if name == b"iTXt":
            data, (checksum,) = _read(file, length), struct.unpack(">I", file.read(4))
            if data.startswith(NAME + bytes(5)):
                if checksum != zlib.crc32(name + data):
                    raise ValueError("a wrong checksum")
                return data[len(NAME) + 5 :]
        else:
            file.seek(length + 4, os.SEEK_CUR)
    return None


# ---- EXR


def _in_exr(file: BinaryIO) -> bytes | None:
    file.seek(8)  # after the file's version
    while name := _word(file):
        kind, size = _word(file), struct.unpack("<I", file.read(4))[0]
        if (name, kind) == (NAME, b"string"):
            return _read(file, size)
        file.seek(size, os.SEEK_CUR)
    return None


def _word(file: BinaryIO) -> bytes:
    """Return the bytes up to the next 0."""
    word = b""
    while (byte := _read(file, 1)) != b"\0":
        word += byte
        if len(word) > 255:
            raise ValueError("its header has a name of more than 255 bytes")
    return word


# ---- GIF


def _in_gif(file: BinaryIO) -> bytes | None:
    head = _read(file, 13)
    if head[10] & 0x80:
        file.seek(3 << (head[10] & 0b111) + 1, os.SEEK_CUR)  # the table of colours
    while _read(file, 1) == b"!":  # what is before the first picture
        label, data = _read(file, 1), bytearray()
        while size := _read(file, 1)[0]:
            data += _read(file, size)
            if len(data) > MAX_BYTES + 2**10:
                raise ValueError("its comment is too long")
        if label == b"\xfe" and data.startswith(b"povgen record "):
            return bytes(data)
    return None


# ---- MP4, WebM and WebP


def into_movie(movie: Path, record: Record) -> None:
    """Write a record into a movie's file, at its end."""
    data = bytes(record)
    with movie.open("r+b") as file:
        if movie.suffix == ".webm":
            tag = _element(SIMPLE_TAG, _element(TAG_NAME, NAME.upper()) + _element(TAG_STRING, data))
            tags = _element(TAGS, _element(TAG, _element(TARGETS, b"") + tag))
            _, size = _element_head(file)
            file.seek(size, os.SEEK_CUR)
            _, size = _element_head(file)
            file.seek(-8, os.SEEK_CUR)
            file.write(_element_size(size + len(tags)))  # the Segment's: ffmpeg writes it with 8 bytes
        elif movie.suffix == ".webp":
            tags = WEBP_TYPE + struct.pack("<I", len(data)) + data + bytes(len(data) % 2)
            size = file.seek(0, os.SEEK_END) + len(tags) - 8
            file.seek(4)
            file.write(struct.pack("<I", size))
        else:
            tags = struct.pack(">I", 4 + len(MP4_TYPE) + len(data)) + MP4_TYPE + data
        file.seek(0, os.SEEK_END)
        file.write(tags)


def _in_mp4(file: BinaryIO) -> bytes | None:
    while head := file.read(8):
        size, kind = struct.unpack(">I4s", head)
        size -= 8
        if size == -7:  # a longer size follows
            size = struct.unpack(">Q", file.read(8))[0] - 16
        if kind == MP4_TYPE[:4] and size >= 16:
            size -= 16
            if _read(file, 16) == MP4_TYPE[4:]:
                return _read(file, size)
        if size < 0:  # the last box, or a damaged file
            return None
        file.seek(size, os.SEEK_CUR)
    return None


def webp_parts(file: BinaryIO) -> Iterator[tuple[bytes, int]]:
    """Yield the name and the size of each part of a WebP file. The file is then at the part's data.

    Raises struct.error or OSError if the file is damaged.
    """
    end = 8 + struct.unpack("<4sI4s", file.read(12))[1]
    if os.fstat(file.fileno()).st_size < end:
        raise OSError("it ends too early")
    start = 12
    while start < end:
        file.seek(start)
        name, size = struct.unpack("<4sI", file.read(8))
        yield name, size
        start += 8 + size + size % 2


def _in_webp(file: BinaryIO) -> bytes | None:
    return next((_read(file, size) for name, size in webp_parts(file) if name == WEBP_TYPE), None)


def _in_webm(file: BinaryIO) -> bytes | None:
    _, size = _element_head(file)
    file.seek(size, os.SEEK_CUR)
    kind, size = _element_head(file)
    if kind != SEGMENT:
        return None
    end = file.tell() + size
    while file.tell() < end:
        kind, size = _element_head(file)
        after = file.tell() + size
        if kind == SIMPLE_TAG:
            named, size = _element_head(file)
            if named == TAG_NAME and size == len(NAME) and _read(file, size) == NAME.upper():
                kind, size = _element_head(file)
                return _read(file, size) if kind == TAG_STRING else None
        if kind not in (TAGS, TAG):  # otherwise go on with what is in it
            file.seek(after)
    return None


def _element_head(file: BinaryIO) -> tuple[int, int]:
    """Return a WebM element's number and the size of what follows. Raises ValueError for one without these."""
    numbers = []
    for longest in (4, 8):
        first = _read(file, 1)[0]
        more = 8 - first.bit_length()  # as many bits before the first 1 as bytes follow
        if more >= longest:
            raise ValueError("an element with a wrong number")
        numbers.append(int.from_bytes(bytes([first]) + _read(file, more)))
    return numbers[0], numbers[1] - (1 << 7 * (more + 1))


def _element(kind: int, data: bytes) -> bytes:
    return kind.to_bytes((kind.bit_length() + 7) // 8) + _element_size(len(data)) + data


def _element_size(size: int) -> bytes:
    return (1 << 56 | size).to_bytes(8)
