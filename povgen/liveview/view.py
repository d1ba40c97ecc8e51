"""The live view of a scene: in Jupyter, or as a page of its own."""

from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import Annotated

from pydantic import Field

from povgen import files
from povgen.errors import InputError, shown
from povgen.liveview.scripts import script
from povgen.liveview.values import values
from povgen.liveview.volumes import stored, volumes
from povgen.model import Model
from povgen.scene.laws import to_live
from povgen.scene.models import SCENES, Scene, checked_scene, piece_files, pieces
from povgen.scene.sdl import to_html

Side = Annotated[int, Field(ge=32, le=7680)]


class _Size(Model):
    width: Side = Field(description="the view's width in Jupyter, 32 to 7680 pixels")
    height: Side = Field(description="the view's height in Jupyter, 32 to 7680 pixels")


class Live:
    """A scene's live view. Jupyter shows it; `save` writes it to an HTML file. It needs no network.

    The view is drawn by the browser, which needs WebGL 2.
    """

    def __init__(self, html: str, size: _Size, inputs: Iterable[str] = ()) -> None:
        self.html, self.size = html, size
        self._inputs = inputs  # the files that were read for it; `save` replaces none of them

    def _repr_html_(self) -> str:
        size = f'width="{self.size.width}" height="{self.size.height}"'
        return (
            f'<iframe {size} style="border: 0" title="The live view of a scene" srcdoc="{escape(self.html)}"></iframe>'
        )

    def save(self, path: str | Path) -> Path:
        """Write the page to an .html file and return its path. Raises InputError if it cannot be written."""
        output = files.checked_output(path, [".html"], inputs=self._inputs)
        files.save(self.html.encode(), output)
        return output


def html(scene: Scene, others: Iterable[Scene] = ()) -> str:
    """Return the page that shows a scene's live view. It also knows the laws of other scenes' sheets.

    Raises what `volumes` and `values` raise.
    """
    data = {"scene": values(scene), "volumes": stored(volumes(pieces(scene)))}
    laws = to_live([scene, *others])
    return to_html("live/page", data, script("live/main.js", laws=laws), laws)


def live(scene: Scene, width: int = 640, height: int = 480) -> Live:
    """Return the scene's live view, which the browser draws. Its width and height in Jupyter are in pixels.

    Raises InputError for anything but a scene of povgen's own classes: the view does not know what another class
    shows. Raises InputError for `fresnel`: the live view follows one ray a pixel, which does not split. Raises
    PovrayError if POV-Ray, which measures the shapes of pieces, fails.
    """
    size = _Size(width=width, height=height)
    if type(checked_scene(scene)) not in SCENES.values():
        allowed = " or ".join(f"{own.__name__}(...)" for own in SCENES.values())
        raise InputError(f"scene = {shown(scene)}: the live view does not know this class; allowed: {allowed}")
    return Live(html(scene), size, piece_files([scene]))
