"""Windows that stand anywhere, in any order: theorems about the rays that pass them."""

import numpy as np
import pytest

from povgen.optics.opening import Opening
from povgen.optics.outline import Outline
from povgen.optics.pose import Pose
from povgen.optics.rays import Bundle
from povgen.optics.trace import End
from povgen.optics.window_trace import paths, trace_windows
from povgen.sheets import IDEAL, SHEETS


def sheet(name, aperture=3.0, **values):
    kind = SHEETS[name]
    return kind({each.name: each.default for each in kind.parameters} | values, aperture)


def pose_of(place, axes):
    """Return the pose of an object with these axes, the rows of a matrix."""
    turn = np.degrees([np.arctan2(axes[2, 0], axes[2, 2]), np.arcsin(-axes[2, 1]), np.arctan2(axes[0, 1], axes[1, 1])])
    return Pose(*place, *turn)


def random_room(rng, kinds, most=20):
    """Return windows in random poses, in one another's way, and rays towards them."""
    windows = []
    for _ in range(rng.integers(4, most)):
        kind = SHEETS[rng.choice(kinds)]
        values = rng.choice(kind.examples) if not kind.layers else {"prisms": 20}
        one = sheet(kind.name, rng.uniform(0.8, 2), **values)
        pose = Pose(*rng.uniform(-2, 2, 3), *rng.uniform(-180, 180, 3))
        new = Opening(pose, one, max(0.1, 1.02 * one.depth))
        radii = [np.hypot(0.71 * each.sheet.aperture, each.frame / 2) for each in (*windows, new)]
        away = [np.linalg.norm(pose.place - other.pose.place) for other in windows]
        if all(d > radius + radii[-1] for d, radius in zip(away, radii, strict=False)):
            windows.append(new)
    start = rng.normal(size=(400, 3))
    start *= 9 / np.linalg.norm(start, axis=1, keepdims=True)
    to = np.array([windows[k].pose.place for k in rng.integers(len(windows), size=400)])
    return windows, Bundle(start, to + rng.uniform(-0.5, 0.5, (400, 3)) - start)


