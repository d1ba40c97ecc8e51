"""CPU seconds beside error: every model of the sheets and every useful sampling, measured in one run, `povgen chart`.

CPU seconds are the operating system's account of the finished POV-Ray process, one at a time; medians of rounds in
turn.
Picture errors are inside the window, against a converged picture of the same scene: RMS of gamma-encoded colours
(0 black to 1 white), and the mean of FLIP. Position errors are RMS against eq. 7, pixels of 1280x960.
"""

import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from statistics import median
from types import ModuleType
from unittest import mock

import numpy as np

from povgen.errors import InputError
from povgen.files import temporary_folder
from povgen.measure import probes
from povgen.measure.verify import SMALL, located, px, rms, targets
from povgen.optics import rotation
from povgen.rendering import povray
from povgen.rendering.frames import read_png
from povgen.scene.models import Chess, Scene
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering
from povgen.video.build import movie

SIZES = ((160, 120), (320, 240), (640, 480))
MAIN = SIZES[1]
# POV-Ray's antialiasing: method, threshold, depth; and k x k pixels averaged to one, box k
SAMPLINGS = (
    *("off", "1,0.9,2", "1,0.3,2", "1,0.1,2", "1,0.9,3", "1,0.3,3", "1,0.1,3", "1,0.3,4", "1,0.1,4"),
    *("2,0.9,1", "2,0.3,1", "2,0.9,2", "2,0.3,2", "2,0.1,2", "2,0.3,3", "2,0.1,3", "box 2", "box 3", "box 4"),
)
USUAL = "1,0.3,3"  # POV-Ray's own, +A0.3
BY_HAND = ("off", "1,0.9,2", USUAL)
CONVERGED = "1,0.001,9"
COUNTS = (25, 50, 100, 200, 400, 800, 1600, 3000)
WORKERS = (1, 2, 4, 8, 16)
ROUNDS = 5


@dataclass
class Point:
    """A way to make a picture, what it costs and how far it is from right."""

    method: str
    sampling: str
    size: tuple[int, int]
    text: str = field(repr=False)
    seconds: list[float] = field(default_factory=list, repr=False)
    picture: np.ndarray = field(init=False, repr=False)
    rms: float = np.nan
    flip: float = np.nan
    flip_detailed: float = np.nan  # against the prisms' picture, whatever the method

    @property
    def cpu(self) -> float:
        """CPU seconds of the frame, median."""
        return median(self.seconds)


def machine() -> str:
    """The machine that measures, in a line."""
    cores = len(os.sched_getaffinity(0))
    return f"{platform.machine()}, {cores} cores, POV-Ray {povray.version()}, Python {platform.python_version()}"


def rewrites(folder: Path) -> dict[str, Callable[[str], str]]:
    """From a folder of macros `Sheet` in .inc files, by their names: what puts each in place of povgen's own.

    Raises InputError where there is none.
    """

    def by_hand(macro: str, text: str) -> str:
        start, end = text.index("#macro Sheet("), text.index("Sheet(0, (Length")
        return text[:start] + macro + text[end:]

    try:
        found: dict[str, Callable[[str], str]] = {
            path.stem: partial(by_hand, path.read_text("utf-8")) for path in sorted(folder.glob("*.inc"))
        }
    except (OSError, ValueError) as error:  # ValueError: not UTF-8
        reason = getattr(error, "strerror", "not UTF-8")
        raise InputError(f"baselines = {str(folder)!r}: {reason}; allowed: a folder of .inc files") from None
    if not found:
        raise InputError(f"baselines = {str(folder)!r}: no .inc file in it; allowed: a folder of .inc files")
    return found


