"""Other ideal sheets in scenes: what they may be, what the eye sees through them, the cells of their camera."""

import numpy as np
import pytest
from conftest import landing, refusal, seen_through_other_sheets, some

from povgen import Chess, MovieSpec, Spheres, limits
from povgen.scene import warnings
from povgen.scene.cells import camera_cells, jumps
from povgen.settings import Rendering
from povgen.video import caption_strips, caption_texts, overlay

SHEETS = [
    {"sheet": "lens", "focal_length": 5},
    {"sheet": "glens", "focal_length": 10, "object_focal_length": 14},
    {"sheet": "twist", "alpha": 30, "twist": 20},
    {"sheet": "view-rotator", "alpha": 66, "view_distance": 2},
    {"sheet": "law", "law": "x + k*sin(2*X)*z, y + k*sin(2*Y)*z, z", "parameter": {"k": 0.05}},
    {"sheet": "axis", "alpha": 30, "axis": (0.2, 0.4, 1)},
    {"sheet": "refraction", "alpha": 40, "ratio": 0.7},
    {"sheet": "lenslets", "alpha": 180, "ratio": 1.4},
    {"sheet": "mirror", "alpha": 70},
]


def test_they_contain_the_rotating_sheet_and_no_sheet():
    right = Chess(sheet="ideal", alpha=50)
    for scene in (
        Chess(sheet="axis", axis="0,0,0.5", alpha=50),
        Chess(sheet="refraction", ratio=1, alpha=50),
        Chess(sheet="lenslets", ratio=1, alpha=50),
    ):
        assert scene.apparent_position(scene.L, 2) == pytest.approx(right.apparent_position(right.L, 2))
        assert caption_texts.facts(scene)["alpha"] == "50°"
    none = Chess(sheet="none")
    for sheet in ("axis", "refraction", "lenslets"):
        scene = Chess(sheet=sheet, alpha=0)
        assert scene.apparent_position(scene.L, 2) == pytest.approx(none.apparent_position(none.L, 2))


def test_one_prism_sheet_of_fine_prisms_is_a_mirror():
    prisms = Chess(sheet="single", prisms=3000)
    mirror = Chess(sheet="mirror", alpha=0)
    assert mirror.apparent_position(0.3 + 0.2j, 2) == pytest.approx(prisms.apparent_position(0.3 + 0.2j, 2), abs=0.001)


def test_lenslets_form_an_image_of_every_point():
    """The focal length on the eye's side over that on the object's scales its depth. The movie moves this image."""
    for eye in ((0, 0), (0.4, -0.3)):
        scene = Chess(sheet="lenslets", alpha=180, ratio=0.8, eye=eye)
        L, z1 = np.array([0.1, 0.5j]), np.array([2.0, 3])
        seen_before_window = scene.E + (L - scene.E) * 6 / (6 - z1 / 0.8)  # an object there, without lenslets
        np.testing.assert_allclose(scene.apparent_position(L, z1), seen_before_window, rtol=1e-12)
    movie = MovieSpec.load("lenslets").scenes("standard")
    distances = [scene.z1 / scene.ratio for scene in movie]
    assert {scene.alpha for scene in movie} == {180} and (max(distances), min(distances)) == pytest.approx((2 / 0.7, 1))


@pytest.mark.parametrize("values", SHEETS, ids=lambda values: values["sheet"])
def test_the_eye_sees_a_point_where_its_ray_meets_it(values, rng):
    """And only if the ray passes the window, and the front and the back of the frame."""
    scene = Spheres(z1=3, eye=(0.3, -0.2), **values)
    P = rng.uniform(-1.7, 1.7, 60) + 1j * rng.uniform(-1.7, 1.7, 60)
    slope = scene.sheets[0].slope((P - scene.E) / 6, P)
    position, visible = scene.seen(P + 3 * slope, 3)
    assert position == pytest.approx(P, abs=1e-7)
    points = np.array([P - 0.15 * (P - scene.E) / 6, P, P + 0.15 * slope])
    assert (visible == (np.maximum(abs(points.real), abs(points.imag)) < 1.5).all(0)).all()
    assert 10 < visible.sum() < 55 and (scene.visible(P + 3 * slope, 3) == visible).all()
    L, z1 = np.array([0.1, 0.2j])[:, None], np.array([1.0, 2, 3])
    both = scene.apparent_position(L, z1)
    assert both.shape == (2, 3) and both[1, 2] == pytest.approx(scene.apparent_position(0.2j, 3.0))


