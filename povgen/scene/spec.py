"""A movie as its TOML file describes it: a scene, what is fixed in it and what is swept."""

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from povgen.errors import InputError, shown, validated
from povgen.scene.models import SCENES, Scene
from povgen.settings import QUALITIES

MOVIES = Path(__file__).parents[1] / "movies"
LONGEST = 2**14  # bytes of a spec; what is much longer can take Python's reader of TOML minutes


class Sweep(BaseModel):
    """The parameter that changes from frame to frame."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    parameter: Literal["alpha", "z1", "z2"] = Field(description="the parameter that is swept")
    start: float = Field(description="its value in the first frame")
    stop: float = Field(description="its value in the last frame")
    frames: Annotated[int, Field(ge=2, le=10000)] = Field(description="number of frames at quality paper, 2 to 10000")
    spacing: Literal["linear", "log"] = Field("linear", description="of the values: linear or log")

    @model_validator(mode="after")
    def _check_range(self):
        if self.start == self.stop:
            raise ValueError(f"stop = {self.stop:g}: nothing would move; allowed: any value but start's")
        if self.spacing == "log" and min(self.start, self.stop) <= 0 <= max(self.start, self.stop):
            raise ValueError(
                f"spacing = 'log': from start = {self.start:g} to stop = {self.stop:g} it would pass through 0; "
                "allowed: start and stop both above or both below 0, or spacing = 'linear'"
            )
        return self

    def values(self, quality: str) -> list[float]:
        """The parameter's value in each frame. A quality scales the number of steps between frames."""
        count = round((self.frames - 1) * QUALITIES[quality]["frames"]) + 1
        space = np.geomspace if self.spacing == "log" else np.linspace
        return space(self.start, self.stop, max(count, 2)).tolist()


class MovieSpec(BaseModel):
    """A movie: title, scene, fixed parameters, swept parameter and frame rate."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    title: Annotated[str, Field(pattern=r"^[^\p{Cc}\p{Zl}\p{Zp}]{1,200}$")] = Field(
        description="the movie's title, one line of up to 200 characters"
    )
    scene: Literal[*SCENES] = Field(description="the scene")  # type: ignore[valid-type]
    frame_rate: Annotated[float, Field(ge=0.1, le=120)] = Field(
        description="frames a second at quality paper, 0.1 to 120"
    )
    fixed: dict[str, Any] = Field({}, description="the scene's fixed parameters")
    sweep: Sweep = Field(description="the swept parameter")

    @classmethod
    def load(cls, path: str | Path) -> "MovieSpec":
        """The movie described by a TOML file, by one of povgen's own (vary-alpha), or by standard input (-).

        Raises InputError, which names the file, the key, its value and what is allowed.
        """
        stdin = str(path) == "-"
        name = "standard input" if stdin else str(path) or "''"
        file = Path(path)
        try:
            if not stdin and file.suffix != ".toml" and not file.exists():
                file = MOVIES / f"{path}.toml"
            with open(0, "rb", closefd=False) if stdin else file.open("rb") as opened:
                data = opened.read(LONGEST + 1)
            if len(data) > LONGEST:
                raise ValueError(f"longer than {LONGEST} bytes")
            text = data.decode("utf-8-sig")  # some editors begin a file with a byte order mark
        except (OSError, ValueError) as error:  # ValueError: too long, not UTF-8, or a NUL in the name
            own = ", ".join(spec.stem for spec in sorted(MOVIES.glob("*.toml")))
            reason = "not UTF-8" if isinstance(error, UnicodeError) else getattr(error, "strerror", error)
            raise InputError(f"{name}: no movie spec: {reason}; allowed: a TOML file or one of {own}") from None
        return cls.parse(text, name)

    @classmethod
    def parse(cls, text: str, name: str) -> "MovieSpec":
        """The movie described by TOML text. Raises InputError, which begins with the name."""
        try:
            values = tomllib.loads(text)
        except (ValueError, RecursionError) as error:  # RecursionError: thousands of brackets
            raise InputError(f"{name}: not TOML: {error}") from None
        try:
            if isinstance(values.get("sweep"), dict):
                values["sweep"] = _of_sweep(validated, Sweep, values["sweep"])
            spec = validated(cls, values)
            spec.scenes("paper")
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        return spec

    def with_fixed(self, values: dict[str, Any]) -> "MovieSpec":
        """The same movie with other fixed parameters, which may be text. Raises InputError."""
        spec = self.model_copy(update={"fixed": {**self.fixed, **values}})
        scene = spec.scenes("paper")[0]
        return spec.model_copy(update={"fixed": {name: getattr(scene, name) for name in spec.fixed}})

    def scenes(self, quality: str) -> list[Scene]:
        """The scene of every frame. Raises InputError for the first frame that cannot be."""
        swept = self.sweep.parameter
        if swept in self.fixed:
            fixed = shown(self.fixed[swept])
            raise InputError(f"{swept} = {fixed}: it is swept; allowed: in fixed or in sweep, not both")
        model = SCENES[self.scene]
        validated(model, {**self.fixed, swept: self.sweep.start})
        _of_sweep(validated, model, {**self.fixed, swept: self.sweep.stop})
        return [validated(model, {**self.fixed, swept: value}) for value in self.sweep.values(quality)]

    def rate(self, quality: str) -> float:
        """Frames a second at a quality: a movie lasts equally long at each."""
        steps = len(self.sweep.values(quality)) - 1
        return self.frame_rate * steps / (self.sweep.frames - 1)


def _of_sweep(make, *arguments):
    try:
        return make(*arguments)
    except InputError as error:
        raise InputError(f"[sweep] {error}") from None
