"""Charts of what was measured, and the same data as CSV."""

import csv
from collections.abc import Callable, Mapping
from io import StringIO
from itertools import product
from pathlib import Path
from statistics import median
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError
from povgen.measure.plotting import (
    GREY,
    IDEAL,
    PRISMS,
    Axes,
    Figure,
    FigureCanvasAgg,
    drawn,
    name_lines,
    plain_ticks,
    point_to_better,
    save_table,
)
from povgen.measure.speed import SIZES, Point, pareto_front
from povgen.measure.tolerance import Change, percentile
from povgen.settings import QUALITIES, Rendering
from povgen.sheets.prisms import ERRORS

Floats = NDArray[np.float64]

# the heads of the tables
FRAMES_HEAD = ("method", "antialias", "width", "height", "CPU s", "RMS", "FLIP", "FLIP against prisms")
FLICKER_HEAD = ("antialias", "flicker")
PRISMS_HEAD = ("sheet", "prisms", "CPU s", "position error (px)")
BEYOND_HEAD = ("kind", "windows or sheet", "CPU s", "position error (px)")
WORKERS_HEAD = ("workers", "wall s", "fraction of cores busy", "cores")

# what `povgen chart` writes
FILES = [
    *("frames.csv", "flicker.csv", "machine.txt", "charts.html"),
    *(f"{name}.{kind}" for name in ("polarisation", "diffraction", "field", "curl") for kind in ("csv", "png")),
    *(f"{name}.{kind}" for name in ("prisms", "beyond", "workers") for kind in ("csv", "png", "svg")),
    *(f"frames-{width}x{height}.{kind}" for width, height in SIZES for kind in ("png", "svg")),
]


def save_frames(points: list[Point], folder: Path) -> None:
    """Write frames.csv and, for each size, a chart of RMS against CPU seconds, with the Pareto fronts."""
    rows = [(p.method, p.sampling, *p.size, p.cpu, p.rms, p.flip, p.flip_detailed) for p in points]
    save_table(folder / "frames.csv", FRAMES_HEAD, [(*row[:4], *(f"{x:.4g}" for x in row[4:])) for row in rows])
    for size in dict.fromkeys(p.size for p in points):
        name = f"frames-{size[0]}x{size[1]}"
        with drawn(12, 6.2, folder / f"{name}.png", folder / f"{name}.svg") as figure:
            axes, labelled = figure.subplots(1, 2, sharex=True, sharey=True), []
            for ax, sheet in zip(axes, ("detailed", "ideal"), strict=True):
                shown = [p for p in points if p.size == size and p.method.endswith("ideal") == (sheet == "ideal")]
                ax.set(title=_finding(sheet, shown), xlabel=f"CPU seconds for a frame of {size[0]}x{size[1]}")
                labelled.append((ax, _scatter(ax, shown, sheet)))
            axes[0].set(ylabel="error: RMS difference from the converged picture (1: white)")
            key = [
                "large, with a name: povgen's qualities",
                "small, grey: other samplings",
                "lines: no cheaper sampling has a smaller error",
            ]
            if any(p.size == size and p.method.split()[-1] not in ("detailed", "ideal") for p in points):
                key.append("crosses (left): other programs, and prisms by hand")
            axes[1].text(0.98, 0.98, "\n".join(key), transform=axes[1].transAxes, color="#444444", ha="right", va="top")
            _draw_labels(figure, labelled)


def _finding(sheet: str, points: list[Point]) -> str:
    """Return a panel's title: whether gl is faster than POV-Ray, for these points of one model of the sheets.

    The median of the ratios of their CPU seconds decides, over all samplings that both renderers have.
    """
    shown = {"detailed": "Prisms", "ideal": "Ideal sheet"}[sheet]
    seconds = {(p.method, p.sampling): p.cpu for p in points}
    theirs = {sampling: cpu for (method, sampling), cpu in seconds.items() if method == sheet}
    shares = [seconds[f"gl {sheet}", each] / cpu for each, cpu in theirs.items() if (f"gl {sheet}", each) in seconds]
    if not shares:
        return f"{shown}: error against cost"
    return f"{shown}: gl is {'faster' if median(shares) < 1 else 'slower'} than POV-Ray"


