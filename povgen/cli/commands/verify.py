"""The command povgen verify."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from povgen.cli.options import made_folder
from povgen.errors import InputError
from povgen.version import __version__

if TYPE_CHECKING:  # slow to import
    from collections.abc import Iterator

    from povgen.measure.measured import Measured


def command(
    sheet: Annotated[
        str | None, typer.Option(metavar="ideal|detailed", help="one model of the sheets (default both)")
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="also write the values to a .json file")
    ] = None,
    stability: Annotated[
        bool, typer.Option("--stability", help="measure where methods fail, draw it as maps, and check the limits")
    ] = False,
    live: Annotated[
        bool, typer.Option("--live", help="measure the live view instead, in a Chromium (needs playwright)")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="folder for the maps (default stability)")
    ] = None,
) -> None:
    """Compare what POV-Ray renders with the equations and the exact ray trace. Exit status 1: a bound is not kept."""
    from contextlib import ExitStack
    from dataclasses import asdict
    from json import dumps
    from math import isfinite

    from rich.console import Console
    from rich.live import Live
    from rich.table import Table

    from povgen.files import checked_output, save
    from povgen.rendering import povray

    _check_options(sheet, stability, live, output)
    if json_file:
        json_file = checked_output(json_file, [".json"], "json")
    versions = {"povgen": __version__, "POV-Ray": povray.version()}
    table = Table("sheet", "measured", "value", "bound", "", title=f"povgen {__version__}, POV-Ray {povray.version()}")
    figures = []
    with ExitStack() as opened:
        folder = opened.enter_context(made_folder(output or Path("stability"))) if stability else None
        # the table appears with its first row
        console = Console(width=None if sys.stdout.isatty() else 120)
        shown = opened.enter_context(Live(console=console, auto_refresh=False))

        def add(measured: "Measured") -> None:
            bound = f"{'≥' if measured.least else '≤'} {measured.bound:.5g} {measured.unit}"
            holds = "ok" if measured.holds else "[red]FAILS[/red]"
            table.add_row(measured.sheet, measured.what, f"{measured.value:.5g} {measured.unit}", bound, holds)
            value = measured.value if isfinite(measured.value) else None
            figures.append(asdict(measured) | {"value": value, "holds": measured.holds})
            shown.update(table, refresh=True)

        if folder:
            from povgen.measure.charts import save_maps
            from povgen.measure.stability import maps

            save_maps(maps(sheet), folder, add)
        else:
            for measured in _checks(sheet, live):
                add(measured)
    if json_file:
        save((dumps({"versions": versions, "figures": figures}, indent=2, default=float) + "\n").encode(), json_file)
    if not all(figure["holds"] for figure in figures):
        raise typer.Exit(1)


def _check_options(sheet: str | None, stability: bool, live: bool, output: Path | None) -> None:
    """Raise InputError if the options do not go together."""
    if sheet not in (None, "ideal", "detailed"):
        raise InputError(f"sheet = {sheet!r}: allowed: ideal or detailed")
    if live and (sheet or stability):
        raise InputError("live: the live view is measured alone; allowed without --sheet and --stability")
    if output and not stability:
        raise InputError(f"output = {str(output)!r}: only the maps are written there; allowed with --stability")


def _checks(sheet: str | None, live: bool) -> "Iterator[Measured]":
    if live:
        from povgen.measure.live import checks

        return checks()
    from povgen.measure import verify

    return verify.checks(sheet)
