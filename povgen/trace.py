"""Exact ray trace of Dove-prism sheets, on numpy arrays. Every ray is followed until it leaves the sheets.

Coordinates are those of the scenes: x right, y up, z away from the eye, the sheets centred on z = 0, lengths in the
unit of the window's side. Rays may run either way. Glass neither absorbs nor reflects partially; light that meets the
frame round the window ends there. Inside a sheet, u is the height above the base of the prism (or of the prism below
the air) that the ray is in, in the sheet's own frame, whose prisms lie along x.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from povgen import prism

CHUNK = 16384  # rays at a time: their arrays stay in the processor's cache


class Face(IntEnum):
    """Faces of a prism, in the order in which a ray's path lists them. NEAR is the facet towards negative z."""

    NONE = 0
    BASE = 1
    TOP = 2
    NEAR = 3
    FAR = 4


class End(IntEnum):
    """How a ray ends."""

    THROUGH = 0  # leaves on the side that it did not come from
    BACK = 1  # leaves on the side that it came from
    FRAME = 2  # meets the frame
    UNFINISHED = 3  # still among the prisms after the greatest number of faces


@dataclass(frozen=True)
class Sheet:
    """A sheet of prisms: turned by `angle` (radians) about z, centred on z = `centre`."""

    angle: float
    centre: float


@dataclass
class Rays:
    """Where rays leave the sheets: position and direction (n, 3); how, `End` (n,); faces met, `Face` (n, most), and
    how many (n,); and whether each took the proper path: entry facet, base and exit facet in every sheet."""

    position: np.ndarray
    direction: np.ndarray
    end: np.ndarray
    faces: np.ndarray
    count: np.ndarray
    proper: np.ndarray


class _Glass:
    """The shape of the prisms, and the plane of each face: outward normal (u, z) and distance from u = z = 0."""

    def __init__(self, window: float, prisms: int, gap: float):
        self.window, self.pitch = window, window / prisms
        self.gap = gap * self.pitch
        self.height = self.pitch - self.gap
        self.half = self.height * prism.aspect() / 2
        slope = np.radians(prism.BASE_ANGLE)
        c, s = np.cos(slope), np.sin(slope)
        # in the order of Face, from BASE
        self.nu = np.array([-1.0, 1.0, c, c])
        self.nz = np.array([0.0, 0.0, -s, s])
        self.distance = np.array([0.0, self.height, s * self.half, s * self.half])
        self.first = -prisms / 2 * self.pitch + self.gap / 2  # the base of prism 0


def pair(alpha: float, window: float, prisms: int, gap: float = prism.AIR_GAP) -> tuple[Sheet, Sheet]:
    """The two sheets that rotate light by alpha (radians), from the eye onwards: the near one turned by alpha/2."""
    glass = _Glass(window, prisms, gap)
    offset = glass.half + glass.gap / 2
    return Sheet(alpha / 2, -offset), Sheet(0.0, offset)


def trace(
    origin: np.ndarray,
    direction: np.ndarray,
    sheets: tuple[Sheet, ...],
    window: float,
    prisms: int,
    gap: float = prism.AIR_GAP,
    most: int = 60,
) -> Rays:
    """Follow rays, (n, 3) origins and directions of any length, from outside through sheets listed from the eye on.

    `gap` is the air between prisms in units of their pitch; after `most` faces a ray is given up, which its end says.
    """
    glass = _Glass(window, prisms, gap)
    origin, direction = np.broadcast_arrays(np.asarray(origin, float), np.asarray(direction, float))
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    n = len(origin)
    rays = Rays(
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty(n, np.uint8),
        np.zeros((n, most), np.uint8),
        np.zeros(n, int),
        np.zeros(n, bool),
    )
    for start in range(0, n, CHUNK):
        part = slice(start, start + CHUNK)
        chunk = Rays(*(getattr(rays, name)[part] for name in rays.__dataclass_fields__))
        chunk.position[:], chunk.direction[:] = origin[part], direction[part]
        _follow(chunk, sheets, glass)
    steps = 3 * len(sheets)
    path = np.array([Face.NEAR, Face.BASE, Face.FAR] * len(sheets))
    path = np.where(direction[:, 2:] > 0, path, path[::-1])
    rays.proper = (rays.end == End.THROUGH) & (rays.count == steps) & (rays.faces[:, :steps] == path).all(1)
    return rays


def _follow(rays: Rays, sheets: tuple[Sheet, ...], glass: _Glass) -> None:
    """Take rays through the sheets, back and forth between them, until all have ended."""
    forward = rays.direction[:, 2] > 0
    # the sheet that a ray comes to next; -1 and len(sheets) are outside
    at = np.where(forward, 0, len(sheets) - 1)
    rays.end[:] = End.UNFINISHED
    while True:
        waiting = (rays.end == End.UNFINISHED) & (rays.count < rays.faces.shape[1]) & (at >= 0) & (at < len(sheets))
        if not waiting.any():
            break
        here = np.flatnonzero(waiting & (at == at[waiting.argmax()]))
        _cross(rays, here, sheets[at[here[0]]], glass)
        at[here] += np.where(rays.direction[here, 2] > 0, 1, -1)
    left = (rays.end == End.UNFINISHED) & (rays.count < rays.faces.shape[1])
    rays.end[left] = np.where((at == len(sheets)) == forward, End.THROUGH, End.BACK)[left]


