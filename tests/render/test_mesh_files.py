"""Pieces from mesh files: their size and place, and files that are refused."""

import base64
import json
import re
import struct

import numpy as np
import pytest
from conftest import refusal

from povgen import Chess, InputError, MovieSpec
from povgen.inputs import mesh, mesh_reader, pieces, readers
from povgen.scene.warnings import warnings

BOM = b"\xef\xbb\xbf"
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


def glb(corners=CORNERS, faces=FACES, *more, accessor=(), part=(), mesh=(), node=(), **document):
    """Return a GLB file of these arrays: accessors 0, 1 and so on. The others change or add keys of its parts."""
    corners = np.asarray(corners)
    arrays = [corners if corners.dtype == np.int16 else np.float32(corners), np.uint32(faces).reshape(-1, 1), *more]
    binary, views, accessors = b"", [], []
    for array in arrays:
        stored = np.pad(array, ((0, 0), (0, -array.itemsize * array.shape[1] % 4 // array.itemsize)))
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": stored.nbytes})
        views[-1] |= {"byteStride": stored.strides[0]} if array.shape[1] > 1 else {}
        component = {"i2": 5122, "u4": 5125, "f4": 5126}[array.dtype.str[1:]]
        kind = "VEC3" if array.shape[1] == 3 else "SCALAR"
        accessors.append({"bufferView": len(accessors), "componentType": component, "count": len(array), "type": kind})
        binary += stored.tobytes()
    accessors[0] = {key: value for key, value in (accessors[0] | dict(accessor)).items() if value is not None}
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **dict(node)}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, **dict(part)}], **dict(mesh)}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    } | document
    text = json.dumps(document).encode()
    parts = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts


def ascii_stl():
    """Two solids; the name of one looks like a vertex and a facet."""
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join("VERTEX {} {} {}\n".format(*CORNERS[n]) for n in face)
        + "endloop\nendfacet\n"
        for face in FACES
    ]
    first, second = "".join(facets[:2]), "".join(facets[2:])
    return f"solid a vertex 1 2 3\n{first}endsolid a facet\r\nsolid\n{second}endsolid\n".encode()


def binary_ply(order, *elements):
    """Return a binary PLY file of the tetrahedron's corners and of elements: a header, and bytes."""
    vertices = (
        "element vertex 4\nproperty uchar red\nproperty double x\nproperty double y\nproperty double z\n",
        b"".join(struct.pack(f"{order}B3d", 9, *corner) for corner in CORNERS),
    )
    heads, parts = zip(vertices, *elements, strict=True)
    name = {"<": "little", ">": "big"}[order]
    return f"ply\nformat binary_{name}_endian 1.0\n{''.join(heads)}end_header\n".encode() + b"".join(parts)


def lists(order, name, rows, kinds="uchar int"):
    """Return an element of a binary PLY file with lists of corners."""
    count, item = ({"uchar": "B", "ushort": "H", "int": "i"}[kind] for kind in kinds.split())
    return (
        f"element {name} {len(rows)}\nproperty list {kinds} vertex_indices\nproperty float quality\n",
        b"".join(struct.pack(f"{order}{count}{len(row)}{item}f", len(row), *row, 1) for row in rows),
    )


def shape(data, kind):
    """Return a mesh's triangles, sorted, in thousandths of the unit, from the lowest corner."""
    vertices, triangles, *_ = mesh_reader.read(data, kind)
    corners = np.round(1000 * (vertices - vertices.min(0))).astype(int).tolist()
    return sorted(sorted(corners[n] for n in face) for face in triangles.tolist())


def short(value):
    """Return a parameter's part of a test's name."""
    return "" if isinstance(value, bytes) else value[:40]


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
    path.write_bytes(obj(CORNERS + np.eye(4)[:, :1] * (0.5, 0.5, 0)) + b"\nl 1 2")  # one corner is nearer to the axis
    scene = Chess(piece=path)
    x, y, z = points(scene.piece).T
    assert np.hypot(x, z).max() == pytest.approx(0.5, abs=1e-5) and y.min() == 0
    assert z[y.argmax()] > 0 < y.max()  # the corner with the greatest y has the least z of the file
    said = dict(warnings(scene))["piece"]
    assert said == f"piece = '{path}': scaled to a height of {y.max():.3g} tiles (another: height=); {mesh_reader.FLAT}"
    slim = tmp_path / "slim.obj"
    slim.write_bytes(obj(CORNERS * (0.1, 9, 0.1)))
    assert points(Chess(piece=slim).piece)[:, 1].max() == pytest.approx(mesh.MAX_HEIGHT, abs=1e-4)


