"""The command povgen demo."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import Quiet, Workers, output_to, split, takes
from povgen.progress import wrote
from povgen.rendering.parallel import worker_count


@takes("rendering")
def command(
    output: Annotated[Path | None, output_to("FILE", "the page, .html (default demo.html)")] = None,
    piece: Annotated[
        list[str] | None,
        typer.Option(metavar="FILE", help="a chess piece of your own: a file that declares Piece; can be repeated"),
    ] = None,
    sky: Annotated[
        str | None, typer.Option(metavar="FILE", help="an equirectangular picture in place of mountains and sky")
    ] = None,
    floor: Annotated[str, typer.Option(metavar="FLOOR", help="tiles, none, or a picture's file")] = "tiles",
    movies: Annotated[
        bool,
        typer.Option(
            "--movies",
            help="render POV-Ray's three movies as well, beside the page; the other options are for them; --workers "
            "and --timeout also for the pieces",
        ),
    ] = False,
    workers: Workers = None,
    quiet: Quiet = False,
    **options: object,
) -> None:
    """Make a page to teach with: the scene, live, beside the geometry and the equations. It needs no network."""
    from povgen.page.page import demo

    _, options = split(options)
    count = worker_count(workers)
    page = demo(
        output, pieces=piece or (), sky=sky, floor=floor, movies=movies, workers=count, progress=not quiet, **options
    )
    if not quiet:
        wrote(page)
