"""Sheets of Dove prisms of finite size (section 2 of the paper)."""

from functools import cached_property
from typing import TYPE_CHECKING

from povgen.limits import MAX_PRISMS, MIN_GAP
from povgen.optics.prism import Prism
from povgen.sheets.mirror import Mirror
from povgen.sheets.parameters import ALPHA
from povgen.sheets.rotation import Rotation
from povgen.sheets.sheet import Parameter, Sheet

if TYPE_CHECKING:
    from povgen.optics.aim import Matrix

PRISMS = (
    Parameter(
        "prisms",
        f"Dove prisms across the window, in each sheet, 1 to {MAX_PRISMS}",
        100,
        1,
        MAX_PRISMS,
        kind="whole number",
    ),
    Parameter("index", "refractive index n of the prisms, 1.1 to 4", Prism.index, 1.1, 4),
    Parameter(
        "base_angle",
        "angle between a prism's base and its slanted facets, 15 to 75 degrees",
        Prism.base_angle,
        15,
        75,
        "degrees",
    ),
    Parameter("gap", f"air between prisms, in units of their pitch, {MIN_GAP:g} to 0.5", Prism.gap, MIN_GAP, 0.5),
    Parameter(
        "aspect",
        "length of a prism, in units of its length at full aperture: "
        "above a least value that depends on index and base angle, and below 2",
        Prism.aspect,
        0,
        2,
    ),
    Parameter(
        "tops",
        "the prisms' tops: clear, or black, which absorbs much of the stray light",
        "clear",
        kind="choice",
        choices=("clear", "black"),
    ),
)


class _Prisms(Sheet):
    source = "Hamilton, Sundar, Nelson and Courtial, Local light-ray rotation (2009)"

    @cached_property
    def prism(self) -> Prism:
        """The shape of the prisms. Lengths are in tiles."""
        shape = {name: self.values[name] for name in ("index", "base_angle", "gap", "aspect")}
        return Prism(self.aperture / self.values["prisms"], **shape)

    @property
    def depth(self) -> float:
        return self.prism.thickness(self.layers)


class PrismPair(_Prisms):
    """Two sheets: the one near the eye is turned by alpha/2 about the normal, the far one has ridges along x."""

    name = "detailed"
    title = "two sheets of Dove prisms"
    does = "turns light by alpha about the sheets' normal"
    parameters = (ALPHA, *PRISMS)
    rotates = True
    layers = 2

    @cached_property
    def transfer(self) -> "Matrix":
        from povgen.optics import aim

        return aim.pair(self.alpha, self.prism)

    @property
    def thin(self) -> Rotation:
        return Rotation({"alpha": self.values["alpha"]})


class SinglePrismSheet(_Prisms):
    """One sheet, with ridges along x: it reverses the y component of light's direction."""

    name = "single"
    title = "one sheet of Dove prisms"
    does = "reverses the y component of light's direction"
    parameters = PRISMS
    layers = 1

    @cached_property
    def transfer(self) -> "Matrix":
        from povgen.optics import aim

        return aim.single(self.prism)

    @property
    def thin(self) -> Mirror:
        return Mirror({"alpha": 0.0})
