"""Captions and overlays on rendered pictures: what is marked is what POV-Ray shows, in pictures and movies."""

import numpy as np
import pytest
from conftest import some

from povgen import Chess, Rendering, Spheres, render
from povgen.measure import probes
from povgen.measure.probes import Positions
from povgen.measure.targets import located, transverse
from povgen.rendering import povray
from povgen.scene import camera
from povgen.video import captions, overlay


@pytest.mark.parametrize(
    "values, most",
    some(
        [
            ({"sheet": "ideal", "alpha": 120, "eye": 0.9 - 0.7j}, 0),
            ({"sheet": "none", "eye": 0.9 - 0.7j}, 0),
            ({"sheet": "detailed", "alpha": 90, "eye": -0.8 + 0.3j}, 0.03),
            ({"sheet": "detailed", "alpha": 66, "eye": 0.5j, "prisms": 20}, 0.03),
            ({"sheet": "single", "eye": 0.3 + 0.9j}, 0),
        ],
        1,
        several=True,
    ),
)
def test_what_is_said_to_be_visible_is_what_is_rendered(values, most):
    """Every pixel that shows a place where it is predicted is predicted to be visible, and the reverse."""
    scene = Positions(z1=2, z2=3.5, L=0.3 - 0.2j, extent=4, **values)
    (decoded,) = probes.decoded([scene], (160, 120))
    inside, _ = camera.rays(scene, (160, 120))
    shown, place = scene.L + transverse(decoded), scene.camera.pixels((160, 120))
    coarse = 2.5 * scene.prism.pitch if scene.sheet == "detailed" else 0  # what differs from prism to prism
    designed = inside & (abs(scene.apparent_position(shown, 2) - place) < 0.04 + coarse)
    hidden = designed & ~scene.visible(shown, 2)
    assert designed.sum() > 1500 and hidden.sum() <= most * designed.sum()
    grid = 4 * place[scene.visible(4 * place, 2)]
    nearest = abs(shown[designed] - grid[:, None]).min(1)
    assert len(grid) > 100 and np.mean(nearest > 0.15 + 2 * coarse) <= most


@pytest.mark.parametrize("prisms", some([20, 100], 1))
def test_nu_and_M_are_those_of_prisms_of_this_size(prisms):
    scenes = [Positions(prisms=prisms, z1=2, L=L, extent=0.6) for L in (0.25 + 0.3j, -0.3 + 0.1j, 0.2 - 0.3j)]
    a = np.mean([seen.a for _, seen in located(scenes, (160, 120))])
    facts = captions.facts(Chess(prisms=prisms, aperture=2.4))
    # eqs. 8 and 9 say 15.0 degrees and 0.851
    assert float(facts["nu"].removesuffix("°")) == pytest.approx(np.degrees(np.angle(a)), abs=10 / prisms)
    assert float(facts["M"]) == pytest.approx(abs(a), abs=0.2 / prisms)


def test_annotated_frames_are_made_from_the_same_frame(tmp_path, monkeypatch):
    scene, size = Spheres(sheet="ideal", z1=[3]), (160, 120)
    plain = render(scene, size=size, antialias="off")
    monkeypatch.setattr(povray.Runner, "run", None)  # no need to render again
    both = render(scene, size=size, antialias="off", caption="full", overlay=True)
    explained = overlay.legend(scene, Rendering(overlay=True))
    top = len(overlay.strip([overlay.Item(text, text, colour) for text, colour in explained], *size))
    assert len(both) > len(plain) + top
    within = both[top : top + size[1]]
    assert (within != plain).any() and (within == plain).all(-1).mean() > 0.5
