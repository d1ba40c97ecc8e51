"""Errors that are not faults of povgen, and the text of their messages."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:  # slow to load
    from pydantic import BaseModel

Model = TypeVar("Model", bound="BaseModel")


class InputError(ValueError):
    """A value that the user gave is not allowed. The message names it and says what is allowed."""


class PovrayError(RuntimeError):
    """POV-Ray is missing, failed, was killed or took too long. The message says which, and where."""

    line: int | None = None  # in the scene's text, counted from 1, if POV-Ray named one


class TransientError(PovrayError):
    """POV-Ray was killed or took too long. Another frame, or another try, may succeed."""


def validated(model: type[Model], values: dict[str, Any]) -> Model:
    """Return a model made from values that a user gave; each may be text.

    Raises InputError with one line about the first value that is not allowed.
    """
    from pydantic import ValidationError

    for name, value in values.items():
        field = model.model_fields.get(name)
        parts = value if isinstance(value, (list, tuple)) else [value]
        # pydantic would read it as 0 or 1
        if field and field.annotation is not bool and any(isinstance(part, bool) for part in parts):
            raise InputError(f"{name} = {shown(value)}: should not be true or false ({field.description})")
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise InputError(_message(model, values, error.errors()[0])) from None


def _message(model: "type[BaseModel]", values: dict[str, Any], fault: Mapping[str, Any]) -> str:
    """Return the message for one of pydantic's errors."""
    message = str(fault["msg"]).removeprefix("Value error, ").removeprefix("Input ")
    if not fault["loc"]:  # a check of several values together; its message names them
        return message
    name = str(fault["loc"][0])
    if fault["type"] == "extra_forbidden":
        return f"{shown(name)}: unknown; allowed: {', '.join(model.model_fields)}"
    if fault["type"] == "missing":  # a part of the value is missing
        message = "has too few parts"
    about = model.model_fields[name].description
    if name not in values:
        return f"{name}: missing ({about})"
    return f"{name} = {shown(values[name])}: {message} ({about})"


def shown(value: object) -> str:
    """Return a value as text for a message: one line of at most 60 characters."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # a number with thousands of digits, or thousands of nested tables
        return f"a very long {type(value).__name__}"
    return text if len(text) <= 60 else text[:57] + "..."
