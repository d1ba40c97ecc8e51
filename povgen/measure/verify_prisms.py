"""Sheets of prisms, compared with the exact ray trace and with predictions."""

from collections.abc import Iterator, Sequence
from math import radians
from typing import Any

import numpy as np

from povgen.measure import probes
from povgen.measure.measured import SMALL, Measured, px, rms
from povgen.measure.probes import Directions, Floats, Positions, Size
from povgen.measure.rounding import decided_by_rounding
from povgen.measure.targets import located, targets
from povgen.optics import equations
from povgen.optics.trace import End
from povgen.scene import camera, survey


def every_pixel(
    prisms: tuple[int, ...] = (100, 1000),
    alphas: tuple[float, ...] = (0, 35, 90, 180),
    others: int = 16,
    size: Size = SMALL,
) -> Iterator[Measured]:
    """Compare the direction that every pixel shows with the exact ray trace, stray light included.

    `others` is the number of random scenes.
    """
    for count in prisms:
        scenes = [Directions(sheet="detailed", prisms=count, alpha=alpha) for alpha in alphas]
        yield from pixel_checks(f"2x{count}, {len(alphas)} alphas", scenes, size)
    if others:
        yield from pixel_checks(f"{others} scenes at random", any_window(others, seed=1), size)


def any_window(count: int, seed: int) -> list[Directions]:
    """Return random windows: 12 to 3000 prisms, all alphas, eyes 0.3 to 60 tiles away, half of them off the axis."""
    random = np.random.default_rng(seed)
    scenes = []
    for n in range(count):
        number = int(np.exp(random.uniform(np.log(12), np.log(3001))))
        E = (n % 2) * complex(random.uniform(-1, 1), random.uniform(-1.3, 8))
        farthest = Directions(prisms=number, z2=60, alpha=random.uniform(-180, 180), eye=E)
        nearest = max(0.3, farthest.depth / 2 + 0.05)
        scenes.append(farthest.model_copy(update={"z2": nearest * (60 / nearest) ** random.uniform()}))
    return scenes


def pixel_shares(scenes: list[Directions], size: Size) -> tuple[float, float, Floats]:
    """Return two shares, 0 to 1, of pixels that show the direction of the ray trace within 1e-3 rad, and an array.

    The first share is that of the rays on the designed path, the second that of all rays that leave. The array (rays,)
    says of each ray that leaves in another direction whether rounding decides its path.
    """
    designed, agree, by_rounding = [], [], []
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        inside, direction = camera.rays(scene, size)
        trace_level = survey.max_trace_level(scene)
        found = scene.trace(camera.along(scene, direction), trace_level)
        off = np.nan_to_num(np.linalg.norm(decoded[inside] - found.direction, axis=1), nan=np.inf)
        seen = (found.end <= End.BACK) & (found.count < trace_level)
        designed.append((off < 1e-3)[seen & found.designed])
        agree.append((off < 1e-3)[seen])
        by_rounding.append(decided_by_rounding(scene, direction[seen & (off >= 1e-3)]))
    return np.concatenate(designed).mean(), np.concatenate(agree).mean(), np.concatenate(by_rounding)


def within_the_trace(kind: str, shares: Sequence[float], bounds: tuple[float, float]) -> Iterator[Measured]:
    """Yield the first two results of `pixel_shares`, in percent, with their bounds. `kind` says of which sheets."""
    texts = "pixels on the designed path", "all pixels whose ray leaves,"
    for text, share, bound in zip(texts, shares, bounds, strict=True):
        yield Measured(
            "detailed", f"{kind}: {text} within 1e-3 rad of the ray trace", 100 * share, bound, "%", least=True
        )


def pixel_checks(kind: str, scenes: list[Directions], size: Size) -> Iterator[Measured]:
    *shares, differing = pixel_shares(scenes, size)
    yield from within_the_trace(kind, shares, (99.99, 99.5))
    yield Measured(
        "detailed", f"{kind}: of the {len(differing)} pixels that differ, not decided by rounding",
        100 * (1 - differing).mean() if len(differing) else 0, 1, "%",
    )  # fmt: skip


