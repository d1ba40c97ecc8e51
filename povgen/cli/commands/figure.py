"""The command povgen figure."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import made_folder, output_to
from povgen.errors import InputError
from povgen.progress import wrote
from povgen.settings import Rendering


def command(
    numbers: Annotated[list[str], typer.Argument(metavar="NUMBER...", help="numbers of figures in the paper, 1 to 6")],
    output: Annotated[Path, output_to("FOLDER", "the folder for pictures and captions")] = Path("figures"),
    quality: Annotated[
        str, typer.Option(metavar="QUALITY", help="quality of the frames: draft, standard, high or hd")
    ] = "high",
) -> None:
    """Make figures of the paper (PNG, for drawings also SVG), with captions that say how well they agree with it."""
    rendering = Rendering(quality=quality)
    for number in numbers:
        if number not in list("123456"):
            raise InputError(
                f"number = {number!r}: the paper has no such figure; allowed: 1, 2, 3, 4, 5 or 6, with spaces between"
            )
    files = {f"figure{number}.md": [f"figure{number}.{kind}" for kind in ("md", "png", "svg")] for number in numbers}
    with made_folder(output, files) as folder:
        from povgen.paper.figures import save_figure  # after all checks, because matplotlib is slow to load

        for number in numbers:
            for path in save_figure(int(number), folder, rendering):
                wrote(path)
