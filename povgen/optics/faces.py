"""What a ray meets in a sheet: the faces of one cell, for prisms and for any other profile, on numpy arrays.

The coordinates are those of `optics.trace`, and so are the cells.
"""

from dataclasses import dataclass, fields, replace
from enum import IntEnum
from functools import cached_property
from math import ceil, sqrt
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from povgen.optics.prism import MOST_DEVIATION, Prism
from povgen.optics.profile import Edge, Profile

Floats = NDArray[np.float64]
Indices = NDArray[np.int_]
Booleans = NDArray[np.bool_]


class Face(IntEnum):
    """Faces of a prism. NEAR is the slanted facet towards negative z, where the eye is.

    `profile.dove` numbers its edges in the same way. The faces of any other profile have the numbers of its edges.
    """

    NONE = 0
    BASE = 1
    NEAR = 2
    TOP = 3
    FAR = 4


# of each `Face`: on which side along z the slanted facet is, and u of the normal of the others
SIDE, UP = np.array([0.0, 0, -1, 0, 1]), np.array([0.0, -1, 0, 1, 0])
BORDER = 255  # in place of a face: the border between two cells of a profile
ROUNDING = 1e-12  # periods, or radii of arcs: by how much a ray may miss the end of an edge


@dataclass(frozen=True)
class GlassSheet:
    """A sheet of equal prisms or lenses, turned by `angle` (radians) about z. Its middle plane is z = `centre`.

    `angle` is from the x axis to the ridges, and positive from x towards y. A sheet that is not built exactly can also
    be tilted about its middle, by `tilt` (radians): about x, and then about y. Positive tilts turn y towards z, and z
    towards x. The window's frame stays upright.
    """

    angle: float
    centre: float
    shape: Prism | Profile
    tilt: tuple[float, float] = (0.0, 0.0)
    # standard deviations, and the seed of the random numbers: `single_prisms`
    facets: float = 0.0  # of the angle between base and each single facet, radians
    pitches: float = 0.0  # of the height of each single prism, divided by the height
    seed: tuple[int, int] = (0, 0)

    @property
    def axes(self) -> Floats:
        """The unit vectors of a sheet that is tilted, but not turned: the rows of a matrix (3, 3)."""
        (cx, cy), (sx, sy) = np.cos(self.tilt), np.sin(self.tilt)
        return np.array([[cy, 0, -sy], [sx * sy, cx, sx * cy], [cx * sy, -sx, cx * cy]])

    def reach(self, window: float) -> float:
        """Return how far the sheet extends along z from its middle, in a window with this side."""
        x, y, z = abs(self.axes[2])  # of the normal
        return float(((x + y) * window + self.shape.length) / 2 / z)


class _Cells:
    """Cells of equal height in sheets. Arguments and results of the methods are arrays with a value for each ray."""

    pitch: Any
    first: Any

    def cell_of(self, v: Floats) -> tuple[Floats, Floats]:
        """Return the cells in which rays at these heights in a sheet are, and the heights above the cells' bottoms."""
        cell = np.floor((v - self.first) / self.pitch)
        return cell, v - self.first - cell * self.pitch

    def bottom(self, cell: Floats) -> Floats:
        """Return the heights in the sheet at which these cells begin."""
        return np.asarray(cell * self.pitch + self.first)


