"""Parameters that several kinds of sheets share."""

from dataclasses import replace

from povgen.limits import MIN_GAP
from povgen.optics.glasses import GLASSES
from povgen.optics.prism import Prism
from povgen.sheets.sheet import Parameter, Said

ALPHA = Parameter(
    "alpha",
    "ray-rotation angle alpha, -360 to 360 degrees",
    66,
    -360,
    360,
    "degrees",
    symbol="α",
    said=Said("rays turned by α = {}", full="α = {}"),
)
RATIO = Parameter("ratio", "ratio, 0.1 to 10", 1, 0.1, 10, symbol="|η|")  # each kind of sheet has a text of its own
FOCAL_LENGTH = Parameter(
    "focal_length", "focal length, -100 to -0.1 or 0.1 to 100 tiles", 4, -100, 100, "tiles", size=0.1, symbol="f"
)
INDEX = Parameter("index", "refractive index n of the prisms or lenses, 1.1 to 4", Prism.index, 1.1, 4)
GLASS = Parameter(
    "glass",
    "glass of the prisms or lenses, such as BK7, in place of index; povgen list shows the glasses with their n",
    "none",
    kind="choice",
    choices=("none", *GLASSES),
)
GAP = Parameter(
    "gap",
    f"width of the air between neighbouring prisms, and between two sheets, in units of the pitch, {MIN_GAP:g} to 0.5",
    Prism.gap,
    MIN_GAP,
    0.5,
)


FOCAL_LENGTHS = Said("lenses' focal lengths f₁/f₂ = {}")  # of lenses in two arrays


def of(parameter: Parameter, text: str = "", said: Said | None = None) -> Parameter:
    """Return a copy of a shared parameter with this text, or its own if `text` is empty, and `said` in captions."""
    return replace(parameter, text=text or parameter.text, said=said)
