"""Where methods fail: maps of error and loss, and the limits read off them, `povgen verify --stability`.

Each map measures scenes of `instruments` and holds a table, which `charts` draws. A limit is the abscissa up to which
(or from which on) the ordinate keeps below a tolerance; it is measured beside the one that is in force in `limits`.
"""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, degrees, radians, sqrt

import numpy as np

from povgen.measure import probes
from povgen.measure.probes import Directions, Positions
from povgen.measure.verify import SMALL, Measured, fractions, located, px, rms, transverse
from povgen.optics import rotation
from povgen.optics.trace import End
from povgen.scene.limits import (
    GAP_RANGE,
    MAX_CAMERA_ERROR,
    MAX_CONDITION,
    MAX_CORRECTION,
    MAX_FACES,
    MAX_LOST_FRACTION,
    MAX_PRISMS,
    MIN_ALPHA,
    MIN_DESIGNED_FRACTION,
    MIN_PIXELS_PER_PRISM,
)
from povgen.scene.models import Chess
from povgen.scene.prediction import camera_cells, grid_error, max_trace_level, survey, warnings

TINY = (320, 240)
CONDITIONS = tuple(10.0 ** np.arange(0.5, 7.5, 0.5))
RENDERED = ", by POV-Ray"  # ends the name of a series beside the one that the exact ray trace makes


@dataclass
class Map:
    """Ordinates over an abscissa, in series: rows of (series, abscissa, ordinate), in the order of measuring.

    `most` is the tolerance that a limit keeps the ordinate below; `logs` names the axes, of 'xy', that are logarithmic.
    """

    name: str
    title: str
    x: str
    y: str
    most: float
    logs: str
    rows: list[tuple[str, float, float]] = dataclasses.field(default_factory=list)
    limits: list[Measured] = dataclasses.field(default_factory=list)

    def add(self, series: str, x: float, y: float) -> None:
        """A row."""
        self.rows.append((series, float(x), float(y)))

    def limit(self, sheet: str, series: str, in_force: float, unit: str = "", *, rising: bool = True) -> None:
        """Measure how far a series keeps below `most`: up to where if it is rising, else from where on.

        Interpolated between abscissas, or their logarithms; NaN, which fails, where it keeps below `most` nowhere.
        """
        points = sorted(((x, y) for name, x, y in self.rows if name == series), reverse=not rising)
        found = points[0][0] if points[0][1] <= self.most else np.nan
        for (x0, y0), (x1, y1) in pairwise(points):
            if not y0 <= self.most:
                break
            if y1 <= self.most:
                found = x1
            elif y1 > self.most and "x" in self.logs:
                found = x0 * (x1 / x0) ** ((self.most - y0) / (y1 - y0))
            elif y1 > self.most:
                found = x0 + (x1 - x0) * (self.most - y0) / (y1 - y0)
        self.limits.append(Measured(sheet, f"{self.title}: {series}", found, in_force, unit, least=rising))


def pole(conditions=CONDITIONS, size=TINY) -> Iterator[Map]:
    """(a) Measured against predicted position as alpha -> 180 deg and as z1 -> z2, by the condition number of P."""
    x, y = "condition number |1 − P|", "error of position (px)"
    map = Map("pole", "(a) near the pole, ideal sheet", x, y, 1, "xy")
    for toward in ("α → 180°", "z1 → z2"):
        for series, E in ((f"eq. 7, {toward}", -0.2 + 0j), (f"eq. 7, {toward}, E = 8i", 8j)):
            for M, _, place, thin in _near_pole(toward, conditions, size, sheet="ideal", E=E):
                map.add(series, M, px(abs(place - thin)))
            map.limit("ideal", series, MAX_CONDITION)
    yield map


def prediction(conditions=(1, 1.5, 2, 3, 4, 6, 8), size=TINY) -> Iterator[Map]:
    """(a) What the paraxial prediction leaves of eq. 7's error: towards the pole, for few prisms, in a wide field."""
    x, y = "correction of eq. 7 (px)", "error of the paraxial prediction (px)"
    map = Map("prediction", "(a) prisms' size and the pole", x, y, 3, "xy")
    for toward in ("α → 180°", "z1 → z2"):
        for series, values in (
            (f"{toward}", {}),
            (f"{toward}, N = 25", {"prisms": 25}),
            (f"{toward}, wide field", {"z2": 3.6, "P": 0.6 - 0.6j}),
        ):
            for _, scene, place, thin in _near_pole(toward, conditions, size, sheet="detailed", **values):
                seen = scene.apparent_position(scene.L, scene.z1)
                map.add(series, px(abs(seen - thin)), px(abs(place - seen)))
            map.limit("detailed", series, MAX_CORRECTION, "px")
    yield map


