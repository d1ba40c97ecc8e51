"""Sheets of glass as closed solids in a file, to print them, to cut them, or to trace them with another program."""

from collections.abc import Iterable, Iterator
from math import ceil
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from povgen import remedies
from povgen.errors import InputError, input_errors
from povgen.files import checked_output
from povgen.optics.faces import GlassSheet, sections
from povgen.optics.outline import Outline
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile
from povgen.record import recorded_call, save, saved_with
from povgen.scene.presets import input_files
from povgen.scene.scene import Scene, checked_scene
from povgen.sheets import SHEETS
from povgen.sheets.layered import Layered
from povgen.sheets.sheet import Ideal
from povgen.validation import Model, as_flag
from povgen.video.still import record_of

try:
    import trimesh
    from manifold3d import CrossSection, FillRule, Manifold, OpType
except ImportError:
    raise InputError(
        f"parts are made with manifold3d and trimesh, which are not installed: {remedies.extra('parts')}"
    ) from None

SUFFIXES = (".stl", ".obj", ".glb")
CIRCLE = 512  # sides of the polygon in place of a round outline, whose corners are on the outline
Floats = NDArray[np.float64]


class _Scale(Model):
    tile: Annotated[float, Field(ge=0.01, le=1e5)] = Field(description="millimetres in a tile, 0.01 to 100000")


@recorded_call
@input_errors()
def part(scene: Scene, output: str | Path, tile: float = 100.0, frame: bool = False) -> Path:
    """Write the scene's sheets of prisms or lenses as closed solids to a .stl, .obj or .glb file. Return its path.

    `tile` is the length of a tile in millimetres. Each sheet is cut off at its window's outline. With `frame`, each
    window that has a frame is one solid: its sheets, whose ends are in a frame with flat sides. Lengths are in
    millimetres, in .glb in metres, as glTF demands. x points right, y up, and z to the eye: such axes are right-handed,
    those of scenes are left-handed. The origin is the scene's. Raises InputError for a scene without such sheets or
    with an ideal one, for a tile out of range, for a file that cannot be written, and without manifold3d and trimesh.
    """
    target = checked_output(output, SUFFIXES, inputs=input_files([checked_scene(scene)]))
    kind = target.suffix[1:].lower()
    scale = _Scale(tile=tile).tile / (1000 if kind == "glb" else 1)
    made = trimesh.Scene()
    for name, solid in solids(scene, as_flag("frame", frame)).items():
        mesh = solid.scale((scale, scale, scale)).mirror((0, 0, 1)).to_mesh64()
        made.add_geometry(trimesh.Trimesh(mesh.vert_properties, mesh.tri_verts, process=False), name, name)
    data = made.export(file_type=kind)
    with saved_with(record_of([scene])):
        save(data.encode() if isinstance(data, str) else data, target)
    return target


def solids(scene: Scene, frame: bool = False) -> dict[str, Manifold]:
    """Return the sheets as closed solids in the scene's coordinates, tiles, by their names. `frame` is as for `part`.

    Raises InputError for a scene without sheets of prisms or lenses, or with an ideal one.
    """
    without = [sheet.name for sheet in scene.sheets if isinstance(sheet, Ideal) and sheet.name != "none"]
    if without or not scene.layered:
        allowed = ", ".join(repr(name) for name, kind in SHEETS.items() if issubclass(kind, Layered))
        raise InputError(f"sheet = {(without or ['none'])[0]!r} has no glass; allowed: {allowed}")
    found: dict[str, Manifold] = {}
    for name, opening in scene.named_openings.items():
        glass, wider = opening.sheet.glass, opening.rim if frame else 0.0  # to the middle of its sides
        ends = ("-near", "-far") if len(glass) > 1 else ("",)
        own = {name + end: _solid(sheet, opening.outline, wider) for end, sheet in zip(ends, glass, strict=False)}
        if glass and wider:
            around = _cut(opening.outline, 2 * wider, opening.frame) - _cut(opening.outline, 0, 2 * opening.frame)
            own = {name: Manifold.batch_boolean([around, *own.values()], OpType.Add)}
        place = np.column_stack((opening.pose.axes.T, opening.pose.place))
        found |= {key: solid.transform(place) for key, solid in own.items()}
    return found


def _cut(outline: Outline, wider: float, depth: float) -> Manifold:
    """Return what is within the outline, whose sides are longer by `wider`, up to depth/2 on either side of it."""
    shape = CrossSection.circle(0.5, CIRCLE) if outline.is_round else CrossSection.square((1, 1), True)
    wide = shape.scale((outline.width + wider, outline.height + wider))
    return wide.extrude(depth).translate((0, 0, -depth / 2))


def _solid(sheet: GlassSheet, outline: Outline, wider: float) -> Manifold:
    """Return a sheet in the window's coordinates, cut off at the outline, whose sides are longer by `wider`."""
    shape, side = sheet.shape, max(outline.width, outline.height)
    half = side + wider + shape.length  # more than half of the diagonal, also if the sheet is tilted
    if isinstance(shape, Prism):
        contours: Iterable[Floats] = sections(sheet, side) / shape.pitch
    else:
        contours = _edges(shape, round(side / shape.pitch), half)
    box = CrossSection.square((2 * half / shape.pitch, 2 * shape.length / shape.pitch), True)
    solid = (CrossSection([*contours], FillRule.EvenOdd) ^ box).extrude(2 * half).translate((0, 0, -half))
    c, s = np.cos(sheet.angle), np.sin(sheet.angle)
    # the columns are the directions of u and z of the cross-section, in periods, and of the ridges
    columns = np.array([[-s * shape.pitch, 0, c], [c * shape.pitch, 0, s], [0, shape.pitch, 0]])
    middle = (0, 0, sheet.centre)
    cut = _cut(outline, wider, 4 * sheet.reach(side + wider)).translate(middle)
    return solid.transform(np.column_stack((sheet.axes.T @ columns, middle))) ^ cut


def _edges(shape: Profile, periods: int, half: float) -> Iterator[Floats]:
    """Return a contour (n, 2) for each copy of each edge, in periods: the points from the edge to a great z.

    Glass is where an odd number of them overlap, by the rule of `Profile`: a line along z from before the sheet to a
    point in the glass crosses an odd number of edges. An arc becomes chords of equal length with corners on the arc.
    """
    beyond = 2 * shape.half + 1
    for edge in shape.edges:
        points = edge.points() if edge.radius else np.array([edge.start, edge.end])
        closed = np.concatenate((points, [(points[-1, 0], beyond), (points[0, 0], beyond)]))
        copies = ceil(half / shape.pitch / edge.period) + 1
        for k in range(-copies, copies):
            yield (closed / (edge.period, 1) + (k - periods % 2 / 2, 0)) * (edge.period, 1)
