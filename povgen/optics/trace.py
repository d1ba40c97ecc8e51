"""Exact ray trace of Dove-prism sheets, on numpy arrays. Each ray is followed until it leaves the sheets.

The coordinates are the scenes': x right, y up, z away from the eye. The first window is centred on z = 0. Lengths are
in the unit of the window's side. Rays may run either way. Glass absorbs no light, and reflects a part of it only if
`trace` is asked for that. A ray that meets the frame of a window from inside ends there, and so does a ray that misses
the first window on its way. A ray also ends where it misses a later window.

Each sheet has its own coordinate system, in which its prisms' ridges lie along x. Each of its prisms has a cell, one
pitch high: the prism and the air above it. There u is the height above the prism's base.
"""

from collections.abc import Iterable
from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.polarisation import reflection
from povgen.optics.prism import Prism

CHUNK = 80000  # rays at a time: enough that the long paths of few rays cost little

Floats = NDArray[np.float64]
Indices = NDArray[np.int_]
Booleans = NDArray[np.bool_]


class Face(IntEnum):
    """Faces of a prism. NEAR is the slanted facet towards negative z, where the eye is."""

    NONE = 0
    BASE = 1
    TOP = 2
    NEAR = 3
    FAR = 4


class End(IntEnum):
    """How a ray ends."""

    THROUGH = 0  # leaves on the side that it did not come from
    BACK = 1  # leaves on the side that it came from
    FRAME = 2  # meets the window frame
    UNFINISHED = 3  # has met the greatest allowed number of faces
    BESIDE = 4  # passes beside a window, after another one


@dataclass(frozen=True)
class Sheet:
    """A sheet of prisms. It is turned by `angle` (radians) about z, and its middle plane is z = `centre`."""

    angle: float
    centre: float
    window: int = 0  # the window that the sheet is in; a window's sheets follow one another


@dataclass
class Rays:
    """Where and how n rays end."""

    position: Floats  # where the ray leaves the sheets, or meets the window frame, (n, 3)
    direction: Floats  # unit vector, (n, 3)
    end: NDArray[np.uint8]  # `End`, (n,)
    faces: NDArray[np.uint8]  # the faces that the ray has met, in order, `Face`, (n, most)
    count: Indices  # how many faces the ray has met, (n,)
    light: Floats  # with partial reflection: the part of the light on this path, 0 to 1, (n,)
    reflected: Booleans  # with partial reflection: a face that also refracts light has reflected this ray, (n,)
    designed: Booleans  # took the designed path: entry facet, base and exit facet in every sheet, (n,)


