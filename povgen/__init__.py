"""POV-Ray scenes of light-ray-rotating sheets, and the movies made from them.

The names below are loaded when they are first used, so that ``povgen --help`` loads none of them.
"""

import sys
from importlib import import_module

__version__ = "0.1.0"

_HOME = {
    "Chess": "scene.models",
    "Spheres": "scene.models",
    "to_pov": "scene.sdl",
    "Rendering": "settings",
    "render": "video.still",
    "MovieSpec": "scene.spec",
    "movie": "video.build",
    "InputError": "errors",
    "PovrayError": "errors",
}
__all__ = ["Chess", "InputError", "MovieSpec", "PovrayError", "Rendering", "Spheres", "movie", "render", "to_pov"]


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'povgen' has no attribute {name!r}")
    return getattr(import_module(f"povgen.{_HOME[name]}"), name)


def _shown_in_notebooks() -> None:
    """Have Jupyter show a scene as its picture. Scenes themselves know nothing of rendering."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is not None:
        formatter = shell.display_formatter.formatters["image/png"]
        formatter.for_type_by_name(
            "povgen.scene.models", "Scene", lambda scene: import_module("povgen.video.still").png(scene)
        )


_shown_in_notebooks()
