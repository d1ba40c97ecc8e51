"""Where two sheets of prisms of finite size show an object: ray-transfer matrices for small angles, on numpy arrays.

Eq. 7 is for infinitely thin sheets. A sheet of prisms with a given pitch is a few pitches thick. Across the ridges (the
prisms' long edges) it reverses the slope of light, as if in the sheet's middle plane. Along the ridges it acts as a
slab of glass: it shifts light sideways by -g times the component of the slope along the ridges (`Prism.slab_shift`).
Other shifts depend on the point at which a ray enters a prism, and are zero on average. docs/sheets.md has the
derivation.

Let light from L reach E with the slope s = (P - E)/z2, a complex number. Then L - E = A s + B conj(s), with A and B
that depend on the windows, z1, z2 and the pitch (`depths`).

Signs and units are as in `rotation`. The plane of a window is midway between its two sheets. z2 and the apparent
position refer to the plane of the first window, z = 0. z1 refers to the plane of the last one. `behind` are the windows
behind the first one, as in `rotation.depth`. `prism` is the shape of the prisms, of all windows or one for each. Prisms
of an ideal window have the pitch 0.
"""

from collections.abc import Sequence
from itertools import accumulate, pairwise

import numpy as np
from numpy.typing import ArrayLike

from povgen.optics.prism import Prism
from povgen.optics.rotation import Complexes, Floats, Windows, depth

Prisms = Prism | Sequence[Prism]

# The least radius of an object, in periods, for which the mean over these periods holds (`possible_error`).
OWN = 1.0  # of the prisms in one sheet
BANDS = 0.6  # of the bands that two sheets make together
FALL = 0.15  # radians: greater field angles by this much show much less light on the designed path


def image(
    z1: ArrayLike, z2: ArrayLike, alpha: ArrayLike, prism: Prisms, behind: Windows = ()
) -> tuple[Complexes, Complexes]:
    """Return a and b with P - E = a (L - E) + b conj(L - E), where light from L to E crosses the plane z = 0 at P.

    z1, z2 and the prisms' pitch are in one unit, alpha in radians. For a pitch of 0 and one window, a = 1 - P of eq. 7,
    and b = 0.
    At |A| = |B| light from L meets the eye's plane in a line, or not at all. Close to |A| = |B|, a and b are large, and
    so are their errors (`possible_error`).
    """
    A, B = depths(z1, z2, alpha, prism, behind)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.divide(z2, abs(A) ** 2 - abs(B) ** 2)
        return A.conj() * scale, -B * scale


def nu_and_M(
    z1: ArrayLike, z2: ArrayLike, alpha: ArrayLike, prism: Prisms, behind: Windows = ()
) -> tuple[Floats, Floats]:
    """Return the angle nu, radians, through which an object appears turned, and its magnification M.

    A short step d on the object appears as a d + b conj(d), with a and b from `image`. Then nu = arg(a). The
    magnification depends on the direction of d: it is between |a| - |b| and |a| + |b|, and M is the mean |a|. For
    a pitch of 0, nu and M are eqs. 8 and 9, corrected. If |b| > |a|, the object appears mirrored: nu is NaN, and M is
    |b|. If |A| = |B|, nu is NaN and M is infinite.
    """
    behind = tuple(behind)
    A, B = depths(z1, z2, alpha, prism, behind)
    a, b = image(z1, z2, alpha, prism, behind)
    M = np.where(abs(A) == abs(B), np.inf, np.maximum(abs(a), abs(b)))
    return np.where(abs(A) > abs(B), -np.angle(A), np.nan)[()], M[()]


def infinite_z1(z2: ArrayLike, alpha: ArrayLike, prism: Prisms, behind: Windows = ()) -> Complexes:
    """Return the two z1 at which |A| = |B|.

    If no real z1 has |A| = |B|, the two results are complex. Their real part is the z1 at which |A| is least.
    """
    behind = tuple(behind)
    A, B = depths(0, z2, alpha, prism, behind)  # A = A(z1 = 0) + z1 exp(-i a), with the sum a of all angles
    a = np.asarray(alpha) + sum(np.asarray(turn) for _, turn in behind)
    least = A * np.exp(1j * a)
    half = np.emath.sqrt(abs(B) ** 2 - least.imag**2)
    return -least.real + np.array([-half, half])


def infinite_alpha(z1: ArrayLike, z2: ArrayLike, prism: Prism) -> Complexes:
    """Return the alpha from 0 to pi, radians, at which |A| = |B|. It is complex if no real alpha has |A| = |B|.

    At -alpha, |A| = |B| too.
    """
    g, apart = prism.slab_shift, prism.separation
    near, far = np.subtract(z2, (apart + g) / 2), np.subtract(z1, (apart + g) / 2)
    return np.emath.arccos(((apart - g) ** 2 - near**2 - far**2) / (2 * near * far))


