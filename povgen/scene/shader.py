"""What the live view's shaders are given for a scene: constants for the compiler, and uniforms.

This module needs no file and no browser.
povgen/liveview/values.js does the same in a page. Lengths are in tiles, angles of the result in radians.
"""

from collections.abc import Sequence
from math import cos, radians, sin
from typing import Any

from povgen.inputs.pictures import Picture
from povgen.optics.faces import GlassSheet
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile
from povgen.scene.laws import Text, to_live
from povgen.scene.model import EyeAndWindows
from povgen.scene.scenes import PEDESTAL_EDGE, Chess, Scene, Spheres
from povgen.scene.survey import Survey, max_trace_level
from povgen.scene.windows import Window
from povgen.sheets.layered import Layered
from povgen.sheets.own import OwnLaw
from povgen.sheets.prisms import SHAPE, shape_of
from povgen.sheets.sheet import Ideal, Sheet

BACKGROUNDS = ("sky", "black", "white", "transparent")  # their numbers in materials.glsl
# The shader is compiled for at least this number of spheres, so that scenes with fewer can use the same shader.
MOST_SPHERES = 11


def defines(scene: Scene, names: Sequence[str], grid: Sequence[int]) -> dict[str, int | str]:
    """Return the constants for which the shaders are compiled, by their names.

    `names` are the names of the scene's different pieces (`scenes.pieces`). `grid` is the number of points of their
    distance fields along x, y and z.
    """
    found: dict[str, int | str] = {
        "WINDOWS": len(scene.windows),
        "CONSTANTS": _constants(to_live([scene])),
        "PIECES": len(scene.pieces) if isinstance(scene, Chess) else 0,
        "SPHERES": max(MOST_SPHERES, len(scene.objects)) if isinstance(scene, Spheres) else 0,
        "VOLUMES": len(names),
        "GRID": ", ".join(map(str, grid)),
    }
    if edges := [len(profile.edges) for profile in _profiles(scene) if profile]:
        found["PROFILE_EDGES"] = max(edges)
    found |= {f"{part.upper()}_PICTURE": 1 for part in surroundings(scene)}
    return found


def surroundings(scene: Scene) -> dict[str, Picture]:
    """Return the pictures that the scene shows: sky and floor."""
    parts = {"sky": scene.sky if scene.background == "sky" else None, "floor": getattr(scene, "floor", None)}
    return {name: part for name, part in parts.items() if isinstance(part, Picture)}


def uniforms(
    scene: Scene, names: Sequence[str], places: Sequence[Sequence[float]], found: Survey | None = None
) -> dict[str, Any]:
    """Return the shaders' uniforms for a scene, by their names.

    `names` are as for `defines`. `places` has four numbers for the distance field of each piece, in tiles: x, y and z
    of its first point, from the centre of the foot, and the side of a voxel. `found` is the scene's survey; without it,
    rays are traced.
    """
    laws = to_live([scene])
    last = scene.places[-1]
    pieces, pedestal = (scene.pieces, scene.pedestal) if isinstance(scene, Chess) else ((), 0.0)
    spheres = scene.objects if isinstance(scene, Spheres) else ()
    radii = scene.radii if spheres else ()
    ball = [(L.real, L.imag, last + z1, radius) for (L, z1), radius in zip(spheres, radii, strict=True)]
    floor = -(scene.aperture / 2 + scene.rim)
    ground = surroundings(scene).get("floor")
    return {
        "simulated": 0 if {sheet.name for sheet in scene.ideal} <= {"none"} else len(scene.ideal),
        "kind": [_kind(sheet, laws) for sheet in scene.sheets],
        "constants": [number for sheet in scene.sheets for number in _law_constants(sheet, _constants(laws))],
        "eye": [*scene.eye, -scene.z2],
        "viewHeight": scene.view,
        "background": BACKGROUNDS.index(scene.background),
        "window": scene.aperture,
        "windowZ": scene.places,
        "frameDepth": scene.depth,
        "frameRim": scene.rim,
        "hasFloor": isinstance(scene, Chess) and scene.floor != "none",
        "skyPicture": 2,
        "floorPicture": 3,
        "floorTiles": ground.tiles if ground else (1, 1),
        "floorMean": ground.mean if ground else (0, 0, 0),
        "floorY": floor,
        "horizon": 1e7 / scene.tile,  # POV-Ray does not show what is farther away
        "maxFaces": max_trace_level(scene, found),
        "volumes": 1,
        "pieceFoot": [(piece.x, floor + pedestal, last + piece.z1) for piece in pieces],
        "pedestal": pedestal,
        "pedestalHalf": [piece.radius + PEDESTAL_EDGE for piece in pieces],
        "pieceColour": [piece.colour for piece in pieces],
        "pieceVolume": [names.index(str(piece.piece)) for piece in pieces],
        "volumePlace": places,
        "sphereCount": len(ball),
        "spheres": ball + [(0, 0, 1, 0)] * (MOST_SPHERES - len(ball)),
    } | _sheets(scene)


