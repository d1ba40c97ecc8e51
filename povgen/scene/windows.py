"""The parameters of sheets, as fields for pydantic. Those of the first window are fields of the scene.

Those of each further window are fields of a `Window`. A `Window` can be given as text: `z=2,sheet=mirror`.
"""

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Annotated, Any, Generic, Literal, NamedTuple, Never, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field, create_model

from povgen.optics.glasses import named
from povgen.sheets import PAPER, PARAMETERS, SHEETS
from povgen.sheets.profile import NAMES, ProfileFile, as_profile
from povgen.sheets.sheet import Parameter, Sheet
from povgen.validation import Model, as_pair, has_boolean

MAX_WINDOWS = 5
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

    If `first`, they are the fields of a scene, for its first window. Otherwise they are the fields of a `Window`. There
    the default is None, which stands for the first window's value.
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

    class _OfWindow(_Parameters[None]): ...

    class ParametersOfSheets(_Parameters[Never]): ...

else:
    _OfWindow = create_model("_OfWindow", __base__=Model, **_fields(first=False))
    ParametersOfSheets = create_model("ParametersOfSheets", __base__=Model, **_fields(first=True))


class Window(_OfWindow):
    """A window behind the first one, and parallel to it. Its size and its frame are those of the first.

    If a parameter of its sheet is not given, the first window's value is used.
    """

    z: Annotated[float, Field(gt=0, le=100)] = Field(
        description="distance from the first window, tiles: greater than 0, at most 100"
    )
    sheet: SheetName | None = Field(default=None, description="kind of its sheet (default: the first window's)")

    def _replaced_by(self, changes: dict[str, object]) -> set[str]:
        return replaced_by(changes)


def has_glass(window: Any) -> bool:  # noqa: ANN401  (a scene, for its first window, or a Window)
    """Return whether the parameters of a window name the prisms' glass."""
    return window.glass not in (None, "none")


def replaced_by(changes: Mapping[str, object], windows: Iterable[Window] = ()) -> set[str]:
    """Return the names of the values that new ones replace. A new glass replaces the index.

    A new index, or the glass "none", replaces the glass. It also replaces the wavelengths of the light and of the
    design, unless one of these further windows has a glass.
    """
    glass = changes.get("glass")
    if isinstance(glass, str) and glass != "none":
        return {"index"}
    if glass is None and changes.get("index") is None:
        return set()
    return {"glass"} if any(map(has_glass, windows)) else {"glass", "wavelength", "design_wavelength"}


class Placed(NamedTuple):
    """A window: where it is, and the sheet in it."""

    z: float  # of its middle plane, tiles behind that of the first window; of a pair, a sheet is on each side of it
    sheet: Sheet


def window_table(value: object) -> object:
    """Return a window's text, such as 'alpha=120,z=2', as a table.

    A part between commas that has no = belongs to the part before it, such as a component of a direction. The table's
    values are texts. Only a parameter that is a table may occur several times. Its value is then a list of texts.
    If `value` is no text, it is returned as it is. Raises ValueError for text of another form.
    """
    if isinstance(value, str):
        parts: list[str] = []
        for part in value.split(","):
            if "=" in part or not parts:
                parts.append(part)
            else:
                parts[-1] += f",{part}"
        pairs = [part.partition("=") for part in parts]
        values: dict[str, list[str]] = {}
        for name, _, given in pairs:
            values.setdefault(name.strip().replace("-", "_"), []).append(given)
        repeated = [name for name, several in values.items() if len(several) > 1 and name not in TABLES]
        if repeated or not all(equals for _, equals, _ in pairs):
            raise ValueError("should be text such as alpha=120,z=2")
        return {name: several if len(several) > 1 else several[0] for name, several in values.items()}
    return value


def _window(value: object) -> object:
    value = window_table(value)
    return Window(**value) if isinstance(value, Mapping) else value


def _windows(value: object) -> object:
    """Accept a single window in place of a list of windows."""
    return [value] if isinstance(value, (str, Mapping, Window)) else value


WINDOW = (
    "a window behind the first one, such as alpha=120,z=2. z: its distance from the first window, tiles. Further "
    "keys: sheet, and its parameters; the first window's value is the default. "
    f"Can be given up to {MAX_WINDOWS - 1} times, in order of z"
)
if TYPE_CHECKING:  # read as windows; a user may give anything that becomes such a tuple
    Windows = tuple[Window, ...] | Any
else:
    Windows = Annotated[
        tuple[Annotated[Window, BeforeValidator(_window)], ...],
        Field(max_length=MAX_WINDOWS - 1),
        BeforeValidator(_windows),
    ]


class _Windows(Model):
    window: Windows = Field(description=WINDOW)


def as_windows(value: object) -> list[Window]:
    """Return the windows that a scene's parameter `window` states. Raises InputError."""
    return list(_Windows(window=value).window)