def spaced(data):
    """The same OBJ file, as other programs write it."""
    lines = [f"\t{line.replace(' ', chr(9))}  # {line}" for line in data.decode().splitlines()]
    lines.insert(1, "# C:\\models\\")
    return ("\ufeff" + "\r\n".join(lines).replace("f\t1\t2\t4", "f\t1\t2\\\r\n4")).encode()


def relative(data):
    """The same OBJ file: each face follows its corners, and its indices count back from there."""
    *vertices, a, b, c, d = data.decode().splitlines()
    return "\n".join(
        [
            *vertices[:-1],
            "f -3/1/1 -1/2/1 -2/3/1",
            "vn 0 0 1",
            vertices[-1],
            "fo -4 -3 4",
            "f -4//1 -1//1 -2//1",
            "f 2 3 -1",
        ]
    ).encode()


SIZES = np.array([4, 2, 3])
STRIP, FAN = [0, 2, 1, 3, 0, 2], [0, 2, 1, 3, 2]
NUMBERS = np.float32(CORNERS).tobytes() + np.uint32(FACES).tobytes()  # of glb()


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        ("obj", spaced(obj())),
        ("obj", BOM + obj().partition(b"\n")[2]),
        ("obj", relative(obj())),
        ("stl", stl() + b"more"),
        ("stl", ascii_stl()),
        ("ply", ply().replace(b"\n0", b"\n\n0").replace(b"\n", b"\r\n")),
        ("ply", binary_ply(">", lists(">", "face", FACES))),
        ("ply", binary_ply("<", lists("<", "hole", [(1,), ()]), lists("<", "face", FACES, "ushort uchar"))),
        ("glb", glb(extensionsRequired=["KHR_materials_unlit", "KHR_texture_transform"])),
        (
            "glb",
            glb(
                np.int16(CORNERS * 8191),
                accessor={"normalized": True},
                node={"scale": [4] * 3},
                extensionsRequired=["KHR_mesh_quantization"],
            ),
        ),
        (
            "glb",
            glb(
                *(CORNERS / 2, FACES, np.float32(CORNERS)),
                part={"targets": [{}, {"POSITION": 2}]},
                mesh={"weights": [9, 9]},
                node={"weights": [1, 0.5]},
            ),
        ),
        (
            "glb",
            glb(
                *(CORNERS * 0, FACES, np.uint32([[3], [1], [2]]), np.float32(CORNERS[[3, 1, 2]])),
                accessor={
                    "sparse": {
                        "count": 3,
                        "indices": {"bufferView": 2, "componentType": 5125},
                        "values": {"bufferView": 3},
                    }
                },
            ),
        ),
        ("glb", glb(faces=STRIP, part={"mode": 5})),
        ("glb", glb(buffers=[{"uri": "data:;base64," + base64.b64encode(NUMBERS).decode()}])),
        (
            "glb",
            glb(
                *(CORNERS, FAN, np.uint32([[1], [2], [3]])),
                meshes=[
                    {
                        "primitives": [
                            {"attributes": {"POSITION": 0}, "indices": 1, "mode": 6},
                            {"attributes": {"POSITION": 0}, "indices": 2},
                        ]
                    }
                ],
            ),
        ),
        # nodes: turned by 90 degrees about z, then stretched, then moved; the mesh hangs at a camera
        (
            "glb",
            glb(
                (CORNERS - [5, 6, 7]) @ [[0, -1, 0], [1, 0, 0], [0, 0, 1]] / SIZES,
                scene=1,
                scenes=[{"nodes": [2]}, {"nodes": [1]}],
                nodes=[
                    {"mesh": 0, "scale": SIZES.tolist()},
                    {
                        "camera": 0,
                        "children": [3],
                        "matrix": [*(1, 0, 0, 0), *(0, 1, 0, 0), *(0, 0, 1, 0), *(5, 6, 7, 1)],
                    },
                    {"mesh": 0},
                    {"rotation": [0, 0, 0.5**0.5, 0.5**0.5], "children": [0], "camera": 0},
                ],
            ),
        ),
    ],
    ids=short,
)
def test_files_of_other_programs(kind, data):
    """Each of them describes the tetrahedron."""
    assert shape(data, kind) == shape(globals()[kind](), kind) and len(shape(data, kind)) == 4


