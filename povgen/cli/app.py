"""The command line: finds the command, runs it, and puts every error in a line. All checking is done by the models."""

import os
import sys
from collections.abc import Callable
from importlib import import_module
from inspect import getdoc
from io import TextIOWrapper
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from povgen import __version__, stopping
from povgen.cli.options import with_options
from povgen.cli.report import one_line, say
from povgen.errors import InputError, PovrayError

COMMANDS = ("list", "pov", "frame", "movie", "demo", "check", "cache", "verify", "chart", "figure")


class _Command(TyperCommand):
    """A command that gets its options when it is run."""

    def __init__(self, name: str, function: Callable):
        super().__init__(name=name, help=getdoc(function))
        self._function = function

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        alone = typer.Typer(add_completion=False)
        alone.command(self.name)(with_options(self._function))
        return typer.main.get_command(alone).make_context(*arguments, **options)


class _Commands(TyperGroup):
    def list_commands(self, context: Any) -> list[str]:
        return list(COMMANDS)

    def get_command(self, context: Any, name: str) -> Any:
        if name in COMMANDS:
            return _Command(name, import_module(f"povgen.cli.commands.{name}").command)
        return None


app = typer.Typer(
    name="povgen",
    help="POV-Ray scenes and movies of ray-rotating Dove-prism sheets. Lengths in floor tiles, angles in degrees.",
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.callback(invoke_without_command=True)
def _version(version: Annotated[bool, typer.Option("--version", help="print povgen's version")] = False) -> None:
    if version:
        print(f"povgen {__version__}")
        raise typer.Exit


def main() -> None:
    """Run the command line; exit status 2 for input that cannot be, 1 where POV-Ray or the disk fails."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed, as by 2>&-: the next file that is opened would take its number
            setattr(sys, name, open(os.devnull, mode))
    if isinstance(sys.stdout, TextIOWrapper):  # a file's name need not be text
        sys.stdout.reconfigure(errors="backslashreplace")
    usage_error = typer.BadParameter.__bases__[0]  # click's, which typer has under another name from release to release
    try:
        status = app(standalone_mode=False)
    except Exception as error:
        if stopping.asked():
            raise
        if isinstance(error, (InputError, usage_error)):
            message = one_line(getattr(error, "format_message", error.__str__)())
            _fail(f"povgen: {message}" if message else "", 2)  # typer has said it all where it has printed the help
        if isinstance(error, (PovrayError, OSError)):
            _fail(f"povgen: {error}", 1)
        if isinstance(error, MemoryError) or str(error) == "can't start new thread":
            _fail("povgen: no memory or no thread is left for povgen itself (ulimit -v, ulimit -u)", 1)
        raise
    sys.exit(status)


def _fail(message: str, status: int) -> None:
    if message:
        say(message)
    sys.exit(status)
