"""A new kind of object is one file: both renderers draw it, TOML, Python, captions and the ray files know it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import povgen
from povgen.scene.sdl import TEMPLATES
from povgen.scene.spec import MOVIES

CONE = '''
"""A cone."""

from pydantic import Field

from povgen.inputs.fields import Colour
from povgen.objects.placed import Extent, Length
from povgen.objects.scene_object import Parts, SceneObject, surface


class Cone(SceneObject):
    """A cone that stands on its base. Its place is the middle of the base."""

    kind = "cone"
    title = "cone"

    radius: Length = Field(default=0.5, description="radius of the base, 0.01 to 1000 tiles")
    height: Length = Field(default=1, description="height, 0.01 to 1000 tiles")
    color: Colour = Field(default="#3a9d5d", description="colour: a name, or a code such as #c87529")

    sdl = "cone { 0, {{ n }}Radius, {{ n }}Height*y, 0 " + surface("each.colour") + " }"
    glsl = """
float reach_cone(vec3 o, vec3 d, vec4 n, float most) {
  float k = n.x / n.y, found = most;
  k *= k;
  vec3 p = o - vec3(0, n.y, 0);
  float a = d.x * d.x + d.z * d.z - k * d.y * d.y, b = p.x * d.x + p.z * d.z - k * p.y * d.y;
  float root = b * b - a * (p.x * p.x + p.z * p.z - k * p.y * p.y);
  for (int side = -1; side <= 1 && root > 0.0; side += 2) {
    float t = (-b + float(side) * sqrt(root)) / a, y = o.y + t * d.y;
    if (t > 0.0 && t < found && y >= 0.0 && y <= n.y) found = t;
  }
  float base = -o.y / d.y;
  vec2 at = o.xz + base * d.xz;
  return base > 0.0 && base < found && dot(at, at) < n.x * n.x ? base : found;
}
vec3 normal_cone(vec3 p, vec4 n) {
  return p.y < 1e-4 ? vec3(0, -1, 0) : normalize(vec3(p.x, (n.y - p.y) * n.x * n.x / (n.y * n.y), p.z));
}
Finish finish_cone(vec3 p, vec4 n, vec3 colour) { return PlainTexture(srgb(colour)); }
"""

    def numbers(self, parts: Parts) -> tuple[float, float, float, float]:
        return self.radius, self.height, 0, 0

    @property
    def box(self) -> Extent:
        return (-self.radius, 0, -self.radius), (self.radius, self.height, self.radius)
'''
DRAWN = """
import json, sys
import numpy as np
from povgen import Room, live, render
from povgen.video.captions import captions
from povgen.settings import Rendering
cones = ["kind=cone,name=hat,x=-1,y=-0.6,z=2,pitch=20", "kind=cone,x=1.2,height=1.5"]
room = Room(window="alpha=60,x=-1.3,width=2.4", object=cones)
gl, pov = (render(room, size=(96, 72), antialias="off", renderer=name).astype(int) for name in ("gl", "povray"))
green = [int(((each[..., 1] > each[..., 0] + 25) & (each[..., 1] > each[..., 2] + 10)).sum()) for each in (gl, pov)]
live(room).save("room.html")
toml = "[[object]]\\nkind = 'cone'\\nname = 'hat'\\nheight = 2\\n"
open("cone.toml", "w").write(toml)
loaded = Room.load("cone.toml").with_numbers({"hat.height": 3}).things["hat"].height
said = str(captions([room], Rendering(caption="full")))
print(json.dumps([float((abs(gl - pov).max(-1) < 15).mean()), green, loaded, said]))
"""


def test_a_new_kind_of_object_is_one_file(tmp_path):
    shutil.copytree(Path(povgen.__file__).parent, tmp_path / "povgen", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in (TEMPLATES, MOVIES):
        shutil.copytree(folder, tmp_path / folder.name)
    (tmp_path / "povgen" / "objects" / "cone.py").write_text(CONE)
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", DRAWN], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert not done.returncode, done.stderr
    same, (gl, pov), height, said = json.loads(done.stdout.splitlines()[-1])
    assert same > 0.99 and gl > 150 and abs(gl - pov) < 20
    assert height == 3 and "cone" in said
    assert "reach_cone" in (tmp_path / "room.html").read_text()
    listed = subprocess.run(
        [sys.executable, "-m", "povgen", "frame", "room", "--object", "kind=cone,radius=0"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert listed.returncode == 2 and "radius = '0'" in listed.stderr