@pytest.mark.parametrize("sheet", [each for each in SHEETS if "alpha" in each], ids=lambda sheet: sheet["sheet"])
def test_alpha_can_be_an_array(sheet):
    scene, alphas, L = Chess(**sheet), np.array([[-20.0], [10], [170]]), np.array([0.1j, 0.3])
    places, visible = scene.seen(L, 2, alphas)
    one = [[Chess(**sheet | {"alpha": alpha}).seen(point, 2) for point in L] for alpha in alphas[:, 0]]
    np.testing.assert_allclose(places, [[place for place, _ in row] for row in one], rtol=1e-9)
    assert (visible == [[seen for _, seen in row] for row in one]).all()


def test_what_the_eye_sees_has_an_apparent_position(rng):
    """Of several paths it is the one nearest to the middle of the window, so that no other one is seen alone."""
    other = count = 0
    for scene, L, P in seen_through_other_sheets(rng):
        found = scene.apparent_position(L, scene.z1)
        assert landing(scene, found) == pytest.approx(L, rel=1e-7, abs=1e-7 * (scene.z1 + scene.z2)), scene
        far, as_far = (np.maximum(abs(place.real), abs(place.imag)) for place in (found, P))
        assert (far < as_far + 1e-5).all(), scene
        other += (abs(found - P) > 1e-3).sum()
        count += len(L)
    assert count > 1000 and other > 5


BUMP = "x + k*X/sqrt(X*X + Y*Y + q), y + k*Y/sqrt(X*X + Y*Y + q), z"
WAVES = "x + k*sin(m*X)*z, y + k*sin(m*Y)*z, z"
JUMP = "x + k*X/abs(X)*z, y + k*max(Y - q, 0.0)*z, z"
SADDLE = "x + k*X*Y*z, y + k*(X*X - Y*Y)*z, z"
HOLE = "x, y, z*sqrt(1 - (X*X + Y*Y)/m) + k*X"


def of_law(law, **parameter):
    return {"sheet": "law", "law": law, "parameter": parameter}


def through_windows(scene, P):
    """Return where rays from the eye through points P (n,) of ideal windows end, and whether they pass all frames."""
    at, slope, z, inside = P, (P - scene.E) / scene.z2, 0.0, np.full(P.shape, True)
    for there, sheet in zip(scene.places, scene.sheets, strict=True):
        at, z = at + (there - z) * slope, there
        behind = sheet.slope(slope, at)
        for place in (at - scene.depth / 2 * slope, at, at + scene.depth / 2 * behind):
            inside &= np.maximum(abs(place.real), abs(place.imag)) < scene.aperture / 2
        slope = behind
    return at + scene.distances[0] * slope, inside


def test_no_path_through_laws_is_missed(rng):
    """No ray that passes the windows is nearer to the middle than the path that is found to its end."""
    found = 0
    laws = [BUMP, WAVES, JUMP, SADDLE, HOLE]
    for number in range(24):
        window = []
        for z in (0, *np.cumsum(rng.uniform(0.5, 3, number % 3))):
            k, m, q = rng.uniform([-0.6, 2, 0.003], [0.6, 8, 0.5])
            law = laws[rng.integers(len(laws))]
            window.append({**of_law(law, k=k, m=m, q=q), "z": z})
        first = {name: value for name, value in window[0].items() if name != "z"}
        scene = Spheres(
            window=window[1:], z1=rng.uniform(1, 8), z2=rng.uniform(1, 9), eye=rng.uniform(-1, 1, 2), **first
        )
        P = rng.uniform(-1.4, 1.4, (300, 2)) @ [1, 1j]
        L, passes = through_windows(scene, P)
        L, P = (each[passes][:8] for each in (L, P))
        place, visible = scene.seen(L, scene.distances[0])
        assert visible.all(), scene
        assert through_windows(scene, place)[0] == pytest.approx(L, rel=1e-7, abs=1e-7)
        far, as_far = (np.maximum(abs(each.real), abs(each.imag)) for each in (place, P))
        assert (far < as_far + 1e-5).all(), scene
        found += len(L)
    assert found > 100


def test_an_object_whose_edge_alone_is_seen_is_marked():
    """No light from the sphere's centre reaches the eye, but light from 0.024 tiles beside it does."""
    scene = Spheres(sheet="axis", axis=(0, -0.7, -0.6), alpha=180, z2=1, eye=(0, -1.5), line=(0, 2.6), z1=3)
    (place,) = overlay.positions(scene)
    assert 0 < abs(landing(scene, np.array([place]))[0] - scene.L) < 0.025 < scene.radius(scene.z1)
    assert not [*warnings.warnings(scene, Rendering(overlay=True))]


# Of the three paths to L, two are nearly the same; the third one is far outside the window.
CAUSTIC = {"sheet": "refraction", "alpha": -161.5, "ratio": 3.077, "eye": (-3.31, -2.94), "z1": 35.9, "z2": 4.27}


