"""A wide picture with texts: they are in a panel beside it, so that picture and panel together have the asked size."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from povgen.scene.presets import AxialScene
from povgen.scene.scene import Scene
from povgen.settings import Rendering
from povgen.video import overlay
from povgen.video.caption_strips import Colour, Item, strip
from povgen.video.caption_texts import Caption, captions
from povgen.video.text import STRIP

SHARE = 0.6  # of the whole width: the picture's
LINES = 12  # of a text, at most
LETTERS = 0.8  # of the side view, as a multiple of those below a picture of the same height
LARGEST = 1.3  # of the texts, likewise
FILLED = 0.85  # of the panel's height, at most, by texts that are larger than those below a picture

Bytes = NDArray[np.uint8]
Sketch = Callable[[int, int], Bytes]  # draws the side view for a width and for the height of a picture


def is_cut(scenes: Iterable[Scene], rendering: Rendering) -> bool:
    """Return whether nothing but surroundings is left out if the sides of these scenes' pictures are cut off.

    This is so if the first window and all objects, as the eye would see them without it, are in the middle part.
    """
    width, height = rendering.size

    def fits(scene: Scene) -> bool:
        if not isinstance(scene, AxialScene):
            return False
        half = SHARE * width / height * scene.view / 2
        sides = [(0j, 0.0, scene.aperture / 2)]
        sides += [(L, scene.places[-1] + z1, r) for (L, z1), r in zip(scene.objects, scene.radii, strict=True)]
        nearer = [(at, scene.z2 / (scene.z2 + z), radius) for at, z, radius in sides]
        return all(
            abs((scene.E + (at - scene.E) * scale - scene.middle).real) + radius * scale <= half
            for at, scale, radius in nearer
        )

    return all(map(fits, scenes))


def beside(
    picture: Bytes,
    scene: Scene,
    rendering: Rendering,
    caption: Caption | None,
    said: Sequence[tuple[str, Colour]],
    sketch: Sketch | None,
    cut: bool,
) -> Bytes:
    """Return the scene's picture with what `rendering` asks for: caption, side view and legend are at its right.

    If it is `cut`, the picture's middle part is shown, otherwise all of it, smaller, above the side view.
    """
    height, width, _ = picture.shape
    part = round(SHARE * width / 2) * 2
    shown = picture.copy()
    overlay.mark(shown, scene, rendering)
    texts = caption or captions([scene], rendering)[0]
    items = [Item(*pair) for pair in zip(texts.texts, texts.widest, strict=True)]
    keys = overlay.legend_items(said)
    if not items and not keys and not sketch:
        return shown
    if cut:
        left = shown[:, (width - part) // 2 :][:, :part]
    else:
        small = Image.fromarray(shown).resize((part, round(height * part / width)), Image.Resampling.LANCZOS)
        below = [sketch(part, round(LETTERS * height))] if sketch else []
        left, sketch = _column([np.asarray(small), *below], part, height), None
    size = LARGEST
    while True:
        above, legend = (
            [strip([item], width - part, height, size, LINES) for item in several] for several in (items, keys)
        )
        drawn = [sketch(width - part, round(LETTERS * height))] if sketch else []
        groups = [*above, *drawn, *legend]
        if sum(map(len, groups)) <= height * (FILLED if size > 1 else 1):
            return np.concatenate((left, _column(groups, width - part, height)), axis=1)
        size *= 0.95


def _column(parts: Sequence[Bytes], width: int, height: int) -> Bytes:
    """Return parts one below the other, with equal spaces."""
    made = np.full((height, width, 3), STRIP, np.uint8)
    space = (height - sum(map(len, parts))) / (len(parts) + 1)
    top = space
    for part in parts:
        made[round(top) : round(top) + len(part)] = part
        top += len(part) + space
    return made
