"""Make the README's first picture, a full turn of alpha, through prisms and the ideal sheet: `... -o FILE.webp`.

It begins where the knight is turned, because where nothing moves the first frame is shown."""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from povgen import Chess, render
from povgen.settings import Rendering
from povgen.video import encode
from povgen.video.captions import Caption
from povgen.video.overlay import annotated

SIZE = 640, 450  # pixels; the caption adds 30 rows
FIRST, STEP, RATE = 64, 4, 20  # degrees, degrees a frame, frames a second


def frames(sheet: str, alphas: Sequence[int]) -> list[np.ndarray]:
    """Return the pictures through these sheets, of many rays a pixel: without noise, they take fewer bytes."""
    scenes = [Chess(sheet=sheet, prisms=88, view=3.5, alpha=alpha) for alpha in alphas]
    return render(scenes, size=SIZE, renderer="gl", antialias="4x")


def joined(prisms: np.ndarray, ideal: np.ndarray, alpha: float) -> np.ndarray:
    """Return the left half of one picture, a line in the window, and the right half of the other, with the caption."""
    middle, scene = SIZE[0] // 2, Chess(view=3.5)
    picture = np.concatenate((prisms[:, :middle], ideal[:, middle:]), axis=1)
    reach = round(scene.aperture / scene.view * SIZE[1] / 2)
    picture[SIZE[1] // 2 - reach : SIZE[1] // 2 + reach, middle - 1 : middle + 1] = 255
    names = "prisms", "ideal sheet"
    texts, widest = ([names[0], f"rays turned by {angle}°", names[1]] for angle in (alpha, 356))
    caption = Caption(texts, widest)
    return annotated(picture, scene, Rendering(size=SIZE, caption="short"), caption)


def main(output: Path, alphas: Sequence[int]) -> None:
    pairs = zip(frames("detailed", alphas), frames("ideal", alphas), alphas, strict=True)
    encode.encode((joined(*pair) for pair in pairs), output, RATE, {}, webp_quality=50)


if __name__ == "__main__":
    main(Path(sys.argv[2]), [alpha % 360 for alpha in range(FIRST, FIRST + 360, STEP)])
