"""The command povgen frame."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import (
    DryRun,
    Quiet,
    Source,
    Tolerance,
    Values,
    again,
    auto_tolerance,
    chosen,
    output_to,
    scene_of,
    split,
    takes,
)
from povgen.cli.report import tell_if_long, warn
from povgen.errors import InputError
from povgen.files import checked_output, save
from povgen.progress import tell, wrote
from povgen.record import check_unasked
from povgen.rendering import cache
from povgen.rendering.estimate import describe, estimate
from povgen.scene.scenes import Scene, input_files
from povgen.video.still import SUFFIXES, as_file, rendering_for


@takes("scenes", "rendering")
def command(
    scene: Annotated[
        str | None, typer.Argument(metavar="[SCENE]", help="chess or spheres; none with --from", show_default=False)
    ] = None,
    source: Source = None,
    output: Annotated[Path | None, output_to("FILE", "the file to write, .png or .exr (default frame.png)")] = None,
    tolerance: Tolerance = None,
    dry_run: DryRun = False,
    quiet: Quiet = False,
    **values: object,
) -> None:
    """Render a scene to a PNG or EXR file, or one again --from its file.

    --sheet auto chooses the cheapest sheet model within --tolerance.
    """
    if (scene is None) == (source is None):
        reason = ": missing" if scene is None else f" = {scene!r}: not with --from, which shows the file's scene"
        raise InputError(f"scene{reason}; allowed: chess or spheres, or else --from FILE")
    first = None
    if source is not None:
        record, (first, *others), values = again(source, output, values, quiet)
        if record.frame_rate is not None:
            raise InputError(f"from = {str(source)!r}: a movie of {len(others) + 1} frames; allowed: a picture")

    def made_with(values: Values) -> Scene:
        return first.replace(**values) if first else scene_of(str(scene), values)

    values, options = split(values)
    limit, renderers = auto_tolerance(values, options, tolerance)
    if dry_run and limit is not None:
        raise InputError("dry-run: not with --sheet auto, which renders to choose; allowed: one of them")
    made = made_with(values if limit is None else values | {"sheet": "detailed"})
    named = output
    inputs: list[str | Path] = [*input_files([made]), *([source] if source else [])]
    output = checked_output(named or "frame.png", SUFFIXES, inputs=inputs)
    rendering = rendering_for(output, options)
    check_unasked([] if named or dry_run else [output])
    if limit is not None:
        options["bits"] = rendering.bits
        choice = chosen([made], options, limit, renderers, quiet)
        values["sheet"], options["antialias"], options["renderer"] = choice
        made, rendering = made_with(values), rendering_for(output, options)
    if dry_run:
        return tell(describe([made], rendering, estimate([made], rendering)))
    cache.check()
    if not quiet:
        tell_if_long([made], rendering)
        # with --sheet auto, no parameter of the prisms is without effect: it always renders the prisms, to compare
        warn(values if limit is None else {}, [made], rendering)
    save(as_file(made, rendering, quiet=quiet), output)
    if not quiet:
        wrote(output)
