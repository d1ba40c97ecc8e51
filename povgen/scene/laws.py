"""The laws of ideal sheets as text in other languages: POV-Ray, and GLSL and JavaScript for the live view."""

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

from povgen.scene.presets import AxialScene
from povgen.scene.scene import Scene
from povgen.sheets import IDEAL
from povgen.sheets.law_grammar import FUNCTIONS, Law
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
    expressions: list[str]  # for the components x, y and z of the ray's direction behind the sheet


def to_pov(scene: AxialScene) -> list[Functions]:
    """Return the laws of a scene's ideal windows, as functions of POV-Ray of x, y, z, X and Y (`sheets.law_grammar`).

    Windows of glass stand behind them.

    In the names of parameters, each word has a capital letter: Alpha, FocalLength, AxisX. For window 2 they end with
    _2. The parameters of a user's own law are Own_NAME, and for window 2 Own2_NAME.
    """
    return [_functions(number, sheet) for number, sheet in enumerate(scene.ideal, 1)]


def _functions(number: int, sheet: Ideal) -> Functions:
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
            # not Own_k_2 for k of window 2: this is the name of a parameter k_2 of window 1
            names[name] = f"Own{number if number > 1 else ''}_{name}"
            lines.append(Line(names[name], value, f"{name} in the law{where}"))
    return Functions(number, sheet, lines, sheet.law.expressions(names))


def _about(parameter: Parameter, name: str) -> str:
    """Return what a number is: the beginning of the parameter's text."""
    component = f"{name[-1]} of the " if parameter.kind == "direction" else ""
    return component + parameter.about


class Text(NamedTuple):
    """The law of a kind of ideal sheet in GLSL and JavaScript."""

    name: str
    # for each name in the law: the parameter's name, the first word of its unit, and the number of the component, from
    # 0, of a direction; None for other parameters
    numbers: dict[str, tuple[str, str, int | None]]
    constants: list[str]  # JavaScript: the parts that depend on parameters alone; a parameter is p.NAME
    # the components x, y and z of the ray's direction behind the sheet
    glsl: list[str]  # this law's constants begin at constants[at] in the shader
    javascript: list[str]  # the constants are c[0], c[1], ...


def to_live(scenes: Iterable[Scene] = ()) -> list[Text]:
    """Return, in GLSL and JavaScript, the laws of all kinds of ideal sheets, and the users' own laws in these scenes.

    What depends on parameters alone is computed in JavaScript: a graphics processor's sine has errors of 2e-5.
    """
    texts = [_text(kind.name, kind.law, tuple(kind.parameters)) for kind in IDEAL.values() if kind is not OwnLaw]
    own = {sheet.values["law"]: sheet.law for scene in scenes for sheet in scene.sheets if isinstance(sheet, OwnLaw)}
    return texts + [_text(f"law {text}", law) for text, law in own.items()]


@lru_cache(maxsize=100)  # each frame of a movie asks for the same
def _text(name: str, law: Law, parameters: tuple[Parameter, ...] = ()) -> Text:
    numbers: dict[str, tuple[str, str, int | None]] = {}
    for each in parameters:
        for k, number in enumerate(each.names):
            numbers[number] = (each.name, each.unit.partition(" ")[0], k if each.kind == "direction" else None)
    count = len(law.constants())
    maths = {each: f"Math.{each}" for each in FUNCTIONS}
    given = {each: f"p.{each}" for each in law.parameters}
    return Text(
        name,
        numbers,
        law.constants(maths | given),
        law.with_constants({f"c{k}": f"constants[at + {k}]" for k in range(count)}),
        law.with_constants(maths | {f"c{k}": f"c[{k}]" for k in range(count)}),
    )
