"""How a scene is rendered: the qualities, picture size, antialiasing, caption and overlay."""

from collections.abc import Mapping, Sequence
from math import ceil, isqrt
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Self, TypedDict, get_args

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from povgen import fonts
from povgen.errors import at_most
from povgen.validation import Model

Factor = Literal["1.5x", "2x", "3x", "4x"]
Renderer = Literal["povray", "gl"]


class Preset(NamedTuple):
    """What a quality decides.

    There are two antialiasings, one through prisms and one without prisms, because few pixels of a picture without
    prisms need more rays. No other antialiasing is both faster and more accurate (docs/speed.md).
    """

    size: tuple[int, int]
    antialias: tuple[Factor | tuple[int, float, int] | None, tuple[int, float, int] | None]
    movie_size: tuple[int, int] | None = None  # of a movie's frames, if it differs
    frames: float = 1  # a movie's number of frames, as a multiple of the number that its spec states
    frame_rate: float | None = None  # of a movie, in place of `frames`


QUALITIES = {
    "draft": Preset((320, 240), ("1.5x", (1, 0.1, 2)), frames=0.8),
    # the paper's three movies are made in 5 minutes on two cores
    "standard": Preset((960, 720), ("1.5x", (1, 0.1, 2)), movie_size=(424, 318)),
    # players and editors expect 30 frames a second
    "high": Preset((960, 720), ("2x", (1, 0.1, 3)), frame_rate=30),
    "hd": Preset((1920, 1080), ("2x", (1, 0.1, 3)), frame_rate=30),
}
PUPIL_RAYS = 65  # in each pixel, from so many places in a pupil: n * n + 1
MAX_SIDES = {"povray": 7680, "gl": 16384}  # pixels, by renderer
MAX_PIXELS = 89_000_000  # of a picture that povgen reduces; Pillow warns of more
# how povgen reduces it, for the keys of the cache
FILTER = "a triangle: the weight falls to 0 two old pixels away, or one new pixel where this is more"
# pydantic takes the names from QUALITIES; mypy takes only names that are written out
Quality = Literal[*QUALITIES]  # type: ignore[valid-type]


def _even(pixels: int) -> int:
    if pixels % 2:
        raise ValueError("should be even, because a movie stores pixels in blocks of 2x2")
    return pixels


def as_size(value: object) -> object:
    """Return text such as '64x48' as a list of texts, and other values as they are."""
    return value.lower().split("x") if isinstance(value, str) else value


def _antialias(value: object) -> object:
    if value == "off":
        return None
    if not isinstance(value, str) or value in get_args(Factor):
        return value
    if value.count(",") != 2:
        raise ValueError("should be off, 1.5x, 2x, 3x, 4x or three numbers")
    return value.split(",")


def _number(value: object) -> object:
    return int(value) if isinstance(value, str) and value.isdecimal() and len(value) < 9 else value


if TYPE_CHECKING:  # what a user may give, for type checkers
    Antialias = str | tuple[int, float, int] | None
else:
    Antialias = Annotated[
        tuple[
            Annotated[int, Field(ge=1, le=2)],
            Annotated[float, Field(ge=0.001, lt=1)],
            Annotated[int, Field(ge=1, le=9)],
        ]
        | Factor
        | None,
        BeforeValidator(_antialias),
    ]
Note = Annotated[str, Field(pattern=f"^[{fonts.LETTERS}]{{0,80}}$")]
Pixels = Annotated[int, Field(ge=32, le=MAX_SIDES["gl"]), AfterValidator(_even)]


