"""A picture that is composed of several frames: two eyes' views, or a transparent background."""

from collections.abc import Sequence

import numpy as np

from povgen.errors import InputError
from povgen.rendering.light import Picture, encoded, linear
from povgen.scene.models import Scene
from povgen.settings import Rendering


def views(scene: Scene, rendering: Rendering) -> list[Scene]:
    """Return the scenes of the frames that the scene's picture is composed of, in the order that `composed` takes.

    The left eye comes first. A transparent background takes two frames of each eye: black behind the scene, then white.
    Raises InputError if an eye's place is not allowed.
    """
    x, y = scene.eye
    half = rendering.eye_distance / 2
    eyes = [(x, y)] if rendering.stereo == "none" else [(x - half, y), (x + half, y)]
    backgrounds = ["black", "white"] if scene.background == "transparent" else [scene.background]
    if len(eyes) * len(backgrounds) == 1:
        return [scene]
    try:
        return [scene.replace(eye=eye, background=sky, view=scene.view) for eye in eyes for sky in backgrounds]
    except InputError as error:
        raise InputError(f"eye_distance = {rendering.eye_distance:g}: for one of the two eyes, {error}") from None


def composed(pictures: Sequence[Picture], scene: Scene, rendering: Rendering) -> Picture:
    """Return the scene's picture from the pictures of its `views`.

    Pictures are (height, width, 3) bytes. With a transparent background the result is (height, width, 4) bytes: red,
    green, blue and alpha. A stereo pair is twice as wide.
    """
    transparent = scene.background == "transparent"
    if not transparent:
        eyes = list(pictures)
    elif rendering.stereo == "anaglyph":
        eyes = [_transparent(_anaglyph(pictures[0], pictures[2]), _anaglyph(pictures[1], pictures[3]))]
    else:
        eyes = [_transparent(black, white) for black, white in zip(pictures[::2], pictures[1::2], strict=True)]
    if len(eyes) == 1:
        return eyes[0]
    return _anaglyph(*eyes) if rendering.stereo == "anaglyph" else np.concatenate(eyes, axis=1)


def _anaglyph(left: Picture, right: Picture) -> Picture:
    """Return a picture with the left eye's red, and the right eye's green and blue."""
    return np.concatenate((left[..., :1], right[..., 1:]), axis=2)


def _transparent(black: Picture, white: Picture) -> Picture:
    """Return a picture with alpha from its appearances in front of black and of white.

    In linear light, white - black = 1 - alpha, and black = alpha times the colour. Each colour gives an alpha;
    the greatest of the three is taken.
    """
    darker, lighter = linear(black), linear(white)
    alpha = (1 - (lighter - darker).min(axis=2, keepdims=True)).clip(0, 1)
    colour = np.divide(darker, alpha, out=np.zeros_like(darker), where=alpha > 0).clip(0, 1)
    return np.asarray(np.concatenate((encoded(colour), 255 * alpha), axis=2) + 0.5, np.uint8)
