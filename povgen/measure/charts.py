"""Charts of what was measured, and the same data as CSV: cost and error of pictures, and errors of building."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill

import numpy as np

from povgen.measure.plotting import (
    COLOURS,
    GREY,
    PRISMS,
    Axes,
    drawn,
    name_lines,
    plain_ticks,
    save_table,
    table_rows,
    withStroke,
)
from povgen.measure.speed import SIZES, Point
from povgen.measure.tolerance import SHOWN, Change, percentile, shown
from povgen.settings import AS_DRAWN, QUALITIES, Print, Rendering
from povgen.sheets.prisms import ERRORS

FRAMES_HEAD = ("method", "antialias", "width", "height", "CPU s", "RMS", "FLIP")
# what `povgen chart` writes
FILES = ["frames.csv", "machine.txt"]
FILES += [f"frames-{width}x{height}.{kind}" for width, height in SIZES for kind in ("png", "svg")]

Row = Sequence[str]  # of frames.csv


def save_frames(points: Sequence[Point], folder: Path) -> None:
    """Write frames.csv and, for each size, a chart of RMS against CPU seconds."""
    save_table(folder / "frames.csv", FRAMES_HEAD, [point.row for point in points])
    draw_frames(folder)


def draw_frames(folder: Path, titles: Mapping[str, Sequence[str]] | None = None) -> None:
    """Draw the charts of the table frames.csv: prisms at the left, the ideal sheet at the right.

    `titles` are both titles by the size, such as 320x240.
    """
    rows = table_rows(folder / "frames.csv")
    for width, height in dict.fromkeys((row[2], row[3]) for row in rows):
        name = f"frames-{width}x{height}"
        with drawn(11, 5.8, folder / f"{name}.png", folder / f"{name}.svg") as figure:
            shown = [row for row in rows if row[2:4] == [width, height]]
            axes = figure.subplots(1, 2)
            axes[0].set(ylabel="RMS error (1: white)")
            letters = "; ".join(f"{names[0][0]}: {', '.join(names)}" for names in _qualities(True).values())
            missing = "; left: gl's d was not measured" * any(row[0].startswith("gl ") for row in shown)
            figure.supxlabel(
                f"lines: samplings that no cheaper one beats; {letters} (--quality){missing}",
                fontsize=11,
            )
            named = (titles or {}).get(f"{width}x{height}", ("Prisms", "Ideal sheet"))
            for ax, prisms, title in zip(axes, (True, False), named, strict=True):
                ax.set(xscale="log", yscale="log", title=title, xlabel=f"CPU seconds for a frame of {width}x{height}")
                for axis in (ax.xaxis, ax.yaxis):
                    plain_ticks(axis)
                ax.grid(alpha=0.25)
                ax.margins(0.2, 0.15)  # room for names
                _scatter(ax, [row for row in shown if row[0].endswith("ideal") != prisms], prisms)


LOOKS = {  # of the renderers that are drawn: name, line and mark, and colour
    "": ("POV-Ray", "--o", COLOURS[3]),
    "gl ": ("gl (without GPU)", "-D", COLOURS[2]),
    "live ": ("live view (browser)", ":^", GREY),
    "Mitsuba scalar_rgb": ("Mitsuba 3", ":v", COLOURS[4]),
}


def _qualities(prisms: bool) -> dict[str, list[str]]:
    """Return povgen's qualities, by their sampling."""
    names: dict[str, list[str]] = {}
    for quality in QUALITIES:
        names.setdefault(Rendering(quality=quality).suited(prisms).sampling, []).append(quality)
    return names


def _scatter(ax: Axes, rows: Sequence[Row], prisms: bool) -> None:
    """Draw RMS against CPU seconds: a line joins the samplings for which no cheaper one has a smaller error."""
    names = _qualities(prisms)
    for renderer, (label, look, colour) in LOOKS.items():
        methods = renderer, f"{renderer}detailed", f"{renderer}ideal"
        found = sorted((float(row[4]), float(row[5]), row[1]) for row in rows if row[0] in methods)
        best = [each for n, each in enumerate(found) if all(each[1] < before[1] for before in found[:n])]
        for x, y, sampling in found:
            if sampling in names:
                ax.plot(x, y, look[-1], color=colour, markersize=9, fillstyle="none")
                aside = (6, 5) if renderer == "" else (-13, -13)
                letter = ax.annotate(names[sampling][0][0], (x, y), aside, textcoords="offset points", color=colour)
                letter.set(weight="bold", path_effects=[withStroke(linewidth=3, foreground="white")])
        if best:
            ax.plot(*np.transpose([each[:2] for each in best]), look, color=colour, markersize=5, label=label)
    name_lines(ax)


WHAT = {  # for each error, what is wrong
    "turn": "near sheet turned",
    "tilt_x": "near sheet tilted about x",
    "tilt_y": "near sheet tilted about y",
    "far_tilt_x": "far sheet tilted about x",
    "far_tilt_y": "far sheet tilted about y",
    "separation": "sheets too far apart",
    "index": "near sheet's index wrong",
    "far_index": "far sheet's index wrong",
    "base_angle": "near prisms' base angle wrong",
    "far_base_angle": "far prisms' base angle wrong",
    "facets": "each facet turned",
    "pitches": "each prism's height wrong, as a part of it",
}
# what is drawn of a `Change`, its unit, and the least that is told apart from 0: in four scenes, smaller values changed
# as much with the traced rays
EFFECTS = {"displaced": ("arcminutes", 0.03), "turned": ("degrees", 0.02)}


