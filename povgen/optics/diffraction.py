"""How much a window of prisms blurs, by the shift of rays and by diffraction, and the pitch that blurs least.

**Shift.** On the designed path, light along z that enters a prism at the height u leaves at h - u (`Prism`). u is
evenly distributed from 0 to h. So a sheet shifts rays across its ridges by h - 2u, from -h to h: h/sqrt(3) RMS. Two
sheets shift them independently, in two directions: sqrt(2/3) h RMS. Light oblique to the sheets is shifted less,
because rays that enter near the top or the base leave the designed path. Over the default scene's window, two sheets
shift light by 0.69 h RMS.

**Diffraction.** Each prism is a slit of the width h. It spreads light of the wavelength lambda across the ridges, by
angles t with the intensity sinc^2(h t/lambda). The RMS of these angles is infinite. So the width is measured by the
Gaussian with the same full width at half maximum, 0.886 lambda/h: 0.376 lambda/h RMS. Two sheets spread it by
0.532 lambda/h, in two directions. Interference between the light of different prisms divides it into narrow orders, but
does not change the width. At an object at the distance z1 the width is 0.532 z1 lambda/h.

The shift and the diffraction are independent displacements at the object, so that their squares add. A displacement D
at the object is seen as |D|/|Z| radians, with the complex depth Z of `equations.depth`. A larger pitch increases the
shift and decreases the diffraction. The sum of their squares is least where the two are equal. The gap is neglected: h
is the pitch.

The formulas are for small angles, an aspect of 1 and a single window. An eye or a camera adds its own blur.
"""

from math import log, sqrt

import numpy as np
from numpy.typing import ArrayLike

from povgen.optics.equations import Floats, depth, real

LONGEST = 1e-3  # wavelength, metres
FARTHEST = 1e200  # z1, metres: for more, the blur is the same
SINC = 0.8858929414  # full width at half maximum of sinc^2(x) = (sin(pi x)/(pi x))^2
SHIFT = sqrt(2 / 3)  # RMS displacement of rays by two sheets, in pitches
SPREAD = sqrt(2) * SINC / (2 * sqrt(2 * log(2)))  # RMS angle of the diffraction at two sheets, in lambda/pitch: 0.532


def blur(pitch: ArrayLike, wavelength: ArrayLike, z1: ArrayLike, z2: ArrayLike, alpha: ArrayLike) -> Floats:
    """Return the RMS blur, radians, with which an eye sees a point at the distance z1 behind a window.

    The eye is a distance z2 in front of the window. All lengths are in metres, and alpha is in radians. The arguments
    broadcast. At the pole, Z = 0, and for a pitch of 0, the blur is infinite. For an infinite z1 the result is the
    limit. Raises ValueError for a negative length, for a wavelength above a millimetre, and for an alpha beyond 10 pi.
    """
    pitch, waves = real("pitch", pitch, 0), _metres(wavelength)
    z1, z2 = np.minimum(real("z1", z1, 0), FARTHEST), real("z2", z2, 0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        blur = np.hypot(SHIFT * pitch, SPREAD * waves * z1 / pitch) / np.abs(depth(z1, z2, alpha))
    return np.where(pitch == 0, np.inf, blur)[()]


def best_pitch(wavelength: ArrayLike, z1: ArrayLike) -> Floats:
    """Return the pitch of least blur, 0.81 sqrt(lambda z1), for objects at the distance z1 behind the window.

    All lengths are in metres. The place of the eye and alpha do not matter: they scale both kinds of blur equally.
    Raises ValueError for a negative length, and for a wavelength above a millimetre.
    """
    return np.sqrt(SPREAD / SHIFT * _metres(wavelength) * np.minimum(real("z1", z1, 0), FARTHEST))


def _metres(wavelength: ArrayLike) -> Floats:
    """Return wavelengths as floats. Raises ValueError for those that are probably in micrometres or nanometres."""
    waves = real("wavelength", wavelength, 0)
    if (waves > LONGEST).any():
        raise ValueError(f"wavelength = {np.nanmax(waves):g}; allowed: 0 to {LONGEST:g}, metres")
    return waves
