"""A sheet that rotates light by an angle that depends on the place."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import ALPHA, of
from povgen.sheets.sheet import Ideal, Parameter

_ANGLE = "(alpha + twist*sqrt(X*X + Y*Y))"


class Twist(Ideal):
    """Light is turned about the normal by alpha + twist R, where R is the distance from the window's centre."""

    name = "twist"
    title = "rotation by an angle that changes from the centre"
    does = "turns light by alpha at the centre, and by another angle outside"
    source = "this project"
    parameters = (
        of(ALPHA),
        Parameter(
            "twist", "change of the angle, -360 to 360 degrees a tile", 30, -360, 360, "degrees a tile", symbol="τ"
        ),
    )
    opening = {"alpha": 0}
    law = Law(f"cos({_ANGLE})*x + sin({_ANGLE})*y, cos({_ANGLE})*y - sin({_ANGLE})*x, z", ["alpha", "twist"])
    examples = ({"alpha": 66, "twist": 10}, {"alpha": 0, "twist": -15})
