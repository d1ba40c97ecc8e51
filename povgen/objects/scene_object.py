"""The base class of objects. A subclass is a kind of object, and says all that is particular to it.

An object has coordinates of its own: x right, y up and z away from the eye, from its place, in tiles. The texts in
POV-Ray's language (SDL) and in GLSL describe it in these coordinates. Colours are sRGB, 0 to 1.
"""

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from pydantic import SerializerFunctionWrapHandler, model_serializer

from povgen.inputs.fields import rgb
from povgen.inputs.pictures import Picture
from povgen.inputs.pieces import PieceFile
from povgen.objects.placed import Placed
from povgen.optics.pose import Floats


class SceneObject(Placed):
    """An object, with what its file says about it."""

    kind: ClassVar[str]
    drawn_as: ClassVar[str] = ""  # KIND in the names of the functions in GLSL, if it is not `kind`
    title: ClassVar[str]  # what it is, in a few words
    point_is: ClassVar[str] = "middle"  # what `point` is
    # Jinja templates: what the text for POV-Ray declares before the object, and the object itself, without its place.
    # `each` is the object, and `n` begins the names of its parameters.
    declarations: ClassVar[Sequence[str]] = ()
    sdl: ClassVar[str]
    # Functions of GLSL. `n` are the object's `numbers`, o and d a ray's origin and unit direction, p a point of the
    # surface: float reach_KIND(o, d, n, most), how far along the ray the surface is, or `most`;
    # vec3 normal_KIND(p, n), the normal, outwards; Finish finish_KIND(p, n, colour), the material.
    glsl: ClassVar[str]

    @model_serializer(mode="wrap")
    def _with_kind(self, fields: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {"kind": self.kind, **fields(self)}

    @property
    def numbers(self) -> tuple[float, ...]:
        """The numbers that the functions in GLSL need, up to four.

        That of the distance field of `shape`, or of `picture` on a board, follows them.
        """
        return ()

    @property
    def called(self) -> str:
        """What it is, in a word, for captions."""
        return self.kind

    @property
    def point(self) -> Floats | None:
        """The point whose image is predicted, (3,) in the scene's coordinates, tiles. None: no prediction is needed."""
        return np.asarray(self.pose.place + np.mean(self.box, axis=0) @ self.pose.axes)

    @property
    def lengths(self) -> dict[str, float]:
        """The lengths that `sdl` uses, in tiles, by their names."""
        own = (name for name in type(self).model_fields if name not in Placed.model_fields)
        return {name: value for name in own if isinstance(value := getattr(self, name), (int, float))}

    @property
    def colour(self) -> tuple[float, float, float]:
        """Red, green and blue (sRGB), 0 to 1."""
        return rgb(getattr(self, "color", "black"))

    @property
    def shape(self) -> "str | PieceFile | None":
        """The chess piece, or the file of one, whose distance field a shader needs."""
        return None

    @property
    def picture(self) -> Picture | None:
        """The picture on it."""
        return None


def surface(color: str) -> str:
    """Return the texture of a plain, somewhat glossy surface, as a Jinja template in POV-Ray's language."""
    return (
        f'pigment {{ srgb <{{{{ "%.4g, %.4g, %.4g" % {color} }}}}> }} finish {{ {{{{ materials.finish("sphere") }}}} }}'
    )
