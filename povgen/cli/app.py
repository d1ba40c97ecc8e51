"""The command line: find a command, run it, and turn every error into a message and an exit status.

The commands are in commands/. The models check values (`povgen.validation`).
"""

import os
import re
import sys
import warnings
from functools import cache
from importlib import import_module
from inspect import getdoc
from io import TextIOWrapper
from textwrap import wrap
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from povgen import stopping
from povgen.cli.options import OTHERS, columns, item, with_options
from povgen.cli.report import message_of
from povgen.errors import InputError, PovrayError, one_line, shown
from povgen.progress import say, tell
from povgen.version import __version__

HELP = {"help_option_names": ["-h", "--help"]}
COMMANDS = ("list", "pov", "frame", "movie", "info", "demo", "check", "cache", "verify", "chart", "tolerance", "figure")


class _Described(TyperCommand):
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


@cache
def _with_options(name: str) -> Any:  # noqa: ANN401  (click's Command, whose module depends on typer's release)
    alone = typer.Typer(add_completion=False)
    alone.command(name, cls=_Described, context_settings=HELP)(
        with_options(import_module(f"povgen.cli.commands.{name}").command)
    )
    return typer.main.get_command(alone)


class _Command(TyperCommand):
    """A command's name and help. Its options are added when it is run, because that loads the scenes."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:  # noqa: ANN401  (as click declares it)
        return _with_options(self.name).make_context(*arguments, **options)


class _Commands(TyperGroup):
    def list_commands(self, context: object) -> list[str]:
        return list(COMMANDS)

    def get_command(self, context: object, name: str) -> _Command:
        if name not in COMMANDS:
            raise InputError(f"command = {shown(name)}: unknown; allowed: {', '.join(COMMANDS)}")
        return _Command(name, help=getdoc(import_module(f"povgen.cli.commands.{name}").command))


app = typer.Typer(
    name="povgen",
    help="POV-Ray scenes and movies of ray-rotating Dove-prism sheets. Lengths in floor tiles, angles in degrees.",
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    context_settings=HELP,
    pretty_exceptions_enable=False,
)


@app.callback(invoke_without_command=True)
def _version(version: Annotated[bool, typer.Option("--version", help="print povgen's version")] = False) -> None:
    if version:
        tell(f"povgen {__version__}")
        raise typer.Exit


# words in the messages of errors without memory: Python cannot start a thread, or the system cannot load a library
NO_MEMORY = ("can't start new thread", "failed to map segment")


def main() -> None:
    """Run the command line. The exit status is 2 for a value that is not allowed, 1 if POV-Ray or the disk fails."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed, as by 2>&-; otherwise the next opened file would get its number
            setattr(sys, name, open(os.devnull, mode))
    if isinstance(sys.stdout, TextIOWrapper):  # the name of a file may not be valid text
        sys.stdout.reconfigure(errors="backslashreplace")
    if not sys.warnoptions:  # Python's warnings are for programmers
        warnings.simplefilter("ignore")
    usage_error = typer.BadParameter.__bases__[0]  # click's UsageError; its module depends on typer's release
    try:
        status = app(standalone_mode=False)
    except Exception as error:
        if stopping.asked():
            raise
        if isinstance(error, (InputError, usage_error)):
            message = one_line(getattr(error, "format_message", error.__str__)())
            _fail(f"povgen: {message}" if message else "", 2)  # no message: typer has printed the help instead
        if isinstance(error, (PovrayError, OSError)):
            _fail(f"povgen: {message_of(error)}", 1)
        if isinstance(error, MemoryError) or any(words in str(error) for words in NO_MEMORY):
            _fail("povgen: no memory or no thread is left for povgen itself (ulimit -v, ulimit -u)", 1)
        raise
    sys.exit(status)


def _fail(message: str, status: int) -> None:
    if message:
        say(message)
    sys.exit(status)
