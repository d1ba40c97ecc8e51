"""What the graphics library draws of a scene: shaders and numbers, as text."""

import json
from collections.abc import Mapping

from povgen.rendering.volumes import GRID, Volume
from povgen.scene import shader
from povgen.scene.laws import to_live
from povgen.scene.presets import pieces
from povgen.scene.scene import Scene
from povgen.scene.sdl import to_glsl
from povgen.scene.survey import Survey


def to_text(
    scene: Scene,
    shapes: Mapping[str, Volume],
    found: Survey | None = None,
    shader_name: str = "picture",
    clipped: bool = True,
) -> str:
    """Return all that `gl.Drawer` draws of a scene, as JSON. `shapes` has the distance field of every piece.

    `found` is the scene's survey; without it, rays are traced. The shader `readout` is for `gl.Drawer.readout`.
    If the light is clipped, no ray is brighter than white.
    """
    fields = {name: shapes[name] for name in pieces(scene)}
    names, places = [*fields], [field.place for field in fields.values()]
    defines = shader.defines(scene, names, GRID) | ({} if clipped else {"UNCLIPPED": 1})
    head = "".join(f"#define {name} {value}\n" for name, value in defines.items())
    return json.dumps(
        {
            "shader": head + to_glsl(shader_name, to_live([scene])),
            "share": to_glsl("share"),
            "display": to_glsl("display"),
            "uniforms": shader.uniforms(scene, names, places, found),
            "volumes": [field._asdict() for field in fields.values()],
            "grid": GRID,
            "pictures": {part: file.name for part, file in shader.pictures(scene).items()},
        }
    )
