"""Captions and overlays: they tell what the equations say, where it is seen, and spoil nothing else."""

from math import radians

import imageio.v3 as iio
import numpy as np
import pytest

from povgen import Chess, MovieSpec, Spheres, annotate, instruments, movie, povray, render, rotation, verify
from povgen.instruments import Positions
from povgen.rendering import Rendering

BLANK = {size: np.full((size[1], size[0], 3), 120, np.uint8) for size in ((640, 480), (320, 240), (64, 48))}


def drawn(scene, size=(640, 480), **options):
    return annotate.annotated(BLANK[size], scene, Rendering(size=size, **options)).astype(int)


def yellow(picture):
    """Where the marks are, as seen in the plane z = 0."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    place = instruments.pixels(picture.shape[1::-1])
    return place[(red > 200) & (green > 190) & (blue < 110)]


@pytest.mark.parametrize("sheet", ["ideal", "detailed", "single", "none"])
@pytest.mark.parametrize("alpha, z1", [(66, 2), (-120, 9)])
def test_the_mark_is_where_the_piece_is_predicted(sheet, alpha, z1):
    scene = Chess(sheet=sheet, alpha=alpha, z1=z1, offset=(0.4, -1))
    marks = yellow(drawn(scene, overlay=True))
    pixel = scene.view_height / 480
    assert len(marks) > 20 and abs(marks.mean() - scene.seen(scene.L, scene.z1)) < 0.5 * pixel


def test_every_sphere_has_its_mark_on_the_circle():
    scene = Spheres(alpha=90, z1=[1.5, 6, 24])
    marks = yellow(drawn(scene, overlay=True))
    (line, _), *others = annotate.loci(scene)
    assert not others  # no circle of constant r for each
    for place in annotate.positions(scene):
        assert abs(marks - place).min() < scene.view_height / 480 * 4
        assert abs(line - place).min() < 0.01
    ideal = Spheres(alpha=60, sheet="ideal", z1=[6])
    (line, _), (turned, _) = annotate.loci(ideal)
    # constant alpha: L and E are seen at one angle from everywhere; constant r: distances to them are in one ratio
    assert np.allclose(np.angle((line - ideal.E) / (ideal.L - line)), radians(60), atol=1e-9)
    turned = turned[np.isfinite(turned)]
    assert np.allclose(abs(turned - ideal.E) / abs(turned - ideal.L), 1)


def test_a_single_sheet_shows_a_place_where_it_is_marked():
    scenes = [Positions(sheet="single", z1=z1, L=0.5 - 0.3j, extent=0.2, prisms=400) for z1 in (1, 3, 12)]
    for scene, seen in verify.located(scenes, (640, 480)):
        assert verify.px(abs(seen.place - scene.seen(scene.L, scene.z1))) < 1


def test_the_overlay_leaves_the_rest_of_the_picture():
    scene = Chess(sheet="ideal", alpha=90)
    changed = (drawn(scene, overlay=True) != 120).any(-1)
    place = instruments.pixels((640, 480))[changed]
    curves = np.concatenate([line for line, _ in annotate.loci(scene)])
    curves = curves[np.isfinite(curves)]
    assert 500 < changed.sum() < 20000
    assert max(abs(curves - z).min() for z in place[::7]) < 0.06


def test_the_caption_tells_what_the_equations_say():
    assert annotate.facts(Chess(alpha=66)) == {
        "alpha": "66°",
        "z1": "2",
        "z2": "6",
        "r": "3",
        "nu": f"{np.degrees(rotation.nu(3, radians(66))):.1f}°",
        "M": f"{rotation.M(3, radians(66)):.3g}",
    }
    several = annotate.facts(Spheres(alpha=90, z1=[3, 6, 12]))
    assert several["z1"] == "3 to 12" and several["r"] == "2 to 0.5" and several["nu"] == "26.6 to 63.4°"
    assert list(annotate.facts(Chess(sheet="none"))) == ["z1", "z2", "r"]


@pytest.mark.parametrize("sheet", ["ideal", "detailed"])
def test_at_the_pole_it_says_so(sheet):
    scene = Chess(alpha=180, z1=6, z2=6, sheet=sheet)
    told = annotate.facts(scene)
    assert told["M"] == "infinite" and told["nu"] == "?°"
    assert drawn(scene, caption=True, overlay=True).shape == (480, 640, 3)
    drawn(Chess(alpha=179.99999, z1=6, z2=6, sheet=sheet), overlay=True)


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


def test_a_movies_caption_stands_still():
    """What does not change from frame to frame is drawn in the same place."""
    strips = [drawn(Chess(alpha=alpha), caption=True)[-40:] for alpha in (7, 178.5)]
    changed = (strips[0] != strips[1]).any((0, 2))
    alpha, distances, rest = changed[:130], changed[130:400], changed[400:]
    assert alpha.any() and rest.any() and not distances.any()
    assert (strips[0][:, 130:400] == 255).any()


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
