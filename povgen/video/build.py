"""Make a movie from its spec."""

import logging
import os
import re
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from itertools import repeat
from mimetypes import guess_type
from pathlib import Path
from typing import Any, NamedTuple, Unpack

from pydantic import Field

from povgen import stopping
from povgen.errors import InputError, one_line, shown
from povgen.files import as_path, check_new_folder, checked_output, output_folder, temporary_folder
from povgen.progress import bar
from povgen.record import MAX_FRAMES, PICTURES, check_unasked, recorded_call, save
from povgen.rendering import light
from povgen.rendering.parallel import checked_scheduler, worker_count
from povgen.rendering.views import fitted, views
from povgen.scene.presets import input_files
from povgen.scene.scene import Scene, checked_scenes
from povgen.scene.spec import FrameRate, MovieSpec, Title, spec_file
from povgen.settings import Note, Options, Rendering, of_movie
from povgen.validation import Model, as_flag, is_several
from povgen.video import encode
from povgen.video.side import MOST
from povgen.video.still import alike, pictures, record_of, rendering_for


class FilmOptions(Model):
    frame_rate: FrameRate = Field(default=25, description="frames a second, 0.1 to 120")
    title: Title | None = Field(default=None, description="the movie's title, one line of up to 200 characters")
    notes: tuple[Note, ...] = Field(
        default=(), description="a text for each frame, of up to 80 letters, Latin or Greek"
    )


@dataclass(frozen=True)
class Movie:
    """A movie's file, which Jupyter plays, or a path such as frames/%04d.png. Functions that take a path accept it."""

    path: Path

    def __post_init__(self) -> None:
        path = as_path(self.path, [*encode.FORMATS, *PICTURES], "path")
        object.__setattr__(self, "path", path)  # the class is frozen

    def __fspath__(self) -> str:
        return str(self.path)

    def _repr_html_(self) -> str | None:
        """Return HTML that holds the movie itself, so that a saved notebook plays it as well; None for pictures.

        Raises InputError if the file cannot be read.
        """
        if self.path.suffix.lower() in PICTURES:
            return None
        try:
            data = b64encode(self.path.read_bytes()).decode()
        except (OSError, ValueError) as error:  # ValueError: a NUL in its name
            reason = getattr(error, "strerror", error)
            raise InputError(f"path = {str(self.path)!r}: {reason}; allowed: a movie's file") from None
        kind = guess_type(f"a{self.path.suffix.lower()}", strict=False)[0]
        if str(kind).startswith("image"):
            return f'<img src="data:{kind};base64,{data}">'
        return f'<video controls loop src="data:{kind};base64,{data}"></video>'


@recorded_call
def movie(
    spec: MovieSpec | str | Path | Iterable[Scene],
    output: str | Path,
    *,
    frame_rate: float | None = None,
    title: str | None = None,
    notes: Sequence[str] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = True,
    **options: Unpack[Options],
) -> Movie:
    """Render a movie to a file such as a.mp4 or a.gif. Jupyter plays the result. The file is written atomically.

    If `caption` is not given, a short caption below the picture says what moves, and the spec's overlay, side view and
    note are drawn. An option `overlay`, `side_view` or `note` replaces the spec's value. If `caption` is given, the
    spec's values are not used. With an output such as frames/%04d.png, every frame becomes a PNG file: frames/0001.png
    and so on; with frames/%04d.exr an EXR file of linear light. PNG files with bits=16 are finer. These files show only
    what the options ask for. Their folder is made if it is missing. No file is written before all frames are rendered.

    `spec` is a MovieSpec, the name of one of povgen's own movies, the path of a TOML file, or the scenes of all frames.
    `frame_rate`, in frames a second, and `title` replace the spec's. For scenes the defaults are 25 and the file's
    name, and `notes` may have the note of each frame. `workers` frames are rendered at once. `scheduler` is the address
    of a Dask scheduler, whose workers then render instead of this machine. `progress=False` shows no progress bar.
    Other options are the fields of `Rendering`. Raises InputError for a request that is not allowed, before anything is
    rendered. Raises PovrayError if POV-Ray fails. Raises OSError if the encoder fails or the disk is full.
    """
    rendering, progress = movie_rendering(output, options), as_flag("progress", progress)
    workers, scheduler = worker_count(workers), checked_scheduler(scheduler)
    given: dict[str, Any] = {"frame_rate": frame_rate, "title": title, "notes": notes}
    given = {name: value for name, value in given.items() if value is not None}
    made = film(spec, rendering.quality, given).fitted(rendering.size)
    return planned(made, output, rendering).make(workers, scheduler, progress)


