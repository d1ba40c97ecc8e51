"""The fonts of captions, charts and the page: parts of Noto Sans, and of STIX for symbols (Fonts.txt)."""

import struct
import zlib
from base64 import b64encode
from pathlib import Path

TEXT, BOLD, SYMBOLS = (Path(__file__).with_name(name) for name in ("NotoSans.ttf", "NotoSans-Bold.ttf", "Symbols.otf"))

# the characters that TEXT and BOLD have, in a regular expression
LETTERS = " -~\u00a1-\u00ff\u0152\u0153\u0391-\u03a1\u03a3-\u03c9–—‘’‚‛“”„…′⁰ⁱ⁴-ⁿ₀-₎−"


def encoded() -> dict[str, str]:
    """Return the fonts as base64 of WOFF, by their names in a page's style sheet."""
    return {
        name: b64encode(woff(file.read_bytes())).decode()
        for name, file in (("text", TEXT), ("bold", BOLD), ("symbols", SYMBOLS))
    }


def woff(font: bytes) -> bytes:
    """Return a TrueType or OpenType font in the compressed format of web pages (W3C, WOFF 1.0)."""
    kind, count = struct.unpack_from(">4sH", font)
    entries, tables = b"", b""
    begin = 44 + 20 * count  # where the tables follow the header and the list of tables
    for number in range(count):
        tag, checksum, offset, length = struct.unpack_from(">4s3I", font, 12 + 16 * number)
        table = font[offset : offset + length]
        packed = min(zlib.compress(table, 9), table, key=len)
        entries += struct.pack(">4s4I", tag, begin + len(tables), len(packed), length, checksum)
        tables += packed + bytes(-len(packed) % 4)
    header = struct.pack(">4s4sI2HI2H5I", b"wOFF", kind, begin + len(tables), count, 0, len(font), 0, 0, *[0] * 5)
    return header + entries + tables
