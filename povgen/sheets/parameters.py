"""Parameters that several kinds of sheets share."""

from dataclasses import replace

from povgen.sheets.sheet import Parameter

ALPHA = Parameter(
    "alpha",
    "ray-rotation angle alpha, -360 to 360 degrees",
    66,
    -360,
    360,
    "degrees",
    symbol="α",
    label="the light is turned by",
)
RATIO = Parameter("ratio", "ratio, 0.1 to 10", 1, 0.1, 10, symbol="|η|")
FOCAL_LENGTH = Parameter(
    "focal_length", "focal length, -100 to -0.1 or 0.1 to 100 tiles", 4, -100, 100, "tiles", size=0.1, symbol="f"
)


def of(parameter: Parameter, text: str, label: str = "") -> Parameter:
    """Return a shared parameter with the text and the label for another kind of sheet."""
    return replace(parameter, text=text, label=label)
