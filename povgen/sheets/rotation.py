"""The ideal sheet of the paper: it rotates light about its normal."""

from povgen.sheets.law import Law
from povgen.sheets.parameters import ALPHA
from povgen.sheets.sheet import Ideal


class Rotation(Ideal):
    """Light is turned counter-clockwise by alpha, as the eye sees it. The pair of Dove-prism sheets approaches it."""

    name = "ideal"
    title = "infinitely fine sheet"
    does = "turns light by alpha about the sheet's normal"
    source = "Hamilton, Sundar, Nelson and Courtial, Local light-ray rotation (2009)"
    parameters = (ALPHA,)
    rotates = True
    law = Law("cos(alpha)*x + sin(alpha)*y, cos(alpha)*y - sin(alpha)*x, z", ["alpha"])
    examples = ({"alpha": 66}, {"alpha": -130})
