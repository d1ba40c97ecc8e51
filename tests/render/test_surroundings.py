"""Surroundings and floors from pictures, in both renderers."""

import base64
import pickle
import re
import struct
import subprocess
import sys
import zlib
from io import BytesIO

import numpy as np
import pytest
from conftest import picture, povgen, refused, some
from PIL import Image, ImageCms

from povgen import Chess, InputError, MovieSpec, Spheres, remedies, render, save, to_pov
from povgen.inputs import hdr, pictures
from povgen.inputs.picture_reader import colours, exr
from povgen.liveview.values import values as live_values
from povgen.rendering.light import linear
from povgen.scene import materials
from povgen.scene.presets import input_files

SIZE = (160, 120)
OPTIONS = {"size": SIZE, "antialias": "off"}
RENDERERS = pytest.mark.parametrize("renderer", ["povray", "gl"])


def directions(scene):
    """Return the unit directions from the eye to the pixels: (height, width, 3)."""
    width, height = SIZE
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - 0.5 - np.arange(height))
    towards = np.stack([x, y, np.full(x.shape, scene.z2 * height / scene.view)], -1)
    return towards / np.linalg.norm(towards, axis=-1, keepdims=True)


@RENDERERS
def test_each_direction_shows_its_place_in_the_picture(renderer, tmp_path):
    """The picture's middle is straight ahead, its right quarter to the right, its upper edge above."""
    scene = Spheres(sheet="none", sky=picture(tmp_path), z1=5000, line=(9, 9), view=20)
    shown = render(scene, renderer=renderer, **OPTIONS)
    x, y, z = np.moveaxis(directions(scene), -1, 0)
    stored = np.asarray(Image.open(tmp_path / "picture.png"))
    wanted = 64 * (0.5 + np.arctan2(x, z) / (2 * np.pi)), 32 * (0.5 - np.arcsin(y) / np.pi)
    light = linear(stored[0, :, 0][None, :, None])[0, :, 0], linear(stored[:, 0, 1][None, :, None])[0, :, 0]
    for channel, (place, values) in enumerate(zip(wanted, light, strict=True)):
        found = np.interp(linear(shown)[..., channel], values, np.arange(len(values)) + 0.5)
        error = abs(found - place)[:, :40]  # left of the frame; between 8 bits are 0.25 of the picture's pixels
        assert np.percentile(error, 95) < 0.3


@RENDERERS
def test_mountains_are_those_of_the_panorama(renderer):
    shown = render(Spheres(sheet="none", z1=5000, line=(9, 9), view=8), renderer=renderer, **OPTIONS)
    x, y, z = np.moveaxis(directions(Spheres(view=8)), -1, 0)
    low, high = (float(materials.PANORAMA[end]) for end in ("low", "high"))
    stored = np.asarray(Image.open(pictures.MOUNTAINS).resize((1024, 83), Image.Resampling.BOX))
    place = 1024 * (0.5 + np.arctan2(x, z) / (2 * np.pi)), 83 * (high - y) / (high - low)
    seen = (y > 0.03) & (y < 0.3) & (abs(x / z) > 0.35)  # beside the frame
    wanted = stored[place[1][seen].astype(int), place[0][seen].astype(int)]
    assert seen.sum() > 1000 and abs(shown[seen].astype(int) - wanted).mean() < 7 < np.ptp(wanted, axis=0).min() / 8


@RENDERERS
def test_the_picture_is_turned_behind_the_ideal_sheet(renderer, tmp_path):
    plain, turned = (
        render(
            Spheres(sheet=sheet, alpha=180, sky=picture(tmp_path), z1=5000, line=(9, 9)), renderer=renderer, **OPTIONS
        )
        for sheet in ("none", "ideal")
    )
    inside = slice(40, 80), slice(60, 100)
    assert abs(plain[inside].astype(int) - turned[inside][::-1, ::-1]).max() <= 3 < np.ptp(plain[inside][..., 0])


