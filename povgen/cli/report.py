"""The command line's messages and warnings."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

from povgen import remedies
from povgen.objects.window import Window
from povgen.progress import say
from povgen.rendering import survey_cache
from povgen.rendering.views import views
from povgen.scene.presets import AxialScene, used_parameters
from povgen.scene.scene import Scene
from povgen.scene.warnings import warnings
from povgen.scene.windows import FurtherWindow
from povgen.settings import Rendering
from povgen.sheets import PARAMETERS, SHEETS, USED_BY
from povgen.sheets.layered import Layered
from povgen.sheets.own import OwnLaw
from povgen.sheets.sheet import Sheet

# headings of docs/troubleshooting.md, by the names of the limits of povgen.scene.warnings
SYMPTOMS = {
    "z2": "little-to-see",
    "window": "little-to-see",
    "alpha": "dark-bands",
    "sheet": "black-window-or-a-wrong-one",
}
SYMPTOMS |= dict.fromkeys(("prisms", "lenses", "periods"), "noise")
SYMPTOMS |= dict.fromkeys(("predicted_image", "overlay", "caption"), "prediction-warning")


def warn(values: Mapping[str, Any], scenes: Sequence[Scene], rendering: Rendering | None = None) -> None:
    """Print a warning for each option of `values` that changes nothing, and for each limit that scenes exceed."""
    warn_unused(values, scenes)
    texts_by_limit: dict[str, list[str]] = {}
    shown = [views(scene, rendering) if rendering else [scene] for scene in scenes]
    if rendering:
        survey_cache.make(chain(*shown))
    for several in shown:
        found: dict[str, str] = {}
        for view in several:
            found = dict(warnings(view, rendering, survey_cache.found(view) if rendering else None)) | found
        for limit, text in found.items():
            texts_by_limit.setdefault(limit, []).append(text)
    for limit, texts in texts_by_limit.items():
        more = f"; {remedies.page(SYMPTOMS[limit])}" if limit in SYMPTOMS else ""
        also = f" (in {len(texts)} of {len(scenes)} frames)" if len(scenes) > 1 else ""
        say(f"povgen: warning: {texts[0]}{more}{also}")


def warn_unused(values: Mapping[str, Any], scenes: Sequence[Scene]) -> None:
    """Print a warning for each option that a user gave and that changes nothing in these scenes."""
    layered = tuple(name for name, kind in SHEETS.items() if issubclass(kind, Layered))
    others = {"fresnel": layered, "wavelength": USED_BY["glass"]}
    sheets = {sheet.name for scene in scenes for sheet in scene.sheets}
    used = {name for scene in scenes for name in used_parameters(scene)}
    used |= {name for name, kinds in others.items() if sheets & {*kinds}}
    used_by = {**USED_BY, **others}
    for name, value in values.items():
        if scenes and name in used_by and value is not False and name not in used:
            shown = "" if value is None else f" = {'true' if value is True else value}"
            *kinds, last = used_by[name]
            allowed = " or ".join(filter(None, [", ".join(kinds), last]))
            given = ", ".join(dict.fromkeys(sheet.name for sheet in scenes[0].sheets)) or "none"
            say(f"povgen: warning: {name}{shown}: no effect with sheet = {given}; it is for {allowed}")
    if values.get("sky") and scenes and not any(scene.background == "sky" for scene in scenes):
        say(f"povgen: warning: sky: no effect with background = {scenes[0].background}; it is for sky")
    if values.get("focus") and scenes and not any(scene.pupil for scene in scenes):
        say("povgen: warning: focus: no effect with pupil = 0; it is for larger pupils")
    for text in dict.fromkeys([*_unused_in_windows(scenes, values), *_unused_in_rooms(scenes, values)]):
        say(f"povgen: warning: {text}")


def _unused_in_windows(scenes: Sequence[Scene], values: Mapping[str, Any]) -> Iterator[str]:
    """Yield a text for each parameter of a further window, or of a law, that the user gave and that changes nothing."""
    shared: set[str] = set()  # the names in the laws whose numbers are the scene's
    stated: set[str] = set()  # the numbers of laws that the scene states
    for scene in scenes:
        if isinstance(scene, AxialScene):
            stated |= scene.parameter.keys()
            for sheet, own in zip(scene.sheets, (None, *scene.window), strict=True):
                if isinstance(sheet, OwnLaw) and (own is None or own.parameter is None):
                    shared |= sheet.law.names
        for name, window, sheet in _with_own_parameters(scene) if "window" in values else ():
            used = {each.name for each in sheet.parameters} | Window.model_fields.keys() - PARAMETERS.keys()
            for unused in sorted(window.model_fields_set - used):
                yield f"{name}: {unused}: no effect with sheet = {sheet.name}"
            if isinstance(sheet, OwnLaw) and "parameter" in window.model_fields_set:
                for lost in sorted((window.parameter or {}).keys() - sheet.law.names):
                    yield f"{name}: parameter: {lost}: no effect, because its law lacks it"
    for lost in sorted(stated - shared) if "parameter" in values and shared else ():
        yield f"parameter: {lost}: no effect, because no law contains it"


def _unused_in_rooms(scenes: Sequence[Scene], values: Mapping[str, Any]) -> Iterator[str]:
    """Yield a text for each number of a room's window that is swept and changes nothing."""
    for name, part in [each for scene in scenes for each in scene.parts.items()]:
        if isinstance(part, Window):
            for unused in sorted(part.without_effect):
                if f"{name}.{unused}" in values:
                    yield f"{name}.{unused}: no effect with sheet = {part.optics.name}"


def _with_own_parameters(scene: Scene) -> list[tuple[str, FurtherWindow | Window, Sheet]]:
    """Return the windows that state parameters of their own: how messages name them, and their sheets."""
    if isinstance(scene, AxialScene):
        further = zip(scene.window, scene.sheets[1:], strict=True)
        return [(f"window {n}", window, sheet) for n, (window, sheet) in enumerate(further, 2)]
    windows = {name: part for name, part in scene.parts.items() if isinstance(part, Window)}
    return [(name, window, window.optics) for name, window in windows.items()]
