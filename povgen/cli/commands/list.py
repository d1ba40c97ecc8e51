"""The command povgen list."""

import click

from povgen.cli.field_options import NAMES, Command, described
from povgen.inputs.pieces import PIECES
from povgen.objects import OBJECTS
from povgen.objects.placed import Placed
from povgen.objects.window import Window
from povgen.optics.glasses import GLASSES, index
from povgen.progress import tell
from povgen.scene.presets import SCENES, Chess
from povgen.scene.room import Eye
from povgen.scene.spec import MOVIES, MovieSpec
from povgen.sheets import PARAMETERS, SHEETS
from povgen.sheets.parameters import WAVELENGTH
from povgen.validation import Model


@click.command("list", cls=Command)
def command() -> None:
    """List scenes with parameters, objects of rooms, kinds of sheets, pieces, glasses, and povgen's own movies."""

    formatter = click.HelpFormatter(max_width=120)
    for name, scene in SCENES.items():
        with formatter.section(f"{name}: {scene.subject}"):
            rows = [(f"--{field.replace('_', '-')}", described(info)) for field, info in scene.model_fields.items()]
            formatter.write_dl(rows, NAMES)
    parts: dict[str, type[Model]] = {"--eye": Eye, "each --object and --window": Placed, "--window": Window}
    parts |= {f"--object kind={name}": kind for name, kind in OBJECTS.items()}
    for name, part in parts.items():
        shared = {*PARAMETERS, *Placed.model_fields} if part is not Placed and part is not Eye else set()
        with formatter.section(f"room, {name}"):
            own = ((field, described(info)) for field, info in part.model_fields.items() if field not in shared)
            formatter.write_dl([*own], NAMES)
    with formatter.section("sheets"):
        made = {kind.name: Chess(sheet=kind.name, **kind.examples[0]).sheets[0].buildable() for kind in SHEETS.values()}
        about = [(kind.name, f"{kind.does}. Buildable: {made[kind.name].parts}") for kind in SHEETS.values()]
        formatter.write_dl(about, NAMES)
    tell(formatter.getvalue())
    tell(f"pieces: {', '.join(PIECES)}")
    tell(f"glasses, n at {WAVELENGTH} nm: {', '.join(f'{x} {index(x, WAVELENGTH * 1e-9):.4f}' for x in GLASSES)}")
    for path in sorted(MOVIES.glob("*.toml")):
        tell(f"movie {path.stem}: {MovieSpec.load(path).title}")
