"""Pictures from a user's files: of the surroundings, and of the floor.

povgen decodes a file and writes a new one: PNG, or Radiance (.hdr) of a picture of light. The renderers read only this
one, never the user's.
"""

import hashlib
import os
import re
from dataclasses import field
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import model_serializer
from pydantic.dataclasses import dataclass

from povgen.files import read_bytes
from povgen.scene import hdr

if TYPE_CHECKING:
    from PIL import Image

FORMATS = ("PNG", "JPEG", "WEBP", "TIFF")
MAX_BYTES = 10**8  # of a file
MAX_SIZE = (8192, 4096)  # pixels
WIDTH = 2.0  # of a copy of the floor's picture, tiles
NAME = re.compile(r"picture-[0-9a-f]{64}\.(?:png|hdr)")
_content: dict[str, bytes] = {}  # of the new files, by their names: a scene's text has the names only


@dataclass(frozen=True)
class Picture:
    """A picture from a file. `name` is the name of the new file, with a hash of its content; `used` returns it."""

    path: str
    name: str = field(repr=False)
    size: tuple[int, int] = field(repr=False)  # width and height, pixels
    # the mean colour: red, green and blue of linear light; 1 is white, and a picture of light can have more
    mean: tuple[float, float, float] = field(repr=False)
    options: str = ""  # as the user wrote them
    width: float = field(default=WIDTH, repr=False)  # of the floor's picture, tiles

    def __getstate__(self) -> dict[str, object]:
        return {**vars(self), "content": _content[self.name]}

    def __setstate__(self, state: dict[str, Any]) -> None:
        know({state["name"]: state.pop("content")})
        vars(self).update(state)

    @property
    def is_light(self) -> bool:
        """Whether the new file is a Radiance file, of light that can be brighter than white."""
        return self.name.endswith(".hdr")

    @property
    def tiles(self) -> tuple[float, float]:
        """Width and height of the floor's picture, tiles."""
        return self.width, self.width * self.size[1] / self.size[0]

    @model_serializer
    def __str__(self) -> str:
        return f"{self.path}{self.options}".encode(errors="backslashreplace").decode()


def sky(value: object, data: bytes | None = None) -> Picture | None:
    """Return the picture of the surroundings in the file with the path `value`. None and a `Picture` stay as they are.

    The text "mountains" gives None: mountains and sky of povgen's own. `data` is the file's content; if it is None, the
    file is read. Raises ValueError for a file that is no picture, and for a picture that is not twice as wide as high.
    """
    if value is None or isinstance(value, Picture):
        return value
    if value == "mountains":
        return None
    picture = _picture(_path(value), "", WIDTH, data)
    width, height = picture.size
    if abs(width - 2 * height) > 0.02 * width:
        raise ValueError(f"should be twice as wide as high (equirectangular), not {width}x{height} pixels")
    return picture


def floor(value: object, data: bytes | None = None) -> Picture | str:
    """Return the floor's picture in a file that `value` names, such as wood.jpg or wood.jpg,width=4.

    The texts "tiles" and "none", and a `Picture`, stay as they are. `data` is the file's content; if it is None, the
    file is read. Raises ValueError for a file that is no picture, for a picture of light, and for a width out of range.
    """
    if isinstance(value, Picture) or isinstance(value, str) and value in ("tiles", "none"):
        return value
    path, comma, text = _path(value).rpartition(",width=")
    try:
        width = float(text) if comma else WIDTH
    except ValueError:
        width = 0
    if not 0.1 <= width <= 1000:
        raise ValueError(f"should have a width from 0.1 to 1000 tiles, not width={text}")
    picture = _picture(*((path, f"{comma}{text}") if comma else (text, "")), width, data)
    if picture.is_light:
        raise ValueError(f"should be a picture of colours: {', '.join(FORMATS)}")
    return picture


def _path(value: object) -> str:
    if not isinstance(value, (str, Path)):
        raise ValueError("should be a picture's file")
    return os.path.expanduser(str(value))


