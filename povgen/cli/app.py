"""The command line: find a command, run it, and turn every error into a message and an exit status.

The commands are in commands/. The models check values (`povgen.validation`).
"""

import os
import sys
import warnings
from functools import cache
from importlib import import_module
from io import TextIOWrapper
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from povgen.errors import InputError, PovrayError, message_of, one_line, shown
from povgen.progress import say, tell
from povgen.version import __version__

HELP = {"help_option_names": ["-h", "--help"]}
COMMANDS = {
    "list": "List the scenes with their parameters, kinds of sheets, pieces, glasses, and movies of povgen's own.",
    "pov": "Write a scene's POV-Ray source to standard output, or to the file of -o.",
    "frame": "Render a scene to a PNG or EXR file, or one again --from its file.",
    "movie": "Render a movie, or one again --from its file. Finished frames stay in the cache.",
    "info": "Print, as JSON, how a picture or a movie was made: its record, with every parameter.",
    "demo": "Make a page to teach with: the scene, live, beside the geometry and the equations. It needs no network.",
    "check": "Test POV-Ray, cache, sandbox and encoder with a small frame and movie; say how to mend faults.",
    "cache": "Print what the cache holds, or empty it.",
    "verify": "Compare what is rendered with the equations and the exact ray trace.",
    "chart": "Measure the cost and the error of pictures, for every model of the sheets and every sampling.",
    "tolerance": "Trace how errors of building a pair of sheets change what is seen, one by one and in random builds.",
    "figure": "Make figures of the paper with captions that say how well they agree with it.",
}


@cache
def _with_options(name: str) -> Any:  # noqa: ANN401  (click's Command, whose module depends on typer's release)
    from povgen.cli.layout import Described  # these load the scenes
    from povgen.cli.options import with_options

    alone = typer.Typer(add_completion=False)
    alone.command(name, cls=Described, context_settings=HELP)(
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
        return _Command(name, help=COMMANDS[name])


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
