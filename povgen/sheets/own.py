"""A sheet whose law the user states. `law_grammar.py` checks the law."""

from functools import cached_property

from povgen.optics.paraxial import Matrix
from povgen.sheets.law_grammar import Law
from povgen.sheets.sheet import Ideal, Parameter


class OwnLaw(Ideal):
    """The law and the values of its parameters are the user's. Angles in it are in radians."""

    name = "law"
    title = "a law of one's own"
    does = "bends light by the user's law"
    source = "docs/beyond.md"
    parameters = (
        Parameter(
            "law",
            "direction behind the sheet of a ray from the eye: three expressions, for x, y and z, separated by commas, "
            "such as 'x, y - k*Y*z, z'",
            "x, y, z",
            kind="text",
        ),
        Parameter("parameter", "number in the law, such as k=0.3", {}, kind="table"),
    )
    examples = (
        {"law": "x - k*X*z, y, z", "parameter": {"k": 0.3}},  # a cylinder lens
        {"law": "x + k*sin(2*X)*z, y + k*sin(2*Y)*z, z", "parameter": {"k": 0.05}},
    )

    @cached_property
    def law(self) -> Law:  # type: ignore[override]  # in other kinds it is a class attribute
        return Law(self.values["law"], self.values["parameter"])

    @cached_property
    def transfer(self) -> Matrix | None:
        """The ray-transfer matrix, or None. Only smooth laws that multiply z by constants have one.

        `x + max(X - 3, 0), y, z` is linear where the rays that determine the matrix meet the sheet, but not everywhere.
        `x*(9 - X*X), y*(9 - X*X), z*(9 - X*X)` leaves light as it is there, and blocks light elsewhere.
        """
        return super().transfer if self.law.is_smooth and self.law.only_scales_z else None

    @property
    def numbers(self) -> dict[str, float]:
        return dict(self.values["parameter"])
