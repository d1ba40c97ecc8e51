"""Where methods fail: `povgen verify --stability` measures the stability maps, (a) to (h), and their limits."""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from copy import deepcopy
from math import ceil, degrees, radians, sqrt

import numpy as np

from povgen import limits
from povgen.measure import probes
from povgen.measure.compare import fractions, window_rays
from povgen.measure.measured import SMALL, px, rms
from povgen.measure.probes import Directions, Floats, Positions, Size
from povgen.measure.stability_map import RENDERED, RESOLUTION, StabilityMap
from povgen.measure.targets import located, transverse
from povgen.optics import equations
from povgen.optics.trace import End
from povgen.scene import camera
from povgen.scene.cells import camera_cells, grid_error
from povgen.scene.eye_and_windows import APERTURE, VIEW
from povgen.scene.presets import Chess
from povgen.scene.survey import max_trace_level, survey
from povgen.scene.warnings import possible_error, warnings
from povgen.video.still import render

TINY = (320, 240)
ALPHAS = (0, 66, 120, 180)  # degrees
TOWARD_POLE = ("α → 180°", "z1 → z2")  # two ways to approach the pole, where the object appears at infinity
GAP = "air gap between prisms / pitch"
LOST, DARK = 100 * limits.MAX_LOST_FRACTION, 100 * (1 - limits.MIN_DESIGNED_FRACTION)
MAPS = {made.name: made for made in (  # without rows
    StabilityMap(
        "pole", "(a) near the pole, ideal sheet", "magnification of what is seen",
        "error of the position (px)", 1, "xy",
        finding="(a) Near the pole the error of ideal sheets grows",
        band=("right", limits.MAX_CONDITION, "povgen warns, a factor of\n3 before the lower limit"),
    ),
    StabilityMap(
        "grid", "(f) cells of the ideal camera", "error that povgen states (px)", "worst error (px)",
        limits.MAX_CAMERA_ERROR + RESOLUTION, "xy", is_estimate=True,
        finding="(f) Ideal camera, eye off the axis (8 scenes): up to 0.036 px where 0.03 px is stated",
        band=("right", limits.MAX_CAMERA_ERROR, "povgen takes finer cells"),
        groups={"": "solid: the cells\nthat povgen takes"},
    ),
    StabilityMap(
        "prediction", "(a) prisms' size and the pole", "error that povgen states as possible (px)",
        "error of the predicted position (px)", limits.MAX_ERROR, "xy", is_estimate=True,
        finding="(a) Without a warning, 4 of 14 errors are greater than stated, up to 1.7 times",
        band=("right", limits.MAX_ERROR, "povgen warns"),
        groups={
            "N = 25": "N = 25, 5° off the axis",
            "16°": "N = 100, 16° off the axis",
            "": "N = 100, 5° off the axis",
        },
    ),
    StabilityMap(
        "prisms", "(b) prism count", "prisms N of a sheet", "pixels with designed light that are wrong (%)", 0.01, "xy",
        finding="(b) The more prisms, the more rays POV-Ray gets wrong",
        band=("right", limits.MAX_PRISMS, "povgen refuses"),
    ),
    StabilityMap(
        "gap", "(c) air gap, narrow", GAP, "pixels with stray light that are wrong (%)", 0.5, "x",
        finding="(c) POV-Ray misses narrow air gaps between fine prisms",
        band=("left", limits.MIN_GAP, "povgen refuses"), ends=(-1, 28),
    ),
    StabilityMap(
        "gap-wide", "(c) air gap, wide", GAP, "designed light lost (%), compared with gap / pitch = 10⁻⁶", 3, "x",
        finding=f"(c) Up to {limits.WIDE_GAP:g} of the pitch, an air gap loses little light",
        band=("right", limits.WIDE_GAP, "more is lost;\nrefused\nabove 0.5"),
        groups={"N": "N = 100, 1000 and 3000: mean (below 0: more light)"},
    ),
    StabilityMap(
        "trace-level", "(d) max_trace_level", "max_trace_level: faces that a ray may meet", "lost pixels (%)",
        LOST, "xy",
        finding="(d) At povgen's level at most 4 % of pixels are lost",
        band=("above", LOST, f"more than {LOST:g} % are lost"), dot="dots: povgen's level", ends=(0.5, 150),
    ),
    StabilityMap(
        "field", "(e) field angle", "field angle: of the line of sight to the axis (degrees)",
        "pixels without light turned by α (%)", 50,
        finding="(e) Beyond 12° off the axis, over half of the pixels lack light turned by α",
        band=("above", 50, "over half"), ends=(0, 100),
        groups={"α": "α = 0°, 66°, 120° and 180°:\nmean and range"},
    ),
    StabilityMap(  # 1 % more than where povgen warns, because the warning uses only a sample of rays
        "distance", "(e) distance of the eye", "z2: from the sheets to the eye (tiles)",
        "pixels without designed light (%)", DARK + 1, "x",
        finding=f"(e) The nearer the eye, the more pixels lack designed light (window of {probes.APERTURE:g} tiles)",
        band=("above", DARK, "povgen warns"), ends=(0, 105),
        groups={"120|180": "α = 120° and 180°: mean"},
    ),
    StabilityMap(
        "aliasing", "(g) aliasing", "pixels per prism", "RMS error, one ray a pixel (1: white)", 0.21, "x",
        finding="(g) Without antialiasing: the narrower the prisms, the noisier the picture",
        band=("left", limits.MIN_PIXELS_PER_PRISM, "povgen warns:\nabout one ray\na prism, or less"),
    ),
    StabilityMap(
        "moire", "(h) ridges nearly parallel", "α N: angle by which rays turn, times the prisms in a sheet (degrees)",
        "contrast of dark bands / their contrast at α = 30°", 1.35,
        finding="(h) From αN = 800° on, dark bands are weak",
        band=("left", limits.MOIRE, "povgen warns\n(at 0 the bands are as wide as the window)"), ends=(0.8, 2.5),
    ),
)}  # fmt: skip
CONDITION_NUMBERS = tuple(float(10**exponent) for exponent in np.arange(0.5, 5, 0.5))


