"""Exact ray trace of Dove-prism sheets, on numpy arrays. Every ray is followed until it leaves the sheets.

Coordinates are those of the scenes: x right, y up, z away from the eye, the sheets centred on z = 0, lengths in the
unit of the window's side. Rays may run either way. Glass neither absorbs nor reflects partially; light that meets the
frame round the window ends there. Inside a sheet, u is the height above the base of the prism (or of the prism below
the air) that the ray is in, in the sheet's own frame, whose prisms lie along x.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from povgen.optics import prism

CHUNK = 80000  # rays at a time: enough that the long paths of few rays cost little


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
    how many (n,); and whether each took the designed path: entry facet, base and exit facet in every sheet."""

    position: np.ndarray
    direction: np.ndarray
    end: np.ndarray
    faces: np.ndarray
    count: np.ndarray
    designed: np.ndarray


class _Glass:
    """The shape of the prisms, and the plane of each face: outward normal (u, z) and distance from u = z = 0."""

    def __init__(self, window: float, prisms: int, gap: float):
        self.window, self.pitch = window, window / prisms
        self.gap = gap * self.pitch
        self.height = self.pitch - self.gap
        self.half = self.height * prism.aspect() / 2
        slope = np.radians(prism.BASE_ANGLE)
        c, s = np.cos(slope), np.sin(slope)
        # in the order of Face
        self.nu = np.array([0.0, -1.0, 1.0, c, c])
        self.nz = np.array([0.0, 0.0, 0.0, -s, s])
        self.facet = s * self.half  # distance of the slanted facets from u = z = 0
        self.first = -prisms / 2 * self.pitch + self.gap / 2  # the base of prism 0

    def _facets(self, u, z, dy, dz):
        """For the facets near and far: how fast a ray nears their plane from inside, and when it meets it."""
        for nu, nz in zip(self.nu[Face.NEAR :], self.nz[Face.NEAR :], strict=True):
            along = nu * dy + nz * dz
            yield along, (self.facet - nu * u - nz * z) / along

    def way_out(self, u, z, dy, dz):
        """Where rays in the glass meet a face, as a multiple of their direction; and the `Face`."""
        up = dy > 0
        t = np.where(dy == 0, np.inf, (np.where(up, self.height, 0) - u) / dy)
        face = np.where(up, Face.TOP, Face.BASE)
        for facet, (along, reach) in zip((Face.NEAR, Face.FAR), self._facets(u, z, dy, dz), strict=True):
            nearer = (along > 0) & (reach < t)
            t, face = np.where(nearer, reach, t), np.where(nearer, facet, face)
        return np.maximum(t, 0), face

    def way_in(self, u, z, dy, dz):
        """Where rays in the air meet a face, `Face.BASE` being that of the next prism; `Face.NONE`: the sheet ends."""
        up = dy > 0
        t_in = np.where(up | (dy == 0), np.where(u > self.height, np.inf, -np.inf), (self.height - u) / dy)
        face = np.full(len(u), Face.TOP)
        t_out = np.where(dy == 0, np.inf, (np.where(up, self.height, 0) - u) / dy)
        for facet, (along, reach) in zip((Face.NEAR, Face.FAR), self._facets(u, z, dy, dz), strict=True):
            t_out = np.where((along > 0) & (reach < t_out), reach, t_out)
            later = (along < 0) & (reach > t_in)
            t_in, face = np.where(later, reach, t_in), np.where(later, facet, face)
            t_in = np.where((along == 0) & (reach < 0), np.inf, t_in)  # along the facet, outside
        meets = (t_in > -1e-12 * self.pitch) & (t_in < t_out) & (t_out >= 0)
        t = np.where(meets, np.maximum(t_in, 0), np.inf)
        for other, reach in (
            (Face.BASE, np.where(up, (self.pitch - u) / dy, np.inf)),
            (Face.NONE, np.where(dz == 0, np.inf, (np.copysign(self.half, dz) - z) / dz)),
        ):
            reach = np.maximum(reach, 0)
            nearer = reach < t if other == Face.BASE else reach <= t
            t, face = np.where(nearer, reach, t), np.where(nearer, other, face)
        return t, face


def pair(alpha: float, window: float, prisms: int, gap: float = prism.AIR_GAP) -> tuple[Sheet, Sheet]:
    """The two sheets that rotate light by alpha (radians), from the eye onwards: the near one turned by alpha/2."""
    glass = _Glass(window, prisms, gap)
    offset = glass.half + glass.gap / 2
    return Sheet(alpha / 2, -offset), Sheet(0.0, offset)


