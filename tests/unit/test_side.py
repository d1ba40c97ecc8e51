"""The side view: everything is where the scene has it, to one scale."""

import numpy as np
import pytest
from conftest import refused

from povgen import Chess, Spheres
from povgen.settings import Rendering
from povgen.video import side, still

SIZE = 640, 480
BETWEEN = slice(44, 138)  # rows without text
TWO = {"alpha": 120, "window": "alpha=120,z=2", "z2": 8, "z1": 2}


def middles(strip, colour):
    """Return the x of each group of columns with this colour, pixels."""
    columns = np.flatnonzero((strip == colour).all(-1).any(0))
    return [group.mean() for group in np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1) if len(group)]


def rays(scene, from_above=False):
    return side._rays(scene, side._shown(scene, from_above)[0][0])


def images(scene):
    return [each.image.z for each in side._shown(scene)[0]]


def test_images_are_where_the_light_comes_together():
    assert images(Chess(alpha=180, z1=2)) == pytest.approx([-2])  # a real image, as far before the window
    assert images(Chess(alpha=0, z1=2)) == pytest.approx([2])
    assert images(Chess(**TWO)) == pytest.approx([-2])
    assert np.isnan(images(Chess(alpha=66))).all()  # light never comes together
    assert np.isnan(images(Chess(sheet="refraction", ratio=0.7))).all()
    assert images(Chess(sheet="view-rotator", alpha=20, view_distance=2)) == pytest.approx([2])  # of this plane
    assert images(Chess(sheet="lenslets", alpha=180, ratio=0.8)) == pytest.approx([-2.5])
    assert images(Chess(sheet="lens", focal_length=1.5)) == pytest.approx([-6])  # 1/2 + 1/6 = 1/1.5
    lens = {"sheet": "lens", "focal_length": 1}
    assert images(Chess(**lens, window={**lens, "z": 4}, z1=2)) == pytest.approx([-2])  # a relay


@pytest.mark.parametrize(
    ("scene", "size"),
    [
        (Chess(sheet="lens", focal_length=1), -1),
        (Chess(sheet="glens"), 1.5),
        (Chess(sheet="lens", focal_length=2, z1=3, window="sheet=lens,focal_length=3,z=1"), -2 / 3),
    ],
)
def test_an_image_has_its_own_size(scene, size):
    """Its tip is where rays from the object's tip meet."""
    (each,), _ = side._shown(scene)
    thing, image = each.thing, each.image
    assert image.tip - image.place == pytest.approx(size * (thing.tip - thing.place))
    for _, ((z0, y0), (z1, y1), *_) in rays(scene):
        assert y0 + (y1 - y0) * (image.z - z0) / (z1 - z0) == pytest.approx(image.tip)
    wide = (side.side_view(scene, *SIZE) == side.IMAGE).all(-1).sum(1)
    assert wide[np.flatnonzero(wide)[-1 if size < 0 else 0]] < wide.max() / 2  # the arrow ends in a point there
    sphere = Spheres(
        **scene.model_dump(include={"sheet", "focal_length", "window", "object_focal_length"}), z1=[scene.z1]
    )
    (each,), _ = side._shown(sphere)
    assert abs(each.image.rim - each.image.place) == pytest.approx(abs(size) * sphere.radii[0])


@pytest.mark.parametrize("scene", [Chess(alpha=180), Chess(**TWO), Chess(alpha=180, z1=3, eye=(0, 0.7), z2=9)])
def test_distances_have_one_scale(scene):
    strip = side.side_view(scene, *SIZE)
    assert strip.shape[1:] == (640, 3) and len(strip) % 2 == 0
    windows, (thing,), (image,) = (middles(strip, colour) for colour in (side.SHEET, side.OBJECT, side.IMAGE))
    (eye, *_) = middles(strip[BETWEEN], (255, 255, 255))
    places = np.array([-scene.z2, *scene.places, scene.places[-1] + scene.z1, *images(scene)])
    pixels = np.array([eye, *windows, thing, image])
    scale = (thing - eye) / (places[-2] - places[0])
    assert abs(pixels - eye - scale * (places - places[0])).max() < 1.5
    column = (strip == side.SHEET).all(-1).any(1)
    assert abs(column.sum() - scale * scene.aperture) < 3  # along y too
    foot = np.flatnonzero((strip == side.OBJECT).all(-1).any(1))[-1]
    middle = np.flatnonzero(column).mean()
    assert abs(foot - middle + scale * scene.L.imag) < 2


@pytest.mark.parametrize("scene", [Chess(sheet="ideal", alpha=180, eye=(0, 0.4)), Chess(sheet="ideal", **TWO)])
def test_rays_from_the_objects_tip_meet_at_the_images(scene):
    (image,) = images(scene)
    heights = []
    for eye, ((z0, y0), (z1, y1), *_, (last, tip)) in rays(scene):
        heights.append(y0 + (y1 - y0) * (image - z0) / (z1 - z0))
        assert (last, tip) == (scene.places[-1] + scene.z1, scene.L + 1j * side.ARROW) and y0 == eye
    assert heights == pytest.approx([tip] * 3)  # the image is upright, and as large as the object


@pytest.mark.parametrize("z", [0.5, 1.5, 2.5, 5])
def test_rays_without_a_common_point_have_none_in_any_view(z):
    found = rays(Chess(sheet="ideal", **{**TWO, "window": f"alpha=120,z={z}"}))
    places = np.array([[y0, y1] for _, ((_, y0), (_, y1), *_) in found])
    part = np.linspace(0, 1, 400)[:, None]
    between = places[:, 0] * (1 - part) + places[:, 1] * part  # from the eye's plane to the first window
    for view in (between.imag, between.real):
        assert len(found) == 3 and np.ptp(view, axis=1).min() > 0.04


