"""The command povgen info."""

import json
from pathlib import Path

import click

from povgen.cli.field_options import Command
from povgen.record import info
from povgen.scene.presets import recorded


@click.command("info", cls=Command)
@click.argument("file", type=Path, metavar="FILE", help="a file that povgen wrote")
def command(file: Path) -> None:
    """Print, as JSON, how a file of povgen's was made: its record. A picture's or a movie's has every parameter."""
    record = info(file)
    if record.frames:
        recorded(file)  # raises InputError for frames that are not allowed
    print(json.dumps(record.stated, indent=1))  # its characters are ASCII, without control characters
