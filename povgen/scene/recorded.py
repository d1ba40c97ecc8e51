"""The scenes in a file's record (povgen.record). The file can be a stranger's: every value is checked."""

import time
from collections.abc import Mapping
from typing import Any, TypeVar

from povgen.errors import InputError, shown
from povgen.record import Record, in_use

T = TypeVar("T")
PATIENCE = 120  # CPU seconds in which all frames are checked; 10,000 frames of one window of prisms take 4


def scenes(record: Record, known: Mapping[str, type[T]]) -> list[T]:
    """Return the scene of every frame. `known` has the allowed classes, by the scenes' names. Raises InputError."""
    end = time.process_time() + PATIENCE
    made: list[T] = []
    with in_use(record):
        for values in record.values:
            if time.process_time() > end:
                count = f"{len(made)} of {len(record.frames)}"
                raise InputError(
                    f"frames: {count} were checked within {PATIENCE} s; allowed: frames that take less time"
                )
            made.append(_scene(values, known))
    return made


def _scene(values: dict[str, Any], known: Mapping[str, type[T]]) -> T:
    name, values = values.get("scene"), {key: value for key, value in values.items() if key != "scene"}
    if not isinstance(name, str) or name not in known:
        raise InputError(f"scene = {shown(name)}: allowed: {', '.join(known)}")
    windows = values.get("window", [])
    if not (isinstance(windows, list) and all(isinstance(window, dict) for window in windows)):
        raise InputError(f"window = {shown(windows)}: should be a list of tables")
    return known[name](**_without_index(values | {"window": [*map(_without_index, windows)]}))


def _without_index(window: dict[str, Any]) -> dict[str, Any]:
    """Return the values of a scene or of a window without the index if a glass is named: it follows from the glass."""
    named = window.get("glass") not in (None, "none")
    return {name: value for name, value in window.items() if not (named and name == "index")}