@pytest.mark.parametrize("kind", ["obj", "ply"])
def test_faces_with_any_number_of_corners(kind, tmp_path):
    """A box whose top and bottom are crosses, not convex: the same as five boxes of quads side by side."""
    x, y = np.array([(1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2), (2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (1, 1)]).T
    n = len(x)
    corners = np.concatenate([np.column_stack((x, y, 0 * x + z)) for z in (0, 1)])
    rows = [range(n)[::-1], range(n, 2 * n), *((k, (k + 1) % n, (k + 1) % n + n, k + n) for k in range(n))]
    if kind == "obj":
        lines = ["v {} {} {}".format(*corner) for corner in corners]
        data = "\n".join(lines + [" ".join(["f", *(str(k + 1) for k in row)]) for row in rows]).encode()
    else:
        head, body = binary_ply("<", lists("<", "face", rows)).replace(b"vertex 4", b"vertex 24").split(b"end_header\n")
        table = b"".join(struct.pack("<B3d", 9, *corner) for corner in corners)
        data = head + b"end_header\n" + table + body[4 * 25 :]
    vertices, triangles, said = mesh_reader.read(data, kind)
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    assert said["count"] == 2 * 10 + 12 * 2 and not said["is_open"]
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(2 * 5 + 12)
    assert np.einsum("ij,ij", a, np.cross(b, c)) / 6 == pytest.approx(5)


def test_faces_of_any_outline():
    """Stars whose corners are at random distances, in any plane, and a square with a hole: the areas are right."""
    random = np.random.default_rng(1)
    square = np.array([0, 4, 4 + 4j, 4j, 0, 1 + 1j, 1 + 3j, 3 + 3j, 3 + 1j, 1 + 1j])
    outlines = [square, square[::-1]]
    wall = np.array([0, *(2 * k + step for k in range(6) for step in (1j, 2j, 1 + 2j, 1 + 1j)), 11])
    outlines += [np.round(wall * np.exp(1j * turn), 6) for turn in random.uniform(0, 6, 100)]  # corners in one line
    for n in range(5, 40):
        outlines.append(random.uniform(0.2, 1, n) * np.exp(2j * np.pi * np.arange(n) / n))
    for outline in outlines:
        plane = np.linalg.qr(random.normal(size=(3, 3)))[0][:2]
        points = np.column_stack((outline.real, outline.imag)) @ plane + 5
        a, b, c = points[mesh_reader._triangles(points, np.arange(len(points)), np.array([len(points)]))].transpose(
            1, 0, 2
        )
        area = abs((outline.conj() * np.roll(outline, -1)).imag.sum())
        assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() == pytest.approx(area)


FLAT, MOVING = mesh_reader.FLAT, mesh_reader.MOVING


@pytest.mark.parametrize(
    ("kind", "data", "said"),
    [
        ("obj", obj() + b"\nl 1 2\np 1", FLAT),
        (
            "glb",
            glb(
                meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": n} for n in (1, 4)]}],
                animations=[{}],
            ),
            f"{MOVING}; {FLAT}",
        ),
    ],
    ids=short,
)
def test_what_is_left_out_is_said(kind, data, said):
    assert mesh_reader.read(data, kind)[-1]["left_out"] == said and shape(data, kind) == shape(stl(), "stl")


def test_a_surface_that_is_not_closed_is_said(tmp_path):
    """Of such a mesh, the renderer gl and outlines can lack parts."""
    for name, faces in (("open", FACES[:3]), ("closed", FACES), ("inside out", [face[::-1] for face in FACES])):
        path = tmp_path / f"{name}.stl"
        path.write_bytes(stl(faces=faces))
        assert ("not closed" in Chess(piece=path).piece.note) == (name == "open")


def test_the_reader_simplifies(monkeypatch):
    """A bowl of 5000 triangles: near each of its points is one of the result, and the other way round."""
    monkeypatch.setattr(mesh_reader, "MAX_TRIANGLES", 3000)
    x, y = np.meshgrid(np.linspace(-1, 1, 51), np.linspace(-1, 1, 51))
    corners = np.column_stack((x.ravel(), y.ravel(), (x * x + y * y).ravel()))
    n = (np.arange(50)[:, None] * 51 + np.arange(50)).ravel()
    faces = np.concatenate([np.column_stack((n, n + 1, n + 52)), np.column_stack((n, n + 52, n + 51))])
    vertices, triangles, said = mesh_reader.read(stl(corners, faces), "stl")
    assert said["is_open"] and said["count"] == 5000 and 1000 < len(triangles) <= 3000
    gaps = np.linalg.norm(np.float32(corners)[:, None] - vertices, axis=2)
    assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) <= said["moved"] + 1e-6 and 0.02 < said["moved"] < 0.1


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
    for height in (0, 1e-7, 0.014):  # rounding errors, and less than can be stated
        for options in ("", ",height=0.5"):
            said = refused(tmp_path / "flat.stl", stl(CORNERS * (1, 1, height)), options)
            assert "should have a height: as wide as it can be, it is " in said and "allowed: from 0.01 tiles" in said


