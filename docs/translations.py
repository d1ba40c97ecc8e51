"""Write a table of the teaching page's sentences in several languages, for a reader who checks a translation.

python docs/translations.py en de translations.html
"""

import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

from povgen.inputs.pieces import PIECES
from povgen.page import items

STYLE = "td, th { vertical-align: top; text-align: start; padding: 0.2em 0.6em; border-top: 1px solid #999; }"
KNOWN = items.tables(items.load([], PIECES))


def sentences(table: dict[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Yield each key of a language, as `page.title`, with its sentence. Those of a list are numbered."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from sentences(value, f"{above}{key}.")
        elif isinstance(value, list):
            yield from ((f"{above}{key} {n}", text) for n, text in enumerate(value, 1))
        else:
            yield above + key, value


def page(*names: str) -> str:
    """Return the page. Where a language does not have a form of a word, its cell is empty."""
    columns = {name: dict(sentences(KNOWN[name])) for name in names}
    rows = []
    for key in dict.fromkeys(key for texts in columns.values() for key in texts):
        cells = (
            f'<td lang="{name}" dir="{texts["dir"]}">{escape(texts.get(key, ""))}</td>'
            for name, texts in columns.items()
        )
        rows.append(f"<tr><th>{key}</th>{''.join(cells)}</tr>\n")
    return f'<!DOCTYPE html>\n<meta charset="utf-8">\n<style>{STYLE}</style>\n<table>\n{"".join(rows)}</table>\n'


if __name__ == "__main__":
    *languages, output = sys.argv[1:] or [""]
    if not languages or not KNOWN.keys() >= {*languages}:
        sys.exit(f"{__doc__}\nLanguages: {', '.join(KNOWN)}")
    Path(output).write_text(page(*languages), "utf-8")
