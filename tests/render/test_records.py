"""The record in a file: how it was made. With it the same picture is made again, and a stranger's file does no harm."""

import base64
import json
import os
import struct
import tomllib
import zlib

import numpy as np
import pytest
from conftest import picture, povgen, refused, some
from PIL import Image

from povgen import Chess, InputError, Rendering, Scene, Spheres, info, movie, render, save
from povgen import record as records
from povgen.cli import shared_options
from povgen.inputs import mesh, pictures, pieces
from povgen.liveview.values import values as live_values
from povgen.rendering import povray
from povgen.scene import scene as scene_module
from povgen.version import __version__
from povgen.video import still

SMALL = {"size": (48, 36), "antialias": "off"}
PIECE = "#declare Piece = cone { 0, 0.4, 1.2*y, 0.1 }\n"
PICTURES = {
    "law": (Chess(sheet="law", law="x - k*X*z, y, z", parameter={"k": 0.3}), {"quality": "draft", "size": (32, 32)}),
    "povray": (Chess(alpha=30.1, prisms=20, z1=3), {"size": (48, 36), "antialias": "1.5x"}),
    "ideal": (Spheres(sheet="ideal", eye=(0.1, 0), view=2), {"size": (48, 36)}),
    "gl": (Spheres(alpha=100 / 3, sheet="ideal"), SMALL | {"renderer": "gl"}),
    "pair": (Chess(sheet="ideal", x=(-1, 1), z1=(2, 3), piece=("king", "pawn")), SMALL | {"stereo": "pair"}),
    "anaglyph": (Chess(sheet="none"), SMALL | {"stereo": "anaglyph", "eye_distance": 0.3}),
    "transparent": (Chess(sheet="ideal", background="transparent"), SMALL),
    "drawn on": (Chess(sheet="ideal", predicted_image=True), SMALL | {"caption": "full", "overlay": True}),
    "windows": (Chess(sheet="ideal", window=[{"z": 2, "sheet": "lenslets", "ratio": 0.5}]), SMALL),
}


def pixels(path):
    with Image.open(path) as image:
        return np.asarray(image)


@pytest.mark.parametrize("change", [["--aperture", "6"], ["--size", "48x64"], ["--prisms", "10"]], ids=str)
def test_what_follows_from_a_changed_value_is_not_the_records(change, tmp_path):
    scene = ["frame", "chess", "--size", "64x48", "--renderer", "gl", "--antialias", "off"]
    for options in ([*scene, "-o", "a.png"], ["frame", "--from", "a.png", *change, "-o", "b.png"]):
        assert povgen(options, tmp_path)[0] == 0
    assert povgen([*scene, *change, "-o", "c.png"], tmp_path)[0] == 0
    views = [Scene.from_file(tmp_path / file).view for file in ("a.png", "b.png", "c.png")]
    assert views[0] != views[1] == views[2]
    assert povgen([*scene, "--view", "3", "-o", "a.png"], tmp_path)[0] == 0
    assert povgen(["frame", "--from", "a.png", *change, "-o", "b.png"], tmp_path)[0] == 0
    assert Scene.from_file(tmp_path / "b.png").view == 3  # it was stated