def save_sensitivities(sensitivities: Mapping[str, Change], path: Path, printed: Print = AS_DRAWN) -> None:
    """Write a chart of how far each error alone displaces and turns the object, and a table beside it, as .csv.

    `sensitivities` are those that `tolerance.sensitivities` returns. The errors drawn are `tolerance.SHOWN`.
    Values that are not told apart from 0 have an open mark.
    """
    sizes = {name: SHOWN[name] for name in sensitivities}
    ordered = sorted(sizes, key=lambda name: abs(np.nan_to_num(sizes[name] * sensitivities[name].displaced)))
    table: list[tuple[object, ...]] = []
    with drawn(11.5, 4.8, path, printed=printed) as figure:
        for ax, (field, (unit, least)) in zip(figure.subplots(1, 2, sharey=True), EFFECTS.items(), strict=True):
            values = {name: abs(size * float(getattr(sensitivities[name], field))) for name, size in sizes.items()}
            names = [f"{WHAT[name]} by {_with_unit(name, sizes[name])}" for name in ordered]
            drawn_at = np.clip(np.nan_to_num([values[name] for name in ordered]), least, None)
            ax.plot(drawn_at, names, "o", color=PRISMS, markersize=9, fillstyle="none")
            found = drawn_at > least
            ax.plot(drawn_at[found], np.array(names)[found], "o", color=PRISMS, markersize=9)
            most = max(values, key=lambda name: np.nan_to_num(values[name]))
            texts = [
                "unknown"
                if np.isnan(value)
                else f"below {least:g}"
                if value < least
                else np.format_float_positional(round(value, 2), 2, fractional=False, trim="-")
                for value in (values[name] for name in ordered)
            ]
            for name, x, text in zip(names, drawn_at, texts, strict=True):
                ax.annotate(text, (x, name), (8, 0), textcoords="offset points", va="center")
            ax.set(xscale="log", xlim=(min(drawn_at) / 2, 10 * max(drawn_at)))
            plain_ticks(ax.xaxis, (1,))
            ax.grid(alpha=0.25)
            ax.set(xlabel=f"{field}, {unit}", title=f"{field.capitalize()} most: {WHAT[most]}")
            rows = values.items()
            table += [(f"{name}, {shown(name)}", f"{field}, {unit}", f"{x:.6g}") for name, x in rows]
    save_table(path.with_suffix(".csv"), ("error", "quantity", "value"), table)


def save_builds(builds: Change, given: Mapping[str, float], path: Path, printed: Print = AS_DRAWN) -> None:
    """Write histograms of how far random builds displace and turn the object, and a table of the values, as .csv.

    `given` are the standard deviations of the builds' errors, in the errors' units.
    """
    table: list[tuple[object, ...]] = []
    with drawn(11.5, 5.2, path, printed=printed, roomy=True) as figure:
        for ax, (field, (unit, _)) in zip(figure.subplots(1, 2), EFFECTS.items(), strict=True):
            found = getattr(builds, field)
            seen = found[np.isfinite(found)]
            most = max(seen.max(initial=0), 1e-9)
            ax.hist(seen, np.linspace(0, most, 21), color="#85afd2", edgecolor="white")  # dark lines stand out
            limits = {share: limit for share in (50, 95) if np.isfinite(limit := percentile(found, share))}
            for share, limit in limits.items():
                ax.axvline(limit, linestyle="--", color="black")
                place = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "va": "top"}
                ax.annotate(f"{share} %: {_two_digits(limit)}", (limit, 1), (5, 0), **place)
            missing = f"; not seen: {len(found) - len(seen)}" if len(seen) < len(found) else ""
            ax.set(xlabel=f"{field}, {unit}", ylabel=f"builds, of {len(found)}{missing}")
            title = f"95 % of the builds: {field} by at most {_two_digits(limits[95])} {unit}" if 95 in limits else ""
            ax.set_title(title or field.capitalize())
            ax.set_xlim(left=0)
            ax.margins(y=0.15)  # room for the texts at the lines
            ax.xaxis.set_major_formatter("{x:g}")
            ax.grid(axis="y", alpha=0.25)
            ax.set_axisbelow(True)
            table += [(f"{field}, {unit}", f"{value:.6g}") for value in found]
        alike: dict[str, list[str]] = {}
        for name, value in given.items():
            alike.setdefault(_with_unit(name, value), []).append(WHAT[name])
        errors = [f"{', '.join(names)}: {size}" for size, names in alike.items()]
        text = fill(f"Standard deviations of the errors: {'; '.join(errors)}", int(14 * figure.get_figwidth()))
        figure.supxlabel(text, x=0.01, ha="left", ma="left", fontsize=10)
    save_table(path.with_suffix(".csv"), ("quantity", "value"), table)


def _two_digits(x: float) -> str:
    return np.format_float_positional(x, 2, unique=False, fractional=False, trim="k").rstrip(".")


def _with_unit(name: str, value: float) -> str:
    return f"{value:g}" + {"degrees": "°", "": ""}.get(ERRORS[name].unit, f" {ERRORS[name].unit}")
