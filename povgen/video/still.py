"""Render one picture of a scene, with its caption and overlay if they are wanted."""

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from povgen import files
from povgen.rendering.frames import read_png, render_all
from povgen.rendering.views import composed, views
from povgen.scene.models import Scene, checked_scene, piece_files
from povgen.settings import Rendering

if TYPE_CHECKING:
    from PIL.Image import Image


def render(scene: Scene, **options: object) -> NDArray[np.uint8]:
    """Return the scene's picture: (height, width, 3) bytes of red, green and blue, or 4 with alpha if transparent.

    Options are the fields of `Rendering`: size=(640, 480), quality="high" and others. Raises InputError if an option is
    not allowed, and PovrayError if POV-Ray fails.
    """
    scene, rendering = checked_scene(scene), Rendering(**options)
    return picture(_frames(scene, rendering), scene, rendering).copy()  # the caller may write to it


def show(scene: Scene, **options: object) -> "Image":
    """Return the scene's picture as an image of Pillow's, which Jupyter shows. Options and errors are `render`'s."""
    from PIL.Image import fromarray

    return fromarray(render(scene, **options))


def save(scene: Scene, path: str | Path, **options: object) -> Path:
    """Write the scene's picture to a PNG file and return its path. The file is written atomically.

    Options and errors are `render`'s. Raises InputError, before anything is rendered, if the file cannot be written.
    """
    scene, rendering = checked_scene(scene), Rendering(**options)
    output = files.checked_output(path, [".png"], inputs=piece_files([scene]))
    target = output.resolve()  # the current folder may change meanwhile
    files.save(png(scene, rendering), target)
    return output


def png(scene: Scene, rendering: Rendering | None = None) -> bytes:
    """Return the scene's picture as the bytes of a PNG file. Raises PovrayError if POV-Ray fails."""
    rendering = rendering or Rendering()
    frames = _frames(scene, rendering)
    if len(frames) == 1 and not rendering.annotated:
        return frames[0]
    from povgen.video import encode

    return encode.png(picture(frames, scene, rendering))


def picture(frames: Sequence[bytes], scene: Scene, rendering: Rendering) -> NDArray[np.uint8]:
    """Return the scene's picture from the rendered frames of its `views`, as `render` does.

    Each frame gets the caption and the overlay that `rendering` asks for.
    """
    pictures = [read_png(frame) for frame in frames]
    if rendering.annotated:
        from povgen.video.overlay import annotated

        shown = views(scene, rendering)
        pictures = [annotated(plain, view, rendering) for plain, view in zip(pictures, shown, strict=True)]
    return composed(pictures, scene, rendering)


def _frames(scene: Scene, rendering: Rendering) -> list[bytes]:
    with closing(render_all([scene], rendering)) as rendered:
        return next(rendered)
