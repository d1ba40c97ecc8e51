"""From a scene to its picture, with what is drawn over it."""

from contextlib import closing

import numpy as np

from povgen.errors import validated
from povgen.rendering.frames import read_png, render_all
from povgen.scene.models import Scene
from povgen.settings import Rendering


def render(scene: Scene, **options) -> np.ndarray:
    """The scene's picture, (height, width, 3) bytes of red, green and blue.

    Options: those of `Rendering`. Raises InputError for options that cannot be, PovrayError where POV-Ray fails.
    """
    rendering = validated(Rendering, options)
    return picture(_frame(scene, rendering), scene, rendering).copy()  # to be written to


def png(scene: Scene, rendering: Rendering | None = None) -> bytes:
    """The scene's picture as a PNG file's bytes. Raises PovrayError where POV-Ray fails."""
    rendering = rendering or validated(Rendering, {})
    plain = _frame(scene, rendering)
    if not rendering.annotated:
        return plain
    from povgen.video import encode

    return encode.png(picture(plain, scene, rendering))


def picture(frame: bytes, scene: Scene, rendering: Rendering) -> np.ndarray:
    """The scene's frame as an array, with the caption and overlay that the rendering asks for."""
    plain = read_png(frame)
    if not rendering.annotated:
        return plain
    from povgen.video.overlay import annotated

    return annotated(plain, scene, rendering)


def _frame(scene: Scene, rendering: Rendering) -> bytes:
    with closing(render_all([scene], rendering)) as frames:
        return next(frames)
