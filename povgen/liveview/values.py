"""What the live view is given: a scene's values."""

import base64
from typing import Any

from povgen.errors import InputError
from povgen.inputs.fields import rgb
from povgen.inputs.pictures import File, as_png
from povgen.optics.opening import Opening
from povgen.scene import shader
from povgen.scene.presets import PEDESTAL_EDGE, AxialScene, pieces
from povgen.scene.pupil import inverse_focus
from povgen.scene.room import Room
from povgen.scene.scene import Scene
from povgen.scene.survey import max_trace_level
from povgen.scene.white import WHITE
from povgen.sheets.parameters import design_index
from povgen.sheets.profile import ProfileSheets
from povgen.sheets.sheet import Sheet


def values(scene: Scene) -> dict[str, Any]:
    """Return a scene's parameters for `LiveView` (povgen/liveview/view.js): tiles, degrees, colours 0 to 1 (sRGB).

    Raises InputError for what the live view cannot show.
    """
    if scene.fresnel:
        raise InputError("fresnel = true: the live view follows one ray a pixel, which does not split; allowed: false")
    if not all(sheet.is_exact for sheet in scene.sheets):
        raise InputError("error: the live view shows sheets that are built exactly; allowed: no errors of building")
    if scene.polarised:
        raise InputError("polariser, analyser: the live view has none; allowed: none")
    if scene.wavelength == WHITE:
        raise InputError(f"wavelength = {WHITE}: the live view shows one; allowed: a number of nm")
    found = _preset(scene) if isinstance(scene, AxialScene) else _room(scene)
    about: dict[str, dict[str, Any]] = {"cards": {"places": shader.cards(scene).places}}
    about |= {part: {"tiles": each.tiles, "mean": each.mean} for part, each in shader.surroundings(scene).items()}
    # not the mountains, which every page has (povgen/liveview/scripts.html.j2)
    shown = {part: file for part, file in shader.pictures(scene).items() if part in about}
    pictures = {part: {"data": _data(file), **about[part]} for part, file in shown.items()}
    return found | {
        "name": scene.name,
        "pupil": scene.pupil,
        "inverse_focus": inverse_focus(scene) if scene.pupil else 0,
        "rim": scene.rim,
        "faces": max_trace_level(scene),
        "pictures": pictures,
    }


def _preset(scene: AxialScene) -> dict[str, Any]:
    """Return the parameters of a scene whose windows and objects the script finds (povgen/liveview/presets.js)."""
    found = scene.model_dump()
    for sheet, own in zip(scene.sheets, (found, *found["window"]), strict=True):
        own |= _made(sheet, found | {name: value for name, value in own.items() if value is not None})
    if scene.pieces:
        found["color"] = [rgb(piece.color) for piece in scene.pieces]
        found["pedestal_halves"] = {str(piece.piece): piece.radius + PEDESTAL_EDGE for piece in scene.pieces}
    return found


def _room(scene: Scene) -> dict[str, Any]:
    """Return the eye, the windows and the objects of any other scene."""
    assert isinstance(scene, Room)
    names, shown = [*pieces(scene)], shader.cards(scene).pictures
    floor = next((each for each in scene.contents if each.kind == "floor"), None)
    return {
        "background": scene.background,
        "eye": scene.eye.model_dump(),
        "floor_y": floor and floor.y,
        "objects": [
            {
                "kind": shader.kind_of(each),
                "place": each.pose[:3],
                "axes": each.pose.axes.tolist(),
                "numbers": shader.numbers(each, names, shown),
                "colour": each.colour,
            }
            for each in shader.drawn(scene)
        ],
        "windows": [
            _window(opening) | {"name": name}
            for opening, name in zip(scene.openings or [shader.NO_WINDOW], [*scene.things, ""], strict=False)
        ],
    }


def _window(opening: Opening) -> dict[str, Any]:
    sheet: Any = opening.sheet
    return {
        "sheet": sheet.name,
        "place": opening.pose[:3],
        "axes": opening.pose.axes.tolist(),
        "half": [side / 2 for side in opening.outline[:2]],
        "round": opening.outline.is_round,
        "depth": opening.frame,
        "framed": opening.rim > 0,
        "values": {**sheet.values, "aperture": sheet.aperture, **_made(sheet, sheet.values)},
    }


def _made(sheet: Sheet, own: dict[str, Any]) -> dict[str, Any]:
    """Return what the script does not find itself: the index that a sheet is made for, and its profile."""
    found: dict[str, Any] = {"design_index": design_index(own)} if "glass" in own else {}
    if isinstance(sheet, ProfileSheets):
        shape = sheet.shape
        edges = [(*edge.start, *edge.end, edge.radius) for edge in shape.edges]
        found["profile"] = {"edges": edges, "half": shape.half, "index": shape.index, "gap": shape.gap}
    return found


def _data(file: File) -> str:
    """Return a picture as a URL that contains it. A browser shows no light that is brighter than white."""
    return f"data:image/png;base64,{base64.b64encode(as_png(file)).decode()}"
