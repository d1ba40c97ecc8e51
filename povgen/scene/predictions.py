"""Where the eye sees an object through the windows, and how large: by the paper's equations, or by `optics.apparent`.

z1 is the distance of an object from the middle plane of the last window.
"""

from __future__ import annotations  # help() then says ArrayLike

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from povgen.errors import input_errors, shown
from povgen.optics import apparent, equations
from povgen.optics.equations import Booleans, Complexes, Floats
from povgen.optics.ghosts import Ghost, ghosts
from povgen.scene.eye_and_windows import EyeAndWindows


class Predicted(EyeAndWindows):
    """The eye and the windows, with what the equations predict for any object."""

    @input_errors()
    def apparent_position(
        self, L: ArrayLike, z1: ArrayLike, alpha: ArrayLike | None = None, near: ArrayLike = 0
    ) -> Complexes:
        """Return where the eye sees a point, in the plane z = 0: eq. 7, or what `apparent.position` finds.

        L (complex) and z1 are in tiles. alpha, in degrees, replaces the first window's own, if its sheet has an
        alpha. `near` is for sheets without a ray-transfer matrix: light that passes the point at up to this distance,
        in tiles, also counts. Arrays broadcast. The result is the complex infinity if the point appears at infinity. It
        is NaN if the eye sees the point in no direction, or in every direction. It is NaN if an argument is NaN, or L
        or alpha is infinite. Raises InputError for a z1 that is infinite or below 0.
        """
        z1, L, near = _distances(z1), np.asarray(L, complex), equations.real("near", near, 0)
        if alpha is not None:
            alpha = equations.real("alpha", alpha)
            alpha = np.where(np.isfinite(alpha), alpha, np.nan)[()]
        turns = 0 if alpha is None else alpha
        shape = np.broadcast_shapes(*map(np.shape, (L, z1, near, turns)))
        L = np.broadcast_to(np.where(np.isfinite(L) & ~np.isnan(near), L, np.nan), shape)
        if self._is_of_the_paper:
            turn = np.radians(self.alpha if alpha is None else np.fmod(alpha, 360))
            return equations.apparent_position(L, self.E, z1, self.z2, turn)
        elements = self._turned(alpha)
        if alpha is not None and np.ndim(alpha) and apparent.matrix(elements) is None:
            # the search is for a single alpha
            found = [self.apparent_position(*values) for values in np.broadcast(L, z1, alpha, near)]
            return np.reshape(found, shape)
        return apparent.position(L, self.E, z1, elements, near, self.depth)

    def visible(self, L: ArrayLike, z1: ArrayLike, alpha: ArrayLike | None = None, near: ArrayLike = 0) -> Booleans:
        """Return whether light from a point reaches the eye through the windows, by the prediction.

        The light must pass inside each window frame's front and back, and inside each window at the middle planes of
        its sheets, where the prediction turns it. Arguments as for `apparent_position`.
        """
        return self.seen(L, z1, alpha, near)[1]

    @input_errors()
    def seen(
        self, L: ArrayLike, z1: ArrayLike, alpha: ArrayLike | None = None, near: ArrayLike = 0
    ) -> tuple[Complexes, Booleans]:
        """Return the apparent position of a point, and whether it is visible: `apparent_position` and `visible`."""
        position = self.apparent_position(L, z1, alpha, near)
        with np.errstate(invalid="ignore"):  # the position can be infinite
            slope = (position - self.E) / self.z2
        return position, apparent.passes(slope, self.E, self._turned(alpha), self.depth)

    @input_errors()
    def ghosts(self, L: complex, z1: float, least: float = 0.05) -> list[Ghost]:
        """Return the ghosts of a point through a window of lenses: images by light that passes over to the next lens.

        L (complex) and z1 are in tiles. Ghosts with a share (`Ghost.share`, 0 to 1) below `least` are left out. So are
        ghosts whose position is outside the opening of the window's frame. The list is empty for several windows, for
        ideal sheets and Dove prisms, and for an L that is NaN or infinite. Raises InputError for a z1 that is infinite
        or below 0.
        """
        _distances(z1)
        if self.window or not self.layered or not np.isfinite(L):
            return []
        return ghosts(L, self.E, z1, self.z2, self.layered[0].glass, self.aperture, least)

    @input_errors()
    def nu_and_M(self, z1: ArrayLike) -> tuple[Floats, Floats]:
        """Return the angle nu, degrees, through which the windows show an object turned, and its magnification M.

        For a single window with the sheet "ideal" they are eqs. 8 and 9, corrected (docs/errata.md). Otherwise they are
        those of `apparent.nu_and_M`. nu is positive if the object appears turned counter-clockwise. Let s be the sum of
        all alphas, reduced to -180 to 180 degrees. Of all equivalent angles, nu is the one within 180 degrees of s/2.
        At the pole nu is NaN and M is infinite. For a mirrored object nu is NaN. nu and M are NaN if a sheet does more
        than to rotate light about its normal, because it can distort an object. z1 is in tiles; arrays broadcast.
        Raises InputError for a z1 that is infinite or below 0.
        """
        z1 = _distances(z1)
        if not self.has_nu_and_M:
            return (nothing := np.full(np.shape(z1), np.nan)[()]), nothing
        alpha = sum(self.alphas)
        alpha -= 360 * np.round(alpha / 360)  # to the even one of two: 180 and -180 stay
        if self._is_of_the_paper:
            r, turn = equations.r(z1, self.z2), np.radians(self.alpha)
            nu, M = equations.nu(r, turn), equations.M(r, turn)
        else:
            nu, M = apparent.nu_and_M(z1, self.elements)
        return alpha / 2 + np.remainder(np.degrees(nu) - alpha / 2 + 180, 360) - 180, M

    @input_errors()
    def image_plane(self, L: ArrayLike, z1: float) -> tuple[float, Complexes]:
        """Return z of the image of points L (n,) at the distance z1, and the points' images in this plane, tiles.

        The image is that of ideal sheets, of which prisms are an approximation. Without an image z is NaN, and if it is
        infinitely far z is infinite (`apparent.image`).
        """
        windows = [(distance, sheet.thin) for (distance, _), sheet in zip(self.elements, self.sheets, strict=True)]
        points, distance = np.ravel(np.asarray(L)), _distances(z1)
        if points.dtype.kind not in "iufc" or distance.ndim:
            raise ValueError(f"L, z1 = {shown(L)}, {shown(z1)}: allowed: complex numbers and one number, tiles")
        return apparent.image(points.astype(complex), float(distance), windows)

    @property
    def has_nu_and_M(self) -> bool:
        """Whether the sheets only rotate light about their normal. Windows may be empty."""
        return all(sheet.rotates or sheet.name == "none" for sheet in self.sheets)

    @property
    def _is_of_the_paper(self) -> bool:
        """Whether to use eqs. 7 to 9, which are exact near the pole."""
        return self.sheets[0].name == "ideal" and not self.window

    def _turned(self, alpha: ArrayLike | None) -> apparent.Windows:
        """Return the windows as in `optics.apparent`. `alpha`, in degrees, replaces that of the first window."""
        if alpha is None:
            return self.elements
        first, (distance, _), *others = self.sheets[0], *self.elements
        turned = type(first)({**first.values, "alpha": np.asarray(alpha, float)[()]}, first.aperture)
        return [(distance, turned), *others]


def _distances(z1: ArrayLike) -> Floats:
    """Return distances of objects as floats. Raises ValueError for one that is infinite or below 0."""
    checked = equations.real("z1", z1, 0)
    if (checked == inf).any():
        raise ValueError("z1 = inf; allowed: finite numbers, tiles")
    return checked
