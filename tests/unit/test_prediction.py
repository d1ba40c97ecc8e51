"""What follows from a scene before it is rendered: trace level, cells of the camera, warnings."""

import pytest

from povgen import Chess, Spheres, limits
from povgen.inputs.pieces import PieceFile
from povgen.measure import probes
from povgen.measure.measured import px
from povgen.optics.trace import End
from povgen.scene import survey, warnings
from povgen.scene.quantities import traced_image
from povgen.settings import Rendering


@pytest.mark.parametrize(
    "scene, options, words",
    [
        (Spheres(), {"overlay": True, "caption": "full"}, None),
        (
            Spheres(alpha=175, z1=[2, 5.5]),
            {"overlay": True},
            "overlay: at alpha = 175 and z1 = 5.5 the prediction can be wrong by up to 202 pix",
        ),
        (Chess(alpha=-9, window="alpha=50,z=2"), {"overlay": True}, "at alpha = -9 and z1 = 2 the prediction can"),
        (Chess(alpha=180, z1=6), {"overlay": True}, "z1 = 6 the prediction can be wrong by more than the picture's"),
        (
            Spheres(alpha=179.9, sheet="ideal"),
            {"caption": "full"},
            "can be wrong by up to 3.82 pixels of 1280x960, because of the magnification of the object, 573 times",
        ),
        (
            Spheres(sheet="single", z1=[2, 5]),
            {"overlay": True},
            "overlay: at z1 = 5 the prediction can be wrong by up to 9.18 pixels",
        ),
        (
            Chess(sheet="lenslets", alpha=180, z1=6),
            {"overlay": True},
            "overlay: at z1 = 6 the object has no mark",
        ),
        (
            Chess(sheet="axis", alpha=180),
            {},
            "sheet = axis: no light passes through the window, because of alpha, axis, z2 and eye",
        ),
        (Chess(alpha=179, z1=5, predicted_image=True), {"overlay": True}, "predicted_image, overlay: at alpha = 179"),
    ],
)
def test_predictions_warn_beyond_their_limit(scene, options, words):
    """The warning names every option that shows the prediction, and the object that is farthest beyond the limit."""
    said = [text for _, text in warnings.warnings(scene, Rendering(**options))]
    assert (len(said) == 1 and words in said[0]) if words else not said


SIZE = (320, 240)


def test_the_trace_level_leaves_few_pixels_black():
    """Counted on rays that lie otherwise than those by which povgen sets the level, traced further than it does."""
    levels = []
    for prisms, alpha, z2, E, shape in (
        (
            19,
            0,
            6,
            0j,
            {"sheet": "single", "index": 1.164, "base_angle": 75},
        ),  # much light enters the deep frame at its edge
        (1059, 50, 1.5, 5.1j, {}),  # 12 % at 61 faces
        (678, -71, 0.92, 8.2j, {}),  # the highest level that was found
        (100, 66, 6, 0j, {}),
    ):
        scene = probes.Directions(prisms=prisms, alpha=alpha, z2=z2, eye=E, **shape)
        found = scene.trace(scene.rays(SIZE), max_faces=255)
        lost = ((found.end != End.FRAME) & (found.count >= survey.max_trace_level(scene)))[found.count > 0]
        assert lost.mean() <= limits.MAX_LOST_FRACTION, (scene, lost.mean())
        levels.append(survey.max_trace_level(scene))
    assert levels[-1] < 40 < 100 < max(levels) <= limits.MAX_FACES + 1


@pytest.mark.parametrize(
    ("values", "brightness"),
    [
        ({}, 0.807),
        ({"sheet": "lenticular"}, 0.947),
        ({"index": 3, "z2": 60}, 0.455),
    ],
)
def test_the_trace_level_costs_no_partially_reflected_light(values, brightness, rng):
    """The values are the brightness of the window in white surroundings, by another ray tracer, without a level."""
    scene = Chess(fresnel=True, **values)
    P = rng.uniform(-1.2, 1.2, (20_000, 2)) @ (1, 1j)  # not close to the frame, which is black
    found = scene.trace(scene.camera.through(P), survey.max_trace_level(scene), partial=rng)
    seen = (found.end <= End.BACK) & (found.light >= limits.LEAST_LIGHT)
    assert abs(seen.mean() - brightness) < 0.02


