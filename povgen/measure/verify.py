"""Compare what POV-Ray renders with the equations and the exact ray trace: `povgen verify`.

Each check renders probes: scenes whose colours encode numbers. It yields each measured value together with the value's
bound. Random scenes have fixed seeds.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, pi, radians

import numpy as np
from numpy.typing import ArrayLike

from povgen.measure import probes
from povgen.measure.probes import (
    ApparentObject,
    Complexes,
    Directions,
    Floats,
    Light,
    Mask,
    PiecePositions,
    Positions,
    Size,
    White,
)
from povgen.measure.rounding import decided_by_rounding
from povgen.optics import rotation, series
from povgen.optics.polarisation import jones, mean_transmission, transmission
from povgen.optics.trace import End, Face
from povgen import limits
from povgen.scene import survey
from povgen.scene.models import APERTURE, VIEW, Scene, Window

HD = (1280, 960)  # errors of position are given in pixels of this size
SMALL = (640, 480)
Series = tuple[float, dict[str, float]]  # alpha of the first window, and a second window
SERIES: tuple[Series, ...] = (
    (120, {"alpha": 120, "z": 2}),
    (50, {"alpha": 75, "z": 1}),
    (40, {"alpha": -100, "z": 0.6}),
)


@dataclass(frozen=True)
class Measured:
    """A measured value and its bound: the least allowed value if `least`, otherwise the greatest."""

    sheet: str
    what: str
    value: float
    bound: float
    unit: str = ""
    least: bool = False

    @property
    def holds(self) -> bool:
        """Return whether the value is within its bound. NaN is not."""
        return bool(self.value >= self.bound if self.least else self.value <= self.bound)


def checks(sheet: str | None = None) -> Iterator[Measured]:
    """Measure everything, or only what concerns one model of the sheets: 'ideal' or 'detailed'."""
    if sheet != "detailed":
        yield from ideal_positions()
        yield from ideal_directions()
        yield from chess_pieces()
        yield from horizon()
        yield from real_image()
        yield from nothing_changed()
        yield from other_sheets()
        yield from series_positions()
        yield from series_directions()
        yield from series_image()
    if sheet != "ideal":
        yield from every_pixel()
        yield from finite_prisms()
        yield from paraxial_prediction()
        yield from other_prisms()
        yield from series_pixels()
        yield from series_prediction()
        yield from black_tops()
        yield from partial_reflection()
        yield from reflected_light()
        yield from hyperbola()
        yield from designed_fraction()


def ideal_positions(count: int = 60, size: Size = HD) -> Iterator[Measured]:
    """Compare the apparent positions of objects with eq. 7, and nu and M with eqs. 8 and 9, corrected."""
    scenes = [
        *targets("ideal", count - 2 * (count // 3), seed=7, E=0j),
        *targets("ideal", count // 3, seed=8, E=0.3 - 0.4j),
        *targets("ideal", count // 3, seed=9, E=8.6j),
    ]
    off, turn, scale = [], [], []
    for scene, seen in located(scenes, size):
        r, alpha = scene.z2 / scene.z1, radians(scene.alpha)
        off.append(px(abs(seen.position - scene.apparent_position(scene.L, scene.z1))))
        turn.append(degrees(abs(np.angle(seen.a * np.exp(-1j * rotation.nu(r, alpha))))))
        scale.append(100 * abs(abs(seen.a) / rotation.M(r, alpha) - 1))
    # numpy's max keeps NaN
    yield Measured("ideal", f"apparent position against eq. 7, {count} scenes, worst", np.max(off), 0.05, "px")
    yield Measured("ideal", "nu of these objects against eq. 8 corrected, worst", np.max(turn), 0.1, "deg")
    yield Measured("ideal", "M of these objects against eq. 9 corrected, worst", np.max(scale), 0.2, "%")


def ideal_directions(size: Size = HD) -> Iterator[Measured]:
    """Compare the direction that each pixel of the window shows with the rotated direction."""
    for E, where in ((0j, "in front of the window"), (0.5 - 0.5j, "to the side"), (8.6j, "far to the side")):
        scenes = [Directions(sheet="ideal", alpha=alpha, eye=E) for alpha in (66, 180)]
        worst = 0.0
        for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
            inside, direction = probes.rays(scene, size)
            turned = rotation.rotate(direction, radians(scene.alpha))
            # rays that leave the sheet but miss the window frame's rear opening end at the frame: leave them out
            leaves = direction[:, :2] * scene.z2 / direction[:, 2:] + turned[:, :2] / turned[:, 2:] * scene.depth / 2
            leaves += (E.real, E.imag)
            off = np.linalg.norm(_unit(decoded[inside]) - turned, axis=1)
            free = abs(leaves).max(1) < scene.aperture / 2 - 1e-6
            worst = max(worst, np.nan_to_num(off[free], nan=np.inf).max())
        yield Measured("ideal", f"direction against the rotation, eye {where}, worst pixel", worst, 1e-4, "rad")


def chess_pieces(size: Size = HD) -> Iterator[Measured]:
    """Compare how chess pieces appear rotated and magnified about the eye with eqs. 8 and 9, corrected."""
    scenes = [
        PiecePositions(sheet="ideal", alpha=alpha, z1=z1, z2=6, x=0.1, eye=(0, -0.33), piece=name)
        for alpha, z1, name in (
            (25, 3, "pawn"),
            (66, 2, "knight"),
            (90, 6, "queen"),
            (140, 1, "rook"),
            (-66, 4, "king"),
        )
    ]
    turn, scale = 0.0, 0.0
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        a = about_eye(scene, decoded, size)
        r = scene.z2 / scene.z1
        turn = max(turn, abs(np.angle(a * np.exp(-1j * rotation.nu(r, radians(scene.alpha))))))
        scale = max(scale, abs(abs(a) / rotation.M(r, radians(scene.alpha)) - 1))
    yield Measured(
        "ideal", f"nu of {len(scenes)} chess pieces against eq. 8 corrected, worst", degrees(turn), 0.1, "deg"
    )
    yield Measured("ideal", f"M of {len(scenes)} chess pieces against eq. 9 corrected, worst", 100 * scale, 0.2, "%")


def about_eye(scene: PiecePositions, decoded: Floats, size: Size) -> complex:
    """Return the complex number that multiplies positions relative to E, at the depth of the piece's axis.

    A piece is as deep as it is wide, and its farther parts appear turned by more. Therefore the number is fitted as a
    cubic polynomial of the depth.
    """
    inside, direction = probes.rays(scene, size)
    if scene.sheet == "detailed":  # stray light shows other places of the piece
        inside[inside] = probes.traced(scene, direction).designed
    inside &= ~np.isnan(decoded[..., 0])
    x, y, depth = decoded[inside].T
    from_eye = scene.L + x + 1j * y - scene.E
    powers = [power for power in range(4) if (0.5 / scene.z1) ** power > 1e-3]  # far away, depth matters less
    basis = from_eye[:, None] * depth[:, None] ** powers
    target = probes.pixels(scene, size)[inside] - scene.E
    kept = np.ones(len(x), bool)
    for _ in range(5):
        a = np.linalg.lstsq(basis[kept], target[kept], rcond=None)[0]
        off = abs(basis @ a - target)
        kept = off < 4 * np.median(off[kept])
    return complex(a[0])


def horizon(size: Size = HD) -> Iterator[Measured]:
    """Measure the angle at which the horizon appears: on a line through E that is turned by alpha."""
    alphas = (-120, 30, 66, 90, 180)
    off = [horizon_angle(Directions(sheet="ideal", alpha=alpha), size) - radians(alpha) for alpha in alphas]
    worst = np.max(abs((np.array(off) + pi) % (2 * pi) - pi))
    yield Measured("ideal", f"the horizon turned by alpha, worst of {len(alphas)}", degrees(worst), 0.1, "deg")


def horizon_angle(scene: Directions, size: Size) -> float:
    """Return the angle, radians, by which the horizon appears turned. The fit drops stray light."""
    (decoded,) = probes.decoded([scene], size)
    inside, _ = probes.rays(scene, size)
    inside &= ~np.isnan(decoded[..., 0])
    slope = decoded[inside][:, 1] / decoded[inside][:, 2]
    position = probes.pixels(scene, size)[inside]
    x, y = position.real, position.imag
    kept = np.ones(len(x), bool)
    for _ in range(8):
        gradient = np.linalg.lstsq(np.column_stack((x, y))[kept], slope[kept], rcond=None)[0]
        off = abs(slope - gradient[0] * x - gradient[1] * y)
        kept = off <= 4 * np.median(off[kept]) + 1e-12
    return float(np.arctan2(gradient[1], gradient[0]) - pi / 2)  # the horizon is perpendicular to the gradient


def real_image(size: Size = HD) -> Iterator[Measured]:
    """Measure the image distance at alpha = 180 deg, by the parallax between two eyes.

    The image is as far in front of the sheets as the object is behind them.
    """
    off = []
    for z1 in (1.0, 2.0, 4.0):
        eyes = (-0.2 + 0.1j, 0.25 - 0.1j)
        scenes = [Positions(sheet="ideal", alpha=180, z1=z1, L=0.1 + 0.1j, eye=E, extent=0.05) for E in eyes]
        off.append(100 * abs(image_distance([seen.position for _, seen in located(scenes, size)], scenes) + z1) / z1)
    yield Measured("ideal", "alpha = 180 deg: image distance -z1 by parallax, worst of 3", np.max(off), 0.2, "%")


def image_distance(positions: list[complex], scenes: list[Positions]) -> complex:
    """Return how far behind the plane z = 0 the lines of sight of two eyes to an object cross."""
    z2_over_distance = 1 - (positions[0] - positions[1]) / (scenes[0].E - scenes[1].E)
    return scenes[0].z2 / z2_over_distance - scenes[0].z2


def nothing_changed(size: Size = SMALL) -> Iterator[Measured]:
    """Measure how much a sheet with alpha = 0 changes the position that a pixel shows."""
    scenes = [Positions(sheet=sheet, alpha=0, z1=2, extent=2) for sheet in ("ideal", "none")]
    ideal, none = probes.decoded(scenes, size)
    inside, _ = probes.rays(scenes[0], size)
    change = transverse(ideal - none)[inside & ~np.isnan(none[..., 0])]
    worst = np.nan_to_num(abs(change), nan=np.inf).max(initial=0) * 6 / 8  # projected from z = 2 to the plane z = 0
    worst = worst if len(change) else np.nan
    yield Measured("ideal", "alpha = 0: change of what a pixel shows, worst", px(worst), 0.05, "px")


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
        yield from _pixels(f"2x{count}, {len(alphas)} alphas", scenes, size)
    if others:
        yield from _pixels(f"{others} scenes at random", any_window(others, seed=1), size)


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


def _pixels(kind: str, scenes: list[Directions], size: Size) -> Iterator[Measured]:
    designed, agree, by_rounding = [], [], []
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        inside, direction = probes.rays(scene, size)
        trace_level = survey.max_trace_level(scene)
        found = probes.traced(scene, direction, trace_level)
        off = np.nan_to_num(np.linalg.norm(decoded[inside] - found.direction, axis=1), nan=np.inf)
        seen = (found.end <= End.BACK) & (found.count < trace_level)
        designed.append((off < 1e-3)[seen & found.designed])
        agree.append((off < 1e-3)[seen])
        by_rounding.append(decided_by_rounding(scene, direction[seen & (off >= 1e-3)]))
    yield Measured(
        "detailed", f"{kind}: pixels on the designed path within 1e-3 rad of the ray trace",
        100 * np.concatenate(designed).mean(), 99.99, "%", least=True,
    )  # fmt: skip
    yield Measured(
        "detailed", f"{kind}: all pixels whose ray leaves, within 1e-3 rad of the ray trace",
        100 * np.concatenate(agree).mean(), 99.5, "%", least=True,
    )  # fmt: skip
    differing = np.concatenate(by_rounding)
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
    """Measure 100 prisms of other shapes against the exact ray trace, and the paraxial prediction for them."""
    between, most = ALPHA_RANGES[1]
    for index, base_angle in shapes:
        shape, kind = {"index": index, "base_angle": base_angle}, f"2x100, n = {index:g}, {base_angle:g} deg"
        scenes = [Directions(sheet="detailed", alpha=alpha, **shape) for alpha in alphas]
        yield from _pixels(f"{kind}, {len(alphas)} alphas", scenes, size)
        yield _prediction_error(
            kind, targets("detailed", count, seed=5, E=0j, alphas=between, **shape), between, most, size
        )


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
        ideal = rotation.apparent_position(scene.L, scene.E, scene.z1, scene.z2, radians(scene.alpha), scene.behind)
        thin.append(abs(seen.position - ideal))
        thick.append(abs(seen.position - scene.apparent_position(scene.L, scene.z1)))
    return rms(thin), rms(thick)


# Of each other ideal sheet, its parameters in the scenes that are measured.
OTHER: dict[str, tuple[dict[str, object], ...]] = {
    "axis": (
        {"alpha": 25, "axis": (0, 1, 0)},
        {"alpha": -40, "axis": (0.6, 0.3, 1)},
        {"alpha": 60, "axis": (1, 0, -1)},
    ),
    "refraction": ({"alpha": 0, "ratio": 1.5}, {"alpha": 180, "ratio": 1}, {"alpha": 50, "ratio": 0.6}),
    "lenslets": ({"alpha": 180, "ratio": 1.5}, {"alpha": 180, "ratio": 0.8}, {"alpha": 50, "ratio": 0.8}),
    "mirror": ({"alpha": 0}, {"alpha": 60}, {"alpha": -100}),
}


def other_sheets(size: Size = HD) -> Iterator[Measured]:
    """Compare the apparent positions of objects behind other ideal sheets with `ideal.apparent_position`."""
    for sheet, scenes in other_targets().items():
        off = [px(abs(seen.position - scene.apparent_position(scene.L, 2))) for scene, seen in located(scenes, size)]
        yield Measured(
            "ideal", f"sheet {sheet}: apparent position, {len(scenes)} scenes, worst", np.max(off), 0.1, "px"
        )


def other_targets() -> dict[str, list[Positions]]:
    """Return squares that appear at 0.2 + 0.3i behind each of the other ideal sheets."""
    found: dict[str, list[Positions]] = {}
    for sheet, several in OTHER.items():
        found[sheet] = []
        for values in several:
            for E in (0j, 0.3 - 0.2j):
                scene = Positions(sheet=sheet, z1=2, z2=5, eye=E, extent=0.1, **values)
                x, y, z = scene.bend(np.array([0.2 - E.real, 0.3 - E.imag, scene.z2]))
                found[sheet].append(scene.replace(L=0.2 + 0.3j + 2 * complex(x, y) / z))
    return found


def series_positions(count: int = 12, size: Size = HD) -> Iterator[Measured]:
    """Compare the apparent positions of objects behind 2 and 3 ideal windows with the complex depth."""
    for windows in (2, 3):
        scenes = [*series_targets("ideal", windows, count - count // 2, seed=11, E=0j)]
        scenes += series_targets("ideal", windows, count // 2, seed=12, E=0.3 - 0.2j)
        off = [
            px(abs(seen.position - scene.apparent_position(scene.L, scene.z1))) for scene, seen in located(scenes, size)
        ]
        what = f"{windows} windows: apparent position against the complex depth, {count} scenes, worst"
        yield Measured("ideal", what, np.max(off), 0.1, "px")


def series_directions(size: Size = HD) -> Iterator[Measured]:
    """Compare the direction that each pixel shows through all of 2 and 3 ideal windows with the rotated direction."""
    worst = 0.0
    for alpha, window, E in (
        (120, SERIES[0][1:], 0j),
        (50, [{"alpha": 75, "z": 1}, {"alpha": -40, "z": 2}], 0.3 - 0.2j),
    ):
        scene = Directions(sheet="ideal", alpha=alpha, window=window, eye=E)
        (decoded,) = probes.decoded([scene], size)
        inside, direction = probes.rays(scene, size)
        through, turned = through_ideal(scene, direction)
        off = np.linalg.norm(_unit(decoded[inside][through]) - turned[through], axis=1)
        worst = max(worst, np.nan_to_num(off, nan=np.inf).max())
    yield Measured("ideal", "2 and 3 windows: direction against the rotations, worst pixel", worst, 1e-4, "rad")


def through_ideal(scene: Scene, direction: Floats) -> tuple[Mask, Floats]:
    """Return which of the eye's rays pass all windows and their frames, and their directions behind the windows.

    Shapes are (n, 3), (n,) and (n, 3). Rays within 1e-6 tiles of an edge do not count.
    """
    slope = (direction[:, 0] + 1j * direction[:, 1]) / direction[:, 2]
    at, z, through, half = scene.E + scene.z2 * slope, 0.0, np.ones(len(slope), bool), scene.aperture / 2 - 1e-6
    for place, alpha in zip(scene.places, scene.alphas, strict=True):
        at = at + (place - z) * slope
        before, after = slope, slope * np.exp(-1j * radians(alpha))
        for point in (at - scene.depth / 2 * before, at, at + scene.depth / 2 * after):
            through &= np.maximum(abs(point.real), abs(point.imag)) < half
        slope, z = after, place
    turned = np.column_stack((slope.real, slope.imag, np.ones(len(slope))))
    return through, _unit(turned)


def series_image(size: Size = HD) -> Iterator[Measured]:
    """Measure the image distance of two windows, by the parallax between two eyes."""
    off = []
    for first, second, gap in ((120, 120, 2.0), (150, 100, 1.5), (40, -100, 2.0)):
        z1, W = series.imaged_plane(radians(first), [(gap, radians(second))])
        window = [{"alpha": second, "z": gap}]
        eyes = (-0.2 + 0.1j, 0.25 - 0.1j)
        scenes = [
            Positions(sheet="ideal", alpha=first, window=window, z1=z1, L=0.1 + 0.1j, eye=E, extent=0.05) for E in eyes
        ]
        off.append(100 * abs(image_distance([seen.position for _, seen in located(scenes, size)], scenes) - W) / abs(W))
    yield Measured("ideal", "2 windows: image distance by parallax, worst of 3", np.max(off), 0.2, "%")


def series_pixels(
    counts: tuple[int, ...] = (100,), scenes: tuple[Series, ...] = SERIES, size: Size = SMALL
) -> Iterator[Measured]:
    """Compare the direction that every pixel shows through 4 sheets with the exact ray trace, stray light included."""
    for count in counts:
        probed = [Directions(sheet="detailed", prisms=count, alpha=alpha, window=window) for alpha, *window in scenes]
        yield from _pixels(f"2 windows of 2x{count}, {len(scenes)} scenes", probed, size)


def series_prediction(count: int = 12, size: Size = SMALL) -> Iterator[Measured]:
    """Measure the error of the paraxial prediction for 2 and 3 windows, as a fraction of the complex depth's error."""
    for windows in (2, 3):
        thin, thick = errors(series_targets("detailed", windows, count, seed=5, E=0j), size)
        what = f"{windows} windows of 2x100: paraxial prediction's error ({px(thick):.2f} px) / the complex depth's"
        yield Measured("detailed", what, thick / thin, 0.1)


