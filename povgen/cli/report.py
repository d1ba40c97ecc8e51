"""The command line's messages and warnings."""

from typing import TYPE_CHECKING

from povgen.progress import say

if TYPE_CHECKING:
    from povgen.cli.options import Values
    from povgen.scene.scenes import Scene
    from povgen.settings import Rendering


def message_of(error: Exception) -> str:
    """Return an error's message. For a file it is the file's name and the reason, without errno."""
    if isinstance(error, OSError) and error.strerror:
        file = error.filename2 or error.filename  # of two files, the second is written
        return f"{file}: {error.strerror}" if file else error.strerror
    return str(error)


def warn(values: "Values", scenes: list["Scene"], rendering: "Rendering | None" = None) -> None:
    """Print a warning for each option of `values` that changes nothing, and for each limit that scenes exceed."""
    from povgen.scene.warnings import warnings

    _warn_unused(values, scenes)
    if rendering:
        from povgen.rendering import surveys
        from povgen.rendering.views import views
    texts_by_limit: dict[str, list[str]] = {}
    for scene in scenes:
        found: dict[str, str] = {}
        for view in views(scene, rendering) if rendering else [scene]:
            found = dict(warnings(view, rendering, surveys.found(view) if rendering else None)) | found
        for limit, text in found.items():
            texts_by_limit.setdefault(limit, []).append(text)
    for texts in texts_by_limit.values():
        also = f" (in {len(texts)} of {len(scenes)} frames)" if len(scenes) > 1 else ""
        say(f"povgen: warning: {texts[0]}{also}")


def _warn_unused(values: "Values", scenes: list["Scene"]) -> None:
    """Print a warning for each option that a user gave and that changes nothing in these scenes."""
    from povgen.sheets import SHEETS, USED_BY
    from povgen.sheets.layered import Layered

    layered = tuple(name for name, kind in SHEETS.items() if issubclass(kind, Layered))
    used_by = {**USED_BY, "fresnel": layered, "wavelength": USED_BY["glass"]}
    sheets = {sheet.name for scene in scenes for sheet in scene.sheets}
    for name, value in values.items():
        if sheets and name in used_by and value is not False and not sheets & {*used_by[name]}:
            shown = "true" if value is True else value
            *others, last = used_by[name]
            allowed = " or ".join(filter(None, [", ".join(others), last]))
            say(f"povgen: warning: {name} = {shown}: no effect with sheet = {scenes[0].sheet}; it is for {allowed}")
    for text in dict.fromkeys(text for scene in scenes for text in _unused_in(scene, values)):
        say(f"povgen: warning: {text}")


def _unused_in(scene: "Scene", values: "Values") -> list[str]:
    """Return texts about the numbers of further windows, and of laws, that change nothing."""
    from povgen.sheets.own import OwnLaw

    found = []
    further = zip(scene.window, scene.sheets[1:], strict=True) if "window" in values else ()
    for n, (window, sheet) in enumerate(further, 2):
        unused = window.model_fields_set - {each.name for each in sheet.parameters} - {"z", "sheet"}
        found += [f"window {n}: {name}: no effect with sheet = {sheet.name}" for name in sorted(unused)]
    for sheet in scene.sheets if values.keys() & {"parameter", "law", "window"} else ():
        if isinstance(sheet, OwnLaw):
            unused = sheet.values["parameter"].keys() - sheet.law.names
            found += [f"parameter: {name}: no effect, because the law does not contain it" for name in sorted(unused)]
    return found


def tell_if_long(scenes: list["Scene"], rendering: "Rendering") -> None:
    """Say how long rendering takes, if that is more than a minute."""
    from povgen.rendering.estimate import describe, is_long

    if is_long(scenes, rendering):
        say(f"povgen: {describe(scenes, rendering)}")
