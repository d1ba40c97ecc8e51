"""Chess pieces: several of them, their colours, and pieces from a user's file."""

import re
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from conftest import povgen, refusal, refused, some
from PIL import Image

from povgen import Chess, Room, Scene, movie, render, save, to_pov
from povgen.errors import PovrayError
from povgen.inputs.pieces import PIECES, PieceFile, declared
from povgen.measure.probes import PiecePositions, decoded
from povgen.optics import equations
from povgen.rendering import volumes
from povgen.scene.spec import MovieSpec
from povgen.video import overlay, piece_outline

SMALL = {"size": (96, 96), "antialias": "off"}
CUBE = "// a cube\n#declare Piece = box { <-0.3, 0, -0.3>, <0.3, 0.6, 0.3> }\n"


def differs(first, second):
    """Return the columns in which two pictures differ."""
    return np.flatnonzero((first != second).any((0, 2)))


@pytest.mark.parametrize("piece", some([*PIECES], 1))
def test_a_piece_is_as_large_as_stated(piece):
    scene = PiecePositions(sheet="none", piece=piece)
    (position,) = decoded([scene], (480, 360))  # pixels are 0.014 tiles apart
    x, y, z = np.moveaxis(position[np.isfinite(position).all(-1)], -1, 0)
    (height,) = re.findall(r"// The piece is (.*) tiles high", to_pov(scene))
    assert float(height) == PIECES[piece]["height"]
    assert abs(y.min()) < 0.02 and abs(y.max() - PIECES[piece]["height"]) < 0.02
    assert abs(np.hypot(x, z).max() - PIECES[piece]["radius"]) < 0.002


def test_several_pieces_stand_where_each_is_put():
    left, right = (Chess(sheet="none", x=x, piece="pawn") for x in (-0.6, 0.6))
    both = Chess(sheet="none", x=[-0.6, 0.6], piece="pawn", color=["red", "#00f"])
    assert both.objects == left.objects + right.objects
    assert overlay.positions(both) == overlay.positions(left) + overlay.positions(right)
    assert len(overlay.loci(both)) == 2  # a curve of constant alpha for each
    picture = render(both, **SMALL).astype(int)
    red, blue = (picture[..., a] - picture[..., 2 - a] for a in (0, 2))
    assert np.argwhere(red > 120)[:, 1].max() < 48 < np.argwhere(blue > 120)[:, 1].min()


def test_each_piece_has_a_predicted_image():
    plain, predicted = (
        render(Chess(sheet="ideal", alpha=0, x=[-0.6, 0.6], z1=[2, 3], predicted_image=shown), **SMALL)
        for shown in (False, True)
    )
    columns = differs(plain, predicted)
    assert columns.min() < 40 and columns.max() > 56
    turned, still = (Chess(sheet="ideal", alpha=alpha, x=[-0.6, 0.6], z1=[2, 3]) for alpha in (90, 0))
    before, after = (piece_outline.outlines(scene, 0.02) for scene in (still, turned))
    left = np.flatnonzero(before.real < 0)  # the first piece's points come first
    assert left.tolist() == [*range(len(left))]
    for z1, points in ((2, before[left]), (3, np.delete(before, left))):
        factor = equations.one_minus_P(6 / z1, np.pi / 2) / equations.one_minus_P(6 / z1, 0)
        assert max(np.min(abs(after - factor * point)) for point in points) < 1e-9


def test_z1_is_swept_for_all_pieces():
    scene = Chess(sheet="ideal", x=[-0.6, 0.6], z1=[2])
    assert scene.z1 == 2 and scene.distances == (2, 2)
    spec = MovieSpec.load("vary-z1").with_fixed({"x": ["-0.6", "0.6"], "color": ["red", "blue"]})
    frames = spec.scenes("draft")
    assert all(len(frame.objects) == 2 and len({z1 for _, z1 in frame.objects}) == 1 for frame in frames)
    assert frames[0].distances != frames[-1].distances


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"x": [0, 1], "z1": [2, 3, 4]}, "2 values of x, 3 values of z1"),
        ({"x": [0, 1], "z1": [2, 0.1]}, "z1 = 0.1"),
        ({"z1": []}, "z1 = []"),
        ({"color": "reddish"}, "color = 'reddish'"),
        ({"color": "rgb(300,0,0)"}, "color"),
        ({"color": "#11223344"}, "opaque"),
    ],
)
def test_what_does_not_fit_is_refused(values, said):
    assert said in refusal(lambda: Chess(**values))


