"""The command povgen list."""

from povgen.progress import tell


def command() -> None:
    """List the scenes with their parameters, the chess pieces, and povgen's own movies."""
    from povgen.cli.options import described
    from povgen.scene.models import SCENES
    from povgen.scene.pieces import PIECES
    from povgen.scene.spec import MOVIES, MovieSpec

    for name, scene in SCENES.items():
        tell(f"{name}: {scene.subject}")
        for field, info in scene.model_fields.items():
            tell(f"    --{field.replace('_', '-'):17}{described(info)}")
    tell(f"pieces: {', '.join(PIECES)}")
    for path in sorted(MOVIES.glob("*.toml")):
        tell(f"movie {path.stem}: {MovieSpec.load(path).title}")
