"""The lines of a chart as a table, for the scripts that draw charts of the documentation."""

from pathlib import Path

import numpy as np

from povgen.measure.plotting import Axes, save_table


def save_lines(path: Path, *panels: Axes) -> None:
    """Write the points of all labelled lines to a .csv file: line, and the labels and values of both axes."""
    rows = [
        (line.get_label(), ax.get_xlabel(), f"{x:.6g}", ax.get_ylabel(), f"{y:.6g}")
        for ax in panels
        for line in ax.lines
        if not str(line.get_label()).startswith("_")
        for x, y in np.array(line.get_xydata())
    ]
    save_table(path, ("line", "quantity along x", "x", "quantity along y", "y"), rows)