def _text(file: Path) -> str:
    """Return a table's text. Raises InputError if the file cannot be read."""
    try:
        return file.read_text("utf-8", "replace")  # a file that is no text has no columns, either
    except OSError as error:
        raise InputError(f"table = {str(file)!r}: {error.strerror}; allowed: a table that povgen chart wrote") from None


def read_frames(file: Path) -> list[Point]:
    """Return the points of a table like frames.csv. Raises InputError if it is not one."""
    points, text = [], _text(file)
    try:
        for row in csv.DictReader(StringIO(text)):
            size = _count(row["width"]), _count(row["height"])
            seconds, *errors = (_amount(row[name]) for name in FRAMES_HEAD[4:])
            points.append(Point(row["method"], row["antialias"], size, None, [seconds], *errors))
        if not points:
            raise ValueError
    except (KeyError, TypeError, ValueError, csv.Error):
        raise InputError(
            f"table = {str(file)!r}: allowed: a table of povgen chart, with the columns {', '.join(FRAMES_HEAD)}"
        ) from None
    return points


class Label(NamedTuple):
    """A text beside the point (x, y)."""

    x: float
    y: float
    text: str
    colour: str
    bold: bool = False


def _scatter(ax: Axes, points: list[Point], sheet: str) -> list[Label]:
    """Draw RMS against CPU seconds: povgen's qualities large, other samplings small. Return the points' labels.

    The marker says which renderer it is. Fronts and labels of POV-Ray and gl have the colour of the model of the
    sheets. Those of the live view and of the baselines are grey.
    """
    labels: list[Label] = []
    samplings = {name: Rendering(quality=name).suited(sheet != "ideal").sampling for name in QUALITIES}
    colour = IDEAL if sheet == "ideal" else PRISMS
    for method in dict.fromkeys(p.method for p in points):
        of_method = [p for p in points if p.method == method]
        renderer = {sheet: "POV-Ray", f"gl {sheet}": "gl", f"live {sheet}": "live view"}.get(method)
        marker = {"POV-Ray": "o", "gl": "D", "live view": "^"}.get(renderer or "", "x")
        ax.plot([p.cpu for p in of_method], [p.rms for p in of_method], marker, color="#d4d4d4", ms=4)
        best = pareto_front(of_method, "rms")
        own = colour if renderer in ("POV-Ray", "gl") else GREY
        same = {"1.5x": "2x"} if renderer == "gl" else {}  # gl draws the same picture for both
        qualities: dict[str, list[str]] = {}
        for name, sampling in samplings.items():
            qualities.setdefault(same.get(sampling, sampling), []).append(name)
        dashes = "--" if renderer == "POV-Ray" else "-"
        ax.plot([p.cpu for p in best], [p.rms for p in best], dashes, color=own, alpha=0.45, zorder=1)
        if renderer:
            what = {"gl": "gl (without GPU)", "live view": "live view (browser)"}.get(renderer, renderer)
            labels.append(Label(best[-1].cpu, best[-1].rms, what, own, bold=True))
        else:
            names = {"intersections": "prisms by hand"}
            if method != "prisms":  # its points lie beside those of "intersections", whose label is for both
                labels.append(Label(best[-1].cpu, best[-1].rms, names.get(method, method.split()[0]), GREY))
        for p in of_method:
            if renderer in ("POV-Ray", "gl") and p.sampling in qualities:
                ax.plot(p.cpu, p.rms, marker, color=own, markersize=11, markeredgecolor="white")
                labels.append(Label(p.cpu, p.rms, ", ".join(qualities[p.sampling]), own))
    ax.set(xscale="log", yscale="log")
    plain_ticks(ax.xaxis)
    plain_ticks(ax.yaxis)
    ax.grid(alpha=0.25)
    ax.margins(0.2, 0.12)  # room for names
    point_to_better(ax)
    drafts = {p.method: p for p in points if p.sampling == samplings["draft"]}
    fast, slow = drafts.get(f"gl {sheet}"), drafts.get(sheet)
    if fast and slow and max(fast.rms / slow.rms, slow.rms / fast.rms) < 1.1:
        y = 1.18 * max(fast.rms, slow.rms)
        look = {"arrowstyle": "<->", "color": "#444444", "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", (fast.cpu, y), (slow.cpu, y), arrowprops=look)
        text = f"draft: {slow.cpu / fast.cpu:.0f} times faster"
        ax.text(np.sqrt(fast.cpu * slow.cpu), 1.03 * y, text, ha="center", va="bottom", color="#444444")
    return labels


