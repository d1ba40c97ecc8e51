"""The command povgen list."""

import click

from povgen.cli.command import NAMES, Command, described
from povgen.inputs.pieces import PIECES
from povgen.optics.glasses import GLASSES, index
from povgen.progress import tell
from povgen.scene.scenes import SCENES
from povgen.scene.spec import MOVIES, MovieSpec
from povgen.sheets import SHEETS
from povgen.sheets.parameters import WAVELENGTH


@click.command("list", cls=Command)
def command() -> None:
    """List the scenes with their parameters, the kinds of sheets, the pieces, the glasses, and povgen's own movies."""

    formatter = click.HelpFormatter(max_width=120)
    for name, scene in SCENES.items():
        with formatter.section(f"{name}: {scene.subject}"):
            rows = [(f"--{field.replace('_', '-')}", described(info)) for field, info in scene.model_fields.items()]
            formatter.write_dl(rows, NAMES)
    with formatter.section("sheets"):
        formatter.write_dl([(kind.name, kind.does) for kind in SHEETS.values()], NAMES)
    tell(formatter.getvalue())
    tell(f"pieces: {', '.join(PIECES)}")
    tell(f"glasses, n at {WAVELENGTH} nm: {', '.join(f'{x} {index(x, WAVELENGTH * 1e-9):.4f}' for x in GLASSES)}")
    for path in sorted(MOVIES.glob("*.toml")):
        tell(f"movie {path.stem}: {MovieSpec.load(path).title}")
