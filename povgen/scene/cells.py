"""The cells in which the camera that simulates ideal sheets interpolates rays (templates/camera/)."""

from math import ceil, hypot, inf, radians, sqrt
from typing import NamedTuple

import numpy as np

from povgen.limits import MAX_CAMERA_ERROR, MAX_CELLS
from povgen.optics import equations
from povgen.optics.equations import Complexes, Floats
from povgen.scene.presets import AxialScene

_CELLS = 16  # across the window, for the first estimate of the error
# With the template "law" and several windows: the least number of cells across the first window. With fewer, a
# further window could lie inside one cell and be missed.
_SERIES_CELLS = 24
JUMP = 0.1  # see `Jumps`


class Jumps(NamedTuple):
    """Where rays jump: the directions of neighbouring rays differ much. Lengths are in tiles.

    The ray of a point inside a triangle jumps if it ends farther from where interpolation says than `tolerance`, and
    than JUMP of the distances between the ends of the corners' rays.
    """

    share: float = 0.0  # of the cells in the window
    step: float = inf  # triangles with a jump are divided down to sides of this length; inf: they are not divided
    farthest: float = 0.0  # rays end at this distance behind the last ideal window
    tolerance: float = 0.0


def template(scene: AxialScene) -> str:
    """Return the name of the template of the camera that simulates the ideal windows.

    "": no ideal window has a sheet, and POV-Ray's own camera is used. "series": there are several ideal windows, and
    all only rotate light: the picture is divided into exact polygons. "law": all other cases. There, a triangle whose
    rays do not all pass the same windows is halved, again and again, until the parts are small.
    """
    if {sheet.name for sheet in scene.ideal} <= {"none"}:
        return ""
    return "series" if len(scene.ideal) > 1 and _rotates(scene) else "law"


def _rotates(scene: AxialScene) -> bool:
    """Whether all ideal windows only rotate light."""
    return all(sheet.rotates for sheet in scene.ideal)


def camera_cells(scene: AxialScene) -> int:
    """Return the number of cells across the window in which the ideal sheets' camera interpolates rays.

    It is the least number that keeps the error below MAX_CAMERA_ERROR, but at most MAX_CELLS. For laws that do not only
    rotate light the least number is only estimated (`_cells_of_laws`). A probe (a scene for measuring) can set the
    number with `grid`. See camera/law.pov.j2. If there is one window, which only rotates light, and the eye is on its
    axis, one cell is exact. With several windows one cell is not: the part of the first window that shows the second
    one is no rectangle.
    """
    grid: int | None = getattr(scene, "grid", None)
    if grid:
        return grid
    if not _rotates(scene):
        return MAX_CELLS if jumps(scene).share else _cells_of_laws(scene)
    return (
        ceil(min(MAX_CELLS, max(1, sqrt(grid_error(scene, 1) / MAX_CAMERA_ERROR))))
        if scene.E or len(scene.ideal) > 1
        else 1
    )


def grid_error(scene: AxialScene, cells: int) -> float:
    """Return the greatest error of an object's position in the ideal sheet's camera, in pixels of 1280x960.

    The windows only rotate light. The error is that of an eye off the axis, or of several windows; otherwise the
    interpolation is exact. POV-Ray interpolates between unit vectors at the corners of triangles. A ray then has the
    direction that belongs to another point, up to d^2 sin(2 field angle)/(8 z2) tiles away, for a triangle with the
    longest side d (docs/sheets.md). An object appears displaced by |z1/Z| times this distance, with Z of
    `equations.depth`. For one window |z1/Z| is |P| of eq. 7.
    """
    half = scene.aperture / 2
    x, y = abs(scene.E.real), abs(scene.E.imag)
    nearest, farthest = hypot(max(0, x - half), max(0, y - half)), hypot(x + half, y + half)
    tangent = min(max(1, nearest / scene.z2), farthest / scene.z2)  # sin(2 angle) is greatest at 45 degrees
    displaced = 2 * (scene.aperture / cells) ** 2 * 2 * tangent / (1 + tangent**2) / (8 * scene.z2)
    z1 = np.array(scene.distances)
    with np.errstate(divide="ignore"):
        P = z1 / abs(equations.depth(z1, scene.z2, radians(scene.alphas[0]), scene.behind))
    return displaced * float(P.max() if len(P) else 1) / scene.view * 960


