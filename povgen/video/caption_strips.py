"""Draw the strips with texts above and below a picture: the legend and the caption."""

import re
from functools import lru_cache
from itertools import combinations, islice, pairwise
from math import ceil
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from povgen.video.text import LEGIBLE, MAX_TEXT, STRIP, TEXT, text_width, write

HALO = (255, 255, 255, 210)  # red, green, blue, opacity: the pale edge of lines and marks
MARGIN = 0.015  # at each side of a strip of text, as a fraction of the picture's width
LINES = 4  # of a strip of text, at most
SAMPLE = 1.7  # width of a dot or line in a strip with the space after it, in units of the text's height
GAP = 1.4  # between two texts of a strip, in units of the text's height
FINER = 3  # discs are drawn this many times as large, and reduced
ROWS = 270  # rows of a picture whose discs are drawn at a time, so that large pictures need little additional memory

Colour = tuple[int, int, int, int]
Complexes = NDArray[np.complex128]


class Item(NamedTuple):
    """A text, and the widest text that can stand there: its width is reserved. A line or a dot can precede it."""

    text: str
    widest: str
    colour: Colour | None = None
    dot: bool = False


def _broken(item: Item, most: float, size: float) -> list[Item]:
    """Return an item's lines. They are at most as wide as `most`, in units of the text's height, if no word is wider.

    The lines of all frames of a movie break after the same words: `Caption.widest` has the widest of each word. They
    are about equally wide.
    """
    width = most - SAMPLE * bool(item.colour)
    if text_width(item.widest, size) <= width:
        return [item]
    every = [_wrapped(item.widest, share * width, size) for share in np.linspace(1, 0.4, 25)]
    lines = [each for each in every if len(each) == len(every[0])][-1]
    if len(_words(item.text)) == len(_words(item.widest)):
        words = iter(_words(item.text))
        texts = [" ".join(islice(words, len(line))) for line in lines]
        texts[-1] = " ".join(filter(None, [texts[-1], *words]))
    else:  # another note
        texts = [" ".join(line) for line in _wrapped(item.text, width, size)]
        texts[len(lines) - 1 :] = [" ".join(texts[len(lines) - 1 :])]
        texts += [""] * (len(lines) - len(texts))
    colours = [item.colour, *[None] * (len(lines) - 1)]
    pairs = zip(texts, map(" ".join, lines), colours, strict=True)
    return [item._replace(text=text, widest=widest, colour=colour) for text, widest, colour in pairs]


def _words(text: str) -> list[str]:
    """Return the words of a text. No line breaks at an equals sign."""
    return re.split("(?<!=) (?!=)", text)


def _wrapped(text: str, width: float, size: float) -> list[list[str]]:
    """Return the words of a text in lines that are at most so wide, if no word is wider."""
    lines: list[list[str]] = [[]]
    for word in _words(text):
        if lines[-1] and text_width(" ".join([*lines[-1], word]), size) > width:
            lines.append([])
        lines[-1].append(word)
    return lines


@lru_cache(16)  # all frames of a movie have the same
def _rows(widths: tuple[float, ...], most: float, most_lines: int) -> tuple[list[range], float]:
    """Divide items into lines. Return the numbers, from 0, of each line's items, and the width of the longest line.

    `widths` are those of the items, each with the gap after it. There are as few lines as possible with lines no wider
    than `most`, but at most `most_lines`. The items are divided so that the longest line is as short as possible.
    """
    for lines in range(1, min(most_lines, len(widths)) + 1):
        starts = ([*places, len(widths)] for places in combinations(range(1, len(widths)), lines - 1))
        every = ([range(a, b) for a, b in pairwise([0, *places])] for places in starts)
        widest, rows = min(
            ((max(sum(widths[n] for n in row) for row in way) - GAP, way) for way in every), key=itemgetter(0)
        )
        if widest <= most:
            break
    return rows, widest


def strip(items: list[Item], width: int, height: int, larger: float = 1, most: int = LINES) -> NDArray[np.uint8]:
    """Return a strip with items for a picture of this size, in 1 to `most` lines; without items, a strip without rows.

    The text's height is a fraction of the picture's height, times `larger`. In small pictures this fraction is greater,
    so that the text stays legible. An item that is wider than the picture is broken between words. If the items do not
    fit, the text is made smaller.
    """
    if not items:
        return np.empty((0, width, 3), np.uint8)
    size = larger * max(TEXT * height, min(LEGIBLE, MAX_TEXT * height))
    free = (1 - 2 * MARGIN) * width
    whole = items
    while True:
        several = [_broken(item, free / size, size) for item in whole]
        items = [part for parts in several for part in parts]
        # the widths of items, each with the gap after it, in units of the text's height
        widths = [text_width(item.widest, size) + SAMPLE * bool(item.colour) + GAP for item in items]
        # a part of a broken text has a line of its own
        whole_lines = [len(parts) > 1 for parts in several for _ in parts]
        needed = (max(wide, alone * free / size) for wide, alone in zip(widths, whole_lines, strict=True))
        rows, widest = _rows(tuple(needed), free / size, most)
        if widest <= free / size:
            break
        size *= 0.95  # smaller text breaks at other words
    step = 2 * ceil(0.8 * size)  # even, because a movie stores pixels in blocks of 2x2
    image = Image.new("RGB", (width, len(rows) * step), STRIP)
    draw = ImageDraw.Draw(image)
    samples = []
    for line, row in enumerate(rows):
        place, middle = (width - size * (np.take(widths, row).sum() - GAP)) / 2, (line + 0.5) * step
        for n in row:
            colour = items[n].colour
            if colour:
                samples.append((place + size * np.linspace(0.2, SAMPLE - 0.6, 60) + 1j * middle, colour, items[n].dot))
            left = place + size * SAMPLE * bool(colour)
            if whole_lines[n]:  # it can be another text than the widest
                left += size * (text_width(items[n].widest, size) - text_width(items[n].text, size)) / 2
            write(draw, left, middle, items[n].text, size)
            place += size * widths[n]
    strip = np.array(image)
    for points, colour, dot in samples:
        for radius, colour_ in ((0.24, HALO), (0.15, colour)):
            discs(strip, points.mean(keepdims=True) if dot else points, radius * size * (1.3 if dot else 0.8), colour_)
    return strip


def discs(picture: NDArray[np.uint8], points: Complexes, radius: float, colour: Colour) -> None:
    """Blend a colour over discs. Their centres x + iy and their radius are in pixels.

    For smooth edges they are drawn FINER times as large, and reduced.
    """
    reach = radius + 1
    for top in range(0, len(picture), ROWS):
        some = points[abs(points.imag - top - ROWS / 2) < ROWS / 2 + reach]
        if not len(some):
            continue
        left, right = (max(0, int(end)) for end in (some.real.min() - reach, some.real.max() + reach + 1))
        part = picture[top : top + ROWS, left:right]
        if not part.size:
            continue
        mask = Image.new("L", (FINER * part.shape[1], FINER * len(part)))
        draw = ImageDraw.Draw(mask)
        half = FINER * radius * (1 + 1j)
        for centre in FINER * (some - complex(left, top) + 0.5 + 0.5j):
            low, high = centre - half, centre + half - 1 - 1j
            draw.ellipse([round(x) for x in (low.real, low.imag, high.real, high.imag)], fill=colour[3])
        image = Image.fromarray(part)
        image.paste(colour[:3], mask=mask.reduce(FINER))
        part[:] = np.asarray(image)
