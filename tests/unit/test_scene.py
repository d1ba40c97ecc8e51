"""A scene's parameters: what each one moves, and what follows from it."""

import re
from contextlib import nullcontext

import numpy as np
import pytest
from conftest import glass, mirrored_position

from povgen import Chess, InputError, Rendering, Room, Spheres, Window, to_pov
from povgen.errors import at_least, at_most
from povgen.optics import apparent
from povgen.optics.prism import Prism
from povgen.rendering.views import views
from povgen.scene.eye_and_windows import APERTURE, VIEW


def test_eye_and_object_move_on_their_own():
    foot = Chess().L
    assert (Chess().E, foot.real, foot.imag) == (0, 0, pytest.approx(-0.85))
    assert (Spheres().E, Spheres().L) == (0, -0.8)
    for scene in (Chess(eye=(1, -0.5)), Chess(eye="1,-0.5"), Chess(eye=1 - 0.5j)):
        assert (scene.E, scene.L) == (1 - 0.5j, foot)
    assert (Chess(x=2).E, Chess(x=2).L) == (0, 2 + foot)
    scene = Spheres(eye=(1, -5), line=(0.2, 0.3))  # no floor
    assert (scene.E, scene.L) == (1 - 5j, 0.2 + 0.3j)


FAR = {"z1": 700, "z2": 150, "sheet": "none"}  # clear of the deepest frame, within POV-Ray's range


@pytest.mark.parametrize(
    ("scene", "name", "ends", "beyond"),
    [
        (Chess, "alpha", (-360, 360), (-360.001, 360.001)),
        (Chess, "z1", (5000,), (0, 5001)),
        (Chess, "axis", ((-1, -1, -1), (1, 1, 1), (0, 0, 0.001)), ((0, 0, 1.001), (-1.001, 0, 0), (0, 0, 9.9e-4))),
        (Chess, "aspect", (1.999,), (0, 2)),
        (Chess, "eye", ((-10, 0), (10, 10)), ((-10.001, 0), (0, 10.001))),
        (Spheres, "z1", ((2,) * 50,), ((2,) * 51, (5001,))),
    ],
)
def test_the_ends_of_a_range_are_allowed_and_nothing_beyond(scene, name, ends, beyond):
    # of prisms so short or long that a sheet of them can be made
    shape = {"base_angle": {"aspect": 1.5}, "index": {"aspect": 1.5}}.get(name, {})
    for value in ends:
        assert np.array_equal(getattr(scene(**{**FAR, **shape, name: value}), name), value)
    for value in beyond:
        with pytest.raises(InputError, match=f"^{name} = "):
            scene(**{**FAR, **shape, name: value})


def test_window_frame_and_pedestals_stand_on_the_floor():
    for aperture in (0.5, 2.4, 10):
        scene = Chess(aperture=aperture, z1=5, pedestal=0)
        assert scene.L.imag == scene.floor_y == -(aperture / 2 + scene.rim)
        assert Chess(aperture=aperture, z1=5, pedestal=1.5).L.imag == scene.floor_y + 1.5
        with pytest.raises(InputError, match=f"allowed: Y > {scene.floor_y:g}$"):
            Chess(aperture=aperture, z1=5, eye=(0, scene.floor_y))


@pytest.mark.parametrize("window", [Window(x=1.3), Window(x=-0.5, y=0.8, z=0.1, yaw=20)])
def test_a_room_says_how_much_farther_apart_windows_must_be(window):
    with pytest.raises(InputError, match="they overlap; allowed: .* tiles farther apart$") as error:
        Room([Window(), window])
    more = float(str(error.value).split()[-4])
    for nearer, allowed in ((0, True), (0.002, False)):
        factor = 1 + (more - nearer) / np.linalg.norm(window.pose.place)
        moved = window.replace(**{name: factor * getattr(window, name) for name in "xyz"})
        with nullcontext() if allowed else pytest.raises(InputError, match="overlap"):
            Room([Window(), moved])


@pytest.mark.parametrize(
    ("values", "least"),
    [
        ({}, 0.86),
        ({"pedestal": 0, "piece": ("pawn", "king")}, 0.79),
    ],
)
def test_pieces_do_not_overlap(values, least):
    for apart in (-least, least, 3 * least):
        Chess(x=(0, apart), **values)
        Chess(x=0, z1=(2, 2 + abs(apart)), **values)
    for x, z1 in ((0, 0), (0.99 * least, 0), (0, -0.99 * least)):
        with pytest.raises(InputError, match=f"overlap; allowed: at least {least} tiles apart"):
            Chess(x=(1, 1 + x), z1=(4, 4 + z1), **values)
    aside = 0.75 * least  # sqrt(2) times this is more
    if values.get("pedestal") == 0:
        Chess(x=(0, aside), z1=(4, 4 + aside), **values)  # round feet
    else:
        with pytest.raises(InputError, match="along x or z$"):
            Chess(x=(0, aside), z1=(4, 4 + aside), **values)  # square pedestals


