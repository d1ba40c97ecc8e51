"""Pieces from mesh files: their size and place, and files that are refused."""

import json
import re
import struct
import sys

import numpy as np
import pytest

from povgen import Chess, InputError, MovieSpec, remedies
from povgen.scene import mesh, mesh_reader, pieces
from povgen.scene.warnings import warnings

# A tetrahedron that no turn or mirror leaves as it is: the foot's corners, and a top. Here z points up.
CORNERS = np.array([[0, 0, 0], [4, 0, 0], [0, 2, 0], [0, 0, 3]], float)
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def stl(corners=CORNERS, faces=FACES):
    rows = [struct.pack("<12fH", 0, 0, 0, *np.float32(corners)[list(face)].ravel(), 0) for face in faces]
    return b"".join([b" " * 80, struct.pack("<I", len(rows)), *rows])


def obj(corners=CORNERS, faces=FACES):
    lines = ["mtllib /etc/passwd", *("v {} {} {}".format(*corner) for corner in corners)]
    return "\n".join(lines + ["f {} {} {}".format(*(n + 1 for n in face)) for face in faces]).encode()


def ply(corners=CORNERS, faces=FACES):
    head = (
        f"ply\nformat ascii 1.0\nelement vertex {len(corners)}\nproperty float x\nproperty float y\nproperty float z\n"
    )
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = ["{} {} {}".format(*corner) for corner in corners] + ["3 {} {} {}".format(*face) for face in faces]
    return (head + "\n".join(rows) + "\n").encode()


def glb(corners=CORNERS, faces=FACES, count=None):
    points, indices = np.float32(corners).tobytes(), np.uint32(faces).tobytes()
    description = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count or len(corners), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)},
        ],
        "buffers": [{"byteLength": len(points + indices)}],
    }
    if count:
        del description["accessors"][0]["bufferView"]  # zeros
    text = json.dumps(description).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<I4s", len(text), b"JSON") + text
    parts += struct.pack("<I4s", len(points + indices), b"BIN\0") + points + indices
    return struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts


def points(piece):
    """Return a mesh's corners in POV-Ray's axes: x to the right, y up, z away from the eye."""
    rows = re.findall(r"<([-\d.e]+), ([-\d.e]+), ([-\d.e]+)>", piece.text.partition("face_indices")[0])
    return np.array(rows, float)


@pytest.mark.parametrize("kind", [stl, obj, ply, glb], ids=lambda kind: kind.__name__)
def test_size_and_place(kind, tmp_path):
    path = tmp_path / f"model.{kind.__name__.upper()}"
    path.write_bytes(kind())
    piece = Chess(piece=f"{path},height=0.6,up=z").piece
    right, up, away = CORNERS[:, 0] - 2, CORNERS[:, 2], CORNERS[:, 1] - 1
    wanted = 0.2 * np.column_stack((right, up, away))
    assert np.sort(points(piece) @ [1, 10, 100]) == pytest.approx(np.sort(wanted @ [1, 10, 100]), abs=1e-3)
    assert (piece.note, str(piece), piece.path) == ("", f"{path},height=0.6,up=z", str(path))


def test_as_large_as_it_can_be(tmp_path):
    """The file says so. In this one, y points up, and z towards the eye."""
    path = tmp_path / "model.obj"
    path.write_bytes(obj())
    scene = Chess(piece=path)
    x, y, z = points(scene.piece).T
    assert np.hypot(x, z).max() == pytest.approx(0.5, abs=1e-5) and y.min() == 0
    assert z[y.argmax()] > 0 < y.max()  # the corner with the greatest y has the least z of the file
    said = dict(warnings(scene))["piece"]
    assert said == f"piece = '{path}': scaled to a height of {y.max():.3g} tiles (height= states another)"
    slim = tmp_path / "slim.obj"
    slim.write_bytes(obj(CORNERS * (0.1, 9, 0.1)))
    assert points(Chess(piece=slim).piece)[:, 1].max() == pytest.approx(mesh.MAX_HEIGHT, abs=1e-4)