def _near_pole(toward: str, conditions, size, z2=6.0, P=0.3 + 0.1j, E=-0.2 + 0j, **values):
    """Condition number, scene, where its object is seen and where eq. 7 has it, tiles: towards the pole."""
    scenes = []
    for M in conditions:
        # near the pole |1 - P| is 1/|alpha - pi|, or z2/|z2 - z1|
        angle = 180 - degrees(2 * np.arcsin(0.5 / M))
        alpha, z1 = (angle, z2) if toward[0] == "α" else (180.0, z2 - z2 / (M + 1))
        L = rotation.object_position(P, E, z1, z2, radians(alpha))
        extent = 0.3 / rotation.M(z2 / z1, radians(alpha))
        scenes.append(Positions(alpha=alpha, z1=z1, z2=z2, L=L, E=E, extent=extent, **values))
    for scene, seen in located(scenes, size):
        thin = rotation.apparent_position(scene.L, scene.E, scene.z1, scene.z2, radians(scene.alpha))
        yield rotation.condition(scene.z2 / scene.z1, radians(scene.alpha)), scene, seen.place, thin


def prism_count(counts=(300, 1000, 3000, 10000, 30000), size=SMALL) -> Iterator[Map]:
    """(b) Rays on the designed path that leave in a direction that the exact ray trace does not give: the leak."""
    map = Map("prisms", "(b) prism count", "prisms N", "pixels on the designed path that are wrong (%)", 0.01, "xy")
    for count in counts:
        wrong = [_wrong(Directions(sheet="detailed", prisms=count, alpha=alpha), size)[0] for alpha in (20, 66, 120)]
        map.add("leak", count, 100 * float(np.mean(wrong)))
    map.limit("detailed", "leak", MAX_PRISMS)
    yield map


def gap_width(gaps=(1e-6, 1e-5, 3e-5, 6e-5, 1e-4, 1e-3, 1e-2, 0.09, 0.2), size=TINY) -> Iterator[Map]:
    """(c) Stray pixels that POV-Ray gets wrong where gaps are narrow; light lost to gaps where they are wide."""
    narrow = Map("gap", "(c) air gap, narrow", "gap / pitch", "stray pixels that are wrong (%)", 0.5, "x")
    wide = Map("gap-wide", "(c) air gap, wide", "gap / pitch", "pixels on the designed path lost to it (%)", 3, "x")
    for count in (100, 1000):
        found = [_wrong(Directions(sheet="detailed", gap=gap, prisms=count), size) for gap in gaps]
        for gap, (_, designed, stray) in zip(gaps, found, strict=True):
            narrow.add(f"N = {count}", gap, 100 * stray)
            wide.add(f"N = {count}", gap, 100 * (1 - designed / found[0][1]))
        narrow.limit("detailed", f"N = {count}", GAP_RANGE[0], rising=False)
        wide.limit("detailed", f"N = {count}", GAP_RANGE[1])
    yield narrow
    yield wide


def _wrong(scene: Directions, size) -> tuple[float, float, float]:
    """Fractions: of pixels on the designed path that are wrong; of pixels on it; of stray pixels that are wrong."""
    inside, direction = probes.rays(scene, size)
    found = probes.traced(scene, direction, max_trace_level(scene))
    (told,) = probes.frames([scene], size)
    wrong = ~(np.linalg.norm(told[inside] - found.direction, axis=1) < 1e-3)
    stray = (found.end <= End.BACK) & (found.count < max_trace_level(scene)) & ~found.designed
    return wrong[found.designed].mean(), found.designed.mean(), wrong[stray].mean()