def _cross(rays: Rays, here: np.ndarray, sheet: Sheet, glass: _Glass) -> None:
    """Take rays[here] into one sheet and on until they leave it, meet the frame or have met too many faces."""
    c, s = np.cos(sheet.angle), np.sin(sheet.angle)
    position, direction = rays.position[here], rays.direction[here]
    z = np.where(direction[:, 2] > 0, -glass.half, glass.half)
    step = (z + sheet.centre - position[:, 2]) / direction[:, 2]
    x, y = position[:, 0] + step * direction[:, 0], position[:, 1] + step * direction[:, 1]
    half = glass.window / 2
    blocked = (abs(x) > half) | (abs(y) > half)
    x, y = c * x + s * y, c * y - s * x
    dx, dy = c * direction[:, 0] + s * direction[:, 1], c * direction[:, 1] - s * direction[:, 0]
    dz = direction[:, 2].copy()
    cell = np.floor((y - glass.first) / glass.pitch)
    u = y - glass.first - cell * glass.pitch
    inside = np.zeros(len(here), bool)
    index = here

    def leave(who: np.ndarray, end: int | None = None) -> None:
        """Put rays back into the world's frame, and take them off the list."""
        nonlocal x, u, z, dx, dy, dz, cell, inside, index
        if not who.any():
            return
        i, y = index[who], u[who] + cell[who] * glass.pitch + glass.first
        rays.position[i] = np.column_stack((c * x[who] - s * y, s * x[who] + c * y, z[who] + sheet.centre))
        rays.direction[i] = np.column_stack((c * dx[who] - s * dy[who], s * dx[who] + c * dy[who], dz[who]))
        if end is not None:
            rays.end[i] = end
        keep = ~who
        x, u, z, dx, dy, dz, cell, inside, index = (a[keep] for a in (x, u, z, dx, dy, dz, cell, inside, index))

    leave(blocked, End.FRAME)
    tiny = 1e-12 * glass.pitch
    most = rays.faces.shape[1]
    while len(index):
        along = glass.nu[:, None] * dy + glass.nz[:, None] * dz  # of the direction along each face's normal
        ahead = glass.distance[:, None] - glass.nu[:, None] * u - glass.nz[:, None] * z
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = ahead / along
        # in glass: the nearest face that the ray runs out through
        out = np.where(along > 0, reach, np.inf)
        face_out = out.argmin(0)
        t_out = np.maximum(out.min(0), 0)
        # in air: into this prism, into the base of the next, or out of the sheet
        into = np.where(along < 0, reach, -np.inf)
        face_in = into.argmax(0)
        t_in = into.max(0)
        parallel_outside = ((along == 0) & (ahead < 0)).any(0)
        hit = (t_in > -tiny) & (t_in < t_out) & (out.min(0) >= 0) & ~parallel_outside
        t_in = np.where(hit, np.maximum(t_in, 0), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            t_next = np.where(dy > 0, (glass.pitch - u) / dy, np.inf)
            t_edge = np.where(dz == 0, np.inf, (np.copysign(glass.half, dz) - z) / dz)
        t_next = np.maximum(t_next, 0)
        t_edge = np.maximum(t_edge, 0)
        t_air = np.minimum(np.minimum(t_in, t_next), t_edge)
        t = np.where(inside, t_out, t_air)
        x, u, z = x + t * dx, u + t * dy, z + t * dz

        # the frame is met in the world's frame
        y = u + cell * glass.pitch + glass.first
        blocked = (abs(c * x - s * y) > half) | (abs(s * x + c * y) > half)
        gone = ~inside & (t_edge <= t_in) & (t_edge <= t_next) & ~blocked
        at_face = ~blocked & ~gone
        into_next = at_face & ~inside & (t_next < t_in)
        face = np.where(inside, face_out, np.where(into_next, Face.BASE - 1, face_in))
        cell = np.where(into_next, cell + 1, cell)
        u = np.where(into_next, 0.0, u)

        nu, nz = glass.nu[face], glass.nz[face]
        cosine = nu * dy + nz * dz  # above 0 on the way out
        eta = np.where(inside, prism.INDEX, 1 / prism.INDEX)
        square = 1 - eta**2 * (1 - cosine**2)
        total = square < 0
        bend = np.where(total, -2 * cosine, np.copysign(np.sqrt(np.maximum(square, 0)), cosine) - eta * cosine)
        eta = np.where(total, 1.0, eta)
        dx = np.where(at_face, eta * dx, dx)
        dy = np.where(at_face, eta * dy + bend * nu, dy)
        dz = np.where(at_face, eta * dz + bend * nz, dz)
        rays.faces[index[at_face], rays.count[index[at_face]]] = face[at_face] + 1
        rays.count[index[at_face]] += 1
        crossed = at_face & ~total
        # out through the base is into the air above the prism below
        below = crossed & inside & (face == Face.BASE - 1)
        cell = np.where(below, cell - 1, cell)
        u = np.where(below, glass.pitch, u)
        inside = inside ^ crossed

        leave(blocked, End.FRAME)
        leave(gone[~blocked])
        leave(rays.count[index] >= most)
