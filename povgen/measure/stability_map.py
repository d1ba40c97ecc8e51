"""Stability maps: measured errors against one quantity, and the limits that follow from them.

A stability map is a series of measurements: an error or loss y against one quantity x, such as the number of prisms.
`stability` measures the maps. A limit is the x up to which (or above which) y is within a tolerance. Each measured
limit is compared with the limit that povgen uses (povgen/limits.py).
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import cycle, pairwise
from pathlib import Path
from textwrap import fill
from typing import Any, Literal

import numpy as np

from povgen.measure.measured import Measured
from povgen.measure.plotting import COLOURS, GREY, MARKS, Axes, drawn, name_lines, plain_ticks, save_table

RENDERED = ", by POV-Ray"  # suffix of a series from POV-Ray's pictures, if another series is from the exact ray trace
RESOLUTION = 0.011  # px, of positions in 16 bits
RED = "#a3161c"
DASHES = "-", "--", "-.", (0, (6, 1.5, 1, 1.5, 1, 1.5))  # one beside each colour, for eyes that do not tell them apart
SOME = 3  # series that are drawn if there are more than colours

Named = tuple[str, list[tuple[float, float]], str]  # a text, the points that it belongs to, and its colour


@dataclass
class StabilityMap:
    """Measured values y against x, in named series. `rows` are (series, x, y), in the order of the measurements.

    `title` is the map's name in tables. The fields `x` and `y` are the labels of the axes. `log_axes` names the
    logarithmic axes: '', 'x', 'y' or 'xy'. `tolerance` is the greatest allowed y. If `is_estimate`, x is an estimate of
    y, in the same unit. For the drawing: `finding` is its title.
    `band` is the shaded range: on which side of which value, and what happens there. `groups` are of series that are
    drawn as one, estimates alike, others by mean and range: by a pattern in their names, how they are called. `dot` is
    the name of large dots, at the last row of each series from POV-Ray's pictures. `ends` are those of the y axis.
    `limits` are what `limit` has found.
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
    groups: dict[str, str] = field(default_factory=dict)
    dot: str = ""
    ends: tuple[float, float] | None = None
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
    """Draw each series as a line, or as points if x is an estimate of y. Mark where the method fails."""
    ax.set(xlabel=measured.x, ylabel=measured.y, title=measured.finding)
    ax.grid(alpha=0.25)
    for name in measured.log_axes:
        getattr(ax, f"set_{name}scale")("log", nonpositive="mask")
    ax.margins(y=0.1)
    others = (_draw_points if measured.is_estimate else _draw_lines)(ax, measured)
    if measured.ends:
        ax.set_ylim(*measured.ends)
    elif ax.get_yscale() == "linear" and min(y for *_, y in measured.rows) >= 0:
        ax.set_ylim(bottom=0)
    ends = ax.get_xlim(), ax.get_ylim()
    for name, (least, most) in zip("xy", ends, strict=True):
        if getattr(ax, f"get_{name}scale")() == "log":
            subs = (1, 2, 5) if most < 30 * least else (1, 3) if most < 1000 * least else (1,)
            plain_ticks(getattr(ax, f"{name}axis"), subs)
    bottom = ends[1][0]
    for x in [x for _, x, y in measured.rows if y == 0] if ax.get_yscale() == "log" and not measured.ends else ():
        ax.plot(x, bottom, "v", color=COLOURS[0], clip_on=False)
        others.append((f"0 at {x:g}", [(x, bottom)], COLOURS[0]))
    if measured.band:
        others.append(_draw_band(ax, measured, *ends))
    ax.set(xlim=ends[0], ylim=ends[1])
    name_lines(ax, *others)


def _draw_band(ax: Axes, measured: StabilityMap, xs: tuple[float, float], ys: tuple[float, float]) -> Named:
    """Mark where the method fails. Return what is written there."""
    side, bound, text = measured.band or ("above", np.inf, "")
    (x0, x1), (y0, y1) = xs, ys
    edge = ax.axhline if side == "above" else ax.axvline
    edge(bound, color=RED, alpha=0.4, linewidth=1)  # no name is written across it
    x0, x1, y0 = (bound if side == end else at for end, at in (("right", x0), ("left", x1), ("above", y0)))
    ax.fill_between((x0, x1), y0, y1, color=RED, alpha=0.09, linewidth=0)
    middle = (x0 * x1) ** 0.5 if "x" in measured.log_axes else (x0 + x1) / 2
    low = (2 * bound + y1) / 3 if side == "above" else y0
    return text, [(middle, y) for y in np.linspace(low, y1, 50)], RED