class Film(NamedTuple):
    """The scenes of a movie's frames, and what else its spec states."""

    scenes: list[Scene]
    rate: float  # frames a second
    title: str | None = None
    drawn: Mapping[str, Any] = {}  # overlay, side_view and note, which are for a movie without a given caption
    notes: Sequence[str] = ()  # of the frames; those of a spec are also for a movie without a given caption
    files: Sequence[str | Path | int] = ()  # that were read
    swept: Sequence[str] = ()  # the names of parameters

    def fitted(self, size: tuple[int, int]) -> "Film":
        """Return the film with default views for pictures of this size: `views.fitted`."""
        return self._replace(scenes=fitted(self.scenes, size))


def film(spec: object, quality: str, given: Mapping[str, Any]) -> Film:
    """Return the film of a `MovieSpec`, of a movie's name or file, or of scenes. Raises InputError.

    `given` may have a frame_rate and a title, which replace the spec's, and the notes of scenes.
    """
    if isinstance(spec, (MovieSpec, str, Path)):
        if "notes" in given:
            raise InputError("notes: given with a spec, which states its own; allowed: with scenes")
        loaded = (spec if isinstance(spec, MovieSpec) else MovieSpec.load(spec)).replace(**given)
        drawn = {name: getattr(loaded, name) for name in ("overlay", "side_view", "note")}
        files = [] if isinstance(spec, MovieSpec) else [spec_file(spec)]
        swept = [sweep.parameter for sweep in loaded.sweep]
        texts = loaded.texts(quality)
        return Film(loaded.scenes(quality), loaded.rate(quality), loaded.title, drawn, texts, files, swept)
    if not is_several(spec):
        raise InputError(f"spec = {shown(spec)}: allowed: a MovieSpec, a movie's name or file, or scenes")
    options = FilmOptions(**given)
    scenes = checked_scenes(spec, MAX_FRAMES)
    if not scenes:
        raise InputError(f"no scenes; allowed: 1 to {MAX_FRAMES}")
    if len(options.notes) not in (0, len(scenes)):
        raise InputError(f"notes: {len(options.notes)} texts for {len(scenes)} frames; allowed: one for each")
    return Film(scenes, options.frame_rate, options.title, notes=options.notes)


@dataclass(frozen=True)
class Plan:
    """A movie that can be made: all that a user can get wrong is checked (`planned`)."""

    film: Film
    rendering: Rendering
    output: Path

    @property
    def shown(self) -> tuple[Rendering, Sequence[str]]:
        """The rendering and the notes of the frames, with what the film's spec states."""
        rendering, notes = self.rendering, self.film.notes
        # a movie with a caption, and numbered pictures, show only what the options ask for
        is_plain = rendering.caption is not None or bool(sequence(self.output, len(self.film.scenes)))
        if self.film.drawn and (is_plain or "note" in rendering.model_fields_set):
            notes = ()
        if not is_plain:
            drawn = {name: value for name, value in self.film.drawn.items() if name not in rendering.model_fields_set}
            rendering = rendering.replace(caption="short", **drawn)
        return rendering, notes

    def make(self, workers: int | None = None, scheduler: str | None = None, progress: bool = True) -> Movie:
        """Render the movie, as `movie` does, and write its files."""
        film, output, target = self.film, self.output, self.output.resolve()
        files = sequence(output, len(film.scenes))
        rendering, notes = self.shown
        record = record_of(film.scenes, rendering, film.title or output.stem, film.rate, notes)

        with ExitStack() as opened:
            frames = len(alike(film.scenes, notes))
            done = opened.enter_context(bar(one_line(output.name), frames, not progress))
            folder = opened.enter_context(temporary_folder())
            made = pictures(film.scenes, rendering, workers, scheduler, done, movie=True, notes=notes)
            opened.enter_context(closing(made))
            if files:
                # each record states the antialiasing of the whole movie; for its scene alone it could differ
                each = zip(film.scenes, notes or repeat(rendering.note))  # noqa: B905  (repeat has no end)
                records = (record_of([scene], record.rendering.replace(note=note)) for scene, note in each)
                to_file = encode.PICTURES[output.suffix.lower()]
                made_files = (to_file(frame, its) for frame, its in zip(made, records, strict=True))
                _save_sequence(made_files, folder, [target.with_name(file.name) for file in files])
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
    if film.notes and rendering.is_light and not film.drawn:
        raise InputError(f"bits = {rendering.bits}: notes are drawn with 8 bits; allowed: bits = 8, or without notes")
    inputs = [*inputs, *film.files, *input_files(film.scenes)]
    return Plan(film, rendering, checked_movie(output, len(film.scenes), film.rate, rendering, inputs))


