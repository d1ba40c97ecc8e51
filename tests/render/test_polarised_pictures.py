"""Pictures through a polariser and an analyser."""

import numpy as np
import pytest

from povgen import Chess, render
from povgen.optics import polarisation

SIZE = (64, 48)


def test_both_renderers_show_the_same_through_polarisers():
    scene = Chess(prisms=20, polariser=45, analyser=100)
    one, other = (render(scene, size=SIZE, renderer=name).astype(int) for name in ("gl", "povray"))
    plain = render(scene.replace(polariser="none", analyser="none"), size=SIZE, renderer="gl").astype(int)
    assert (abs(one - other).max(-1) > 15).mean() < 0.04 < 0.2 < (abs(one - plain).max(-1) > 30).mean()
    assert abs(one - plain)[:, :6].mean() < 3  # beside the window


@pytest.mark.parametrize("values", [{}, {"wavelength": "white", "glass": "BK7"}, {"pupil": 0.01}])
def test_the_light_of_a_pixel_is_that_of_the_closed_form(values):
    scene = Chess(prisms=10, alpha=60, background="white", floor="none", z2=60, polariser=20, analyser=70, **values)
    options = {"size": SIZE, "renderer": "gl", "linear": True}
    shown = render(scene, **options) / render(scene.replace(polariser="none", analyser="none"), **options)
    J = polarisation.jones([0, 0, -1], [0, np.radians(30)], scene.prism)
    behind, before = (np.array([np.cos(angle), np.sin(angle)]) for angle in np.radians([20, 70]))
    expected = abs(before @ J @ behind) ** 2 / 2
    near = abs(shown[10:38, 18:46] - expected).max(-1) < 0.03 * expected
    assert near.mean() > 0.2
