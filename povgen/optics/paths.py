"""Where an eye sees a point through windows that stand anywhere: by each path on which its light reaches the eye.

The coordinates are those of `rays`. Light is followed backwards, from the eye. A window does to a ray what `apparent`
predicts: its ray-transfer matrix says place and slope behind it, or its law the slope. So prisms and lenses count by
their designed light, for rays at small angles to the normal.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from povgen.optics.apparent import nearest_rays
from povgen.optics.camera import Camera
from povgen.optics.equations import Complexes
from povgen.optics.faces import Booleans, Floats, Indices
from povgen.optics.opening import Opening
from povgen.optics.rays import Bundle
from povgen.optics.values import Values
from povgen.optics.window_trace import nearest, slope_of_light

MOST = 20  # windows on a path: as many as a room can have
STARTS = 2  # rays from which a path through a sequence of windows is searched for
_ROW = 40  # rays to a window in a row of the net
_ANGLES = np.tan(np.radians(np.linspace(-84, 84, 57)))  # slopes of the net's other rays
_PRECISION = 1e-9  # a path misses the point by at most this fraction of the point's distance from the eye


@dataclass(frozen=True, eq=False)
class Image(Values):
    """Where the eye sees a point by one path of its light."""

    position: complex  # in the picture's plane, x + iy, tiles
    windows: tuple[str, ...]  # the names of those on the path, the nearest to the eye first
    # (windows + 2, 3): the eye, where light leaves the sheets towards the point, and the point
    corners: Floats = field(repr=False)


class Leg(NamedTuple):
    """The straight parts of rays (n,) from one window to the next. NaN for rays that have ended."""

    start: Floats  # (n, 3)
    direction: Floats  # (n, 3), unit vectors
    length: Floats  # to the next window; infinite if there is none
    window: Indices  # the next one's number, or -1: there is none, or its frame's rim stops the ray


class DesignedLight:
    """Light on the path for which windows are designed, as it passes them one after another."""

    def __init__(self, windows: Iterable[Opening]) -> None:
        self.windows = [window.deep for window in windows]
        self.matrices = [_both_ways(window.sheet.transfer) for window in self.windows]
        self.centres = [layers[-1].centre if (layers := each.sheet.glass) else 0.0 for each in self.windows]

    @np.errstate(all="ignore")  # rays that have ended are NaN
    def walk(self, rays: Bundle, most: int = MOST) -> list[Leg]:
        """Follow rays (n,) through at most so many windows. Return their legs, one after another."""
        start, direction = rays.position, rays.direction
        last = np.full(len(start), -1)
        legs: list[Leg] = []
        while True:
            met, length, rim = nearest(self.windows, start, direction, last)
            last = np.where(rim, -1, met)
            legs.append(Leg(start, direction, length, last))
            if len(legs) > most or (last < 0).all():
                return legs
            start, direction = np.full_like(start, np.nan), direction.copy()
            for w in np.unique(last[last >= 0]):
                i = np.flatnonzero(last == w)
                start[i], direction[i] = self.cross(w, legs[-1].start[i], legs[-1].direction[i])

    def cross(self, w: int, position: Floats, direction: Floats, framed: bool = True) -> tuple[Floats, Floats]:
        """Take rays (n, 3) through window w. Return where they leave its middle plane, and their directions.

        They are NaN where the sheet, or the frame if it counts, lets no light pass.
        """
        window = self.windows[w]
        p, d = window.pose.own(position, direction)
        way = np.sign(d[:, 2])
        s = (d[:, 0] + 1j * d[:, 1]) / d[:, 2]
        P = p[:, 0] + 1j * p[:, 1] - p[:, 2] * s
        after, slope = self._sheet(w, P, s, way > 0)
        after = np.where(np.isfinite(slope), after, np.nan)
        if framed:
            planes = window.frame / 2, self.centres[w]  # as `apparent.passes`
            crossed = [point for z in planes for point in (P - way * z * s, after + way * z * slope)]
            hidden = np.any([window.outline.excludes(point.real, point.imag) for point in crossed], axis=0)
            after = np.where(hidden, np.nan, after)
        bent = np.stack((slope.real, slope.imag, np.ones(len(s))), -1) * way[:, None]
        bent /= np.linalg.norm(bent, axis=1, keepdims=True)
        return window.pose.scene(np.stack((after.real, after.imag, 0 * way), -1), bent)

    def _sheet(self, w: int, P: Complexes, s: Complexes, forward: Booleans) -> tuple[Complexes, Complexes]:
        """Return places and slopes behind the sheet of window w. A ray from behind takes its path backwards."""
        matrices, sheet = self.matrices[w], self.windows[w].sheet
        if matrices is not None:
            ray = np.stack((P.real, P.imag, s.real, s.imag, np.ones(len(s))))
            x, y, sx, sy, _ = np.where(forward, *(matrix @ ray for matrix in matrices))
            return x + 1j * y, sx + 1j * sy
        slope = np.empty_like(s)
        slope[forward] = sheet.slope(s[forward], P[forward])
        slope[~forward] = slope_of_light(sheet, s[~forward], P[~forward])
        return P, slope


class Paths(DesignedLight):
    """The paths of light through windows, by their names, to an eye."""

    def __init__(self, view: Camera, windows: Mapping[str, Opening]) -> None:
        super().__init__(windows.values())
        self.view, self.names = view, [*windows]
        self.net = self._net()
        self.legs = self.walk(view.through(self.net))

    def _net(self) -> Complexes:
        """Return positions in the picture's plane: rays to all windows, and to all sides."""
        right, up = np.array(self.view.right), np.array(self.view.up)
        x, y = (_ANGLES[axis].reshape(-1, 1) for axis in np.indices((len(_ANGLES),) * 2))
        found = [self.view.position(self.view.eye + x * right + y * up + np.cross(right, up))]
        side = (np.arange(_ROW) + 0.5) / _ROW - 0.5
        across, along = map(np.ravel, np.meshgrid(side, side))
        for window in self.windows:
            points = np.stack((across * window.outline.width, along * window.outline.height, 0 * across), -1)
            found.append(self.view.position(window.pose.scene(points, points)[0]))
        every = np.concatenate(found)
        return every[np.isfinite(every)]

    @np.errstate(all="ignore")  # rays that end are NaN
    def images(self, points: ArrayLike) -> list[list[Image]]:
        """Return the images of each of the points (n, 3): those nearest to the picture's middle first.

        A path passes up to MOST windows; the straight path counts too. Of light through a sheet that does not image,
        the path is that of the ray that reaches the eye. Through several windows that are turned against each other
        there can be several paths in the same sequence. Objects hide nothing. A sequence of windows is found if
        rays of a net pass it, 40 to a window in a row: what is seen of a window within less than that can be missed. A
        point that the eye sees in all directions, or in those of a line, has no image.
        """
        points = np.asarray(points, float).reshape(-1, 3)
        found: list[list[Image]] = [[] for _ in points]
        for sequence, (target, positions) in self._sequences(points):
            made = self._search(sequence, points[target], positions)
            target, made = target[there := np.isfinite(made)], made[there]
            for n, position, corners in self._verified(sequence, points[target], made):
                known = found[target[n]]
                near = 1e-7 * (1 + abs(position))
                names = tuple(self.names[w] for w in sequence)
                if not any(each.windows == names and abs(each.position - position) < near for each in known):
                    known.append(Image(position, names, corners))
        return [sorted(each, key=lambda image: abs(image.position)) for each in found]

    def _sequences(self, points: Floats) -> Iterator[tuple[tuple[int, ...], tuple[Indices, Complexes]]]:
        """Yield each sequence of windows, and where to begin to search: numbers of points, and positions (n,)."""
        straight = self.view.position(points)
        seen = np.flatnonzero(np.isfinite(straight))
        yield (), (seen, straight[seen])
        for k in range(1, len(self.legs)):
            met = np.stack([leg.window for leg in self.legs[:k]], 1)
            rays = np.flatnonzero(np.isfinite(self.legs[k].start[:, 0]))
            sequences, which = np.unique(met[rays], axis=0, return_inverse=True)
            for n, sequence in enumerate(sequences):
                some = rays[which.ravel() == n]
                start, direction = self.legs[k].start[some], self.legs[k].direction[some]
                off = np.linalg.norm(np.cross(points[:, None] - start, direction), axis=-1)
                yield tuple(sequence.tolist()), _closest(off, self.net[some])

    def _search(self, sequence: Sequence[int], points: Floats, starts: Complexes) -> Complexes:
        """Return positions (n,) near these of rays that pass the points (n, 3) behind a sequence of windows.

        They are NaN where neighbouring rays pass the point too: then the eye sees it in no certain direction.
        """
        _, normal = self._follow(sequence, starts)
        right = np.cross(normal, np.eye(3)[abs(normal).argmin(-1)])
        right /= np.linalg.norm(right, axis=-1, keepdims=True)
        up = np.cross(right, normal)

        def miss(position: Complexes, target: Indices) -> Complexes:
            """Return where rays cross a plane through the point, seen from the point."""
            p, d = (x.reshape(*position.shape, 3) for x in self._follow(sequence, position.ravel()))
            off = p - points[target]
            along = (off * normal[target]).sum(-1) / (d * normal[target]).sum(-1)
            off = off - along[..., None] * d
            return np.asarray((off * right[target]).sum(-1) + 1j * (off * up[target]).sum(-1))

        far, every = np.linalg.norm(points - self.view.eye, axis=-1), np.arange(len(starts))
        made, _ = nearest_rays(starts, every, miss, 1e-13 * far)
        step = 1e-4 * (1 + abs(made))
        a, b = (miss(made + way * step, every) - miss(made, every) for way in (1, 1j))
        size = abs(a) ** 2 + abs(b) ** 2
        alone = (abs((a.conj() * b).imag) > 1e-9 * size) & (size > (_PRECISION * far) ** 2)
        return np.where(alone, made, np.nan)

    def _follow(self, sequence: Sequence[int], positions: Complexes) -> tuple[Floats, Floats]:
        """Return rays through positions (n,) behind a sequence of windows, as if these had no edges."""
        rays = self.view.through(positions)
        position, direction = rays.position, rays.direction
        for w in sequence:
            position, direction = self.cross(w, position, direction, framed=False)
        return position, direction

    def _verified(
        self, sequence: Sequence[int], points: Floats, positions: Complexes
    ) -> Iterator[tuple[int, complex, Floats]]:
        """Yield which rays pass this sequence and then their points, with positions and corners."""
        legs = self.walk(self.view.through(positions), len(sequence))
        for n, point in enumerate(points):
            met = [int(leg.window[n]) for leg in legs[: len(sequence)]]
            if met != [*sequence] or len(legs) <= len(sequence):
                continue
            start, direction, length, _ = (part[n] for part in legs[len(sequence)])
            to = point - start
            enough = _PRECISION * np.linalg.norm(point - legs[0].start[n])
            least = -enough if sequence else 0  # a point on a sheet is behind it
            if np.linalg.norm(np.cross(to, direction)) <= enough and least < to @ direction < length - enough:
                corners = [leg.start[n] for leg in legs[: len(sequence) + 1]]
                yield n, complex(positions[n]), np.stack([*corners, point])


def _closest(off: Floats, net: Complexes) -> tuple[Indices, Complexes]:
    """Return for each point those rays of a net (m,) that pass it most closely, and are not near each other.

    `off` (n, m) are the distances from the points. The result is the number of the point, and the ray's position.
    """
    apart = 0.2 * max(np.ptp(net.real), np.ptp(net.imag))
    found: list[tuple[int, complex]] = []
    for n, row in enumerate(off):
        for _ in range(STARTS if np.isfinite(row).any() else 0):
            found.append((n, net[best := np.argmin(row)]))
            row[abs(net - net[best]) <= apart] = np.inf
            if not np.isfinite(row).any():
                break
    return np.array([n for n, _ in found], int), np.array([position for _, position in found], complex)


def _both_ways(matrix: Floats | None) -> tuple[Floats, Floats] | None:
    """Return the matrix of a sheet, and that of its paths backwards, NaN if there are none."""
    if matrix is None or not np.isfinite(matrix).all():
        return None
    back = np.linalg.inv(matrix) if np.linalg.cond(matrix) < 1e12 else np.full(matrix.shape, np.nan)
    return matrix, np.asarray(back, float)
