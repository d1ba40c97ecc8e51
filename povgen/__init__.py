"""POV-Ray scenes of light-ray-rotating sheets, and the movies made from them.

The public names are those that `__init__.pyi` imports. Each is imported when it is first used: importing all is slow,
and ``povgen --help`` needs none.
"""

import sys
from importlib import import_module

with open(f"{__file__}i") as _stub:
    # the module of each name: a line is `from MODULE import NAME as NAME`
    _MODULES = {line.split()[3]: line.split()[1] for line in _stub}
__all__ = [name for name in _MODULES if not name.startswith("_")]


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'povgen' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted({*_MODULES, *(name for name in globals() if name.startswith("__"))})


def _shown_in_notebooks() -> None:
    """Tell Jupyter to show a scene as its picture. The scene models themselves do not depend on rendering."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is not None:
        formatter = shell.display_formatter.formatters["image/png"]
        formatter.for_type_by_name(
            "povgen.scene.scene", "Scene", lambda scene: import_module("povgen.video.still").as_file(scene)
        )


_shown_in_notebooks()
