"""What a frame's caption says: the parameters of the scene, and what is predicted for it."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import zip_longest
from math import floor, log10
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from povgen.inputs.pieces import PIECES
from povgen.objects.window import Window
from povgen.optics import equations
from povgen.scene.presets import AxialScene, used_parameters
from povgen.scene.quantities import BEHIND, BEHIND_LAST, LATER, SECOND, SYMBOLS, unit
from povgen.scene.scene import Scene, is_empty, object_images
from povgen.scene.spec import swept_numbers
from povgen.settings import Rendering
from povgen.sheets import PARAMETERS
from povgen.sheets.parameters import WAVELENGTH
from povgen.sheets.prisms import PRISMS
from povgen.sheets.sheet import Parameter, Said, Sheet
from povgen.video.text import text_width

SUBSCRIPTS = "₀₁₂₃₄₅₆₇₈₉"
MOVING = 1.25  # the factor by which the text of a movie's short caption is larger: it is read while something moves
LEAST_TURN = 2  # degrees: a movie's short caption states nu only if it changes by more than this
NO_TURN = 1e-6  # degrees: a rounding error
LEAST_GROWTH = 1.4  # it states the size only if the size changes by more than this factor
MOST_NAMES = 4  # of points that are not seen
SET = "pupil", "focus", "polariser", "analyser"  # what a full caption states if it is not the default
MOST_NUMBERS = 8  # the short caption of a room's movie states its numbers if at most so many change
MOST_SHEETS = 4  # the caption of a room states its sheets if there are at most so many different ones

Reals = NDArray[np.float64]


class Caption(NamedTuple):
    """A frame's caption.

    `widest` has, for each text, a text as wide as the widest at the same place in any frame of the movie.
    """

    texts: Sequence[str]
    widest: Sequence[str]
    size: float = 1  # of the text, as a multiple of the usual size


def captions(scenes: Sequence[Scene], rendering: Rendering, notes: Sequence[str] = ()) -> list[Caption]:
    """Return the captions of a movie's frames, or of a single picture.

    A short caption states what differs between the frames, and by how much an object appears turned, if that changes.
    The short caption of a single picture states the sheets' parameters, or z1 where the sheets have none. Of a room it
    says what stands there. The note stands last: the rendering's, or of `notes`, which has one for each scene.
    """
    size = 1.0
    axial = [scene for scene in scenes if isinstance(scene, AxialScene)]
    if rendering.caption == "short" and len(scenes) > 1:
        rows = _moving(axial, rendering.side_view) if len(axial) == len(scenes) else _moving_parts(scenes)
        size = MOVING
    elif rendering.caption in ("short", "full"):
        rows = [_about(scene, rendering.caption == "full") for scene in scenes]
    else:
        rows = [[] for _ in scenes]
    if rendering.overlay and len(axial) < len(scenes):
        rows = [[*row, *_without_image(scene)] for row, scene in zip(rows, scenes, strict=True)]
    notes = notes or [rendering.note] * len(scenes)
    if any(notes):
        rows = [[*row, note] for row, note in zip(rows, notes, strict=True)]
    widest = [_widest(texts) for texts in zip_longest(*rows, fillvalue="")]
    # scenes of several kinds can have different numbers of texts
    return [Caption([*texts, *[""] * (len(widest) - len(texts))], widest, size) for texts in rows]


def _widest(texts: Sequence[str]) -> str:
    """Return a text as wide as the widest of these.

    If all texts have the same number of words, each word of the result is the widest at its place.
    """
    words = [text.split(" ") for text in {*texts} - {""}]
    if len({len(row) for row in words}) == 1:
        return " ".join(max(each, key=text_width) for each in zip(*words, strict=True))
    return max(texts, key=text_width)


def _about(scene: Scene, full: bool) -> list[str]:
    """Return what the caption of a single picture says."""
    if isinstance(scene, AxialScene):
        values = facts(scene) if full else _values(scene) or {"z1": facts(scene)["z1"]}
        return _all_said(scene, values, full)
    sheets = Counter(map(_sheet, scene.sheets))
    said = ", ".join(text if n == 1 or len(sheets) == 1 else f"{n} × {text}" for text, n in sheets.items())
    windows = f"{_count(len(scene.sheets), 'window')}{f': {said}' if 0 < len(sheets) <= MOST_SHEETS else ''}"
    things = Counter(each.called for each in scene.contents if each.point is not None)
    texts = [windows, ", ".join(name if n == 1 else _count(n, name) for name, n in things.items())]
    if full:
        eye, to = (", ".join(_number(x, ".4g") for x in place) for place in (scene.camera.eye, scene.camera.middle))
        texts += [f"eye at ({eye}), looks at ({to})", *(f"{name} = {text}" for name, text in _set(scene).items())]
    return [text for text in texts if text]


def _count(number: int, name: str) -> str:
    """Return a number of things: no window, 1 window, 2 windows."""
    ending = "" if number < 2 else "es" if name.endswith("x") else "s"
    return f"{number or 'no'} {name}{ending}"


def _sheet(sheet: Sheet) -> str:
    """Return what a room's caption says of a sheet: its name, and its numbers."""
    values = {each.name: (text, each.said) for each, text in _texts(sheet)}
    words = {
        name: said.full or said.words if said else f"{SYMBOLS.get(name, name.replace('_', ' '))} = {{}}"
        for name, (_, said) in values.items()
    }
    texts = {name: text for name, (text, _) in values.items()}
    every = "".join(words.values())
    said = [words[name].format(text, **texts) for name, text in texts.items() if f"{{{name}}}" not in every]
    said += [f"{name} = {_number(x, '.3g')}" for name, x in sheet.values.get("parameter", {}).items()]
    name = "empty" if sheet.name == "none" else sheet.name
    return " ".join(said if said and said[0].startswith(name) else [name, *said])


