"""Charts of what was measured, and the same data as CSV."""

import csv
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from io import StringIO
from itertools import product
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError
from povgen.files import save
from povgen.measure.measured import Measured
from povgen.measure.plotting import (
    GREY,
    IDEAL,
    PRISMS,
    Axes,
    Bbox,
    Figure,
    FigureCanvasAgg,
    Text,
    drawn,
    name_lines,
    plain_ticks,
    point_to_better,
)
from povgen.measure.speed import Point, pareto_front
from povgen.measure.stability_map import RENDERED, StabilityMap
from povgen.measure.tolerance import Change, percentile
from povgen.settings import QUALITIES, Rendering
from povgen.sheets.prisms import ERRORS


def save_maps(maps: Iterable[StabilityMap], folder: Path, done: Callable[[Measured], object]) -> None:
    """Write each stability map as NAME.png and NAME.csv as soon as it is measured. Calls `done` with each limit."""
    for measured in maps:
        _save_table(folder / f"{measured.name}.csv", ("series", measured.x, measured.y), measured.rows)
        with drawn(8, 5, folder / f"{measured.name}.png") as figure:
            _draw_map(figure.subplots(), measured)
        for limit in measured.limits:
            done(limit)


COLUMNS = ("method", "antialias", "width", "height", "CPU s", "RMS", "FLIP", "FLIP against prisms")


def save_frames(points: list[Point], folder: Path) -> None:
    """Write frames.csv and, for each size, charts of RMS and FLIP against CPU seconds, each with its Pareto front."""
    rows = [(p.method, p.sampling, *p.size, p.cpu, p.rms, p.flip, p.flip_detailed) for p in points]
    _save_table(folder / "frames.csv", COLUMNS, [(*row[:4], *(f"{x:.4g}" for x in row[4:])) for row in rows])
    for size in dict.fromkeys(p.size for p in points):
        of_size = [p for p in points if p.size == size]
        name = f"frames-{size[0]}x{size[1]}"
        with drawn(12, 10, folder / f"{name}.png", folder / f"{name}.svg") as figure:
            axes, labelled = figure.subplots(2, 2, sharex=True, sharey="col"), []
            for row, sheet in zip(axes, ("detailed", "ideal"), strict=True):
                shown = [p for p in of_size if p.method.endswith("ideal") == (sheet == "ideal")]
                row[0].set_title(_finding(sheet, shown))
                for ax, error in zip(row, ("rms", "flip"), strict=True):
                    labelled.append((ax, _scatter(ax, shown, error, sheet)))
            for ax, label in zip(axes[0], ("RMS error (1: white)", "mean FLIP"), strict=True):
                ax.set(ylabel=label)
            for ax, label in zip(axes[1], ("RMS error (1: white)", "mean FLIP"), strict=True):
                ax.set(xlabel=f"CPU seconds for a frame of {size[0]}x{size[1]}", ylabel=label)
            axes[0, 0].text(0.98, 0.02, "grey: other samplings", transform=axes[0, 0].transAxes, color=GREY, ha="right")
            _draw_labels(figure, labelled)


def _finding(sheet: str, points: list[Point]) -> str:
    """Return what a chart's row of these points shows."""
    if sheet == "detailed":
        return "Prisms: gl needs about a tenth of POV-Ray's CPU time for the same error"
    ours, theirs = (min((p.rms for p in points if p.method == name), default=0) for name in ("gl ideal", "ideal"))
    return "Ideal sheet: gl is cheaper, except for the least errors" if ours > theirs else "Ideal sheet: gl is cheaper"


def read_frames(file: Path) -> list[Point]:
    """Return the points of a table like frames.csv. Raises InputError if it is not one."""
    points = []
    try:
        for row in csv.DictReader(StringIO(file.read_text("utf-8"))):
            size = int(row["width"]), int(row["height"])
            seconds, *errors = (float(row[name]) for name in COLUMNS[4:])
            points.append(Point(row["method"], row["antialias"], size, None, [seconds], *errors))
    except (KeyError, TypeError, ValueError, OSError):
        raise InputError(f"table = {file.name!r}: allowed: a table with the columns {', '.join(COLUMNS)}") from None
    return points


class Label(NamedTuple):
    """A text beside the point (x, y)."""

    x: float
    y: float
    text: str
    colour: str
    bold: bool = False


