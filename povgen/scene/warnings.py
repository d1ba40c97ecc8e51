"""Warnings: the limits of the methods that a picture exceeds. The limits are in povgen/limits.py."""

import re
from collections.abc import Iterator

import numpy as np

from povgen.inputs.pieces import PieceFile, without_comments
from povgen.limits import (
    MAX_CONDITION,
    MAX_ERROR,
    MAX_FACES,
    MIN_DESIGNED_FRACTION,
    MIN_PIXELS_PER_PRISM,
    moire_alpha,
)
from povgen.optics import uncertainty
from povgen.optics.trace import End
from povgen.optics.window_trace import MOST_CROSSINGS
from povgen.scene.cells import camera_cells, grid_error, is_dark, jumps
from povgen.scene.presets import AxialScene, pieces
from povgen.scene.scene import Scene, is_empty
from povgen.scene.survey import Survey, survey
from povgen.settings import Rendering
from povgen.sheets.layered import Layered
from povgen.sheets.prisms import SHAPE, Prisms

# in a piece's file: only POV-Ray shows them
TEXTURES = {"pigment", "texture", "finish", "material"}
UNUSUAL = (*SHAPE, "ratio", "f_number")  # a warning states these, if they differ from their defaults


def warnings(
    scene: Scene, rendering: Rendering | None = None, found: Survey | None = None
) -> Iterator[tuple[str, str]]:
    """Yield, for each limit that a picture of the scene exceeds, the name of the parameter and a sentence.

    Without `rendering`, limits that depend on it, such as on the size of the picture, are not checked. `found` is the
    result of `survey`, if it is known already. If it is None, rays are traced.
    """
    yield from _of_pieces(scene, rendering)
    designed = (found or survey(scene)).designed if scene.has_prisms else 1
    yield from _of_axis(scene, designed) if isinstance(scene, AxialScene) else _of_room(scene, designed)
    yield from _moire(scene)
    if isinstance(scene, AxialScene):
        yield from _of_predictions(scene, rendering)
    if rendering and rendering.antialias is None:
        yield from _noise(scene, rendering)


def _of_room(scene: Scene, designed: float) -> Iterator[tuple[str, str]]:
    """Yield warnings of rays that go round between windows, and of prisms through which little is seen."""
    ends = scene.trace(scene.rays((64, 48)), MAX_FACES).end
    if (lost := float((ends == End.UNFINISHED).mean())) > 0.001:
        text = f"window: {100 * lost:.2g} % of the picture is black: these rays meet more than {MOST_CROSSINGS} windows"
        yield "window", f"{text}, or {MAX_FACES} faces of prisms"
    if designed < MIN_DESIGNED_FRACTION:
        text = f"window: at most {100 * designed:.3g} % of a window shows light on the {_things(scene)}' designed path,"
        yield "window", f"{text} other light is stray light or lost"


def _noise(scene: Scene, rendering: Rendering) -> Iterator[tuple[str, str]]:
    """Yield a warning for the prisms or periods that are narrowest in the picture, if pixels cannot show them."""
    camera = scene.camera
    along = np.cross(camera.right, camera.up)
    middle = along @ np.subtract(camera.middle, camera.eye)
    narrowest = (MIN_PIXELS_PER_PRISM, "", "")
    for opening in scene.openings:
        away = along @ (opening.pose.place - camera.eye)
        if isinstance(sheet := opening.sheet, Layered) and away > 0:
            pixels = float(sheet.pitch / camera.height * rendering.size[1] * middle / away)
            thing = "prism" if isinstance(sheet, Prisms) else "period"
            text = f"{sheet.counted} = {sheet.values[sheet.counted]}: a {thing} is {pixels:.2g} pixels wide;"
            narrowest = min(narrowest, (pixels, sheet.counted, text))
    if narrowest[1]:
        text = f"{narrowest[2]} below {MIN_PIXELS_PER_PRISM} pixels, without antialiasing, the picture is noise"
        yield narrowest[1], text


def _of_axis(scene: AxialScene, designed: float) -> Iterator[tuple[str, str]]:
    """Yield a warning if the windows show little light on the designed path."""
    if designed < MIN_DESIGNED_FRACTION:
        eye = " and an eye at {:g},{:g}".format(*scene.eye) if scene.E else ""
        shapes = [(name, sheet.values[name]) for name in UNUSUAL for sheet in scene.layered if name in sheet.values]
        unusual = {name: x for name, x in shapes if x != type(scene).model_fields[name].default}
        if "glass" in unusual:
            unusual.pop("index", None)  # the glass decides it
        stated = "".join(f", {name} = {x if isinstance(x, str) else f'{x:g}'}" for name, x in unusual.items())
        text = f"z2 = {scene.z2:g}{eye}{stated}: {100 * designed:.3g} % of the window shows light on the"
        text += f" {_things(scene)}' designed path,"
        least = f"{100 * MIN_DESIGNED_FRACTION:.0f} %"
        yield "z2", f"{text} other light is stray light or lost; below {least} little of the scene is visible"


