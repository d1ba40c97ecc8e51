"""Windows in series: against light followed window by window, closed forms, and the exact trace through real prisms."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import glass
from hypothesis import assume, given
from hypothesis import strategies as st

from povgen.optics import apparent, equations, series
from povgen.optics.faces import GlassSheet
from povgen.optics.opening import Opening
from povgen.optics.pose import Pose
from povgen.optics.prism import Prism
from povgen.optics.rays import Bundle
from povgen.optics.trace import pair, trace
from povgen.optics.window_trace import trace_windows
from povgen.sheets.rotation import Rotation

ANGLE = st.floats(-2 * np.pi, 2 * np.pi)
DISTANCE = st.floats(0.1, 20)
POINT = st.complex_numbers(max_magnitude=10)
BEHIND = st.lists(st.tuples(DISTANCE, ANGLE), max_size=4)
WINDOW = 2.4
TWO = np.radians(50), [(2.0, np.radians(75))]
IMAGING = np.radians(120), [(2.0, np.radians(120))]
THREE = np.radians(40), [(1.0, np.radians(-70)), (1.5, np.radians(100))]


def image_distance(z1, alpha, behind=()):
    """Return where the image of points is. It is upright and as large as they are."""
    turns = [(0.0, alpha), *behind]
    points = np.array([0, 1 + 2j])
    z, places = apparent.image(points, z1, [(d, Rotation({"alpha": np.degrees(turn)})) for d, turn in turns])
    assert np.isnan(z) or places == pytest.approx(points)
    return z


@given(POINT, POINT, DISTANCE, DISTANCE, ANGLE, BEHIND)
def test_light_followed_from_window_to_window_reaches_the_eye(P, E, z1, z2, alpha, behind):
    """A camera's ray, which each window turns by -alpha (`equations.rotate`), meets L; light retraces its path."""
    at, direction = P, np.array([(P - E).real, (P - E).imag, z2])
    for turn, step in zip([alpha, *(a for _, a in behind)], [*(d for d, _ in behind), z1], strict=True):
        direction = equations.rotate(direction, turn)
        at += step * complex(*direction[:2]) / direction[2]
    close = {"abs": 1e-12 * (1 + abs(P) + abs(E)) * (1 + (z1 + sum(d for d, _ in behind)) / z2)}
    assert equations.object_position(P, E, z1, z2, alpha, behind) == pytest.approx(at, **close)
    Z = equations.depth(z1, z2, alpha, behind)
    assume(abs(Z) > 1e-3)
    assert equations.apparent_position(at, E, z1, z2, alpha, behind) == pytest.approx(P, abs=close["abs"] * z2 / abs(Z))


def test_windows_may_be_arrays():
    alphas, gaps = np.radians([10.0, 20, 30]), np.array([[1.0], [2]])
    Z = equations.depth(3, 6, alphas, [(gaps, 0.5)])
    assert Z.shape == (2, 3) and Z[1, 2] == pytest.approx(equations.depth(3, 6, alphas[2], [(2, 0.5)]))
    assert equations.apparent_position(0, 1, 3, 6, alphas, [(gaps, 0.5)]).shape == (2, 3)
    assert series.imaged_plane(alphas, [(gaps, 0.5)])[1].shape == (2, 3)


def test_two_windows_of_120_degrees_make_a_real_image():
    assert series.imaged_plane(*IMAGING) == pytest.approx((2, -2))
    assert image_distance(2, *IMAGING) == pytest.approx(-2)
    assert np.isnan(image_distance(2.001, *IMAGING))
    assert series.image_depth(2, *TWO).imag != 0 and np.isnan(image_distance(2, *TWO))


@given(st.floats(0.1, np.pi - 0.1), st.floats(0.1, np.pi - 0.1), st.sampled_from([1, -1]), DISTANCE)
def test_which_pairs_image(first, second, sense, d):
    """Angles of two windows from 0 to 180 degrees either way. A plane is imaged that an object can stand in, if ..."""
    z1, W = series.imaged_plane(sense * first, [(d, sense * second)])
    assume(abs(np.sin(first + second)) > 1e-3)
    # ... the windows turn light the same way, and by more than 180 degrees together: then the image is real
    assert (z1 > 0) == (W < 0) == (first + second > np.pi)
    assert image_distance(z1, sense * first, [(d, sense * second)]) == pytest.approx(W)
    # ... or they turn it in opposite ways, the second one by more: then the image is virtual
    z1, W = series.imaged_plane(sense * first, [(d, -sense * second)])
    assume(abs(first - second) > 1e-3)
    assert (z1 > 0) == (W > 0) == (first < second)
    # law of sines
    assert z1 / np.sin(first) == pytest.approx(d / np.sin(second - first)) == pytest.approx(W / np.sin(second))
    assert np.isnan(image_distance(z1 + 0.01, sense * first, [(d, -sense * second)]))