def test_options_more_than_once(tmp_path):
    options = ["--x=-0.5", "--x=0.5", "--z1=2", "--piece=pawn", "--piece=king", "--color=red", "--color=blue"]
    status, source, _ = povgen(["pov", "chess", "--sheet=none", *options], tmp_path)
    assert status == 0 and source.count("  Piece\n") == 2 and "<0, 0, 1>;" in source
    assert "--x" not in refused(["pov", "chess", "--x=1", "--x=2", "--z1=3", "--z1=4", "--z1=5"], tmp_path)


def test_a_piece_from_a_file(tmp_path):
    file = tmp_path / "a\n#error (b) ----.inc"
    file.write_bytes(CUBE.replace("\n", "\r\n").encode("utf-8-sig"))
    scene = Chess(sheet="none", piece=str(file), x=-0.5)
    assert scene == Chess(sheet="none", piece=file, x=-0.5)
    file.unlink()  # its text is in the scene
    assert CUBE in to_pov(scene)
    pawn = Chess(sheet="none", piece="pawn", x=-0.5)
    columns = differs(*(render(each, **SMALL)[:, 10:-10] for each in (scene, pawn)))  # between the frame's sides
    assert columns.min() > 12  # to the right is the shadow


def test_a_long_piece_is_stated_as_its_path(tmp_path):
    """In messages. A movie's record has its text once. The path has a byte that is no text."""
    file = tmp_path / "big\udcff.inc"
    file.write_text(CUBE + "// 0123456789\n" * 20000)
    scene = Chess(sheet="none", piece=[file, "king"], x=[-1, 1])
    assert len(repr(scene)) < 1000
    spec = MovieSpec.of_sweeps("chess", ["alpha=0:9"], {"frames": 2}).with_fixed({"sheet": "none", "piece": file})
    for made, frames_made in ((spec, 2), ([scene], 1)):
        path = movie(made, tmp_path / "a.mp4", **SMALL).path
        assert imageio_ffmpeg.count_frames_and_secs(str(path))[0] == frames_made
        assert rb"big\\udcff.inc" in path.read_bytes() and path.read_bytes().count(b"0123456789") == 20000


def test_a_piece_does_not_change_the_rest_of_the_scene(tmp_path):
    """Not even if it declares all of povgen's names, or asks for another language version."""
    own, old = tmp_path / "own.inc", tmp_path / "old.inc"
    own.write_text(CUBE)
    old.write_text(CUBE)
    scene = Chess(prisms=20, z1=[2, 3, 4], x=[-0.8, 0, 0.8], piece=[own, "king", old])
    names = set(re.findall(r"\b(?!OwnPiece)[A-Z]\w*", re.sub("//.*", "", to_pov(scene)))) - {"Piece"}
    kinds = (
        "#declare {} = 5;\n",
        "#macro {}() 5 #end\n",
        "#for ({}, 0, 1) #end\n",
        "#declare {} = texture {{ pigment {{ rgb 1 }} }}\n",
    )
    declared = "".join(kinds[n % 4].format(name) for n, name in enumerate(sorted(names)))
    own.write_text(declared + CUBE)
    old.write_text(
        "#version 3.1;\n"
        + "".join(f'#include "{file}"\n' for file in ("colors.inc", "textures.inc", "shapes.inc"))
        + CUBE
    )
    assert (render(scene, **SMALL) == render(scene.replace(piece=[own, "king", old]), **SMALL)).all()


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("#declare Piece =\n3;\n", "', line 2: "),
        (CUBE + "camera { location 0 }\n", "', line 3: "),
        (CUBE + "}\n", "', line 3: "),
    ],
)
def test_an_error_that_povray_finds_later_names_the_users_file(text, line, tmp_path):
    file = tmp_path / "mi\nne.inc"
    file.write_text(text)
    with pytest.raises(PovrayError) as error:
        render(Chess(sheet="none", piece=file), **SMALL)
    assert f"{tmp_path}/mi\\nne.inc{line}" in str(error.value) and len(str(error.value).splitlines()) == 2


