"""Options of several commands, and what they mean for scenes and their rendering."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import click

from povgen.cli.report import warn
from povgen.errors import InputError
from povgen.files import in_home, output_folder
from povgen.progress import say, tell
from povgen.record import PICTURES, Record, check_unasked
from povgen.rendering import auto, cache
from povgen.rendering.estimate import describe, estimate, if_long
from povgen.rendering.frames import drawn_by
from povgen.rendering.views import fitted
from povgen.scene.presets import SCENES, AxialScene, recorded
from povgen.scene.room import Room
from povgen.scene.scene import Scene
from povgen.settings import Rendering
from povgen.version import __version__

Values = dict[str, Any]  # what a user gave, by the parameters' names: texts, several texts, and Booleans of switches
F = TypeVar("F", bound=Callable[..., Any])

SCENE = "chess, spheres, room, or the TOML file of a room"
scene = click.argument("scene", metavar="SCENE", help=SCENE)
workers = click.option(
    "--workers",
    metavar="N",
    help="how many frames are rendered at once, 1 to 256 (default: 8 for each core; with --renderer gl one, and on a "
    "GPU at most 4)",
)
tolerance = click.option(
    "--tolerance",
    metavar="ERROR",
    help="largest error for --sheet auto: of positions (1px), of the picture (0.2flip), or both (1px,0.2flip)",
)
scheduler = click.option(
    "--scheduler", metavar="ADDRESS", help="address of a Dask scheduler, tcp://HOST:PORT, whose workers compute"
)
quiet = click.option("--quiet", is_flag=True, help="print errors only")
dry_run = click.option(
    "--dry-run",
    is_flag=True,
    help="print how many frames, and about how long they take, as small pictures show; render nothing else",
)
source = click.option(
    "--from",
    "source",
    type=Path,
    metavar="FILE",
    help="make a file of povgen's again, from the record in it; other options replace what the record says",
)


def output(metavar: str, about: str, default: str | None = None) -> Callable[[F], F]:
    """Return the option --output."""
    shown = {"default": default, "show_default": True} if default else {}
    return click.option("-o", "--output", type=Path, metavar=metavar, help=about, **shown)  # type: ignore[arg-type]


def scene_of(name: str, values: Values) -> Scene:
    """Return the scene of this name, or of a room's file, with these values. Values can be text. Raises InputError."""
    if name in SCENES:
        return SCENES[name](**values)
    if not scene_files(name):
        raise InputError(f"scene = {name!r}: unknown; allowed: {', '.join(SCENES)}, or the TOML file of a room")
    return Room.load(name, **values)


def stated(made: Scene, values: Values) -> Values:
    """Return the values that a user gave for a new scene: these, and those in the scene's file."""
    return values | {name: getattr(made, name) for name in made.model_fields_set - values.keys()}


def scene_files(name: str | None) -> list[str]:
    """Return the file that states a scene, if the command line names one in place of a scene."""
    if name is None or name in SCENES:
        return []
    return [name] if name == "-" or name.endswith(".toml") or os.path.isfile(in_home(Path(name))) else []


def again(source: Path, output: Path | None, values: Values, quiet: bool) -> "tuple[Record, list[Scene], Values]":
    """Return the record in a file, its scenes, and the values of its rendering.

    A value that the user gave replaces the record's, and also the record's values that depend on it. The bits follow
    from the output's ending if such a file cannot have the record's. Print a warning if another version of
    povgen or of the renderer made the file. Raises InputError if the file has no valid record.
    """
    record, scenes = recorded(source)
    options = record.rendering.model_dump()
    if options["bits"] not in PICTURES.get((output or Path("frame.png")).suffix.lower(), PICTURES[".png"])[1]:
        del options["bits"]
    if values.get("stereo", options["stereo"]) == "none":
        del options["eye_distance"]
    if "quality" in values:  # the quality then decides the size, unless the user gives a size
        del options["size"]
    if "quality" in values or "sheet" in values:  # they decide it
        del options["antialias"]
    scenes = _without_default_views(scenes, record.rendering.size)
    if not quiet and values.get("renderer", record.rendering.renderer) == record.rendering.renderer:
        here = __version__, drawn_by(record.rendering.renderer)
        if record.renderer and here != (record.povgen, record.renderer):
            made = f"made by povgen {record.povgen} and {record.renderer}, here are {' and '.join(here)}"
            say(f"povgen: warning: {source}: {made}: pixels can differ")
    return record, scenes, {**options, **values}