@given(ANGLE, BEHIND, POINT, POINT, DISTANCE)
def test_every_eye_sees_the_image_in_its_place_upright_and_of_the_objects_size(alpha, behind, L, E, z2):
    z1, W = series.imaged_plane(alpha, behind)
    assume(1e-3 < abs(z1) < 1e3 and abs(z2 + W) > 1e-3)
    Z = equations.depth(z1, z2, alpha, behind)
    assert Z == pytest.approx(z2 + W, rel=1e-8, abs=1e-8)
    if z1 > 0:
        straight = E + (L - E) * z2 / (z2 + W)  # where the line from E to the point opposite L at W crosses z = 0
        found = equations.apparent_position(L, E, z1, z2, alpha, behind)
        assert found == pytest.approx(straight, abs=1e-6 * (1 + abs(straight - E) / abs(z2 + W)) * (1 + abs(L - E)))


@pytest.mark.parametrize(
    ("alpha", "behind", "image"),
    [
        (np.pi, [(2, np.pi)], lambda z1: z1 - 2),  # all planes, each as far from the next as before
        (0, [(2, np.pi)], lambda z1: 2 - z1),  # in reversed order: pseudoscopic
        (np.pi, [], lambda z1: -z1),
        (np.pi / 3, [(1, np.pi / 3), (1, -2 * np.pi / 3)], lambda z1: np.nan),
    ],
)
def test_windows_that_image_every_plane_or_none(alpha, behind, image):
    assert np.isnan(series.imaged_plane(alpha, behind)).all()
    for z1 in (0.5, 3):
        assert image_distance(z1, alpha, behind) == pytest.approx(image(z1), nan_ok=True)


def windows(alpha, behind, prism):
    """Return windows in series, with `behind` as in `equations.depth`. All have the same prisms."""
    places = np.cumsum([0, *(d for d, _ in behind)])
    turns = [alpha, *(turn for _, turn in behind)]
    sheets = [SimpleNamespace(glass=pair(turn, prism), aperture=WINDOW) for turn in turns]
    return [Opening(Pose(z=z), sheet) for z, sheet in zip(places, sheets, strict=True)]


def traced(series, prisms, points, E=0.1 + 0.2j, z2=6.0, **shape):
    """Trace rays from the eye to points in the plane of the first window. Return the rays, their slopes, the prism."""
    prism = Prism(WINDOW / prisms, **shape)
    direction = np.column_stack(((points - E).real, (points - E).imag, np.full(len(points), z2)))
    rays = trace_windows(Bundle([E.real, E.imag, -z2], direction), windows(*series, prism))
    return rays, (points - E) / z2, prism


def squares(n, half, rng):
    """Return a random point in each of n x n squares."""
    x, y = half * (2 * (np.indices((n, n)) + rng.uniform(size=(2, n, n))).reshape(2, -1) / n - 1)
    return x + 1j * y


SHAPES = [{}, {"index": 1.7, "base_angle": 40}, {"base_angle": 60}, {"index": 2, "aspect": 0.9}]


@pytest.mark.parametrize(
    ("series", "prisms", "shape"),
    [
        ((1.15, []), 50, {}),
        *(((angle, []), 200, shape) for angle, shape in zip([0.2, 1.15, -2.0, np.pi], SHAPES, strict=True)),
        *((TWO, 50, {}), (IMAGING, 200, {}), (THREE, 200, {})),
    ],
)
def test_the_paraxial_prediction_for_prisms_of_finite_size(series, prisms, shape, rng):
    """L - E = A s + B conj(s), fitted to rays of the exact trace at small angles, is what apparent.depths() says."""
    z1, z2, E = 3.0, 8.0, 0.1 + 0.2j
    alpha, behind = series
    rays, slope, prism = traced(series, prisms, squares(100 if behind else 200, 0.4, rng), E, z2, **shape)
    on = rays.designed & rays.met_each_in_turn(True, len(behind) + 1)
    D = rays.at(sum(d for d, _ in behind) + z1)[on] - E
    (A, B), *_ = np.linalg.lstsq(np.column_stack((slope[on], slope[on].conj())), D, rcond=None)
    thin = equations.depth(z1, z2, alpha, behind)
    predicted = apparent.depths(z1, glass(z2, alpha, prism, behind))
    error = abs(A - predicted[0]) + abs(B - predicted[1])
    assert error < 0.15 * (abs(A - thin) + abs(B))
    seen = apparent.position(A * 0.01 + B * 0.01 + E, E, z1, glass(z2, alpha, prism, behind))
    assert seen == pytest.approx(E + 0.01 * z2, abs=0.02 * z2 * error / abs(A))


@given(DISTANCE, DISTANCE, ANGLE, BEHIND)
def test_prisms_of_no_size_obey_the_complex_depth(z1, z2, alpha, behind):
    Z = equations.depth(z1, z2, alpha, behind)
    assume(abs(Z) > 1e-3)
    windows = glass(z2, alpha, Prism(0.0), behind)
    A, B = apparent.depths(z1, windows)
    assert B == pytest.approx(0, abs=1e-12) and A == pytest.approx(Z, rel=1e-9)
    nu, M = apparent.nu_and_M(z1, windows)
    assert M * np.exp(1j * nu) == pytest.approx(z2 / Z, rel=1e-9)


def test_sheets_that_overlap_are_refused():
    prism = Prism(WINDOW / 30)
    with pytest.raises(ValueError, match=f"^centre = 0: overlaps the sheet before; allowed: {prism.length:g} or more$"):
        trace([[0, 0.02, -3]], [[0, 0, 1]], (GlassSheet(0.0, 0.0, prism), GlassSheet(1.0, 0.0, prism)), WINDOW)