def _sheets(scene: Scene) -> dict[str, Any]:
    """Return the uniforms of povgen/liveview/prisms.glsl: of two sheets for each window. A missing one has zeros."""
    windows = [sheet.layers_at(0.0, k) for k, sheet in enumerate(scene.sheets)]
    none = GlassSheet(0.0, 0.0, Prism(1.0))
    layers = [layer for sheets in windows for layer in (*sheets, none, none)[:2]]
    prisms = [_prism(scene, window) for window in scene.parameter_sets]
    profiles = _profiles(scene)
    shapes = [profile or prism for profile, prism in zip(profiles, prisms, strict=True)]
    # two shapes for each window, one for each sheet: with errors of building they differ
    own = [[layer.shape for layer in sheets] + [plan] * 2 for sheets, plan in zip(windows, shapes, strict=True)]
    bases = [
        radians((shape if isinstance(shape, Prism) else prism).base_angle)
        for several, prism in zip(own, prisms, strict=True)
        for shape in several[:2]
    ]
    return {
        "sheetCounts": [len(sheets) for sheets in windows],
        "sheetTurns": [(cos(layer.angle), sin(layer.angle)) for layer in layers],
        "sheetAxes": [layer.axes.tolist() for layer in layers],
        "sheetCentres": [layer.centre for layer in layers],
        "pitches": [shape.pitch for shape in shapes],
        "firstBases": [
            ((shape.gap if isinstance(shape, Prism) else 0) - scene.aperture / shape.pitch) / 2 for shape in shapes
        ],
        "prismHeights": [prism.height / prism.pitch for prism in prisms],
        "prismHalves": [shape.length / shape.pitch / 2 for shape in shapes],
        "slants": [(cos(base), sin(base)) for base in bases],
        "glassIndices": [shape.index for several in own for shape in several[:2]],
        "blackTops": [sheet.values.get("tops") == "black" for sheet in scene.sheets],
    } | _edges(profiles)


def _profiles(scene: Scene) -> list[Profile | None]:
    """Return the profile of the sheets in each window, None for Dove prisms and ideal sheets."""
    shapes = (sheet.shape if isinstance(sheet, Layered) else None for sheet in scene.sheets)
    return [None if isinstance(shape, Prism) else shape for shape in shapes]


def _edges(profiles: Sequence[Profile | None]) -> dict[str, Any]:
    """Return the uniforms of profiles in povgen/liveview/prisms.glsl."""
    several = [profile.edges if profile else () for profile in profiles]
    most = max(map(len, several))
    if not most:
        return {}
    lines = [[(*edge.start, *edge.end) for edge in edges] + [(0.0,) * 4] * (most - len(edges)) for edges in several]
    radii = [[edge.radius for edge in edges] + [0.0] * (most - len(edges)) for edges in several]
    return {"profileCounts": [*map(len, several)], "profileEdges": sum(lines, []), "profileRadii": sum(radii, [])}


def _prism(scene: Scene, window: EyeAndWindows | Window) -> Prism:
    """Return the shape of the prisms in a window. A window without prisms has values for them too."""
    values = scene.values_of(window, ("prisms", *SHAPE))
    return shape_of(values, scene.aperture / values["prisms"])


def _constants(laws: Sequence[Text]) -> int:
    return max(1, *(len(law.constants) for law in laws))


def _kind(sheet: Sheet, laws: Sequence[Text]) -> int:
    """Return the number of a sheet's law in laws.glsl, from 0. It is -1 for prisms and lenses, which have no law."""
    if sheet.layers:
        return -1
    name = f"law {sheet.values['law']}" if isinstance(sheet, OwnLaw) else sheet.name
    return [law.name for law in laws].index(name)


def _law_constants(sheet: Sheet, count: int) -> list[float]:
    """Return the numbers that depend on a law's parameters alone, and zeros up to `count`."""
    found = sheet.law.constant_numbers(sheet.numbers) if isinstance(sheet, Ideal) else []
    return found + [0.0] * (count - len(found))
