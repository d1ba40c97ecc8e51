"""Stability maps: measured errors against one quantity, and the limits that follow from them.

A stability map is a series of measurements: an error or loss y against one quantity x, such as the number of prisms.
`stability` measures the maps, `stability_chart` draws them. A limit is the x up to which (or above which) y is within a
tolerance. Each measured limit is compared with the limit that povgen uses (povgen/limits.py).
"""

import dataclasses
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from povgen.measure.measured import Measured

RENDERED = ", by POV-Ray"  # suffix of a series from POV-Ray's pictures, if another series is from the exact ray trace


@dataclass
class StabilityMap:
    """Measured values y against x, in named series. `rows` are (series, x, y), in the order of the measurements.

    The fields `x` and `y` are the labels of the axes. `log_axes` names the logarithmic axes: '', 'x', 'y' or 'xy'.
    `tolerance` is the greatest allowed y, and `allowed` says so in a drawing. `action` is what povgen does beyond its
    limit. `finding` is what the map shows, in a sentence. `note` stands below the drawing. `reached` is the x where the
    mean of the series first exceeds the tolerance, if the drawing marks it. `limits` are what `limit` has found.
    `shape` is how the map is drawn:

    - 'lines': each series is a line.
    - 'range': the mean of the series is a line, in the band that they cover.
    - 'bound': x is a bound of y, in the same unit. Each row is a point, open if x exceeds the limit.
    - 'limits': the limits are drawn, not the series.
    """

    name: str
    title: str
    finding: str
    x: str
    y: str
    tolerance: float
    log_axes: str
    allowed: str = ""
    action: str = "povgen refuses"
    shape: Literal["lines", "range", "bound", "limits"] = "lines"
    note: str = ""
    reached: float | None = None
    rows: list[tuple[str, float, float]] = dataclasses.field(default_factory=list)
    limits: list[Measured] = dataclasses.field(default_factory=list)

    def add(self, series: str, x: float, y: float) -> None:
        """Append a row."""
        self.rows.append((series, float(x), float(y)))

    def limit(self, sheet: str, series: str, in_force: float, unit: str = "", *, rising: bool = True) -> None:
        """Find the limit of a series in its rows. Append it to `limits`, with the limit that povgen uses, `in_force`.

        If y is rising with x, the limit is the greatest x up to which y is within the tolerance. Otherwise the limit is
        the least x above which y is within the tolerance. Between two rows the limit is interpolated linearly, or in
        the logarithm of x if the x axis is logarithmic. If y exceeds the tolerance already at the least x (or, if y is
        not rising, at the greatest x), the limit is NaN, which fails.
        """
        points = sorted(((x, y) for name, x, y in self.rows if name == series), reverse=not rising)
        found = points[0][0] if points[0][1] <= self.tolerance else np.nan
        for (x0, y0), (x1, y1) in pairwise(points):
            if not y0 <= self.tolerance:
                break
            if y1 <= self.tolerance:
                found = x1
            elif y1 > self.tolerance and "x" in self.log_axes:
                found = x0 * (x1 / x0) ** ((self.tolerance - y0) / (y1 - y0))
            elif y1 > self.tolerance:
                found = x0 + (x1 - x0) * (self.tolerance - y0) / (y1 - y0)
        self.limits.append(Measured(sheet, f"{self.title}: {series}", found, in_force, unit, least=rising))
