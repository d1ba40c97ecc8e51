"""The view from the side or from above: everything is where the scene has it, to one scale, with legible names."""

from itertools import combinations

import numpy as np
import pytest
from conftest import refused

from povgen import Chess, Spheres
from povgen.objects.box import Box
from povgen.objects.piece import Piece
from povgen.objects.sphere import Sphere
from povgen.objects.window import Window
from povgen.scene.room import Eye, Room
from povgen.settings import Rendering
from povgen.video import side, still

SIZE = 640, 480
TWO = {"sheet": "ideal", "alpha": 120, "window": "alpha=120,z=2", "z2": 8, "z1": 2}
LEFT, RIGHT, KNIGHT = Window(name="left", alpha=90, x=-1.75), Window(alpha=40, x=1.75), Piece(x=-1.6, y=-0.85, z=2.5)
ROOM = Room([LEFT, RIGHT, KNIGHT, Sphere(x=3.9, radius=0.3)], eye=Eye(y=0.5, z=-9, view=7))


def shown(scene, colour):
    return [thing for thing in side._shown(scene)[0] if thing.colour == colour]


def light(scene):
    """Return the corners of light to the eye and to points beside it."""
    return [corners for _, corners in side._light(scene, [each.source for each in shown(scene, side.OBJECT)])]


def middles(strip, colour):
    """Return column and row of the pixels of a colour: the middle of each group of columns, and of its rows."""
    found = (strip == colour).all(-1)
    columns = np.flatnonzero(found.any(0))
    groups = [group for group in np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1) if len(group)]
    rows = [np.flatnonzero(found[:, group].any(1)) for group in groups]
    return np.array([(group.mean(), (y[0] + y[-1]) / 2) for group, y in zip(groups, rows, strict=True)])


@pytest.mark.parametrize(
    ("values", "z", "size"),
    [
        ({"alpha": 180}, -2, 1),  # a real image, as far before the window
        ({"alpha": 0}, 2, 1),
        (TWO, -2, 1),
        ({"sheet": "view-rotator", "alpha": 20, "view_distance": 2}, 2, None),  # of this plane
        ({"sheet": "lenslets", "alpha": 180, "ratio": 0.8}, -2.5, None),
        ({"sheet": "lens", "focal_length": 1}, -2, -1),
        ({"sheet": "lens", "focal_length": 1.5}, -6, None),  # 1/2 + 1/6 = 1/1.5
        ({"sheet": "glens"}, 2, 1.5),
        ({"sheet": "lens", "focal_length": 2, "z1": 3, "window": "sheet=lens,focal_length=3,z=1"}, -2, -2 / 3),
        ({"sheet": "lens", "focal_length": 1, "window": "sheet=lens,focal_length=1,z=4"}, -2, None),  # a relay
    ],
)
def test_light_comes_together_in_the_image(values, z, size):
    scene = Chess(**{"sheet": "ideal", **values})
    found, points = scene.image_plane([scene.L, scene.L + 1], scene.z1)
    assert found == pytest.approx(z)
    if size is None:
        return
    assert points[1] - points[0] == pytest.approx(size)
    ((image,), (thing,)) = shown(scene, side.IMAGE), shown(scene, side.OBJECT)
    place, tip, _ = image.points
    assert tip - place == pytest.approx(size * (thing.points[1] - thing.points[0]) * [1, 1, 0])
    for eye, bend, *_ in (rays := light(scene)):
        part = (tip[2] - eye[2]) / (bend[2] - eye[2])
        assert eye + part * (bend - eye) == pytest.approx(tip, abs=1e-6)
    assert len(rays) >= 2


def test_light_that_does_not_come_together_has_no_image():
    for values in ({"alpha": 66}, {"sheet": "refraction", "ratio": 0.7}):
        assert np.isnan(Chess(**values).image_plane([0.3j], 2)[0])


@pytest.mark.parametrize("z", [0.5, 1.5, 2.5, 5])
def test_rays_without_a_common_point_have_none_in_any_view(z):
    eyes, bends = np.array(
        [corners[:2] for corners in light(Chess(**{**TWO, "window": f"alpha=120,z={z}"}, piece="pawn"))]
    ).swapaxes(0, 1)
    between = eyes + np.linspace(0, 1, 400)[:, None, None] * (bends - eyes)  # from the eye's plane to the first window
    assert len(eyes) == 3 and np.ptp(between[..., :2], axis=1).min() > 0.04


@pytest.mark.parametrize(
    ("things", "from_above"),
    [
        ([LEFT, RIGHT], True),
        ([Window(y=2, pitch=20), Window(y=-2)], False),
        ([Window(pitch=30)], False),
        ([Window(yaw=-30)], True),
        ([Window(roll=30), Box(x=3, z=3), Box(x=-3, z=3)], True),  # the boxes decide
        ([Window(), Piece(y=-2, z=3)], False),
        ([], False),
    ],
)
def test_it_is_from_where_the_windows_show_more(things, from_above):
    assert side.extent([Room(things)]).from_above is from_above


def test_an_eye_that_moves_sideways_is_seen_from_above():
    scenes = [Chess(**TWO, eye=(x, 0)) for x in (-0.8, 0, 0.8)]
    shows = side.extent(scenes)
    assert shows.from_above and not side.extent([*scenes, Chess(**TWO, eye=(0, 2))]).from_above
    strips = [side.side_view(scene, *SIZE, shows) for scene in scenes]
    eyes, sheets = (
        np.array([middles(strip, colour)[0] for strip in strips]) for colour in (side.EYE[2][2], side.SHEET)
    )
    assert np.ptp(sheets, axis=0).max() == 0  # a movie keeps its scale
    scale = (sheets - eyes)[1, 0] / 8
    assert np.diff(eyes[:, 1]) == pytest.approx([0.8 * scale] * 2, abs=2)  # to the right is downwards


