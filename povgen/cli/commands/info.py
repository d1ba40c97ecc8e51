"""The command povgen info."""

import json
from pathlib import Path

import click

from povgen.cli.command import Command
from povgen.scene.scenes import recorded


@click.command("info", cls=Command)
@click.argument("file", type=Path, metavar="FILE", help="a picture or a movie that povgen wrote")
def command(file: Path) -> None:
    """Print, as JSON, how a picture or a movie was made: its record, with every parameter."""
    record, _ = recorded(file)
    print(json.dumps(record.model_dump(mode="json"), indent=1))  # its characters are ASCII, without control characters
