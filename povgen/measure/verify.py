"""What POV-Ray renders, measured against the equations and the exact ray trace: `povgen verify`.

Every check renders scenes of `instruments` and yields what it measured beside its bound. Random ones are seeded.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import degrees, pi, radians

import numpy as np

from povgen.measure import probes
from povgen.measure.probes import Directions, Piece, Positions
from povgen.optics import rotation
from povgen.optics.trace import End
from povgen.scene import prediction

Size = tuple[int, int]
HD = (1280, 960)  # what pixels are counted in
SMALL = (640, 480)
VIEW = Positions.view_height


@dataclass(frozen=True)
class Measured:
    """A figure, the bound that it must keep, and whether that is the least or the most that it may be."""

    sheet: str
    what: str
    value: float
    bound: float
    unit: str = ""
    least: bool = False

    @property
    def holds(self) -> bool:
        return bool(self.value >= self.bound if self.least else self.value <= self.bound)


def checks(sheet: str | None = None) -> Iterator[Measured]:
    """Measure all, or what concerns one sheet model: 'ideal' or 'detailed'."""
    if sheet != "detailed":
        yield from ideal_positions()
        yield from ideal_directions()
        yield from piece()
        yield from horizon()
        yield from real_image()
        yield from nothing_changed()
    if sheet != "ideal":
        yield from every_pixel()
        yield from finite_prisms()
        yield from paraxial_prediction()
        yield from hyperbola()
        yield from designed_fraction()


def ideal_positions(count: int = 60, size: Size = HD) -> Iterator[Measured]:
    """The apparent position of an object against eq. 7."""
    scenes = [
        *targets("ideal", count - 2 * (count // 3), seed=7, E=0j),
        *targets("ideal", count // 3, seed=8, E=0.3 - 0.4j),
        *targets("ideal", count // 3, seed=9, E=8.6j),
    ]
    off, turn, scale = [], [], []
    for scene, seen in located(scenes, size):
        r, alpha = scene.z2 / scene.z1, radians(scene.alpha)
        off.append(px(abs(seen.place - scene.apparent_position(scene.L, scene.z1))))
        turn.append(degrees(abs(np.angle(seen.a * np.exp(-1j * rotation.nu(r, alpha))))))
        scale.append(100 * abs(abs(seen.a) / rotation.M(r, alpha) - 1))
    # numpy's max keeps NaN
    yield Measured("ideal", f"apparent position against eq. 7, {count} scenes, worst", np.max(off), 0.05, "px")
    yield Measured("ideal", "nu of these objects against eq. 8 corrected, worst", np.max(turn), 0.1, "deg")
    yield Measured("ideal", "M of these objects against eq. 9 corrected, worst", np.max(scale), 0.2, "%")


def ideal_directions(size: Size = HD) -> Iterator[Measured]:
    """The direction seen in every pixel of the window against the rotation."""
    for E, where in ((0j, "before the window"), (0.5 - 0.5j, "aside"), (8.6j, "far aside")):
        scenes = [Directions(sheet="ideal", alpha=alpha, E=E) for alpha in (66, 180)]
        worst = 0.0
        for scene, told in zip(scenes, probes.frames(scenes, size), strict=True):
            inside, direction = probes.rays(scene, size)
            turned = rotation.rotate(direction, radians(scene.alpha))
            # the frame's inner walls hide what leaves the sheet beside the opening behind it
            leaves = direction[:, :2] * scene.z2 / direction[:, 2:] + turned[:, :2] / turned[:, 2:] * scene.depth / 2
            leaves += (E.real, E.imag)
            off = np.linalg.norm(_unit(told[inside]) - turned, axis=1)
            free = abs(leaves).max(1) < scene.window / 2 - 1e-6
            worst = max(worst, np.nan_to_num(off[free], nan=np.inf).max())
        yield Measured("ideal", f"direction against the rotation, eye {where}, worst pixel", worst, 1e-4, "rad")


def piece(size: Size = HD) -> Iterator[Measured]:
    """Rotation and magnification of a chess piece about the eye against eqs. 8 and 9, corrected."""
    scenes = [
        Piece(sheet="ideal", alpha=alpha, z1=z1, z2=6, offset=(0.1, -1.0), piece=name)
        for alpha, z1, name in (
            (25, 3, "pawn"),
            (66, 2, "knight"),
            (90, 6, "queen"),
            (140, 1, "rook"),
            (-66, 4, "king"),
        )
    ]
    turn, scale = 0.0, 0.0
    for scene, told in zip(scenes, probes.frames(scenes, size), strict=True):
        a = about_eye(scene, told, size)
        r = scene.z2 / scene.z1
        turn = max(turn, abs(np.angle(a * np.exp(-1j * rotation.nu(r, radians(scene.alpha))))))
        scale = max(scale, abs(abs(a) / rotation.M(r, radians(scene.alpha)) - 1))
    yield Measured(
        "ideal", f"nu of {len(scenes)} chess pieces against eq. 8 corrected, worst", degrees(turn), 0.1, "deg"
    )
    yield Measured("ideal", f"M of {len(scenes)} chess pieces against eq. 9 corrected, worst", 100 * scale, 0.2, "%")


def about_eye(scene: Piece, told: np.ndarray, size: Size) -> complex:
    """The complex number by which what lies in the plane of the piece's axis appears multiplied about the eye.

    A piece is as deep as it is wide, and what is farther turns more: so the number is fitted as a cubic of depth.
    """
    inside, _ = probes.rays(scene, size)
    inside &= ~np.isnan(told[..., 0])
    x, y, depth = told[inside].T
    offset = scene.L + x + 1j * y - scene.E
    basis = offset[:, None] * depth[:, None] ** np.arange(4)
    target = probes.pixels(size)[inside] - scene.E
    kept = np.ones(len(x), bool)
    for _ in range(5):
        a = np.linalg.lstsq(basis[kept], target[kept], rcond=None)[0]
        off = abs(basis @ a - target)
        kept = off < 4 * np.median(off[kept])
    return complex(a[0])


def horizon(size: Size = HD) -> Iterator[Measured]:
    """Where light from the horizon is seen: on a line through E that is turned by alpha."""
    alphas = (-120, 30, 66, 90, 180)
    off = [horizon_angle(Directions(sheet="ideal", alpha=alpha), size) - radians(alpha) for alpha in alphas]
    worst = np.max(abs((np.array(off) + pi) % (2 * pi) - pi))
    yield Measured("ideal", f"the horizon turned by alpha, worst of {len(alphas)}", degrees(worst), 0.1, "deg")


def horizon_angle(scene: Directions, size: Size) -> float:
    """The angle, radians, through which the horizon is seen turned; stray light is left out of the fit."""
    (told,) = probes.frames([scene], size)
    inside, _ = probes.rays(scene, size)
    inside &= ~np.isnan(told[..., 0])
    slope = told[inside][:, 1] / told[inside][:, 2]
    place = probes.pixels(size)[inside]
    x, y = place.real, place.imag
    kept = np.ones(len(x), bool)
    for _ in range(8):
        low = np.linalg.lstsq(np.column_stack((x, y))[kept], slope[kept], rcond=None)[0]
        off = abs(slope - low[0] * x - low[1] * y)
        kept = off <= 4 * np.median(off[kept]) + 1e-12
    return float(np.arctan2(low[1], low[0]) - pi / 2)  # its normal, upwards


def real_image(size: Size = HD) -> Iterator[Measured]:
    """alpha = 180 deg: two eyes see an object by parallax as far before the sheets as it is behind them."""
    off = []
    for z1 in (1.0, 2.0, 4.0):
        eyes = (-0.2 + 0.1j, 0.25 - 0.1j)
        scenes = [Positions(sheet="ideal", alpha=180, z1=z1, L=0.1 + 0.1j, E=E, extent=0.05) for E in eyes]
        a, b = (seen.place for _, seen in located(scenes, size))
        nearness = 1 - (a - b) / (eyes[0] - eyes[1])  # of the crossing of the two lines of sight: z2/distance
        off.append(100 * abs(scenes[0].z2 - scenes[0].z2 / nearness - z1) / z1)
    yield Measured("ideal", "alpha = 180 deg: image distance -z1 by parallax, worst of 3", np.max(off), 0.2, "%")


def nothing_changed(size: Size = SMALL) -> Iterator[Measured]:
    """alpha = 0: every pixel of the window shows the place that it shows without a sheet."""
    scenes = [Positions(sheet=sheet, alpha=0, z1=2, extent=2) for sheet in ("ideal", "none")]
    ideal, none = probes.frames(scenes, size)
    inside, _ = probes.rays(scenes[0], size)
    change = transverse(ideal - none)[inside & ~np.isnan(none[..., 0])]
    worst = np.nan_to_num(abs(change), nan=np.inf).max(initial=0) * 6 / 8  # as seen in the plane z = 0
    worst = worst if len(change) else np.nan
    yield Measured("ideal", "alpha = 0: change of what a pixel shows, worst", px(worst), 0.05, "px")


def every_pixel(
    prisms: tuple[int, ...] = (100, 1000),
    alphas: tuple[float, ...] = (0, 35, 90, 180),
    others: int = 16,
    size: Size = SMALL,
) -> Iterator[Measured]:
    """The direction in every pixel against the exact ray trace, stray light and light between the sheets included."""
    for count in prisms:
        scenes = [Directions(sheet="detailed", prisms=count, alpha=alpha) for alpha in alphas]
        yield from _pixels(f"2x{count}, {len(alphas)} alphas", scenes, size)
    if others:
        yield from _pixels(f"{others} scenes at random", any_window(others, seed=1), size)


def any_window(count: int, seed: int) -> list[Directions]:
    """Windows of 12 to 3000 prisms at all alphas, for eyes 0.3 to 60 tiles off, half of them aside."""
    random = np.random.default_rng(seed)
    scenes = []
    for n in range(count):
        number = int(np.exp(random.uniform(np.log(12), np.log(3001))))
        E = (n % 2) * complex(random.uniform(-1, 1), random.uniform(-1.3, 8))
        farthest = Directions(prisms=number, z2=60, alpha=random.uniform(-180, 180), E=E)
        nearest = max(0.3, farthest.depth / 2 + 0.05)
        scenes.append(farthest.model_copy(update={"z2": nearest * (60 / nearest) ** random.uniform()}))
    return scenes


def _pixels(kind: str, scenes: list[Directions], size: Size) -> Iterator[Measured]:
    designed, agree, sensitive = [], [], []
    for scene, told in zip(scenes, probes.frames(scenes, size), strict=True):
        inside, direction = probes.rays(scene, size)
        found = probes.traced(scene, direction, prediction.max_trace_level(scene))
        off = np.nan_to_num(np.linalg.norm(told[inside] - found.direction, axis=1), nan=np.inf)
        seen = (found.end <= End.BACK) & (found.count < prediction.max_trace_level(scene))
        designed.append((off < 1e-3)[seen & found.designed])
        agree.append((off < 1e-3)[seen])
        sensitive.append(_sensitive(scene, direction[seen & (off >= 1e-3)]))
    yield Measured(
        "detailed", f"{kind}: pixels on the designed path within 1e-3 rad of the ray trace",
        100 * np.concatenate(designed).mean(), 99.99, "%", least=True,
    )  # fmt: skip
    yield Measured(
        "detailed", f"{kind}: all pixels whose ray leaves, likewise",
        100 * np.concatenate(agree).mean(), 99.5, "%", least=True,
    )  # fmt: skip
    told_by_rounding = np.concatenate(sensitive)
    yield Measured(
        "detailed", f"{kind}: of the {len(told_by_rounding)} others not decided by rounding",
        100 * (1 - told_by_rounding).mean() if len(told_by_rounding) else 0, 1, "%",
    )  # fmt: skip


# tiles: POV-Ray takes no face that is nearer to the last than its tolerance, 1e-6
EDGE = 1e-6
# radians, times N: POV-Ray keeps vertices to 1e-7 tiles, which tilts the faces of prisms 2.4/N wide
TILT = 1e-7


def _sensitive(scene: Directions, direction: np.ndarray) -> np.ndarray:
    """Which rays POV-Ray's rounding can send elsewhere.

    Those that take another path, or leave 5e-4 rad aside, if they come to the sheets up to EDGE aside and turned by
    TILT N; and those that meet two faces within EDGE, as at an edge.
    """
    most = prediction.max_trace_level(scene)
    path = probes.traced(scene, direction, most)
    sensitive = np.zeros(len(direction), bool)
    eye = np.array([scene.E.real, scene.E.imag, -scene.z2])
    front = eye + direction * ((scene.z2 - 0.51 * scene.depth) / direction[:, 2:])
    across = np.cross(direction, (0, 1, 0))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = np.cross(direction, across)
    for n in range(16):
        angle = n * pi / 8
        turn = scene.prisms * TILT * np.exp(5j * angle)  # in all combinations with the side
        turned = direction + turn.real * across + turn.imag * other
        aside = front + EDGE * np.array([np.cos(angle), np.sin(angle), 0])
        neighbour = probes.traced(scene, turned, most, aside)
        sensitive |= (neighbour.faces != path.faces).any(1) | (neighbour.end != path.end)
        sensitive |= np.linalg.norm(neighbour.direction - path.direction, axis=1) > 5e-4
    # where each ray meets its first face, its second ...; the last of them again where it has met them all
    places = [probes.traced(scene, direction, most=met).position for met in range(1, path.count.max(initial=0) + 1)]
    for met, (place, after) in enumerate(pairwise(places), 1):
        sensitive |= (np.linalg.norm(after - place, axis=1) < EDGE) & (path.count > met)
    return sensitive


def finite_prisms(
    prisms: tuple[int, ...] = (25, 50, 100, 200, 400, 800, 1600), count: int = 8, size: Size = SMALL
) -> Iterator[Measured]:
    """The apparent position through prisms against eq. 7 and against the paraxial prediction for thick sheets."""
    thin = [errors(targets("detailed", count, seed=3, E=0j, prisms=number), size)[0] for number in prisms]
    slope = np.polyfit(np.log(prisms), np.log(thin), 1)[0]
    yield Measured(
        "detailed", f"error of eq. 7 falls as N^k, N = {prisms[0]} to {prisms[-1]}: |k + 1|", abs(slope + 1), 0.15
    )


# |alpha|, degrees: from and to where the paraxial prediction for 100 prisms is measured, and what it may leave
RANGES = (((0, 8), 0.5), ((8, 150), 0.1), ((150, 180), 0.4))


def paraxial_prediction(count: int = 12, size: Size = SMALL) -> Iterator[Measured]:
    """What the paraxial prediction leaves of eq. 7's error, by alpha: near 0 it does not know of the moire bands."""
    for between, most in RANGES:
        thin, thick = errors(targets("detailed", count, seed=5, E=0j, alphas=between, prisms=100), size)
        kind = f"2x100, |alpha| {between[0]} to {between[1]} deg"
        yield Measured(
            "detailed", f"{kind}: paraxial prediction's error ({px(thick):.2f} px) over eq. 7's", thick / thin, most
        )


