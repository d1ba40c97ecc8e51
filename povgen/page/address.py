"""The settings in the address of the teaching page: the kinds of sheets, and which values are allowed."""

from collections.abc import Collection
from contextlib import suppress
from dataclasses import asdict
from typing import Any
from urllib.parse import unquote_plus

from povgen import limits
from povgen.errors import InputError, shown
from povgen.sheets import OTHER, PARAMETERS, SHEETS, USED_BY
from povgen.sheets.sheet import Parameter

# the kinds of sheets that the page shows beyond the paper's: ideal ones, and sheets of lenses
KINDS = {name: kind for name, kind in OTHER.items() if name != "law"}
ALL_KINDS = {**KINDS, "lenticular": SHEETS["lenticular"]}
KEPT = {"index", "glass", "design_wavelength", "gap", "error"}  # parameters that have their defaults on the page


def _parameter(parameter: Parameter) -> dict[str, Any]:
    """Return what the page needs to know of a parameter. If it has no limits, they are -100 and 100 on the page."""
    return asdict(parameter) | {
        "symbol": parameter.symbol or parameter.name.replace("_", " "),
        "unit": parameter.unit.replace("degrees", "°").replace(" a ", "/"),
        "least": -100 if parameter.least is None else parameter.least,
        "most": 100 if parameter.most is None else parameter.most,
    }


PAGES = {
    name: _parameter(several[0])
    for name, several in PARAMETERS.items()
    if {*USED_BY[name]} & {*ALL_KINDS} and name not in KEPT
}
RANGES = {name: [each["least"], each["most"]] for name, each in PAGES.items()} | {
    **{"z1": [0.01, 5000], "z2": [0.01, 150], "prisms": [1, limits.MAX_PRISMS], "windows": [1, 2], "d": [0.01, 100]},
    **{"pupil": [0, 0.6], "focus": [0.1, 1000]},
    **{"alpha": [-180, 180], "alpha2": [-180, 180]},  # other angles turn light as one of these does
}
_SHEETS = ["none", "single", "detailed", "ideal", *ALL_KINDS]
CHOICES = {
    "scene": ["chess", "spheres"],
    "sheet": _SHEETS,
    "sheet2": ["same", *(name for name in _SHEETS if name != "lenticular")],
    "diagram": ["picture", "paper"],
    "light": ["ray", "pencil", "eye", "aim", "prism", "field"],
    "level": ["simple", "expert"],
    "compare": ["off", "none", "single", "detailed", "ideal"],
}
SWITCHES = ["position", "circles", "image", "caption", "depth", "stray", "large"]
POINTS = {"L", "E", "W"}
VIEWS = ["side", "corner", "above", "eye"]  # of the light
OTHERS = {"level", "language", "question", "own", "panel"}  # what else a link has


def settings(text: str, pieces: Collection[str]) -> dict[str, object]:
    """Return the settings that a text states as the page's address does, also as a whole link. Raises InputError."""
    found: dict[str, object] = {}
    choices = CHOICES | {"piece": [*pieces]}
    for part in filter(None, text.rpartition("#")[2].split("&")):
        name, _, value = part.partition("=")
        value, words = unquote_plus(value), unquote_plus(value).split(",")
        if name in OTHERS:
            continue
        if name == "view":
            _allowed(part, [value], VIEWS)
        elif name == "show":
            _allowed(part, [*filter(None, words)], SWITCHES)
            # the glasses are the reader's own
            found |= {switch: switch in words for switch in SWITCHES if switch != "depth"}
        elif name in choices:
            _allowed(part, [value], choices[name])
            found[name] = value
        elif name in RANGES or name in POINTS:
            found[name] = value if part == "focus=best" else _numbers(part, name, words)
        else:
            raise InputError(
                f"{shown(name)}: unknown setting; allowed: {', '.join([*choices, *RANGES, *POINTS, 'show', 'view'])}"
            )
    return found


def _allowed(part: str, words: Collection[str], allowed: Collection[str]) -> None:
    if not {*words} <= {*allowed}:
        raise InputError(f"{shown(part)}: allowed: {', '.join(allowed)}")


def _numbers(part: str, name: str, words: list[str]) -> float | list[float]:
    count = 2 if name in POINTS else 3 if PAGES.get(name, {}).get("kind") == "direction" else 1
    least, most = RANGES.get(name, [-100, 100])
    with suppress(ValueError):
        numbers = [*map(float, words)]
        if len(numbers) == count and all(least <= x <= most for x in numbers):
            return numbers if count > 1 else numbers[0]
    many = "" if count == 1 else f"{count} numbers, each "
    raise InputError(f"{shown(part)}: allowed: {many}from {least:g} to {most:g}")
