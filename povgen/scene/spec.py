"""Movie specs: a TOML file with a scene, its fixed parameters, and the parameters that change from frame to frame."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, Self, get_args, get_origin

import numpy as np
from pydantic import BeforeValidator, Field, model_validator
from pydantic.fields import FieldInfo

from povgen.errors import InputError, shown
from povgen.files import own_folder
from povgen.optics.equations import Floats
from povgen.scene import files
from povgen.scene.presets import SCENES, AxialScene
from povgen.scene.room import Room, changed
from povgen.scene.scene import Scene
from povgen.scene.windows import MAX_WINDOWS, FurtherWindow, as_windows, replaced_by, with_numbers
from povgen.settings import Note, preset_of
from povgen.validation import Model, as_pair

MOVIES = own_folder("movies")
MAX_FRAMES = 10000
ROUNDING = 1e-9  # of times
Title = Annotated[str, Field(pattern=r"^[^\p{Cc}\p{Zl}\p{Zp}]{1,200}$")]
FrameRate = Annotated[float, Field(ge=0.1, le=120)]
FRAMES = 65  # of a movie that does not state it
ROOM_TABLES = {"eye", "object", "window"}  # at least one of them makes a TOML file without a scene's name a room's


def _number_or_pair(value: object) -> object:
    """Accept text such as 'X,Y', and a complex number."""
    return value if isinstance(value, str) and "," not in value else as_pair(value)


Ease = Literal["none", "start", "stop", "both"]
Value = Annotated[float | tuple[float, float], BeforeValidator(_number_or_pair)]


# the part of the way that is done in a part of the time, from 0 to 1
EASES: dict[Ease, Callable[[Floats], Floats]] = {
    "none": lambda time: time,
    "start": lambda time: 1 - np.cos(np.pi / 2 * time),
    "stop": lambda time: np.sin(np.pi / 2 * time),
    "both": lambda time: 0.5 - 0.5 * np.cos(np.pi * time),
}


class Sweep(Model):
    """A parameter that changes from frame to frame, and its values: numbers, or pairs X, Y for a point."""

    parameter: str = Field(description="the swept parameter: a number of the scene, or a point")
    start: Value | None = Field(
        default=None, description="its value in the first frame: a number, or [X, Y] for a point"
    )
    stop: Value | None = Field(default=None, description="its last value: a number, or [X, Y] for a point")
    via: Value | None = Field(
        default=None, description="its value halfway, where the movie also stays for `hold` seconds"
    )
    spacing: Literal["linear", "log"] = Field(default="linear", description="spacing of the values: linear or log")
    values: Annotated[tuple[Value, ...], Field(min_length=2, max_length=MAX_FRAMES)] | None = Field(
        default=None, description=f"its value in every frame, in place of start and stop: 2 to {MAX_FRAMES} values"
    )
    ease: Ease | tuple[Ease, Ease] | None = Field(
        default=None,
        description="where its change is gentle: none, start, stop or both; or, with `via`, two of these words, for "
        "the way to it and the way from it (default: the movie's)",
    )

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the sweep that a text states, such as alpha=0:180 or z1=1:9:log. Raises InputError."""
        name, _, ends = text.partition("=") if isinstance(text, str) else ("", "", "")
        if ":" not in ends:
            raise InputError(f"sweep = {shown(text)}: allowed: NAME=START:STOP, or with :linear or :log")
        parts = dict(zip(("start", "stop", "spacing"), ends.split(":", 2), strict=False))
        try:
            return cls(parameter=name.strip().replace("-", "_"), **parts)
        except InputError as error:
            raise InputError(f"sweep = {shown(text)}: {error}") from None

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if self.values is not None:
            if {self.start, self.stop, self.via, self.ease} != {None} or self.spacing != "linear":
                raise ValueError(
                    "values: given with start, stop, via, spacing or ease; allowed: values, or start and stop"
                )
            if len(set(self.values)) == 1:
                raise ValueError(f"values = {shown(self.values)}: all equal, nothing would move; allowed: others")
            return self
        for name, value in (("start", self.start), ("stop", self.stop)):
            if value is None:
                raise ValueError(f"{name}: missing; allowed: start and stop, or values")
        if self.via is None and isinstance(self.ease, tuple):
            raise ValueError(f"ease = {shown(self.ease)}: two words; allowed: one, or with via")
        if self.via is not None and self.via in self.ends:
            raise ValueError(f"via = {_text(self.via)}: equal to start or stop; allowed: any other value")
        if self.start == self.stop and self.via is None:
            raise ValueError(f"stop = {_text(self.stop)}: equal to start, nothing would move; allowed: any other value")
        self._check_log()
        return self

    def _check_log(self) -> None:
        if self.spacing == "log":
            given = [value for value in self.given if isinstance(value, float)]
            if len(given) < len(self.given):
                raise ValueError("spacing = 'log': not for points; allowed: linear")
            if min(given) <= 0 <= max(given):
                raise ValueError(
                    f"spacing = 'log': {min(given):g} to {max(given):g} contains 0; "
                    "allowed: all values above or all below 0, or spacing = 'linear'"
                )

    @property
    def ends(self) -> tuple[Value, Value]:
        """The first and the last value."""
        if self.values:
            return self.values[0], self.values[-1]
        assert self.start is not None and self.stop is not None  # by _check_range
        return self.start, self.stop

    @property
    def given(self) -> tuple[Value, ...]:
        """The values that are stated."""
        return self.values or tuple(value for value in (self.start, self.via, self.stop) if value is not None)

    def in_frames(self, count: int, ease: Ease = "none") -> list[Value]:
        """Return the parameter's value in each of `count` frames. `values`, if given, are returned as they are.

        `ease` says at which ends of each part, before and after `via`, the value changes slowly. It is for a sweep that
        does not state this.
        """
        if self.values:
            return list(self.values)
        if self.via is not None:
            before, after = self.ease if isinstance(self.ease, tuple) else (self.ease, self.ease)
            there = self.replace(stop=self.via, via=None, ease=before)
            back = self.replace(start=self.via, via=None, ease=after)
            return there.in_frames(count // 2 + 1, ease)[:-1] + back.in_frames(count - count // 2, ease)
        start, stop = np.atleast_1d(*self.ends)
        share = np.linspace(0, 1, count)[:, np.newaxis]
        share = EASES[self.ease or ease](share)  # type: ignore[index]  # one word, without via
        rows = start * (stop / start) ** share if self.spacing == "log" else start + (stop - start) * share
        rows[-1] = stop  # exactly: with a rounding error it could be outside the parameter's range
        return [row[0] if len(row) == 1 else tuple(row) for row in rows.tolist()]


class PartNote(Model):
    """A text in the caption during a part of a movie."""

    text: Note = Field(description="the text, up to 80 letters, Latin or Greek")
    start: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0, description="when it appears, as a part of the time from the sweeps' start to their stop, 0 to 1"
    )
    stop: Annotated[float, Field(ge=0, le=1)] = Field(default=1, description="when it disappears, likewise")

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if self.stop < self.start:
            raise ValueError(f"stop = {self.stop:g}: before start = {self.start:g}; allowed: from start to 1")
        return self