def errors(scenes: list[Positions], size: Size) -> tuple[float, float]:
    """The errors of eq. 7 and of the scenes' own prediction, tiles, RMS of where objects are seen."""
    thin, thick = [], []
    for scene, seen in located(scenes, size):
        ideal = rotation.apparent_position(scene.L, scene.E, scene.z1, scene.z2, radians(scene.alpha))
        thin.append(abs(seen.place - ideal))
        thick.append(abs(seen.place - scene.apparent_position(scene.L, scene.z1)))
    return rms(thin), rms(thick)


def hyperbola(size: Size = SMALL) -> Iterator[Measured]:
    """Through a single sheet a line along the normal at (X, Y) is seen as a hyperbola, (x - X/2)(y - Y/2) = XY/4."""
    L = 0.45 + 0.3j
    scenes = [
        Positions(sheet="single", prisms=1600, z1=z1, L=L, extent=0.1) for z1 in (0.4, 0.8, 1.3, 1.8, 2.4, 3, 3.5)
    ]
    place = np.array([seen.place for _, seen in located(scenes, size)])
    x, y = place.real, place.imag
    # x y = p x + q y + const
    fit = np.linalg.lstsq(np.column_stack((x, y, np.ones(len(x)))), x * y, rcond=None)[0]
    away = abs(x * y - (fit[0] * x + fit[1] * y + fit[2])) / np.hypot(y - fit[0], x - fit[1])
    yield Measured("detailed", "single sheet: a line along the normal off its hyperbola, rms", px(rms(away)), 0.2, "px")
    middle = abs(fit[1] + 1j * fit[0] - L / 2)
    yield Measured("detailed", "single sheet: the hyperbola's centre against L/2", px(middle), 2, "px")
    y = (fit[0] * L.real + fit[2]) / (L.real - fit[1])
    yield Measured(
        "detailed", "single sheet: the hyperbola off L, where the line meets the sheet", px(abs(y - L.imag)), 2, "px"
    )