def _without_default_views(scenes: list[Scene], size: tuple[int, int]) -> list[Scene]:
    """Return the scenes of a record without their views, if these are the defaults for pictures of this size."""
    plain = [_without_view(scene) for scene in scenes]
    alike = (a.camera.height == b.camera.height for a, b in zip(fitted(plain, size), scenes, strict=True))
    return plain if all(alike) else scenes


def _without_view(scene: Scene) -> Scene:
    if not isinstance(scene, AxialScene):
        return scene
    return type(scene)(**{name: getattr(scene, name) for name in scene.model_fields_set - {"view"}})


def split(values: Values) -> tuple[Values, Values]:
    """Divide values into a scene's values and a rendering's. Raises InputError for eye_distance without stereo."""
    rendering = {name: value for name, value in values.items() if name in Rendering.model_fields}
    if "eye_distance" in rendering and rendering.get("stereo", "none") == "none":
        raise InputError(
            f"eye_distance = {rendering['eye_distance']}: one eye has no distance; allowed: with stereo = pair or "
            "anaglyph"
        )
    return {name: value for name, value in values.items() if name not in rendering}, rendering


def made_folder(output: Path, files: Mapping[str, Iterable[str]]) -> AbstractContextManager[Path]:
    """Make the folder for a command's output, as files.output_folder does. Check all other values before this call.

    `files` has the names of the files that the command writes there. The key of each group of names is the file that
    shows whether povgen wrote this group. Raises InputError if one of these files exists and povgen did not write it.
    """
    cache.check()
    for sign, names in files.items():
        check_unasked((in_home(output) / name for name in names), in_home(output) / sign)
    return output_folder(output)


class Automatic(NamedTuple):
    """What --sheet auto, --renderer auto and --tolerance ask for."""

    tolerance: auto.Tolerance
    renderers: Sequence[str]  # that may be chosen

    def choose(
        self, scenes: Sequence[Scene], options: Values, quiet: bool, scheduler: str | None = None
    ) -> tuple[Values, Values]:
        """Return the choice for scenes with prisms: values of the scenes, and of their rendering. Print why.

        The scheduler does not take part in the choice. But if it does not answer, PovrayError is raised before anything
        is rendered. Raises what `auto.choose` raises.
        """
        if scheduler:
            from povgen.rendering.cluster import ask

            ask(scheduler)
        rendering = Rendering(**options)
        choice, why = auto.choose(scenes, rendering, self.tolerance, options.get("antialias"), self.renderers)
        if not quiet:
            say(f"povgen: {why}")
        return {"sheet": choice.sheet}, {"antialias": choice.antialias, "renderer": choice.renderer}


def automatic(values: Values, options: Values, tolerance: str | None, dry_run: bool) -> Automatic | None:
    """Return what --sheet auto asks for, or None for another sheet. Remove --renderer auto from the options.

    Raises InputError if the tolerance is not valid, if only one of --sheet auto and --tolerance is given, if --renderer
    auto is given without them, or for a dry run.
    """
    if (values.get("sheet") == "auto") != (tolerance is not None):
        raise InputError("sheet = 'auto' and tolerance go together; allowed: both: --sheet auto --tolerance 1px")
    renderer = options.get("renderer", "povray")
    if tolerance is None:
        if renderer == "auto":
            raise InputError("renderer = 'auto': allowed: with --sheet auto, otherwise 'povray' or 'gl'")
        return None
    if renderer == "auto":
        del options["renderer"]
    found = Automatic(auto.Tolerance.parse(tolerance), auto.RENDERERS if renderer == "auto" else [renderer])
    if dry_run:
        raise InputError("dry-run: not with --sheet auto, which renders to choose; allowed: one of them")
    return found


def ready(scenes: Sequence[Scene], rendering: Rendering, values: Values, dry_run: bool, quiet: bool) -> bool:
    """Return whether rendering is to begin, after all that is said before it: warnings, and how long it takes.

    `values` are those of which a warning says that they change nothing.
    """
    if dry_run:
        tell(describe(scenes, rendering, estimate(scenes, rendering)))
        return False
    cache.check()
    if not quiet:
        if text := if_long(scenes, rendering):
            say(f"povgen: {text}")
        warn(values, scenes, rendering)
    return True
