"""The command povgen check."""

import typer

from povgen.cli.checkup import faults
from povgen.progress import tell


def command() -> None:
    """Test POV-Ray, cache, sandbox and encoder with a small frame and movie, and say how to mend what does not work."""
    if list(faults(tell)):
        raise typer.Exit(1)