def pole(conditions: Sequence[float] = CONDITION_NUMBERS, size: Size = TINY) -> Iterator[StabilityMap]:
    """(a) Measure the error of eq. 7 for alpha -> 180 deg and for z1 -> z2, against the condition number of P."""
    result = deepcopy(MAPS["pole"])
    for series, E in (("eye near the axis", -0.2 + 0j), ("eye 8 tiles up", 8j)):
        ways = [_near_pole(toward, conditions, size, "ideal", E=E) for toward in TOWARD_POLE]
        for each in zip(*ways, strict=True):
            errors = [px(abs(place - thin)) for *_, place, thin in each]
            result.add(series, min(M for M, *_ in each), float(np.max(errors)))  # NaN, if one of them is
        result.limit("ideal", series, limits.MAX_CONDITION)
    yield result


def prediction(conditions: Sequence[float] = (1, 1.5, 2, 3, 4, 6, 8), size: Size = TINY) -> Iterator[StabilityMap]:
    """(a) Measure the error of the paraxial prediction: near the pole, for few prisms, and off the axis."""
    result = deepcopy(MAPS["prediction"])
    for toward in TOWARD_POLE:
        for series, prisms, z2, P in (
            (toward, 100, 6.0, 0.3 + 0.1j),
            (f"{toward}, N = 25", 25, 6.0, 0.3 + 0.1j),
            (f"{toward}, 16° off the axis", 100, 3.6, 0.6 - 0.6j),
        ):
            for _, scene, place, _ in _near_pole(toward, conditions, size, "detailed", z2=z2, P=P, prisms=prisms):
                off = abs(place - scene.apparent_position(scene.L, scene.z1))
                result.add(series, possible_error(scene, scene.L, scene.z1, scene.extent), px(off))
            result.limit("detailed", series, limits.MAX_ERROR, "px")
    yield result


