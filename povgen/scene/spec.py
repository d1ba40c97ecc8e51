"""Movie specs: a TOML file with a scene, its fixed parameters and one swept parameter."""

import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from povgen.errors import InputError, shown, validated
from povgen.model import Model
from povgen.scene.models import SCENES, Scene
from povgen.settings import QUALITIES

MOVIES = Path(__file__).parents[1] / "movies"
MAX_BYTES = 2**14  # of a spec; Python's TOML parser can take minutes for much longer ones
FrameRate = Annotated[float, Field(ge=0.1, le=120)]


class Sweep(Model):
    """The parameter that changes from frame to frame, and its values."""

    parameter: Literal["alpha", "z1", "z2"] = Field(description="the parameter that is swept")
    start: float = Field(description="its value in the first frame")
    stop: float = Field(description="its value in the last frame")
    frames: Annotated[int, Field(ge=2, le=10000)] = Field(description="number of frames at quality paper, 2 to 10000")
    spacing: Literal["linear", "log"] = Field("linear", description="spacing of the values: linear or log")

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if self.start == self.stop:
            raise ValueError(f"stop = {self.stop:g}: equal to start, nothing would move; allowed: any other value")
        if self.spacing == "log" and min(self.start, self.stop) <= 0 <= max(self.start, self.stop):
            raise ValueError(
                f"spacing = 'log': 0 lies between start = {self.start:g} and stop = {self.stop:g}; "
                "allowed: start and stop both above or both below 0, or spacing = 'linear'"
            )
        return self

    def values(self, quality: str) -> list[float]:
        """Return the parameter's value in each frame. The quality scales the number of steps."""
        count = round((self.frames - 1) * QUALITIES[quality]["frames"]) + 1
        space = np.geomspace if self.spacing == "log" else np.linspace
        values: list[float] = space(self.start, self.stop, max(count, 2)).tolist()
        return values


class MovieSpec(Model):
    """A movie: its title, scene, fixed parameters, swept parameter and frame rate."""

    title: Annotated[str, Field(pattern=r"^[^\p{Cc}\p{Zl}\p{Zp}]{1,200}$")] = Field(
        description="the movie's title, one line of up to 200 characters"
    )
    scene: Literal[*SCENES] = Field(description="the scene")  # type: ignore[valid-type]
    frame_rate: FrameRate = Field(description="frames a second at quality paper, 0.1 to 120")
    fixed: dict[str, Any] = Field({}, description="the scene's fixed parameters")
    sweep: Sweep = Field(description="the swept parameter")

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a movie spec: a TOML file, one of povgen's own by its name (vary-alpha), or standard input (-).

        Raises InputError, which names the file, the key, the value and what is allowed.
        """
        stdin = str(path) == "-"
        name = "standard input" if stdin else str(path) or "''"
        file = Path(path)
        try:
            if not stdin and file.suffix != ".toml" and not file.exists():
                file = MOVIES / f"{path}.toml"
            with open(0, "rb", closefd=False) if stdin else file.open("rb") as opened:
                data = opened.read(MAX_BYTES + 1)
            if len(data) > MAX_BYTES:
                raise ValueError(f"longer than {MAX_BYTES} bytes")
            text = data.decode("utf-8-sig")  # some editors begin a file with a byte order mark
        except (OSError, ValueError) as error:  # ValueError: too long, not UTF-8, or a NUL in the name
            own = ", ".join(spec.stem for spec in sorted(MOVIES.glob("*.toml")))
            reason = "not UTF-8" if isinstance(error, UnicodeError) else getattr(error, "strerror", error)
            raise InputError(f"{name}: no movie spec: {reason}; allowed: a TOML file or one of {own}") from None
        return cls.parse(text, name)

    @classmethod
    def parse(cls, text: str, name: str) -> Self:
        """Read a movie spec from TOML text. Raises InputError, whose message begins with the name."""
        try:
            values = tomllib.loads(text)
        except (ValueError, RecursionError) as error:  # RecursionError: thousands of brackets
            raise InputError(f"{name}: not TOML: {error}") from None
        try:
            if isinstance(values.get("sweep"), dict):
                with _errors_of_sweep():
                    values["sweep"] = validated(Sweep, values["sweep"])
            spec = validated(cls, values)
            spec.scenes("paper")
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        return spec

    def with_fixed(self, values: dict[str, Any]) -> Self:
        """Return the movie with other fixed parameters. The values may be text. Raises InputError."""
        spec = self.model_copy(update={"fixed": {**self.fixed, **values}})
        scene = spec.scenes("paper")[0]
        return spec.model_copy(update={"fixed": {name: getattr(scene, name) for name in spec.fixed}})

    def scenes(self, quality: str) -> list[Scene]:
        """Return the scene of every frame. Raises InputError for the first frame that is not allowed."""
        swept = self.sweep.parameter
        if swept in self.fixed:
            fixed = shown(self.fixed[swept])
            raise InputError(f"{swept} = {fixed}: also the swept parameter; allowed: in fixed or in sweep, not in both")
        model = SCENES[self.scene]
        validated(model, {**self.fixed, swept: self.sweep.start})
        with _errors_of_sweep():
            validated(model, {**self.fixed, swept: self.sweep.stop})
        return [validated(model, {**self.fixed, swept: value}) for value in self.sweep.values(quality)]

    def rate(self, quality: str) -> float:
        """Return the frames a second at a quality. A movie lasts equally long at each quality."""
        steps = len(self.sweep.values(quality)) - 1
        return self.frame_rate * steps / (self.sweep.frames - 1)


@contextmanager
def _errors_of_sweep() -> Iterator[None]:
    """Let the message of an InputError begin with the TOML table's name."""
    try:
        yield
    except InputError as error:
        raise InputError(f"[sweep] {error}") from None
