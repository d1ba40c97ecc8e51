"""The command povgen chart."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import made_folder, output_to
from povgen.errors import InputError
from povgen.progress import say


def command(
    output: Annotated[
        Path, output_to("FOLDER", "write charts and tables there, and a page of all, charts.html")
    ] = Path("chart"),
    baselines: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="compare with a folder's macros Sheet (.inc) and other programs (.csv)"),
    ] = None,
    tables: Annotated[
        Path | None,
        typer.Option(
            "--from", metavar="FOLDER", help="measure nothing: draw from the tables of an earlier measurement"
        ),
    ] = None,
    optics: Annotated[
        bool,
        typer.Option("--optics", help="only draw polarisation, diffraction, and the field of rays; takes seconds"),
    ] = False,
) -> None:
    """Measure the cost and the error of pictures, for every model of the sheets and every sampling. Takes an hour."""
    from povgen.files import save
    from povgen.measure import charts, field, glass, report, speed

    for name, given in (("baselines", baselines), ("optics", optics)):
        if tables and given:
            raise InputError(
                f"{name}: with --from nothing is measured, and all charts are drawn; allowed without --from"
            )
    if optics and baselines:
        raise InputError("baselines: with --optics no pictures are measured; allowed without --optics")
    sheet_macros = speed.baselines(baselines) if baselines else {}
    others = [p for file in sorted(baselines.glob("*.csv")) for p in charts.read_frames(file)] if baselines else []
    measured = charts.read_tables(tables) if tables else None
    with made_folder(output, {"field.csv": charts.FILES}) as folder:
        before = report.times(folder)
        glass.save_charts(folder)
        field.save_charts(folder)
        if measured:
            charts.redraw(measured, folder)
        elif not optics:
            charts.save_frames(speed.measure_samplings(sheet_macros, say) + others, folder)
            charts.save_flicker(list(speed.measure_flicker(say)), folder)
            charts.save_prism_counts(list(speed.measure_prism_counts(say)), folder)
            charts.save_beyond(list(speed.measure_beyond(say)), folder)
            charts.save_workers(list(speed.measure_workers(say)), folder)
            save(f"{speed.machine()}\n".encode(), folder / "machine.txt")
        text = "Cost and error of pictures. The data of each chart stand in a .csv file beside this page."
        drawn, saved = (report.written(folder, before, suffix) for suffix in (".png", ".csv"))
        report.save_report(folder / "charts.html", "povgen's charts", text, report.read_tables(saved), drawn)
