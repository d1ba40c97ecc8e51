"""Rooms: in TOML, on the command line, in movies, in records, and in messages."""

import re
from pathlib import Path

import numpy as np
import pytest
from conftest import picture, povgen, refused
from PIL import Image

from povgen import (
    Card,
    Eye,
    Floor,
    InputError,
    MovieSpec,
    Piece,
    Rendering,
    Room,
    Ruler,
    Scene,
    Sphere,
    Text,
    Window,
    cheapest,
    info,
    results,
    save,
)
from povgen.cli.report import warn
from povgen.optics import window_trace
from povgen.rendering.views import views
from povgen.scene.room import OF_MOVIES
from povgen.scene.warnings import warnings

TINY = {"renderer": "gl", "size": (64, 48), "antialias": "off"}
GL = ["--renderer", "gl", "--size", "64x48", "--antialias", "off"]
TOML = """
title = "A sheet that tilts"
frames = 3
background = "black"

[eye]
z = -8
view = 6

[[window]]
name = "left"
x = -1.7
alpha = 90

[[window]]
x = 1.7
pitch = 25
sheet = "refraction"
ratio = 0.8

[[object]]
kind = "piece"
name = "knight"
x = -1.7
y = -1
z = 3

[[object]]
kind = "text"
text = "α = 90°"
x = 1.6
z = 3

[[object]]
kind = "ruler"
y = -1.1
z = 2

[[sweep]]
parameter = "window2.pitch"
start = 0
stop = 60
"""
ROOM = Room(
    [
        Window(name="left", x=-1.7, alpha=90),
        Window(x=1.7, pitch=25, sheet="refraction", ratio=0.8),
        Piece(name="knight", x=-1.7, y=-1, z=3),
        Text(text="α = 90°", x=1.6, z=3),
        Ruler(y=-1.1, z=2),
    ],
    eye=Eye(z=-8, view=6),
    background="black",
)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "room.toml"
    path.write_text(TOML)
    return path


def test_a_room_is_the_same_in_toml_in_python_and_as_options(file, tmp_path):
    assert Room.load(file) == ROOM
    moved = ROOM.eye.replace(x=0.5)  # the option changes only what it states
    assert Room.load(file, eye="x=0.5").eye == ROOM.replace(eye={"x": 0.5}).eye == moved != ROOM.eye
    assert MovieSpec.load(file, {"eye": "x=0.5"}, ["left.alpha=0:9"]).scenes("draft")[0].eye == moved
    assert ROOM.replace(eye=Eye(x=0.5)).eye == Eye(x=0.5)
    assert Room([], eye=Eye(view=5)).replace(eye="x=1").eye.model_fields_set == {"view", "x"}  # a stated view stays
    options = [
        f"--window={text}" for text in ("name=left,x=-1.7,alpha=90", "x=1.7,pitch=25,sheet=refraction,ratio=0.8")
    ]
    pieces = ("kind=piece,name=knight,x=-1.7,y=-1,z=3", "kind=text,text=α = 90°,x=1.6,z=3", "kind=ruler,y=-1.1,z=2")
    options += [f"--object={text}" for text in pieces] + ["--eye=z=-8,view=6", "--background=black"]
    for scene in (["room.toml"], ["room", *options]):
        assert povgen(["frame", *scene, *GL, "-o", "cli.png"], tmp_path)[::2] == (0, "")
        assert Room.from_file(tmp_path / "cli.png") == ROOM
    save(ROOM, tmp_path / "python.png", **TINY)
    cli, python = (np.asarray(Image.open(tmp_path / f"{name}.png")) for name in ("cli", "python"))
    assert (cli == python).all() and len(np.unique(cli)) > 50


def test_options_replace_what_a_file_states(file, tmp_path):
    line = ["frame", "room.toml", "--object=kind=sphere,z=2", "--background", "white", *GL, "-o", "a.png"]
    assert povgen(line, tmp_path)[0] == 0
    made = Scene.from_file(tmp_path / "a.png")
    assert made == ROOM.replace(object=Sphere(z=2), background="white")
    assert povgen(["frame", "--from", "a.png", "--eye", "z=-9", *GL, "-o", "b.png"], tmp_path)[0] == 0
    assert Scene.from_file(tmp_path / "b.png") == made.replace(eye=made.eye.replace(z=-9))
    assert "a.png'" not in refused(["frame", "room.toml", "-o", "room.toml"], tmp_path)  # it would be written over
    assert file.read_text() == TOML


