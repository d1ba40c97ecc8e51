"""Reads a mesh, in a process of its own (`readers`): `python -m povgen.inputs.mesh_reader KIND`.

KIND is stl, obj, ply or glb. The answer is what `read` returns.

The formats: the OBJ specification of Wavefront (Advanced Visualizer, appendix B1), the PLY format of Greg Turk, STL,
and glTF 2.0 of the Khronos Group (ISO/IEC 12113). What changes the shape is applied, or refused by its name.
"""

import base64
import json
import re
import struct
import sys
from array import array
from collections.abc import Iterator
from typing import Any

import numpy as np

from povgen.inputs import readers

MAX_MEMORY = 3 << 30  # bytes of address space
MAX_TIME = 60  # seconds of CPU time
MAX_TRIANGLES = 200_000  # of the result; a text for POV-Ray of about 8 MB
FINEST = 2**20  # cells along the longest side: all vertices in one of these cells become one vertex
FLAT = "its lines and points are left out: they have no thickness"
MOVING = "its animation is not played: it is shown as it stands in the file"

BOM = b"\xef\xbb\xbf"
# OBJ: curves and surfaces that are no polygons, another file, and a command
OBJ_REFUSED = {b"curv", b"surf", b"bsp", b"bzp", b"cdc", b"cdp", b"call", b"csh"}
PLY_ORDERS = {b"ascii": "", b"binary_little_endian": "<", b"binary_big_endian": ">"}
PLY_TYPES = {
    **{b"char": "b", b"uchar": "B", b"short": "h", b"ushort": "H", b"int": "i", b"uint": "I", b"float": "f"},
    **{b"int8": "b", b"uint8": "B", b"int16": "h", b"uint16": "H", b"int32": "i", b"uint32": "I", b"float32": "f"},
    **{b"double": "d", b"float64": "d"},
}
GLB_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
GLB_SIZES = {"SCALAR": 1, "VEC3": 3}
# Extensions of glTF that change the shape and are not read. A file may require those alone that are read, or that
# change nothing but colours and light.
GLB_REFUSED = [
    *("KHR_draco_mesh_compression", "KHR_meshopt_compression", "EXT_meshopt_compression"),
    *("EXT_mesh_gpu_instancing", "KHR_node_visibility"),
]
GLB_ALLOWED = re.compile(r"KHR_mesh_quantization|[A-Z]+_(materials|texture|lights)_\w+|KHR_xmp(_json_ld)?")


def main() -> None:
    """Read, simplify and write a mesh."""

    def answer(data: bytes) -> tuple[dict[str, Any], bytes]:
        vertices, triangles, said = read(data, sys.argv[1])
        return {"points": len(vertices), **said}, vertices.tobytes() + triangles.tobytes()

    readers.serve(answer, MAX_MEMORY, MAX_TIME)