@RENDERERS
def test_the_floor_shows_copies_of_the_picture(renderer, tmp_path):
    """Red grows to the right within a copy, green towards the eye. The left edge of a copy is at x = 0."""
    scene = Chess(
        sheet="none", view=9, z1=5000, piece="pawn", pedestal=0, floor=f"{picture(tmp_path, (64, 64))},width=6"
    )
    shown = render(scene, renderer=renderer, **OPTIONS).astype(int)
    x, y, z = np.moveaxis(directions(scene), -1, 0)
    with np.errstate(divide="ignore"):
        away = scene.floor_y / y
    place = away * x, away * z - scene.z2
    near = (y < 0) & (away < 12) & (abs(place[0]) > 2.4) & ((abs(place[0]) % 6 - 3) ** 2 < 6) & (place[1] < 0)
    assert near.sum() > 500
    red, green = (linear(np.uint8(shown))[..., k][near] for k in (0, 1))
    u, v = (place[0] / 6 % 1)[near], (-place[1] / 6 % 1)[near]
    for found, part in ((red, u), (green, v)):
        assert np.corrcoef(found, linear(np.uint8(255 * part)[None, :, None])[0, :, 0])[0, 1] > 0.98


@RENDERERS
def test_without_a_floor(renderer):
    tiles, none = (
        render(Chess(sheet="none", floor=f, view=5), renderer=renderer, **OPTIONS).astype(int)
        for f in ("tiles", "none")
    )
    corner = slice(-12, None), slice(0, 20)
    assert np.ptp(tiles[corner].mean(-1)) > 40 > 5 > np.ptp(none[corner].mean(-1))
    assert (tiles == none).all(-1)[:40].mean() > 0.99


def test_the_picture_and_not_its_name_decides_what_is_shown(tmp_path):
    first = render(Chess(sheet="none", sky=picture(tmp_path)), **OPTIONS)
    Image.new("RGB", (8, 4), "red").save(tmp_path / "picture.png")
    then = render(Chess(sheet="none", sky=tmp_path / "picture.png"), **OPTIONS)
    assert tuple(then[5, 5]) == (255, 0, 0) != tuple(first[5, 5])


def test_grey_of_16_bits_is_that_of_8(tmp_path):
    grey = np.tile(np.arange(0, 256, 2, np.uint8), (64, 1))
    Image.fromarray(grey).save(tmp_path / "eight.png")
    for name in ("grey.png", "grey.tif"):
        Image.fromarray(grey.astype(np.uint16) * 257).save(tmp_path / name)
        assert Image.open(tmp_path / name).mode[0] == "I"
        assert pictures.sky(tmp_path / name).file is pictures.sky(tmp_path / "eight.png").file
    for numbers in (grey.astype(np.float32) / 255, grey.astype(np.int32)):  # white is not known
        Image.fromarray(numbers).save(tmp_path / "other.tif")
        with pytest.raises(ValueError, match="^should be a picture of 8 or 16 bits without sign; for light"):
            pictures.sky(tmp_path / "other.tif")


def test_a_photo_is_turned_as_its_exif_data_say(tmp_path):
    upright = Image.open(picture(tmp_path)).convert("RGB")
    exif = Image.Exif()
    for orientation, stored in ((3, Image.Transpose.ROTATE_180), (6, Image.Transpose.ROTATE_90)):
        exif[0x112] = orientation
        upright.transpose(stored).save(tmp_path / "photo.png", exif=exif)
        assert colours((tmp_path / "photo.png").read_bytes()).tobytes() == upright.tobytes()
    upright.save(tmp_path / "damaged.png", exif=b"Exif\0\0MM damaged")
    assert colours((tmp_path / "damaged.png").read_bytes()).tobytes() == upright.tobytes()