def _near_pole(
    toward: str,
    conditions: Sequence[float],
    size: Size,
    sheet: str,
    z2: float = 6.0,
    P: complex = 0.3 + 0.1j,
    E: complex = -0.2 + 0j,
    prisms: int = 100,
) -> Iterator[tuple[float, Positions, complex, complex]]:
    """Yield the condition number, the scene, and its object's apparent position in tiles: as measured, and by eq. 7.

    `toward` says how the scenes approach the pole.
    """
    scenes = []
    for M in conditions:
        # near the pole |1 - P| is 1/|alpha - pi|, or z2/|z2 - z1|
        angle = 180 - degrees(2 * np.arcsin(0.5 / M))
        alpha, z1 = (angle, z2) if toward[0] == "α" else (180.0, z2 - z2 / (M + 1))
        L = equations.object_position(P, E, z1, z2, radians(alpha))
        extent = 0.3 / equations.M(z2 / z1, radians(alpha))
        scenes.append(Positions(sheet=sheet, prisms=prisms, alpha=alpha, z1=z1, z2=z2, L=L, eye=E, extent=extent))
    for scene, seen in located(scenes, size):
        thin = equations.apparent_position(scene.L, scene.E, scene.z1, scene.z2, radians(scene.alpha))
        yield equations.condition(scene.z2 / scene.z1, radians(scene.alpha)), scene, seen.position, thin


def prism_count(counts: Sequence[int] = (300, 1000, 3000, 10000, 30000), size: Size = SMALL) -> Iterator[StabilityMap]:
    """(b) Measure how many pixels on the designed path are wrong: POV-Ray's direction is not that of the ray trace."""
    result = deepcopy(MAPS["prisms"])
    for count in counts:
        wrong = [_wrong(Directions(sheet="detailed", prisms=count, alpha=alpha), size)[0] for alpha in (20, 66, 120)]
        result.add("wrong pixels", count, 100 * float(np.mean(wrong)))
    result.limit("detailed", "wrong pixels", limits.MAX_PRISMS)
    yield result


def gap_width(
    gaps: Sequence[float] = (1e-6, 1e-5, 3e-5, 6e-5, 1e-4, 1e-3, 1e-2, 0.03, 0.06, 0.09, 0.13, 0.2), size: Size = TINY
) -> Iterator[StabilityMap]:
    """(c) Measure how many pixels of stray light are wrong if gaps are narrow, and how much light wide gaps lose."""
    narrow, wide = deepcopy((MAPS["gap"], MAPS["gap-wide"]))
    for count in (100, 1000, limits.MAX_PRISMS):
        found = [_wrong(Directions(sheet="detailed", gap=gap, prisms=count), size) for gap in gaps]
        for gap, (_, designed, stray) in zip(gaps, found, strict=True):
            narrow.add(f"N = {count}", gap, 100 * stray)
            if gap >= limits.MIN_GAP:
                wide.add(f"N = {count}", gap, 100 * (1 - designed / found[0][1]))
        narrow.limit("detailed", f"N = {count}", limits.MIN_GAP, rising=False)
        wide.limit("detailed", f"N = {count}", limits.WIDE_GAP)
    yield narrow
    yield wide


def _wrong(scene: Directions, size: Size) -> tuple[float, float, float]:
    """Return three fractions: wrong among designed pixels, designed among all pixels, wrong among stray pixels.

    Designed pixels show light on the designed path. Stray pixels show other light.
    """
    rays, (decoded,) = window_rays(scene, size), probes.decoded([scene], size)
    wrong = ~(np.linalg.norm(decoded[rays.inside] - rays.traced.direction, axis=1) < 1e-3)
    designed = rays.traced.designed
    return wrong[designed].mean(), designed.mean(), wrong[rays.leaves & ~designed].mean()


