"""Make a movie from its spec."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from itertools import chain, cycle, islice
from pathlib import Path

from povgen import __version__
from povgen.errors import InputError, validated
from povgen.files import checked_output, save
from povgen.rendering import cache, povray
from povgen.rendering.frames import render_all
from povgen.scene.models import Scene
from povgen.scene.spec import MovieSpec
from povgen.settings import Rendering
from povgen.video import encode
from povgen.video.still import picture
from povgen.video.views import views


def movie(
    spec: MovieSpec | str | Path,
    output: str | Path,
    *,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    scheduler: str | None = None,
    **options: object,
) -> Path:
    """Render a movie to .mp4, .webm or .gif and return its path. The file is written atomically.

    Options are the fields of `Rendering`. `done` is called after each frame. `scheduler` is the address of a Dask
    scheduler, whose workers then render instead of this machine.
    Raises InputError for a request that is not allowed, before anything is rendered. Raises PovrayError if POV-Ray
    fails.
    """
    if not isinstance(spec, MovieSpec):
        spec = MovieSpec.load(spec)
    rendering = validated(Rendering, options)
    scenes = spec.scenes(rendering.quality)
    shown = movie_views(scenes, rendering)
    each = cycle([False] * (len(shown[0]) - 1) + [True])  # whether all views of a frame are finished
    output, rate = checked_movie(Path(output), spec, rendering.quality), spec.rate(rendering.quality)
    eyes = (
        ""
        if rendering.stereo == "none"
        else f", stereo {rendering.stereo}, eyes {rendering.eye_distance:g} tiles apart"
    )
    sampling = "off" if rendering.antialias is None else ",".join(f"{x:g}" for x in rendering.antialias)
    tags = {
        "title": spec.title,
        "comment": spec.model_dump_json(exclude_none=True),
        "description": f"povgen {__version__}, POV-Ray {povray.version()}, antialias {sampling}{eyes}",
    }
    target = output.resolve()
    with ExitStack() as opened:
        cluster = None
        if scheduler is not None:
            from povgen.rendering.cluster import Cluster

            cluster = opened.enter_context(Cluster(scheduler))
            workers = workers or cluster.frames
        frames = render_all(list(chain(*shown)), rendering, workers, lambda: next(each) and done(), cluster)
        folder = opened.enter_context(cache.work_folder())  # counts towards the cache's size if povgen is killed
        opened.enter_context(closing(frames))
        part = folder / f"movie{output.suffix.lower()}"
        groups = (list(islice(frames, len(shown[0]))) for _ in scenes)
        pictures = (picture(group, scene, rendering) for group, scene in zip(groups, scenes, strict=True))
        encode.encode(pictures, part, rate, tags)
        save(part, target)
    return output


def movie_views(scenes: Sequence[Scene], rendering: Rendering) -> list[list[Scene]]:
    """Return the `views` of each frame. Raises InputError if a movie cannot show them."""
    if any(scene.background == "transparent" for scene in scenes):
        raise InputError(
            "background = 'transparent': a movie has no transparency; allowed: 'scene', 'black' or 'white'"
        )
    return [views(scene, rendering) for scene in scenes]


def checked_movie(output: Path, spec: MovieSpec, quality: str) -> Path:
    """Return the path if the movie can be written there, in the format of its suffix. Otherwise raise InputError."""
    if output.suffix.lower() == ".gif":
        encode.check_gif(len(spec.sweep.values(quality)), spec.rate(quality))
    return checked_output(output, encode.FORMATS)