def _scatter(ax: Axes, points: list[Point], error: str, sheet: str) -> list[Label]:
    """Draw error against CPU seconds: povgen's qualities large, other samplings small. Return the points' labels.

    The model's colour and the marker tell the renderer; what povgen does not render is grey.
    """
    labels: list[Label] = []
    qualities: dict[str, list[str]] = {}
    for name in QUALITIES:
        sampling = Rendering(quality=name).suited(sheet != "ideal").sampling
        qualities.setdefault(sampling, []).append(name)
    colour = IDEAL if sheet == "ideal" else PRISMS
    for method in dict.fromkeys(p.method for p in points):
        of_method = [p for p in points if p.method == method]
        renderer = {sheet: "POV-Ray", f"gl {sheet}": "gl", f"live {sheet}": "live view"}.get(method)
        marker = {"POV-Ray": "o", "gl": "D", "live view": "^"}.get(renderer or "", "x")
        ax.plot([p.cpu for p in of_method], [getattr(p, error) for p in of_method], marker, color="#aaaaaa", ms=5)
        best = pareto_front(of_method, error)
        own = colour if renderer in ("POV-Ray", "gl") else GREY
        ax.plot([p.cpu for p in best], [getattr(p, error) for p in best], "-", color=own, alpha=0.45, zorder=1)
        if renderer:
            labels.append(Label(best[-1].cpu, getattr(best[-1], error), renderer, own, bold=True))
        else:
            names = {"intersections": "prisms by hand"}
            if method != "prisms":  # beside the points of intersections
                labels.append(Label(best[-1].cpu, getattr(best[-1], error), names.get(method, method.split()[0]), GREY))
        for p in of_method:
            if renderer in ("POV-Ray", "gl") and p.sampling in qualities:
                ax.plot(p.cpu, getattr(p, error), marker, color=own, markersize=11, markeredgecolor="white")
                labels.append(Label(p.cpu, getattr(p, error), ", ".join(qualities[p.sampling]), own))
    ax.set(xscale="log", yscale="log")
    plain_ticks(ax.xaxis)
    plain_ticks(ax.yaxis)
    ax.grid(alpha=0.25)
    ax.margins(0.12)
    point_to_better(ax)
    return labels


def save_prism_counts(rows: list[tuple[str, int, float, float]], folder: Path) -> None:
    """Write prisms.csv and a chart of position error and CPU seconds against the number of prisms."""
    _save_table(folder / "prisms.csv", ("sheet", "prisms", "CPU s", "position error (px)"), rows)
    with drawn(12, 4.6, folder / "prisms.png", folder / "prisms.svg") as figure:
        for ax, n, label, title, better in zip(
            figure.subplots(1, 2),
            (3, 2),
            ("distance from the ideal image (px of 1280x960)", "CPU seconds for a frame of 640x480"),
            ("Twice as many prisms: half the error …", "… for little more CPU time"),
            (-1, 0),
            strict=True,
        ):
            detailed = [(float(row[1]), float(row[n])) for row in rows if row[0] == "detailed"]
            ax.plot(*np.transpose(detailed), "o-", color=PRISMS, label="2 × N prisms")
            for row in rows:
                if row[0] == "ideal":
                    ends = [each[0] for each in detailed]
                    shown = max(float(row[n]), 0.01) if better else row[n]  # far below the prisms' error
                    name = "ideal sheet" if shown == row[n] else "ideal sheet: below 0.01"
                    ax.plot(
                        [min(ends), max(ends)], [shown] * 2, "-" if shown == row[n] else ":", color=IDEAL, label=name
                    )
            ax.set(xscale="log", xlabel="prisms N of a sheet", ylabel=label, title=title)
            plain_ticks(ax.xaxis)
            ax.grid(alpha=0.25)
            if better:
                ax.set_yscale("log")
                plain_ticks(ax.yaxis, (1,))
            else:
                ax.set_ylim(bottom=0)
            name_lines(ax)


