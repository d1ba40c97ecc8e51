"""The command povgen pov."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import SceneName, scene_of, split, takes
from povgen.cli.report import warn


@takes("scenes", "sampling")
def command(
    scene: SceneName,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE", help="the file to write")] = None,
    **values: object,
) -> None:
    """Write a scene's POV-Ray source to standard output, or to the file of -o.

    The source's header states a command, which makes the same picture as povgen frame with these options.
    """
    from povgen.files import checked_output, save
    from povgen.scene.models import piece_files
    from povgen.scene.sdl import to_pov

    values, options = split(values)
    made = scene_of(scene, values)
    if output is not None:
        checked_output(output, [".pov"], inputs=piece_files([made]))
    text = to_pov(made, file="scene.pov" if output is None else output.name, **options)
    warn(values, [made])
    if output is None:
        print(text, end="")
    else:
        save(text.encode(), output)