def _without_image(scene: Scene) -> list[str]:
    """Return the text that names the points of which the overlay marks no image, if there are any."""
    if isinstance(scene, AxialScene):
        return []
    names = {id(part): name for name, part in scene.parts.items()}
    counts = Counter(each.called for each in scene.contents)
    unseen = [
        f"{each.point_is} of {each.called if counts[each.called] == 1 else names.get(id(each), each.called)}"
        for each, images in object_images(scene)
        if not images
    ]
    if len(unseen) > MOST_NAMES:
        unseen[MOST_NAMES - 1 :] = [f"{len(unseen) - MOST_NAMES + 1} others"]
    return [f"not seen: {', '.join(unseen)}"] if unseen else []


def _moving_parts(scenes: Sequence[Scene]) -> list[list[str]]:
    """Return the short caption of each frame of a movie of rooms: the numbers that are not the same in all frames."""
    rows: list[dict[tuple[str, str], float]] = [{} for _ in scenes]
    about: dict[tuple[str, str], str] = {}
    common = set.intersection(*({*type(scene).model_fields} for scene in scenes))
    for scene, row in zip(scenes, rows, strict=True):
        for part, model in {"": scene, **scene.parts}.items():
            unused = model.without_effect if isinstance(model, Window) else set()
            numbers = {name: x for name, x in model if type(x) in (int, float) and name not in unused}
            row |= {(part, name): x for name, x in numbers.items() if part or name in common}
            about |= {(part, name): field.description or "" for name, field in type(model).model_fields.items()}
    found: list[list[str]] = []
    for part, name in dict.fromkeys(key for row in rows for key in row):
        values = [row.get((part, name)) for row in rows]
        if len({*values}) > 1 and not (part and None in values):  # what some frames lack is left out
            text = about[part, name]
            unit = _unit(name) or ("°" if "degrees" in text else " tiles" if "tiles" in text else "")
            digits = _digits([(x,) for x in values if x is not None], unit.startswith("°"))
            texts = [
                f"{x:z.{digits}f}{unit}" if x is not None else _word(scene, name)
                for scene, x in zip(scenes, values, strict=True)
            ]
            called = f"{part}: {SYMBOLS.get(name, name.replace('_', ' '))}".removeprefix(": ")
            found.append([f"{called} = {text}" for text in texts])
    if len(found) > MOST_NUMBERS:
        return [[f"{len(found)} numbers change"]] * len(scenes)
    return [[*texts] for texts in zip(*found, strict=True)] if found else [[] for _ in scenes]


