"""A thin board with a picture on the side that faces -z, towards the eye: a card, a text or a ruler."""

from functools import lru_cache
from hashlib import sha256
from io import BytesIO
from typing import ClassVar

import numpy as np
from PIL.Image import Image, new
from PIL.Image import open as open_image

from povgen.inputs import pictures
from povgen.inputs.hdr import linear
from povgen.inputs.pictures import File, Picture
from povgen.objects.placed import Extent
from povgen.objects.scene_object import SceneObject
from povgen.optics.pose import Floats

THICKNESS = 0.02  # tiles


class Board(SceneObject):
    """A thin board with a picture. Its place is the middle of the picture."""

    drawn_as: ClassVar[str] = "board"
    point_is = "lower edge"  # a mark there covers nothing
    sdl = """union {
  box { <-{{ n }}Width/2, -{{ n }}Height/2, 0>, <{{ n }}Width/2, {{ n }}Height/2, 0.001>
    pigment {
      image_map { png "{{ each.picture.file.name }}" gamma srgb interpolate 2 }
      translate <-0.5, -0.5, 0>
      scale <{{ n }}Width, {{ n }}Height, 1>
    }
    finish { {{ materials.finish("card") }} }
  }
  box { <-{{ n }}Width/2, -{{ n }}Height/2, 0.001>, <{{ n }}Width/2, {{ n }}Height/2, {{ n }}Depth>
    pigment { rgb <{{ materials.CARD_BACK }}> }
    finish { {{ materials.finish("card") }} }
  }
}"""
    glsl = """
#ifdef CARDS
uniform sampler2D cardPictures;   // all pictures, one above the other
uniform vec4 cardPlace[CARDS];    // of each: left and upper edge, width and height, as parts of the whole
// n: half the width and height, thickness, number of the picture
float reach_board(vec3 o, vec3 d, vec4 n, float most) {
  return reachOfBox(o, d, vec3(-n.xy, 0), n.xyz, most);
}
vec3 normal_board(vec3 p, vec4 n) { return faceNormal(vec3(p.xy / n.xy, 2.0 * p.z / n.z - 1.0)); }
Finish finish_board(vec3 p, vec4 n, vec3 colour) {
  vec4 place = cardPlace[int(n.w)];
  vec2 at = vec2(0.5, -0.5) * p.xy / n.xy + 0.5;
  bool front = p.z < 0.05 * n.z && max(abs(p.x) / n.x, abs(p.y) / n.y) < 1.0;
  return CardTexture(front ? textureLod(cardPictures, place.xy + at * place.zw, 0.0).rgb : CARD_BACK);
}
#endif
"""

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, tiles."""
        raise NotImplementedError

    @property
    def lengths(self) -> dict[str, float]:
        return {"width": self.size[0], "height": self.size[1], "depth": THICKNESS}

    @property
    def numbers(self) -> tuple[float, ...]:
        width, height = self.size
        return width / 2, height / 2, THICKNESS

    @property
    def point(self) -> Floats:
        return np.asarray(self.pose.place - self.size[1] / 2 * self.pose.axes[1])

    @property
    def box(self) -> Extent:
        x, y = (side / 2 for side in self.size)
        return (-x, -y, 0), (x, y, THICKNESS)


LARGEST = 8192  # pixels: the side of a picture that graphics libraries take


@lru_cache(maxsize=4)  # a movie's frames have the same pictures
def stacked(several: tuple[Picture, ...]) -> File:
    """Return a file with several pictures, one above the other, the first one at the top."""
    images: list[Image] = [open_image(BytesIO(each.file.content), formats=["PNG"]) for each in several]
    high, wide = sum(image.height for image in images), max(image.width for image in images)
    if (scale := LARGEST / max(high, wide)) < 1:
        sizes = [[max(1, int(scale * side)) for side in image.size] for image in images]
        images = [image.resize(size) for image, size in zip(images, sizes, strict=True)]
    whole = new("RGB", (max(image.width for image in images), sum(image.height for image in images)))
    top = 0
    for image in images:
        whole.paste(image, (0, top))
        top += image.height
    return _file(whole)


def _file(image: Image) -> File:
    png = BytesIO()
    image.save(png, "png")
    return pictures.kept(f"picture-{sha256(png.getvalue()).hexdigest()}.png", png.getvalue())


def as_picture(name: str, image: Image) -> Picture:
    """Return a picture that povgen has drawn, as if it were from a file of this name."""
    red, green, blue = linear(range(256))[np.asarray(image)].mean((0, 1)).tolist()
    return Picture(name, _file(image), image.size, (red, green, blue))