@pytest.mark.parametrize("kind", some([*PICTURES], 3))
def test_a_picture_is_made_again(kind, tmp_path, monkeypatch):
    scene, options = PICTURES[kind]
    save(scene, tmp_path / "a.png", **options)
    if kind == "povray":
        monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))  # rendered anew
    assert povgen(["frame", "--from", "a.png", "-o", "b.png"], tmp_path) == (0, "wrote b.png\n", "")
    assert np.array_equal(pixels(tmp_path / "a.png"), pixels(tmp_path / "b.png"))
    assert Scene.from_file(tmp_path / "a.png").model_dump() == scene.model_dump()
    again = render(type(scene).from_file(tmp_path / "b.png"), **info(tmp_path / "b.png").rendering.model_dump())
    assert np.array_equal(again, pixels(tmp_path / "a.png"))
    if kind == "law":  # other values replace the record's; a quality also replaces what follows from it
        assert povgen(["frame", "--from", "a.png", "--quality", "draft", "--parameter", "k=0.1"], tmp_path)[0] == 0
        made = info(tmp_path / "frame.png")
        assert made.rendering.size == (320, 240) and made.frames[0]["parameter"] == {"k": 0.1}
        # --sheet auto may choose the antialiasing, too
        given = [{"sheet": "auto"}, {"sheet": "auto", "antialias": "2x"}, {}]
        assert ["antialias" in shared_options.again(tmp_path / "a.png", None, values, True)[2] for values in given] == [
            0,
            1,
            1,
        ]


def test_a_piece_of_ones_own_is_in_the_record(tmp_path):
    (tmp_path / "mine.inc").write_text(PIECE)
    assert povgen(["frame", "chess", "--piece", "mine.inc", "--sheet", "none", "--size", "32x32"], tmp_path)[0] == 0
    (tmp_path / "mine.inc").unlink()
    assert povgen(["frame", "--from", "frame.png", "-o", "b.png"], tmp_path)[0] == 0
    assert np.array_equal(pixels(tmp_path / "frame.png"), pixels(tmp_path / "b.png"))
    assert info(tmp_path / "b.png").pieces == {"mine.inc": PIECE}


