"""A sheet that rotates light about any axis."""

from povgen.sheets.law_grammar import Law
from povgen.sheets.parameters import ALPHA, of
from povgen.sheets.sheet import Ideal, Parameter, Said

# Rodrigues' formula for the angle -alpha, because the ray runs against the light.
_SQUARE = "(axis_x*axis_x + axis_y*axis_y + axis_z*axis_z)"
_ALONG = f"(axis_x*x + axis_y*y + axis_z*z)*((1 - cos(alpha))/{_SQUARE})"
_ACROSS = f"(sin(alpha)/sqrt({_SQUARE}))"


class AxisRotation(Ideal):
    """Light is rotated by alpha about an axis.

    alpha is positive if the rotation is counter-clockwise for somebody who looks along the axis. With the axis
    (0, 0, 1), the sheet does the same as `ideal`. Light passes if the rotated direction still points to the eye's side.
    """

    name = "axis"
    title = "rotation about an axis"
    does = "turns light by alpha about the axis"
    source = "Hamilton, Sundar and Courtial, J. Opt. 12, 095101 (2010)"
    parameters = (
        of(ALPHA, said=Said("light turned by {} about the axis")),
        Parameter(
            "axis",
            "axis of rotation as X,Y,Z, to the right, up and away from the eye, each from -1 to 1, one at least 0.001; "
            "in chess and spheres, --sheet axis has alpha 15 by default",
            (0.0, 1.0, 0.0),
            -1,
            1,
            kind="direction",
            size=0.001,  # POV-Ray squares the components, and tiny squares are 0
            symbol="a",
        ),
    )
    angle = 15  # at 66 degrees, most light would not pass
    opening = {"alpha": angle}
    sweep = {"alpha": (-60, 60)}  # for larger angles it is dark
    law = Law(
        f"cos(alpha)*x - {_ACROSS}*(axis_y*z - axis_z*y) + {_ALONG}*axis_x,"
        f"cos(alpha)*y - {_ACROSS}*(axis_z*x - axis_x*z) + {_ALONG}*axis_y,"
        f"cos(alpha)*z - {_ACROSS}*(axis_x*y - axis_y*x) + {_ALONG}*axis_z",
        ["alpha", "axis_x", "axis_y", "axis_z"],
    )
    examples = (
        {"alpha": 25, "axis": (0, 1, 0)},
        {"alpha": -40, "axis": (0.6, 0.3, 1)},
        {"alpha": 60, "axis": (1, 0, -1)},
    )

    @property
    def line(self) -> tuple[str, complex] | None:
        x, y, z = self.values["axis"]
        return ("axis", complex(x, y)) if z == 0 else None