def test_lenses_more_than_a_pitch_from_those_opposite_are_warned_of():
    values = {"sheet": "lenticular", "lenses": 1800, "f_number": 4, "alpha": 138, "aperture": 10}
    scene = Chess(z1=2.1, z2=9, x=1.1, error={"pitch": 0.001, "far_pitch": 0.0016}, **values)
    (L, z1), (radius,) = scene.objects[0], scene.radii
    error = px(abs(traced_image(scene).position - scene.apparent_position(L, z1)), scene.view)
    assert 9 < error < warnings.possible_error(scene, L, z1, radius) < 20


def said(scene, rendering=None):
    return " ".join(text for _, text in warnings.warnings(scene, rendering))


def test_no_warning_without_cause():
    commented = PieceFile("own.inc", "// without texture { }\n#declare Piece = sphere { <0, 0.5, 0>, 0.3 }")
    for scene, rendering in (
        *((scene, Rendering(quality="draft")) for scene in (Chess(predicted_image=True), Spheres())),
        (Chess(sheet="ideal", alpha=0, z2=1), None),
        (Chess(sheet="single", z2=2), None),
        (Chess(alpha=0, error={"turn": 10}), None),  # an error turns the sheets apart
        (Chess(alpha=2, prisms=12, z1=3), None),  # the bands of few prisms do not stand out
        (Chess(piece=commented), Rendering(renderer="gl")),
        (Chess(prisms=400), Rendering(quality="standard")),  # antialiasing
    ):
        assert not said(scene, rendering), scene


@pytest.mark.parametrize(
    ("scene", "rendering", "words"),
    [
        (Chess(z2=2), None, ["z2 = 2", "13.1 % of the window", "stray light", "25 %"]),
        (Chess(sheet="lenticular", glass="N-SF11", z2=2), None, ["glass = N-SF11", "designed path"]),
        (Chess(z2=20, eye=(0, 7.97)), None, ["z2 = 20", "an eye at 0,7.97", "designed path"]),
        (Chess(alpha=-7.9), None, ["alpha = -7.9", "within 8 degrees", "dark bands"]),
        (Chess(alpha=-20, error={"turn": 10}), None, ["alpha + 2 turn = 0: within 8 degrees", "dark bands"]),
        (Chess(predicted_image=True, prisms=12, z1=3), None, ["predicted_image", "up to 137 pixels", "prisms' size"]),
        (
            Chess(piece=PieceFile("own.inc", "#declare Piece = sphere { 0, 0.3 pigment { rgb 1 } }")),
            Rendering(renderer="gl"),
            ["renderer = gl", "textures in 'own.inc'", "--renderer povray"],
        ),
        (
            Chess(prisms=400),
            Rendering(size=(320, 240), antialias="off"),
            ["prisms = 400", "0.49 pixels", "1.2 pixels", "noise"],
        ),
    ],
)
def test_each_limit_warns_in_words(scene, rendering, words):
    text = said(scene, rendering)
    assert all(word in text for word in words), text
    assert "index" not in text  # the name of a glass states it


def test_settings_follow_the_maps():
    level = survey.max_trace_level
    assert 7 == level(Chess(z2=75)) < level(Chess(z2=6)) < level(Chess(z2=2)) < 62
    assert level(Chess(z2=60, z1=40, eye=(0, 8.67))) > 20  # an eye aside looks aslant, however far
    assert level(Chess(sheet="single")) < level(Chess())
    assert level(Chess(sheet="ideal")) == level(Chess(sheet="none")) == 5
    # POV-Ray's tolerances: finer prisms in a larger scene, which must not end before its farthest object
    assert (Chess().tile, Chess(prisms=3000).tile, Chess(sheet="ideal", prisms=3000).tile) == (1000, 1200, 1000)


@pytest.mark.parametrize("sheet", ["ideal", "detailed", "single", "mirror", "lenslets", "lenticular", "refraction"])
def test_an_object_very_far_away_appears_where_a_far_one_does(sheet):
    """No number overflows on the way."""
    scene, slope = Chess(alpha=60, sheet=sheet), 0.1 + 0.2j
    for z1 in (1e100, 1e140):
        assert scene.apparent_position(z1 * slope, z1) == pytest.approx(scene.apparent_position(1e12 * slope, 1e12))
        (nu, M), (far_nu, far_M) = scene.nu_and_M(z1), scene.nu_and_M(1e12)
        assert (nu, M * z1) == pytest.approx((far_nu, far_M * 1e12), nan_ok=True)
