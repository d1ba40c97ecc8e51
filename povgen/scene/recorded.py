"""The scenes in a file's record (povgen.record). The file can be a stranger's: every value is checked."""

import base64
from collections.abc import Collection, Mapping
from typing import Any, TypeVar

from povgen.errors import InputError, shown
from povgen.record import Record
from povgen.scene import mesh, pictures
from povgen.scene.pieces import MAX_BYTES, PIECES, PieceFile, checked
from povgen.sheets.profile import NAMES, ProfileFile

T = TypeVar("T")


def scenes(record: Record, known: Mapping[str, type[T]]) -> list[T]:
    """Return the scene of every frame. `known` has the allowed classes, by the scenes' names. Raises InputError.

    No file is read: the record has the text of every piece and every profile that is not povgen's own.
    """
    for name, text in record.pieces.items():
        if len(text) > MAX_BYTES and not mesh.is_own(text):
            raise InputError(f"piece = {shown(name)}: should be a file of at most {MAX_BYTES} bytes")
    return [_scene(_with_pictures(values, record.pictures), record.pieces, known) for values in record.values]


def _with_pictures(values: dict[str, Any], files: Mapping[str, str]) -> dict[str, Any]:
    """Return a scene's values with the pictures of sky and floor that the record holds, in place of their names."""
    found = dict(values)
    for part, read in (("sky", pictures.sky), ("floor", pictures.floor)):
        name = values.get(part)
        if name is None or part == "floor" and name in ("tiles", "none"):
            continue
        if not isinstance(name, str) or name not in files:
            raise InputError(f"{part} = {shown(name)}: the picture is not in the record; allowed: one of up to 4 MiB")
        try:
            found[part] = read(name, base64.b64decode(files[name]))
        except ValueError as error:
            raise InputError(f"{part} = {shown(name)}: {error}") from None
    return found


def _text_of(kind: str, name: object, texts: Mapping[str, str], own: Collection[str]) -> tuple[str, str]:
    """Return the path and the text of a file that the record has."""
    if isinstance(name, str) and name in texts:
        return name, texts[name]
    raise InputError(f"{kind} = {shown(name)}: its text is not in the record; allowed: {', '.join(own)}")


def _piece(name: object, texts: Mapping[str, str]) -> str | PieceFile:
    if isinstance(name, str) and name in PIECES:
        return name
    path, text = _text_of("piece", name, texts, PIECES)
    if mesh.is_own(text):
        return PieceFile(path, text, is_mesh=True)
    try:
        return PieceFile(path, checked(text))
    except ValueError as error:
        raise InputError(f"piece = {shown(name)}: {error}") from None


def _window(values: object, texts: Mapping[str, str]) -> dict[str, Any]:
    """Return the values of a scene or of a window, with the text of its profile.

    The index is left out if a glass is named: it follows from the glass.
    """
    if not isinstance(values, Mapping):
        raise InputError(f"window = {shown(values)}: should be a table")
    found = dict(values)
    if found.get("glass") not in (None, "none"):
        found.pop("index", None)
    name = found.get("profile")
    if name is not None and not (isinstance(name, str) and name in NAMES):
        found["profile"] = ProfileFile(*_text_of("profile", name, texts, NAMES))
    return found


def _scene(values: dict[str, Any], texts: Mapping[str, str], known: Mapping[str, type[T]]) -> T:
    name, values = values.get("scene"), {key: value for key, value in values.items() if key != "scene"}
    if not isinstance(name, str) or name not in known:
        raise InputError(f"scene = {shown(name)}: allowed: {', '.join(known)}")
    if "piece" in values:
        given = values["piece"]
        values["piece"] = [_piece(each, texts) for each in given] if isinstance(given, list) else _piece(given, texts)
    if not isinstance(windows := values.get("window", []), list):
        raise InputError(f"window = {shown(windows)}: should be a list of tables")
    values["window"] = [_window(each, texts) for each in windows]
    return known[name](**_window(values, texts))
