"""From sRGB bytes to light and back, and pictures reduced in size by averaging light."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Light = NDArray[np.float32]


def linear(picture: Picture) -> Light:
    """Return the light, 0 to 1, of sRGB bytes."""
    encoded = np.arange(256, dtype=np.float32) / 255
    light = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return np.asarray(light, np.float32)[picture]


def encoded(light: Light) -> Light:
    """Return light, 0 to 1, in the encoding of sRGB, 0 to 255."""
    return np.asarray(255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055), np.float32)


def reduced(picture: Picture, size: tuple[int, int]) -> Picture:
    """Return a picture, (height, width, 3) bytes, with fewer pixels. `size` is their number: width and height.

    Each new pixel is the weighted mean of the light around its middle. The weight falls linearly to 0 one new pixel
    away (a triangle filter). Compared with the mean over the pixel alone (a box filter) this leaves less moire.
    """
    from PIL import Image

    made = np.empty((size[1], size[0], 3), np.uint8)
    for colour in range(3):  # one after the other, so that large pictures need less memory
        light = Image.fromarray(linear(picture[..., colour])).resize(size, Image.Resampling.BILINEAR)
        made[..., colour] = encoded(np.asarray(light)) + 0.5
    return made


def reduce_file(path: Path, size: tuple[int, int]) -> None:
    """Replace a PNG file's picture with the reduced one. Leave a damaged file as it is, for its reader to find."""
    from PIL import Image

    try:
        with Image.open(path, formats=["PNG"]) as image:
            picture = np.asarray(image)[..., :3]
    except (OSError, SyntaxError, ValueError):  # what Pillow raises
        return
    Image.fromarray(reduced(picture, size)).save(path, format="PNG")
