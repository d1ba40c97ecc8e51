"""The command povgen demo."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import Quiet, Workers, split, takes
from povgen.cli.report import warn
from povgen.progress import bar


@takes("rendering")
def command(
    specs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SPEC]...",
            help="a movie's TOML file, or the name of one of povgen's own movies",
            show_default="the paper's three",
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FOLDER", help="the folder for index.html and its frames")
    ] = Path("demo"),
    workers: Workers = None,
    quiet: Quiet = False,
    **options: object,
) -> None:
    """Make a page to teach with: movies, seen through prisms or the ideal sheet, beside the diagram of figure 5."""
    from povgen.rendering import cache
    from povgen.rendering.parallel import worker_count
    from povgen.scene.spec import MovieSpec
    from povgen.settings import Rendering
    from povgen.teach.page import OWN, checked_page, one_eyed, scenes
    from povgen.teach.page import demo as make

    loaded, count = [MovieSpec.load(spec) for spec in specs or OWN], worker_count(workers)
    _, options = split(options)
    rendering = one_eyed(Rendering(**options))
    shown = [scene for spec in loaded for frames in scenes(spec, rendering.quality).values() for scene in frames]
    cache.check()  # before the page's folder is made
    checked_page(output)
    if not quiet:
        warn(shown, rendering)
    with bar(output.name, len(shown), quiet) as done:
        page = make(loaded, output, workers=count, done=done, **options)
    if not quiet:
        print(f"wrote {page}")
