"""Fresnel losses and Jones matrices, against closed forms, textbook values, and laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from povgen.optics import polarisation
from povgen.optics.faces import GlassSheet
from povgen.optics.polarisation import jones, mean_transmission, transmission
from povgen.optics.prism import Prism
from povgen.optics.trace import pair, trace

DEFAULT, BK7 = Prism(0.024), Prism(0.024, 1.5168)
AXIAL = np.array([0, 0, -1.0])
ALPHA = np.radians(66)


def test_reflection_has_the_textbook_values():
    r_s, r_p = polarisation.reflection(1, 1.5, 1)
    assert r_s == pytest.approx(-0.2) and r_p == pytest.approx(0.2)  # 4 % at normal incidence
    brewster = np.arctan(1.5)
    r_s, r_p = polarisation.reflection(1, 1.5, np.cos(brewster))
    assert abs(r_p) < 1e-15 and abs(r_s) ** 2 == pytest.approx((1.25 / 3.25) ** 2)
    assert np.abs(polarisation.reflection(1.5, 1, 0.01)) == pytest.approx([1, 1])


@pytest.mark.parametrize("degrees", [48 + 37 / 60, 54 + 37 / 60])
def test_fresnels_rhomb(degrees):
    """Born and Wolf, section 1.5.4: glass of 1.51 retards by 45 degrees at 48 deg 37' and at 54 deg 37'."""
    r_s, r_p = polarisation.reflection(1.51, 1, np.cos(np.radians(degrees)))
    assert np.degrees(np.angle(r_s / r_p)) == pytest.approx(45, abs=0.02)


@pytest.mark.parametrize(("prism", "degrees"), [(DEFAULT, 24.55), (BK7, 25.27), (Prism(1, 1.7, 40), None)])
def test_retardance_at_the_base(prism, degrees):
    incidence = np.pi / 2 - prism._slope
    sine = np.sin(incidence)
    closed = 2 * np.arctan(np.cos(incidence) * np.sqrt(sine**2 - 1 / prism.index**2) / sine**2)
    assert polarisation.retardance(prism) == pytest.approx(closed, rel=1e-12)  # above 0: p is ahead
    if degrees:
        assert np.degrees(closed) == pytest.approx(degrees, abs=0.01)


def test_transmission_of_one_sheet():
    """Light at 45 degrees to the facets of n = 1.5: 9.2 % of s and 0.85 % of p are reflected at each of two facets."""
    J = jones(AXIAL, [0], DEFAULT)
    inside = np.sqrt(1 - 0.5 / 1.5**2)
    r = (np.sqrt(0.5) - 1.5 * inside) / (np.sqrt(0.5) + 1.5 * inside)
    s, p = (1 - r**2) ** 2, (1 - r**4) ** 2  # at 45 degrees r_p = r_s^2
    assert (s, p) == pytest.approx((0.8244, 0.9831), abs=1e-4)
    # the ridges lie along x: light polarised along them is s
    assert np.abs(J) ** 2 == pytest.approx(np.diag([s, p]), abs=1e-12)
    assert transmission(J) == pytest.approx((s + p) / 2)
    np.testing.assert_allclose(transmission(J, [0, np.pi / 2, np.pi / 4]), [s, p, (s + p) / 2])
    aligned, crossed = (transmission(jones(AXIAL, [0, t], DEFAULT)) for t in (0, np.pi / 2))
    assert aligned == pytest.approx((s**2 + p**2) / 2) and crossed == pytest.approx(s * p)


@given(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), st.floats(-3, 3), st.floats(-3, 3), st.booleans())
def test_laws_for_light_in_any_direction(slope, first, second, towards):
    direction = np.array([*slope, -1.0 if towards else 1.0])
    J = jones(direction, [first, second], BK7)
    # no more light than there was
    assert (np.linalg.svd(J, compute_uv=False) <= 1 + 1e-12).all()
    # reciprocity: a reversed ray meets the sheets in reverse order, and has the transposed matrix
    d = complex(*slope) * np.exp(2j * (second - first))  # two mirrorings turn the transverse direction
    after = np.array([d.real, d.imag, direction[2]])
    np.testing.assert_allclose(jones(-after, [second, first], BK7), J.T, atol=1e-12)
    # turning all: the axes of a wave along z turn too
    turned = np.array([[np.cos(first), -np.sin(first)], [np.sin(first), np.cos(first)]])
    np.testing.assert_allclose(
        jones(AXIAL, [first, second], BK7), turned @ jones(AXIAL, [0, second - first], BK7) @ turned.T, atol=1e-12
    )


def test_only_the_designed_path_has_a_matrix(rng):
    """The ray trace takes no designed path where the matrix is NaN, and many where it is not."""
    direction = np.column_stack((rng.uniform(-1.2, 1.2, (4000, 2)), np.ones(4000)))
    prism = Prism(0.024)
    rays = trace([[0, 0, -0.1]], direction, (GlassSheet(0.3, 0, prism),), 2.4)
    J = jones(direction, [0.3], prism)
    missing = np.isnan(J).any((-1, -2))
    assert J.shape == (4000, 2, 2) and 0.05 < missing.mean() < 0.9
    assert not rays.designed[missing].any() and rays.designed[~missing].mean() > 0.2
    # and every ray on the designed path through two sheets has one
    rays = trace([[0, 0, -1]], direction, pair(ALPHA, prism), 2.4)
    J = jones(direction[rays.designed], [ALPHA / 2, 0], prism)
    assert rays.designed.sum() > 100 and np.isfinite(J).all()


def test_light_that_is_unpolarised_after_every_face(rng):
    """Along z it meets four facets alike. Otherwise nearly as much passes as `jones` says for both polarisations."""
    prism = Prism(0.02)
    R = 1 - mean_transmission([0, 0, -1], [0.3], prism) ** 0.5
    assert R == pytest.approx((0.0920 + 0.0085) / 2, abs=1e-4)
    assert mean_transmission([0, 0, -1], [0, 0.5], prism) == pytest.approx((1 - R) ** 4)
    direction = np.column_stack((rng.uniform(-0.15, 0.15, (50, 2)), -np.ones(50)))
    for angle, shape in ((0.0, prism), (0.7, prism), (0.7, Prism(0.02, base_angle=50))):
        # of one sheet: (s^2 + p^2)/2 passes twice; jones gives (s^4 + p^4)/2, which is larger by ((s^2 - p^2)/2)^2
        single, both = mean_transmission(direction, [angle], shape), transmission(jones(direction, [angle], shape))
        assert (both >= single - 1e-12).all() and (both < single + 0.01).all()
