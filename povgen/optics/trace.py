"""Exact ray trace of sheets of Dove prisms, and of any other profile, on numpy arrays.

Each ray is followed until it leaves the sheets.

The coordinates are those of a window: x right, y up, z away from the eye. All lengths, also the window's side, are in
one unit, such as tiles. Rays may run either way. Glass absorbs no light. Its faces refract all light or reflect all
light, unless `trace` has the argument `partial`; black tops of prisms absorb it. A ray that meets the window's frame
from inside ends there. So does a ray that misses the window (`End.FRAME`).

Each sheet has its own coordinate system, in which its ridges lie along x. It is divided into cells, one pitch high, and
u is the height in a cell. A cell of prisms begins at a prism's base: it is the prism and the air above it. The cells of
any other profile are its periods. There a ray also crosses the borders between cells. A border is no face: what is on
one side, glass or air, continues on the other.

The code for prisms is special: it takes 0.7 times the CPU time that the code for profiles takes for the same prisms.
`tests/unit/test_profile.py` compares the two.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from povgen.optics.faces import (
    BORDER,
    Booleans,
    Face,
    Floats,
    GlassSheet,
    Indices,
    PrismCells,
    ProfileCells,
    UnequalPrismCells,
)
from povgen.optics.outline import Outline
from povgen.optics.polarisation import reflection
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile
from povgen.optics.ray_path import Steps
from povgen.optics.values import Values

CHUNK = 80000  # rays at a time: enough that the long paths of few rays cost little


class End(IntEnum):
    """How a ray ends."""

    THROUGH = 0  # leaves on the side that it did not come from
    BACK = 1  # leaves on the side that it came from
    FRAME = 2  # meets the window frame
    UNFINISHED = 3  # has met the greatest allowed number of faces
    BESIDE = 4  # passes beside every window, or beside one of windows in series
    BLOCKED = 5  # meets an ideal sheet through which no light of this direction passes
    ABSORBED = 6  # meets a black top of a prism


@dataclass(eq=False)
class Rays(Values):
    """Where and how n rays end."""

    position: Floats  # where the ray leaves the last sheet, or ends, (n, 3)
    direction: Floats  # unit vector, (n, 3)
    end: NDArray[np.uint8]  # `End`, (n,)
    faces: NDArray[np.uint8]  # the faces that the ray has met, in order: `Face`, or edges of profiles, (n, most)
    count: Indices  # how many faces the ray has met, (n,)
    light: Floats  # with partial reflection: the part of the light on this path, 0 to 1, (n,)
    reflected: Booleans  # with partial reflection: a face that also refracts light has reflected this ray, (n,)
    # took the designed path: in every sheet entry facet, base and exit facet, or `Profile.path` within one cell, (n,)
    designed: Booleans
    # of profiles, for each sheet: the number of the cell in which the ray last met glass, minus that of the cell in
    # which it first did, (n, sheets). For lenses it is the number of the ghost.
    orders: Indices

    @classmethod
    def starting(cls, position: Floats, direction: Floats, most: int, sheets: int) -> "Rays":
        """Return rays that start, whose count of faces is at most `most`. Their positions are copied."""
        n = len(position)
        return cls(
            position.copy(order="F"),
            direction.copy(order="F"),
            np.full(n, End.THROUGH, np.uint8),
            np.zeros((n, most), np.uint8),
            np.zeros(n, int),
            np.ones(n),
            np.zeros(n, bool),
            np.full(n, not sheets),
            np.zeros((n, sheets), int),
        )

    def __getitem__(self, some: slice) -> "Rays":
        """Return some of the rays. Their arrays share memory with those of all."""
        return Rays(*(getattr(self, field.name)[some] for field in fields(self)))


def pair(alpha: float, shape: Prism | Profile) -> tuple[GlassSheet, ...]:
    """Return the two sheets that rotate light by alpha (radians). The near one comes first; it is turned by alpha/2."""
    aside = shape.separation / 2
    return GlassSheet(alpha / 2, -aside, shape), GlassSheet(0.0, aside, shape)


def trace(
    origin: ArrayLike,
    direction: ArrayLike,
    sheets: tuple[GlassSheet, ...],
    window: float | Outline,
    most: ArrayLike = 60,
    frame: float = 0.0,
    partial: "np.random.Generator | None" = None,
    steps: Steps | None = None,
) -> Rays:
    """Follow rays through the sheets. Where they meet faces is written into `steps`.

    Origins and directions are (n, 3) and broadcast. Directions may have any length. `sheets` are in order of z, the
    eye's side first, and fill a window with this outline, or a square one with this side. `frame` is the extent of
    the window's frame along z. It matters only if it is greater than that of the sheets: then light from the sheets
    can meet the frame. A ray ends after `most` faces, a number or one for each ray (n,).
    With `partial`, a generator of random numbers, a face that refracts light also reflects a part of it. The part
    follows from the Fresnel equations for unpolarised light. The ray is reflected with this part as its probability. So
    each ray stands for an equal share of the light, and light is unpolarised again after every face.
    Raises ValueError if a ray does not start outside the sheets, or does not run towards them. Raises ValueError for a
    window or prisms without extent, for prisms without a top (`Prism.least_aspect`), for sheets that overlap, and for
    `most` < 1.
    """
    several = [sheet.shape for sheet in sheets]
    outline = window if isinstance(window, Outline) else Outline(window, window)
    window = max(outline[:2])
    if not np.min(most, initial=1) > 0:
        raise ValueError(f"most = {np.min(most):g}; allowed: above 0")
    glass = _glass(sheets, window)
    position, along = np.broadcast_arrays(np.asarray(origin, float), np.asarray(direction, float))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
    _check_approach(position, along, sheets, window)
    forward = along[:, 2:] > 0
    rays = Rays.starting(position, along, int(np.max(most, initial=0)), len(sheets))
    limits = np.broadcast_to(most, len(position))
    for start in range(0, len(position), CHUNK):
        part = slice(start, start + CHUNK)
        with np.errstate(divide="ignore", invalid="ignore"):
            kept = steps and Steps(*(values[part] for values in steps))
            _Trace(rays[part], limits[part], sheets, glass, outline, frame, partial, kept).run()
    rays.designed = on_path(rays, several, forward) & ~rays.reflected & ~rays.orders.any(1)
    return rays


def _glass(sheets: tuple[GlassSheet, ...], window: float) -> PrismCells | ProfileCells:
    """Return the cells of the sheets. All must be sheets of prisms, or all of profiles.

    Raises ValueError for sheets through which no ray can be followed.
    """
    shapes = dict.fromkeys(sheet.shape for sheet in sheets)
    for name, value in (("window", window), *(("pitch", shape.pitch) for shape in shapes)):
        if not value > 0:
            raise ValueError(f"{name} = {value:g}; allowed: above 0")
    prisms = [sheet.shape for sheet in sheets if isinstance(sheet.shape, Prism)]
    for prism in prisms:
        if prism.aspect < (1 - 1e-9) * prism.least_aspect:
            raise ValueError(f"aspect = {prism.aspect:g}: facets cross; allowed: {prism.least_aspect:.4g} or more")
    for before, sheet in pairwise(sheets):
        least = before.centre + before.reach(window) + sheet.reach(window)
        if sheet.centre < least - 1e-9 * window:  # for rounding
            raise ValueError(f"centre = {sheet.centre:g}: overlaps the sheet before; allowed: {least:g} or more")
    if profiles := [sheet.shape for sheet in sheets if isinstance(sheet.shape, Profile)]:
        return ProfileCells.of(profiles, window)
    unequal = any(sheet.facets or sheet.pitches for sheet in sheets)
    return UnequalPrismCells.of_sheets(sheets, prisms, window) if unequal else PrismCells.of(prisms, window)


def on_path(rays: Rays, shapes: Sequence[Prism | Profile], forward: ArrayLike = True) -> Booleans:
    """Return which rays met, in sheets of these shapes, the faces of the designed path and no others.

    The faces may belong to several cells: such light forms ghosts. `forward`, True or (n, 1), says which rays run to
    greater z.
    """
    path = np.array([face for shape in shapes for face in path_of(shape)])
    most, steps = rays.faces.shape[1], len(path)
    met = rays.faces[:, :steps] == np.where(forward, path, path[::-1])[..., :most]
    return np.asarray((rays.end == End.THROUGH) & (rays.count == steps) & met.all(1))


def path_of(shape: Prism | Profile) -> tuple[int, ...]:
    """Return the faces of the designed path, for light that runs to greater z."""
    return shape.path if isinstance(shape, Profile) else (Face.NEAR, Face.BASE, Face.FAR)


def _check_approach(origin: Floats, direction: Floats, sheets: tuple[GlassSheet, ...], window: float) -> None:
    """Raise ValueError for the first ray that does not run towards the sheets from outside."""
    dz = direction[:, 2]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        front = sheets[0].centre - sheets[0].reach(window)
        back = sheets[-1].centre + sheets[-1].reach(window)
        way = np.where(dz > 0, front, back) - origin[:, 2]
        entry = origin + (way / dz)[:, None] * direction
        # a ray may start where another ray has left the sheets, which rounding moves
        towards = (way * np.sign(dz) > -1e-9 * window) & np.isfinite(entry).all(1)
    if not towards.all():
        i = np.argmin(towards)
        raise ValueError(
            f"ray {i} from {origin[i]} along {direction[i]} does not reach the sheets; "
            "allowed: from outside the sheets, towards them"
        )


class _Trace:
    """Rays under way. `run` takes them through the sheets and writes how they end.

    The methods take the indices of rays, and most return those of some of these rays. x, u, z and dx, dy, dz, each
    (n,), are position and direction in the coordinate system of the sheet that the ray is at. u is measured from the
    bottom of the ray's cell, whose number is `cell`. c and s are the cosine and the sine of that sheet's angle.
    """

    def __init__(
        self,
        rays: Rays,
        most: Indices,
        sheets: tuple[GlassSheet, ...],
        glass: PrismCells | ProfileCells,
        outline: Outline,
        frame: float,
        partial: "np.random.Generator | None",
        steps: Steps | None,
    ) -> None:
        n, self.most, self.steps = len(rays.count), most, steps
        self.rays, self.glass, self.sheets, self.partial = rays, glass, len(sheets), partial
        angle = np.array([sheet.angle for sheet in sheets])
        self.cosine, self.sine = np.cos(angle), np.sin(angle)
        self.centre = np.array([sheet.centre for sheet in sheets])
        self.axes = np.array([sheet.axes for sheet in sheets]) if any(any(sheet.tilt) for sheet in sheets) else None
        self.middle = self.centre.mean()
        self.outline, self.frame = outline, frame / 2
        self.black = any(isinstance(sheet.shape, Prism) and sheet.shape.black for sheet in sheets)
        # of profiles: the cell in which a ray first met glass in its sheet, and the one in which it did last
        self.borders = isinstance(glass, ProfileCells)
        self.entered, self.last = np.empty((2, n if self.borders else 0))
        self.x, self.u, self.z, self.dx, self.dy, self.dz, self.cell, self.c, self.s = np.empty((9, n))
        self.forward = rays.direction[:, 2] > 0
        self.sheet = np.where(self.forward, 0, len(sheets) - 1)

    def run(self) -> None:
        """Move all rays on, face by face, until each has ended."""
        air = self.enter(np.arange(len(self.x)))
        glass = air[:0]
        while len(air) or len(glass):
            entering, reflected, leaving = self.cross(air, out=False)
            glass = np.concatenate((glass, entering))
            air = np.concatenate((reflected, self.change_sheet(leaving)))
            leaving, glass, _ = self.cross(glass, out=True)
            air = np.concatenate((air, leaving))

    def enter(self, i: Indices) -> Indices:
        """Take rays to the surface of their sheet. Return those that reach it within the window."""
        here = self.sheet[i]
        glass = self.glass.at(here)
        if self.borders:
            self.entered[i] = np.nan
        c = self.c[i] = self.cosine[here]
        s = self.s[i] = self.sine[here]
        x, y, surface, (dx, dy, dz), outside = self.arrival(i)
        v = c * y - s * x
        self.x[i], self.z[i] = c * x + s * y, surface
        self.dx[i], self.dy[i], self.dz[i] = c * dx + s * dy, c * dy - s * dx, dz
        self.cell[i], self.u[i] = glass.cell_of(v)
        return self.without_ended(i, outside, End.FRAME)

    def arrival(self, i: Indices) -> tuple[Floats, Floats, Floats, Floats, Booleans]:
        """Return where rays reach the surface of their sheet, in which direction, and if this is outside the window.

        x and y are in the coordinates of the sheet before it is turned: the scene's, unless it is tilted.
        z is from the sheet's middle plane. The directions are (3, n).
        """
        here = self.sheet[i]
        (x, y, z), d = self.rays.position[i].T, self.rays.direction[i].T
        place = np.stack((x, y, z - self.centre[here]))
        outer = d
        if self.axes is not None:
            place, d = (np.einsum("nij,jn->in", self.axes[here], v) for v in (place, d))
        surface = -np.copysign(self.glass.at(here).half, d[2])
        step = (surface - place[2]) / d[2]
        beyond = self.outline.excludes(x + step * outer[0], y + step * outer[1])
        # some rays run parallel to a tilted sheet's surface, or nearly
        return place[0] + step * d[0], place[1] + step * d[1], surface, d, beyond | (d[2] * outer[2] <= 0)

    def leave(self, i: Indices) -> None:
        """Write positions and directions in the scene's coordinates."""
        c, s = self.c[i], self.s[i]
        x, dx, dy = self.x[i], self.dx[i], self.dy[i]
        here = self.sheet[i]
        y = self.u[i] + self.glass.at(here).bottom(self.cell[i])
        position = np.column_stack((c * x - s * y, s * x + c * y, self.z[i]))
        direction = np.column_stack((c * dx - s * dy, s * dx + c * dy, self.dz[i]))
        if self.axes is not None:
            position, direction = (np.einsum("ni,nij->nj", v, self.axes[here]) for v in (position, direction))
        position[:, 2] += self.centre[here]
        self.rays.position[i], self.rays.direction[i] = position, direction

    def without_ended(self, i: Indices, ended: Booleans, end: End) -> Indices:
        """Write the end of the rays that have ended. Return the others."""
        if ended.any():
            self.leave(i[ended])
            self.rays.end[i[ended]] = end
            i = i[~ended]
        return i

    def without_unfinished(self, i: Indices) -> Indices:
        """End the rays that have met the greatest number of faces. Return the others."""
        return self.without_ended(i, self.rays.count[i] == self.most[i], End.UNFINISHED)

    def cross(self, i: Indices, out: bool) -> tuple[Indices, Indices, Indices]:
        """Take rays to the next face: with `out` rays in the glass, otherwise rays in the air.

        Return those that leave the glass or enter it, those that stay where they are, and those that leave the sheet.
        """
        glass = self.glass.at(self.sheet[i], self.cell[i])
        way = glass.way_out if out else glass.way_in
        i, face = self.advance(i, *way(self.u[i], self.z[i], self.dy[i], self.dz[i]))
        i, face, onward = self.cross_borders(i, face)
        meets = face != Face.NONE
        i, leaving, face = i[meets], i[~meets], face[meets]
        index = self.glass.at(self.sheet[i]).index
        reflected = self.bend(i, face, index if out else 1 / index)
        if self.steps:
            self.leave(i)
            at = i, self.rays.count[i] - 1
            self.steps.place[at], self.steps.glass[at] = self.rays.position[i], index
            self.steps.behind[at] = np.where(reflected == out, index, 1)
        if self.black:
            on = face != Face.TOP
            self.without_ended(i, ~on, End.ABSORBED)
            i, face, reflected = i[on], face[on], reflected[on]
        if not self.borders:
            through = i[~reflected & (face == Face.BASE)]
            self.cell[through] += -1 if out else 1
            self.u[through] = self.glass.at(self.sheet[through], self.cell[through]).pitch if out else 0
        staying = np.concatenate((onward, self.without_unfinished(i[reflected])))
        return self.without_unfinished(i[~reflected]), staying, leaving

    def change_sheet(self, i: Indices) -> Indices:
        """Take rays that leave a sheet to the next one, if there is one. Return those that reach it."""
        self.leave(i)
        if self.borders:
            self.rays.orders[i, self.sheet[i]] += np.nan_to_num(self.last[i] - self.entered[i]).astype(int)
        onward = np.where(self.rays.direction[i, 2] > 0, 1, -1)
        after = self.sheet[i] + onward
        last = (after < 0) | (after == self.sheets)
        self.sheet[i[~last]] = after[~last]
        j, onward = i[last], onward[last]
        through = np.where((onward > 0) == self.forward[j], End.THROUGH, End.BACK)
        self.rays.end[j] = np.where(self.outside(j, self.middle + onward * self.frame), End.FRAME, through)
        return self.enter(i[~last])

    def outside(self, i: Indices, z: Floats) -> Booleans:
        """Return whether rays are outside the window where they cross the plane z.

        A ray that has passed this plane is tested at its present position.
        """
        position, direction = self.rays.position[i], self.rays.direction[i]
        step = np.maximum((z - position[:, 2]) / direction[:, 2], 0)
        x, y, _ = (position + step[:, None] * direction).T
        return self.outline.excludes(x, y)

    def cross_borders(self, i: Indices, face: Indices) -> tuple[Indices, Indices, Indices]:
        """Take rays at a border into the next cell. Return the rays at faces, these faces, and the rays at borders."""
        if not self.borders:
            return i, face, i[:0]
        border = face == BORDER
        onward = i[border]
        up = self.dy[onward] > 0
        self.cell[onward] += np.where(up, 1, -1)
        self.u[onward] = np.where(up, 0, self.glass.at(self.sheet[onward]).pitch)
        return i[~border], face[~border], onward

    def advance(self, i: Indices, t: Floats, face: Indices) -> tuple[Indices, Indices]:
        """Move rays on to a face. Return those that the window frame does not stop, and their faces."""
        x = self.x[i] = self.x[i] + t * self.dx[i]
        u = self.u[i] = self.u[i] + t * self.dy[i]
        self.z[i] += t * self.dz[i]
        y = u + self.glass.at(self.sheet[i]).bottom(self.cell[i])
        c, s = self.c[i], self.s[i]
        x, y = c * x - s * y, s * x + c * y
        if self.axes is not None:
            x, y, _ = np.einsum("nij,in->jn", self.axes[self.sheet[i]], np.stack((x, y, self.z[i])))
        blocked = self.outline.excludes(x, y)
        return self.without_ended(i, blocked, End.FRAME), face[~blocked]

    def bend(self, i: Indices, face: Indices, eta: Floats) -> Booleans:
        """Refract or reflect rays at a face. Return which of the rays are reflected.

        eta is the refractive index before the face, divided by the index behind the face.
        """
        count = self.rays.count[i]
        self.rays.faces[i, count] = face
        self.rays.count[i] = count + 1
        nu, nz = self.glass.at(self.sheet[i], self.cell[i]).normals(face, self.u[i], self.z[i])
        if isinstance(self.glass, ProfileCells):
            cell = self.cell[i] + self.glass.at(self.sheet[i], self.cell[i]).copy(face, self.u[i])
            self.entered[i] = np.where(np.isnan(self.entered[i]), cell, self.entered[i])
            self.last[i] = cell
        dy, dz = self.dy[i], self.dz[i]
        along = nu * dy + nz * dz  # positive for a ray that leaves the prism
        square = 1 - eta**2 * (1 - along**2)
        stops = face == Face.TOP if self.black else np.zeros(len(i), bool)
        reflected = (square < 0) & ~stops  # totally
        if self.partial:
            r_s, r_p = reflection(eta, 1, np.abs(along))
            part = np.where(stops, 0, (np.abs(r_s) ** 2 + np.abs(r_p) ** 2) / 2)
            partly = ~reflected & (self.partial.uniform(size=len(i)) < part)
            self.rays.light[i] *= np.where(reflected | partly, part, 1 - part)
            self.rays.reflected[i[partly]] = True
            reflected |= partly
        change = np.where(reflected, -2 * along, np.copysign(np.sqrt(np.maximum(square, 0)), along) - eta * along)
        # what a top absorbs keeps its direction
        change, scale = np.where(stops, 0, change), np.where(reflected | stops, 1, eta)
        self.dx[i] *= scale
        self.dy[i] = scale * dy + change * nu
        self.dz[i] = scale * dz + change * nz
        return np.asarray(reflected)
