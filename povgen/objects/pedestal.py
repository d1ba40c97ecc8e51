"""A pedestal: a square block of stone with a base and a cap."""

from pydantic import Field

from povgen.objects.placed import Extent, Length
from povgen.objects.scene_object import SceneObject


class Pedestal(SceneObject):
    """A pedestal of stone. Its place is the middle of its foot."""

    kind = "pedestal"
    title = "pedestal"

    width: Length = Field(default=0.86, description="side of its square base and cap, 0.01 to 1000 tiles")
    height: Length = Field(default=0.8, description="height, 0.01 to 1000 tiles")

    declarations = ('{% include "pedestal.pov.j2" %}',)
    sdl = "object { Plinth({{ n }}Width/2, {{ n }}Height) }"
    glsl = """
float reach_pedestal(vec3 o, vec3 d, vec4 n, float most) {  // n: half the width, height
  vec2 around = boxed(o, d, vec3(-n.x, 0, -n.x), vec3(n.x, n.y, n.x));
  if (around.x > around.y || around.y < 0.0 || around.x > most) return most;
  float narrow = PlinthShaft(n.x), base = PlinthBase(n.y), cap = n.y - PlinthCap(n.y);
  most = reachOfBox(o, d, vec3(-n.x, 0, -n.x), vec3(n.x, base, n.x), most);
  most = reachOfBox(o, d, vec3(-narrow, base, -narrow), vec3(narrow, cap, narrow), most);
  return reachOfBox(o, d, vec3(-n.x, cap, -n.x), vec3(n.x, n.y, n.x), most);
}
vec3 normal_pedestal(vec3 p, vec4 n) {
  float base = PlinthBase(n.y), cap = n.y - PlinthCap(n.y), narrow = PlinthShaft(n.x), edge = 1e-4;
  bool shaft = p.y > base + edge && p.y < cap - edge;
  vec2 ends = shaft ? vec2(base, cap) : p.y < 0.5 * n.y ? vec2(0, base) : vec2(cap, n.y);
  float half_ = shaft ? narrow : n.x;
  return faceNormal(vec3(p.x / half_, (2.0 * p.y - ends.x - ends.y) / (ends.y - ends.x), p.z / half_));
}
Finish finish_pedestal(vec3 p, vec4 n, vec3 colour) { return PlinthTexture(p); }
"""

    @property
    def numbers(self) -> tuple[float, ...]:
        return self.width / 2, self.height

    @property
    def point(self) -> None:
        return None

    @property
    def box(self) -> Extent:
        half = self.width / 2
        return (-half, 0, -half), (half, self.height, half)
