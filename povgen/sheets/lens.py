"""A thin lens that fills the window."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import FOCAL_LENGTH
from povgen.sheets.sheet import Ideal


class Lens(Ideal):
    """An object at z1 has its image at b, with 1/z1 + 1/b = 1/focal_length. This holds at any angle of light."""

    name = "lens"
    title = "thin lens"
    does = "bends light as an ideal thin lens does"
    source = "any textbook of optics"
    parameters = (FOCAL_LENGTH,)
    law = Law("x - X*z/focal_length, y - Y*z/focal_length, z", ["focal_length"])
    examples = ({"focal_length": 4}, {"focal_length": -8})
