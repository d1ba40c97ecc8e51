"""The equations against closed forms, limits, an independent ray construction and the authors' own ray tracer."""

import warnings

import numpy as np
import pytest

from povgen import rotation

RNG = np.random.default_rng(2009)
# double precision, a few operations
EXACT = 1e-14


def test_P_solves_the_equation_it_comes_from():
    r = RNG.uniform(0.01, 10, 1000)
    alpha = RNG.uniform(-np.pi, np.pi, 1000)
    P = rotation.P(r, alpha)
    # eq. 5: E - P = r exp(i alpha) P with E = 1
    np.testing.assert_allclose(1 - P, r * np.exp(1j * alpha) * P, atol=1e-11)


def test_apparent_position_is_where_a_turned_ray_reaches_the_eye():
    """Light leaves L, crosses the sheet at P, has its transverse direction turned by alpha and must arrive at E."""
    n = 1000
    L, E = RNG.normal(size=(2, n)) + 1j * RNG.normal(size=(2, n))
    z1, z2 = RNG.uniform(0.1, 10, (2, n))
    alpha = RNG.uniform(-3, 3, n)
    P = rotation.apparent_position(L, E, z1, z2, alpha)
    slope = (P - L) / z1 * np.exp(1j * alpha)
    np.testing.assert_allclose(P + slope * z2, E, atol=1e-10)


def test_the_authors_ray_tracer_agrees():
    # Dr TIM, to the four digits that it gave
    P = rotation.apparent_position(0.6, 0, 2, 6, np.radians(90))
    assert P == pytest.approx(0.5400 + 0.1800j, abs=1e-12)
    assert abs(P - (0.5399 + 0.1801j)) < 2e-4


def test_nu_and_M_are_those_at_the_eye_and_not_as_printed():
    nu, M = rotation.nu(3, np.radians(66)), rotation.M(3, np.radians(66))
    assert np.degrees(nu) == pytest.approx(15.0, abs=0.05)
    assert M == pytest.approx(0.851, abs=0.0005)
    # an object of two points, seen from E: turned by nu and scaled by M
    L = np.array([0.3 + 0.2j, -0.1 + 0.5j])
    E = 0.4 - 0.1j
    seen = rotation.apparent_position(L, E, 2, 6, np.radians(66))
    np.testing.assert_allclose(seen - E, (L - E) * M * np.exp(1j * nu), rtol=EXACT)
    # the print's |P| would make an object that touches the sheet vanish
    assert abs(rotation.P(1e12, 0.3)) < 1e-11 and rotation.M(1e12, 0.3) == pytest.approx(1)


def test_limits_and_symmetric_angles():
    alpha = RNG.uniform(-3, 3, 100)
    np.testing.assert_allclose(rotation.P(0, alpha), 1, rtol=EXACT)  # far away: seen at E
    np.testing.assert_allclose(rotation.P(np.inf, alpha), 0, atol=EXACT)  # touches the sheet: seen at L
    np.testing.assert_allclose(rotation.M(3, 0.0), 0.75, rtol=EXACT)  # alpha = 0: perspective
    np.testing.assert_allclose(rotation.M(3, np.pi), 1.5, rtol=EXACT)  # alpha = 180 deg: real image at -z1
    np.testing.assert_allclose(rotation.nu(1e-9, 1.0), 1.0, atol=1e-8)  # the horizon turns by alpha


def test_near_the_pole_and_at_it():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for sign in (1, -1):
            assert rotation.P(1, sign * np.pi) == complex(np.inf, 0)
            assert rotation.M(1, sign * np.pi) == np.inf
            assert np.isnan(rotation.nu(1, sign * np.pi))
        # r = 1, alpha = pi - d: 1 + r exp(i alpha) = 1 - exp(-i d), so M = 1/(2 sin(d/2)) without cancellation
        d = np.pi - (np.pi - 1e-8)
        assert rotation.M(1, np.pi - 1e-8) == pytest.approx(1 / (2 * np.sin(d / 2)), rel=1e-14)
