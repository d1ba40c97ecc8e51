"""The exact ray trace, compared with a path computed by hand and with laws: reciprocity, mirror, rotation."""

from math import asin, pi, sin, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from povgen.optics.faces import Face, GlassSheet
from povgen.optics.polarisation import reflection
from povgen.optics.prism import Prism
from povgen.optics.trace import End, pair, trace

WINDOW = 2.4
COARSE = Prism(WINDOW / 30)


def fan(n, eye=(0.0, 0.0, -6.0)):
    """Return rays from an eye to n random points of the window: origins and unit directions."""
    points = np.random.default_rng(66).uniform(-1.1, 1.1, (n, 2))
    direction = np.column_stack((points, np.zeros(n))) - eye
    return np.broadcast_to(eye, (n, 3)), direction / np.linalg.norm(direction, axis=1, keepdims=True)


def transverse(direction):
    return direction[:, 0] + 1j * direction[:, 1]


@pytest.mark.parametrize(("u", "prisms"), [(0.3, 10), (0.7, 10), (0.95, 10), (0.7, 11)])
def test_an_axial_ray_through_one_prism(u, prisms):
    """The ray is bent down by 45 deg - asin(sin 45 deg / n), reflected at the base, and leaves along z."""
    prism = Prism(WINDOW / prisms)
    gap = 0.01 * prism.pitch
    height = prism.pitch - gap
    down = pi / 4 - asin(sin(pi / 4) / 1.5)
    half = height * (1 + 1 / tan(down)) / 2
    # height of a prism's base above the middle of the window, which is between two prisms, or amid one
    base = gap / 2 - (prisms % 2) * prism.pitch / 2
    u *= height
    rays = trace([[0.01, base + u, -3]], [[0, 0, 1]], (GlassSheet(0, 0.2, prism),), WINDOW)
    assert rays.designed[0] and list(rays.faces[0, :3]) == [Face.NEAR, Face.BASE, Face.FAR]
    reflected = -half + u + u / tan(down)  # z on the base, from the sheet's middle
    # where it meets the far facet, z = half - height above base
    leaves = (half - reflected) * tan(down) / (1 + tan(down))
    np.testing.assert_allclose(rays.position[0, :2], [0.01, base + leaves], atol=1e-14)
    np.testing.assert_allclose(rays.direction[0], [0, 0, 1], atol=1e-14)


@pytest.mark.parametrize("prisms", [10, 100, 1600])
@pytest.mark.parametrize("t", [0.0, 0.4, -1.1])
def test_the_designed_path_through_a_sheet_mirrors(prisms, t):
    origin, direction = fan(2000)
    rays = trace(origin, direction, (GlassSheet(t, 0, Prism(WINDOW / prisms)),), WINDOW)
    assert rays.designed.mean() > 0.6
    mirrored = np.exp(2j * t) * transverse(direction).conj()
    np.testing.assert_allclose(transverse(rays.direction)[rays.designed], mirrored[rays.designed], atol=1e-13)
    np.testing.assert_allclose(rays.direction[rays.designed, 2], direction[rays.designed, 2], atol=1e-13)


@pytest.mark.parametrize("alpha", [0.0, 0.3, pi / 2, pi, -2.0])
def test_the_designed_path_through_two_sheets_rotates_light_by_alpha(alpha):
    """Rays from the eye run against the light, so that they turn by -alpha."""
    origin, direction = fan(5000)
    rays = trace(origin, direction, pair(alpha, Prism(WINDOW / 100)), WINDOW)
    assert rays.designed.mean() > 0.5
    turned = np.exp(-1j * alpha) * transverse(direction)
    np.testing.assert_allclose(transverse(rays.direction)[rays.designed], turned[rays.designed], atol=1e-13)


