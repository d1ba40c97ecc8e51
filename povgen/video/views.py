"""A picture that is composed of several frames: two eyes' views, or a transparent background."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from povgen.scene.models import Scene
from povgen.settings import Rendering

Picture = NDArray[np.uint8]


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
    return [scene.replace(eye=eye, background=sky) for eye in eyes for sky in backgrounds]


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

    In linear light, white - black = 1 - alpha, and black = alpha times the colour. Alpha is the greatest of those of
    the three colours.
    """
    darker, lighter = _linear(black), _linear(white)
    alpha = (1 - (lighter - darker).min(axis=2, keepdims=True)).clip(0, 1)
    colour = np.divide(darker, alpha, out=np.zeros_like(darker), where=alpha > 0).clip(0, 1)
    encoded = np.where(colour <= 0.0031308, 12.92 * colour, 1.055 * colour ** (1 / 2.4) - 0.055)
    return np.asarray(255 * np.concatenate((encoded, alpha), axis=2) + 0.5, np.uint8)


def _linear(picture: Picture) -> NDArray[np.float32]:
    """Return the light, 0 to 1, of sRGB bytes."""
    encoded = np.arange(256, dtype=np.float32) / 255
    light = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return np.asarray(light, np.float32)[picture]
