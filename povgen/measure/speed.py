"""CPU seconds and errors of pictures, for every model of the sheets and every useful sampling: `povgen chart`.

A sampling is the choice of rays for a pixel, `Rendering.antialias`. CPU seconds are what the operating system reports
of POV-Ray and of povgen, which reduces larger pictures. The POV-Ray processes run one at a time. They are measured in
several rounds, in the same order, and the median of the rounds counts. The renderer gl is measured in the same rounds,
if this system has OpenGL: CPU seconds are those of drawing, on all cores, and of writing the picture. The live view is
measured in these rounds too, in a Chromium that draws without a GPU, if one is installed: CPU seconds are what all
processes of Chromium use for a picture. A picture is compared, inside the window, with a converged picture of the same
scene (81 rays a pixel). Its errors are the RMS difference of gamma-encoded colours (0 black to 1 white) and the mean of
FLIP. FLIP says how different two pictures look, 0 to 1. Errors of position are RMS distances from the position by the
formula for infinitely fine sheets, in pixels of 1280x960. For one window that rotates light, this formula is eq. 7.
"""

import os
import platform
import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from math import ceil
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from statistics import median
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError
from povgen.files import temporary_folder
from povgen.measure.browser import View, chromium
from povgen.measure.drawn import Drawn
from povgen.measure.measured import SMALL, px, rms
from povgen.measure.probes import Positions, Size
from povgen.measure.targets import located, other_targets, series_targets, targets
from povgen.rendering import parallel, povray
from povgen.rendering.flip import CONVERGED, flip
from povgen.rendering.frames import read_png
from povgen.rendering.light import Picture, linear
from povgen.scene import camera
from povgen.scene.scenes import Chess, Scene
from povgen.scene.sdl import to_pov
from povgen.scene.spec import MovieSpec
from povgen.settings import Rendering
from povgen.sheets import OTHER
from povgen.video.build import movie

# A file with one macro `Sheet`. It must not change names of the scene: it contains no #declare and no other macro.
BASELINE = re.compile(r"(?:\s|//[^\n]*\n)*#macro Sheet\b(?:(?!#\s*(?:declare|macro)\b).)*#end\s*", re.DOTALL)

SIZES = ((160, 120), (320, 240), (640, 480))
MAIN_SIZE = SIZES[1]
SAMPLINGS = (
    *("off", "1,0.9,2", "1,0.3,2", "1,0.1,2", "1,0.9,3", "1,0.3,3", "1,0.1,3", "1,0.3,4", "1,0.1,4"),
    *("2,0.9,1", "2,0.3,1", "2,0.9,2", "2,0.3,2", "2,0.1,2", "2,0.3,3", "2,0.1,3", "1.5x", "2x", "3x", "4x"),
)
POVRAY_DEFAULT = "1,0.3,3"  # POV-Ray's own antialiasing, +A0.3
BASELINE_SAMPLINGS = ("off", "1,0.9,2", POVRAY_DEFAULT)
# the renderer gl draws the same number of rays in every pixel: METHOD and THRESHOLD of POV-Ray do not matter
GL_SAMPLINGS = ("off", "2x", "3x", "4x", "1,0.1,2", "1,0.1,3", "1,0.1,4", "1,0.1,8")
LIVE_RAYS = (1, 4, 16, 64)  # a pixel
FLICKER_SAMPLINGS = ("off", "1,0.9,2", "1.5x", "1,0.1,2", "2x")
FLICKER_ANGLES, FLICKER_STEP = (66.0, 120.0), 0.25  # alpha of two frames, and the difference to the next frame, degrees
PRISM_COUNTS = (25, 50, 100, 200, 400, 800, 1600, 3000)
FURTHER_WINDOWS = ("alpha=120,z=2", "alpha=40,z=4")  # behind the first one, which has alpha = 120
WORKER_COUNTS = (1, 2, 4, 8, 16)
MOVIE: MovieSpec | str = "vary-alpha"
ROUNDS = 5


