"""The command povgen live."""

from pathlib import Path
from typing import Any

import click

from povgen.cli import shared_options
from povgen.cli.field_options import Command, fields
from povgen.cli.report import warn_unused
from povgen.files import checked_output
from povgen.liveview.view import live
from povgen.progress import say, wrote
from povgen.record import check_unasked


@click.command("live", cls=Command)
@shared_options.scene
@shared_options.output("FILE", "the page, .html (default live.html)")
@shared_options.quiet
@fields("scenes")
def command(scene: str, output: Path | None, quiet: bool, **values: Any) -> None:  # noqa: ANN401
    """Make a page that shows a scene live: the eye moves by mouse and keys. It needs a browser, and no network."""
    made = shared_options.scene_of(scene, values)
    file = checked_output(output or "live.html", [".html"], inputs=shared_options.scene_files(scene))
    check_unasked([] if output else [file])
    view = live(made)
    if not quiet:
        warn_unused(shared_options.stated(made, values), [made])
        for outline in made.outlines:
            say(f"povgen: warning: {outline} = true: no effect in the live view")
    view.save(file)
    if not quiet:
        wrote(file)
