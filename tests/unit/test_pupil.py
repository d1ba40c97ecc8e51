"""An eye with a pupil: where its rays start, what it blurs, and at which distance it is sharp."""

from math import factorial

import numpy as np
import pytest

from povgen import Chess, Eye, Piece, Room, Sphere, Spheres, Window, best_focus, mtf, results
from povgen.errors import InputError
from povgen.optics import equations
from povgen.scene import pupil

ARCMINUTE = np.radians(1 / 60)
METRE = {"z1": 10, "z2": 10, "alpha": 90}  # tiles of 10 cm


@pytest.mark.parametrize(
    "scene",
    [
        Chess(pupil=0.4, focus=9, eye=(0.5, 0.2), look=(-0.4, 0.3)),
        Room([Sphere(z=3)], pupil=0.4, focus=9, eye=Eye(x=3, y=2, z=-7, look_y=1, look_z=2, roll=30, aside=0.5)),
    ],
)
def test_what_is_at_the_distance_of_the_focus_does_not_move_with_the_eye(scene):
    camera = scene.camera
    sides, normal = np.array((camera.right, camera.up)), np.cross(camera.right, camera.up)
    point = np.array(camera.eye) + 9 * normal + (0.7, -1.1) @ sides
    eyes = pupil.eyes(scene, np.zeros(9), 0.01)
    assert np.ptp([complex(eye.camera.position(point)) for eye in eyes]) < 1e-9
    places = np.array([np.subtract(eye.camera.eye, camera.eye) for eye in eyes])
    assert abs(places @ normal).max() < 1e-9 and 0.15 < np.linalg.norm(places, axis=1).max() <= 0.2
    moved = pupil.eyes(scene, [1 + 2j], 0.01)[0].camera.position(point) - camera.position(point)
    assert moved == pytest.approx(-0.01 - 0.02j)


@pytest.mark.parametrize("values", [METRE, {"z1": 2, "alpha": 30, "eye": (1, 0.5)}, {"window": "z=2,alpha=70"}])
def test_a_rotating_sheet_blurs_by_the_closed_form(values):
    scene = Chess(sheet="ideal", pupil=0.04, **values)
    # docs/beyond.md: Z = z2 + exp(-i alpha) ((z of the second window) + exp(-i alpha2) z1)
    Z = complex(equations.depth(scene.distances[0], scene.z2, np.radians(scene.alpha), scene.behind))
    table = results([scene, scene.replace(focus=3)], "best_focus", "pupil_blur", "seen_blur", progress=False)
    assert table["best_focus"] == pytest.approx(1 / (1 / Z).real)
    size = 1 + abs((scene.apparent_position(*scene.objects[0]) - scene.E) / scene.z2) ** 2  # the secant squared
    angles = np.sqrt((1 / size + 1 / size**2) / 2)
    expected = 0.04 / 8**0.5 * angles * np.array([abs((1 / Z).imag), abs(1 / Z - 1 / 3)]) / ARCMINUTE
    assert table["pupil_blur"] == pytest.approx(expected)
    assert table["seen_blur"] == pytest.approx(expected, rel=0.01)


def test_a_blur_is_an_angle_also_far_from_the_normal():
    """Between a ray that enters the pupil anywhere and the one that the focus expects there."""
    scene = Chess(sheet="ideal", z1=1, alpha=40, z2=1.5, eye=(1.2, 0.5), look=(0.7, -0.4), pupil=0.04)
    Z = complex(equations.depth(1, 1.5, np.radians(40)))
    slope = (scene.apparent_position(*scene.objects[0]) - scene.E) / scene.z2
    assert abs(slope) > 0.7
    place = 0.02 * pupil.places(5000)
    across = 1j * slope / abs(slope)

    def directions(slopes):
        found = np.stack((slopes.real, slopes.imag, slopes.real**0), -1)
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    for focus in (3, "best"):
        focused = scene.replace(focus=focus)
        table = results(focused, "best_focus", "pupil_blur", "seen_blur", progress=False)
        near = pupil.inverse_focus(focused)
        off = directions(slope - place / Z) - directions(slope - place * near)
        blur = np.sqrt((off**2).sum(1).mean()) / ARCMINUTE
        assert table["best_focus"] == pytest.approx(1 / (1 / Z).real)
        assert table["pupil_blur"] == pytest.approx(blur, rel=1e-3)
        assert table["seen_blur"] == pytest.approx(blur, rel=0.01)
        aside = off @ (across.real, across.imag, 0)  # perpendicular to the light
        contrast = abs(np.exp(2j * np.pi * np.degrees(4) * aside).mean())
        assert mtf(focused, 4, np.degrees(np.angle(across))) == pytest.approx(contrast, abs=0.002)