def _all_said(scene: AxialScene, values: Mapping[str, str], full: bool = False) -> list[str]:
    """Return what a caption says of these values. A value is left out if the words about another value state it."""
    words = "".join(_words(scene, name).words for name in values)
    return [_said(scene, name, text, full) for name, text in values.items() if f"{{{name}}}" not in words]


def _moving(scenes: Sequence[AxialScene], side_view: bool = False) -> list[list[str]]:
    """Return the short caption of each frame.

    It states the numbers and points that are not the same in all frames. If the angle by which an object appears turned
    changes, it states this too, and how large the object appears if this changes. With a side view, a number that
    is only rounded to that of a frame in which all objects have an image has the sign ~.
    """
    imaged = [
        not (side_view and any(np.isnan(scene.image_plane([L], z1)[0]) for L, z1 in scene.objects)) for scene in scenes
    ]
    uses = [used_parameters(scene) for scene in scenes]
    rows = [_numbers(scene, set().union(*uses)) for scene in scenes]
    found: list[list[str]] = []
    for name in dict.fromkeys(name for row in rows for name in row):
        # the kind of sheet decides what a caption states: the angle of a mirror's line is half of its alpha
        values = [
            tuple(_words(scene, name).factor * x for x in row.get(name, ()))
            for scene, row in zip(scenes, rows, strict=True)
        ]
        if len({*values}) > 1 and name in ("eye", "look", "line"):
            digits = _digits(values)
            found.append([_place(name, place, digits) for place in values])
        elif len({*values}) > 1:
            plain, _, kind = name.rstrip(SUBSCRIPTS).partition(" ")
            unit = "" if kind == "law" else _unit(plain)
            digits = _digits(values, unit.startswith("°"))
            texts = [
                " to ".join(f"{x:z.{digits}f}" for x in value) + unit if value else _word(scene, plain)
                for scene, value in zip(scenes, values, strict=True)
            ]
            texts = _signed(texts, values, imaged)
            texts = [text + _in_each_window(scene, name) for scene, text in zip(scenes, texts, strict=True)]
            # a frame states nothing of a parameter that its own sheet does not have
            lacks = [
                plain in PARAMETERS and (name not in own if name == plain else not value)
                for own, value in zip(uses, values, strict=True)
            ]
            found.append(
                ["" if no else _said(scene, name, text) for scene, text, no in zip(scenes, texts, lacks, strict=True)]
            )
    turned, sizes = zip(*[_image(scene) for scene in scenes], strict=True)
    known = [nu for nu in turned if np.isfinite(nu)]
    if known and max(known) - min(known) > LEAST_TURN:
        if len({scene.alphas for scene in scenes}) == 1 and not scenes[0].window:
            found.append([_said(scene, "alpha", _values(scene)["alpha"]) for scene in scenes])
        names = [next((str(each.piece) for each in getattr(scene, "pieces", ())), "") for scene in scenes]
        texts = [
            f"{name if name in PIECES else 'object'} appears {_turn(nu)}"
            for name, nu in zip(names, turned, strict=True)
        ]
        if np.nanmax(sizes) > LEAST_GROWTH * np.nanmin(sizes):
            times = [f"{size:.1f}" if np.isfinite(size) else "?" for size in sizes]
            texts = [f"{text}, magnified {size} times" for text, size in zip(texts, times, strict=True)]
        found.append(texts)
    return [[*texts] for texts in zip(*found, strict=True)] if found else [[] for _ in scenes]