def series_targets(sheet: str, windows: int, count: int, seed: int, E: complex, **values: float) -> list[Positions]:
    """Return squares behind random windows, like `targets`, that are well inside every window."""
    random = np.random.default_rng(seed)
    scenes: list[Positions] = []
    while len(scenes) < count:
        angles = random.uniform(8, 150, windows) * random.choice([-1, 1], windows)
        places = np.cumsum(random.uniform(0.6, 1.6, windows - 1))
        window = tuple(Window(alpha=alpha, z=z) for alpha, z in zip(angles[1:], places, strict=True))
        z1, z2, P = random.uniform(1, 6), random.uniform(4, 8), complex(*random.uniform(-0.5, 0.5, 2))
        scene = Positions(sheet=sheet, alpha=angles[0], window=window, z1=z1, z2=z2, eye=E, **values)
        L = rotation.object_position(P, E, z1, z2, radians(scene.alpha), scene.behind)
        crossed = series.crossings(P, E, z2, radians(scene.alpha), scene.behind)
        M = z2 / abs(rotation.depth(z1, z2, radians(scene.alpha), scene.behind))
        if M < 4 and np.maximum(abs(crossed.real), abs(crossed.imag)).max() < 0.7:
            scenes.append(scene.replace(L=L, extent=0.25 / M))
    return scenes