@dataclass
class Point:
    """A point of the chart: a way to make a picture, its CPU seconds, and the picture's error."""

    method: str  # 'detailed' or 'ideal', alone (by POV-Ray) or after 'gl ' or 'live '; or a baseline's name
    sampling: str
    size: Size
    # makes the picture: returns CPU seconds and the picture. None for a point from a table
    make: Callable[[], tuple[float, Picture]] | None = field(repr=False)
    seconds: list[float] = field(default_factory=list, repr=False)
    picture: Picture = field(init=False, repr=False)
    rms: float = np.nan
    flip: float = np.nan
    flip_detailed: float = np.nan  # compared with the converged picture through prisms, for every method

    @property
    def cpu(self) -> float:
        """Return the median CPU seconds of the frame."""
        return median(self.seconds)


def machine() -> str:
    """Describe this machine in one line."""
    cores = parallel.cores()
    return f"{platform.machine()}, {cores} cores, POV-Ray {povray.version()}, Python {platform.python_version()}"


def baselines(folder: Path) -> dict[str, str]:
    """Return the hand-written macros `Sheet` from a folder's .inc files, by the files' names without suffix.

    Raises InputError if the folder cannot be read or contains no such file, and for a file that is not one macro
    `Sheet` with #local names, or whose name ends with 'detailed' or 'ideal'.
    """
    try:
        found = {path.stem: path.read_text("utf-8") for path in sorted(folder.glob("*.inc"))}
    except (OSError, ValueError) as error:  # ValueError: not UTF-8
        reason = getattr(error, "strerror", "not UTF-8")
        raise InputError(f"baselines = {str(folder)!r}: {reason}; allowed: a folder of .inc files") from None
    if not found:
        raise InputError(f"baselines = {str(folder)!r}: no .inc file in it; allowed: a folder of .inc files")
    for name, text in found.items():
        if name.endswith(("detailed", "ideal")):
            raise InputError(
                f"baselines = {str(folder)!r}: {name}.inc: allowed: a name that is none of povgen's methods"
            )
        if not BASELINE.fullmatch(text):
            raise InputError(f"baselines = {str(folder)!r}: {name}.inc: allowed: a macro Sheet whose names are #local")
    return found


def sample(text: str, sampling: str, size: Size) -> tuple[float, Picture]:
    """Render a scene's text by POV-Ray. Return the CPU seconds of POV-Ray and of povgen, and the picture.

    Raises PovrayError if POV-Ray fails.

    No other child process is allowed to end during the call, and no other thread to work: their CPU seconds would be
    counted too.
    """
    with temporary_folder() as folder:
        before = _cpu()
        path = povray.run(text, Rendering(size=size, antialias=sampling), folder)
        return _cpu() - before, read_png(path)


def drawn_sample(view: Drawn, sampling: str, size: Size) -> tuple[float, Picture]:
    """Return the CPU seconds that the renderer gl uses for a picture, in all threads, and the picture.

    If the scene has been drawn before, this does not include the time to start OpenGL and to compile the shaders.
    """
    with temporary_folder() as folder:
        before = _cpu()
        view.save(folder / "frame.png", Rendering(renderer="gl", size=size, antialias=sampling))
        picture = read_png(folder / "frame.png")
        return _cpu() - before, picture


def median_seconds(scenes: Iterable[Scene]) -> list[float]:
    """Return the median CPU seconds of each scene, of 640x480 pixels without antialiasing."""
    texts = [to_pov(scene) for scene in scenes]
    rounds = [[sample(text, "off", SMALL)[0] for text in texts] for _ in range(ROUNDS)]
    return [median(seconds) for seconds in zip(*rounds, strict=True)]


def picture_error(picture: Picture, reference: Picture, scene: Scene) -> tuple[float, float]:
    """Return the RMS difference (0 to 1) and the mean FLIP of two pictures, inside the window."""
    height, width = reference.shape[:2]
    window = camera.window(scene, (width, height))
    a, b = (image[window].astype(float) / 255 for image in (reference, picture))
    return rms(a - b), float(flip(picture[window], reference[window]).mean())


