"""Cross-sections of the sheets that light-ray metamaterials are built of: prisms, lenticular arrays, wedges.

A sheet is a cross-section, extruded along the ridges and repeated across them. Points of the cross-section are (u, z):
u runs across the ridges, z away from the eye. Both are in units of the period, so that u is from 0 to 1. The outlines
between glass and air consist of straight edges and of circular arcs. An outline is closed, as round a prism, or it
continues in the next period, as the face of an array of lenses does.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate, combinations, pairwise
from math import asin, hypot, isfinite, radians, sqrt, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from povgen.optics.prism import Prism

MAX_EDGES = 32  # of a profile
CHORDS = 64  # into which an arc is divided to find out whether outlines cross; even
TOLERANCE = 1e-9  # of a corner's place
LARGEST = 1e100  # numbers in a TOML file are less: whole numbers there can be too large for a float
LARGEST_RADIUS = 1e4  # periods: POV-Ray draws cylinders of 1e6 wrongly, and the ray trace those of 1e12
ASIDE = 1e-5  # periods: at this distance from an outline, there must be glass on one side, and air on the other

Point = tuple[float, float]
Polyline = NDArray[np.float64]  # (points, 2)


class Outline(NamedTuple):
    """Corners of an outline, and for each edge between two corners its radius: `Edge.radius`."""

    corners: tuple[Point, ...]  # the last is the first, or the first one period farther
    radii: tuple[float, ...]


class Edge(NamedTuple):
    """An edge of an outline: straight, or an arc of up to a semicircle.

    If u points right and z up, glass is on the left of the way from start to end. So the normal that points out of the
    glass is the direction from start to end, turned by 90 degrees clockwise.
    """

    start: Point
    end: Point
    radius: float  # of an arc: above 0 if the glass bulges, below 0 if it is hollow; 0: a straight edge
    # from the edge to its next copy, in periods. If it is not 1, copies are counted from the middle of the window
    period: float = 1.0

    @property
    def chord(self) -> float:
        """The distance from start to end."""
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])

    @property
    def along(self) -> Point:
        """The unit vector from start to end."""
        return (self.end[0] - self.start[0]) / self.chord, (self.end[1] - self.start[1]) / self.chord

    @property
    def normal(self) -> Point:
        """The unit vector perpendicular to the chord that points out of the glass."""
        return self.along[1], -self.along[0]

    @property
    def centre(self) -> Point:
        """The centre of the arc; of a straight edge, its start."""
        if not self.radius:
            return self.start
        aside = sqrt(max(self.radius**2 - self.chord**2 / 4, 0)) * (-1 if self.radius > 0 else 1)
        (u0, z0), (u1, z1), (nu, nz) = self.start, self.end, self.normal
        return (u0 + u1) / 2 + aside * nu, (z0 + z1) / 2 + aside * nz

    def points(self, chords: int = CHORDS) -> Polyline:
        """Return the ends of equal parts of the edge, (chords + 1, 2)."""
        if not self.radius:
            return np.linspace(self.start, self.end, chords + 1)
        half = asin(min(self.chord / 2 / abs(self.radius), 1))
        angle = np.linspace(-half, half, chords + 1)[:, None]
        outwards = np.array(self.normal) * (1 if self.radius > 0 else -1)
        found = self.centre + abs(self.radius) * (np.sin(angle) * self.along + np.cos(angle) * outwards)
        found[[0, -1]] = self.start, self.end
        return np.asarray(found)

    @property
    def depths(self) -> Point:
        """The least and the greatest z."""
        z = [self.start[1], self.end[1]]
        for sign in (-1, 1) if self.radius else ():
            u, top = self.centre[0], self.centre[1] + sign * abs(self.radius)
            outwards = (u - self.start[0]) * self.normal[0] + (top - self.start[1]) * self.normal[1]
            along = (u - self.start[0]) * self.along[0] + (top - self.start[1]) * self.along[1]
            if outwards * self.radius > 0 and 0 < along < self.chord:
                z.append(top)
        return min(z), max(z)


@dataclass(frozen=True)
class Profile:
    """One period of a sheet. `of_outlines` makes it from outlines that a user states, and checks them."""

    edges: tuple[Edge, ...]  # of all outlines, numbered from 1; z = 0 is midway between the least and the greatest z
    path: tuple[int, ...]  # the edges that light on the designed path meets on its way to greater z, in order
    index: float = 1.5  # refractive index n of the glass, above 1
    gap: float = 0.01  # air between two sheets, in periods
    pitch: float = 1.0  # the period, in any unit of length

    @classmethod
    def of_outlines(
        cls, outlines: Sequence[Outline], path: Sequence[int], index: float = 1.5, gap: float = 0.01
    ) -> "Profile":
        """Return the profile with these outlines, in units of the period.

        The glass lies within closed outlines. Of outlines that continue in the next period it lies between the first
        and the second along z, the third and the fourth, and so on. Edges are numbered from 1, through all outlines in
        order. `path` has the numbers of the edges on the designed path. The result has the pitch 1. Raises ValueError
        for outlines that do not close, that cross or leave the period, or that do not have glass on one side and air on
        the other, and for numbers outside their ranges. NaN is outside.
        """
        for name, value, allowed, inside in (
            ("index", index, "above 1, up to 4", 1 < index <= 4),
            ("gap", gap, "0 or more, up to 100 periods", 0 <= gap <= 100),
        ):
            if not inside:
                raise ValueError(f"{name} = {value:g}; allowed: {allowed}")
        several = [_edges(outline, number) for number, outline in enumerate(outlines, 1)]
        continuing = sum(abs(outline.corners[0][0] - outline.corners[-1][0]) > 0.5 for outline in outlines)
        if continuing % 2:
            raise ValueError(f"{continuing} outlines that continue in the next period; allowed: an even number")
        if not 1 <= sum(map(len, several)) <= MAX_EDGES:
            raise ValueError(f"{sum(map(len, several))} edges; allowed: 1 to {MAX_EDGES}")
        edges = _with_glass(several)
        for number, edge in enumerate(edges, 1):
            _check_edge(edge, number)
        _check_apart(edges)
        _check_glass(edges, [len(outline) for outline in several])
        for number in path:
            if not 1 <= number <= len(edges):
                raise ValueError(f"path: edge {number}; allowed: 1 to {len(edges)}")
        if len(path) < 2:
            raise ValueError(f"path = {list(path)}; allowed: the numbers of two or more edges")
        z = [depth for edge in edges for depth in edge.depths]
        middle = (min(z) + max(z)) / 2
        if not max(z) - min(z) > 0:
            raise ValueError("thickness = 0; allowed: above 0")
        centred = [
            edge._replace(start=(edge.start[0], edge.start[1] - middle), end=(edge.end[0], edge.end[1] - middle))
            for edge in edges
        ]
        return cls(tuple(centred), tuple(path), index, gap)

    def scaled(self, pitch: float) -> "Profile":
        """Return the profile with another period."""
        return replace(self, pitch=pitch)

    @property
    def is_mismatched(self) -> bool:
        """Whether an edge has another period than the others."""
        return any(edge.period != 1 for edge in self.edges)

    @cached_property
    def half(self) -> float:
        """Half of the extent along z, in periods."""
        return max(abs(depth) for edge in self.edges for depth in edge.depths)

    @property
    def length(self) -> float:
        """Extent along z."""
        return 2 * self.half * self.pitch

    @property
    def separation(self) -> float:
        """Distance between the middle planes of two parallel sheets."""
        return self.length + self.gap * self.pitch

    def thickness(self, sheets: int) -> float:
        """Extent along z of one sheet, or of two parallel sheets and the air between them."""
        return self.length + (sheets - 1) * self.separation


def dove(prism: Prism) -> Profile:
    """Return the profile of Dove prisms.

    The edges are the base, the slanted facet near the eye, the top, and the other slanted facet, in this order. Raises
    ValueError for prisms without a top, and for an index above 4. The pitch is above 0.
    """
    low, high = prism.gap / 2, 1 - prism.gap / 2
    base, top = prism.length / prism.pitch / 2, prism.top_length / prism.pitch / 2
    corners = ((low, base), (low, -base), (high, -top), (high, top), (low, base))
    return Profile.of_outlines([Outline(corners, (0,) * 4)], (2, 1, 4), prism.index, prism.gap).scaled(prism.pitch)


@lru_cache  # of many scenes, most have the same
def confocal(
    ratio: float = 1.0, f_number: float = 3.0, index: float = 1.5, gap: float = 0.01, mismatch: float = 0.0
) -> Profile:
    """Return the profile of a block of glass with an array of lenses on both faces, whose focal planes coincide.

    f_number is the focal length, in the glass, of the lenses on the eye's side, in periods. ratio is the focal length
    on the object's side divided by f_number. The block is as thick as both focal lengths together. The period of the
    lenses on the object's side is greater by the fraction `mismatch`. Raises ValueError for a mismatch below -0.9,
    for a focal length whose lens would be more than a semicircle, and for what `Profile.of_outlines` does not allow.
    """
    if not -0.9 <= mismatch < LARGEST:  # light meets many lenses of a small period in one cell
        raise ValueError(f"mismatch = {mismatch:g}; allowed: -0.9 or more")
    near, far = _lens_radius(f_number, index), _lens_radius(ratio * f_number, index, 1 + max(mismatch, 0))
    thickness = (1 + ratio) * f_number
    made = Profile.of_outlines([_lenses(0.0, near, -1), _lenses(thickness, far, 1)], (1, 2), index, gap)
    if not mismatch:
        return made
    edge, wide = made.edges[1], 1 + mismatch  # the edge keeps its radius, and its distance from the other lenses
    z = edge.depths[1] - (far - sqrt(far**2 - wide**2 / 4))
    start, end = ((u * wide, z) for u in (edge.start[0], edge.end[0]))
    return replace(made, edges=(made.edges[0], Edge(start, end, far, wide)))


def lenticulars(
    ratio: float = 1.0, f_number: float = 2.0, index: float = 1.5, gap: float = 0.01, sheet: float = 0.3
) -> Profile:
    """Return the profile of two thin sheets of lenses, with air between them, whose focal planes coincide.

    The lenses are on the outer faces. f_number is the focal length in air on the eye's side, in periods. ratio is as
    for `confocal`. Each thin sheet has the thickness `sheet`, in periods, at the middle of its lenses. Raises
    ValueError for a sheet that is thinner than its lenses or that leaves no air, for a focal length whose lens would be
    more than a semicircle, and for what `Profile.of_outlines` does not allow.
    """
    near, far = _lens_radius(f_number * index, index), _lens_radius(ratio * f_number * index, index)
    air = (1 + ratio) * f_number - 2 * sheet / index
    least = max(radius - sqrt(radius**2 - 0.25) for radius in (near, far))
    if not (sheet > least and air > 0):
        most = (1 + ratio) * f_number * index / 2
        raise ValueError(f"sheet = {sheet:g}; allowed: above {least:.4g}, and below {most:.4g} periods")
    flat = [Outline(((0, z), (1, z)), (0,)) for z in (sheet, sheet + air)]
    return Profile.of_outlines(
        [_lenses(0.0, near, -1), *flat, _lenses(2 * sheet + air, far, 1)], (1, 2, 3, 4), index, gap
    )


def wedges(angle: float = 15.0, index: float = 1.5, gap: float = 0.01, draft: float = 0.02) -> Profile:
    """Return the profile of an array of wedges: a flat face to the eye, and facets at `angle` degrees behind it.

    Along a facet, the glass gets thicker with increasing u. The steep side between two facets extends over `draft`
    periods along u. Raises ValueError for an angle that is not from 1 to 60, and for what `Profile.of_outlines` does
    not allow.
    """
    if not 1 <= angle <= 60:
        raise ValueError(f"angle = {angle:g}; allowed: 1 to 60 degrees")
    rise = (1 - draft) * tan(radians(angle))
    facets = Outline(((0, 0.2), (1 - draft, 0.2 + rise), (1, 0.2)), (0, 0))
    return Profile.of_outlines([Outline(((0, 0), (1, 0)), (0,)), facets], (1, 2), index, gap)


def _lens_radius(focal_length: float, index: float, width: float = 1.0) -> float:
    """Return the radius of a lens with this width and focal length in its glass, in periods. Raises ValueError."""
    if not index > 1:
        raise ValueError(f"index = {index:g}; allowed: above 1")
    radius = focal_length * (index - 1) / index
    if not (isfinite(radius) and radius >= width / 2):
        least = index * width / (2 * (index - 1))
        raise ValueError(
            f"focal length = {focal_length:g} periods in glass of index {index:g}: a lens would be more than a "
            f"semicircle; allowed: {least:.4g} periods or more"
        )
    return radius


def _lenses(vertex: float, radius: float, side: int) -> Outline:
    """Return a face of lenses that bulge to smaller z (side -1) or to greater z (1), up to z = `vertex`."""
    corner = vertex - side * (radius - sqrt(radius**2 - 0.25))
    return Outline(((0, corner), (1, corner)), (radius,))


def _edges(outline: Outline, number: int) -> list[Edge]:
    """Return an outline's edges as they are stated. Raises ValueError if it does not close, or an edge is short."""
    where, corners = f"outline {number}", outline.corners
    (u0, z0), (u1, z1) = corners[0], corners[-1]
    if abs(z1 - z0) > TOLERANCE or min(abs(u1 - u0), abs(abs(u1 - u0) - 1)) > TOLERANCE:
        raise ValueError(
            f"{where}: begins at {_text(corners[0])} and ends at {_text(corners[-1])}; "
            "allowed: the same point, or one period farther"
        )
    edges = [Edge(*ends, radius) for ends, radius in zip(pairwise(corners), outline.radii, strict=True)]
    for n, edge in enumerate(edges, 1):
        if not edge.chord > TOLERANCE:
            raise ValueError(f"{where}, edge {n}: begins and ends at {_text(edge.start)}; allowed: two points")
    return edges


