"""Write docs/kinds.md and docs/objects.md, tables of the kinds of sheets and of objects: `python docs/kinds.py`."""

from pathlib import Path

from povgen.objects import OBJECTS
from povgen.objects.placed import Placed
from povgen.objects.window import Window
from povgen.scene.room import Eye
from povgen.sheets import PARAMETERS, SHEETS
from povgen.sheets.own import OwnLaw
from povgen.sheets.sheet import Ideal
from povgen.validation import Model

PAGE = Path(__file__).with_name("kinds.md")
OBJECTS_PAGE = Path(__file__).with_name("objects.md")
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


OBJECTS_HEAD = """# The objects of a room

`make docs/objects.md` writes this page from `povgen/objects/`. [A room of your own](rooms.md) says how to use them.
"""


def objects_page() -> str:
    """Return the text of the page about objects."""
    parts: dict[str, type[Model]] = {"The eye, `[eye]`": Eye, "Every object and window": Placed}
    parts |= {"A window, `[[window]]`": Window}
    parts |= {f'A {kind.title}, `kind = "{name}"`': kind for name, kind in OBJECTS.items()}
    text = OBJECTS_HEAD
    for title, part in parts.items():
        text += f"\n## {title}\n\n| parameter | it is | default |\n|---|---|---|\n"
        shared = {} if part in (Eye, Placed) else {**Placed.model_fields, **PARAMETERS}
        for name, field in part.model_fields.items():
            if name not in shared:
                default = "" if field.is_required() or field.default in (None, "") else f"`{field.default}`"
                text += f"| `{name}` | {field.description} | {default} |\n"
        if part is Window:
            text += "\nAnd the parameters of [its sheet](kinds.md).\n"
    return text


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
    OBJECTS_PAGE.write_text(objects_page(), "utf-8")
