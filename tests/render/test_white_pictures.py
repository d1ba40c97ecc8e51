"""Pictures in white light, and what lenses and prisms do to it."""

import numpy as np
import pytest
from conftest import povgen

from povgen import Chess, render

SIZE = (64, 48)


@pytest.mark.parametrize(("renderer", "values"), [("povray", {}), ("gl", {"pupil": 0.3, "background": "transparent"})])
def test_without_dispersion_all_colours_stay(renderer, values):
    scene = Chess(sheet="none", glass="BK7", color="#c01030", **values)
    one, white = (render(each, size=SIZE, renderer=renderer) for each in (scene, scene.replace(wavelength="white")))
    assert abs(one.astype(int) - white).max() <= 1


def test_lenses_show_colours_and_the_designed_path_of_dove_prisms_none():
    differs = {}
    for sheet in ("detailed", "lenticular"):
        scene = Chess(sheet=sheet, glass="N-SF11", f_number=6)
        one, white = (
            render(each, size=SIZE, renderer="gl", antialias="off").astype(int)
            for each in (scene, scene.replace(wavelength="white"))
        )
        seen = [each.trace(each.rays(SIZE)).designed for each in (scene.replace(wavelength=w) for w in (405, 695))]
        differs[sheet] = (abs(one - white).max(-1) > 3)[np.all(seen, axis=0)].mean()
    assert differs["detailed"] < 0.005 < 0.2 < differs["lenticular"]


def test_a_command_says_what_a_text_leaves_out(tmp_path):
    command = ["pov", "chess", "--glass", "BK7", "--wavelength", "white", "--analyser", "3", "-o", "a.pov"]
    status, _, err = povgen(command, tmp_path)
    assert status == 0 and "a .pov file shows one, 587.6 nm" in err and "polariser, analyser: no effect" in err
