"""Sheets of Dove prisms of finite size (section 2 of the paper)."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import radians, tan
from typing import Any, NamedTuple

import numpy as np

from povgen.limits import MAX_PRISMS
from povgen.optics import faces, trace
from povgen.optics.prism import MOST_DEVIATION, Prism
from povgen.sheets.layered import Layered
from povgen.sheets.mirror import Mirror
from povgen.sheets.parameters import ALPHA, DESIGN_WAVELENGTH, GAP, GLASS, INDEX, design_index
from povgen.sheets.rotation import Rotation
from povgen.sheets.sheet import Parameter, Said

PRISMS = (
    Parameter(
        "prisms",
        f"Dove prisms across the window in each sheet, 1 to {MAX_PRISMS}",
        100,
        1,
        MAX_PRISMS,
        kind="whole number",
        said=Said("{} prisms"),
    ),
    INDEX,
    GLASS,
    DESIGN_WAVELENGTH,
    Parameter(
        "base_angle",
        "angle between base and facets, 15 to 75 degrees",
        Prism.base_angle,
        15,
        75,
        "degrees",
    ),
    GAP,
    Parameter(
        "aspect",
        "length of a prism; 1: just enough for all light along z; below 2; its minimum depends on index and base angle",
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


class Range(NamedTuple):
    """The allowed numbers of an error, and their unit."""

    least: float
    most: float
    unit: str = ""


ANGLE = Range(-10, 10, "degrees")
CHANGE = Range(-0.1, 0.1)
# By how much a pair of sheets can differ from its plan: docs/tolerances.md
ERRORS = {
    "turn": ANGLE,  # the near sheet is turned too far about z
    "tilt_x": ANGLE,  # the near sheet is tilted about x, and then about y
    "tilt_y": ANGLE,
    "far_tilt_x": ANGLE,
    "far_tilt_y": ANGLE,
    "separation": Range(0, 10, "tiles"),  # the sheets are too far apart
    "index": CHANGE,  # of the near sheet's glass: too great
    "far_index": CHANGE,
    "base_angle": ANGLE,  # of the near sheet's prisms: too great, for a base of the planned length
    "far_base_angle": ANGLE,
    "pitch": CHANGE,  # of the near sheet's lenses on the object's side: too great by this fraction
    "far_pitch": CHANGE,
    "facets": Range(0, 1, "degrees"),  # standard deviation of the angle of each single facet
    "pitches": Range(0, 0.05),  # standard deviation of the height of each single prism, as a fraction of this height
    "seed": Range(0, 1e9),  # of the random numbers for facets and pitches
}
ERROR = Parameter(
    "error",
    "error of building, such as turn=0.1; docs/tolerances.md names them",
    {},
    kind="table",
    choices=tuple(ERRORS),
)


OF_LENSES = ("pitch", "far_pitch")  # the other errors are of prisms
RANDOM = ("facets", "pitches")  # of each single prism


def check_ranges(errors: Mapping[str, float], allowed: Sequence[str], of: str) -> None:
    """Raise ValueError for an error that these sheets cannot have, and for one outside its range."""
    for name, value in errors.items():
        if name not in allowed and value:
            raise ValueError(f"error: {name} = {value:g}; allowed for {of}: {', '.join(allowed)}")
        least, most, unit = ERRORS[name]
        if not least <= value <= most:
            raise ValueError(f"error: {name} = {value:g}; allowed: {least:g} to {most:g}{unit and ' '}{unit}")


SHAPE = ("index", "glass", "design_wavelength", "base_angle", "gap", "aspect")  # decide a prism's, beside its pitch


def shape_of(values: Mapping[str, Any], pitch: float) -> Prism:
    """Return the shape of prisms with these values of `SHAPE` and `tops`, with their index for light.

    The prisms are made for the design wavelength, at which they have the stated aspect.
    """
    black = values["tops"] == "black"
    made = Prism(pitch, design_index(values), values["base_angle"], values["gap"], values["aspect"], black)
    return made.with_length_kept(index=values["index"])


class Prisms(Layered):
    """What the sheets of prisms share."""

    source = "Hamilton, Sundar, Nelson and Courtial, Local light-ray rotation (2009)"
    counted = "prisms"

    @cached_property
    def shape(self) -> Prism:
        return shape_of(self.values, self.pitch)


class PrismPair(Prisms):
    """Two sheets: the one near the eye is turned by alpha/2 about the normal, the far one has ridges along x."""

    name = "detailed"
    title = "two sheets of Dove prisms"
    does = "turns light by alpha about the sheets' normal"
    parameters = (ALPHA, *PRISMS, ERROR)
    rotates = True
    layers = 2

    @property
    def is_exact(self) -> bool:
        return not any(value for name, value in self.values["error"].items() if name != "seed")

    @property
    def _built(self) -> dict[str, float]:
        return {name: self.values["error"].get(name, 0.0) for name in ERRORS}

    def _shape_of(self, index: float, base_angle: float) -> Prism:
        """Return the shape of a sheet's prisms, for these errors. The base has the planned length."""
        plan = self.shape
        return plan.with_length_kept(index=plan.index + index, base_angle=plan.base_angle + base_angle)

    @property
    def glass(self) -> tuple[faces.GlassSheet, ...]:
        near, far = trace.pair(self.alpha, self.shape)
        if self.is_exact:
            return near, far
        wrong = self._built
        turn, x, y, far_x, far_y = (
            radians(wrong[name]) for name in ("turn", "tilt_x", "tilt_y", "far_tilt_x", "far_tilt_y")
        )
        shape = self._shape_of(wrong["index"], wrong["base_angle"])
        near = replace(near, angle=near.angle + turn, tilt=(x, y), shape=shape)
        far = replace(far, tilt=(far_x, far_y), shape=self._shape_of(wrong["far_index"], wrong["far_base_angle"]))
        random: dict[str, Any] = {"facets": radians(wrong["facets"]), "pitches": wrong["pitches"]}
        near, far = (replace(each, **random, seed=(int(wrong["seed"]), k)) for k, each in enumerate((near, far)))
        least = near.reach(self.aperture) + far.reach(self.aperture)  # a tilted sheet must not meet the other
        aside = (max(far.centre - near.centre, least) + wrong["separation"]) / 2
        return replace(near, centre=-aside), replace(far, centre=aside)

    @property
    def single(self) -> list[list[tuple[float, ...]]]:
        """The prisms of each sheet, the near sheet first, from the lowest prism up; empty if all prisms are equal.

        Each prism has four numbers: where its base is, as a height above the window's centre before the sheet is
        turned, and its own height, tiles; and the angles of its near and its far facet to the base, degrees.
        """
        found: list[list[tuple[float, ...]]] = []
        if not any(self._built[name] for name in RANDOM):
            return found

        for sheet in self.glass:
            _, bottoms, angles = faces.single_prisms(sheet, self.aperture)
            heights = np.diff(bottoms) - self.shape.gap * self.pitch
            found.append([*zip(bottoms, heights, *np.degrees(angles).T, strict=False)])
        return found

    @property
    def depth(self) -> float:
        if self.is_exact:
            return super().depth
        near, far = self.glass
        return 2 * max(far.centre + far.reach(self.aperture), near.reach(self.aperture) - near.centre)

    @property
    def thin(self) -> Rotation:
        return Rotation({"alpha": self.values["alpha"] + 2 * self._built["turn"]})

    def check_errors(self) -> None:
        """Raise ValueError for an error that prisms cannot have, or that is outside its range.

        Also raise it if no prisms with these errors are possible.
        """
        check_ranges(self.values["error"], [name for name in ERRORS if name not in OF_LENSES], "prisms")
        wrong = self._built
        if wrong["seed"] % 1:
            raise ValueError(f"error: seed = {wrong['seed']:g}; allowed: a whole number")
        for sheet in ("", "far_"):
            try:
                shape = self._shape_of(wrong[f"{sheet}index"], wrong[f"{sheet}base_angle"])
            except ValueError as error:
                raise ValueError(f"error: the {'far' if sheet else 'near'} sheet would have {error}") from None
            least = shape.base_angle - MOST_DEVIATION * wrong["facets"]
            height = shape.height * (1 + MOST_DEVIATION * wrong["pitches"])
            if 2 * height / tan(radians(least)) >= shape.length:
                raise ValueError("error: slanted facets would cross; allowed: smaller errors, or a greater aspect")


class SinglePrismSheet(Prisms):
    """One sheet, with ridges along x: it reverses the y component of light's direction."""

    name = "single"
    title = "one sheet of Dove prisms"
    does = "reverses the y component of light's direction"
    parameters = PRISMS
    layers = 1

    @property
    def thin(self) -> Mirror:
        return Mirror({"alpha": 0.0})
