"""What the live view is given: a scene's values."""

from typing import Any

from povgen.errors import InputError
from povgen.scene.models import PEDESTAL_EDGE, Chess, Scene, rgb
from povgen.scene.survey import max_trace_level


def values(scene: Scene) -> dict[str, Any]:
    """Return a scene's parameters for `LiveView` (templates/live/view.js): tiles, degrees, colours 0 to 1 (sRGB).

    Raises InputError for what the live view cannot show.
    """
    if scene.fresnel:
        raise InputError("fresnel = true: the live view follows one ray a pixel, which does not split; allowed: false")
    found = scene.model_dump() | {"name": scene.name, "rim": scene.rim, "faces": max_trace_level(scene)}
    if isinstance(scene, Chess):
        colors = scene.color if isinstance(scene.color, tuple) else (scene.color,)
        found["color"] = [rgb(color) for color in colors]
        found["pedestal_halves"] = {str(piece.piece): piece.radius + PEDESTAL_EDGE for piece in scene.pieces}
    return found
