"""Make the README's first picture: two equal knights, one seen through the ideal sheet, for a full turn of alpha, and
one beside the window: `... -o FILE.webp`. Alpha stands below the picture.

It begins where the knight is turned, because where nothing moves the first frame is shown."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from povgen import Chess, render
from povgen.video.overlay import Item, strip

SIZE = 800, 450  # pixels
FIRST, STEP, RATE = 90, 3, 15  # degrees, degrees a frame, frames a second
QUALITY = 41  # of the file, which is to be below 1.5 MB


def main(output: Path, alphas: Sequence[int]) -> None:
    twins: dict[str, Any] = {"piece": ("knight", "knight"), "x": (0, 3.3), "z1": (3, 3)}
    scenes = [Chess(sheet="ideal", alpha=alpha, **twins) for alpha in alphas]
    # of many rays a pixel: without noise, they take fewer bytes
    pictures = render(scenes, size=SIZE, renderer="gl", antialias="4x")
    texts = [Item(f"α = {alpha}°, ideal sheet", "α = 000°, ideal sheet") for alpha in alphas]
    below = [strip([text], *SIZE, larger=1.3) for text in texts]
    first, *others = (Image.fromarray(np.concatenate(parts)) for parts in zip(pictures, below, strict=True))
    # without the blocks that ffmpeg's encoder leaves in the sky at this size of the file
    look: dict[str, Any] = {"quality": QUALITY, "method": 6, "duration": round(1000 / RATE), "loop": 0}
    first.save(output, save_all=True, append_images=others, **look)


if __name__ == "__main__":
    main(Path(sys.argv[2]), [alpha % 360 for alpha in range(FIRST, FIRST + 360, STEP)])
