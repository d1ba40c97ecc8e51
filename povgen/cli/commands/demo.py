"""The command povgen demo."""

from pathlib import Path
from typing import Any

import click

from povgen.cli import shared_options
from povgen.cli.field_options import Command, fields
from povgen.page.page import demo
from povgen.progress import wrote
from povgen.rendering.parallel import worker_count


@click.command("demo", cls=Command)
@shared_options.output("FILE", "the page, .html (default demo.html)")
@click.option(
    "--piece",
    metavar="FILE",
    multiple=True,
    help="a chess piece of your own: a file that declares Piece; can be repeated",
)
@click.option(
    "--add",
    metavar="FILE",
    multiple=True,
    help="a question, challenge, tour or lesson of your own: a TOML file (docs/adding.md); can be repeated",
)
@click.option("--sky", metavar="FILE", help="an equirectangular picture in place of mountains and sky")
@click.option("--floor", metavar="FLOOR", default="tiles", show_default=True, help="tiles, none, or a picture's file")
@click.option(
    "--movies",
    is_flag=True,
    help="render POV-Ray's three movies as well, beside the page; the other options are for them; --workers and "
    "--timeout also for the pieces",
)
@shared_options.workers
@shared_options.quiet
@fields("rendering")
def command(
    output: Path | None,
    piece: tuple[str, ...],
    add: tuple[str, ...],
    sky: str | None,
    floor: str,
    movies: bool,
    workers: str | None,
    quiet: bool,
    **values: Any,  # noqa: ANN401  (texts and Booleans)
) -> None:
    """Make a page to teach with: the scene, live, beside the geometry and the equations. It needs no network."""
    _, rendering = shared_options.split(values)
    count = worker_count(workers)
    given: dict[str, Any] = {
        "pieces": piece,
        "add": add,
        "sky": sky,
        "floor": floor,
        "movies": movies,
        "workers": count,
    }
    page = demo(output, progress=not quiet, **given, **rendering)
    if not quiet:
        wrote(page)
