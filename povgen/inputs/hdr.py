"""Linear light: Radiance files (.hdr) are read and written here; colours are converted from and to sRGB.

Light is (height, width, 3) float32 of red, green and blue. 1 is the white of a screen.
"""

import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen.errors import shown

Light = NDArray[np.float32]

RGBE = b"32-bit_rle_rgbe"
MARK = b"#?"  # of a Radiance file, at its start
HEAD = re.compile(rb"#\?[^\n]*\n((?:[^\n]+\n)*)\n *([+-])([XY]) +(\d{1,9}) +([+-])([XY]) +(\d{1,9}) *\n")
MAX_HEAD = 1 << 16  # bytes
MAX_PIXELS = 1 << 25
WHOLE = "should be a whole Radiance file"
MOST = 65504.0  # the greatest 16-bit floating-point number: the graphics card stores light as such numbers
SRGB = 0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329  # chromaticities: x and y of red, green, blue and white
# from XYZ to the responses of the eye's cones by which Bradford's method adapts light to another white
BRADFORD = (0.8951, 0.2664, -0.1614), (-0.7502, 1.7135, 0.0367), (0.0389, -0.0685, 1.0296)


def read(data: bytes) -> "Light":
    """Return the light in a Radiance file with this content, as `clipped` does.

    EXPOSURE and COLORCORR change nothing: they say by what the stored light has been multiplied. Raises ValueError for
    any other file and for too many pixels.
    """
    head = HEAD.match(data[:MAX_HEAD])
    if not head or head[3] == head[6]:
        raise ValueError(WHOLE)
    stated = dict(line.split(b"=", 1) for line in head[1].splitlines() if b"=" in line)
    if (kind := stated.get(b"FORMAT", RGBE).strip()) != RGBE:
        raise ValueError(
            f"should be a Radiance file of red, green and blue ({RGBE.decode()}), not {shown(kind.decode())}"
        )
    rows, width = int(head[4]), int(head[7])
    if rows * width > MAX_PIXELS:
        raise ValueError(f"should be a picture of at most {MAX_PIXELS} pixels")
    at = head.end()
    if 8 <= width < 1 << 15 and data[at : at + 4] == bytes((2, 2, width >> 8, width & 255)):
        unpacked = bytearray()
        for _ in range(rows):
            at = _row(data, at, width, unpacked)
        pixels = np.frombuffer(unpacked, np.uint8).reshape(rows, 4, width).transpose(0, 2, 1)
    else:
        if len(data) < at + 4 * rows * width:
            raise ValueError(f"{WHOLE}, without run lengths of before 1991")
        pixels = np.frombuffer(data, np.uint8, 4 * rows * width, at).reshape(rows, width, 4)
    # -Y +X: rows from the upper left to the right. +X -Y: columns.
    y, x = head[2], head[5]
    if head[3] == b"X":
        pixels, y, x = pixels.swapaxes(0, 1), x, y
    pixels = pixels[:: 1 if y == b"-" else -1, :: 1 if x == b"+" else -1]
    # m stands for numbers from m to m + 1, and is read as m + 0.5, as in the program Radiance and in POV-Ray
    light = pixels[..., :3].astype(np.float32)
    light += 0.5
    np.ldexp(light, pixels[..., 3:].astype(np.int32) - 136, out=light)
    light *= pixels[..., 3:] > 0
    primaries = stated.get(b"PRIMARIES")
    return clipped(light, SRGB if primaries is None else [float(number) for number in primaries.split()])


def clipped(light: "Light", chromaticities: Sequence[float]) -> "Light":
    """Return linear light of these chromaticities as that of sRGB, from 0 to MOST. NaN becomes 0. `light` changes."""
    light = converted(np.nan_to_num(light, copy=False, nan=0, posinf=MOST, neginf=0), chromaticities)
    return np.clip(light, 0, MOST, out=light)


def converted(light: "Light", chromaticities: Sequence[float]) -> "Light":
    """Return linear light of these chromaticities as that of sRGB, which can be below 0. White stays white.

    Chromaticities are as in SRGB. Another white is adapted by Bradford's method. Raises ValueError for those of no
    colours.
    """
    if np.shape(chromaticities) == np.shape(SRGB) and np.allclose(chromaticities, SRGB, atol=1e-4):
        return light
    try:
        to_xyz, white = _to_xyz(chromaticities)
        from_xyz, own_white = _to_xyz(SRGB)
        cones = np.array(BRADFORD)
        adapted = np.linalg.solve(cones, (cones @ own_white / (cones @ white))[:, None] * cones)
        matrix = np.linalg.solve(from_xyz, adapted @ to_xyz)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        matrix = np.array(np.nan)
    if not np.isfinite(matrix).all():
        raise ValueError(f"should state the chromaticities of colours, not {shown(tuple(chromaticities))}")
    return light @ matrix.T.astype(np.float32)


def _to_xyz(chromaticities: Sequence[float]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the matrix from linear light of these chromaticities to XYZ, and the white's XYZ, whose Y is 1."""
    x, y = np.reshape(chromaticities, (4, 2)).T
    columns = np.array([x, y, 1 - x - y])
    with np.errstate(all="ignore"):
        white = columns[:, 3] / y[3]
    return columns[:, :3] * np.linalg.solve(columns[:, :3], white), white


def linear(encoded: Iterable[int]) -> "Light":
    """Return the light, 0 to 1, of sRGB bytes."""
    share = np.asarray(encoded, np.float32) / 255
    return np.asarray(np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4), np.float32)


def encoded(light: NDArray[Any]) -> "Light":
    """Return light, 0 to 1, in the encoding of sRGB, 0 to 255."""
    return np.asarray(255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055), np.float32)


def as_bytes(light: NDArray[Any]) -> NDArray[np.uint8]:
    """Return light as sRGB bytes. Light brighter than white becomes white, and below 0 black."""
    return (encoded(light.clip(0, 1)) + 0.5).astype(np.uint8)


def written(light: "Light") -> bytes:
    """Return the Radiance file of light, with errors of up to 0.4 % of each pixel's greatest channel."""
    height, width, _ = light.shape
    fraction, exponent = np.frexp(light.max(-1))
    pixels = np.empty((height, width, 4), np.uint8)
    pixels[..., 3] = np.where((fraction > 0) & (exponent > -128), exponent + 128, 0)  # 0: black
    pixels[..., :3] = np.ldexp(light, 8 - exponent[..., None]) * (pixels[..., 3:] > 0)
    return b"#?RADIANCE\nFORMAT=%s\n\n-Y %d +X %d\n" % (RGBE, height, width) + pixels.tobytes()


def _row(data: bytes, at: int, width: int, rows: bytearray) -> int:
    """Add a row of four channels, each in run lengths, and return where it ends."""
    if data[at : at + 4] != bytes((2, 2, width >> 8, width & 255)):
        raise ValueError(WHOLE)
    at += 4
    for _ in range(4):
        end = len(rows) + width
        while len(rows) < end:
            code = data[at] if at + 1 < len(data) else 0
            if code > 128:
                rows += data[at + 1 : at + 2] * (code - 128)
                at += 2
            else:
                rows += data[at + 1 : at + 1 + code]
                at += 1 + code
            if not code or at > len(data) or len(rows) > end:
                raise ValueError(WHOLE)
    return at
