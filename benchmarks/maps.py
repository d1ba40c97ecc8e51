"""Draw stability maps again, from their tables: `python benchmarks/maps.py FOLDER`. Nothing is measured."""

import sys
from copy import deepcopy
from pathlib import Path

from povgen.measure.plotting import table_rows
from povgen.measure.stability import MAPS
from povgen.measure.stability_map import draw

if __name__ == "__main__":
    for name, blank in MAPS.items():
        measured, folder = deepcopy(blank), Path(sys.argv[1])
        for series, x, y in table_rows(folder / f"{name}.csv"):
            measured.add(series, float(x), float(y))
        draw(measured, folder)
