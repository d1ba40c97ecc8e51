"""Confocal lenslet arrays."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import ALPHA, FOCAL_LENGTHS, RATIO, of
from povgen.sheets.sheet import Ideal


class Lenslets(Ideal):
    """Light's slope is multiplied by ratio * exp(i alpha): Snell's law with tangents in place of sines.

    For real lenslets, with the focal length f1 on the object's side and f2 on the eye's, `ratio` is f1/f2 and alpha
    is 180 degrees. Their field of view is limited; the law's is not.
    """

    name = "lenslets"
    title = "confocal lenslet arrays"
    does = "multiplies light's slope by the ratio, and turns light by alpha"
    source = "Courtial, New J. Phys. 10, 083033 (2008)"
    parameters = (
        ALPHA,
        of(RATIO, "ratio of focal lengths, the object's side over the eye's, 0.1 to 10", FOCAL_LENGTHS),
    )
    opening = {"alpha": 180, "ratio": 2}
    law = Law(
        "(cos(alpha)*x + sin(alpha)*y)/ratio, (cos(alpha)*y - sin(alpha)*x)/ratio, z",
        ["alpha", "ratio"],
    )
    examples = ({"alpha": 180, "ratio": 1.5}, {"alpha": 180, "ratio": 0.8}, {"alpha": 50, "ratio": 0.8})
