"""Render one picture of a scene, with its caption and overlay if they are asked for."""

from contextlib import closing

import numpy as np
from numpy.typing import NDArray

from povgen.errors import validated
from povgen.rendering.frames import read_png, render_all
from povgen.scene.models import Scene
from povgen.settings import Rendering


def render(scene: Scene, **options: object) -> NDArray[np.uint8]:
    """Return the scene's picture: (height, width, 3) bytes of red, green and blue.

    Options are the fields of `Rendering`. Raises InputError if an option is not allowed, and PovrayError if POV-Ray
    fails.
    """
    rendering = validated(Rendering, options)
    return picture(_frame(scene, rendering), scene, rendering).copy()  # the caller may write to it


def png(scene: Scene, rendering: Rendering | None = None) -> bytes:
    """Return the scene's picture as the bytes of a PNG file. Raises PovrayError if POV-Ray fails."""
    rendering = rendering or validated(Rendering, {})
    plain = _frame(scene, rendering)
    if not rendering.annotated:
        return plain
    from povgen.video import encode

    return encode.png(picture(plain, scene, rendering))


def picture(frame: bytes, scene: Scene, rendering: Rendering) -> NDArray[np.uint8]:
    """Return a rendered frame of the scene as an array, with the caption and overlay that `rendering` asks for."""
    plain = read_png(frame)
    if not rendering.annotated:
        return plain
    from povgen.video.overlay import annotated

    return annotated(plain, scene, rendering)


def _frame(scene: Scene, rendering: Rendering) -> bytes:
    with closing(render_all([scene], rendering)) as frames:
        return next(frames)
