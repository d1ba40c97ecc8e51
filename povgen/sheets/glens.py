"""A lens with two focal lengths."""

from dataclasses import replace

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import FOCAL_LENGTH, of
from povgen.sheets.sheet import Ideal


class Glens(Ideal):
    """Planes at distances a on the eye's side and b on the object's are imaged into each other if f/a + g/b = 1.

    f is focal_length and g is object_focal_length. If f = g, the sheet is a thin lens.
    """

    name = "glens"
    title = "glens, a lens with two focal lengths"
    does = "images as a lens with a focal length for each side"
    source = "Chaplain, Macauley, Belin, Tyc, Cowie and Courtial, J. Opt. Soc. Am. A 33, 962 (2016)"
    parameters = (
        of(FOCAL_LENGTH, "focal length, on the eye's side, -100 to -0.1 or 0.1 to 100 tiles"),
        replace(
            FOCAL_LENGTH,
            name="object_focal_length",
            text="focal length on the object's side, -100 to -0.1 or 0.1 to 100 tiles",
            default=6,
            symbol="g",
        ),
    )
    law = Law(
        "(focal_length*x - X*z)/object_focal_length, (focal_length*y - Y*z)/object_focal_length, z",
        ["focal_length", "object_focal_length"],
    )
    examples = (
        {"focal_length": 4, "object_focal_length": 6},
        {"focal_length": -4, "object_focal_length": 5},
    )
