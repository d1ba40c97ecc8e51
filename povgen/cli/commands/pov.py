"""The command povgen pov."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from zlib import crc32

import click

from povgen.cli import shared_options
from povgen.cli.field_options import Command, fields
from povgen.cli.report import warn
from povgen.errors import InputError
from povgen.files import checked_output
from povgen.inputs.pictures import used
from povgen.progress import say
from povgen.record import check_unasked, save
from povgen.scene.presets import input_files
from povgen.scene.room import Room
from povgen.scene.scene import Scene
from povgen.scene.sdl import to_pov, to_sheets
from povgen.scene.white import WHITE
from povgen.settings import Sampling
from povgen.sheets.parameters import WAVELENGTH


@click.command("pov", cls=Command)
@shared_options.scene
@shared_options.output("FILE", "the file to write")
@click.option("--part", metavar="sheets", help="write the sheets alone (.inc), to #include in a scene of your own")
@fields("scenes", "sampling")
def command(scene: str, output: Path | None, part: str | None, **values: Any) -> None:  # noqa: ANN401
    """Write a scene's POV-Ray source to standard output, or to the file of -o.

    The source's header states the command with which POV-Ray makes the same picture as povgen frame does.
    The picture of the mountains, those of --sky and --floor, and a room's rays, which the source names, are written
    beside the file of -o.
    """
    values, sampling = shared_options.split(values)
    made = shared_options.scene_of(scene, values).fitted(Sampling(**sampling).size)
    if part not in (None, "sheets"):
        raise InputError(f"part = {part!r}: allowed: sheets")
    if part and sampling:
        raise InputError(f"part = {part!r}, {next(iter(sampling))}: the picture is not povgen's; allowed: one of them")
    if output is not None:
        output = checked_output(
            output, [".inc" if part else ".pov"], inputs=[*input_files([made]), *shared_options.scene_files(scene)]
        )
    name = "scene.pov" if output is None else output.name
    stem = Path(name).stem
    if not re.fullmatch(r"[\w .-]+", stem, re.ASCII):  # POV-Ray reads no other name of a file in a scene
        stem = f"scene-{crc32(stem.encode()):08x}"
    rays = f"{stem}-rays-"
    text = to_sheets(made) if part else to_pov(made, file=name, rays=rays, **sampling)
    warn(shared_options.stated(made, values), [made])
    for lost in _left_out(made):
        say(f"povgen: warning: {lost}")
    if output is None:
        print(text, end="")
    else:
        tables = made.ray_tables(Sampling(**sampling).size) if isinstance(made, Room) else ()
        files = {output.parent / f"{rays}{number}.inc": table for number, table in enumerate(tables)}
        check_unasked(files)
        for file, png in used(text).items():
            save(png, output.parent / file)
        for path, table in files.items():
            save(table, path)
        save(text.encode(), output)


def _left_out(made: Scene) -> Iterator[str]:
    """Yield what a text for POV-Ray does not say of a scene, because povgen makes it from rendered pictures."""
    for outline in made.outlines:
        yield f"{outline} = true: no effect in a .pov file; povgen draws it on the rendered picture"
    if made.pupil:
        yield f"pupil = {made.pupil:g}: a .pov file shows what its middle sees"
    if made.wavelength == WHITE:
        yield f"wavelength = {WHITE}: a .pov file shows one, {WAVELENGTH} nm"
    if made.polarised:
        yield "polariser, analyser: no effect in a .pov file; povgen weights the rendered pictures"
