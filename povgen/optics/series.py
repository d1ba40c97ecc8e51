"""Windows in series: the images that parallel ray-rotating windows form (Hamilton and Courtial 2008), on numpy arrays.

Signs and units are as in `equations`. `behind` are the windows behind the first one, as in `equations.depth`. Windows
have no thickness. `equations.apparent_position` says where light crosses the first window.

Light from L that reaches the eye E with the slope s obeys L - E = Z s, with the complex depth Z of `equations.depth`.
Without windows, L - E = (z2 + w) s for a point L at the distance w behind the plane of the first window. So if W = Z -
z2 is real, the light of L runs as if it came from the point with L's x and y at w = W, whatever its slope: an image. W
does not depend on the eye. All points of a plane have the same W, so the image is upright and as large as the object.
"""

import numpy as np
from numpy.typing import ArrayLike

from povgen.optics.equations import ROUNDING, Complexes, Floats, Windows, depth


def image_depth(z1: ArrayLike, alpha: ArrayLike, behind: Windows = ()) -> Complexes:
    """Return W = Z - z2, the complex depth of the object behind the first window.

    Two rays from L whose slopes at the eye differ by ds are |W - w| |ds| apart at the distance w behind the first
    window (before it if w < 0). So the light is closest together at w = Re W. There the distance is |Im W| |ds|:
    without an image the light never comes together.
    """
    return depth(z1, 0, alpha, behind)


def imaged_plane(alpha: ArrayLike, behind: Windows = ()) -> tuple[Floats, Floats]:
    """Return z1 of the plane that has an image, and the distance of the image behind the first window.

    Let phi be the sum of all angles, and c the depth of the last window: `image_depth` at z1 = 0. Then
    W = c + z1 exp(-i phi), and Im W = 0 at z1 = Im(c)/sin(phi). For two windows, d apart, this is the law of
    sines: z1 = -d sin(alpha_1)/sin(alpha_1 + alpha_2), and W = d sin(alpha_2)/sin(alpha_1 + alpha_2).

    z1 < 0 is a plane before the last window: no object can stand there, but an image made by other optics can. If
    sin(phi) = 0, both results are NaN. Then every plane has an image if Im c = 0, and otherwise no plane has one.
    `apparent.image` finds the image of a given plane.
    """
    behind = tuple(behind)
    c = image_depth(0, alpha, behind)
    phi = np.asarray(alpha) + sum(np.asarray(turn) for _, turn in behind)
    flat = np.abs(np.sin(phi)) <= ROUNDING * (1 + np.abs(phi))
    z1 = np.where(flat, np.nan, c.imag / np.where(flat, 1, np.sin(phi)))[()]
    return z1, c.real + z1 * np.cos(phi)