class Sampling(Model):
    """What POV-Ray's options decide. Size and antialiasing follow from the quality if they are not given."""

    if TYPE_CHECKING:  # the names of changes are those of the fields

        @property
        def replace(self) -> type[Self]: ...

    quality: Quality = Field(default="standard", description=", ".join(QUALITIES))
    size: Annotated[tuple[Pixels, Pixels], BeforeValidator(as_size)] = Field(
        default=QUALITIES["standard"].size,
        description="WIDTHxHEIGHT, even numbers of pixels from 32 to 7680, with --renderer gl to 16384 "
        "(default: the quality's)",
    )
    antialias: Antialias = Field(
        default=QUALITIES["standard"].antialias[0],
        description="off; 1.5x, 2x, 3x or 4x: POV-Ray's picture is that many times as wide and as high, and povgen "
        "averages its light; or POV-Ray's METHOD,THRESHOLD,DEPTH: 1 or 2, 0.001 to below 1, 1 to 9 "
        "(default: the quality's)",
    )

    @model_validator(mode="after")
    def _follow_quality(self) -> Self:
        preset = QUALITIES[self.quality]
        for name, value in (("size", preset.size), ("antialias", preset.antialias[0])):
            if name not in self.model_fields_set:
                object.__setattr__(self, name, value)  # the model is frozen
        return self

    @model_validator(mode="after")
    def _check_pixels(self) -> Self:
        if getattr(self, "renderer", "povray") == "gl":
            return self
        width, height = self.size
        if max(self.size) > MAX_SIDES["povray"]:
            raise ValueError(f"size = {width}x{height}: should be up to 7680 pixels, or 16384 with renderer = 'gl'")
        if self.supersampling > 1 and self.supersampling**2 * width * height > MAX_PIXELS:
            raise ValueError(
                f"size = {width}x{height}: too large for antialias = {self.sampling!r}; allowed: up to "
                f"{at_most(MAX_PIXELS / self.supersampling**2 / 1e6)} million pixels, or another antialias"
            )
        return self

    def suited(self, prisms: bool) -> Self:
        """Return the sampling for a picture through prisms, or for one without. A given antialiasing stays."""
        suited = self.model_copy()
        if "antialias" not in self.model_fields_set:
            object.__setattr__(suited, "antialias", QUALITIES[self.quality].antialias[not prisms])
        return suited

    def through(self, pupil: float, polarised: bool = False) -> Self:
        """Return the sampling for an eye with a pupil, whose many rays a pixel are antialiasing enough.

        A `polarised` picture is the sum of several pictures, each of one ray a pixel.
        """
        if not (pupil or polarised):
            return self
        one = polarised or getattr(self, "renderer", "povray") == "povray"
        rays = None if one else (1, 0.1, isqrt(PUPIL_RAYS - 1))
        return self.model_copy(update={"antialias": rays})

    @property
    def file(self) -> str:
        """The name of POV-Ray's picture."""
        return "frame.png"

    @property
    def format(self) -> tuple[str, ...]:
        """POV-Ray's options for the file format: PNG with 8 bits a colour."""
        return ("+FN8",)

    @property
    def supersampling(self) -> float:
        """How many times as wide and as high as povgen's picture POV-Ray's is."""
        return float(self.antialias[:-1]) if isinstance(self.antialias, str) else 1

    @property
    def sampling(self) -> str:
        """Return the antialiasing as text, as in a command."""
        if isinstance(self.antialias, tuple):
            return ",".join(map(str, self.antialias))
        return self.antialias or "off"

    @property
    def rays(self) -> int:
        """How many rays the renderer gl draws in every pixel. Its error is then about that of POV-Ray."""
        return self.antialias[2] ** 2 + 1 if isinstance(self.antialias, tuple) else ceil(self.supersampling) ** 2

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


def of_movie(options: Mapping[str, object]) -> dict[str, Any]:
    """Return a rendering's options with the size of a movie's frames, unless they state a size. Raises InputError."""
    preset = preset_of(str(options.get("quality", "standard")))
    return {"size": preset.movie_size or preset.size, **options}