def test_turns_are_about_the_scenes_axes_in_the_order_roll_pitch_yaw():
    np.testing.assert_allclose(Pose(roll=90).axes, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-15)  # x towards y
    np.testing.assert_allclose(Pose(pitch=90).axes, [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-15)  # y towards z
    np.testing.assert_allclose(Pose(yaw=90).axes, [[0, 0, -1], [0, 1, 0], [1, 0, 0]], atol=1e-15)  # z towards x
    one_by_one = Pose(roll=20).axes @ Pose(pitch=-50).axes @ Pose(yaw=70).axes
    np.testing.assert_allclose(Pose(1, 2, 3, 70, -50, 20).axes, one_by_one)


def test_a_room_that_is_moved_as_a_whole_bends_light_alike(rng):
    kinds = [name for name in SHEETS if name != "profile"]
    crossings = 0
    for _ in range(6):
        windows, rays = random_room(rng, kinds)
        by = Pose(*rng.uniform(-5, 5, 3), *rng.uniform(-180, 180, 3))
        moved = [
            window._replace(pose=pose_of(by.scene(window.pose.place, by.place)[0], window.pose.axes @ by.axes))
            for window in windows
        ]
        here = trace_windows(rays, windows)
        there = trace_windows(Bundle(*by.scene(rays.position, rays.direction)), moved)
        off = np.linalg.norm(there.direction - here.direction @ by.axes, axis=1)
        same = off < np.where(here.count, 1e-6, 1e-9)  # stray light between lenses magnifies rounding
        assert same[here.count == 0].all() and same.mean() > 0.95
        assert (here.windows[same] == there.windows[same]).all() and (here.end[same] == there.end[same]).all()
        crossings += (here.windows[:, 1:] >= 0).sum()
    assert crossings > 60


def test_rays_that_are_followed_in_parts_are_the_same(rng, monkeypatch):
    """Also where the rays of one part meet fewer windows than those of another."""
    for _ in range(3):
        windows, rays = random_room(rng, [*IDEAL])
        whole, legs = vars(trace_windows(rays, windows, path=True)), paths(rays, windows, 60)
        monkeypatch.setattr("povgen.optics.window_trace.PART", 40)
        for name, values in vars(trace_windows(rays, windows, path=True)).items():
            np.testing.assert_allclose(values, whole[name], atol=1e-12)
        for leg, part in zip(legs, paths(rays, windows, 60), strict=True):
            assert all(map(np.allclose, leg, part))
        monkeypatch.undo()


def test_light_takes_its_path_back(rng):
    kinds = [name for name in SHEETS if name != "profile"]
    returned = 0
    for _ in range(6):
        windows, rays = random_room(rng, kinds)
        there = trace_windows(rays, windows)
        some = (there.end <= End.BACK) & (there.count < 40)
        ends = there.position[some] + there.direction[some]
        back = trace_windows(Bundle(ends, -there.direction[some]), windows)
        same = np.linalg.norm(back.direction + rays.direction[some], axis=1) < 1e-8
        assert same[there.count[some] == 0].all() and same.mean() > 0.9
        off = np.cross(back.position[same] - rays.position[some][same], rays.direction[some][same])
        assert abs(off).max() < 1e-7
        returned += same.sum()
    assert returned > 300


def star(count, alpha, aperture=1000.0):
    """Return square windows that share an edge on the y axis. Each turns light by alpha, in the sense of the loop."""
    windows = []
    for k in range(count):
        yaw = -360 / count * (k + 0.3)
        middle = aperture / 2 * Pose(yaw=yaw).axes[0]  # its own x axis points away from the edge
        windows.append(Opening(Pose(*middle, yaw=yaw), sheet("ideal", aperture, alpha=alpha)))
    return windows


def test_what_windows_can_be():
    glass = sheet("single", prisms=5)
    found = trace_windows(Bundle((0.1, 0.2, -5), (0, 0, 1)), (Opening(Pose(z=z), glass) for z in (0, 9)))  # deep enough
    assert [*found.windows[found.windows >= 0]][0] == 0 and found.count > 0
    many = [Opening(Pose(x=3 * n), sheet("none")) for n in range(300)]
    assert trace_windows(Bundle((3 * 256, 0, -5), (0, 0, 1)), many).windows == 256
    with pytest.raises(ValueError, match=r"ray 1 from \[0. 0. 9.\]: inside the sheets of window 2; allowed: outside"):
        trace_windows(Bundle([(0, 0, 4), (0, 0, 9)], (0, 0, 1)), [Opening(Pose(z=z), glass) for z in (0, 9)])
    with pytest.raises(ValueError, match="windows: Pose; allowed: each an Opening"):
        trace_windows(Bundle((0, 0, 4), (0, 0, 1)), [Pose()])


def test_light_that_starts_behind_a_sheet_in_its_frame_has_not_passed_it():
    for glass in (sheet("ideal", alpha=90), sheet("single", prisms=100)):
        found = trace_windows(Bundle((0.1, 0.1, 0.29), (0.2, 0.1, 1)), [Opening(Pose(), glass, 0.6)])
        assert found.end == End.THROUGH and not found.designed and found.windows == -1
        assert (found.direction == Bundle((0, 0, 0), (0.2, 0.1, 1)).direction).all()


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("name", ["ideal", "single"])
def test_a_frame_stops_light_from_outside(name, way):
    """A window 2 wide and 1 high, its frame 0.15 wide and 0.4 deep."""
    opening = Opening(Pose(yaw=25), sheet(name, 2, prisms=100), 0.4, Outline(2, 1), 0.15)
    aims = [
        ((1.02, 0, -0.2), (0, 0, 1)),  # through its front, at each end
        ((1.14, 0, -0.2), (0, 0, 1)),
        ((0, 0.64, -0.2), (0, 0, 1)),
        ((1.05, 0, -0.2), (-0.6, 0, 1)),  # towards the opening's middle plane
        ((1.15, 0, 0.1), (-1, 0, 0.3)),  # through its side
        ((0.98, 0, -0.2), (0, 0, 1)),  # through the opening
        ((1.16, 0, -0.2), (0, 0, 1)),  # beside it
    ]
    place, to = np.array(aims).transpose(1, 0, 2) * [1, 1, way]
    bundle = Bundle(*opening.pose.scene(place - 9 * to, to))
    ends = [*trace_windows(bundle, [opening]).end]
    assert ends[:5] == [End.FRAME] * 5 and ends[5:] == [End.THROUGH, End.BESIDE]
    assert trace_windows(bundle, [opening._replace(rim=0)]).end[1] == End.BESIDE
    ended = trace_windows(bundle, [opening])[:5]
    assert (trace_windows(Bundle(ended.position, -ended.direction), [opening]).end == End.BESIDE).all()
    inside = Bundle(*opening.pose.scene(np.array([[0, 0.45, 0.19 * way]]), np.array([[0, 1, 0.01 * way]])))
    assert trace_windows(inside, [opening]).end == End.FRAME  # from behind the sheet, to the side