def save_beyond(rows: list[tuple[str, str, float, float]], folder: Path) -> None:
    """Write beyond.csv and a chart of CPU seconds and error, for windows in series and other ideal sheets."""
    _save_table(folder / "beyond.csv", ("kind", "windows or sheet", "CPU s", "position error (px)"), rows)
    with drawn(12, 5.2, folder / "beyond.png", folder / "beyond.svg") as figure:
        axes = figure.subplots(1, 2, sharey=True)
        names, places, top = [], [], 0.0
        # one to three windows, each of prisms and ideal, then the other sheets
        rows = sorted(rows, key=lambda row: (row[0] == "other ideal sheets", row[1], row[0]))
        for kind, name, _, _ in rows:
            windows = "1 window" if name == "1" else f"{name} windows"
            names.append({"detailed": f"{windows}, prisms", "ideal": f"{windows}, ideal"}.get(kind, f"{name}, ideal"))
            top -= 1.5 if kind == "detailed" or name == "axis" else 1
            places.append(top)
        colours = [PRISMS if row[0] == "detailed" else IDEAL for row in rows]
        for ax, column, title, form in (
            (axes[0], 2, "A further window costs less than the first", "CPU seconds for a frame of 640x480"),
            (axes[1], 3, "Only prisms displace what is seen", "position error (px of 1280x960)"),
        ):
            values = [float(row[column]) for row in rows]
            bars = ax.barh(places, values, color=colours)
            ax.bar_label(bars, [f"{x:.2f}" if x >= 0.01 else "below 0.01" for x in values], padding=4)
            ax.set(xlabel=form, title=title)
            ax.set_xlim(right=1.12 * max(values, default=1))
            ax.spines["left"].set_visible(False)
            ax.tick_params(left=False)
        axes[0].set_yticks(places, names)


def save_flicker(rows: list[tuple[str, float]], folder: Path) -> None:
    """Write flicker.csv."""
    _save_table(folder / "flicker.csv", ("antialias", "flicker"), [(name, f"{value:.3g}") for name, value in rows])


def save_workers(rows: list[tuple[int, float, float]], folder: Path) -> None:
    """Write workers.csv and a chart of a movie's wall seconds, and of the cores' use, against workers."""
    _save_table(folder / "workers.csv", ("workers", "wall s", "fraction of cores busy"), rows)
    with drawn(12, 4.6, folder / "workers.png", folder / "workers.svg") as figure:
        workers, wall, busy = zip(*rows, strict=True)
        for ax, values, label, title, top in zip(
            figure.subplots(1, 2),
            (wall, [100 * share for share in busy]),
            ("wall seconds for 61 frames of 320x240", "cores busy (%)"),
            ("More processes at once make a movie sooner …", "… until the cores are busy"),
            (None, 105),
            strict=True,
        ):
            ax.plot(workers, values, "o-", color=PRISMS)
            ax.set(xlabel="POV-Ray processes at once", ylabel=label, title=title)
            ax.set_xscale("log", base=2)
            ax.set_xticks(workers)
            ax.xaxis.set_major_formatter("{x:g}")
            ax.set_ylim(0, top)
            ax.grid(alpha=0.25)


class Tables(NamedTuple):
    """What was measured: the arguments of `save_frames`, `save_prism_counts`, `save_beyond` and `save_workers`."""

    frames: list[Point]
    prism_counts: list[tuple[str, int, float, float]]
    beyond: list[tuple[str, str, float, float]]
    workers: list[tuple[int, float, float]]


def read_tables(folder: Path) -> Tables:
    """Return the tables of an earlier measurement. Raises InputError if one is not there."""
    return Tables(
        read_frames(folder / "frames.csv"),
        _read(folder / "prisms.csv", str, int, float, float),
        _read(folder / "beyond.csv", str, str, float, float),
        _read(folder / "workers.csv", int, float, float),
    )


def redraw(tables: Tables, folder: Path) -> None:
    """Draw the charts again, from the tables of an earlier measurement."""
    save_frames(tables.frames, folder)
    save_prism_counts(tables.prism_counts, folder)
    save_beyond(tables.beyond, folder)
    save_workers(tables.workers, folder)


def _read(file: Path, *types: Callable[[str], object]) -> list[Any]:
    """Return the rows of a table, with columns of these types. Raises InputError if it has no such columns."""
    try:
        rows = list(csv.reader(StringIO(file.read_text("utf-8"))))[1:]
        return [tuple(made(value) for made, value in zip(types, row, strict=True)) for row in rows]
    except (ValueError, OSError):
        raise InputError(f"table = {file.name!r}: allowed: one that povgen chart wrote") from None


ERROR_WORDS = {
    "turn": "near sheet turned",
    "tilt_x": "near sheet tilted about x",
    "tilt_y": "near sheet tilted about y",
    "far_tilt_x": "far sheet tilted about x",
    "far_tilt_y": "far sheet tilted about y",
    "separation": "sheets too far apart",
    "index": "near sheet's index",
    "far_index": "far sheet's index",
    "base_angle": "near prisms' base angle",
    "far_base_angle": "far prisms' base angle",
}


