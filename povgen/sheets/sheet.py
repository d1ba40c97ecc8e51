"""Base classes of sheets. A subclass is a kind of sheet. An instance is a sheet with values of its parameters.

An ideal sheet has a law: the direction of a ray behind the sheet, for a ray that comes from the eye (`law_grammar.py`).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from povgen.optics import faces
from povgen.optics.paraxial import Matrix
from povgen.sheets.buildable import PRISMS_PAGE, Buildable, judged
from povgen.sheets.law_grammar import Law

Kind = Literal["number", "whole number", "direction", "choice", "glass", "text", "table", "profile"]


class Said(NamedTuple):
    """How a caption says a parameter's value."""

    words: str  # {} stands for the value with its unit, {NAME} for the value of the sheet's parameter NAME
    factor: float = 1  # the caption states the value times this factor
    full: str = ""  # for `--caption full`; if empty, `words` is used


@dataclass(frozen=True)
class Parameter:
    """A parameter of a sheet. It can be set on the command line, in a TOML file, and in the text of `--window`.

    Several kinds of sheets can have a parameter with the same name. Then these parameters may differ only in
    `text` and `said`.
    """

    name: str
    text: str  # what it is, for this kind of sheet, and its range
    default: Any
    least: float | None = None
    most: float | None = None
    unit: str = ""  # such as "tiles"; for an angle "degrees" or "degrees a tile"
    kind: Kind = "number"
    choices: tuple[str, ...] = ()
    size: float = 0.0  # the least absolute value of a number, or of a direction's largest component
    symbol: str = ""  # shown on the teaching page; if empty, the name is shown
    said: Said | None = None  # how captions state it; None: as `NAME = value`

    @property
    def about(self) -> str:
        """A short description: `text` up to its first comma, or to " as "."""
        return re.split(",| as ", self.text)[0]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of this parameter's numbers in a law. A direction has three numbers."""
        if self.kind == "direction":
            return tuple(f"{self.name}_{component}" for component in "xyz")
        return (self.name,)

    def numbers(self, value: Any) -> tuple[float, ...]:  # noqa: ANN401  (its type depends on `kind`)
        """Convert a value of this parameter to the numbers in a law. Angles become radians."""
        if self.kind == "direction":
            return tuple(value)
        return (value * (pi / 180) if self.unit.startswith("degrees") else float(value),)


@dataclass(frozen=True)
class Sheet:
    """What a window holds: one sheet, or a pair of sheets. In the code, the pair as a whole is also called a sheet.

    `values` are the values of its parameters. Lengths are in tiles, angles in degrees.
    """

    values: Mapping[str, Any]
    aperture: float = 3.0  # side of the square window

    name: ClassVar[str]
    title: ClassVar[str]  # what it is, in a few words
    does: ClassVar[str]  # what it does to light: a predicate, such as "leaves light as it is"
    source: ClassVar[str]  # where it is described
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    rotates: ClassVar[bool] = False  # whether it turns light about the normal, and does no more
    layers: ClassVar[int] = 0  # how many sheets of prisms or lenses it consists of
    examples: ClassVar[tuple[Mapping[str, Any], ...]] = ({},)  # values for which `povgen verify` tests the sheet
    angle: ClassVar[float | None] = None  # the default of alpha, degrees, if it is not that of `parameters`
    # values at the start on the teaching page; a parameter that is missing here has its default
    opening: ClassVar[Mapping[str, Any]] = {}
    # first and last value of each parameter in the teaching page's movies; default: the values of the paper's movies
    sweep: ClassVar[Mapping[str, tuple[float, float]]] = {}

    def __hash__(self) -> int:
        plain = (self.values[name] for name in sorted(self.values))
        return hash((type(self), self.aperture, *(x for x in plain if isinstance(x, (int, float, str)))))

    @property
    def alpha(self) -> Any:  # noqa: ANN401  (a number, or an array)
        """The parameter alpha, radians; 0 for sheets without it.

        If the sheet turns light, alpha is positive for light that turns counter-clockwise, as the eye sees it.
        """
        return self.values.get("alpha", 0.0) * (pi / 180)  # alpha may be an array

    @property
    def line(self) -> tuple[str, complex] | None:
        """The line in the sheet's plane about which light is mirrored or turned: name and direction x + iy. Or None."""
        return None

    @property
    def transfer(self) -> Matrix | None:
        """The ray-transfer matrix (..., 5, 5) of `optics.apparent`, or None if the sheet has none.

        For sheets of glass it is the paraxial approximation.
        """
        return None

    def buildable(self) -> Buildable:
        """Return what is known to do what the sheet does: prisms, lenses or nothing, with the reason."""
        number = "one sheet" if self.layers == 1 else "two sheets"
        return Buildable("as it is", f"it is {number} of glass", PRISMS_PAGE)

    @property
    def is_exact(self) -> bool:
        """Whether the sheet has no errors of manufacture."""
        return True

    @property
    def depth(self) -> float:
        """Extent along z, tiles."""
        return 0.0

    @property
    def glass(self) -> tuple[faces.GlassSheet, ...]:
        """The layers of glass of which this sheet consists, the one nearest to the eye first; none of an ideal sheet.

        They are in the window's own coordinates.
        """
        return ()

    @property
    def thin(self) -> "Ideal":
        """The ideal sheet that does to every ray what this sheet does to the rays for which it is designed.

        In a Dove prism, these rays enter through one facet, are reflected at the base, and leave through the other
        facet. In arrays of lenses, they leave through the lens opposite to the one where they enter.
        """
        raise NotImplementedError

    def slope(self, slope: ArrayLike, place: ArrayLike = 0) -> Any:  # noqa: ANN401
        """Return the slope behind the sheet of a ray from the eye.

        Slopes and places are complex numbers: dx/dz + i dy/dz, and X + iY in tiles from the window's centre. x points
        right and y up, as the eye sees them, and z away from the eye. The result is NaN if no light passes. For sheets
        of glass it is that of `thin`.
        """
        return self.thin.slope(slope, place)


