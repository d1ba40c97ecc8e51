"""Types of the fields of scenes, for pydantic: what a user may give, and its range."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, TypeVar

from PIL import ImageColor
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag

from povgen.inputs.pictures import Picture
from povgen.inputs.pieces import Piece, PieceFile, as_piece
from povgen.settings import as_size
from povgen.validation import Model, as_pair

T = TypeVar("T")
MAX_SIDE = 16384  # of a picture, pixels
Side = Annotated[int, Field(ge=1, le=MAX_SIDE)]
Z1 = Annotated[float, Field(gt=0, le=5000)]
MAX_ASIDE = 10  # tiles
Aside = Annotated[float, Field(ge=-MAX_ASIDE, le=MAX_ASIDE)]


def _listed(value: object) -> object:
    """Return an array or another collection as a list, but one of a single value as this value. Other values stay."""
    value = value.tolist() if hasattr(value, "tolist") else value  # numpy's
    if isinstance(value, Collection) and not isinstance(value, (str, bytes, Mapping)):
        value = list(value)
        return value[0] if len(value) == 1 else value
    return value


def _kind(value: object) -> str:
    return "several" if isinstance(value, (list, tuple)) else "one"


def as_tuple(value: T | tuple[T, ...]) -> tuple[T, ...]:
    return value if isinstance(value, tuple) else (value,)


def _piece(value: object) -> str | PieceFile:
    """Return a piece's name, or the `PieceFile` of its file. Raises ValueError for other values."""
    piece = as_piece(value)
    if not isinstance(piece, (str, PieceFile)):
        raise ValueError("should be a name or a file")
    return piece


def _colour(value: str) -> str:
    """Check a colour's name or code."""
    rgb(value)
    return value


def rgb(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue (sRGB, 0 to 1) of a colour's name or code. Raises ValueError for any other text."""
    try:
        parts = ImageColor.getrgb(colour)
        if len(parts) > 3 or max(parts) > 255:
            raise ValueError
    except ValueError:
        raise ValueError("should be a colour's name or code, and opaque") from None
    return parts[0] / 255, parts[1] / 255, parts[2] / 255


if TYPE_CHECKING:  # what is read; a user may give anything that becomes such a value, as an array or text
    Point = tuple[float, float] | Any
    OneOrMore: TypeAlias = T | tuple[T, ...] | Any
    PictureFile = Picture | Any
else:
    Point = Annotated[tuple[Aside, Aside], BeforeValidator(as_pair)]
    # one value, or one for each object
    OneOrMore = Annotated[
        Annotated[T, Tag("one")] | Annotated[tuple[T, ...], Field(min_length=1, max_length=50), Tag("several")],
        Discriminator(_kind),
        BeforeValidator(_listed),
    ]
    PictureFile = Picture
PieceValue = Annotated[Piece, BeforeValidator(_piece)]
Colour = Annotated[str, AfterValidator(_colour)]


class PictureSize(Model):
    """The size of a picture."""

    size: Annotated[tuple[Side, Side], BeforeValidator(as_size)] = Field(
        description=f"WIDTHxHEIGHT, whole numbers of pixels from 1 to {MAX_SIDE}"
    )
