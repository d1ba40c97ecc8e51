"""Drawing with matplotlib: the style of povgen's charts and figures, and how they become files."""

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen import fonts, remedies
from povgen.errors import InputError
from povgen.record import save
from povgen.settings import AS_DRAWN, Print

try:
    import matplotlib
    from cycler import cycler
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_mixed import MixedModeRenderer
    from matplotlib.backends.backend_pdf import Op, PdfFile, RendererPdf
    from matplotlib.figure import Figure
    from matplotlib.font_manager import fontManager
    from matplotlib.patheffects import withStroke
    from matplotlib.ticker import AutoLocator, LogLocator
except ImportError:
    raise InputError(
        f"charts and figures are drawn with matplotlib, which is not installed: {remedies.extra('charts')}"
    ) from None

# for the modules that draw
__all__ = [
    "COLOURS", "GREY", "IDEAL", "MARKS", "PRISMS", "AutoLocator", "Axes", "Figure", "drawn", "name_lines",
    "plain_ticks", "save_drawing", "save_table", "style", "table_rows", "withStroke",
]  # fmt: skip
Floats = NDArray[np.float64]
PRISMS, IDEAL = "#0b5fa5", "#c1512d"  # a model of the sheets has the same colour in every chart
GREY = "#5c5c5c"
LEGIBLE = 7  # points on paper, of most text
# the contrast of each with white is at least 4.5
COLOURS = [PRISMS, IDEAL, "#3a7d44", "#7b4b94", "#8a6800", "#555555", "#c2185b", "#0e7f7f"]
MARKS = "os^Dv*PX"  # one beside each colour, for eyes that do not tell the colours apart
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
PAPER = 200  # of 255: grids and bands are lighter, and names may be upon them
STEPS = 0, 0.5, -0.5, 1, -1  # aside of what is named, in halves of the name
CLEAR = 40  # pixels between a name and another line, if there is room
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
    "pdf.fonttype": 42,  # text stays text, in TrueType
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "povgen",  # the same figure always gives the same file
}
for font in (fonts.TEXT, fonts.BOLD):
    fontManager.addfont(font)


def style(**other: object) -> AbstractContextManager[None]:
    """Return a context in which figures have povgen's style. `other` settings of matplotlib override the style."""
    return matplotlib.rc_context(STYLE | other)


@contextmanager
def drawn(
    width: float, height: float, *paths: Path, printed: Print = AS_DRAWN, roomy: bool = False
) -> Iterator[Figure]:
    """Give a figure of this size, in inches, in povgen's style. At the end, write it to files as `printed` says.

    If its text would be too small on paper, a figure with room for larger text is made smaller: text fills more of it.
    """
    if printed.width and roomy:
        smaller = min(1, printed.width / 25.4 / width * STYLE["font.size"] / LEGIBLE)
        width, height = smaller * width, smaller * height
    with style():
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure
        save_drawing(figure, *paths, printed=printed)


def plain_ticks(axis: Axis, subs: tuple[float, ...] = (1, 2, 5)) -> None:
    """Write the numbers of a logarithmic axis as 0.2 instead of 2 x 10^-1. Ticks are at `subs` times powers of ten."""
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_major_formatter(lambda x, _: _plain(x))
    axis.set_minor_formatter("")


def _plain(x: float) -> str:
    """Return a number without an exponent, or a power of ten below 0.001 as such."""
    power = np.log10(x).round(9)
    if power < -3 and power == round(power):
        return "10" + str(int(power)).translate(SUPERSCRIPT)
    return np.format_float_positional(x, 3, fractional=False, trim="-")


def name_lines(ax: Axes, *others: tuple[str, Sequence[Any], str], short: Callable[[str], str] = str) -> None:
    """Write the label of each line beside it, in its colour: a legend would be far from it.

    `others` are written too: each a text, the points (n, 2) that it may stand beside, and a colour. A name hides as
    little as possible, and is rather at the end of its line. `short` makes it from the label. What else is drawn has to
    be there already.
    """
    canvas = FigureCanvasAgg(ax.figure)  # type: ignore[arg-type]
    canvas.draw()  # the axes have their place only now
    light = np.asarray(canvas.buffer_rgba())[::-1, :, :3].min(2)
    ink = (PAPER - np.minimum(light, PAPER)).astype(float)
    names: list[tuple[str, Any, Any]] = [(text, ax.transData.transform(at), colour) for text, at, colour in others]
    for line in ax.lines:
        label, corners = str(line.get_label()), line.get_transform().transform(line.get_xydata())
        corners = corners[np.isfinite(corners).all(1)]
        if label.startswith("_") or not len(corners):
            continue
        if line.get_linestyle() != "None":  # a name may be beside the middle of a long piece
            along = np.hypot(*np.diff(corners, axis=0, prepend=corners[:1]).T).cumsum()
            corners = np.column_stack([np.interp(np.linspace(0, along[-1], 80), along, each) for each in corners.T])
        names.append((short(label), corners, line.get_color()))
    for text, corners, colour in names:
        written = ax.text(0, 0, text, color=colour, transform=ax.transAxes, ha="center", va="center")
        half = np.divide(written.get_window_extent().size, 2)
        rivals = np.concatenate([other for _, other, _ in names if other is not corners] or [np.empty((0, 2))])
        place = _free_place(ax, ink, corners[::-1], rivals, half)
        x, y = ax.transAxes.inverted().transform(place)
        written.set_position((x, y))
        (x0, y0), (x1, y1) = (np.add(place, side * half).astype(int) for side in (-1, 1))
        if ink[y0:y1, x0:x1].any():  # then no line strikes the letters through
            written.set_path_effects([withStroke(linewidth=4, foreground="white")])
        ink[y0:y1, x0:x1] = PAPER


