"""The modules of a page's script, joined to one script: a page is one file, which a browser opens without a server.

Each module becomes a function that returns its exports. `povgen` in the page holds them, by the modules' names.
An export is a constant, a function or a class, but no variable: the module's function returns its value only once.
Comments and indents are left out.
"""

import posixpath
import re
from collections.abc import Sequence
from graphlib import TopologicalSorter

from povgen.scene.laws import Text
from povgen.scene.sdl import PACKAGE, bare, to_javascript

IMPORT = re.compile(r'^import (?:(?:\* as )?([^"]+) from )?"([^"]+)";\n', re.M)
EXPORT = re.compile(r"^export (?=(?:async )?(?:const|function|class) ([\w$]+))", re.M)


def script(*mains: str, laws: Sequence[Text]) -> str:
    """Return a script that runs modules and all that they import. `mains` are the modules' paths in povgen/.

    The module liveview/laws.js is made from `laws`. Raises graphlib.CycleError for a circle of imports.
    """
    texts: dict[str, str] = {}
    graph: dict[str, list[str]] = {}
    waiting = [*mains]
    while waiting:
        path = waiting.pop()
        if path not in texts:
            made = path == "liveview/laws.js"
            texts[path] = to_javascript(laws) if made else (PACKAGE / path).read_text("utf-8")
            near = [posixpath.join(posixpath.dirname(path), found[2]) for found in IMPORT.finditer(texts[path])]
            graph[path] = [posixpath.normpath(other) for other in near]
            waiting += graph[path]
    order = TopologicalSorter(graph).static_order()
    return "\n".join(["const povgen = (window.povgen = {});", *(_function(path, texts[path]) for path in order)])


def _function(path: str, text: str) -> str:
    exports = ", ".join(found[1] for found in EXPORT.finditer(text))
    body = bare(IMPORT.sub(_names, text))
    return f"povgen.{_name(path)} = (() => {{\n{EXPORT.sub('', body)}return {{ {exports} }};\n}})();\n"


def _names(found: re.Match[str]) -> str:
    """Return the declaration of what is imported. For an import without names it is empty: the module runs before."""
    return f"const {found[1].replace(' as ', ': ')} = povgen.{_name(found[2])};\n" if found[1] else ""


def _name(path: str) -> str:
    return posixpath.basename(path).removesuffix(".js")
