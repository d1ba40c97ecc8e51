"""Pictures as light: floating-point numbers, EXR files and PNG files of 16 bits, by both renderers."""

import subprocess
import sys

import imageio_ffmpeg
import numpy as np
import OpenEXR
import pytest
from conftest import povgen, refused
from PIL import Image

from povgen import Chess, InputError, PovrayError, Rendering, Spheres, info, movie, remedies, render, save, show
from povgen.inputs import hdr
from povgen.rendering import cache, light, povray
from povgen.rendering.frames import is_whole, render_all

SCENE = Spheres(sheet="ideal", view=1.5, z1=(3, 6))  # with highlights
SIZE = (96, 72)
OFF = {"size": SIZE, "antialias": "off"}
RENDERERS = ("povray", "gl")


def read_exr(path):
    with OpenEXR.File(str(path)) as file:
        return file.channels()["RGB"].pixels


@pytest.mark.parametrize("renderer", RENDERERS)
@pytest.mark.parametrize("more", [{}, {"stereo": "anaglyph"}])
def test_light_is_that_of_the_bytes(renderer, more):
    """One ray a pixel: the bytes are the same light, clipped, in sRGB. POV-Ray's numbers have 11 bits."""
    options = OFF | more | {"renderer": renderer}
    found = render(SCENE, linear=True, **options)
    assert found.dtype == np.float32 and found.shape == (72, 96, 3) and found.flags.writeable
    assert found.max() > 1.2 and found.min() >= 0
    assert abs(hdr.encoded(found.clip(0, 1)) - render(SCENE, **options)).max() < 0.6
    assert np.array_equal(render(SCENE, bits=32, **options), found)
    assert np.array_equal(render(SCENE, linear=True, bits="32", **options), found)


def test_the_renderers_agree():
    one, other = (render(SCENE, linear=True, renderer=renderer, **OFF) for renderer in RENDERERS)
    differences = abs(one - other).max(axis=2)
    assert np.median(differences) < 0.001 and abs(one.mean() - other.mean()) < 0.003
    assert abs(one.max() / other.max() - 1) < 0.05


def test_light_above_white_is_averaged():
    """With 2x, POV-Ray's light is averaged as it is: a clipped highlight would be darker."""
    large = render(SCENE, linear=True, size=(192, 144), antialias="off")
    small = render(SCENE, linear=True, size=SIZE, antialias="2x")

    def averaged(picture):
        return np.stack([Image.fromarray(picture[..., k]).resize(SIZE, Image.BILINEAR) for k in range(3)], axis=-1)

    assert abs(averaged(large) - small).max() < 1e-6
    assert small.max() > 1.05 and abs(averaged(large.clip(0, 1)) - small).max() > 0.05
    drawn = render(SCENE, linear=True, size=SIZE, antialias="2x", renderer="gl")
    assert drawn.max() > 1.05 and abs(drawn.mean() - small.mean()) < 0.003


@pytest.mark.parametrize("renderer", RENDERERS)
def test_a_png_file_of_16_bits(renderer, tmp_path):
    options = OFF | {"renderer": renderer, "bits": 16}
    save(SCENE, tmp_path / "a.png", **options)
    read = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", tmp_path / "a.png"]
    read += "-f rawvideo -pix_fmt rgb48le -".split()
    found = np.frombuffer(subprocess.run(read, capture_output=True, check=True).stdout, np.uint16).reshape(72, 96, 3)
    assert np.array_equal(found, render(SCENE, **options))
    clipped = render(SCENE, **options | {"bits": 32}).clip(0, 1)
    assert abs(found - 65535 / 255 * hdr.encoded(clipped)).max() < 0.51
    assert len(np.unique(found)) > 2 * 256
    with Image.open(tmp_path / "a.png") as image:
        assert (image.info["srgb"], image.info["gamma"]) == (0, 0.45455)


@pytest.mark.parametrize("renderer", RENDERERS)
def test_an_exr_file_and_again(renderer, tmp_path):
    arguments = ["frame", "spheres", "--sheet", "ideal", "--view", "1.5", "--z1", "3", "--z1", "6", "--size", "96x72"]
    assert povgen([*arguments, "--renderer", renderer, "-o", "a.exr"], tmp_path) == (0, "wrote a.exr\n", "")
    found = read_exr(tmp_path / "a.exr")
    assert found.dtype == np.float32
    assert np.array_equal(found, render(SCENE, linear=True, size=SIZE, renderer=renderer))
    made = info(tmp_path / "a.exr")
    assert made.rendering.bits == 32 and made.frames[0]["view"] == 1.5
    assert povgen(["frame", "--from", "a.exr", "-o", "b.exr"], tmp_path) == (0, "wrote b.exr\n", "")
    assert np.array_equal(read_exr(tmp_path / "b.exr"), found)
    assert povgen(["frame", "--from", "a.exr"], tmp_path)[:2] == (0, "wrote frame.png\n")
    with Image.open(tmp_path / "frame.png") as image:
        assert np.array_equal(np.asarray(image), render(SCENE, size=SIZE, renderer=renderer))
    if renderer == "povray":  # another reader of the record, which is not OpenEXR's
        data = (tmp_path / "a.exr").read_bytes()
        for end in (0, 4, 20, data.index(b"povgen\0") + 30):
            (tmp_path / "short.exr").write_bytes(data[:end])
            with pytest.raises(InputError, match=r"short.exr': .*; allowed: a PNG, EXR"):
                info(tmp_path / "short.exr")


