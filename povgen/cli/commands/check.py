"""The command povgen check."""

import click

from povgen.cli.checkup import faults
from povgen.cli.field_options import Command
from povgen.progress import tell


@click.command("check", cls=Command)
def command() -> None:
    """Test POV-Ray, cache, sandbox and encoder with a small frame and movie, and say how to mend what does not work."""
    if list(faults(tell)):
        raise click.exceptions.Exit(1)
