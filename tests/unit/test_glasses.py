"""Glasses by name: the catalogue's indices, and scenes whose prisms have them."""

import pickle

import numpy as np
import pytest

from povgen import Chess, InputError, MovieSpec, to_pov
from povgen.optics.glasses import GLASSES, index
from povgen.scene.shader import uniforms
from povgen.video.captions import facts

# n of the yellow line d and Abbe's number, as Schott's data sheets state them; of the others, as their papers do
STATED = {
    "BK7": (1.51680, 64.17),
    "N-K5": (1.52249, 59.48),
    "N-FK51A": (1.48656, 84.47),
    "N-BAK4": (1.56883, 55.98),
    "N-SK16": (1.62041, 60.32),
    "F2": (1.62004, 36.37),
    "N-BAF10": (1.67003, 47.11),
    "N-LAK8": (1.71300, 53.83),
    "N-SF10": (1.72828, 28.53),
    "N-SF11": (1.78472, 25.68),
    "N-LASF9": (1.85025, 32.17),
    "N-SF66": (1.92286, 20.88),
    "fused-silica": (1.45846, 67.8),
    "CaF2": (1.43384, 95.1),
    "water": (1.33340, 55.8),
}


@pytest.mark.parametrize("glass", GLASSES)
def test_the_catalogue(glass):
    F, d, C = (index(glass, wavelength * 1e-9) for wavelength in (486.1327, 587.5618, 656.2725))
    if glass in STATED:
        assert (d, (d - 1) / (F - C)) == (
            pytest.approx(STATED[glass][0], abs=1.5e-5),
            pytest.approx(STATED[glass][1], rel=2e-3),
        )
    else:  # plastics, of which a sample's n differs in the third digit
        assert d == pytest.approx({"PMMA": 1.491, "polycarbonate": 1.585}[glass], abs=1e-3)


def test_a_glass_is_an_index():
    scene = Chess(glass="BK7")
    assert to_pov(scene) == to_pov(Chess(index=scene.index)) != to_pov(Chess())
    assert scene.index == index("BK7", 587.6e-9)
    assert uniforms(scene, ["knight"], [(0, 0, 0, 1)])["glassIndices"] == [scene.index] * 2
    assert scene.replace(wavelength=450).index > scene.index and scene.replace(glass="none").index == 1.5
    assert scene.replace(index=1.7) == scene.replace(wavelength=450).replace(index=1.7) == Chess(index=1.7)
    assert scene.replace(wavelength=450).replace(glass="none") == Chess()
    other = Chess(glass="BK7", wavelength=450, window="z=2,glass=N-SF11").replace(index=1.7)
    assert (other.glass, other.wavelength, other.index) == ("none", 450, 1.7)
    assert other.replace(index=1.4, window=()) == Chess(index=1.4)  # the new windows count
    assert scene.replace(window=(text for text in ["z=2"])).window == Chess(window="z=2").window
    then = scene.replace(wavelength=450).replace(index=1.7, window="z=2,glass=N-SF11")
    assert then.wavelength == 450 and then.window[0].index == index("N-SF11", 450e-9)
    assert Chess(index=1.7).replace(glass="BK7") == scene
    for copy in (
        Chess(**scene.model_dump()),
        Chess(**scene.model_dump()).replace(alpha=66),
        pickle.loads(pickle.dumps(scene)),
    ):
        assert copy == scene
    assert Chess(**scene.model_dump()).replace(wavelength=450) == scene.replace(wavelength=450)


def test_windows_can_have_glass_of_their_own():
    scene = Chess(glass="BK7", wavelength=500, window=["z=2", "z=3,index=1.7", "z=4,glass=N-SF11"], z2=8)
    n, other = (index(glass, 500e-9) for glass in ("BK7", "N-SF11"))
    assert [sheet.values["index"] for sheet in scene.sheets] == [n, n, 1.7, other]
    assert facts(scene)["n"] == f"{n:.4f} (BK7), {other:.4f} (N-SF11) at 500.0 nm"
    assert scene.replace(wavelength=600).sheets[3].values["index"] == pytest.approx(index("N-SF11", 600e-9), abs=1e-12)


def test_a_new_index_replaces_the_glass_of_a_window_and_of_a_movie():
    scene = Chess(window=["z=2,glass=BK7", "z=3,index=1.6"])
    glass, plain = scene.window
    assert Chess(window=[glass.replace(index=1.7), plain.replace(glass="BK7")]) == Chess(
        window=["z=2,index=1.7", "z=3,glass=BK7"]
    )
    spec = MovieSpec(
        title="a", scene="chess", fixed={"glass": "BK7"}, sweep=[{"parameter": "alpha", "start": 10, "stop": 90}]
    )
    assert spec.with_fixed({"index": "1.7"}).fixed == {"index": 1.7}
    blue = spec.with_fixed({"wavelength": 450})
    assert blue.with_fixed({"index": "1.7"}).fixed == {"index": 1.7}
    assert blue.with_fixed({"glass": "none"}).fixed == {"glass": "none"}
    for change in ({"index": "1.7"}, {"glass": "none"}):
        assert blue.with_fixed({**change, "window": "z=2,glass=BK7"}).fixed["wavelength"] == 450
    with pytest.raises(InputError, match="glass = "):
        plain.replace(glass=np.array([1, 2]))
    assert spec.with_fixed({"index": "1.7"}).with_fixed({"glass": "N-SF11"}).fixed == {"glass": "N-SF11"}


def test_a_dump_keeps_the_glass_of_a_window():
    scene = Chess(window="z=2,glass=BK7")
    again = Chess(**scene.model_dump())
    assert again == scene and again.replace(wavelength=500) == scene.replace(wavelength=500)
    assert again.replace(wavelength=500).window[0].index != scene.window[0].index


def test_a_wavelength_can_be_swept():
    spec = MovieSpec.of_sweeps("chess", ["wavelength=400:700"], {"frames": 4, "fixed": {"glass": "N-SF11"}})
    assert [scene.index for scene in spec.scenes("standard")] == [
        index("N-SF11", x * 1e-9) for x in (400, 500, 600, 700)
    ]
    with pytest.raises(InputError, match="frame 1 of 4: wavelength = 400: for no glass; allowed: with glass"):
        spec.replace(fixed={}).scenes("standard")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"glass": "BK7", "index": 1.6}, "index = 1.6, glass = 'BK7': allowed: one of them"),
        ({"wavelength": 500}, "wavelength = 500: for no glass; allowed: with glass, such as glass = BK7"),
        (
            {"glass": "PMMA", "wavelength": 400},
            "wavelength of 400 nm: outside the formula of PMMA; allowed: 436.8 to 1052 nm",
        ),
        (
            {"window": "z=2,glass=PMMA", "wavelength": 400},
            "window 2, wavelength of 400 nm: outside the formula of PMMA; allowed: 436.8 to 1052 nm",
        ),
    ],
)
def test_what_cannot_be_is_refused(values, message):
    with pytest.raises(InputError) as caught:
        Chess(**values)
    assert str(caught.value) == message


def test_the_caption_says_n_only_of_a_named_glass():
    assert "n" not in facts(Chess()) and "n" not in facts(Chess(glass="BK7", sheet="ideal"))
    assert facts(Chess(glass="BK7"))["n"] == "1.5168 (BK7) at 587.6 nm"
