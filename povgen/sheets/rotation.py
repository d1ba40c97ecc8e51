"""The ideal sheet of the paper: it rotates light about its normal."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import ALPHA
from povgen.sheets.sheet import Ideal


class Rotation(Ideal):
    """Light is turned counter-clockwise by alpha, as the eye sees it.

    The law is that of a ray from the eye. Such a ray runs against the light, so it turns clockwise. A pair of sheets of
    Dove prisms does the same to rays on its designed path, apart from their place.
    """

    name = "ideal"
    title = "infinitely fine sheet"
    does = "turns light by alpha about the sheet's normal"
    source = "Hamilton, Sundar, Nelson and Courtial, Local light-ray rotation (2009)"
    parameters = (ALPHA,)
    rotates = True
    law = Law("cos(alpha)*x + sin(alpha)*y, cos(alpha)*y - sin(alpha)*x, z", ["alpha"])
    examples = ({"alpha": 66}, {"alpha": -130})
