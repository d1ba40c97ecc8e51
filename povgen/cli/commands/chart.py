"""povgen chart."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import made_folder
from povgen.cli.report import say


def command(
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FOLDER", help="for charts and tables")] = Path(
        "chart"
    ),
    baselines: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="of other ways to write the prisms, as .inc files")
    ] = None,
) -> None:
    """Measure CPU seconds against error, for every model and sampling; charts and tables, in some 20 minutes."""
    from povgen.files import save
    from povgen.measure import charts, speed

    by_hand = speed.rewrites(baselines) if baselines else {}
    folder = made_folder(output)
    charts.save_frames(speed.frames(by_hand, say), folder)
    charts.save_counts(list(speed.prism_counts(say)), folder)
    charts.save_movies(list(speed.movies(speed.WORKERS, say)), folder)
    save(f"{speed.machine()}\n".encode(), folder / "machine.txt")
