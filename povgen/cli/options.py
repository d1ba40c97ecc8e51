"""What options commands take: those that follow from the models' fields, and those that several commands share."""

import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from povgen.cli.report import say
from povgen.errors import InputError, validated

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from povgen.scene.models import Scene

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="chess or spheres")]
Workers = Annotated[
    str | None,
    typer.Option(metavar="N", help="POV-Ray processes at once, 1 to 256", show_default="enough to keep the cores busy"),
]
Tolerance = Annotated[
    str | None,
    typer.Option(metavar="ERROR", help="for --sheet auto: 1px (of position), 0.2flip (of the picture), or 1px,0.2flip"),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="print errors only")]


def takes(*models: str) -> Callable[[Callable], Callable]:
    """Mark a command that takes, in its **values, an option for every field of the models.

    'scenes' stands for all scenes, 'rendering' for Rendering. The command gets a dictionary of what was given.
    """

    def mark(command: Callable) -> Callable:
        command.__dict__["models"] = models
        return command

    return mark


def with_options(command: Callable) -> Callable:
    """The command as typer reads it: with an option for every field of the models that it `takes`.

    A field is given as text, or as --x and --no-x. The models are slow to load: this is for a command that is run.
    """
    fields = _fields(command.__dict__.get("models", ()))

    def called(**arguments):
        given = {name: arguments.pop(name) for name in fields}
        if given.get("z1") and len(given["z1"]) == 1:
            given["z1"] = given["z1"][0]
        given = {name: value for name, value in given.items() if value not in (None, [])}
        return command(**arguments, **given)

    own = [p for p in inspect.signature(command).parameters.values() if p.kind is not p.VAR_KEYWORD]
    parameters = [*own, *(_option(name, owners) for name, owners in fields.items())]
    parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    called.__dict__["__signature__"] = inspect.Signature(parameters)
    called.__annotations__ = {p.name: p.annotation for p in parameters}
    called.__doc__ = command.__doc__
    return called


def _fields(models: tuple[str, ...]) -> dict[str, list[tuple[str, "FieldInfo"]]]:
    """Every field's name, with the names of the scenes that have it ('' for Rendering) and what it is in each."""
    from povgen.scene.models import SCENES
    from povgen.settings import Rendering

    fields: dict[str, list] = {}
    named = {"scenes": SCENES.values(), "rendering": [Rendering]}
    for model in [model for name in models for model in named[name]]:
        for name, field in model.model_fields.items():
            fields.setdefault(name, []).append((getattr(model, "name", ""), field))
    return fields


def _option(name: str, owners: list[tuple[str, "FieldInfo"]]) -> inspect.Parameter:
    texts = {_about(field): owner for owner, field in owners}
    about = " ".join(f"{owner}: {text}." if len(texts) > 1 else text for text, owner in texts.items())
    flag = name.replace("_", "-")
    kind: Any
    if owners[0][1].annotation is bool:
        kind, info = bool, typer.Option(f"--{flag}/--no-{flag}", help=about)
    else:
        # the spheres' scene takes several z1
        kind, info = list[str] if name == "z1" else str, typer.Option(f"--{flag}", help=about, metavar=name.upper())
    # None: not given, so that a movie's spec decides
    annotation = Annotated[kind | None, info]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def _about(field: "FieldInfo") -> str:
    from pydantic_core import PydanticUndefined

    default = field.default
    if isinstance(default, tuple):
        default = ",".join(f"{x:g}" for x in default)
    about = field.description or ""
    return about if default in (None, False, PydanticUndefined) else f"{about} (default {default})"


def scene_of(name: str, values: dict[str, Any]) -> "Scene":
    """The scene of a name, with values as text. Raises InputError."""
    from povgen.scene.models import SCENES

    if name not in SCENES:
        raise InputError(f"scene = {name!r}: unknown; allowed: {', '.join(SCENES)}")
    return validated(SCENES[name], values)


def split(values: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The values of the scene and those of the rendering."""
    from povgen.settings import Rendering

    rendering = {name: values.pop(name) for name in Rendering.model_fields if name in values}
    return values, rendering


def worker_count(text: str | None) -> int | None:
    """How many POV-Rays run at once. Raises InputError."""
    if text is None:
        return None
    if not re.fullmatch("[0-9]{1,9}", text) or not 1 <= int(text) <= 256:
        raise InputError(f"workers = {text!r}: allowed: a whole number from 1 to 256")
    return int(text)


def made_folder(output: Path) -> Path:
    """A folder that is made, when there is nothing left to refuse."""
    from povgen.files import checked_folder
    from povgen.rendering import cache

    cache.check()
    return checked_folder(output)


def chosen_sheet(
    values: dict[str, Any],
    options: dict[str, Any],
    tolerance: str | None,
    quiet: bool,
    scenes: Callable[[dict[str, Any], str], list["Scene"]],
) -> dict[str, str]:
    """The sheet in place of 'auto', if that is what was given; puts the antialiasing chosen into the options."""
    if (values.get("sheet") == "auto") != (tolerance is not None):
        raise InputError("sheet = 'auto' and tolerance go together; allowed: both, as --sheet auto --tolerance 1px")
    if tolerance is None:
        return {}
    from povgen.measure import auto
    from povgen.settings import Rendering

    limit = auto.Tolerance.parse(tolerance)
    rendering = validated(Rendering, options)
    through = scenes(values | {"sheet": "detailed"}, rendering.quality)
    chosen, why = auto.choose(through, rendering, limit, options.get("antialias"))
    if not quiet:
        say(f"povgen: {why}")
    options["antialias"] = chosen.antialias
    return {"sheet": chosen.sheet}
