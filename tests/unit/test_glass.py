"""Charts of polarisation and diffraction: their curves are those of the mathematics."""

import numpy as np
import pytest
import real_glass as glass

from povgen.measure.plotting import Figure
from povgen.optics.prism import Prism
from povgen.optics.trace import pair, trace


def curves(draw):
    ax = Figure().subplots()
    draw(ax)
    return {line.get_label(): line.get_xydata() for line in ax.get_lines()}


def test_transmission_by_polarisation():
    """docs/sheets.md: 0.70 to 0.94 for 66 degrees. Crossed sheets pass all polarisations alike."""
    drawn = {name: y for name, (_, y) in ((name, data.T) for name, data in curves(glass.draw_polarisation).items())}
    assert (drawn["α = 66°"].min(), drawn["α = 66°"].max()) == pytest.approx((0.70, 0.94), abs=0.005)
    assert np.ptp(drawn["α = 180°"]) < 1e-9 < np.ptp(drawn["α = 0°"])


def test_the_dots_are_at_the_least_blur():
    drawn = curves(glass.draw_blur)
    pitch, blur = drawn["z₁ = 1 m: best 0.6 mm"].T
    assert pitch[blur.argmin()] == pytest.approx(0.6, abs=0.02) and blur.min() == pytest.approx(1.4, abs=0.05)
    dots = [data[0] for data in drawn.values() if len(data) == 1]
    for (pitch, least), z1 in zip(dots, (0.3, 1, 3, 10), strict=True):
        assert least == pytest.approx(glass.minutes(np.array([0.99, 1, 1.01]) * pitch / 1e3, z1).min())
    z1, best = curves(glass.draw_best_pitch)["450 nm"].T
    assert best == pytest.approx(1e3 * 0.81 * np.sqrt(450e-9 * z1), rel=0.005)


def test_the_shift_of_rays_through_two_sheets(rng):
    """Parallel light along z: the exact trace displaces it by sqrt(2/3) of a prism's height, RMS."""
    prism = Prism(2.4 / 100)
    origin = np.column_stack((rng.uniform(-0.5, 0.5, (4000, 2)), np.full(4000, -1.0)))
    rays = trace(origin, [[0, 0, 1]], pair(np.radians(66), prism), 2.4)
    shift = (rays.position - origin)[rays.designed, :2]
    assert rays.designed.mean() > 0.95
    assert np.sqrt((shift**2).sum(1).mean()) == pytest.approx(glass.SHIFT * prism.height, rel=0.02)