@pytest.mark.parametrize(
    ("sweep", "of", "field", "values"),
    [
        ("window2.pitch=0:60", "window2", "pitch", [0, 30, 60]),
        ("knight.z=3:4", "knight", "z", [3, 3.5, 4]),
        ("left.alpha=10:1000:log", "left", "alpha", None),
        ("eye.view=4:6", "eye", "view", [4, 5, 6]),
        ("ruler1.length=1:4", "ruler1", "length", [1, 2, 4]),  # whole numbers
        ("window2.ratio=0.5:1", "window2", "ratio", [0.5, 0.75, 1]),
    ],
)
def test_a_sweep_changes_the_named_number_alone(sweep, of, field, values, file):
    if values is None:
        with pytest.raises(InputError, match=r"room.toml: frame 3 of 3, left.alpha = 1000: alpha = 1000.0: should be"):
            MovieSpec.load(file, sweeps=[sweep])
        return
    scenes = MovieSpec.load(file, sweeps=[sweep]).replace(exact_frames=True).scenes("draft")
    assert [getattr(scene.parts[of], field) for scene in scenes] == values
    for scene in scenes:
        assert scene.with_numbers({f"{of}.{field}": getattr(ROOM.parts[of], field)}) == ROOM


def test_a_movie_of_a_room(file, tmp_path):
    spec = MovieSpec(
        title="a",
        scene="room",
        fixed=dict(ROOM),
        sweep=[{"parameter": "window2.pitch", "start": 0, "stop": 60}],
        frames=3,
        exact_frames=True,
    )
    line = [*GL, "--frames", "3", "-o", "f/%d.png"]
    assert povgen(["movie", "room.toml", *line], tmp_path)[0] == 0
    frames = [Room.from_file(tmp_path / "f" / f"{n}.png") for n in (1, 2, 3)]
    assert frames == spec.scenes("standard") == MovieSpec.load(file).replace(exact_frames=True).scenes("draft")
    untitled = MovieSpec.parse(TOML.partition("\n\n")[2], "room.toml")
    assert untitled.title == "room, window2.pitch from 0 to 60"
    swept = ["movie", "room", "--window=name=a", "--sweep=a.x=-1:1", "--sweep=eye.x=-1:1", *line]
    assert povgen(swept, tmp_path)[0] == 0
    assert Room.from_file(tmp_path / "f/3.png") == Room(Window(name="a", x=1), eye=Eye(x=1))


THINGS = "left, window2, knight, text1, ruler1, eye"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"window2.pitch"', '"windo2.pitch"', [f"allowed: wavelength, pupil, focus, and NAME.PARAMETER of {THINGS}"]),
        ('"window2.pitch"', '"knight.hight"', ["allowed: knight.x, knight.y, knight.z, knight.yaw, knight.pitch"]),
        ('"window2.pitch"', '"knight.color"', ["parameter = 'knight.color': cannot be swept"]),
        ("stop = 60", "stop = 4000", ["frame 3 of 3, window2.pitch = 4000: pitch = 4000.0: should be less"]),
        (
            "x = 1.7",
            "x = 0",
            ["left, at -1.7, 0, 0, and window2, at 0, 0, 0: they overlap; allowed: 1.6 tiles farther"],
        ),
        ('"knight"', '"left"', ["name = 'left': two things have it; allowed: different names"]),
        ('"knight"', '"Left"', ["name = 'Left': two things have it; allowed: different names, also in small letters"]),
        ('"knight"', '"eye"', ["name = 'eye': the eye has it"]),
        ('"ruler"', '"rular"', ["object", "kind = 'rular': allowed: box, card, floor, pedestal, piece, ruler"]),
        ("view = 6", "wiew = 6", ["eye", "'wiew': unknown; did you mean view?"]),
        ("title", "titel", ["'titel': unknown"]),
        ("frames = 3", "object = 3", ["Cannot overwrite"]),
        ("z = 3", "z = 3\nsize = 2", ["object", "'size': unknown; allowed: name, x, y, z"]),
    ],
)
def test_a_files_mistakes(old, new, words, file, tmp_path):
    file.write_text(TOML.replace(old, new, 1) if "window2" not in old else TOML.replace(old, new))
    message = refused(["movie", "room.toml", "-o", "a.gif", "--frames", "3", *GL], tmp_path)
    assert message.startswith("povgen: room.toml: ") and all(word in message for word in words), message
    if "swept" not in message and "frame 3" not in message:
        picture_message = refused(["frame", "room.toml", *GL], tmp_path)
        assert picture_message.startswith("povgen: room.toml: ") and words[-1] in picture_message


