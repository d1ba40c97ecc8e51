"""The command povgen figure."""

from pathlib import Path
from typing import Any

import click

from povgen.cli import shared_options
from povgen.cli.field_options import Command, fields
from povgen.errors import InputError
from povgen.progress import wrote
from povgen.settings import QUALITIES, Print, Rendering


@click.command("figure", cls=Command)
@click.argument("numbers", metavar="NUMBER...", nargs=-1, required=True, help="numbers of figures, 1 to 6")
@shared_options.output("FOLDER", "the folder for pictures and captions", "figures")
@click.option(
    "--quality",
    metavar="QUALITY",
    default="high",
    show_default=True,
    help=f"quality of the frames: {', '.join(QUALITIES)}",
)
@click.option("--pdf", is_flag=True, help="also write PDF files, in which text is text")
@fields("print")
def command(numbers: tuple[str, ...], output: Path, quality: str, pdf: bool, **values: Any) -> None:  # noqa: ANN401
    """Make figures of the paper (PNG, for drawings also SVG), with captions that say how well they agree with it."""
    rendering, printed = Rendering(quality=quality), Print(**values)
    for number in numbers:
        if number not in list("123456"):
            raise InputError(
                f"number = {number!r}: the paper has no such figure; allowed: 1, 2, 3, 4, 5 or 6, with spaces between"
            )
    files = {
        f"figure{number}.md": [f"figure{number}.{kind}" for kind in ("md", "png", "svg", "pdf")] for number in numbers
    }
    with shared_options.made_folder(output, files) as folder:
        from povgen.paper.figures import save_figure  # after all checks, because matplotlib is slow to load

        for number in numbers:
            for path in save_figure(int(number), folder, rendering, printed, pdf):
                wrote(path)
