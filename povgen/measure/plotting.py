"""Drawing with matplotlib: the style of povgen's charts and figures, and how they become files."""

import csv
import re
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

from povgen import fonts, remedies
from povgen.errors import InputError
from povgen.record import save
from povgen.settings import AS_DRAWN, Print

try:
    import matplotlib
    from cycler import cycler
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
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
    "COLOURS", "GREY", "IDEAL", "PRISMS", "AutoLocator", "Axes", "Figure", "drawn", "plain_ticks", "save_drawing",
    "save_table", "style", "table_rows", "withStroke",
]  # fmt: skip
PRISMS, IDEAL = "#0b5fa5", "#d1603d"  # a model of the sheets has the same colour in every chart
GREY = "#777777"
LEGIBLE = 7  # points on paper, of most text
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
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter("")


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
