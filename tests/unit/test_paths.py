"""Where the eye sees a point through windows that stand anywhere."""

import numpy as np
import pytest
from test_rooms import pose_of, random_room, star

from povgen import Chess
from povgen.errors import InputError
from povgen.objects.window import Window
from povgen.optics.camera import Camera
from povgen.optics.paths import Paths
from povgen.optics.pose import Pose
from povgen.optics.trace import End
from povgen.optics.window_trace import trace_windows
from povgen.scene.room import Eye, Room

PRESETS = [
    {"sheet": "ideal", "alpha": 66},
    {"sheet": "ideal", "alpha": 30, "window": "alpha=-50,z=1.5", "eye": (0.4, -0.3), "x": 0.5},
    {"sheet": "detailed", "alpha": 40},
    {"sheet": "lens", "focal_length": 3, "window": "sheet=detailed,alpha=70,z=2"},
    {"sheet": "refraction", "ratio": 0.7},
    {"sheet": "lenslets", "alpha": 100, "ratio": 0.8},
]


@pytest.mark.parametrize("values", PRESETS)
@pytest.mark.parametrize("by", [Pose(), Pose(3, -2, 5, 40, -70, 130)])
def test_it_is_the_prediction_for_windows_on_an_axis_also_when_all_is_moved(values, by):
    scene = Chess(**values)
    L, z1 = scene.objects[0]
    windows = {
        str(n): each._replace(pose=pose_of(by.scene(each.pose.place, by.place)[0], by.axes))
        for n, each in enumerate(scene.openings)
    }
    eye, middle = by.scene(np.array([scene.camera.eye, scene.camera.middle]), np.zeros(3))[0]
    camera = Camera(tuple(eye), tuple(middle), tuple(by.axes[0]), tuple(by.axes[1]), 4)
    point = by.scene(np.array([L.real, L.imag, scene.places[-1] + z1]), by.place)[0]
    ((image,),) = Paths(camera, windows).images(point)
    assert image.windows == tuple(windows)
    assert image.position == pytest.approx(scene.apparent_position(L, z1), abs=1e-9)
    np.testing.assert_allclose(image.corners[[0, -1]], [eye, point], atol=1e-12)


def through(windows, camera, rng, count=40):
    """Return positions of rays, the names of the windows on their way, and points on them behind the last window."""
    position = rng.uniform(-2, 2, (2, count)).T @ (1, 1j)
    found = trace_windows(camera.through(position), windows)
    met = [tuple(str(w) for w in row if w >= 0) for row in found.windows.reshape(count, -1)]
    ends = np.isin(found.end, (End.THROUGH, End.BACK, End.BESIDE)) & np.array([len(row) <= 6 for row in met])
    points = found.position + rng.uniform(0.2, 8, (count, 1)) * found.direction
    return [(position[n], met[n], points[n]) for n in np.flatnonzero(ends)]


@pytest.mark.parametrize("kinds", ["star", ["ideal", "mirror", "lens"], ["axis", "refraction", "twist"]])
def test_each_path_is_found_and_exists(kinds, rng):
    camera = Camera((1, 0.3, -7), (1, 0.3, 0), (1, 0, 0), (0, 1, 0), 6)
    lengths, is_linear = set(), "axis" not in kinds
    for n in (4, 5, 6) if is_linear else (4,):
        windows = star(n, 109.47, 4.0) if kinds == "star" else random_room(rng, kinds, 12 if is_linear else 6)[0]
        rays = through(windows, camera, rng)
        paths = Paths(camera, {str(n): window for n, window in enumerate(windows)})
        for (position, met, _), images in zip(rays, paths.images([point for *_, point in rays]), strict=True):
            lengths.add(len(met))
            assert any(each.windows == met and abs(each.position - position) < 1e-6 for each in images)
            assert [abs(each.position) for each in images] == sorted(abs(each.position) for each in images)
            for image in images:
                found = trace_windows(camera.through(image.position), windows)
                assert tuple(str(w) for w in found.windows if w >= 0)[: len(image.windows)] == image.windows
                if (found.windows >= 0).sum() == len(image.windows):
                    off = np.cross(image.corners[-1] - found.position, found.direction)
                    assert np.linalg.norm(off) < 1e-8
    assert lengths >= ({0, 1, 2} if kinds == "star" else {0, 1})