def trace_level(size=TINY) -> Iterator[Map]:
    """(d) Pixels of the window that stay black though their light comes through: the ray trace, and POV-Ray beside it.

    The limit is the level that povgen takes for the scene.
    """
    map = Map("trace-level", "(d) max_trace_level", "max_trace_level", "lost pixels (%)", 100 * MAX_LOST_FRACTION, "")
    levels = np.arange(5, MAX_FACES)
    for series, scene in (
        ("z2 = 2", Directions(sheet="detailed", z2=2)),
        ("z2 = 6", Directions(sheet="detailed")),
        ("z2 = 6, α = 150°", Directions(sheet="detailed", alpha=150)),
        ("z2 = 6, N = 1000", Directions(sheet="detailed", prisms=1000)),
        ("z2 = 6, E = 3i", Directions(sheet="detailed", E=3j)),
        ("z2 = 1.5, E = 5.1i, N = 1059", Directions(sheet="detailed", z2=1.5, E=5.1j, alpha=50, prisms=1059)),
        ("z2 = 0.92, E = 8.2i, N = 678", Directions(sheet="detailed", z2=0.92, E=8.2j, alpha=-71, prisms=678)),
        ("z2 = 60", Directions(sheet="detailed", z2=60)),
        ("z2 = 60, E = 8i", Directions(sheet="detailed", z2=60, E=8j)),
        ("single, z2 = 2", Directions(sheet="single", z2=2)),
    ):
        inside, direction = probes.rays(scene, size)
        found = probes.traced(scene, direction, 255)
        leaves = found.end != End.FRAME  # those that the ray trace gives up would leave as well
        for level in levels:
            map.add(series, int(level), 100 * float((leaves & (found.count >= level)).mean()))
        scenes = [scene.model_copy(update={"trace_level": level}) for level in (7, 15, max_trace_level(scene))]
        for other, told in zip(scenes, probes.frames(scenes, size), strict=True):
            black = np.isnan(told[inside][:, 0]) & leaves
            map.add(series + RENDERED, max_trace_level(other), 100 * black.mean())
        map.limit(scene.sheet, series, max_trace_level(scene), rising=False)
    yield map


def field_angle(distances=(0.5, 0.7, 1, 1.5, 2, 3, 4, 6, 9, 15, 30, 60, 150), size=SMALL) -> Iterator[Map]:
    """(e) Pixels that show no rotated light, by field angle; and those of a whole window, by the eye's distance."""
    y, most = (
        "pixels without rotated light (%)",
        100 * (1 - MIN_DESIGNED_FRACTION) + 1,
    )  # one for the sample that povgen warns by
    angles = Map("field", "(e) field angle", "field angle (degrees)", y, most, "")
    for alpha, angle, rendered, exact in fractions((0, 66, 120, 180), size, z2=0.7):
        angles.add(f"α = {alpha:g}°", angle, 100 * (1 - exact))
        angles.add(f"α = {alpha:g}°{RENDERED}", angle, 100 * (1 - rendered))
    yield angles
    distance = Map("distance", "(e) distance of the eye", "z2 (tiles)", y, most, "x")
    for z2 in distances:
        for alpha in (0, 66, 120, 180):
            scene = Directions(sheet="detailed", alpha=alpha, z2=z2)
            distance.add(f"α = {alpha}°", z2, 100 * (1 - survey(scene, 150).designed))
    for alpha in (0, 66, 120, 180):
        near = next(z2 for z2 in np.arange(0.5, 9, 0.1) if not _warned(alpha, z2))
        distance.limit("detailed", f"α = {alpha}°", near, "tiles", rising=False)
    yield distance


def _warned(alpha: float, z2: float) -> bool:
    return any(name == "z2" for name, _ in warnings(Directions(sheet="detailed", alpha=alpha, z2=z2)))


ASIDE = (  # z2, E, alpha, z1/z2: wide fields, eyes far aside, near the pole, objects far off
    (20, 0.5 - 0.5j, 66, 1),
    (6, 3 - 1j, 66, 1),
    (6, 8.6j, 162.5, 1),
    (6, 8.6j, -170, 1.1),
    (2, 0.5 - 0.5j, 66, 1),
    (2, 8.6j, 120, 1),
    (1, 0.5 - 0.5j, 0, 30),
    (60, 8.6j, 150, 0.8),
)


