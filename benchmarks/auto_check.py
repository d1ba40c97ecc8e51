"""Check what `--sheet auto` promises on random scenes, and print a table: `make auto-check`.

The arguments are the number of scenes, and the renderers that povgen may choose: povray or auto. Results are kept in
build/auto-check, so that a stopped run can continue and nothing is rendered twice. CPU seconds are what the operating
system reports of the processes that draw, for whole frames and for whole trials.
"""

import json
import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import asdict, dataclass
from hashlib import sha256
from itertools import repeat
from math import exp, inf, log
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from povgen import Chess, Rendering, Spheres, to_pov
from povgen.errors import InputError
from povgen.files import write
from povgen.measure import speed
from povgen.measure.opengl import OpenGLView
from povgen.rendering import auto
from povgen.rendering.flip import CONVERGED
from povgen.scene.presets import PIECES
from povgen.scene.scene import Scene
from povgen.scene.spec import MovieSpec

KEPT = Path("build/auto-check")
SEED = 2009
MOVIES = (("vary-alpha", 0.3), ("vary-z1", 0.2), ("spheres", 0.3))  # movie, tolerance (mean FLIP)
AUTO_SOURCE = Path(auto.__file__).read_text()  # kept trials are used until this changes
PROCESSES = len(os.sched_getaffinity(0))
RENDERERS = {"povray": ("povray",), "auto": auto.RENDERERS}
Ordered = tuple[str, str, str]  # a candidate: renderer, sheet, sampling


@dataclass
class Found:
    """The choice for one scene, the error that the trial expected, and what whole frames show."""

    scene: str
    tolerance: float
    renderer: str
    sheet: str | None  # None: refused, because no candidate keeps the tolerance
    antialias: str | None
    flip: float  # of the whole window; if refused, of the best candidate
    expected: float
    cost_ratio: float  # CPU seconds of the choice divided by CPU seconds of the cheapest candidate within tolerance
    trial: float  # CPU seconds of the trial divided by CPU seconds of a converged frame

    @property
    def missed(self) -> bool:
        return self.sheet is not None and self.flip > self.tolerance


def draw(number: int) -> tuple[Scene, tuple[int, int], float]:
    """Draw a random scene. Return the scene, the size and the tolerance (mean FLIP)."""
    rng = np.random.default_rng((SEED, number))

    def spread(least: float, greatest: float) -> float:
        """Draw a number, evenly in its logarithm, to three digits."""
        return float(f"{exp(rng.uniform(log(least), log(greatest))):.3g}")

    height = 2 * round(spread(60, 240))
    shared = dict(prisms=round(spread(15, 600)), alpha=round(float(rng.uniform(-180, 180)), 1), z2=spread(2, 25))
    z1, piece, tolerance = spread(1, 20), str(rng.choice(list(PIECES))), spread(0.08, 0.5)
    if rng.integers(2):
        scene: Scene = Spheres(**shared)
    else:
        clear = Chess(**shared | {"z1": 5}).depth / 2 + 0.45  # the least z1 at which no piece touches the window frame
        scene = Chess(**shared, z1=max(z1, round(clear, 2)), piece=piece)
    return scene, (2 * round(height * 2 / 3), height), tolerance


def kept(text: str, what: object, make: Callable[[], Any]) -> Any:
    """Return what `make` returns, which JSON can represent, or what it returned in an earlier run."""
    key = "\0".join([text, json.dumps(what), AUTO_SOURCE if what == "tried" else ""])
    path = KEPT / f"{sha256(key.encode()).hexdigest()[:32]}.json"
    if not path.is_file():
        write(json.dumps(make()).encode(), path)
    return json.loads(path.read_text())


def converged(scene: Scene, size: tuple[int, int]) -> tuple[float, np.ndarray]:
    """Return the CPU seconds and the picture of the converged frame, the reference."""
    text = to_pov(scene)
    path = KEPT / f"{sha256(f'{text}{size}'.encode()).hexdigest()[:32]}.npz"
    if not path.is_file():
        cpu, picture = speed.sample(text, CONVERGED, size)
        with path.with_suffix(".part").open("wb") as file:
            np.savez_compressed(file, cpu=cpu, picture=picture)
        path.with_suffix(".part").rename(path)
    with np.load(path) as data:
        return float(data["cpu"]), data["picture"]


def measured(scene: Scene, size: tuple[int, int], candidate: Ordered) -> tuple[float, float]:
    """Return the CPU seconds and the mean FLIP of a candidate's whole frame."""
    renderer, sheet, sampling = candidate
    shown = scene.model_copy(update={"sheet": sheet})

    def make() -> list[float]:
        if renderer == "gl":
            view = OpenGLView(shown)
            view.picture(size, 1)  # the first picture compiles the shaders
            cpu, picture = speed.drawn_sample(view, sampling, size)
        else:
            cpu, picture = speed.sample(to_pov(shown), sampling, size)
        return [cpu, speed.picture_error(picture, converged(scene, size)[1], scene)[1]]

    cpu, flip = kept(to_pov(shown), [size, candidate], make)
    return cpu, flip


def spent() -> float:
    """Return the CPU seconds of this process's children so far, also of the one that goes on to draw with OpenGL."""
    ended, ticks = getrusage(RUSAGE_CHILDREN), 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # the process has ended
            _, parent, *numbers = stat.read_text().rpartition(")")[2].split()
            ticks += (int(parent) == os.getpid()) * sum(map(int, numbers[9:11]))
    return ended.ru_utime + ended.ru_stime + ticks / os.sysconf("SC_CLK_TCK")


