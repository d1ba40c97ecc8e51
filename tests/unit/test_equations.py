"""The equations against closed forms, limits and the authors' own ray tracer. test_series.py follows rays."""

import warnings

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from povgen.optics import equations

mpmath.mp.dps = 50
ANGLE = st.floats(-2 * np.pi, 2 * np.pi)
RATIO = st.floats(0.01, 100)
DIRECTION = st.tuples(*[st.floats(-1, 1)] * 2, st.floats(0.05, 1) | st.floats(-1, -0.05)).map(np.array)
# double precision, a few operations
EXACT = 1e-14


def test_the_authors_ray_tracer_agrees():
    # Dr TIM, to the four digits that it gave
    P = equations.apparent_position(0.6, 0, 2, 6, np.radians(90))
    assert P == pytest.approx(0.5400 + 0.1800j, abs=1e-12)
    assert abs(P - (0.5399 + 0.1801j)) < 2e-4


def test_nu_and_M_are_those_at_the_eye_and_not_as_printed():
    nu, M = equations.nu(3, np.radians(66)), equations.M(3, np.radians(66))
    assert np.degrees(nu) == pytest.approx(15.0, abs=0.05)
    assert M == pytest.approx(0.851, abs=0.0005)
    # an object of two points, seen from E: turned by nu and scaled by M
    L = np.array([0.3 + 0.2j, -0.1 + 0.5j])
    E = 0.4 - 0.1j
    seen = equations.apparent_position(L, E, 2, 6, np.radians(66))
    np.testing.assert_allclose(seen - E, (L - E) * M * np.exp(1j * nu), rtol=EXACT)
    # the print's |P| would make an object that touches the sheet vanish
    assert abs(equations.P(1e12, 0.3)) < 1e-11 and equations.M(1e12, 0.3) == pytest.approx(1)


def test_limits_and_symmetric_angles(rng):
    alpha = rng.uniform(-3, 3, 100)
    np.testing.assert_allclose(equations.P(0, alpha), 1, rtol=EXACT)  # far away: seen at E
    np.testing.assert_allclose(equations.P(np.inf, alpha), 0, atol=EXACT)  # touches the sheet: seen at L
    np.testing.assert_allclose(equations.M(3, 0.0), 0.75, rtol=EXACT)  # alpha = 0: perspective
    np.testing.assert_allclose(equations.M(3, np.pi), 1.5, rtol=EXACT)  # alpha = 180 deg: real image at -z1
    np.testing.assert_allclose(equations.nu(1e-9, 1.0), 1.0, atol=1e-8)  # the horizon turns by alpha
    np.testing.assert_allclose(equations.nu(0, alpha), alpha, rtol=EXACT)
    assert equations.nu(np.inf, 1.0) == 0 and equations.M(np.inf, 1.0) == 1
    assert equations.r(0, 6) == np.inf
    assert equations.apparent_position(0.3j, 1, 0, 6, 2.0) == pytest.approx(0.3j)


def test_near_the_pole_and_at_it():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for sign in (1, -1):
            assert equations.P(1, sign * np.pi) == complex(np.inf, 0)
            assert equations.M(1, sign * np.pi) == np.inf
            assert np.isnan(equations.nu(1, sign * np.pi))
        assert np.isnan(equations.apparent_position(0.2, 0.2, 3, 3, np.pi))  # seen in every direction
        assert equations.apparent_position(0.2, 0, 3, 3, np.pi) == complex(np.inf, 0)
        assert equations.object_position(0.2, 0.1, 3, 3, np.pi) == 0.1


@given(st.floats(-9, 0.5), st.floats(-np.pi, np.pi), st.sampled_from([1, -1, 3, -7]), st.floats(0.1, 100))
def test_twelve_digits_up_to_a_billionth_from_the_pole(decade, direction, odd, z1):
    """Against 50 digits, for exactly the doubles that are given; found are 4e-16."""
    r = max(1e-9, 1 + 10**decade * np.cos(direction))
    alpha = odd * np.pi + 10**decade * np.sin(direction)
    z = mpmath.mpf(r) * mpmath.expj(alpha)
    assume(abs(1 + z) > 1e-9)
    assert off(equations.P(r, alpha), 1 / (1 + z)) < 1e-12
    assert off(equations.one_minus_P(r, alpha), z / (1 + z)) < 1e-12
    assert off(equations.M(r, alpha), abs(z / (1 + z))) < 1e-12
    z2 = z1 * r
    z = mpmath.mpf(z2) / mpmath.mpf(z1) * mpmath.expj(alpha)
    assume(abs(1 + z) > 1e-9)
    assert off(equations.apparent_position(0.6 - 0.1j, 0, z1, z2, alpha), mpmath.mpc(0.6, -0.1) * z / (1 + z)) < 1e-12