def cpu_seconds(text: str, rendering: Rendering) -> tuple[float, np.ndarray]:
    """CPU seconds that POV-Ray took for a scene's text, and its picture, (height, width, 3) bytes.

    No other child process may end meanwhile.
    """
    with temporary_folder() as folder:
        before = getrusage(RUSAGE_CHILDREN)
        path = povray.run(text, rendering, folder)
        after = getrusage(RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, read_png(path)


def sample(text: str, sampling: str, size: tuple[int, int]) -> tuple[float, np.ndarray]:
    """CPU seconds and picture for antialiasing as POV-Ray's, or 'box k'."""
    if not sampling.startswith("box"):
        return cpu_seconds(text, Rendering(size=size, antialias=sampling))
    k = int(sampling.split()[1])
    seconds, picture = cpu_seconds(text, Rendering(size=(k * size[0], k * size[1]), antialias="off"))
    # light is averaged, not its gamma-encoded value
    light = (picture / 255.0) ** 2.2
    light = light.reshape(size[1], k, size[0], k, 3).mean((1, 3))
    return seconds, np.round(255 * light ** (1 / 2.2)).astype(np.uint8)


def picture_error(picture: np.ndarray, reference: np.ndarray, scene: Scene) -> tuple[float, float]:
    """RMS difference (0 to 1) and mean FLIP of two pictures, bytes, inside the window."""
    height, width = reference.shape[:2]
    window = probes.window(scene, (width, height))
    a, b = (image[window].astype(float) / 255 for image in (reference, picture))
    return rms(a - b), float(flip(picture[window], reference[window]).mean())


def flip(picture: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """FLIP of each pixel of two pictures, (height, width, 3) bytes. Raises InputError where it cannot be measured."""
    a, b = (np.ascontiguousarray(image / np.float32(255), np.float32) for image in (reference, picture))
    return flip_evaluator().evaluate(a, b, "LDR", applyMagma=False)[0][..., 0]


def flip_evaluator() -> ModuleType:
    """What measures FLIP. Raises InputError where it is not installed."""
    try:
        import flip_evaluator
    except ImportError:
        text = "FLIP is measured with flip-evaluator, which is not installed: pip install 'povgen[charts]'"
        raise InputError(f"{text}; tolerances in px do without") from None
    return flip_evaluator


def frames(baselines: dict[str, Callable[[str], str]], done: Callable[[str], object]) -> list[Point]:
    """Every method with every sampling. Each of `baselines` turns povgen's .pov of detailed sheets into its own."""
    detailed, ideal = Chess(), Chess(sheet="ideal")
    texts = {"detailed": to_pov(detailed), "ideal": to_pov(ideal)}
    texts |= {name: by_hand(texts["detailed"]) for name, by_hand in baselines.items()}
    points = [
        Point(method, sampling, size, text)
        for method, text in texts.items()
        for size in (SIZES if method in ("detailed", "ideal") else (MAIN,))
        for sampling in (SAMPLINGS if method in ("detailed", "ideal") else BY_HAND)
    ]
    for turn in range(ROUNDS):
        for point in points:
            if turn == 0 or point.size != SIZES[-1]:  # whose frames are long, and noise small beside them
                seconds, point.picture = sample(point.text, point.sampling, point.size)
                point.seconds.append(seconds)
        done(f"frames, round {turn + 1} of {ROUNDS}")
    for size in SIZES:
        right = {method: sample(texts[method], CONVERGED, size)[1] for method in ("detailed", "ideal")}
        for point in points:
            if point.size == size:
                own = right["ideal" if point.method == "ideal" else "detailed"]
                point.rms, point.flip = picture_error(point.picture, own, detailed)
                point.flip_detailed = picture_error(point.picture, right["detailed"], detailed)[1]
        done(f"converged pictures of {size[0]}x{size[1]}")
    return points


def front(points: Sequence[Point], error: str) -> list[Point]:
    """The points that no other beats in both CPU seconds and the named error, the cheapest first."""
    best, least = [], np.inf
    for point in sorted(points, key=lambda point: point.cpu):
        if getattr(point, error) < least:
            best.append(point)
            least = getattr(point, error)
    return best


def prism_counts(done: Callable[[str], object]) -> Iterator[tuple[str, int, float, float]]:
    """Sheet, prisms, CPU seconds of 640x480 pixels without antialiasing, and position error, pixels of 1280x960."""
    rendering = Rendering(size=SMALL, antialias="off")
    cases = [("ideal", 100), *(("detailed", count) for count in COUNTS)]
    texts = [to_pov(Chess(sheet=sheet, prisms=count)) for sheet, count in cases]
    seconds = [[cpu_seconds(text, rendering)[0] for text in texts] for _ in range(ROUNDS)]
    for (sheet, count), times in zip(cases, zip(*seconds, strict=True), strict=True):
        yield sheet, count, median(times), position_error(sheet, count)
        done(f"{sheet}, {count} prisms")


def position_error(sheet: str, prisms: int) -> float:
    """RMS distance of objects, as seen, from where eq. 7 has them, pixels of 1280x960."""
    off = []
    for scene, seen in located(targets(sheet, 6, seed=3, E=0j, prisms=prisms), SMALL):
        place = rotation.apparent_position(scene.L, scene.E, scene.z1, scene.z2, np.radians(scene.alpha))
        off.append(abs(seen.place - place))
    return px(rms(off))


def movies(workers: Sequence[int], done: Callable[[str], object]) -> Iterator[tuple[int, float, float]]:
    """Workers, wall seconds of a movie of 61 small frames, and the fraction of the cores that was busy meanwhile."""
    cores = len(os.sched_getaffinity(0))
    for count in workers:
        with temporary_folder() as folder, mock.patch.dict(os.environ, POVGEN_CACHE=str(folder / "cache")):
            before, start = _cpu(), time.monotonic()
            movie("vary-alpha", folder / "movie.mp4", size=MAIN, antialias="off", workers=count)
            wall = time.monotonic() - start
            yield count, wall, (_cpu() - before) / wall / cores
        done(f"a movie with {count} workers")


def _cpu() -> float:
    """CPU seconds so far of this process and of those it has waited for."""
    return sum(usage.ru_utime + usage.ru_stime for usage in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))