@dataclass(frozen=True)
class PrismCells(_Cells):
    """The shapes of the prisms in sheets.

    If all sheets have the same shape, each field is a number, or a pair of numbers. Otherwise it is an array with a
    value for each sheet, or, in a result of `at`, for each ray.
    """

    pitch: Floats
    height: Floats
    half: Floats  # of the length
    index: Floats
    first: Floats  # y of the base of prism 0
    cosine: Floats  # of the angle between the base and the slanted facets
    sine: Floats
    far: tuple[Floats, Floats] | None = None  # cosine and sine of the far facet, if it has another angle

    @classmethod
    def of(cls, shapes: list[Prism], window: float) -> "PrismCells":
        """Return the prisms of sheets with these shapes, one for each sheet, in windows with this side."""
        if len(set(shapes)) == 1:
            shapes = shapes[:1]
        base = np.radians([prism.base_angle for prism in shapes])
        pitch, height, half, index, gap = np.array(
            [(prism.pitch, prism.height, prism.length / 2, prism.index, prism.gap) for prism in shapes]
        ).T
        found = (pitch, height, half, index, -window / 2 + gap * pitch / 2, np.cos(base), np.sin(base))
        numbers: list[Any] = [values if len(shapes) > 1 else values[0] for values in found]
        return cls(*numbers)

    def at(self, sheet: Indices, cell: Floats | None = None) -> Self:
        """Return the shape of the prisms for each ray. `sheet` is the number of its sheet, from 0, `cell` its prism."""
        if not np.ndim(self.pitch):
            return self
        own = ("pitch", "height", "half", "index", "first", "cosine", "sine")
        return replace(self, **{name: getattr(self, name)[sheet] for name in own})

    def normals(self, face: Indices, u: Floats, z: Floats) -> tuple[Floats, Floats]:
        """Return u and z of the faces' outward normals at the places of rays."""
        side, c, s = SIDE[face], self.cosine, self.sine
        if self.far:
            c, s = np.where(side < 0, (c, s), self.far)
        return np.where(side == 0, UP[face], c), side * s

    def _facets(self, u: Floats, z: Floats, dy: Floats, dz: Floats) -> list[tuple[Face, Floats, Floats]]:
        """Return for each slanted facet: the `Face`, the component of the direction along its outward normal, and t.

        A ray meets the facet's plane at its place plus t times its direction.
        """
        found = []
        near = self.cosine, self.sine
        for face, side, (cosine, sine) in ((Face.NEAR, -1, near), (Face.FAR, 1, self.far or near)):
            along = cosine * dy + side * sine * dz
            found.append((face, along, (sine * self.half - cosine * u - side * sine * z) / along))
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


@dataclass(frozen=True, kw_only=True)
class UnequalPrismCells(PrismCells):
    """Prisms whose single facets differ from the planned angle, and whose heights differ from the planned height."""

    bottoms: (
        Floats  # where each prism's cell begins, and the last one ends: the height in the sheet, (sheets, prisms + 1)
    )
    angles: Floats  # of each prism's near and far facet to the base, radians: (sheets, prisms, 2)
    lowest: Indices  # the number of the first of these prisms in each sheet, (sheets,)
    sheet: Indices | None = None  # of each ray

    @classmethod
    def of_sheets(cls, sheets: tuple[GlassSheet, ...], shapes: list[Prism], window: float) -> "UnequalPrismCells":
        """Return the prisms of these sheets, in windows with this side."""
        found = [single_prisms(sheet, window) for sheet in sheets]
        most = max(len(angles) for _, _, angles in found)
        bottoms = [np.pad(bottoms, (0, most + 1 - len(bottoms)), "edge") for _, bottoms, _ in found]
        angles = [np.pad(angles, ((0, most - len(angles)), (0, 0)), "edge") for _, _, angles in found]
        equal = PrismCells.of(shapes, window)
        same = {field.name: getattr(equal, field.name) for field in fields(equal)}
        return cls(**same, bottoms=np.array(bottoms), angles=np.array(angles), lowest=np.array([n for n, *_ in found]))

    def at(self, sheet: Indices, cell: Floats | None = None) -> Self:
        found = replace(super().at(sheet), sheet=sheet)
        if cell is None:
            return found
        k = found._row(cell)
        (cosine, far_cosine), (sine, far_sine) = np.cos(self.angles[sheet, k].T), np.sin(self.angles[sheet, k].T)
        pitch = self.bottoms[sheet, k + 1] - self.bottoms[sheet, k]
        height, far = pitch - (found.pitch - found.height), (far_cosine, far_sine)
        return replace(found, pitch=pitch, height=height, cosine=cosine, sine=sine, far=far)

    def cell_of(self, v: Floats) -> tuple[Floats, Floats]:
        cell = np.empty(len(v))
        for number, (bottoms, lowest) in enumerate(zip(self.bottoms, self.lowest, strict=True)):
            own = self.sheet == number
            cell[own] = lowest + np.searchsorted(bottoms, v[own], "right") - 1
        return cell, v - self.bottom(cell)

    def bottom(self, cell: Floats) -> Floats:
        return np.asarray(self.bottoms[self.sheet, self._row(cell)])

    def _row(self, cell: Floats) -> Indices:
        """Return the indices of the rays' prisms in the arrays. No ray is followed beyond the last prism."""
        return np.clip(cell.astype(int) - self.lowest[self.sheet], 0, self.angles.shape[1] - 1)


