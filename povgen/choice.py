"""The cheapest model of the sheets, and sampling, that keeps a picture within a tolerance: `--sheet auto`.

Position errors follow from the scene's own numbers, by eq. 7 and the paraxial prediction; picture errors and CPU
seconds from what `povgen chart` measured of one scene (measured.csv), by the pitch of the prisms in pixels, and from
how much worse others are (`BEATS`, `STRAY`). What is right is the picture through the scene's own prisms, converged.
"""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import inf, radians, sqrt
from pathlib import Path

import numpy as np

from povgen import limits, rotation
from povgen.errors import InputError
from povgen.rendering import Rendering
from povgen.scenes import Scene

MEASURED = Path(__file__).with_name("measured.csv")
FAR = 1000.0  # tiles: where the horizon and the sky are, as good as
# How many times the chart's FLIP a picture's may be: through prisms by alpha (degrees), for where those of the near
# sheet lie along the pixels' rows or diagonals they beat with them; of the ideal sheet by the share of stray light.
BEATS = ((0, 66, 80, 90, 95, 100, 120, 150, 165, 180), (1.1, 1.1, 1.2, 1.55, 1.7, 1.5, 1.1, 1.1, 1.35, 2.75))
STRAY = 1.15, 0.4  # factor; share of stray light in the chart's scene
ALLOWED = "allowed: a number of pixels, as 1px, or of mean FLIP, as 0.2flip, or both, as 1px,0.2flip"


@dataclass(frozen=True)
class Tolerance:
    """The most that a picture may be off: in pixels of position, and in mean FLIP inside the window."""

    px: float = inf
    flip: float = inf

    @classmethod
    def parse(cls, text: str) -> "Tolerance":
        """From text such as '1px', '0.2flip', '1px,0.2flip'. Raises InputError."""
        given = {}
        for part in text.split(","):
            match = re.fullmatch(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(px|flip)\s*", part, re.ASCII)
            if not match or match[2] in given or not 0 < float(match[1]) < inf:
                raise InputError(f"tolerance = {text[:40]!r}: not one; {ALLOWED}")
            given[match[2]] = float(match[1])
        return cls(**given)


@dataclass(frozen=True)
class Candidate:
    """A model and a sampling, what it costs (CPU seconds of a 320x240 frame) and how far off it is expected to be."""

    sheet: str
    antialias: str
    cpu: float
    px: float
    flip: float

    def meets(self, tolerance: Tolerance) -> bool:
        """Whether both errors are within the tolerance."""
        return self.px <= tolerance.px and self.flip <= tolerance.flip

    def __str__(self) -> str:
        return f"sheet {self.sheet}, antialias {self.antialias} ({self.px:.2g} px, {self.flip:.2g} FLIP)"


def candidates(scenes: Sequence[Scene], rendering: Rendering, antialias: str | None = None) -> list[Candidate]:
    """What could make the pictures of scenes with detailed sheets, the cheapest first, with the worst of their errors.

    All measured samplings, or one. Raises InputError where that one is not measured.
    """
    pixels = [scene.window / scene.view_height * rendering.size[1] / scene.prisms for scene in scenes]
    measured = _measured()
    samplings = dict.fromkeys(sampling for _, sampling in measured)
    if antialias is not None and antialias not in samplings:
        raise InputError(f"antialias = {antialias!r}: not measured; allowed with sheet auto: {' '.join(samplings)}")
    off = {
        sheet: max(_position_error(scene, sheet) * rendering.size[1] / scene.view_height for scene in scenes)
        for sheet in ("none", "ideal", "detailed")
    }
    worse = {"detailed": [_beats(scene) for scene in scenes], "ideal": [_stray(scene) for scene in scenes]}
    ghost = any(getattr(scene, "ghost", False) for scene in scenes)
    unturned = all(scene.alpha % 360 == 0 for scene in scenes)
    found = []
    for (sheet, sampling), table in measured.items():
        if antialias in (None, sampling):
            costs, errors = (np.interp(np.log(pixels), np.log(table[0]), y) for y in table[1:])
            cpu, flip = float(np.max(costs)), float(np.max(errors * worse[sheet]))
            found.append(Candidate(sheet, sampling, cpu, off[sheet], flip))
            if sheet == "ideal" and not ghost:
                # no sheet: saves the ideal one's camera alone, and the picture is another unless alpha is 0
                found.append(Candidate("none", sampling, 0.99 * cpu, off["none"], flip if unturned else 1.0))
    return sorted(found, key=lambda candidate: candidate.cpu)


def choose(
    scenes: Sequence[Scene], rendering: Rendering, tolerance: Tolerance, antialias: str | None = None
) -> tuple[Candidate, str]:
    """The cheapest candidate that meets the tolerance in every scene, and why, in a line.

    Raises InputError where none does.
    """
    ranked = candidates(scenes, rendering, antialias)
    n = next((n for n, candidate in enumerate(ranked) if candidate.meets(tolerance)), None)
    if n is None:
        best = min(ranked, key=lambda candidate: (candidate.px > tolerance.px, candidate.flip))
        raise InputError(f"tolerance: none meets it; the nearest is {best}; allowed: no less than that")
    cheaper = f"; the next cheaper, {ranked[n - 1]}, is not" if n else ""
    return ranked[n], f"{ranked[n]}: the cheapest within tolerance{cheaper}"


@cache
def _measured() -> dict[tuple[str, str], tuple[list[float], list[float], list[float]]]:
    """For each sheet and sampling: pixels per prism, CPU seconds as of 320x240, and mean FLIP against prisms."""
    tables: dict = {}
    with MEASURED.open(newline="") as file:
        for row in csv.DictReader(file):
            if row["method"] in ("ideal", "detailed") and not row["antialias"].startswith("box"):
                x, cpu, flip = tables.setdefault((row["method"], row["antialias"]), ([], [], []))
                height = int(row["height"])
                x.append(Scene.window / Scene.view_height * height / 100)
                cpu.append(float(row["CPU s"]) * (240 / height) ** 2)
                flip.append(float(row["FLIP against prisms"]))
    return tables


def _beats(scene: Scene) -> float:
    """By how much the prisms' FLIP may exceed the chart's."""
    return float(np.interp(abs((scene.alpha + 180) % 360 - 180), *BEATS))


def _stray(scene: Scene) -> float:
    """By how much the ideal sheet's FLIP may exceed the chart's."""
    factor, share = STRAY
    return factor * sqrt((1 - limits.survey(scene).proper) / share)


def _position_error(scene: Scene, sheet: str) -> float:
    """How far from where the scene's prisms show it a sheet shows anything that is seen in the window, tiles.

    Infinite where eq. 7 is not to be trusted.
    """
    if sheet == "detailed":
        return 0.0
    alpha = radians(scene.alpha)
    side = np.linspace(-0.45, 0.45, 5) * scene.window
    place = (side + 1j * side[:, None]).ravel()
    worst = 0.0
    for z1 in (*scene.distances, FAR):
        L = rotation.object_position(place, scene.E, z1, scene.z2, alpha)
        prisms = scene.seen(L, z1)
        if rotation.condition(scene.z2 / z1, alpha) > limits.CONDITION:
            return inf
        shown = place if sheet == "ideal" else rotation.apparent_position(L, scene.E, z1, scene.z2, 0.0)
        worst = max(worst, float(abs(shown - prisms).max()))
    return worst
