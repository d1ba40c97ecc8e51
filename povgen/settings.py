"""How a scene is rendered: the qualities, picture size, antialiasing, caption and overlay."""

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from povgen.model import Model

# Each quality's picture size and antialiasing (POV-Ray's method, threshold and depth). No other antialiasing is both
# faster and more accurate (docs/speed.md). A movie's number of frames is a multiple of the number that its spec states.
# hd states frames a second instead, because players and editors expect 30.
QUALITIES: dict[str, dict[str, Any]] = {
    "draft": {"size": (320, 240), "antialias": None, "frames": 1 / 4},
    "standard": {"size": (480, 360), "antialias": (1, 0.9, 2), "frames": 1},
    "high": {"size": (960, 720), "antialias": (1, 0.1, 2), "frames": 3},
    "hd": {"size": (1920, 1080), "antialias": (1, 0.1, 2), "frame_rate": 30},
}
SAMPLING = ("quality", "size", "antialias")  # the fields of Rendering that decide POV-Ray's options
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
    return value.split(",") if isinstance(value, str) else value


Pixels = Annotated[int, Field(ge=32, le=7680), AfterValidator(_even)]


class Rendering(Model):
    """How a scene is rendered. Size and antialiasing follow from the quality if they are not given."""

    file: ClassVar[str] = "frame.png"
    format: ClassVar[tuple[str, ...]] = ("+FN8",)  # POV-Ray's options for PNG with 8 bits a colour

    quality: Quality = Field("standard", description="draft, standard, high or hd")
    size: Annotated[tuple[Pixels, Pixels], BeforeValidator(_size)] = Field(
        QUALITIES["standard"]["size"],
        description="WIDTHxHEIGHT, even numbers of pixels from 32 to 7680 (default: the quality's)",
    )
    antialias: Annotated[
        tuple[
            Annotated[int, Field(ge=1, le=2)],
            Annotated[float, Field(ge=0.001, lt=1)],
            Annotated[int, Field(ge=1, le=9)],
        ]
        | None,
        BeforeValidator(_antialias),
    ] = Field(
        QUALITIES["standard"]["antialias"],
        description="off, or POV-Ray's METHOD,THRESHOLD,DEPTH: 1 or 2, 0.001 to below 1, 1 to 9 "
        "(default: the quality's)",
    )
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
        0.2, description="distance between the two eyes of stereo, above 0 to 5 tiles"
    )

    @model_validator(mode="after")
    def _follow_quality(self) -> Self:
        for name in {"size", "antialias"} - self.model_fields_set:
            object.__setattr__(self, name, QUALITIES[self.quality][name])  # the model is frozen
        return self

    @model_validator(mode="after")
    def _check_eyes(self) -> Self:
        if self.stereo == "none" and "eye_distance" in self.model_fields_set:
            raise ValueError(
                f"eye_distance = {self.eye_distance:g}: stereo = 'none' has one eye; "
                "allowed: with stereo = 'pair' or 'anaglyph'"
            )
        return self

    @property
    def picture_options(self) -> list[str]:
        """Return POV-Ray's options for the file format, the size and the antialiasing."""
        width, height = self.size
        if self.antialias is None:
            sampling = ["-A"]
        else:
            method, threshold, depth = self.antialias
            # -J: no jitter, so that the same scene gives the same pixels
            sampling = [f"+AM{method}", f"+A{threshold:g}", f"+R{depth}", "-J"]
        return [*self.format, f"+W{width}", f"+H{height}", *sampling]

    @property
    def annotated(self) -> bool:
        """Whether povgen draws on POV-Ray's picture."""
        return self.caption or self.overlay
