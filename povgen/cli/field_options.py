"""A command of the command line: its options from the fields of models, how it is run, and the layout of its help."""

import logging
import os
import re
from collections.abc import Callable, Iterable
from itertools import chain
from typing import Any, TypeVar, get_args, get_origin

import click
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from povgen.errors import InputError
from povgen.inputs import mesh
from povgen.scene.eye_and_windows import EyeAndWindows
from povgen.scene.presets import SCENES
from povgen.scene.room import Room
from povgen.settings import Print, Rendering, Sampling
from povgen.sheets import PAPER, PARAMETERS, USED_BY
from povgen.validation import Model

F = TypeVar("F", bound=Callable[..., Any])
OTHERS = "Parameters of other sheets, which povgen list explains"
NAMES = 16  # characters of the column with the names of options, in a help
AUTO = {
    "sheet": "; or auto: the cheapest within --tolerance",
    "renderer": "; or auto, with --sheet auto: the cheapest within --tolerance",
}


class FieldOption(click.Option):
    """An option for a field of a model. Its value is text, which the model checks; a switch is --x or --no-x."""

    def __init__(self, name: str, owners: list[tuple[str, FieldInfo]], more: str) -> None:
        """Make the option of a field, with the scenes that have it. `more` is added to the help.

        If the field differs between scenes, the help names the scenes.
        """
        texts: dict[str, list[str]] = {}
        for owner, field in owners:
            texts.setdefault(described(field), []).append(owner)
        named = len(texts) > 1
        about = "; ".join(f"{', '.join(who)}: {text}" if named else text for text, who in texts.items()) + more
        flag, kind = name.replace("_", "-"), owners[0][1].annotation
        several = any(_takes_several(field.annotation) for _, field in owners)
        super().__init__(
            [f"--{flag}/--no-{flag}" if kind is bool else f"--{flag}", name],
            default=None,  # the user did not give it; for a movie, the spec then decides
            type=bool if kind is bool else str,
            multiple=several,
            help=about + "; can be repeated" * several,
            metavar=None if kind is bool else name.upper(),
        )
        self.group = _group(name)

    def get_help_record(self, context: click.Context) -> tuple[str, str]:  # noqa: ARG002  (as click declares it)
        return self.opts[0], re.sub(r"\(default ([^)]*)\)", r"[\1]", str(self.help))


class Command(click.Command):
    """A command whose function gets, in its **values, what the user gives for fields of models: text and Booleans."""

    def __init__(self, *names: Any, **more: Any) -> None:  # noqa: ANN401  (as click declares it)
        super().__init__(*names, **more)
        self.context_settings = {"help_option_names": ["-h", "--help"], "max_content_width": 120}

    def invoke(self, context: click.Context) -> Any:  # noqa: ANN401  (as click declares it)
        """Call the command's function, without warnings if --quiet is given."""
        given = context.params
        repeated = {name: value for name, value in given.items() if isinstance(value, tuple) and value}
        for field in (parameter for parameter in self.params if isinstance(parameter, FieldOption)):
            value = given.pop(str(field.name))
            if value not in (None, ()):
                given[str(field.name)] = value[0] if isinstance(value, tuple) and len(value) == 1 else value
        logger = logging.getLogger("povgen")
        level = logger.level
        try:
            logger.setLevel("ERROR" if given.get("quiet") else level)
            return super().invoke(context)
        except InputError as error:
            raise InputError(f"{error}{_repeat(str(error), repeated)}") from None
        finally:
            logger.setLevel(level)

    def format_options(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, under headings."""
        groups: dict[str, list[tuple[str, str]]] = {"Options": []}
        for param in self.get_params(context):
            if isinstance(param, click.Option) and (record := param.get_help_record(context)):
                groups.setdefault(getattr(param, "group", "Options"), []).append(record)
        for group, rows in groups.items():
            with formatter.section(group):
                if group == OTHERS:
                    formatter.write_text(" ".join(name for name, _ in rows))
                else:
                    formatter.write_dl(rows, NAMES)
        if "The picture" in groups:
            formatter.write_paragraph()
            formatter.write_text("In brackets: the defaults. The opposite of a switch: --no-overlay.")


def fields(*models: str, auto: bool = False) -> Callable[[F], F]:
    """Add an option for every field of these models: 'scenes' (all scenes), 'rendering', 'sampling', 'print'.

    'sampling' is the part of 'rendering' that also has an effect if a user starts POV-Ray: quality, size and antialias.
    `auto` adds to the help what --sheet and --renderer take beside their values.
    """
    groups: dict[str, Iterable[type[Model]]] = {
        "scenes": SCENES.values(),
        "sampling": [Sampling],
        "rendering": [Rendering],
        "print": [Print],
    }
    found: dict[str, list[tuple[str, FieldInfo]]] = {}
    for model in chain.from_iterable(groups[group] for group in models):
        for name, field in model.model_fields.items():
            found.setdefault(name, []).append((getattr(model, "name", ""), field))

    def add(function: F) -> F:
        options = [FieldOption(name, owners, AUTO.get(name, "") * auto) for name, owners in found.items()]
        function.__dict__.setdefault("__click_params__", []).extend(reversed(options))  # as click's own decorators
        return function

    return add


def _repeat(message: str, repeated: dict[str, tuple[str, ...]]) -> str:
    """Return what to add to an error about an option that can be repeated, and that got several values at once."""
    for name, texts in repeated.items():
        several = (x for x in texts if re.search("[,; ]", x) and not os.path.exists(x) and not mesh.split(x))
        is_table = name in Room.model_fields  # its text has commas
        if not is_table and re.search(rf"\b{name} = ", message) and any(several):
            return f"; give --{name} once for each value"
    return ""


def _group(name: str) -> str:
    """Return the heading under which a field's option stands in the help."""
    if name in PARAMETERS and {*PAPER}.isdisjoint(USED_BY[name]):
        return OTHERS
    if name in (*PARAMETERS, "sheet", "window", "wavelength", "fresnel", "aperture"):
        return "The sheets"
    if name in (*Rendering.model_fields, *Print.model_fields, "view", "background", "sky"):
        return "The picture"
    return "The eye" if name in EyeAndWindows.model_fields else "The objects"


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
    said = default in (None, False, "", (), {}, PydanticUndefined) or "(default" in about or isinstance(default, Model)
    return about if said else f"{about} (default {default})"
