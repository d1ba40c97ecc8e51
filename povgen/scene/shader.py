"""What the live view's shaders are given for a scene: constants for the compiler, and uniforms.

This module needs no browser. povgen/liveview/values.js does the same in a page. Lengths are in tiles, angles of the
result in radians.
"""

from collections.abc import Sequence
from math import cos, radians, sin
from typing import Any, NamedTuple

from povgen.inputs.pictures import File, Picture, mountains
from povgen.objects.board import Board, stacked
from povgen.objects.scene_object import SceneObject
from povgen.optics.faces import GlassSheet
from povgen.optics.opening import Opening
from povgen.optics.pose import Pose
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile
from povgen.scene.laws import Text, to_live
from povgen.scene.presets import AxialScene
from povgen.scene.pupil import distance, inverse_focus
from povgen.scene.scene import Scene
from povgen.scene.survey import Survey, max_trace_level
from povgen.sheets.layered import Layered
from povgen.sheets.none import NoSheet
from povgen.sheets.own import OwnLaw
from povgen.sheets.sheet import Ideal, Sheet

BACKGROUNDS = ("sky", "black", "white", "transparent")  # their numbers in materials.glsl
NO_WINDOW = Opening(Pose(), NoSheet({}, 1e-9))  # of a scene without windows: a shader has at least one


class Cards(NamedTuple):
    """The pictures on boards, one above the other in a single picture."""

    file: File | None
    pictures: Sequence[Picture]
    places: Sequence[Sequence[float]]  # of each: left and upper edge, width and height, as parts of the whole


def drawn(scene: Scene) -> list[SceneObject]:
    """Return the objects that the shader's functions draw: all but the floor. Those of a kind are side by side."""
    found = [each for each in scene.contents if each.glsl]
    kinds = [*map(kind_of, found)]
    return sorted(found, key=lambda each: kinds.index(kind_of(each)))


def kind_of(thing: SceneObject) -> str:
    """Return KIND in the names of an object's functions in GLSL."""
    return thing.drawn_as or thing.kind


def cards(scene: Scene) -> Cards:
    """Return the pictures on the scene's boards, and where they are in the picture that has all of them."""
    shown = tuple(dict.fromkeys(each.picture for each in drawn(scene) if isinstance(each, Board) and each.picture))
    if not shown:
        return Cards(None, (), ())
    wide, high = max(each.size[0] for each in shown), sum(each.size[1] for each in shown)
    tops = [sum(each.size[1] for each in shown[:n]) for n in range(len(shown))]
    places = [(0, top / high, each.size[0] / wide, each.size[1] / high) for top, each in zip(tops, shown, strict=True)]
    return Cards(stacked(shown), shown, places)


def defines(scene: Scene, names: Sequence[str], grid: Sequence[int]) -> dict[str, int | str]:
    """Return the constants for which the shaders are compiled, by their names.

    `names` are the names of the scene's different pieces (`scenes.pieces`). `grid` is the number of points of their
    distance fields along x, y and z.
    """
    things = drawn(scene)
    found: dict[str, int | str] = {
        "WINDOWS": max(1, len(scene.openings)),
        "CONSTANTS": _constants(to_live([scene])),
        "OBJECTS": len(things),
        "VOLUMES": len(names),
        "GRID": ", ".join(map(str, grid)),
    }
    kinds = [*map(kind_of, things)]
    for kind in kinds:
        first = kinds.index(kind)
        found[f"ALL_{kind.upper()}"] = f"ivec2({first}, {first + kinds.count(kind)})"
    if edges := [len(profile.edges) for profile in map(_profile, scene.openings) if profile]:
        found["PROFILE_EDGES"] = max(edges)
    if count := len(cards(scene).pictures):
        found["CARDS"] = count
    if any(opening.outline.is_round for opening in scene.openings):
        found["ROUND_WINDOWS"] = 1
    if any(any(opening.pose[3:]) for opening in scene.openings):
        found["TURNED_WINDOWS"] = 1
    if any(any(each.pose[3:]) for each in things):
        found["TURNED_OBJECTS"] = 1
    laws = any(isinstance(sheet, Ideal) and sheet.name != "none" for sheet in scene.sheets)
    features = {"PRISMS": scene.has_prisms, "LAWS": laws, "PUPIL": bool(scene.pupil)}
    features["AXIAL"] = isinstance(scene, AxialScene)
    found |= {name: 1 for name, needed in features.items() if needed}
    found |= {f"{part.upper()}_PICTURE": 1 for part in surroundings(scene)}
    return found


