"""What the page knows of rooms: the tables of a room's file with what each value can be, and rooms to begin with."""

from collections.abc import Sequence
from typing import Any, Literal, get_args, get_origin

from povgen import fonts
from povgen.inputs.pieces import PIECES
from povgen.objects import OBJECTS
from povgen.objects.placed import Placed
from povgen.objects.window import Window
from povgen.scene import files
from povgen.scene.room import MOST_OBJECTS, MOST_WINDOWS, OF_MOVIES, Eye, Room
from povgen.scene.sdl import PACKAGE
from povgen.sheets import PARAMETERS
from povgen.validation import Model

EXAMPLES = PACKAGE / "page/examples"
NAMES = ("two", "tilted", "star")  # of the examples, in this order
SHEETS = {"law", "profile"}  # kinds that need what only Python makes
# what the page does not show, with all that it depends on, and what is a table of its own
LEFT_OUT = {"error", "fresnel", "glass", "design_wavelength", "wavelength", "law", "parameter", "profile", "periods"}
LEFT_OUT |= {"arrangement", "sky", "file", "eye", "object", "window"}


def data(pieces: Sequence[str] = tuple(PIECES)) -> dict[str, object]:
    """Return what the page's scripts read of rooms. `pieces` are the names of the pieces that the page has."""
    objects = {name: _fields(kind) for name, kind in OBJECTS.items() if kind.kind != "card"}
    objects["piece"]["piece"] = ["knight", [*pieces]]
    shared = _fields(Placed)
    return {
        "examples": {name: (EXAMPLES / f"{name}.toml").read_text("utf-8") for name in NAMES},
        "tables": {"room": _fields(Room), "eye": _fields(Eye), "window": _fields(Window), "placed": shared},
        "objects": {name: {x: own[x] for x in own if x not in shared} for name, own in objects.items()},
        "most": {"window": MOST_WINDOWS, "object": MOST_OBJECTS, "bytes": files.MAX_BYTES},
        "movies": sorted(OF_MOVIES),
        "letters": fonts.LETTERS,
    }


def _fields(model: type[Model]) -> dict[str, list[Any]]:
    """Return for each value of a table its default, and what else is allowed.

    That is the least and the greatest number, whether it is whole, and the least size; or a list of choices; nothing
    for other text, and for true and false.
    """
    found: dict[str, list[Any]] = {}
    for name, field in model.model_fields.items():
        if name in LEFT_OUT:
            continue
        bounds = _bounds(field.annotation, field.metadata)
        found[name] = [field.default]
        if get_origin(field.annotation) is Literal:
            found[name].append([each for each in get_args(field.annotation) if name != "sheet" or each not in SHEETS])
        elif bounds:
            size = PARAMETERS[name][0].size if name in PARAMETERS else 0
            least = bounds.get("ge", 0.01)  # a number above 0
            found[name] += [least, bounds["le"], field.annotation is int, size]
    return found


def _bounds(annotation: Any, metadata: Sequence[object]) -> dict[str, float]:  # noqa: ANN401  (any type)
    """Return the bounds ge and le of a number, wherever they are in its type."""
    found = {name: getattr(each, name) for each in metadata for name in ("ge", "le") if hasattr(each, name)}
    for part in get_args(annotation):
        found |= _bounds(part, getattr(part, "metadata", ()))
    return found