class _Glass:
    """The shape of the prisms. Each face has an outward normal (u, z), at the index of its `Face`."""

    def __init__(self, window: float, prism: Prism) -> None:
        self.window, self.pitch, self.height, self.index = window, prism.pitch, prism.height, prism.index
        self.half = prism.length / 2
        c, s = np.cos(np.radians(prism.base_angle)), np.sin(np.radians(prism.base_angle))
        self.normal_u = np.array([0.0, -1.0, 1.0, c, c])
        self.normal_z = np.array([0.0, 0.0, 0.0, -s, s])
        self.facet = s * self.half  # distance of the slanted facets' planes from u = z = 0
        self.first = -window / 2 + prism.gap * prism.pitch / 2  # y of the base of prism 0

    def _facets(self, u: Floats, z: Floats, dy: Floats, dz: Floats) -> list[tuple[Face, Floats, Floats]]:
        """For each slanted facet: how fast a ray approaches its plane from inside, and when the ray meets it."""
        found = []
        for face in (Face.NEAR, Face.FAR):
            nu, nz = self.normal_u[face], self.normal_z[face]
            along = nu * dy + nz * dz
            found.append((face, along, (self.facet - nu * u - nz * z) / along))
        return found

    def way_out(self, u: Floats, z: Floats, dy: Floats, dz: Floats) -> tuple[Floats, Indices]:
        """Return where rays in the glass meet a face, as a multiple of their direction, and the `Face`."""
        up = dy > 0
        t = np.where(dy == 0, np.inf, (np.where(up, self.height, 0) - u) / dy)
        face = np.where(up, Face.TOP, Face.BASE)
        for facet, along, reach in self._facets(u, z, dy, dz):
            nearer = (along > 0) & (reach < t)
            t, face = np.where(nearer, reach, t), np.where(nearer, facet, face)
        return np.maximum(t, 0), face

    def way_in(self, u: Floats, z: Floats, dy: Floats, dz: Floats) -> tuple[Floats, Indices]:
        """Return where rays in the air meet a face, as a multiple of their direction, and the `Face`.

        `Face.BASE` is the base of the prism above. `Face.NONE` means that the ray leaves the sheet.
        """
        up = dy > 0
        t_in = np.where(up | (dy == 0), np.where(u > self.height, np.inf, -np.inf), (self.height - u) / dy)
        face = np.full(len(u), Face.TOP)
        t_out = np.where(dy == 0, np.inf, (np.where(up, self.height, 0) - u) / dy)
        for facet, along, reach in self._facets(u, z, dy, dz):
            t_out = np.where((along > 0) & (reach < t_out), reach, t_out)
            later = (along < 0) & (reach > t_in)
            t_in, face = np.where(later, reach, t_in), np.where(later, facet, face)
            t_in = np.where((along == 0) & (reach < 0), np.inf, t_in)  # parallel to the facet, outside
        meets = (t_in > -1e-12 * self.pitch) & (t_in < t_out) & (t_out >= 0)
        t = np.where(meets, np.maximum(t_in, 0), np.inf)
        base = np.maximum(np.where(up, (self.pitch - u) / dy, np.inf), 0)
        t, face = np.where(base < t, base, t), np.where(base < t, Face.BASE, face)
        side = np.maximum(np.where(dz == 0, np.inf, (np.copysign(self.half, dz) - z) / dz), 0)
        return np.where(side <= t, side, t), np.where(side <= t, Face.NONE, face)


def pair(alpha: float, prism: Prism, behind: Iterable[tuple[float, float]] = ()) -> tuple[Sheet, ...]:
    """Return the two sheets that rotate light by alpha (radians). The near one comes first; it is turned by alpha/2.

    `behind` are further windows, as in `rotation.depth`: the distance from the middle of the window before, and alpha.
    Two sheets of each follow. Raises ValueError for windows that overlap.
    """
    aside, z = prism.separation / 2, 0.0
    sheets = [Sheet(alpha / 2, -aside), Sheet(0.0, aside)]
    for window, (distance, turn) in enumerate(behind, 1):
        if distance < prism.thickness(2):
            raise ValueError(f"distance between windows = {distance:g}; allowed: {prism.thickness(2):g} or more")
        z += distance
        sheets += [Sheet(turn / 2, z - aside, window), Sheet(0.0, z + aside, window)]
    return tuple(sheets)


