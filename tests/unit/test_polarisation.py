"""Fresnel losses and Jones matrices, against closed forms, textbook values, and laws."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from povgen import Bundle, Chess
from povgen.optics import polarisation
from povgen.optics.polarisation import transmission

ALONG_Z = (0, 0, -1)


def designed(scene, direction):
    """Return rays of light in one direction on the designed path."""
    start = np.random.default_rng(1).uniform(-0.3, 0.3, (60, 3)) * (1, 1, 0) - 3 * np.array(direction)
    found = scene.trace(Bundle(start, direction), path=True)
    return found[found.designed]


def jones(scene, direction=ALONG_Z):
    """Return the Jones matrix of light in a direction on the designed path, wherever it enters."""
    found = designed(scene, direction).jones
    assert len(found) > 3 and abs(found - found[0]).max() < 1e-9
    return found[0]


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


@pytest.mark.parametrize(("values", "degrees"), [({}, 24.55), ({"index": 1.5168}, 25.27), ({"index": 1.7}, None)])
def test_retardance_at_the_base(values, degrees):
    scene = Chess(sheet="single", **values)
    incidence = np.pi / 2 - scene.prism._slope
    sine = np.sin(incidence)
    closed = 2 * np.arctan(np.cos(incidence) * np.sqrt(sine**2 - 1 / scene.prism.index**2) / sine**2)
    J = jones(scene)
    assert np.angle(J[0, 0] / J[1, 1]) == pytest.approx(closed, rel=1e-10)  # above 0: p is ahead
    if degrees:
        assert np.degrees(closed) == pytest.approx(degrees, abs=0.01)


def test_transmission_of_one_sheet():
    """Light at 45 degrees to the facets of n = 1.5: 9.2 % of s and 0.85 % of p are reflected at each of two facets."""
    J = jones(Chess(sheet="single"))
    inside = np.sqrt(1 - 0.5 / 1.5**2)
    r = (np.sqrt(0.5) - 1.5 * inside) / (np.sqrt(0.5) + 1.5 * inside)
    s, p = (1 - r**2) ** 2, (1 - r**4) ** 2  # at 45 degrees r_p = r_s^2
    assert (s, p) == pytest.approx((0.8244, 0.9831), abs=1e-4)
    # the ridges lie along x: light polarised along them is s
    assert np.abs(J) ** 2 == pytest.approx(np.diag([s, p]), abs=1e-10)
    assert transmission(J) == pytest.approx((s + p) / 2)
    np.testing.assert_allclose(transmission(J, [0, np.pi / 2, np.pi / 4]), [s, p, (s + p) / 2])
    aligned, crossed = (transmission(jones(Chess(alpha=alpha))) for alpha in (0, 180))
    assert aligned == pytest.approx((s**2 + p**2) / 2) and crossed == pytest.approx(s * p)


def test_one_sheet_after_the_other():
    """Light along z, in the axes of each sheet: the matrix of two sheets is the product of those of the sheets."""
    J, half = jones(Chess(sheet="single")), np.radians(33)
    turned = np.array([[np.cos(half), -np.sin(half)], [np.sin(half), np.cos(half)]])
    both = jones(Chess(alpha=66))
    product = turned @ J @ turned.T @ J
    np.testing.assert_allclose(both, product * (both[0, 0] / product[0, 0]), atol=1e-9)
    np.testing.assert_allclose(abs(both), abs(product), atol=1e-9)


@settings(max_examples=15, deadline=None)
@given(st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)), st.floats(-170, 170))
def test_laws_for_light_in_any_direction(slope, alpha):
    scene = Chess(alpha=alpha)
    there = designed(scene, (*slope, -1.0))
    assert (np.linalg.svd(there.jones, compute_uv=False) <= 1 + 1e-9).all()  # no more light than there was
    # reciprocity: a reversed ray has the transposed matrix
    back = scene.trace(Bundle(there.position + there.direction, -there.direction), path=True)
    np.testing.assert_allclose(back.jones, np.swapaxes(there.jones, -1, -2), atol=1e-7)


class Fixed(np.random.Generator):
    """Random numbers that are all 1: no ray is reflected, where it also refracts."""

    def __init__(self):
        super().__init__(np.random.PCG64())

    def uniform(self, low=0.0, high=1.0, size=None):
        return np.ones(size)


def test_light_that_is_unpolarised_after_every_face():
    """Along z it meets the facets alike. Otherwise nearly as much passes as for both polarisations."""
    share = (0.0920 + 0.0085) / 2
    for scene, facets in ((Chess(sheet="single"), 2), (Chess(), 4)):
        rays = Bundle(designed(scene, ALONG_Z).corners[:, 0], ALONG_Z)
        assert scene.trace(rays, partial=Fixed()).light == pytest.approx((1 - share) ** facets, abs=2e-4)
    for slope in ((0.1, 0.05), (-0.1, 0.1)):
        there = designed(Chess(sheet="single", base_angle=50), (*slope, -1.0))
        single = Chess(sheet="single", base_angle=50).trace(
            Bundle(there.corners[:, 0], (*slope, -1.0)), partial=Fixed()
        )
        # (s^2 + p^2)/2 passes twice; the matrix gives (s^4 + p^4)/2, which is larger by ((s^2 - p^2)/2)^2
        both = transmission(there.jones)
        assert (both >= single.light - 1e-9).all() and (both < single.light + 0.01).all()
