"""Drawings of stability maps, and their tables."""

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from textwrap import fill

import numpy as np

from povgen.measure.measured import Measured
from povgen.measure.plotting import GREY, IDEAL, PRISMS, Axes, drawn, plain_ticks, save_table
from povgen.measure.probes import Floats
from povgen.measure.stability_map import RENDERED, StabilityMap

RED = "#c1272d"
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SYMBOLS = {
    "α": "angle by which rays turn",
    "N": "prisms of a sheet",
    "away": "from the sheets (tiles)",
    "up": "above the axis (tiles)",
}


def save_maps(maps: Iterable[StabilityMap], folder: Path, done: Callable[[Measured], object]) -> None:
    """Write each stability map as NAME.png and NAME.csv as soon as it is measured. Calls `done` with each limit."""
    for measured in maps:
        save_table(folder / f"{measured.name}.csv", ("series", measured.x, measured.y), measured.rows)
        with drawn(9.5 if measured.shape == "limits" else 8, 5, folder / f"{measured.name}.png") as figure:
            draw_map(figure.subplots(), measured)
        for limit in measured.limits:
            done(limit)


def draw_map(ax: Axes, measured: StabilityMap) -> None:
    """Draw a map as its `shape` says."""
    ax.set(xlabel=measured.x, ylabel=measured.y)
    ax.set_title(measured.finding, pad=26)  # room for the line of `_name_limit`
    ax.grid(alpha=0.25)
    if "x" in measured.log_axes:
        ax.set_xscale("log")
    if "y" in measured.log_axes:
        ax.set_yscale("log")
    {"lines": _draw_lines, "range": _draw_range, "bound": _draw_bound, "limits": _draw_limits}[measured.shape](
        ax, measured
    )
    if "x" in measured.log_axes:
        low, high = ax.get_xlim()
        plain_ticks(ax.xaxis, (1, 3) if high < 1e5 * low else (1,))
        ax.xaxis.set_major_formatter(
            lambda x, _: (
                f"{x:,.0f}" if x >= 1 else f"{x:g}" if low > 1e-4 else "10" + f"{np.log10(x):.0f}".translate(RAISED)
            )
        )
    if "y" in measured.log_axes:
        plain_ticks(ax.yaxis, (1, 3))


def _draw_lines(ax: Axes, measured: StabilityMap) -> None:
    """Draw each series as a line with its name."""
    series, colours = _series(measured), {}
    for name, (x, y) in series.items():
        shown = y > 0 if "y" in measured.log_axes else np.isfinite(y)
        (line,) = ax.plot(x[shown], y[shown], "o-", markersize=5, label=name)
        colours[name] = line.get_color()
    _shade_beyond_limit(ax, measured)
    _explain(ax, measured.note, *_symbols(" ".join(series)))
    top = ax.get_ylim()[1]
    # all lines leave the axes at the top: each name stands where its line has just exceeded the tolerance
    if all(y.max() > top for _, y in series.values()):
        for (name, colour), limit in zip(colours.items(), measured.limits, strict=True):
            at = limit.value, 1.6 * measured.tolerance
            ax.annotate(name, at, (-6, 0), textcoords="offset points", ha="right", color=colour, fontsize=10)
    elif len(series) > 1:
        ax.legend()


def _draw_range(ax: Axes, measured: StabilityMap) -> None:
    """Draw the mean of all series as a line, and the range that they cover as a band. All have the same values of x."""
    series = _series(measured)
    traced = {name: values for name, values in series.items() if not name.endswith(RENDERED)}
    x, y = next(iter(traced.values()))[0], np.array([y for _, y in traced.values()])
    rendered = len(series) > len(traced)
    ax.fill_between(x, y.min(0), y.max(0), color=PRISMS, alpha=0.25, linewidth=0)
    ax.plot(x, y.mean(0), "-" if rendered else "o-", color=PRISMS, markersize=5)
    notes = [
        f"line: mean for {', '.join(traced)}, by povgen's ray trace",
        "band: from the least to the greatest of them",
    ]
    if rendered:
        ax.plot(x, np.mean([series[name + RENDERED][1] for name in traced], 0), "x", color="black", markersize=9)
        notes.append("crosses: the mean in POV-Ray's pictures")
    _shade_beyond_limit(ax, measured)
    if measured.reached is not None:
        ax.plot([measured.reached] * 2, [0, measured.tolerance], ":", color=GREY)
        ax.annotate(
            f"{measured.reached:.0f}", (measured.reached, 0), (4, 4), textcoords="offset points", color="#444444"
        )
    _explain(ax, measured.note, *notes, *_symbols(" ".join(traced)))


def _shade_beyond_limit(ax: Axes, measured: StabilityMap) -> None:
    """Draw the tolerance as a dotted line. Shade the values of x beyond the limit that povgen uses."""
    y = [y for *_, y in measured.rows]
    if "y" not in measured.log_axes:  # from 0, or from below the least negative value, to at most eight tolerances
        top = min(ax.get_ylim()[1], 8 * measured.tolerance)
        ax.set_ylim(1.5 * min(0, *y), max(top, 1.15 * measured.tolerance))
    left, right = ax.get_xlim()
    ax.axhline(measured.tolerance, color=GREY, linestyle=":")
    rising = not measured.limits or measured.limits[0].least
    at_left = bool(measured.limits) and rising  # where the curves are not
    ax.annotate(
        measured.allowed,
        (0.01 if at_left else 0.99, measured.tolerance),
        (0, 3 if measured.limits else -3),
        ax.get_yaxis_transform(),
        "offset points",
        color="#444444",
        fontsize=10,
        ha="left" if at_left else "right",
        va="bottom" if measured.limits else "top",
    )
    if measured.limits:
        bounds = [limit.bound for limit in measured.limits]
        bound, word = (min(bounds), "above") if rising else (max(bounds), "below")
        ax.axvline(bound, color=RED)
        ax.axvspan(bound, right if rising else left, color=RED, alpha=0.09, linewidth=0)
        ax.set_xlim(left, right)
        unit = {"deg": "°"}.get(measured.limits[0].unit, f" {measured.limits[0].unit}".rstrip())
        _name_limit(ax, bound, f"{measured.action} {word} {bound:,g}{unit}")