def save_prism_counts(rows: list[tuple[str, int, float, float]], folder: Path) -> None:
    """Write prisms.csv and a chart of position error and CPU seconds against the number of prisms."""
    save_table(folder / "prisms.csv", PRISMS_HEAD, rows)
    counts, seconds, errors = np.transpose(sorted(row[1:] for row in rows if row[0] == "detailed"))
    several = len(counts) > 1
    halved = several and (errors > 0).all() and (abs(np.diff(np.log(errors)) / np.diff(np.log(counts)) + 1) < 0.3).all()
    cheap = several and seconds[-1] < 2 * seconds[0]
    with drawn(12, 4.6, folder / "prisms.png", folder / "prisms.svg") as figure:
        for ax, n, label, title, better in zip(
            figure.subplots(1, 2),
            (3, 2),
            ("distance from the ideal image (px of 1280x960)", "CPU seconds for a frame of 640x480"),
            (
                "Twice as many prisms: half the error" if halved else "Error for each number of prisms",
                "More prisms cost little more CPU time" if cheap else "CPU time for each number of prisms",
            ),
            (-1, 0),
            strict=True,
        ):
            detailed = [(float(row[1]), float(row[n])) for row in rows if row[0] == "detailed"]
            ax.plot(*np.transpose(detailed), "o-", color=PRISMS, label="2 × N prisms")
            for row in rows:
                if row[0] == "ideal":
                    ends = [each[0] for each in detailed]
                    # a smaller error is drawn at 0.01, which is far below the prisms' errors
                    shown = max(float(row[n]), 0.01) if better else row[n]
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
    save_table(folder / "beyond.csv", BEYOND_HEAD, rows)
    with drawn(12, 5.2, folder / "beyond.png", folder / "beyond.svg") as figure:
        axes = figure.subplots(1, 2, sharey=True)
        names, places, top = [], [], 0.0
        headings: dict[str, float] = {}
        # one to three windows, each of prisms and ideal, then the other sheets
        rows = sorted(rows, key=lambda row: (row[0] == "other ideal sheets", row[1], row[0]))
        for kind, name, _, _ in rows:
            windows = "1 window" if name == "1" else f"{name} windows"
            if kind == "other ideal sheets" and not headings:
                top -= 1.5
                headings = {f"{kind}, 1 window:": top}
            names.append({"detailed": f"{windows}, prisms", "ideal": f"{windows}, ideal"}.get(kind, name))
            top -= 1.5 if kind == "detailed" else 1
            places.append(top)
        cost = {row[:2]: row[2] for row in rows}
        fewer = [
            [cost[kind, str(n)] for n in range(1, int(name))] if name.isdigit() else [] for kind, name, _, _ in rows
        ]
        steps = [row[2] - less[-1] if less else None for row, less in zip(rows, fewer, strict=True)]
        further = [f" ({step:+.2f})" if step is not None else "" for step in steps]
        dear = any(step is not None and step >= less[0] for step, less in zip(steps, fewer, strict=True))
        colours = [PRISMS if row[0] == "detailed" else IDEAL for row in rows]
        for ax, column, title, form in (
            (
                axes[0],
                2,
                "CPU time of several windows" if dear else "A further window costs less than the first",
                "CPU seconds for a frame of 640x480 (in brackets: of the last window)",
            ),
            (axes[1], 3, "Only prisms displace what is seen", "distance from the exact position (px of 1280x960)"),
        ):
            values = [float(row[column]) for row in rows]
            bars = ax.barh(places, [x if x >= 0.01 else 0 for x in values], color=colours)
            texts = [f"{x:.2f}" if x >= 0.01 else "below 0.01" for x in values]
            ax.bar_label(bars, [*map("".join, zip(texts, further, strict=True))] if column == 2 else texts, padding=4)
            ax.set(xlabel=form, title=title)
            ax.set_xlim(right=1.25 * max(values, default=1))
            ax.spines["left"].set_visible(False)
            ax.tick_params(left=False)
        for place, less in zip(places, fewer, strict=True):
            axes[0].vlines(less, place - 0.4, place + 0.4, color="white", linewidth=2)
        axes[0].set_yticks([*places, *headings.values()], [*names, *headings])


