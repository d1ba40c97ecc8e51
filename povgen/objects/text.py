"""A text on a board."""

from functools import cached_property
from typing import Annotated

from PIL import Image, ImageDraw, ImageFont
from pydantic import Field

from povgen import fonts
from povgen.inputs.fields import Colour, rgb
from povgen.inputs.pictures import Picture
from povgen.objects.board import Board, as_picture
from povgen.objects.placed import Length

LETTER = 96  # height of a line in the picture, pixels
MARGIN = 0.25  # around the text, in heights of a line


class Text(Board):
    """A text of one line, on a board. Its place is the middle."""

    kind = "text"
    title = "text"

    text: Annotated[str, Field(pattern=f"^[{fonts.LETTERS}]{{1,60}}$")] = Field(
        default="R", description="the text, up to 60 characters: A to ÿ, Œ, œ, Greek without accents, signs"
    )
    height: Length = Field(default=0.6, description="height of the board, 0.01 to 1000 tiles; its width follows")
    color: Colour = Field(default="#20242a", description="colour of the letters: a name, or a code such as #c87529")
    background: Colour = Field(default="#f4efe2", description="colour of the board: a name, or a code")

    @property
    def size(self) -> tuple[float, float]:
        width, height = self.picture.size
        return self.height * width / height, self.height

    @cached_property
    def picture(self) -> Picture:
        return written(self.text, self.color, self.background)


def written(text: str, color: str, background: str) -> Picture:
    """Return the picture of a text."""
    font, edge = ImageFont.truetype(fonts.BOLD, LETTER), round(MARGIN * LETTER)
    back, ink = ([round(255 * part) for part in rgb(each)] for each in (background, color))
    image = Image.new("RGB", (round(font.getlength(text)) + 2 * edge, LETTER + 2 * edge), tuple(back))
    ImageDraw.Draw(image).text((edge, edge + 0.82 * LETTER), text, font=font, anchor="ls", fill=tuple(ink))
    return as_picture("text", image)
