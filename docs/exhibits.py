"""The gallery's exhibits: the scene of each picture, its .pov text, and where it can be moved.

The frames of the paper's figures are those of povgen's own movies.
"""

from collections.abc import Sequence
from typing import NamedTuple
from urllib.parse import urlencode

from page_picture import ADDRESS
from panels import PANELS

from povgen import Chess, MovieSpec, live, to_pov
from povgen.page.address import ALL_KINDS, KEPT
from povgen.scene.scene import Scene
from povgen.sheets import PARAMETERS

FIGURES = {"figure3": "vary-alpha", "figure4": "vary-z1", "figure6": "spheres"}  # figure: movie
# the parameters that the page knows, besides those of sheets
KNOWN = {"sheet", "alpha", "z1", "z2", "prisms", "piece", "x", "pedestal", "line", "eye", "window", "predicted_image"}


class Exhibit(NamedTuple):
    """A picture's scene, the words of its command after `povgen`, and the part of the page's address after `#`.

    The address is empty if the page cannot show the scene. Then the scene has a live view of its own.
    """

    scene: Scene
    words: list[str]
    address: str

    def pov(self, file: str) -> str:
        """Return the .pov text, whose header has the command for this file. For a movie it is the first frame's."""
        return to_pov(self.scene, file=file)

    def view(self) -> str:
        """Return a page with the scene's live view."""
        return live(self.scene).html


def exhibits() -> dict[str, Exhibit]:
    """Return the exhibit of each picture by the name of its file without suffix."""
    made = {
        "rotation": Exhibit(Chess(sheet="ideal", alpha=0, piece=("knight", "knight"), x=(0, 3.3), z1=(3, 3)), [], ""),
        "page": Exhibit(Chess(sheet="ideal"), ["demo"], ADDRESS.removeprefix("#")),
    }
    for name, panels in PANELS.items():
        scene, overlay = panels[-1].scene, panels[-1].overlay
        made[name] = Exhibit(scene, [], _address_without_view(scene, ["position", "circles"] * overlay))
    for figure, movie in FIGURES.items():
        scene = MovieSpec.load(movie).scenes("draft")[0]
        made[figure] = Exhibit(scene, ["figure", figure[-1]], _address_without_view(scene))
    return made


def _address_without_view(scene: Scene, shown: Sequence[str] = ()) -> str:
    """Return the page's address of a scene; the page has a view of its own, and no direct image."""
    shown = [*shown, *["image"] * getattr(scene, "predicted_image", False)]
    names = scene.model_fields_set - {"view", "direct_image"}
    return address(type(scene)(**{name: getattr(scene, name) for name in names}), shown)


def address(scene: Scene, shown: Sequence[str]) -> str:
    """Return the page's address of a scene (povgen/page/address.js), or nothing if the page cannot show it.

    `shown` are the names of what is drawn on the picture.
    """
    given = scene.model_fields_set
    several = [
        name for name in ("x", "piece", "z1") if isinstance(getattr(scene, name, 0), tuple) and len(scene.distances) > 1
    ]
    if (
        given - KNOWN - {*PARAMETERS}
        or "tops" in given
        or len(scene.window) > 1
        or isinstance(scene, Chess)
        and several
    ):
        return ""
    values: dict[str, object] = {"scene": type(scene).name, "sheet": scene.sheet}
    values |= {name: getattr(scene, name) for name in ("alpha", "z2", "prisms", "piece") if hasattr(scene, name)}
    values["L"] = f"{scene.L.real:g},{scene.L.imag:g}"
    if isinstance(scene, Chess):
        values["z1"] = scene.distances[0]
    if scene.sheet in ALL_KINDS:
        names = [each.name for each in ALL_KINDS[scene.sheet].parameters if each.name not in KEPT]
        values |= {name: getattr(scene, name) for name in names}
    for window in scene.window:
        values |= {"windows": 2, "sheet2": window.sheet or "same", "alpha2": window.alpha, "d": window.z}
    values |= {"E": f"{scene.eye[0]:g},{scene.eye[1]:g}"}
    values["show"] = ",".join(shown)
    return urlencode(values, safe=",")
