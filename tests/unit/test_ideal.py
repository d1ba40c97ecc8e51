"""Ideal sheets as maps of directions: laws, closed forms, and light that is followed from the object to the eye."""

from functools import partial

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from povgen.optics import ideal, rotation

DIRECTION = st.tuples(*[st.floats(-1, 1)] * 2, st.floats(0.1, 1) | st.floats(-1, -0.1)).map(np.array)
LIGHT = st.tuples(*[st.floats(-1, 1)] * 2, st.floats(-1, -0.1)).map(np.array)
ANGLE = st.floats(-2 * np.pi, 2 * np.pi)
FACTOR = st.builds(lambda size, angle: size * np.exp(1j * angle), st.floats(0.3, 3), ANGLE)
AXIS = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: np.hypot(*axis[:2]) + abs(axis[2]) > 0.01)
SHEETS = (
    st.builds(lambda axis, angle: partial(ideal.rotate_about, axis=axis, alpha=angle), AXIS, ANGLE)
    | st.builds(lambda ratio: partial(ideal.refract, ratio=ratio), FACTOR)
    | st.builds(lambda factor: partial(ideal.scale_slope, factor=factor), FACTOR)
    | st.builds(lambda angle: partial(rotation.mirror, angle=angle), ANGLE)
    | st.builds(lambda angle: partial(rotation.rotate, alpha=angle), ANGLE)
)
CLOSE = {"rtol": 0, "atol": 1e-12}


@given(SHEETS, DIRECTION)
def test_every_map_obeys_reciprocity_and_keeps_side_and_length(sheet, direction):
    out = sheet(direction)
    if np.isnan(out).any():
        assert np.isnan(out).all()
    else:
        assert out[2] * direction[2] > 0
        assume(abs(out[2]) > 1e-3)  # rounding is amplified for light that leaves along the sheet
        assert np.linalg.norm(out) == pytest.approx(np.linalg.norm(direction))
        np.testing.assert_allclose(sheet(-out), -direction, rtol=0, atol=1e-9)


@given(DIRECTION, ANGLE, st.floats(0.1, 9))
def test_rotation_about_the_normal_is_that_of_the_paper(direction, alpha, length):
    expected = rotation.rotate(direction, alpha)
    np.testing.assert_allclose(ideal.rotate_about(direction, (0, 0, length), alpha), expected, **CLOSE)
    np.testing.assert_allclose(ideal.rotate_about(direction, (0, 0, -length), -alpha), expected, **CLOSE)
    np.testing.assert_allclose(ideal.refract(direction, np.exp(1j * alpha)), expected, **CLOSE)
    np.testing.assert_allclose(ideal.scale_slope(direction, np.exp(1j * alpha)), expected, **CLOSE)


@given(LIGHT, AXIS, ANGLE, st.floats(-1, 1))
def test_rotation_about_any_axis(direction, axis, alpha, share):
    axis /= np.linalg.norm(axis)
    whole = ideal.rotate_about(direction, axis, alpha)
    assume(abs(whole[2]) > 1e-6 or np.isnan(whole[2]))
    first = ideal.rotate_about(direction, axis, share * alpha)
    second = ideal.rotate_about(first, axis, (1 - share) * alpha)
    if not np.isnan(second).any():
        np.testing.assert_allclose(second, whole, rtol=0, atol=1e-9)
    if not np.isnan(whole).any():
        assert whole @ axis == pytest.approx(direction @ axis, abs=1e-12)
        across, before = (d - (d @ axis) * axis for d in (whole, direction))
        assert across @ before == pytest.approx(np.cos(alpha) * (before @ before), abs=1e-12)
        assert np.cross(before, across) @ axis == pytest.approx(np.sin(alpha) * (before @ before), abs=1e-12)