@settings(max_examples=20)
@given(
    alpha=st.floats(-2 * pi, 2 * pi),
    prisms=st.integers(2, 1000),
    window=st.floats(0.1, 100),
    gap=st.floats(1e-4, 0.3),
    index=st.floats(1.1, 4),
    base_angle=st.floats(15, 75),
    aspect=st.floats(0, 1),
    single=st.booleans(),
    eye=st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(3, 20), st.sampled_from([1, -1])),
    seed=st.integers(0, 1000),
)
def test_a_reversed_ray_retraces_its_path(alpha, prisms, window, gap, index, base_angle, aspect, single, eye, seed):
    """Reciprocity: a ray sent back along its exit meets the same faces in reverse order, and arrives at its start.

    Stray light is included. A few rays are so close to an edge or to the critical angle that rounding decides.
    """
    least = Prism(window / prisms, index, base_angle).least_aspect
    prism = Prism(window / prisms, index, base_angle, gap, aspect=least + (2 * max(1, least) - least) * aspect)
    sheets = (GlassSheet(alpha, 0.3 * window, prism),) if single else pair(alpha, prism)
    rng = np.random.default_rng(seed)
    x, y, distance, side = eye
    start = np.array([window * x, window * y, side * (window * distance + prism.thickness(2) / 2)])
    direction = np.column_stack((rng.uniform(-0.5, 0.5, (50, 2)) * window, np.zeros(50))) - start
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    there = trace(start + 0 * direction, direction, sheets, window, most=80)
    leaves = there.end <= End.BACK
    faces, end, met = there.faces[leaves], there.end[leaves], there.count[leaves]
    back = trace(there.position[leaves], -there.direction[leaves], sheets, window, most=80)
    missed = np.linalg.norm(np.cross(back.position - start, direction[leaves]), axis=1)
    again = (back.end == end) & (back.count == met) & (missed < 1e-6 * window)
    again &= np.isclose(back.direction, -direction[leaves], atol=1e-6).all(1)
    for ray in np.flatnonzero(again):
        assert (faces[ray, : met[ray]] == back.faces[ray, : met[ray]][::-1]).all()
    assert (~again).sum() <= 2


@pytest.mark.parametrize(
    ("origin", "direction"),
    [
        ((0, 0, -6), (1, 0, 0)),  # parallel to the sheets
        ((0, 0, 0), (0.3, 1, 0)),  # between them
        ((0, 0, -6), (0.1, 0, -1)),  # away from them
        ((0, 0, 0.01), (0, 0, 1)),  # from inside them
        ((0, 0, -6), (0, np.nan, 1)),
    ],
)
def test_a_ray_that_does_not_run_towards_the_sheets_is_refused(origin, direction):
    origins, directions = fan(5)
    origins, directions = origins.copy(), directions.copy()
    origins[3], directions[3] = origin, direction
    with pytest.raises(ValueError, match="^ray 3 from .* does not reach the sheets; allowed"):
        trace(origins, directions, pair(0.7, COARSE), WINDOW)


# ---- partial reflection


class Fixed:
    """Random numbers that are all the same: with 0 every face reflects, with 1 no face does."""

    def __init__(self, value):
        self.value = value

    def uniform(self, size):
        return np.full(size, self.value)


def test_a_ray_that_every_face_reflects():
    """By hand: up from the slanted facet (45 deg) to the base of the prism above, down again, and back."""
    prism = Prism(WINDOW / 10)
    y = prism.pitch * 2.5
    rays = trace([[0.1, y, -3]], [[0, 0, 1]], pair(0.0, prism), WINDOW, partial=Fixed(0.0))
    assert list(rays.faces[0, :4]) == [Face.NEAR, Face.BASE, Face.NEAR, Face.NONE]
    assert rays.end[0] == End.BACK and rays.reflected[0] and not rays.designed[0]
    np.testing.assert_allclose(rays.direction[0], [0, 0, -1], atol=1e-14)
    np.testing.assert_allclose(rays.position[0, :2], [0.1, y], atol=1e-14)
    part = [(np.abs(reflection(1, 1.5, np.cos(angle))) ** 2).mean() for angle in (pi / 4, 0, pi / 4)]
    assert rays.light[0] == pytest.approx(np.prod(part))


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ({"pitch": -1}, "pitch = -1; allowed: 0 or more"),
        ({"index": 1}, "index = 1; allowed: above 1"),
        ({"base_angle": 90}, "base_angle = 90; allowed: above 0 and below 90"),
        ({"gap": 1}, "gap = 1; allowed: 0 or more, and below 1"),
        ({"aspect": 0}, "aspect = 0; allowed: above 0"),
    ],
)
def test_prisms_that_cannot_be_are_refused(shape, words):
    with pytest.raises(ValueError, match=f"^{words}$"):
        Prism(**{"pitch": 0.1, **shape})
    assert Prism(0, index=1.01, base_angle=89, gap=0, aspect=0.1).length == 0


@pytest.mark.parametrize(
    ("window", "shape", "most", "words"),
    [
        (0, {}, 60, "window = 0; allowed: above 0"),
        (WINDOW, {"aspect": 0.465}, 60, "aspect = 0.465: facets cross; allowed: 0.4655 or more"),
        (WINDOW, {}, 0, "most = 0; allowed: above 0"),
    ],
)
def test_windows_that_no_ray_can_pass_are_refused(window, shape, most, words):
    prism = Prism(**{"pitch": 0.1, **shape})
    with pytest.raises(ValueError, match=f"^{words}$"):
        trace([[0, 0, -6]], [[0, 0, 1]], pair(1.0, prism), window, most)
