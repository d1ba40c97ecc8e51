"""Pictures that are composed of several frames: a transparent background, and what two eyes see."""

import imageio.v3 as iio
import numpy as np
import pytest
from conftest import povgen, refused

from povgen import Chess, Rendering, Spheres, movie, render, to_pov
from povgen.rendering.views import composed, views
from povgen.scene.spec import MovieSpec

SIZE = {"size": (64, 64), "antialias": "off"}


@pytest.mark.parametrize(
    "sheet",
    ["detailed", pytest.param("ideal", marks=pytest.mark.release), pytest.param("none", marks=pytest.mark.release)],
)
def test_the_sky_is_transparent_through_the_sheets_too(sheet):
    scene = Spheres(sheet=sheet, alpha=66, prisms=12, z1=8, line=(0, 0), aperture=2.4, background="transparent")
    alpha = render(scene, **SIZE)[..., 3]
    assert (alpha[:, :4] == 0).all() and (alpha[:4] == 0).all()  # beside the window
    assert alpha[32, 9] == 255  # the window frame
    behind = alpha[18:46, 18:46]
    assert (behind == 0).mean() > (0.25 if sheet == "detailed" else 0.7)
    assert alpha[30:34, 30:34].max() == 255  # the sphere


def test_the_colours_in_front_of_a_background_are_those_of_the_scene():
    scene = Chess(sheet="none", background="transparent", eye=(0, -0.5), aperture=2.4)
    shown = render(scene, **SIZE).astype(float)
    white = render(scene.replace(background="white"), **SIZE)
    assert (shown[:8, :, 3] == 0).all() and (shown[-8:, :, 3] == 255).all()
    opaque = shown[..., 3] == 255
    assert abs(shown[opaque][:, :3] - white[opaque]).max() <= 1
    assert (white[shown[..., 3] == 0] == 255).all()


def test_alpha_is_of_linear_light():
    """A half covered pixel of the colour 0.5: 0.25 in front of black, 0.75 in front of white."""
    black, white = (np.full((1, 1, 3), value, np.uint8) for value in (137, 225))
    scene, rendering = Chess(background="transparent"), Rendering()
    red, _, _, alpha = composed([black, white], scene, rendering)[0, 0].tolist()
    assert abs(alpha - 127.5) < 2 and abs(red - 188) < 2


def test_transparency_goes_to_png_only(tmp_path):
    line = ["--background=transparent", "--size=32x32", "--antialias=off"]
    assert povgen(["frame", "chess", "--sheet=none", "--caption=full", "--overlay", *line], tmp_path)[0] == 0
    assert iio.imread(tmp_path / "frame.png").shape[1:] == (32, 4)
    for name in ("x.mp4", "x.webm", "x.gif"):
        assert "background = 'transparent'" in refused(["movie", "vary-alpha", "-o", name, *line], tmp_path)
    assert "background" in refused(["movie", "vary-alpha", "--shard=1/9", *line], tmp_path)
    assert "'black'" in refused(["pov", "chess", line[0]], tmp_path)
    for colour, number in (("black", 0), ("white", 1)):
        source = to_pov(Chess(sheet="none", background=colour))
        assert f"background {{ rgb {number} }}" in source and "sky_sphere" not in source


def test_two_eyes():
    scene = Chess(sheet="ideal", eye=(0.3, 0.1))
    eyes = [render(Chess(sheet="ideal", eye=(x, 0.1)), **SIZE) for x in (0.1, 0.5)]
    pair = render(scene, stereo="pair", eye_distance=0.4, **SIZE)
    assert (pair == np.concatenate(eyes, axis=1)).all()
    anaglyph = render(scene, stereo="anaglyph", eye_distance=0.4, **SIZE)
    assert (anaglyph[..., 0] == eyes[0][..., 0]).all() and (anaglyph[..., 1:] == eyes[1][..., 1:]).all()


def test_each_eye_has_its_own_overlay():
    scene = Chess(sheet="ideal", alpha=90)
    rendering = {"stereo": "pair", "eye_distance": 1, "overlay": True, **SIZE}
    left, right = (render(view, **SIZE, overlay=True) for view in views(scene, Rendering(**rendering)))
    assert (render(scene, **rendering) == np.concatenate((left, right), axis=1)).all()


@pytest.mark.parametrize(("stereo", "width"), [("pair", 64), pytest.param("anaglyph", 32, marks=pytest.mark.release)])
def test_two_eyes_and_transparency(stereo, width):
    scene = Chess(sheet="none", background="transparent")
    rendering = Rendering(stereo=stereo)
    shown = views(scene, rendering)
    assert [(view.E, view.background) for view in shown] == [
        (-0.1, "black"),
        (-0.1, "white"),
        (0.1, "black"),
        (0.1, "white"),
    ]
    picture = render(scene, stereo=stereo, size=(32, 32), antialias="off")
    assert picture.shape == (32, width, 4) and set(picture[[0, -1], :, 3].ravel()) == {0, 255}


def test_movies_for_two_eyes(tmp_path):
    spec = MovieSpec.load("vary-alpha").with_fixed({"sheet": "none"})
    options = {"stereo": "pair", "size": (32, 32), "antialias": "off"}
    path = movie(spec.replace(frames=2, hold=0), tmp_path / "pair.mp4", caption="none", **options).path
    assert iio.imread(path).shape == (2, 32, 64, 3)


LINE = ["--size=32x32", "--antialias=off", "--stereo=pair"]


def test_messages_count_pictures_not_the_frames_that_they_are_composed_of(tmp_path):
    narrow = ["--z2=0.5", "--prisms=30", "--view=0.1", "--background=transparent"]
    error = povgen(["frame", "chess", *narrow, *LINE], tmp_path)[2]
    assert error.startswith("povgen: warning: z2 = 0.5 and an eye at -0.1,0: ") and "frames" not in error
    movie = ["movie", "chess", "--sweep", "x=0:1", "--frames=3", "--sheet=none", *LINE]
    assert povgen([*movie, "--shard=1/2"], tmp_path)[1] == "rendered shard 1/2: 2 frames\n"
    late = [*movie, "--timeout=0.001", "--eye=0.3,0", "-o", "x.mp4"]
    error = povgen(late, tmp_path)[2]
    assert error.startswith("povgen: 3 of 3 frames failed.\n") and error.count("in the frame with ") == 3
    assert all(error.count(f", x = {x}") == 1 for x in (0.0, 0.5, 1.0))


def test_an_eye_that_cannot_be_is_said_to_be_one_of_two(tmp_path):
    error = refused(["frame", "chess", "--eye=10,0", *LINE], tmp_path)
    assert error.startswith("povgen: eye_distance = 0.2: for one of the two eyes, eye = (10.1, 0.0): ")
    refused(["movie", "vary-alpha", "--eye=10,0", *LINE], tmp_path)


def test_one_eye_has_no_distance(tmp_path):
    for command in (["frame", "chess"], ["movie", "vary-alpha", "--stereo=none"], ["demo"]):
        assert "eye_distance = 0.4: one eye" in refused([*command, "--eye-distance=0.4"], tmp_path)
    pair = Rendering(stereo="pair", eye_distance=0.4)
    assert pair.replace(stereo="none").replace(stereo="pair") == pair


def test_the_page_shows_one_eye(tmp_path):
    assert "stereo" in refused(["demo", "--stereo=pair"], tmp_path)
