"""What povgen costs, compared with baselines, as a table and as JSON: `make bench`.

CPU seconds are what the operating system reports of each finished process. povgen and a baseline run alternately. The
table gives the medians of the times and of their ratios. Mitsuba runs in its own environment; `make bench` makes it.
"""

import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median

import numpy as np
from charts import baselines
from mitsuba_points import fastest
from rich.console import Console
from rich.table import Table

from povgen import Bundle, Chess, Rendering, to_pov
from povgen.measure import speed

PLAIN = Rendering(size=(640, 480), antialias="off")


Line = tuple[str, str, float, float, float, float]  # povgen, baseline, their values, ratio, greatest ratio


def paired(ours: Callable[[], float], theirs: Callable[[], float], rounds: int) -> tuple[float, float, float]:
    """Call two functions alternately. Return the medians of what they return, and of the ratio."""
    times = [(ours(), theirs()) for _ in range(rounds)]
    return median(a for a, _ in times), median(b for _, b in times), median(a / b for a, b in times)


def cpu(text: str, rendering: Rendering = PLAIN) -> Callable[[], float]:
    return lambda: speed.sample(text, rendering.sampling, rendering.size)[0]


def traced(sheet: str) -> float:
    """Return the CPU seconds for a million rays through the default scene's window, with this sheet."""
    random = np.random.default_rng(0).uniform(-1.1, 1.1, (1_000_000, 2))
    rays = Bundle((0, 0, -6), np.column_stack((random, np.full(len(random), 6.0))))
    scene = Chess(sheet=sheet)
    start = time.process_time()
    scene.trace(rays)
    return time.process_time() - start


def lines() -> Iterator[Line]:
    """Yield the lines of the table."""
    detailed = to_pov(Chess())
    for name, macro in baselines().items():
        text = to_pov(Chess(), sheet_macro=macro)
        yield "detailed, CPU s", f"union of {name}", *paired(cpu(detailed), cpu(text), 5), 0.25
    if len(sys.argv) > 1:
        other = fastest(sys.argv[1])
        name = f"Mitsuba 3 {other.variant}, the same mesh"
        yield "detailed, CPU s", name, *paired(cpu(detailed), lambda: other.sample(PLAIN.size, 1)[0], 5), 0.9
    ideal, none = to_pov(Chess(sheet="ideal")), to_pov(Chess(sheet="none"))
    for sampling, rounds in (("off", 25), ("2,0.1,3", 7)):
        rendering = Rendering(size=PLAIN.size, antialias=sampling)
        found = paired(cpu(ideal, rendering), cpu(none, rendering), rounds)
        yield f"ideal, antialias {sampling}, CPU s", "no sheet", *found, 1.1
    for sheet, name, most in (("detailed", "", 5), ("ideal", ", ideal sheet", 0.5)):
        seconds = traced(sheet)
        yield f"ray trace{name}, a million rays, CPU s", "a second", seconds, 1, seconds, most


def main() -> None:
    table = Table("povgen", "baseline", "povgen's", "baseline's", "ratio", "bound", title=speed.machine())
    figures = []
    for name, baseline, ours, theirs, ratio, bound in lines():
        table.add_row(name, baseline, *(f"{x:.3g}" for x in (ours, theirs, ratio)), f"{bound}")
        figures.append(
            {"povgen": name, "baseline": baseline, "ours": ours, "theirs": theirs, "ratio": ratio, "bound": bound}
        )
        print(f"{name}: {ours:.3g}; {baseline}: {theirs:.3g}; ratio {ratio:.3g}", file=sys.stderr, flush=True)
    Console(width=None if sys.stdout.isatty() else 120).print(table)
    text = json.dumps({"machine": speed.machine(), "figures": figures}, indent=2) + "\n"
    Path("build/bench.json").write_text(text)


if __name__ == "__main__":
    main()