def designed_fraction(alphas: tuple[float, ...] = (30, 66, 120, 170), size: Size = SMALL) -> Iterator[Measured]:
    """The fraction of pixels that show light rotated by alpha, by field angle, against the exact ray trace."""
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
    """alpha, field angle, the fraction of pixels that show rotated light, and the same by the exact ray trace.

    The fields are rings of 5 deg.
    """
    scenes = [Directions(sheet="detailed", alpha=alpha, z2=z2) for alpha in alphas]
    for scene, told in zip(scenes, probes.frames(scenes, size), strict=True):
        inside, direction = probes.rays(scene, size)
        turned = rotation.rotate(direction, radians(scene.alpha))
        found = probes.traced(scene, direction, prediction.max_trace_level(scene))
        rendered = np.linalg.norm(told[inside] - turned, axis=1) < 1e-3
        exact = (np.linalg.norm(found.direction - turned, axis=1) < 1e-3) & (found.end == End.THROUGH)
        exact &= found.count < prediction.max_trace_level(scene)
        field = np.degrees(np.arccos(direction[:, 2])) // 5
        for ring in np.unique(field):
            pixels = field == ring
            if pixels.sum() > 500:
                yield scene.alpha, 5 * ring + 2.5, rendered[pixels].mean(), exact[pixels].mean()