def jumps(scene: AxialScene) -> Jumps:
    """Return where rays jump. Through windows that only rotate light no ray jumps.

    Where a law jumps, interpolation is as wrong in a small cell as in a large one. Here, MAX_CELLS cells across the
    window are tried. A cell also counts if a ray inside does not pass although those of all corners do, or passes
    although none of those does. Cells at the edge of a dark part do not count: POV-Ray's text divides them anyway.

    POV-Ray's text divides cells into some 100,000 triangles in half a minute; `step` follows from that. If more than a
    quarter of the cells count, they are not divided.
    """
    if _rotates(scene):
        return Jumps()

    farthest, tolerance = max(scene.distances, default=2 * scene.z2), 10 * MAX_CAMERA_ERROR * scene.view / 960

    def ends(P: Complexes) -> Floats:
        start, unit = _behind_points(scene, P)
        return np.stack((start.real, start.imag, 0 * start.real), -1) + farthest * unit

    step = scene.aperture / MAX_CELLS
    side = (np.arange(MAX_CELLS + 1) / MAX_CELLS - 0.5) * scene.aperture
    P = side + 1j * side[:, None]
    corners = ends(P)
    A, B = corners[:-1, :-1], corners[1:, 1:]
    jump = np.zeros((MAX_CELLS, MAX_CELLS), bool)
    for C, aside in ((corners[:-1, 1:], 1), (corners[1:, :-1], 1j)):
        inside = ends(P[:-1, :-1] + (0.3 * (1 + 1j) + 0.25 * aside) * step)
        off, AB, AC = (np.linalg.norm(v, axis=-1) for v in (0.45 * A + 0.3 * B + 0.25 * C - inside, B - A, C - A))
        lit = sum(np.isfinite(corner[..., 0]) for corner in (A, B, C))
        with np.errstate(invalid="ignore"):
            jump |= off > np.maximum(tolerance, JUMP * (AB + AC))
        jump |= np.where(np.isfinite(inside[..., 0]), lit == 0, lit == 3)
    # of a cell and its neighbours
    dark = np.lib.stride_tricks.sliding_window_view(np.pad(np.isnan(corners[..., 0]), 1, "edge"), (4, 4))
    jump &= dark.all((2, 3)) == dark.any((2, 3))
    share = float(jump.mean())
    return Jumps(share, scene.aperture * sqrt(share) / 160 if 0 < share < 0.25 else inf, farthest, tolerance)


def is_dark(scene: AxialScene) -> bool:
    """Whether no light passes the ideal windows."""
    return bool(np.isnan(_behind(scene, MAX_CELLS)[1]).all())


def _cells_of_laws(scene: AxialScene) -> int:
    """Return the cells across the window that keep the camera's error below MAX_CAMERA_ERROR, at most MAX_CELLS.

    The error is computed with 16 cells across the window. With n cells it falls as 1/n^2 if the law is smooth. If a law
    depends on the place, n grows until the error, computed again, is small enough. The error of a cell can be computed
    only if light passes at its middle and at all its corners. If there is no such cell, although light passes the
    windows somewhere, the result is MAX_CELLS. For several windows it is at least _SERIES_CELLS.
    """
    least = _SERIES_CELLS if len(scene.ideal) > 1 else 1
    if least == 1 and _is_exact(scene):
        return 1
    error = _law_error(scene, _CELLS)
    if np.isnan(error):
        return least if is_dark(scene) else MAX_CELLS
    cells = ceil(min(MAX_CELLS, max(1, _CELLS * sqrt(error / MAX_CAMERA_ERROR))))
    if any(sheet.law.uses_place for sheet in scene.ideal):
        while cells < MAX_CELLS and (error := _law_error(scene, cells)) > MAX_CAMERA_ERROR:
            cells = min(MAX_CELLS, max(cells + 1, ceil(cells * min(2, sqrt(error / MAX_CAMERA_ERROR)))))
    return max(least, cells)


