"""One infinitely fine sheet of Dove prisms."""

from povgen.sheets.law import Law
from povgen.sheets.parameters import ALPHA, of
from povgen.sheets.sheet import Ideal


class Mirror(Ideal):
    """The transverse part of light's direction is mirrored about a line in the sheet, at alpha/2 to the x axis."""

    name = "mirror"
    title = "one infinitely fine sheet of prisms"
    does = "mirrors light's transverse direction about a line at alpha/2"
    source = "Hamilton, Sundar, Nelson and Courtial, Local light-ray rotation (2009)"
    parameters = (of(ALPHA, ALPHA.text, "twice the angle of the mirror line"),)
    choice = "one mirroring"
    opening = {"alpha": 90}
    sentence = "The sheet mirrors the light’s slope about a line at {alpha/2}, as one sheet of prisms does."
    law = Law("cos(alpha)*x + sin(alpha)*y, sin(alpha)*x - cos(alpha)*y, z", ["alpha"])
    examples = ({"alpha": 0}, {"alpha": 60}, {"alpha": -100})
