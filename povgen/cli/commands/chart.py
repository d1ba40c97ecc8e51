"""The command povgen chart."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import made_folder
from povgen.progress import say


def command(
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FOLDER", help="write charts and tables there")
    ] = Path("chart"),
    baselines: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="compare with the macros Sheet in this folder's .inc files")
    ] = None,
    glass: Annotated[
        bool,
        typer.Option("--glass", help="only draw what real glass does, polarisation and diffraction; takes seconds"),
    ] = False,
) -> None:
    """Measure the cost and the error of pictures, for every model of the sheets and every sampling. Takes an hour."""
    from povgen.files import save
    from povgen.measure import charts, speed
    from povgen.measure.glass import save_charts

    sheet_macros = speed.baselines(baselines) if baselines else {}
    with made_folder(output) as folder:
        save_charts(folder)
        if glass:
            return
        charts.save_frames(speed.measure_samplings(sheet_macros, say), folder)
        charts.save_flicker(list(speed.measure_flicker(say)), folder)
        charts.save_prism_counts(list(speed.measure_prism_counts(say)), folder)
        charts.save_beyond(list(speed.measure_beyond(say)), folder)
        charts.save_workers(list(speed.measure_workers(say)), folder)
        save(f"{speed.machine()}\n".encode(), folder / "machine.txt")
