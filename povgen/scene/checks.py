"""Checks of a scene's parameters together. Each raises ValueError with what is wrong and what is allowed."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from itertools import combinations, pairwise
from math import ceil, inf
from typing import Any

import numpy as np

from povgen.errors import at_least, at_most, shown
from povgen.objects.piece import Piece
from povgen.objects.placed import Placed
from povgen.objects.window import Window
from povgen.optics import glasses
from povgen.optics.equations import Floats
from povgen.optics.prism import Prism
from povgen.scene import white
from povgen.scene.eye_and_windows import EyeAndWindows
from povgen.scene.windows import FurtherWindow, has_glass
from povgen.sheets.law_grammar import Law
from povgen.sheets.layered import Layered
from povgen.sheets.lenticular import Lenticular
from povgen.sheets.parameters import INDEX, WAVELENGTH, design_index
from povgen.sheets.prisms import SHAPE, PrismPair, Prisms
from povgen.sheets.sheet import Sheet

MAX_DEPTH = 100  # of the sheets, tiles
MAX_DISTANCE = 5e6  # POV-Ray's units; its own limit is 10 million


def check(scene: EyeAndWindows) -> None:
    """Check the eye and the windows, and set the index of named glasses."""
    _find_indices(scene)
    for number, (window, sheet) in enumerate(zip(scene.parameter_sets, scene.sheets, strict=True), 1):
        with _named(number):
            _check_shape(scene.values_of(window, SHAPE), window is scene, window, sheet)
            _check_depth(sheet, bool(scene.window))
            law, parameter = scene.values_of(window, ("law", "parameter")).values()
            _check_law(law, tuple(parameter.items()))
    _check_places(scene)
    if scene.polarised and any(sheet.name != "none" for sheet in scene.ideal):
        raise ValueError("polariser, analyser: an ideal sheet has no polarisation; allowed: prisms, lenses or none")
    if scene.polarised and scene.fresnel:
        raise ValueError("fresnel = true: rays would split; allowed: without polariser and analyser")


def check_clear(scene: EyeAndWindows, what: str, z1: float, nearest: float) -> None:
    if z1 <= nearest:
        raise ValueError(
            f"z1 = {z1:g}: {what} would touch the window frame around the sheets, whose back is at "
            f"z = {scene.places[-1] + scene.depth / 2:.4g} tiles; allowed: z1 > {at_least(nearest)}"
        )
    if z1 > farthest(scene):
        counts = {sheet.values[sheet.counted]: sheet.counted for sheet in scene.layered}
        what = f"with {max(counts)} {counts[max(counts)]}" if counts else f"behind z = {scene.places[-1]:g}"
        raise ValueError(f"z1 = {z1:g}: beyond POV-Ray's range {what}; allowed: z1 <= {at_most(farthest(scene))}")


def farthest(scene: EyeAndWindows) -> float:
    """Return the greatest z1, tiles."""
    return MAX_DISTANCE / scene.tile - scene.places[-1]


@contextmanager
def _named(number: int) -> Iterator[None]:
    """Begin the message of a ValueError with the number of the window that it is about, if it is not the first one."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"window {number}, {error}" if number > 1 else str(error)) from None


def _index_of(window: EyeAndWindows | FurtherWindow | Window, wavelength: float | str) -> float | None:
    """Return the refractive index of a window's prisms, or None if the window uses that of the first window.

    For white light it is that at WAVELENGTH.
    """
    given: float | None = window.index
    if not has_glass(window):
        return given
    needed = (*white.ENDS, WAVELENGTH) if isinstance(wavelength, str) else (wavelength,)
    *_, index = [glasses.index(str(window.glass), each * 1e-9) for each in needed]
    if "index" in window.model_fields_set and given != index:
        raise ValueError(f"index = {given:g}, glass = {window.glass!r}: allowed: one of them")
    return index


