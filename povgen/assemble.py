"""From a spec to its movie."""

from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

from povgen import __version__, cache, encode, povray
from povgen.errors import InputError, validated
from povgen.frames import picture, render_all
from povgen.output import checked_output, save
from povgen.rendering import Rendering
from povgen.spec import MovieSpec


def movie(
    spec: MovieSpec | str | Path,
    output: str | Path,
    *,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    scheduler: str | None = None,
    **options,
) -> Path:
    """Render a movie to .mp4, .webm or .gif; returns its path, which names it only when it is whole.

    Options: those of `Rendering`. `done` is called after each frame. `scheduler` is the address of a Dask
    scheduler, whose workers render in place of this machine.
    Raises InputError for what cannot be before anything is rendered, PovrayError where POV-Ray fails.
    """
    if not isinstance(spec, MovieSpec):
        spec = MovieSpec.load(spec)
    rendering = validated(Rendering, options)
    scenes = spec.scenes(rendering.quality)
    rate = spec.rate(rendering.quality)
    output = checked_output(Path(output), encode.FORMATS)
    if output.suffix.lower() == ".gif" and rate > encode.FASTEST_GIF:
        raise InputError(
            f"frame_rate = {rate:g}: too fast for a GIF; allowed: up to {encode.FASTEST_GIF} frames a second"
        )
    sampling = "off" if rendering.antialias is None else ",".join(f"{x:g}" for x in rendering.antialias)
    tags = {
        "title": spec.title,
        "comment": spec.model_dump_json(exclude_none=True),
        "description": f"povgen {__version__}, POV-Ray {povray.version()}, antialias {sampling}",
    }
    target = output.resolve()
    with ExitStack() as opened:
        cluster = None
        if scheduler is not None:
            from povgen.cluster import Cluster

            cluster = opened.enter_context(Cluster(scheduler))
            workers = workers or cluster.frames
        frames = render_all(scenes, rendering, workers, done, cluster)
        folder = opened.enter_context(cache.work())  # whose size is counted if povgen is killed
        opened.enter_context(closing(frames))
        part = folder / f"movie{output.suffix.lower()}"
        pictures = (picture(frame, scene, rendering) for frame, scene in zip(frames, scenes, strict=True))
        encode.encode(pictures, part, rate, tags)
        save(part, target)
    return output