def trace_level(size: Size = TINY) -> Iterator[StabilityMap]:
    """(d) Measure lost pixels, by the exact ray trace and by POV-Ray: they stay black although light reaches them.

    The limit that povgen uses is the trace level that it sets for the scene.
    """
    result = deepcopy(MAPS["trace-level"])
    levels = np.arange(5, limits.MAX_FACES)
    for given in (
        {"z2": 2},
        {},
        {"alpha": 150},
        {"prisms": 1000},
        {"eye": 3j},
        {"z2": 1.5, "eye": 5.1j, "alpha": 50, "prisms": 1059},
        {"z2": 0.92, "eye": 8.2j, "alpha": -71, "prisms": 678},
        {"z2": 60},
        {"z2": 60, "eye": 8j},
        {"z2": 2, "sheet": "single"},
    ):
        scene = Directions(**{"sheet": "detailed", **given})
        series = f"eye {scene.z2:g} tiles away, {scene.E.imag:g} up, N = {scene.prisms}, α = {scene.alpha:g}°"
        series += "" if scene.rotates else ", 1 sheet"
        inside, direction = camera.rays(scene, size)
        found = scene.trace(scene.camera.along(direction), 255)
        leaves = found.end != End.FRAME  # rays that the trace does not finish count as leaving
        for level in levels:
            result.add(series, int(level), 100 * float((leaves & (found.count >= level)).mean()))
        scenes = [scene.model_copy(update={"trace_level": level}) for level in (7, 15, max_trace_level(scene))]
        for other, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
            black = np.isnan(decoded[inside][:, 0]) & leaves
            result.add(series + RENDERED, max_trace_level(other), 100 * black.mean())
        result.limit(scene.sheet, series, max_trace_level(scene), rising=False)
    yield result


def field_angle(
    distances: Sequence[float] = (0.5, 0.7, 1, 1.5, 2, 3, 4, 6, 9, 15, 30, 60, 150), size: Size = SMALL
) -> Iterator[StabilityMap]:
    """(e) Measure pixels without light turned by alpha at field angles, and those without designed light at z2."""
    angles, distance = deepcopy((MAPS["field"], MAPS["distance"]))
    near = [Directions(sheet="detailed", alpha=alpha, z2=0.7) for alpha in ALPHAS]
    for alpha, angle, rendered, exact in fractions(near, size):
        angles.add(f"α = {alpha:g}°", angle, 100 * (1 - exact))
        angles.add(f"α = {alpha:g}°{RENDERED}", angle, 100 * (1 - rendered))
    yield angles
    for alpha in ALPHAS:
        for z2 in distances:
            scene = Directions(sheet="detailed", alpha=alpha, z2=z2)
            distance.add(f"α = {alpha}°", z2, 100 * (1 - survey(scene, 150).designed))
        distance.limit("detailed", f"α = {alpha}°", _nearest_without_warning(alpha), "tiles", rising=False)
    yield distance


def _nearest_without_warning(alpha: float) -> float:
    """Return the eye's least distance, in steps of 0.1 tiles, at which povgen does not warn of z2."""

    def quiet(z2: float) -> bool:
        scene = Directions(sheet="detailed", alpha=alpha, z2=z2)
        return all(name != "z2" for name, _ in warnings(scene))

    distances = np.arange(0.5, 9, 0.1)
    return float(distances[bisect_left(distances, True, key=quiet)])


# z2, E, alpha, z1/z2: wide fields, eyes far from the axis, scenes near the pole, distant objects
OFF_AXIS: tuple[tuple[float, complex, float, float], ...] = (
    (20, 0.5 - 0.5j, 66, 1),
    (6, 3 - 1j, 66, 1),
    (6, 8.6j, 162.5, 1),
    (6, 8.6j, -170, 1.1),
    (2, 0.5 - 0.5j, 66, 1),
    (2, 8.6j, 120, 1),
    (1, 0.5 - 0.5j, 0, 30),
    (60, 8.6j, 150, 0.8),
)


