"""The fonts of captions, charts and the page: parts of Noto Sans, and of STIX for symbols (Fonts.txt)."""

from base64 import b64encode
from pathlib import Path

TEXT, BOLD, SYMBOLS = (Path(__file__).with_name(name) for name in ("NotoSans.ttf", "NotoSans-Bold.ttf", "Symbols.otf"))


def encoded() -> dict[str, str]:
    """Return the fonts as base64, by their names in a page's style sheet."""
    return {
        name: b64encode(file.read_bytes()).decode()
        for name, file in (("text", TEXT), ("bold", BOLD), ("symbols", SYMBOLS))
    }
