"""White light: the wavelengths at which a scene is shown, and how their pictures become one.

The picture is the sum of pictures at COUNT wavelengths, each with the colours that an eye sees there: the CIE's colour
matching functions of 1931, as the sums of Gaussians of Wyman, Sloan and Shirley, J. Comput. Graph. Tech. 2 (2), 1
(2013). The light's power is the same at each wavelength, and the eye is adapted to it (Bradford), so that white is
sRGB's white. A colour stands for a spectrum from 0 to 1, with which it looks as it does without dispersion.
"""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from povgen.inputs import hdr
from povgen.optics.equations import Floats
from povgen.scene.scene import Scene

WHITE = "white"
ENDS = 400.0, 700.0  # nm
COUNT = 16  # docs/light.md says what is left
_OF_XYZ = 1, 0, 0, 1, 0, 0, 1 / 3, 1 / 3  # chromaticities: XYZ's primaries, and the white of equal power
_STEPS = 100  # of alternating projections: spectra are then within 0.001 of the range from 0 to 1


def wavelengths(count: int = COUNT) -> Floats:
    """Return the wavelengths of the pictures, nm: the middles of equal parts of the range."""
    return ENDS[0] + (ENDS[1] - ENDS[0]) / count * (np.arange(count) + 0.5)


def cie(wavelength: ArrayLike) -> Floats:
    """Return the colour matching functions x, y and z (..., 3) at wavelengths in nm."""

    def lobe(height: float, peak: float, below: float, above: float) -> Floats:
        off = np.asarray(wavelength) - peak
        return np.asarray(height * np.exp(-((off * np.where(off < 0, below, above)) ** 2) / 2))

    x = lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) - lobe(0.065, 501.1, 0.0490, 0.0382)
    y = lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322)
    return np.stack((x, y, lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725)), -1)


@cache
def mixing(count: int = COUNT) -> Floats:
    """Return for each wavelength a matrix (count, 3, 3): from a picture's linear sRGB to its part of the sum.

    The matrices' sum is 1, so that without dispersion all colours are those of each picture.
    """
    xyz = cie(wavelengths(count))
    seen = hdr.converted(xyz / xyz.sum(0), _OF_XYZ)  # the linear sRGB of each wavelength's part of white
    spectra = np.full((count, 3), 1 / 3)  # of red, green and blue; their sum is 1
    for _ in range(_STEPS):
        spectra = spectra.clip(0) / spectra.clip(0).sum(1, keepdims=True)
        spectra -= seen @ np.linalg.solve(seen.T @ seen, seen.T @ spectra - np.eye(3))
    return np.asarray(seen[:, :, None] * spectra[:, None])


def coloured(scene: Scene) -> list[Scene]:
    """Return the scene at each of the wavelengths that its picture needs."""
    return [scene.replace(wavelength=float(w)) for w in wavelengths()] if scene.wavelength == WHITE else [scene]