def tried(scenes: list[Scene], size: tuple[int, int], tolerance: float, renderers: str) -> Any:
    """Return the choice as a dictionary, with the CPU seconds of the trial."""

    def make() -> dict[str, Any]:
        before = spent()
        try:
            chosen, _ = auto.choose(
                scenes, Rendering(size=size), auto.Tolerance(flip=tolerance), None, RENDERERS[renderers]
            )
            found = asdict(chosen)
        except InputError:
            found = {"renderer": "povray", "sheet": None, "antialias": None, "flip": inf, "margin": 0}
        return found | {"cpu": spent() - before}

    return kept("".join(map(to_pov, scenes)) + f"{size} {tolerance} {renderers}", "tried", make)


def check(number: int, renderers: str) -> Found:
    """Choose for a random scene, and render the frames that are needed to judge the choice."""
    scene, size, tolerance = draw(number)
    chosen = tried([scene], size, tolerance, renderers)
    order = [
        (renderer, sheet, sampling)
        for renderer in RENDERERS[renderers]
        for sheet, samplings in (("ideal", auto.IDEAL_SAMPLINGS), ("detailed", auto.prism_samplings(renderer)))
        for sampling in samplings
    ]
    refused = chosen["sheet"] is None
    place = len(order) - 1 if refused else order.index(candidate(chosen))
    cpu, flip = measured(scene, size, order[place])
    cost_ratio = inf if refused and flip <= tolerance else 1.0
    if not refused:
        costs = [measured(scene, size, candidate) for candidate in order[:place]]
        cost_ratio = max([1.0, *(cpu / cost for cost, error in costs if error <= tolerance)])
    trial = chosen["cpu"] / converged(scene, size)[0]
    name = f"{scene.name} {size[0]}x{size[1]} N {scene.prisms} α {scene.alpha} z2 {scene.z2:g}"
    return Found(name, tolerance, *candidate(chosen), flip, chosen["flip"], cost_ratio, trial)


def candidate(chosen: dict[str, Any]) -> Ordered:
    """Return the candidate of a choice."""
    return chosen["renderer"], chosen["sheet"], chosen["antialias"]


def check_movie(name: str, tolerance: float, renderers: str) -> tuple[str, float, float]:
    """Return the choice, and two ratios.

    The first is the worst FLIP of frames that were not tried, divided by the tolerance. The second is the trial's CPU
    seconds divided by a converged frame's.
    """
    size = (160, 120)
    scenes = [scene.model_copy(update={"sheet": "detailed"}) for scene in MovieSpec.load(name).scenes("standard")]
    chosen = tried(scenes, size, tolerance, renderers)
    between = [scenes[round((k + 0.5) * (len(scenes) - 1) / 7)] for k in range(7)]
    flip = max(measured(scene, size, candidate(chosen))[1] for scene in between)
    cost = float(np.mean([converged(scene, size)[0] for scene in between]))
    return " ".join([f"{name}:", *candidate(chosen)]), flip / tolerance, chosen["cpu"] / cost


def main(count: int, renderers: str) -> bool:
    KEPT.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(PROCESSES) as pool:
        found = []
        for number, one in enumerate(pool.map(check, range(count), repeat(renderers))):
            found.append(one)
            print(f"{number}: {one}", file=sys.stderr, flush=True)
        movies = list(pool.map(check_movie, *zip(*MOVIES, strict=True), repeat(renderers)))
    missed = [one for one in found if one.missed]
    far = [one for one in found if one.missed and one.flip > 1.1 * one.tolerance]
    costly = [one for one in found if not one.missed and one.cost_ratio > 1.5]
    share = max(one.trial for one in found)
    rows = [
        ("tolerance kept, scenes", len(found) - len(missed), 0.98 * count, True),
        ("missed by more than 10 %, scenes", len(far), 0, False),
        (
            "at most 1.5 times as costly as the cheapest that keeps it, scenes",
            len(found) - len(costly),
            0.9 * count,
            True,
        ),
        ("greatest cost of a trial, converged frames", share, 0.2, False),
        ("greatest cost of a movie's trial, converged frames", max(cost for *_, cost in movies), 2, False),
        (
            "worst FLIP of a movie's frames that were not tried, tolerances",
            max(worst for _, worst, _ in movies),
            1.1,
            False,
        ),
    ]
    table = Table("", "measured", "bound", "", title=f"--sheet auto --renderer {renderers} on {count} random scenes")
    for what, value, bound, least in rows:
        holds = value >= bound if least else value <= bound
        table.add_row(what, f"{value:.3g}", f"{'≥' if least else '≤'} {bound:g}", "ok" if holds else "FAILS")
    console = Console(width=120)
    console.print(table)
    refused = sum(one.sheet is None for one in found)
    ideal = sum(one.sheet == "ideal" for one in found)
    drawn = sum(one.renderer == "gl" for one in found)
    console.print(f"chosen: {ideal} ideal, {count - ideal - refused} detailed, {refused} refused; {drawn} by gl")
    for one in missed + costly:
        console.print(one)
    for movie in movies:
        console.print(*movie)
    return all(value >= bound if least else value <= bound for _, value, bound, least in rows)


if __name__ == "__main__":
    sys.exit(not main(int(sys.argv[1]), sys.argv[2]))
