"""The command povgen movie."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import typer

from povgen.cli.options import (
    DryRun,
    Quiet,
    Scheduler,
    Source,
    Tolerance,
    Values,
    Workers,
    again,
    auto_tolerance,
    chosen,
    output_to,
    split,
    takes,
)
from povgen.cli.report import tell_if_long, warn
from povgen.errors import InputError, TransientError, one_line
from povgen.progress import bar, counted, tell, wrote
from povgen.record import check_unasked
from povgen.rendering import cache
from povgen.rendering.estimate import describe, estimate
from povgen.rendering.frames import missing, render_all, shard
from povgen.rendering.parallel import checked_scheduler, worker_count
from povgen.scene.scenes import SCENES, Scene, input_files
from povgen.scene.spec import MOVIES, MovieSpec, spec_file
from povgen.settings import Rendering
from povgen.video.build import FilmOptions, check_views, checked_movie
from povgen.video.build import movie as make


@takes("scenes", "rendering")
def command(
    spec: Annotated[
        str | None,
        typer.Argument(
            metavar="[SPEC]",
            help="a movie's TOML file, or the name of one of povgen's own movies; or, with --sweep, a scene "
            "(chess or spheres); none with --from",
            show_default=False,
        ),
    ] = None,
    source: Source = None,
    sweep: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=START:STOP",
            help="SPEC is a scene, and a parameter changes from START to STOP: alpha=0:180 or z1=1:9:log. "
            "The spacing can be :linear or :log. Give it once for each parameter",
        ),
    ] = None,
    frames: Annotated[
        str | None,
        typer.Option(metavar="N", help="frames from start to stop, at every quality, 2 to 10000"),
    ] = None,
    frame_rate: Annotated[
        str | None,
        typer.Option(metavar="RATE", help="frames a second at quality standard, or of --frames, 0.1 to 120"),
    ] = None,
    ease: Annotated[
        bool | None,
        typer.Option("--ease/--no-ease", help="whether the sweeps start and stop gently", show_default=False),
    ] = None,
    hold: Annotated[
        str | None,
        typer.Option(metavar="SECONDS", help="how long both ends, and the frame at via, stay, 0 to 10"),
    ] = None,
    loop: Annotated[
        bool | None, typer.Option("--loop/--no-loop", help="whether the movie goes there and back", show_default=False)
    ] = None,
    output: Annotated[
        Path | None,
        output_to("FILE", ".mp4, .webm, .webp, .gif, or frames/%04d.png for a file of each frame (default: NAME.mp4)"),
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    part: Annotated[
        str | None,
        typer.Option(
            "--shard", metavar="I/N", help="only render every N-th frame, starting with the I-th; make no movie"
        ),
    ] = None,
    tolerance: Tolerance = None,
    dry_run: DryRun = False,
    quiet: Quiet = False,
    **values: object,
) -> None:
    """Render a movie, or one again --from its file. Finished frames stay in the cache.

    Options for the scene replace values that the spec fixes.
    """
    given: Values = {"frames": frames, "frame_rate": frame_rate, "ease": ease, "hold": hold, "loop": loop}
    given = {name: value for name, value in given.items() if value is not None}
    given |= {"exact_frames": True, "hold": given.get("hold", 0)} if frames else {}
    loaded, values, options = _loaded(spec, source, sweep, given, values, quiet)
    count, scheduler = worker_count(workers), checked_scheduler(scheduler)
    limit, renderers = auto_tolerance(values, options, tolerance)
    if dry_run and limit is not None:
        raise InputError("dry-run: not with --sheet auto, which renders to choose; allowed: one of them")
    made = loaded.with_fixed(values if limit is None else values | {"sheet": "detailed"})
    rendering = Rendering(**options)
    scenes = made.scenes(rendering.quality)
    if part is not None:
        _check_shard(part, scheduler, output)
    read = source or spec or ""
    named = output
    output = output or Path(f"{'movie' if spec == '-' else Path(read).stem}.mp4")
    if part is None:
        # a dry run writes nothing: then the default output may be the source
        own = [] if sweep or dry_run and not named else [source or spec_file(read)]
        inputs = [*input_files(scenes), *own]
        checked_movie(output, len(scenes), made.rate(rendering.quality), rendering, inputs)
        check_unasked([] if named or dry_run else [output])
    if limit is not None:
        check_views(scenes, rendering)
        choice = chosen(scenes, options, limit, renderers, quiet, scheduler)
        values["sheet"], options["antialias"], options["renderer"] = choice
        made, rendering = loaded.with_fixed(values), Rendering(**options)
        scenes = made.scenes(rendering.quality)
    scenes, rendering = _shard(scenes, rendering, part)
    check_views(scenes, rendering)
    if dry_run:
        return tell(describe(scenes, rendering, estimate(scenes, rendering)))
    cache.check()
    if not quiet:
        tell_if_long(scenes, rendering)
        swept = dict.fromkeys(each.parameter for each in getattr(made, "sweep", ()))
        # with --sheet auto, no parameter of the prisms is without effect: it always renders the prisms, to compare
        warn(swept | values if limit is None else {}, scenes, rendering)
    if part is not None:
        return _render_shard(part, scenes, rendering, count, quiet)
    what = scenes if isinstance(made, _Recorded) else made
    more = {"workers": count, "scheduler": scheduler, "progress": not quiet, **options}
    make(what, output, frame_rate=made.frame_rate, title=made.title, **more)
    if not quiet:
        wrote(output)


@dataclass(frozen=True)
class _Recorded:
    """A movie's frames, from its record."""

    frames: list[Scene]
    frame_rate: float
    title: str | None

    def with_fixed(self, values: Values) -> "_Recorded":
        return replace(self, frames=[scene.replace(**values) for scene in self.frames])

    def scenes(self, _quality: str) -> list[Scene]:
        return self.frames

    def rate(self, _quality: str) -> float:
        return self.frame_rate


