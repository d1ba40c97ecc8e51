"""Text on pictures: the fonts of its words and symbols, its width, and writing it."""

import re
from functools import lru_cache
from typing import Any

from PIL import ImageDraw, ImageFont

from povgen import fonts

DARK = (20, 20, 20)  # red, green, blue of letters with a white edge
STRIP = (24, 26, 30)  # red, green, blue behind text
# Height of text, as a fraction of the picture's height. In a small picture it is higher, to be at least LEGIBLE pixels
# high, but not higher than MAX_TEXT.
TEXT, MAX_TEXT, LEGIBLE = 0.041, 0.05, 12
FONTS = {"text": fonts.TEXT, "symbol": fonts.SYMBOLS}
SYMBOL_SIZE = 1.2  # the symbols' letters are larger, because they are low for their size
# A symbol is a Greek letter, or a Latin letter that is no part of a word or a name, but neither A nor a. Its subscript
# is text.
SYMBOL = re.compile("(?<![\\w'’-])([B-Zb-zα-ω])(?![^\\W₀-₉²³¹]|['’][^\\Ws]|-)")


def _runs(text: str) -> list[tuple[str, str]]:
    """Return the parts of a text, each with its font. A hyphen before a digit is a minus sign."""
    parts = SYMBOL.split(re.sub(r"(?<!\w)-(?=\d)", "–", text))
    return [(part, "symbol" if n % 2 else "text") for n, part in enumerate(parts) if part]


@lru_cache(maxsize=4096)
def text_width(text: str, size: float = 100) -> float:
    """Return the width of a text of this height, pixels, in units of its height.

    Small letters are wider or narrower, because they are fitted to the grid of pixels.
    """
    return sum(_font(size, font).getlength(part) for part, font in _runs(text)) / size


def write(
    draw: ImageDraw.ImageDraw, x: float, middle: float, text: str, size: float, edge: float = 0, dark: bool = True
) -> None:
    """Write a text in white. x is its left edge, `middle` the middle of its letters' height, `size` its height.

    All are in pixels. If `edge` is not 0, the text is dark, with a white edge of this width; or, if it is not `dark`,
    white with an edge like the strip behind texts.
    """
    colours: dict[str, Any] = {"fill": "white"}
    if edge:
        colours = {"fill": DARK if dark else "white", "stroke_width": edge, "stroke_fill": "white" if dark else STRIP}
    for part, font in _runs(text):
        draw.text((x, middle + 0.36 * size), part, font=_font(size, font), anchor="ls", **colours)
        x += _font(size, font).getlength(part)  # the grid of pixels makes letters wider or narrower at each size


def _font(size: float, name: str = "text") -> ImageFont.FreeTypeFont:
    # with the basic layout, places of letters do not depend on whether Pillow has Raqm
    larger = SYMBOL_SIZE if name == "symbol" else 1
    return ImageFont.truetype(str(FONTS[name]), size * larger, layout_engine=ImageFont.Layout.BASIC)
