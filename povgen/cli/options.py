"""Options of the commands: options made from the fields of scenes and `Rendering`, and options of several commands."""

import inspect
import re
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin

import typer

from povgen.errors import InputError
from povgen.progress import say

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from povgen.model import Model
    from povgen.rendering.auto import Tolerance as AutoTolerance
    from povgen.scene.models import Scene

Command = Callable[..., None]
Values = dict[str, Any]  # what a user gave, by the parameters' names: texts, lists of texts, and Booleans of switches
SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="chess or spheres")]
Workers = Annotated[
    str | None,
    typer.Option(metavar="N", help="how many POV-Ray processes run at once, 1 to 256", show_default="8 for each core"),
]
Tolerance = Annotated[
    str | None,
    typer.Option(
        metavar="ERROR",
        help="largest error for --sheet auto: of positions (1px), of the picture (0.2flip), or both (1px,0.2flip)",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="print errors only")]


def takes(*models: str) -> Callable[[Command], Command]:
    """Mark a command that has an option for every field of these models: 'scenes' (all scenes) or 'rendering'.

    'sampling' is the part of 'rendering' that POV-Ray does without povgen: quality, size and antialias.

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
        try:
            command(**arguments, **given)
        except InputError as error:
            raise InputError(f"{error}{_repeat(str(error), repeated)}") from None

    own = [p for p in inspect.signature(command).parameters.values() if p.kind is not p.VAR_KEYWORD]
    auto = "; or auto: the cheapest within --tolerance" if any(p.name == "tolerance" for p in own) else ""
    parameters = [*own, *(_option(name, owners, auto if name == "sheet" else "") for name, owners in fields.items())]
    parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    called.__dict__["__signature__"] = inspect.Signature(parameters)
    called.__annotations__ = {p.name: p.annotation for p in parameters}
    # typer breaks lines as the terminal needs it, but also wherever the text has a line break
    called.__doc__ = "\n\n".join(" ".join(part.split()) for part in (command.__doc__ or "").split("\n\n"))
    return called


def _repeat(message: str, repeated: dict[str, list[str]]) -> str:
    """Return what to add to an error about an option that can be repeated, and that got several values at once."""
    for name, texts in repeated.items():
        if re.search(rf"\b{name} = ", message) and any(re.search("[,; ]", text) for text in texts):
            return f"; give --{name} once for each value"
    return ""


def _fields(models: tuple[str, ...]) -> dict[str, list[tuple[str, "FieldInfo"]]]:
    """Return, for each field name, the names of the scenes that have the field ('' for Rendering) and their fields."""
    from povgen.scene.models import SCENES
    from povgen.settings import Rendering, Sampling

    fields: dict[str, list[tuple[str, FieldInfo]]] = {}
    groups: dict[str, list[type[Model]]] = {
        "scenes": [*SCENES.values()],
        "sampling": [Sampling],
        "rendering": [Rendering],
    }
    for group in models:
        for model in groups[group]:
            for name, field in model.model_fields.items():
                fields.setdefault(name, []).append((getattr(model, "name", ""), field))
    return fields


def _option(name: str, owners: list[tuple[str, "FieldInfo"]], more: str = "") -> inspect.Parameter:
    """Return a field's option, as a parameter with typer's annotation. `more` is added to the help.

    If the field differs between scenes, the help names the scenes.
    """
    texts = {described(field): owner for owner, field in owners}
    about = "; ".join(f"{owner}: {text}" if len(texts) > 1 else text for text, owner in texts.items()) + more
    flag = name.replace("_", "-")
    kind: Any  # a type that is composed here
    if owners[0][1].annotation is bool:
        kind, info = bool, typer.Option(f"--{flag}/--no-{flag}", help=about)
    else:
        several = any(_takes_several(field.annotation) for _, field in owners)
        about += "; can be repeated" if several else ""
        kind, info = list[str] if several else str, typer.Option(f"--{flag}", help=about, metavar=name.upper())
    # None: the user did not give it; for a movie, the spec then decides
    annotation = Annotated[kind | None, info]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def _takes_several(annotation: object) -> bool:
    """Whether a field's type allows a tuple of any length, or a table."""
    parts = get_args(annotation)
    if get_origin(annotation) is dict:
        return True
    return get_origin(annotation) is tuple and parts[-1] is ... or any(_takes_several(part) for part in parts)


def described(field: "FieldInfo") -> str:
    """Return a field's help: its description and its default."""
    from pydantic_core import PydanticUndefined

    default = field.default
    if isinstance(default, tuple) and default:
        default = ",".join(f"{x:g}" for x in default)
    about = field.description or ""
    said = default in (None, False, (), {}, PydanticUndefined) or "(default" in about
    return about if said else f"{about} (default {default})"


def scene_of(name: str, values: Values) -> "Scene":
    """Return the scene of this name with these values. Values can be text. Raises InputError."""
    from povgen.scene.models import SCENES

    if name not in SCENES:
        raise InputError(f"scene = {name!r}: unknown; allowed: {', '.join(SCENES)}")
    return SCENES[name](**values)


def split(values: Values) -> tuple[Values, Values]:
    """Divide values into a scene's values and a rendering's values. Raises InputError for a value without use."""
    from povgen.settings import Rendering

    rendering = {name: value for name, value in values.items() if name in Rendering.model_fields}
    if "eye_distance" in rendering and rendering.get("stereo", "none") == "none":
        raise InputError(
            f"eye_distance = {rendering['eye_distance']}: one eye has no distance; allowed: with stereo = pair or "
            "anaglyph"
        )
    return {name: value for name, value in values.items() if name not in rendering}, rendering


def made_folder(output: Path) -> AbstractContextManager[Path]:
    """Make the folder for a command's output, as files.output_folder does. Call this when other values were checked."""
    from povgen.files import output_folder
    from povgen.rendering import cache

    cache.check()
    return output_folder(output)


def auto_tolerance(values: Values, tolerance: str | None) -> "AutoTolerance | None":
    """Return the tolerance of --sheet auto, or None for another sheet.

    Raises InputError if the tolerance is not valid, or if only one of --sheet auto and --tolerance is given.
    """
    if (values.get("sheet") == "auto") != (tolerance is not None):
        raise InputError("sheet = 'auto' and tolerance go together; allowed: both: --sheet auto --tolerance 1px")
    if tolerance is None:
        return None
    from povgen.rendering.auto import Tolerance

    return Tolerance.parse(tolerance)


def chosen(scenes: list["Scene"], options: Values, tolerance: "AutoTolerance", quiet: bool) -> tuple[str, str]:
    """Return the sheet and the antialiasing that --sheet auto chooses for scenes with prisms, and print why."""
    from povgen.rendering import auto
    from povgen.rendering.views import views
    from povgen.settings import Rendering

    rendering = Rendering(**options)
    shown = [view for scene in scenes for view in views(scene, rendering)]
    choice, why = auto.choose(shown, rendering, tolerance, options.get("antialias"))
    if not quiet:
        say(f"povgen: {why}")
    return choice.sheet, choice.antialias