def _loaded(
    spec: str | None, source: Path | None, sweeps: list[str] | None, given: Values, values: Values, quiet: bool
) -> "tuple[MovieSpec | _Recorded, Values, Values]":
    """Return the movie, with these values of the spec, and the values of scenes and rendering. Raises InputError.

    The values of the scenes are not in the movie yet.
    """
    if source is None:
        if spec is None:
            raise InputError(
                "spec: missing; allowed: a TOML file, a movie's name, a scene with --sweep, or --from FILE"
            )
        values, options = split(values)
        fixed = {name: value for name, value in values.items() if value != "auto"}
        return _movie_of(spec, sweeps, given, fixed), values, options

    of_spec = {name: value for name, value in given.items() if name != "frame_rate"}
    for name, value in {"spec": spec, "sweep": sweeps, **of_spec}.items():
        if value is not None:
            raise InputError(f"{name} = {value!r}: not with --from, which makes the same frames; allowed: one of them")
    record, scenes, values = again(source, None, values, quiet)
    if record.frame_rate is None:
        raise InputError(f"from = {str(source)!r}: a picture; allowed: a movie")
    rate = FilmOptions(frame_rate=given.get("frame_rate", record.frame_rate)).frame_rate
    title = one_line(record.title or "")[:200] or None  # if it is the name of a file, it can be longer
    return _Recorded(scenes, rate, title), *split(values)


def _movie_of(spec: str, sweeps: list[str] | None, values: Values, fixed: Values) -> MovieSpec:
    """Return the movie of a spec, or of a scene and its sweeps, with these values of the spec and the scene.

    Raises InputError.
    """
    if not sweeps:
        if spec in SCENES and not Path(spec).is_file() and not (MOVIES / f"{spec}.toml").exists():
            raise InputError(f"{spec}: a scene, no movie spec; allowed: with sweeps, such as --sweep alpha=0:180")
        return MovieSpec.load(spec, fixed).replace(**values)
    if spec not in SCENES:
        raise InputError(
            f"sweep = {sweeps[0]!r}: not with the movie {spec!r}; allowed: with a scene: {' or '.join(SCENES)}"
        )
    return MovieSpec.of_sweeps(spec, sweeps, values)


def _check_shard(part: str, scheduler: str | None, output: Path | None) -> None:
    """Raise InputError if a shard is not i/n, or for an option that has no use with it."""
    shard([], part)
    for name, value in (("scheduler", scheduler), ("output", output)):
        if value is not None:
            raise InputError(f"shard = {part!r}, {name} = {str(value)!r}: a shard makes no movie; allowed: one of them")


def _shard(scenes: list[Scene], rendering: Rendering, part: str | None) -> tuple[list[Scene], Rendering]:
    """Return a shard's frames, with the sampling of the whole movie; without a shard, all."""
    if part is None:
        return scenes, rendering
    sampling = rendering.suited(any(scene.has_prisms for scene in scenes))
    return shard(scenes, part), rendering.replace(antialias=sampling.sampling)


def _render_shard(part: str, scenes: list[Scene], rendering: Rendering, count: int | None, quiet: bool) -> None:
    """Render the frames of a shard into the cache. Raises TransientError for frames that are not there at the end."""
    with bar(f"shard {part}", len(scenes), quiet) as done:
        for _ in render_all(scenes, rendering, count, done):
            pass
    if lost := missing(scenes, rendering):
        raise TransientError(
            f"shard {part}: frames that the cache does not keep: {lost}; allowed: a larger cache (POVGEN_CACHE_SIZE), "
            "to which povgen can write"
        )
    if not quiet:
        tell(f"rendered shard {part}: {counted(len(scenes), 'frame')}")