def for_no_glass(name: str, wavelength: float | str) -> str:
    """Return the message about a wavelength that has no effect."""
    stated = wavelength if isinstance(wavelength, str) else f"{wavelength:g}"
    return f"{name} = {stated}: needs a glass; allowed: with one, such as glass = BK7"


def _find_indices(scene: EyeAndWindows) -> None:
    """Set the index of named glasses for light. Checks, renderers and predictions then need the index alone."""
    object.__setattr__(scene, "index", _index_of(scene, scene.wavelength))  # the model is frozen
    scene.model_fields_set.discard("index" if scene.glass != "none" else "")
    found: list[FurtherWindow] = []
    for number, window in enumerate(scene.window, 2):
        own = window.model_copy()
        if own.glass is None and own.index is not None:  # else it would get the first window's glass, and its index
            object.__setattr__(own, "glass", "none")
        if own.glass == "none" and own.index is None and has_glass(scene):  # the first window's index is its glass's
            object.__setattr__(own, "index", INDEX.default)
        with _named(number):
            object.__setattr__(own, "index", _index_of(own, scene.wavelength))
        if has_glass(own):  # the index is found, not given
            own.model_fields_set.discard("index")
        found.append(own)
    object.__setattr__(scene, "window", tuple(found))
    for name in ("wavelength", "design_wavelength") if not any(map(has_glass, (scene, *found))) else ():
        if (value := getattr(scene, name)) != WAVELENGTH:
            raise ValueError(for_no_glass(name, value))


def _check_shape(
    values: Mapping[str, Any], is_first: bool, window: EyeAndWindows | FurtherWindow | Window, sheet: Sheet
) -> None:
    if not is_first and window.design_wavelength is not None and values["glass"] == "none":
        raise ValueError(for_no_glass("design_wavelength", window.design_wavelength))
    planned = Prism(1.0, design_index(values), values["base_angle"], aspect=values["aspect"])
    if not is_first and not isinstance(sheet, Prisms):  # the first shape is checked even if no window has prisms
        return
    if planned.aspect == 2:
        raise ValueError("aspect = 2: no light would take the designed path; allowed: below 2")
    if planned.aspect <= (least := planned.least_aspect):
        raise ValueError(
            f"aspect = {planned.aspect:g}: the slanted facets of prisms with index = {planned.index:g} "
            f"and base_angle = {planned.base_angle:g} would cross; allowed: {at_least(least)} < aspect < 2"
        )


def _check_depth(sheet: Sheet, must_be_exact: bool) -> None:
    if isinstance(sheet, (PrismPair, Lenticular)):
        sheet.check_errors()
    depth = sheet.depth  # raises for lenses of a shape that does not exist
    if must_be_exact and not sheet.is_exact:
        raise ValueError("error: only for a single window, of chess or spheres; allowed: no errors")
    if depth > MAX_DEPTH:
        assert isinstance(sheet, Layered)  # others have no depth
        what = "prisms" if isinstance(sheet, Prisms) else "profile"
        raise ValueError(
            f"{sheet.counted} = {sheet.values[sheet.counted]}: with this shape of the {what} and "
            f"a window of {sheet.aperture:g} tiles the sheets would be {depth:.4g} tiles deep; "
            f"allowed: up to {MAX_DEPTH} tiles, as with more {sheet.counted}"
        )


@lru_cache(maxsize=256)  # of many scenes, most have the same
def _check_law(text: str, parameters: tuple[tuple[str, float], ...]) -> None:
    """Check a window's law, even if its sheet has none."""
    try:
        Law(text, values := dict(parameters)).check_divisions(values)
    except ValueError as error:
        raise ValueError(f"law = {shown(text)}: {error}") from None


