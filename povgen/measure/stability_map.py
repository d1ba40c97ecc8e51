"""Stability maps: measured errors against one quantity, and the limits that follow from them.

A stability map is a series of measurements: an error or loss y against one quantity x, such as the number of prisms.
`stability` measures the maps. A limit is the x up to which (or above which) y is within a tolerance. Each measured
limit is compared with the limit that povgen uses (povgen/limits.py).
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from textwrap import fill
from typing import Literal

import numpy as np

from povgen.measure.measured import Measured
from povgen.measure.plotting import COLOURS, GREY, MARKS, Axes, drawn, name_lines, plain_ticks, save_table

RENDERED = ", by POV-Ray"  # suffix of a series from POV-Ray's pictures, if another series is from the exact ray trace
RED = "#a3161c"
SIGNS = "●■▲◆▼★✚✖"  # MARKS, in names
SOME = 3  # series that are drawn if there are more than colours


@dataclass
class StabilityMap:
    """Measured values y against x, in named series. `rows` are (series, x, y), in the order of the measurements.

    `title` is the map's name in tables. The fields `x` and `y` are the labels of the axes. `log_axes` names the
    logarithmic axes: '', 'x', 'y' or 'xy'. `tolerance` is the greatest allowed y. If `is_estimate`, x is an estimate of
    y, in the same unit, and y/x is drawn. For the drawing: `finding` is its title. `band` is where the method fails: on
    which side of which value, and what happens there. `groups` are of series that look alike: a series is in the group
    whose name is a part of its own, or in the first one. `dot` is the name of large dots, at the last row of each
    series from POV-Ray's pictures. `limits` are what `limit` has found.
    """

    name: str
    title: str
    x: str
    y: str
    tolerance: float
    log_axes: str = ""
    is_estimate: bool = False
    finding: str = ""
    band: tuple[Literal["left", "right", "above"], float, str] | None = None
    groups: tuple[str, ...] = ()
    dot: str = ""
    rows: list[tuple[str, float, float]] = field(default_factory=list)
    limits: list[Measured] = field(default_factory=list)

    def add(self, series: str, x: float, y: float) -> None:
        """Append a row."""
        self.rows.append((series, float(x), float(y)))

    def limit(self, sheet: str, series: str, in_force: float, unit: str = "", *, rising: bool = True) -> None:
        """Find the limit of a series. Append it to `limits`, with the limit that povgen uses, `in_force`."""
        found = self.crossing(series, rising=rising)
        self.limits.append(Measured(sheet, f"{self.title}: {series}", found, in_force, unit, least=rising))

    def crossing(self, series: str, *, rising: bool) -> float:
        """Return the limit of a series: where the line between its rows, as it is drawn, crosses the tolerance.

        If y is rising with x, the limit is the greatest x up to which y is within the tolerance. Otherwise the limit is
        the least x above which y is within the tolerance. If y exceeds the tolerance already at the least x (or, if y
        is not rising, at the greatest x), the limit is NaN, which fails.
        """

        def scaled(axis: str, *values: float) -> list[float]:
            return [np.log(max(value, 1e-9)) if axis in self.log_axes else value for value in values]

        points = sorted(((x, y) for name, x, y in self.rows if name == series), reverse=not rising)
        found = points[0][0] if points[0][1] <= self.tolerance else np.nan
        for (x0, y0), (x1, y1) in pairwise(points):
            if not y0 <= self.tolerance:
                break
            if y1 <= self.tolerance:
                found = x1
            elif y1 > self.tolerance:
                found = np.interp(scaled("y", self.tolerance), scaled("y", y0, y1), scaled("x", x0, x1))[0]
                found = np.exp(found) if "x" in self.log_axes else found
        return float(found)


def save_maps(maps: Iterable[StabilityMap], folder: Path, done: Callable[[Measured], object]) -> None:
    """Write each stability map as NAME.png and NAME.csv as soon as it is measured. Calls `done` with each limit."""
    for measured in maps:
        save_table(folder / f"{measured.name}.csv", ("series", measured.x, measured.y), measured.rows)
        draw(measured, folder)
        for limit in measured.limits:
            done(limit)


def draw(measured: StabilityMap, folder: Path) -> None:
    """Write a stability map as NAME.png."""
    with drawn(9, 5, folder / f"{measured.name}.png") as figure:
        draw_map(figure.subplots(), measured)


def draw_map(ax: Axes, measured: StabilityMap) -> None:
    """Draw each series as a line, or y/x as points if x is an estimate of y. Mark where the method fails."""
    if measured.is_estimate:
        rows = [(name, x, y / x) for name, x, y in measured.rows]
        measured = replace(measured, y="error / what povgen states", log_axes="x", rows=rows)
    ax.set(xlabel=measured.x, ylabel=measured.y, title=measured.finding)
    ax.grid(alpha=0.25)
    for name in measured.log_axes:
        getattr(ax, f"set_{name}scale")("log", nonpositive="mask")
    ax.margins(y=0.1)
    others = _draw_series(ax, measured)
    if "y" not in measured.log_axes and min(y for *_, y in measured.rows) >= 0:
        ax.set_ylim(bottom=0)
    ends = ax.get_xlim(), ax.get_ylim()
    for name, (least, most) in zip("xy", ends, strict=True):
        if name in measured.log_axes:
            subs = (1, 2, 5) if most < 30 * least else (1, 3) if most < 300 * least else (1,)
            plain_ticks(getattr(ax, f"{name}axis"), subs)
    (left, right), (bottom, top) = ends
    for x in [x for _, x, y in measured.rows if y == 0] if "y" in measured.log_axes else ():
        ax.plot(x, bottom, "v", color=COLOURS[0], clip_on=False)
        others.append((f"0 at {x:g}", [(x, bottom)], COLOURS[0]))
    if measured.is_estimate:
        ax.axhline(1, color=GREY, linestyle=":", label="as great as stated")
        above = [(x, y) for _, x, y in measured.rows if y > 1]
        ax.plot(*np.reshape(above, (-1, 2)).T, "o", color=RED, markersize=13, fillstyle="none")
        others += [("circled: greater than stated", above, RED)] if above else []
    elif not (measured.band and measured.band[0] == "above"):
        ax.axhline(measured.tolerance, color=GREY, linestyle=":", label=f"allowed: {measured.tolerance:g}")
    if measured.band:
        side, bound, text = measured.band
        x0, x1 = (left, bound) if side == "left" else (bound, right) if side == "right" else (left, right)
        ax.fill_between((x0, x1), bound if side == "above" else bottom, top, color=RED, alpha=0.09, linewidth=0)
        middle = (x0 * x1) ** 0.5 if "x" in measured.log_axes else (x0 + x1) / 2
        low = (2 * bound + top) / 3 if side == "above" else bottom
        others.append((text, [(middle, y) for y in np.linspace(low, top, 50)], RED))
    ax.set(xlim=(left, right), ylim=(bottom, top))
    name_lines(ax, *others)


def _draw_series(ax: Axes, measured: StabilityMap) -> list[tuple[str, list[tuple[float, float]], str]]:
    """Draw the series. Return what else to name: a text, the points that it belongs to, and its colour.

    Of more series than colours, SOME are drawn, whose last rows of `RENDERED` are spread evenly. The table has all.
    """
    rows: dict[str, list[tuple[float, float]]] = {}
    for name, *row in measured.rows:
        rows.setdefault(name, []).append((row[0], row[1]))
    traced = [name for name in rows if not name.endswith(RENDERED)]
    if len(traced) > len(COLOURS) and not measured.groups:
        ax.set_title(f"{measured.finding} in these {len(traced)} scenes ({SOME} shown)")
        ordered = sorted(traced, key=lambda name: rows[name + RENDERED][-1][0])
        traced = [ordered[n] for n in np.linspace(0, len(traced) - 1, SOME).round().astype(int)]
    dots, others = [], []
    for name in traced:
        group = (
            next((group for group in measured.groups[1:] if group in name), measured.groups[0])
            if measured.groups
            else name
        )
        n, points = (measured.groups or traced).index(group), np.array(rows[name])
        label = fill(re.sub("(?<!,) ", "\N{NBSP}", group), 30).replace("-", "−")  # in several lines only after commas
        line = ("-", "--", "-.")[n % 3] if len(points) > 30 else MARKS[n] + "-" * (not measured.is_estimate)
        label = f"{SIGNS[n]} {label}" if line[0] in MARKS and not measured.is_estimate else label
        if label in [line.get_label() for line in ax.lines]:
            label = "_"
        ax.plot(*points.T, line, color=COLOURS[n], label=label)
        if measured.dot:
            dots += rows[name + RENDERED][-1:]
            ax.plot(*dots[-1], "o", color=COLOURS[n], markersize=10)
        elif "y" in measured.log_axes and not measured.is_estimate:
            x = measured.crossing(name, rising=True)
            ax.plot(x, measured.tolerance, "o", color=COLOURS[n], markersize=13, fillstyle="none")
            others.append((f"{float(f'{x:.2g}'):g}", [(x, measured.tolerance)], COLOURS[n]))
    if measured.is_estimate:
        ax.legend(frameon=True, fontsize=11)  # a sign beside a name would look like a point
        for each in ax.lines:
            each.set_label("_")
    return [*others, (measured.dot, dots, "black")] if dots else others
