"""Captions and overlays: they tell what the equations say, where it is seen, and spoil nothing else."""

import subprocess
import sys
from math import radians

import imageio.v3 as iio
import numpy as np
import pytest

from povgen import Chess, MovieSpec, Spheres, movie, render
from povgen.measure import probes, verify
from povgen.measure.probes import Positions
from povgen.optics import rotation
from povgen.rendering import povray
from povgen.scene import prediction
from povgen.settings import Rendering
from povgen.video import overlay

BLANK = {size: np.full((size[1], size[0], 3), 120, np.uint8) for size in ((640, 480), (320, 240), (64, 48))}


def drawn(scene, size=(640, 480), **options):
    return overlay.annotated(BLANK[size], scene, Rendering(size=size, **options)).astype(int)


def yellow(picture):
    """Where the marks are, as seen in the plane z = 0."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    place = probes.pixels(picture.shape[1::-1])
    return place[(red > 200) & (green > 190) & (blue < 110)]


@pytest.mark.parametrize("sheet", ["ideal", "detailed", "single", "none"])
@pytest.mark.parametrize("alpha, z1", [(66, 20), (-120, 9)])
def test_the_mark_is_where_the_piece_is_predicted(sheet, alpha, z1):
    scene = Chess(sheet=sheet, alpha=alpha, z1=z1, offset=(0.4, -0.73))
    marks = yellow(drawn(scene, overlay=True))
    pixel = scene.view_height / 480
    assert len(marks) > 20 and abs(marks.mean() - scene.apparent_position(scene.L, scene.z1)) < 0.5 * pixel


def test_every_sphere_has_its_mark_on_the_circle():
    scene = Spheres(alpha=90, z1=[1.5, 6, 24])
    marks = yellow(drawn(scene, overlay=True))
    ((line,), _), *others = overlay.loci(scene)
    assert not others  # no circle of constant r for each
    assert len(overlay.positions(scene)) == 3
    for place in overlay.positions(scene):
        assert abs(marks - place).min() < scene.view_height / 480 * 4
        assert abs(line - place).min() < 0.01
    ideal = Spheres(alpha=60, sheet="ideal", z1=[6])
    ((line,), _), (turned, _) = overlay.loci(ideal)
    # constant alpha: L and E are seen at one angle from everywhere; constant r: distances to them are in one ratio
    assert np.allclose(np.angle((line - ideal.E) / (ideal.L - line)), radians(60), atol=1e-9)
    turned = np.concatenate(turned)
    assert np.allclose(abs(turned - ideal.E) / abs(turned - ideal.L), 1)


def near(places, reach, size=(640, 480)):
    """Which pixels have one of the places within a reach, pixels."""
    mask = np.zeros(size[::-1], bool)
    tile = size[1] / Chess.view_height
    x, y = size[0] / 2 + places.real * tile, size[1] / 2 - places.imag * tile
    mask[y.astype(int), x.astype(int)] = True
    grown = np.zeros_like(mask)
    steps = np.arange(-int(reach), int(reach) + 1)
    for dy, dx in ((dy, dx) for dy in steps for dx in steps if np.hypot(dx, dy) <= reach):
        grown |= np.roll(mask, (dy, dx), (0, 1))
    return grown


def dense(first, last, *about):
    """Parameters between two ends, the denser the nearer to where a curve may pass through infinity."""
    steps = np.geomspace(1e-12, 1, 60_000) * (last - first)
    found = np.concatenate([np.linspace(first, last, 200_000), *(at + s * steps for at in about for s in (-1, 1))])
    return found[(first < found) & (found < last)]


@pytest.mark.parametrize(
    "scene, z1, alphas",
    [
        # alpha changes: one branch of a hyperbola in the window, one beyond
        (Spheres(alpha=100, z1=[6], offset=(0.1, 0.05)), 0, (180,)),
        # z1 changes: both branches in the window
        (Spheres(z1=[6], offset=(0.1, 0.05), sheet="single"), 6, None),
        # a straight line through infinity, but not from L to E
        (Spheres(alpha=180, sheet="ideal"), 6, None),
        # the pole within a thousandth of a tile and of a degree, and all near the eye's axis
        (Spheres(alpha=180, z1=[6], offset=(1e-3, 2e-3), prisms=3000), 6, (180,)),
        (Chess(prisms=5, z1=9, z2=4), 0, (180,)),
    ],
)
def test_curves_are_whole_and_never_cross_infinity(scene, z1, alphas, monkeypatch):
    """Every visible point of the true curve is drawn, and nothing farther from it than the line is wide."""
    distances = dense(scene.depth / 2, 1e4 * scene.z2, scene.depth / 2, z1)
    true = [(scene.apparent_position(scene.L, distances), scene.visible(scene.L, distances))]
    if alphas:
        angles, at = dense(-180, 180, -180, *alphas), scene.distances[0]
        true.append((scene.apparent_position(scene.L, at, angles), scene.visible(scene.L, at, angles)))
    places = np.concatenate([place[visible] for place, visible in true])
    monkeypatch.setattr(overlay, "positions", lambda scene: [])
    changed = (drawn(scene, overlay=True) != 120).any(-1)
    assert changed.sum() > 500
    assert not (near(places, 0) & ~changed).any()
    assert not (changed & ~near(places, 1.1 * 480 / 180 + 1.5)).any()


@pytest.mark.parametrize(
    "values, most",
    [
        ({"sheet": "ideal", "alpha": 120, "E": 0.9 - 0.7j}, 0),
        ({"sheet": "none", "E": 0.9 - 0.7j}, 0),
        ({"sheet": "detailed", "alpha": 90, "E": -0.8 + 0.3j}, 0.03),
        ({"sheet": "detailed", "alpha": 66, "E": 0.5j, "prisms": 20}, 0.03),
        ({"sheet": "single", "E": 0.3 + 0.9j}, 0),
    ],
)
def test_what_is_said_to_be_visible_is_what_is_rendered(values, most):
    """By every pixel that shows a place in its designed position, and by every place that should be shown."""
    scene = Positions(z1=2, z2=3.5, L=0.3 - 0.2j, extent=4, **values)
    (told,) = probes.decoded([scene], (160, 120))
    inside, _ = probes.rays(scene, (160, 120))
    shown, place = scene.L + verify.transverse(told), probes.pixels((160, 120))
    coarse = 2.5 * scene.pitch if scene.sheet == "detailed" else 0  # what differs from prism to prism
    designed = inside & (abs(scene.apparent_position(shown, 2) - place) < 0.04 + coarse)
    hidden = designed & ~scene.visible(shown, 2)
    assert designed.sum() > 1500 and hidden.sum() <= most * designed.sum()
    grid = 4 * place[scene.visible(4 * place, 2)]
    nearest = abs(shown[designed] - grid[:, None]).min(1)
    assert len(grid) > 100 and np.mean(nearest > 0.15 + 2 * coarse) <= most


@pytest.mark.parametrize(
    "scene",
    [
        Chess(alpha=150, prisms=20),  # the foot is seen below the window
        Chess(sheet="none", z1=6, offset=(2.38, -1)),  # behind the frame's side, which is deep
        Spheres(sheet="none", z1=[1], z2=0.5, offset=(-3, 0)),
    ],
)
def test_no_mark_where_the_frame_hides_the_object(scene):
    picture = drawn(scene, overlay=True)
    assert not len(yellow(picture)) and not overlay.positions(scene)
    drawn_at = probes.pixels((640, 480))[(picture != 120).any(-1)]
    front = scene.E + (drawn_at - scene.E) * (1 - scene.depth / 2 / scene.z2)
    reach = np.maximum(abs(front.real), abs(front.imag)).max(initial=0)
    assert reach < scene.window / 2 + 4 * scene.view_height / 480  # half a line's width


def test_a_single_sheet_shows_a_place_where_it_is_marked():
    scenes = [Positions(sheet="single", z1=z1, L=0.5 - 0.3j, extent=0.2, prisms=400) for z1 in (1, 3, 12)]
    for scene, seen in verify.located(scenes, (640, 480)):
        assert verify.px(abs(seen.position - scene.apparent_position(scene.L, scene.z1))) < 1


def test_the_overlay_leaves_the_rest_of_the_picture():
    scene = Chess(sheet="ideal", alpha=90)
    changed = (drawn(scene, overlay=True) != 120).any(-1)
    place = probes.pixels((640, 480))[changed]
    curves = np.concatenate([piece for pieces, _ in overlay.loci(scene) for piece in pieces])
    assert 500 < changed.sum() < 20000
    assert max(abs(curves - z).min() for z in place[::7]) < 0.06


def test_the_caption_tells_what_the_equations_say():
    assert overlay.facts(Chess(alpha=66, sheet="ideal")) == {
        "alpha": "66°",
        "z1": "2",
        "z2": "6",
        "r": "3",
        "nu": f"{np.degrees(rotation.nu(3, radians(66))):.1f}°",
        "M": f"{rotation.M(3, radians(66)):.3g}",
    }
    assert list(overlay.facts(Chess(sheet="none"))) == ["z1", "z2", "r"]


@pytest.mark.parametrize(
    "scene, told",
    [
        (Spheres(alpha=90, sheet="ideal", z1=[3, 12, 6]), ["3 to 12", "0.5 to 2", "26.6 to 63.4°", "0.447 to 0.894"]),
        (Spheres(alpha=90, z1=[20, 2, 60]), ["2 to 60", "0.1 to 3", "18.1 to 84.3°", "0.0996 to 0.961"]),
        (Spheres(alpha=-90, sheet="ideal", z1=[6, 6]), ["6", "1", "-45.0°", "0.707"]),
        (Spheres(alpha=270, sheet="ideal", z1=[3, 6]), ["3 to 6", "1 to 2", "-45.0 to -26.6°", "0.707 to 0.894"]),
        # beyond the pole, on it and before it
        (
            Spheres(alpha=180, sheet="ideal", z1=[9, 6, 3]),
            ["3 to 9", "0.667 to 2", "0.0 to 180.0, ?°", "2 to infinite"],
        ),
        (Spheres(alpha=-180, sheet="ideal", z1=[9, 8]), ["8 to 9", "0.667 to 0.75", "-180.0°", "2 to 3"]),
        (Spheres(alpha=180, sheet="ideal", z1=[6]), ["6", "1", "?°", "infinite"]),
        (Chess(alpha=180, sheet="ideal", z1=6), ["6", "1", "?°", "infinite"]),
        # light meets the eye's plane in a line or not at all, in a mirrored image
        (Spheres(alpha=180, z1=[9, 6]), ["6 to 9", "0.667 to 1", "180.0, ?°", "2 to 76.4"]),
    ],
)
def test_ranges_are_from_the_least_to_the_greatest(scene, told):
    assert [overlay.facts(scene)[name] for name in ("z1", "r", "nu", "M")] == told


@pytest.mark.parametrize("prisms", [20, 100])
def test_nu_and_M_are_those_of_prisms_of_this_size(prisms):
    scenes = [Positions(prisms=prisms, z1=2, L=L, extent=0.6) for L in (0.25 + 0.3j, -0.3 + 0.1j, 0.2 - 0.3j)]
    a = np.mean([seen.a for _, seen in verify.located(scenes, (320, 240))])
    told = overlay.facts(Chess(prisms=prisms))
    # eqs. 8 and 9 say 15.0 degrees and 0.851
    assert float(told["nu"].removesuffix("°")) == pytest.approx(np.degrees(np.angle(a)), abs=10 / prisms)
    assert float(told["M"]) == pytest.approx(abs(a), abs=0.2 / prisms)


@pytest.mark.parametrize("sheet", ["ideal", "detailed"])
def test_at_the_pole_there_is_nothing_to_mark(sheet):
    assert drawn(Chess(alpha=180, z1=6, z2=6, sheet=sheet), caption=True, overlay=True).shape == (480, 640, 3)
    drawn(Chess(alpha=179.99999, z1=6, z2=6, sheet=sheet), overlay=True)


@pytest.mark.parametrize(
    "scene, options, words",
    [
        (Spheres(), {"overlay": True, "caption": True}, None),
        (Spheres(alpha=175, z1=[2, 5.5]), {}, None),
        (Spheres(alpha=175, z1=[2, 5.5]), {"overlay": True}, "overlay: at alpha = 175 and z1 = 5.5 the prisms' size"),
        (Spheres(alpha=175, z1=[5.5, 2]), {"caption": True}, "caption: at alpha = 175 and z1 = 5.5 the prisms' size"),
        (Chess(prisms=20), {"overlay": True, "caption": True}, "by 34.7 pixels of 1280x960; beyond 8"),
        (Chess(alpha=180, z1=6), {"overlay": True}, "z1 = 6 the prisms' size moves the object infinitely"),
        (
            Spheres(alpha=179.9, sheet="ideal"),
            {"caption": True},
            "z1 = 6 the object is magnified 573 times; beyond 150",
        ),
        (Spheres(sheet="single", z1=[2, 3]), {"overlay": True}, None),
        (Spheres(sheet="single", z1=[2, 5]), {"overlay": True}, "overlay: at z1 = 5 the prisms' size"),
        (Spheres(sheet="single", z1=[2, 5]), {"caption": True}, None),  # it has no nu and no M
        (Spheres(sheet="none", z1=[6]), {"overlay": True}, None),
        (Chess(alpha=179, z1=5, predicted_image=True), {"overlay": True}, "predicted_image, overlay: at alpha = 179"),
    ],
)
def test_predictions_warn_beyond_their_limit(scene, options, words):
    """Whatever shows them, for the object that is farthest beyond it."""
    said = [text for _, text in prediction.warnings(scene, Rendering(**options))]
    assert (len(said) == 1 and words in said[0]) if words else not said


@pytest.mark.parametrize("size", list(BLANK))
def test_the_caption_is_legible_and_whole(size):
    for scene in (Chess(alpha=137.2, z1=1.234), Spheres(alpha=137.2)):
        picture = drawn(scene, size, caption=True)
        rows = np.flatnonzero((picture != 120).any((1, 2)))
        assert rows[-1] == size[1] - 1 and len(rows) == rows[-1] - rows[0] + 1  # a strip at the lower edge
        strip = picture[rows[0] :]
        assert strip.max() > 100 and np.median(strip) < 40  # light on dark
        if size[0] > 64:
            assert strip.max() == 255
            assert (strip[:, [0, -1]] < 40).all()  # no letter touches the edge
            assert len(rows) <= size[1] / 4


@pytest.mark.parametrize(
    "scenes",
    [
        [Chess(alpha=alpha) for alpha in (7, 178.5)],
        [Chess(alpha=180, z1=z1, sheet="ideal") for z1 in (0.6, 6)],
        [Spheres(alpha=alpha, sheet="ideal", z1=[1, 6, 50]) for alpha in (0, 100, 180)],
    ],
)
def test_a_movies_caption_stands_still(scenes, monkeypatch):
    """Every fact begins at the same place in all frames."""
    places = []
    write = overlay.ImageDraw.ImageDraw.text
    monkeypatch.setattr(
        overlay.ImageDraw.ImageDraw, "text", lambda draw, *a, **b: (places.append(a[:1]), write(draw, *a, **b))
    )
    for scene in scenes:
        for size in BLANK:
            drawn(scene, size, caption=True)
    assert len(set(places)) == len(BLANK) * len(overlay.facts(scenes[0]))


def test_a_large_picture_needs_little_memory_more():
    """Than itself, and what is made of it: MiB of the process, at 7680x4320 (95 MiB)."""
    code = """if True:
        import re, numpy
        from povgen import Chess
        from povgen.video import overlay
        from povgen.settings import Rendering
        picture = numpy.full((4320, 7680, 3), 120, numpy.uint8)
        peak = lambda: int(re.search("VmHWM:[^0-9]*([0-9]+)", open("/proc/self/status").read())[1])
        before = peak()
        overlay.annotated(picture, Chess(), Rendering(size=(7680, 4320), overlay=True, caption=True))
        print((peak() - before) / 1024)"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100, check=True)
    assert 50 < float(done.stdout) < 200


def test_annotated_frames_are_made_from_the_same_frame(tmp_path, monkeypatch):
    scene, size = Spheres(sheet="ideal", z1=[3]), (160, 120)
    plain = render(scene, size=size, antialias="off")
    monkeypatch.setattr(povray.Runner, "run", None)  # no need to render again
    both = render(scene, size=size, antialias="off", caption=True, overlay=True)
    assert both.shape == plain.shape and (both != plain).any()
    assert (both == plain).all(-1).mean() > 0.5


def test_a_movie_has_them_too(tmp_path):
    spec = MovieSpec.load("spheres").model_copy(update={"fixed": {"sheet": "ideal"}})
    drawn_over = {"caption": True, "overlay": True}
    made = movie(spec, tmp_path / "a.mp4", quality="draft", size=(320, 240), **drawn_over)
    scene = spec.scenes("draft")[7]
    decoded = iio.imread(made, plugin="FFMPEG", index=7).astype(float)
    with_, without = (render(scene, quality="draft", size=(320, 240), **over) for over in (drawn_over, {}))
    assert np.sqrt(((decoded - with_) ** 2).mean()) < 8 < np.sqrt(((decoded - without) ** 2).mean())