def _signed(texts: Sequence[str], values: Sequence[tuple[float, ...]], imaged: Sequence[bool]) -> list[str]:
    """Return the texts of rounded values, with ~ where only rounding makes one that of a frame with an image."""
    exact = {(text, value) for text, value, has in zip(texts, values, imaged, strict=True) if has}
    rounded = {text for text, _ in exact}
    return [
        f"~{text}" if text in rounded and not has and (text, value) not in exact else text
        for text, value, has in zip(texts, values, imaged, strict=True)
    ]


def _word(scene: Scene, name: str) -> str:
    """Return the parameter's value if it is text, such as best for focus, otherwise none."""
    value = getattr(scene, name, None)
    return value if isinstance(value, str) else "none"


def _turn(nu: float) -> str:
    """Return how an object appears that is turned by nu, degrees. Only what is not turned at all is upright."""
    if not np.isfinite(nu):
        return "turned by ?"
    if abs(nu) < NO_TURN:
        return "upright"
    return f"turned by {nu:z.0f}°" if round(nu) else "turned by <1°"


def _image(scene: AxialScene) -> tuple[float, float]:
    """Return the angle nu, degrees, by which a scene's only object appears turned, and its size.

    The size is a multiple of the size without the sheets. Both are NaN unless the scene has one object and every window
    rotates light. At the pole, nu is NaN and the size is infinite.
    """
    if len(scene.objects) != 1 or not scene.rotates:
        return float("nan"), float("nan")
    nu, M = scene.nu_and_M(scene.distances[0])
    return float(nu), float(M) * (scene.z2 + scene.places[-1] + scene.distances[0]) / scene.z2


def _digits(values: Iterable[tuple[float, ...]], angles: bool = False) -> int:
    """Return how many decimals show that the values differ: 0 to 4, and 0 if all are whole numbers.

    Angles have no more than needed. Other values have at least one, unless they differ by 100 or more.
    """
    numbers = [x for value in values for x in value]
    span = max(numbers) - min(numbers)
    if all(float(x).is_integer() for x in numbers):
        return 0
    if not span:  # all frames that have the value have the same; some frames do not have it
        return next((digits for digits in range(4) if round(numbers[0], digits) == numbers[0]), 4)
    return min(max(1 - floor(log10(span)), 0 if angles or span >= 100 else 1), 4)


def _place(name: str, place: tuple[float, ...], digits: int) -> str:
    """Return where a point is: `eye 0.4 tiles to the left`, rounded."""
    if not place:  # a movie of several kinds of scenes
        return f"{name} none"
    ways = (("to the left", "to the right"), ("down", "up"))
    rounded = [round(x, digits) for x in place]
    parts = [f"{abs(x):.{digits}f}{_unit(name)} {way[x > 0]}" for x, way in zip(rounded, ways, strict=True) if x]
    return f"{name} {', '.join(parts) or 'in the middle'}"


def _words(scene: AxialScene, name: str) -> Said:
    """Return how a caption says a parameter. For a further window, `name` ends with the window's number.

    `name` can also be a parameter and a kind of sheet: see `_values`.
    """
    plain, _, kind = name.rstrip(SUBSCRIPTS).partition(" ")
    number = name[len(name.rstrip(SUBSCRIPTS)) :]
    if plain == "z" and number:
        return SECOND if len(scene.window) == 1 else LATER
    if plain == "z1" and not kind:
        return BEHIND_LAST if scene.window else BEHIND
    sheets = [sheet for sheet in scene.sheets if kind in ("", sheet.name)]
    said = next((each.said for sheet in sheets for each in sheet.parameters if each.name == plain), None)
    if said and not number:
        words = said.words
        for name in _values(scene) if kind else ():  # {ratio} is the ratio of this kind of sheet
            if name.endswith(f" {kind}"):
                words = words.replace(f"{{{name.removesuffix(f' {kind}')}}}", f"{{{name}}}")
        return said._replace(words=words)
    return Said(f"{SYMBOLS.get(plain, plain.replace('_', ' '))}{number} = {{}}")


