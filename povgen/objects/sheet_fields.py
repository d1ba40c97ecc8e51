"""The parameters of sheets, as fields for pydantic: of a window that states all, or of one that may leave some out."""

from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING, Annotated, Any, Generic, Literal, Never, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field, create_model

from povgen.optics.glasses import named
from povgen.sheets import PAPER, PARAMETERS, SHEETS
from povgen.sheets.profile import NAMES, ProfileFile, as_profile
from povgen.sheets.sheet import Parameter
from povgen.validation import Model, as_pair, has_boolean

TABLES = {name for name, (parameter, *_) in PARAMETERS.items() if parameter.kind == "table"}


def as_table(value: object) -> object:
    """Return a text such as 'k=0.3', or several, as a table whose values are text. Return other values as they are.

    Raises ValueError for text of another form, for a name that occurs twice, and for a table with a Boolean value.
    """
    if isinstance(value, Mapping) and has_boolean(value.values()):
        raise ValueError("should be a table of numbers")
    texts = [value] if isinstance(value, str) else value
    if not isinstance(texts, (list, tuple)):
        return value
    parts = [text.partition("=") if isinstance(text, str) else ("", "", "") for text in texts]
    if not all(equals for _, equals, _ in parts):
        raise ValueError("should be text such as k=0.3")
    table = {name.strip(): number for name, _, number in parts}
    if len(table) < len(parts):
        raise ValueError("should have each name once")
    return table


def _checked_size(parameter: Parameter) -> AfterValidator:
    """Return a check that a number, or the largest component of a direction, is not too close to 0."""

    def check(value: Any) -> Any:  # noqa: ANN401  (a number or a direction)
        if max(abs(x) for x in (value if isinstance(value, tuple) else [value])) < parameter.size:
            raise ValueError("too short" if parameter.kind == "direction" else "too close to 0")
        return value

    return AfterValidator(check)


def _as_glass(value: object) -> object:
    """Return the name of a glass as povgen writes it. Raises ValueError for an unknown name."""
    return named(value) if isinstance(value, str) and value != "none" else value


def _annotation(parameter: Parameter) -> Any:  # noqa: ANN401  (a type that is composed here)
    """Return the type of a sheet's parameter, for pydantic."""
    bounds = Field(ge=parameter.least, le=parameter.most)
    number = Annotated[float, bounds]
    match parameter.kind:
        case "direction":
            return Annotated[tuple[number, number, number], BeforeValidator(as_pair), _checked_size(parameter)]
        case "choice":
            return Literal[parameter.choices]
        case "glass":
            return Annotated[Literal[parameter.choices], BeforeValidator(_as_glass)]
        case "text":
            return str
        case "profile":
            return Annotated[Literal[NAMES] | ProfileFile, BeforeValidator(as_profile)]
        case "table":
            names = Literal[parameter.choices] if parameter.choices else str
            return Annotated[dict[names, number], BeforeValidator(as_table)]  # type: ignore[valid-type]
        case "whole number":
            return Annotated[int, bounds]
    return Annotated[number, _checked_size(parameter)] if parameter.size else number


def _fields(first: bool) -> dict[str, Any]:
    """Return the fields for the parameters of all kinds of sheets.

    If `first`, they are the fields of a scene, for its first window. Otherwise they are the fields of a
    `FurtherWindow`. There the default is None, which stands for the first window's value.
    """
    found: dict[str, Any] = {}
    for name, several in PARAMETERS.items():
        kinds: dict[str, list[str]] = {}
        for kind in SHEETS.values():
            for text in (each.text for each in kind.parameters if each.name == name):
                kinds.setdefault(text, []).append(kind.name)
        # A description has the form "NAME, NAME: text; NAME: text", with the names of the kinds of sheets. If all kinds
        # have the same text, and one of them is in the paper, the names are left out.
        plain = len(kinds) == 1 and not {*PAPER}.isdisjoint(*kinds.values())
        about = "; ".join(text if plain else f"{', '.join(names)}: {text}" for text, names in kinds.items())
        annotation, default = _annotation(several[0]), several[0].default
        found[name] = (
            (annotation, Field(default=default, description=about))
            if first
            else (annotation | None, Field(default=None, description=about))
        )
    return found


if TYPE_CHECKING:  # mypy accepts only a Literal with values that are written out
    SheetName = str
else:
    SheetName = Literal[tuple(SHEETS)]
if TYPE_CHECKING:
    # The sheets' parameters, for type checkers: at run time `_fields` makes them from PARAMETERS. A value that a window
    # behind the first one does not state is Absent: None.
    Absent = TypeVar("Absent")
    _default: Any = None

    class _Parameters(Model, Generic[Absent]):
        alpha: float | Absent = _default
        prisms: int | Absent = _default
        index: float | Absent = _default
        glass: str | Absent = _default
        design_wavelength: float | Absent = _default
        base_angle: float | Absent = _default
        gap: float | Absent = _default
        aspect: float | Absent = _default
        tops: str | Absent = _default
        error: dict[str, float] | Absent = _default
        axis: tuple[float, float, float] | Any = _default
        focal_length: float | Absent = _default
        object_focal_length: float | Absent = _default
        law: str | Absent = _default
        parameter: dict[str, float] | Absent = _default
        ratio: float | Absent = _default
        lenses: int | Absent = _default
        f_number: float | Absent = _default
        profile: str | PathLike[str] | ProfileFile | Absent = _default
        periods: int | Absent = _default
        arrangement: str | Absent = _default
        twist: float | Absent = _default
        view_distance: float | Absent = _default

    class FurtherParameters(_Parameters[None]): ...

    class ParametersOfSheets(_Parameters[Never]): ...

else:
    FurtherParameters = create_model("FurtherParameters", __base__=Model, **_fields(first=False))
    ParametersOfSheets = create_model("ParametersOfSheets", __base__=Model, **_fields(first=True))