def test_the_window_frame_holds_the_sheets():
    assert Chess().depth == Chess(sheet="none").depth == APERTURE / 10
    assert Chess(aperture=10, z1=5).depth == Chess(aperture=10, z1=5, sheet="ideal").depth == 1
    for values in ({"prisms": 10}, {"base_angle": 75}):
        scene = Chess(z1=50, z2=50, **values)
        assert scene.depth == pytest.approx(1.02 * scene.prism.thickness(2)) and scene.depth > APERTURE / 10
        with pytest.raises(InputError, match="would touch the window frame"):
            Chess(**{"z1": scene.depth / 2, "z2": 50, **values})


def test_sheets_are_up_to_100_tiles_deep():
    thick = {"prisms": 1, "aperture": 10, "z1": 150, "z2": 150}
    assert 99.9 < Chess(aspect=1.174, **thick).depth / 1.02 < 100
    with pytest.raises(InputError, match="would be 100.1 tiles deep; allowed: up to 100 tiles"):
        Chess(aspect=1.175, **thick)


def test_the_whole_piece_is_well_inside_the_window():
    """By eq. 7, in every frame of vary-alpha and of vary-z1."""
    scene, width, height = Chess(sheet="ideal"), 0.45, 1.55
    corners = scene.L + np.array([-width, width, -width + 1j * height, width + 1j * height])
    assert scene.visible(1.08 * corners, 2, np.arange(0, 181)[:, None]).all()
    assert scene.visible(1.08 * corners, np.geomspace(0.6, 60)[:, None], 90).all()


@pytest.mark.parametrize("name", ["index", "base_angle", "gap", "aspect", "aperture"])
@pytest.mark.parametrize("sheet", ["detailed", "single"])
def test_predictions_follow_the_prisms(name, sheet):
    values = {"index": 1.9, "base_angle": 52, "gap": 0.2, "aspect": 0.8, "aperture": 2.0}
    usual, scene = Chess(sheet=sheet, prisms=20), Chess(sheet=sheet, prisms=20, **{name: values[name]})
    shape = {"index": 1.5, "base_angle": 45, "gap": 0.01, "aspect": 1, name: values[name]}
    prism, L = Prism(shape.pop("aperture", APERTURE) / 20, **shape), 0.3 + 0.3j
    if sheet == "detailed":
        right = apparent.position(L, scene.E, 2, glass(6, np.radians(66), prism))
    else:
        right = mirrored_position(L, scene.E, 2, 6, prism)
    assert scene.apparent_position(L, 2) == pytest.approx(right, rel=1e-13)
    unchanged = sheet == "single" and name == "index"  # docs/sheets.md: the shift of the slab does not depend on it
    assert (abs(right - usual.apparent_position(L, 2)) < 1e-12) == unchanged


@pytest.mark.parametrize("scene", [Chess, Spheres])
def test_prisms_whose_facets_cross_are_refused(scene):
    least = Prism(1.0, 2, 40).least_aspect
    shape = {"index": 2, "base_angle": 40}
    assert scene(**{**shape, "aspect": least + 1e-9}).prism.top_length == pytest.approx(0, abs=1e-9)
    with pytest.raises(InputError, match=f"aspect = .*cross; allowed: {at_least(least)} < aspect < 2"):
        scene(**{**shape, "aspect": least - 1e-9})


def test_limits_that_messages_name_are_allowed():
    assert [at_most(limit) for limit in (1.7788, 4166.67, 0.67082, 12)] == ["1.778", "4166", "0.6708", "12"]
    assert [at_least(limit) for limit in (0.15, 0.1 + 0.2, 0.76531, 1.2491)] == ["0.15", "0.3", "0.7654", "1.25"]


def test_the_view_is_the_height_of_the_picture():
    for view in (0.1, VIEW, 100):
        position = Chess(view=view).camera.pixels((40, 30))
        assert position.shape == (30, 40) and position.mean() == pytest.approx(0)
        assert np.ptp(position.imag) == pytest.approx(view * 29 / 30)
        assert np.ptp(position.real) == pytest.approx(view * 39 / 30)


def test_a_default_view_is_no_larger_than_the_frame_needs():
    for values in ({}, {"prisms": 50}, {"aperture": 3.2}, {"eye": (10, 7)}, {"z2": 1.1}, {"z2": 150}):
        assert Chess(**values).view == Spheres(**values).view == VIEW


def test_a_default_view_follows_the_values_of_a_copy():
    coarse = Chess(prisms=12)
    assert coarse.view > VIEW == coarse.replace(prisms=100).view == coarse.replace(view=VIEW).view
    left, right = views(coarse.replace(eye=(9, 0)), Rendering(stereo="pair"))
    assert left.view == right.view


def test_the_text_for_povray_states_values_with_15_digits():
    values = {"z1": 5 + 1 / 3, "z2": 7 / 3, "aperture": 2.123456789012, "view": 10 / 3, "x": -1 / 7, "pedestal": 1 / 3}
    values |= {"index": 4 / 3 + 0.2, "base_angle": 45 + 1 / 3, "gap": 1 / 30, "aspect": 1 + 1 / 7, "prisms": 123}
    names = ("Z1", "Z2", "Window", "ViewHeight", "PieceX", "Pedestal", "GlassIndex", "BaseAngle", "AirGap", "Aspect")
    source = to_pov(Chess(**values))
    for name, value in zip((*names, "Prisms"), values.values(), strict=True):
        assert re.search(rf"#declare {name} += {re.escape(f'{value:.15g}')};", source), name
