"""Where two sheets of prisms of finite size show things: ray-transfer matrices for small angles, on numpy arrays.

Eq. 7 is for infinitely thin sheets. Prisms of a given pitch make each sheet a few pitches thick, and it does not act in
one plane: it mirrors the direction across its prisms, as if in its middle plane, while along them it is a slab of
glass, which moves light sideways by -g times the component of its slope along the prisms (`prism.slab_shift`). The
shifts that depend on where in a prism a ray enters are as often to one side as to the other and cancel.
Derivation in docs/sheets.md. Signs and units as in `rotation`; the planes z = 0, from which z1 and z2 count, and of
the apparent position are midway between the sheets.
"""

import numpy as np

from povgen import prism


def image(z1, z2, alpha, pitch):
    """The numbers a, b by which light from L reaches E at P, P - E = a (L - E) + b conj(L - E); they broadcast.

    z1, z2 and the pitch of the prisms in one unit, alpha in radians. For pitch = 0, a = 1 - P and b = 0 (eq. 7).
    Where |A| = |B| light from L meets the eye's plane in a line or not at all; a and b grow without bound towards it,
    and with them their error: `limits.CORRECTION`.
    """
    height = pitch * (1 - prism.AIR_GAP)
    g = prism.slab_shift() * height
    apart = height * prism.aspect() + pitch * prism.AIR_GAP  # of the two middle planes
    turn = np.exp(-1j * np.asarray(alpha))
    # L - E = A s + B conj(s) for a ray that reaches the eye with the slope s
    A = (z2 - (apart + g) / 2) + turn * (z1 - (apart + g) / 2)
    B = (apart - g) * turn.conj()
    with np.errstate(divide="ignore"):
        scale = np.divide(z2, abs(A) ** 2 - abs(B) ** 2)
    return A.conj() * scale, -B * scale


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