def test_numbered_files_of_light(tmp_path):
    """EXR files, and PNG files of 16 bits, are those of each scene alone."""
    scenes, options = [SCENE, SCENE.replace(alpha=30)], {"size": SIZE, "progress": False}
    assert movie(scenes, tmp_path / "new" / "%02d.exr", **options).path.suffix == ".exr"
    movie(scenes, tmp_path / "%d.png", bits=16, **options)
    for n, scene in enumerate(scenes, 1):
        assert np.array_equal(read_exr(tmp_path / "new" / f"0{n}.exr"), render(scene, linear=True, size=SIZE))
        save(scene, tmp_path / "own.png", bits=16, size=SIZE)
        alone, numbered = ((tmp_path / name).read_bytes() for name in ("own.png", f"{n}.png"))
        assert alone[alone.index(b"IDAT") :] == numbered[numbered.index(b"IDAT") :]
        assert info(tmp_path / f"{n}.png").rendering.bits == 16
    spec = ["movie", "spheres", "--sweep", "alpha=0:30", "--frames", "2", "--size", "32x32", "--quality", "draft"]
    assert povgen([*spec, "-o", "%d.exr"], tmp_path)[:2] == (0, "wrote %d.exr: 2 files\n")
    assert info(tmp_path / "2.exr").rendering.bits == 32 and info(tmp_path / "2.exr").frames[0]["alpha"] == 30
    assert "a name with a number, such as a%04d.exr, for an EXR file" in refused([*spec, "-o", "a.exr"], tmp_path)
    assert "bits = 16: an EXR file has 32" in refused([*spec, "-o", "%d.exr", "--bits", "16"], tmp_path)
    with pytest.raises(InputError, match="exists, and povgen did not write it"):
        (tmp_path / "1.exr").write_bytes(b"mine")
        movie(scenes, tmp_path / "%d.exr", **options)


def test_what_does_not_go_together(tmp_path):
    chess = ["frame", "chess"]
    for arguments, words in (
        ([*chess, "--bits", "16", "--caption=full"], "bits = 16: caption is drawn with 8 bits; allowed: bits = 8"),
        ([*chess, "-o", "a.exr", "--overlay"], "bits = 32: overlay is drawn with 8 bits"),
        ([*chess, "-o", "a.exr", "--background", "transparent"], "background = 'transparent': not with bits = 32"),
        ([*chess, "-o", "a.exr", "--bits", "16"], "bits = 16: an EXR file has 32; allowed: 32"),
        ([*chess, "--bits", "32"], "bits = 32: a PNG file has 8 or 16; allowed: 8 or 16"),
        ([*chess, "--bits", "12"], "bits = '12': should be 8, 16 or 32"),
        (["movie", "vary-alpha", "--bits", "16"], "bits = 16: a movie has 8; allowed: 8"),
    ):
        assert words in refused(arguments, tmp_path)
    for wrong, words in (
        (lambda: show(SCENE, bits=16), "bits = 16: an image of Pillow's has 8"),
        (lambda: render(SCENE, linear=1), "linear = 1: should be true or false"),
        (lambda: render(SCENE, linear=True, bits=8), "bits = 8: linear light has 32"),
        (lambda: movie([SCENE], tmp_path / "a.gif", bits=16), "bits = 16: a movie has 8"),
    ):
        with pytest.raises(InputError, match=words):
            wrong()


def test_without_the_library(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    for arguments in (["-o", "a.exr"], ["--bits", "16"], ["-o", "a.exr", "--renderer", "gl"]):
        assert f"bits: EXR files need OpenEXR, which is not installed: {remedies.pip()} install " in refused(
            ["frame", "chess", *arguments], tmp_path
        )
    assert render(SCENE, linear=True, renderer="gl", **OFF).max() > 1  # needs no EXR file


WHOLE = light.packed(np.random.default_rng(1).random((36, 48, 3), np.float32))
DAMAGED = {
    "empty": b"",
    "short": WHOLE[:-1],
    "changed": WHOLE[:2000] + bytes([WHOLE[2000] ^ 1]) + WHOLE[2001:],
    "another size": light.packed(np.zeros((36, 47, 3), np.float32)),
}


@pytest.mark.parametrize("kind", DAMAGED)
def test_what_is_no_frame_of_light(kind):
    assert is_whole(WHOLE, (48, 36), True) and not is_whole(DAMAGED[kind], (48, 36), True)


def test_a_picture_that_is_cut_off_is_refused(tmp_path):
    picture = tmp_path / "rays.ppm"
    whole = b"P6\n2 1\n65535\n" + bytes(12)
    picture.write_bytes(whole)
    assert light.read(picture, (2, 1)).shape == (1, 2, 3)
    for length in (24, 19, 5, 0):
        picture.write_bytes(whole[:length])
        with pytest.raises(PovrayError, match="not whole"):
            light.read(picture, (2, 1))


def test_light_is_kept_in_the_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    rendering = Rendering(size=(48, 36), antialias="off", bits=32)
    ((first,),) = render_all([Chess(sheet="none")], rendering)
    monkeypatch.setattr(povray.Runner, "run", lambda *_: pytest.fail("rendered again"))
    assert list(render_all([Chess(sheet="none")], rendering)) == [[first]]
    assert [path.suffix for path in cache.trim(-1)] == [".light"]


def test_frames_of_another_kind_have_another_key():
    for renderer in RENDERERS:
        paths = [cache.frame_path("text", Rendering(renderer=renderer, bits=bits)) for bits in (8, 16, 32)]
        assert paths[0] != paths[1] == paths[2]  # light is rendered once for both
