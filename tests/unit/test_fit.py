"""Parameters from points in a photograph."""

import numpy as np
import pytest

from povgen import Chess, InputError, fit

TRUE = Chess(sheet="ideal", alpha=66, z1=3, z2=7, eye=(0.3, 0.1))
PLACES = np.random.default_rng(3).uniform(-1, 1, (12, 2))


def seen(scene, places=PLACES, z1=None):
    found = scene.apparent_position(places[:, 0] + 1j * places[:, 1], scene.z1 if z1 is None else z1)
    return np.stack((found.real, found.imag), -1)


@pytest.mark.parametrize(
    ("scene", "start", "free"),
    [
        (TRUE, {"alpha": 40, "z1": 2}, ("alpha", "z1")),
        (TRUE, {"alpha": 80, "eye": (0, 0)}, ("alpha", "eye_x", "eye_y")),
        (TRUE.replace(sheet="detailed"), {"alpha": 60, "z2": 6}, ("alpha", "z2")),
        (Chess(sheet="lens", focal_length=5, z1=2), {"focal_length": 4}, ("focal_length",)),
    ],
)
def test_points_without_noise_give_the_parameters_back(scene, start, free):
    found = fit(scene.replace(**start), PLACES, seen(scene), free, noise=0.01)
    assert not found.warning and found.scene.replace(**start) == scene.replace(**start, view=scene.view)
    true = {**scene.model_dump(), "eye_x": scene.eye[0], "eye_y": scene.eye[1]}
    for name, value in found.values.items():
        assert value == pytest.approx(true[name], abs=1e-5) and 0 < found.errors[name] < 5


def test_numbers_of_a_further_window_are_found():
    scene = TRUE.replace(window="alpha=40,z=2", z2=9)
    start = scene.replace(window="alpha=30,z=1.5")
    found = fit(start, PLACES, seen(scene), ("window2_alpha", "window2_z"), noise=0.01)
    assert not found.warning and found.values == pytest.approx({"window2_alpha": 40, "window2_z": 2}, abs=1e-5)
    assert found.scene.places[1] == pytest.approx(2) and found.scene.view == start.view
    with pytest.raises(InputError, match="free = 'window3_z': no number"):
        fit(scene, PLACES, seen(scene), "window3_z")


@pytest.mark.parametrize("seed", [1, 2])
def test_numbers_of_lenses_are_found(seed):
    """The prediction for lenses jumps where a ray leaves the designed path. Derivatives and warnings allow for that."""
    true = {"ratio": 1.13, "f_number": 6.5}
    scene = Chess(sheet="lenticular", alpha=40, **true)
    points = seen(scene, z1=2) + np.random.default_rng(seed).normal(0, 0.003, (12, 2))
    found = fit(scene.replace(ratio=1, f_number=6), PLACES, points, tuple(true), noise=0.003)
    assert not found.warning and 0.05 < found.errors["f_number"] < 0.5
    for name, value in true.items():
        assert abs(found.values[name] - value) < 3 * found.errors[name] + 1e-3


def test_one_point_is_enough_for_one_parameter():
    found = fit(TRUE, PLACES[:1], seen(TRUE, PLACES[:1]) + (1e-4, 0), "alpha")
    assert not found.warning and found.values["alpha"] == pytest.approx(66, abs=0.1)


def test_without_a_stated_noise_it_is_that_of_what_is_left():
    points = seen(TRUE) + np.random.default_rng(5).normal(0, 0.01, (12, 2))
    known, unknown = (fit(TRUE.replace(alpha=60), PLACES, points, noise=noise) for noise in (0.01, None))
    assert unknown.errors["alpha"] == pytest.approx(known.errors["alpha"], rel=0.5)
    assert unknown.rms == pytest.approx(0.01 * 2**0.5, rel=0.4)