def test_the_source_names_a_new_file_beside_it(tmp_path):
    """povgen writes this file. Nothing of the user's file but its colours gets there, and its path in the record."""
    path = picture(tmp_path)
    secret = Image.open(path)
    secret.save(path, comment="secret", exif=b"Exif\0\0secret")
    assert (
        povgen(["pov", "chess", "--sheet", "none", "--sky", path, "--size", "64x48", "-o", "a.pov"], tmp_path)[0] == 0
    )
    source, _, _ = (tmp_path / "a.pov").read_text().partition("// povgen record")
    (name,) = re.findall(r'png "(.*)" gamma', source)
    assert pictures.NAME.fullmatch(name) and path not in source
    assert b"secret" not in (tmp_path / name).read_bytes()
    command = ["povray", "+Ia.pov", "+W64", "+H48", "-A", "-D", "+Oown.png"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    wanted = render(Chess(sheet="none", sky=path), size=(64, 48), antialias="off")
    assert (np.asarray(Image.open(tmp_path / "own.png").convert("RGB")) == wanted).all()


def light_of(path):
    """Write a sky (32, 64) of light up to 4, as an EXR file and as a Radiance file with run lengths. Return it."""
    light = np.full((32, 64, 3), 0.1, np.float32)
    light[..., 0], light[..., 1] = np.linspace(0.01, 4, 64), np.linspace(2, 0.01, 32)[:, None]
    light[:4] = 0
    OpenEXR = pytest.importorskip("OpenEXR")
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": light}).write(str(path / "sky.exr"))
    head, _, body = hdr.written(light).partition(b"+X 64\n")
    rows = b""
    for row in np.frombuffer(body, np.uint8).reshape(32, 64, 4):
        rows += bytes((2, 2, 0, 64))
        for channel in row.T:  # a run where all are equal, else as they are
            same = (channel == channel[0]).all()
            rows += bytes((128 + 64, channel[0])) if same else bytes((40, *channel[:40], 24, *channel[40:]))
    (path / "sky.hdr").write_bytes(head + b"+X 64\n" + rows)
    return light


@RENDERERS
def test_a_sky_can_be_brighter_than_white(renderer, tmp_path):
    light = light_of(tmp_path)
    skies = [
        Spheres(sheet="none", sky=tmp_path / f"sky.{kind}", z1=5000, line=(9, 9), view=20) for kind in ("hdr", "exr")
    ]
    shown, other = (render(scene, renderer=renderer, linear=True, **OPTIONS) for scene in skies)
    assert (shown == other).all()
    x, y, z = np.moveaxis(directions(skies[0]), -1, 0)
    u, v = 64 * (0.5 + np.arctan2(x, z) / (2 * np.pi)) - 0.5, 32 * (0.5 - np.arcsin(y) / np.pi) - 0.5
    wanted = np.stack([np.interp(u, np.arange(64), light[9, :, 0]), np.interp(v, np.arange(32), light[:, 9, 1])], -1)
    assert abs(shown[..., :2] - wanted)[:, :40].max() < 0.03 and shown[:, :40].max() > 1.2  # left of the frame
    clipped = render(skies[0], renderer=renderer, **OPTIONS)
    assert (clipped[:, :40, 0][wanted[:, :40, 0] > 1.02] == 255).all()


def test_light_is_stored_as_a_radiance_file(tmp_path):
    light = light_of(tmp_path)
    stored = hdr.written(light)
    assert hdr.written(hdr.read(stored)) == stored and (hdr.read(stored)[:4] == 0).all()
    greatest = np.broadcast_to(light.max(-1, keepdims=True), light.shape)
    assert (abs(hdr.read(stored) - light) <= greatest / 256).all()
    assert (hdr.read((tmp_path / "sky.hdr").read_bytes()) == hdr.read(stored)).all()
    odd = np.tile(np.float32([[[np.nan, -1, np.inf]]]), (2, 4, 1))
    (tmp_path / "odd.exr").write_bytes(b"")
    import OpenEXR

    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": odd}).write(str(tmp_path / "odd.exr"))
    assert (exr(tmp_path / "odd.exr")[0, 0] == (0, 0, hdr.MOST)).all()


def test_a_sky_of_light_is_made_again_and_shown_live(tmp_path):
    light_of(tmp_path)
    scene = Chess(sheet="none", sky=tmp_path / "sky.exr")
    first = save(scene, tmp_path / "a.png", **OPTIONS)
    (tmp_path / "sky.exr").unlink()
    again = Chess.from_file(first)
    assert again == scene and (render(again, **OPTIONS) == render(scene, **OPTIONS)).all()
    image = Image.open(BytesIO(base64.b64decode(live_values(scene)["pictures"]["sky"]["data"].partition(",")[2])))
    assert image.format == "PNG" and image.size == (64, 32)
    red = 255 * (1.055 * np.linspace(0.01, 4, 64)[10] ** (1 / 2.4) - 0.055)
    assert image.getpixel((63, 9))[0] == 255 and abs(image.getpixel((10, 9))[0] - red) < 2


def test_another_process_knows_the_picture_of_a_scene_that_it_is_sent(tmp_path):
    Image.new("RGB", (64, 32), (9, 60, 200)).save(tmp_path / "sky.png")
    scene = Chess(sheet="ideal", sky=tmp_path / "sky.png", floor=f"{tmp_path / 'sky.png'},width=4")
    sent = pickle.dumps(scene)
    code = (
        "import pickle, sys; from povgen import render; from povgen.liveview.view import html\n"
        "scene = pickle.load(sys.stdin.buffer); html(scene)\n"
        "pixels = [render(scene, size=(32, 32), antialias='off', renderer=each) for each in ('povray', 'gl')]\n"
        "sys.stdout.buffer.write(pickle.dumps(pixels))"
    )
    (tmp_path / "sky.png").unlink()
    answer = subprocess.run([sys.executable, "-c", code], input=sent, capture_output=True, check=True).stdout
    for renderer, pixels in zip(("povray", "gl"), pickle.loads(answer), strict=True):
        assert np.array_equal(
            pixels, render(scene, **OPTIONS | {"renderer": renderer, "size": (32, 32), "antialias": "off"})
        )


def test_damaged_light_is_refused(tmp_path, capfd):
    light_of(tmp_path)
    radiance, exr = ((tmp_path / f"sky.{kind}").read_bytes() for kind in ("hdr", "exr"))
    plain = radiance.partition(b"\n\n")[0]
    for data, said in (
        (radiance[:-9], "should be a whole Radiance file"),
        (radiance.replace(b"rgbe", b"xyze"), r"red, green and blue \(32-bit_rle_rgbe\), not '32-bit_rle_xyze'"),
        (plain + b"\n\n-Y 99999 +X 99999\n", "of at most 33554432 pixels"),
        (exr[:-9], "should be a whole picture"),
    ):
        (tmp_path / "own.hdr").write_bytes(data)
        with pytest.raises(InputError, match=said) as caught:
            Chess(sky=tmp_path / "own.hdr")
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="should be a picture of colours: PNG"):
        Chess(floor=tmp_path / "sky.hdr")
    assert capfd.readouterr() == ("", "")  # what OpenEXR says