def _said(scene: AxialScene, name: str, text: str, full: bool = False) -> str:
    """Return what a caption says of a parameter, whose value as text is given."""
    number, words = SUBSCRIPTS.find(name[-1]), _words(scene, name)
    return (words.full if full and words.full else words.words).format(text, **{**_values(scene), "number": number})


def _numbers(scene: AxialScene, used: set[str]) -> dict[str, tuple[float, ...]]:
    """Return the parameters that a movie can change, each as a number, as least and greatest number, or as x and y.

    A parameter of a further window has the window's number as a subscript. The sheets' parameters that are not `used`
    in any frame are left out. The view is left out, because it does not change the scene, only the picture of it.
    """
    counts = swept_numbers(type(scene))
    found: dict[str, Any] = {
        name: getattr(scene, name) for name in counts if name != "view" and (name in used or name not in PARAMETERS)
    }
    said = {each.name: each.said for sheet in scene.sheets[::-1] for each in sheet.parameters}
    for n, (window, sheet) in enumerate(zip(scene.window, scene.sheets[1:], strict=True), 2):
        own = {each.name: each.said for each in sheet.parameters}
        for name in swept_numbers(type(window)):
            if name in own and getattr(window, name) is None and own[name] != said[name]:
                found[f"{name} {sheet.name}"] = getattr(scene, name)  # this kind has other words for the scene's value
            elif name in own or name not in PARAMETERS:
                found[f"{name}{SUBSCRIPTS[n]}"] = getattr(window, name)
    for n, sheet in enumerate(scene.sheets, 1):
        number = SUBSCRIPTS[n] if n > 1 and scene.window[n - 2].parameter is not None else ""
        found |= {f"{name} law{number}": x for name, x in sheet.values.get("parameter", {}).items()}
    values = {}
    for name, value in found.items():
        several = value if isinstance(value, tuple) else (value,)
        if all(isinstance(x, (int, float)) for x in several):
            values[name] = several if counts.get(name) == 2 else tuple(dict.fromkeys((min(several), max(several))))
    return values


def _in_each_window(scene: AxialScene, name: str) -> str:
    """Return ` in each window` if several windows have this number of the scene in common."""
    said = [each.said for sheet in scene.sheets for each in sheet.parameters if each.name == name]
    alike = len(said) == len(scene.sheets) > 1 and len({*said}) == 1
    return " in each window" if alike and all(getattr(each, name) is None for each in scene.window) else ""


def _unit(name: str) -> str:
    """Return the unit of a parameter, as it follows a number."""
    text = unit(name).replace("degrees", "°").replace(" a ", "/")
    return text if text.startswith("°") else f" {text}" if text else ""