def test_rotation_about_an_axis_in_the_sheet_tilts_light_up_to_90_degrees():
    """Who looks along the axis x sees y point up, and light that runs towards the eye run to the right."""
    np.testing.assert_allclose(ideal.rotate_about([0, 0, -1], (2, 0, 0), np.pi / 6), [0, 0.5, -(0.75**0.5)], **CLOSE)
    passes = ~np.isnan(ideal.rotate_about([0, 0, -1], (1, 0, 0), np.radians(89)))
    assert passes.all() and np.isnan(ideal.rotate_about([0, 0, -1], (1, 0, 0), np.radians(91))).all()
    directions = np.array([[0, np.sin(t), -np.cos(t)] for t in np.radians([-89, -29, 29, 31, 89])])
    turned = ideal.rotate_about(directions, (1, 0, 0), np.radians(60))
    assert np.isnan(turned[:, 0]).tolist() == [False, False, False, True, True]


@given(st.floats(0.3, 3), st.floats(0.01, 1.5), ANGLE)
def test_real_ratios_are_snells_law(ratio, angle, turn):
    light = [np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), -np.cos(angle)]
    out = ideal.refract(light, ratio)
    if ratio * np.sin(angle) > 1:
        assert np.isnan(out).all()
    else:
        assert out[:2] == pytest.approx(ratio * np.array(light[:2])) and out[2] < 0
        np.testing.assert_allclose(ideal.refract(light, -ratio)[:2], -out[:2], **CLOSE)  # negative refraction
        both = rotation.rotate(out, 0.7)
        np.testing.assert_allclose(ideal.refract(light, ratio * np.exp(0.7j)), both, **CLOSE)


@given(LIGHT, FACTOR, FACTOR)
def test_ratios_and_factors_multiply(light, first, second):
    for sheet in (ideal.refract, ideal.scale_slope):
        out = sheet(sheet(light, first), second)
        if not np.isnan(out).any():
            np.testing.assert_allclose(out, sheet(light, first * second), rtol=0, atol=1e-7)
    assert not np.isnan(ideal.scale_slope(light, first)).any()


def test_confocal_lenslets_scale_the_slope():
    """The ray matrix of two lenses f1 + f2 apart: every ray with the slope s leaves with -f1/f2 s."""
    f1, f2, s = 3.0, -1.2, 0.4
    lens = [np.array([[1, 0], [-1 / f, 1]]) for f in (f1, f2)]
    height, slope = lens[1] @ [[1, f1 + f2], [0, 1]] @ lens[0] @ [0.1, s]
    out = ideal.scale_slope([s, 0, -1.0], -f1 / f2)
    assert -out[0] / out[2] == pytest.approx(slope) and height != 0


def test_maps_take_arrays_and_refuse_what_is_no_sheet():
    directions = np.random.default_rng(1).normal(size=(4, 5, 3))
    for sheet in (partial(ideal.rotate_about, axis=(1, 2, 3), alpha=0.4), partial(ideal.refract, ratio=0.8j)):
        np.testing.assert_allclose(sheet(directions)[2, 3], sheet(directions[2, 3]), **CLOSE)
        assert np.isnan(sheet([np.nan, 0, 1])).all()
    assert np.isnan(ideal.refract([1, 0, 0.0], 0.5)).all() and np.isnan(ideal.scale_slope([1, 0, 0.0], 0.5)).all()
    assert np.isnan(ideal.rotate_about([1, 0, 0.0], (0, 0, 1), 0.5)).all()
    for length in (5e-324, 1e-200, 1e300):
        turned = ideal.rotate_about(directions, (0, length, 0), 0.4)
        np.testing.assert_allclose(turned, ideal.rotate_about(directions, (0, 1, 0), 0.4), **CLOSE)
    with pytest.raises(ValueError, match=r"^axis = \(0, 0, 0\); allowed: any other$"):
        ideal.rotate_about([0, 0, 1], (0, 0, 0), 1)
    with pytest.raises(ValueError, match="^ratio = 0; allowed: any other$"):
        ideal.refract([0, 0, 1], 0)
    with pytest.raises(ValueError, match="^factor = 0; allowed: any other$"):
        ideal.scale_slope([0, 0, 1], 0)


