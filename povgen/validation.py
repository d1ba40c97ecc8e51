"""The base class of scenes and settings. It checks values, writes the one-line error, and fills help()."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Set
from contextlib import contextmanager
from difflib import get_close_matches
from inspect import Parameter, Signature, cleandoc
from numbers import Complex, Real
from typing import Any, Self, TypeGuard, get_type_hints

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from povgen.errors import InputError, shown

# povgen's words for those of pydantic's errors whose own words are Python's
WORDS = {
    "missing": "has too few parts",
    "too_short": "should have at least {min_length} values",
    "too_long": "should have at most {max_length} values",
    "tuple_type": "should be a list",
    "string_pattern_mismatch": "is not allowed",
    **dict.fromkeys(("dict_type", "model_type"), "should be a table"),
    **dict.fromkeys(("float_parsing", "float_type"), "should be a number"),
    **dict.fromkeys(("int_parsing", "int_parsing_size", "int_type", "int_from_float"), "should be a whole number"),
    **dict.fromkeys(("bool_parsing", "bool_type"), "should be true or false"),
}

HIDDEN = {name for name in dir(BaseModel) if not name.startswith("_")} - {"model_dump"}


class Model(BaseModel):
    """Values that a user gave. They never change; variants are copies.

    Values may be text. A value that is not allowed raises InputError, with one line about the first such value.
    """

    # defer_build: a class is made ready when its first model is made, and many never have one
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)

    def __init__(self, /, *unnamed: object, **values: object) -> None:
        if unnamed:
            raise InputError(f"{shown(unnamed[0])}: a value without a name; allowed: NAME=VALUE, as in help()")
        with _errors(type(self), values):
            super().__init__(**values)

    def __setattr__(self, name: str, value: object) -> None:
        raise InputError(f"{name} = {shown(value)}: values never change; allowed: a copy, .replace({name}=...)")

    def __repr_args__(self) -> Iterator[tuple[str, object]]:
        """Yield what repr() shows: the values that were given and differ from the defaults."""
        for name, field in type(self).model_fields.items():
            if name in self.model_fields_set and (value := getattr(self, name)) != field.default:
                yield name, value

    __str__ = BaseModel.__repr__

    def __dir__(self) -> list[str]:
        """Return the names that a notebook proposes: povgen's own, without those of pydantic."""
        return sorted({*super().__dir__()} - HIDDEN)

    def __iter__(self) -> Iterator[tuple[str, Any]]:  # type: ignore[override]
        """Return an iterator over the fields' names and values. The class makes an equal model from dict(model)."""
        return ((name, getattr(self, name)) for name in type(self).model_fields)

    def __hash__(self) -> int:
        return hash((type(self), *(hashable(getattr(self, name)) for name in type(self).model_fields)))

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy: with an update, what `replace` returns. Raises InputError."""
        return self.replace(**update) if update else super().model_copy(deep=deep)

    def replace(self, /, *unnamed: object, **changes: object) -> Self:
        """Return a copy with these values changed. Raises InputError if the copy is not allowed.

        In scenes and windows, a new glass replaces the index, and a new index the glass. A scene's new index also
        replaces the wavelengths of light and design, unless a further window has a glass.
        """
        given = {name: getattr(self, name) for name in self.model_fields_set - self._replaced_by(changes)}
        return type(self)(*unnamed, **{**given, **changes})

    def _replaced_by(self, changes: dict[str, object]) -> set[str]:  # noqa: ARG002
        """Return the names of the values that changes of other names replace."""
        return set()

    @classmethod
    def __pydantic_init_subclass__(cls, **_: object) -> None:
        """Describe the parameters in the class's docstring and signature, for help() and editors."""
        fields = cls.model_fields
        about = []
        for name, field in fields.items():
            text = field.description or ""
            default = "" if field.is_required() or "(default" in text else f" = {field.default!r}"
            about.append(f"- `{name}{default}`: {text}")
        own = cleandoc(cls.__dict__.get("__doc__") or "")
        cls.__doc__ = "\n".join([own, "", "Parameters:", "", *about]) if about else own
        cls._sign()

    @classmethod
    def model_rebuild(cls, **options: Any) -> bool | None:  # noqa: ANN401  (as pydantic declares it)
        """Make the class ready, as pydantic does when the first model is made: pydantic then signs the class anew."""
        made = super().model_rebuild(**options)
        cls._sign()
        return made

    @classmethod
    def _sign(cls) -> None:
        cls.__signature__ = _TypedSignature()  # type: ignore[assignment]