def test_both_paths_close_to_a_caustic_are_found_and_then_none():
    scene, P = Spheres(**CAUSTIC), 0.224 + 0.558j
    L = landing(scene, np.array([P]))[0]
    at = scene.apparent_position(L, scene.z1)
    assert abs(at - P) < 0.2 and landing(scene, np.array([at])) == pytest.approx(L)
    beyond = L + np.linspace(-3, 3, 31)[:, None] + 1j * np.linspace(-3, 3, 31)
    exact, near = (scene.apparent_position(beyond, scene.z1, near=distance) for distance in (0, 0.5))
    gone = (abs(exact) > 5) & (abs(near) < 5)
    assert gone.sum() > 12
    miss = abs(landing(scene, near[gone]) - beyond[gone])
    assert 0.1 < miss.max() <= 0.5 + 1e-9
    np.testing.assert_allclose(near[abs(exact) < 2], exact[abs(exact) < 2], atol=1e-12)


@pytest.mark.parametrize("values", some(SHEETS, 3), ids=lambda values: values["sheet"])
def test_overlays_are_drawn(values):
    scene = Chess(**values)
    ((parts, _),) = overlay.loci(scene, 0.02)
    assert abs(np.concatenate(parts) - overlay.positions(scene)[0]).min() < 0.02
    assert "P at all distances z₁" in dict(overlay.legend(scene, Rendering(overlay=True)))
    assert "M" not in caption_texts.facts(scene)
    assert ("ratio" in caption_texts.facts(scene)) == (scene.sheet in ("refraction", "lenslets"))
    assert not [*warnings.warnings(scene, Rendering(overlay=True, caption="full"))]


def shown_aside(scene, cells):
    """By how many pixels of 1280x960 the camera's interpolation shows an object aside, at the middle of diagonals.

    In up to 24 x 24 of the cells, with those at the window's edges.
    """
    side = np.linspace(-0.5, 0.5, cells + 1) * scene.aperture
    P = side + 1j * side[:, None]
    x, y = (P - scene.E).real, (P - scene.E).imag
    unit = scene.sheets[0].bend(np.stack((x, y, np.full(P.shape, scene.z2)), -1), P)
    d = unit[:-1, :-1] + unit[1:, 1:]
    middle = (P[:-1, :-1] + P[1:, 1:]) / 2
    some = np.unique(np.linspace(0, cells - 1, 24).astype(int))
    middle, d = (each[np.ix_(some, some)] for each in (middle, d))
    L = middle + scene.z1 * (d[..., 0] + 1j * d[..., 1]) / d[..., 2]
    aside = abs(scene.apparent_position(L, scene.z1) - middle) / scene.view * 960
    return np.nanmax(aside), np.nanquantile(aside, 0.98)


@pytest.mark.parametrize("eye", [(0, 0), (0.4, -0.3)])
@pytest.mark.parametrize("values", [*SHEETS, {"sheet": "ideal", "alpha": 162}], ids=lambda values: values["sheet"])
def test_the_camera_has_no_more_cells_than_it_needs(values, eye):
    scene = Chess(eye=eye, **values)
    cells = camera_cells(scene)
    smooth = scene.sheet not in ("twist", "law", "view-rotator")
    assert (cells == 1) == (eye == (0, 0) and scene.sheet not in ("refraction", "twist", "law"))
    most, usual = shown_aside(scene, cells)
    assert (most if smooth else usual) < 0.033 or cells == limits.MAX_CELLS
    if cells > 1:
        assert shown_aside(scene, 2 * cells // 3)[0] > 0.03


@pytest.mark.parametrize(
    ("law", "share", "said"),
    [
        ("x - 0.1*X/abs(X)*z, y, z", 0.01, False),
        ("x + 0.1*sin(50*X)/abs(sin(50*X)), y, z", 0.47, True),  # 47 jumps
        (
            "x, y, (X - 0.015)*(X - 0.015) + (Y - 0.015)*(Y - 0.015) - 0.0001",
            0.0006,
            False,
        ),  # a dark hole between the corners of cells
        ("x, y, sin(3*X)", 0, False),  # the edges of dark parts are no jumps
    ],
)
def test_cells_in_which_rays_jump(law, share, said):
    scene = Chess(sheet="law", law=law)
    assert jumps(scene).share == pytest.approx(share, rel=0.5)
    assert camera_cells(scene) == 100 or not share
    messages = [text for _, text in warnings.warnings(scene, Rendering(size=(1280, 960)))]
    assert any("neighbouring rays differ much" in text for text in messages) == said
    assert not any("neighbouring rays" in text for _, text in warnings.warnings(scene, Rendering(renderer="gl")))


def test_a_small_circle_of_light_is_not_missed():
    """Light passes within 0.18 tiles of the eye's foot: between the corners of 16 cells across the window."""
    scene = Spheres(sheet="refraction", ratio=0.1, z2=1.8, eye=(0.05, -1.4), line=(0.05, -1.4), z1=3)
    assert camera_cells(scene) == 100 and camera_cells(Chess(sheet="axis", alpha=180)) == 1  # this one sees no light
    assert overlay.positions(scene) and not [*warnings.warnings(scene, Rendering(overlay=True))]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"sheet": "axis", "axis": (0, 0, 0)}, "axis = (0, 0, 0): too short"),
        ({"window": "z=2,sheet=lens"}, "window: prisms or lenses stand in front of an ideal sheet"),
        ({"sheet": "lens", "focal_length": 0.05}, "focal_length = 0.05: too close to 0"),
        ({"sheet": "axis", "predicted_image": True}, "the prediction is for two sheets, but sheet = 'axis'"),
    ],
)
def test_sheets_that_cannot_be_are_refused(values, words):
    assert words in refusal(lambda: Chess(**values))