def finite_prisms(
    prisms: tuple[int, ...] = (25, 50, 100, 200, 400, 800, 1600), count: int = 8, size: Size = SMALL
) -> Iterator[Measured]:
    """Measure how the error of eq. 7, which is for infinitely small prisms, decreases with the number of prisms."""
    thin = [errors(targets("detailed", count, seed=3, E=0j, prisms=number), size)[0] for number in prisms]
    slope = np.polyfit(np.log(prisms), np.log(thin), 1)[0]
    yield Measured(
        "detailed", f"error of eq. 7 falls as N^k, N = {prisms[0]} to {prisms[-1]}: |k + 1|", abs(slope + 1), 0.15
    )


# Ranges of |alpha|, degrees, each with the greatest allowed ratio of the paraxial prediction's error to eq. 7's error.
ALPHA_RANGES = (((0, 8), 0.5), ((8, 150), 0.1), ((150, 180), 0.4))


# Refractive indices, and base angles in degrees: dense glass, BK7, and flat prisms.
OTHER_PRISMS = ((1.7, 40), (1.5168, 45), (1.5, 35))


def paraxial_prediction(count: int = 12, size: Size = SMALL) -> Iterator[Measured]:
    """Measure the error of the paraxial prediction, for 100 prisms, as a fraction of eq. 7's error.

    The fraction is large near alpha = 0: nearly parallel sheets show bands (moire), which the prediction ignores.
    """
    for between, most in ALPHA_RANGES:
        yield _prediction_error("2x100", targets("detailed", count, seed=5, E=0j, alphas=between), between, most, size)


def other_prisms(
    shapes: tuple[tuple[float, float], ...] = OTHER_PRISMS,
    alphas: tuple[float, ...] = (0, 35, 90, 180),
    count: int = 12,
    size: Size = SMALL,
) -> Iterator[Measured]:
    """Compare sheets of 100 prisms of other shapes with the exact ray trace, and measure their prediction's error.

    `shapes` are refractive indices and base angles, `alphas` angles. Angles are in degrees. `count` squares are located
    for each shape.
    """
    between, most = ALPHA_RANGES[1]
    for index, base_angle in shapes:
        shape, kind = {"index": index, "base_angle": base_angle}, f"2x100, n = {index:g}, {base_angle:g} deg"
        scenes = [Directions(sheet="detailed", alpha=alpha, **shape) for alpha in alphas]
        yield from pixel_checks(f"{kind}, {len(alphas)} alphas", scenes, size)
        yield _prediction_error(
            kind, targets("detailed", count, seed=5, E=0j, alphas=between, **shape), between, most, size
        )


# Errors of building, as of `sheets.prisms.ERRORS`, and values of other parameters
BUILDS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("index and base angle", {"error": {"index": 0.1, "far_index": -0.05, "base_angle": 5, "far_base_angle": -3}}),
    ("turn, tilts and separation", {"error": {"turn": 2, "tilt_x": 3, "far_tilt_y": 2, "separation": 0.1}}),
    ("single facets", {"prisms": 30, "error": {"facets": 1, "seed": 5}}),
    ("heights of single prisms", {"prisms": 30, "error": {"pitches": 0.05, "seed": 5}}),
)


def errors_of_building(
    builds: tuple[tuple[str, dict[str, Any]], ...] = BUILDS, size: Size = SMALL
) -> Iterator[Measured]:
    """Compare every pixel of sheets that are built with errors with the exact ray trace."""
    for kind, values in builds:
        yield from pixel_checks(f"errors: {kind}", [Directions(sheet="detailed", alpha=66, **values)], size)


def _prediction_error(
    kind: str, scenes: list[Positions], between: tuple[float, float], most: float, size: Size
) -> Measured:
    thin, thick = errors(scenes, size)
    what = f"{kind}, |alpha| {between[0]} to {between[1]} deg: paraxial prediction's error ({px(thick):.2f} px)"
    return Measured("detailed", f"{what} / eq. 7's error", thick / thin, most)