def test_without_openexr_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    light_of(tmp_path)
    pictures._decoded.cache_clear()  # another test of this process may have read the same picture
    (tmp_path / "OpenEXR.py").write_text("raise ImportError")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(InputError, match=re.escape(f"needs OpenEXR, which is not installed: {remedies.extra('exr')}")):
        Chess(sky=tmp_path / "sky.exr")


def test_what_replaces_what(tmp_path):
    path = picture(tmp_path)
    scene = Chess(sky=path, floor=path)
    assert Chess(**scene.model_dump()) == scene == scene.replace(alpha=66) and input_files([scene]) == {path}
    assert "picture-" not in to_pov(Chess(sky=path, background="black"))
    text = '[fixed]\nsky = "picture.png"\nfloor = "none"\n[[sweep]]\nparameter = "alpha"\nstart = 1\nstop = 9'
    spec = MovieSpec.parse(f'title = "T"\nscene = "chess"\n{text}', "spec", tmp_path)
    assert spec.scenes("draft")[0].sky == scene.sky
    assert "picture.png" in refused(["frame", "chess", "--sky", "picture.png", "-o", "picture.png"], tmp_path)


def damaged(tmp_path, data):
    (tmp_path / "own.png").write_bytes(data)
    return tmp_path / "own.png"


