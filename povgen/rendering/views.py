"""A picture that is composed of several frames: two eyes' views, or a transparent background."""

from collections.abc import Callable, Sequence
from itertools import islice, repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError, shown
from povgen.inputs.hdr import encoded
from povgen.optics.camera import Vector
from povgen.optics.opening import Opening
from povgen.rendering import light
from povgen.rendering.light import Picture, linear
from povgen.scene import polarisers, pupil, white
from povgen.scene.presets import AxialScene
from povgen.scene.scene import Scene, checked_class
from povgen.settings import PUPIL_RAYS, Rendering
from povgen.sheets.lenticular import Lenticular
from povgen.sheets.own import OwnLaw
from povgen.sheets.prisms import RANDOM


def views(scene: Scene, rendering: Rendering) -> list[Scene]:
    """Return the scenes of the frames that the scene's picture is composed of, in the order that `composed` takes.

    The left eye comes first. A transparent background takes two frames of each eye: black behind the scene, then white.
    Raises InputError if an eye's place is not allowed, and if `rendering.renderer` is gl, for what gl cannot show. For
    light (`rendering.is_light`), raises InputError if the background is transparent or if the scene has outlines.
    """
    if rendering.renderer == "gl":
        check_gl(scene)
    if rendering.is_light and scene.background == "transparent":
        raise InputError(f"background = 'transparent': not with bits = {rendering.bits}; allowed: bits = 8, or another")
    if rendering.is_light and scene.outlines:
        raise InputError(
            f"{scene.outlines[0]} = true: it is drawn with 8 bits, not {rendering.bits}; allowed: bits = 8"
        )
    half = rendering.eye_distance / 2
    try:
        eyes = [scene] if rendering.stereo == "none" else [scene.seen_from(by) for by in (-half, half)]
    except InputError as error:
        raise InputError(f"eye_distance = {rendering.eye_distance:g}: for one of the two eyes, {error}") from None
    if scene.background != "transparent":
        return eyes
    return [eye.replace(background=sky) for eye in eyes for sky in ("black", "white")]


def fitted(scenes: Sequence[Scene], size: tuple[int, int]) -> list[Scene]:
    """Return the scenes of a movie with their default views for pictures of this size, on one scale in all."""
    views = {
        number: made.view
        for number, scene in enumerate(scenes)
        if isinstance(made := scene.fitted(size), AxialScene) and "view" not in scene.model_fields_set
    }
    if len(set(views.values())) < 2:
        return [scene.fitted(size) for scene in scenes]
    widest = max(views.values())
    return [scene.replace(view=widest) if n in views else scene.fitted(size) for n, scene in enumerate(scenes)]


def frames_of(scene: Scene, rendering: Rendering) -> list[Scene]:
    """Return the scenes that are rendered for each of the `views`, one view after another.

    White light is shown by pictures at several wavelengths. POV-Ray shows an eye with a pupil by pictures from
    PUPIL_RAYS places in it. Through polarisers, each picture has one ray a pixel. Raises as `views` does, and
    InputError if an eye cannot be at one of these places.
    """
    shown = [each for view in views(scene, rendering) for each in white.coloured(view)]
    if not (scene.polarised or scene.pupil and rendering.renderer == "povray"):
        return shown
    rays = PUPIL_RAYS if scene.pupil else polarisers.PLACES
    jitter = [complex(*light.place(number, rays, False)) for number in range(rays)]
    try:
        eyes = [eye for view in shown for eye in pupil.eyes(view, jitter, view.camera.height / rendering.size[1])]
    except InputError as error:
        raise InputError(f"pupil = {scene.pupil:g}: for a place in it, {error}") from None
    return [eye.replace(pupil=0) for eye in eyes] if scene.polarised else eyes


