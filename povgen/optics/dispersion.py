"""The colours of light through prisms of glass with dispersion.

The designed path has no dispersion. Let n be the unit normal of the first slanted facet, pointing out, and R the
reflection at the base, which reverses the component across the ridges. The normal of the second facet is -Rn. Light
with the unit direction k is refracted into the direction k + m n, times 1/index, for some number m. After the base it
is Rk + m Rn. The second facet adds a multiple of its normal -Rn again, such that the length becomes 1. Rk has the
length 1. So light leaves along Rk, for every index. Only its position depends on the colour, by less than a
hundredth of the pitch from F to C. Stray light leaves in directions that depend on the index.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.prism import Prism
from povgen.optics.rotation import Floats
from povgen.optics.trace import End, Rays

F, D, C = 486.13e-9, 587.56e-9, 656.27e-9  # Fraunhofer lines by which glasses are described, wavelengths in metres
LEAST, MOST = 0.3e-6, 2.5e-6  # wavelengths, metres, for which the constants of N-BK7 hold


def bk7(wavelength: ArrayLike) -> Floats:
    """Return the refractive index of the glass N-BK7: Sellmeier's formula with Schott's constants.

    The wavelength is in metres, from 0.3e-6 to 2.5e-6. Raises ValueError for any other.
    """
    wavelength = np.asarray(wavelength, float)
    if (outside := wavelength[(wavelength < LEAST) | (wavelength > MOST)]).size:
        raise ValueError(f"wavelength = {outside[0]:g}; allowed: {LEAST:g} to {MOST:g} metres")
    square = np.square(1e6 * wavelength)  # the constants are in square micrometres
    terms = ((1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653))
    return np.sqrt(1 + sum(B * square / (square - C) for B, C in terms))


def in_colour(prism: Prism, index: float) -> Prism:
    """Return a prism of the same shape for light of another colour: with another index, and the aspect that keeps it.

    The aspect counts in lengths at full aperture, which depend on the index.
    """
    changed = replace(prism, index=index)
    return replace(changed, aspect=prism.aspect * prism.full_aperture / changed.full_aperture)


def spread(first: Rays, second: Rays) -> NDArray[np.float64]:
    """Return the angles, radians, (n,), between the same rays traced in two colours.

    They are NaN for rays that do not leave through the sheets on the same path in both colours.
    """
    same = (first.faces == second.faces).all(1) & (first.end == End.THROUGH) & (second.end == End.THROUGH)
    apart = np.linalg.norm(first.direction - second.direction, axis=1)
    return np.where(same, 2 * np.arcsin(np.minimum(apart / 2, 1)), np.nan)
