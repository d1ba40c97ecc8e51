"""A card: a rectangle with a picture from a file."""

from typing import Annotated

from pydantic import BeforeValidator, Field

from povgen.inputs import pictures
from povgen.inputs.fields import PictureFile
from povgen.inputs.pictures import Picture
from povgen.objects.board import Board
from povgen.objects.placed import Length


class Card(Board):
    """A rectangle with a picture. Its height follows from the picture's proportions. Its place is the middle."""

    kind = "card"
    title = "picture"

    file: Annotated[PictureFile, BeforeValidator(pictures.card)] = Field(
        description="the picture's file: PNG, JPEG, WebP or TIFF"
    )
    width: Length = Field(default=1.5, description="width, 0.01 to 1000 tiles")

    @property
    def size(self) -> tuple[float, float]:
        return self.width, self.width * self.file.size[1] / self.file.size[0]

    @property
    def picture(self) -> Picture:
        found: Picture = self.file
        return found