@pytest.mark.parametrize(
    ("text", "file"),
    [
        ('#if (strlen("\u00e4\u2013") != 2) #error "bytes" #end', ""),  # as many letters as the text has
        (f'text {{ ttf "{Path("/usr/share/povray-3.7/include/timrom.ttf").resolve()}" "K" 0.1, 0 scale 0.4 }}', ""),
        ('text { ttf "arial.ttf" "K" 0.1, 0 }', "arial.ttf"),
        ('box { -0.3, 0.3 pigment { image_map { png "my own.png" } } }', "my own.png"),
        ('height_field { png "/etc/passwd" }', "/etc/passwd"),
    ],
)
def test_files_that_a_piece_names(text, file, tmp_path):
    (tmp_path / "own.inc").write_text(f"#declare Piece = union {{ sphere {{ 0.4*y, 0.4 }}\n{text} }}", "utf-8")
    scene = Chess(sheet="none", piece=tmp_path / "own.inc")
    if not file:
        render(scene, **SMALL)
        return
    with pytest.raises(PovrayError, match=f"own.inc', line 2: no file '{file}' that it may read; allowed: the fonts"):
        render(scene, **SMALL)


def test_a_piece_can_name_pictures_in_the_users_folder(tmp_path, monkeypatch):
    """A picture that has changed is not taken from the cache."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "da ta"))
    (tmp_path / "da ta" / "povgen" / "in").mkdir(parents=True)
    text = 'sphere { 0.5*y, 0.5 pigment { image_map { png "in/own.png" } } finish { ambient 1 diffuse 0 } }'
    (tmp_path / "own.inc").write_text(f"#declare Piece = {text}")
    scene = Chess(sheet="none", piece=tmp_path / "own.inc", z1=1)
    for channel in (0, 2):
        colour = np.uint8([255 * (channel == each) for each in range(3)])
        Image.fromarray(np.full((4, 4, 3), colour)).save(tmp_path / "da ta" / "povgen" / "in" / "own.png")
        picture = np.asarray(render(scene, **SMALL), int)
        assert (picture[:, :, channel] > picture.sum(2) - picture[:, :, channel] + 150).sum() > 20


# a bar for which POV-Ray finds no bounding box, or an infinite one
BAR = "".join(f"plane {{ <{normal}>, 0.1 }} " for normal in ("1, 1, 0", "-1, -1, 0", "1, -1, 0", "-1, 1, 0", "0, 0, 1"))
BAR = f"intersection {{ {BAR} plane {{ -z, 0.1 }} translate 0.3*y }}"


STAYS = [
    (f"union {{ sphere {{ 0.4*y, 0.4 }} {BAR} }}", ""),
    ("intersection { box { -2, 2 } sphere { 0.4*y, 0.4 } }", ""),  # its box is larger than the piece
]
LEAVES = [
    (f"union {{ sphere {{ 1.5*y, 1.5 }} {BAR} }}", "1.498 tiles from its axis, and 2.993 up"),
    ("box { <-0.51, 0, -0.4>, <0.4, 0.6, 0.4> }", "0.510 tiles from its axis, and 0.600 up;"),
    ("cylinder { 0, 5*y, 0.3 }", "5.000 up; allowed: up to 0.5 and 4.0; it fits if scaled by 0.800"),
]


@pytest.mark.parametrize(
    ("text", "said", "renderer"),
    [
        (*STAYS[0], "povray"),
        (*LEAVES[0], "povray"),
        (*LEAVES[1], "gl"),
        *(
            pytest.param(*each, renderer, marks=pytest.mark.release)
            for each in STAYS + LEAVES
            for renderer in ("povray", "gl")
        ),
    ],
)
def test_a_piece_stays_on_its_tile(text, said, renderer, tmp_path):
    file = tmp_path / "own.inc"
    file.write_text(f"#declare Piece = {text}\n")
    scene = Chess(sheet="none", piece=file)
    if not said:
        assert differs(render(scene, renderer=renderer, **SMALL), render(scene.replace(piece="pawn"), **SMALL)).size
        return
    with pytest.raises(PovrayError, match=f"^POV-Ray: '{file}', line 1: the piece reaches .*{said}"):
        render(scene, renderer=renderer, **SMALL)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "No such file"),
        (b"// #declare Piece = 1\n/* #declare Piece = \n2 */", "declares Piece"),
        ("#declare Piece = sphere { 0, 1 } // \u00e4".encode("utf-16"), "UTF-8"),
        (b"#declare Piece = sphere { 0, 1 } // \0", "the control character"),
        ("#declare Piece = sphere { 0, 1 } // \x9b[31m".encode(), "the control character"),
        (b"#declare Piece = sphere { 0, 1 }" + b"\n" * 2**20, "at most"),
        ("folder", "file"),
    ],
)
def test_a_file_that_is_no_piece_is_refused(tmp_path, content, said):
    path = tmp_path / "piece.inc"
    if content == "folder":
        path.mkdir()
    elif content is not None:
        path.write_bytes(content)
    message = refused(["pov", "chess", f"--piece={path}"], tmp_path)
    assert "piece = " in message and said in message and len(message.splitlines()) == 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
def test_letters_of_older_editors(encoding, tmp_path):
    text = CUBE + "// K\u00f6nig \u2013 \u201eroi\u201c\n"
    (tmp_path / "own.inc").write_text(text, encoding)
    assert Chess(piece=tmp_path / "own.inc").piece.text == text


def test_the_names_that_a_piece_declares():
    text = (
        "#declare A = 1; # local b = array[1] {2} #macro M(P) #declare C[0] = 1; #end #for (K, 0, 1) #end // #declare D"
    )
    assert declared(text) == ["A", "C", "K", "M", "b"]
    assert declared('#declare A = "#declare B \\" #declare C"; /* #declare D = 1 */ #declare E = 2;') == ["A", "E"]
    source = to_pov(Chess(piece=[PieceFile("own.inc", CUBE + text + "\n"), "king"], x=[-1, 1]))
    before, after = source.split(text)
    for name in ("A", "C", "K", "M", "b", "Piece"):
        assert f"\n#ifdef ({name}) #undef {name} #end\n" in after.partition("// ----")[0]
    assert before.count("#declare") == 2  # OwnPiece_1 and Piece: no names yet


@pytest.mark.release
def test_a_mesh_is_shown_as_the_same_shape_in_povrays_language(tmp_path):
    """A cube. The renderer gl shows it too: see test_volumes.py for what it draws of any text."""
    corners = [(x, y, z) for x in (0, 6) for y in (0, 6) for z in (0, 6)]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    lines = ["v {} {} {}".format(*corner) for corner in corners]
    lines += ["f {} {} {} {}".format(*(n + 1 for n in side)) for side in sides]
    (tmp_path / "cube.obj").write_text("\n".join(lines))
    (tmp_path / "cube.inc").write_text(CUBE)
    mesh, box = (Chess(sheet="none", piece=str(tmp_path / name)) for name in ("cube.obj,height=0.6", "cube.inc"))
    assert differs(render(box, **SMALL), render(Chess(sheet="none"), **SMALL)).size > 5
    assert (render(mesh, **SMALL) == render(box, **SMALL)).mean() > 0.999
    flat = volumes.volumes({"mesh": mesh.piece, "box": box.piece})
    assert flat["mesh"].place == pytest.approx(flat["box"].place, abs=1e-4)
    room = Room(object=f"kind=piece,piece={tmp_path / 'cube.obj'},height=0.6,z=2")
    assert (room.object[0].z, room.object[0].piece) == (2, mesh.piece)
    assert Scene.from_file(save(mesh, tmp_path / "a.png", **SMALL)) == mesh
