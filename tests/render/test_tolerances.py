"""Pairs of sheets that are not built exactly: the ray trace, the prediction, sensitivities and random builds."""

import numpy as np
import pytest
from conftest import PROJECT, refusal

from povgen import Chess, InputError, results
from povgen.liveview.values import values
from povgen.measure import charts, plotting, tolerance
from povgen.optics import paraxial
from povgen.optics.faces import GlassSheet, single_prisms
from povgen.optics.prism import Prism
from povgen.optics.profile import confocal
from povgen.optics.trace import trace
from povgen.rendering.views import check_gl
from povgen.scene import quantities
from povgen.scene.quantities import traced_image

FINE = Chess(prisms=1000, alpha=90, z1=10, z2=10)


def test_a_tilt_of_both_sheets_displaces_the_object():
    """By this angle at the eye, as docs/tolerances.md says. It also states what an eye's pupil adds to the blur."""
    scene = FINE
    for tilts in (("tilt_x", "far_tilt_x"), ("tilt_y", "far_tilt_y")):
        tilted = scene.replace(error=dict.fromkeys(tilts, 0.5))
        moved = abs(tilted.apparent_position(*scene.objects[0]) - scene.apparent_position(*scene.objects[0]))
        turn = np.exp(-1j * np.radians(scene.alpha))
        expected = abs(1 - turn) * scene.z1 / abs(scene.z2 + scene.z1 * turn)  # for each radian
        assert moved / scene.z2 == pytest.approx(np.radians(0.5) * expected, rel=0.04)
    pupils = np.array((0.02, 0.04, 0.08))
    blurs = results(scene, "pupil_blur", pupil=pupils, progress=False)["pupil_blur"]
    ahead = pupils / np.sqrt(8) * abs((1 / (scene.z2 + scene.z1 * turn)).imag)
    assert blurs == pytest.approx(np.degrees(ahead) * 60, rel=0.003)  # it is nearly straight ahead
    stated = "(`pupil_blur`), arcminutes | {:.2f} | {:.2f} | {:.2f} |".format(*blurs)
    assert stated in " ".join((PROJECT / "docs" / "tolerances.md").read_text("utf-8").split())


def test_a_sheet_that_is_turned_changes_alpha_by_twice_as_much():
    wrong, planned = FINE.replace(error={"turn": 1.5}), FINE.replace(alpha=93)
    rays = planned.rays((30, 30))
    found = [scene.trace(rays) for scene in (wrong, planned)]
    np.testing.assert_allclose(*(each.direction for each in found), atol=1e-12)
    assert wrong.sheets[0].thin == planned.sheets[0].thin


@pytest.mark.parametrize("error", tolerance.STEPS)
def test_the_prediction_knows_the_error(error):
    """Glass and base angle of both facets alike do not turn light."""
    wrong = FINE.replace(error={error: {"separation": 0.2, "index": 0.05, "far_index": 0.05}.get(error, 0.5)})
    predicted = wrong.apparent_position(wrong.L, wrong.z1)
    effect = abs(traced_image(wrong).position - traced_image(FINE).position)
    assert (effect > 0.005) is (error in ("turn", "tilt_x", "tilt_y", "far_tilt_x", "separation"))
    assert abs(traced_image(wrong).position - predicted) < 0.1 * effect + 5e-4


def test_a_seed_gives_the_same_prisms_in_every_version():
    """Otherwise a file's record would make another picture."""
    error = {"facets": 1, "pitches": 0.05, "seed": 3}
    lowest, bottoms, angles = single_prisms(Chess(prisms=30, error=error).sheets[0].glass[0], 3.0)
    np.testing.assert_allclose(bottoms[-lowest:][:3], [-1.509798, -1.40783, -1.303852], atol=1e-6)
    np.testing.assert_allclose(np.degrees(angles[-lowest]), [44.7564, 46.0023], atol=1e-4)