def targets(
    sheet: str, count: int, seed: int, E: complex, alphas: tuple[float, float] = (0, 180), **values
) -> list[Positions]:
    """Objects at random distances that are seen at random places of the window, magnified less than 10 times.

    |alpha| lies between `alphas`, degrees.
    """
    random = np.random.default_rng(seed)
    scenes: list[Positions] = []
    while len(scenes) < count:
        alpha, z1, z2 = random.uniform(-180, 180), np.exp(random.uniform(np.log(1), np.log(30))), random.uniform(3, 8)
        alpha = np.copysign(alphas[0] + abs(alpha) / 180 * (alphas[1] - alphas[0]), alpha)
        place = complex(*random.uniform(-0.8, 0.8, 2))
        M = rotation.M(z2 / z1, radians(alpha))
        # the object is seen as 0.4 tiles wide
        if M < 10:
            L = rotation.object_position(place, E, z1, z2, radians(alpha))
            values |= {"alpha": alpha, "z1": z1, "z2": z2, "L": L, "extent": 0.3 / M}
            scenes.append(Positions(sheet=sheet, E=E, **values))
    return scenes


NOWHERE = probes.Seen(complex("nan"), complex("nan"), complex("nan"))


def located(scenes: list[Positions], size: Size) -> Iterator[tuple[Positions, probes.Seen]]:
    """Each scene, and where its square is seen, in tiles; NOWHERE where it is not, which holds no bound."""
    place = probes.pixels(size)
    for scene, told in zip(scenes, probes.frames(scenes, size), strict=True):
        inside, _ = probes.rays(scene, size)
        yield scene, probes.locate(place[inside], transverse(told[inside]), scene.extent) or NOWHERE


def transverse(told: np.ndarray) -> np.ndarray:
    return told[..., 0] + 1j * told[..., 1]


def _unit(direction: np.ndarray) -> np.ndarray:
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True)


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def px(tiles: float) -> float:
    """Pixels of a picture of 1280x960."""
    return float(tiles * HD[1] / VIEW)
