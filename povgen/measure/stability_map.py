"""Stability maps: measured errors against one quantity, and the limits that follow from them.

A stability map is a series of measurements: an error or loss y against one quantity x, such as the number of prisms.
`stability` measures the maps. A limit is the x up to which (or above which) y is within a tolerance. Each measured
limit is compared with the limit that povgen uses (povgen/limits.py).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from povgen.measure.measured import Measured
from povgen.measure.plotting import COLOURS, GREY, Axes, drawn, plain_ticks, save_table

RENDERED = ", by POV-Ray"  # suffix of a series from POV-Ray's pictures, if another series is from the exact ray trace
RED = "#c1272d"
SOME = 6  # series that are drawn if there are more than colours


@dataclass
class StabilityMap:
    """Measured values y against x, in named series. `rows` are (series, x, y), in the order of the measurements.

    The fields `x` and `y` are the labels of the axes. `log_axes` names the logarithmic axes: '', 'x', 'y' or 'xy'.
    `tolerance` is the greatest allowed y. If `is_bound`, x is a bound of y in the same unit. `limits` are what `limit`
    has found.
    """

    name: str
    title: str
    x: str
    y: str
    tolerance: float
    log_axes: str = ""
    is_bound: bool = False
    rows: list[tuple[str, float, float]] = field(default_factory=list)
    limits: list[Measured] = field(default_factory=list)

    def add(self, series: str, x: float, y: float) -> None:
        """Append a row."""
        self.rows.append((series, float(x), float(y)))

    def limit(self, sheet: str, series: str, in_force: float, unit: str = "", *, rising: bool = True) -> None:
        """Find the limit of a series in its rows. Append it to `limits`, with the limit that povgen uses, `in_force`.

        If y is rising with x, the limit is the greatest x up to which y is within the tolerance. Otherwise the limit is
        the least x above which y is within the tolerance. Between two rows the limit is interpolated linearly, or in
        the logarithm of x if the x axis is logarithmic. If y exceeds the tolerance already at the least x (or, if y is
        not rising, at the greatest x), the limit is NaN, which fails.
        """
        points = sorted(((x, y) for name, x, y in self.rows if name == series), reverse=not rising)
        found = points[0][0] if points[0][1] <= self.tolerance else np.nan
        for (x0, y0), (x1, y1) in pairwise(points):
            if not y0 <= self.tolerance:
                break
            if y1 <= self.tolerance:
                found = x1
            elif y1 > self.tolerance and "x" in self.log_axes:
                found = x0 * (x1 / x0) ** ((self.tolerance - y0) / (y1 - y0))
            elif y1 > self.tolerance:
                found = x0 + (x1 - x0) * (self.tolerance - y0) / (y1 - y0)
        self.limits.append(Measured(sheet, f"{self.title}: {series}", found, in_force, unit, least=rising))


def save_maps(maps: Iterable[StabilityMap], folder: Path, done: Callable[[Measured], object]) -> None:
    """Write each stability map as NAME.png and NAME.csv as soon as it is measured. Calls `done` with each limit."""
    for measured in maps:
        save_table(folder / f"{measured.name}.csv", ("series", measured.x, measured.y), measured.rows)
        with drawn(9, 5, folder / f"{measured.name}.png") as figure:
            draw_map(figure.subplots(), measured)
        for limit in measured.limits:
            done(limit)


def draw_map(ax: Axes, measured: StabilityMap) -> None:
    """Draw each series as a line, or the rows as points if x is a bound of y. Mark povgen's limits."""
    ax.set(xlabel=measured.x, ylabel=measured.y, title=measured.title)
    ax.grid(alpha=0.25)
    if "x" in measured.log_axes:
        ax.set_xscale("log")
    if "y" in measured.log_axes:
        ax.set_yscale("log")
        plain_ticks(ax.yaxis, (1,))
    traced = _draw_series(ax, measured)
    least, most = ax.get_xlim()
    if "x" in measured.log_axes:
        plain_ticks(ax.xaxis, (1,) if most > 100 * least else (1, 2, 5))
    ax.set(xlim=(least, most), ylim=ax.get_ylim())
    if measured.is_bound:
        ends = np.array(ax.get_xlim())
        ax.plot(ends, ends, ":", color=GREY, label="error as great as its bound")
    else:
        ax.axhline(measured.tolerance, color=GREY, linestyle=":", label=f"allowed: {measured.tolerance:g}")
    bounds = {limit.bound: limit.least for limit in measured.limits}
    for bound, rising in bounds.items() if len(bounds) == 1 else ():
        beyond = ax.get_xlim()[1 if rising else 0]
        ax.axvspan(bound, beyond, color=RED, alpha=0.09, linewidth=0, label=f"beyond povgen's limit, {bound:g}")
    whats = [f"{measured.title}: {name}" for name in traced]
    for limit in measured.limits if len(bounds) > 1 else ():
        if limit.what not in whats:
            continue
        n = whats.index(limit.what)
        ax.axvline(limit.bound, color=COLOURS[n], linestyle="--", linewidth=0.8)
    if len(bounds) > 1:
        ax.plot([], [], "--", color=GREY, linewidth=0.8, label="povgen's limits")
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1))


def _draw_series(ax: Axes, measured: StabilityMap) -> list[str]:
    """Draw series, and choose the range of y. Return the names of those that have a place in the legend.

    Of more series than colours, SOME are drawn, whose limits are spread evenly. The table has all.
    """
    traced = [name for name in dict.fromkeys(name for name, *_ in measured.rows) if not name.endswith(RENDERED)]
    if len(traced) > len(COLOURS):
        bounds = {limit.what.removeprefix(f"{measured.title}: "): limit.bound for limit in measured.limits}
        spread = np.linspace(0, len(traced) - 1, SOME).round().astype(int)
        ordered = sorted(traced, key=lambda name: bounds.get(name, 0))
        ax.set_title(f"{measured.title}: {SOME} of {len(traced)} scenes")
        traced = [ordered[n] for n in spread]
    for n, name in enumerate(traced):
        for series, look in ((name, "o" if measured.is_bound else "o-"), (name + RENDERED, "x")):
            x, y = np.array([row[1:] for row in measured.rows if row[0] == series]).reshape(-1, 2).T
            label = name if series == name else None
            ax.plot(x, y, look, color=COLOURS[n], markersize=5 if len(x) < 30 else 2.5, label=label)
    if not measured.log_axes.endswith("y"):
        ax.set_ylim(top=min(ax.get_ylim()[1], 8 * measured.tolerance))
        if min(y for *_, y in measured.rows) >= 0 > ax.get_ylim()[0]:
            ax.set_ylim(bottom=0)
    return traced
