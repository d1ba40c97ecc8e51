"""Pieces from mesh files: the file's numbers, and nothing else of it, become a mesh in POV-Ray's language."""

import re
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen.errors import at_most
from povgen.inputs import readers

NAME = re.compile(r"(.*\.(stl|obj|ply|glb))((?:,[a-z]+=[^,=]*)*)", re.IGNORECASE | re.DOTALL)
OWN = re.compile(
    r"#declare Piece = mesh2 \{\nvertex_vectors \{ [\d,<>.e\s+-]*\}\n"
    r"face_indices \{ [\d,<>\s]*\}\ninside_vector y\n\}\n",
    re.ASCII,
)
MAX_BYTES = 50 * 10**6  # of a file
LEAST_HEIGHT = 0.01  # tiles
MAX_HEIGHT = 1.7  # tiles, of a piece whose height is not stated
TALLEST = 4.0  # tiles, that can be stated


def split(value: str) -> tuple[str, str, str] | None:
    """Return the file, its kind and the options of a value such as model.stl,height=1.2,up=z; None for no mesh."""
    found = NAME.fullmatch(value)
    return (found[1], found[2].lower(), found[3]) if found else None


@lru_cache(maxsize=4)  # every frame of a movie may ask for the same
def text_and_note(data: bytes, kind: str, options: str, radius: float) -> tuple[str, str]:
    """Return a text that declares `Piece`, and a note for the user, which is empty if there is nothing to say.

    `data` is the file's content. `kind` and `options` are results of `split`, such as "stl" and ",height=1.2,up=z". The
    piece stands on y = 0. The middle of its box is on the y axis. It stays within `radius`, in tiles, of this axis. It
    is as high as the option `height` says, or else as large as it can be, up to MAX_HEIGHT. The option `up`, y or z, is
    the file's axis that points up: by default z for stl and ply, y for obj and glb. Raises ValueError for a wrong
    option, for a file that is no whole mesh, for a mesh without height, and for a height with which it is too wide.
    """
    height, up = _checked(kind, options)

    said, content = readers.run("mesh_reader", "mesh", data, kind)
    at = 24 * said["points"]  # bytes of the vertices
    vertices, triangles = np.frombuffer(content[:at]).reshape(-1, 3), np.frombuffer(content[at:], int).reshape(-1, 3)
    x, y, z = vertices.T
    points = np.column_stack((x, y, -z) if up == "y" else (x, z, y))  # POV-Ray is left-handed: z points away
    low, high = points.min(axis=0), points.max(axis=0)
    points -= [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]
    reach, tall = float(np.hypot(points[:, 0], points[:, 2]).max()), float(points[:, 1].max())
    most = min(radius / reach if reach else np.inf, TALLEST / tall if tall else np.inf)
    if most * tall < LEAST_HEIGHT:  # rounding errors are no height
        raise ValueError(
            f"should have a height: as wide as it can be, it is {most * tall:.2g} tiles high; allowed: from "
            f"{LEAST_HEIGHT:g} tiles, or another up="
        )
    scale = min(most, MAX_HEIGHT / tall)
    if height is not None:
        if height / tall > most * (1 + 1e-9):
            raise ValueError(
                f"should be within {radius:g} tiles of its axis: height = {height:g} is too much; "
                f"allowed: up to {at_most(most * tall)}"
            )
        scale = height / tall
    points *= scale
    note = [] if height is not None else [f"scaled to a height of {tall * scale:.3g} tiles (another: height=)"]
    if len(triangles) < said["count"] and (moved := said["moved"] * scale) > 1e-5:
        note.append(f"{len(triangles)} of {said['count']} triangles, no point moved by more than {moved:.2g} tiles")
    if said["left_out"]:
        note.append(said["left_out"])
    if said["is_open"]:
        note.append(
            "its surface is not closed: parts may be missing in outlines, with the renderer gl, and on the page"
        )
    return _sdl(points, triangles), "; ".join(note)


def _checked(kind: str, text: str) -> tuple[float | None, str]:
    """Return the height in tiles, or None, and the axis that points up. Raises ValueError."""
    options = {name: value for name, _, value in (part.partition("=") for part in text.split(",")[1:])}
    for name in options.keys() - {"height", "up"}:
        raise ValueError(f"should have no option {name!r}: allowed: height and up, as in model.stl,height=1.2,up=z")
    up = options.get("up", "z" if kind in ("stl", "ply") else "y")
    if up not in ("y", "z"):
        raise ValueError(f"should have up=y or up=z, not up={up}")
    if "height" not in options:
        return None, up
    try:
        height = float(options["height"])
    except ValueError:
        height = 0
    if not LEAST_HEIGHT <= height <= TALLEST:
        raise ValueError(
            f"should have a height from {LEAST_HEIGHT:g} to {TALLEST:g} tiles, not height={options['height']}"
        )
    return height, up


def is_own(text: str) -> bool:
    """Return whether a text that declares `Piece` is a mesh of numbers, as `text_and_note` writes it."""
    return bool(OWN.fullmatch(text))


def _sdl(points: NDArray[Any], triangles: NDArray[Any]) -> str:
    """Return a text that declares `Piece` as a mesh2."""
    vectors = ",\n".join(f"<{x:.6g}, {y:.6g}, {z:.6g}>" for x, y, z in points.tolist())
    faces = ",\n".join(f"<{a}, {b}, {c}>" for a, b, c in triangles.tolist())
    return (
        "#declare Piece = mesh2 {\n"
        f"vertex_vectors {{ {len(points)},\n{vectors} }}\n"
        f"face_indices {{ {len(triangles)},\n{faces} }}\n"
        "inside_vector y\n"
        "}\n"
    )