def errors(scenes: list[Positions], size: Size) -> tuple[float, float]:
    """Return the errors of eq. 7 and of the scenes' paraxial predictions, RMS over the scenes, in tiles.

    For windows in series, the complex depth takes the place of eq. 7.
    """
    thin, thick = [], []
    for scene, seen in located(scenes, size):
        ideal = equations.apparent_position(scene.L, scene.E, scene.z1, scene.z2, radians(scene.alpha), scene.behind)
        thin.append(abs(seen.position - ideal))
        thick.append(abs(seen.position - scene.apparent_position(scene.L, scene.z1)))
    return rms(thin), rms(thick)


def hyperbola(size: Size = SMALL) -> Iterator[Measured]:
    """Measure how a line perpendicular to a single sheet appears through the sheet: as a hyperbola.

    The line through (X, Y) appears as (x - X/2)(y - Y/2) = XY/4.
    """
    L = 0.45 + 0.3j
    scenes = [
        Positions(sheet="single", prisms=1600, z1=z1, L=L, extent=0.1) for z1 in (0.4, 0.8, 1.3, 1.8, 2.4, 3, 3.5)
    ]
    position = np.array([seen.position for _, seen in located(scenes, size)])
    x, y = position.real, position.imag
    # x y = p x + q y + c
    p, q, c = np.linalg.lstsq(np.column_stack((x, y, np.ones(len(x)))), x * y, rcond=None)[0]
    away = abs(x * y - (p * x + q * y + c)) / np.hypot(y - p, x - q)
    what = "single sheet: a perpendicular line's distance from its hyperbola, rms"
    yield Measured("detailed", what, px(rms(away)), 0.2, "px")
    centre = abs(q + 1j * p - L / 2)
    yield Measured("detailed", "single sheet: the hyperbola's centre against L/2", px(centre), 2, "px")
    y = (p * L.real + c) / (L.real - q)
    what = "single sheet: the hyperbola's distance from L, where the line meets the sheet"
    yield Measured("detailed", what, px(abs(y - L.imag)), 2, "px")


def designed_fraction(alphas: tuple[float, ...] = (30, 66, 120, 170), size: Size = SMALL) -> Iterator[Measured]:
    """Compare the fraction of pixels that show rotated light with the exact ray trace, for each field angle."""
    found = list(fractions(alphas, size))
    worst = max((abs(rendered - exact) for *_, rendered, exact in found), default=np.nan)
    angles = [angle for _, angle, *_ in found] or [np.nan]
    what = f"fraction of pixels on the designed path, fields of {min(angles):g} to {max(angles):g} deg, worst error"
    yield Measured("detailed", what, worst, 0.002)


def fractions(alphas: tuple[float, ...], size: Size, z2: float = 1.4) -> Iterator[tuple[float, float, float, float]]:
    """Yield alpha, field angle, and two fractions of pixels that show rotated light: rendered, and traced exactly.

    Angles are in degrees. Pixels are grouped by field angle, in rings 5 degrees wide. The field angle is that of the
    ring's middle. Rings of 500 pixels or fewer are left out.
    """
    scenes = [Directions(sheet="detailed", alpha=alpha, z2=z2) for alpha in alphas]
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        inside, direction = camera.rays(scene, size)
        turned = equations.rotate(direction, radians(scene.alpha))
        found = scene.trace(camera.along(scene, direction), survey.max_trace_level(scene))
        rendered = np.linalg.norm(decoded[inside] - turned, axis=1) < 1e-3
        exact = (np.linalg.norm(found.direction - turned, axis=1) < 1e-3) & (found.end == End.THROUGH)
        exact &= found.count < survey.max_trace_level(scene)
        field = np.degrees(np.arccos(direction[:, 2])) // 5
        for ring in np.unique(field):
            pixels = field == ring
            if pixels.sum() > 500:
                yield scene.alpha, float(5 * ring + 2.5), rendered[pixels].mean(), exact[pixels].mean()
