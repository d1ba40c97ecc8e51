"""Write pages about the Python interface, made from the docstrings: `make docs`."""

import sys
from pathlib import Path
from pkgutil import iter_modules

import pdoc

import povgen

for name in povgen.__all__:  # a name is loaded on first use, and pdoc documents only what is loaded
    setattr(povgen, name, getattr(povgen, name))
parts = [module.name for module in iter_modules(povgen.__path__, "povgen.")]
public = [name for name in parts if name not in ("povgen.cli", "povgen.__main__")]
pdoc.render.configure(show_source=False)
pdoc.pdoc("povgen", *public, "!povgen.measure.plotting", output_directory=Path(sys.argv[1]))
