"""Rooms as both renderers show them."""

import subprocess

import numpy as np
import pytest
from conftest import PROJECT, povgen, some

from povgen import Box, Chess, Eye, Room, Sphere, Window, render
from povgen.inputs import hdr
from povgen.measure import verify_rooms
from povgen.measure.opengl import OpenGLView
from povgen.optics.pose import Pose
from povgen.rendering import light
from povgen.scene.traced_rays import HOLD_OUT

SIZE = (96, 72)
RENDERERS = ["gl", "povray"]


def picture(scene, renderer, size=SIZE):
    return render(scene, size=size, renderer=renderer, antialias="off").astype(int)


def differing(one, other, most=15):
    """Return the share of pixels that differ by this or more."""
    return (abs(one - other).max(-1) >= most).mean()


@pytest.mark.parametrize("seed", some([1, 5, 16, 12], 1))
def test_both_renderers_and_the_ray_trace_agree_on_a_random_room(seed):
    room = verify_rooms.random_room(np.random.default_rng(seed))
    view = OpenGLView(room)
    found = view.picture((160, 120), verify_rooms.SHADOW_RAYS, part=0).astype(int)
    assert differing(found, picture(room, "povray", (160, 120))) < 0.005
    off, traced = verify_rooms.directions(room, view, SIZE)
    passes = (traced.end <= 1) & (traced.windows >= 0).any(-1) & np.isfinite(off) & traced.designed
    assert passes.sum() > 20 and (off[passes] < 1e-3).mean() >= 0.998


@pytest.mark.parametrize("renderer", RENDERERS)
def test_opposite_sheets_close_together_show_nothing(renderer):
    things = [Sphere(x=-0.5, z=2, radius=0.5), Box(x=1, y=0.5, z=3, yaw=30)]
    turn = {"yaw": 20, "pitch": -30, "roll": 50}
    normal = Pose(**turn).axes[2]
    pair = [
        Window(alpha=70 * side, frame=False, **dict(zip("xyz", 0.002 * side * normal, strict=True)), **turn)
        for side in (-1, 1)
    ]
    assert differing(picture(Room([*pair, *things]), renderer), picture(Room(things), renderer)) < 0.01
    assert differing(picture(Room([pair[0], *things]), renderer), picture(Room(things), renderer)) > 0.1


@pytest.mark.parametrize("renderer", some(["povray", "gl"], 1))
def test_a_room_that_is_turned_as_a_whole_looks_the_same(renderer):
    """Black spheres before white: the light stays where it is."""
    places = [(-0.9, 0.3), (0.8, 0.5), (0.2, -0.7)]
    things = [Sphere(x=x, y=y, z=3, radius=0.4, color="black") for x, y in places]
    windows = [Window(alpha=50, frame=False, yaw=25, width=2.5), Window(alpha=-30, frame=False, z=1.5, width=3)]
    plain = Room([*windows, *things], background="white", eye=Eye(z=-7, view=4))
    by = Pose(2, -1, 3, 40)  # a yaw keeps the picture upright

    def moved(each):
        x, y, z = by.scene(each.pose.place, each.pose.place)[0]
        return each.replace(x=x, y=y, z=z, yaw=each.yaw + by.yaw)

    (ex, ey, ez), (lx, ly, lz) = (by.scene(np.array(p, float), np.zeros(3))[0] for p in ((0, 0, -7), (0, 0, 0)))
    eye = Eye(x=ex, y=ey, z=ez, look_x=lx, look_y=ly, look_z=lz, view=4)
    turned = Room([moved(each) for each in (*windows, *things)], background="white", eye=eye)
    before, after = ((picture(room, renderer) > 200).all(-1) for room in (plain, turned))
    assert 0.02 < 1 - before.mean() < 0.5 and (before != after).mean() < 0.005


@pytest.mark.parametrize("renderer", RENDERERS)
@pytest.mark.parametrize("sheet", some(["ideal", "detailed"], 1))
def test_a_room_like_a_preset_looks_like_it(sheet, renderer):
    preset = Chess(sheet=sheet, alpha=60, prisms=20, view=4)
    window = Window(sheet=sheet, alpha=60, prisms=20)
    room = Room([window, *preset.contents], eye=Eye(view=4))
    assert differing(picture(room, renderer), picture(preset, renderer), 5) < 0.004


def test_the_legs_of_a_rooms_text_make_its_picture(tmp_path):
    """As the text's own comment says: a pixel is that of the first leg in which it has not the colour HoldOut."""
    toml = PROJECT / "docs" / "rooms" / "box.toml"
    assert povgen(["pov", str(toml), "--size", "64x48", "-o", "box.pov"], tmp_path)[0] == 0
    made, rows = np.full((48, 64, 3), np.nan), slice(1, None)
    for leg in range(len([*tmp_path.glob("box-rays-*.inc")])):
        kind = ["+FP16", "File_Gamma=1", "+W64", "+H49", "-A", "-D", f"Declare=Leg={leg}", f"+Oleg{leg}.ppm"]
        subprocess.run(["povray", "+Ibox.pov", *kind], cwd=tmp_path, check=True, capture_output=True)
        seen = light.read(tmp_path / f"leg{leg}.ppm", (64, 49))[rows]
        shown = np.isnan(made[..., 0]) & (abs(seen - HOLD_OUT).max(-1) > 5e-4)
        made[shown] = seen[shown]
    assert leg == 2
    picture = np.asarray(hdr.encoded(np.nan_to_num(made).astype(np.float32).clip(0, 1)))
    whole = render(Room.load(toml), size=(64, 48), antialias="off")
    assert (abs(picture - whole).max(-1) < 2).mean() > 0.995
