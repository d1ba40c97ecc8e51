"""Options of the commands: options made from the fields of scenes and `Rendering`, and options of several commands."""

import inspect
import logging
import os
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

import typer
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from povgen.cli.layout import OTHERS
from povgen.errors import InputError
from povgen.files import in_home, output_folder
from povgen.progress import say
from povgen.record import Record, check_unasked
from povgen.rendering import auto, cache
from povgen.rendering.auto import RENDERERS
from povgen.rendering.auto import Tolerance as AutoTolerance
from povgen.rendering.views import views
from povgen.scene import mesh
from povgen.scene.scenes import SCENES, Scene, recorded
from povgen.settings import Rendering, Sampling
from povgen.sheets import PAPER, PARAMETERS, USED_BY
from povgen.version import __version__
from povgen.video.still import drawn_by

Command = Callable[..., None]
Values = dict[str, Any]  # what a user gave, by the parameters' names: texts, lists of texts, and Booleans of switches
SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="chess or spheres")]
Workers = Annotated[
    str | None,
    typer.Option(
        metavar="N",
        help="how many frames are rendered at once, 1 to 256",
        show_default="8 for each core; with --renderer gl one, and on a GPU at most 4",
    ),
]
Tolerance = Annotated[
    str | None,
    typer.Option(
        metavar="ERROR",
        help="largest error for --sheet auto: of positions (1px), of the picture (0.2flip), or both (1px,0.2flip)",
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="address of a Dask scheduler, tcp://HOST:PORT, whose workers compute"),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="print errors only")]
DryRun = Annotated[
    bool,
    typer.Option(
        "--dry-run",
        help="print how many frames, and about how long they take, as small pictures show; render nothing else",
    ),
]
Source = Annotated[
    Path | None,
    typer.Option(
        "--from",
        metavar="FILE",
        help="make a file of povgen's again, from the record in it; other options replace what the record says",
    ),
]


def output_to(metavar: str, about: str) -> Any:  # noqa: ANN401  (as typer declares its options)
    """Return the option --output."""
    return typer.Option("-o", "--output", metavar=metavar, help=about)


def takes(*models: str) -> Callable[[Command], Command]:
    """Mark a command that has an option for every field of these models: 'scenes' (all scenes) or 'rendering'.

    'sampling' is the part of 'rendering' that also has an effect if a user starts POV-Ray: quality, size and antialias.

    The command gets the values that the user gives as text, in its **values.
    """

    def mark(command: Command) -> Command:
        command.__dict__["models"] = models
        return command

    return mark


def with_options(command: Command) -> Command:
    """Return the command with a signature for typer: an option for every field of the models that it `takes`.

    An option's value is text; a switch is --x or --no-x. This function loads the models, which is slow, so it is called
    only for the command that is run.
    """
    fields = _fields(command.__dict__.get("models", ()))

    def called(**arguments: object) -> None:
        given: Values = {name: arguments.pop(name) for name in fields}
        given = {name: value for name, value in given.items() if value not in (None, [])}
        repeated = {name: x for name, x in {**arguments, **given}.items() if isinstance(x, list)}
        given = {name: x[0] if isinstance(x, list) and len(x) == 1 else x for name, x in given.items()}
        logger = logging.getLogger("povgen")
        level = logger.level
        try:
            logger.setLevel("ERROR" if arguments.get("quiet") else level)
            command(**arguments, **given)
        except InputError as error:
            raise InputError(f"{error}{_repeat(str(error), repeated)}") from None
        finally:
            logger.setLevel(level)

    own = [p for p in inspect.signature(command).parameters.values() if p.kind is not p.VAR_KEYWORD]
    auto = {}
    if any(p.name == "tolerance" for p in own):
        auto = {
            "sheet": "; or auto: the cheapest within --tolerance",
            "renderer": "; or auto, with --sheet auto: the cheapest within --tolerance",
        }
    parameters = [*own, *(_option(name, owners, auto.get(name, "")) for name, owners in fields.items())]
    parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    called.__dict__["__signature__"] = inspect.Signature(parameters)
    called.__annotations__ = {p.name: p.annotation for p in parameters}
    # typer breaks lines as the terminal needs it, but also wherever the text has a line break
    called.__doc__ = "\n\n".join(" ".join(part.split()) for part in (command.__doc__ or "").split("\n\n"))
    return called


def _repeat(message: str, repeated: dict[str, list[str]]) -> str:
    """Return what to add to an error about an option that can be repeated, and that got several values at once."""
    for name, texts in repeated.items():
        several = (x for x in texts if re.search("[,; ]", x) and not os.path.exists(x) and not mesh.split(x))
        if re.search(rf"\b{name} = ", message) and any(several):
            return f"; give --{name} once for each value"
    return ""


def _fields(models: tuple[str, ...]) -> dict[str, list[tuple[str, FieldInfo]]]:
    """Return, for each field name, the names of the scenes that have the field ('' for Rendering) and their fields."""
    fields: dict[str, list[tuple[str, FieldInfo]]] = {}
    groups = {"scenes": SCENES.values(), "sampling": [Sampling], "rendering": [Rendering]}
    for model in chain.from_iterable(groups[group] for group in models):
        for name, field in model.model_fields.items():
            fields.setdefault(name, []).append((getattr(model, "name", ""), field))
    return fields