def facts(scene: AxialScene) -> dict[str, str]:
    """Return what a full caption states, as text by name: the sheets' parameters, z1, z2, r, nu, M and N.

    nu and M are there if the sheets only rotate light. r is there for one window with such a sheet, with the sheet
    `single` or without a sheet. Windows in series have their z instead. A glass that is named adds n. For several
    objects a value is a range. nu and M are predictions for prisms of the scene's size (`Scene.nu_and_M`). Of pupil,
    focus and polarisers it has those that are not the default.
    """
    z1 = np.array(scene.distances)
    tiles = _unit("z1")
    texts = {"z1": _range(z1, ".4g") + tiles, "z2": _number(scene.z2, ".4g") + tiles}
    texts["r"] = _range(equations.r(z1, scene.z2))
    other = not (scene.has_nu_and_M or scene.sheet == "single")
    if scene.window or other:  # r is for a single window that rotates light
        del texts["r"]
    if scene.window:
        texts = {"z": ", ".join(_number(z, ".4g") for z in scene.places) + tiles, **texts}
    if scene.has_nu_and_M and not is_empty(scene):
        nu, M = scene.nu_and_M(z1)
        texts = {**_values(scene), **texts, "nu": _range(nu, ".1f", "°"), "M": _range(M)}
    if other:
        texts = {**_values(scene), **texts}
    if scene.layered:
        texts["N"] = ", ".join(dict.fromkeys(str(sheet.values[sheet.counted]) for sheet in scene.layered))
    glasses = [sheet.values for sheet in scene.layered if sheet.values.get("glass", "none") != "none"]
    if glasses:
        light = "in white light" if isinstance(scene.wavelength, str) else f"at {scene.wavelength:.1f} nm"
        texts["n"] = f"{', '.join(dict.fromkeys(map(_glass, glasses)))} {light}"
    return texts | _set(scene)


def _set(scene: Scene) -> dict[str, str]:
    """Return the parameters of pupil, focus and polarisers that are not the default, as text by name."""
    fields = {name: field for name, field in type(scene).model_fields.items() if name in SET}
    values = {name: getattr(scene, name) for name, field in fields.items() if getattr(scene, name) != field.default}
    return {name: _number(x, ".4g") + _unit(name) if x != "best" else x for name, x in values.items()}


def _glass(values: Mapping[str, Any]) -> str:
    made = values["design_wavelength"]
    return f"{values['index']:.4f} ({values['glass']}{f', made for {made:g} nm' if made != WAVELENGTH else ''})"


def _values(scene: AxialScene) -> dict[str, str]:
    """Return the numbers of the sheets' parameters, as text: for each name those of all windows that have it.

    A number that all windows in series have in common is said once. Two kinds of sheets can have different words
    for a parameter. The name for the later kind is then the parameter's and the kind's, such as "alpha mirror". The
    name for a number in a user's own law is the number's and "law", such as "k law".
    """
    found: dict[str, list[str]] = {}
    words: dict[str, Said | None] = {}
    for sheet in scene.sheets:
        for each, text in _texts(sheet):
            name = each.name if words.setdefault(each.name, each.said) == each.said else f"{each.name} {sheet.name}"
            found.setdefault(name, []).append(text)
        for name, x in sheet.values.get("parameter", {}).items():
            found.setdefault(f"{name} law", []).append(_number(x, ".3g"))
    for name, texts in found.items():
        if len(texts) == len(scene.sheets) > 1 and len({*texts}) == 1:
            found[name] = [f"{texts[0]} in each window"]
    return {name: ", ".join(texts) for name, texts in found.items()}


def _texts(sheet: Sheet) -> Iterator[tuple[Parameter, str]]:
    """Yield the parameters of a sheet that are numbers, without those of its prisms, and the numbers as text."""
    for each in sheet.parameters:
        if each.kind == "number" and each not in PRISMS:
            x = sheet.values[each.name] * (each.said.factor if each.said else 1)
            unit = _unit(each.name)
            yield each, _number(x, ".4g" if unit.startswith("°") else ".3g") + unit


def _range(values: Reals, form: str = ".3g", unit: str = "") -> str:
    """Return the least and the greatest number as text, and '?' if one is NaN (nu at the pole)."""
    numbers = values[~np.isnan(values)]
    ends = dict.fromkeys(_number(end, form) for end in (numbers.min(), numbers.max())) if len(numbers) else ()
    known = [" to ".join(ends) + unit] if len(numbers) else []
    return ", ".join(known if len(numbers) == len(values) else [*known, "?"])


def _number(value: float, form: str) -> str:
    if np.isinf(value):
        return "infinite"
    text = f"{value:z{form}}"  # z: 0.0 in place of -0.0
    return f"{float(text):g}" if "g" in form else text  # 5000 in place of 5e+03
