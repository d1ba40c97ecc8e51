"""Where two sheets of prisms of finite size show things: ray-transfer matrices for small angles, on numpy arrays.

Eq. 7 is for infinitely thin sheets. Prisms of a given pitch make each sheet a few pitches thick, and it does not act in
one plane: it mirrors the direction across its prisms, as if in its middle plane, while along them it is a slab of
glass, which moves light sideways by -g times the component of its slope along the prisms (`prism.slab_shift`). The
shifts that depend on where in a prism a ray enters are as often to one side as to the other and cancel.
Derivation in docs/sheets.md. Signs and units as in `rotation`; the planes z = 0, from which z1 and z2 count, and of
the apparent position are midway between the sheets.
"""

import numpy as np

from povgen.optics import prism


def image(z1, z2, alpha, pitch):
    """The numbers a, b by which light from L reaches E at P, P - E = a (L - E) + b conj(L - E); they broadcast.

    z1, z2 and the pitch of the prisms in one unit, alpha in radians. For pitch = 0, a = 1 - P and b = 0 (eq. 7).
    Where |A| = |B| light from L meets the eye's plane in a line or not at all; a and b grow without bound towards it,
    and with them their error: `limits.MAX_CORRECTION`.
    """
    A, B = _depths(z1, z2, alpha, pitch)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.divide(z2, abs(A) ** 2 - abs(B) ** 2)
        return A.conj() * scale, -B * scale


def nu_and_M(z1, z2, alpha, pitch):
    """The angle nu, radians, through which an object appears turned, and its magnification M, for prisms of a pitch.

    A short step d on the object appears as a d + b conj(d), with a, b of `image`: nu = arg(a), and M is the mean of the
    greatest and the least magnification over the directions of d, |a| + |b| and |a| - |b|, so M = |a|. For pitch = 0
    they are eqs. 8 and 9, corrected. Where |b| > |a| the object appears mirrored: nu is NaN, and that mean is |b|.
    Where |A| = |B|, nu is NaN and M infinite.
    """
    A, B = _depths(z1, z2, alpha, pitch)
    a, b = image(z1, z2, alpha, pitch)
    M = np.where(abs(A) == abs(B), np.inf, np.maximum(abs(a), abs(b)))
    return np.where(abs(A) > abs(B), -np.angle(A), np.nan)[()], M[()]


def infinite_z1(z2, alpha, pitch):
    """The two z1 for which |A| = |B|; complex where there are none, their real part that of the least |A|."""
    g, apart = _sheet(pitch)
    h = (apart + g) / 2
    half = np.emath.sqrt((apart - g) ** 2 - ((z2 - h) * np.sin(alpha)) ** 2)
    return h - (z2 - h) * np.cos(alpha) + np.array([-half, half])


def infinite_alpha(z1, z2, pitch):
    """The alpha from 0 to pi, radians, for which |A| = |B|, as it is for -alpha; complex as in `infinite_z1`."""
    g, apart = _sheet(pitch)
    near, far = z2 - (apart + g) / 2, z1 - (apart + g) / 2
    return np.emath.arccos(((apart - g) ** 2 - near**2 - far**2) / (2 * near * far))


def apparent_position(L, E, z1, z2, alpha, pitch):
    """Where light from L crosses the plane z = 0: as `rotation.apparent_position`, for prisms of a pitch."""
    a, b = image(z1, z2, alpha, pitch)
    D = np.subtract(L, E)
    return E + a * D + b * np.conj(D)


def mirrored_position(L, E, z1, z2, pitch):
    """Where light from L crosses z = 0, the middle of one sheet whose prisms lie along x: a line along z is seen as a
    hyperbola. For z1 = z2 light from L meets the eye's plane in a line or not at all: infinite or NaN there.
    """
    D = np.subtract(L, E)
    g = prism.slab_shift() * pitch * (1 - prism.AIR_GAP)
    with np.errstate(divide="ignore", invalid="ignore"):
        return E + z2 * (D.real / (z2 + z1 - g) + 1j * np.divide(D.imag, np.subtract(z2, z1)))


def _depths(z1, z2, alpha, pitch):
    """A and B: L - E = A s + B conj(s) for a ray from L that reaches the eye with the slope s."""
    g, apart = _sheet(pitch)
    turn = np.exp(-1j * np.asarray(alpha))
    return (z2 - (apart + g) / 2) + turn * (z1 - (apart + g) / 2), (apart - g) * turn.conj()


def _sheet(pitch):
    """g, by which the glass of a sheet brings nearer what is seen along its prisms, and the middle planes' distance."""
    height = pitch * (1 - prism.AIR_GAP)
    return prism.slab_shift() * height, height * prism.aspect() + pitch * prism.AIR_GAP