def save_flicker(rows: list[tuple[str, float]], folder: Path) -> None:
    """Write flicker.csv."""
    save_table(folder / "flicker.csv", FLICKER_HEAD, [(name, f"{value:.3g}") for name, value in rows])


def save_workers(rows: list[tuple[int, float, float, int]], folder: Path) -> None:
    """Write workers.csv and a chart of a movie's wall seconds against workers."""
    _, _, _, cores = rows[0]
    save_table(folder / "workers.csv", WORKERS_HEAD, rows)
    with drawn(8, 4.6, folder / "workers.png", folder / "workers.svg") as figure:
        workers, wall, busy = np.transpose([row[:3] for row in rows])
        ax = figure.subplots()
        ax.plot(workers, wall, "o-", color=PRISMS, label="measured")
        ax.plot(workers, wall * busy, ":", color=GREY, label="if no core were idle")
        ax.set(xlabel=f"POV-Ray processes at once, on {cores} cores", ylabel="wall seconds for 61 frames of 320x240")
        several = workers > cores
        better = several.any() and busy[several].max() > busy[~several].max(initial=0)
        ax.set_title("Several processes for each core keep the cores busy" if better else "A movie's time by processes")
        ax.set_xscale("log", base=2)
        ax.set_xticks(workers)
        ax.xaxis.set_major_formatter("{x:g}")
        ax.set_ylim(0)
        ax.grid(alpha=0.25)
        name_lines(ax)


class Tables(NamedTuple):
    """What was measured: the arguments of `save_frames`, `save_flicker` and the other functions that save rows."""

    frames: list[Point]
    flicker: list[tuple[str, float]]
    prism_counts: list[tuple[str, int, float, float]]
    beyond: list[tuple[str, str, float, float]]
    workers: list[tuple[int, float, float, int]]


def read_tables(folder: Path) -> Tables:
    """Return the tables of an earlier measurement in a folder. Raises InputError if one is missing or malformed."""
    found = Tables(
        read_frames(folder / "frames.csv"),
        _read(folder / "flicker.csv", FLICKER_HEAD, str, _amount),
        _read(folder / "prisms.csv", PRISMS_HEAD, str, _count, _amount, _amount),
        _read(folder / "beyond.csv", BEYOND_HEAD, str, str, _amount, _amount),
        _read(folder / "workers.csv", WORKERS_HEAD, _count, _amount, _amount, _count),
    )
    known = {row[:2] for row in found.beyond}
    fewer = {(kind, str(int(name) - 1)) for kind, name in known if name.isdecimal() and name != "1"}
    if not fewer <= known or "detailed" not in {row[0] for row in found.prism_counts}:
        raise InputError(f"tables in {str(folder)!r}: rows are missing; allowed: tables that povgen chart wrote")
    return found


