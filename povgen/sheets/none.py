"""An empty window."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.sheet import Ideal


class NoSheet(Ideal):
    """Light passes as it is."""

    name = "none"
    title = "no sheet"
    does = "leaves light as it is"
    source = ""
    law = Law("x, y, z")