@dataclass(frozen=True)
class ProfileCells(_Cells):
    """The cells of profiles, with the methods of `PrismCells`. Fields of type Any are numbers or arrays as there."""

    shapes: list[Profile]
    which: Any  # the number of the shape: None if all sheets have the same, or an array
    pitch: Any
    half: Any
    index: Any
    first: float  # the lower border of cell 0
    cell: Any = None  # if `is_mismatched`: each ray's cell; the number is its lower border, in periods from the middle

    @classmethod
    def of(cls, profiles: list[Profile], window: float) -> "ProfileCells":
        """Return the cells of sheets with these profiles, one for each sheet. `window` is the window's side length."""
        one, many = profiles[0], [*dict.fromkeys(profiles)]
        if len(many) == 1:
            return cls(many, None, one.pitch, one.length / 2, one.index, -window / 2)
        which = np.array([many.index(shape) for shape in profiles])
        pitch, half, index = np.array([(shape.pitch, shape.length / 2, shape.index) for shape in profiles]).T
        return cls(many, which, pitch, half, index, -window / 2)

    def at(self, sheet: Indices, cell: Floats | None = None) -> "ProfileCells":
        """Return the shape for each ray. `sheet` is the number of its sheet, from 0, and `cell` that of its cell."""
        own = () if self.which is None else ("which", "pitch", "half", "index")
        found = replace(self, **{name: getattr(self, name)[sheet] for name in own}) if own else self
        if cell is None or not self.is_mismatched:
            return found
        return replace(found, cell=cell + found.first / found.pitch)

    @cached_property
    def is_mismatched(self) -> bool:
        """Whether edges have another period than their cells."""
        return any(shape.is_mismatched for shape in self.shapes)

    def copy(self, face: Indices, u: Floats) -> Floats:
        """Return the number of the edge's copy at each ray's place, minus the number of the ray's cell.

        Both are counted from the window's middle. The result is 0 for edges whose period is that of the cells.
        """
        found = np.zeros(len(u))
        for k, shape in enumerate(self.shapes if self.is_mismatched else ()):
            for number, edge in enumerate(shape.edges, 1):
                own = (face == number) & (self.which is None or self.which == k) & (edge.period != 1)
                found[own] = np.rint(_copy(edge, self.cell[own], u[own] / shape.pitch) - self.cell[own])
        return found

    def way_out(self, u: Floats, z: Floats, dy: Floats, dz: Floats) -> tuple[Floats, Indices]:
        """Return where rays in the glass meet a face or a border, as a multiple of their direction, and which."""
        return self._way(u, z, dy, dz, 1)

    def way_in(self, u: Floats, z: Floats, dy: Floats, dz: Floats) -> tuple[Floats, Indices]:
        """Return what `way_out` does, for rays in the air. `Face.NONE` means that the ray leaves the sheet."""
        t, face = self._way(u, z, dy, dz, -1)
        side = np.maximum(np.where(dz == 0, np.inf, (np.copysign(self.half, dz) - z) / dz), 0)
        leaves = (side < t) | (side == t) & (face == BORDER)
        return np.where(leaves, side, t), np.where(leaves, Face.NONE, face)

    def _way(self, u: Floats, z: Floats, dy: Floats, dz: Floats, outwards: int) -> tuple[Floats, Indices]:
        if self.which is None:
            return _met(self.shapes[0], u, z, dy, dz, outwards, self.cell)
        t, face = np.empty(len(u)), np.empty(len(u), int)
        for k, shape in enumerate(self.shapes):
            own = self.which == k
            cell = None if self.cell is None else self.cell[own]
            t[own], face[own] = _met(shape, u[own], z[own], dy[own], dz[own], outwards, cell)
        return t, face

    def normals(self, face: Indices, u: Floats, z: Floats) -> tuple[Floats, Floats]:
        """Return u and z of the edges' outward normals at the places of rays."""
        nu, nz = np.empty(len(u)), np.empty(len(u))
        for k, shape in enumerate(self.shapes):
            for number, edge in enumerate(shape.edges, 1):
                own = face == number if self.which is None else (face == number) & (self.which == k)
                if edge.radius:
                    (cu, cz), radius, shift = edge.centre, edge.radius * shape.pitch, np.zeros(1)
                    if edge.period != 1:
                        shift = _shift(edge, self.cell[own], _copy(edge, self.cell[own], u[own] / shape.pitch))
                    nu[own] = (u[own] - (cu + shift) * shape.pitch) / radius
                    nz[own] = (z[own] - cz * shape.pitch) / radius
                else:
                    nu[own], nz[own] = edge.normal
        return nu, nz