def test_a_point_is_seen_beside_and_through_a_window():
    """A sheet with alpha = 180 shows what is behind it as far before it."""
    room = Room([Window(name="left", alpha=180, width=1), Window(alpha=180, x=2, width=1)], eye=Eye(z=-6, view=9))
    images = room.images((1.2, 0, 2))
    assert [each.windows for each in images] == [(), ("window2",)] and images == room.images((1.2, 0, 2))
    assert str(images[1]).startswith("Image(position=(1.") and str(images[1]).endswith(", windows=('window2',))")
    assert [each.position for each in images] == pytest.approx([1.2 * 6 / 8, 1.2 * 6 / 4])
    assert [each.windows for each in room.images((0.1, 0.1, 2))] == [("left",)]
    assert [each.windows for each in room.images((0.1, 0.1, -2))] == [()]  # before the windows


@pytest.mark.parametrize("outline", ["rectangle", "round"])
def test_a_frame_hides_what_is_behind_it(outline):
    """Its sides are 0.15 tiles wide, of a window whose opening ends at x = 0.5; the eye is far away."""
    room = Room([Window(sheet="none", width=1, outline=outline)], eye=Eye(z=-500))
    for x, windows in ((0.48, ("window1",)), (0.52, None), (0.63, None), (0.67, ())):
        for z, seen in ((2, windows), (-2, ())):
            assert [each.windows for each in room.images((x, 0, z))] == ([] if seen is None else [seen])
    bare = room.replace(window=room.window[0].replace(frame=False))
    assert [each.windows for each in bare.images((0.52, 0, 2))] == [()]
    behind = room.replace(window=[Window(sheet="none", width=2, z=-1), Window(sheet="none", width=1, name="far")])
    assert [len(behind.images((x, 0, 2))) for x in (0.48, 0.55, 0.7)] == [1, 0, 1]


def test_a_path_may_have_as_many_windows_as_a_room():
    room = Room([Window(z=z, alpha=5) for z in range(20)], eye=Eye(z=-6))
    (image,) = room.images((0.2, 0.1, 22))
    found = room.trace(room.camera.through(image.position))
    assert len(image.windows) == 20 and abs(found.at(22) - (0.2 + 0.1j)) < 1e-8


@pytest.mark.parametrize("scene", [Chess(sheet="ideal"), Room([Window(frame=False, alpha=66)]), Chess(sheet="none")])
@pytest.mark.parametrize("point", [(0, 0, 0), (0.3, 0, 0), (-0.2, 0.1, 1e-15)])
def test_a_point_on_a_sheet_is_seen_there(scene, point):
    (image,) = scene.images(point)
    assert image.windows in {("window1",), ("window",)}
    assert image.position == pytest.approx(complex(*point[:2]), abs=1e-9)


@pytest.mark.parametrize(("yaw", "most"), [(0, 0.001), (20, 0.0015)])
def test_through_prisms_it_is_where_their_designed_light_comes_from(yaw, most, rng):
    room = Room([Window(sheet="detailed", alpha=40, yaw=yaw, prisms=100)], eye=Eye(z=-6))
    for point in [(0.3, 0.2, 2), (-0.4, 0.3, 3), (0.1, -0.5, 1.5)]:
        (image,) = room.images(point)
        step = 0.1 * rng.normal(size=(2, 4000)).T @ (1, 1j)
        light = room.trace(room.camera.through(image.position + step))
        step, light = step[light.designed], light[light.designed]
        off = light.at(point[2]) - complex(*point[:2])
        (off, along, across), *_ = np.linalg.lstsq(np.column_stack((step**0, step, step.conj())), off, rcond=None)
        size = abs(along) ** 2 - abs(across) ** 2
        assert len(step) > 500 and abs(along.conj() * off - across * off.conj()) / abs(size) < most


@pytest.mark.parametrize("point", [(1, 0, 6), (0, 0, 6), (0, 0, -7), (4, 0, 2)])
def test_what_no_path_reaches_has_no_image(point):
    """It appears at infinity, or in all directions; it is behind the eye, or a frame hides it."""
    assert Room([Window(alpha=180), Window(x=2.4, width=1, height=9, yaw=90)], eye=Eye(z=-6)).images(point) == []


@pytest.mark.parametrize("wrong", [(1, 2), (1, 2, np.inf), "here", None])
def test_a_point_has_three_numbers(wrong):
    with pytest.raises(InputError, match="point"):
        Room().images(wrong)


@pytest.mark.filterwarnings("error")
def test_an_eye_in_a_windows_plane():
    room = Room(Window(x=5), eye=Eye(z=0, look_z=3))
    assert np.isnan(room.camera.position([[5, 1, 0], [-2, 0, 0]])).all() and room.images((-2, 0, 0)) == []
