"""Charts of what was measured, with matplotlib, and the same as CSV: the one place that draws."""

import csv
from collections.abc import Callable, Iterable
from io import BytesIO, StringIO
from pathlib import Path

import numpy as np

from povgen.errors import InputError
from povgen.output import save
from povgen.stability import RENDERED, Map
from povgen.verify import Measured

try:
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
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
        table = StringIO()
        csv.writer(table, lineterminator="\n").writerows([("series", map.x, map.y), *map.rows])
        save(table.getvalue().encode(), folder / f"{map.name}.csv")
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


def _save(figure: Figure, path: Path) -> None:
    image = BytesIO()
    figure.savefig(image, format=path.suffix[1:], dpi=110)
    save(image.getvalue(), path)
