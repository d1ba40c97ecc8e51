"""Pictures of light: Radiance files (.hdr) are read and written here, EXR files are read by `exr_reader`.

Light is linear, as (height, width, 3) float32 of red, green and blue. 1 is the white of a screen.
"""

import os
import re
import subprocess
import sys
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from povgen import remedies
from povgen.files import temporary_folder
from povgen.scene import exr_reader

if TYPE_CHECKING:  # numpy is slow to load
    import numpy as np
    from numpy.typing import NDArray

    Light = NDArray[np.float32]

HEAD = re.compile(rb"#\?[^\n]*\n((?:[^\n]+\n)*)\n-Y (\d{1,9}) \+X (\d{1,9})\n")
MAX_HEAD = 1 << 16  # bytes
PATIENCE = 120  # seconds
EXR = b"v/1\x01"
WHOLE = "should be a whole picture, Radiance (.hdr) or EXR"
MOST = 65504.0  # the greatest 16-bit floating-point number: the graphics card stores light as such numbers


def is_light(data: bytes) -> bool:
    """Return whether a file's content is that of a Radiance or an EXR file."""
    return data.startswith((b"#?", EXR))


def read(data: bytes) -> "Light":
    """Return the light in a Radiance or EXR file with this content.

    Values below 0 and NaN become 0, values above MOST become MOST. Raises ValueError for any other file, for too many
    pixels, and for an EXR file if OpenEXR is not installed.
    """
    import numpy as np

    light = (_exr if data.startswith(EXR) else _radiance)(data)
    return np.asarray(np.clip(np.nan_to_num(light, nan=0, posinf=MOST), 0, MOST), np.float32)


def written(light: "Light") -> bytes:
    """Return the Radiance file of light, with errors of up to 0.4 % of each pixel's greatest channel."""
    import numpy as np

    height, width, _ = light.shape
    fraction, exponent = np.frexp(light.max(-1))
    mantissas = np.floor(np.ldexp(light, 8 - exponent[..., None]))
    shared = np.where((fraction > 0) & (exponent > -128), exponent + 128, 0)  # 0: black
    pixels = np.dstack([mantissas * (shared > 0)[..., None], shared]).astype(np.uint8)
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    return head.encode() + pixels.tobytes()


def _exr(data: bytes) -> "NDArray[Any]":
    import numpy as np

    path = [str(Path(__file__).parents[2]), *filter(None, sys.path)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path), "OPENBLAS_NUM_THREADS": "1"}
    with temporary_folder() as folder:
        (folder / "own.exr").write_bytes(data)
        command = [sys.executable, "-P", "-m", "povgen.scene.exr_reader", str(folder / "own.exr")]
        try:
            done = subprocess.run(command, capture_output=True, timeout=PATIENCE, cwd="/", env=environment)
        except subprocess.TimeoutExpired:
            raise ValueError(f"should be a picture that is read within {PATIENCE} s") from None
    if done.returncode == exr_reader.NO_OPENEXR:
        raise ValueError(f"needs OpenEXR, which is not installed: {remedies.extra('exr')}")
    if done.returncode == exr_reader.NO_COLOURS:
        raise ValueError("should be an EXR file with the channels R, G and B")
    if done.returncode == exr_reader.TOO_LARGE:
        raise ValueError(f"should be a picture of at most {exr_reader.MAX_PIXELS} pixels")
    if done.returncode:
        raise ValueError(WHOLE)
    return np.asarray(np.load(BytesIO(done.stdout.partition(b"\0")[2]), allow_pickle=False))


def _radiance(data: bytes) -> "NDArray[Any]":
    import numpy as np

    head = HEAD.match(data[:MAX_HEAD])
    if not head or b"FORMAT=32-bit_rle_rgbe" not in head[1].splitlines():
        raise ValueError("should be a Radiance file of red, green and blue, stored from the upper left")
    height, width = int(head[2]), int(head[3])
    if width * height > exr_reader.MAX_PIXELS:
        raise ValueError(f"should be a picture of at most {exr_reader.MAX_PIXELS} pixels")
    at = head.end()
    if 8 <= width < 1 << 15 and data[at : at + 4] == bytes((2, 2, width >> 8, width & 255)):
        rows = bytearray()
        for _ in range(height):
            at = _row(data, at, width, rows)
        pixels = np.frombuffer(rows, np.uint8).reshape(height, 4, width).transpose(0, 2, 1)
    else:
        if len(data) - at < 4 * width * height:
            raise ValueError(WHOLE)
        pixels = np.frombuffer(data, np.uint8, 4 * width * height, at).reshape(height, width, 4)
        if (pixels[..., :3] == 1).all(-1).any():
            raise ValueError("should be a Radiance file without the run lengths of before 1991")
    # m stands for numbers from m to m + 1, and is read as m + 0.5, as in the program Radiance and in POV-Ray
    light = np.ldexp(pixels[..., :3].astype(np.float32) + 0.5, pixels[..., 3:].astype(np.int32) - 136)
    return np.where(pixels[..., 3:] > 0, light, 0)


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