@dataclass(frozen=True)
class Ideal(Sheet):
    """A sheet without thickness. A ray from the eye leaves where it arrives, in the direction that the law states."""

    law: ClassVar[Law]

    __hash__ = Sheet.__hash__

    @property
    def thin(self) -> "Ideal":
        return self

    def buildable(self) -> Buildable:
        return judged(self.bend, self.aperture / 2)

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers of the parameters in the law, by their names."""
        found: dict[str, float] = {}
        for each in self.parameters:
            found |= zip(each.names, each.numbers(self.values[each.name]), strict=True)
        return found

    def bend(self, direction: ArrayLike, place: ArrayLike = 0) -> Any:  # noqa: ANN401
        """Return unit directions (..., 3) behind the sheet, NaN if no light passes: `Law.bend`."""
        return self.law.bend(direction, place, self.numbers)

    def slope(self, slope: ArrayLike, place: ArrayLike = 0) -> Any:  # noqa: ANN401
        """Return the slope behind the sheet of a ray from the eye: `Sheet.slope`."""
        s = np.asarray(slope, complex)
        bent = self.bend(np.moveaxis(np.stack(np.broadcast_arrays(s.real, s.imag, 1.0)), 0, -1), place)
        with np.errstate(invalid="ignore"):
            return bent[..., 0] / bent[..., 2] + 1j * (bent[..., 1] / bent[..., 2])

    @cached_property
    def transfer(self) -> Matrix | None:
        """The ray-transfer matrix; None if the sheet has none.

        A sheet has one if the slope behind it is a constant plus a linear function of the slope before the sheet and of
        the place. Five rays determine the matrix. If one of 20 other rays disagrees, there is none.
        """
        shape = np.broadcast_shapes(*map(np.shape, self.numbers.values()))
        # The parameters can be arrays, which stand for several sheets. The first axis of `s` counts the rays, the other
        # axes count the sheets.
        axes = (slice(None), *[None] * len(shape))
        s = self.slope(np.array([0, 1, 1j, 0, 0])[axes], np.array([0, 0, 0, 1, 1j])[axes])
        steps = s[1:] - s[0]
        others = np.random.default_rng(1).uniform(-2, 2, (4, 20))
        slope, place = others[0] + 1j * others[1], others[2] + 1j * others[3]
        linear = s[0] + np.einsum("i...,ij->j...", steps, others)
        if not (abs(self.slope(slope[axes], place[axes]) - linear) <= 1e-11 * (1 + abs(steps).max(initial=0))).all():
            return None
        matrix = np.broadcast_to(np.eye(5), (*shape, 5, 5)).copy()
        columns = np.moveaxis(np.stack((*steps[2:], *steps[:2], s[0])), 0, -1)
        matrix[..., 2, :], matrix[..., 3, :] = columns.real, columns.imag
        return matrix