def _check_edge(edge: Edge, number: int) -> None:
    """Raise ValueError for a radius out of range, and for an edge that leaves the period or lies on its border."""
    if edge.radius and not (1 - TOLERANCE) * edge.chord / 2 <= abs(edge.radius) <= LARGEST_RADIUS:
        raise ValueError(
            f"edge {number}: radius = {edge.radius:g}; "
            f"allowed: 0, or {edge.chord / 2:.4g} to {LARGEST_RADIUS:g} periods in size"
        )
    u = edge.points()[:, 0]
    if u.min() < -TOLERANCE or u.max() > 1 + TOLERANCE:
        raise ValueError(f"edge {number}: u from {u.min():.4g} to {u.max():.4g} periods; allowed: 0 to 1")
    if u.max() < TOLERANCE or u.min() > 1 - TOLERANCE:
        raise ValueError(f"edge {number}: lies on the border of the period; allowed: inside")


def _text(point: Point) -> str:
    return "[{:g}, {:g}]".format(*point)


def _check_apart(edges: Sequence[Edge]) -> None:
    """Raise ValueError if edges cross."""
    for (n, one), (m, other) in combinations(enumerate(edges, 1), 2):
        a, b, c, d = one.points()[:-1, None], one.points()[1:, None], other.points()[:-1], other.points()[1:]
        sides = [_side(a, b, c) * _side(a, b, d), _side(c, d, a) * _side(c, d, b)]
        crossed = (sides[0] < -(TOLERANCE**2)) & (sides[1] < -(TOLERANCE**2))
        if crossed.any():
            at = a[np.argwhere(crossed)[0][0], 0]
            raise ValueError(f"edges {n} and {m} cross near {_text(at)}; allowed: outlines that do not cross")


