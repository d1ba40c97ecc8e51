"""Compare what POV-Ray renders with the equations and the exact ray trace: `povgen verify`. The table of checks.

A check renders probes: scenes whose colours encode numbers (`compare.ghosts` renders nothing). Random scenes have fixed
seeds. To prove that a check can fail, the tests compare other scenes than those that the check expects.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import radians
from typing import Any

import numpy as np

from povgen.measure import compare, verify_paths
from povgen.measure.measured import HD, SMALL, Measured
from povgen.measure.probes import Directions, Light, PiecePositions, Positions, Size, White
from povgen.measure.targets import SERIES, other_targets, series_targets, targets
from povgen.optics import series
from povgen.scene.eye_and_windows import APERTURE, VIEW


@dataclass(frozen=True)
class Check:
    """A way of measuring, its scenes, and a line of the result for each of the first numbers that the way returns.

    A line has what is measured, its bound, the unit, and whether the bound is the least allowed value. {n} in its first
    text is the number of scenes; {0}, {1} ... are the numbers.
    """

    sheet: str  # the model of the sheets, for the result
    way: compare.Way
    scenes: Sequence[Any]
    lines: Sequence[tuple[Any, ...]]
    size: Size = SMALL
    # what is added to values of the scenes to get other scenes, for which at least one line must fail
    wrong: Mapping[str, float] = field(default_factory=lambda: {"alpha": 0.5})

    def measured(self) -> Iterator[Measured]:
        """Measure the scenes, and compare with the bounds."""
        numbers = self.way(self.scenes, self.size)
        for (what, *bound), number in zip(self.lines, numbers, strict=False):
            yield Measured(self.sheet, what.format(*numbers, n=len(self.scenes)), number, *bound)


SHORT_ALPHAS = (0, 35, 90, 180)
# Ranges of |alpha|, degrees, each with the greatest ratio of the paraxial prediction's error to eq. 7's error. It is
# large near alpha = 0: nearly parallel ridges show bands (moire), which the prediction ignores.
ALPHA_RANGES = (((0, 8), 0.5), ((8, 150), 0.1), ((150, 180), 0.4))
BUILDS_WITH_ERRORS: dict[str, dict[str, Any]] = {  # of building
    "index and base angle": {"error": {"index": 0.1, "far_index": -0.05, "base_angle": 5, "far_base_angle": -3}},
    "turn, tilts and separation": {"error": {"turn": 2, "tilt_x": 3, "far_tilt_y": 2, "separation": 0.1}},
    "single facets": {"prisms": 30, "error": {"facets": 1, "seed": 5}},
    "heights of single prisms": {"prisms": 30, "error": {"pitches": 0.05, "seed": 5}},
}
# Parameters of sheets. The f-numbers are 2.8 or more: of rays through steeper lenses, a few percent graze the end of an
# arc, and rounding decides their path.
PROFILES: dict[str, tuple[dict[str, Any], ...]] = {
    "confocal lenticular arrays": (
        {"sheet": "lenticular"},
        {"sheet": "lenticular", "alpha": 120, "ratio": 0.7, "f_number": 4, "eye": (0.3, 0.2)},
        {"sheet": "lenticular", "lenses": 400, "f_number": 5, "alpha": 180},
    ),
    "thin lenticulars, wedges, Dove prisms as a profile": (
        {"sheet": "profile", "profile": "lenticulars", "alpha": 35},
        {"sheet": "profile", "profile": "wedges", "arrangement": "single"},
        {"sheet": "profile", "profile": "dove", "alpha": 90},
    ),
}
MISMATCHED = {  # errors of building, which the renderer gl does not show
    "lenticular arrays of different pitch": (
        {"sheet": "lenticular", "error": {"pitch": 0.05, "far_pitch": -0.03}, "eye": (0.3, 0.2)},
        {"sheet": "lenticular", "error": {"pitch": 0.001}},
    )
}


def checks(sheet: str | None = None) -> Iterator[Measured]:
    """Measure everything, or only what concerns one model of the sheets: 'ideal' or 'detailed'."""
    for check in table(sheet):
        yield from check.measured()
    if sheet is None:
        yield from verify_paths.checks()


def table(sheet: str | None = None) -> Iterator[Check]:
    """Yield the checks of both models of the sheets, or of one."""
    if sheet != "detailed":
        yield from ideal()
        yield from ideal_series()
    if sheet != "ideal":
        yield from prisms()
        yield from lenses()
        yield from prisms_in_series()
        yield from light()


def ideal() -> Iterator[Check]:
    """One window with an ideal sheet."""
    scenes: list[Any] = [*targets("ideal", 20, 7, 0j), *targets("ideal", 20, 8, 0.3 - 0.4j)]
    lines = [
        ("apparent position against eq. 7, {n} scenes, worst", 0.05, "px"),
        ("nu of these objects against eq. 8 corrected, worst", 0.1, "deg"),
        ("M of these objects against eq. 9 corrected, worst", 0.2, "%"),
    ]
    yield Check("ideal", compare.positions, [*scenes, *targets("ideal", 20, 9, 8.6j)], lines, HD)
    for E, where in ((0j, "in front of the window"), (0.5 - 0.5j, "to the side"), (8.6j, "far to the side")):
        scenes = [Directions(sheet="ideal", alpha=alpha, eye=E) for alpha in (66, 180, 0)]
        line = f"direction against the rotation, eye {where}, worst pixel", 1e-4, "rad"
        yield Check("ideal", compare.directions, scenes, [line], HD)
    pieces = ((25, 3, "pawn"), (66, 2, "knight"), (90, 6, "queen"), (140, 1, "rook"), (-66, 4, "king"))
    shown = {"sheet": "ideal", "z2": 6, "x": 0.1, "eye": (0, -0.33)}
    scenes = [PiecePositions(**shown, alpha=alpha, z1=z1, piece=piece) for alpha, z1, piece in pieces]
    lines = [
        ("nu of {n} chess pieces against eq. 8 corrected, worst", 0.1, "deg"),
        ("M of {n} chess pieces against eq. 9 corrected, worst", 0.2, "%"),
    ]
    yield Check("ideal", compare.pieces, scenes, lines, HD)
    scenes = [Directions(sheet="ideal", alpha=alpha) for alpha in (-120, 30, 66, 90, 180)]
    yield Check("ideal", compare.horizon, scenes, [("the horizon turned by alpha, worst of {n}", 0.1, "deg")], HD)
    yield parallax("alpha = 180 deg: image distance -z1", *({"alpha": 180, "z1": z1} for z1 in (1.0, 2.0, 4.0)))
    kinds = (("none", 0), ("ideal", 66), ("ideal", -120))
    points = [Positions(sheet=sheet, alpha=alpha, z1=2, z2=3, L=0.3 + 0.2j) for sheet, alpha in kinds]
    lines = [
        ("irradiance by a point: abs(1 - RMS of the differences from cos^3 / standard errors), worst of {n}", 0.1, ""),
        ("irradiance by a point: power that enters against the solid angle, worst of {n}", 0.3, "%"),
    ]
    yield Check("ideal", compare.screens, points, lines, wrong={"alpha": 5})
    for sheet, scenes in other_targets().items():
        line = f"sheet {sheet}: apparent position, {{n}} scenes, worst", 0.1, "px"
        yield Check("ideal", compare.positions, scenes, [line], HD, {"L": 0.05})  # some kinds have no alpha


def ideal_series() -> Iterator[Check]:
    """Several windows with ideal sheets."""
    for windows in (2, 3):
        scenes = [*series_targets("ideal", windows, 6, seed=11, E=0j)]
        scenes += series_targets("ideal", windows, 6, seed=12, E=0.3 - 0.2j)
        line = f"{windows} windows: apparent position against the complex depth, {{n}} scenes, worst", 0.1, "px"
        yield Check("ideal", compare.positions, scenes, [line], HD)
    probes = [
        Directions(sheet="ideal", alpha=120, window=SERIES[0][1:]),
        Directions(sheet="ideal", alpha=50, window=[{"alpha": 75, "z": 1}, {"alpha": -40, "z": 2}], eye=0.3 - 0.2j),
    ]
    line = "2 and 3 windows: direction against the rotations, worst pixel", 1e-4, "rad"
    yield Check("ideal", compare.directions, probes, [line], HD)
    imaging = []
    for first, second, gap in ((120, 120, 2.0), (150, 100, 1.5), (40, -100, 2.0)):
        z1, _ = series.imaged_plane(radians(first), [(gap, radians(second))])
        imaging.append({"alpha": first, "window": [{"alpha": second, "z": gap}], "z1": z1})
    yield parallax("2 windows: image distance", *imaging)


def parallax(what: str, *scenes: dict[str, Any]) -> Check:
    """Compare the image distance, by the parallax between two eyes, with that of the formulas."""
    shown = {"sheet": "ideal", "L": 0.1 + 0.1j, "extent": 0.05}
    pairs = [Positions(**shown, **each, eye=eye) for each in scenes for eye in (-0.2 + 0.1j, 0.25 - 0.1j)]
    line = f"{what} by parallax, worst of {len(scenes)}", 0.2, "%"
    return Check("ideal", compare.parallax, pairs, [line], HD, {"z2": -0.12})


def prisms() -> Iterator[Check]:
    """Two sheets of prisms."""
    for count in (100, 1000):
        yield pixels(f"2x{count}, 4 alphas", *({"alpha": alpha, "prisms": count} for alpha in SHORT_ALPHAS))
    yield pixels("16 scenes at random", *any_window(16, seed=1))
    counts = (25, 50, 100, 200, 400, 800, 1600)
    scenes = [scene for n in counts for scene in targets("detailed", 8, seed=3, E=0j, prisms=n)]
    line = f"error of eq. 7 falls as N^k, N = {counts[0]} to {counts[-1]}: |k + 1|", 0.15
    yield Check("detailed", compare.power_law, scenes, [line], wrong={"L": 0.05})
    for between, most in ALPHA_RANGES:
        scenes = targets("detailed", 12, seed=5, E=0j, alphas=between)
        yield prediction(f"2x100, |alpha| {between[0]} to {between[1]} deg", scenes, most)
    between, most = ALPHA_RANGES[1]
    for index, base_angle in ((1.7, 40), (1.5168, 45), (1.5, 35)):  # dense glass, BK7, and flat prisms
        shape, kind = {"index": index, "base_angle": base_angle}, f"2x100, n = {index:g}, {base_angle:g} deg"
        yield pixels(f"{kind}, 4 alphas", *({"alpha": alpha, **shape} for alpha in SHORT_ALPHAS))
        scenes = targets("detailed", 12, seed=5, E=0j, alphas=between, **shape)
        yield prediction(f"{kind}, |alpha| {between[0]} to {between[1]} deg", scenes, most)
    for kind, values in BUILDS_WITH_ERRORS.items():
        yield pixels(f"errors: {kind}", values)


def pixels(kind: str, *scenes: dict[str, Any], bounds: tuple[float, float] = (99.99, 99.5)) -> Check:
    """Compare the direction that every pixel shows with the exact ray trace, stray light included.

    `bounds` are the least percentages: of the pixels on the designed path, and of all whose rays leave. Rounding
    decides the paths of a few rays.
    """
    within = "within 1e-3 rad of the ray trace"
    lines = [
        (f"{kind}: pixels on the designed path {within}", bounds[0], "%", True),
        (f"{kind}: all pixels whose ray leaves, {within}", bounds[1], "%", True),
    ]
    probes = [Directions(**{"sheet": "detailed", **values}) for values in scenes]
    return Check("detailed", compare.pixels, probes, lines)


def prediction(kind: str, scenes: list[Positions], most: float, formula: str = "eq. 7's error") -> Check:
    """Compare the error of the paraxial prediction with that of a formula for infinitely small prisms."""
    line = f"{kind}: paraxial prediction's error ({{1:.2f}} px) / {formula}", most
    return Check("detailed", compare.prediction, scenes, [line], wrong={"alpha": 3})


def any_window(count: int, seed: int) -> Iterator[dict[str, Any]]:
    """Yield random windows: 12 to 3000 prisms, all alphas, eyes 0.3 to 60 tiles away, half of them off the axis."""
    random = np.random.default_rng(seed)
    for n in range(count):
        number = int(np.exp(random.uniform(np.log(12), np.log(3001))))
        E = (n % 2) * complex(random.uniform(-1, 1), random.uniform(-1.3, 8))
        values = {"prisms": number, "alpha": random.uniform(-180, 180), "eye": E}
        nearest = max(0.3, Directions(**values, z2=60).depth / 2 + 0.05)
        yield {**values, "z2": nearest * (60 / nearest) ** random.uniform()}


def lenses() -> Iterator[Check]:
    """Sheets of lenses and of other profiles, and the ghosts of lenses."""
    for kind, scenes in (PROFILES | MISMATCHED).items():
        yield pixels(kind, *scenes, bounds=(99.9, 99))
    for kind, most, ghosts in (
        ("below 4, spherical aberration", 10, [(3, 66, 2)]),
        ("4 or more", 5, [(4, 66, 2), (6, 40, 1.5), (6, 40, 3)]),
    ):
        probes = [
            Positions(sheet="lenticular", f_number=f_number, alpha=alpha, z1=z1, L=0.05 - 0.3j)
            for f_number, alpha, z1 in ghosts
        ]
        lines = [
            (f"lenses of f-number {kind}: {{n}} objects against the ray trace, worst", 3, "px"),
            (f"lenses of f-number {kind}: {{2}} ghosts against the ray trace, worst", most, "px"),
        ]
        yield Check("detailed", compare.ghosts, probes, lines, (800, 500), {"alpha": 30})
    line = "lenses: slope up to which the designed path has most light, against n p/(4 f), worst of {n}", 5, "%"
    steep = [Directions(sheet="lenticular", f_number=f_number) for f_number in (3, 6, 12)]
    yield Check("detailed", compare.field_of_view, steep, [line], wrong={"index": 0.1})


def prisms_in_series() -> Iterator[Check]:
    """Several windows, each with two sheets of prisms."""
    yield pixels(f"2 windows of 2x100, {len(SERIES)} scenes", *({"alpha": alpha, "window": w} for alpha, *w in SERIES))
    for windows in (2, 3):
        scenes = series_targets("detailed", windows, 12, seed=5, E=0j)
        yield prediction(f"{windows} windows of 2x100", scenes, 0.1, "the complex depth's")


def light() -> Iterator[Check]:
    """The window's brightness (black tops, partial reflection), and the fraction of pixels on the designed path."""
    usual, wrong = {"aperture": APERTURE, "view": VIEW}, {"index": 0.05}
    tops = Directions(sheet="detailed", tops="black", **usual)
    black = "black tops take {1:.1f} % of the pixels: as in the ray trace", 99.5, "%", True
    yield Check("detailed", compare.black_tops, [tops], [black], wrong=wrong)
    lines = [
        ("--fresnel: brightness on the designed path ({2:.3f}) against Fresnel's equations, 99 % of pixels", 0.0005),
        ("--fresnel: its mean against that of polarised light ({3:.3f})", 0.02),
    ]
    square = Light(sheet="detailed", fresnel=True, z1=2, L=0.3 + 0.1j, extent=0.25)
    yield Check("detailed", compare.partial_reflection, [square], lines, wrong=wrong)
    for sheet, name, z2 in (("detailed", "", 6), ("single", "single sheet, ", 60)):
        line = (
            f"--fresnel, {name}z2 = {z2}: brightness of the window ({{1:.3f}}, {{2:.1f}} % reflected), ray trace",
            0.005,
        )
        white = White(sheet=sheet, z2=z2, fresnel=True, **usual)
        yield Check("detailed", compare.reflected_light, [white], [line], wrong=wrong)
    near = [Directions(sheet="detailed", alpha=alpha, z2=1.4) for alpha in (30, 66, 120, 170)]
    line = "fraction of pixels on the designed path, fields of {1:g} to {2:g} deg, worst error", 0.002
    yield Check("detailed", compare.designed_fraction, near, [line])
