"""Sheets of any profile: a cross-section that the user states, or one of povgen's."""

import os
import tomllib
from functools import cached_property
from typing import Annotated

from pydantic import Field, model_serializer
from pydantic.dataclasses import dataclass

from povgen.files import read_text
from povgen.limits import MAX_PRISMS
from povgen.optics import paraxial, profile
from povgen.optics.prism import Prism
from povgen.record import held
from povgen.sheets.crossed import Alone, Crossed
from povgen.sheets.layered import Layered
from povgen.sheets.parameters import ALPHA
from povgen.sheets.sheet import Ideal, Parameter
from povgen.validation import Model

NAMES = ("dove", "confocal", "lenticulars", "wedges")  # functions of optics/profile.py
MAX_BYTES = 2**14  # of a file
NEARLY = 0.02  # a sheet reverses slopes if `factor` differs from -1, and `deviation` from 0, by less than this


Number = Annotated[float, Field(ge=-1e9, le=1e9)]


class _Outline(Model):
    corners: Annotated[tuple[tuple[Number, Number], ...], Field(min_length=2)] = Field(
        description="two or more points, as [[0, 0], [1, 0]]"
    )
    radii: tuple[Number, ...] = Field(default=(), description="a number for each edge; 0: straight")


class _Table(Model):
    """What a profile's file states. Lengths are in the unit of `period`."""

    index: Number = Field(default=1.5, description="refractive index, above 1, up to 4")
    gap: Number | None = Field(default=None, description="air between two sheets (default: 0.01 periods)")
    period: Annotated[Number, Field(gt=0)] = Field(default=1, description="above 0")
    outline: tuple[_Outline, ...] = Field(description="a table [[outline]] for each outline")
    path: tuple[int, ...] = Field(description="numbers of the edges that light should meet, as [1, 2]")


@dataclass(frozen=True)
class ProfileFile:
    """A TOML file that states a profile, and its text."""

    path: str
    text: str

    @cached_property
    def profile(self) -> profile.Profile:
        """The profile, with the pitch 1. Raises ValueError if the text is not TOML, or states none that is allowed."""
        try:
            table = _Table(**tomllib.loads(self.text))
        except RecursionError:  # thousands of brackets
            raise ValueError("not TOML") from None
        outlines = []
        for number, (corners, radii) in enumerate(((each.corners, each.radii) for each in table.outline), 1):
            if len(radii) not in (0, len(corners) - 1):
                raise ValueError(
                    f"outline {number}: {len(radii)} radii; allowed: one for each of {len(corners) - 1} edges"
                )
            points = tuple((u / table.period, z / table.period) for u, z in corners)
            several = tuple(radius / table.period for radius in radii or (0.0,) * (len(corners) - 1))
            outlines.append(profile.Outline(points, several))
        gap = 0.01 if table.gap is None else table.gap / table.period
        return profile.Profile.of_outlines(outlines, table.path, table.index, gap)

    @model_serializer
    def __str__(self) -> str:
        return self.path.encode(errors="backslashreplace").decode()  # a path can have bytes that are no text


def as_profile(value: object) -> object:
    """Return the `ProfileFile` of a path. Return the name of one of povgen's profiles, and any other value, as it is.

    Raises ValueError if the file cannot be read or does not state a profile.
    """
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, str) and value not in NAMES:
        path = os.path.expanduser(value)
        value = held(value, ProfileFile) or ProfileFile(path, read_text(path, MAX_BYTES))
    if not isinstance(value, ProfileFile):
        return value
    try:
        value.profile  # noqa: B018  (it is checked)
    except ValueError as error:
        raise ValueError(f"no profile: {error}") from None
    return value


class ProfileSheets(Layered):
    """The cross-section is repeated across the window, and extruded along the ridges."""

    name = "profile"
    title = "sheets of any profile"
    does = "bends light by its cross-section"
    source = "this project"
    parameters = (
        ALPHA,
        Parameter(
            "profile",
            f"cross-section of a sheet: {', '.join(NAMES)}, or a TOML file",
            "wedges",
            kind="profile",
        ),
        Parameter("periods", f"periods of the profile across the window, 1 to {MAX_PRISMS}", 100, 1, MAX_PRISMS,
                  kind="whole number"),
        Parameter(
            "arrangement",
            "a pair of sheets, of which the near one is turned by alpha/2, or a single one",
            "pair",
            kind="choice",
            choices=("pair", "single"),
        ),
    )  # fmt: skip
    counted = "periods"

    @property
    def layers(self) -> int:  # type: ignore[override]  # in other kinds it is a class attribute
        return 1 if self.values["arrangement"] == "single" else 2

    @property
    def rotates(self) -> bool:  # type: ignore[override]
        if self.layers == 1:
            return False
        does = self._does
        return abs(does.factor + 1) < NEARLY and abs(does.deviation) < NEARLY

    @cached_property
    def shape(self) -> profile.Profile:
        value = self.values["profile"]
        if isinstance(value, ProfileFile):
            return value.profile.scaled(self.pitch)
        made = profile.dove(Prism(1.0)) if value == "dove" else getattr(profile, value)()
        return made.scaled(self.pitch)

    @cached_property
    def _does(self) -> paraxial.SmallAngles:
        return paraxial.small_angles(self.shape)

    @property
    def thin(self) -> Ideal:
        does = self._does
        values = {"factor": does.factor, "deviation": does.deviation}
        return Alone(values) if self.layers == 1 else Crossed({"alpha": self.values["alpha"], **values})