def _grouped(measured: StabilityMap, names: Iterable[str]) -> dict[str, list[str]]:
    """Return the names of series by what they are called: some are drawn as one."""
    groups: dict[str, list[str]] = {}
    for name in names:
        # in several lines only after commas
        own = fill(re.sub("(?<!,) ", "\N{NBSP}", name), 30).replace("-", "−")
        label = next((label for part, label in measured.groups.items() if re.search(part, name)), own)
        groups.setdefault(label, []).append(name)
    return groups


def _by_series(measured: StabilityMap) -> dict[str, list[tuple[float, float]]]:
    """Return the x and y of each series, in the order of the measurements."""
    rows: dict[str, list[tuple[float, float]]] = {}
    for name, x, y in measured.rows:
        rows.setdefault(name, []).append((x, y))
    return rows


def _draw_points(ax: Axes, measured: StabilityMap) -> list[Named]:
    """Draw the points of each group, and where y is as great as its estimate x. Nothing else is to be named.

    Of a single group, the last point of each series is solid.
    """
    rows = _by_series(measured)
    groups = _grouped(measured, rows)
    for (label, names), mark, colour in zip(groups.items(), MARKS, COLOURS, strict=False):
        points = [point for name in names for point in rows[name]]
        if len(groups) == 1:
            ax.plot(*np.transpose(points), mark, color=colour, fillstyle="none", label="_")
            points = [each[-1] for each in rows.values()]
        ax.plot(*np.transpose(points), mark, color=colour, label=label, markeredgecolor="white")
    if len(groups) == 1:
        ax.set_xlim(left=ax.get_xlim()[0] / 2)  # room for the name of the last points
    ends = ax.get_xlim()
    ax.plot(ends, ends, ":", color=GREY, label="as great as stated")
    ax.set_xlim(ends)
    return []


def _draw_lines(ax: Axes, measured: StabilityMap) -> list[Named]:
    """Draw the series, and what is allowed. Return what else to name.

    Of more series than colours, SOME are drawn, whose last rows of `RENDERED` are spread evenly. The table has all.
    """
    rows = _by_series(measured)
    traced = [name for name in rows if not name.endswith(RENDERED)]
    if len(traced) > len(COLOURS):
        ax.set_title(f"{measured.finding} in these {len(traced)} scenes ({SOME} shown)")
        ordered = sorted(traced, key=lambda name: rows[name + RENDERED][-1][0])
        traced = [ordered[n] for n in np.linspace(0, len(traced) - 1, SOME).round().astype(int)]
    groups = _grouped(measured, traced)
    others: list[Named] = []
    for (label, names), colour, mark, dashes in zip(groups.items(), COLOURS, MARKS, cycle(DASHES), strict=False):
        points = np.array([rows[name] for name in names])
        x, y = points[0, :, 0], points[..., 1]
        look: dict[str, Any] = {"color": colour, "linestyle": dashes, "marker": "" if len(x) > 30 else mark}
        ax.plot(x, y.mean(0), label=label if len(names) == 1 < len(groups) else "_", **look)
        if len(names) > 1:
            ax.fill_between(x, y.min(0), y.max(0), color=colour, alpha=0.25, linewidth=0)
            others.append((label, [*zip(x, y.min(0), strict=True), *zip(x, y.max(0), strict=True)], colour))
        if measured.dot:
            ax.plot(*rows[names[0] + RENDERED][-1], "o", color=colour, markersize=10)
        elif "y" in measured.log_axes:
            limit = measured.crossing(names[0], rising=True)
            ax.plot(limit, measured.tolerance, "o", color=colour, markersize=13, fillstyle="none")
            others.append((f"{float(f'{limit:.2g}'):g}", [(limit, measured.tolerance)], colour))
    if measured.dot:
        dot = rows[traced[0] + RENDERED][-1]
        ax.annotate(
            measured.dot, dot, (0, -45), textcoords="offset points", ha="center", arrowprops={"arrowstyle": "-"}
        )
    if not (measured.band and measured.band[0] == "above"):
        ax.axhline(measured.tolerance, color=GREY, linestyle=":", label=f"allowed: {measured.tolerance:g}")
    return others
