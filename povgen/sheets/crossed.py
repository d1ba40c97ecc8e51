"""Laws of infinitely fine sheets that scale the slope of light across their ridges. They are no kinds of their own."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.sheet import Ideal, Parameter

# No user states these: they follow from a sheet's shape. So they have no ranges. `deviation` is a change of slope.
_FACTOR, _DEVIATION = Parameter("factor", "", -1.0), Parameter("deviation", "", 0.0)
_ALONG, _ACROSS = "(cos(alpha/2)*x + sin(alpha/2)*y)", "(cos(alpha/2)*y - sin(alpha/2)*x)"
_BEHIND = f"(factor*{_ACROSS} + deviation*z)"


class Alone(Ideal):
    """One sheet, with ridges along x. It changes a ray's slope t across the ridges to `factor` t + `deviation`."""

    parameters = (_FACTOR, _DEVIATION)
    law = Law("x, factor*y + deviation*z, z", ["factor", "deviation"])


class Crossed(Ideal):
    """Two such sheets. The one near the eye is turned by alpha/2 about the normal. Mirrors have the factor -1."""

    parameters = (Parameter("alpha", "", 0.0, unit="degrees"), _FACTOR, _DEVIATION)
    law = Law(
        f"cos(alpha/2)*{_ALONG} - sin(alpha/2)*{_BEHIND},"
        f"factor*(sin(alpha/2)*{_ALONG} + cos(alpha/2)*{_BEHIND}) + deviation*z, z",
        ["alpha", "factor", "deviation"],
    )
