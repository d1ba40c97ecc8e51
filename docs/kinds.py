"""Write docs/kinds.md, a table of the kinds of sheets, from povgen/sheets/: `python docs/kinds.py`."""

from pathlib import Path

from povgen.sheets import SHEETS
from povgen.sheets.own import OwnLaw
from povgen.sheets.sheet import Ideal

PAGE = Path(__file__).with_name("kinds.md")
HEAD = """# The kinds of sheets

`make docs/kinds.md` writes this page from `povgen/sheets/`. [Beyond the paper](beyond.md#other-ideal-sheets) explains
the laws. [Adding](adding.md#a-sheet) says how to add a kind.

A law is the direction (x, y, z) behind the sheet of a ray that runs away from the eye. Before the sheet the ray has
the direction (x, y, z), of length 1. It meets the sheet at (X, Y), in tiles from the window's centre. Angles are in
radians. Light passes only where z of the new direction, divided by the direction's length, is above 1e-6.

| `--sheet` | it | parameters | law | source |
|---|---|---|---|---|
"""


def page() -> str:
    """Return the page's text."""
    rows = []
    for kind in SHEETS.values():
        parameters = ", ".join(f"`{each.name}`" for each in kind.parameters)
        law = f"`{kind.law}`" if issubclass(kind, Ideal) and kind is not OwnLaw else "the user's" * (kind is OwnLaw)
        rows.append(f"| `{kind.name}` | {kind.does} | {parameters} | {law} | {kind.source} |")
    return HEAD + "\n".join(rows) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