def test_what_is_refused(tmp_path):
    path = picture(tmp_path)
    Image.new("RGB", (64, 64)).save(tmp_path / "square.png")
    Image.new("L", (8, 4)).save(tmp_path / "own.gif")
    Image.new("L", (8194, 4097)).save(tmp_path / "large.png")
    for values, said in (
        ({"sky": tmp_path / "large.png"}, "should be a picture of 2x2 to 8192x4096 pixels, not 8194x4097"),
        ({"sky": tmp_path / "square.png"}, r"twice as wide as high \(equirectangular\), not 64x64 pixels"),
        ({"sky": tmp_path / "no.png"}, "No such file"),
        ({"floor": damaged(tmp_path, b"P6 1 1 255 abc")}, "should be a whole picture: PNG, JPEG, WEBP, TIFF"),
        ({"floor": tmp_path / "own.gif"}, "should be a whole picture: PNG"),
        ({"floor": f"{path},width=0"}, "should have a width from 0.1 to 1000 tiles, not width=0"),
        ({"floor": f"{path},width=1001"}, "not width=1001"),
        ({"sky": {"path": "x", "name": '"', "size": (2, 1), "mean": (0, 0, 0)}}, "should be a picture's file"),
    ):
        with pytest.raises(InputError, match=said) as caught:
            Chess(**values)
        assert "\n" not in str(caught.value)


AP0 = 0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767
D50 = 0.3457, 0.3585


def exr_of(path, channels, **header):
    """Write an EXR file with these channels, each (height, width), and return its path."""
    OpenEXR = pytest.importorskip("OpenEXR")
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, channels).write(str(path / "a.exr"))
    return path / "a.exr"


@pytest.mark.parametrize(
    ("chromaticities", "stored", "wanted"),
    [
        (AP0, (0.4077147, 0.16267508, 0.11216602), (0.8, 0.1, 0.1)),  # another program's numbers for this colour
        ((*hdr.SRGB[:6], *D50), (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)),  # white stays white
        ((1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1 / 3, 1 / 3), (0.4124 / 0.9505, 0.2126, 0.0193 / 1.089), (1, 0, 0)),  # XYZ
        ((0.3,) * 8, (0.5, 0.5, 0.5), None),
    ],
)
def test_primaries_and_white_of_light_are_those_of_srgb(chromaticities, stored, wanted, tmp_path):
    """An EXR file states them as chromaticities, a Radiance file as PRIMARIES."""
    light = np.tile(np.float32(stored), (2, 4, 1))
    of_exr = exr_of(tmp_path, {"RGB": light}, chromaticities=chromaticities)
    stated = b"PRIMARIES= " + " ".join(map(str, chromaticities)).encode()
    of_hdr = hdr.written(light).replace(b"\n\n", b"\nEXPOSURE=3\nCOLORCORR= 2 1 1\n" + stated + b"\n\n")
    for read, file, accuracy in ((exr, of_exr, 4e-3), (hdr.read, of_hdr, 0.02)):
        if wanted:
            assert abs(read(file) - wanted).max() < accuracy
        else:
            with pytest.raises(ValueError, match="should state the chromaticities of colours, not"):
                read(file)


def test_which_exr_files_are_pictures(tmp_path):
    """What is stored as another picture than R, G and B of all pixels is refused: it would be shown as another."""
    light = np.full((2, 4, 3), 0.5, np.float32)
    mixed = {"R": light[..., 0], "G": light[..., 1], "B": light[..., 2], "A": light[..., 0].astype(np.float16)}
    for channels in ({"RGB": light.astype(np.float16)}, {"RGBA": np.dstack((light, light[..., 0]))}, mixed):
        assert (exr(exr_of(tmp_path, channels)) == light).all()
    window = {"displayWindow": ((0, 0), (7, 3)), "dataWindow": ((0, 0), (3, 1))}
    cropped = {name: tuple(np.array(end, np.int32) for end in ends) for name, ends in window.items()}
    for channels, header in (({"Y": light[..., 0]}, {}), ({"a.RGB": light}, {}), ({"RGB": light}, cropped)):
        file = exr_of(tmp_path, channels, **header)
        with pytest.raises(ValueError, match="should be an EXR file whose first part has R, G and B for every pixel"):
            exr(file)
    file = exr_of(tmp_path, {"RGB": light})
    samples = b"B\0" + struct.pack("<5I", 2, 0, 1, 1, 0)[:16]  # of 32 bits; each pixel along x and y
    file.write_bytes(file.read_bytes().replace(samples, samples[:10] + struct.pack("<2I", 2, 2)))
    with pytest.raises(InputError):
        Chess(sky=file)