def _check_places(scene: EyeAndWindows) -> None:
    nearest = scene.depth / 2 + 0.01
    if scene.z2 <= nearest:
        raise ValueError(
            f"z2 = {scene.z2:g}: the eye would be inside the window frame; allowed: z2 > {at_least(nearest)}"
        )
    for number, (before, z) in enumerate(pairwise(scene.places), 2):
        least = before + scene.depth + 0.01
        if z <= least:
            raise ValueError(
                f"window {number}, z = {z:g}: its frame would touch that of the window before, at z = {before:g}; "
                f"allowed: z > {at_least(least)}"
            )
    if any(sheet.layers for sheet in scene.sheets[: len(scene.ideal)]):
        raise ValueError(
            "window: prisms or lenses stand in front of an ideal sheet or an empty window; allowed: prisms and lenses "
            "in the last windows, or in a room"
        )


# ---- Rooms


def with_index(window: Window, wavelength: float | str) -> Window:
    """Return a room's window, checked, with the index of its glass for this wavelength."""
    made = window.model_copy()
    object.__setattr__(made, "index", _index_of(made, wavelength))  # the model is frozen
    if has_glass(made):  # the index is found, not given
        made.model_fields_set.discard("index")
    elif made.design_wavelength != WAVELENGTH:
        raise ValueError(for_no_glass("design_wavelength", made.design_wavelength))
    sheet = made.optics
    _check_shape({name: getattr(made, name) for name in SHAPE}, True, made, sheet)
    _check_depth(sheet, True)  # a room's text for POV-Ray builds all sheets exactly
    _check_law(made.law, tuple(made.parameter.items()))
    return made


def check_apart(things: Mapping[str, Placed], eye: Sequence[float]) -> None:
    """Check that no two of a room's objects and windows overlap, and that the eye is in none of them.

    Boxes around them are compared. Edges and sides may touch.
    """
    boxes = {name: _box(thing) for name, thing in things.items() if thing.box != ((0, 0, 0), (0, 0, 0))}  # no floor
    for name, (middle, axes, half) in boxes.items():
        if (abs(axes @ (np.asarray(eye) - middle)) < half).all() and not isinstance(things[name], Piece):
            place = ", ".join(f"{x:g}" for x in eye)
            raise ValueError(f"eye = {place}: inside {name}; allowed: outside all objects and windows")
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        if (depth := _overlap(a, b)) > 1e-6:
            here, there = (", ".join(f"{x:g}" for x in things[name].pose[:3]) for name in (one, other))
            more = f"{ceil(1000 * depth - 1e-3) / 1000:g} tiles farther apart" if depth < inf else "other places"
            raise ValueError(f"{one}, at {here}, and {other}, at {there}: they overlap; allowed: {more}")


Solid = tuple[Floats, Floats, Floats]  # the middle of a box (3,), its axes as rows (3, 3), half its sides (3,)


def _box(thing: Placed) -> Solid:
    lower, upper = np.array(thing.box)
    axes = thing.pose.axes
    return thing.pose.place + (lower + upper) / 2 @ axes, axes, (upper - lower) / 2


def _overlap(a: Solid, b: Solid) -> float:
    """Return by how much two boxes overlap along the line between their middles; 0: not at all.

    It is infinite if their middles are in one place. By the theorem of the separating axis: normals of both boxes'
    faces, and their cross products.
    """
    (p, u, g), (q, v, h) = a, b
    if np.linalg.norm(q - p) >= np.linalg.norm(g) + np.linalg.norm(h):  # the spheres around them do not
        return 0.0
    across = np.cross(u[:, None], v[None]).reshape(-1, 3)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    axes = np.concatenate((u, v, across[length[:, 0] > 1e-9] / length[length[:, 0] > 1e-9]))
    reach = abs(axes @ u.T) @ g + abs(axes @ v.T) @ h
    apart = abs(axes @ (q - p))
    if (apart >= reach).any():
        return 0.0
    more = (reach - apart)[apart > 0] / apart[apart > 0]
    return float(min(more) * np.linalg.norm(q - p)) if len(more) else inf
