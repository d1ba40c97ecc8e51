"""Blur by the prisms' size and by diffraction: constants from their definitions, and the least blur."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from povgen.optics import diffraction, equations
from povgen.optics.diffraction import best_pitch, blur
from povgen.optics.prism import Prism
from povgen.optics.trace import pair, trace

GREEN, ALPHA = 550e-9, np.radians(66)  # metres, radians
ARCMINUTE = np.radians(1 / 60)
LENGTH = st.floats(0.1, 10)


def test_the_shift_of_rays_through_two_sheets(rng):
    """Parallel light along z: the exact trace displaces it by sqrt(2/3) of a prism's height, RMS."""
    prism = Prism(2.4 / 100)
    origin = np.column_stack((rng.uniform(-0.5, 0.5, (4000, 2)), np.full(4000, -1.0)))
    rays = trace(origin, [[0, 0, 1]], pair(ALPHA, prism), 2.4)
    shift = (rays.position - origin)[rays.designed, :2]
    assert rays.designed.mean() > 0.95
    rms = np.sqrt((shift**2).sum(1).mean())
    assert rms == pytest.approx(diffraction.SHIFT * prism.height, rel=0.02)


def test_figures_for_a_builder():
    assert best_pitch(GREEN, 1.0) == pytest.approx(0.6e-3, rel=0.01)
    assert best_pitch(GREEN, 1.0) / np.sqrt(GREEN) == pytest.approx(0.81, abs=0.005)
    at = [blur(pitch, GREEN, 1.0, 1.0, ALPHA) / ARCMINUTE for pitch in (0.6e-3, 0.1e-3, 1e-3)]
    assert at == pytest.approx([1.4, 6.0, 1.8], abs=0.05)


@given(st.floats(4e-7, 8e-7), LENGTH, LENGTH, st.floats(-3, 3), st.floats(1.01, 10))
def test_no_other_pitch_blurs_less(wavelength, z1, z2, alpha, factor):
    best = best_pitch(wavelength, z1)
    least = blur(best, wavelength, z1, z2, alpha)
    assert blur(best * factor, wavelength, z1, z2, alpha) > least
    # by symmetry between shift and diffraction
    mirrored = blur(best * factor, wavelength, z1, z2, alpha)
    assert blur(best / factor, wavelength, z1, z2, alpha) == pytest.approx(mirrored)
    # longer waves at the same place: the same blur in units of the pitch, at a pitch that is larger by the root
    assert best_pitch(4 * wavelength, z1) == pytest.approx(2 * best)


@given(LENGTH, LENGTH, st.floats(-3, 3), st.floats(0, 6))
def test_blur_is_the_angle_in_which_the_eye_sees_a_displacement(z1, z2, alpha, direction):
    """Without diffraction: an object displaced by the RMS shift is seen displaced by the blur."""
    pitch = 1e-4
    D = diffraction.SHIFT * pitch * np.exp(1j * direction)
    seen = equations.apparent_position(D, 0, z1, z2, alpha) - equations.apparent_position(0, 0, z1, z2, alpha)
    assert blur(pitch, 0.0, z1, z2, alpha) == pytest.approx(abs(seen) / z2)


@pytest.mark.parametrize("name", ["pitch", "wavelength", "z1", "z2"])
def test_negative_lengths_are_refused(name):
    given = {"pitch": 1e-3, "wavelength": GREEN, "z1": 1.0, "z2": 1.0} | {name: [1.0, -0.5]}
    with pytest.raises(ValueError, match=f"^{name} = -0.5; allowed: 0 or more$"):
        blur(**given, alpha=ALPHA)
    if name in ("wavelength", "z1"):
        with pytest.raises(ValueError, match=f"^{name} = -0.5; allowed: 0 or more$"):
            best_pitch(given["wavelength"], given["z1"])


def test_blur_at_the_pole_is_infinite_and_arrays_broadcast():
    assert blur(0.0, GREEN, 1.0, 2.0, 1.0) == np.inf == blur(1e-3, GREEN, 2.0, 2.0, np.pi)
    far = blur(1e-3, GREEN, [1e12, np.inf], 1.0, 1.0)
    assert far[0] == pytest.approx(far[1], rel=1e-9) and far[1] > 0
    assert blur(np.full((3, 1), 1e-3), GREEN, 2.0, np.array([1.0, 2]), 1.0).shape == (3, 2)


@pytest.mark.parametrize("wavelength", [0.55, 550, [GREEN, 0.5]])
def test_wavelengths_in_other_units_are_refused(wavelength):
    for call in (lambda: best_pitch(wavelength, 1.0), lambda: blur(1e-3, wavelength, 1.0, 1.0, ALPHA)):
        with pytest.raises(ValueError, match="^wavelength = .*; allowed: 0 to 0.001, metres$"):
            call()
