"""What the live view is given: a scene's values."""

import base64
from typing import Any

from povgen.errors import InputError
from povgen.inputs.fields import rgb
from povgen.inputs.pictures import Picture, as_png
from povgen.scene import shader
from povgen.scene.scene import Scene
from povgen.scene.scenes import PEDESTAL_EDGE, Chess
from povgen.scene.survey import max_trace_level
from povgen.sheets.parameters import design_index
from povgen.sheets.profile import ProfileSheets


def values(scene: Scene) -> dict[str, Any]:
    """Return a scene's parameters for `LiveView` (povgen/liveview/view.js): tiles, degrees, colours 0 to 1 (sRGB).

    Raises InputError for what the live view cannot show.
    """
    if scene.fresnel:
        raise InputError("fresnel = true: the live view follows one ray a pixel, which does not split; allowed: false")
    if not all(sheet.is_exact for sheet in scene.sheets):
        raise InputError("error: the live view shows sheets that are built exactly; allowed: no errors of building")
    found = scene.model_dump() | {"name": scene.name, "rim": scene.rim, "faces": max_trace_level(scene)}
    for sheet, own in zip(scene.sheets, (found, *found["window"]), strict=True):
        if isinstance(sheet, ProfileSheets):  # the script does not read profiles
            shape = sheet.shape
            edges = [(*edge.start, *edge.end, edge.radius) for edge in shape.edges]
            own["profile"] = {"edges": edges, "half": shape.half, "index": shape.index, "gap": shape.gap}
        own["design_index"] = design_index(found | {name: value for name, value in own.items() if value is not None})
    found["pictures"] = {
        part: {"data": _data(picture), "tiles": picture.tiles, "mean": picture.mean}
        for part, picture in shader.surroundings(scene).items()
    }
    if isinstance(scene, Chess):
        colors = scene.color if isinstance(scene.color, tuple) else (scene.color,)
        found["color"] = [rgb(color) for color in colors]
        found["pedestal_halves"] = {str(piece.piece): piece.radius + PEDESTAL_EDGE for piece in scene.pieces}
    return found


def _data(picture: Picture) -> str:
    """Return the picture as a URL that contains it. A browser shows no light that is brighter than white."""
    return f"data:image/png;base64,{base64.b64encode(as_png(picture.file)).decode()}"
