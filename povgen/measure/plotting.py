"""Drawing with matplotlib: the style of povgen's charts and figures, and how they become files."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

from povgen.errors import InputError
from povgen.files import save

try:
    import matplotlib
    from cycler import cycler
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.text import Text
    from matplotlib.ticker import LogLocator
    from matplotlib.transforms import Bbox
except ImportError:
    raise InputError(
        "charts and figures are drawn with matplotlib, which is not installed: pip install 'povgen[charts]'"
    ) from None

# for the modules that draw
__all__ = ["Axes", "Axis", "Bbox", "Figure", "FigureCanvasAgg", "LogLocator", "Text", "drawn", "save_drawing", "style"]
COLOURS = ["#0b5fa5", "#d1603d", "#3a7d44", "#7b4b94", "#b58900", "#555555", "#c2185b", "#17a2a2"]
STYLE: dict[Any, Any] = {  # Any, because matplotlib's own type for this lists every setting by name
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "figure.dpi": 110,
    "font.size": 11,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "axes.prop_cycle": cycler(color=COLOURS),
    "svg.hashsalt": "povgen",  # the same figure always gives the same file
}


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


def save_drawing(figure: Figure, *paths: Path) -> None:
    """Write a figure to files. Each file name ends with its format: .png or .svg."""
    for path in paths:
        image = BytesIO()
        undated = {"Date": None} if path.suffix == ".svg" else None
        figure.savefig(image, format=path.suffix[1:], metadata=undated)
        save(image.getvalue(), path)