def black_tops(size: Size = SMALL) -> Iterator[Measured]:
    """Compare which pixels are black, if the tops of prisms are, with the exact ray trace."""
    scene = Directions(sheet="detailed", tops="black", aperture=APERTURE, view=VIEW)
    (decoded,) = probes.decoded([scene], size)
    inside, direction = probes.rays(scene, size)
    found = probes.traced(scene, direction, survey.max_trace_level(scene))
    seen = (found.end <= End.BACK) & (found.count < survey.max_trace_level(scene))
    black = (found.faces == Face.TOP).any(1)
    agree = np.isnan(decoded[inside][seen][:, 0]) == black[seen]
    what = f"black tops take {100 * black[seen].mean():.1f} % of the pixels: as in the ray trace"
    yield Measured("detailed", what, 100 * agree.mean(), 99.5, "%", least=True)


def partial_reflection(size: Size = SMALL) -> Iterator[Measured]:
    """Compare how bright light on the designed path is, with partial reflection, with the Fresnel equations."""
    scene = Light(sheet="detailed", fresnel=True, z1=2, L=0.3 + 0.1j, extent=0.25)
    inside, direction = probes.rays(scene, size)
    angles, prism = [0, radians(scene.alpha) / 2], scene.prism
    light = -rotation.rotate(direction, radians(scene.alpha))  # towards the eye, before the sheets
    clear = probes.brightness(scene.replace(fresnel=False), size)[inside] > 0.99
    clear &= probes.traced(scene, direction).designed
    seen = probes.brightness(scene, size)[inside][clear]
    expected = mean_transmission(light[clear], angles, prism)
    off = np.quantile(abs(seen - expected), 0.99)
    what = f"--fresnel: brightness on the designed path ({seen.mean():.3f}) against Fresnel's equations, 99 % of pixels"
    yield Measured("detailed", what, off, 0.0005)
    both = transmission(jones(light[clear], angles, prism)).mean()
    what = f"--fresnel: its mean against that of polarised light ({both:.3f})"
    yield Measured("detailed", what, abs(seen.mean() - both), 0.02)


