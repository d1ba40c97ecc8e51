"""The command povgen list."""

import click

from povgen.cli.command import Command, columns, described, item
from povgen.optics.glasses import GLASSES, index
from povgen.progress import tell
from povgen.scene.pieces import PIECES
from povgen.scene.scenes import SCENES
from povgen.scene.spec import MOVIES, MovieSpec
from povgen.sheets import SHEETS
from povgen.sheets.parameters import WAVELENGTH


@click.command("list", cls=Command)
def command() -> None:
    """List the scenes with their parameters, the kinds of sheets, the pieces, the glasses, and povgen's own movies."""

    def show(name: str, about: str) -> None:
        tell("\n".join(item(name, about, columns())))

    for name, scene in SCENES.items():
        tell(f"{name}: {scene.subject}")
        for field, info in scene.model_fields.items():
            show(f"--{field.replace('_', '-')}", described(info))
    tell("sheets:")
    for kind in SHEETS.values():
        show(kind.name, kind.does)
    tell(f"pieces: {', '.join(PIECES)}")
    tell(f"glasses, n at {WAVELENGTH} nm: {', '.join(f'{x} {index(x, WAVELENGTH * 1e-9):.4f}' for x in GLASSES)}")
    for path in sorted(MOVIES.glob("*.toml")):
        tell(f"movie {path.stem}: {MovieSpec.load(path).title}")