def test_prisms_and_pupil_blur_together():
    table = results([Chess(prisms=400, pupil=0.04, **METRE)], "pupil_blur", "prism_blur", "seen_blur", progress=False)
    assert table["prism_blur"] == pytest.approx(1.31, abs=0.02)
    assert table["seen_blur"] == pytest.approx(np.hypot(table["pupil_blur"], table["prism_blur"]), rel=0.05)


def test_at_0_and_180_degrees_things_can_be_in_focus_and_a_real_image_before_the_eye_too():
    scenes = [Spheres(sheet="ideal", alpha=alpha, z1=2, z2=6, pupil=0.2) for alpha in (0, 180)]
    table = results(scenes, "best_focus", "pupil_blur", progress=False)
    assert table["best_focus"] == pytest.approx([8, 4]) and table["pupil_blur"] == pytest.approx([0, 0], abs=1e-6)
    behind = Spheres(
        sheet="ideal", alpha=180, z1=9, line=(-0.2, 0), z2=6, pupil=0.2
    )  # light that runs together behind the eye
    parallel = Chess(sheet="lens", focal_length=4, z1=4)  # within rounding
    found = results([behind, parallel], "best_focus", progress=False)["best_focus"]
    assert found.tolist() == [np.inf, np.inf]
    at_pole = Spheres(sheet="ideal", alpha=180, z1=6, z2=6, pupil=0.2)
    assert np.isnan(results([at_pole], "best_focus", "seen_blur", progress=False)["best_focus"])


def test_a_room_is_focused_on_its_first_object_that_is_seen():
    window, far = Window(alpha=90), Piece(z=2, y=-0.5)
    preset, room = Chess(sheet="ideal", alpha=90), Room([window, Sphere(x=99, z=-20), far])
    assert best_focus(room) == pytest.approx(best_focus(preset)) == pytest.approx(6 + 2 / 3)
    assert pupil.inverse_focus(Room([window])) == pytest.approx(1 / 6)  # no object: the picture's plane
    assert best_focus(Room([Sphere(x=3, y=2, z=2)])) == pytest.approx(8)  # seen directly, from the side


def test_mtf_is_that_of_a_disc(monkeypatch):
    """2 J1(x) / x, by its series: the pupil is a disc, and the blur through a rotating sheet is one, too."""
    scene, frequencies = Spheres(sheet="ideal", line=(0, 0), pupil=0.04, **METRE), np.array([0, 2, 5, 9, 10, 50.0])
    x = np.pi * 0.04 * abs((1 / (10 + 10j)).imag) * np.degrees(frequencies)
    disc = abs(sum((-1) ** k / (factorial(k) * factorial(k + 1)) * (x / 2) ** (2 * k) for k in range(60)))
    assert disc[-2:] == pytest.approx([0.053, 0.021], abs=5e-4)
    for direction in (0, 30):
        assert mtf(scene, frequencies, direction) == pytest.approx(disc, abs=1e-8)
    assert mtf(scene, [[5], [1e9]]).tolist() == [[pytest.approx(disc[2])], [0]]
    monkeypatch.setattr("povgen.optics.apparent.matrix", lambda _: None)  # traced rays
    assert mtf(scene, frequencies) == pytest.approx(disc, abs=0.008)


@pytest.mark.parametrize(
    ("frequencies", "direction", "words"),
    [
        ([2, np.nan], 0, "frequencies: NaN or infinite"),
        (2, [0, 90], "direction: allowed: one finite number"),
        (-1, 0, "frequencies = -1; allowed: 0 or more"),
        ("few", 0, "frequencies has other values than numbers"),
        (2, "up", "direction has other values than numbers"),
    ],
)
def test_mtf_refuses_what_is_no_frequency_or_direction(frequencies, direction, words):
    with pytest.raises(InputError, match=words):
        mtf(Chess(sheet="ideal", pupil=0.04), frequencies, direction)
