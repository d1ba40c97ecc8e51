"""The paper's figures: drawn whole, and in agreement with the equations by as much as their captions say."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from povgen.measure import verify
from povgen.optics import rotation
from povgen.rendering.frames import read_png
from povgen.settings import Rendering
from povgen.teach.figures import FIGURES, save_figure

pytestmark = pytest.mark.xdist_group("figures")  # what is costly is made once
DRAWINGS = {1, 2, 5}


@pytest.fixture(scope="module")
def figures(tmp_path_factory):
    """Every figure at draft quality: its picture and its caption."""
    folder = tmp_path_factory.mktemp("figures")
    made = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verify, "SMALL", (320, 240))  # of what is measured
        for number in FIGURES:
            files = save_figure(number, folder, Rendering(quality="draft"))
            assert {path.suffix for path in files} == {".png", ".md", *([".svg"] if number in DRAWINGS else [])}
            made[number] = read_png(folder / f"figure{number}.png"), (folder / f"figure{number}.md").read_text()
    for number in DRAWINGS:
        ElementTree.parse(folder / f"figure{number}.svg")
    return made


def numbers(text):
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", text)]


@pytest.mark.parametrize("number", FIGURES)
def test_is_whole_and_has_a_caption(figures, number):
    picture, caption = figures[number]
    assert picture.shape[1] == 1400  # two columns at 200 dots an inch
    border = np.concatenate([picture[:3].reshape(-1, 3), picture[-3:].reshape(-1, 3)])
    sides = np.concatenate([picture[:, :3].reshape(-1, 3), picture[:, -3:].reshape(-1, 3)])
    assert (border == 255).all() and (sides == 255).all(), "something is cut off"
    assert (picture != 255).any(-1).mean() > 0.03
    assert caption.startswith(f"![{FIGURES[number][0]}](figure{number}.png)\n\n**Figure {number}.** ")
    assert "easured" in caption and "nan" not in caption


def test_a_ray_leaves_a_sheet_mirrored(figures):
    exponent, shift = numbers(figures[1][1].partition("measured")[2])[:2]
    assert exponent == 10  # 10^-n, for numbers() takes the sign for a dash
    assert float(re.search(r"10\^(-\d+) degrees", figures[1][1])[1]) <= -13
    assert 0 < numbers(re.search(r"shifted by (\S+)", figures[1][1])[1])[0] < 1


def test_mirroring_twice_is_rotation(figures):
    assert int(re.search(r"turned once is 10\^(-\d+)", figures[2][1])[1]) <= -10


@pytest.mark.parametrize("number, scenes", [(3, [(3, a) for a in (0, 33, 66, 99, 132, 180)]), (4, None)])
def test_pieces_agree(figures, number, scenes):
    scenes = scenes or [(6 / z1, 90) for z1 in (0.6, 1.5, 3, 6, 15, 60)]
    told = numbers(re.search(r"small prisms: (.*)\.\n", figures[number][1])[1])
    for (r, alpha), measured in zip(scenes, np.reshape(told, (-1, 4)), strict=True):
        nu, expected_nu, M, expected_M = measured
        assert expected_nu == pytest.approx(np.degrees(rotation.nu(r, np.radians(alpha))), abs=0.05)
        assert expected_M == pytest.approx(rotation.M(r, np.radians(alpha)), abs=5e-4)
        # 2 x 100 prisms are some 2 pixels off, more where the picture is magnified
        assert abs(nu - expected_nu) < 2 and abs(M / expected_M - 1) < 0.04


def test_the_horizon_is_turned_by_90_degrees(figures):
    assert float(re.search(r"measured, by (\S+) degrees", figures[4][1])[1]) == pytest.approx(90, abs=0.1)


def test_the_ray_trace_agrees_with_equation_7(figures):
    assert float(re.search(r"turned by (\S+) degrees \(alpha is 60\)", figures[5][1])[1]) == pytest.approx(60, abs=1e-3)
    assert float(re.search(r"within (\S+) of L", figures[5][1])[1]) < 0.003


def test_spheres_lie_where_they_are_predicted(figures):
    found, of = map(int, re.search(r"which (\d+) of (\d+) could", figures[6][1]).groups())
    thick, thin = map(float, re.search(r"by (\S+) pixels, off eq\. 7.*?by (\S+) \(RMS", figures[6][1]).groups())
    assert of == 5 * 11 and found > 0.7 * of
    assert thick < 3 and thin < 8 and thick < thin