def grid(scenes=ASIDE, size=TINY) -> Iterator[Map]:
    """(f) The ideal sheet's camera off the axis: the error of what is seen, over the most that it should be."""
    x = "the most that the error should be (px)"
    # 0.011 px of it are the 16 bits that tell the place
    map = Map(
        "grid", "(f) cells of the ideal camera", x, "worst error of position (px)", MAX_CAMERA_ERROR + 0.011, "xy"
    )
    place = probes.pixels(size)
    for z2, E, alpha, ratio in scenes:
        z1 = ratio * z2
        seen = rotation.one_minus_P(1 / ratio, radians(alpha))
        # the square lies across the whole window
        values = {"E": E, "L": rotation.object_position(0, E, z1, z2, radians(alpha)), "extent": 2 / abs(seen)}
        values |= {"sheet": "ideal", "alpha": alpha, "z1": z1, "z2": z2}
        enough = ceil(sqrt(grid_error(Positions(**values), 1) / MAX_CAMERA_ERROR))
        cut = [Positions(**values, grid=max(1, enough // part)) for part in (8, 4, 2, 1)]
        for scene, told in zip(cut, probes.frames(cut, size), strict=True):
            inside, _ = probes.rays(scene, size)
            inside &= ~np.isnan(told[..., 0])
            predicted = scene.E + (transverse(told[inside]) + scene.L - scene.E) * seen
            error = abs(predicted - place[inside]).max(initial=0)
            series = f"z2 = {z2:g}, E = {E.real:g}{E.imag:+g}i, α = {alpha:g}°"
            map.add(series, grid_error(scene, camera_cells(scene)), px(error) if inside.sum() > 100 else np.nan)
        map.limit("ideal", series, MAX_CAMERA_ERROR, "px")
    yield map


def aliasing(counts=(12, 25, 50, 75, 100, 150, 300), size=TINY) -> Iterator[Map]:
    """(g) Error of a picture without antialiasing, by the pitch of the prisms in pixels; and that of 12x12 blocks.

    Where the pixels resolve no prism, their error is that of a sample at random; it grows no more.
    """
    from povgen.video.still import render

    map = Map("aliasing", "(g) aliasing", "pixels per prism", "RMS error of the picture (1: white)", 0.21, "x")
    width = Chess.window / Chess.view_height * size[1]
    for count in counts:
        scene = Chess(prisms=count, z1=3)
        window = probes.window(scene, size)
        coarse, fine = (render(scene, size=size, antialias=to)[window] / 255 for to in ("off", "1,0.001,4"))
        off = coarse - fine
        map.add("pixels", width / count, rms(off))
        map.add("blocks of 12x12 pixels", width / count, rms(_blocks(off, 12)))
    map.limit("detailed", "pixels", MIN_PIXELS_PER_PRISM, "px", rising=False)
    yield map


def moire(alphas=(0, 0.3, 1, 2, 3, 5, 8, 15, 30), size=SMALL) -> Iterator[Map]:
    """(h) Moire of nearly parallel sheets: how far blocks of pixels differ in their share on the designed path."""
    map = Map("moire", "(h) sheets nearly parallel", "α (degrees)", "contrast over that at 30°", 1.35, "")
    for count in (50, 100, 400):
        contrast = []
        for alpha in alphas:
            scene = Directions(sheet="detailed", alpha=alpha, prisms=count)
            inside, direction = probes.rays(scene, size)
            designed = np.zeros(inside.shape)
            designed[inside] = probes.traced(scene, direction).designed
            blocks = _blocks(designed[probes.window(scene, size)][6:-6, 6:-6], 24)
            # of neighbours, for the slow fall towards the edges does not count
            contrast.append(rms(np.diff(blocks, axis=0)))
        for alpha, value in zip(alphas, contrast, strict=True):
            map.add(f"N = {count}", alpha, value / contrast[-1])
        map.limit("detailed", f"N = {count}", MIN_ALPHA, "deg", rising=False)
    yield map


def _blocks(picture: np.ndarray, n: int) -> np.ndarray:
    """Means of n x n pixels."""
    h, w = picture.shape[0] // n, picture.shape[1] // n
    return picture[: h * n, : w * n].reshape(h, n, w, n, *picture.shape[2:]).mean((1, 3))


def maps(sheet: str | None = None) -> Iterator[Map]:
    """All maps, one after the other, or those of one sheet model: 'ideal' or 'detailed'."""
    if sheet != "detailed":
        yield from pole()
        yield from grid()
    if sheet != "ideal":
        for measure in (prediction, prism_count, gap_width, trace_level, field_angle, aliasing, moire):
            yield from measure()
