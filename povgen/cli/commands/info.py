"""The command povgen info."""

import json
from pathlib import Path
from typing import Annotated

import typer

from povgen.scene.scenes import recorded


def command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="a picture or a movie that povgen wrote")],
) -> None:
    """Print, as JSON, how a picture or a movie was made: its record, with every parameter."""
    record, _ = recorded(file)
    print(json.dumps(record.model_dump(mode="json"), indent=1))  # its characters are ASCII, without control characters