def test_files_that_a_scene_shows_are_in_the_record(tmp_path, monkeypatch):
    """A mesh, a sky, a floor, and a glass. The picture is made again without these files."""
    path = picture(tmp_path)
    (tmp_path / "a.obj").write_text("v -1 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    options = ["--piece", "a.obj,height=0.4", "--sky", path, "--floor", f"{path},width=3", "--glass", "N-SF11"]
    line = ["frame", "chess", "--quiet", *options, "--size", "64x48", "--antialias", "off"]
    assert povgen(line, tmp_path)[0] == 0
    monkeypatch.setattr(still, "MAX_LARGE", 10)
    assert povgen([*line, "-o", "bare.png"], tmp_path)[0] == 0
    (tmp_path / "a.obj").unlink()
    (tmp_path / "picture.png").unlink()
    monkeypatch.setattr(mesh, "text_and_note", None)
    assert povgen(["frame", "--quiet", "--from", "frame.png", "-o", "b.png"], tmp_path)[0] == 0
    assert np.array_equal(pixels(tmp_path / "frame.png"), pixels(tmp_path / "b.png"))
    assert povgen(["frame", "--quiet", "--from", "frame.png", "--sky", "mountains", "-o", "c.png"], tmp_path)[0] == 0
    assert [info(tmp_path / name).frames[0]["sky"] for name in ("b.png", "c.png")] == [str(path), None]
    said = refused(["frame", "--from", "bare.png"], tmp_path)
    assert "not in the record, which holds pieces, profiles and up to 4 pictures, of 4 MiB together" in said


def test_what_is_not_seen_is_not_embedded(tmp_path):
    """A sky behind another background, and profiles that no sheet has."""
    profile = tmp_path / "own.toml"
    profile.write_text("path = [2, 1]\noutline = [{ corners = [[0.1, 0], [0.9, 0], [0.5, 1], [0.1, 0]] }]")
    window = {"z": 2, "sheet": "mirror", "profile": profile}
    hidden = Chess(sheet="ideal", profile=profile, window=[window], sky=picture(tmp_path), background="black")
    made = still.record_of([hidden, hidden.replace(background="white")], Rendering())
    assert not made.pieces and not made.pictures and "own.toml" not in str(made) and "picture.png" not in str(made)
    assert not live_values(hidden)["pictures"]
    assert Chess.from_file(save(hidden, tmp_path / "a.png", **SMALL)).background == "black"
    seen = hidden.replace(background="sky", window=[{**window, "sheet": "profile"}])
    made = still.record_of([seen], Rendering())
    assert [*made.pieces] == [str(profile)] and [*made.pictures] == [str(tmp_path / "picture.png")]


def test_a_strangers_mesh_is_checked():
    own = "#declare Piece = mesh2 {\nvertex_vectors { 1,\n<1, 2, 3e-05> }\n"
    own += "face_indices { 1,\n<0, 0, 0> }\ninside_vector y\n}\n"
    assert mesh.is_own(own)
    for text in (own + "\n", own.replace("1, 2", "1 }} fog { distance 2"), own.replace("<0, 0", "<x, 0")):
        assert not mesh.is_own(text)


def test_what_a_record_says(tmp_path, monkeypatch):
    arguments = ["frame", "chess", "--sheet", "none", "--size", "32x32", "-o", "a b.png"]
    assert povgen(arguments, tmp_path)[0] == 0
    status, out, err = povgen(["info", "a b.png"], tmp_path)
    said = json.loads(out)
    assert (status, err) == (0, "")
    assert (said["povgen"], said["renderer"]) == (__version__, f"POV-Ray {povray.version()}")
    assert said["command"] == "povgen frame chess --sheet none --size 32x32 -o 'a b.png'"
    assert said["rendering"]["antialias"] == [1, 0.1, 2] and said["rendering"]["bits"] == 8  # defaults
    assert said["frames"][0]["scene"] == "chess" and said["frames"][0]["z2"] == 6 and said["frames"][0]["view"] == 3.7
    with Image.open(tmp_path / "a b.png") as image:
        assert image.info["srgb"] == 0 and image.info["gamma"] == 0.45455 and image.info["povgen"]
    save(Chess(sheet="none"), tmp_path / "a.png", **SMALL)
    assert info(tmp_path / "a.png").command.startswith("povgen.save(Chess(sheet='none'), '/")
    assert info(tmp_path / "a.png").command.endswith("a.png', size=(48, 36), antialias='off')")
    monkeypatch.setattr("povgen.cli.shared_options.__version__", "9.9")
    assert f"a.png: made by povgen {__version__} and POV-Ray" in povgen(["frame", "--from", "a.png"], tmp_path)[2]


SCENES = [Chess(sheet="none", x=x) for x in (-0.5, 0.25)] + [Spheres(sheet="none")]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    for kind in ("mp4", "webm", "webp", "gif"):
        movie(SCENES, folder / f"a.{kind}", frame_rate=4, title="What α does", progress=False, **SMALL)
    save(SCENES[0], folder / "a.png", **SMALL)
    return folder


@pytest.mark.parametrize("kind", some(["mp4", "gif", "webm", "webp"], 1))
def test_a_movie_is_made_again(kind, made):
    file = made / f"a.{kind}"
    assert Scene.list_from_file(file) == SCENES and info(file).frame_rate == 4
    assert info(file).frames[1] == {"x": 0.25}  # what differs from the first frame
    status, out, err = povgen(["movie", "--from", file.name, "--dry-run"], made)  # of the file's own name, too
    assert (status, err) == (0, "") and out.startswith("3 frames")
    assert "povgen reads this file" in povgen(["movie", "--from", file.name, "--dry-run", "-o", file.name], made)[2]
    status, _, err = povgen(["movie", "--from", file.name, "-o", f"b.{kind}", "--quiet"], made)
    assert (status, err) == (0, "")
    assert info(made / f"b.{kind}").title == info(file).title == "What α does"
    from imageio.v3 import imiter

    plugin = "pillow" if kind in ("gif", "webp") else None
    pictures = [[*imiter(made / name, plugin=plugin)] for name in (file.name, f"b.{kind}")]
    assert np.array_equal(*pictures) and len(pictures[0]) == 3


def test_numbered_pictures_are_made_again(tmp_path):
    """All have the antialiasing that suits the prisms of one of them."""
    scenes = [Chess(prisms=20, z1=3), Chess(sheet="none")]
    movie(scenes, tmp_path / "%d.png", size=(48, 36), progress=False)
    assert [info(tmp_path / f"{n}.png").rendering.antialias for n in (1, 2)] == ["1.5x"] * 2
    assert povgen(["frame", "--from", "2.png", "-o", "b.png", "--quiet"], tmp_path)[0] == 0
    assert np.array_equal(pixels(tmp_path / "2.png"), pixels(tmp_path / "b.png"))


def test_the_wrong_kind_of_file(made, tmp_path):
    for arguments, words in (
        (["frame", "--from", "a.gif"], "from = 'a.gif': a movie of 3 frames; allowed: a picture"),
        (["movie", "--from", "a.png"], "from = 'a.png': a picture; allowed: a movie"),
        (["movie", "--from", "a.gif", "--frames", "4"], "frames = '4': not with --from"),
        (["movie", "--from", "a.mp4"], "output = 'a.mp4': povgen reads this file"),
        (["frame", "chess", "--from", "a.png"], "scene = 'chess': not with --from, which shows the file's scene; "),
        (["frame"], "scene: missing; allowed: chess, spheres, room, or the TOML file of a room, or else --from FILE"),
        (["movie"], "spec: missing; allowed: "),
    ):
        assert words in refused(arguments, made)
    with pytest.raises(InputError, match="a movie of 3 frames; allowed: a picture, or list_from_file"):
        Scene.from_file(made / "a.webm")
    with pytest.raises(
        InputError, match=rf"a.png': its record, of .* {__version__}: scene = 'chess': allowed: spheres"
    ):
        Spheres.from_file(made / "a.png")


def with_record(folder, **changes):
    """Write a PNG file with a record in which these values, and those of the frame, differ."""
    values = info(folder / "a.png").model_dump(mode="json")
    values["frames"][0] |= changes.pop("frame", {})
    return with_text(folder, json.dumps(values | changes).encode())


def with_text(folder, text, form=1):
    first = b"povgen record %d %08x\n" % (form, zlib.crc32(text))
    data = b"iTXt" + b"povgen" + bytes(5) + first + text
    png = (folder / "a.png").read_bytes()
    part = struct.pack(">I", len(data) - 4) + data + struct.pack(">I", zlib.crc32(data))
    (folder / "changed.png").write_bytes(png[:33] + part + png[33:])  # before povgen's own
    return refused(["frame", "--from", "changed.png"], folder)


def test_a_strangers_record_is_checked(made, tmp_path):
    secret = tmp_path / "secret.inc"
    secret.write_text(PIECE)
    before = os.stat(secret).st_atime_ns
    for piece in (str(secret), [str(secret)]):
        assert "not in the record, which" in with_record(made, frame={"piece": piece})
    assert "should be a name or a file" in with_record(made, frame={"piece": 3})
    (tmp_path / "secret.toml").write_text("")
    window = f"z=2,sheet=profile,profile={tmp_path / 'secret.toml'}"
    for windows in (window, [window], {"z": 2, "profile": str(secret)}):
        assert "window = " in with_record(made, frame={"window": windows})
    assert "not in the record" in with_record(made, frame={"window": [{"z": 2, "profile": str(secret)}]})
    (made / "none").write_bytes((made / "a.png").read_bytes())
    assert "sky = 'none': not in the record" in with_record(made, frame={"sky": "none"})
    broken = (made / "a.png").read_bytes()[:60]
    said = with_record(made, frame={"sky": "none"}, pictures={"none": base64.b64encode(broken).decode()})
    assert "sky = 'none': should be a whole picture" in said
    assert os.stat(secret).st_atime_ns == before
    assert "should be a file of at most" in with_record(made, frame={"piece": "a"}, pieces={"a": " " * 2**21})
    assert "alpha = 361.0: should be less than" in with_record(made, frame={"alpha": 361.0})
    assert "alpha = nan: should be a finite number" in with_record(made, frame={"alpha": float("nan")})
    assert "'roughness': unknown in the scene chess" in with_record(made, frame={"roughness": 1})
    assert "'sharpness': unknown" in with_record(made, rendering={"sharpness": 1})
    assert "scene = 'castle': allowed: chess, spheres" in with_record(made, frame={"scene": "castle"})
    assert "frames = []" in with_record(made, frames=[])
    assert "the record of a newer povgen, of format 2; allowed: up to 1" in with_text(made, b"?", form=2)
    for text in (b"[" * 10**6, b"[]", b"null", b"{", b"", b"\xff"):
        assert "its record is damaged" in with_text(made, text)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"frames": [1] * 30_001}, "'frames': 30001 values; allowed: up to 30000"),
        ({"pictures": dict.fromkeys("abcde", "")}, "'pictures': 5 values; allowed: up to 4"),
        ({"rendering": {"size": [[]] * 1001}}, "'size': 1001 values; allowed: up to 1000"),
        ({"frame": {"window": [{"parameter": dict.fromkeys(map(str, range(1001)))}]}}, "'parameter': 1001 values"),
        (dict.fromkeys(map(str, range(1001))), "'record': 1012 values"),
    ],
)  # fmt: skip
def test_what_a_record_holds_is_counted_before_it_is_checked(changes, words, made):
    """pydantic would make an error of each wrong value."""
    assert f"'changed.png': its record: {words}" in with_record(made, **changes)