def surroundings(scene: Scene) -> dict[str, Picture]:
    """Return the pictures of sky and floor that the scene shows."""
    floor = next((each.picture for each in scene.contents if each.kind == "floor"), None)
    parts = {"sky": scene.sky if scene.background == "sky" else None, "floor": floor}
    return {name: part for name, part in parts.items() if isinstance(part, Picture)}


def pictures(scene: Scene) -> dict[str, File]:
    """Return the files of the pictures that the shader reads: of sky or mountains, of the floor, and of all boards."""
    found = {part: picture.file for part, picture in surroundings(scene).items()}
    if scene.background == "sky" and "sky" not in found:
        found["mountains"] = mountains()
    return found | ({"cards": file} if (file := cards(scene).file) else {})


def uniforms(
    scene: Scene, names: Sequence[str], places: Sequence[Sequence[float]], found: Survey | None = None
) -> dict[str, Any]:
    """Return the shaders' uniforms for a scene, by their names.

    `names` are as for `defines`. `places` has four numbers for the distance field of each piece, in tiles: x, y and z
    of its first point, from the centre of the foot, and the side of a voxel. `found` is the scene's survey; without it,
    rays are traced.
    """
    camera, floor = scene.camera, next((each for each in scene.contents if each.kind == "floor"), None)
    ground, boards = surroundings(scene).get("floor"), cards(scene)
    things = drawn(scene)
    return {
        "eye": camera.eye,
        "viewMiddle": camera.middle,
        "viewRight": camera.right,
        "viewUp": camera.up,
        "viewHeight": camera.height,
        "pupil": scene.pupil / 2,
        "outOfFocus": 1 - distance(camera) * inverse_focus(scene) if scene.pupil else 0,
        "background": BACKGROUNDS.index(scene.background),
        "frameRim": scene.rim,
        "hasFloor": floor is not None,
        "skyPicture": 2,
        "floorPicture": 3,
        "cardPictures": 4,
        "mountains": 5,
        "cardPlace": boards.places,
        "floorTiles": ground.tiles if ground else (1, 1),
        "floorMean": ground.mean if ground else (0, 0, 0),
        "floorY": floor.y if floor else 0,
        "horizon": 1e7 / scene.tile,  # POV-Ray does not show what is farther away
        "maxFaces": max_trace_level(scene, found),
        "volumes": 1,
        "volumePlace": places,
        "objectPlace": [each.pose[:3] for each in things],
        "objectAxes": [each.pose.axes.tolist() for each in things],
        "objectNumbers": [numbers(each, names, boards.pictures) for each in things],
        "objectColour": [each.colour for each in things],
        **_windows(scene.openings or [NO_WINDOW], to_live([scene])),
    }


def numbers(thing: SceneObject, names: Sequence[str], shown: Sequence[Picture]) -> list[float]:
    """Return the four numbers that an object's functions in GLSL need. `names` are as for `defines`.

    `shown` are the pictures on boards.
    """
    found = [*thing.numbers]
    if thing.shape:
        found.append(names.index(str(thing.shape)))
    elif thing.picture:
        found.append(shown.index(thing.picture))
    return found + [0.0] * (4 - len(found))


def of_rays(window: Opening) -> tuple[dict[str, int | str], dict[str, Any]]:
    """Return the constants and the uniforms of povgen/liveview/rays.glsl for a window of prisms or lenses."""
    profile = _profile(window)
    # prisms.glsl has its own numbers for the faces of Dove prisms
    path = (profile.path if profile else (3, 1, 4)) * len(window.sheet.glass)
    defines: dict[str, int | str] = {"WINDOWS": 1, "PRISMS": 1, "PATH": len(path)}
    if profile:
        defines["PROFILE_EDGES"] = len(profile.edges)
    if window.outline.is_round:
        defines["ROUND_WINDOWS"] = 1
    return defines, _windows([window], to_live()) | {"designedPath": path, "starts": 0, "ways": 1}


