"""Pictures from a user's files: of the surroundings, and of the floor.

povgen decodes a file and writes a new one: PNG, or Radiance (.hdr) of a picture of light. The renderers read only this
one, never the user's.
"""

import base64
import dataclasses
import os
import re
from collections.abc import Callable
from dataclasses import field
from functools import cache, lru_cache
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from weakref import WeakValueDictionary

from PIL import Image
from pydantic import model_serializer
from pydantic.dataclasses import dataclass

from povgen.files import read_bytes
from povgen.inputs import hdr, readers
from povgen.inputs.picture_reader import FORMATS
from povgen.record import held

MAX_BYTES = 10**8  # of a file
WIDTH = 2.0  # of a copy of the floor's picture, tiles
MOUNTAINS = Path(__file__).with_name("mountains.jpg")  # `make povgen/inputs/mountains.jpg` computes it
NAME = re.compile(r"picture-[0-9a-f]{64}\.(?:png|hdr|jpg)|rays-[0-9a-f]{64}\.inc")


@dataclasses.dataclass(frozen=True, eq=False)
class File:
    """The new file of a picture, which renderers read. `kept` makes one for each name, which has the content's hash."""

    name: str
    content: bytes

    def __reduce__(self) -> "tuple[Callable[[str, bytes], File], tuple[str, bytes]]":
        return kept, (self.name, self.content)


# by their names, which are all that a scene's text has; as long as something else refers to them
_files: WeakValueDictionary[str, File] = WeakValueDictionary()


def kept(name: str, content: bytes) -> File:
    """Return the new file with this name. As long as something refers to it, `used` returns its content."""
    return _files.setdefault(name, File(name, content))


@dataclass(frozen=True)
class Picture:
    """A picture from a file. `file` is the new file."""

    path: str
    file: File = field(repr=False)
    size: tuple[int, int] = field(repr=False)  # width and height, pixels
    # the mean colour: red, green and blue of linear light; 1 is white, and a picture of light can have more
    mean: tuple[float, float, float] = field(repr=False)
    options: str = ""  # as the user wrote them
    width: float = field(default=WIDTH, repr=False)  # of the floor's picture, tiles

    @property
    def is_light(self) -> bool:
        """Whether the new file is a Radiance file, of light that can be brighter than white."""
        return self.file.name.endswith(".hdr")

    @property
    def tiles(self) -> tuple[float, float]:
        """Width and height of the floor's picture, tiles."""
        return self.width, self.width * self.size[1] / self.size[0]

    @model_serializer
    def __str__(self) -> str:
        return f"{self.path}{self.options}".encode(errors="backslashreplace").decode()


@cache
def mountains() -> File:
    """Return the panorama of povgen's own mountains."""
    content = MOUNTAINS.read_bytes()
    return kept(f"picture-{sha256(content).hexdigest()}.jpg", content)


def sky(value: object) -> Picture | None:
    """Return the picture of the surroundings in the file with the path `value`. None and a `Picture` stay as they are.

    The text "mountains" gives None: mountains and sky of povgen's own. Raises ValueError for a file that is no picture,
    and for a picture that is not twice as wide as high.
    """
    if value is None or isinstance(value, Picture):
        return value
    if value == "mountains":
        return None
    picture = _picture(_path(value), "", WIDTH)
    width, height = picture.size
    if abs(width - 2 * height) > 0.02 * width:
        raise ValueError(f"should be twice as wide as high (equirectangular), not {width}x{height} pixels")
    return picture


def floor(value: object) -> Picture | str:
    """Return the floor's picture in a file that `value` names, such as wood.jpg or wood.jpg,width=4.

    The texts "tiles" and "none", and a `Picture`, stay as they are. Raises ValueError for a file that is no
    picture, for a picture of light, and for a width out of range.
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
    picture = _picture(*((path, f"{comma}{text}") if comma else (text, "")), width)
    if picture.is_light:
        raise ValueError(f"should be a picture of colours: {', '.join(FORMATS)}")
    return picture


def card(value: object) -> Picture:
    """Return the picture in a file. Raises ValueError for a file that is no picture, and for a picture of light."""
    found = value if isinstance(value, Picture) else _picture(_path(value), "", WIDTH)
    if found.is_light:
        raise ValueError(f"should be a picture of colours: {', '.join(FORMATS)}")
    return found


def _path(value: object) -> str:
    if not isinstance(value, (str, Path)):
        raise ValueError("should be a picture's file")
    return os.path.expanduser(str(value))


def used(text: str) -> dict[str, bytes]:
    """Return the new files that a scene's text names: their contents, by their names."""
    names = dict.fromkeys(NAME.findall(text))
    if names:
        mountains()  # the text may come from another process
    return {name: _files[name].content for name in names if name in _files}


def _picture(path: str, options: str, width: float) -> Picture:
    file, size, mean = held(f"{path}{options}", _recorded) or _decoded(read_bytes(path, MAX_BYTES))
    return Picture(path, file, size, mean, options, width)


def _recorded(name: str, text: str) -> tuple[File, tuple[int, int], tuple[float, float, float]]:  # noqa: ARG001
    return _decoded(base64.b64decode(text))


@lru_cache(maxsize=2)  # a movie's frames have the same sky and floor
def _decoded(data: bytes) -> tuple[File, tuple[int, int], tuple[float, float, float]]:
    """Return the new file of a picture, its size in pixels, and the mean colour."""
    answer, content = readers.run("picture_reader", "picture", data)
    width, height = answer["size"]
    red, green, blue = answer["mean"]
    return kept(answer["name"], content), (width, height), (red, green, blue)


def as_png(file: File) -> bytes:
    """Return a new file's content as PNG. Light brighter than white becomes white."""
    if not file.name.endswith(".hdr"):
        return file.content

    png = BytesIO()
    Image.fromarray(hdr.as_bytes(hdr.read(file.content))).save(png, "png")
    return png.getvalue()
