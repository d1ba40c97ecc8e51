"""Where the eye sees an object through the windows, and how large: by the paper's equations, or by `optics.apparent`.

The methods of `povgen.scene.scenes.Scene` with these names say what the arguments and results are.
"""

from math import inf, radians, remainder

import numpy as np
from numpy.typing import ArrayLike

from povgen.optics import apparent, equations
from povgen.optics.equations import Booleans, Complexes, Floats
from povgen.scene.model import EyeAndWindows


def distances(z1: ArrayLike) -> Floats:
    """Return distances of objects as floats. Raises ValueError for one that is infinite or below 0."""
    checked = equations.real("z1", z1, 0)
    if (checked == inf).any():
        raise ValueError("z1 = inf; allowed: finite numbers, tiles")
    return checked


def _elements(scene: EyeAndWindows, alpha: ArrayLike | None) -> apparent.Windows:
    """Return the windows as in `optics.apparent`. `alpha`, in degrees, replaces that of the first window."""
    if alpha is None:
        return scene.elements

    first, (distance, _), *others = scene.sheets[0], *scene.elements
    turned = type(first)({**first.values, "alpha": np.asarray(alpha, float)[()]}, first.aperture)
    return [(distance, turned), *others]


def only_rotates(scene: EyeAndWindows) -> bool:
    """Whether the sheets do no more than to rotate light about their normal. Windows may have none."""
    return all(sheet.rotates or sheet.name == "none" for sheet in scene.sheets)


def _is_of_the_paper(scene: EyeAndWindows) -> bool:
    """Whether eqs. 7 to 9 hold: no digits are then lost near the pole."""
    return scene.sheets[0].name == "ideal" and not scene.window


def apparent_position(
    scene: EyeAndWindows, L: ArrayLike, z1: ArrayLike, alpha: ArrayLike | None, near: ArrayLike
) -> Complexes:
    """Return where the eye sees a point, in the plane z = 0. Raises ValueError."""
    z1, L, near = distances(z1), np.asarray(L, complex), equations.real("near", near, 0)
    if alpha is not None:
        alpha = equations.real("alpha", alpha)
        alpha = np.where(np.isfinite(alpha), alpha, np.nan)[()]
    turns = 0 if alpha is None else alpha
    shape = np.broadcast_shapes(*map(np.shape, (L, z1, near, turns)))
    L = np.broadcast_to(np.where(np.isfinite(L) & ~np.isnan(near), L, np.nan), shape)
    if _is_of_the_paper(scene):
        turn = np.radians(scene.alpha if alpha is None else np.fmod(alpha, 360))
        return equations.apparent_position(L, scene.E, z1, scene.z2, turn)
    elements = _elements(scene, alpha)
    if alpha is not None and np.ndim(alpha) and apparent.matrix(elements) is None:
        # the search is for a single alpha
        found = [apparent_position(scene, *values) for values in np.broadcast(L, z1, alpha, near)]
        return np.reshape(found, shape)
    return apparent.position(L, scene.E, z1, elements, near, scene.depth)


def seen(
    scene: EyeAndWindows, L: ArrayLike, z1: ArrayLike, alpha: ArrayLike | None, near: ArrayLike
) -> tuple[Complexes, Booleans]:
    """Return where the eye sees a point, and whether it is visible. Raises ValueError."""
    position = apparent_position(scene, L, z1, alpha, near)
    with np.errstate(invalid="ignore"):  # the position can be infinite
        slope = (position - scene.E) / scene.z2
    return position, apparent.passes(slope, scene.E, _elements(scene, alpha), scene.depth)


def nu_and_M(scene: EyeAndWindows, z1: ArrayLike) -> tuple[Floats, Floats]:
    """Return the angle through which an object appears turned, degrees, and its magnification. Raises ValueError."""
    z1 = distances(z1)
    if not only_rotates(scene):
        return (nothing := np.full(np.shape(z1), np.nan)[()]), nothing
    alpha = remainder(sum(scene.alphas), 360)
    if _is_of_the_paper(scene):
        r = equations.r(z1, scene.z2)
        nu, M = equations.nu(r, radians(scene.alpha)), equations.M(r, radians(scene.alpha))
    else:
        nu, M = apparent.nu_and_M(z1, scene.elements)
    return alpha / 2 + np.remainder(np.degrees(nu) - alpha / 2 + 180, 360) - 180, M