def ply_with_an_edge():
    head, _, rows = ply().partition(b"end_header\n")
    return head + b"element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n" + rows + b"0 1\n"


def changed_glb(accessor=None, part=None, **more):
    """Return a GLB file with other numbers in its first accessor and in its part, and with other keys."""
    data = glb()
    length = int.from_bytes(data[12:16], "little")
    description = json.loads(data[20 : 20 + length])
    description["accessors"][0] |= accessor or {}
    description["meshes"][0]["primitives"][0] |= part or {}
    text = json.dumps(description | more).encode()
    text += b" " * (-len(text) % 4)
    rest = struct.pack("<I4s", len(text), b"JSON") + text + data[20 + length :]
    return struct.pack("<4sII", b"glTF", 2, 12 + len(rest)) + rest


def spaced(data):
    """The same OBJ file, as other programs write it."""
    lines = [f"\t{line.replace(' ', chr(9))}  # {line}" for line in data.decode().splitlines()]
    lines.insert(1, "# C:\\models\\")
    return ("\ufeff" + "\r\n".join(lines).replace("f\t1\t2\t4", "f\t1\t2\\\r\n4")).encode()


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        ("obj", spaced(obj())),
        ("obj", obj().replace(b"\n", b"\r")),
        ("obj", b"\xef\xbb\xbf" + obj().partition(b"\n")[2]),
        ("stl", stl() + b"more"),
        ("glb", changed_glb(extensionsUsed=["KHR_materials_unlit"], extensionsRequired=["KHR_materials_unlit"])),
    ],
    ids=["spaces", "returns", "mark", "more", "extension"],
)
def test_files_of_other_programs(kind, data, tmp_path):
    assert np.sort(points(Chess(piece=write(tmp_path, kind, data)).piece).ravel()) == pytest.approx(
        np.sort(points(Chess(piece=write(tmp_path, kind, globals()[kind]())).piece).ravel())
    )


def write(folder, kind, data):
    path = folder / f"model{len(data)}.{kind}"
    path.write_bytes(data)
    return path


def test_a_surface_that_is_not_closed_is_said(tmp_path):
    """Of such a mesh, the renderer gl and outlines can lack parts."""
    for name, faces in (("open", FACES[:3]), ("closed", FACES), ("inside out", [face[::-1] for face in FACES])):
        path = tmp_path / f"{name}.stl"
        path.write_bytes(stl(faces=faces))
        assert ("not closed" in Chess(piece=path).piece.note) == (name == "open")


def test_the_reader_simplifies(monkeypatch):
    """A bowl of 20 000 triangles: near each of its points is one of the result, and the other way round."""
    pytest.importorskip("trimesh")
    monkeypatch.setattr(mesh_reader, "MAX_TRIANGLES", 3000)
    x, y = np.meshgrid(np.linspace(-1, 1, 101), np.linspace(-1, 1, 101))
    corners = np.column_stack((x.ravel(), y.ravel(), (x * x + y * y).ravel()))
    n = (np.arange(100)[:, None] * 101 + np.arange(100)).ravel()
    faces = np.concatenate([np.column_stack((n, n + 1, n + 102)), np.column_stack((n, n + 102, n + 101))])
    vertices, triangles, (count, moved, is_open) = mesh_reader._mesh(stl(corners, faces), "stl")
    assert is_open and count == 20000 and 1000 < len(triangles) <= 3000
    gaps = np.linalg.norm(np.float32(corners)[:, None] - vertices, axis=2)
    assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) <= moved + 1e-6 and 0.02 < moved < 0.1


def refused(path, data=None, options=""):
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        Chess(piece=f"{path}{options}")
    message = str(caught.value)
    assert "\n" not in message and message.startswith("piece = ")
    return message