def test_each_file_in_a_record_is_checked_once(made, tmp_path, monkeypatch):
    """However many pieces, windows and frames name it."""
    with open(picture(tmp_path), "rb") as file:
        png = base64.b64encode(file.read()).decode()
    calls = []
    for module, name in ((pieces, "checked"), (pictures, "_decoded"), (tomllib, "loads")):
        function = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *a, f=function, n=name, **b: calls.append(n) or f(*a, **b))
    window = {"z": 30, "sheet": "profile", "profile": "own.toml"}
    shape = "path=[1, 2]\n[[outline]]\ncorners=[[0, -0.2], [1, -0.2]]\n[[outline]]\ncorners=[[1, 0.2], [0, 0.2]]\n"
    first = info(made / "a.png").frames[0] | {"sky": "a", "floor": "b", "window": [window, window | {"z": 60}]}
    first |= {"piece": ["mine"] * 3, "x": [-2, 0, 2], "profile": "own.toml", "sheet": "profile"}
    record = info(made / "a.png").replace(
        frames=[first, {"z1": 3}, {"z1": 4}],
        pieces={"mine": PIECE, "own.toml": shape},
        pictures={"a": png, "b": png},
    )
    scenes = scene_module.of_record(record)
    assert [scene.z1 for scene in scenes] == [2, 3, 4] and scenes[0].piece[0] is scenes[2].piece[2]
    assert sorted(calls) == ["_decoded", "_decoded", "checked", "loads"]
    monkeypatch.setattr(scene_module, "PATIENCE", -1)
    with pytest.raises(InputError, match="frames: 0 of 3 were checked within -1 s; allowed: "):
        scene_module.of_record(record)