def _copy(edge: Edge, cell: Floats, u: Floats | float) -> Floats:
    """Return the number of the edge's copy at the height u in a cell, in periods.

    Cells and copies are counted from the window's middle: number k begins k of its own periods above the middle.
    """
    # the fractional part of the numbers of all cells and copies: 0 for an even number of cells, 0.5 for an odd one
    begin = cell % 1
    return np.asarray(np.floor((cell + u) / edge.period - begin) + begin)


def _shift(edge: Edge, cell: Floats, copy: Floats) -> Floats:
    """Return the place at which a copy of an edge's period begins, in periods above the bottom of a cell."""
    return copy * edge.period - cell


def _met(
    shape: Profile, u: Floats, z: Floats, dy: Floats, dz: Floats, outwards: int, cell: Floats | None = None
) -> tuple[Floats, Indices]:
    """Return where rays in a cell first meet an edge or a border, as a multiple of their direction, and which.

    Only edges count that rays cross from glass to air (`outwards` 1), or from air to glass (-1). So a ray that has just
    met an edge does not meet it again at the same place. Of the two points in which a ray crosses a circle, one counts.
    """
    pitch = shape.pitch
    t = np.where(dy == 0, np.inf, (np.where(dy > 0, pitch, 0) - u) / dy)
    face = np.full(len(u), BORDER)
    square = dy**2 + dz**2
    copies: list[tuple[int, Edge, Floats]] = []  # with u from the place where the edge's period begins
    for number, edge in enumerate(shape.edges, 1):
        if edge.period == 1 or cell is None:
            copies.append((number, edge, u))
        else:  # all copies that overlap with the cell
            lowest, most = _copy(edge, cell, 0.0), ceil(1 / edge.period) + 1
            copies += [(number, edge, u - pitch * _shift(edge, cell, lowest + k)) for k in range(most)]
    for number, edge, own_u in copies:
        reach, meets = _reach(edge, pitch, own_u, z, dy, dz, square, outwards)
        least = ROUNDING * pitch * max(1, abs(edge.radius))
        (su, sz), (tu, tz), (nu, nz) = edge.start, edge.along, edge.normal
        hu, hz = own_u + reach * dy - pitch * su, z + reach * dz - pitch * sz
        along = tu * hu + tz * hz
        meets &= (reach > -least) & (reach < t) & (along >= -least) & (along <= pitch * edge.chord + least)
        if edge.radius:  # the circle's other part is on the other side of the chord
            meets &= np.copysign(1, edge.radius) * (nu * hu + nz * hz) >= -least
        t, face = np.where(meets, reach, t), np.where(meets, number, face)
    return np.maximum(t, 0), face


