"""Make a movie from its spec."""

import logging
import os
import re
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple, Unpack

from pydantic import Field

from povgen import stopping
from povgen.errors import InputError, one_line, shown
from povgen.files import as_path, check_new_folder, checked_output, output_folder, temporary_folder
from povgen.progress import bar
from povgen.record import MAX_FRAMES, check_unasked, in_png, recorded_call, save
from povgen.rendering.parallel import checked_scheduler, worker_count
from povgen.rendering.views import views
from povgen.scene.scene import Scene, checked_scenes
from povgen.scene.scenes import input_files
from povgen.scene.spec import FrameRate, MovieSpec, Title, spec_file
from povgen.settings import Options, Rendering
from povgen.validation import Model, as_flag, is_several
from povgen.video import encode
from povgen.video.side import MOST
from povgen.video.still import pictures, record_of


class FilmOptions(Model):
    frame_rate: FrameRate = Field(default=25, description="frames a second, 0.1 to 120")
    title: Title | None = Field(default=None, description="the movie's title, one line of up to 200 characters")


@dataclass(frozen=True)
class Movie:
    """A movie's file, which Jupyter plays, or a path such as frames/%04d.png. Functions that take a path accept it."""

    path: Path

    def __post_init__(self) -> None:
        path = as_path(self.path, [*encode.FORMATS, ".png"], "path")
        object.__setattr__(self, "path", path)  # the class is frozen

    def __fspath__(self) -> str:
        return str(self.path)

    def _repr_html_(self) -> str | None:
        """Return HTML that holds the movie itself, so that a saved notebook plays it as well; None for PNG files.

        Raises InputError if the file cannot be read.
        """
        if self.path.suffix.lower() == ".png":
            return None
        try:
            kind, data = self.path.suffix.lower()[1:], b64encode(self.path.read_bytes()).decode()
        except (OSError, ValueError) as error:  # ValueError: a NUL in its name
            reason = getattr(error, "strerror", error)
            raise InputError(f"path = {str(self.path)!r}: {reason}; allowed: a movie's file") from None
        if kind in ("gif", "webp"):
            return f'<img src="data:image/{kind};base64,{data}">'
        return f'<video controls loop src="data:video/{kind};base64,{data}"></video>'


@recorded_call
def movie(
    spec: MovieSpec | str | Path | Iterable[Scene],
    output: str | Path,
    *,
    frame_rate: float | None = None,
    title: str | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = True,
    **options: Unpack[Options],
) -> Movie:
    """Render a movie to .mp4, .webm, .webp or .gif. Jupyter plays the result. The file is written atomically.

    If `caption` is not given, a short caption below the picture says what moves, and the spec's overlay, side view and
    note are drawn. An option `overlay`, `side_view` or `note` replaces the spec's value. If `caption` is given, the
    spec's values are not used. With an output such as frames/%04d.png, every frame becomes a PNG file: frames/0001.png
    and so on. These files show only what the options ask for. Their folder is made if it is missing. No file is written
    before all frames are rendered.

    `spec` is a MovieSpec, the name of one of povgen's own movies, the path of a TOML file, or the scenes of all frames.
    `frame_rate`, in frames a second, and `title` replace the spec's. For scenes the defaults are 25 and the file's
    name. `workers` frames are rendered at once. `scheduler` is the address of a Dask scheduler, whose workers then
    render instead of this machine. `progress=False` shows no progress bar. Other options are the fields of `Rendering`.
    Raises InputError for a request that is not allowed, before anything is rendered. Raises PovrayError if POV-Ray
    fails. Raises OSError if the encoder fails or the disk is full.
    """
    rendering, progress = Rendering(**options), as_flag("progress", progress)
    workers, scheduler = worker_count(workers), checked_scheduler(scheduler)
    given: dict[str, Any] = {"frame_rate": frame_rate, "title": title}
    given = {name: value for name, value in given.items() if value is not None}
    return planned(film(spec, rendering.quality, given), output, rendering).make(workers, scheduler, progress)


class Film(NamedTuple):
    """The scenes of a movie's frames, and what else its spec states."""

    scenes: list[Scene]
    rate: float  # frames a second
    title: str | None = None
    drawn: Mapping[str, Any] = {}  # overlay, side_view and note, which are for a movie without a given caption
    files: Sequence[str | Path | int] = ()  # that were read
    swept: Sequence[str] = ()  # the names of parameters


def film(spec: object, quality: str, given: Mapping[str, Any]) -> Film:
    """Return the film of a `MovieSpec`, of a movie's name or file, or of scenes. Raises InputError.

    `given` may have a frame_rate and a title, which replace the spec's.
    """
    if isinstance(spec, (MovieSpec, str, Path)):
        loaded = (spec if isinstance(spec, MovieSpec) else MovieSpec.load(spec)).replace(**given)
        drawn = {name: getattr(loaded, name) for name in ("overlay", "side_view", "note")}
        files = [] if isinstance(spec, MovieSpec) else [spec_file(spec)]
        swept = [sweep.parameter for sweep in loaded.sweep]
        return Film(loaded.scenes(quality), loaded.rate(quality), loaded.title, drawn, files, swept)
    if not is_several(spec):
        raise InputError(f"spec = {shown(spec)}: allowed: a MovieSpec, a movie's name or file, or scenes")
    options = FilmOptions(**given)
    scenes = checked_scenes(spec, MAX_FRAMES)
    if not scenes:
        raise InputError(f"no scenes; allowed: 1 to {MAX_FRAMES}")
    return Film(scenes, options.frame_rate, options.title)