def test_a_turned_window_is_to_scale_and_a_movie_keeps_its_scale():
    movie = [Room([Window(yaw=yaw, frame=False), Box(x=3, z=z)], eye=Eye(z=-6)) for yaw, z in ((0, 2), (30, 4))]
    shows = side.extent(movie)
    assert shows.from_above and shows[:2] == (-6, 4.5)
    strips = [side.side_view(room, *SIZE, shows) for room in movie]
    assert strips[0].shape == strips[1].shape
    boxes = [np.argwhere((strip == side.OBJECT).all(-1)) for strip in strips]
    scale = np.diff([(box.min(0) + box.max(0))[1] / 2 for box in boxes])[0] / 2
    for strip, yaw in zip(strips, np.radians((0, 30)), strict=True):
        extent = np.ptp(np.argwhere((strip == side.SHEET).all(-1)), axis=0)
        assert extent / scale == pytest.approx(3 * np.array([np.cos(yaw), np.sin(yaw)]), abs=0.1)


def test_scenes_of_several_kinds_have_one_scale_and_what_is_far_is_left_out():
    movie = [Chess(alpha=180), ROOM, ROOM.seen_from(0.5)]
    strips = [side.side_view(scene, *SIZE, side.extent(movie, 0.5)) for scene in movie]
    assert strips[0].shape == strips[1].shape and (strips[1] != strips[2]).any()
    has = [[(strip == colour).all(-1).any() for colour in (side.SHEET, side.IMAGE, side.RAY)] for strip in strips]
    assert has == [[True, True, False], [True, False, True], [True, False, True]]
    assert side.extent([Room([LEFT, Sphere(z=1000)])]).last < 3
    high, far = Chess(sheet="lens", focal_length=2, z1=1.7), Chess(sheet="lenslets", alpha=180, ratio=0.1, z1=4)
    for scene in (high, far):  # their images
        assert side.extent([scene])[:4] == side.extent([scene.replace(sheet="none")])[:4]


@pytest.mark.parametrize("scene", [Chess(alpha=0), Spheres(alpha=0, z1=[3])])
def test_an_object_and_an_image_at_the_same_place_are_both_seen(scene):
    strip = side.side_view(scene, *SIZE)
    assert all((strip == colour).all(-1).sum() > 10 for colour in (side.OBJECT, side.IMAGE))


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        (Chess(alpha=66), {"sheets", "knight", "pedestal", "from the side", "no common point of rays"}),
        (Chess(alpha=180), {"sheets", "knight", "pedestal", "real image", "from the side"}),
        (Chess(sheet="none"), {"window", "knight", "pedestal", "from the side"}),
        (Chess(sheet="lens", focal_length=2), {"sheet", "knight", "pedestal", "from the side", "image at infinity"}),
        (
            Chess(sheet="lens", focal_length=2.1),
            {"sheet", "knight", "pedestal", "from the side", "image not in the view"},
        ),
        (
            Chess(alpha=0, window="alpha=0,z=2", z1=4),
            {"window 1", "window 2", "knight", "pedestal", "virtual image", "from the side"},
        ),
        (Spheres(alpha=66), {"sheets", "sphere", "from the side, 4 farther", "no common point of rays"}),
        (Room([LEFT, RIGHT, KNIGHT, Box(name="b", z=3)]), {"left", "window 2", "knight", "b", "from above"}),
    ],
)
def test_names_are_legible_and_hide_no_other(scene, said, monkeypatch):
    texts = []
    monkeypatch.setattr(side, "write", lambda draw, x, y, text, size, *_, **__: texts.append((text, x, y, size, draw)))
    for size in (SIZE, (320, 240), (1280, 720), (240, 426), (96, 480)):
        texts.clear()
        side.side_view(scene, *size)
        names = {text for text, *_ in texts}
        assert names == said | {"eye"} if size[0] > 300 else names <= said | {"eye"}
        assert any("image" in name or "rays" in name for name in names) is any(
            "image" in s or "rays" in s for s in said
        )
        boxes = [(x, y - size / 2, x + size * side.text_width(text), y + size / 2) for text, x, y, size, _ in texts]
        width, height = texts[0][-1].im.size
        assert all(a >= 0 and b >= 0 and c <= width and d <= height for a, b, c, d in boxes)
        for (a, b, c, d), (e, f, g, h) in combinations(boxes, 2):
            assert c <= e or g <= a or d <= f or h <= b
        assert min(each[3] for each in texts) >= size[1] / 40 or size[0] < size[1] / 2


def test_names_of_windows_stand_in_their_order(monkeypatch):
    """Also if the windows are so near to each other that their names would hide each other."""
    places = {}
    monkeypatch.setattr(side, "write", lambda draw, x, y, text, *_, **__: places.update({text: x}))
    movie = [Chess(sheet="ideal", alpha=120, z1=2, z2=8, window=f"z={gap},alpha=120") for gap in (0.4, 0.5, 1, 5)]
    for scene in movie:
        side.side_view(scene, 768, 864, side.extent(movie))
        assert places["window 1"] < places["window 2"] < places["knight"]


def test_it_is_added_below_the_picture(tmp_path):
    scene, size = Chess(sheet="none"), (96, 72)
    plain, more = (still.render(scene, size=size, antialias="off", side_view=on) for on in (False, True))
    assert (more[:72] == plain).all() and (more[72:] == side.side_view(scene, *size)).all()
    assert Rendering(side_view=True).annotated
    assert "side_view is drawn with 8 bits" in refused(["frame", "chess", "--side-view", "--bits=16"], tmp_path)