def redraw(tables: Tables, folder: Path) -> None:
    """Draw the charts again, from the tables of an earlier measurement."""
    save_frames(tables.frames, folder)
    save_flicker(tables.flicker, folder)
    save_prism_counts(tables.prism_counts, folder)
    save_beyond(tables.beyond, folder)
    save_workers(tables.workers, folder)


def _amount(text: str) -> float:
    """Return a number that is finite and 0 or more. Raises ValueError for other text."""
    if not 0 <= (value := float(text)) < np.inf:
        raise ValueError
    return value


def _count(text: str) -> int:
    """Return a whole number above 0. Raises ValueError for other text."""
    if (value := int(text)) < 1:
        raise ValueError
    return value


def _read(file: Path, head: tuple[str, ...], *types: Callable[[str], object]) -> list[Any]:
    """Return the rows of a table, with columns of these types. Raises InputError for other columns, or no rows."""
    text = _text(file)
    try:
        first, *rows = csv.reader(StringIO(text))
        if tuple(first) != head:
            raise ValueError
        table = [tuple(made(value) for made, value in zip(types, row, strict=True)) for row in rows]
    except (ValueError, csv.Error):
        table = []
    if not table:
        raise InputError(f"table = {str(file)!r}: allowed: a table that povgen chart wrote")
    return table


ERROR_WORDS = {
    "turn": "near sheet turned by",
    "tilt_x": "near sheet tilted about x by",
    "tilt_y": "near sheet tilted about y by",
    "far_tilt_x": "far sheet tilted about x by",
    "far_tilt_y": "far sheet tilted about y by",
    "separation": "sheets too far apart by",
    "index": "near sheet's index wrong by",
    "far_index": "far sheet's index wrong by",
    "base_angle": "near prisms' base angle wrong by",
    "far_base_angle": "far prisms' base angle wrong by",
    "facets": "each facet turned by",
    "pitches": "each prism's height wrong, as a part of it, by",
}
EFFECTS = {"displaced": "arcminutes", "turned": "degrees"}  # what is drawn of a `Change`, and its unit


def save_sensitivities(sensitivities: Mapping[str, Change], path: Path) -> None:
    """Write a chart of how far each error alone displaces and turns the object, and a table beside it, as .csv.

    `sensitivities` are those that `tolerance.sensitivities` returns. The errors drawn are 1 degree, 0.01 tiles, and
    0.01 for an index.
    """
    small = {"tiles": (0.01, "0.01 tiles"), "": (0.01, "0.01")}  # a tile, or an index of 1, would be far too much
    units = {name: small.get(ERRORS[name].unit, (1.0, "1 degree")) for name in sensitivities}
    effects = {
        field: {name: abs(units[name][0] * float(getattr(change, field))) for name, change in sensitivities.items()}
        for field in EFFECTS
    }
    ordered = sorted(sensitivities, key=lambda name: np.nan_to_num(effects["displaced"][name]))
    with drawn(11.5, 4.8, path) as figure:
        for column, (ax, (field, unit)) in enumerate(zip(figure.subplots(1, 2), EFFECTS.items(), strict=True)):
            found = np.array([effects[field][name] for name in ordered])
            values, known = np.nan_to_num(found), np.isfinite(found)
            most, worst = values.max(), _words(ordered[int(values.argmax())])
            names = [f"{ERROR_WORDS[name]} {_with_unit(name, units[name][0])}" for name in ordered]
            bars = ax.barh(names, values, color=PRISMS)
            least = _rounded_up(most / 100)  # less cannot be seen beside the longest bar
            texts = [f"below {least:g}" if value < least else _two_digits(value) for value in values]
            ax.bar_label(bars, [text if one else "unknown" for text, one in zip(texts, known, strict=True)], padding=4)
            ax.margins(x=0.12)
            ax.set_xlim(left=0)
            ax.tick_params(labelleft=column == 0, left=False)
            title = f"{field.capitalize()} most by: {worst}" if known.any() else f"{field.capitalize()}: unknown"
            ax.set(xlabel=f"{field}, {unit}", title=title)
    table = [
        (f"{name}, {units[name][1]}", f"{field}, {unit}", f"{effects[field][name]:.6g}")
        for field, unit in EFFECTS.items()
        for name in effects[field]
    ]
    save_table(path.with_suffix(".csv"), ("error", "quantity", "value"), table)