def trace(
    origin: ArrayLike,
    direction: ArrayLike,
    sheets: tuple[Sheet, ...],
    window: float,
    prism: Prism,
    most: int = 60,
    frame: float = 0.0,
    partial: np.random.Generator | None = None,
) -> Rays:
    """Follow rays through the sheets.

    Origins and directions are (n, 3) and broadcast. Directions may have any length. `sheets` are in order of z, the
    eye's side first, and fill square windows with the given side. `frame` is the extent of each window's frame along z,
    if it is greater than that of the sheets: light from the sheets can meet it. A ray ends after `most` faces.
    With `partial`, which makes random numbers, a face that refracts light also reflects a part of it: the ray is
    reflected with a probability that is this part, by the Fresnel equations for unpolarised light. So each ray stands
    for an equal share of the light, and light is unpolarised again after every face.
    Raises ValueError if a ray does not start outside the sheets, or does not run towards them. Raises ValueError for a
    window or prisms without extent, for prisms without a top (`Prism.least_aspect`), and for `most` < 1.
    """
    for name, value in (("window", window), ("pitch", prism.pitch), ("most", most)):
        if not value > 0:
            raise ValueError(f"{name} = {value:g}; allowed: above 0")
    if prism.aspect < (1 - 1e-9) * prism.least_aspect:
        raise ValueError(f"aspect = {prism.aspect:g}: facets cross; allowed: {prism.least_aspect:.4g} or more")
    glass = _Glass(window, prism)
    position, along = np.broadcast_arrays(np.asarray(origin, float), np.asarray(direction, float))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
    _check_approach(position, along, sheets, glass)
    forward = along[:, 2:] > 0
    n = len(position)
    rays = Rays(
        position.copy(),
        along,
        np.empty(n, np.uint8),
        np.zeros((n, most), np.uint8),
        np.zeros(n, int),
        np.ones(n),
        np.zeros(n, bool),
        np.zeros(n, bool),
    )
    for start in range(0, n, CHUNK):
        chunk = Rays(*(getattr(rays, field.name)[start : start + CHUNK] for field in fields(Rays)))
        with np.errstate(divide="ignore", invalid="ignore"):
            _Trace(chunk, sheets, glass, frame, partial).run()
    path = np.array([Face.NEAR, Face.BASE, Face.FAR] * len(sheets))
    steps = len(path)
    path = np.where(forward, path, path[::-1])
    rays.designed = (rays.end == End.THROUGH) & (rays.count == steps) & (rays.faces[:, :steps] == path[:, :most]).all(1)
    rays.designed &= ~rays.reflected
    return rays


def _check_approach(origin: Floats, direction: Floats, sheets: tuple[Sheet, ...], glass: _Glass) -> None:
    """Raise ValueError for the first ray that does not run towards the sheets from outside."""
    dz = direction[:, 2]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        way = np.where(dz > 0, sheets[0].centre - glass.half, sheets[-1].centre + glass.half) - origin[:, 2]
        entry = origin + (way / dz)[:, None] * direction
        # a ray may start where another ray has left the sheets, which rounding moves
        towards = (way * np.sign(dz) > -1e-9 * glass.window) & np.isfinite(entry).all(1)
    if not towards.all():
        i = np.argmin(towards)
        raise ValueError(
            f"ray {i} from {origin[i]} along {direction[i]} does not reach the sheets; "
            "allowed: from outside the sheets, towards them"
        )


