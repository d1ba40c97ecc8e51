"""The exact ray trace against hand-computed paths, and against laws: reversal, none lost, the mirror, the rotation."""

from math import asin, pi, sin, tan

import numpy as np
import pytest

from povgen.optics import prism
from povgen.optics.trace import End, Face, Sheet, pair, trace

WINDOW = 2.4


def fan(n, eye=(0.0, 0.0, -6.0)):
    """Rays from an eye to random points of the window, directions of length 1."""
    places = np.random.default_rng(66).uniform(-1.1, 1.1, (n, 2))
    direction = np.column_stack((places, np.zeros(n))) - eye
    return np.broadcast_to(eye, (n, 3)), direction / np.linalg.norm(direction, axis=1, keepdims=True)


def transverse(direction):
    return direction[:, 0] + 1j * direction[:, 1]


@pytest.mark.parametrize("u", [0.3, 0.7, 0.95])
def test_an_axial_ray_through_one_prism(u):
    """Down at the entry facet by 45 deg - asin(sin 45 deg / n), up again from the base, and out along z."""
    prisms = 10
    pitch = WINDOW / prisms
    gap = prism.AIR_GAP * pitch
    height = pitch - gap
    half = height * prism.aspect() / 2
    down = pi / 4 - asin(sin(pi / 4) / 1.5)
    base = gap / 2  # height of the base of the prism above the middle
    u *= height
    rays = trace([[0.01, base + u, -3]], [[0, 0, 1]], (Sheet(0, 0.2),), WINDOW, prisms)
    assert rays.designed[0] and list(rays.faces[0, :3]) == [Face.NEAR, Face.BASE, Face.FAR]
    reflected = -half + u + u / tan(down)  # z on the base, from the sheet's middle
    leaves = (
        (half - reflected) * tan(down) / (1 + tan(down))
    )  # where it meets the far facet, z = half - height above base
    np.testing.assert_allclose(rays.position[0, :2], [0.01, base + leaves], atol=1e-14)
    np.testing.assert_allclose(rays.direction[0], [0, 0, 1], atol=1e-14)


def test_a_ray_between_two_prisms_goes_straight_on():
    rays = trace([[0.3, 0, -6]], [[0.05, 0, 1]], pair(0.0, WINDOW, 10), WINDOW, 10)
    assert rays.count[0] == 0 and rays.end[0] == End.THROUGH and not rays.designed[0]
    np.testing.assert_allclose(rays.direction[0], np.array([0.05, 0, 1]) / np.hypot(0.05, 1), rtol=1e-14)


@pytest.mark.parametrize("prisms", [10, 100, 1600])
@pytest.mark.parametrize("t", [0.0, 0.4, -1.1])
def test_the_proper_path_through_a_sheet_mirrors(prisms, t):
    origin, direction = fan(2000)
    rays = trace(origin, direction, (Sheet(t, 0),), WINDOW, prisms)
    assert rays.designed.mean() > 0.6
    mirrored = np.exp(2j * t) * transverse(direction).conj()
    np.testing.assert_allclose(transverse(rays.direction)[rays.designed], mirrored[rays.designed], atol=1e-13)
    np.testing.assert_allclose(rays.direction[rays.designed, 2], direction[rays.designed, 2], atol=1e-13)


@pytest.mark.parametrize("alpha", [0.0, 0.3, pi / 2, pi, -2.0])
def test_the_proper_path_through_two_sheets_rotates_light_by_alpha(alpha):
    """Rays from the eye run against the light, so they turn by -alpha."""
    origin, direction = fan(5000)
    rays = trace(origin, direction, pair(alpha, WINDOW, 100), WINDOW, 100)
    assert rays.designed.mean() > 0.5
    turned = np.exp(-1j * alpha) * transverse(direction)
    np.testing.assert_allclose(transverse(rays.direction)[rays.designed], turned[rays.designed], atol=1e-13)


def test_a_reversed_ray_retraces_itself():
    """Stray light included; but for rays so close to an edge or to the critical angle that rounding decides."""
    sheets = pair(1.1, WINDOW, 50)
    origin, direction = fan(20000)
    there = trace(origin, direction, sheets, WINDOW, 50, most=80)
    passed = there.end == End.THROUGH
    assert passed.mean() > 0.8
    back = trace(there.position[passed], -there.direction[passed], sheets, WINDOW, 50, most=80)
    same = (back.end == End.THROUGH) & (back.count == there.count[passed])
    np.testing.assert_allclose(np.where(same[:, None], back.direction + direction[passed], 0), 0, atol=1e-9)
    assert same.mean() > 0.9999
    for path, reverse, count in zip(
        there.faces[passed][same], back.faces[same], there.count[passed][same], strict=True
    ):
        mirror = np.array([0, Face.BASE, Face.TOP, Face.NEAR, Face.FAR])
        assert (mirror[path[:count]] == reverse[:count][::-1]).all()


def test_no_ray_is_lost():
    origin, direction = fan(20000, eye=(0.4, -0.2, -2.0))
    rays = trace(origin, direction, pair(0.7, WINDOW, 30), WINDOW, 30, most=250)
    assert (rays.end != End.UNFINISHED).all()
    np.testing.assert_allclose(np.linalg.norm(rays.direction, axis=1), 1, rtol=1e-12)
    assert (rays.direction[rays.end == End.THROUGH, 2] > 0).all() and (
        rays.direction[rays.end == End.BACK, 2] < 0
    ).all()
    edge = np.abs(rays.position[rays.end == End.FRAME, :2]).max(axis=1)
    assert (edge >= WINDOW / 2 - 1e-12).all()


@pytest.mark.parametrize(
    ("origin", "direction"),
    [
        ((0, 0, -6), (1, 0, 0)),  # along the sheets
        ((0, 0, 0), (0.3, 1, 0)),  # between them
        ((0, 0, -6), (0, 1, -0.0)),
        ((0, 0, -6), (0.1, 0, 5e-324)),  # along them for all that numbers can tell
        ((0, 0, -6), (0.1, 0, -1)),  # away from them
        ((0, 0, 6), (0, 0, 1)),
        ((0, 0, 0.01), (0, 0, 1)),  # from within
        ((0, 0, -6), (0, 0, 0)),
        ((0, 0, -6), (0, np.nan, 1)),
        ((np.inf, 0, -6), (0, 0, 1)),
    ],
)
def test_a_ray_that_does_not_run_towards_the_sheets_is_refused(origin, direction):
    origins, directions = fan(5)
    origins, directions = origins.copy(), directions.copy()
    origins[3], directions[3] = origin, direction
    with pytest.raises(ValueError, match="^ray 3 from .* does not reach the sheets; allowed"):
        trace(origins, directions, pair(0.7, WINDOW, 30), WINDOW, 30)


def test_a_ray_almost_along_the_sheets_meets_the_frame():
    rays = trace([[0, 0, -6]], [[1, 0, 1e-9], [1, 0, 1e-300]], pair(0.7, WINDOW, 30), WINDOW, 30)
    assert (rays.end == End.FRAME).all() and np.isfinite(rays.position).all()