def read(data: bytes, kind: str) -> tuple[Any, Any, dict[str, Any]]:
    """Return the vertices (n, 3), the triangles (m, 3), which are indices of vertices, and what to say of the mesh.

    That is: `count`, the number of triangles in the file; `moved`, the greatest distance by which simplification moves
    a vertex; `is_open`, if the surface is not closed; `left_out`, what was left out of the mesh. Lengths are in the
    file's unit. Raises ValueError with a description of the fault.
    """
    with readers.faults(f"{kind} file"):
        # the vertices, the corners of all faces as indices of vertices, and the number of corners of each face
        vertices, corners, sizes, left_out = {"obj": _obj, "stl": _stl, "ply": _ply, "glb": _glb}[kind](data)
        if len(corners) and not (0 <= corners.min() and corners.max() < len(vertices)):
            raise ValueError("should be a mesh whose vertices exist")
        triangles = _triangles(vertices, corners, sizes)
        if not len(triangles):
            raise ValueError("should be a mesh with triangles")
        used, triangles = np.unique(triangles, return_inverse=True)
        vertices, triangles = vertices[used], triangles.reshape(-1, 3)
        count, longest = len(triangles), float(np.ptp(vertices, axis=0).max())
        if not np.isfinite(vertices).all():
            raise ValueError("should be a mesh whose numbers are finite")
        if not 1e-9 < longest < 1e9:
            raise ValueError("should be a mesh whose longest side is from 1e-9 to 1e9")
        kept, left, moved = _clustered(vertices, triangles, longest / FINEST)
        edges = np.sort(left[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        is_open = bool(len(left)) and bool((np.unique(edges, axis=0, return_counts=True)[1] == 1).any())
        size = longest / 1024
        while len(left) > MAX_TRIANGLES:
            kept, left, moved = _clustered(vertices, triangles, size)
            size *= 1.25
        if not len(left):
            raise ValueError("should be a mesh with triangles that have an area")
    left_out = FLAT if (sizes < 3).any() else left_out
    return kept, left, {"count": count, "moved": moved, "is_open": is_open, "left_out": left_out}


def _stl(data: bytes) -> tuple[Any, Any, Any, str]:
    if b"\0" in data[:134]:  # a binary file, which can have more after its last triangle
        count, there = int.from_bytes(data[80:84], "little"), max(0, len(data) - 84) // 50
        if there < count:
            raise ValueError(f"should be a whole stl file: it has {there} of its {count} triangles")
        vertices = np.frombuffer(data, "V12, (3, 3)<f4, V2", count, 84)["f1"].reshape(-1, 3).astype(float)
    else:
        text = data.lower().replace(b"\r", b"\n")
        text = re.sub(rb"(?m)^\s*((end)?solid)\b.*", rb"\1", text)  # a name can have any words
        vertices = np.array(re.findall(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", text)).astype(float).reshape(-1, 3)
        facets = len(re.findall(rb"\bfacet\b", text))
        if not (len(vertices) == 3 * facets and text.rstrip().endswith(b"endsolid")):
            raise ValueError("should be a whole stl file: of triangles, with 'endsolid' at the end")
    return vertices, np.arange(len(vertices)), np.full(len(vertices) // 3, 3), ""


def _obj(data: bytes) -> tuple[Any, Any, Any, str]:
    data = data.removeprefix(BOM).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    data = re.sub(rb"#[^\n]*", b"", data).replace(b"\\\n", b" ")
    vertices, corners, sizes, left_out = array("d"), array("q"), array("q"), ""
    for line in data.split(b"\n"):
        word, *values = line.split() or [b""]
        if word == b"v":
            x, y, z = values[:3]
            vertices.extend((float(x), float(y), float(z)))
        elif word in (b"f", b"fo"):
            for value in values:
                index = int(value.partition(b"/")[0])  # from 1; -1 is the last vertex before this line; 0 is none
                corners.append(len(vertices) // 3 + index if index < 0 else index - 1)
            sizes.append(len(values))
        elif word in (b"l", b"p"):
            left_out = FLAT
        elif word in OBJ_REFUSED:
            raise ValueError(f"should be an OBJ file of polygons alone, without {word.decode()!r}")
    return np.array(vertices).reshape(-1, 3), np.array(corners), np.array(sizes), left_out


def _ply(data: bytes) -> tuple[Any, Any, Any, str]:
    head, _, body = re.split(rb"end_header[ \t]*(\r\n|\n|\r)", data, maxsplit=1)
    lines = [line.split() for line in head.splitlines() if line.split()]
    (order,) = (PLY_ORDERS[line[1]] for line in lines if line[0] == b"format")
    rows = _Rows(body, order)
    vertices, corners, sizes, left_out = array("d"), array("q"), array("q"), ""
    for name, count, properties in _elements(lines):
        names = [each[-1] for each in properties]
        if name == b"vertex":
            x, y, z = (names.index(axis) for axis in (b"x", b"y", b"z"))
            for row in rows.take(count, properties):
                vertices.extend((row[x], row[y], row[z]))
        elif name == b"face":
            column = names.index(b"vertex_index" if b"vertex_index" in names else b"vertex_indices")
            for row in rows.take(count, properties):
                corners.extend([int(n) for n in row[column]])
                sizes.append(len(row[column]))
        else:
            left_out = FLAT if name == b"edge" and count else left_out
            for _ in rows.take(count, properties):
                pass
    return np.array(vertices).reshape(-1, 3), np.array(corners), np.array(sizes), left_out


def _elements(lines: list[list[bytes]]) -> list[tuple[bytes, int, list[list[bytes]]]]:
    """Return the elements of a PLY header: name, count, and properties such as [b"list", b"uchar", b"int", name]."""
    found: list[tuple[bytes, int, list[list[bytes]]]] = []
    for line in lines:
        if line[0] == b"element":
            found.append((line[1], int(line[2]), []))
        elif line[0] == b"property":
            found[-1][2].append(line[1:])
    return found


class _Rows:
    """The numbers of a PLY file, from its start to its end."""

    def __init__(self, body: bytes, order: str) -> None:
        self.order, self.at = order, 0  # `order` is struct's sign for the order of bytes, or "" for a text
        self.data: Any = body if order else [float(word) for word in body.split()]

    def take(self, count: int, properties: list[list[bytes]]) -> Iterator[list[Any]]:
        """Yield the values of that many rows: numbers, and lists of numbers."""
        runs: list[tuple[str, str]] = []  # lists: the types of their length and of their numbers; "" for other numbers
        for each in properties:
            if each[0] == b"list":
                runs.append((PLY_TYPES[each[1]], PLY_TYPES[each[2]]))
            else:
                before = runs.pop()[1] if runs and not runs[-1][0] else ""
                runs.append(("", before + PLY_TYPES[each[0]]))
        for _ in range(count if runs else 0):
            row: list[Any] = []
            for length, types in runs:
                row += [self._next(types * int(self._next(length)[0]))] if length else self._next(types)
            yield row

    def _next(self, types: str) -> Any:  # noqa: ANN401  (ints and floats)
        """Return the next numbers: in a binary file, those of these types."""
        start, order = self.at, self.order
        self.at += struct.calcsize(order + types) if order else len(types)
        if self.at > len(self.data):
            raise ValueError
        return struct.unpack_from(order + types, self.data, start) if order else self.data[start : self.at]


def _glb(data: bytes) -> tuple[Any, Any, Any, str]:
    document, binary = _chunks(data)
    required = [name for name in document.get("extensionsRequired", ()) if not GLB_ALLOWED.fullmatch(name)]
    for name in [*required, *(name for name in GLB_REFUSED if f'"{name}"'.encode() in data)]:
        raise ValueError(f"should be a GLB file without {name[:80]!r}, an extension that povgen does not read")
    left_out = {MOVING} if document.get("animations") else set()
    corners = [np.empty((0, 3))]  # of triangles
    nodes = dict(enumerate(document["nodes"]))
    waiting = [(index, np.eye(4)) for index in document["scenes"][document.get("scene", 0)].get("nodes", ())]
    while waiting:
        index, place = waiting.pop()
        node = nodes.pop(index)  # a node has one parent
        place = place @ _placed(node)
        waiting += [(child, place) for child in node.get("children", ())]
        mesh = document["meshes"][node["mesh"]] if "mesh" in node else {"primitives": ()}
        if "skin" in node:
            raise ValueError("should be a GLB file without a skin: apply the skeleton's pose before the export")
        for part in mesh["primitives"]:
            if part.get("mode", 4) < 4:
                left_out.add(FLAT)
                continue
            points = _numbers(document, binary, part["attributes"]["POSITION"]).astype(float)
            weights = node.get("weights", mesh.get("weights", ()))
            for weight, target in zip(weights, part.get("targets", ()), strict=False):
                points += weight * _numbers(document, binary, target["POSITION"]) if "POSITION" in target else 0
            order = _numbers(document, binary, part["indices"]).ravel() if "indices" in part else np.arange(len(points))
            triangles: Any = {4: np.ravel, 5: _strip, 6: _fan}[part.get("mode", 4)]
            corners.append(points[triangles(order).ravel()] @ place[:3, :3].T + place[:3, 3])
    vertices = np.concatenate(corners)
    return vertices, np.arange(len(vertices)), np.full(len(vertices) // 3, 3), "; ".join(sorted(left_out))


def _chunks(data: bytes) -> tuple[Any, bytes]:
    """Return a GLB file's description and its binary part."""
    magic, version, length = struct.unpack_from("<4sII", data)
    if magic == b"glTF" and version == 1:
        raise ValueError("should be glTF 2.0, not glTF 1.0: convert it, as by npx gltf-pipeline -i old.glb -o new.glb")
    chunks: dict[bytes, bytes] = {}
    at = 12
    while at < length:
        size, kind = struct.unpack_from("<I4s", data, at)
        at += 8 + size
        chunks.setdefault(kind, data[at - size : at])
    if magic != b"glTF" or at > len(data):
        raise ValueError
    return json.loads(chunks[b"JSON"]), chunks.get(b"BIN\0", b"")


def _numbers(document: Any, binary: bytes, index: int) -> Any:  # noqa: ANN401
    """Return the numbers of an accessor of a GLB file, (count, size)."""
    accessor = document["accessors"][index]
    kind, size, count = GLB_TYPES[accessor["componentType"]], GLB_SIZES[accessor["type"]], accessor["count"]

    def block(place: Any, kind: str, size: int, count: int) -> Any:  # noqa: ANN401
        view = document["bufferViews"][place["bufferView"]]
        uri = document["buffers"][view["buffer"]].get("uri")
        if uri is not None and not uri.startswith("data:"):
            raise ValueError(f"should be a GLB file that has all its numbers, without the file {uri[:80]!r}")
        buffer = binary if uri is None else base64.b64decode(uri.partition(",")[2])
        start, width = view.get("byteOffset", 0) + place.get("byteOffset", 0), np.dtype(kind).itemsize
        return np.ndarray((count, size), kind, buffer, start, (view.get("byteStride", size * width), width)).copy()

    found = block(accessor, kind, size, count) if "bufferView" in accessor else np.zeros((count, size), kind)
    if sparse := accessor.get("sparse"):
        changed = block(sparse["indices"], GLB_TYPES[sparse["indices"]["componentType"]], 1, sparse["count"])
        found[changed.ravel()] = block(sparse["values"], kind, size, sparse["count"])
    return np.maximum(found / np.iinfo(kind).max, -1) if accessor.get("normalized") else found


def _placed(node: Any) -> Any:  # noqa: ANN401
    """Return a node's matrix, (4, 4), for column vectors."""
    if "matrix" in node:
        return np.reshape(node["matrix"], (4, 4)).T
    place = np.eye(4)
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    turn = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    place[:3, :3] = (np.eye(3) + 2 * (w * turn + turn @ turn)) * node.get("scale", (1, 1, 1))
    place[:3, 3] = node.get("translation", (0, 0, 0))
    return place


def _strip(corners: Any) -> Any:  # noqa: ANN401  (numpy's)
    return np.column_stack((corners[:-2], corners[1:-1], corners[2:]))


def _fan(corners: Any) -> Any:  # noqa: ANN401  (numpy's)
    """Return the triangles of convex faces (..., n): (..., n - 2, 3)."""
    second, third = corners[..., 1:-1], corners[..., 2:]
    return np.stack((np.broadcast_to(corners[..., :1], second.shape), second, third), axis=-1)


def _triangles(vertices: Any, corners: Any, sizes: Any) -> Any:  # noqa: ANN401  (numpy's)
    """Return the triangles of faces (n, 3), also of faces that are not convex. Faces of two corners are left out."""
    starts, found = np.cumsum(sizes) - sizes, [np.empty((0, 3), np.int64)]
    for size in np.unique(sizes[sizes > 2]):
        faces = corners[starts[sizes == size][:, None] + np.arange(size)]
        fans = _fan(faces)
        if size > 3:
            points = vertices[faces]
            sides = points[:, 1:] - points[:, :1]
            turns = np.cross(sides[:, :-1], sides[:, 1:])  # twice the areas of the fan's triangles
            normals = turns.sum(axis=1)
            forward = np.einsum("fti,fi->ft", turns, normals)
            squares = np.einsum("fi,fi->f", normals, normals)
            for face in np.flatnonzero((forward < -1e-6 * squares[:, None]).any(axis=1)):
                fans[face] = faces[face][_ears(points[face], normals[face])]
        found.append(fans.reshape(-1, 3))
    return np.concatenate(found)


def _ears(points: Any, normal: Any) -> Any:  # noqa: ANN401  (numpy's)
    """Return the triangles of a face that is not convex: one corner after the other is cut off ("ear clipping").

    The corners are numbered from 0. A face that crosses itself has no inside: then any triangles are returned.
    """
    axis = np.abs(normal).argmax()  # the face is seen along this axis, counterclockwise
    flat = points[:, (axis + 1) % 3] + 1j * points[:, (axis + 2) % 3] * np.sign(normal[axis])
    found, left = [], np.arange(len(points))

    least = -1e-6 * np.abs(normal).max()  # corners in one line: their numbers are rounded

    def turn(a: Any, b: Any, p: Any) -> Any:  # noqa: ANN401
        """Above 0 where the point p is to the left of the line from a to b."""
        return ((b - a).conjugate() * (p - a)).imag

    while len(left) > 3:
        for n in range(len(left)):
            ear = left[[n - 1, n, (n + 1) % len(left)]]
            a, b, c = flat[ear]
            others = flat[left]
            others = others[(others != a) & (others != b) & (others != c)]
            inside = (turn(a, b, others) >= least) & (turn(b, c, others) >= least) & (turn(c, a, others) >= least)
            if turn(a, b, c) > -least and not inside.any():
                break
        else:
            n = 1
        found.append(left[[n - 1, n, (n + 1) % len(left)]])
        left = np.delete(left, n)
    return np.array([*found, left])


def _clustered(vertices: Any, triangles: Any, size: float) -> tuple[Any, Any, float]:  # noqa: ANN401  (numpy's)
    """Return the mesh in which the mean of the vertices in each cubic cell with the side `size` replaces them.

    The results are the vertices, the triangles that are left, and the greatest distance by which a vertex moves.
    """
    cells = ((vertices - vertices.min(axis=0)) / size).astype(np.int64)
    _, number, count = np.unique(cells @ [1, 2**21, 2**42], return_inverse=True, return_counts=True)
    number = number.reshape(-1)
    means = np.column_stack([np.bincount(number, column) / count for column in vertices.T])
    moved = float(np.linalg.norm(vertices - means[number], axis=1).max())
    left = number[triangles]
    whole = (left[:, 0] != left[:, 1]) & (left[:, 1] != left[:, 2]) & (left[:, 2] != left[:, 0])
    _, single = np.unique(np.sort(left[whole], axis=1), axis=0, return_index=True)
    return means, left[whole][np.sort(single)], moved


if __name__ == "__main__":
    main()