@pytest.mark.parametrize(("count", "aspect"), [(30, 1), (31, 0.8)])
def test_prisms_of_other_heights_reflect_the_place_of_light_at_their_own_base(count, aspect):
    """Light along z leaves along z, and on average at the height at which it arrives: docs/tolerances.md."""
    shape = Prism(3 / count, aspect=aspect)
    sheet = GlassSheet(0.0, 0.0, shape, pitches=0.05, seed=(4, 1))
    lowest, bottoms, _ = single_prisms(sheet, 3.0)
    heights = np.diff(bottoms) - shape.gap * shape.pitch
    assert np.std(heights) == pytest.approx(0.05 * shape.height, rel=0.2)
    assert bottoms[0] < -1.5 * np.sqrt(2) and bottoms[-1] > 1.5 * np.sqrt(2)  # even if the sheet is turned
    middle = bottoms[count // 2 - lowest]
    assert middle == pytest.approx(-1.5 + (count // 2 + shape.gap / 2) * shape.pitch)
    y = np.random.default_rng(1).uniform(-1.4, 1.4, 5000)
    rays = trace(np.column_stack((0 * y, y, 0 * y - 5)), [[0, 0, 1]], (sheet,), 3.0)
    own = np.searchsorted(bottoms, y, "right") - 1
    u = y - bottoms[own]
    wanted = (u < np.minimum(heights[own], shape.aspect * shape.height)) & (
        u > shape.aspect * shape.height - heights[own]
    )
    assert (rays.designed == wanted).all() and wanted.mean() > 0.7
    np.testing.assert_allclose(rays.direction[wanted, 1], 0, atol=1e-12)
    leaves = bottoms[own] + shape.aspect * shape.height - u
    np.testing.assert_allclose(rays.position[wanted, 1], leaves[wanted], atol=1e-12)
    assert abs((leaves - y)[wanted].mean()) < 0.02 * shape.height


@pytest.mark.parametrize("random", ["facets", "pitches"])
def test_prisms_without_differences_are_equal_prisms(random):
    rays = FINE.replace(prisms=40).rays((60, 60))
    equal, unequal = (FINE.replace(prisms=40, error={random: x, "seed": 3}).trace(rays) for x in (0, 1e-12))
    assert (equal.faces == unequal.faces).mean() > 0.9999
    np.testing.assert_allclose(equal.direction[equal.designed], unequal.direction[equal.designed], atol=1e-10)
    with pytest.raises(InputError, match=f"error: {random}: the renderer gl draws equal prisms"):
        check_gl(FINE.replace(error={random: 0.01}))


@pytest.mark.parametrize("mismatch", [1e-4, -1e-3])
@pytest.mark.parametrize(("ratio", "lenses"), [(1, 100), (0.7, 31)])
def test_lenses_of_another_pitch_turn_light_in_proportion_to_the_distance(mismatch, ratio, lenses):
    """By n delta/f1: delta = mismatch * x is how far the lenses opposite are displaced, f1 their focal length."""
    pitch = 3 / lenses
    shape = confocal(ratio, 6, 1.5, mismatch=mismatch).scaled(pitch)
    x = pitch * (np.arange(-lenses // 2 + 5, lenses // 2 - 5) + (0.5 if lenses % 2 == 0 else 0))
    start = np.column_stack((0 * x, x, 0 * x - 5))
    rays = trace(start, [[0, 0, 1]], (GlassSheet(0.0, 0.0, shape),), 3.0)
    assert rays.designed.all()
    slope = rays.direction[:, 1] / rays.direction[:, 2]
    wanted = 1.5 * mismatch * x / (ratio * 6 * pitch)
    np.testing.assert_allclose(slope, wanted, rtol=0.003, atol=1e-12)
    # the prediction is fitted to rays up to 0.1 rad, and so has some spherical aberration
    np.testing.assert_allclose(paraxial.layer(GlassSheet(0.0, 0.0, shape))[3, 1] * x, wanted, rtol=0.1, atol=1e-12)


def test_the_picture_of_arrays_of_different_pitch_repeats():
    """Where the lenses opposite are displaced by a whole lens, their light has order 1: every p/mismatch."""
    pitch, mismatch = 0.03, 0.025  # p/mismatch is 1.2 tiles: opposite 41 lenses are 40
    sheet = GlassSheet(0.0, 0.0, confocal(1, 6, 1.5, mismatch=mismatch).scaled(pitch))
    x = pitch * np.array([0.5, 41.5, -40.5])
    rays = trace(np.column_stack((0 * x, x, 0 * x - 5)), [[0, 0, 1]], (sheet,), 3.0)
    assert rays.orders[:, 0].tolist() == [0, -1, 1] and rays.designed.tolist() == [True, False, False]
    np.testing.assert_allclose(rays.direction[:, 1], rays.direction[0, 1], atol=1e-9)
    assert abs(rays.direction[0, 1]) > 0.003


@pytest.mark.parametrize("mismatch", [1e-3, 3e-3, 1e-2])
def test_the_prediction_knows_the_pitch(mismatch):
    scene = Chess(sheet="lenticular", lenses=400, f_number=6, alpha=40, z1=3)
    wrong = scene.replace(error={"pitch": mismatch, "far_pitch": mismatch})
    traced, predicted = traced_image(wrong), wrong.apparent_position(wrong.L, 3)
    plan = scene.apparent_position(scene.L, 3)
    assert abs(traced.position - predicted) < 0.1 * abs(traced.position - plan)


def test_facets_of_random_builds():
    """Each build draws its own facets, and all are blurred alike."""
    rough = Chess(prisms=200, alpha=90, z1=10, z2=10)
    change = tolerance.builds(
        rough, tolerance.random_builds(rough, tolerance.Spread(deviation={"facets": 0.1}, builds=6))
    )
    assert len(set(change.displaced)) == 6 and (change.blurred > 2).all()


@pytest.fixture(scope="module")
def found():
    return tolerance.sensitivities(FINE)


def test_sensitivities(found):
    exact, turned = (scene.apparent_position(scene.L, scene.z1) for scene in (FINE, FINE.replace(alpha=92)))
    assert found["turn"].displaced == pytest.approx(abs(turned - exact) / 10 / tolerance.ARCMINUTE, rel=0.05)
    assert found["turn"].turned == pytest.approx(1, abs=0.02)  # half of alpha's change: the object is as far as the eye
    apart = FINE.replace(error={"separation": 0.1})
    moved, before = (scene.apparent_position(scene.L, scene.z1) for scene in (apart, FINE))
    assert found["separation"].displaced == pytest.approx(abs(moved - before) / tolerance.ARCMINUTE, rel=0.02)
    # at alpha = 90 the light of an object as far as the eye appears displaced by 1/sqrt(2) of the light's deviation
    assert found["far_tilt_x"].displaced == pytest.approx(120 / np.sqrt(2), rel=0.02)
    # whichever way it is tilted, it is moved away from the other sheet
    tilted = (FINE.replace(error={"far_tilt_y": tilt}).apparent_position(FINE.L, FINE.z1) for tilt in (1, -1))
    apart = max(abs(position - exact) for position in tilted) / FINE.z2 / tolerance.ARCMINUTE
    assert found["far_tilt_y"].displaced == pytest.approx(apart, abs=0.25) and apart > 0.5
    assert np.hypot(found["tilt_x"].displaced, found["tilt_y"].displaced) == pytest.approx(120 / np.sqrt(2), rel=0.02)


@pytest.mark.parametrize("aside", [0, 3])
def test_a_blur_is_an_angle_at_the_eye(aside):
    scene = Chess(eye=(aside, aside), z2=6)
    place, seen = np.array([-0.5 + 0.2j]), np.array([[-0.5], [0.2], [0], [1], [1e-3]])
    step = np.exp(2j * np.pi * np.arange(360) / 360)
    cloud, middle = (scene.camera.through(each).direction for each in (place + 1e-3 * step, place))
    angles = np.linalg.norm(cloud - middle, axis=-1)
    assert tolerance._blur_angle(scene, seen) == pytest.approx(np.sqrt(np.mean(angles**2)), rel=1e-3)


def test_sensitivities_where_the_scene_allows_only_smaller_errors(monkeypatch):
    """A tilted sheet would reach the knight, or facets would cross."""
    monkeypatch.setattr(quantities, "RAYS", 1000)
    found = tolerance.sensitivities(Chess(alpha=90, z1=0.6), workers=1)
    assert all(np.isfinite(each.displaced) for each in found.values())
    assert tolerance._moved(Chess(aspect=0.48), "base_angle", -1).error == {"base_angle": -0.5}
    with pytest.raises(InputError, match="error: tilt_x: the scene allows neither less nor more of it"):
        tolerance.sensitivities(Chess(prisms=20, z1=1.0818))


@pytest.mark.release
def test_random_builds_agree_with_the_sensitivities(found):
    spread = tolerance.Spread(deviation={"far_tilt_x": 0.02}, builds=60)
    change = tolerance.builds(FINE, tolerance.random_builds(FINE, spread))
    unit = found["far_tilt_x"].displaced
    drawn = abs(np.random.default_rng(1).normal(size=60)) * 0.02
    np.testing.assert_allclose(change.displaced, unit * drawn, rtol=0.05, atol=0.02)
    assert tolerance.percentile(change.displaced, 50) == pytest.approx(unit * np.quantile(drawn, 0.5), rel=0.1)
    assert tolerance.percentile(np.array([1, np.nan]), 99) == tolerance.percentile(np.array([1, np.inf]), 99) == np.inf


@pytest.fixture
def figures(monkeypatch):
    drawn = []
    monkeypatch.setattr(plotting, "save_drawing", lambda figure, *_, **__: drawn.append(figure))
    return drawn


def test_the_chart_of_builds_counts_those_that_are_seen(figures, tmp_path):
    given = dict.fromkeys(tolerance.DEVIATIONS, 0.05)
    values = np.array([*np.arange(1, 100) / 100, np.nan])
    charts.save_builds(tolerance.Change(*[values] * 4), given, tmp_path / "builds.png")
    ax = figures[0].axes[0]
    assert sum(bar.get_height() for bar in ax.patches) == 99 and ax.get_ylabel() == "builds, of 100; not seen: 1"
    assert [text.get_text() for text in ax.texts] == ["50 %: 0.51", "95 %: 0.96"]
    assert ax.get_title("left") == "95 % of the builds: displaced by at most 0.96 arcminutes"
    rows = (tmp_path / "builds.csv").read_text("utf-8").splitlines()
    assert rows[1] == '"displaced, arcminutes",0.01' and rows[-2] == '"turned, degrees",nan'
    charts.save_builds(tolerance.Change(*[1000 * values] * 4), given, tmp_path / "builds.png")
    assert [text.get_text() for text in figures[1].axes[0].texts] == ["50 %: 510", "95 %: 960"]
    charts.save_builds(tolerance.Change(*np.full((4, 5), np.nan)), {"turn": 0.1}, tmp_path / "builds.png")
    assert not figures[2].axes[0].lines


def test_the_chart_of_errors_has_a_point_for_each(figures, tmp_path):
    found = {
        "turn": tolerance.Change(2.0, -3.0, 0.0, 0.0),
        "separation": tolerance.Change(-900.0, 1.0, 0.0, 0.0),
        "tilt_x": tolerance.Change(np.nan, np.nan, 0.0, 0.0),
    }
    charts.save_sensitivities(found, tmp_path / "errors.png")
    left, right = figures[0].axes
    assert [*left.lines[0].get_xdata()] == [0.03, 2, 9] and [*left.lines[1].get_xdata()] == [2, 9]
    assert [*right.lines[0].get_xdata()] == [0.02, 3, 0.02] and [*right.lines[1].get_xdata()] == [3]
    assert {text.get_text() for text in left.texts} == {"unknown", "2", "9"}
    assert {text.get_text() for text in right.texts} == {"unknown", "3", "below 0.02"}
    rows = (tmp_path / "errors.csv").read_text("utf-8").splitlines()
    assert rows[1:3] == [
        '"turn, 1 degree","displaced, arcminutes",2',
        '"separation, 0.01 tiles","displaced, arcminutes",9',
    ]


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: Chess(error={"x": 1}), "error = {'x': 1}: should be 'turn', 'tilt_x'"),
        (lambda: Chess(error="tilt_x=11"), "error: tilt_x = 11; allowed: -10 to 10 degrees"),
        (lambda: Chess(error="separation=-0.1"), "error: separation = -0.1; allowed: 0 to 10 tiles"),
        (lambda: Chess(aspect=0.48, error="base_angle=-8"), "error: slanted facets would cross"),
        (lambda: Chess(aspect=0.5, error="pitches=0.04"), "error: slanted facets would cross"),
        (lambda: Chess(error="pitches=0.06"), "error: pitches = 0.06; allowed: 0 to 0.05"),
        (lambda: Chess(index=1.1, error="far_index=-0.1"), "error: the far sheet would have index = 1; allowed: above"),
        (lambda: Chess(error="seed=1.5"), "error: seed = 1.5; allowed: a whole number"),
        (lambda: Chess(error="turn=1", window="z=2"), "only for a single window"),
        (lambda: Chess(error="pitch=0.01"), "error: pitch = 0.01; allowed for prisms: turn, tilt_x"),
        (lambda: Chess(sheet="lenticular", error="turn=1"), "turn = 1; allowed for lenses: pitch, far_pitch"),
        (lambda: Chess(sheet="lenticular", error="far_pitch=0.2"), "error: far_pitch = 0.2; allowed: -0.1 to 0.1"),
        (lambda: Chess(sheet="lenticular", f_number=1.5, error="pitch=0.1"), "more than a semicircle"),
        (lambda: check_gl(Chess(sheet="lenticular", error="pitch=0.01")), "the renderer gl draws lenses of one pitch"),
        (lambda: values(Chess(sheet="lenticular", error="pitch=0.01")), "the live view shows sheets that are built"),
        (
            lambda: tolerance.sensitivities(Chess(sheet="ideal")),
            "windows: 1, sheet = 'ideal'; allowed: one window, sheet = 'detailed'",
        ),
        (lambda: tolerance.Spread(deviation=["turn=2"]), "deviation: turn = 2; allowed: greater than 0, up to 1"),
        (lambda: tolerance.Spread(deviation={"turn": -1}), "deviation = {'turn': -1}: should be greater than"),
        (
            lambda: tolerance.sensitivities(Chess(alpha=180, z1=6, z2=6)),
            "the eye does not see the object on the designed path",
        ),
        (
            lambda: tolerance.random_builds(Chess(x=10), tolerance.Spread()),
            "the eye does not see the object on the designed path",
        ),
        (
            lambda: tolerance.random_builds(
                FINE.replace(error="index=0.09"), tolerance.Spread(deviation={"index": 0.02})
            ),
            "random build 2: error: index = ",
        ),
    ],
)
def test_what_is_refused(call, words):
    assert words in refusal(call)
