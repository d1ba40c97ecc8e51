"""Reads a mesh in a process of its own, whose memory and time are limited: `python -m povgen.scene.mesh_reader KIND`.

KIND is stl, obj, ply or glb. The file's bytes come by standard input. Standard output gets three arrays in numpy's
format. The first has the vertices, (n, 3). The second has the triangles, (m, 3): indices of vertices, from 0. The third
has three numbers: the number of triangles in the file, the greatest distance by which simplification moves a vertex,
and 1 if the surface is not closed (otherwise 0). Lengths are in the file's unit. The exit status is 0 for success,
NO_TRIMESH if trimesh is not installed, and 1 for a fault, which is described in a line on standard error. Only this
module uses trimesh.
"""

import json
import re
import resource
import sys
from importlib import import_module
from io import BytesIO
from typing import Any

NO_TRIMESH = 3
MAX_MEMORY = 3 << 30  # bytes of address space
MAX_TIME = 60  # seconds of CPU time
MAX_TRIANGLES = 200_000  # of the result; a text for POV-Ray of about 8 MB
FINEST = 2**20  # cells along the longest side: all vertices in one of these cells become one vertex
BOM = b"\xef\xbb\xbf"
TRIANGLE_FAN = 6  # a primitive's mode in glTF
COMPRESSIONS = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}  # extensions of glTF


def main() -> int:
    """Read, simplify and write a mesh. Return the exit status."""
    limits = ((resource.RLIMIT_AS, MAX_MEMORY), (resource.RLIMIT_CPU, MAX_TIME))
    for limit, most in limits:
        hard = resource.getrlimit(limit)[1]
        resource.setrlimit(limit, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    try:
        import_module("trimesh")  # after the limits are set
    except ImportError:
        return NO_TRIMESH
    try:
        output = BytesIO()  # numpy cannot always write to a pipe
        for array in _mesh(sys.stdin.buffer.read(), sys.argv[1]):
            _numpy().save(output, array, allow_pickle=False)
        sys.stdout.buffer.write(output.getvalue())
    except ImportError:  # for edges, trimesh needs other packages
        fault = "should be a mesh of vertices and faces alone"
    except MemoryError:
        fault = "should be a mesh that needs less memory"
    except ValueError as error:
        fault = str(error) if str(error).startswith("should be ") else f"should be a whole {sys.argv[1]} file"
    except Exception:  # of trimesh, for a malformed file
        fault = f"should be a whole {sys.argv[1]} file"
    else:
        return 0
    sys.stderr.write(fault)
    return 1


def _numpy() -> Any:  # noqa: ANN401  (imported after the limits are set)
    import numpy

    return numpy


def _mesh(data: bytes, kind: str) -> tuple[Any, Any, Any]:
    """Return the three arrays. Raises ValueError, or anything that trimesh raises."""
    import numpy as np
    import trimesh

    if prepared := {"obj": _plain_obj, "stl": _whole_stl, "glb": _checked_glb}.get(kind):
        data = prepared(data)
    mesh = trimesh.load_mesh(BytesIO(data), file_type=kind, process=False)
    vertices, triangles = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
    if not len(triangles):
        raise ValueError("should be a mesh with triangles")
    if triangles.min() < 0 or triangles.max() >= len(vertices) or not np.isfinite(vertices[triangles]).all():
        raise ValueError("should be a mesh whose numbers are finite and whose vertices exist")
    used, triangles = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], triangles.reshape(-1, 3)
    count, longest = len(triangles), float(np.ptp(vertices, axis=0).max())
    if not 1e-9 < longest < 1e9:
        raise ValueError("should be a mesh whose longest side is from 1e-9 to 1e9")
    kept, left, moved = _clustered(vertices, triangles, longest / FINEST)
    edges = np.sort(left[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    is_open = bool(len(left)) and (np.unique(edges, axis=0, return_counts=True)[1] == 1).any()
    size = longest / 1024
    while len(left) > MAX_TRIANGLES:
        kept, left, moved = _clustered(vertices, triangles, size)
        size *= 1.25
    if not len(left):
        raise ValueError("should be a mesh with triangles that have an area")
    return kept, left, np.array([count, moved, is_open])


def _plain_obj(data: bytes) -> bytes:
    """Return an OBJ file with single spaces, no comments and no continued lines: trimesh can skip lines with these."""
    data = data.removeprefix(BOM).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    data = re.sub(rb"#[^\n]*", b"", data).replace(b"\\\n", b" ")
    return b"\n".join(b" ".join(line.split()) for line in data.split(b"\n"))


def _whole_stl(data: bytes) -> bytes:
    """Return a binary STL file without what follows its last triangle. A text file stays as it is."""
    end = 84 + 50 * int.from_bytes(data[80:84], "little")
    return data[:end] if b"\0" in data[:134] and 84 < end < len(data) else data


def _checked_glb(data: bytes) -> bytes:
    """Return a GLB file. Raises ValueError for what trimesh does not read, or reads as another shape."""
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    if any("sparse" in accessor for accessor in document.get("accessors", ())):
        raise ValueError("should be a GLB file without sparse accessors")
    if any(part.get("mode") == TRIANGLE_FAN for mesh in document.get("meshes", ()) for part in mesh["primitives"]):
        raise ValueError("should be a GLB file without triangle fans")
    if packed := {*document.get("extensionsRequired", ())} & COMPRESSIONS:
        raise ValueError(f"should be a GLB file without {min(packed)}")
    return data


def _clustered(vertices: Any, triangles: Any, size: float) -> tuple[Any, Any, float]:  # noqa: ANN401  (numpy's)
    """Return the mesh in which the mean of the vertices in each cubic cell with the side `size` replaces them.

    The results are the vertices, the triangles that are left, and the greatest distance by which a vertex moves.
    """
    import numpy as np

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
    sys.exit(main())
