"""A box."""

from pydantic import Field

from povgen.inputs.fields import Colour
from povgen.objects.placed import Extent, Length
from povgen.objects.scene_object import SceneObject, surface


class Box(SceneObject):
    """A box. Its place is its centre."""

    kind = "box"
    title = "box"

    width: Length = Field(default=1, description="extent along its x, 0.01 to 1000 tiles")
    height: Length = Field(default=1, description="extent along its y, 0.01 to 1000 tiles")
    depth: Length = Field(default=1, description="extent along its z, 0.01 to 1000 tiles")
    color: Colour = Field(default="#3f6fb0", description="colour: a name, or a code such as #c87529")

    sdl = (
        "box { -<{{ n }}Width, {{ n }}Height, {{ n }}Depth>/2, <{{ n }}Width, {{ n }}Height, {{ n }}Depth>/2 "
        + surface("each.colour")
        + " }"
    )
    glsl = """
float reach_box(vec3 o, vec3 d, vec4 n, float most) {
  vec2 reach = boxed(o, d, -n.xyz, n.xyz);
  return reach.x < reach.y && reach.x > 0.0 && reach.x < most ? reach.x : most;
}
vec3 normal_box(vec3 p, vec4 n) { return faceNormal(p / n.xyz); }
Finish finish_box(vec3 p, vec4 n, vec3 colour) { return PlainTexture(srgb(colour)); }
"""

    @property
    def numbers(self) -> tuple[float, ...]:
        return self.width / 2, self.height / 2, self.depth / 2

    @property
    def box(self) -> Extent:
        x, y, z = self.numbers
        return (-x, -y, -z), (x, y, z)