def save_tolerance(sensitivities: Mapping[str, Change], builds: Change | None, path: Path) -> None:
    """Write a chart of how far each error displaces and turns the object, and of how the builds are distributed.

    Its values stand beside it, in a .csv file of the same name.
    """
    small = {"tiles": (0.01, "0.01 tiles"), "": (0.01, "0.01")}  # a tile, or an index of 1, would be far too much
    units = {name: small.get(ERRORS[name].unit, (1.0, "1 degree")) for name in sensitivities}
    table: list[tuple[object, ...]] = []
    with drawn(11, 8.4 if builds else 4.4, path) as figure:
        rows = figure.subplots(2 if builds else 1, 2, squeeze=False)
        for column, (field, unit) in enumerate((("displaced", "arcminutes"), ("turned", "degrees"))):
            ax = rows[0, column]
            values = {
                name: abs(units[name][0] * float(getattr(change, field))) for name, change in sensitivities.items()
            }
            worst = max(values, key=lambda name: np.nan_to_num(values[name]))
            names = [f"{ERROR_WORDS[name]}, {units[name][1].replace(' degree', '°')}" for name in values][::-1]
            colours = [PRISMS if name == worst else "#a9cbe8" for name in values][::-1]
            bars = ax.barh(names, list(values.values())[::-1], color=colours)
            ax.bar_label(bars, [f"{value:.2g}" for value in list(values.values())[::-1]], padding=4)
            ax.margins(x=0.12)
            ax.tick_params(labelleft=column == 0)
            ax.set(xlabel=f"{field}, {unit}", title=f"Most {field} by: {ERROR_WORDS[worst]}")
            table += [
                (f"{name}, {units[name][1]}", f"{field}, {unit}", f"{value:.6g}") for name, value in values.items()
            ]
            if builds:
                ax, most = rows[1, column], percentile(getattr(builds, field), 95)
                ordered = np.sort(np.nan_to_num(getattr(builds, field), nan=np.inf))
                ax.plot(ordered, 100 * np.arange(1, len(ordered) + 1) / len(ordered), color=PRISMS, linewidth=2)
                ax.set(
                    xlabel=f"{field} at most, {unit}", ylabel="share of the builds, %", ylim=(0, 102), xlim=(0, None)
                )
                if np.isfinite(most):
                    ax.plot([0, most, most], [95, 95, 0], ":", color=GREY)
                    ax.plot(most, 95, "o", color=PRISMS, markersize=9)
                ax.set_title(f"95 % of builds: at most {most:.2g} {unit}")
                table += [("random build", f"{field}, {unit}", f"{value:.6g}") for value in getattr(builds, field)]
    _save_table(path.with_suffix(".csv"), ("error", "quantity", "value"), table)


