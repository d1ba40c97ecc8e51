"""Write docs/reference.md, tables that are made from the code: `python docs/reference.py`."""

import re
from collections.abc import Iterable
from importlib import import_module
from inspect import getdoc
from pathlib import Path

import click
from pydantic import BaseModel
from pydantic.fields import FieldInfo

import povgen
from povgen.cli.app import COMMANDS
from povgen.cli.field_options import FieldOption
from povgen.objects import OBJECTS
from povgen.objects.placed import Placed
from povgen.objects.window import Window
from povgen.scene.quantities import QUANTITIES
from povgen.scene.room import Eye
from povgen.scene.spec import MovieSpec, PartNote, Sweep
from povgen.sheets import PARAMETERS, SHEETS
from povgen.sheets.own import OwnLaw
from povgen.sheets.sheet import Ideal

PAGE = Path(__file__).with_name("reference.md")
AGAIN = "; can be repeated"  # at the end of an option's help
NAMES = ", ".join(SHEETS)
LONG = 200  # characters of a law; the file of the sheet has a longer one
HEAD = """# Reference

`make docs/reference.md` writes this page from the code: [options](#options), [sheets](#sheets), [objects](#objects),
[quantities](#quantities), [movie files](#movie-files), [Python](#python). [Terms and signs](terms.md) defines the
symbols. *The paper*: [credits](credits.md).
"""
OPTIONS = """
## Options

In Python and in TOML files a parameter has the option's name, with `_` in place of `-`. In parentheses: the defaults.
`--no-NAME` turns a switch off. An option with … can be repeated. `povgen COMMAND --help` explains all options
of a command, also [its own](#of-commands).
"""
KINDS = """
## Sheets

A [law](beyond.md#other-ideal-sheets) is the new direction of a ray that runs away from the eye with the direction
(x, y, z), of length 1, and meets the sheet at (X, Y), in tiles from the window's centre. Angles are in radians. Light
passes only where z of the new direction, divided by its length, is above 1e-6.
"""
OF_OBJECTS = """
## Objects

[Rooms](rooms.md) says how to use them, and `povgen list` what each parameter is. In Python they are the classes `Eye`,
`Window`, `Box` and so on. A window also has the parameters of its sheet. Lengths are in tiles, turns in degrees.
"""
OF_QUANTITIES = """
## Quantities

For [`povgen.results`](rays.md#many-scenes), of the scene's first object.
"""
MOVIES = """
## Movie files

The keys of [a movie's TOML file](adding.md#a-movie), and of its tables `[[sweep]]` and `[[notes]]`. An option of
`povgen movie` replaces a value of the file.
"""
PYTHON = """
## Python

The public names of `povgen`, beside [the objects](#objects). `help(povgen.Chess)` has the parameters.
[The site](website.md) has every docstring.
"""
# of a room
PARTS: dict[str, type[BaseModel]] = {
    "`[eye]`": Eye,
    "every object and window": Placed,
    "`[[window]]`": Window,
    **{f"`{name}`": kind for name, kind in OBJECTS.items()},
}


def table(heads: str, rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown. A bar within a cell is escaped, and a list of all kinds of sheets is a link."""
    lines = [heads.split(" | "), ["---"] * (heads.count(" | ") + 1)]
    lines += [[cell.replace("|", "\\|").replace(NAMES, "[a kind](#sheets)") for cell in row] for row in rows]
    return "".join(f"|{'|'.join(line)}|\n" for line in lines)


def mark(flag: str, about: str) -> str:
    """Return an option's name, with an ellipsis if it can be repeated."""
    return f"`{flag}`" + " …" * about.endswith(AGAIN)


def options() -> str:
    """Return the tables of options: a table for each heading of the help, and the names of the others by command."""
    groups: dict[str, dict[str, str]] = {}
    others: dict[str, list[str]] = {}
    for name in COMMANDS:
        for option in import_module(f"povgen.cli.commands.{name}").command.params:
            if isinstance(option, FieldOption):
                rows = groups.setdefault(option.group.partition(",")[0], {})
                rows[option.opts[0]] = max(rows.get(option.opts[0], ""), option.help or "", key=len)
            elif isinstance(option, click.Option):
                others.setdefault(f"`povgen {name}`", []).append(mark(option.opts[-1], option.help or ""))
    text = OPTIONS
    for group, rows in groups.items():
        described = ([mark(flag, about), about.removesuffix(AGAIN)] for flag, about in rows.items())
        text += f"\n### {group}\n\n" + table("option | what it is", described)
    rest = ([name, ", ".join(flags)] for name, flags in others.items())
    return f"{text}\n### Of commands\n\n" + table("command | its own options", rest)


def sheets() -> str:
    """Return the table of the kinds of sheets."""

    def law(kind: type) -> str:
        if kind is OwnLaw or not issubclass(kind, Ideal):
            return "the user's" * (kind is OwnLaw)
        file = kind.__module__.replace(".", "/") + ".py"
        law = re.sub(r" ([-+*/]) ", r"\1", str(kind.law))
        return f"`{law}`" if len(law) < LONG else f"[{Path(file).name}](../{file})"

    def source(kind: type) -> str:
        return "the paper" if kind.source == SHEETS["ideal"].source else kind.source

    rows = (
        [f"`{kind.name}`", kind.does, ", ".join(f"`{each.name}`" for each in kind.parameters), law(kind), source(kind)]
        for kind in SHEETS.values()
    )
    return f"{KINDS}\n" + table("`--sheet` | it | parameters | law | source", rows)


def objects() -> str:
    """Return the table of what stands in a room, and of its parameters, with their defaults."""

    def stated(name: str, field: FieldInfo) -> str:
        return f"`{name}`" + f" (`{field.default}`)" * (not field.is_required() and field.default not in (None, "", 0))

    rows = (
        [
            title,
            (getdoc(part) or "").partition("\n\n")[0],
            ", ".join(
                stated(name, field)
                for name, field in part.model_fields.items()
                if part in (Eye, Placed) or name not in {**Placed.model_fields, **PARAMETERS}
            ),
        ]
        for title, part in PARTS.items()
    )
    return f"{OF_OBJECTS}\n" + table("of | it is | parameters (defaults, if not 0)", rows)


def quantities() -> str:
    """Return the table of quantities."""
    return f"{OF_QUANTITIES}\n" + table(
        "quantity | unit | it is", ([f"`{name}`", each.unit, each.text] for name, each in QUANTITIES.items())
    )


def movies() -> str:
    """Return the table of the keys of a movie's file."""
    parts = {"": MovieSpec, "`[[sweep]]`": Sweep, "`[[notes]]`": PartNote}
    rows = (
        [title * (k == 0), f"`{name}`", field.description or ""]  # the title stands once
        for title, part in parts.items()
        for k, (name, field) in enumerate(part.model_fields.items())
    )
    return f"{MOVIES}\n" + table("in | key | it is", rows)


def python() -> str:
    """Return the table of public names, with the first sentence of each docstring."""

    def about(value: object) -> str:
        first = " ".join((getdoc(value) or "").partition("\n\n")[0].split())
        return first.partition(". ")[0].removesuffix(".").removeprefix("Return ")

    names = (name for name in povgen.__all__ if not name.startswith("_"))
    values = {name: value for name in names if (value := getattr(povgen, name)) not in PARTS.values()}
    rows = ([f"`{name}`", about(value)] for name, value in values.items())
    return f"{PYTHON}\n" + table("name | it is", rows)


def page() -> str:
    """Return the page's text."""
    return HEAD + options() + sheets() + objects() + quantities() + movies() + python()


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
