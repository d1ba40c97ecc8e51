"""The cheapest model of the sheets, and sampling, that keeps a picture within a tolerance: `--sheet auto`.

Position errors follow from the scene's own numbers, by eq. 7 and the paraxial prediction. Picture errors are measured:
candidates are rendered in small blocks of the scene's own window, and compared with what is right there, the picture
through the scene's own prisms, converged.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isnan, nan, radians, sqrt

import numpy as np

from povgen.errors import InputError, validated
from povgen.files import temporary_folder
from povgen.measure import probes, speed
from povgen.optics import rotation
from povgen.rendering import povray
from povgen.rendering.frames import read_png
from povgen.rendering.parallel import thread_pool
from povgen.scene import limits
from povgen.scene.models import Scene
from povgen.scene.sdl import Mosaic, to_pov
from povgen.settings import Rendering

FAR = 1000.0  # tiles: where the horizon and the sky are, as good as
# Samplings, the cheapest first, for prisms and for the sheet that stands in for them, which needs fewer rays. Each is
# on or near the front of FLIP against cost (docs/speed.md); the dearest stand-in costs about as much as the first of
# the prisms.
STAND_IN = ("off", "1,0.1,2", "1,0.1,4")
PRISMS = ("off", "1,0.9,2", "1,0.5,2", "1,0.1,2", "1,0.1,3", "1,0.1,4")
CONVERGED = speed.CONVERGED
SHARE = 0.15  # of the window's pixels that a trial renders, at most
SIDE = 10  # of its blocks, pixels, about: many small blocks tell more of the window than a few large ones
LEAST = 4  # blocks in a row and in a column
MOSAIC = 20, 100  # the least and the greatest side of all blocks together, pixels
FRAMES = 8  # of a movie that are tried, at most
MARGIN = 0.8  # standard errors of the mean over the blocks by which a picture must keep its tolerance
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
    """A model of the sheets and a sampling, how far off it is, and by how much its FLIP may be more; nan: not tried."""

    sheet: str
    antialias: str
    px: float
    flip: float = nan
    margin: float = nan

    def __str__(self) -> str:
        flip = "" if isnan(self.flip) else f", {self.flip:.2g}±{self.margin:.1g} FLIP"
        return f"sheet {self.sheet}, antialias {self.antialias} ({self.px:.2g} px{flip})"


class _Part(Rendering):
    """A mosaic, which may be smaller than any picture."""

    size: tuple[int, int]


def choose(
    scenes: Sequence[Scene], rendering: Rendering, tolerance: Tolerance, antialias: str | None = None
) -> tuple[Candidate, str]:
    """The cheapest sheets and sampling for scenes with detailed sheets that meet the tolerance, and why, in a line.

    Positions are predicted in every scene; pictures are tried in `FRAMES` of them at most. `antialias` stands for all
    samplings. Raises InputError where none meets it, or where flip-evaluator is missing; PovrayError.
    """
    # POV-Ray's own picture has no sheet where light is not turned
    plain = all(scene.alpha % 360 == 0 and not getattr(scene, "predicted_image", False) for scene in scenes)
    stand_in = "none" if plain else "ideal"
    off = {
        sheet: max(_position_error(scene, sheet) * rendering.size[1] / scene.view_height for scene in scenes)
        for sheet in (stand_in, "detailed")
    }
    ladders = [
        [Candidate(sheet, sampling, off[sheet]) for sampling in ([antialias] if antialias else samplings)]
        for sheet, samplings in ((stand_in, STAND_IN), ("detailed", PRISMS))
    ]
    kept = [ladder for ladder in ladders if ladder[0].px <= tolerance.px]
    reason = f"; {ladders[0][0]} is not" if len(kept) < len(ladders) else ""
    if tolerance.flip == inf:
        return kept[0][0], f"{kept[0][0]}: the cheapest within tolerance{reason}"
    trial = _Trial(scenes, rendering.size)
    for ladder in kept:
        low, high = 0, len(ladder)  # the cheapest that will do is among these, or there is none
        while low < high:
            middle = (low + high) // 2
            tried = ladder[middle] = trial.of(ladder[middle])
            if tried.flip + tried.margin <= tolerance.flip:
                high = middle
            else:
                low, reason = middle + 1, f"; the next cheaper, {tried}, is not"
        if low < len(ladder):
            return ladder[low], f"{ladder[low]}: the cheapest within tolerance{reason}"
    best = min((c for ladder in kept for c in ladder if not isnan(c.flip)), key=lambda c: c.flip + c.margin)
    raise InputError(f"tolerance: none meets it; the nearest is {best}; allowed: no less than that")


class _Trial:
    """What candidates make of a few small blocks of a few scenes' windows, against what is right there."""

    def __init__(self, scenes: Sequence[Scene], size: tuple[int, int]):
        speed.flip_evaluator()  # missed before anything is rendered
        chosen = np.unique(np.linspace(0, len(scenes) - 1, FRAMES).round().astype(int))
        self.mosaics = [(scenes[n], found) for n in chosen if (found := mosaic(scenes[n], size))]
        self.right = self._pictures("detailed", CONVERGED)

    def of(self, candidate: Candidate) -> Candidate:
        """The candidate with its mean FLIP, and the margin, in the scene where they are worst."""
        pictures = self._pictures(candidate.sheet, candidate.antialias)
        worst = (0.0, 0.0)  # where the window shows nothing
        for (_, part), picture, right in zip(self.mosaics, pictures, self.right, strict=True):
            blocks = _flip(picture, right, part.side)
            if candidate.sheet == "detailed":
                # FLIP minds a pixel's surroundings. Noise at the edges of a block counts for too much beside other
                # blocks, and for as much too little beside the block itself (3 %, in the mean of 14 scenes).
                blocks = (blocks + _flip(picture, right, part.side, part.side // 2)) / 2
            margin = MARGIN * float(blocks.std(ddof=1)) / sqrt(blocks.size)
            worst = max(worst, (float(blocks.mean()), margin), key=sum)
        return replace(candidate, flip=worst[0], margin=worst[1])

    def _pictures(self, sheet: str, antialias: str) -> list[np.ndarray]:
        def render(source: str, part: Mosaic) -> np.ndarray:
            size = part.side * len(part.blocks[0]), part.side * len(part.blocks)
            with temporary_folder() as folder:
                return read_png(runner.run(source, validated(_Part, {"size": size, "antialias": antialias}), folder))

        runner = povray.Runner()
        with thread_pool(runner) as pool:
            # texts are made in this thread: rays are traced for them in Python, which a signal interrupts only here
            texts = [to_pov(scene.model_copy(update={"sheet": sheet}), part) for scene, part in self.mosaics]
            return list(pool.map(render, texts, [part for _, part in self.mosaics]))


def mosaic(scene: Scene, size: tuple[int, int]) -> Mosaic | None:
    """Blocks of the window's pixels, each at random in a part of the window of its own; None where it is not seen."""
    inside, _ = probes.rays(scene, size)
    if not inside.any():
        return None
    y, x = probes.window(scene, size)
    height, width = y.stop - y.start, x.stop - x.start
    whole = min(float(np.clip(sqrt(SHARE * height * width), *MOSAIC)), height, width)
    count = max(LEAST, round(whole / SIDE))
    side = max(1, int(whole / count))
    shift = np.random.default_rng(1).uniform(size=(2, count, count))
    rows = y.start + ((np.arange(count)[:, None] + shift[0]) / count * (height - side)).round().astype(int)
    columns = x.start + ((np.arange(count) + shift[1]) / count * (width - side)).round().astype(int)
    return Mosaic(size, side, np.stack((columns, rows), axis=-1).tolist())


def _flip(picture: np.ndarray, right: np.ndarray, side: int, around: int = 0) -> np.ndarray:
    """Mean FLIP of each block of a mosaic, (rows, columns), with `around` pixels of itself, repeated, about each."""
    extent, columns = side + 2 * around, picture.shape[1] // side
    index = np.arange(-around, side + around) % side

    def repeated(mosaic: np.ndarray) -> np.ndarray:
        blocks = mosaic.reshape(-1, side, columns, side, 3)[:, index][:, :, :, index]
        return blocks.reshape(-1, columns * extent, 3)

    off = speed.flip(repeated(picture), repeated(right)).reshape(-1, extent, columns, extent)
    inner = slice(around, around + side)
    return off[:, inner, :, inner].mean((1, 3))


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
        prisms = scene.apparent_position(L, z1)
        if rotation.condition(scene.z2 / z1, alpha) > limits.MAX_CONDITION:
            return inf
        shown = place if sheet == "ideal" else rotation.apparent_position(L, scene.E, z1, scene.z2, 0.0)
        worst = max(worst, float(abs(shown - prisms).max()))
    return worst
