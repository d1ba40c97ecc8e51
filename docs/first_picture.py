"""Make the README's first picture: two equal knights, one seen through the ideal sheet, for a full turn of alpha, and
one beside the window: `... -o FILE.webp`. Alpha stands below the picture.

It begins where the knight is turned, because where nothing moves the first frame is shown."""

import io
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from povgen import Chess, render
from povgen.video.caption_strips import Item, strip

SIZE = 800, 450  # pixels
FIRST, STEP, RATE = 90, 3, 15  # degrees, degrees a frame, frames a second
QUALITY = 52  # of the file, which is to be below 1.5 MB


def main(output: Path, alphas: Sequence[int]) -> None:
    twins: dict[str, Any] = {"piece": ("knight", "knight"), "x": (0, 3.3), "z1": (3, 3)}
    scenes = [Chess(sheet="ideal", alpha=alpha, **twins) for alpha in alphas]
    # of many rays a pixel: without noise, they take fewer bytes
    pictures = render(scenes, size=SIZE, renderer="gl", antialias="4x")
    texts = [Item(f"light is turned by α = {alpha}°", "light is turned by α = 000°") for alpha in alphas]
    below = [strip([text], *SIZE, larger=1.3) for text in texts]
    frames = np.stack([np.concatenate(parts) for parts in zip(pictures, below, strict=True)])
    output.write_bytes(animation(frames))


def animation(frames: NDArray[np.uint8]) -> bytes:
    """Return a WebP file (chunks as in Google's WebP Container Specification) of frames (n, height, width, 3).

    Each frame after the first has only the rectangle in which frames differ. Pillow's own animations keep pixels of
    the frame before where they are nearly alike, which looks like a grid.
    """
    moves = (frames != frames[0]).any((0, 3))
    (top, bottom), (left, right) = (np.flatnonzero(moves.any(axis))[[0, -1]].tolist() for axis in (1, 0))
    top, left = top // 2 * 2, left // 2 * 2  # offsets are stored as halves
    height, width = frames.shape[1:3]
    parts = [_chunk(b"VP8X", bytes([2, 0, 0, 0]) + _sizes(width, height)), _chunk(b"ANIM", bytes(6))]  # 2: animated
    for n, frame in enumerate(frames):
        y, x = (top, left) if n else (0, 0)
        part = frame[y : bottom + 1, x : right + 1] if n else frame
        with io.BytesIO() as file:
            Image.fromarray(part).save(file, "WEBP", quality=QUALITY, method=6)
            picture = file.getvalue()[12:]
        place = (x // 2).to_bytes(3, "little") + (y // 2).to_bytes(3, "little") + _sizes(*part.shape[1::-1])
        duration = round(1000 / RATE).to_bytes(3, "little")
        parts.append(_chunk(b"ANMF", place + duration + bytes([2]) + picture))  # 2: without blending
    return _chunk(b"RIFF", b"WEBP" + b"".join(parts))


def _sizes(width: int, height: int) -> bytes:
    return (width - 1).to_bytes(3, "little") + (height - 1).to_bytes(3, "little")


def _chunk(name: bytes, data: bytes) -> bytes:
    return name + len(data).to_bytes(4, "little") + data + bytes(len(data) % 2)


if __name__ == "__main__":
    main(Path(sys.argv[2]), [alpha % 360 for alpha in range(FIRST, FIRST + 360, STEP)])