def _free_place(ax: Axes, ink: Floats, corners: Floats, rivals: Floats, half: Floats) -> Floats:
    """Return where the middle of a text has to be, pixels: beside one of `corners` (n, 2), rather the first.

    The text is as large as twice `half`. It should be inside the axes, hide no ink, and be far from `rivals` (m, 2).
    """
    sides = np.array([(x, y) for x in STEPS for y in STEPS if 1 in (abs(x), abs(y))])
    places = (corners[:, None] + np.concatenate([sides * (half + gap) for gap in (6, 13)])).reshape(-1, 2)
    sums = np.pad(ink, ((1, 0), (1, 0))).cumsum(0).cumsum(1)  # below and left of each pixel
    (x0, y0), (x1, y1) = ((places + side * half).astype(int).clip(0, ink.T.shape).T for side in (-1.1, 1.1))
    hidden = sums[y1, x1] - sums[y0, x1] - sums[y1, x0] + sums[y0, x0]
    low, high = np.reshape(ax.bbox.extents, (2, 2))
    outside = (np.maximum(low - places, places - high) + half + 4).max(1).clip(0)
    apart = np.linalg.norm((abs(places[:, None] - rivals) - half).clip(0), axis=2).min(1, initial=CLEAR)
    cost = 1000 * outside + hidden + 2 * (CLEAR - apart) + np.linspace(0, 40, len(places))
    best: Floats = places[cost.argmin()]
    return best


def save_table(path: Path, head: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> None:
    """Write a .csv file."""
    table = StringIO()
    csv.writer(table, lineterminator="\n").writerows([head, *rows])
    save(table.getvalue().encode(), path)


def table_rows(path: Path) -> list[list[str]]:
    """Return the rows of a .csv file that `save_table` wrote, without the head and the record."""
    with path.open(encoding="utf-8", newline="") as file:
        return [*csv.reader(line for line in file if not line.startswith("#"))][1:]


def save_drawing(figure: Figure, *paths: Path, printed: Print = AS_DRAWN) -> None:
    """Write a figure to files. Each file name ends with its format: .png, .svg or .pdf."""
    dpi = printed.dpi or figure.dpi
    scale = printed.width / 25.4 / figure.get_figwidth() if printed.width else 1
    for path in paths:
        image, kind = BytesIO(), path.suffix.lower()
        if kind == ".png":
            figure.savefig(image, format="png", dpi=dpi * scale, pil_kwargs={"dpi": (dpi, dpi)})
        elif kind == ".svg":
            figure.savefig(image, format="svg", dpi=dpi * scale, metadata={"Date": None})
            width, height = (25.4 * scale * size for size in figure.get_size_inches())
            size = f'width="{width:.6g}mm" height="{height:.6g}mm"'
            image = BytesIO(
                re.sub(r'width="[^"]*pt" height="[^"]*pt"', size, image.getvalue().decode(), count=1).encode()
            )
        else:
            _draw_pdf(figure, image, scale, dpi * scale)
        save(image.getvalue(), path)


def _draw_pdf(figure: Figure, file: BytesIO, scale: float, dpi: float) -> None:
    """Write a figure as a PDF file, with everything in it scaled: matplotlib itself would keep the size of text."""
    figure.dpi = 72  # PDF's points
    width, height = figure.get_size_inches()
    pdf = PdfFile(file, {"CreationDate": None})
    pdf.newPage(scale * width, scale * height)
    pdf.width, pdf.height = width, height  # lines are cut off there
    pdf.output(scale, 0, 0, scale, 0, 0, Op.concat_matrix)
    renderer: Any = MixedModeRenderer(figure, width, height, dpi, RendererPdf(pdf, dpi, height, width))
    figure.draw(renderer)
    pdf.finalize()
