"""An interface between media with a real or complex ratio of refractive indices."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import ALPHA, RATIO, of
from povgen.sheets.sheet import Ideal, Said

_X = "(cos(alpha)*x + sin(alpha)*y)/ratio"
_Y = "(cos(alpha)*y - sin(alpha)*x)/ratio"


class Refraction(Ideal):
    """The sine of light's angle to the normal is multiplied by the ratio (Snell's law), and light is turned by alpha.

    The complex ratio is ratio * exp(i alpha). alpha = 180 degrees is negative refraction. Light passes if the new sine
    is less than 1; otherwise it is totally reflected.
    """

    name = "refraction"
    title = "refraction by a complex ratio of indices"
    does = "multiplies the sine of light's angle by the ratio, and turns light by alpha"
    source = "Sundar, Hamilton and Courtial, Opt. Lett. 34, 374 (2009)"
    parameters = (
        of(ALPHA, said=Said("index behind/in front = {ratio}, light turned by {}")),
        of(RATIO, "ratio of refractive indices, the object's side over the eye's, 0.1 to 10", Said("n₁/n₂ = {}")),
    )
    opening = {"alpha": 40, "ratio": 0.7}
    law = Law(f"{_X}, {_Y}, sqrt(max(1 - (x*x + y*y)/(ratio*ratio), 0))", ["alpha", "ratio"])
    examples = ({"alpha": 0, "ratio": 1.5}, {"alpha": 180, "ratio": 1}, {"alpha": 50, "ratio": 0.6})