def save_builds(builds: Change, given: Mapping[str, float], path: Path) -> None:
    """Write histograms of how far random builds displace and turn the object, and a table of the values, as .csv.

    `given` are the standard deviations of the builds' errors, in the errors' units.
    """
    table: list[tuple[object, ...]] = []
    with drawn(11.5, 5.2, path) as figure:
        axes = figure.subplots(1, 2)
        for ax, (field, unit) in zip(axes, EFFECTS.items(), strict=True):
            found = getattr(builds, field)
            limit = percentile(found, 95)
            _draw_builds(ax, found, limit)
            sign = "°" if unit == "degrees" else f" {unit}"
            title = f"95 of 100 builds: {field} by at most {limit:.2g}{sign}"
            if not np.isfinite(limit):
                title = f"{field.capitalize()}: unknown in more than 5 of 100 builds"
            ax.set(xlabel=f"{field}, {unit}", title=title)
            table += [(f"{field}, {unit}", f"{value:.6g}") for value in found]
        axes[0].set(ylabel=f"builds, of {len(builds.displaced)}")
        scatter = "; ".join(f"{_words(name)}:\u00a0{_with_unit(name, value)}" for name, value in given.items())
        text = f"each build has all these errors, at random, with the standard deviations: {scatter}"
        figure.supxlabel(fill(text, 120), fontsize=10, color="#444444")
    save_table(path.with_suffix(".csv"), ("quantity", "value"), table)


def _rounded_up(value: float) -> float:
    """Return the least number with one significant digit that is not below a value, which is finite and 0 or more."""
    if not value:
        return 0.0
    unit = 10.0 ** np.floor(np.log10(value))
    return float(f"{np.ceil(value / unit - 1e-9) * unit:.1g}")


def _two_digits(value: float) -> str:
    return f"{value:.0f}" if value >= 99.5 else f"{value:#.2g}".rstrip(".")


def _words(name: str) -> str:
    """Return what an error is, without its size."""
    return ERROR_WORDS[name].removesuffix(" by").removesuffix(",")


def _with_unit(name: str, value: float) -> str:
    """Return the value of an error with its unit."""
    return f"{value:g}" + {"degrees": "°", "": ""}.get(ERRORS[name].unit, f" {ERRORS[name].unit}")


def _draw_builds(ax: Axes, found: Floats, limit: float) -> None:
    """Draw a histogram of the builds' values. Bins above the limit are pale. NaN: a build does not show the object."""
    values = found[np.isfinite(found)]
    most = np.max(values, initial=0)
    width = limit / 12 if 0 < limit < np.inf else most / 20 or 1.0
    bins = int(min(np.ceil(most / width - 1e-9), 120)) or 1
    # a bin has the values above its lower edge, up to its upper edge; the last one also has what is beyond
    places = np.clip(np.ceil(values / width - 1e-9) - 1, 0, bins - 1).astype(int)
    edges = width * np.arange(bins)
    colours = [PRISMS if not edge or edge < limit * (1 - 1e-9) else "#a9cbe8" for edge in edges]
    ax.bar(edges, np.bincount(places, minlength=bins), width, align="edge", color=colours, edgecolor="white")
    ax.set_xlim(left=0)
    said = []
    if np.isfinite(limit):
        ax.axvline(limit, color=GREY, linestyle=":")
        above = int((values > limit).sum())
        said += [f"pale: the other {above} of {len(found)}"] * (above > 0)
        said += [f"beyond: {number}" for number in [int((values > width * bins * (1 + 1e-9)).sum())] if number]
    said += [f"not seen: {number}" for number in [len(found) - len(values)] if number]
    ax.text(0.98, 0.95, "\n".join(said), transform=ax.transAxes, ha="right", va="top", color="#444444")


