"""The command povgen movie."""

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from povgen.cli.options import Quiet, Tolerance, Values, Workers, auto_tolerance, chosen, split, takes
from povgen.cli.report import warn
from povgen.errors import InputError
from povgen.progress import bar, tell

if TYPE_CHECKING:
    from povgen.scene.models import Scene
    from povgen.scene.spec import MovieSpec
    from povgen.settings import Rendering


@takes("scenes", "rendering")
def command(
    spec: Annotated[
        str,
        typer.Argument(
            metavar="SPEC",
            help="a movie's TOML file, or the name of one of povgen's own movies; or, with --sweep, a scene "
            "(chess or spheres)",
        ),
    ],
    sweep: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=START:STOP",
            help="SPEC is a scene, and a parameter changes from START to STOP: alpha=0:180 or z1=1:9:log. "
            "The spacing can be :linear, :log or :cosine. Give it once for each parameter",
        ),
    ] = None,
    frames: Annotated[
        str | None,
        typer.Option(metavar="N", help="number of frames from start to stop at quality standard, 2 to 10000"),
    ] = None,
    frame_rate: Annotated[
        str | None, typer.Option(metavar="RATE", help="frames a second at quality standard, 0.1 to 120")
    ] = None,
    loop: Annotated[
        bool | None, typer.Option("--loop/--no-loop", help="whether the movie goes there and back", show_default=False)
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help=".mp4, .webm or .gif (default: SPEC's name with .mp4, in the current folder)",
        ),
    ] = None,
    workers: Workers = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="address of a Dask scheduler, tcp://HOST:PORT, whose workers render"),
    ] = None,
    part: Annotated[
        str | None,
        typer.Option(
            "--shard", metavar="I/N", help="only render every N-th frame, starting with the I-th; make no movie"
        ),
    ] = None,
    tolerance: Tolerance = None,
    quiet: Quiet = False,
    **values: object,
) -> None:
    """Render a movie. Options for the scene replace values that the spec fixes. Finished frames stay in the cache."""
    from povgen.rendering import cache
    from povgen.rendering.frames import shard
    from povgen.rendering.parallel import checked_scheduler, worker_count
    from povgen.scene.models import piece_files
    from povgen.scene.spec import spec_file
    from povgen.settings import Rendering
    from povgen.video.build import check_views, checked_movie
    from povgen.video.build import movie as make

    values, options = split(values)
    given = {"frames": frames, "frame_rate": frame_rate, "loop": loop}
    given = {name: value for name, value in given.items() if value is not None}
    loaded = _movie_of(spec, sweep, given, {name: value for name, value in values.items() if value != "auto"})
    count, scheduler = worker_count(workers), checked_scheduler(scheduler)
    limit = auto_tolerance(values, tolerance)
    made = loaded.with_fixed(values if limit is None else values | {"sheet": "detailed"})
    rendering = Rendering(**options)
    scenes = made.scenes(rendering.quality)
    if part is not None:
        _check_shard(part, scheduler, output)
    output = output or Path(f"{'movie' if spec == '-' else Path(spec).stem}.mp4")
    if part is None:
        inputs = [*piece_files(scenes), *([] if sweep else [spec_file(spec)])]
        checked_movie(output, len(scenes), made.rate(rendering.quality), inputs)
    if limit is not None:
        check_views(scenes, rendering)
        values["sheet"], options["antialias"] = chosen(scenes, options, limit, quiet)
        made, rendering = loaded.with_fixed(values), Rendering(**options)
        scenes = made.scenes(rendering.quality)
    scenes = scenes if part is None else shard(scenes, part)
    check_views(scenes, rendering)
    cache.check()
    if not quiet:
        warn(values if limit is None else {}, scenes, rendering)  # --sheet auto compares with the prisms in any case
    if part is not None:
        return _render_shard(part, scenes, rendering, count, quiet)
    if quiet:
        logging.getLogger("povgen").setLevel("ERROR")
    make(made, output, workers=count, scheduler=scheduler, progress=not quiet, **options)
    if not quiet:
        tell(f"wrote {output}")


def _movie_of(spec: str, sweeps: list[str] | None, values: Values, fixed: Values) -> "MovieSpec":
    """Return the movie of a spec, or of a scene and its sweeps, with these values of the spec and the scene.

    Raises InputError.
    """
    from povgen.scene.models import SCENES
    from povgen.scene.spec import MOVIES, MovieSpec

    if not sweeps:
        if spec in SCENES and not Path(spec).exists() and not (MOVIES / f"{spec}.toml").exists():
            raise InputError(f"{spec}: a scene, no movie spec; allowed: with sweeps, such as --sweep alpha=0:180")
        return MovieSpec.load(spec, fixed).replace(**values)
    if spec not in SCENES:
        raise InputError(f"sweep = {sweeps[0]!r}: not for the movie {spec!r}; allowed: for {' or '.join(SCENES)}")
    return MovieSpec.of_sweeps(spec, sweeps, values)


def _check_shard(part: str, scheduler: str | None, output: Path | None) -> None:
    """Raise InputError if a shard is not i/n, or for an option that has no use with it."""
    from povgen.rendering.frames import shard

    shard([], part)
    for name, value in (("scheduler", scheduler), ("output", output)):
        if value is not None:
            raise InputError(f"shard = {part!r}, {name} = {str(value)!r}: a shard makes no movie; allowed: one of them")


def _render_shard(part: str, scenes: list["Scene"], rendering: "Rendering", count: int | None, quiet: bool) -> None:
    """Render the frames of a shard into the cache."""
    from povgen.rendering.frames import render_all

    with bar(f"shard {part}", len(scenes), quiet) as done:
        for _ in render_all(scenes, rendering, count, done):
            pass
    if not quiet:
        tell(f"rendered shard {part}: {len(scenes)} frames")
