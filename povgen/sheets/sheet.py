"""Base classes of sheets. A class is a kind: name, parameters, texts. An instance has values."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import radians
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from povgen.sheets.law import Law

if TYPE_CHECKING:  # numpy is slow to load
    from numpy.typing import ArrayLike

    from povgen.optics.aim import Matrix

Kind = Literal["number", "whole number", "direction", "choice", "text", "table"]


@dataclass(frozen=True)
class Parameter:
    """A parameter of a sheet. It is an option of the command line, and a key of a TOML file and of `--window`.

    If several kinds have a parameter of the same name, only `text` and `label` may differ.
    """

    name: str
    text: str  # what it is, for this kind of sheet, and its range
    default: Any
    least: float | None = None
    most: float | None = None
    unit: str = ""  # of an angle "degrees" or "degrees a tile"
    kind: Kind = "number"
    choices: tuple[str, ...] = ()
    size: float = 0.0  # the absolute value of a number, or of a direction's largest component, is at least this
    symbol: str = ""  # on the teaching page; otherwise its name
    label: str = ""  # what it is, beside its slider; otherwise the beginning of `text`

    @property
    def about(self) -> str:
        """What it is: the beginning of `text`."""
        return re.split(",| as ", self.text)[0]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its numbers in a law. A direction has three."""
        if self.kind == "direction":
            return tuple(f"{self.name}_{component}" for component in "xyz")
        return (self.name,)

    def numbers(self, value: Any) -> tuple[float, ...]:  # noqa: ANN401  (what the kind says)
        """Return the numbers in a law for a value: angles in radians."""
        if self.kind == "direction":
            return tuple(value)
        return (radians(value) if self.unit.startswith("degrees") else float(value),)


@dataclass(frozen=True)
class Sheet:
    """The sheet, or the pair of sheets, in a window. Its class is its kind; `values` are those of its parameters.

    Lengths are in tiles, angles in degrees.
    """

    values: Mapping[str, Any]
    aperture: float = 3.0  # side of the square window

    name: ClassVar[str]
    title: ClassVar[str]  # what it is, in a few words
    does: ClassVar[str]  # what it does to light: a predicate, such as "leaves light as it is"
    source: ClassVar[str]  # where it is described
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    rotates: ClassVar[bool] = False  # whether it turns light about the normal, and does no more
    layers: ClassVar[int] = 0  # how many sheets of prisms it consists of
    examples: ClassVar[tuple[Mapping[str, Any], ...]] = ({},)  # values with which `povgen verify` measures it
    # For ideal sheets on the teaching page. {alpha} and {alpha/2} in `sentence` are replaced by values.
    choice: ClassVar[str] = ""  # its name in the choice; otherwise the title
    # values when the user chooses this kind; otherwise the parameters' defaults
    opening: ClassVar[Mapping[str, Any]] = {}
    sentence: ClassVar[str] = ""  # what it does; otherwise what `does` says
    remark: ClassVar[str] = ""  # one more sentence; left out if, with its values, the sheet only rotates light
    # first and last value of a parameter, in place of those of the paper's movies
    sweep: ClassVar[Mapping[str, tuple[float, float]]] = {}

    def __hash__(self) -> int:
        return hash((type(self), str(sorted(self.values.items())), self.aperture))

    @property
    def alpha(self) -> float:
        """The angle by which light is turned about the normal, radians; 0 for sheets without this parameter."""
        return radians(self.values.get("alpha", 0.0))

    @property
    def transfer(self) -> "Matrix | None":
        """The ray-transfer matrix (`optics.aim`), of prisms in paraxial approximation; None if the sheet has none."""
        return None

    @property
    def depth(self) -> float:
        """Extent along z, tiles."""
        return 0.0

    @property
    def thin(self) -> "Ideal":
        """The ideal sheet with the same law for light on the designed path."""
        raise NotImplementedError

    def slope(self, slope: "ArrayLike", place: "ArrayLike" = 0) -> Any:  # noqa: ANN401
        """Return a ray's slope behind the sheet. The ray comes from the eye. Slopes and places are x + iy."""
        return self.thin.slope(slope, place)


@dataclass(frozen=True)
class Ideal(Sheet):
    """A sheet without thickness: light leaves it where it has met it, in the direction that its law states."""

    law: ClassVar[Law]

    __hash__ = Sheet.__hash__

    @property
    def thin(self) -> "Ideal":
        return self

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers of the parameters in the law, by their names."""
        found: dict[str, float] = {}
        for each in self.parameters:
            found |= zip(each.names, each.numbers(self.values[each.name]), strict=True)
        return found

    def bend(self, direction: "ArrayLike", place: "ArrayLike" = 0) -> Any:  # noqa: ANN401
        """Return unit directions (..., 3) behind the sheet, NaN if no light passes: `Law.bend`."""
        return self.law.bend(direction, place, self.numbers)

    def slope(self, slope: "ArrayLike", place: "ArrayLike" = 0) -> Any:  # noqa: ANN401
        """Return a ray's slope behind the sheet. The ray comes from the eye. Slopes and places are x + iy."""
        import numpy as np

        s = np.asarray(slope, complex)
        bent = self.bend(np.stack(np.broadcast_arrays(s.real, s.imag, 1.0), -1), place)
        with np.errstate(invalid="ignore"):
            return (bent[..., 0] + 1j * bent[..., 1]) / bent[..., 2]

    @cached_property
    def transfer(self) -> "Matrix | None":
        """The matrix if the slope behind the sheet is a linear function of the slope before it and of the place.

        Five rays determine it. If one of 20 other rays disagrees, there is no matrix.
        """
        import numpy as np

        probes = np.array([0, 1, 1j, 0, 0]), np.array([0, 0, 0, 1, 1j])
        s = self.slope(*probes)
        steps = s[1:] - s[0]
        others = np.random.default_rng(1).uniform(-2, 2, (4, 20))
        slope, place = others[0] + 1j * others[1], others[2] + 1j * others[3]
        linear = s[0] + sum(step * part for step, part in zip(steps, others, strict=True))
        if not (abs(self.slope(slope, place) - linear) <= 1e-11 * (1 + abs(steps).max())).all():
            return None
        matrix = np.eye(5)
        matrix[2:4] = [[*part(steps[2:]), *part(steps[:2]), part(s[0])] for part in (np.real, np.imag)]
        return matrix