class MovieSpec(Model):
    """A movie: its title, scene, fixed parameters, swept parameters, number of frames and frame rate."""

    title: Title = Field(description="the movie's title, one line of up to 200 characters")
    # pydantic takes the names from SCENES; mypy takes only names that are written out
    scene: Literal[*SCENES] = Field(description="the scene")  # type: ignore[valid-type]
    frame_rate: FrameRate = Field(default=15, description="frames a second at quality standard, 0.1 to 120")
    frames: Annotated[int, Field(ge=2, le=MAX_FRAMES)] | None = Field(
        default=None,
        description=f"number of frames from start to stop at quality standard, 2 to {MAX_FRAMES} (default {FRAMES}, "
        "or as many as a sweep has values)",
    )
    exact_frames: bool = Field(
        default=False, description="whether `frames` is the number of frames at every quality, as with --frames"
    )
    ease: bool = Field(
        default=False, description="whether the sweeps start and stop gently; not for a sweep with `values`"
    )
    hold: Annotated[float, Field(ge=0, le=10)] = Field(
        default=0,
        description="how much longer the first picture, the last one and that at `via` are shown, 0 to 10 seconds",
    )
    overlay: bool = Field(default=False, description="whether the movie's file has the overlay")
    note: Note = Field(default="", description="a text added to the caption, up to 80 letters, Latin or Greek")
    notes: tuple[PartNote, ...] = Field(
        default=(),
        description="texts in place of the note, each during a part of the movie; a table [[notes]] for each. Where "
        "several overlap, the last one counts",
    )
    side_view: bool = Field(default=False, description="whether the movie's file has the side view")
    loop: bool = Field(default=False, description="whether the movie goes there and back, so that it can be repeated")
    fixed: dict[str, object] = Field(
        default={},
        description="the scene's fixed parameters; each window behind the first one has a table [[window]] of its own",
    )
    sweep: Annotated[tuple[Sweep, ...], Field(min_length=1)] = Field(
        description="the swept parameters; for each a table [[sweep]], with two brackets"
    )

    @model_validator(mode="after")
    def _check_sweeps(self) -> Self:
        for name in self.fixed.keys() - SCENES[self.scene].model_fields:
            raise ValueError(f"{shown(name)}: unknown; allowed: {', '.join(SCENES[self.scene].model_fields)}")
        names = [sweep.parameter for sweep in self.sweep]
        for sweep in self.sweep:
            name = sweep.parameter
            if name not in self._fields:
                raise ValueError(f"parameter = {shown(name)}: cannot be swept; allowed: {self._allowed(name)}")
            if names.count(name) > 1:
                raise ValueError(f"parameter = {shown(name)}: swept more than once; allowed: once")
            for value in sweep.given:
                if np.size(value) != (count := _numbers(self._fields[name].annotation)):
                    kind = "a number" if count == 1 else "a pair, X,Y (in a TOML file [X, Y])"
                    raise ValueError(f"{name} = {shown(value)}: allowed: {kind}")
            if len({self._rounded(name, value) for value in sweep.given}) == 1:
                raise ValueError(f"{name}: all values equal after rounding, nothing would move; allowed: other values")
        counts = {len(sweep.values) for sweep in self.sweep if sweep.values} | ({self.frames} - {None})
        if len(counts) > 1 and any(sweep.values for sweep in self.sweep):
            text = " and ".join(map(str, sorted(filter(None, counts))))
            raise ValueError(f"[[sweep]] values: {text} frames; allowed: frames and all lists of values equally long")
        if self.ease and all(sweep.values for sweep in self.sweep):
            raise ValueError("ease = True: no sweep has start and stop; allowed: ease = false, or start and stop")
        return self

    @cached_property
    def _base(self) -> Scene:
        """The scene of the fixed parameters alone."""
        return SCENES[self.scene](**self.fixed)

    @cached_property
    def _fields(self) -> dict[str, FieldInfo]:
        """The fields of what can be swept, by its names in sweeps."""
        model = SCENES[self.scene]
        found = {name: model.model_fields[name] for name in swept_numbers(model)}
        if issubclass(model, AxialScene):
            windows = FurtherWindow.model_fields | model.model_fields  # a whole number is one in the scene's fields
            return found | {name: windows[field] for name, field in WINDOW_NUMBERS.items()}
        for name, part in self._base.parts.items():
            fields = type(part).model_fields
            found |= {f"{name}.{field}": fields[field] for field, n in swept_numbers(type(part)).items() if n == 1}
        return found

    def _allowed(self, name: str) -> str:
        """Return what can be swept in place of this name: all parameters of a part, or all names of parts."""
        parts = dict.fromkeys(field.partition(".")[0] for field in self._fields if "." in field)
        if parts and (part := name.partition(".")[0]) in parts:
            return ", ".join(field for field in self._fields if field.startswith(f"{part}."))
        own = ", ".join(swept_numbers(SCENES[self.scene]))
        return f"{own}, and NAME.PARAMETER of {', '.join(parts)}" if parts else f"{own}, window2_alpha, window2_z, ..."

    @classmethod
    def load(cls, path: str | Path, fixed: Mapping[str, object] = {}, sweeps: Sequence[str] = ()) -> Self:
        """Read a movie spec: a TOML file, one of povgen's own by its name (vary-alpha), or standard input (-).

        The paths of the scene's files (pieces, profiles and pictures) are relative to the TOML file's folder. A
        warning names those that are outside of it. The values in `fixed` replace the file's. So do `sweeps`, such as
        left.alpha=0:180, which only the file of a `Room` takes. Raises InputError, which names the file, the key, the
        value and what is allowed.
        """
        own = ", ".join(spec.stem for spec in sorted(MOVIES.glob("*.toml")))
        text, name, folder = files.text_of(path, "movie spec", f"a TOML file or one of {own}", MOVIES)
        return cls.parse(text, name, folder, fixed, sweeps)

    @classmethod
    def parse(
        cls,
        text: str,
        name: str,
        folder: str | Path = "",
        fixed: Mapping[str, object] = {},
        sweeps: Sequence[str] = (),
    ) -> Self:
        """Read a movie spec from TOML text. Raises InputError, whose message begins with `name`.

        The paths of the scene's files (pieces, profiles and pictures) are relative to `folder`. The values in `fixed`
        and the `sweeps`, such as left.alpha=0:180, replace those of the text.
        """
        values = files.table_of(text, name)
        if sweeps and not is_room(values):
            raise InputError(
                f"sweep = {sweeps[0]!r}: not with the movie {name!r}; allowed: with a scene: {' or '.join(SCENES)}, or "
                "with a room's TOML file"
            )
        try:
            for key, model in (("sweep", Sweep), ("notes", PartNote)):
                if isinstance(tables := values.get(key), list):
                    values[key] = [_named(key, model, each) if isinstance(each, dict) else each for each in tables]
            if sweeps:
                values["sweep"] = [*map(Sweep.parse, sweeps)]
            values = _with_fixed_table(values, folder, fixed)
            scene = SCENES.get(str(values.get("scene")), Scene)
            for key in sorted(values.keys() & scene.model_fields.keys() - cls.model_fields.keys()):
                raise InputError(f"{key}: a parameter of the scene; allowed: in the table [fixed]")
            spec = cls(**values).with_fixed(fixed)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        stated = tuple(value for key, value in spec.fixed.items() if key not in fixed)
        files.name_files_outside(folder, name, stated)
        return spec

    @classmethod
    def of_sweeps(cls, scene: str, texts: Sequence[str], values: dict[str, object]) -> Self:
        """Return the movie of the scene with this name, with sweeps such as alpha=0:180. Raises InputError.

        `values` are other fields of `MovieSpec`, such as frames, by their names. They may be text.
        """
        sweeps = [Sweep.parse(text) for text in texts]
        return cls(title=_title(scene, sweeps), scene=scene, sweep=sweeps, **values)

    def with_fixed(self, values: Mapping[str, object]) -> Self:
        """Return the movie with these fixed parameters, added or replaced. They may be text. Raises InputError.

        What these replace is what they replace in a scene: `windows.replaced_by`.
        """
        if not isinstance(values, Mapping):
            raise InputError(f"fixed = {shown(values)}: should be a dictionary of the scene's parameters")
        glass = {"index", "glass"} & values.keys() & SCENES[self.scene].model_fields.keys()
        windows = {**self.fixed, **values}.get("window", []) if glass else []
        dropped = replaced_by(values, as_windows(windows))
        kept = {name: value for name, value in self.fixed.items() if name not in dropped}
        spec = self.replace(fixed=changed(kept, values))
        scene = spec.scenes("standard")[0]
        if scene.parts:  # the first frame's have swept numbers
            scene = spec._base
        return spec.replace(fixed={name: getattr(scene, name) for name in spec.fixed})

    def scenes(self, quality: str) -> list[Scene]:
        """Return the scene of every frame. Raises InputError if one of them is not allowed."""
        for sweep in self.sweep:
            if (name := sweep.parameter) in self.fixed:
                raise InputError(
                    f"{name} = {shown(self.fixed[name])}: also swept; allowed: one value or a sweep, not both"
                )
        count = self._frames_there(quality)
        if (every := len(self._order(quality))) > 3 * MAX_FRAMES:
            raise InputError(
                f"quality = {quality!r}: {every} frames, with loop and hold; allowed: up to {3 * MAX_FRAMES}"
            )
        if count < 3 and self._stays_halfway:
            raise InputError(f"quality = {quality!r}: {count} frames, none of them at via; allowed: frames = 3 or more")
        # Both end values are checked before the others. If they are allowed, all values between them are finite.
        for n, end in ((1, 0), (count, 1)):
            self._scene({sweep.parameter: sweep.ends[end] for sweep in self.sweep}, n, count)
        names = [sweep.parameter for sweep in self.sweep]
        ease: Ease = "both" if self.ease else "none"
        rows = zip(*(sweep.in_frames(count, ease) for sweep in self.sweep), strict=True)
        scenes = [self._scene(dict(zip(names, row, strict=True)), n, count) for n, row in enumerate(rows, 1)]
        return [scenes[n] for n in self._order(quality)]

    def texts(self, quality: str) -> list[str]:
        """Return the note of every frame, by `notes`; none if there are no `notes`."""
        last = self._frames_there(quality) - 1
        return [self._note_at(n / last) for n in self._order(quality)] if self.notes else []

    def _note_at(self, time: float) -> str:
        """Return the note at a time, a part of that from start to stop."""
        now = [note.text for note in self.notes if note.start - ROUNDING <= time <= note.stop + ROUNDING]
        return now[-1] if now else self.note

    def _order(self, quality: str) -> list[int]:
        """Return which frame from start to stop, counted from 0, each frame of the movie is."""
        count = self._frames_there(quality)
        held, way = round(self.hold * self.rate(quality)), [*range(count)]
        if self._stays_halfway:
            way[count // 2 : count // 2] = [count // 2] * held
        there = [0] * held + way + [count - 1] * held
        return there + way[-2:0:-1] if self.loop else there

    def _scene(self, swept: Mapping[str, Any], n: int, count: int) -> Scene:
        """Return the scene of a frame. Raises InputError.

        The error's message names the frame. If the fixed parameters alone are wrong, it does not. The type of a swept
        value is Any, because the scene's model says whether it is a number or a pair.
        """
        model = SCENES[self.scene]
        values = {name: self._rounded(name, x) for name, x in swept.items()}
        own = {name: x for name, x in values.items() if name in model.model_fields}
        parts = {name: x for name, x in values.items() if "." in name}
        try:
            if windows := {name: x for name, x in values.items() if name not in own | parts}:
                own["window"] = with_numbers(as_windows(self.fixed.get("window", ())), windows)
            scene = model(**{**self.fixed, **own}) if own else self._base
            return scene.with_numbers(parts) if parts else scene
        except InputError as error:
            try:
                model(**self.fixed)
            except InputError as own:
                if str(own) == str(error):
                    raise
            texts = [f", {x} = {_text(value)}" for x, value in swept.items() if not str(error).startswith(f"{x} = ")]
            raise InputError(f"frame {n} of {count}{''.join(texts)}: {error}") from None

    def _rounded(self, name: str, value: Any) -> Any:  # noqa: ANN401  (as in `_scene`)
        """Return a parameter's value. It is rounded if the parameter is a whole number, such as `prisms`."""
        return round(value) if self._fields[name].annotation is int else value

    def _frames_there(self, quality: str) -> int:
        """Return the number of frames from start to stop."""
        preset, steps = preset_of(quality), (self.frames or FRAMES) - 1
        for sweep in self.sweep:
            if sweep.values:
                return len(sweep.values)
        if self.exact_frames:
            return steps + 1
        more = preset.frame_rate / self.frame_rate if preset.frame_rate else preset.frames
        return max(round(steps * more), 1) + 1

    def count(self, quality: str) -> int:
        """Return the number of frames of the whole movie, with those for `hold` and `loop`."""
        return len(self._order(quality))

    @property
    def _stays_halfway(self) -> bool:
        """Whether `hold` also applies to the middle picture, because a sweep has `via`."""
        return any(sweep.via is not None for sweep in self.sweep)

    def rate(self, quality: str) -> float:
        """Return the number of frames a second. From start to stop, a movie takes nearly the same time at each quality.

        Raises InputError if the number is not from 0.1 to 120, as `frame_rate` has to be.
        """
        rate = preset_of(quality).frame_rate
        if self.exact_frames or any(sweep.values for sweep in self.sweep):
            return self.frame_rate
        if not rate:
            rate = self.frame_rate * ((self._frames_there(quality) - 1) / ((self.frames or FRAMES) - 1))
        if not 0.1 <= rate <= 120:
            raise InputError(
                f"frame_rate = {self.frame_rate:g}: {rate:.4g} frames a second at quality = {quality!r}; "
                "allowed: 0.1 to 120"
            )
        return rate


def spec_file(path: str | Path) -> Path | int:
    """Return the file that `MovieSpec.load` reads. It is 0, standard input, for the path "-"."""
    return files.file_of(path, MOVIES)


def is_room(values: Mapping[str, object]) -> bool:
    """Whether the values of a TOML file state a room: as the scene, or by a room's tables without a scene's name."""
    return values.get("scene", Room.name) == Room.name and not ROOM_TABLES.isdisjoint(values)


def _with_fixed_table(values: dict[str, Any], folder: str | Path, fixed: Mapping[str, object]) -> dict[str, Any]:
    """Return the values of a TOML file with those of the scene in the table [fixed], and its files in the folder.

    Above this table a file states further windows of a preset. A room's file states all of the room there; the values
    in `fixed` replace these.
    """
    own: Collection[str] = ["window"]
    more: Mapping[str, object] = {}
    if is_room(values):
        sweeps = values.get("sweep")
        title = _title(Room.name, sweeps if isinstance(sweeps, list) else [])
        values = {"title": title, "scene": Room.name, "fixed": {}, **values}
        own, more = Room.model_fields, fixed
    stated, table = {name: values[name] for name in own if name in values}, values.get("fixed", {})
    if not isinstance(table, dict):
        return values
    for name in stated.keys() & table.keys():
        raise InputError(f"{name}: stated twice, also in the table [fixed]; allowed: only above it")
    values = {name: value for name, value in values.items() if name not in stated}
    return {**values, "fixed": changed(files.in_folder({**stated, **table}, folder), more)}


def swept_numbers(scene: type[Model]) -> dict[str, int]:
    """Return the parameters of a class of scenes, objects or windows that can be swept.

    For each name, the result has how many numbers a value has: 1, or 2 for a point.
    """
    counts = {name: _numbers(field.annotation) for name, field in scene.model_fields.items()}
    return {name: count for name, count in counts.items() if count in (1, 2)}


def _numbers(kind: object) -> int:
    """Return how many numbers a value of an annotated type has, 0 if none. A tuple of any length counts as 1."""
    if kind in (int, float):
        return 1
    origin, parts = get_origin(kind), get_args(kind)
    if origin is dict:
        return 0
    if origin is Annotated:
        return _numbers(parts[0])
    counts = [_numbers(part) for part in parts if part not in (..., NoneType)] if origin is not Literal else [0]
    return sum(counts) if origin is tuple else max(counts, default=0)  # otherwise a union


# What can be swept of the windows behind the first one: window2_alpha, window2_z, window3_alpha, ...
WINDOW_NUMBERS = {
    f"window{n}_{name}": name
    for n in range(2, MAX_WINDOWS + 1)
    for name, count in swept_numbers(FurtherWindow).items()
    if count == 1
}


def _title(scene: str, sweeps: Iterable[object]) -> str:
    ends = [(each.parameter, *map(_text, each.ends)) for each in sweeps if isinstance(each, Sweep)]
    return ", ".join([scene, *(f"{name} from {start} to {stop}" for name, start, stop in ends)])[:200]


def _text(value: object) -> str:
    """Return a value of a sweep, a number or a pair, as it is written on the command line."""
    return ",".join(f"{x:.6g}" for x in (value if isinstance(value, tuple) else (value,)))


def _named(key: str, model: type[Model], table: dict[str, object]) -> Model:
    """Return the model of a TOML table. The message of an InputError begins with the table's name."""
    try:
        return model(**table)
    except InputError as error:
        raise InputError(f"[[{key}]] {error}") from None