@pytest.mark.parametrize("order", ["-Y 3 +X 4", "+Y 3 +X 4", "-Y 3 -X 4", "+Y 3 -X 4"])
@pytest.mark.parametrize("by_columns", [False, True])
def test_a_radiance_file_states_where_its_rows_begin(order, by_columns):
    light = np.arange(1, 37, dtype=np.float32).reshape(3, 4, 3)
    stored = light[:: 1 if order[0] == "-" else -1, :: 1 if order[5] == "+" else -1]
    if by_columns:
        stored, order = stored.swapaxes(0, 1), f"{order[5:]} {order[:4]}"
    data = hdr.written(stored).replace(b"-Y 4 +X 3" if by_columns else b"-Y 3 +X 4", order.encode())
    assert (np.round(hdr.read(data) - 0.06) == light).all()


def test_pixels_without_run_lengths():
    head = b"#?RGBE\n# no FORMAT\n\n -Y    2 +X   8 \n"  # padded, as some programs write it
    assert (hdr.read(head + bytes((9, 9, 9, 136)) * 16)[..., 1] == 9.5).all()
    with pytest.raises(ValueError, match="a whole Radiance file, without run lengths of before 1991"):
        hdr.read(head + bytes((9, 9, 9, 136, 1, 1, 1, 15)))


def profile_of(space="sRGB"):
    return ImageCms.ImageCmsProfile(ImageCms.createProfile(space)).tobytes()


def exchanged():
    """Return a profile of sRGB whose red and green are exchanged, by the names of its parts."""
    return profile_of().replace(b"rXYZ", b"tXYZ").replace(b"gXYZ", b"rXYZ").replace(b"tXYZ", b"gXYZ")


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png_with(colour, *chunks, mode="RGB", **options):
    """Return a PNG file of one colour, with these parts, each a name and its data."""
    file = BytesIO()
    Image.new(mode, (8, 4), colour).save(file, "png", **options)
    return file.getvalue()[:33] + b"".join(chunk(*each) for each in chunks) + file.getvalue()[33:]


P3 = struct.pack(">8I", 31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000)
LINEAR = (b"gAMA", struct.pack(">I", 100000))
CICP_P3, CICP_SRGB = ((b"cICP", bytes(numbers)) for numbers in ((12, 13, 0, 1), (1, 13, 0, 1)))


def file_of(picture, kind, **options):
    file = BytesIO()
    picture.save(file, kind, **options)
    return file.getvalue()


GREY = Image.fromarray(np.full((4, 8), 1000, np.uint16))
LAB = ImageCms.profileToProfile(
    Image.new("RGB", (8, 4), (200, 30, 30)), *map(ImageCms.createProfile, ("sRGB", "LAB")), outputMode="LAB"
)
RED = Image.new("RGB", (8, 4), (200, 30, 30))
# Exif data whose interoperability index says Adobe RGB, as cameras write it: three tables of one entry each
ADOBE = b"Exif\0\0II*\0\x08\0\0\0" + b"".join(
    struct.pack("<3HI4sI", 1, *entry, 0)
    for entry in (
        (0x8769, 4, 1, struct.pack("<I", 26)),
        (0xA005, 4, 1, struct.pack("<I", 44)),
        (1, 2, 4, b"R03\0"),
    )
)