def _is_exact(scene: AxialScene) -> bool:
    """Whether interpolation between the window's corners is exact."""
    start, unit = _behind(scene, 1)
    share = np.linspace(0.05, 0.95, 7)
    parts = np.array(np.meshgrid(share, share))
    low, high = parts.min(0), parts.max(0)
    # the third corner of the point's triangle: lower right (1) or upper left (0)
    corner = np.where(parts[0] > parts[1], 1, 0)
    weights = (1 - high), low, high - low
    place = (share[None, :] - 0.5 + 1j * (share[:, None] - 0.5)) * scene.aperture
    exact_start, exact = _behind_points(scene, place)
    third = np.where(corner[..., None], unit[0, 1], unit[1, 0])
    third_start = np.where(corner, start[0, 1], start[1, 0])
    shown = weights[0][..., None] * unit[0, 0] + weights[1][..., None] * unit[1, 1] + weights[2][..., None] * third
    shown_start = weights[0] * start[0, 0] + weights[1] * start[1, 1] + weights[2] * third_start
    with np.errstate(invalid="ignore", divide="ignore"):
        off = np.linalg.norm(shown / shown[..., 2:] - exact / exact[..., 2:], axis=-1)
    return bool((off < 1e-8).all() and (abs(shown_start - exact_start) < 1e-8).all())


def _law_error(scene: AxialScene, n: int) -> float:
    """Return the error of an object's position with n cells across the window, in pixels of 1280x960.

    It is computed in the middle of the cells' diagonals. Of all cells, the worst 2 % are left out. Of all objects, the
    one with the greatest error counts. NaN if there is no cell with light at its middle and at all of its corners.
    """
    step = scene.aperture / n
    with np.errstate(invalid="ignore", divide="ignore"):
        start, corners = _behind(scene, n)
        side = np.linspace(-0.5, 0.5, n + 1) * scene.aperture
        middle = (side[1:] + side[:-1]) / 2
        right_start, right = _behind_points(scene, middle + 1j * middle[:, None])
        shown = corners[:-1, :-1] + corners[1:, 1:]
        shown_start = (start[:-1, :-1] + start[1:, 1:]) / 2
        slope = corners[..., :2] / corners[..., 2:]
        places = np.stack((start.real, start.imag), -1)
        aside = (shown / shown[..., 2:] - right / right[..., 2:])[..., :2]
        away = np.stack(((shown_start - right_start).real, (shown_start - right_start).imag), -1)
        worst = 0.0
        for z1 in scene.distances or (2 * scene.z2,):
            # a lower bound of the smallest singular value of d(object)/d(apparent position)
            steps = [np.diff(places + z1 * slope, axis=axis)[:n, :n] / step for axis in (1, 0)]
            jacobian = np.stack(steps, -1)
            least = abs(np.linalg.det(jacobian)) / np.linalg.norm(jacobian, axis=(-2, -1))
            errors = np.linalg.norm(away + z1 * aside, axis=-1) / np.maximum(least, 0.02)
            errors = errors[~np.isnan(errors)]  # NaN: no light passes there
            if not len(errors):
                return float("nan")
            worst = max(worst, np.quantile(errors, 0.98, method="higher"))
    return worst / scene.view * 960


def _behind(scene: AxialScene, n: int) -> tuple[Complexes, Floats]:
    """Return where lines of sight through the corners of n x n cells of the first window go.

    The results are the lines' places (n + 1, n + 1), x + iy in tiles, at the last ideal window, and their unit
    directions (n + 1, n + 1, 3) behind it. NaN: no light passes.
    """
    side = np.linspace(-0.5, 0.5, n + 1) * scene.aperture
    return _behind_points(scene, side + 1j * side[:, None])


def _behind_points(scene: AxialScene, P: Complexes) -> tuple[Complexes, Floats]:
    """Return places and directions as `_behind` does, for lines of sight through the points P of the first window."""
    P = P + (1.1e-9 + 0.7e-9j)  # as in camera/law.pov.j2: a law may divide by 0 on a line of symmetry, such as X = 0
    view, z = P - scene.E, -scene.z2
    direction = np.stack(np.broadcast_arrays(view.real, view.imag, scene.z2), -1)
    place = scene.E + 0 * P
    with np.errstate(invalid="ignore", divide="ignore"):
        for there, sheet in zip(scene.places, scene.ideal, strict=False):
            place = place + (there - z) * (direction[..., 0] + 1j * direction[..., 1]) / direction[..., 2]
            direction, z = sheet.bend(direction, place), there
        return place, direction
