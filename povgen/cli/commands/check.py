"""The command povgen check."""

import typer


def command() -> None:
    """Test POV-Ray, cache, sandbox and encoder with a small frame and movie, and say how to mend what does not work."""
    from povgen.cli.checkup import faults

    if list(faults(print)):
        raise typer.Exit(1)
