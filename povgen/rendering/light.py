"""Light as numbers: from sRGB bytes and back, reduced in size by averaging, and as the bytes of a frame."""

import zlib
from collections.abc import Iterable
from itertools import repeat
from math import isqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from povgen import remedies
from povgen.errors import InputError, TransientError
from povgen.inputs import hdr
from povgen.inputs.hdr import Light

Picture = NDArray[np.uint8]
STEP = 512  # `place` returns multiples of 1/STEP: these places are exact in 32-bit numbers in every tile of gl.py


def linear(picture: Picture) -> Light:
    """Return the light, 0 to 1, of sRGB bytes."""
    return hdr.linear(range(256))[picture]


def mixed(
    pictures: Iterable[NDArray[Any]],
    weights: Iterable[NDArray[Any]],
    shares: Iterable[NDArray[Any]] = repeat(np.ones(1)),
) -> NDArray[Any]:
    """Return the weighted sum of the light of pictures: sRGB bytes, or light. The result is of the same kind.

    A weight is a matrix (3, 3), by which red, green and blue are multiplied. A share (height, width, 1) multiplies each
    pixel. Bytes below black and above white do not exist; light can be both.
    """
    light: Light = np.zeros(1, np.float32)
    kind: np.dtype[Any] = light.dtype
    for picture, weight, share in zip(pictures, weights, shares, strict=False):
        kind = picture.dtype
        one = (linear(picture) if kind == np.uint8 else picture) @ weight.T.astype(np.float32)
        light = light + one * share.astype(np.float32)
    return hdr.as_bytes(light) if kind == np.uint8 else light


def reduced(picture: Picture, size: tuple[int, int]) -> Picture:
    """Return a picture, (height, width, 3) bytes, with fewer pixels. `size` is their number: width and height.

    Each new pixel is the weighted mean of the light around its middle, by `settings.FILTER`. Compared with the mean
    over the pixel alone (a box filter) this leaves less moire.
    """
    made = np.empty((size[1], size[0], 3), np.uint8)
    for colour in range(3):  # one after the other, so that large pictures need less memory
        made[..., colour] = hdr.encoded(_reduced(linear(picture[..., colour]), size)) + 0.5
    return made


def _reduced(light: Light, size: tuple[int, int]) -> Light:
    """Return one colour's light, (height, width), reduced in size as by `reduced`."""
    if (2 * light.shape[0], 2 * light.shape[1]) == (3 * size[1], 3 * size[0]):
        return _two_thirds(_two_thirds(light).T).T

    return np.asarray(Image.fromarray(light).resize(size, Image.Resampling.BILINEAR))


def _two_thirds(light: Light) -> Light:
    """Return light with two rows in place of three. Pillow's triangle is narrower here than `settings.FILTER`."""
    framed = np.pad(light, ((1, 1), (0, 0)), "edge")
    a, b, c, d, e = (framed[k : k + len(light) - 2 : 3] for k in range(5))  # each new row's neighbours, in their order
    pairs = np.stack(((3 * a + 7 * b + 5 * c + d) / 16, (b + 5 * c + 7 * d + 3 * e) / 16), axis=1)
    return np.asarray(pairs.reshape(-1, light.shape[1]), np.float32)


def reduce_file(path: Path, size: tuple[int, int]) -> None:
    """Replace a PNG file's picture with the reduced one, of this width and height. Leave a damaged file unchanged."""
    try:
        with Image.open(path, formats=["PNG"]) as image:
            picture = np.asarray(image)[..., :3]
    except (OSError, SyntaxError, ValueError):  # what Pillow raises
        return
    Image.fromarray(reduced(picture, size)).save(path, format="PNG")


def place(number: int, rays: int, wide_filter: bool) -> tuple[float, float]:
    """Return a ray's place in its pixel, (x, y) from the centre to the right and up, pixels. `number` is from 0.

    With the wide filter, `rays` is n * n, and the rays are on a square grid. Otherwise `rays` is n * n + 1, and this
    grid is rotated so that no two rays are in a row or in a column. This makes nearly horizontal and vertical edges
    smoother.
    """
    if wide_filter:
        n = side = isqrt(rays)
        at = number % side, number // side
    else:
        n, middle, rise = rays, rays // 2, isqrt(rays - 1)
        at = number, (middle + (number - middle) * rise) % rays
    x, y = (round(STEP * ((k + 0.5) / n - 0.5)) / STEP for k in at)
    return x, y