def apparent_position(
    L: ArrayLike,
    E: ArrayLike,
    z1: ArrayLike,
    z2: ArrayLike,
    alpha: ArrayLike,
    prism: Prisms,
    behind: Windows = (),
) -> Complexes:
    """Return where light from L to E crosses the plane z = 0: `rotation.apparent_position` for real prisms."""
    a, b = image(z1, z2, alpha, prism, behind)
    D = np.subtract(L, E)
    return np.add(E, a * D) + b * np.conj(D)


def frequencies(z2: float, alpha: float, prism: Prisms, behind: Sequence[tuple[float, float]] = ()) -> list[complex]:
    """Return k of every sheet of prisms: Im(k d) of its prisms lie between the rays that cross z = 0 a step d apart.

    1/|k| is the pitch as the eye sees it in the plane z = 0, in the unit of z2. At right angles to the prisms, d is i
    times the conjugate of k. Signs and units are otherwise as for `image`.
    """
    prisms = [prism] * (1 + len(behind)) if isinstance(prism, Prism) else prism
    found, turned = [], 0.0
    for n, (shape, turn) in enumerate(zip(prisms, [alpha, *(turn for _, turn in behind)], strict=True)):
        # a ray with the slope s at the eye meets the window's plane at E + A s + B conj(s), with the slope `slope` s
        A, B = depths(behind[n - 1][0], z2, alpha, prisms[:n], behind[: n - 1]) if n else (z2, 0)
        slope = np.exp(-1j * turned)
        turned += turn
        if shape.pitch:
            a, g = shape.separation, shape.slab_shift
            near = A - a / 2 * slope, B
            far = A - (a + g) / 2 * slope, B + (a - g / 2) * np.exp(1j * turn) * slope.conjugate()
            for (c, d), angle in ((near, turn / 2), (far, 0)):
                ridges = np.exp(-1j * angle)
                found.append(complex(c * ridges - np.conj(d * ridges)) / (z2 * shape.pitch))
    return found


def possible_error(k: Sequence[complex], scale: float, radius: float, tangent: float, z2: float, prism: Prism) -> float:
    """Return how far, at most, an object appears from its predicted position. Lengths are in one unit.

    `k` are the `frequencies` of all sheets, `radius` is the object's radius, as it appears in the plane z = 0, and
    `tangent` is that of the field angle. `scale` is how far the object appears moved if light is displaced by one unit
    at the windows: z2/||A| - |B||.

    A prism displaces light across its ridges by up to `reach`, and the prediction takes the mean over all places in the
    prism, which is zero. An object that covers only a part of a prism shows less of this mean. So does one that covers
    only a part of a band of two sheets that are nearly parallel to the eye (moire). There the displacements by all
    these sheets can add up. The mean is right if the object's radius is longer than OWN periods of a sheet alone, and
    than BANDS bands. Where it is much longer, the error falls as its fourth power.

    The second part is the shift along the ridges, which grows faster than the slope: for a slab of glass, by
    (n + 1)/(2 n^2) slope^2. The third part: less light takes the designed path at greater field angles. So the light of
    an object that displacements spread has its centre nearer to E. OWN, BANDS and FALL are fitted to ray traces:
    docs/accuracy.md.
    """
    reach = prism.height * min(prism.aspect, 2 - prism.aspect)

    def share(frequency: complex, least: float) -> float:
        covered = abs(frequency) * radius
        return (least / covered) ** 4 if covered > least else 1.0

    shares = [
        max([share(one, OWN), *(share(one + sign * k[j], BANDS) for j in range(len(k)) if j != i for sign in (1, -1))])
        for i, one in enumerate(k)
    ]
    beyond = len(k) * prism.slab_shift * tangent**3 * (prism.index + 1) / (2 * prism.index**2)
    spread = scale * reach
    return spread * max(2 * max(shares), sum(shares)) + scale * beyond + spread**2 / (FALL * z2)


def depths(
    z1: ArrayLike, z2: ArrayLike, alpha: ArrayLike, prism: Prisms, behind: Windows = ()
) -> tuple[Complexes, Complexes]:
    """Return A and B with L - E = A s + B conj(s), for a ray from L that reaches the eye with the slope s.

    Each window shortens the distances on its two sides by h, and adds (apart - g) exp(i a) conj(s) to L - E. Here a is
    the sum of the angles up to this window (docs/beyond.md).
    """
    behind = tuple(behind)
    prisms = [prism] * (1 + len(behind)) if isinstance(prism, Prism) else prism
    h = [(prism.separation + prism.slab_shift) / 2 for prism in prisms]
    totals = accumulate([np.asarray(alpha), *(np.asarray(turn) for _, turn in behind)])
    B = sum((prism.separation - prism.slab_shift) * np.exp(1j * a) for prism, a in zip(prisms, totals, strict=True))
    shortened = [(np.subtract(d, x + y), turn) for (d, turn), (x, y) in zip(behind, pairwise(h), strict=True)]
    return depth(np.subtract(z1, h[-1]), np.subtract(z2, h[0]), alpha, shortened), B
