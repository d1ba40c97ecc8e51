"""The command povgen pov."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import SceneName, output_to, scene_of, split, takes
from povgen.cli.report import warn
from povgen.errors import InputError
from povgen.files import checked_output, save
from povgen.progress import say
from povgen.scene.pictures import used
from povgen.scene.scenes import input_files
from povgen.scene.sdl import to_pov, to_sheets


@takes("scenes", "sampling")
def command(
    scene: SceneName,
    output: Annotated[Path | None, output_to("FILE", "the file to write")] = None,
    part: Annotated[
        str | None,
        typer.Option(metavar="sheets", help="write the sheets alone (.inc), to #include in a scene of your own"),
    ] = None,
    **values: object,
) -> None:
    """Write a scene's POV-Ray source to standard output, or to the file of -o.

    The source's header states the command with which POV-Ray makes the same picture as povgen frame does.
    The pictures of --sky and --floor, which the source names, are written beside the file of -o.
    """
    values, options = split(values)
    made = scene_of(scene, values)
    if part not in (None, "sheets"):
        raise InputError(f"part = {part!r}: allowed: sheets")
    if part and options:
        raise InputError(f"part = {part!r}, {next(iter(options))}: the picture is not povgen's; allowed: one of them")
    if output is not None:
        output = checked_output(output, [".inc" if part else ".pov"], inputs=input_files([made]))
    name = "scene.pov" if output is None else output.name
    text = to_sheets(made) if part else to_pov(made, file=name, **options)
    warn(values, [made])
    for outline in made.outlines:
        say(f"povgen: warning: {outline} = true: no effect in a .pov file; povgen draws it on the rendered picture")
    if output is None:
        print(text, end="")
    else:
        for file, png in used(text).items():
            save(png, output.parent / file)
        save(text.encode(), output)