def _side(a: Polyline, b: Polyline, point: Polyline) -> NDArray[np.float64]:
    """Return on which side of the lines from a to b points are, as a signed area."""
    d, e = b - a, point - a
    return np.asarray(d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0])


def _with_glass(outlines: Sequence[Sequence[Edge]]) -> list[Edge]:
    """Return the edges of outlines, turned where needed so that glass is on the side that `Edge` says.

    Straight lines take the place of arcs, because the side to which an arc bulges is known only after the turning.
    Raises ValueError if there is not glass on one side of an outline and air on the other.
    """
    chords = np.array([(edge.start, edge.end) for outline in outlines for edge in outline])
    found: list[Edge] = []
    for number, outline in enumerate(outlines, 1):
        edge = max(outline, key=lambda each: each.chord)
        left, right = _has_glass_beside(np.array([edge.start, edge.end]), chords)
        if left == right:
            raise ValueError(
                f"outline {number}: glass or air on both sides; allowed: glass on one, air on the other, "
                "also with straight lines in place of arcs"
            )
        found += outline if left else [Edge(edge.end, edge.start, edge.radius) for edge in outline]
    return found


def _check_glass(edges: Sequence[Edge], counts: Sequence[int]) -> None:
    """Raise ValueError if an outline has glass on another side than its edges say.

    `counts` are the numbers of edges of the outlines. The side can be wrong for an outline between an arc and the
    straight line that `_with_glass` puts in the arc's place.
    """
    lines = np.concatenate([np.stack((points[:-1], points[1:]), axis=1) for points in map(Edge.points, edges)])
    for number, end in enumerate(accumulate(counts), 1):
        edge = max(edges[end - counts[number - 1] : end], key=lambda each: each.chord)
        if _has_glass_beside(edge.points()[CHORDS // 2 :][:2], lines) != (True, False):
            raise ValueError(
                f"outline {number}: between another outline's arc and the straight line from its start to its end; "
                "allowed: elsewhere, or this arc in shorter parts"
            )


def _has_glass_beside(line: Polyline, lines: Polyline) -> tuple[bool, bool]:
    """Return whether there is glass beside the middle of a line from a to b: on its left, and on its right.

    `lines` (n, 2, 2) are all outlines' lines. A point is in glass if a line along z, from before the sheet to the
    point, crosses an odd number of them.
    """
    (u0, z0), (u1, z1) = np.moveaxis(lines, 0, -1)
    along = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    found = []
    for side in (1, -1):
        u, z = line.mean(0) + side * ASIDE * np.array([-along[1], along[0]])
        crossed = (u0 <= u) != (u1 <= u)
        at = z0[crossed] + (u - u0[crossed]) / (u1 - u0)[crossed] * (z1 - z0)[crossed]
        found.append(bool((at < z).sum() % 2))
    return found[0], found[1]
