"""The floor: a chessboard without end, or a picture of which copies cover it."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from povgen.inputs import pictures
from povgen.inputs.fields import PictureFile
from povgen.inputs.pictures import Picture
from povgen.objects.placed import Extent
from povgen.objects.scene_object import SceneObject


class Floor(SceneObject):
    """The floor, a horizontal plane. Of its place only y matters, and it has no turns."""

    kind = "floor"
    title = "floor"

    file: Annotated[PictureFile | Literal["tiles"], BeforeValidator(pictures.floor)] = Field(
        default="tiles",
        description="tiles, or a picture's file, of which copies cover the floor, 2 tiles wide or as "
        "wood.jpg,width=4 says",
    )

    # both renderers draw the floor by themselves: it has no end, and it fades into haze
    sdl = '{% include "floor.pov.j2" %}'
    glsl = ""

    @property
    def picture(self) -> Picture | None:
        return self.file if isinstance(self.file, Picture) else None

    @property
    def point(self) -> None:
        return None

    @property
    def box(self) -> Extent:
        """A floor takes no room: it is checked otherwise."""
        return (0, 0, 0), (0, 0, 0)
