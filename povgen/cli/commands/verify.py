"""The command povgen verify."""

import sys
from contextlib import ExitStack
from dataclasses import asdict
from json import dumps
from math import isfinite
from pathlib import Path

import click
from rich.console import Console
from rich.live import Live
from rich.table import Table

from povgen.cli import shared_options
from povgen.cli.field_options import Command
from povgen.errors import InputError
from povgen.files import checked_output
from povgen.measure.measured import Measured
from povgen.record import save
from povgen.rendering import gl_runner, povray
from povgen.version import __version__


@click.command("verify", cls=Command)
@click.option("--sheet", metavar="ideal|detailed", help="one model of the sheets (default both)")
@click.option("--json", "json_file", type=Path, metavar="FILE", help="also write the values to a .json file")
@click.option("--stability", is_flag=True, help="measure where methods fail, draw it as maps, and check the limits")
@click.option("--gl", is_flag=True, help="measure the renderer gl and the live view's shaders instead (needs moderngl)")
@click.option(
    "--live", is_flag=True, help="compare the live view in a Chromium with the renderer gl (needs playwright)"
)
@shared_options.output("FOLDER", "folder for the maps (default stability)")
def command(
    sheet: str | None,
    json_file: Path | None,
    stability: bool,
    gl: bool,
    live: bool,
    output: Path | None,
) -> None:
    """Compare what is rendered with the equations and the exact ray trace. Exit status 1: a bound is not kept."""
    _check_options(sheet, stability, gl, live, output)
    json_file = json_file and checked_output(json_file, [".json"], "json")
    versions = _versions(gl, live)
    table = Table("sheet", "measured", "value", "bound", "", title=", ".join(map(" ".join, versions.items())))
    found: list[Measured] = []
    with ExitStack() as opened:
        if stability:
            from povgen.measure.stability import MAPS, maps
            from povgen.measure.stability_map import save_maps

            files = {f"{name}.csv": (f"{name}.csv", f"{name}.png") for name in MAPS}
            folder = opened.enter_context(shared_options.made_folder(output or Path("stability"), files))
        # the table appears with its first row
        console = Console(width=None if sys.stdout.isatty() else 120)
        shown = opened.enter_context(Live(console=console, auto_refresh=False))

        def add(measured: Measured) -> None:
            found.append(measured)
            bound = f"{'≥' if measured.least else '≤'} {measured.bound:.5g} {measured.unit}"
            holds = "ok" if measured.holds else "[red]FAILS[/red]"
            table.add_row(measured.sheet, measured.what, f"{measured.value:.5g} {measured.unit}", bound, holds)
            shown.update(table, refresh=True)

        if stability:
            save_maps(maps(sheet), folder, add)
        else:
            from povgen.measure import verify, verify_gl, verify_live  # slow to load

            for measured in verify_gl.checks() if gl else verify_live.checks() if live else verify.checks(sheet):
                add(measured)
    if json_file:
        rows = [{**asdict(m), "value": m.value if isfinite(m.value) else None, "holds": m.holds} for m in found]
        save((dumps({"versions": versions, "figures": rows}, indent=2, default=float) + "\n").encode(), json_file)
    if not all(measured.holds for measured in found):
        raise click.exceptions.Exit(1)


def _versions(gl: bool, live: bool) -> dict[str, str]:
    """Return the versions of what is measured."""
    versions = {"povgen": __version__} | ({} if live else {"POV-Ray": povray.version()})
    return versions | ({"OpenGL by": gl_runner.device()} if gl or live else {})


def _check_options(sheet: str | None, stability: bool, gl: bool, live: bool, output: Path | None) -> None:
    """Raise InputError if the options do not go together."""
    if sheet not in (None, "ideal", "detailed"):
        raise InputError(f"sheet = {sheet!r}: allowed: ideal or detailed")
    if gl and (sheet or stability or live):
        raise InputError("gl: measured alone; allowed without --sheet, --stability and --live")
    if live and (sheet or stability):
        raise InputError("live: measured alone; allowed without --sheet and --stability")
    if output and not stability:
        raise InputError(f"output = {str(output)!r}: only the maps are written there; allowed with --stability")