def used(text: str) -> dict[str, bytes]:
    """Return the new files that a scene's text names."""
    return {name: _content[name] for name in dict.fromkeys(NAME.findall(text)) if name in _content}


def know(files: dict[str, bytes]) -> None:
    """Add new files that another process made."""
    _content.update(files)


def _picture(path: str, options: str, width: float, data: bytes | None) -> Picture:
    name, size, mean = _decoded(read_bytes(path, MAX_BYTES) if data is None else data)
    return Picture(path, name, size, mean, options, width)


@lru_cache(maxsize=2)  # a movie's frames have the same sky and floor
def _decoded(data: bytes) -> tuple[str, tuple[int, int], tuple[float, float, float]]:
    """Make the new file of a picture; keep it in memory. Return its name, its size in pixels, and the mean colour."""
    if hdr.is_light(data):
        file = hdr.written(hdr.read(data))
        stored = hdr.read(file)
        _check_size(stored.shape[1::-1])
        red, green, blue = stored.mean((0, 1), float).tolist()
        return _named(file, "hdr"), stored.shape[1::-1], (red, green, blue)
    from PIL import Image

    try:
        with Image.open(BytesIO(data), formats=FORMATS) as opened:
            _check_size((max(opened.size), min(opened.size)))  # before Exif data turn it
            image: Image.Image = opened
            if opened.mode.startswith("I;16") or (opened.mode, opened.format) == ("I", "PNG"):
                # 16 bits: convert("RGB") would cut the numbers at 255
                image = opened.convert("I").point(lambda grey: grey * (1 / 257) + 0.5)
            elif opened.mode in ("I", "F"):
                raise ValueError("should be a picture of 8 or 16 bits; for light: .hdr or .exr")
            image = _upright(image).convert("RGB")
            _check_size(image.size)
    except ValueError as error:
        if str(error).startswith("should "):
            raise
        raise ValueError("should be a whole picture") from None
    except (OSError, SyntaxError, EOFError, MemoryError, ArithmeticError, LookupError, Image.DecompressionBombError):
        raise ValueError(f"should be a whole picture: {', '.join(FORMATS)}") from None
    counts, light = image.histogram(), [_linear(k / 255) for k in range(256)]
    pixels = image.width * image.height
    red, green, blue = (sum(x * n for x, n in zip(light, counts[k : k + 256], strict=True)) for k in (0, 256, 512))
    png = BytesIO()
    image.save(png, "png", compress_level=3)
    name = _named(png.getvalue(), "png", image.tobytes() + repr(image.size).encode())
    return name, image.size, (red / pixels, green / pixels, blue / pixels)


def _upright(image: "Image.Image") -> "Image.Image":
    """Return a picture turned as its Exif data say."""
    from PIL import ImageOps

    try:
        return ImageOps.exif_transpose(image)
    except Exception:  # of any kind, for damaged Exif data
        return image


def _check_size(size: tuple[int, ...]) -> None:
    """Raise ValueError for a picture, width and height in pixels, that is too small or too large."""
    if min(size) < 2 or size[0] > MAX_SIZE[0] or size[1] > MAX_SIZE[1]:
        most, given = ("{}x{}".format(*pixels) for pixels in (MAX_SIZE, size))
        raise ValueError(f"should be a picture of 2x2 to {most} pixels, not {given}")


def _named(file: bytes, ending: str, content: bytes = b"") -> str:
    """Keep a new file, and return its name. `content` is what decides the name, if it is not the whole file."""
    name = f"picture-{hashlib.sha256(content or file).hexdigest()}.{ending}"
    _content[name] = file
    return name


def as_png(name: str) -> bytes:
    """Return the content of the new file with this name, as PNG. Light brighter than white becomes white."""
    if not name.endswith(".hdr"):
        return _content[name]
    import numpy as np
    from PIL import Image

    light = hdr.read(_content[name]).clip(0, 1)
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    png = BytesIO()
    Image.fromarray(np.uint8(255 * encoded + 0.5)).save(png, "png")
    return png.getvalue()


def _linear(value: float) -> float:
    """Return the linear light of an sRGB value, both 0 to 1."""
    return float(value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4)
