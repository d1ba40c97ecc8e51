"""How a scene becomes a picture: size and antialiasing, by name of a quality or one by one."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

# Size, antialiasing (method, threshold, depth; each on the front of error against cost, docs/speed.md) and the share of
# a movie's frames, for each quality.
QUALITIES: dict[str, dict[str, Any]] = {
    "draft": {"size": (320, 240), "antialias": "off", "frames": 1 / 4},
    "paper": {"size": (480, 360), "antialias": "1,0.9,2", "frames": 1},
    "high": {"size": (960, 720), "antialias": "1,0.1,2", "frames": 3},
}
Quality = Literal["draft", "paper", "high"]


def _even(pixels: int) -> int:
    if pixels % 2:
        raise ValueError("should be even, for movies hold pixels in blocks of 2x2")
    return pixels


def _size(value: Any) -> Any:
    return value.lower().split("x") if isinstance(value, str) else value


def _antialias(value: Any) -> Any:
    if value == "off":
        return None
    return value.split(",") if isinstance(value, str) else value


Pixels = Annotated[int, Field(ge=32, le=7680), AfterValidator(_even)]


class Rendering(BaseModel):
    """What is asked for beside the scene. What is not given follows from the quality."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    file: ClassVar[str] = "frame.png"
    format: ClassVar[tuple[str, ...]] = ("+FN8",)  # in POV-Ray's options

    quality: Quality = Field("paper", description="draft, paper or high")
    size: Annotated[tuple[Pixels, Pixels], BeforeValidator(_size)] = Field(
        description="WIDTHxHEIGHT, even numbers of pixels from 32 to 7680"
    )
    antialias: Annotated[
        tuple[
            Annotated[int, Field(ge=1, le=2)],
            Annotated[float, Field(ge=0.001, lt=1)],
            Annotated[int, Field(ge=1, le=9)],
        ]
        | None,
        BeforeValidator(_antialias),
    ] = Field(description="off, or POV-Ray's METHOD,THRESHOLD,DEPTH: 1 or 2, 0.001 to below 1, 1 to 9")
    timeout: Annotated[float, Field(gt=0, le=1e6)] = Field(
        1800, description="the longest a frame may take, above 0 to 1e6 seconds"
    )

    caption: bool = Field(
        False, description="burn alpha, z1, z2, r, and the predicted nu and M into the picture's lower edge"
    )
    overlay: bool = Field(
        False,
        description="mark where objects are predicted, and the curves that they move on, in the window's opening alone",
    )

    @model_validator(mode="before")
    @classmethod
    def _follow_quality(cls, values: Any) -> Any:
        preset = QUALITIES.get(values.get("quality", "paper"), QUALITIES["paper"])
        return {"size": preset["size"], "antialias": preset["antialias"], **values}

    @property
    def picture_options(self) -> list[str]:
        """POV-Ray's options for this format, size and antialiasing."""
        width, height = self.size
        if self.antialias is None:
            sampling = ["-A"]
        else:
            method, threshold, depth = self.antialias
            # without jitter the same scene gives the same pixels
            sampling = [f"+AM{method}", f"+A{threshold:g}", f"+R{depth}", "-J"]
        return [*self.format, f"+W{width}", f"+H{height}", *sampling]

    @property
    def annotated(self) -> bool:
        """Whether something is drawn over POV-Ray's picture."""
        return self.caption or self.overlay