def _draw_labels(figure: Figure, labelled: list[tuple[Axes, list[Label]]]) -> None:
    """Write each label beside its point, with a line to it, where it covers few or no other labels, points or lines."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()  # fixes the layout
    figure.set_layout_engine("none")
    for ax, labels in labelled:
        taken = [np.array([text.get_window_extent(renderer).extents for text in ax.texts]).reshape(-1, 4)]
        for line in ax.lines:
            places = ax.transData.transform(np.array(line.get_xydata()))
            half = line.get_markersize() * 0.9
            if line.get_marker() == "None":  # points along the line
                steps = np.linspace(0, len(places) - 1, 100 * len(places))
                places = np.transpose([np.interp(steps, np.arange(len(places)), xy) for xy in places.T])
                half = 1
            taken.append(_squares(places, half))
        # bold labels come first; then the points at the right, because there is less room beside them
        for x, y, text, colour, bold in sorted(labels, key=lambda each: (not each.bold, -each.x)):
            look: dict[str, Any] = {
                "fontsize": 11,
                "fontweight": "bold" if bold else "normal",
                "color": colour,
                "va": "center",
            }
            alone = ax.text(x, y, text, **look)
            size = np.asarray(alone.get_window_extent(renderer).size) + 2
            alone.remove()
            point, others = ax.transData.transform((x, y)), np.concatenate(taken)
            best, least = (10.0, 0.0), 8.0
            for distance, angle in product((10.0, 18.0, 28.0, 40.0, 55.0, 75.0), np.radians(np.arange(0, 360, 20))):
                box, leader = _candidate(point, size, distance * figure.dpi / 72, angle)
                outside = not (ax.bbox.x0 < box[0, 0] and box[0, 2] < ax.bbox.x1)
                fault = 4 * outside + 2 * _overlap(box, others) + _overlap(leader, others)
                if fault < least:
                    best, least = (distance, angle), fault
                if not fault:
                    break
            distance, angle = best
            ax.annotate(
                text,
                (x, y),
                (distance * np.cos(angle), distance * np.sin(angle)),
                textcoords="offset points",
                ha=_side(angle),
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
                arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 2},
                **look,
            )
            taken += _candidate(point, size, distance * figure.dpi / 72, angle)


def _side(angle: float) -> str:
    """Return the horizontal alignment of a label that lies in the direction `angle`, radians, from its point."""
    return "left" if np.cos(angle) > 0.2 else "right" if np.cos(angle) < -0.2 else "center"


def _candidate(point: Floats, size: Floats, distance: float, angle: float) -> tuple[Floats, Floats]:
    """Return the box of a label, and boxes along the line that leads to it: left, bottom, right and top, pixels."""
    middle = point + distance * np.array((np.cos(angle), np.sin(angle)))
    low = middle - size * ({"left": 0, "right": 1, "center": 0.5}[_side(angle)], 0.5)
    line = np.linspace(point, np.clip(point, low, low + size), 30)
    beyond_marker = np.linalg.norm(line - point, axis=1) > 14
    return np.concatenate((low, low + size))[None], _squares(line[beyond_marker], 1)


def _squares(middles: Floats, half: float) -> Floats:
    """Return squares of the side 2 `half` around points (points, 2): left, bottom, right and top of each."""
    return np.hstack((middles - half, middles + half))


def _overlap(boxes: Floats, others: Floats) -> bool:
    """Return whether one of the boxes overlaps one of the others."""
    apart = (boxes[:, None, :2] >= others[:, 2:]) | (others[:, :2] >= boxes[:, None, 2:])
    return bool((~apart.any(-1)).any())
