"""Drawing with matplotlib: the style of povgen's charts and figures, and how they become files."""

import csv
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

from povgen import fonts, remedies
from povgen.errors import InputError
from povgen.files import save

try:
    import matplotlib
    from cycler import cycler
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.font_manager import fontManager
    from matplotlib.patheffects import withStroke
    from matplotlib.ticker import LogLocator
except ImportError:
    raise InputError(
        f"charts and figures are drawn with matplotlib, which is not installed: {remedies.extra('charts')}"
    ) from None

# for the modules that draw
__all__ = [
    "COLOURS", "GREY", "IDEAL", "PRISMS", "Axes", "Figure", "drawn", "plain_ticks", "save_drawing",
    "save_table", "style", "withStroke",
]  # fmt: skip
PRISMS, IDEAL = "#0b5fa5", "#d1603d"  # a model of the sheets has the same colour in every chart
GREY = "#777777"
COLOURS = [PRISMS, IDEAL, "#3a7d44", "#7b4b94", "#b58900", "#555555", "#c2185b", "#17a2a2"]
STYLE: dict[Any, Any] = {  # Any, because matplotlib's own type for this lists every setting by name
    # DejaVu Sans, which is matplotlib's own, has the arrows and other signs that Noto Sans lacks
    "font.family": ["Noto Sans", "DejaVu Sans"],
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "figure.dpi": 110,
    "font.size": 11,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "axes.prop_cycle": cycler(color=COLOURS),
    "mathtext.fontset": "stix",  # in it an italic nu does not look like a v
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "povgen",  # the same figure always gives the same file
}
for font in (fonts.TEXT, fonts.BOLD):
    fontManager.addfont(font)


def style(**other: object) -> AbstractContextManager[None]:
    """Return a context in which figures have povgen's style. `other` settings of matplotlib override the style."""
    return matplotlib.rc_context(STYLE | other)


@contextmanager
def drawn(width: float, height: float, *paths: Path) -> Iterator[Figure]:
    """Give a figure of this size, in inches, in povgen's style. At the end, write it to files."""
    with style():
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure
        save_drawing(figure, *paths)


def plain_ticks(axis: Axis, subs: tuple[float, ...] = (1, 2, 5)) -> None:
    """Write the numbers of a logarithmic axis as 0.2 instead of 2 x 10^-1. Ticks are at `subs` times powers of ten."""
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter("")


def save_table(path: Path, head: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> None:
    """Write a .csv file."""
    table = StringIO()
    csv.writer(table, lineterminator="\n").writerows([head, *rows])
    save(table.getvalue().encode(), path)


def save_drawing(figure: Figure, *paths: Path) -> None:
    """Write a figure to files. Each file name ends with its format: .png or .svg."""
    for path in paths:
        image = BytesIO()
        undated = {"Date": None} if path.suffix == ".svg" else None
        figure.savefig(image, format=path.suffix[1:], metadata=undated)
        save(image.getvalue(), path)
