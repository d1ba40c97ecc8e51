"""A sheet behind which one plane appears turned as a rigid body."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import ALPHA, of
from povgen.sheets.sheet import Ideal, Parameter

_X = "((cos(alpha) - 1)*X + sin(alpha)*Y)*z/view_distance"
_Y = "((cos(alpha) - 1)*Y - sin(alpha)*X)*z/view_distance"


class ViewRotator(Ideal):
    """What stands at view_distance behind the sheet appears turned by alpha about the window's centre.

    A ray that would meet this plane at Q meets it at Q turned by -alpha. So every eye sees what is there turned as a
    whole, and not scaled. The sheet `ideal` turns it about the point opposite the eye, and scales it.
    """

    name = "view-rotator"
    title = "view rotator for one distance"
    does = "shows what is at view_distance turned by alpha about the window's centre, for every eye"
    source = "this project"
    parameters = (
        of(ALPHA),
        Parameter(
            "view_distance",
            "distance of the plane that appears undistorted, 0.1 to 100 tiles",
            2,
            0.1,
            100,
            "tiles",
            symbol="D",
        ),
    )
    law = Law(
        f"cos(alpha)*x + sin(alpha)*y + {_X}, cos(alpha)*y - sin(alpha)*x + {_Y}, z",
        ["alpha", "view_distance"],
    )
    examples = ({"alpha": 66, "view_distance": 2}, {"alpha": -150, "view_distance": 3})
