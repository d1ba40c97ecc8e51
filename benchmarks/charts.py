"""The charts of docs/speed.md: `python benchmarks/charts.py FOLDER` measures and draws them; it takes an hour.

With `--draw` nothing is measured: the charts are drawn from the tables that are in the folder.
"""

import csv
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import product
from math import ceil
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING
from unittest.mock import patch

import numpy as np

from povgen import Chess, movie, to_pov
from povgen.files import temporary_folder
from povgen.measure import charts, speed
from povgen.measure.browser import View, chromium
from povgen.measure.measured import SMALL, px, rms
from povgen.measure.plotting import GREY, IDEAL, PRISMS, drawn, name_lines, plain_ticks, save_table, table_rows
from povgen.measure.targets import located, other_targets, series_targets, targets
from povgen.progress import say
from povgen.rendering import parallel
from povgen.rendering.flip import CONVERGED
from povgen.rendering.light import linear
from povgen.scene import camera
from povgen.sheets import OTHER

if TYPE_CHECKING:
    from povgen.measure.browser import Browser

HERE = Path(__file__).parent
MAIN_SIZE = (320, 240)
LIVE_RAYS = (1, 4, 16, 64)  # a pixel
SCENES = {"detailed": Chess(), "ideal": Chess(sheet="ideal")}
BASELINE_SAMPLINGS = ("off", "1,0.9,2", "1,0.3,3")  # the last is POV-Ray's own antialiasing, +A0.3
FLICKER_SAMPLINGS = ("off", "1,0.9,2", "1.5x", "1,0.1,2", "2x")
FLICKER_ANGLES, FLICKER_STEP = (66.0, 120.0), 0.25  # alpha of two frames, and the difference to the next frame, degrees
PRISM_COUNTS = (25, 50, 100, 200, 400, 800, 1600, 3000)
FURTHER_WINDOWS = ("alpha=120,z=2", "alpha=40,z=4")  # behind the first one, which has alpha = 120
WORKER_COUNTS = (1, 2, 4, 8, 16)
ROUNDS = 5
HEADS = {  # of the tables
    "flicker": ("antialias", "flicker"),
    "prisms": ("sheet", "prisms", "CPU s", "position error (px)"),
    "beyond": ("kind", "windows or sheet", "CPU s", "position error (px)"),
    "workers": ("workers", "wall s", "fraction of cores busy", "cores"),
}
TITLES = {  # of the charts of frames
    size: (
        "Prisms: for the same error, gl costs\nless than half of what POV-Ray costs",
        f"Ideal sheet: gl costs clearly less\nfor {errors}",
    )
    for size, errors in (
        ("160x120", "every error"),
        ("320x240", "errors above 0.011"),
        ("640x480", "errors above 0.017"),
    )
}
Row = tuple[object, ...]


def baselines() -> dict[str, str]:
    """Return the macros `Sheet` of prisms by hand, by their files' names."""
    return {path.stem: path.read_text() for path in sorted(HERE.glob("*.inc"))}


def frames() -> list[speed.Point]:
    """Measure every renderer, the live view, and prisms by hand, with every sampling."""
    texts = {name: to_pov(Chess(), sheet_macro=macro) for name, macro in baselines().items()}
    others = [
        speed.Point(name, sampling, MAIN_SIZE, partial(speed.sample, text, sampling, MAIN_SIZE))
        for (name, text), sampling in product(texts.items(), BASELINE_SAMPLINGS)
    ]
    with chromium() as browser:
        return speed.measure_samplings(SCENES, say, [*live_points(browser), *others])


def live_points(browser: "Browser") -> Iterator[speed.Point]:
    """Yield the points of the live view."""
    for method, scene in SCENES.items():
        view = View(browser, scene)
        view.picture(speed.SIZES[0], 1)  # the first picture compiles the shaders
        for size, rays in product(speed.SIZES, LIVE_RAYS):
            make = partial(live_sample, browser, view, size, rays)
            yield speed.Point(f"live {method}", f"{rays} ray{'s' * (rays > 1)}", size, make)


def live_sample(browser: "Browser", view: View, size: tuple[int, int], rays: int) -> tuple[float, np.ndarray]:
    """Return the CPU seconds that the browser's processes use for a picture, and the picture.

    A small picture is drawn several times, and the mean counts: the clock's step is 0.01 s.
    """
    repeats = ceil(500_000 / (size[0] * size[1] * rays))
    before = browser_seconds(browser)
    for _ in range(repeats):
        view.page.evaluate("(numbers) => { povgen.readout.light(povgen.main.view, ...numbers); }", [*size, rays, 1])
    return (browser_seconds(browser) - before) / repeats, view.picture(size, rays)