# ---- Frames of light: red, green and blue of each pixel, numbers of 32 bits, compressed by zlib, which adds a checksum


def packed(light: Light) -> bytes:
    """Return light, (height, width, 3), as the bytes of a frame."""
    return zlib.compress(np.ascontiguousarray(light, "<f4").data, 1)


def unpacked(frame: bytes, size: tuple[int, int]) -> Light:
    """Return the light, (height, width, 3), of a frame of this width and height. Raises ValueError if it is damaged."""
    width, height = size
    unpacker, count = zlib.decompressobj(), 12 * width * height
    try:
        numbers = unpacker.decompress(frame, count + 1)
    except zlib.error as error:
        raise ValueError(str(error)) from None
    if len(numbers) != count or not unpacker.eof or unpacker.unused_data:
        raise ValueError(f"{len(numbers)} bytes of light, of {count}")
    return np.frombuffer(numbers, "<f4").reshape(height, width, 3)


def exr() -> Any:  # noqa: ANN401  (a library without types)
    """Return the library that reads and writes EXR files. Raises InputError if it is not installed."""
    try:
        import OpenEXR
    except ImportError:
        raise InputError(
            f"bits: EXR files need OpenEXR, which is not installed: {remedies.extra('exr')}; allowed: bits = 8, with "
            "renderer = 'gl' also a PNG file with bits = 16"
        ) from None
    return OpenEXR


def from_exr(path: Path, size: tuple[int, int]) -> Path:
    """Write the light of POV-Ray's EXR file as a frame beside it, reduced to this width and height. Return its path.

    The light is not clipped before it is reduced. If the EXR file is damaged, its own path is returned. Whoever reads
    this as a frame finds that it is damaged. Raises InputError if OpenEXR is not installed.
    """
    try:
        light = _exr(path)
    except (KeyError, OSError, RuntimeError, ValueError):  # what OpenEXR raises
        return path
    return write(light, size, True, path.parent)


def _exr(path: Path) -> Light:
    with exr().File(str(path)) as file:
        return np.asarray(file.channels()["RGB"].pixels, np.float32)


def read(path: Path, size: tuple[int, int]) -> Light:
    """Return the light (height, width, 3) of POV-Ray's picture of this size: an EXR file, or a PPM file of 16 bits.

    Raises TransientError if the file is damaged.
    """
    try:
        if path.suffix == ".exr":
            return _exr(path)
        data, count = path.read_bytes(), 6 * size[0] * size[1]
        if not data[:-count].endswith(b"65535\n"):  # the end of the head
            raise ValueError
        return np.frombuffer(data[-count:], ">u2").reshape(size[1], size[0], 3).astype(np.float32) / np.float32(65535)
    except (KeyError, OSError, RuntimeError, ValueError):
        raise TransientError("the picture is not whole (is the disk full?)") from None


def write(light: Light, size: tuple[int, int], is_light: bool, folder: Path) -> Path:
    """Write light (height, width, 3), reduced to this width and height, as a frame in a folder. Return its path."""
    if light.shape[:2] != size[::-1]:
        light = np.stack([_reduced(light[..., colour], size) for colour in range(3)], axis=-1)
    if is_light:
        frame = folder / "frame.light"
        frame.write_bytes(packed(light))
        return frame
    picture = np.asarray(hdr.encoded(light.clip(0, 1)) + np.float32(0.5), np.uint8)
    Image.fromarray(picture).save(folder / "frame.png", format="PNG")
    return folder / "frame.png"


def as_16_bits(light: Light) -> NDArray[np.uint16]:
    """Return light in the encoding of sRGB, 0 to 65535. What is brighter than white is white."""
    return np.asarray(hdr.encoded(light.clip(0, 1)) * np.float32(65535 / 255) + np.float32(0.5), np.uint16)