def test_a_movie_keeps_its_scale():
    scenes = [Chess(**{**TWO, "window": f"alpha=120,z={z}"}) for z in (0.5, 2, 5)]
    strips = [side.side_view(scene, *SIZE, side.extent(scenes)) for scene in scenes]
    marks = np.array([middles(strip[BETWEEN], (255, 255, 255))[:1] for strip in strips])
    eyes, firsts = marks[:, 0], np.array([middles(strip, side.SHEET)[0] for strip in strips])
    assert np.ptp(eyes) == 0 == np.ptp(firsts)
    seconds = np.array([middles(strip, side.SHEET)[1] for strip in strips])
    assert np.allclose((seconds - firsts) / (firsts - eyes), np.array([0.5, 2, 5]) / 8, atol=0.01)


def test_an_eye_that_moves_sideways_is_seen_from_above():
    scenes = [Chess(sheet="ideal", **TWO, eye=(x, 0)) for x in (-0.8, 0, 0.8)]
    shows = side.extent(scenes)
    assert shows.from_above and not side.extent([*scenes, Chess(**TWO, eye=(0, 1))]).from_above
    strips = [side.side_view(scene, *SIZE, shows) for scene in scenes]
    assert not any((strip[BETWEEN.stop + 4 :] == side.OTHER_RAYS).all(-1).any() for strip in strips)  # no rays in texts
    left = [strip[BETWEEN, :120] for strip in strips]
    eyes = [np.flatnonzero((part == 255).all(-1).any(1)).mean() for part in left]
    scale = np.diff(middles(strips[0], side.SHEET))[0] / 2
    assert np.diff(eyes) == pytest.approx([0.8 * scale] * 2, abs=1.5)  # to the right is downwards


def test_of_several_objects_those_that_are_shown_count():
    """What is too far to be shown may come first."""
    one, other = (side.side_view(Spheres(alpha=66, z1=z1), *SIZE) for z1 in ((100, 2), (2, 100)))
    assert (one == other).all()
    far, near = (Chess(alpha=180, z1=z1, x=x) for z1, x in (((27, 2), (0.5, 0)), ((2, 27), (0, 0.5))))
    assert rays(far) == rays(near) and rays(far)[0][1][-1][0] == 2


def test_without_an_image_it_says_so_and_what_is_far_is_counted(monkeypatch):
    texts = []
    monkeypatch.setattr(side, "write", lambda draw, x, middle, text, size: texts.append((x, text, size, middle)))
    for scene, expected in (
        (Chess(alpha=66), {"eye", "sheets", "object", "no common point of rays", "from the side"}),
        (Chess(alpha=180), {"eye", "sheets", "object", "real image", "from the side"}),
        (Chess(sheet="none"), {"eye", "window", "object", "from the side"}),
        (Chess(sheet="lens", focal_length=2), {"eye", "sheet", "object", "image at infinity", "from the side"}),
        (Chess(sheet="lens", focal_length=2.1), {"eye", "sheet", "object", "image not in the view", "from the side"}),
        (
            Chess(alpha=0, window="alpha=0,z=2", z2=1, z1=3.9),
            {"eye", "window 1", "2", "object", "virtual image", "from the side"},
        ),
        (Spheres(alpha=66), {"eye", "sheets", "objects", "3 farther", "no common point of rays", "from the side"}),
    ):
        for width in (SIZE[0], 96):
            texts.clear()
            side.side_view(scene, width, SIZE[1])
            assert {text for _, text, *_ in texts} == expected
            assert max((y, -x, text) for x, text, _, y in texts)[2] == "eye"  # below, on the left
            for line in {y for *_, y in texts}:
                ends = sorted((x, x + size * side.text_width(text)) for x, text, size, y in texts if y == line)
                assert ends[0][0] >= 0 and ends[-1][1] <= width
                assert all(end < start for (_, end), (start, _) in zip(ends, ends[1:], strict=False))


def test_an_image_does_not_make_the_rest_small_and_covers_no_text():
    movie = [Chess(sheet="lens", focal_length=2, z1=z) for z in np.linspace(1, 4, 31)]
    assert side.extent(movie).reach <= 2 * 1.5 + 1e-9
    huge = Chess(sheet="lens", focal_length=0.725, z1=0.7)
    assert side.extent([huge]).reach == 1.5 and side._shown(huge)[1] == []
    sphere = Spheres(sheet="lens", focal_length=1.2, z1=[1.0])
    shows, (_, (image,)) = side.extent([sphere]), side._shown(sphere)
    strip = side.side_view(sphere, *SIZE, shows)
    rows, columns = np.nonzero((strip == side.IMAGE).all(-1))
    assert image.radius > 0.45 and 20 < rows.min() and rows.max() < len(strip) - 20
    assert 0 < columns.min() and columns.max() < SIZE[0] - 1


@pytest.mark.parametrize("scene", [Chess(alpha=0), Spheres(alpha=0, z1=[3])])
def test_an_object_and_an_image_at_the_same_place_are_both_seen(scene):
    strip = side.side_view(scene, *SIZE)
    for colour in (side.OBJECT, side.IMAGE):
        assert (strip == colour).all(-1).sum() > 10


def test_it_is_added_below_the_picture(tmp_path):
    scene, size = Chess(sheet="none"), (96, 72)
    plain, more = (still.render(scene, size=size, antialias="off", side_view=on) for on in (False, True))
    assert (more[:72] == plain).all() and (more[72:] == side.side_view(scene, *size)).all()
    assert Rendering(side_view=True).annotated
    assert "side_view is drawn with 8 bits" in refused(["frame", "chess", "--side-view", "--bits=16"], tmp_path)