def _moire(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield a warning for each pair of sheets whose prisms or lenses are nearly parallel."""
    for sheet in scene.sheets:
        alpha = sheet.values.get("alpha", 0.0)
        turn = sheet.values.get("error", {}).get("turn", 0)  # the near sheet is turned by alpha/2 + turn
        if not isinstance(sheet, Layered) or sheet.layers < 2:
            continue
        below = moire_alpha(float(sheet.values[sheet.counted]))
        if abs((alpha + 2 * turn + 180) % 360 - 180) >= below:
            continue
        value = f"alpha + 2 turn = {alpha + 2 * turn:.3g}" if turn else f"alpha = {alpha:.3g}"
        text = f"{value}: within {below:.2g} degrees of 0 the {sheet.counted} of the two sheets are nearly"
        yield "alpha", f"{text} parallel and make dark bands (moire)"


def _of_predictions(scene: AxialScene, rendering: Rendering | None) -> Iterator[tuple[str, str]]:
    """Yield warnings of predictions that can be wrong, of darkness, and of rays that jump."""
    if scene.has_prisms or scene.rotates:
        yield from _wrong_prediction(scene, rendering)
    if not scene.rotates:
        yield from _no_light(scene, rendering)
        yield from _jumps(scene, rendering)


def _of_pieces(scene: Scene, rendering: Rendering | None) -> Iterator[tuple[str, str]]:
    """Yield what a user should know of the pieces from files."""
    shown = [piece for piece in pieces(scene).values() if isinstance(piece, PieceFile)]
    if notes := [f"piece = {str(piece)!r}: {piece.note}" for piece in shown if piece.note]:
        yield "piece", "; ".join(notes)
    if not (rendering and rendering.renderer == "gl"):
        return
    coloured = [
        piece for piece in shown if not piece.is_mesh and TEXTURES & {*re.findall(r"\w+", without_comments(piece.text))}
    ]
    if coloured:
        text = f"renderer = gl: the textures in {str(coloured[0])!r} are not drawn; the piece has the colour --color,"
        yield "renderer", f"{text} with --renderer povray its own"


def _things(scene: Scene) -> str:
    return "prisms" if any(isinstance(sheet, Prisms) for sheet in scene.layered) else "lenses"


def _no_light(scene: AxialScene, rendering: Rendering | None) -> Iterator[tuple[str, str]]:
    """Yield a warning if no light passes the ideal windows, and one for each object that the overlay cannot mark."""
    if is_empty(scene):
        return

    if scene.ideal and is_dark(scene):
        names = dict.fromkeys(name for sheet in scene.ideal for name in sheet.values)
        by = f"{', '.join(names)}, z2 and eye"
        kinds = ", ".join(dict.fromkeys(sheet.name for sheet in scene.ideal))
        yield "sheet", f"sheet = {kinds}: no light passes through the window, because of {by}"
    for (L, z1), radius in zip(scene.objects, scene.radii, strict=True) if rendering and rendering.overlay else ():
        if not np.isfinite(scene.apparent_position(L, z1, near=radius)):
            text = f"overlay: at z1 = {z1:g} the object has no mark: it appears at infinity,"
            yield "overlay", f"{text} or none of its light reaches the eye"


def _jumps(scene: AxialScene, rendering: Rendering | None) -> Iterator[tuple[str, str]]:
    """Yield a warning if POV-Ray's camera interpolates over more than two pixels where rays jump."""
    if not rendering or rendering.renderer == "gl" or not (found := jumps(scene)).share:
        return
    wide = min(found.step, scene.aperture / camera_cells(scene)) / scene.view * rendering.size[1]
    if wide > 2:
        names = ", ".join(dict.fromkeys(sheet.name for sheet in scene.ideal))
        where = f"sheet = {names}: in {100 * found.share:.2g} % of the window, neighbouring rays differ much in"
        yield (
            "sheet",
            f"{where} direction; POV-Ray's picture is wrong there by up to {wide:.2g} pixels; allowed: renderer = gl",
        )


def possible_error(scene: AxialScene, L: complex, z1: float, radius: float) -> float:
    """Return by how many pixels of 1280x960 the prediction for an object behind prisms can be wrong.

    L (complex), z1 and `radius` are those of the object, in tiles. The result is infinite if it appears at infinity.
    """
    P = complex(scene.apparent_position(L, z1, near=radius))
    return uncertainty.possible_error(P, scene.E, z1, radius, scene.elements) / scene.view * 960


def _wrong_prediction(scene: AxialScene, rendering: Rendering | None) -> Iterator[tuple[str, str]]:
    """Yield a warning for the worst object if the predicted image, overlay or caption can be wrong by too much.

    The limit is MAX_ERROR for prisms and lenses, and 1 pixel for ideal sheets, both in pixels of 1280x960.
    """
    shows = {
        "predicted_image": "predicted_image" in scene.outlines,
        "overlay": rendering and rendering.overlay,
        "caption": rendering and rendering.caption == "full" and scene.rotates,
    }
    names = [name for name, shown in shows.items() if shown]
    if not names:
        return
    errors = []
    for (L, z1), radius in zip(scene.objects, scene.radii, strict=True):
        if scene.has_prisms:
            what = f"the {_things(scene)}' size" + ("" if _things(scene) == "prisms" else " and aberrations")
            errors.append((possible_error(scene, L, z1, radius), MAX_ERROR, z1, what))
        else:
            # Two errors, in pixels. Up to M = MAX_CONDITION eq. 7 is right to one pixel. grid_error is that of the
            # camera, which interpolates rays in the cells of its mesh.
            M = float(scene.nu_and_M(z1)[1])
            cells = camera_cells(scene)
            error = max(M / MAX_CONDITION, grid_error(scene, cells) if cells > 1 else 0)
            errors.append((error, 1, z1, f"the magnification of the object, {M:.3g} times"))
    error, limit, z1, cause = max(errors, key=lambda each: each[0])
    if error > limit:
        where = f"alpha = {scene.alpha:g} and " * scene.rotates + f"z1 = {z1:g}"
        much = f"by up to {error:.3g} pixels of 1280x960" if error < 1280 else "by more than the picture's width"
        yield names[0], f"{', '.join(names)}: at {where} the prediction can be wrong {much}, because of {cause}"
