"""Pictures through a polariser and an analyser."""

import numpy as np
import pytest
from conftest import some

from povgen import Chess, render
from povgen.rendering import views
from povgen.scene import polarisers

SIZE = (64, 48)


def test_both_renderers_show_the_same_through_polarisers():
    scene = Chess(prisms=20, polariser=45, analyser=100)
    one, other = (render(scene, size=SIZE, renderer=name).astype(int) for name in ("gl", "povray"))
    without = scene.replace(polariser="none", analyser="none")
    plain = render(without, size=SIZE, renderer="gl", antialias=(1, 0.1, 3)).astype(int)  # the same places
    assert (abs(one - other).max(-1) > 15).mean() < 0.04 < 0.2 < (abs(one - plain).max(-1) > 30).mean()
    assert abs(one - plain)[:, :6].max() <= 2  # beside the window


@pytest.mark.parametrize("values", some([{}, {"wavelength": "white", "glass": "BK7"}, {"pupil": 0.01}], 1))
def test_the_light_of_a_pixel_is_what_passes_on_the_designed_path(values, monkeypatch):
    for module, name in ((polarisers, "PLACES"), (views, "PUPIL_RAYS")):
        monkeypatch.setattr(module, name, 2)
    scene = Chess(prisms=10, alpha=60, background="white", floor="none", z2=60, polariser=20, analyser=70, **values)
    options = {"size": SIZE, "renderer": "gl", "linear": True}
    shown = render(scene, **options) / render(scene.replace(polariser="none", analyser="none"), **options)
    designed = scene.trace(scene.rays(SIZE)).designed
    expected = np.median(polarisers.passed(scene, SIZE)[designed])
    near = abs(shown - expected).max(-1) < 0.03 * expected
    assert 0.01 < expected < 0.3 and near[designed].mean() > 0.25
