"""A sphere."""

from pydantic import Field

from povgen.inputs.fields import Colour
from povgen.objects.placed import Extent, Length
from povgen.objects.scene_object import SceneObject, surface


class Sphere(SceneObject):
    """A sphere. Its place is its centre."""

    kind = "sphere"
    title = "sphere"

    radius: Length = Field(default=0.3, description="radius, 0.01 to 1000 tiles")
    color: Colour = Field(default="#d23b2b", description="colour: a name, or a code such as #c87529")

    sdl = f"sphere {{ 0, {{{{ n }}}}Radius {surface('each.colour')} }}"
    # n.y is the place in the colours of the scene `spheres`, or below 0
    glsl = """
float reach_sphere(vec3 o, vec3 d, vec4 n, float most) {
  float nearest = -dot(o, d);
  vec3 aside = o + nearest * d;
  float square = n.x * n.x - dot(aside, aside);
  float t = nearest - sqrt(max(square, 0.0));
  return square > 0.0 && t > 0.0 && t < most ? t : most;
}
vec3 normal_sphere(vec3 p, vec4 n) { return p / n.x; }
Finish finish_sphere(vec3 p, vec4 n, vec3 colour) { return PlainTexture(n.y < 0.0 ? srgb(colour) : SphereColor(n.y)); }
"""

    @property
    def numbers(self) -> tuple[float, ...]:
        return self.radius, -1

    @property
    def box(self) -> Extent:
        r = self.radius
        return (-r, -r, -r), (r, r, r)