def sheets(model: str, alpha: float, window: float, prisms: int, gap: float = prism.AIR_GAP) -> tuple[Sheet, ...]:
    """The sheets of a scene, 'detailed' or 'single'."""
    return (Sheet(0.0, 0.0),) if model == "single" else pair(alpha, window, prisms, gap)


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
    Raises ValueError if a ray does not run from outside the sheets towards them: parallel to them, dz = 0, or away.
    """
    glass = _Glass(window, prisms, gap)
    origin, direction = np.broadcast_arrays(np.asarray(origin, float), np.asarray(direction, float))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
        front = np.where(direction[:, 2] > 0, sheets[0].centre - glass.half, sheets[-1].centre + glass.half)
        way = front - origin[:, 2]
        entry = origin + (way / direction[:, 2])[:, None] * direction
        # a ray may start where another has left the sheets, but for rounding
        towards = (way * np.sign(direction[:, 2]) > -1e-9 * window) & np.isfinite(entry).all(1)
    if not towards.all():
        i = np.argmin(towards)
        raise ValueError(
            f"ray {i} from {origin[i]} along {direction[i]} does not reach the sheets; "
            "allowed: from outside the sheets, towards them"
        )
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
        with np.errstate(divide="ignore", invalid="ignore"):
            _follow(chunk, sheets, glass)
    steps = 3 * len(sheets)
    path = np.array([Face.NEAR, Face.BASE, Face.FAR] * len(sheets))
    path = np.where(direction[:, 2:] > 0, path, path[::-1])
    rays.designed = (rays.end == End.THROUGH) & (rays.count == steps) & (rays.faces[:, :steps] == path[:, :most]).all(1)
    return rays


def _follow(rays: Rays, sheets: tuple[Sheet, ...], glass: _Glass) -> None:
    """Take rays through the sheets, back and forth between them, until they leave, or meet the frame or `most` faces.

    x, u, z and the direction are in the frame of the sheet that a ray is at, u above the base of prism `cell`.
    """
    n, most = rays.faces.shape
    angle, centre = (np.array([getattr(sheet, name) for sheet in sheets]) for name in ("angle", "centre"))
    cosine, sine = np.cos(angle), np.sin(angle)
    half = glass.window / 2
    x, u, z, dx, dy, dz, cell, c, s = np.empty((9, n))
    forward = rays.direction[:, 2] > 0
    at = np.where(forward, 0, len(sheets) - 1)

    def enter(i: np.ndarray) -> np.ndarray:
        """Take rays to their sheet; returns those that meet no frame before it."""
        here = at[i]
        co, si = c[i], s[i] = cosine[here], sine[here]
        px, py, pz = rays.position[i].T
        vx, vy, vz = rays.direction[i].T
        front = np.where(vz > 0, -glass.half, glass.half)
        step = (front + centre[here] - pz) / vz
        px, py = px + step * vx, py + step * vy
        x[i], y, z[i] = co * px + si * py, co * py - si * px, front
        dx[i], dy[i], dz[i] = co * vx + si * vy, co * vy - si * vx, vz
        cell[i] = np.floor((y - glass.first) / glass.pitch)
        u[i] = y - glass.first - cell[i] * glass.pitch
        return stopped(i, (abs(px) > half) | (abs(py) > half), End.FRAME)

    def leave(i: np.ndarray) -> None:
        """Bring rays back to the world's frame."""
        co, si = c[i], s[i]
        y = u[i] + cell[i] * glass.pitch + glass.first
        rays.position[i] = np.column_stack((co * x[i] - si * y, si * x[i] + co * y, z[i] + centre[at[i]]))
        rays.direction[i] = np.column_stack((co * dx[i] - si * dy[i], si * dx[i] + co * dy[i], dz[i]))

    def stopped(i: np.ndarray, those: np.ndarray, end: End) -> np.ndarray:
        """End some rays; returns the others."""
        if those.any():
            leave(i[those])
            rays.end[i[those]] = end
            i = i[~those]
        return i

    def advance(i: np.ndarray, t: np.ndarray, face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Move rays on to a face; returns those that meet no frame on the way, and their faces."""
        xi = x[i] = x[i] + t * dx[i]
        ui = u[i] = u[i] + t * dy[i]
        z[i] += t * dz[i]
        y = ui + cell[i] * glass.pitch + glass.first
        blocked = (abs(c[i] * xi - s[i] * y) > half) | (abs(s[i] * xi + c[i] * y) > half)
        return stopped(i, blocked, End.FRAME), face[~blocked]

    def bend(i: np.ndarray, face: np.ndarray, eta: float) -> np.ndarray:
        """Refract or reflect rays at a face, eta the index before it over that behind; returns which are reflected."""
        count = rays.count[i]
        rays.faces[i, count] = face
        rays.count[i] = count + 1
        nu, nz = glass.nu[face], glass.nz[face]
        vy, vz = dy[i], dz[i]
        along = nu * vy + nz * vz  # above 0 on the way out
        square = 1 - eta**2 * (1 - along**2)
        total = square < 0
        change = np.where(total, -2 * along, np.copysign(np.sqrt(np.maximum(square, 0)), along) - eta * along)
        scale = np.where(total, 1, eta)
        dx[i] *= scale
        dy[i] = scale * vy + change * nu
        dz[i] = scale * vz + change * nz
        return total

    def unfinished(i: np.ndarray) -> np.ndarray:
        return stopped(i, rays.count[i] == most, End.UNFINISHED)

    air = enter(np.arange(n))
    inside = air[:0]
    while len(air) or len(inside):
        t, face = glass.way_in(u[air], z[air], dy[air], dz[air])
        air, face = advance(air, t, face)
        out, into, face = air[face == Face.NONE], air[face != Face.NONE], face[face != Face.NONE]
        above = into[face == Face.BASE]
        cell[above] += 1
        u[above] = 0
        bend(into, face, 1 / prism.INDEX)
        inside = np.concatenate((inside, unfinished(into)))

        leave(out)
        at[out] += np.where(dz[out] > 0, 1, -1)
        ended = (at[out] < 0) | (at[out] == len(sheets))
        rays.end[out[ended]] = np.where((at[out[ended]] > 0) == forward[out[ended]], End.THROUGH, End.BACK)
        air = enter(out[~ended])

        t, face = glass.way_out(u[inside], z[inside], dy[inside], dz[inside])
        inside, face = advance(inside, t, face)
        total = bend(inside, face, prism.INDEX)
        below = inside[~total & (face == Face.BASE)]  # out through the base: above the prism below
        cell[below] -= 1
        u[below] = glass.pitch
        air = np.concatenate((air, unfinished(inside[~total])))
        inside = unfinished(inside[total])
