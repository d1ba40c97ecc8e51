"""Make a movie from its spec."""

import logging
from base64 import b64encode
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field

from povgen.errors import InputError, shown
from povgen.files import as_path, checked_output, save, unless_removed
from povgen.model import Model
from povgen.progress import bar
from povgen.rendering import cache, povray
from povgen.rendering.frames import render_all
from povgen.rendering.parallel import checked_scheduler, worker_count
from povgen.rendering.views import views
from povgen.scene.models import Scene, checked_scene, piece_files
from povgen.scene.spec import FrameRate, MovieSpec, spec_file
from povgen.settings import Rendering
from povgen.version import __version__
from povgen.video import encode
from povgen.video.still import picture


class _FrameRate(Model):
    frame_rate: FrameRate = Field(25, description="frames a second, 0.1 to 120")


@dataclass(frozen=True)
class Movie:
    """A movie's file. Jupyter plays it. Functions that take a path accept it."""

    path: Path

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", as_path(self.path, encode.FORMATS, "path"))  # the class is frozen

    def __fspath__(self) -> str:
        return str(self.path)

    def _repr_html_(self) -> str:
        """Return HTML that holds the movie itself, so that a saved notebook plays it as well.

        Raises InputError if the file cannot be read.
        """
        try:
            kind, data = self.path.suffix.lower()[1:], b64encode(self.path.read_bytes()).decode()
        except (OSError, ValueError) as error:  # ValueError: a NUL in its name
            reason = getattr(error, "strerror", error)
            raise InputError(f"path = {str(self.path)!r}: {reason}; allowed: a movie's file") from None
        if kind == "gif":
            return f'<img src="data:image/gif;base64,{data}">'
        return f'<video controls loop src="data:video/{kind};base64,{data}"></video>'


def movie(
    spec: MovieSpec | str | Path | Sequence[Scene],
    output: str | Path,
    *,
    frame_rate: float | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = True,
    **options: object,
) -> Movie:
    """Render a movie to .mp4, .webm or .gif. Jupyter plays the result. The file is written atomically.

    The movie is a spec, the name of one of povgen's own movies, the path of a TOML file, or a list with the scene of
    every frame. `frame_rate` replaces the spec's; for a list it is 25 a second unless given. `workers` frames are
    rendered at once. `scheduler` is the address of a Dask scheduler, whose workers then render instead of this
    machine. `progress=False` shows no progress bar. Other options are the fields of `Rendering`.
    Raises InputError for a request that is not allowed, before anything is rendered. Raises PovrayError if POV-Ray
    fails.
    """
    rendering = Rendering(**options)
    workers, scheduler = worker_count(workers), checked_scheduler(scheduler)
    if isinstance(spec, (list, tuple)):
        rate = _FrameRate(**{} if frame_rate is None else {"frame_rate": frame_rate}).frame_rate
        scenes = [checked_scene(scene) for scene in spec]
        if not scenes:
            raise InputError("no scenes; allowed: one or more")
        title, comment, inputs = "", f"first frame: {scenes[0].model_dump_json(exclude_none=True)}", []
    elif isinstance(spec, (MovieSpec, str, Path)):
        loaded = spec if isinstance(spec, MovieSpec) else MovieSpec.load(spec)
        inputs = [] if isinstance(spec, MovieSpec) else [spec_file(spec)]
        spec = loaded if frame_rate is None else loaded.replace(frame_rate=frame_rate)
        scenes, rate = spec.scenes(rendering.quality), spec.rate(rendering.quality)
        title, comment = spec.title, spec.model_dump_json(exclude_none=True)
    else:
        raise InputError(f"spec = {shown(spec)}: allowed: a MovieSpec, a movie's name or file, or a list of scenes")
    rendering = rendering.suited(any(scene.has_prisms for scene in scenes))
    check_views(scenes, rendering)
    output = checked_movie(output, len(scenes), rate, [*inputs, *piece_files(scenes)])
    eyes = ""
    if rendering.stereo != "none":
        eyes = f", stereo {rendering.stereo}, eyes {rendering.eye_distance:g} tiles apart"
    tags = {
        "title": title or output.stem,
        "comment": comment,
        "description": f"povgen {__version__}, POV-Ray {povray.version()}, antialias {rendering.sampling}{eyes}",
    }
    target = output.resolve()

    def write() -> None:
        with ExitStack() as opened:
            cluster = None
            if scheduler is not None:
                from povgen.rendering.cluster import Cluster

                cluster = opened.enter_context(Cluster(scheduler))
            done = opened.enter_context(bar(output.name, len(scenes), not progress))
            frames = render_all(scenes, rendering, workers or (cluster.frames if cluster else None), done, cluster)
            folder = opened.enter_context(cache.work_folder())  # `povgen cache` finds it there if povgen is killed
            opened.enter_context(closing(frames))
            part = folder / f"movie{output.suffix.lower()}"
            pictures = (picture(views, scene, rendering) for views, scene in zip(frames, scenes, strict=True))
            encode.encode(pictures, part, rate, tags)
            save(part, target)

    removed = "povgen: warning: the cache was removed; the movie is made once more"
    unless_removed(write, lambda: logging.getLogger("povgen").warning(removed))
    return Movie(target)


def check_views(scenes: Sequence[Scene], rendering: Rendering) -> None:
    """Raise InputError if a movie cannot show the scenes' `views`."""
    if any(scene.background == "transparent" for scene in scenes):
        raise InputError("background = 'transparent': a movie has no transparency; allowed: 'sky', 'black' or 'white'")
    for scene in scenes:
        views(scene, rendering)


def checked_movie(output: str | Path, frames: int, rate: float, inputs: Iterable[str | Path | int]) -> Path:
    """Return the path if the movie can be written there, in the format of its suffix. Otherwise raise InputError.

    The inputs are the files that povgen reads for the movie.
    """
    output = checked_output(output, encode.FORMATS, inputs=inputs)
    if output.suffix.lower() == ".gif":
        encode.check_gif(frames, rate)
    return output