def measure_samplings(sheet_macros: Mapping[str, str], done: Callable[[str], object]) -> list[Point]:
    """Measure every method with every sampling. `sheet_macros` are the macros that `baselines` returns.

    A method is a baseline, or a model of the sheets by POV-Ray, by the renderer gl or by the live view. Calls `done`
    with the name of each finished step. If OpenGL or Chromium is missing, `done` is told so, and what needs it is not
    measured.
    """
    scenes = {"detailed": Chess(), "ideal": Chess(sheet="ideal")}
    texts = {method: to_pov(scene) for method, scene in scenes.items()}
    texts |= {name: to_pov(scenes["detailed"], sheet_macro=macro) for name, macro in sheet_macros.items()}
    points = [
        Point(method, sampling, size, partial(sample, text, sampling, size))
        for method, text in texts.items()
        for size in (SIZES if method in scenes else (MAIN_SIZE,))
        for sampling in (SAMPLINGS if method in scenes else BASELINE_SAMPLINGS)
    ]
    with ExitStack() as opened:
        for name, further in (("the renderer gl", gl_points), ("the live view", live_points)):
            try:
                points += further(scenes, opened)
            except InputError as error:
                done(f"without {name}: {error}")
        for number in range(ROUNDS):
            for point in points:
                # only one round for the largest size: its frames take long, and their times vary little
                if point.make and (number == 0 or point.size != SIZES[-1]):
                    seconds, point.picture = point.make()
                    point.seconds.append(seconds)
            done(f"frames, round {number + 1} of {ROUNDS}")
    for size in SIZES:
        right = {method: sample(texts[method], CONVERGED, size)[1] for method in scenes}
        for point in points:
            if point.size == size:
                own = right["ideal" if point.method.endswith("ideal") else "detailed"]
                point.rms, point.flip = picture_error(point.picture, own, scenes["detailed"])
                point.flip_detailed = picture_error(point.picture, right["detailed"], scenes["detailed"])[1]
        done(f"converged pictures of {size[0]}x{size[1]}")
    return points


def gl_points(scenes: Mapping[str, Scene], _: ExitStack) -> list[Point]:
    """Return the points of the renderer gl. Raises InputError without OpenGL."""
    points = []
    for method, scene in scenes.items():
        view = Drawn(scene)
        view.picture(SIZES[0], 1)  # the first picture compiles the shaders
        points += [
            Point(f"gl {method}", sampling, size, partial(drawn_sample, view, sampling, size))
            for size, sampling in product(SIZES, GL_SAMPLINGS)
        ]
    return points


def live_points(scenes: Mapping[str, Scene], opened: ExitStack) -> list[Point]:
    """Return the live view's points, to be measured before `opened` is closed. Raises InputError without a Chromium."""
    browser, points = opened.enter_context(chromium()), []
    for method, scene in scenes.items():
        view = View(browser, scene)
        view.picture(SIZES[0], 1)  # the first picture compiles the shaders
        for size, rays in product(SIZES, LIVE_RAYS):
            repeats = ceil(500_000 / (size[0] * size[1] * rays))  # a small picture takes less than the clock's step
            make = partial(view.measured, size, rays, repeats=repeats)
            points.append(Point(f"live {method}", f"{rays} ray{'s' * (rays > 1)}", size, make))
    return points


def measure_flicker(done: Callable[[str], object]) -> Iterator[tuple[str, float]]:
    """Yield each sampling and the flicker of a movie in which alpha grows.

    Flicker is the mean, over the window, of |change of light from a frame to the next, less the same change in
    converged pictures|. Light is linear, 0 black to 1 white. The change that belongs to the movement does not
    count.
    """
    texts = [to_pov(Chess(alpha=alpha + step)) for alpha in FLICKER_ANGLES for step in (0, FLICKER_STEP)]
    window = camera.window(Chess(), MAIN_SIZE)

    def changes(sampling: str) -> NDArray[np.float32]:
        frames = np.array([linear(sample(text, sampling, MAIN_SIZE)[1][window]) for text in texts])
        return np.asarray(frames[1::2] - frames[::2])

    right = changes(CONVERGED)
    for sampling in FLICKER_SAMPLINGS:
        yield sampling, float(abs(changes(sampling) - right).mean())
    done("flicker")