def test_a_time_limit_is_no_part_of_a_record(made):
    values = info(made / "a.png").model_dump(mode="json")
    assert "timeout" not in values["rendering"]
    record = records.Record(**values | {"rendering": values["rendering"] | {"timeout": 1e6}})
    assert record.rendering == info(made / "a.png").rendering and record.rendering.timeout == 1800


@pytest.mark.parametrize("kind", some(["png", "mp4", "webm", "webp", "gif"], 2))
def test_a_damaged_file(kind, made, tmp_path, rng):
    """Whatever is in it, povgen says so in one line. A record that is not damaged is still read."""
    data = (made / f"a.{kind}").read_bytes()
    file = tmp_path / f"damaged.{kind}"
    record = info(made / f"a.{kind}")
    refusals = 0
    for n in range(300):
        damaged = bytearray(data[: rng.integers(1, len(data))] if n % 3 == 0 else data)
        for at in rng.integers(0, len(damaged), rng.integers(1, 4)):
            damaged[at] = rng.integers(256)
        file.write_bytes(damaged)
        try:
            assert info(file) == record
        except InputError as error:
            refusals += 1
            assert str(error).startswith(f"{str(file)!r}: ") and "\n" not in str(error) and "allowed: " in str(error)
    assert 20 < refusals < 300


