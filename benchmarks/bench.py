"""What povgen costs, compared with baselines, as a table and as JSON: `make bench`.

CPU seconds are what the operating system reports of each finished process. povgen and a baseline run alternately. The
table gives the medians of the times and of their ratios. Mitsuba runs in its own environment; `make bench` makes it.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median

import numpy as np
from charts import MAIN_SIZE, baselines
from mitsuba_points import fastest
from rich.console import Console
from rich.table import Table

from povgen import Bundle, Chess, Rendering, to_pov
from povgen.measure import speed
from povgen.rendering.flip import CONVERGED

HERE = Path(__file__).parent
PLAIN = Rendering(size=(640, 480), antialias="off")


Line = tuple[str, str, float, float, float, float | None]  # povgen, baseline, their values, ratio, greatest ratio


def paired(ours: Callable[[], float], theirs: Callable[[], float], rounds: int) -> tuple[float, float, float]:
    """Call two functions alternately. Return the medians of what they return, and of the ratio."""
    times = [(ours(), theirs()) for _ in range(rounds)]
    return median(a for a, _ in times), median(b for _, b in times), median(a / b for a, b in times)


def cpu(text: str, rendering: Rendering = PLAIN) -> Callable[[], float]:
    return lambda: speed.sample(text, rendering.sampling, rendering.size)[0]


def help_seconds() -> float:
    before = getrusage(RUSAGE_CHILDREN)
    subprocess.run([Path(sys.executable).with_name("povgen"), "--help"], check=True, stdout=subprocess.DEVNULL)
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def traced(sheet: str) -> float:
    """Return the CPU seconds for a million rays through the default scene's window, with this sheet."""
    random = np.random.default_rng(0).uniform(-1.1, 1.1, (1_000_000, 2))
    rays = Bundle((0, 0, -6), np.column_stack((random, np.full(len(random), 6.0))))
    scene = Chess(sheet=sheet)
    start = time.process_time()
    scene.trace(rays)
    return time.process_time() - start


MOVIE = """
import sys
from povgen import MovieSpec, movie
spec = MovieSpec.load("vary-alpha")
movie(spec.model_copy(update={"frames": int(sys.argv[1]), "fixed": {**spec.fixed, "sheet": sys.argv[2]}}), sys.argv[3],
      size=(int(sys.argv[4]), int(sys.argv[4]) * 3 // 4))
# not ru_maxrss, which a process takes over from the one that starts it
print(next(int(line.split()[1]) / 1024 for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""


def movie(frames: int, sheet: str, width: int) -> tuple[float, float]:
    """Make a movie in its own process. Return the fraction of the cores that was busy, and the peak memory, MiB."""
    with tempfile.TemporaryDirectory() as folder:
        before, start = getrusage(RUSAGE_CHILDREN), time.monotonic()
        arguments = [sys.executable, "-c", MOVIE, str(frames), sheet, f"{folder}/movie.mp4", str(width)]
        environment = {**os.environ, "POVGEN_CACHE": folder}
        done = subprocess.run(arguments, check=True, stdout=subprocess.PIPE, text=True, env=environment)
        wall, after = time.monotonic() - start, getrusage(RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return used / wall / len(os.sched_getaffinity(0)), float(done.stdout)


def lines() -> Iterator[Line]:
    """Yield the lines of the table."""
    detailed = to_pov(Chess())
    by_hand = {name: to_pov(Chess(), sheet_macro=macro) for name, macro in baselines().items()}
    for name, text in by_hand.items():
        bound = 0.25 if name == "intersections" else None
        yield "detailed, CPU s", f"union of {name}", *paired(cpu(detailed), cpu(text), 5), bound
    if len(sys.argv) > 1:
        other = fastest(sys.argv[1])
        name = f"Mitsuba 3 {other.variant}, the same mesh"
        yield "detailed, CPU s", name, *paired(cpu(detailed), lambda: other.sample(PLAIN.size, 1)[0], 5), 0.9
    yield equal_error(detailed, by_hand["intersections"])
    ideal, none = to_pov(Chess(sheet="ideal")), to_pov(Chess(sheet="none"))
    for sampling in ("off", "1,0.9,2", "1,0.3,3", "2,0.3,2", "2,0.1,3"):
        rendering = Rendering(size=PLAIN.size, antialias=sampling)
        rounds = 25 if sampling == "off" else 7
        yield (
            f"ideal, antialias {sampling}, CPU s",
            "no sheet",
            *paired(cpu(ideal, rendering), cpu(none, rendering), rounds),
            1.1,
        )
    yield "3000 prisms, CPU s", "100 prisms", *paired(cpu(to_pov(Chess(prisms=3000))), cpu(detailed), 5), 1.3
    busy, _ = movie(61, "detailed", 480)
    yield "a movie: cores not busy, %", "all", 100 * (1 - busy), 100, 1 - busy, 0.1
    yield (
        "a movie of 181 frames, peak MiB",
        "of 61",
        *(memory := [movie(frames, "none", 160)[1] for frames in (181, 61)]),
        memory[0] / memory[1],
        1.1,
    )
    seconds = median(help_seconds() for _ in range(15))
    yield "povgen --help, CPU s", "a second", seconds, 1, seconds, 0.3
    for sheet, name, most in (("detailed", "", 5), ("ideal", ", ideal sheet", 0.5)):
        seconds = traced(sheet)
        yield f"ray trace{name}, a million rays, CPU s", "a second", seconds, 1, seconds, most


def equal_error(detailed: str, by_hand: str) -> Line:
    """Compare the hand-written scene at +A0.3 with povgen's cheapest sampling whose picture is no worse."""
    scene, size = Chess(), MAIN_SIZE
    reference = speed.sample(detailed, CONVERGED, size)[1]
    theirs, picture = speed.sample(by_hand, "1,0.3,3", size)
    wanted = speed.picture_error(picture, reference, scene)[0]
    found = []
    for sampling in speed.SAMPLINGS:
        seconds, picture = speed.sample(detailed, sampling, size)
        if speed.picture_error(picture, reference, scene)[0] <= 1.01 * wanted:
            found.append((seconds, sampling))
    ours, sampling = min(found)
    return f"detailed, {sampling}, CPU s", "intersections at +A0.3, as good", ours, theirs, ours / theirs, 0.25


def main() -> None:
    table = Table("povgen", "baseline", "povgen's", "baseline's", "ratio", "bound", title=speed.machine())
    figures = []
    for name, baseline, ours, theirs, ratio, bound in lines():
        table.add_row(name, baseline, *(f"{x:.3g}" for x in (ours, theirs, ratio)), f"{bound or ''}")
        figures.append(
            {"povgen": name, "baseline": baseline, "ours": ours, "theirs": theirs, "ratio": ratio, "bound": bound}
        )
        print(f"{name}: {ours:.3g}; {baseline}: {theirs:.3g}; ratio {ratio:.3g}", file=sys.stderr, flush=True)
    Console(width=None if sys.stdout.isatty() else 120).print(table)
    text = json.dumps({"machine": speed.machine(), "figures": figures}, indent=2) + "\n"
    Path("build/bench.json").write_text(text)


if __name__ == "__main__":
    main()
