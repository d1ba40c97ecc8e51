"""Rays through sheets of prisms or lenses, followed by the graphics library, with numbers of 32 bits."""

import json

import numpy as np

from povgen.files import temporary_folder
from povgen.optics.faces import Floats, Indices
from povgen.optics.opening import Opening
from povgen.optics.profile import Profile
from povgen.optics.trace import Rays
from povgen.rendering.gl_runner import Runner
from povgen.scene import shader
from povgen.scene.sdl import to_glsl

AT_ONCE = 1 << 20  # rays
TIMEOUT = 600.0  # seconds for so many


def follow(position: Floats, direction: Floats, window: Opening, most: Indices) -> Rays:
    """Follow rays through a window as `trace.trace` does, in its coordinates. The result does not have their faces.

    Raises ValueError for prisms or lenses that the shaders cannot show, and what `gl_runner.Runner.draw` raises.
    """
    sheets = window.sheet.glass
    lenses = [each.shape for each in sheets if isinstance(each.shape, Profile)]
    if any(each.facets or each.pitches for each in sheets) or any(shape.is_mismatched for shape in lenses):
        raise ValueError(
            "device = 'gl': follows rays through equal prisms and lenses of one pitch; allowed: device = 'numpy'"
        )
    defines, uniforms = shader.of_rays(window)
    head = "".join(f"#define {name} {value}\n" for name, value in defines.items())
    uniforms["maxFaces"] = int(np.max(most, initial=1))
    source = json.dumps({"shader": head + to_glsl("rays"), "uniforms": uniforms, "volumes": [], "pictures": {}})
    given = np.zeros((2, len(position), 4), "<f4")
    given[0, :, :3], given[0, :, 3], given[1, :, :3] = position, most, direction
    found = Rays.starting(position, direction, 0, len(sheets))
    with temporary_folder() as folder:
        for first in range(0, len(position), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            given[:, some].tofile(folder / "rays")
            Runner().draw(source, folder / "drawn", TIMEOUT, {"kind": "rays", "rays": str(folder / "rays")})
            where, way, path = np.fromfile(folder / "drawn", "<f4").reshape(3, -1, 4)
            found.position[some], found.end[some] = where[:, :3], where[:, 3]
            found.direction[some], found.count[some] = way[:, :3], way[:, 3]
            found.designed[some], found.orders[some] = path[:, 0] > 0, path[:, 1 : 1 + len(sheets)]
    return found