def test_points_at_one_distance_tell_z1_over_z2_alone():
    found = fit(TRUE.replace(z1=2), PLACES, seen(TRUE), ("alpha", "z1", "z2"), noise=0.01)
    assert found.warning == "the points do not determine: z1, z2" and "± inf" in str(found)
    assert found == fit(TRUE.replace(z1=2), PLACES, seen(TRUE), ("alpha", "z1", "z2"), noise=0.01)
    assert np.isinf([found.errors["z1"], found.errors["z2"]]).all() and found.errors["alpha"] < 1
    assert found.values["z1"] / found.values["z2"] == pytest.approx(3 / 7)
    depths = np.linspace(2, 5, 12)  # known distances tell z2
    places = np.column_stack((PLACES, depths))
    known = fit(TRUE.replace(z2=6), places, seen(TRUE, PLACES, depths), ("alpha", "z2"), noise=0.01)
    assert not known.warning and known.values["z2"] == pytest.approx(7)


MARKED = [(-1, -1), (1, -1), (0, 0.5)], [(-0.51, -1.02), (1.02, -0.51), (-0.13, 0.38)]  # alpha = 66, z1 = 3, z2 = 7


@pytest.mark.parametrize("sheet", ["ideal", "detailed"])
@pytest.mark.parametrize("start", [{"alpha": 250}, {"alpha": -100, "z1": 30}, {"alpha": 359.9, "z1": 0.7}])
def test_the_search_may_start_far_from_the_truth(sheet, start):
    found = fit(Chess(sheet=sheet, z2=7, **start), *MARKED)
    assert found.values["alpha"] % 360 == pytest.approx(66, abs=2) and found.values["z1"] == pytest.approx(3, abs=0.2)
    assert not found.warning and found.scene.z1 == found.values["z1"]


def test_a_fit_does_not_depend_on_where_the_piece_could_stand():
    points = seen(Chess(sheet="ideal", z2=7), z1=0.3)
    found = fit(Chess(sheet="ideal", z2=7), PLACES, points, noise=0.01)
    assert found.values["z1"] == pytest.approx(0.3) and found.scene is None
    assert found.warning.startswith("no scene: z1 = 0.3: the knight would touch the window frame")


@pytest.mark.parametrize(
    ("free", "noise", "warning"),
    [
        ("z1", 0.01, "at the edge of what is allowed: z1; the points are 0.41 tiles from where these values show them"),
        ("z2", 1, "at the edge of what is allowed: z2"),
        ("z1", None, "at the edge of what is allowed: z1; the points are 0.41 tiles"),
        ("focal_length", 1, "the points do not determine: focal_length"),
    ],
)
def test_a_fit_that_is_none_has_a_warning(free, noise, warning):
    assert fit(Chess(sheet="ideal", alpha=250, z2=7), *MARKED, free, noise).warning.startswith(warning)


def test_points_in_the_middle_determine_nothing():
    found = fit(Chess(sheet="ideal"), [(0, 0)] * 2, [(0, 0)] * 2, noise=0.01)
    assert found.warning == "the points do not determine: alpha, z1" and "nan" not in str(found)


@pytest.mark.parametrize(
    ("places", "free", "message"),
    [
        (PLACES, ("alhpa",), "free = 'alhpa': no number of eye and windows, or a whole one; allowed: alpha, z1"),
        (PLACES, ("sheet",), "free = 'sheet': no number"),
        (PLACES[:1], ("alpha", "z1"), "free: 2 for 2 coordinates; allowed: 1 to 1"),
        (np.column_stack((PLACES, PLACES[:, 0] + 2)), ("z1",), "free: z1, which places state"),
        (PLACES[:, :1], ("alpha",), "places, seen: arrays of the shapes"),
        (PLACES * np.nan, "alpha", "places, seen: NaN, infinite, or a z1 below 0"),
        (PLACES, ("prisms",), "free = 'prisms': no number of eye and windows, or a whole one; allowed: alpha"),
        (PLACES, ("alpha", "alpha"), "free = alpha, alpha: a name twice; allowed: each once"),
    ],
)
def test_what_cannot_be_fitted_is_refused(places, free, message):
    with pytest.raises(InputError, match=message.replace("(", r"\(")):
        fit(TRUE, places, np.zeros((len(places), 2)), free)
    for noise in (0, -1, np.nan):
        with pytest.raises(InputError, match="noise = .*: allowed: above 0"):
            fit(TRUE, PLACES, PLACES, noise=noise)
