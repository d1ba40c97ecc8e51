"""Make the README's first picture, a full turn of alpha, through prisms and the ideal sheet: `... -o FILE.webp`.

It begins where the knight is turned, because where nothing moves the first frame is shown."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from povgen import Chess, render
from povgen.settings import Rendering
from povgen.video.captions import Caption
from povgen.video.overlay import annotated
from povgen.video.text import text_width, write

SIZE = 640, 450  # pixels; the caption adds 30 rows
LETTERS = 20  # height of the names on the picture, pixels
FIRST, STEP, RATE = 64, 4, 20  # degrees, degrees a frame, frames a second


def frames(sheet: str, alphas: Sequence[int]) -> list[np.ndarray]:
    """Return the pictures through these sheets, of many rays a pixel: without noise, they take fewer bytes."""
    scenes = [Chess(sheet=sheet, prisms=88, view=3.5, alpha=alpha) for alpha in alphas]
    return render(scenes, size=SIZE, renderer="gl", antialias="4x")


def joined(prisms: np.ndarray, ideal: np.ndarray, alpha: float) -> np.ndarray:
    """Return the left part of one picture, a line in the window, and the right part of the other, with the caption.

    The line moves once to and fro over the knight in a turn. The names of both parts stand beside it.
    """
    scene = Chess(view=3.5)
    reach = round(scene.aperture / scene.view * SIZE[1] / 2)
    border = SIZE[0] // 2 + round(0.1 * reach * np.sin(np.radians(alpha - FIRST)))
    top = SIZE[1] // 2 - reach
    picture = np.concatenate((prisms[:, :border], ideal[:, border:]), axis=1)
    picture[top : SIZE[1] // 2 + reach, border - 1 : border + 1] = 255
    image = Image.fromarray(picture)
    names = "prisms", "ideal sheet"
    for name, x in zip(names, (border - 8 - LETTERS * text_width(names[0]), border + 8), strict=True):
        write(ImageDraw.Draw(image), x, top + 16, name, LETTERS, edge=2)
    texts, widest = ([f"rays turned by {angle}°"] for angle in (alpha, 356))
    return annotated(np.asarray(image), scene, Rendering(size=SIZE, caption="short"), Caption(texts, widest))


def main(output: Path, alphas: Sequence[int]) -> None:
    pairs = zip(frames("detailed", alphas), frames("ideal", alphas), alphas, strict=True)
    first, *others = (Image.fromarray(joined(*pair)) for pair in pairs)
    # without the blocks that ffmpeg's encoder leaves in the sky at this size of the file, which is to be below 2 MB
    look: dict[str, Any] = {"quality": 45, "method": 6, "duration": 1000 // RATE, "loop": 0}
    first.save(output, save_all=True, append_images=others, **look)


if __name__ == "__main__":
    main(Path(sys.argv[2]), [alpha % 360 for alpha in range(FIRST, FIRST + 360, STEP)])