def _option(name: str, owners: list[tuple[str, FieldInfo]], more: str = "") -> inspect.Parameter:
    """Return a field's option, as a parameter with typer's annotation. `more` is added to the help.

    If the field differs between scenes, the help names the scenes.
    """
    texts = {described(field): owner for owner, field in owners}
    about = "; ".join(f"{owner}: {text}" if len(texts) > 1 else text for text, owner in texts.items()) + more
    flag = name.replace("_", "-")
    kind: Any  # a type that is composed here
    if owners[0][1].annotation is bool:
        kind, info = bool, typer.Option(f"--{flag}/--no-{flag}", help=about, rich_help_panel=_panel(name))
    else:
        several = any(_takes_several(field.annotation) for _, field in owners)
        about += "; can be repeated" if several else ""
        kind = list[str] if several else str
        info = typer.Option(f"--{flag}", help=about, metavar=name.upper(), rich_help_panel=_panel(name))
    # None: the user did not give it; for a movie, the spec then decides
    annotation = Annotated[kind | None, info]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def _panel(name: str) -> str:
    """Return the heading under which a field's option stands in the help."""
    if name in PARAMETERS and {*PAPER}.isdisjoint(USED_BY[name]):
        return OTHERS
    if name in (*PARAMETERS, "sheet", "window", "wavelength", "fresnel", "aperture"):
        return "The sheets"
    if name in Rendering.model_fields or name in ("view", "background"):
        return "The picture"
    return "The eye" if name in Scene.model_fields else "The objects"


def _takes_several(annotation: object) -> bool:
    """Whether a field's type allows a tuple of any length, or a table."""
    parts = get_args(annotation)
    if get_origin(annotation) is dict:
        return True
    return get_origin(annotation) is tuple and parts[-1] is ... or any(_takes_several(part) for part in parts)


def described(field: FieldInfo) -> str:
    """Return a field's help: its description and its default."""
    default = field.default
    if isinstance(default, tuple) and default:
        default = ",".join(f"{x:g}" for x in default)
    about = field.description or ""
    said = default in (None, False, "", (), {}, PydanticUndefined) or "(default" in about
    return about if said else f"{about} (default {default})"


def scene_of(name: str, values: Values) -> Scene:
    """Return the scene of this name with these values. Values can be text. Raises InputError."""
    if name not in SCENES:
        raise InputError(f"scene = {name!r}: unknown; allowed: {', '.join(SCENES)}")
    return SCENES[name](**values)


def again(source: Path, output: Path | None, values: Values, quiet: bool) -> "tuple[Record, list[Scene], Values]":
    """Return the record in a file, its scenes, and the values of its rendering.

    A value that the user gave replaces the record's, and also the record's values that depend on it. The bits follow
    from the output's ending if this is .exr, or if the record's picture has 32. Print a warning if another version of
    povgen or of the renderer made the file. Raises InputError if the file has no valid record.
    """
    record, scenes = recorded(source)
    options = record.rendering.model_dump()
    if options["bits"] == 32 or str(output).lower().endswith(".exr"):  # the bits then follow from the output's ending
        del options["bits"]
    if values.get("stereo", options["stereo"]) == "none":
        del options["eye_distance"]
    if "quality" in values:  # the quality then decides the size, unless the user gives a size
        del options["size"]
    if "quality" in values or values.get("sheet") == "auto":
        del options["antialias"]
    if not quiet and values.get("renderer", record.rendering.renderer) == record.rendering.renderer:
        here = __version__, drawn_by(record.rendering)
        if here != (record.povgen, record.renderer):
            made = f"made by povgen {record.povgen} and {record.renderer}, here are {' and '.join(here)}"
            say(f"povgen: warning: {source}: {made}: pixels can differ")
    return record, scenes, {**options, **values}


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


def auto_tolerance(values: Values, options: Values, tolerance: str | None) -> tuple[AutoTolerance | None, list[str]]:
    """Return the tolerance of --sheet auto and the renderers that it may choose; None and [] for another sheet.

    Remove --renderer auto from the options. Raises InputError if the tolerance is not valid, if only one of --sheet
    auto and --tolerance is given, or if --renderer auto is given without them.
    """
    if (values.get("sheet") == "auto") != (tolerance is not None):
        raise InputError("sheet = 'auto' and tolerance go together; allowed: both: --sheet auto --tolerance 1px")
    renderer = options.get("renderer", "povray")
    if tolerance is None:
        if renderer == "auto":
            raise InputError("renderer = 'auto': allowed: with --sheet auto, otherwise 'povray' or 'gl'")
        return None, []

    if renderer == "auto":
        del options["renderer"]
        return AutoTolerance.parse(tolerance), [*RENDERERS]
    return AutoTolerance.parse(tolerance), [renderer]


def chosen(
    scenes: list[Scene],
    options: Values,
    tolerance: AutoTolerance,
    renderers: list[str],
    quiet: bool,
    scheduler: str | None = None,
) -> tuple[str, str, str]:
    """Return what --sheet auto chooses for scenes with prisms: sheet, antialiasing and renderer. Print why.

    The scheduler does not take part in the choice. But if it does not answer, PovrayError is raised before anything is
    rendered. Raises what `auto.choose` raises.
    """
    if scheduler:
        from povgen.rendering.cluster import ask

        ask(scheduler)
    rendering = Rendering(**options)
    shown = [view for scene in scenes for view in views(scene, rendering)]
    choice, why = auto.choose(shown, rendering, tolerance, options.get("antialias"), renderers)
    if not quiet:
        say(f"povgen: {why}")
    return choice.sheet, choice.antialias, choice.renderer
