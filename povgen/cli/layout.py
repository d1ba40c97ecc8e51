"""How the help of a command is laid out."""

import re
from shutil import get_terminal_size
from textwrap import wrap
from typing import Any

from typer.core import TyperCommand

OTHERS = "Parameters of other sheets, which povgen list explains"
INDENT = 20  # characters before the text that says what an option does, in a help


class Described(TyperCommand):
    """A command whose help lists its options under headings, in few lines."""

    def format_help(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401  (as click declares it)
        width, usage = columns(), [f"Usage: {ctx.command_path} [OPTIONS]"]
        groups: dict[str, list[str]] = {"Options": []}
        for param in self.get_params(ctx):
            about, default = getattr(param, "help", None) or "", getattr(param, "show_default", False)
            if default and (isinstance(default, str) or param.default not in (None, False)):
                about += f" (default {default if isinstance(default, str) else param.default})"
            group = getattr(param, "rich_help_panel", None)
            if param.param_type_name == "argument":
                names = str(param.metavar or param.name.upper())
                usage.append(names)
            else:
                names = ", ".join(param.opts)
                names += f" {param.metavar}" if param.metavar and group is None else ""
            about = re.sub(r"\(default:? ([^)]*)\)", r"[\1]", about)
            groups.setdefault(group or "Options", []).extend(item(names, about, width))
        text = [" ".join(usage)]
        for paragraph in (self.help or "").split("\n\n"):
            text += ["", *wrap(paragraph, width)]
        for group, lines in groups.items():
            if group == OTHERS:
                names = " ".join(line.split()[0] for line in lines if line.startswith("  --"))
                lines = wrap(names, width, initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False)
            text += ["", f"{group}:", *lines]
        if "The picture" in groups:
            text += ["", "In brackets: the defaults. The opposite of a switch: --no-overlay."]
        formatter.write("\n".join(text) + "\n")


def columns() -> int:
    """Return how wide a help is, in characters: as the terminal, but not so narrow that no word fits."""
    return min(max(get_terminal_size().columns, 2 * INDENT), 120)


def item(names: str, about: str, width: int) -> list[str]:
    """Return the lines about an option or another name: the name, and beside it what it is."""
    lines = wrap(about, width - INDENT, break_on_hyphens=False) or [""]
    if len(names) > INDENT - 3:
        return [f"  {names}", *(" " * INDENT + line for line in lines)]
    return [f"  {names:{INDENT - 2}}{lines[0]}", *(" " * INDENT + line for line in lines[1:])]
