"""The command povgen frame."""

from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import Quiet, SceneName, Tolerance, auto_tolerance, chosen, scene_of, split, takes
from povgen.cli.report import warn
from povgen.progress import tell


@takes("scenes", "rendering")
def command(
    scene: SceneName,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="the file to write")] = Path(
        "frame.png"
    ),
    tolerance: Tolerance = None,
    quiet: Quiet = False,
    **values: object,
) -> None:
    """Render a scene to a PNG file. --sheet auto chooses the cheapest sheet model within --tolerance."""
    from povgen.files import checked_output, save
    from povgen.rendering import cache
    from povgen.scene.models import piece_files
    from povgen.settings import Rendering
    from povgen.video.still import png

    values, options = split(values)
    limit = auto_tolerance(values, tolerance)
    made = scene_of(scene, values if limit is None else values | {"sheet": "detailed"})
    output = checked_output(output, [".png"], inputs=piece_files([made]))
    if limit is not None:
        values["sheet"], options["antialias"] = chosen([made], options, limit, quiet)
        made = scene_of(scene, values)
    rendering = Rendering(**options)
    cache.check()
    if not quiet:
        warn(values if limit is None else {}, [made], rendering)  # --sheet auto compares with the prisms in any case
    save(png(made, rendering), output)
    if not quiet:
        tell(f"wrote {output}")