def reflected_light(size: Size = SMALL) -> Iterator[Measured]:
    """Compare how bright the whole window is before white surroundings, with partial reflection, with the ray trace.

    The ray trace also says what share of this light at least one partial reflection has sent to the eye.
    """
    scene = White(sheet="detailed", fresnel=True, aperture=APERTURE, view=VIEW)
    inside, direction = probes.rays(scene, size)
    seen = probes.brightness(scene, size)[inside].mean()
    directions = np.tile(direction, (200_000 // len(direction) + 1, 1))
    found = probes.traced(scene, directions, survey.max_trace_level(scene), partial=np.random.default_rng(1))
    followed = (found.end <= End.BACK) & (found.light >= limits.LEAST_LIGHT)
    share = 100 * found.reflected[followed].mean()
    what = f"--fresnel: brightness of the window ({seen:.3f}, {share:.1f} % of it by reflections) against the ray trace"
    yield Measured("detailed", what, abs(seen - followed.mean()), 0.005)


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
    yield Measured(
        "detailed", "single sheet: a perpendicular line's distance from its hyperbola, rms", px(rms(away)), 0.2, "px"
    )
    centre = abs(q + 1j * p - L / 2)
    yield Measured("detailed", "single sheet: the hyperbola's centre against L/2", px(centre), 2, "px")
    y = (p * L.real + c) / (L.real - q)
    yield Measured(
        "detailed",
        "single sheet: the hyperbola's distance from L, where the line meets the sheet",
        px(abs(y - L.imag)),
        2,
        "px",
    )


def designed_fraction(alphas: tuple[float, ...] = (30, 66, 120, 170), size: Size = SMALL) -> Iterator[Measured]:
    """Compare the fraction of pixels that show rotated light with the exact ray trace, for each field angle."""
    found = list(fractions(alphas, size))
    worst = max((abs(rendered - exact) for *_, rendered, exact in found), default=np.nan)
    angles = [angle for _, angle, *_ in found] or [np.nan]
    yield Measured(
        "detailed",
        f"fraction of pixels on the designed path, fields of {min(angles):g} to {max(angles):g} deg, worst error",
        worst,
        0.002,
    )


def fractions(alphas: tuple[float, ...], size: Size, z2: float = 1.4) -> Iterator[tuple[float, float, float, float]]:
    """Yield alpha, field angle, and two fractions of pixels that show rotated light: rendered, and traced exactly.

    Angles are in degrees. Pixels are grouped by field angle, in rings 5 degrees wide; each ring's middle is yielded.
    """
    scenes = [Directions(sheet="detailed", alpha=alpha, z2=z2) for alpha in alphas]
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        inside, direction = probes.rays(scene, size)
        turned = rotation.rotate(direction, radians(scene.alpha))
        found = probes.traced(scene, direction, survey.max_trace_level(scene))
        rendered = np.linalg.norm(decoded[inside] - turned, axis=1) < 1e-3
        exact = (np.linalg.norm(found.direction - turned, axis=1) < 1e-3) & (found.end == End.THROUGH)
        exact &= found.count < survey.max_trace_level(scene)
        field = np.degrees(np.arccos(direction[:, 2])) // 5
        for ring in np.unique(field):
            pixels = field == ring
            if pixels.sum() > 500:
                yield scene.alpha, float(5 * ring + 2.5), rendered[pixels].mean(), exact[pixels].mean()


def targets(
    sheet: str, count: int, seed: int, E: complex, alphas: tuple[float, float] = (0, 180), **values: float
) -> list[Positions]:
    """Return squares at random distances that appear at random positions in the window, magnified less than 10 times.

    |alpha| lies between `alphas`, degrees. Each square appears 0.6 tiles wide. The scenes have these other values.
    """
    random = np.random.default_rng(seed)
    scenes: list[Positions] = []
    while len(scenes) < count:
        alpha, z1, z2 = random.uniform(-180, 180), np.exp(random.uniform(np.log(1), np.log(30))), random.uniform(3, 8)
        alpha = np.copysign(alphas[0] + abs(alpha) / 180 * (alphas[1] - alphas[0]), alpha)
        position = complex(*random.uniform(-0.8, 0.8, 2))
        M = rotation.M(z2 / z1, radians(alpha))
        if M < 10:
            L = rotation.object_position(position, E, z1, z2, radians(alpha))
            scene = Positions(sheet=sheet, alpha=alpha, z1=z1, z2=z2, L=L, eye=E, extent=0.3 / M, **values)
            scenes.append(scene)
    return scenes


NOT_FOUND = ApparentObject(complex("nan"), complex("nan"), complex("nan"))


def located(scenes: list[Positions], size: Size) -> Iterator[tuple[Positions, ApparentObject]]:
    """Yield each scene and where its square appears, or NOT_FOUND (NaN) if too little of the square is visible."""
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        inside, _ = probes.rays(scene, size)
        yield (
            scene,
            probes.locate(probes.pixels(scene, size)[inside], transverse(decoded[inside]), scene.extent) or NOT_FOUND,
        )


def transverse(decoded: Floats) -> Complexes:
    """Return x + iy of decoded vectors (..., 3)."""
    return np.asarray(decoded[..., 0] + 1j * decoded[..., 1], np.complex128)


def _unit(direction: Floats) -> Floats:
    return np.asarray(direction / np.linalg.norm(direction, axis=-1, keepdims=True))


def rms(values: ArrayLike) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def px(tiles: float) -> float:
    """Convert a length in the plane z = 0 from tiles to pixels of a picture of 1280x960 with the default view."""
    return float(tiles * HD[1] / probes.VIEW)