def test_what_is_no_room(tmp_path, file):
    for text, words in (
        ('scene = "chess"\n', "scene = 'chess': no room"),
        ("[[object]]\nx = 1", "kind: missing; allowed: box"),
        ("[eye", "not TOML"),
        ("# nothing\n", "states nothing; allowed: a room's tables"),
    ):
        (tmp_path / "a.toml").write_text(text)
        message = refused(["frame", "a.toml", *GL], tmp_path)
        assert message.startswith("povgen: a.toml: ") and words in message, message
    assert "b.toml: no room: No such file" in refused(["frame", "b.toml"], tmp_path)
    assert "'alpha': unknown in the scene room" in refused(["frame", "room", "--alpha", "3"], tmp_path)
    assert "not with the movie 'vary-z1'" in refused(["movie", "vary-z1", "--sweep", "alpha=0:9"], tmp_path)
    assert "'knigt.x': not in the room; allowed: NAME.PARAMETER with one" in message_of(
        lambda: ROOM.with_numbers({"knigt.x": 1})
    )
    assert "'sheet': unknown" in refused(["frame", "room.toml", "--sheet=auto", "--tolerance=1px"], tmp_path)
    assert message_of(lambda: cheapest(ROOM, "1px")).endswith("is not for Room; allowed: Chess(...) or Spheres(...)")
    message = "quantity = 'nu': not for a room; allowed: x, y, visible, best_focus, pupil_blur, or Chess(...) or"
    assert message_of(lambda: results([ROOM], "x", "nu")).startswith(message)
    assert "povgen tolerance is not for Room" in refused(["tolerance", "room.toml"], tmp_path)


def message_of(call):
    with pytest.raises(InputError) as error:
        call()
    assert "\n" not in str(error.value)
    return str(error.value)


def test_the_keys_of_movies_are_not_a_rooms():
    assert MovieSpec.model_fields.keys() - {"scene", "fixed"} == OF_MOVIES


@pytest.fixture
def with_files(tmp_path):
    """A room in a folder, which shows a file of each kind."""
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "own.inc").write_text("#declare Piece = sphere { 0.5*y, 0.5 }")
    (folder / "own.toml").write_text(
        "path = [2, 1]\noutline = [{ corners = [[0.1, 0], [0.9, 0], [0.5, 1], [0.1, 0]] }]"
    )
    Path(picture(folder)).rename(folder / "card.png")
    (folder / "room.toml").write_text(
        '[[window]]\nsheet = "profile"\nprofile = "own.toml"\nperiods = 9\n'
        '[[object]]\nkind = "piece"\npiece = "own.inc"\nz = 2\n'
        '[[object]]\nkind = "card"\nfile = "card.png"\nz = 4\n'
        '[[object]]\nkind = "floor"\nfile = "card.png"\ny = -2\n'
    )
    return folder


def test_a_record_has_all_files_of_a_room(with_files, tmp_path):
    room = Room.load(with_files / "room.toml")
    assert (
        room.object[0].piece.path == str(with_files / "own.inc")
        and Card(file=with_files / "card.png", z=4) in room.object
    )
    assert Floor(y=-2, file=with_files / "card.png") in room.object
    save(room, tmp_path / "a.png", **TINY)
    for name in ("own.inc", "own.toml", "card.png"):
        (with_files / name).write_text("changed")
    assert Room.from_file(tmp_path / "a.png") == room
    assert povgen(["frame", "--from", "a.png", "-o", "b.png"], tmp_path)[0] == 0
    a, b = (np.asarray(Image.open(tmp_path / f"{name}.png")) for name in "ab")
    assert (a == b).all()


def test_files_that_are_not_seen_are_not_in_the_record(with_files, tmp_path):
    window = Window(profile=with_files / "own.toml")
    save(Room(window, background="black", sky=picture(tmp_path)), tmp_path / "a.png", **TINY)
    record = info(tmp_path / "a.png")
    assert record.pieces == record.pictures == {}
    assert Room.from_file(tmp_path / "a.png") == Room(Window(), background="black")