def pareto_front(points: Sequence[Point], error: str) -> list[Point]:
    """Return the points for which no other point has both fewer CPU seconds and less error, the cheapest first.

    `error` is the name of a field of `Point`.
    """
    best, least = [], np.inf
    for point in sorted(points, key=lambda point: point.cpu):
        if getattr(point, error) < least:
            best.append(point)
            least = getattr(point, error)
    return best


def measure_prism_counts(done: Callable[[str], object]) -> Iterator[tuple[str, int, float, float]]:
    """Yield sheet, number of prisms, CPU seconds, and position error in pixels of 1280x960.

    The CPU seconds are for 640x480 pixels without antialiasing.
    """
    cases = [("ideal", 100), *(("detailed", count) for count in PRISM_COUNTS)]
    seconds = median_seconds(Chess(sheet=sheet, prisms=count) for sheet, count in cases)
    for (sheet, count), cpu in zip(cases, seconds, strict=True):
        yield sheet, count, cpu, position_error(targets(sheet, 6, seed=3, E=0j, prisms=count))
        done(f"{sheet}, {count} prisms")


def measure_beyond(done: Callable[[str], object]) -> Iterator[tuple[str, str, float, float]]:
    """Yield a kind of sheet, how many windows or which sheet, CPU seconds, and position error in pixels of 1280x960.

    These are one to three windows in series, and the other ideal sheets. The CPU seconds are for 640x480 pixels without
    antialiasing. The error is the distance from the formula for infinitely fine sheets.
    """
    cases: list[tuple[str, str, Scene, list[Positions]]] = []
    for sheet, count in product(("ideal", "detailed"), range(1, 4)):
        shown = Chess(sheet=sheet, alpha=120, window=FURTHER_WINDOWS[: count - 1], z2=8)
        cases.append((sheet, str(count), shown, series_targets(sheet, count, 6, seed=3, E=0j)))
    for sheet, measured in other_targets().items():
        cases.append(("other ideal sheets", sheet, Chess(sheet=sheet, z2=5, **OTHER[sheet].examples[0]), measured))
    seconds = median_seconds(shown for _, _, shown, _ in cases)
    for (kind, name, _, measured), cpu in zip(cases, seconds, strict=True):
        yield kind, name, cpu, position_error(measured)
        done(f"{kind}: {name}")


def position_error(scenes: list[Positions]) -> float:
    """Return the RMS distance of apparent positions from the formula for fine sheets, in pixels of 1280x960."""
    off = []
    for scene, seen in located(scenes, SMALL):
        fine = scene.replace(sheet="ideal") if scene.has_prisms else scene
        off.append(abs(seen.position - fine.apparent_position(scene.L, scene.z1)))
    return px(rms(off))


def measure_workers(done: Callable[[str], object]) -> Iterator[tuple[int, float, float, int]]:
    """Yield the number of workers, a movie's wall seconds, the fraction of the cores' time used, and the cores.

    The movie has 61 small frames. povgen's cache is not used.
    """
    cores = parallel.cores()
    for count in WORKER_COUNTS:
        with temporary_folder() as folder, empty_cache(folder / "cache"):
            before, start = _cpu(), time.monotonic()
            movie(MOVIE, folder / "movie.mp4", size=MAIN_SIZE, antialias="off", workers=count, progress=False)
            wall = time.monotonic() - start
            yield count, wall, (_cpu() - before) / wall / cores, cores
        done(f"a movie with {count} workers")


def empty_cache(folder: Path) -> AbstractContextManager[object]:
    """Return a context in which an empty folder is used instead of povgen's cache."""
    return patch.dict(os.environ, POVGEN_CACHE=str(folder))


def _cpu() -> float:
    """Return the CPU seconds so far of this process and of its finished children."""
    return sum(usage.ru_utime + usage.ru_stime for usage in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))
