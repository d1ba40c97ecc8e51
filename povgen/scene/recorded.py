"""The scenes in a file's record (povgen.record). The file can be a stranger's: every value is checked."""

import base64
import time
from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar

from povgen.errors import InputError, shown
from povgen.record import MAX_PICTURES, Record
from povgen.scene import mesh, pictures
from povgen.scene.pieces import PIECES, PieceFile, checked
from povgen.sheets.profile import NAMES, ProfileFile

T = TypeVar("T")
PATIENCE = 120  # CPU seconds in which all frames are checked; 10,000 frames of one window of prisms take 4


def scenes(record: Record, known: Mapping[str, type[T]]) -> list[T]:
    """Return the scene of every frame. `known` has the allowed classes, by the scenes' names. Raises InputError.

    No file is read: the record has the text of every piece and every profile that is not povgen's own.
    """
    files, end = _Files(record), time.process_time() + PATIENCE
    made: list[T] = []
    for values in record.values:
        if time.process_time() > end:
            count = f"{len(made)} of {len(record.frames)}"
            raise InputError(f"frames: {count} were checked within {PATIENCE} s; allowed: frames that take less time")
        made.append(_scene(values, files, known))
    return made


class _Files:
    """The pieces, profiles and pictures that a record holds. Each is checked once, when a frame first names it."""

    def __init__(self, record: Record) -> None:
        self._record = record
        self._made: dict[tuple[str, str], object] = {}

    def __call__(self, kind: str, name: object) -> object:
        """Return what the record holds under a name. None and povgen's own names stay as they are.

        `kind` is the parameter that has the name: piece, profile, sky or floor. Raises InputError.
        """
        own, make = _KINDS[kind]
        is_picture = kind in ("sky", "floor")
        texts = self._record.pictures if is_picture else self._record.pieces
        if name is None or isinstance(name, str) and name in own:
            return name
        if not isinstance(name, str) or name not in texts:
            missing = f"the picture is not in the record; allowed: up to {MAX_PICTURES}, of 4 MiB together"
            missing = missing if is_picture else f"its text is not in the record; allowed: {', '.join(own)}"
            raise InputError(f"{kind} = {shown(name)}: {missing}")
        if (kind, name) not in self._made:
            try:
                self._made[kind, name] = make(name, texts[name])
            except ValueError as error:
                raise InputError(f"{kind} = {shown(name)}: {error}") from None
        return self._made[kind, name]


def _piece(path: str, text: str) -> PieceFile:
    is_mesh = mesh.is_own(text)
    return PieceFile(path, text if is_mesh else checked(text), is_mesh=is_mesh)


# for each parameter that names a file, povgen's own names, and what makes its value from the record's name and text
_KINDS: dict[str, tuple[Collection[str], Callable[[str, str], object]]] = {
    "piece": (PIECES, _piece),
    "profile": (NAMES, ProfileFile),
    "sky": ((), lambda name, text: pictures.sky(name, base64.b64decode(text))),
    "floor": (("tiles", "none"), lambda name, text: pictures.floor(name, base64.b64decode(text))),
}


def _window(values: object, files: _Files) -> dict[str, Any]:
    """Return the values of a scene or of a window, with the text of its profile.

    The index is left out if a glass is named: it follows from the glass.
    """
    if not isinstance(values, Mapping):
        raise InputError(f"window = {shown(values)}: should be a table")
    found = dict(values)
    if found.get("glass") not in (None, "none"):
        found.pop("index", None)
    if "profile" in found:
        found["profile"] = files("profile", found["profile"])
    return found


def _scene(values: dict[str, Any], files: _Files, known: Mapping[str, type[T]]) -> T:
    name, values = values.get("scene"), {key: value for key, value in values.items() if key != "scene"}
    if not isinstance(name, str) or name not in known:
        raise InputError(f"scene = {shown(name)}: allowed: {', '.join(known)}")
    for kind in ("sky", "floor", "piece"):
        given = values.get(kind)
        several = isinstance(given, list) and kind == "piece"
        if given is not None:
            values[kind] = [files(kind, each) for each in given] if several else files(kind, given)
    if not isinstance(windows := values.get("window", []), list):
        raise InputError(f"window = {shown(windows)}: should be a list of tables")
    values["window"] = [_window(each, files) for each in windows]
    return known[name](**_window(values, files))
