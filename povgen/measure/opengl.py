"""The live view's shaders, run by OpenGL without a browser: for measurements, and for the points that pixels show."""

import numpy as np
from numpy.typing import NDArray

from povgen.files import temporary_folder
from povgen.rendering import gl_runner, gl_scene
from povgen.rendering.frames import read_png
from povgen.rendering.views import check_gl
from povgen.rendering.volumes import volumes
from povgen.scene.presets import pieces
from povgen.scene.scene import Scene, checked_scene
from povgen.settings import Rendering

Size = tuple[int, int]  # width and height, pixels
TIMEOUT = 600.0  # seconds for a picture


def points(scene: Scene, size: Size) -> NDArray[np.float32]:
    """Return the point in space that each pixel of a picture shows: x, y and z, in tiles, (height, width, 3).

    z is the depth behind the first window. The points are NaN for the sky, and where no light arrives. `size` is the
    picture's width and height in pixels, even numbers from 32. One ray is followed for each pixel, through all windows,
    by the renderer gl. The first row is the top one. Raises InputError for a size that the renderer does not allow, for
    what is no scene or one that gl cannot draw, and if this system cannot draw with OpenGL.
    """
    size = Rendering(size=size, renderer="gl").size
    check_gl(scene := checked_scene(scene).fitted(size))
    met = OpenGLView(scene).readout(size)["met"]
    return np.where(met[..., 3:] > 0, met[..., :3], np.float32(np.nan))


class OpenGLView:
    """What the shaders draw of a scene. Pictures have their first row at the top.

    `set`, `readout` and `picture` take and return the same as those of `browser.View`.
    """

    def __init__(self, scene: Scene) -> None:
        """Raises InputError if this system cannot draw with OpenGL."""
        gl_runner.device()
        self.set(scene)

    def set(self, scene: Scene) -> None:
        """Show another scene."""
        self._scene, self._shapes = scene, volumes(pieces(scene))

    def readout(self, size: Size) -> dict[str, NDArray[np.float32]]:
        """Return `ray`, `shown` and `met`, (height, width, 4) each. povgen/liveview/readout.glsl explains them."""
        numbers = np.frombuffer(self._drawn("readout", size=size, kind="readout"), "<f4")
        return dict(zip(("ray", "shown", "met"), numbers.reshape(3, size[1], size[0], 4), strict=True))

    def picture(self, size: Size, rays: int, part: float = 1) -> NDArray[np.uint8]:
        """Return the picture, (height, width, 3) sRGB bytes: `rays` rays in the middle `part` of each pixel's side."""
        return read_png(self._drawn("picture", size=size, rays=rays, wide_filter=False, part=part, kind="png"))

    def source(self, shader_name: str = "picture") -> str:
        """Return the text that `gl_runner` draws."""
        return gl_scene.to_text(self._scene, self._shapes, shader_name=shader_name)

    def _drawn(self, shader_name: str, **asked: object) -> bytes:
        with temporary_folder() as folder:
            gl_runner.Runner().draw(self.source(shader_name), folder / "drawn", TIMEOUT, asked)
            return (folder / "drawn").read_bytes()
