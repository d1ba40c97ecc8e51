"""POV-Ray scenes of light-ray-rotating sheets, and the movies made from them.

Each public name is imported when it is first used: importing all is slow, and ``povgen --help`` needs none.
"""

import sys

from povgen.version import __version__ as __version__

TYPE_CHECKING = False  # that of `typing` takes a while to load
if TYPE_CHECKING:
    from povgen.errors import InputError as InputError
    from povgen.errors import PovrayError as PovrayError
    from povgen.liveview.view import live as live
    from povgen.measure.drawn import points as points
    from povgen.optics.rays import Bundle as Bundle
    from povgen.record import info as info
    from povgen.rendering.auto import cheapest as cheapest
    from povgen.rendering.results import results as results
    from povgen.scene.scenes import Chess as Chess
    from povgen.scene.scenes import Scene as Scene
    from povgen.scene.scenes import Spheres as Spheres
    from povgen.scene.sdl import to_pov as to_pov
    from povgen.scene.sdl import to_sheets as to_sheets
    from povgen.scene.spec import MovieSpec as MovieSpec
    from povgen.settings import Rendering as Rendering
    from povgen.video.build import Movie as Movie
    from povgen.video.build import movie as movie
    from povgen.video.still import render as render
    from povgen.video.still import save as save
    from povgen.video.still import show as show

_NAMES = {
    "errors": ("InputError", "PovrayError"),
    "liveview.view": ("live",),
    "measure.drawn": ("points",),
    "optics.rays": ("Bundle",),
    "record": ("info",),
    "rendering.auto": ("cheapest",),
    "rendering.results": ("results",),
    "scene.scenes": ("Chess", "Scene", "Spheres"),
    "scene.sdl": ("to_pov", "to_sheets"),
    "scene.spec": ("MovieSpec",),
    "settings": ("Rendering",),
    "video.build": ("Movie", "movie"),
    "video.still": ("render", "save", "show"),
}
_MODULES = {name: module for module, names in _NAMES.items() for name in names}
__all__ = list(_MODULES)


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'povgen' has no attribute {name!r}")
    from importlib import import_module  # not before: `__main__` is loaded after this module

    return getattr(import_module(f"povgen.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _shown_in_notebooks() -> None:
    """Tell Jupyter to show a scene as its picture. The scene models themselves do not depend on rendering."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is not None:
        from importlib import import_module

        formatter = shell.display_formatter.formatters["image/png"]
        formatter.for_type_by_name(
            "povgen.scene.scenes", "Scene", lambda scene: import_module("povgen.video.still").as_file(scene)
        )


_shown_in_notebooks()
