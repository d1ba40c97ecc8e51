"""The command povgen tolerance."""

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.console import Console
from rich.table import Table

from povgen.cli import shared_options
from povgen.cli.field_options import Command, fields
from povgen.cli.report import warn_unused
from povgen.errors import InputError, one_line
from povgen.files import checked_output
from povgen.measure import tolerance
from povgen.progress import tell
from povgen.record import DRAWINGS, check_unasked, saved_with
from povgen.rendering.parallel import worker_count
from povgen.scene.presets import checked_axial, input_files
from povgen.scene.scene import Scene
from povgen.settings import Print
from povgen.video.still import record_of


@click.command("tolerance", cls=Command)
@shared_options.scene
@click.option(
    "--deviation",
    metavar="NAME=NUMBER",
    multiple=True,
    help="standard deviation of an error of --error, such as turn=0.05; can be repeated",
)
@click.option("--builds", metavar="N", help="how many random builds, 1 to 100000 (default 200)")
@click.option("--seed", metavar="N", help="seed of the random numbers of the builds (default 1)")
@click.option(
    "--workers", metavar="N", help="how many processes compute at once, 1 to 256 (default: one for each core)"
)
@shared_options.scheduler
@shared_options.output(
    "FILE",
    "also draw a chart into this .png, .svg or .pdf file, and write its numbers beside it, as .csv: of random builds, "
    "or without --deviation of each error",
)
@fields("scenes", "print")
def command(
    scene: str,
    deviation: Sequence[str],
    builds: str | None,
    seed: str | None,
    workers: str | None,
    scheduler: str | None,
    output: Path | None,
    **values: Any,  # noqa: ANN401  (texts and Booleans)
) -> None:
    """Trace how errors of building a pair of sheets change what is seen: for each error, and for random builds."""
    printed = Print(**{name: values.pop(name) for name in Print.model_fields if name in values})
    made = checked_axial(shared_options.scene_of(scene, values), "povgen tolerance")
    count = worker_count(workers)
    warn_unused(values, [made])
    given = {name: value for name, value in (("builds", builds), ("seed", seed)) if value is not None}
    spread = tolerance.Spread(deviation=deviation, **given)
    if given and not deviation:
        name = next(iter(given))
        raise InputError(f"{name} = {given[name]}: no random builds; allowed: with --deviation, such as turn=0.1")
    random = (
        tolerance.random_builds(made, spread) if deviation else []
    )  # says what is not allowed before anything is traced
    output, table_file = _checked_files(output, made)
    if output:
        from povgen.measure import charts  # needs matplotlib, and says so before anything is traced
    found = tolerance.sensitivities(made, count, scheduler)
    rows = (
        (f"{tolerance.shown(name)} of {name}", size * np.array(found[name])) for name, size in tolerance.SHOWN.items()
    )
    _print("what each error changes", "error", rows)
    if output and not random:
        with saved_with(record_of([made])):
            charts.save_sensitivities(found, output, printed)
    if random:
        differing = tolerance.builds(made, random, count, scheduler)
        deviations = ", ".join(f"{name} {value:g}" for name, value in spread.deviation.items())
        title = f"{spread.builds} build{'s' * (spread.builds > 1)} with the standard deviations {deviations}"
        percentiles = (
            (f"{percent} %: at most", [tolerance.percentile(change, percent) for change in differing])
            for percent in tolerance.PERCENTILES
        )
        _print(title, "of the builds", percentiles)
        if output:
            with saved_with(record_of([made])):
                charts.save_builds(differing, spread.deviation, output, printed)
    if output and table_file:
        tell(f"wrote {one_line(str(output))} and {one_line(table_file.name)}")


def _checked_files(output: Path | None, scene: Scene) -> tuple[Path | None, Path | None]:
    """Return the files of the chart and of its numbers. Raises InputError if one of them cannot be written."""
    if output is None:
        return None, None
    output = checked_output(output, DRAWINGS, inputs=input_files([scene]))
    table_file = checked_output(output.with_suffix(".csv"), [".csv"], inputs=input_files([scene]))
    check_unasked([table_file])
    return output, table_file


def _print(title: str, first: str, rows: Iterable[tuple[str, Iterable[float]]]) -> None:
    """Print a table of changes, with a name for each row."""
    table = Table(first, "displaced, arcmin", "turned, degrees", "magnified, %", "blurred, arcmin", title=title)
    for name, change in rows:
        table.add_row(name, *(f"{float(value):.3g}" for value in change))
    Console(width=None if sys.stdout.isatty() else 120).print(table)
