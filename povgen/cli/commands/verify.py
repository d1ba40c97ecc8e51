"""povgen verify."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from povgen import __version__
from povgen.cli.options import made_folder
from povgen.errors import InputError


def command(
    sheet: Annotated[str | None, typer.Option(metavar="ideal|detailed", help="one sheet model (default both)")] = None,
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="write the figures to a .json file as well")] = None,
    stability: Annotated[
        bool, typer.Option("--stability", help="map where methods fail, and measure the limits")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="for the maps (default stability)")
    ] = None,
) -> None:
    """Measure what POV-Ray renders against the equations and the exact ray trace; exit status 1 where a bound fails."""
    from dataclasses import asdict
    from json import dumps
    from math import isfinite

    from rich.console import Console
    from rich.live import Live
    from rich.table import Table

    from povgen.files import checked_output, save
    from povgen.rendering import povray

    if sheet not in (None, "ideal", "detailed"):
        raise InputError(f"sheet = {sheet!r}: allowed: ideal or detailed")
    if output and not stability:
        raise InputError(f"output = {str(output)!r}: it is for the maps; allowed with --stability")
    if json:
        json = checked_output(json, [".json"])
    versions = {"povgen": __version__, "POV-Ray": povray.version()}
    table = Table("sheet", "measured", "value", "bound", "", title=f"povgen {__version__}, POV-Ray {povray.version()}")
    figures = []
    with Live(table, console=Console(width=None if sys.stdout.isatty() else 120), auto_refresh=False) as live:

        def add(figure) -> None:
            bound = f"{'≥' if figure.least else '≤'} {figure.bound:.5g} {figure.unit}"
            holds = "ok" if figure.holds else "[red]FAILS[/red]"
            table.add_row(figure.sheet, figure.what, f"{figure.value:.5g} {figure.unit}", bound, holds)
            value = figure.value if isfinite(figure.value) else None
            figures.append(asdict(figure) | {"value": value, "holds": figure.holds})
            live.refresh()

        if stability:
            from povgen.measure.charts import save_maps
            from povgen.measure.stability import maps

            save_maps(maps(sheet), made_folder(output or Path("stability")), add)
        else:
            from povgen.measure.verify import checks

            for figure in checks(sheet):
                add(figure)
    if json:
        save((dumps({"versions": versions, "figures": figures}, indent=2, default=float) + "\n").encode(), json)
    if not all(figure["holds"] for figure in figures):
        raise typer.Exit(1)
