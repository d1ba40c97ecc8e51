"""What an eye with a pupil sees, and pictures that look elsewhere."""

import numpy as np
import pytest
from conftest import povgen, some

from povgen import Chess, Eye, Room, Sphere, Window, render, settings
from povgen.measure.opengl import OpenGLView
from povgen.rendering import light, views
from povgen.scene import pupil

SIZE = (96, 72)


@pytest.fixture
def few_rays(monkeypatch):
    for module in (settings, views):
        monkeypatch.setattr(module, "PUPIL_RAYS", 5)


@pytest.mark.parametrize(
    "scene",
    [
        Chess(sheet="ideal", alpha=90, pupil=0.6, focus=5),
        Chess(alpha=90, prisms=30, pupil=0.6),
        Room([Window(alpha=60, yaw=20), Sphere(z=2, radius=0.5)], eye=Eye(x=1, view=4), pupil=0.6, focus=5),
    ],
)
def test_both_renderers_show_the_same_blur(scene, few_rays):
    one, other = (render(scene, size=SIZE, renderer=name, quality="high").astype(int) for name in ("gl", "povray"))
    sharp = render(scene.replace(pupil=0), size=SIZE, renderer="gl", quality="high").astype(int)
    # the soft shadows of gl have few rays here
    assert (abs(one - other).max(-1) > 15).mean() < 0.04 < 0.1 < (abs(one - sharp).max(-1) > 15).mean()


def test_a_picture_is_the_mean_of_light_from_the_places_in_the_pupil(few_rays):
    scene = Chess(sheet="ideal", alpha=50, pupil=0.6)
    jitter = [complex(*light.place(k, 5, False)) for k in range(5)]
    eyes = [eye.replace(pupil=0) for eye in pupil.eyes(scene, jitter, scene.view / SIZE[1])]
    single = light.mixed(render(eyes, size=SIZE, renderer="gl", antialias="off", quality="draft"), [np.eye(3) / 5] * 5)
    # the lights of the soft shadows differ
    assert (abs(single.astype(int) - render(scene, size=SIZE, renderer="gl")).max(-1) > 8).mean() < 0.03
    wide = render(scene, size=SIZE, renderer="gl", bits=32)
    assert wide.shape == (72, 96, 3) and wide.dtype == np.float32


@pytest.mark.parametrize("focus", some([3, 8, 40], 1))
def test_a_dot_becomes_a_disc_of_the_size_that_geometry_says(focus):
    """A black dot at the distance 8 from the eye, whose picture is measured at the distance 6."""
    R, at = 0.3, 6 / focus
    dot = Room([Sphere(z=2, radius=0.05, color="black")], background="white", pupil=2 * R, focus=focus)
    view = OpenGLView(dot)
    dark = 255.0 - view.picture((160, 160), 197).astype(float)[..., 0]
    x, y = (np.arange(160) - 79.5) * 5 / 160, (np.arange(160) - 79.5)[:, None] * 5 / 160
    light_ = (255 - dark) / 255
    dark = 1 - np.where(light_ <= 0.04045, light_ / 12.92, ((light_ + 0.055) / 1.055) ** 2.4)
    square = (dark * (x**2 + y**2)).sum() / dark.sum()
    disc, sphere = R * abs(6 / 8 - at), 0.05 * 6 / 8
    assert square == pytest.approx(disc**2 / 2 + sphere**2 / 2 + (5 / 160) ** 2 / 6, rel=0.1)


@pytest.mark.parametrize(
    "values", some([{"prisms": 30}, {"sheet": "ideal"}, {"sheet": "ideal", "window": "z=1.5,alpha=20"}], 1)
)
@pytest.mark.parametrize("renderer", ["povray", "gl"])
def test_a_picture_that_looks_elsewhere_is_moved(values, renderer):
    pixel = 3.7 / SIZE[1]
    scene = Chess(alpha=60, z1=3, view=3.7, **values)
    options = {"size": SIZE, "renderer": renderer, "antialias": "1.5x"}
    moved = render(scene.replace(look=(20 * pixel, -10 * pixel)), **options).astype(int)
    plain = render(scene, **options).astype(int)
    assert (abs(plain[10:, 20:] - moved[:-10, :-20]).max(-1) > 15).mean() < 0.02
    assert (abs(plain - moved).max(-1) > 15).mean() > 0.1


def test_the_overlay_looks_elsewhere_too():
    scene = Chess(sheet="ideal", alpha=60, view=3.7)
    marked, plain = (render(scene.replace(look=(0.5, 0)), size=SIZE, renderer="gl", overlay=on) for on in (True, False))
    middle = render(scene, size=SIZE, renderer="gl", overlay=True)
    changed = abs(marked[-72:].astype(int) - plain).max(-1) > 30
    before = abs(middle[-72:].astype(int) - render(scene, size=SIZE, renderer="gl")).max(-1) > 30
    columns = [np.argwhere(each.any(0)).mean() for each in (changed, before)]
    assert columns[0] - columns[1] == pytest.approx(-0.5 / 3.7 * 72, abs=2)


def test_a_command_says_where_an_eye_cannot_be_and_what_a_text_leaves_out(tmp_path):
    status, _, err = povgen(["frame", "chess", "--eye", "9.95,0", "--pupil", "0.3", "-o", "a.png"], tmp_path)
    assert status == 2 and "pupil = 0.3: for a place in it, eye" in err
    status, _, err = povgen(["pov", "chess", "--pupil", "0.3", "-o", "a.pov"], tmp_path)
    assert status == 0 and "pupil = 0.3: a .pov file shows what its middle sees" in err
