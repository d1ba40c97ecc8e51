"""The rooms of docs/rooms do what docs/rooms.md says of them."""

from pathlib import Path

import numpy as np

from povgen import Room
from povgen.optics.rays import Bundle
from povgen.optics.trace import End

ROOMS = [Path(__file__).parents[2] / folder for folder in ("docs/rooms", "povgen/page/examples")]


def load(name):
    return Room.load(next(folder / f"{name}.toml" for folder in ROOMS if (folder / f"{name}.toml").exists()))


def test_the_same_knight_is_seen_beside_the_sheet_and_turned_through_it():
    room = load("side-by-side")
    behind, beside = room.things["behind"], room.things["beside"]
    assert (behind.y, behind.z) == (beside.y, beside.z)
    [through], [plain] = ([image.windows for image in room.images(each.pose[:3])] for each in (behind, beside))
    assert (through, plain) == (("sheet",), ())


def test_the_right_one_of_two_equal_windows_is_turned():
    left, right = load("tilted").window
    assert right.replace(name="left", x=left.x, yaw=0) == left and right.yaw == 35


def test_boards_are_turned_as_the_picture_of_the_turns_shows():
    roll, pitch, yaw = (each.pose.axes for each in load("turns").object)
    assert roll[0, 1] > 0.7 and pitch[1, 2] > 0.7 and yaw[0, 2] < -0.7  # right side up, top away, right side near


def test_a_direction_that_goes_round_the_star_returns(rng):
    room = load("star")
    start = way = rng.normal(size=(20, 3))
    for opening in room.openings:
        front = np.sign(way @ opening.pose.axes[2])[:, None]
        # through this sheet alone, from in front of it
        alone = room.replace(window=[each for each in room.window if each.opening.pose == opening.pose])
        found = alone.trace(Bundle(opening.pose.place - 0.01 * front * way, front * way))
        assert (found.end == End.THROUGH).all()
        way = front * found.direction
    np.testing.assert_allclose(way, Bundle((0, 0, 0), start).direction, atol=1e-6)
    ray = room.trace(Bundle((0.24, -1.3, -0.6), (-1, 0.455, 0)), path=True)  # the one of the picture goes round
    assert len({*ray.windows[:8].tolist()}) == 8 and ray.windows[8] == ray.windows[0]
    first, again = np.diff(ray.corners, axis=0)[[1, 9]]
    np.testing.assert_allclose(again, first, atol=1e-3)


def test_the_box_shows_what_is_behind_it_and_its_knight_elsewhere():
    room = load("box")
    rays = room.rays("64x48")
    found = room.trace(rays)
    opposite = [
        tuple(sorted(pair)) in ((0, 1), (2, 3)) for pair in found.windows.reshape(-1, found.windows.shape[-1])[:, :2]
    ]
    crossed = np.reshape(opposite, found.shape) & ((found.windows >= 0).sum(-1) == 2) & (found.end == End.THROUGH)
    assert crossed.sum() > 100
    np.testing.assert_allclose(found.direction[crossed], rays.direction[crossed], atol=1e-9)
    places = {image.windows: image.position for image in room.images((0, -0.4, 0))}
    empty = {image.windows: image.position for image in room.replace(window=()).images((0, -0.4, 0))}
    assert abs(places["front",] - empty[()]) > 0.3


def test_equal_rooms_have_the_same_rays_in_the_cache():
    room, other = load("tilted"), load("tilted")
    other.images((0, 0, 3))  # computes the sheets' matrices
    again = Room(**room.model_dump())
    assert room.rays_file.name == other.rays_file.name == again.rays_file.name
    left, right = room.window
    for change in ({"alpha": 31}, {"x": 1.9}, {"outline": "round"}, {"sheet": "lens"}):
        assert room.replace(window=[left, right.replace(**change)]).rays_file.name != room.rays_file.name
    assert room.replace(eye="z=-9").rays_file.name != room.rays_file.name
