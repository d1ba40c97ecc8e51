"""Diffraction by prisms: the numbers of docs/beyond.md."""

import numpy as np
import pytest
import real_glass as glass

from povgen.optics.prism import Prism
from povgen.optics.trace import pair, trace


def test_the_pitch_of_least_blur():
    """docs/beyond.md: 0.81 sqrt(wavelength z1), and 0.60 mm with 1.4 arcminutes for 550 nm and 1 m."""
    best = float(glass.best_pitch(550e-9, 1.0))
    assert best == pytest.approx(0.60e-3, abs=5e-6) and 0.81 * np.sqrt(550e-9) == pytest.approx(best, rel=0.005)
    around = glass.minutes(best * np.array([0.99, 1, 1.01]), 1.0)
    assert around.argmin() == 1 and around[1] == pytest.approx(1.4, abs=0.05)


def test_the_shift_of_rays_through_two_sheets(rng):
    """Parallel light along z: the exact trace displaces it by sqrt(2/3) of a prism's height, RMS."""
    prism = Prism(2.4 / 100)
    origin = np.column_stack((rng.uniform(-0.5, 0.5, (4000, 2)), np.full(4000, -1.0)))
    rays = trace(origin, [[0, 0, 1]], pair(np.radians(66), prism), 2.4)
    shift = (rays.position - origin)[rays.designed, :2]
    assert rays.designed.mean() > 0.95
    assert np.sqrt((shift**2).sum(1).mean()) == pytest.approx(glass.SHIFT * prism.height, rel=0.02)
