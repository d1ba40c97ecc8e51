"""Two sheets of confocal lenticular arrays of finite size, as they are built."""

from dataclasses import replace
from functools import cached_property

from povgen.limits import MAX_PRISMS
from povgen.optics import faces
from povgen.optics.profile import Profile, confocal
from povgen.sheets.crossed import Crossed
from povgen.sheets.layered import Layered
from povgen.sheets.parameters import (
    ALPHA,
    DESIGN_WAVELENGTH,
    FOCAL_LENGTHS,
    GAP,
    GLASS,
    INDEX,
    RATIO,
    design_index,
    of,
)
from povgen.sheets.prisms import ERROR, OF_LENSES, check_ranges
from povgen.sheets.rotation import Rotation
from povgen.sheets.sheet import Ideal, Parameter, Said


class Lenticular(Layered):
    """Each sheet is a block of glass with cylindrical lenses on both faces, whose focal planes coincide.

    A sheet multiplies the slope across its ridges by -f1/f2, with the focal length f1 on the object's side and f2 on
    the eye's. With f1 = f2 it mirrors the slope, as a sheet of Dove prisms does.
    """

    name = "lenticular"
    title = "two sheets of confocal lenticular arrays"
    does = "turns light by alpha about the sheets' normal, if the ratio is 1"
    source = "Blair, Clark, Houston, Smith, Leach, Hamilton and Courtial, Opt. Commun. 282, 4299 (2009)"
    parameters = (
        ALPHA,
        Parameter(
            "lenses",
            f"cylindrical lenses across the window, on each face of a sheet, 1 to {MAX_PRISMS}",
            100,
            1,
            MAX_PRISMS,
            kind="whole number",
            symbol="N",
            said=Said("{} lenses"),
        ),
        of(RATIO, "ratio of focal lengths, the object's side over the eye's, 0.1 to 10", FOCAL_LENGTHS),
        Parameter(
            "f_number",
            "f-number of the lenses on the eye's side: focal length in the glass, in units of the pitch, 1 to 100",
            3,
            1,
            100,
            symbol="F",
            said=Said("f/{} lenses"),
        ),
        INDEX,
        GLASS,
        DESIGN_WAVELENGTH,
        GAP,
        ERROR,
    )
    counted = "lenses"
    layers = 2

    @property
    def rotates(self) -> bool:  # type: ignore[override]  # in other kinds it is a class attribute
        return bool(self.values["ratio"] == 1)

    @property
    def is_exact(self) -> bool:
        return not any(self.values["error"].get(name) for name in OF_LENSES)

    def check_errors(self) -> None:
        """Raise ValueError for an error that lenses cannot have, or that is outside its range.

        Also raise it if no lenses with these errors are possible.
        """
        check_ranges(self.values["error"], OF_LENSES, "lenses")
        if not self.is_exact:
            _ = self.glass

    @cached_property
    def shape(self) -> Profile:
        return self._shape_of(0.0)

    @property
    def glass(self) -> tuple[faces.GlassSheet, ...]:
        near, far = super().glass
        wrong = [self.values["error"].get(name, 0.0) for name in OF_LENSES]
        return replace(near, shape=self._shape_of(wrong[0])), replace(far, shape=self._shape_of(wrong[1]))

    def _shape_of(self, mismatch: float) -> Profile:
        """Return the shape of a sheet whose pitch on the object's side is greater by the fraction `mismatch`.

        Raises ValueError, which names f_number and ratio, if there is no such shape.
        """
        ratio, f_number = self.values["ratio"], self.values["f_number"]
        try:
            shape = confocal(ratio, f_number, design_index(self.values), self.values["gap"], mismatch)
        except ValueError as error:
            raise ValueError(f"f_number = {f_number:g} and ratio = {ratio:g}: {error}") from None
        return replace(shape, index=self.values["index"], pitch=self.pitch)

    @property
    def thin(self) -> Ideal:
        if self.rotates:
            return Rotation({"alpha": self.values["alpha"]})
        values = {"alpha": self.values["alpha"], "factor": -1 / self.values["ratio"], "deviation": 0.0}
        return Crossed(values)