def _save_sequence(pictures: Iterable[bytes], folder: Path, files: Sequence[Path]) -> None:
    """Write files of pictures, but none of them before all are there: until then they are in another folder."""
    parts = [folder / file.name for file in files]
    for part, picture in zip(parts, pictures, strict=True):
        part.write_bytes(picture)
    with output_folder(files[0].parent):
        for part, file in zip(parts, files, strict=True):
            save(part, file)


def sequence(output: Path, frames: int) -> list[Path]:
    """Return the files of a path such as frames/%04d.png, whose numbers begin with 1; none for a movie's file.

    Raises InputError for the file of a picture, without a number.
    """
    if output.suffix.lower() not in PICTURES:
        return []
    if re.fullmatch(r"[^%]*%(0[1-9])?d[^%]*", output.name) is None:
        plain = re.sub("%(-?[0-9]*[disux](?![a-z]))?", "", output.stem)
        kind, _ = PICTURES[output.suffix.lower()]
        allowed = f"a name with a number, such as {plain}%04d{output.suffix}, for {kind} of every frame"
        raise InputError(f"output = {str(output)!r}: one picture; allowed: {', '.join(encode.FORMATS)}, or {allowed}")
    return [output.with_name(output.name % number) for number in range(1, frames + 1)]


def movie_rendering(output: object, options: Mapping[str, object]) -> Rendering:
    """Return the rendering for a movie's file, or for numbered pictures. Raises as `rendering_for`."""
    suffix = as_path(output, [*encode.FORMATS, *PICTURES], "output").suffix.lower()
    options = of_movie(options)
    rendering = rendering_for(output, options) if suffix in PICTURES else Rendering(**options)
    if rendering.is_light and suffix not in PICTURES:
        raise InputError(
            f"bits = {rendering.bits}: a movie has 8; allowed: 8, or an output such as frames/%04d.png (16) or "
            "frames/%04d.exr (32)"
        )
    if rendering.bits == 32:
        light.exr()  # raises an error before anything is rendered
    return rendering


def check_views(scenes: Sequence[Scene], rendering: Rendering) -> None:
    """Raise InputError if a movie cannot show the scenes' `views`."""
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
    output = as_path(output, [*encode.FORMATS, *PICTURES], "output")
    if files := sequence(output, frames):
        if not os.path.lexists(output.parent):  # it is made when all frames are there
            check_new_folder(output, files[-1].name)
            return output
        inputs = [*inputs]
        for file in files:
            if file in (files[0], files[-1]) or os.path.lexists(file):  # the last one has the longest name
                checked_output(file, PICTURES, inputs=inputs)
        check_unasked(files)
        return output
    output = checked_output(output, encode.FORMATS, inputs=inputs)
    width, height = rendering.size
    if rendering.side_view and not rendering.is_wide:
        height += 2 * round(MOST * height / 2)  # at most
    width *= 2 if rendering.stereo == "pair" else 1
    encode.check_size(output.suffix.lower(), width, height)
    if output.suffix.lower() == ".gif":
        encode.check_gif(frames, rate, width * height)
    else:
        encode.check_encoder(output.suffix.lower())
    return output