def test_values_that_are_refused(tmp_path):
    path = tmp_path / "model.stl"
    path.write_bytes(stl())
    for options, said in (
        (",height=9", "should have a height from 0.01 to 4 tiles, not height=9"),
        (",height=nan", "not height=nan"),
        (",height=2", "within 0.5 tiles of its axis: height = 2 is too much; allowed: up to 0.6708"),
        (",up=x", "should have up=y or up=z, not up=x"),
        (",size=2", "should have no option 'size': allowed: height and up"),
    ):
        assert said in refused(path, options=options)
    assert "No such file" in refused(tmp_path / "no.glb")
    flat = stl(CORNERS * (1, 1, 0))
    for options in ("", ",height=0.5"):
        assert "should have a height: all its corners are in one horizontal plane" in refused(
            tmp_path / "flat.stl", flat, options
        )


@pytest.mark.parametrize(
    ("kind", "data", "said"),
    [
        ("stl", b"", "should be a mesh with triangles"),
        ("stl", stl()[:-20], "should be a mesh with triangles"),
        ("stl", b" " * 80 + b"\xff" * 4 + b"\0" * 50, "should be a mesh with triangles"),
        ("stl", stl(CORNERS * np.nan), "should be a mesh whose numbers are finite"),
        ("stl", stl(CORNERS * 0), "should be a mesh whose longest side is from 1e-9 to 1e9"),
        ("obj", b"v 0 0 0\nv 0 0 1\nf 1 2 99999999\n", "should be a"),
        ("ply", ply()[:-30], "should be a"),
        ("glb", b"glTF" + b"\xff" * 40, "should be a whole glb file"),
        ("glb", glb(count=10**10), "should be a mesh that needs less memory"),
        ("ply", ply_with_an_edge(), "should be a mesh of vertices and faces alone"),
        ("glb", changed_glb({"sparse": {"count": 1}}), "should be a GLB file without sparse accessors"),
        ("glb", changed_glb(part={"mode": 6}), "should be a GLB file without triangle fans"),
        (
            "glb",
            changed_glb(extensionsRequired=["KHR_draco_mesh_compression"]),
            "should be a GLB file without KHR_draco_mesh_compression",
        ),
    ],
    ids=["empty", "cut", "count", "nan", "point", "index", "ply", "glb", "memory", "edge", "sparse", "fan", "packed"],
)
def test_files_that_are_refused(kind, data, said, tmp_path):
    assert said in refused(tmp_path / f"model.{kind}", data)


def test_a_file_that_is_too_large_or_takes_too_long(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh, "MAX_BYTES", 100)
    assert "should be a file of at most 100 bytes" in refused(tmp_path / "model.stl", stl())
    monkeypatch.undo()
    monkeypatch.setattr(mesh, "PATIENCE", 0.01)
    assert "should be a mesh that is read within 0.01 s" in refused(tmp_path / "model.stl", stl(CORNERS * 2))


def test_without_trimesh_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    (tmp_path / "trimesh.py").write_text("raise ImportError")
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    assert f"needs trimesh, which is not installed: {remedies.extra('mesh')}" in refused(
        tmp_path / "model.stl", stl(CORNERS * 3)
    )


def test_a_movie_reads_the_file_once(tmp_path, monkeypatch):
    (tmp_path / "model.stl").write_bytes(stl(CORNERS * 5))
    read = []
    once = mesh._read
    monkeypatch.setattr(mesh, "_read", lambda *given: read.append(1) or once(*given))
    text = """title = "T"\nscene = "chess"\nframes = 4\n[fixed]\npiece = "model.stl,height=0.5"
[[sweep]]\nparameter = "alpha"\nstart = 1\nstop = 9\n"""
    spec = MovieSpec.parse(text, "spec", tmp_path)
    assert len(spec.scenes("standard")) == 4 and len(read) == 1
    assert spec.model_dump()["fixed"]["piece"] == f"{tmp_path}/model.stl,height=0.5"
    assert pieces.radius(spec.scenes("standard")[0].piece) == pieces.FILE_RADIUS