class Print(Model):
    """How a chart or a figure is written to a file."""

    dpi: Annotated[float, Field(ge=50, le=1200)] | None = Field(
        default=None,
        description="of charts and figures: dots an inch of a PNG file, and of pictures in other files, 50 to 1200",
    )
    width: Annotated[float, Field(ge=40, le=300)] | None = Field(
        default=None,
        description="of charts and figures: the width on paper in millimetres, 40 to 300; text is scaled with the rest",
    )


AS_DRAWN = Print()


class SharedOptions(TypedDict, total=False):
    """The options of all renderers."""

    quality: str
    size: str | Sequence[int]
    antialias: Antialias
    bits: Literal[8, 16, 32]
    timeout: float
    caption: Literal["none", "short", "full"]
    note: str
    overlay: bool
    side_view: bool
    stereo: Literal["none", "pair", "anaglyph"]
    eye_distance: float


class Options(SharedOptions, total=False):
    """The fields of `Rendering`, for type checkers: the options of `render` and of other functions."""

    renderer: Renderer


class Rendering(Sampling):
    """How a scene is rendered. Size and antialiasing follow from the quality if they are not given."""

    renderer: Renderer = Field(
        default="povray",
        description="povray, or gl: the live view's shaders, on a graphics processor if there is one; no --fresnel",
    )
    bits: Annotated[Literal[8, 16, 32], BeforeValidator(_number)] = Field(
        default=8,
        description="bits of each colour: 8, 16 (a finer PNG file) or 32 (an EXR file, which has scene-linear light: "
        "1 is white, and highlights are brighter)",
    )
    timeout: Annotated[float, Field(gt=0, le=1e6)] = Field(
        default=1800,
        description="time limit for a frame, at most 1e6 seconds",
        exclude=True,  # no part of a file's record
    )

    caption: Literal["none", "short", "full"] | None = Field(
        default=None,
        description="below the picture: none, short (what moves, or the sheets' parameters) or full (with predicted nu "
        "and M) (default: none; short for a movie's file)",
    )
    note: Note = Field(
        default="",
        description="a text with the caption: up to 80 letters, Latin or Greek",
    )
    overlay: bool = Field(default=False, description="mark predicted positions, and the curves on which they move")

    side_view: bool = Field(
        default=False,
        description="add a view from the side, to scale",
    )

    stereo: Literal["none", "pair", "anaglyph"] = Field(
        default="none",
        description="what two eyes see: pair (the left eye's picture beside the right eye's), anaglyph (for glasses "
        "with red on the left, cyan on the right) or none (one eye)",
    )
    eye_distance: Annotated[float, Field(gt=0, le=5)] = Field(
        default=0.2, description="distance between the two eyes of stereo, at most 5 tiles; a movie cannot sweep it"
    )

    @model_validator(mode="after")
    def _check_bits(self) -> Self:
        if self.is_light and self.annotated:
            drawn = next(name for name in ("overlay", "side_view", "note", "caption") if getattr(self, name))
            raise ValueError(
                f"bits = {self.bits}: {drawn} is drawn with 8 bits; allowed: bits = 8 (no EXR file), or without {drawn}"
            )
        return self

    def in_default_time(self) -> Self:
        """Return the rendering with the default time limit."""
        return type(self)(**self.model_dump(exclude_unset=True))

    @property
    def is_light(self) -> bool:
        """Whether frames are rendered as light: floating-point numbers, in place of the bytes of a PNG file."""
        return self.bits > 8

    @property
    def file(self) -> str:
        return "frame.exr" if self.is_light else super().file

    @property
    def format(self) -> tuple[str, ...]:
        return ("+FE",) if self.is_light else super().format

    @property
    def is_wide(self) -> bool:
        """Whether texts and the side view stand beside the picture, so that all together have the asked size.

        In a lower picture they would be too small.
        """
        width, height = self.size
        return 2 * width >= 3 * height and height >= 480

    @property
    def annotated(self) -> bool:
        """Whether povgen adds a caption, a note, an overlay or a side view to the rendered picture."""
        return self.caption in ("short", "full") or bool(self.note) or self.overlay or self.side_view