def _draw_labels(figure: Figure, labelled: list[tuple[Axes, list[Label]]]) -> None:
    """Write each label beside its point where it covers no other label or point, with a line to the point."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()  # fixes the layout
    figure.set_layout_engine("none")
    for ax, labels in labelled:
        taken = []
        for line in ax.lines:
            half = line.get_markersize() * 0.9
            taken += [
                Bbox.from_bounds(x - half, y - half, 2 * half, 2 * half)
                for x, y in ax.transData.transform(np.array(line.get_xydata()))
                if line.get_marker() != "None"
            ]
        for x, y, text, colour, bold in labels:
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
                    fontsize=11,
                    fontweight="bold" if bold else "normal",
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


MAP_SYMBOLS = {
    "z2": "from the sheets to the eye (tiles)",
    "α": "angle by which rays turn",
    "N": "prisms of a sheet",
}


def _draw_map(ax: Axes, measured: StabilityMap) -> None:
    """Draw the worst series of a map, four at most, with their names and limits. Shade what is beyond the tolerance.

    A diamond is at each limit that povgen uses for such a series. It has the series' colour, or is black if it is the
    limit of all. Colours follow the order of the measurements. If `measured.is_bound`, `_draw_bound` draws the map.
    """
    found = {name: np.array([row[1:] for row in measured.rows if row[0] == name]).T for name, _, _ in measured.rows}
    series = [name for name in found if not name.endswith(RENDERED)]
    _set_axes(ax, measured)
    if measured.is_bound:
        _draw_bound(ax, measured)
        return
    worst = sorted(series, key=lambda name: -np.nanmean(found[name][1]))
    named = sorted(worst[:: -(-len(worst) // 4) or 1], key=series.index)
    marks, bounds = [], {limit.what.removeprefix(f"{measured.title}: "): limit.bound for limit in measured.limits}
    for name in named:
        x, y = found[name]
        if "y" in measured.log_axes:
            x, y = x[y > 0], y[y > 0]
        (line,) = ax.plot(x, y, "-" if len(x) > 30 else "o-", markersize=5, label=name)
        if name + RENDERED in found:
            ax.plot(*found[name + RENDERED], "x", color=line.get_color(), markersize=8, label="_")
            marks = ["crosses: POV-Ray's pictures; lines: the ray trace"]
        if name in bounds:
            colour = "black" if len(set(bounds.values())) == 1 else line.get_color()
            place = bounds[name], measured.tolerance
            ax.plot(*place, "D", color=colour, markeredgecolor="black", markersize=8, label="_")
    bottom, top = ax.get_ylim()
    if "y" not in measured.log_axes:  # from 0, or from the least value below it, to five times the tolerance
        bottom, top = 1.5 * min(0, *(y for *_, y in measured.rows)), min(top, 5 * measured.tolerance)
    if measured.limits:
        marks.insert(0, "◆ the limit that povgen uses")
        top = max(top, 1.15 * measured.tolerance)
        _shade(ax, measured.beyond, np.array(ax.get_xlim()), np.full(2, measured.tolerance), top)
    ax.set_ylim(bottom, top)
    words = {*re.findall(r"\w+", " ".join(named))}
    symbols = [f"{symbol}: {text}" for symbol, text in MAP_SYMBOLS.items() if symbol in words]
    _explain(ax, marks, symbols)
    name_lines(ax, 10)


def _set_axes(ax: Axes, measured: StabilityMap) -> None:
    """Set the title, the labels and the scales of a map's axes."""
    ax.set(title=measured.finding, xlabel=measured.x, ylabel=measured.y)
    ax.grid(alpha=0.25)
    if "x" in measured.log_axes:
        ax.set_xscale("log")
        x = [x for _, x, _ in measured.rows]
        if min(x) > 0.01:
            plain_ticks(ax.xaxis, (1, 3) if max(x) < 1e5 * min(x) else (1,))
            ax.xaxis.set_major_formatter(lambda x, _: f"{x:,.0f}" if x >= 1 else f"{x:g}")
    if "y" in measured.log_axes:
        ax.set_yscale("log")
        plain_ticks(ax.yaxis, (1, 3))


def _draw_bound(ax: Axes, measured: StabilityMap) -> None:
    """Draw a point for each row: y against the stated bound x. Shade what exceeds the bound.

    As far as the tolerance exceeds the limit, y may exceed the bound too.
    """
    _, x, y = zip(*measured.rows, strict=True)
    limit = measured.limits[0]
    ax.plot(x, y, "o", color=IDEAL if limit.sheet == "ideal" else PRISMS, markersize=6)
    ends = np.array([ax.get_xlim(), ax.get_ylim()])
    ax.axvline(limit.bound, color=GREY, linestyle=":")
    across = np.geomspace(ends[0, 0], ends[0, 1], 200)
    _shade(ax, measured.beyond, across, across + measured.tolerance - limit.bound, ends[1, 1])
    ax.set(xlim=ends[0], ylim=ends[1])
    _explain(ax, ["each point: a scene", f"dotted: {limit.bound:g} px, the most without a warning"])


def _shade(ax: Axes, text: str, x: NDArray[np.float64], bottom: NDArray[np.float64], top: float) -> None:
    """Shade what is between two heights, and say what it is."""
    ax.fill_between(x, bottom, top, color="#c1272d", alpha=0.09, linewidth=0)
    ax.set_xlim(x[0], x[-1])
    ax.text(0.5, 0.98, text, transform=ax.transAxes, color="#c1272d", ha="center", va="top", zorder=5)


def _explain(ax: Axes, *lines: Sequence[str]) -> None:
    """Write below the axes what marks and symbols mean."""
    text = "\n".join(fill("; ".join(line), 105) for line in lines if line)
    ax.annotate(text, (0, 0), (0, -48), "axes fraction", "offset points", va="top", fontsize=10, color="#444444")


def _save_table(path: Path, head: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> None:
    table = StringIO()
    csv.writer(table, lineterminator="\n").writerows([head, *rows])
    save(table.getvalue().encode(), path)