def _reach(
    edge: Edge, pitch: float, u: Floats, z: Floats, dy: Floats, dz: Floats, square: Floats, outwards: int
) -> tuple[Floats, Booleans]:
    """Return where rays cross an edge's line or circle in the direction `outwards`, and whether they do: see `_met`."""
    if not edge.radius:
        nu, nz = edge.normal
        along = nu * dy + nz * dz
        return (nu * (pitch * edge.start[0] - u) + nz * (pitch * edge.start[1] - z)) / along, along * outwards > 0
    cu, cz = edge.centre
    qu, qz = u - pitch * cu, z - pitch * cz
    half = qu * dy + qz * dz
    root = half**2 - square * (qu**2 + qz**2 - (pitch * edge.radius) ** 2)
    sign = outwards if edge.radius > 0 else -outwards
    return (sign * np.sqrt(root) - half) / square, root > 0


def single_prisms(sheet: GlassSheet, window: float) -> tuple[int, Floats, Floats]:
    """Return the prisms of a sheet, in a window with this side, one by one: they differ at random.

    The result is the number of the lowest prism, the heights of the bases, and the angles of the facets. The heights
    (prisms + 1,) are those in the sheet before it is turned. The last one is for a prism above the last prism. The
    angles (prisms, 2), radians, are those of each prism's near and far facet to its base. The prisms are stacked with
    the planned gaps between them. `count` prisms fit in the window, and prism 0 is the lowest of them. Prism count // 2
    has its base where it is planned. Heights and angles are normally distributed. None differs from the plan by more
    than MOST_DEVIATION times its standard deviation. `sheet.shape` is a `Prism`, and `sheet.pitches` is below
    1/MOST_DEVIATION.
    """
    shape = sheet.shape
    assert isinstance(shape, Prism)
    count = round(window / shape.pitch)
    # prisms outside the window, on either side: enough for a turned and tilted sheet, even if all prisms have the least
    # height
    beyond = ceil((sqrt(2) / sheet.axes[2, 2] / (1 - MOST_DEVIATION * sheet.pitches) - 1) / 2 * count) + 2

    def drawn(seed: tuple[int, ...], *shape: int) -> Floats:
        return np.clip(np.random.default_rng(seed).normal(size=shape), -MOST_DEVIATION, MOST_DEVIATION)

    angles = np.radians(shape.base_angle) + sheet.facets * drawn(sheet.seed, count + 2 * beyond, 2)
    pitches = shape.pitch + shape.height * sheet.pitches * drawn((*sheet.seed, 1), len(angles))
    bottoms = np.concatenate(([0], np.cumsum(pitches)))
    planned = (shape.gap / 2 + count // 2) * shape.pitch - window / 2
    return -beyond, bottoms - bottoms[beyond + count // 2] + planned, angles


def sections(sheet: GlassSheet, window: float) -> Floats:
    """Return the corners of each of the `single_prisms`, across its ridges: (prisms, 4, 2).

    They are u, the height in the sheet before it is turned, and z from the sheet's middle.
    """
    shape = sheet.shape
    assert isinstance(shape, Prism)
    _, bottoms, angles = single_prisms(sheet, window)
    height = np.diff(bottoms) - shape.gap * shape.pitch
    low, z = bottoms[:-1], np.full(len(height), shape.length / 2)
    near, far = height / np.tan(angles.T)
    corners = (low, z), (low, -z), (low + height, near - z), (low + height, z - far)
    return np.asarray(np.moveaxis(np.array(corners), 2, 0))
