"""Which part of each pixel's light passes a polariser, the glass and an analyser."""

import numpy as np
import pytest

from povgen import Bundle, Chess, InputError, live, results
from povgen.optics.trace import End
from povgen.scene.polarisers import passed

SIZE = (64, 48)


ANGLES = [(0, 0), (0, 90), (30, -45), ("none", 20), (70, "none"), ("none", "none")]


def power(J, polariser, analyser):
    """The part of unpolarised light that passes a polariser, the glass with this Jones matrix, and an analyser."""
    behind, before = (
        np.eye(2) if angle == "none" else np.array([[np.cos(np.radians(angle)), np.sin(np.radians(angle))]])
        for angle in (polariser, analyser)
    )
    return (abs(before @ J @ behind.T) ** 2).sum((-1, -2)) / 2


@pytest.mark.parametrize("angles", ANGLES)
def test_light_that_runs_to_the_eye_has_the_same_power(angles):
    """The rays of the picture are traced from the eye. Here the light is traced."""
    scene = Chess(prisms=40, alpha=-110, eye=(0.4, -0.3), index=1.7, polariser=angles[0], analyser=angles[1])
    found = scene.trace(scene.rays(SIZE))
    some = (found.end == End.THROUGH) & (found.count < 12)
    light = scene.trace(Bundle(found.position[some] + found.direction[some], -found.direction[some]), path=True)
    same = abs(light.direction + scene.rays(SIZE).direction[some]).max(-1) < 1e-6  # few graze an edge
    assert same.mean() > 0.99 and some.sum() > 1000
    assert passed(scene, SIZE)[some][same] == pytest.approx(power(light.jones[same], *angles), abs=1e-6)


def test_two_analysers_share_all_light_and_what_is_beside_the_window_stays():
    scene = Chess(prisms=40, polariser=10)
    found = scene.trace(scene.rays(SIZE))
    back = found.end == End.BACK
    sums = [passed(scene.replace(analyser=angle), SIZE) for angle in (25, 115)]
    alone, beside = passed(scene, SIZE), (found.end != End.THROUGH) & (found.count == 0)
    assert back.any() and np.sum(sums, 0)[~back & ~beside] == pytest.approx(alone[~back & ~beside])
    assert (sums[0][beside] == 1).all() and beside.mean() > 0.3
    assert alone[found.end == End.THROUGH].max() <= 0.5 + 1e-9


def test_without_glass_it_is_malus_law():
    scene = Chess(sheet="none", polariser=20, analyser=80, eye=(0, 0))
    assert passed(scene, (65, 65))[32, 32] == pytest.approx(np.cos(np.radians(60)) ** 2 / 2)
    # the analyser fills the first opening, also where light misses a window behind it
    far = Chess(sheet="none", window="sheet=none,z=6", z1=3, analyser=0)
    found = far.trace(far.rays((48, 36)))
    missed = (found.end == End.BESIDE) & (found.windows[..., 0] == 0)
    assert missed.sum() > 50 and np.median(passed(far, (48, 36))[missed.reshape(36, 48)]) == pytest.approx(0.5)
    assert passed(far, (48, 36))[0, 0] == 1


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"sheet": "ideal", "polariser": 0}, "polariser, analyser: an ideal sheet has no polarisation"),
        ({"fresnel": True, "analyser": 0}, "fresnel = true: rays would split"),
        ({"analyser": 400}, "analyser = 400: should be less than or equal to 360"),
    ],
)
def test_what_has_no_polarisation_is_refused(values, words):
    with pytest.raises(InputError, match=words):
        Chess(**values)


def test_the_live_view_has_no_polarisers_and_tables_have():
    scenes = [Chess(analyser=angle) for angle in (0, 45)]
    with pytest.raises(InputError, match="the live view has none"):
        live(scenes[0])
    assert results(scenes, "nu", progress=False)["analyser"].tolist() == [0, 45]
