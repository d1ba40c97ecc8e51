"""The live view's shaders, run by OpenGL without a browser: for measurements, and for the points that pixels show."""

import json
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError
from povgen.rendering import gl_runner, gl_scene
from povgen.rendering.views import check_gl
from povgen.rendering.volumes import volumes
from povgen.scene.pictures import used
from povgen.scene.scenes import Scene, checked_scene, pieces
from povgen.settings import Rendering

if TYPE_CHECKING:  # needs moderngl
    from povgen.rendering.gl import Drawer

Size = tuple[int, int]  # width and height, pixels
T = TypeVar("T")
FORKED = "this process was forked after its parent had drawn with OpenGL; allowed: the start method spawn or forkserver"


@cache
def _thread() -> tuple[ThreadPoolExecutor, int]:
    """Return the thread that draws for all others, and its process. An OpenGL context belongs to one thread."""
    gl_runner.device()  # raises InputError if something is missing
    return ThreadPoolExecutor(1, "povgen-opengl"), os.getpid()


@cache
def _drawer() -> "Drawer":
    from povgen.rendering.gl import Drawer

    return Drawer()


def _drawn(work: "Callable[[Drawer], T]") -> T:
    """Return what a function of the drawer returns. Raises InputError if this system or process cannot draw."""
    thread, process = _thread()
    if process != os.getpid():  # a fork copies no thread: neither povgen's nor those of OpenGL
        raise InputError(FORKED)
    return thread.submit(lambda: work(_drawer())).result()


def points(scene: Scene, size: Size) -> NDArray[np.float32]:
    """Return the point in space that each pixel of a picture shows: x, y and z, in tiles, (height, width, 3).

    z is the depth behind the first window. The points are NaN for the sky, and where no light arrives. `size` is the
    picture's width and height in pixels, even numbers from 32. One ray is followed for each pixel, through all windows,
    by the renderer gl. The first row is the top one. Raises InputError for a size that the renderer does not allow, for
    what is no scene or one that gl cannot draw, and if this system cannot draw with OpenGL.
    """
    size = Rendering(size=size, renderer="gl").size
    check_gl(checked_scene(scene))
    met = Drawn(scene).readout(size)["met"]
    return np.where(met[..., 3:] > 0, met[..., :3], np.float32(np.nan))


class Drawn:
    """What the shaders draw of a scene. Pictures have their first row at the top.

    `set`, `readout` and `picture` take and return the same as those of `browser.View`.
    """

    def __init__(self, scene: Scene) -> None:
        """Raises InputError if this system cannot draw with OpenGL."""
        _thread()
        self.set(scene)

    def set(self, scene: Scene) -> None:
        """Show another scene."""
        self._scene, self._shapes = scene, volumes(pieces(scene))

    def readout(self, size: Size) -> dict[str, NDArray[np.float32]]:
        """Return `ray`, `shown` and `met`, (height, width, 4) each. povgen/liveview/readout.glsl explains them."""
        text = self._text("readout")
        return dict(zip(("ray", "shown", "met"), _drawn(lambda drawer: drawer.readout(text, size)), strict=True))

    def picture(self, size: Size, rays: int, part: float = 1) -> NDArray[np.uint8]:
        """Return the picture, (height, width, 3) sRGB bytes: `rays` rays in the middle `part` of each pixel's side."""
        text = self._text()
        return _drawn(lambda drawer: np.concatenate([*drawer.bands(text, size, rays, part=part)]))

    def save(self, file: Path, rendering: Rendering) -> None:
        """Write the picture to a PNG file, as `povgen frame --renderer gl` does."""
        from povgen.rendering.gl import write_png

        text, sampling = self._text(), (rendering.size, rendering.rays, rendering.supersampling > 1)
        _drawn(lambda drawer: write_png(file, drawer.bands(text, *sampling), rendering.size))

    def _text(self, shader_name: str = "picture") -> dict[str, object]:
        text = json.loads(gl_scene.to_text(self._scene, self._shapes, shader_name=shader_name))
        files = {part: used(name)[name] for part, name in text["pictures"].items()}
        return {**text, "pictures": files}