class _TypedSignature:
    """The signature of a class of models, with types, without their ranges. It is made when it is read, for help()."""

    def __get__(self, _: Model | None, owner: type[Model]) -> Signature:
        kinds = get_type_hints(owner)
        return Signature(
            [
                Parameter(
                    name,
                    Parameter.KEYWORD_ONLY,
                    default=Parameter.empty if field.is_required() else field.default,
                    annotation=kinds[name],
                )
                for name, field in owner.model_fields.items()
            ]
        )


def hashable(value: object) -> object:
    """Return something that has a hash, and is equal for equal values. A table's values without a hash are left out."""
    if isinstance(value, Mapping):
        return frozenset((name, x) for name, x in value.items() if isinstance(x, (Real, str)))
    return tuple(map(hashable, value)) if isinstance(value, (list, tuple)) else value


def is_several(value: object) -> TypeGuard[Iterable[Any]]:
    """Return whether a value can contain several scenes: it is iterable, but no text, no model and no single number."""
    one = isinstance(value, (str, bytes, Model)) or getattr(value, "ndim", 1) == 0  # numpy's array of one value
    return isinstance(value, Iterable) and not one


def as_pair(value: object) -> object:
    """Return text such as 'X,Y' as a list of texts, a complex number as two numbers, and other values as they are."""
    if isinstance(value, Complex) and not isinstance(value, Real):
        return value.real, value.imag
    return value.split(",") if isinstance(value, str) else value


@contextmanager
def _errors(model: type[BaseModel], values: Mapping[str, object] = {}) -> Iterator[None]:
    """Raise InputError in place of pydantic's error, and for what pydantic would silently convert."""
    for name, value in values.items():
        if field := model.model_fields.get(name):
            wrong = ""
            if field.annotation is not bool and has_boolean(value):  # pydantic would read it as 0 or 1
                wrong = "should not be true or false"
            elif any(isinstance(part, Set) for part in _parts(value)):
                wrong = "should be in order: a list, not a set"
            if wrong:
                raise InputError(f"{name} = {shown(value)}: {wrong} ({field.description})")
    try:
        yield
    except ValidationError as error:
        raise InputError(_message(model, values, error.errors()[0])) from None


def has_boolean(value: object) -> bool:
    """Return whether a value is a Boolean, or a list with one. Tables are not searched."""
    return any(isinstance(part, bool) for part in _parts(value))


def _parts(value: object, depth: int = 2) -> Iterator[object]:
    """Yield a value, and of a list its parts too, nested at most `depth` deep. Tables are not searched."""
    value = value.tolist() if hasattr(value, "tolist") else value  # numpy's
    yield value
    if depth and isinstance(value, Collection) and not isinstance(value, (str, bytes, Mapping)):
        for part in value:
            yield from _parts(part, depth - 1)


def as_flag(name: str, value: object) -> bool:
    """Return a value that is true or false. Raises InputError for any other, such as the text 'no'."""
    if not isinstance(value, bool):
        raise InputError(f"{name} = {shown(value)}: should be true or false")
    return value


def _message(model: type[BaseModel], values: Mapping[str, object], fault: ErrorDetails) -> str:
    """Return the message for one of pydantic's errors."""
    message = fault["msg"].removeprefix("Value error, ").removeprefix("Input ")
    if not fault["loc"]:  # no values at all, or a check of several values together, whose message names them
        return message if fault["type"] == "value_error" else f"{shown(fault['input'])}: {message}"
    if words := WORDS.get(fault["type"]):
        message = words.format(**fault.get("ctx", {}))
    name = str(fault["loc"][0])
    if fault["type"] == "extra_forbidden":
        where = f" in the scene {model.name}" if hasattr(model, "name") else ""  # another scene may have it
        near = get_close_matches(name[:50], model.model_fields, 1, 0.7)
        allowed = f"did you mean {near[0]}?" if near else f"allowed: {', '.join(model.model_fields)}"
        return f"{shown(name)}: unknown{where}; {allowed}"
    about = model.model_fields[name].description or ""
    if fault["type"] == "literal_error" and len(fault["loc"]) == 1:
        choices = re.findall("'([^']+)'", fault["ctx"]["expected"])
        if choices and all(choice in about for choice in choices):
            message = "unknown"  # the description lists the choices
    if name not in values:
        return f"{name}: missing ({about})"
    several = any(isinstance(part, int) for part in fault["loc"][1:]) and fault["input"] is not values[name]
    if isinstance(fault.get("ctx", {}).get("error"), InputError):  # of a model in the model: it says what is allowed
        return f"{name} = {shown(fault['input'] if several else values[name])}: {message}"
    if several and fault["type"] != "missing" and not isinstance(fault["input"], dict):
        message = f"{shown(fault['input'])} {message}"  # which of the values
    return f"{name} = {shown(values[name])}: {message} ({about})"
