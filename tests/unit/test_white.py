"""White light as a sum over wavelengths."""

import numpy as np
import pytest

from povgen import Chess, InputError, Room, Window, live
from povgen.inputs import hdr
from povgen.rendering import light
from povgen.scene import white


def test_the_matching_functions_are_the_cie_s():
    """Values of the CIE's table of 1931, which the fit meets within about 2 % of each function's maximum."""
    table = np.array([(0.3362, 0.0380, 1.7721), (0.0049, 0.3230, 0.2720), (0.5121, 1, 0.0057), (1.0622, 0.631, 0.0008)])
    assert white.cie([450, 500, 555, 600]) == pytest.approx(table, abs=0.035)


@pytest.mark.parametrize("count", [12, white.COUNT, 48])
def test_each_wavelength_has_its_colour_and_their_sum_changes_nothing(count):
    mixing, waves = white.mixing(count), white.wavelengths(count)
    assert mixing.sum(0) == pytest.approx(np.eye(3), abs=1e-6)
    seen = mixing.sum(2)  # the colour of each wavelength's part of white
    spectra = mixing[..., 0, :] / seen[:, :1]  # of objects that are red, green, blue: the share that is reflected
    assert spectra.min() > -0.002 and spectra.sum(1) == pytest.approx(np.ones(count), abs=1e-6)
    for k, nm in enumerate((620, 535, 450)):
        here = abs(waves - nm).argmin()
        assert seen[here].argmax() == k and spectra[here].argmax() == k and spectra[here].max() > 0.9


def test_white_light_needs_a_glass_whose_dispersion_is_known():
    for make in (Chess, lambda **values: Room([Window()], **values)):
        with pytest.raises(InputError, match="wavelength = white: needs a glass"):
            make(wavelength="white")
    with pytest.raises(InputError, match=r"wavelength of 400 nm: outside the formula of PMMA; allowed: 436.8"):
        Chess(glass="PMMA", wavelength="white")
    scene = Chess(glass="BK7", window="z=1,glass=SF11", wavelength="white")
    assert scene.index == scene.replace(wavelength=587.6).index and scene.window[0].index > 1.7
    assert Chess(**dict(scene)) == scene and scene.replace(index=1.4, window=()).wavelength == 587.6


def test_what_shows_one_wavelength_refuses_white_light():
    scene = Chess(glass="BK7", wavelength="white")
    with pytest.raises(InputError, match="wavelength = white: the live view"):
        live(scene)
    with pytest.raises(InputError, match="not with a pupil, polarisers or in white light"):
        from povgen import cheapest

        cheapest(scene, "1px")


@pytest.mark.parametrize("as_bytes", [False, True])
def test_pictures_are_mixed_in_linear_light(as_bytes):
    """A half red, half blue pixel at two wavelengths: red's part at 620 nm, blue's at 450 nm, each twice as bright."""
    picture = np.array([[[1, 0, 0.0]], [[0, 0, 1]]])
    weights = [2 * white.mixing()[abs(white.wavelengths() - nm).argmin()] for nm in (620, 450)]
    expected = picture[0] @ weights[0].T + picture[1] @ weights[1].T
    shown = [(255 * each).astype(np.uint8) if as_bytes else each for each in picture]
    found = light.mixed(shown, weights)
    assert found == pytest.approx(hdr.as_bytes(expected) if as_bytes else expected, abs=1e-6)
    assert expected[0].argmin() == 1 and weights[1][0, 0] != weights[1][2, 0]
