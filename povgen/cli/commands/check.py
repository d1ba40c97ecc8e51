"""povgen check."""

import typer


def command() -> None:
    """See whether POV-Ray and the encoder work, with a small frame and movie; say what to do where they do not."""
    from povgen.cli.checkup import faults

    if list(faults(print)):
        raise typer.Exit(1)