def merged(
    frames: Sequence[bytes], read: Callable[[bytes], NDArray[Any]], scene: Scene, rendering: Rendering
) -> list[NDArray[Any]]:
    """Return the pictures of the `views` from their frames (`frames_of`), which `read` decodes: sums of light."""
    count = len(views(scene, rendering))
    each = len(frames) // count
    if each == 1:
        return [read(frame) for frame in frames]
    colours = white.mixing() if scene.wavelength == white.WHITE else np.eye(3)[None]
    weights = np.repeat(colours * len(colours) / each, each // len(colours), axis=0)
    eyes = frames_of(scene, rendering) if scene.polarised else []
    passed = (polarisers.passed(eye, rendering.size)[..., None] for eye in eyes) if eyes else repeat(np.ones(1))
    pictures = map(read, frames)
    return [light.mixed(islice(pictures, each), weights, passed) for _ in range(count)]


def check_gl(scene: Scene) -> None:
    """Raise InputError for what the live view's shaders do not show."""
    if scene.fresnel:
        raise InputError("fresnel = true: the renderer gl splits no rays; allowed: with --renderer povray")
    if any(isinstance(sheet, Lenticular) and not sheet.is_exact for sheet in scene.sheets):
        raise InputError("error: the renderer gl draws lenses of one pitch; allowed: with --renderer povray")
    for name in RANDOM:
        if any(getattr(sheet, name) for each in scene.layered for sheet in each.glass):
            raise InputError(f"error: {name}: the renderer gl draws equal prisms; allowed: with --renderer povray")
    for opening in scene.openings:
        if isinstance(sheet := opening.sheet, OwnLaw) and not _fits_32_bits(sheet, opening, scene.camera.eye):
            raise InputError(
                f"law = {shown(sheet.values['law'])}: the renderer gl computes with 32-bit numbers; "
                "allowed: parts of 1e-38 to 3e38, or --renderer povray"
            )
    checked_class(scene, "the renderer gl")


def _fits_32_bits(sheet: OwnLaw, opening: Opening, eye: Vector) -> bool:
    """Return whether a law bends most rays alike with 32-bit numbers, as shaders compute it, and with 64 bits."""
    side = np.linspace(-0.47, 0.49, 15)
    place = side * opening.outline.width + 1j * (side * opening.outline.height)[:, None]
    (x, y, z), _ = opening.pose.own(np.array(eye), np.zeros(3))
    ray = np.stack(((place - x).real, place.imag - y, np.full(place.shape, abs(z))), -1)
    right = sheet.bend(ray, place)
    off = np.linalg.norm(sheet.law.bend_in_32_bits(ray, place, sheet.numbers) - right, axis=-1)
    lit = np.isfinite(right[..., 0])
    return not lit.any() or bool((off[lit] < 0.01).mean() > 0.9)


def composed(pictures: Sequence[NDArray[Any]], scene: Scene, rendering: Rendering) -> NDArray[Any]:
    """Return the scene's picture from the pictures of its `views`.

    Pictures are (height, width, 3) bytes, or light. With a transparent background, which light does not have, the
    result is (height, width, 4) bytes: red, green, blue and alpha. A stereo pair is twice as wide.
    """
    if scene.background == "transparent":
        return _transparent(_joined(pictures[::2], rendering), _joined(pictures[1::2], rendering))
    return _joined(pictures, rendering)


def _joined(eyes: Sequence[NDArray[Any]], rendering: Rendering) -> NDArray[Any]:
    """Return one picture from that of each eye. An anaglyph has the left eye's red, the right eye's green and blue."""
    if len(eyes) == 1:
        return eyes[0]

    left, right = eyes
    if rendering.stereo == "anaglyph":
        return np.concatenate((left[..., :1], right[..., 1:]), axis=2)
    return np.concatenate((left, right), axis=1)


def _transparent(black: Picture, white: Picture) -> Picture:
    """Return a picture with alpha from its appearances in front of black and of white.

    In linear light, white - black = 1 - alpha, and black = alpha times the colour. Red, green and blue each give an
    alpha; the greatest of the three is taken.
    """
    darker, lighter = linear(black), linear(white)
    alpha = (1 - (lighter - darker).min(axis=2, keepdims=True)).clip(0, 1)
    colour = np.divide(darker, alpha, out=np.zeros_like(darker), where=alpha > 0).clip(0, 1)
    return np.asarray(np.concatenate((encoded(colour), 255 * alpha), axis=2) + 0.5, np.uint8)