@pytest.mark.parametrize(
    ("kind", "data", "said"),
    [
        ("stl", stl()[:-20], "should be a whole stl file: it has 3 of its 4 triangles"),
        ("stl", stl(faces=[]), "should be a mesh with triangles"),
        ("stl", ascii_stl()[:-10], "should be a whole stl file: of triangles, with 'endsolid' at the end"),
        ("stl", stl(CORNERS * np.nan), "should be a mesh whose numbers are finite"),
        ("obj", b"v 0 0 0\nv 0 0 1\nf 1 2 99999999\n", "should be a mesh whose vertices exist"),
        ("obj", obj() + b"\nsurf 0 1 0 1 1 2 3", "should be an OBJ file of polygons alone, without 'surf'"),
        ("ply", ply()[:-30], "should be a whole ply file"),
        ("ply", binary_ply("<", lists("<", "tristrips", [STRIP])), "should be a mesh with triangles"),
        ("glb", glb()[:-4], "should be a whole glb file"),
        ("glb", b"glTF\1\0\0\0" + glb()[8:], "should be glTF 2.0, not glTF 1.0: convert it, as by npx gltf-pipeline"),
        ("glb", glb(extensionsRequired=["NEW_x"]), "without 'NEW_x', an extension that povgen does not read"),
        ("glb", glb(part={"extensions": {"KHR_draco_mesh_compression": {}}}), "without 'KHR_draco_mesh_compression'"),
        ("glb", glb(node={"extensions": {"EXT_mesh_gpu_instancing": {}}}), "without 'EXT_mesh_gpu_instancing'"),
        (
            "glb",
            glb(node={"skin": 0}),
            "should be a GLB file without a skin: apply the skeleton's pose before the export",
        ),
        (
            "glb",
            glb(buffers=[{"uri": "b.bin"}]),
            "should be a GLB file that has all its numbers, without the file 'b.bin'",
        ),
    ],
    ids=short,
)
def test_files_that_are_refused(kind, data, said):
    assert said in refusal(lambda: mesh_reader.read(data, kind), ValueError)


def test_a_file_that_is_too_large_or_takes_too_long(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh, "MAX_BYTES", 100)
    assert "should be a file of at most 100 bytes" in refused(tmp_path / "model.stl", stl())
    monkeypatch.undo()
    monkeypatch.setattr(readers, "PATIENCE", 0.01)
    assert "should be a mesh that is read within 0.01 s" in refused(tmp_path / "model.stl", stl(CORNERS * 2))
    monkeypatch.undo()
    huge = glb(accessor={"count": 10**10, "bufferView": None})
    assert "should be a file that needs less memory" in refused(tmp_path / "model.glb", huge)


def test_a_movie_reads_the_file_once(tmp_path, monkeypatch):
    (tmp_path / "model.stl").write_bytes(stl(CORNERS * 5))
    read = []
    once = readers.run
    monkeypatch.setattr(readers, "run", lambda *given: read.append(1) or once(*given))
    text = """title = "T"\nscene = "chess"\nframes = 4\n[fixed]\npiece = "model.stl,height=0.5"
[[sweep]]\nparameter = "alpha"\nstart = 1\nstop = 9\n"""
    spec = MovieSpec.parse(text, "spec", tmp_path)
    assert len(spec.scenes("standard")) == 4 and len(read) == 1
    assert spec.model_dump()["fixed"]["piece"] == f"{tmp_path}/model.stl,height=0.5"
    assert pieces.radius(spec.scenes("standard")[0].piece) == pieces.FILE_RADIUS