@pytest.mark.parametrize(
    ("data", "wanted"),
    [
        (png_with((200, 30, 30), icc_profile=exchanged()), (30, 200, 30)),
        (png_with(200, mode="L", icc_profile=profile_of()), (200, 200, 200)),
        (png_with((200, 30, 30), CICP_SRGB, icc_profile=exchanged()), (200, 30, 30)),
        (png_with((200, 30, 30), CICP_P3), "its chunk cICP states other colours"),
        (png_with((55, 55, 55), LINEAR), (128, 128, 128)),
        (png_with((55, 55, 55), LINEAR, (b"sRGB", b"\0")), (55, 55, 55)),
        (png_with((55, 55, 55), (b"gAMA", struct.pack(">I", 45455))), (55, 55, 55)),
        (png_with((55, 55, 55), (b"gAMA", bytes(4))), "a gamma above 0"),
        (png_with((200, 100, 50), (b"cHRM", P3)), (215, 93, 31)),  # Display P3, by CSS Color 4
        (png_with((0, 0, 0), icc_profile=b"no profile" * 20), "whose ICC profile is whole"),
        (file_of(GREY, "tiff"), (4, 4, 4)),
        (file_of(GREY, "tiff", tiffinfo={262: 0}), (251, 251, 251)),  # 0 is white
        (
            file_of(GREY, "tiff").replace(b"\2\1\3\0\1\0\0\0\x10", b"\2\1\3\0\1\0\0\0\x0c"),
            (128, 128, 128),
        ),  # 0x803 of 12 bits
        (file_of(LAB, "tiff"), (200, 30, 30)),  # with its profile
        (
            file_of(RED, "tiff", tiffinfo={318: (0.3127, 0.329), 319: (0.68, 0.32, 0.265, 0.69, 0.15, 0.06)}),
            (218, 0, 6),
        ),
        (file_of(Image.new("L", (8, 4), 99), "tiff", tiffinfo={339: 2}), "without sign"),
        (file_of(RED, "jpeg", quality=100, icc_profile=exchanged()), (30, 200, 30)),
        (file_of(RED.convert("CMYK"), "jpeg", quality=100), (200, 30, 30)),
        (file_of(RED.convert("CMYK"), "jpeg", icc_profile=exchanged()), "for its colours, CMYK, not for 'RGB'"),
        (file_of(RED, "jpeg", quality=100, exif=ADOBE), (233, 24, 24)),
    ],
    ids=lambda value: "file" if isinstance(value, bytes) else None,  # the date in a profile changes its length
)
def test_what_files_state_about_their_colours(data, wanted):
    if isinstance(wanted, str):
        with pytest.raises(ValueError, match=wanted):
            colours(data)
    else:
        assert np.abs(np.subtract(colours(data).getpixel((3, 2)), wanted)).max() <= 2


TRANSPARENT = np.dstack([np.full((4, 8), 200, np.uint8)] * 2)
TRANSPARENT[2, 3, 1] = 254


@pytest.mark.parametrize(
    "data",
    [
        file_of(Image.fromarray(TRANSPARENT), "png"),
        file_of(Image.fromarray(TRANSPARENT).convert("RGBA"), "webp", lossless=True),
        file_of(RED.quantize(), "png", transparency=bytes([9])),
        png_with((7, 8, 9), (b"tRNS", struct.pack(">3H", 7, 8, 9))),
        file_of(GREY, "png")[:33] + chunk(b"tRNS", struct.pack(">H", 1000)) + file_of(GREY, "png")[33:],
    ],
    ids=lambda value: "file" if isinstance(value, bytes) else None,  # the date in a profile changes its length
)
def test_transparent_pixels_are_refused(data):
    with pytest.raises(ValueError, match="without transparent pixels"):
        colours(data)


def test_pixels_can_be_opaque():
    assert colours(file_of(RED.convert("RGBA"), "png")).tobytes() == RED.tobytes()
    assert colours(png_with((7, 8, 9), (b"tRNS", struct.pack(">3H", 7, 8, 8)))).getpixel((0, 0)) == (7, 8, 9)


@pytest.mark.parametrize("limit", some(["MAX_MEMORY = 100 << 20", "MAX_TIME = 1"], 1))
def test_a_picture_is_decoded_within_limits(limit, tmp_path, monkeypatch):
    """A JPEG file can repeat its last scan: 2000 times, decoding takes many seconds."""
    noise = Image.fromarray(np.random.default_rng(1).integers(0, 255, (512, 1024), np.uint8))
    jpeg = file_of(noise, "jpeg", progressive=True, quality=5)
    last = jpeg.rfind(b"\xff\xda")
    slow = jpeg[:-2] + jpeg[last:-2] * 2000 + jpeg[-2:]
    code = f"from povgen.inputs import picture_reader\npicture_reader.{limit}\npicture_reader.main()"
    done = subprocess.run([sys.executable, "-c", code], input=slow, capture_output=True, timeout=100)
    assert done.returncode or b'"fault"' in done.stdout
    monkeypatch.setattr(sys, "executable", "/bin/false")  # a process that ends without an answer
    with pytest.raises(InputError, match="should be a picture that needs less time and memory"):
        Chess(sky=picture(tmp_path, (62, 31)))
