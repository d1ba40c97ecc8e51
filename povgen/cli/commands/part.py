"""The command povgen part."""

from typing import Any

import click

from povgen.cli import shared_options
from povgen.cli.field_options import Command, fields
from povgen.cli.report import warn_unused
from povgen.progress import wrote


@click.command("part", cls=Command)
@shared_options.scene
@click.option("-o", "--output", required=True, metavar="FILE", help="the file to write: .stl, .obj or .glb")
@click.option("--tile", default="100", metavar="MM", help="millimetres in a tile, 0.01 to 100000", show_default=True)
@click.option("--frame", is_flag=True, help="unite the sheets of each window with its frame, which holds them")
@shared_options.quiet
@fields("scenes")
def command(scene: str, output: str, tile: Any, frame: bool, quiet: bool, **values: Any) -> None:  # noqa: ANN401
    """Write the sheets of prisms or lenses of a scene as closed solids, cut off at the windows' outlines.

    They stand in their places, with their errors of building. Lengths are in millimetres, in .glb in metres.
    """
    made = shared_options.scene_of(scene, values)
    from povgen.measure.part import part  # needs manifold3d and trimesh, and says so

    if not quiet:
        warn_unused(shared_options.stated(made, values), [made])
    file = part(made, output, tile, frame)
    if not quiet:
        wrote(file)
