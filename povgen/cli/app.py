"""The command line: find a command, run it, and turn every error into a message and an exit status.

The commands are in commands/. The models check values (`povgen.validation`).
"""

import os
import sys
import warnings
from importlib import import_module
from io import TextIOWrapper
from typing import NoReturn

import click

from povgen.errors import InputError, PovrayError, message_of, one_line, shown
from povgen.progress import say
from povgen.version import __version__

# The commands, with what the help says of each. A command is loaded only when it is run, because that is slow.
COMMANDS = {
    "list": "list the scenes with their parameters, kinds of sheets, pieces, glasses, and movies",
    "pov": "write a scene's POV-Ray source",
    "frame": "render a scene to a PNG or EXR file, or one again --from its file",
    "movie": "render a movie, or one again --from its file",
    "live": "make a page that shows a scene live, to move in a browser",
    "info": "print, as JSON, how a file of povgen's was made",
    "demo": "make a page to teach with: the scene, live, beside the geometry and the equations",
    "check": "test POV-Ray, cache, sandbox and encoder, and say how to mend what does not work",
    "cache": "print what the cache holds, or empty it",
    "verify": "compare what is rendered with the equations and the exact ray trace",
    "chart": "measure the cost and the error of pictures, for every renderer and every sampling",
    "tolerance": "trace how errors of building a pair of sheets change what is seen",
    "part": "write the sheets of prisms or lenses as solids, to print them: STL, OBJ or GLB",
    "cite": "print BibTeX entries of povgen and of the paper",
    "figure": "make figures of the paper, with captions that say how well they agree with it",
}


class _Commands(click.Group):
    def list_commands(self, context: click.Context) -> list[str]:  # noqa: ARG002
        return list(COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command:  # noqa: ARG002
        if name not in COMMANDS:
            raise InputError(f"command = {shown(name)}: unknown; allowed: {', '.join(COMMANDS)}")
        found: click.Command = import_module(f"povgen.cli.commands.{name}").command
        return found

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        with formatter.section("Commands"):
            formatter.write_dl([*COMMANDS.items()])


@click.group(cls=_Commands, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, message="povgen %(version)s", help="print povgen's version")
@click.pass_context
def app(context: click.Context) -> None:
    """POV-Ray scenes and movies of ray-rotating Dove-prism sheets. Lengths in floor tiles, angles in degrees."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())
        context.exit(2)


# words in the messages of errors without memory: Python cannot start a thread, or the system cannot load a library
NO_MEMORY = ("can't start new thread", "failed to map segment")


def main() -> NoReturn:
    """Run the command line. The exit status is 2 for a value that is not allowed, 1 if POV-Ray or the disk fails."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed, as by 2>&-; otherwise the next opened file would get its number
            setattr(sys, name, open(os.devnull, mode))
    if isinstance(sys.stdout, TextIOWrapper):  # the name of a file may not be valid text
        sys.stdout.reconfigure(errors="backslashreplace")
    if not sys.warnoptions:  # Python's warnings are for programmers
        warnings.simplefilter("ignore")
    try:
        status = app(prog_name="povgen", standalone_mode=False)
    except Exception as error:
        if isinstance(error, (InputError, click.UsageError)):
            _fail(one_line(getattr(error, "format_message", error.__str__)()), 2)
        if isinstance(error, (PovrayError, OSError)):
            _fail(message_of(error), 1)
        if isinstance(error, MemoryError) or any(words in str(error) for words in NO_MEMORY):
            _fail("no memory or no thread is left for povgen itself (ulimit -v, ulimit -u)", 1)
        raise
    sys.exit(status)


def _fail(message: str, status: int) -> NoReturn:
    say(f"povgen: {message}")
    sys.exit(status)