def test_files_without_a_record(tmp_path):
    Image.new("RGB", (32, 32)).save(tmp_path / "plain.png")
    Image.new("RGB", (32, 32)).save(tmp_path / "plain.gif")
    (tmp_path / "text.png").write_text("a text")
    (tmp_path / "empty.mp4").write_bytes(b"")
    for name in ("plain.png", "plain.gif", "text.png", "empty.mp4"):
        assert refused(["info", name], tmp_path).startswith(f"povgen: '{name}': without a record of how it was made")
    with pytest.raises(InputError, match="No such file.*; allowed: a PNG, EXR, MP4, WebM, WebP, GIF, SVG, "):
        info(tmp_path / "?")


def test_a_record_that_is_too_large_is_refused_before_anything_is_rendered(tmp_path, monkeypatch):
    monkeypatch.setattr(records, "MAX_BYTES", 2000)
    monkeypatch.setattr(povray, "run", None)
    (tmp_path / "mine.inc").write_text(PIECE + "// " + 2000 * "-")
    said = refused(["frame", "chess", "--piece", "mine.inc"], tmp_path)
    assert "frames: the record of how the file was made has 0.0 MiB with the text of all pieces; allowed: " in said


def test_options_in_place_of_what_the_record_says(tmp_path):
    """A glass replaces the record's index, and an EXR file can be made of a PNG file's record."""
    save(Chess(window=[{"z": 2, "glass": "BK7"}]), tmp_path / "a.png", size=(32, 32))
    again = ["frame", "--from", "a.png", "--quiet", "--glass", "F2", "--wavelength", "500", "-o"]
    for name in ("b.png", "b.exr"):
        assert povgen([*again, name], tmp_path) == (0, "", "")
    scene = Scene.from_file(tmp_path / "b.exr")
    assert scene.glass == "F2" and scene.index == Chess(glass="F2", wavelength=500).index
    assert scene.window[0].index == Chess(glass="BK7", wavelength=500).index


def test_one_eye_in_place_of_two(tmp_path):
    """The record's distance between the eyes is not the user's."""
    save(Chess(sheet="none"), tmp_path / "a.png", stereo="pair", eye_distance=0.3, **SMALL)
    again = ["frame", "--from", "a.png", "-o", "b.png"]
    assert povgen([*again, "--stereo", "none"], tmp_path) == (0, "wrote b.png\n", "")
    assert pixels(tmp_path / "b.png").shape == (36, 48, 3)
    assert "eye_distance = 0.4: one eye" in refused([*again, "--stereo", "none", "--eye-distance", "0.4"], tmp_path)


def test_the_bits_of_what_is_made_again(tmp_path):
    save(Chess(sheet="none"), tmp_path / "a.png", bits=16, **SMALL)
    for name, bits in (("b.png", 16), ("b.exr", 32), ("B.EXR", 32)):
        assert povgen(["frame", "--from", "a.png", "-o", name], tmp_path) == (0, f"wrote {name}\n", "")
        assert info(tmp_path / name).rendering.bits == bits
    assert povgen(["frame", "--from", "b.exr", "-o", "c.png"], tmp_path)[0] == 0
    assert info(tmp_path / "c.png").rendering.bits == 8
    assert "bits = 16: an EXR file has 32" in refused(["frame", "--from=a.png", "--bits=16", "-o=c.exr"], tmp_path)
