"""The command povgen tolerance."""

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from povgen.cli.options import SceneName, Scheduler, output_to, scene_of, takes
from povgen.cli.report import warn_unused
from povgen.errors import InputError, one_line
from povgen.files import checked_output
from povgen.progress import tell
from povgen.record import check_unasked
from povgen.rendering.parallel import worker_count
from povgen.scene.scenes import input_files
from povgen.sheets.prisms import ERRORS


@takes("scenes")
def command(
    scene: SceneName,
    deviation: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=NUMBER",
            help="standard deviation of an error of --error, such as turn=0.05; can be repeated",
        ),
    ] = None,
    builds: Annotated[
        str | None, typer.Option(metavar="N", help="how many random builds, 1 to 100000 (default 200)")
    ] = None,
    seed: Annotated[
        str | None, typer.Option(metavar="N", help="seed of the random numbers of the builds (default 1)")
    ] = None,
    workers: Annotated[
        str | None,
        typer.Option(
            metavar="N", help="how many processes compute at once, 1 to 256", show_default="one for each core"
        ),
    ] = None,
    scheduler: Scheduler = None,
    output: Annotated[
        Path | None,
        output_to(
            "FILE",
            "also draw a chart into this .png file, and write its numbers beside it, as .csv: of random builds, or "
            "without --deviation of each error",
        ),
    ] = None,
    **values: object,
) -> None:
    """Trace how errors of building a pair of sheets change what is seen: for each error, and for random builds."""
    from povgen.measure import tolerance

    made, count = scene_of(scene, values), worker_count(workers)
    warn_unused(values, [made])
    given = {name: value for name, value in (("builds", builds), ("seed", seed)) if value is not None}
    spread = tolerance.Spread(deviation=deviation or [], **given)
    if given and not deviation:
        name = next(iter(given))
        raise InputError(f"{name} = {given[name]}: no random builds; allowed: with --deviation, such as turn=0.1")
    random = tolerance.drawn(made, spread) if deviation else []  # says what is not allowed before anything is traced
    if output:
        output = checked_output(output, [".png"], inputs=input_files([made]))
        table_file = checked_output(output.with_suffix(".csv"), [".csv"], inputs=input_files([made]))
        check_unasked([table_file])
        from povgen.measure import charts  # says what is missing before anything is traced
    found = tolerance.sensitivities(made, count, scheduler)
    console = Console(width=None if sys.stdout.isatty() else 120)
    columns = ("displaced, arcmin", "turned, degrees", "magnified, %", "blurred, arcmin")
    table = Table("a unit of the error", *columns, title="what each error changes")
    for name, change in found.items():
        unit = {"tiles": "1 tile of", "": "1 of"}.get(ERRORS[name].unit, "1 degree of")
        table.add_row(f"{unit} {name}", *(f"{float(value):.3g}" for value in change))
    console.print(table)
    if output and not random:
        charts.save_sensitivities(found, output)
    if random:
        differing = tolerance.builds(made, random, count, scheduler)
        deviations = ", ".join(f"{name} {value:g}" for name, value in spread.deviation.items())
        table = Table(
            "of the builds",
            *columns,
            title=f"{spread.builds} build{'s' * (spread.builds > 1)} with the standard deviations {deviations}",
        )
        for percentile in tolerance.PERCENTILES:
            row = (f"{tolerance.percentile(change, percentile):.3g}" for change in differing)
            table.add_row(f"{percentile} %: at most", *row)
        console.print(table)
        if output:
            charts.save_builds(differing, spread.deviation, output)
    if output:
        tell(f"wrote {one_line(str(output))} and {one_line(table_file.name)}")