def browser_seconds(browser: "Browser") -> float:
    """Return the CPU seconds that the browser's processes have used so far."""
    session = browser.new_browser_cdp_session()
    processes = session.send("SystemInfo.getProcessInfo")["processInfo"]
    session.detach()
    return float(sum(process["cpuTime"] for process in processes))


def flicker() -> Iterator[Row]:
    """Yield each sampling and the flicker of a movie in which alpha grows.

    Flicker is the mean, over the window, of |change of light from a frame to the next, less the same change in
    converged pictures|. Light is linear, 0 black to 1 white. The change that belongs to the movement does not count.
    """
    texts = [to_pov(Chess(alpha=alpha + step)) for alpha in FLICKER_ANGLES for step in (0, FLICKER_STEP)]
    window = camera.window(Chess(), MAIN_SIZE)

    def changes(sampling: str) -> np.ndarray:
        pictures = np.array([linear(speed.sample(text, sampling, MAIN_SIZE)[1][window]) for text in texts])
        return pictures[1::2] - pictures[::2]

    right = changes(CONVERGED)
    for sampling in FLICKER_SAMPLINGS:
        yield sampling, f"{abs(changes(sampling) - right).mean():.3g}"


def costs_and_errors(cases: list) -> Iterator[tuple[float, float]]:
    """Yield, for each case, the median CPU seconds of its scene and the RMS error of position of its targets.

    A case is a scene, and squares behind the same sheets. The CPU seconds are for 640x480 pixels without antialiasing.
    The error is the distance from the formula for infinitely fine sheets, in pixels of 1280x960.
    """
    texts = [to_pov(scene) for scene, _ in cases]
    seconds = [[speed.sample(text, "off", SMALL)[0] for text in texts] for _ in range(ROUNDS)]
    for cpu, (_, squares) in zip(np.median(seconds, 0), cases, strict=True):
        off = []
        for scene, seen in located(squares, SMALL):
            fine = scene.replace(sheet="ideal") if scene.has_prisms else scene
            off.append(abs(seen.position - fine.apparent_position(scene.L, scene.z1)))
        yield cpu, px(rms(off))


def prisms() -> Iterator[Row]:
    """Yield sheet, number of prisms, CPU seconds and error of position."""
    kinds = [("ideal", 100), *(("detailed", count) for count in PRISM_COUNTS)]
    cases = [(Chess(sheet=sheet, prisms=n), targets(sheet, 6, seed=3, E=0j, prisms=n)) for sheet, n in kinds]
    for kind, found in zip(kinds, costs_and_errors(cases), strict=True):
        yield *kind, *found


def beyond() -> Iterator[Row]:
    """Yield a kind of sheet, how many windows or which sheet, CPU seconds and error of position."""
    cases = {}
    for sheet, count in product(("ideal", "detailed"), range(1, 4)):
        shown = Chess(sheet=sheet, alpha=120, window=FURTHER_WINDOWS[: count - 1], z2=8)
        cases[sheet, str(count)] = shown, series_targets(sheet, count, 6, seed=3, E=0j)
    for sheet, squares in other_targets().items():
        cases["other ideal sheets", sheet] = Chess(sheet=sheet, z2=5, **OTHER[sheet].examples[0]), squares
    for kind, found in zip(cases, costs_and_errors([*cases.values()]), strict=True):
        yield *kind, *found


def workers() -> Iterator[Row]:
    """Yield the number of workers, a movie's wall seconds, the fraction of the cores' time used, and the cores."""
    cores = parallel.cores()
    for count in WORKER_COUNTS:
        with temporary_folder() as folder, patch.dict(os.environ, POVGEN_CACHE=str(folder / "cache")):
            before, start = parallel.cpu_seconds(), time.monotonic()
            movie("vary-alpha", folder / "movie.mp4", size=MAIN_SIZE, antialias="off", workers=count, progress=False)
            wall = time.monotonic() - start
            yield count, wall, (parallel.cpu_seconds() - before) / wall / cores, cores


def draw_prisms(rows: list[list[str]], folder: Path) -> None:
    with drawn(11, 5, folder / "prisms.png", folder / "prisms.svg") as figure:
        left, right = figure.subplots(1, 2)
        left.set(title="The error is proportional to 1/N", ylabel="distance from the ideal image (px of 1280x960)")
        right.set(title="From 25 to 3000 prisms, the cost rises by 40 %", ylabel="CPU seconds for a frame of 640x480")
        left.set(yscale="log", ylim=(0.03, 20))
        plain_ticks(left.yaxis, (1,))
        for ax, column in ((left, 3), (right, 2)):
            detailed = [(int(row[1]), float(row[column])) for row in rows if row[0] == "detailed"]
            ax.plot(*np.transpose(detailed), "o-", color=PRISMS, label="2 sheets of N prisms")
            ax.set(xscale="log", xlabel="prisms N of a sheet")
            plain_ticks(ax.xaxis)
            ax.grid(alpha=0.25)
        right.axhline(
            next(float(row[2]) for row in rows if row[0] == "ideal"), color=IDEAL, ls="--", label="ideal sheet"
        )
        right.set_ylim(bottom=0)
        left.text(22, 0.035, "↓ ideal sheet: below 0.0001", color=IDEAL)
        for ax in (left, right):
            name_lines(ax)


