"""The laws of ideal sheets as text in other languages: POV-Ray, and GLSL and JavaScript for the live view."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from povgen.scene.models import Placed, Scene
from povgen.sheets import IDEAL
from povgen.sheets.law import FUNCTIONS
from povgen.sheets.own import OwnLaw
from povgen.sheets.sheet import Ideal, Parameter


class Line(NamedTuple):
    """A parameter of a law in a .pov text."""

    name: str
    value: float
    about: str


class Functions(NamedTuple):
    """The law of a window's sheet in a .pov text."""

    number: int  # of the window, from 1
    sheet: Ideal
    parameters: list[Line]
    expressions: list[str]  # of x, y and z


def to_pov(scene: Scene) -> list[Functions]:
    """Return the laws of a scene's ideal windows, as POV-Ray's functions of x, y, z, X and Y.

    A parameter has its name, with a capital letter for each word: Alpha, FocalLength, AxisX. Those of window 2 end
    with 2.
    """
    return [_functions(number, window) for number, window in enumerate(scene.windows[: len(scene.ideal)], 1)]


def _functions(number: int, window: Placed) -> Functions:
    sheet = window.sheet
    assert isinstance(sheet, Ideal)  # by _check_windows of Scene, ideal windows come first
    suffix, where = (f"_{number}", f" of window {number}") if number > 1 else ("", "")
    names: dict[str, str] = {}
    lines = []
    for each in sheet.parameters:
        value = sheet.values[each.name]
        parts = value if each.kind == "direction" else [value]
        for name, part in zip(each.names, parts, strict=True) if each.kind not in ("text", "table") else ():
            written = "".join(word.capitalize() for word in name.split("_")) + suffix
            names[name] = f"radians({written})" if each.unit.startswith("degrees") else written
            unit = f", {each.unit}" if each.unit else ""
            lines.append(Line(written, part, f"{_about(each, name)}{where}{unit}"))
    for name, value in sheet.numbers.items():
        if name not in names:
            names[name] = f"Own_{name}{suffix}"
            lines.append(Line(names[name], value, f"{name} in the law{where}"))
    return Functions(number, sheet, lines, sheet.law.expressions(lambda name: names.get(name, name)))


def _about(parameter: Parameter, name: str) -> str:
    """Return what a number is: the beginning of the parameter's text."""
    component = f"{name[-1]} of the " if parameter.kind == "direction" else ""
    return component + re.split(",| as ", parameter.text)[0]


class Text(NamedTuple):
    """A kind's law in GLSL and JavaScript, where `c` is a list of its constants."""

    name: str
    constants: list[str]  # JavaScript, of the parameters' numbers p.NAME
    glsl: list[str]
    javascript: list[str]
    angles: list[str]  # the numbers that are angles


def to_live(own: Sequence[OwnLaw] = ()) -> list[Text]:
    """Return the laws of all kinds of ideal sheets, and of a user's own, in GLSL and JavaScript.

    What depends on parameters alone is computed in JavaScript: a graphics processor's sine has errors of 2e-5.
    """
    kinds: list[Ideal] = [kind({}) for kind in IDEAL.values() if kind is not OwnLaw]
    return [_text(sheet, sheet.name) for sheet in kinds] + [
        _text(sheet, f"law {number}") for number, sheet in enumerate(own)
    ]


def _text(sheet: Ideal, name: str) -> Text:
    numbered = {f"c{k}": f"c[{k}]" for k in range(len(sheet.law.constants()))}
    parameters = {each: f"p.{each}" for each in sheet.law.parameters}
    maths = {each: f"Math.{each}" for each in FUNCTIONS}
    angles = [name for each in sheet.parameters if each.unit.startswith("degrees") for name in each.names]
    return Text(
        name,
        sheet.law.constants(lambda each: {**maths, **parameters}.get(each, each)),
        sheet.law.with_constants(lambda each: numbered.get(each, each)),
        sheet.law.with_constants(lambda each: {**maths, **numbered}.get(each, each)),
        angles,
    )
