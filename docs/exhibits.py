"""The gallery's exhibits: the scene of each picture, its .pov text, and where it can be moved.

The frames of the paper's figures are those of povgen's own movies.
"""

import shlex
from typing import NamedTuple
from urllib.parse import urlencode

from gallery import pictures
from page_picture import ADDRESS
from panels import PANELS

from povgen import Chess, MovieSpec, live, to_pov
from povgen.page.address import ALL_KINDS, KEPT
from povgen.scene.scene import Scene
from povgen.scene.scenes import SCENES
from povgen.sheets import PARAMETERS

FIGURES = {"figure3": "vary-alpha", "figure4": "vary-z1", "figure6": "spheres"}  # figure: movie
# the parameters that the page knows, besides those of sheets
KNOWN = {"sheet", "alpha", "z1", "z2", "prisms", "piece", "x", "pedestal", "line", "eye", "window", "predicted_image"}
NAMED = {"--overlay": ["position", "circles"], "--predicted-image": ["image"], "--caption": ["caption"]}


class Exhibit(NamedTuple):
    """A picture's scene, the words of its command after `povgen`, and the part of the page's address after `#`.

    The address is empty if the page cannot show the scene. Then the scene has a live view of its own.
    """

    scene: Scene
    words: list[str]
    address: str

    def pov(self, file: str) -> str:
        """Return the .pov text, whose header has the command for this file. For a movie it is the first frame's."""
        given = {
            name: value
            for option, value in zip(self.words, self.words[1:], strict=False)
            if (name := option.removeprefix("--")) in ("quality", "size", "antialias")
        }
        return to_pov(self.scene, file=file, **given)

    def view(self) -> str:
        """Return a page with the scene's live view."""
        return live(self.scene).html


def exhibits() -> dict[str, Exhibit]:
    """Return the exhibit of each picture by the name of its file without suffix."""
    made = {name: _of(shlex.split(each["command"])) for name, each in pictures().items() if "command" in each}
    twins = "--piece knight --piece knight --x 0 --x 3.3 --z1 3 --z1 3"
    made["rotation"] = _of(shlex.split(f"movie chess --sweep alpha=0:357 --frames 120 --sheet ideal {twins}"))
    for name, panels in PANELS.items():
        made[name] = Exhibit(panels[-1].scene, [], _address_without_view(panels[-1].scene))
    made["page"] = Exhibit(Chess(sheet="ideal"), ["demo"], ADDRESS.removeprefix("#"))
    for figure, movie in FIGURES.items():
        scene = MovieSpec.load(movie).scenes("draft")[0]
        made[figure] = Exhibit(scene, ["figure", figure[-1]], _address_without_view(scene))
    return made


def _address_without_view(scene: Scene) -> str:
    """Return the page's address of a scene; the page has a view of its own, and no direct image."""
    shown = ["--predicted-image"] if getattr(scene, "predicted_image", False) else []
    names = scene.model_fields_set - {"view", "direct_image"}
    return address(type(scene)(**{name: getattr(scene, name) for name in names}), shown)


def _of(words: list[str]) -> Exhibit:
    """Return the exhibit of a command: `frame chess --alpha 180`, or a movie with one sweep."""
    kind = SCENES[words[1]]
    values: dict[str, list[str]] = {}
    for option, value in zip(words, [*words[1:], ""], strict=True):
        name = option.removeprefix("--").replace("-", "_")
        if option == "--sweep":
            name, _, sweep = value.partition("=")
            value = sweep.partition(":")[0]
        if option.startswith("--") and name in kind.model_fields:
            values.setdefault(name, []).append("true" if not value or value.startswith("--") else value)
    scene = kind(
        **{name: several if len(several) > 1 or name == "window" else several[0] for name, several in values.items()}
    )
    return Exhibit(scene, words, address(scene, words))


def address(scene: Scene, words: list[str]) -> str:
    """Return the page's address of a scene (povgen/page/address.js), or nothing if the page cannot show it."""
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
    if isinstance(scene, Chess):
        values |= {"z1": scene.distances[0], "L": f"{scene.L.real:g},{scene.L.imag:g}"}
    if scene.sheet in ALL_KINDS:
        names = [each.name for each in ALL_KINDS[scene.sheet].parameters if each.name not in KEPT]
        values |= {name: getattr(scene, name) for name in names}
    for window in scene.window:
        values |= {"windows": 2, "sheet2": window.sheet or "same", "alpha2": window.alpha, "d": window.z}
    values |= {"E": f"{scene.eye[0]:g},{scene.eye[1]:g}"}
    values["show"] = ",".join(name for word in words for name in NAMED.get(word, []))
    return urlencode(values, safe=",")
