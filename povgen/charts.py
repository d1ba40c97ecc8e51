"""Charts of what was measured, with matplotlib, and the same as CSV: the one place that draws."""

import csv
from collections.abc import Callable, Iterable
from io import BytesIO, StringIO
from itertools import product
from pathlib import Path

import numpy as np

from povgen.errors import InputError
from povgen.output import save
from povgen.speed import MAIN, Point, front
from povgen.stability import RENDERED, Map
from povgen.verify import Measured

try:
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox
except ImportError:
    raise InputError("charts are drawn with matplotlib, which is not installed: pip install 'povgen[charts]'") from None

STYLE = {
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "font.size": 11,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "axes.prop_cycle": matplotlib.cycler(
        color=["#0b5fa5", "#d1603d", "#3a7d44", "#7b4b94", "#b58900", "#555555", "#c2185b", "#17a2a2"]
    ),
}


def save_maps(maps: Iterable[Map], folder: Path, done: Callable[[Measured], object]) -> None:
    """Write each stability map as NAME.png and NAME.csv as soon as it is measured, at last all on one page.

    Calls `done` with each limit.
    """
    drawn = []
    for map in maps:
        _table(folder / f"{map.name}.csv", ("series", map.x, map.y), map.rows)
        with matplotlib.rc_context(STYLE):
            figure = Figure(figsize=(8, 5), layout="constrained")
            _draw(figure.subplots(), map)
            _save(figure, folder / f"{map.name}.png")
        drawn.append(map)
        for limit in map.limits:
            done(limit)
    with matplotlib.rc_context(STYLE):
        columns = 3
        figure = Figure(figsize=(6 * columns, 4.4 * -(-len(drawn) // columns)), layout="constrained")
        axes = figure.subplots(-(-len(drawn) // columns), columns, squeeze=False).ravel()
        for map, ax in zip(sorted(drawn, key=lambda map: map.title), axes, strict=False):
            _draw(ax, map)
        for ax in axes[len(drawn) :]:
            ax.axis("off")
        _save(figure, folder / "stability.png")


FRAMES = ("method", "antialias", "width", "height", "CPU s", "RMS", "FLIP", "FLIP against prisms")


def save_frames(points: list[Point], folder: Path) -> None:
    """Write frames.csv, and charts of error against CPU seconds, picture by RMS and by FLIP, with the Pareto front."""
    rows = [(p.method, p.sampling, *p.size, p.cpu, p.rms, p.flip, p.flip_detailed) for p in points]
    _table(folder / "frames.csv", FRAMES, [(*row[:4], *(f"{x:.4g}" for x in row[4:])) for row in rows])
    errors = {"rms": "RMS error (1: white)", "flip": "mean FLIP error"}
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(15, 12), layout="constrained")
        axes = figure.subplots(2, 2)
        for row, (methods, what) in zip(
            axes,
            (
                (["detailed", *sorted({p.method for p in points} - {"detailed", "ideal"})], "2 x 100 prisms"),
                (["ideal"], "ideal sheet"),
            ),
            strict=True,
        ):
            for ax, (error, label) in zip(row, errors.items(), strict=True):
                ax.set(xscale="log", yscale="log", xlabel="CPU seconds a frame", ylabel=label)
                ax.set_title(f"{what}, {MAIN[0]}x{MAIN[1]}: {label.split(' (')[0]}")
                labels = []
                for method in methods:
                    of = [p for p in points if p.method == method and p.size == MAIN]
                    (line,) = ax.plot([p.cpu for p in of], [getattr(p, error) for p in of], "o", label=method)
                    labels += [(p.cpu, getattr(p, error), p.sampling, line.get_color()) for p in of]
                best = front([p for p in points if p.method in methods and p.size == MAIN], error)
                ax.plot([p.cpu for p in best], [getattr(p, error) for p in best], "k-", alpha=0.4, label="front")
                ax.grid(alpha=0.25, which="both")
                ax.legend()
                ax.margins(0.12)
                _label(ax, labels)
        _save(figure, folder / "frames.png", folder / "frames.svg")


def save_counts(rows: list[tuple[str, int, float, float]], folder: Path) -> None:
    """Write prisms.csv and a chart of position error and CPU seconds against the number of prisms."""
    _table(folder / "prisms.csv", ("sheet", "prisms", "CPU s", "position error (px)"), rows)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(12, 4.6), layout="constrained")
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
            _label(ax, [(row[1], row[column], str(row[1]), "black") for row in detailed])
            ax.grid(alpha=0.25)
            ax.legend()
        _save(figure, folder / "prisms.png", folder / "prisms.svg")


def save_movies(rows: list[tuple[int, float, float]], folder: Path) -> None:
    """Write workers.csv and a chart of a movie's wall seconds and of the cores' use against workers."""
    _table(folder / "workers.csv", ("workers", "wall s", "fraction of cores busy"), rows)
    with matplotlib.rc_context(STYLE):
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
        ax.legend(*(a + b for a, b in zip(*(x.get_legend_handles_labels() for x in (ax, other)), strict=True)))
        ax.grid(alpha=0.25)
        _save(figure, folder / "workers.png", folder / "workers.svg")


def _label(ax: Axes, labels: list[tuple[float, float, str, str]]) -> None:
    """Write beside points (x, y, text, colour) what they are, each where it covers no other, with a line to it."""
    renderer = ax.figure.canvas.get_renderer()
    ax.figure.draw_without_rendering()
    points = [ax.transData.transform((x, y)) for x, y, _, _ in labels]
    taken = [Bbox.from_bounds(x - 4, y - 4, 8, 8) for x, y in points]
    for (x, y, text, colour), _ in zip(labels, points, strict=True):
        for distance, angle in product((9, 20, 32, 45, 60), np.radians(np.arange(0, 360, 30))):
            offset = distance * np.cos(angle), distance * np.sin(angle)
            note = ax.annotate(
                text,
                (x, y),
                offset,
                textcoords="offset points",
                fontsize=8,
                color=colour,
                ha="left" if offset[0] > 1 else "right" if offset[0] < -1 else "center",
                va="center",
                arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 2},
            )
            box = note.get_window_extent(renderer).padded(1)
            if not any(box.overlaps(other) for other in taken):
                break
            note.remove()
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


def _save(figure: Figure, *paths: Path) -> None:
    for path in paths:
        image = BytesIO()
        figure.savefig(image, format=path.suffix[1:], dpi=110)
        save(image.getvalue(), path)