def off(value, true):
    return abs((mpmath.mpmathify(complex(value)) - true) / true)


@given(RATIO, ANGLE)
def test_condition_number_is_what_a_small_error_grows_by(r, alpha):
    assume(equations.M(r, alpha) < 1e4)
    for step in (1e-9 * r, 1e-9j * r):  # an error of r, and one of alpha
        z = mpmath.mpf(r) * mpmath.expj(alpha)
        P, moved = 1 / (1 + z), 1 / (1 + z + mpmath.mpc(step) * mpmath.expj(alpha))
        assert abs(moved / P - 1) / 1e-9 == pytest.approx(equations.condition(r, alpha), rel=1e-4)


@given(RATIO, ANGLE)
def test_equations_4_to_6_lead_to_7(r, alpha):
    assume(equations.condition(r, alpha) < 1e6)
    P, turn = equations.P(r, alpha), r * np.exp(1j * alpha)
    assert abs(1 - P) == pytest.approx(r * abs(P), rel=1e-9)
    assert turn * P == pytest.approx(1 - P, abs=1e-9 * (1 + abs(P)))
    assert P * (1 + turn) == pytest.approx(1)
    assert equations.one_minus_P(r, alpha) == pytest.approx(1 - P, abs=1e-12 * (1 + abs(P)))


@given(DIRECTION, ANGLE, ANGLE)
def test_rotations_are_a_group_and_mirrors_their_roots(direction, a, b):
    rotate, mirror = equations.rotate, equations.mirror
    close = {"atol": 1e-14 * np.abs(direction).max()}
    np.testing.assert_allclose(rotate(rotate(direction, a), b), rotate(direction, a + b), **close)
    np.testing.assert_allclose(mirror(mirror(direction, a), a), direction, **close)
    # light meets the far sheet, at 0, first; a camera's ray the near one, at alpha/2
    sheets = (0, a / 2) if direction[2] < 0 else (a / 2, 0)
    np.testing.assert_allclose(mirror(mirror(direction, sheets[0]), sheets[1]), rotate(direction, a), **close)
    np.testing.assert_allclose(rotate(-rotate(direction, a), a), -direction, **close)  # reciprocity


# functions, and the parameters that they call real numbers
REAL = [
    (equations.P, {"r": 3.0, "alpha": 1.0}, "r"),
    (equations.apparent_position, {"L": 1j, "E": 0.2, "z1": 2.0, "z2": 6.0, "alpha": 1.0}, "z1"),
    (equations.curl, {"z1": 2.0, "z2": 6.0, "alpha": 1.0, "theta": 0.5}, "theta"),
    (equations.mirror, {"direction": [0.1, 0.2, 1.0], "angle": 1.0}, "direction"),
]
# the first two take complex numbers, the others refuse them for all others


@pytest.mark.parametrize(("function", "given", "name"), REAL)
def test_complex_numbers_are_refused_nan_is_kept(function, given, name):
    for wrong in (np.asarray(given[name]) + 0.5j, np.array([1j], object)):
        with pytest.raises(TypeError):
            function(**given | {name: wrong})
    assert np.isnan(function(**given | {name: np.asarray(given[name]) * np.nan})).any()
    for wrong, words in ((-0.5, "-0.5; allowed: 0 or more"), (66, "66; allowed: -10 pi to 10 pi, radians")):
        if (name in ("r", "z1")) == (wrong < 0) and name != "direction":
            with pytest.raises(ValueError, match=rf"^{name} = {words}$"):
                function(**given | {name: [1, wrong, np.nan]})
    with pytest.raises(TypeError, match="is complex; allowed: real numbers"):
        equations.depth(2.0, 6.0, 1.0, [(1.0, 0.5j)])


def test_places_of_any_type_of_number_are_exact():
    P, E = np.uint8([2]), np.uint8([3])
    assert equations.apparent_position(P, E, 1, 1, 0) == 2.5
    with pytest.raises(TypeError):
        equations.apparent_position("1", 0, 1, 1, 0.5)


def test_light_parallel_to_the_sheet_is_refused():
    with pytest.raises(ValueError, match="z = 0, parallel to the sheet"):
        equations.rotate([[1.0, 0, 1], [1, 0, 0]], 0.3)