def _windows(openings: Sequence[Opening], laws: Sequence[Text]) -> dict[str, Any]:
    """Return the uniforms of windows and sheets. A window has two sheets of glass; a missing one has zeros."""
    windows = [opening.sheet.glass for opening in openings]
    none = GlassSheet(0.0, 0.0, Prism(1.0))
    layers = [layer for sheets in windows for layer in (*sheets, none, none)[:2]]
    shapes = [opening.sheet.shape if isinstance(opening.sheet, Layered) else Prism(1.0) for opening in openings]
    prisms = [shape if isinstance(shape, Prism) else Prism(1.0) for shape in shapes]
    # two shapes for each window, one for each sheet: with errors of building they differ
    own = [[layer.shape for layer in sheets] + [plan] * 2 for sheets, plan in zip(windows, shapes, strict=True)]
    slants = [
        radians((shape if isinstance(shape, Prism) else prism).base_angle)
        for several, prism in zip(own, prisms, strict=True)
        for shape in several[:2]
    ]
    sheets: list[Any] = [opening.sheet for opening in openings]
    return {
        "kind": [_kind(sheet, laws) for sheet in sheets],
        "constants": [number for sheet in sheets for number in _law_constants(sheet, _constants(laws))],
        "windowPlace": [opening.pose[:3] for opening in openings],
        "windowAxes": [opening.pose.axes.tolist() for opening in openings],
        "windowHalf": [[side / 2 for side in opening.outline[:2]] for opening in openings],
        "windowRound": [opening.outline.is_round for opening in openings],
        "windowDepth": [opening.frame for opening in openings],
        "windowFramed": [opening.rim > 0 for opening in openings],
        "sheetCounts": [len(each) for each in windows],
        "sheetTurns": [(cos(layer.angle), sin(layer.angle)) for layer in layers],
        "sheetAxes": [layer.axes.tolist() for layer in layers],
        "sheetCentres": [layer.centre for layer in layers],
        "pitches": [shape.pitch for shape in shapes],
        "firstBases": [
            ((shape.gap if isinstance(shape, Prism) else 0) - opening.sheet.aperture / shape.pitch) / 2
            for shape, opening in zip(shapes, openings, strict=True)
        ],
        "prismHeights": [prism.height / prism.pitch for prism in prisms],
        "prismHalves": [shape.length / shape.pitch / 2 for shape in shapes],
        "slants": [(cos(base), sin(base)) for base in slants],
        "glassIndices": [shape.index for several in own for shape in several[:2]],
        "blackTops": [prism.black for prism in prisms],
    } | _edges([*map(_profile, openings)])


def _profile(opening: Opening) -> Profile | None:
    """Return the profile of the sheets in a window, None for Dove prisms and ideal sheets."""
    shape = opening.sheet.shape if isinstance(opening.sheet, Layered) else None
    return None if isinstance(shape, Prism) else shape


def _edges(profiles: Sequence[Profile | None]) -> dict[str, Any]:
    """Return the uniforms of profiles in povgen/liveview/prisms.glsl."""
    several = [profile.edges if profile else () for profile in profiles]
    most = max(map(len, several))
    if not most:
        return {}
    lines = [[(*edge.start, *edge.end) for edge in edges] + [(0.0,) * 4] * (most - len(edges)) for edges in several]
    radii = [[edge.radius for edge in edges] + [0.0] * (most - len(edges)) for edges in several]
    return {"profileCounts": [*map(len, several)], "profileEdges": sum(lines, []), "profileRadii": sum(radii, [])}


def _constants(laws: Sequence[Text]) -> int:
    return max(1, *(len(law.constants) for law in laws))


def _kind(sheet: Sheet, laws: Sequence[Text]) -> int:
    """Return the number of a sheet's law in laws.glsl, from 0: -1 for prisms and lenses, -2 for no sheet."""
    if sheet.layers or sheet.name == "none":
        return -1 if sheet.layers else -2
    name = f"law {sheet.values['law']}" if isinstance(sheet, OwnLaw) else sheet.name
    return [law.name for law in laws].index(name)


def _law_constants(sheet: Sheet, count: int) -> list[float]:
    """Return the numbers that depend on a law's parameters alone, and zeros up to `count`."""
    found = sheet.law.constant_numbers(sheet.numbers) if isinstance(sheet, Ideal) else []
    return found + [0.0] * (count - len(found))