def test_a_strangers_record_reads_no_file(with_files, tmp_path):
    save(Room.load(with_files / "room.toml"), tmp_path / "a.png", **TINY)
    record = info(tmp_path / "a.png")
    for part in ({"pieces": {}}, {"pictures": {}}):
        message = message_of(lambda part=part: _scenes(record.replace(**part)))
        assert "not in the record" in message
    for wrong in ({"object": 3}, {"object": [{"kind": ["x"]}]}, {"eye": 1}, {"window": [3]}, {"eye": {"z": "a"}}):
        message_of(lambda wrong=wrong: _scenes(record.replace(frames=[{**record.frames[0], **wrong}])))


def _scenes(record):
    from povgen.scene.scene import of_record

    return of_record(record)


def test_a_file_outside_the_folder_is_named(with_files, tmp_path, caplog):
    caplog.set_level("WARNING", "povgen")
    text = (with_files / "room.toml").read_text().replace('"own.inc"', '"../own.inc"')
    (with_files / "own.inc").rename(tmp_path / "own.inc")
    (with_files / "room.toml").write_text(text)
    Room.load(with_files / "room.toml")
    assert f"names a file outside its folder, {str(tmp_path / 'own.inc')!r}" in caplog.text
    caplog.clear()
    Room.load(with_files / "room.toml", object=Piece(z=2))
    assert not caplog.text


def test_two_eyes_see_a_room():
    room = ROOM.replace(eye=Eye(x=2, y=1, z=-5, roll=20, view=4))
    left, right = (each.camera for each in views(room, Rendering(stereo="pair", eye_distance=0.3)))
    camera = room.camera
    np.testing.assert_allclose(np.subtract(right.eye, left.eye), 0.3 * np.array(camera.right), atol=1e-12)
    np.testing.assert_allclose(np.add(right.eye, left.eye) / 2, camera.eye, atol=1e-12)
    assert left[1:] == right[1:] == camera[1:]
    shown = views(room.replace(background="transparent"), Rendering(stereo="anaglyph"))
    assert [each.background for each in shown] == ["black", "white"] * 2
    inside = ROOM.replace(eye=Eye(x=-1.6, y=-0.9, z=2.95), object=[Sphere(x=-1.4, y=-0.9, z=2.95, radius=0.1)])
    with pytest.raises(InputError, match=r"eye_distance = 0.4: for one of the two eyes, eye = .*: inside sphere1"):
        views(inside, Rendering(stereo="pair", eye_distance=0.4))


def test_a_law_that_gl_cannot_compute_is_refused_in_any_pose():
    for pose in ({}, {"x": 2, "yaw": 150}, {"pitch": 90, "y": -3}):
        for law, fits in (("x + 0.3*X, y, z", True), ("x + X*z*1e-30*1e-30*1e30*1e30, y, z", False)):
            room = Room(Window(sheet="law", law=law, **pose))
            if fits:
                views(room, Rendering(renderer="gl"))
            else:
                assert "the renderer gl computes with 32-bit numbers" in message_of(
                    lambda room=room: views(room, Rendering(renderer="gl"))
                )


def test_warnings_of_a_room(capsys, tmp_path, monkeypatch):
    room = Room([Window(name="left", prisms=30), Window(x=4, sheet="law", law="x, y, z", parameter={"k": 1})])
    warn({"window": room.window}, [room])
    found = [line.removeprefix("povgen: warning: ") for line in capsys.readouterr().err.splitlines()]
    assert found == [
        "left: prisms: no effect with sheet = ideal",
        "window2: parameter: k: no effect, because its law lacks it",
    ]
    glass = Room([Window(sheet="detailed", prisms=300, alpha=0.1, name="a"), Window(sheet="detailed", z=9, prisms=200)])
    found = {name: text.split(":")[0] for name, text in warnings(glass, Rendering(size=(160, 120), antialias="off"))}
    assert found == {
        "window": "window",
        "alpha": "alpha = 0.1",
        "prisms": "prisms = 200",  # farther, and therefore narrower
    }
    two = Room([Window(), Window(z=1)])
    assert not [*warnings(two)]
    monkeypatch.setattr(window_trace, "MOST_CROSSINGS", 1)
    ((name, text),) = warnings(two)
    share = float(re.search(r"([0-9.]+) % of the picture is black", text)[1])
    assert name == "window" and 10 < share < 60


def test_a_dry_run_of_a_room(file, tmp_path):
    status, out, _ = povgen(["frame", "room.toml", "--dry-run", *GL], tmp_path)
    assert status == 0 and out.startswith("a picture of 64x48 pixels")
