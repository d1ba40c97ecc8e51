"""The command povgen frame."""

from pathlib import Path
from typing import Any

import click

from povgen.cli import shared_options
from povgen.cli.field_options import Command, fields
from povgen.errors import InputError
from povgen.files import checked_output
from povgen.progress import wrote
from povgen.record import PICTURES, check_unasked, save
from povgen.scene.presets import input_files
from povgen.video.still import as_file, rendering_for


@click.command("frame", cls=Command)
@click.argument("scene", metavar="[SCENE]", required=False, help=f"{shared_options.SCENE}; none with --from")
@shared_options.source
@shared_options.output("FILE", f"the file to write, {' or '.join(PICTURES)} (default frame.png)")
@shared_options.tolerance
@shared_options.dry_run
@shared_options.quiet
@fields("scenes", "rendering", auto=True)
def command(
    scene: str | None,
    source: Path | None,
    output: Path | None,
    tolerance: str | None,
    dry_run: bool,
    quiet: bool,
    **values: Any,  # noqa: ANN401  (texts and Booleans)
) -> None:
    """Render a scene to a file, or one again --from its file.

    --sheet auto chooses the cheapest sheet model within --tolerance.
    """
    if (scene is None) == (source is None):
        reason = ": missing" if scene is None else f" = {scene!r}: not with --from, which shows the file's scene"
        raise InputError(f"scene{reason}; allowed: {shared_options.SCENE}, or else --from FILE")
    first = None
    if source is not None:
        record, (first, *others), values = shared_options.again(source, output, values, quiet)
        if record.frame_rate is not None:
            raise InputError(f"from = {str(source)!r}: a movie of {len(others) + 1} frames; allowed: a picture")
    values, chosen = shared_options.split(values)
    automatic = shared_options.automatic(values, chosen, tolerance, dry_run)
    if automatic is not None:
        values["sheet"] = "detailed"
    made = first.replace(**values) if first else shared_options.scene_of(str(scene), values)
    inputs: list[str | Path] = [*input_files([made]), *shared_options.scene_files(scene), *([source] if source else [])]
    file = checked_output(output or "frame.png", PICTURES, inputs=inputs)
    rendering = rendering_for(file, chosen)
    check_unasked([] if output or dry_run else [file])
    if automatic is not None:
        sheet, choice = automatic.choose([made], {**chosen, "bits": rendering.bits}, quiet)
        made, rendering = made.replace(**sheet), rendering_for(file, {**chosen, **choice})
    made = made.fitted(rendering.size)
    # with --sheet auto, no parameter of the prisms is without effect: it always renders the prisms, to compare
    stated = values if first else shared_options.stated(made, values)
    if shared_options.ready([made], rendering, stated if automatic is None else {}, dry_run, quiet):
        save(as_file(made, rendering, file.suffix, quiet=quiet), file)
        if not quiet:
            wrote(file)
