"""The live view of a scene: in Jupyter, or as a page of its own."""

from collections.abc import Iterable
from html import escape
from pathlib import Path

from povgen import files
from povgen.rendering.volumes import page
from povgen.scene.models import Scene, checked_scene, piece_files


class Live:
    """A scene's live view. Jupyter shows it; `save` writes it to an HTML file. It needs no network.

    The view is drawn by the browser, which needs WebGL 2. The arguments are the view's width and height in Jupyter,
    pixels.
    """

    def __init__(self, html: str, width: int, height: int, inputs: Iterable[str] = ()) -> None:
        self.html, self.width, self.height = html, width, height
        self._inputs = inputs  # the files that were read for it; `save` replaces none of them

    def _repr_html_(self) -> str:
        size = f'width="{self.width}" height="{self.height}"'
        return (
            f'<iframe {size} style="border: 0" title="The live view of a scene" srcdoc="{escape(self.html)}"></iframe>'
        )

    def save(self, path: str | Path) -> Path:
        """Write the page to an .html file and return its path. Raises InputError if it cannot be written."""
        output = files.checked_output(Path(path), [".html"], inputs=self._inputs)
        files.save(self.html.encode(), output)
        return output


def live(scene: Scene, width: int = 640, height: int = 480) -> Live:
    """Return the scene's live view, which the browser draws.

    Raises InputError for anything but a scene, and for `fresnel`: the live view follows one ray
    a pixel, which does not split. Raises
    PovrayError if POV-Ray, which measures the shapes of pieces, fails.
    """
    return Live(page(checked_scene(scene)), width, height, piece_files([scene]))