def draw_beyond(rows: list[list[str]], folder: Path) -> None:
    heads = {
        "ideal": "ideal sheets",
        "detailed": "sheets of 100 prisms",
        "other ideal sheets": "one window, other ideal sheets",
    }
    windows = {str(n): f"{n} window{'s' * (n > 1)}" for n in (1, 2, 3)}
    names = [windows.get(row[1]) or fill(OTHER[row[1]].title, 27) for row in rows]
    firsts = [[row[0] for row in rows].index(kind) for kind in heads]
    places = np.arange(len(rows)) + 0.9 * np.searchsorted(firsts, np.arange(len(rows)), side="right")
    with drawn(11, 9, folder / "beyond.png", folder / "beyond.svg") as figure:
        left, right = figure.subplots(1, 2, sharey=True)
        left.set(title="Three windows cost twice as much as one", xlabel="CPU seconds for a frame of 640x480")
        right.set(title="Ideal sheets: within 0.04 px, prisms: 2.6 px")
        right.set(xlabel="distance from the exact position (px of 1280x960)")
        left.set_ylim(places[-1] + 0.6, places[0] - 1.2)
        for ax, column in ((left, 2), (right, 3)):
            values = [float(row[column]) for row in rows]
            bars = ax.barh(places, values, color=[PRISMS if row[0] == "detailed" else IDEAL for row in rows])
            ax.set_yticks(places, names)
            ax.bar_label(bars, [f"{x:.2f}" if x >= 0.01 else "below 0.01" for x in values], padding=4)
            ax.margins(x=0.2)
            for first, head in zip(firsts, heads.values(), strict=True):
                ax.annotate(
                    head, (0, places[first] - 0.75), (4, 0), textcoords="offset points", va="center", weight="bold"
                )


def draw_workers(rows: list[list[str]], folder: Path) -> None:
    with drawn(8, 4.6, folder / "workers.png", folder / "workers.svg") as figure:
        count, wall, busy, cores = np.transpose(np.array(rows, float))
        ax = figure.subplots()
        ax.plot(count, wall, "o-", color=PRISMS, label="measured")
        ax.plot(count, wall * busy, ":", color=GREY, label="if no core were idle")
        ax.set_title("Two cores are busy with 8 POV-Ray processes or more")
        ax.annotate("povgen starts 16", (16, wall[-1]), (0, 12), ha="right", textcoords="offset points", color=PRISMS)
        ax.set_xscale("log", base=2)
        ax.set_xticks(count, [f"{each:g}" for each in count])
        ax.set(xlabel=f"POV-Ray processes at once, on {cores[0]:g} cores", ylim=(0, None))
        ax.set_ylabel("wall seconds for 61 frames of 320x240")
        ax.text(1.1, wall[0], "each process sleeps 0.65 s in each frame", va="center", color=GREY)
        ax.grid(alpha=0.25)
        name_lines(ax)


MEASURES: dict[str, Callable[[], Iterable[Row]]] = {
    "flicker": flicker,
    "prisms": prisms,
    "beyond": beyond,
    "workers": workers,
}
DRAWINGS = {"prisms": draw_prisms, "beyond": draw_beyond, "workers": draw_workers}


def measure(folder: Path) -> None:
    """Write the tables: frames.csv also has the rows of mitsuba.csv, which make has measured."""
    _, *mitsuba = csv.reader((HERE / "mitsuba.csv").open())
    save_table(folder / "frames.csv", charts.FRAMES_HEAD, [*(point.row for point in frames()), *mitsuba])
    for name, rows in MEASURES.items():
        save_table(folder / f"{name}.csv", HEADS[name], rows())
        say(name)
    (folder / "machine.txt").write_text(f"{speed.machine()}\n")


def draw(folder: Path) -> None:
    """Draw the charts of the tables in a folder."""
    charts.draw_frames(folder, TITLES)
    for name, drawing in DRAWINGS.items():
        drawing(table_rows(folder / f"{name}.csv"), folder)


if __name__ == "__main__":
    if "--draw" not in sys.argv:
        measure(Path(sys.argv[1]))
    draw(Path(sys.argv[1]))
