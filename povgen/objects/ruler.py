"""A ruler: a board with a mark for each tile."""

from functools import cached_property
from typing import Annotated

from PIL import Image, ImageDraw, ImageFont
from pydantic import Field

from povgen import fonts
from povgen.inputs.pictures import Picture
from povgen.objects.board import Board, as_picture

TILE = 160  # pixels of the picture in a tile
HEIGHT = 0.4  # tiles
MOST = 8192  # pixels along the picture: a longer ruler has fewer in a tile


class Ruler(Board):
    """A ruler along its x, with a long mark and a number at each tile, and a short mark at each tenth.

    Its place is the middle.
    """

    kind = "ruler"
    title = "ruler"

    length: Annotated[int, Field(ge=1, le=100)] = Field(default=4, description="length, 1 to 100 tiles")

    @property
    def size(self) -> tuple[float, float]:
        return self.length + HEIGHT / 2, HEIGHT

    @cached_property
    def picture(self) -> Picture:
        width, height = self.size
        tile = min(TILE, MOST / width)
        image = Image.new("RGB", (round(width * tile), round(height * tile)), "#f4e6b4")
        draw, first = ImageDraw.Draw(image), HEIGHT / 4 * tile
        font = ImageFont.truetype(fonts.TEXT, max(6, round(0.17 * tile)))
        for tenth in range(10 * self.length + 1):
            x, mark = first + tenth / 10 * tile, 0.16 if tenth % 10 == 0 else 0.11 if tenth % 5 == 0 else 0.07
            thick = max(1, round((0.02 if tenth % 10 == 0 else 0.01) * tile))
            draw.line([(x, 0), (x, mark * tile)], fill="#20242a", width=thick)
            if tenth % 10 == 0:
                draw.text((x, 0.36 * tile), str(tenth // 10), font=font, anchor="ms", fill="#20242a")
        return as_picture("ruler", image)
