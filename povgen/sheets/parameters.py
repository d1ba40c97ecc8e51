"""Parameters that several kinds of sheets share."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from povgen.limits import MIN_GAP
from povgen.optics import glasses
from povgen.optics.prism import Prism
from povgen.sheets.sheet import Parameter, Said

WAVELENGTH = 587.6  # nm, the default of light and of the design: the yellow line d of helium
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
    kind="glass",
    choices=("none", *glasses.GLASSES),
)
DESIGN_WAVELENGTH = Parameter(
    "design_wavelength",
    "wavelength the sheets are made for, 180 to 10000 nm",
    WAVELENGTH,
    180,
    10000,
    "nm",
)
GAP = Parameter(
    "gap",
    f"width of the air between neighbouring prisms, and between two sheets, in units of the pitch, {MIN_GAP:g} to 0.5",
    Prism.gap,
    MIN_GAP,
    0.5,
)


FOCAL_LENGTHS = Said("lenses' focal lengths f₁/f₂ = {}")  # of lenses in two arrays


def design_index(values: Mapping[str, Any]) -> float:
    """Return the index for which prisms or lenses with these values are made; `index` is that for light.

    Raises ValueError if the glass's formula does not hold at the design wavelength.
    """
    if values["glass"] == "none":
        return float(values["index"])
    try:
        return glasses.index(values["glass"], values["design_wavelength"] * 1e-9)
    except ValueError as error:
        raise ValueError(f"design_{error}") from None


def of(parameter: Parameter, text: str = "", said: Said | None = None) -> Parameter:
    """Return a copy of a shared parameter with this text, or its own if `text` is empty, and `said` in captions."""
    return replace(parameter, text=text or parameter.text, said=said)