def grid(scenes: Sequence[tuple[float, complex, float, float]] = OFF_AXIS, size: Size = TINY) -> Iterator[StabilityMap]:
    """(f) Measure the error of the ideal sheet's camera for an eye off the axis, against what povgen states."""
    result = deepcopy(MAPS["grid"])
    for z2, E, alpha, ratio in scenes:
        z1 = ratio * z2
        seen = equations.one_minus_P(1 / ratio, radians(alpha))
        # the square fills the whole window
        L = equations.object_position(0, E, z1, z2, radians(alpha))
        own = Positions(sheet="ideal", alpha=alpha, z1=z1, z2=z2, eye=E, L=L, extent=2 / abs(seen))
        enough = ceil(sqrt(grid_error(own, 1) / limits.MAX_CAMERA_ERROR))
        coarser = [own.model_copy(update={"grid": max(1, enough // part)}) for part in (8, 4, 2, 1)]
        for scene, decoded in zip(coarser, probes.decoded(coarser, size), strict=True):
            place = scene.camera.pixels(size)
            inside, _ = camera.rays(scene, size)
            inside &= ~np.isnan(decoded[..., 0])
            predicted = scene.E + (transverse(decoded[inside]) + scene.L - scene.E) * seen
            error = abs(predicted - place[inside]).max(initial=0)
            series = f"z2 = {z2:g}, eye at ({E.real:g}, {E.imag:g}), α = {alpha:g}°"
            result.add(series, grid_error(scene, camera_cells(scene)), px(error) if inside.sum() > 100 else np.nan)
        result.limit("ideal", series, limits.MAX_CAMERA_ERROR, "px")
    yield result


def aliasing(counts: Sequence[int] = (12, 25, 50, 75, 100, 150, 300), size: Size = TINY) -> Iterator[StabilityMap]:
    """(g) Measure the errors of pixels and of means of 12x12 pixels, without antialiasing, against the prisms' width.

    If prisms are narrower than pixels, each pixel shows a random ray, and its error does not grow any more.
    """
    result = deepcopy(MAPS["aliasing"])
    width = APERTURE / VIEW * size[1]
    for count in counts:
        scene = Chess(prisms=count, z1=3, view=VIEW)
        window = camera.window(scene, size)
        coarse, fine = (
            render(scene, size=size, antialias=antialias)[window] / 255 for antialias in ("off", "1,0.001,4")
        )
        off = coarse - fine
        result.add("single pixels", width / count, rms(off))
        result.add("means of 12x12 pixels", width / count, rms(_blocks(off, 12)))
    result.limit("detailed", "single pixels", limits.MIN_PIXELS_PER_PRISM, "px", rising=False)
    yield result


def moire(
    products: Sequence[float] = (0, 100, 300, 500, 700, 800, 900, 1200), size: Size = SMALL
) -> Iterator[StabilityMap]:
    """(h) Measure the contrast of the dark bands (moire) of nearly parallel ridges, against alpha times N.

    N is the number of prisms in a sheet, and alpha is in degrees. Nothing is rendered. For each block of 24x24 pixels,
    the ray trace gives the fraction of rays on the designed path. The contrast is the RMS difference of this fraction
    between neighbouring blocks, divided by that at alpha = 30 deg.
    """
    result = deepcopy(MAPS["moire"])
    for count in (50, 100, 400):
        contrast = []
        for product in (*products, 30 * count):
            scene = Directions(sheet="detailed", alpha=product / count, prisms=count)
            inside, direction = camera.rays(scene, size)
            designed = np.zeros(inside.shape)
            designed[inside] = scene.trace(scene.camera.along(direction)).designed
            blocks = _blocks(designed[camera.window(scene, size)][6:-6, 6:-6], 24)
            # only neighbours are compared, because the slow decrease towards the window's edges is not moire
            contrast.append(np.hypot(rms(np.diff(blocks, axis=0)), rms(np.diff(blocks, axis=1))))
        *contrast, reference = contrast
        for product, value in zip(products, contrast, strict=True):
            result.add(f"N = {count}", product, value / reference)
        result.limit("detailed", f"N = {count}", limits.MOIRE, "deg", rising=False)
    yield result


def _blocks(picture: Floats, n: int) -> Floats:
    """Return the means of n x n pixels."""
    h, w = picture.shape[0] // n, picture.shape[1] // n
    blocks: Floats = picture[: h * n, : w * n].reshape(h, n, w, n, *picture.shape[2:]).mean((1, 3))
    return blocks


def maps(sheet: str | None = None) -> Iterator[StabilityMap]:
    """Measure all maps, or only those of one model of the sheets: 'ideal' or 'detailed'."""
    if sheet != "detailed":
        yield from pole()
        yield from grid()
    if sheet != "ideal":
        for measure in (prediction, prism_count, gap_width, trace_level, field_angle, aliasing, moire):
            yield from measure()
