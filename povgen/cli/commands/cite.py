"""The command povgen cite."""

import click

from povgen.citation import ENTRIES
from povgen.cli.field_options import Command
from povgen.progress import tell


@click.command("cite", cls=Command)
def command() -> None:
    """Print BibTeX entries of povgen and of the paper that it follows."""
    tell(ENTRIES)
