"""Captions and overlays on rendered pictures: what is marked is what POV-Ray shows, in pictures and movies."""

import numpy as np
import pytest
from conftest import some

from povgen import Chess, Rendering, Spheres, render
from povgen.measure.probes import Positions
from povgen.measure.targets import located
from povgen.rendering import povray
from povgen.video import caption_strips, caption_texts, overlay


@pytest.mark.parametrize("prisms", some([20, 100], 1))
def test_nu_and_M_are_those_of_prisms_of_this_size(prisms):
    scenes = [Positions(prisms=prisms, z1=2, L=L, extent=0.6) for L in (0.25 + 0.3j, -0.3 + 0.1j, 0.2 - 0.3j)]
    a = np.mean([seen.a for _, seen in located(scenes, (160, 120))])
    facts = caption_texts.facts(Chess(prisms=prisms, aperture=2.4))
    # eqs. 8 and 9 say 15.0 degrees and 0.851
    assert float(facts["nu"].removesuffix("°")) == pytest.approx(np.degrees(np.angle(a)), abs=10 / prisms)
    assert float(facts["M"]) == pytest.approx(abs(a), abs=0.2 / prisms)


def test_annotated_frames_are_made_from_the_same_frame(tmp_path, monkeypatch):
    scene, size = Spheres(sheet="ideal", z1=[3]), (160, 120)
    plain = render(scene, size=size, antialias="off")
    monkeypatch.setattr(povray.Runner, "run", None)  # no need to render again
    both = render(scene, size=size, antialias="off", caption="full", overlay=True)
    explained = overlay.legend(scene, Rendering(overlay=True))
    top = len(caption_strips.strip(overlay.legend_items(explained), *size))
    assert len(both) > len(plain) + top
    within = both[top : top + size[1]]
    assert (within != plain).any() and (within == plain).all(-1).mean() > 0.5