def _name_limit(ax: Axes, x: float, text: str, colour: str = RED) -> None:
    """Write above the axes what the limit at x is."""
    at_left = ax.transAxes.inverted().transform(ax.transData.transform((x, ax.get_ylim()[0])))[0] < 0.3
    side = "left" if at_left else "center"
    ax.annotate(text, (x, 1), (0, 3), ax.get_xaxis_transform(), "offset points", color=colour, ha=side)


def _draw_bound(ax: Axes, measured: StabilityMap) -> None:
    """Draw a point for each row: y against its bound x. Shade the region where y exceeds its bound by too much.

    y may exceed its bound by the tolerance minus the limit that povgen uses. A point in the shaded region is red.
    """
    _, x, y = zip(*measured.rows, strict=True)
    limit = measured.limits[0]
    colour = IDEAL if limit.sheet == "ideal" else PRISMS
    beyond = measured.tolerance - limit.bound
    edges = [RED if error > bound + beyond else colour for bound, error in zip(x, y, strict=True)]
    faces = [edge if bound <= 1.001 * limit.bound else "white" for bound, edge in zip(x, edges, strict=True)]
    ax.scatter(x, y, color=faces, edgecolors=edges, zorder=3)
    left, right, top = *ax.get_xlim(), ax.get_ylim()[1]
    ax.set(xlim=(left, right), ylim=ax.get_ylim())
    across = np.geomspace(left, right, 200)
    ax.fill_between(across, across + beyond, top, color=RED, alpha=0.09, linewidth=0)
    ax.plot(across, across, ":", color=GREY)
    at = np.sqrt(limit.bound * min(right, top))
    ax.annotate("equal", (at, at), (-4, 4), textcoords="offset points", color="#444444", ha="right", fontsize=10)
    ax.text(0.11, 0.97, measured.allowed, transform=ax.transAxes, color=RED, va="top")
    ax.axvline(limit.bound, color="#444444", linewidth=1)
    _name_limit(ax, limit.bound, measured.action, "#444444")
    _explain(ax, measured.note)


def _draw_limits(ax: Axes, measured: StabilityMap) -> None:
    """Draw, for each series, its measured limit and the limit that povgen uses. The greatest stand at the top."""
    limits = sorted(measured.limits, key=lambda limit: limit.value)
    rows = np.arange(len(limits))
    values, bounds = np.array([(limit.value, limit.bound) for limit in limits]).T
    ax.hlines(rows, values, bounds, color=GREY)
    ax.plot(bounds, rows, "D", color=RED, markersize=9, markerfacecolor="white", markeredgewidth=1.8)
    ax.plot(values, rows, "o", color=PRISMS, markersize=6)
    names = [limit.what.removeprefix(f"{measured.title}: ") for limit in limits]
    left = -8.0
    for parts in [*zip(*(name.split(", ") for name in names), strict=True)][::-1]:  # a column for each part of a name
        usual = max(parts, key=parts.count)
        for row, part in zip(rows, parts, strict=True):
            colour = GREY if part == usual else "black"
            ax.annotate(
                part,
                (0, row),
                (left, 0),
                ax.get_yaxis_transform(),
                "offset points",
                color=colour,
                fontsize=10,
                ha="right",
                va="center",
            )
        left -= 5 * max(map(len, parts)) + 10
    ax.set_yticks(rows, [])
    ax.set_ylabel("")
    ax.set_ylim(-0.6, len(limits) - 0.4)
    for height, mark, text, colour in ((20, "●", measured.allowed, PRISMS), (6, "◇", measured.action, RED)):
        place = (0, 1), (0, height), "axes fraction", "offset points"
        ax.annotate(f"{mark} {text}", *place, color=colour)
    # the title and the note begin at the left of the names
    ax.annotate(ax.get_title("left"), (0, 1), (left, 44), "axes fraction", "offset points", weight="bold", fontsize=12)
    ax.set_title("")
    _explain(ax, measured.note, "grey: as in most rows", *_symbols(" ".join(names)), left=left)


def _series(measured: StabilityMap) -> dict[str, tuple[Floats, Floats]]:
    """Return x and y of each series."""
    names = dict.fromkeys(name for name, _, _ in measured.rows)
    found = {name: np.array([row[1:] for row in measured.rows if row[0] == name]).T for name in names}
    return {name: (x, y) for name, (x, y) in found.items()}


def _symbols(text: str) -> list[str]:
    """Return what the symbols in a text mean: one line, which is empty if the text has none of SYMBOLS."""
    words = {*re.findall(r"\w+", text)}
    return ["; ".join(f"{symbol}: {meaning}" for symbol, meaning in SYMBOLS.items() if symbol in words)]


def _explain(ax: Axes, *lines: str, left: float = 0) -> None:
    """Write below the axes what marks and symbols mean, beginning `left` points right of the axes' left edge."""
    text = "\n".join(fill(line, 80) for line in lines if line)
    ax.annotate(text, (0, 0), (left, -48), "axes fraction", "offset points", va="top", fontsize=10, color="#444444")
