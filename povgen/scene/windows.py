"""The windows behind the first one of `Chess` and `Spheres`. One can be given as text: `z=2,sheet=mirror`."""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, Field

from povgen.errors import InputError, shown
from povgen.objects.sheet_fields import TABLES, FurtherParameters, SheetName
from povgen.validation import Model

MAX_WINDOWS = 5


class FurtherWindow(FurtherParameters):
    """A window behind the first one, and parallel to it. Its size and its frame are those of the first.

    If a parameter of its sheet is not given, the first window's value is used.
    """

    z: Annotated[float, Field(gt=0, le=100)] = Field(
        description="distance from the first window, tiles: greater than 0, at most 100"
    )
    sheet: SheetName | None = Field(default=None, description="kind of its sheet (default: the first window's)")

    def __repr__(self) -> str:
        return repr(dict(self.__repr_args__()))  # as a scene takes it: this class is not public

    def _replaced_by(self, changes: dict[str, object]) -> set[str]:
        return replaced_by(changes)


def has_glass(window: Any) -> bool:  # noqa: ANN401  (a scene, for its first window, or a FurtherWindow)
    """Return whether the parameters of a window name the prisms' glass."""
    return window.glass not in (None, "none")


def replaced_by(changes: Mapping[str, object], windows: Iterable[FurtherWindow] = ()) -> set[str]:
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


def window_table(value: object) -> object:
    """Return a window's text, such as 'alpha=120,z=2', as a table.

    A part between commas that has no = belongs to the part before it, such as a component of a direction. So do height=
    and up= of a mesh, as in piece=model.stl,height=1.2. The table's values are texts. Only a parameter that is a table
    may occur several times. Its value is then a list of texts. If `value` is no text, it is returned as it is. Raises
    ValueError for text of another form.
    """
    if isinstance(value, str):
        parts: list[str] = []
        for part in value.split(","):
            of_mesh = parts and parts[-1].strip().startswith("piece=") and re.match(" *(height|up)=", part)
            if not parts or "=" in part and not of_mesh:
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


def stated_as(make: Callable[..., Model]) -> BeforeValidator:
    """Accept a table, or text such as alpha=120,z=2, in place of what is made of these values."""

    def made(value: object) -> object:
        table = window_table(value)
        return make(**table) if isinstance(table, Mapping) else value

    return BeforeValidator(made)


def several(kind: Any, make: Callable[..., Model], most: int) -> Any:  # noqa: ANN401  (types, for pydantic)
    """Return the type of up to `most` things of a kind: a tuple. One of them may be given in place of a list."""

    def listed(value: object) -> object:
        return [value] if isinstance(value, (str, Mapping, Model)) else value

    return Annotated[tuple[Annotated[kind, stated_as(make)], ...], Field(max_length=most), BeforeValidator(listed)]


WINDOW = (
    "a window behind the first one, such as alpha=120,z=2. z: its distance from the first window, tiles. Further "
    "keys: sheet, and its parameters; the first window's value is the default. "
    f"Can be given up to {MAX_WINDOWS - 1} times, in order of z"
)
if TYPE_CHECKING:  # read as windows; a user may give anything that becomes such a tuple
    Windows = tuple[FurtherWindow, ...] | Any
else:
    Windows = several(FurtherWindow, FurtherWindow, MAX_WINDOWS - 1)


# names of numbers of windows behind the first one: window2_alpha, window2_z, window3_alpha, ...
WINDOW_NUMBER = re.compile(f"window([2-{MAX_WINDOWS}])_([a-z_]+)")


def with_numbers(windows: Iterable[FurtherWindow], values: Mapping[str, Any]) -> list[FurtherWindow]:
    """Return the windows with other numbers, as {"window2_alpha": 90}. Raises InputError."""
    made = [*windows]
    for name, value in values.items():
        if not (match := WINDOW_NUMBER.fullmatch(name)):
            raise InputError(f"{shown(name)}: no number of a window behind the first one; allowed: such as window2_z")
        number, field = int(match[1]), match[2]
        if number > len(made) + 1:
            raise InputError(f"{name}: there is no window {number}; allowed: in a scene with it (--window, [[window]])")
        made[number - 2] = made[number - 2].replace(**{field: value})
    return made


class _Windows(Model):
    window: Windows = Field(description=WINDOW)


def as_windows(value: object) -> list[FurtherWindow]:
    """Return the windows that a scene's parameter `window` states. Raises InputError."""
    return list(_Windows(window=value).window)