class _Trace:
    """Rays under way. `run` takes them through the sheets and writes how they end.

    The methods take and return the indices of rays. x, u, z and dx, dy, dz, each (n,), are position and direction in
    the coordinate system of the sheet that the ray is at, u above the base of prism `cell`. c and s are the cosine and
    the sine of that sheet's angle.
    """

    def __init__(
        self, rays: Rays, sheets: tuple[Sheet, ...], glass: _Glass, frame: float, partial: np.random.Generator | None
    ) -> None:
        n, self.most = rays.faces.shape
        self.rays, self.glass, self.sheets, self.partial = rays, glass, len(sheets), partial
        angle = np.array([sheet.angle for sheet in sheets])
        self.cosine, self.sine = np.cos(angle), np.sin(angle)
        self.centre = np.array([sheet.centre for sheet in sheets])
        self.window = np.array([sheet.window for sheet in sheets])
        # z of the middle of each sheet's window
        self.middle = np.array([self.centre[self.window == window].mean() for window in self.window])
        self.frame = frame / 2
        self.x, self.u, self.z, self.dx, self.dy, self.dz, self.cell, self.c, self.s = np.empty((9, n))
        self.forward = rays.direction[:, 2] > 0
        self.sheet = np.where(self.forward, 0, len(sheets) - 1)

    def run(self) -> None:
        """Move all rays on, face by face, until each has ended."""
        air = self.enter(np.arange(len(self.x)))
        glass = air[:0]
        while len(air) or len(glass):
            entering, reflected, leaving = self.cross_air(air)
            glass = np.concatenate((glass, entering))
            air = np.concatenate((reflected, self.change_sheet(leaving)))
            leaving, glass = self.cross_glass(glass)
            air = np.concatenate((air, leaving))

    def enter(self, i: Indices) -> Indices:
        """Take rays to the surface of their sheet. Return those that reach it within the window."""
        here = self.sheet[i]
        c = self.c[i] = self.cosine[here]
        s = self.s[i] = self.sine[here]
        dx, dy, dz = self.rays.direction[i].T
        x, y, surface, outside = self.arrival(i)
        v = c * y - s * x
        self.x[i], self.z[i] = c * x + s * y, surface
        self.dx[i], self.dy[i], self.dz[i] = c * dx + s * dy, c * dy - s * dx, dz
        cell = self.cell[i] = np.floor((v - self.glass.first) / self.glass.pitch)
        self.u[i] = v - self.glass.first - cell * self.glass.pitch
        return self.without_ended(i, outside, End.FRAME)

    def arrival(self, i: Indices) -> tuple[Floats, Floats, Floats, Booleans]:
        """Return where rays in the scene's coordinates reach the surface of their sheet, and if this is outside it.

        x and y are in the scene's coordinates, z is from the sheet's middle plane.
        """
        x, y, z = self.rays.position[i].T
        dx, dy, dz = self.rays.direction[i].T
        surface = np.where(dz > 0, -self.glass.half, self.glass.half)
        step = (surface + self.centre[self.sheet[i]] - z) / dz
        x, y, half = x + step * dx, y + step * dy, self.glass.window / 2
        return x, y, surface, (abs(x) > half) | (abs(y) > half)

    def leave(self, i: Indices) -> None:
        """Write positions and directions in the scene's coordinates."""
        c, s = self.c[i], self.s[i]
        x, dx, dy = self.x[i], self.dx[i], self.dy[i]
        y = self.u[i] + self.cell[i] * self.glass.pitch + self.glass.first
        z = self.z[i] + self.centre[self.sheet[i]]
        self.rays.position[i] = np.column_stack((c * x - s * y, s * x + c * y, z))
        self.rays.direction[i] = np.column_stack((c * dx - s * dy, s * dx + c * dy, self.dz[i]))

    def without_ended(self, i: Indices, ended: Booleans, end: End) -> Indices:
        """Write the end of the rays that have ended. Return the others."""
        if ended.any():
            self.leave(i[ended])
            self.rays.end[i[ended]] = end
            i = i[~ended]
        return i

    def without_unfinished(self, i: Indices) -> Indices:
        """End the rays that have met the greatest number of faces. Return the others."""
        return self.without_ended(i, self.rays.count[i] == self.most, End.UNFINISHED)

    def cross_air(self, i: Indices) -> tuple[Indices, Indices, Indices]:
        """Take rays from the air to the next face.

        Return those that enter a prism, those that are reflected, and those that leave the sheet.
        """
        i, face = self.advance(i, *self.glass.way_in(self.u[i], self.z[i], self.dy[i], self.dz[i]))
        meets = face != Face.NONE
        i, leaving, face = i[meets], i[~meets], face[meets]
        reflected = self.bend(i, face, 1 / self.glass.index)
        above = i[~reflected & (face == Face.BASE)]
        self.cell[above] += 1
        self.u[above] = 0
        return self.without_unfinished(i[~reflected]), self.without_unfinished(i[reflected]), leaving

    def change_sheet(self, i: Indices) -> Indices:
        """Take rays that leave a sheet to the next one, if there is one. Return those that reach it."""
        self.leave(i)
        onward = np.where(self.dz[i] > 0, 1, -1)
        before, after = self.sheet[i], self.sheet[i] + onward
        last = (after < 0) | (after == self.sheets)
        after = np.where(last, before, after)
        self.sheet[i] = after
        ended = last | (self.window[after] != self.window[before])  # they leave the window; some reach the next one
        j, before, after, onward, last = (values[ended] for values in (i, before, after, onward, last))
        blocked = self.outside(j, self.middle[before] + onward * self.frame)
        beside = self.outside(j, self.middle[after] - onward * self.frame) | self.arrival(j)[-1]
        through = np.where((onward > 0) == self.forward[j], End.THROUGH, End.BACK)
        self.rays.end[j] = np.select([blocked, last], [End.FRAME, through], End.BESIDE)
        ended[ended] = blocked | last | beside
        return self.enter(i[~ended])

    def outside(self, i: Indices, z: Floats) -> Booleans:
        """Return if rays are outside the window's square in the plane z, or where they are if they have passed it."""
        position, direction = self.rays.position[i], self.rays.direction[i]
        step = np.maximum((z - position[:, 2]) / direction[:, 2], 0)
        x, y, _ = abs(position + step[:, None] * direction).T
        return np.asarray(np.maximum(x, y) > self.glass.window / 2)

    def cross_glass(self, i: Indices) -> tuple[Indices, Indices]:
        """Take rays in the glass to the next face. Return those that leave the prism and those that are reflected."""
        i, face = self.advance(i, *self.glass.way_out(self.u[i], self.z[i], self.dy[i], self.dz[i]))
        reflected = self.bend(i, face, self.glass.index)
        below = i[~reflected & (face == Face.BASE)]
        self.cell[below] -= 1
        self.u[below] = self.glass.pitch
        return self.without_unfinished(i[~reflected]), self.without_unfinished(i[reflected])

    def advance(self, i: Indices, t: Floats, face: Indices) -> tuple[Indices, Indices]:
        """Move rays on to a face. Return those that the window frame does not stop, and their faces."""
        x = self.x[i] = self.x[i] + t * self.dx[i]
        u = self.u[i] = self.u[i] + t * self.dy[i]
        self.z[i] += t * self.dz[i]
        y = u + self.cell[i] * self.glass.pitch + self.glass.first
        c, s, half = self.c[i], self.s[i], self.glass.window / 2
        blocked = (abs(c * x - s * y) > half) | (abs(s * x + c * y) > half)
        return self.without_ended(i, blocked, End.FRAME), face[~blocked]

    def bend(self, i: Indices, face: Indices, eta: float) -> Booleans:
        """Refract or reflect rays at a face. Return which of the rays are reflected.

        eta is the refractive index before the face, divided by the index behind the face.
        """
        count = self.rays.count[i]
        self.rays.faces[i, count] = face
        self.rays.count[i] = count + 1
        nu, nz = self.glass.normal_u[face], self.glass.normal_z[face]
        dy, dz = self.dy[i], self.dz[i]
        along = nu * dy + nz * dz  # positive for a ray that leaves the prism
        square = 1 - eta**2 * (1 - along**2)
        reflected = square < 0  # totally
        if self.partial:
            r_s, r_p = reflection(eta, 1, np.abs(along))
            part = (np.abs(r_s) ** 2 + np.abs(r_p) ** 2) / 2
            partly = ~reflected & (self.partial.uniform(size=len(i)) < part)
            self.rays.light[i] *= np.where(reflected | partly, part, 1 - part)
            self.rays.reflected[i[partly]] = True
            reflected |= partly
        change = np.where(reflected, -2 * along, np.copysign(np.sqrt(np.maximum(square, 0)), along) - eta * along)
        scale = np.where(reflected, 1, eta)
        self.dx[i] *= scale
        self.dy[i] = scale * dy + change * nu
        self.dz[i] = scale * dz + change * nz
        return np.asarray(reflected)