@dataclass(frozen=True)
class Plan:
    """A movie that can be made: all that a user can get wrong is checked (`planned`)."""

    film: Film
    rendering: Rendering
    output: Path

    def make(self, workers: int | None = None, scheduler: str | None = None, progress: bool = True) -> Movie:
        """Render the movie, as `movie` does, and write its files."""
        film, output, target = self.film, self.output, self.output.resolve()
        files = sequence(output, len(film.scenes))
        rendering = self.rendering
        if rendering.caption is None and not files:
            drawn = {name: value for name, value in film.drawn.items() if name not in rendering.model_fields_set}
            rendering = rendering.replace(caption="short", **drawn)
        record = record_of(film.scenes, rendering, film.title or output.stem, film.rate)

        with ExitStack() as opened:
            frames = len([*groupby(film.scenes)])
            done = opened.enter_context(bar(one_line(output.name), frames, not progress))
            folder = opened.enter_context(temporary_folder())
            made = pictures(film.scenes, rendering, workers, scheduler, done, movie=True)
            opened.enter_context(closing(made))
            if files:
                # each record states the antialiasing of the whole movie; for its scene alone it could differ
                records = (record_of([scene], record.rendering) for scene in film.scenes)
                pngs = (in_png(encode.png(frame), its) for frame, its in zip(made, records, strict=True))
                _save_sequence(pngs, folder, [target.with_name(file.name) for file in files])
            else:
                part = folder / f"movie{output.suffix.lower()}"
                encode.encode(made, part, film.rate, record)
                save(part, target)
        if files and (further := target.with_name(output.name % (len(files) + 1))).exists():
            text = f"povgen: warning: {further.name} was there before: it is not a frame of this movie"
            logging.getLogger("povgen").warning(text)
        return Movie(target)


def planned(film: Film, output: str | Path, rendering: Rendering, inputs: Iterable[str | Path | int] = ()) -> Plan:
    """Return the plan of a movie. Raises InputError if it cannot be made, or not be written there.

    `inputs` are files that povgen reads, besides those of the film.
    """
    stopping.keeps_frames = True  # also those of a run before
    check_views(film.scenes, rendering)
    inputs = [*inputs, *film.files, *input_files(film.scenes)]
    return Plan(film, rendering, checked_movie(output, len(film.scenes), film.rate, rendering, inputs))


def _save_sequence(pngs: Iterable[bytes], folder: Path, files: Sequence[Path]) -> None:
    """Write PNG files, but none of them before all are there: until then they are in another folder."""
    parts = [folder / file.name for file in files]
    for part, png in zip(parts, pngs, strict=True):
        part.write_bytes(png)
    with output_folder(files[0].parent):
        for part, file in zip(parts, files, strict=True):
            save(part, file)


def sequence(output: Path, frames: int) -> list[Path]:
    """Return the PNG files of a path such as frames/%04d.png, whose numbers begin with 1; none for a movie's file.

    Raises InputError for a PNG file without a number.
    """
    if output.suffix.lower() != ".png":
        return []
    if re.fullmatch(r"[^%]*%(0[1-9])?d[^%]*", output.name) is None:
        plain = re.sub("%(-?[0-9]*[disux](?![a-z]))?", "", output.stem)
        allowed = f"a name with a number, such as {plain}%04d.png, for a PNG file of every frame"
        raise InputError(f"output = {str(output)!r}: one picture; allowed: {', '.join(encode.FORMATS)}, or {allowed}")
    return [output.with_name(output.name % number) for number in range(1, frames + 1)]


def check_views(scenes: Sequence[Scene], rendering: Rendering) -> None:
    """Raise InputError if a movie cannot show the scenes' `views`."""
    if rendering.is_light:
        raise InputError(f"bits = {rendering.bits}: a movie has 8; allowed: 8, or a picture")
    if any(scene.background == "transparent" for scene in scenes):
        raise InputError("background = 'transparent': a movie has no transparency; allowed: 'sky', 'black' or 'white'")
    for scene in scenes:
        views(scene, rendering)


def checked_movie(
    output: str | Path, frames: int, rate: float, rendering: Rendering, inputs: Iterable[str | Path | int]
) -> Path:
    """Return the path if the movie can be written there, in the format of its suffix. Otherwise raise InputError.

    The inputs are the files that povgen reads for the movie.
    """
    output = as_path(output, [*encode.FORMATS, ".png"], "output")
    if files := sequence(output, frames):
        if not os.path.lexists(output.parent):  # it is made when all frames are there
            check_new_folder(output, files[-1].name)
            return output
        inputs = [*inputs]
        for file in files:
            if file in (files[0], files[-1]) or os.path.lexists(file):  # the last one has the longest name
                checked_output(file, [".png"], inputs=inputs)
        check_unasked(files)
        return output
    output = checked_output(output, encode.FORMATS, inputs=inputs)
    width, height = rendering.size
    if rendering.side_view:
        height += 2 * round(MOST * height / 2)  # at most
    width *= 2 if rendering.stereo == "pair" else 1
    encode.check_size(output.suffix.lower(), width, height)
    if output.suffix.lower() == ".gif":
        encode.check_gif(frames, rate, width * height)
    else:
        encode.check_encoder(output.suffix.lower())
    return output
