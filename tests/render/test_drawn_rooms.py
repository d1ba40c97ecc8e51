"""Rooms as both renderers show them."""

import subprocess

import numpy as np
import pytest
from conftest import PROJECT, povgen, refused, some

from povgen import Chess, Eye, Room, Window, render
from povgen.inputs import hdr
from povgen.measure import verify_rooms
from povgen.measure.opengl import OpenGLView
from povgen.optics.trace import End
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
    passes = (traced.end <= End.BACK) & (traced.windows >= 0).any(-1) & np.isfinite(off) & traced.designed
    assert passes.sum() > 20 and (off[passes] < 1e-3).mean() >= 0.998
    framed = traced.end == End.FRAME
    assert framed[np.isnan(off)].all() and framed[np.isfinite(off)].mean() < 0.01  # which has no bevels


def test_no_pixel_is_black_beside_a_frame():
    """POV-Ray's frame has a bevel: light passes there."""
    room = Room([Window(alpha=30, width=8, z=3), Window(alpha=20, width=2, yaw=40)], eye=Eye(z=-6))
    assert picture(room, "povray").max(-1).min() > 0


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
    (tmp_path / "box-rays-0.inc").write_text("mine")
    command = ["pov", str(toml), "--size", "64x48", "-o", "box.pov"]
    assert "'box-rays-0.inc' exists, and povgen did not write it" in refused(command, tmp_path)
    (tmp_path / "box-rays-0.inc").unlink()
    for _ in range(2):  # over its own files
        assert povgen(command, tmp_path)[0] == 0
    (tmp_path / "box-rays-1.inc").write_text("mine")  # beside povgen's own
    assert "'box-rays-1.inc' exists, and povgen did not write it" in refused(command, tmp_path)
    (tmp_path / "box-rays-1.inc").unlink()
    (tmp_path / "box.pov").unlink()  # without it, the other files are still povgen's own
    assert povgen(command, tmp_path)[0] == 0
    assert povgen([*command[:-1], "ä.pov"], tmp_path)[0] == 0
    assert [*tmp_path.glob("scene-*-rays-0.inc")]  # POV-Ray reads only names in ASCII
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