def seen(sheet, L, E=0, z1=2.0, z2=6.0):
    """Return where light crosses a sheet of SHEETS: a rotation about an axis, or a refraction."""
    if sheet.func is ideal.rotate_about:
        return ideal.position_by_rotation(L, E, z1, z2, **sheet.keywords)
    return ideal.position_by_refraction(L, E, z1, z2, **sheet.keywords)


@pytest.mark.parametrize(
    "sheet",
    [
        partial(ideal.rotate_about, axis=(0.3, -0.2, 1), alpha=1.0),
        partial(ideal.rotate_about, axis=(1, 0.5, 0), alpha=-0.4),
        partial(ideal.refract, ratio=1.5),
        partial(ideal.refract, ratio=0.6),
        partial(ideal.refract, ratio=-1.3),
        partial(ideal.refract, ratio=1.4 * np.exp(1j)),
        partial(ideal.refract, ratio=0.7j),
    ],
)
def test_light_from_the_object_through_the_apparent_position_reaches_the_eye(sheet, rng):
    L, E = rng.uniform(-1, 1, (2, 40, 2)) @ [1, 1j]
    z1, z2 = 2.0, 6.0
    P = seen(sheet, L, E, z1, z2)
    assert np.isfinite(P).all()
    light = sheet(np.stack(((P - L).real, (P - L).imag, np.full(40, -z1)), axis=-1))
    np.testing.assert_allclose(P + z2 * (light[:, 0] + 1j * light[:, 1]) / -light[:, 2], E, atol=1e-8)


def test_closed_forms_of_the_apparent_position():
    L, E, z1, z2 = 0.6 - 0.3j, 0.1 + 0.2j, 2.0, 6.0
    rays = L, E, z1, z2
    at = pytest.approx(rotation.apparent_position(*rays, 1.2))
    assert ideal.position_by_rotation(*rays, (0, 0, 1), 1.2) == at
    assert ideal.position_by_refraction(*rays, np.exp(1.2j)) == at
    # negative refraction makes an image of every point, as far before the sheet as the point is behind it
    assert ideal.position_by_refraction(*rays, -1) == pytest.approx(E + (L - E) * z2 / (z2 - z1))
    # refraction, near the axis, is perspective with the depth z1/ratio; the error is of second order
    near, paraxially = ideal.position_by_refraction(0.01, 0, z1, z2, 1.5), 0.01 * z2 / (z2 + z1 / 1.5)
    assert 1e-8 < abs(near / paraxially - 1) < 1e-6
    # half a turn about an axis in the sheet sends all light back
    assert np.isnan(ideal.position_by_rotation(*rays, (1, 2, 0), np.pi))
    assert np.isnan(ideal.position_by_refraction(1, 0, 6, 6, -1))  # the pole
    for refused in (
        lambda: ideal.position_by_rotation(*rays, (0, 0, 0), 1),
        lambda: ideal.position_by_refraction(*rays, 0),
    ):
        with pytest.raises(ValueError, match="allowed: any other"):
            refused()


def test_positions_where_the_ray_along_the_normal_does_not_pass():
    """Light at 35 degrees to the normal is turned by 100 degrees about x, and runs back to the axis."""
    turned = partial(ideal.rotate_about, axis=(1, 0, 0), alpha=np.radians(100))
    angle = np.arctan(abs(seen(turned, 0, 0, 2, 6).imag) / 6)
    assert 6 * np.tan(angle) == pytest.approx(2 * np.tan(np.radians(100) - angle)) and np.degrees(angle) > 35
    # behind a denser medium's interface light leaves at 41.8 degrees at most: L far aside is seen, close to that angle
    assert abs(ideal.position_by_refraction(1e3, 0, 2, 6, 1 / 1.5)) < 6 * np.tan(np.arcsin(1 / 1.5))
