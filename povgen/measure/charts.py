"""Charts of what was measured, and the same data as CSV."""

import csv
from collections.abc import Callable, Iterable
from io import StringIO
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from povgen.files import save
from povgen.measure.measured import Measured
from povgen.measure.plotting import Axes, Axis, Bbox, Figure, FigureCanvasAgg, LogLocator, Text, drawn
from povgen.measure.speed import Point, pareto_front
from povgen.measure.stability import RENDERED, StabilityMap


def save_maps(maps: Iterable[StabilityMap], folder: Path, done: Callable[[Measured], object]) -> None:
    """Write each stability map as NAME.png and NAME.csv as soon as it is measured, and finally all on one page.

    Calls `done` with each limit.
    """
    finished = []
    for measured in maps:
        _save_table(folder / f"{measured.name}.csv", ("series", measured.x, measured.y), measured.rows)
        with drawn(8, 5, folder / f"{measured.name}.png") as figure:
            _draw_map(figure.subplots(), measured)
        finished.append(measured)
        for limit in measured.limits:
            done(limit)
    columns, rows = 3, -(-len(finished) // 3)
    with drawn(6 * columns, 4.4 * rows, folder / "stability.png") as figure:
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for measured, ax in zip(sorted(finished, key=lambda measured: measured.title), axes, strict=False):
            _draw_map(ax, measured)
        for ax in axes[len(finished) :]:
            ax.axis("off")


COLUMNS = ("method", "antialias", "width", "height", "CPU s", "RMS", "FLIP", "FLIP against prisms")


def save_frames(points: list[Point], folder: Path) -> None:
    """Write frames.csv and, for each size, charts of RMS and FLIP against CPU seconds, each with its Pareto front."""
    rows = [(p.method, p.sampling, *p.size, p.cpu, p.rms, p.flip, p.flip_detailed) for p in points]
    _save_table(folder / "frames.csv", COLUMNS, [(*row[:4], *(f"{x:.4g}" for x in row[4:])) for row in rows])
    for size in dict.fromkeys(p.size for p in points):
        of_size = [p for p in points if p.size == size]
        ideal = [p for p in of_size if p.method.endswith("ideal")]
        detailed = [p for p in of_size if not p.method.endswith("ideal")]
        name = f"frames-{size[0]}x{size[1]}"
        with drawn(12, 10, folder / f"{name}.png", folder / f"{name}.svg") as figure:
            axes, labelled = figure.subplots(2, 2), []
            for row, shown, what in zip(axes, (detailed, ideal), ("2 x 100 prisms", "ideal sheet"), strict=True):
                for ax, error, label in zip(row, ("rms", "flip"), ("RMS error (1: white)", "mean FLIP"), strict=True):
                    labelled.append((ax, _scatter(ax, shown, error)))
                    ax.set(xlabel="CPU seconds a frame", ylabel=label, title=f"{what}, {size[0]}x{size[1]}")
            _draw_labels(figure, labelled)


class Label(NamedTuple):
    """A text beside the point (x, y)."""

    x: float
    y: float
    text: str
    colour: str


def _scatter(ax: Axes, points: list[Point], error: str) -> list[Label]:
    """Draw error against CPU seconds, a colour for each method, and the Pareto front. Return the points' labels."""
    labels: list[Label] = []
    for method in dict.fromkeys(p.method for p in points):
        of_method = [p for p in points if p.method == method]
        (line,) = ax.plot([p.cpu for p in of_method], [getattr(p, error) for p in of_method], "o", label=method)
        labels += [Label(p.cpu, getattr(p, error), p.sampling, str(line.get_color())) for p in of_method]
    best = pareto_front([p for p in points if not p.method.startswith("live")], error)
    ax.plot([p.cpu for p in best], [getattr(p, error) for p in best], "k-", alpha=0.4, label="POV-Ray's Pareto front")
    ax.set(xscale="log", yscale="log")
    _plain_ticks(ax.xaxis)
    _plain_ticks(ax.yaxis)
    ax.grid(alpha=0.25, which="both")
    ax.margins(0.12)
    ax.legend(loc="lower left")  # no picture is both cheap and accurate
    return labels


def _plain_ticks(axis: Axis) -> None:
    """Write the numbers of a logarithmic axis as 0.2 instead of 2 x 10^-1, which would overlap the next numbers."""
    axis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter("")


def save_prism_counts(rows: list[tuple[str, int, float, float]], folder: Path) -> None:
    """Write prisms.csv and a chart of position error and CPU seconds against the number of prisms."""
    _save_table(folder / "prisms.csv", ("sheet", "prisms", "CPU s", "position error (px)"), rows)
    with drawn(12, 4.6, folder / "prisms.png", folder / "prisms.svg") as figure:
        labelled = []
        prisms = [row[1] for row in rows if row[0] == "detailed"]
        for ax, log, label, values in zip(
            figure.subplots(1, 2),
            (True, False),
            ("position error against eq. 7 (px)", "CPU seconds a frame"),
            ([row[3] for row in rows], [row[2] for row in rows]),
            strict=True,
        ):
            detailed = [y for y, row in zip(values, rows, strict=True) if row[0] == "detailed"]
            ax.plot(prisms, detailed, "o-", label="detailed")
            for y, row in zip(values, rows, strict=True):
                if row[0] == "ideal":
                    ax.axhline(y, color="#d1603d", label="ideal")
            ax.set(xscale="log", xlabel="prisms N", ylabel=label, title=label.split(" (")[0])
            if log:
                ax.set_yscale("log")
            else:
                ax.set_ylim(bottom=0)
            labelled.append((ax, [Label(x, y, str(x), "black") for x, y in zip(prisms, detailed, strict=True)]))
            ax.grid(alpha=0.25)
            ax.legend()
        _draw_labels(figure, labelled)


def save_beyond(rows: list[tuple[str, str, float, float]], folder: Path) -> None:
    """Write beyond.csv and a chart of error against CPU seconds, for windows in series and other ideal sheets."""
    _save_table(folder / "beyond.csv", ("kind", "windows or sheet", "CPU s", "position error (px)"), rows)
    with drawn(8, 4.6, folder / "beyond.png", folder / "beyond.svg") as figure:
        ax, labels = figure.subplots(), []
        for kind in dict.fromkeys(row[0] for row in rows):
            names, cpu, error = zip(*(row[1:] for row in rows if row[0] == kind), strict=True)
            (line,) = ax.plot(cpu, error, "o" if "other" in kind else "o-", label=kind)
            colour = str(line.get_color())
            labels += [
                Label(x, y, f"{name} windows" if name in "23" else "1 window" if name == "1" else name, colour)
                for name, x, y in zip(names, cpu, error, strict=True)
            ]
        ax.set(xscale="log", yscale="log", xlabel="CPU seconds a frame", ylabel="position error (px)")
        ax.set_title("windows in series, and other ideal sheets, 640x480")
        _plain_ticks(ax.xaxis)
        ax.margins(0.15)
        ax.grid(alpha=0.25)
        ax.legend(loc="lower right")  # empty: the costly sheets are not the accurate ones
        _draw_labels(figure, [(ax, labels)])


def save_flicker(rows: list[tuple[str, float]], folder: Path) -> None:
    """Write flicker.csv."""
    _save_table(folder / "flicker.csv", ("antialias", "flicker"), [(name, f"{value:.3g}") for name, value in rows])


def save_workers(rows: list[tuple[int, float, float]], folder: Path) -> None:
    """Write workers.csv and a chart of a movie's wall seconds, and of the cores' use, against workers."""
    _save_table(folder / "workers.csv", ("workers", "wall s", "fraction of cores busy"), rows)
    with drawn(8, 4.6, folder / "workers.png", folder / "workers.svg") as figure:
        ax = figure.subplots()
        workers, wall, busy = zip(*rows, strict=True)
        ax.plot(workers, wall, "o-", label="wall seconds")
        ax.set(xlabel="POV-Ray processes at once", ylabel="wall seconds", title="a movie of 61 frames, 320x240")
        ax.set_ylim(bottom=0)
        ax.set_xscale("log", base=2)
        ax.xaxis.set_major_formatter("{x:g}")
        other = ax.twinx()
        other.plot(workers, [100 * share for share in busy], "s--", color="#d1603d", label="cores busy")
        other.set(ylim=(0, 105), ylabel="cores busy (%)")
        ax.legend(
            *(a + b for a, b in zip(*(x.get_legend_handles_labels() for x in (ax, other)), strict=True)),
            loc="center right",
        )
        ax.grid(alpha=0.25)


def _draw_labels(figure: Figure, labelled: list[tuple[Axes, list[Label]]]) -> None:
    """Write each label beside its point where it covers no other label or point, with a line to the point."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()  # fixes the layout
    figure.set_layout_engine("none")
    for ax, labels in labelled:
        points = [ax.transData.transform((label.x, label.y)) for label in labels]
        taken = [Bbox.from_bounds(x - 4, y - 4, 8, 8) for x, y in points]
        for x, y, text, colour in labels:
            note = None
            for distance, angle in product((10, 18, 28, 40, 55, 75), np.radians(np.arange(0, 360, 20))):
                if note:
                    note.remove()
                side = np.cos(angle)
                note = ax.annotate(
                    text,
                    (x, y),
                    (distance * side, distance * np.sin(angle)),
                    textcoords="offset points",
                    fontsize=8,
                    color=colour,
                    ha="left" if side > 0.2 else "right" if side < -0.2 else "center",
                    va="center",
                    bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
                    arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 2},
                )
                note.update_positions(renderer)
                box = Text.get_window_extent(note, renderer).padded(1)  # the text without the line
                if ax.bbox.containsx(box.x0) and ax.bbox.containsx(box.x1) and not any(map(box.overlaps, taken)):
                    break
            taken.append(box)


def _draw_map(ax: Axes, measured: StabilityMap) -> None:
    """Draw each series, the tolerance as a dashed line, and on this line a diamond at each limit that povgen uses."""
    rendered = None
    for series in dict.fromkeys(name for name, _, _ in measured.rows):
        x, y = np.array([row[1:] for row in measured.rows if row[0] == series]).T
        if series.endswith(RENDERED):  # drawn over the exact ray trace's line
            (rendered,) = ax.plot(x, y, "kx", markersize=6)
        else:
            ax.plot(x, y, "-" if len(x) > 20 else "o-", markersize=5, label=series)
    if rendered:
        rendered.set_label("the same, by POV-Ray")
    if measured.limits:
        ax.axhline(measured.tolerance, color="black", linestyle="--", linewidth=1, label="tolerance")
        places = sorted({limit.bound for limit in measured.limits})
        ax.plot(places, [measured.tolerance] * len(places), "D", color="black", markersize=7, label="limit used")
    if "x" in measured.log_axes:
        ax.set_xscale("log")
    if "y" in measured.log_axes:
        ax.set_yscale("log")
    else:
        ax.set_ylim(bottom=0)
    ax.set(title=measured.title, xlabel=measured.x, ylabel=measured.y)
    ax.grid(alpha=0.25)
    ax.legend()


def _save_table(path: Path, head: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> None:
    table = StringIO()
    csv.writer(table, lineterminator="\n").writerows([head, *rows])
    save(table.getvalue().encode(), path)
