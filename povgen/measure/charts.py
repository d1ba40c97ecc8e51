"""Charts of what was measured, with matplotlib, and the same as CSV: the one place that draws them."""

import csv
from collections.abc import Callable, Iterable
from io import StringIO
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from povgen.files import save
from povgen.measure.plotting import Axes, Bbox, Figure, FigureCanvasAgg, LogLocator, Text, save_drawing, style
from povgen.measure.speed import Point, front
from povgen.measure.stability import RENDERED, Map
from povgen.measure.verify import Measured


def save_maps(maps: Iterable[Map], folder: Path, done: Callable[[Measured], object]) -> None:
    """Write each stability map as NAME.png and NAME.csv as soon as it is measured, at last all on one page.

    Calls `done` with each limit.
    """
    drawn = []
    for map in maps:
        _table(folder / f"{map.name}.csv", ("series", map.x, map.y), map.rows)
        with style():
            figure = Figure(figsize=(8, 5), layout="constrained")
            _draw(figure.subplots(), map)
            save_drawing(figure, folder / f"{map.name}.png")
        drawn.append(map)
        for limit in map.limits:
            done(limit)
    with style():
        columns = 3
        figure = Figure(figsize=(6 * columns, 4.4 * -(-len(drawn) // columns)), layout="constrained")
        axes = figure.subplots(-(-len(drawn) // columns), columns, squeeze=False).ravel()
        for map, ax in zip(sorted(drawn, key=lambda map: map.title), axes, strict=False):
            _draw(ax, map)
        for ax in axes[len(drawn) :]:
            ax.axis("off")
        save_drawing(figure, folder / "stability.png")


FRAMES = ("method", "antialias", "width", "height", "CPU s", "RMS", "FLIP", "FLIP against prisms")


def save_frames(points: list[Point], folder: Path) -> None:
    """Write frames.csv, and for each size a chart of error against CPU seconds, by RMS and by FLIP, with the front."""
    rows = [(p.method, p.sampling, *p.size, p.cpu, p.rms, p.flip, p.flip_detailed) for p in points]
    _table(folder / "frames.csv", FRAMES, [(*row[:4], *(f"{x:.4g}" for x in row[4:])) for row in rows])
    for size in dict.fromkeys(p.size for p in points):
        of_size = [p for p in points if p.size == size]
        by_hand = sorted({p.method for p in of_size} - {"detailed", "ideal"})
        with style():
            figure = Figure(figsize=(12, 10), layout="constrained")
            axes, to_label = figure.subplots(2, 2), []
            for row, methods, what in zip(
                axes, (["detailed", *by_hand], ["ideal"]), ("2 x 100 prisms", "ideal sheet"), strict=True
            ):
                for ax, error, label in zip(row, ("rms", "flip"), ("RMS error (1: white)", "mean FLIP"), strict=True):
                    to_label.append((ax, _scatter(ax, [p for p in of_size if p.method in methods], error)))
                    ax.set(xlabel="CPU seconds a frame", ylabel=label, title=f"{what}, {size[0]}x{size[1]}")
            for ax, labels in to_label:
                _label(ax, labels)
            name = f"frames-{size[0]}x{size[1]}"
            save_drawing(figure, folder / f"{name}.png", folder / f"{name}.svg")


def _scatter(ax: Axes, points: list[Point], error: str) -> list[tuple[float, float, str, str]]:
    """Error against CPU seconds, a colour for each method, and the Pareto front; returns what to label the points."""
    labels: list[tuple[float, float, str, str]] = []
    for method in dict.fromkeys(p.method for p in points):
        of = [p for p in points if p.method == method]
        (line,) = ax.plot([p.cpu for p in of], [getattr(p, error) for p in of], "o", label=method)
        labels += [(p.cpu, getattr(p, error), p.sampling, str(line.get_color())) for p in of]
    best = front(points, error)
    ax.plot([p.cpu for p in best], [getattr(p, error) for p in best], "k-", alpha=0.4, label="front")
    ax.set(xscale="log", yscale="log")
    for axis in (ax.xaxis, ax.yaxis):  # 0.2, not 2 x 10^-1: those run into each other
        axis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")
    ax.grid(alpha=0.25, which="both")
    ax.margins(0.12)
    ax.legend()
    return labels


def save_counts(rows: list[tuple[Any, ...]], folder: Path) -> None:
    """Write prisms.csv and a chart of position error and CPU seconds against the number of prisms."""
    _table(folder / "prisms.csv", ("sheet", "prisms", "CPU s", "position error (px)"), rows)
    with style():
        figure, to_label = Figure(figsize=(12, 4.6), layout="constrained"), []
        for ax, column, label in zip(
            figure.subplots(1, 2), (3, 2), ("position error against eq. 7 (px)", "CPU seconds a frame"), strict=True
        ):
            detailed = [row for row in rows if row[0] == "detailed"]
            ax.plot([row[1] for row in detailed], [row[column] for row in detailed], "o-", label="detailed")
            for row in rows:
                if row[0] == "ideal":
                    ax.axhline(row[column], color="#d1603d", label="ideal")
            ax.set(xscale="log", xlabel="prisms N", ylabel=label, title=label.split(" (")[0])
            if column == 3:
                ax.set_yscale("log")
            else:
                ax.set_ylim(bottom=0)
            to_label.append((ax, [(row[1], row[column], str(row[1]), "black") for row in detailed]))
            ax.grid(alpha=0.25)
            ax.legend()
        for ax, labels in to_label:
            _label(ax, labels)
        save_drawing(figure, folder / "prisms.png", folder / "prisms.svg")


def save_movies(rows: list[tuple[int, float, float]], folder: Path) -> None:
    """Write workers.csv and a chart of a movie's wall seconds and of the cores' use against workers."""
    _table(folder / "workers.csv", ("workers", "wall s", "fraction of cores busy"), rows)
    with style():
        figure = Figure(figsize=(8, 4.6), layout="constrained")
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
        save_drawing(figure, folder / "workers.png", folder / "workers.svg")


def _label(ax: Axes, labels: list[tuple[float, float, str, str]]) -> None:
    """Write beside points (x, y, text, colour) what they are, each where it covers no other, with a line to it."""
    figure = ax.figure.figure
    assert figure
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()  # which lays it out
    figure.set_layout_engine("none")
    points = [ax.transData.transform((x, y)) for x, y, _, _ in labels]
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
            box = Text.get_window_extent(note, renderer).padded(1)  # of the text alone, without the line
            if ax.bbox.containsx(box.x0) and ax.bbox.containsx(box.x1) and not any(map(box.overlaps, taken)):
                break
        taken.append(box)


def _draw(ax: Axes, map: Map) -> None:
    """A map: each series, the tolerance as a dashed line, and a diamond on it at each limit that is in force."""
    rendered = None
    for series in dict.fromkeys(name for name, _, _ in map.rows):
        x, y = np.array([row[1:] for row in map.rows if row[0] == series]).T
        if series.endswith(RENDERED):  # beside the exact ray trace's line
            (rendered,) = ax.plot(x, y, "kx", markersize=6)
        else:
            ax.plot(x, y, "-" if len(x) > 20 else "o-", markersize=5, label=series)
    if rendered:
        rendered.set_label("the same, by POV-Ray")
    if map.limits:
        ax.axhline(map.most, color="black", linestyle="--", linewidth=1, label="tolerance")
        places = sorted({limit.bound for limit in map.limits})
        ax.plot(places, [map.most] * len(places), "D", color="black", markersize=7, label="limit in force")
    if "x" in map.logs:
        ax.set_xscale("log")
    if "y" in map.logs:
        ax.set_yscale("log")
    else:
        ax.set_ylim(bottom=0)
    ax.set(title=map.title, xlabel=map.x, ylabel=map.y)
    ax.grid(alpha=0.25)
    ax.legend()


def _table(path: Path, head: tuple[str, ...], rows: Iterable[tuple]) -> None:
    table = StringIO()
    csv.writer(table, lineterminator="\n").writerows([head, *rows])
    save(table.getvalue().encode(), path)