def test_captions_name_the_parameters_in_words():
    scene = Chess(sheet="twist", twist=20, window="z=1,sheet=lens,focal_length=4.5")
    assert caption_texts.facts(scene)["twist"] == "20°/tile"
    plain = np.zeros((240, 640, 3), np.uint8)
    with pytest.MonkeyPatch.context() as patch:
        texts = []
        patch.setattr(caption_strips, "write", lambda draw, x, middle, text, size: texts.append(text))
        overlay.annotated(plain, scene, Rendering(caption="full"))
    assert "focal length = 4.5 tiles" in texts and "α = 66°" in texts


def test_a_movie_of_several_sheets_states_no_angle_of_a_lens():
    scenes = [Chess(sheet=sheet) for sheet in ("ideal", "mirror", "lens")]
    said = [caption.texts for caption in caption_texts.captions(scenes, Rendering(caption="short"))]
    assert said == [["rays turned by α = 66°"], ["mirror line at 33°"], [""]]
    windows = {"sheet": "ideal", "alpha": 30}, {"sheet": "lens", "focal_length": 3}
    scenes = [Chess(sheet="ideal", window=[{"z": 2, **window}]) for window in windows]
    said = [caption.texts for caption in caption_texts.captions(scenes, Rendering(caption="short"))]
    assert said == [["α₂ = 30°", ""], ["", "focal length₂ = 3 tiles"]]


@pytest.mark.parametrize(
    ("law", "parts"),
    [
        ("-y, x, z", "straight prisms"),
        ("y, x, z", "straight prisms"),
        ("cos(X)*x + sin(X)*y, cos(X)*y - sin(X)*x, z", "prisms that change with the place"),
        ("x - X*z/4, y - Y*z/4, z", "a lens"),
        ("x + sin(X)*z/9, y, z", "a lens"),
        ("x + 0.1*z, y, z", "a wedge"),
        ("x - Y*z/9, y + X*z/9, z", "wedges that change with the place"),
        ("-y - Y*z/9, x, z", "straight prisms and wedges that change with the place"),
        ("x/2, -y/3, z", "lenslets and straight prisms"),
        ("-x/2, -y/2, z", "lenslets"),
        ("2*x - X*z, 2*y - Y*z, z", "lenslets and a lens"),
        ("x/2 + 0.1*z, y/2, z", "lenslets and a wedge"),
        ("-y - X*z/4, x - Y*z/4, z", "straight prisms and a lens"),
        ("0.8776*x - 0.4794*y, 0.4794*x + 0.8776*y, z", "straight prisms"),  # rounded
        ("0.8776*x - 0.4794*y - X*z/4, 0.4794*x + 0.8776*y - Y*z/4, z", "straight prisms and a lens"),
        ("0.999*x, 0.999*y, z", "lenslets"),
        ("x, x, z", "nothing known"),
        ("x*(1 + X*X), y, z", "nothing known"),
        ("x, y, z + x/5", "nothing known"),
        ("x, y, -z", "nothing known"),
    ],
)
def test_what_can_be_built_follows_from_the_law(law, parts):
    found = Chess(sheet="law", law=law).sheets[0].buildable()
    assert found.parts == parts and found.reason and found.page.startswith("docs/")
    assert ("the law differs from this by up to " in found.reason) == ("0.8776" in law)
    assert ("concave" in found.reason) == law.startswith(("x/2 +", "2*x", "0.999"))


def test_the_first_picture_of_a_kind_shows_something_of_its_own():
    """At 66 degrees the sheet `axis` would show the sky alone. `profile` differs from `lenticular`."""
    scene = Chess(sheet="axis")
    assert (scene.alpha, scene.axis) == (15, (0, 1, 0)) and scene.seen(*scene.objects[0])[1]
    assert Chess(sheet="axis", alpha=40).alpha == 40 and scene.replace(sheet="ideal").alpha == 66
    assert (
        abs(Chess(sheet="profile").sheets[0].thin.transfer - Chess(sheet="lenticular").sheets[0].thin.transfer).max()
        > 0.1
    )
