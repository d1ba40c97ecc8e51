"""The command povgen movie."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from povgen.cli import shared_options
from povgen.cli.field_options import Command, fields
from povgen.cli.shared_options import Values
from povgen.errors import InputError, TransientError, one_line
from povgen.progress import bar, counted, tell, wrote
from povgen.record import check_unasked
from povgen.rendering.frames import missing, render_all, shard
from povgen.rendering.parallel import checked_scheduler, worker_count
from povgen.scene.presets import SCENES
from povgen.scene.scene import Scene
from povgen.scene.spec import MOVIES, MovieSpec, spec_file
from povgen.settings import Rendering, of_movie
from povgen.video.build import Film, FilmOptions, Plan, check_views, film, movie_rendering, planned, sequence
from povgen.video.encode import FORMATS


@click.command("movie", cls=Command)
@click.argument(
    "spec",
    metavar="[SPEC]",
    required=False,
    help="a movie's TOML file, or the name of one of povgen's own movies; or, with --sweep, a scene (chess, spheres or "
    "room) or a room's TOML file; none with --from",
)
@shared_options.source
@click.option(
    "--sweep",
    metavar="NAME=START:STOP",
    multiple=True,
    help="SPEC is a scene, and a parameter changes from START to STOP: alpha=0:180, z1=1:9:log or, of a room, "
    "left.alpha=0:180 or eye.x=-1:1. The spacing can be :linear or :log. Give it once for each parameter",
)
@click.option("--frames", metavar="N", help="frames from start to stop, at every quality, 2 to 10000")
@click.option("--frame-rate", metavar="RATE", help="frames a second at quality standard, or of --frames, 0.1 to 120")
@click.option("--ease/--no-ease", default=None, help="whether the sweeps start and stop gently")
@click.option("--hold", metavar="SECONDS", help="how long both ends, and the frame at via, stay, 0 to 10")
@click.option("--loop/--no-loop", default=None, help="whether the movie goes there and back")
@shared_options.output(
    "FILE",
    f"{', '.join(FORMATS)}; or frames/%04d.png or frames/%04d.exr for a file of each frame (default: NAME.mp4)",
)
@shared_options.workers
@shared_options.scheduler
@click.option(
    "--shard", "part", metavar="I/N", help="only render every N-th frame, starting with the I-th; make no movie"
)
@shared_options.tolerance
@shared_options.dry_run
@shared_options.quiet
@fields("scenes", "rendering", auto=True)
def command(
    spec: str | None,
    source: Path | None,
    sweep: Sequence[str],
    output: Path | None,
    workers: str | None,
    scheduler: str | None,
    part: str | None,
    tolerance: str | None,
    dry_run: bool,
    quiet: bool,
    **values: Any,  # noqa: ANN401  (texts and Booleans)
) -> None:
    """Render a movie, or one again --from its file. Finished frames stay in the cache.

    Options for the scene replace values that the spec fixes.
    """
    given = {name: values.pop(name) for name in ("frames", "frame_rate", "ease", "hold", "loop")}
    given = {name: value for name, value in given.items() if value is not None}
    if "frames" in given:
        given |= {"exact_frames": True, "hold": given.get("hold", 0)}
    film_with, values, chosen = _loaded(spec, source, sweep, output, given, values, quiet)
    count, scheduler = worker_count(workers), checked_scheduler(scheduler)
    automatic = shared_options.automatic(values, chosen, tolerance, dry_run)
    file = output or Path(f"{'movie' if spec == '-' else Path(source or spec or '').stem}.mp4")
    rendering = movie_rendering(file, chosen) if part is None else Rendering(**of_movie(chosen))
    made = film_with(values if automatic is None else {**values, "sheet": "detailed"}, rendering.quality)
    if part is not None:
        _check_shard(part, scheduler, output)
        check_views(made.scenes, rendering)
    else:
        # a dry run writes nothing: then the default output may be the source
        own = [] if spec in SCENES or dry_run and not output else [source or spec_file(str(spec))]
        file = planned(made, file, rendering, own).output
        check_unasked([] if output or dry_run else [file])
    if automatic is not None:
        sheet, choice = automatic.choose(
            made.fitted(rendering.size).scenes, {**of_movie(chosen), "bits": rendering.bits}, quiet, scheduler
        )
        made, rendering = film_with({**values, **sheet}, rendering.quality), rendering.replace(**choice)
    made = made.fitted(rendering.size)
    plan = Plan(made, rendering, file)
    scenes, sampled = _shard(made.scenes, rendering if part else plan.shown[0], part)
    # with --sheet auto, no parameter of the prisms is without effect: it always renders the prisms, to compare
    used = dict.fromkeys(made.swept) | values if automatic is None else {}
    if not shared_options.ready(scenes, sampled, used, dry_run, quiet):
        return
    if part is not None:
        return _render_shard(part, scenes, sampled, count, quiet)
    plan.make(count, scheduler, not quiet)
    if not quiet:
        wrote(file, len(sequence(file, len(made.scenes))))


def _loaded(
    spec: str | None,
    source: Path | None,
    sweeps: Sequence[str],
    output: Path | None,
    given: Values,
    values: Values,
    quiet: bool,
) -> tuple[Callable[[Values, str], Film], Values, Values]:
    """Return the movie with these values of its spec, and the values of scenes and of the rendering. Raises InputError.

    The movie is a function: it returns the film for values of the scenes and for a quality.
    """
    if source is None:
        if spec is None:
            raise InputError(
                "spec: missing; allowed: a TOML file, a movie's name, a scene with --sweep, or --from FILE"
            )
        values, rendering = shared_options.split(values)
        loaded = _movie_of(spec, sweeps, given, {name: value for name, value in values.items() if value != "auto"})
        return lambda values, quality: film(loaded.with_fixed(values), quality, {}), values, rendering

    of_spec = {name: value for name, value in given.items() if name != "frame_rate"}
    for name, value in {"spec": spec, "sweep": sweeps or None, **of_spec}.items():
        if value is not None:
            raise InputError(f"{name} = {value!r}: not with --from, which makes the same frames; allowed: one of them")
    notes = "note" not in values
    record, scenes, values = shared_options.again(source, output, values, quiet)
    if record.frame_rate is None:
        raise InputError(f"from = {str(source)!r}: a picture; allowed: a movie")
    rate = FilmOptions(frame_rate=given.get("frame_rate", record.frame_rate)).frame_rate
    title = one_line(record.title or "")[:200] or None  # if it is the name of a file, it can be longer
    values, rendering = shared_options.split(values)
    texts = record.notes if notes else ()

    def made(values: Values, _: str) -> Film:
        return Film([scene.replace(**values) for scene in scenes], rate, title, notes=texts)

    return made, values, rendering


def _movie_of(spec: str, sweeps: Sequence[str], values: Values, fixed: Values) -> MovieSpec:
    """Return the movie of a spec, or of a scene and its sweeps, with these values of the spec and the scene.

    Raises InputError.
    """
    if sweeps and spec in SCENES:
        return MovieSpec.of_sweeps(spec, sweeps, {**values, "fixed": fixed})
    if not sweeps and spec in SCENES and not Path(spec).is_file() and not (MOVIES / f"{spec}.toml").exists():
        raise InputError(f"{spec}: a scene, no movie spec; allowed: with sweeps, such as --sweep alpha=0:180")
    return MovieSpec.load(spec, fixed, sweeps).replace(**values)


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
