"""One infinitely fine sheet of Dove prisms."""

from cmath import rect

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import ALPHA, of
from povgen.sheets.sheet import Ideal, Said


class Mirror(Ideal):
    """The transverse part of light's direction is mirrored about a line in the sheet, at alpha/2 to the x axis."""

    name = "mirror"
    title = "one infinitely fine sheet of prisms"
    does = "mirrors light's transverse direction about a line at alpha/2"
    source = "Hamilton, Sundar, Nelson and Courtial, Local light-ray rotation (2009)"
    parameters = (of(ALPHA, said=Said("mirror line at {}", 0.5)),)
    opening = {"alpha": 90}
    law = Law("cos(alpha)*x + sin(alpha)*y, sin(alpha)*x - cos(alpha)*y, z", ["alpha"])
    examples = ({"alpha": 0}, {"alpha": 60}, {"alpha": -100})

    @property
    def line(self) -> tuple[str, complex]:
        return "mirror line", rect(1, self.alpha / 2)
