"""What can go wrong through no fault of the program, and how it is put to the user."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:  # slow to load
    from pydantic import BaseModel

Model = TypeVar("Model", bound="BaseModel")


class InputError(ValueError):
    """Something that the user gave cannot be: the message names it, its value and what is allowed."""


class PovrayError(RuntimeError):
    """POV-Ray is missing, failed, was killed or took too long: the message tells which, and where."""

    line: int | None = None  # of the scene's text, from 1 on, where POV-Ray named one


class TransientError(PovrayError):
    """POV-Ray was killed or took too long: a fault that another frame, or another try, need not have."""


def validated(model: type[Model], values: dict[str, Any]) -> Model:
    """The model made of values that a user gave, which may be text.

    Raises InputError with one line for the first value that cannot be.
    """
    from pydantic import ValidationError

    for name, value in values.items():
        field = model.model_fields.get(name)
        parts = value if isinstance(value, (list, tuple)) else [value]
        # pydantic would take it for 0 or 1
        if field and field.annotation is not bool and any(isinstance(part, bool) for part in parts):
            raise InputError(f"{name} = {shown(value)}: should not be true or false ({field.description})")
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise InputError(_line(model, values, error.errors()[0])) from None


def _line(model: "type[BaseModel]", values: dict[str, Any], fault: Mapping[str, Any]) -> str:
    message = fault["msg"].removeprefix("Value error, ").removeprefix("Input ")
    if not fault["loc"]:  # a check of several values together, which names them itself
        return message
    name = str(fault["loc"][0])
    if fault["type"] == "extra_forbidden":
        return f"{shown(name)}: unknown; allowed: {', '.join(model.model_fields)}"
    if fault["type"] == "missing":  # a part of the value
        message = "has too few parts"
    about = model.model_fields[name].description
    if name not in values:
        return f"{name}: missing ({about})"
    return f"{name} = {shown(values[name])}: {message} ({about})"


def shown(value: Any) -> str:
    """What a user gave, for a message: in one line, and a short one."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # a number of thousands of digits, thousands of tables in each other
        return f"a very long {type(value).__name__}"
    return text if len(text) <= 60 else text[:57] + "..."
