"""How a scene is rendered: the qualities, picture size, antialiasing, caption and overlay."""

from typing import Annotated, ClassVar, Literal, NamedTuple, Self, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, Field, PrivateAttr, model_validator

from povgen.model import Model

Factor = Literal["1.5x", "2x", "3x", "4x"]


class Preset(NamedTuple):
    """What a quality decides.

    There are two antialiasings, one through prisms and one without prisms, because few pixels of a picture without
    prisms need more rays. No other antialiasing is both faster and more accurate (docs/speed.md).
    """

    size: tuple[int, int]
    antialias: tuple[Factor | tuple[int, float, int] | None, tuple[int, float, int] | None]
    frames: float = 1  # a movie's number of frames, as a multiple of the number that its spec states
    frame_rate: float | None = None  # of a movie, in place of `frames`


QUALITIES = {
    "draft": Preset((320, 240), (None, None), frames=1 / 4),
    "standard": Preset((480, 360), ("1.5x", (1, 0.1, 2))),
    "high": Preset((960, 720), ("2x", (1, 0.1, 3)), frames=3),
    "hd": Preset((1920, 1080), ("2x", (1, 0.1, 3)), frame_rate=30),  # players and editors expect 30 frames a second
}
MAX_PIXELS = 89_000_000  # of a picture that povgen reduces; Pillow warns of more
# pydantic takes the names from QUALITIES; mypy takes only names that are written out
Quality = Literal[*QUALITIES]  # type: ignore[valid-type]


def _even(pixels: int) -> int:
    if pixels % 2:
        raise ValueError("should be even, because a movie stores pixels in blocks of 2x2")
    return pixels


def _size(value: object) -> object:
    return value.lower().split("x") if isinstance(value, str) else value


def _antialias(value: object) -> object:
    if value == "off":
        return None
    if not isinstance(value, str) or value in get_args(Factor):
        return value
    if value.count(",") != 2:
        raise ValueError("should be off, 1.5x, 2x, 3x, 4x or three numbers")
    return value.split(",")


Pixels = Annotated[int, Field(ge=32, le=7680), AfterValidator(_even)]


class Sampling(Model):
    """What POV-Ray's options decide. Size and antialiasing follow from the quality if they are not given."""

    file: ClassVar[str] = "frame.png"
    format: ClassVar[tuple[str, ...]] = ("+FN8",)  # POV-Ray's options for PNG with 8 bits a colour

    quality: Quality = Field("standard", description=", ".join(QUALITIES))
    size: Annotated[tuple[Pixels, Pixels], BeforeValidator(_size)] = Field(
        QUALITIES["standard"].size,
        description="WIDTHxHEIGHT, even numbers of pixels from 32 to 7680 (default: the quality's)",
    )
    antialias: Annotated[
        tuple[
            Annotated[int, Field(ge=1, le=2)],
            Annotated[float, Field(ge=0.001, lt=1)],
            Annotated[int, Field(ge=1, le=9)],
        ]
        | Factor
        | None,
        BeforeValidator(_antialias),
    ] = Field(
        QUALITIES["standard"].antialias[0],
        description="off; 1.5x, 2x, 3x or 4x: POV-Ray's picture is that many times as wide and as high, and povgen "
        "averages its light; or POV-Ray's METHOD,THRESHOLD,DEPTH: 1 or 2, 0.001 to below 1, 1 to 9 "
        "(default: the quality's)",
    )

    _prisms: bool = PrivateAttr(True)  # whether it is for pictures through prisms

    @model_validator(mode="after")
    def _follow_quality(self) -> Self:
        preset = QUALITIES[self.quality]
        for name, value in (("size", preset.size), ("antialias", preset.antialias[0])):
            if name not in self.model_fields_set:
                object.__setattr__(self, name, value)  # the model is frozen
        return self

    @model_validator(mode="after")
    def _check_pixels(self) -> Self:
        width, height = self.size
        if self.supersampling > 1 and self.supersampling**2 * width * height > MAX_PIXELS:
            raise ValueError(
                f"size = {width}x{height}: too large for antialias = {self.sampling!r}; allowed: up to "
                f"{MAX_PIXELS / self.supersampling**2 / 1e6:.3g} million pixels, or another antialias"
            )
        return self

    def suited(self, prisms: bool) -> Self:
        """Return the sampling for a picture through prisms, or for one without. A given antialiasing stays."""
        suited = self.model_copy()
        BaseModel.__setattr__(suited, "_prisms", prisms)  # `Model` refuses changes
        if "antialias" not in self.model_fields_set:
            object.__setattr__(suited, "antialias", QUALITIES[self.quality].antialias[not prisms])
        return suited

    def replace(self, /, *unnamed: object, **changes: object) -> Self:
        """Return a copy with these values changed, for the same pictures. Raises InputError if it is not allowed."""
        return super().replace(*unnamed, **changes).suited(self._prisms)

    @property
    def supersampling(self) -> float:
        """How many times as wide and as high as povgen's picture POV-Ray's is."""
        return float(self.antialias[:-1]) if isinstance(self.antialias, str) else 1

    @property
    def sampling(self) -> str:
        """Return the antialiasing as text, as in a command."""
        if isinstance(self.antialias, tuple):
            return ",".join(f"{value:g}" for value in self.antialias)
        return self.antialias or "off"

    @property
    def picture_options(self) -> list[str]:
        """Return POV-Ray's options for the file format, the size and the antialiasing."""
        width, height = (round(self.supersampling * pixels) for pixels in self.size)
        if isinstance(self.antialias, tuple):
            method, threshold, depth = self.antialias
            # -J: no jitter, so that the same scene gives the same pixels
            sampling = [f"+AM{method}", f"+A{threshold:g}", f"+R{depth}", "-J"]
        else:
            sampling = ["-A"]
        return [*self.format, f"+W{width}", f"+H{height}", *sampling]


def preset_of(quality: str) -> Preset:
    """Return what a quality decides. Raises InputError if there is no such quality."""
    return QUALITIES[Sampling(quality=quality).quality]


class Rendering(Sampling):
    """How a scene is rendered. Size and antialiasing follow from the quality if they are not given."""

    timeout: Annotated[float, Field(gt=0, le=1e6)] = Field(
        1800, description="time limit for a frame, above 0 to 1e6 seconds"
    )

    caption: bool = Field(
        False, description="write alpha, z1, z2, r and the predicted nu and M along the picture's lower edge"
    )
    overlay: bool = Field(
        False,
        description="mark predicted positions inside the window, and the curves on which they move",
    )

    stereo: Literal["none", "pair", "anaglyph"] = Field(
        "none",
        description="what two eyes see: pair (the left eye's picture beside the right eye's), anaglyph (for glasses "
        "with red on the left, cyan on the right) or none (one eye)",
    )
    eye_distance: Annotated[float, Field(gt=0, le=5)] = Field(
        0.2, description="distance between the two eyes of stereo, above 0 to 5 tiles; a movie cannot sweep it"
    )

    @property
    def annotated(self) -> bool:
        """Whether povgen draws on POV-Ray's picture."""
        return self.caption or self.overlay
