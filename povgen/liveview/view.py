"""The live view of a scene: in Jupyter, or as a page of its own."""

from functools import cached_property
from html import escape
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from povgen import files, remedies
from povgen.errors import InputError, shown
from povgen.inputs.pictures import MOUNTAINS
from povgen.liveview import languages
from povgen.liveview.scripts import script
from povgen.liveview.values import values
from povgen.record import save
from povgen.rendering.volumes import stored, volumes
from povgen.scene.laws import to_live
from povgen.scene.presets import input_files, pieces
from povgen.scene.room import Room
from povgen.scene.scene import Scene, checked_class, checked_scene
from povgen.scene.sdl import PACKAGE, to_html
from povgen.scene.shader import cards, surroundings
from povgen.validation import Model

MOVABLE = {"eye", "alpha"}  # what the user can move in the view (povgen/liveview/main.js)
Side = Annotated[int, Field(ge=32, le=7680)]


class _Size(Model):
    width: Side = Field(description="the view's width in Jupyter, 32 to 7680 pixels")
    height: Side = Field(description="the view's height in Jupyter, 32 to 7680 pixels")


class Live:
    """A scene's live view. Jupyter shows it; `save` writes it to an HTML file. It needs no network.

    The view is drawn by the browser, which needs WebGL 2. Dragging and the arrow keys move the eye; with Shift they
    change alpha. `view.scene` is the scene that is shown. Another scene, or a value of a parameter as in
    `view.alpha = 90`, changes the view. A notebook shows such changes only if povgen[jupyter] is installed. Then
    `view.scene` also follows what the user moves. `view.widget` is the widget, of the package anywidget.
    """

    scene: Scene

    def __init__(self, scene: Scene, size: _Size) -> None:
        self.__dict__.update(scene=scene, size=size)

    def __repr__(self) -> str:
        return f"live({shown(self.scene, 80)})"

    @property
    def html(self) -> str:
        """The page that shows the scene."""
        return html(self.scene)

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  (a parameter of a scene)
        scene = self.__dict__.get("scene")  # a copy that is being made has none yet
        if scene is not None and name in type(scene).model_fields:
            return getattr(scene, name)
        raise AttributeError(name)

    def __setattr__(self, name: str, value: object) -> None:
        """Change the scene, or one of its parameters. Raises what `live` raises: then the view stays as it is."""
        self._show(_checked(value) if name == "scene" else self.scene.replace(**{name: value}))

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *type(self.scene).model_fields]

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy has. It gets a widget of its own."""
        return {name: value for name, value in vars(self).items() if name != "widget"}

    def _show(self, scene: Scene) -> None:
        """Show another scene. Raises what `html` raises: then nothing has changed."""
        data = values(scene)
        before, known = (
            (type(x), [*pieces(x).items()], surroundings(x), cards(x), to_live([x])) for x in (self.scene, scene)
        )
        page = html(scene) if before != known else None  # the page lacks a law, a piece or a picture of the new scene
        self.__dict__["scene"] = scene
        if widget := self.__dict__.get("widget"):
            if page:
                widget.html = page
            data.pop("pictures")  # the page has them
            widget.scene = data

    @cached_property
    def widget(self) -> Any:  # noqa: ANN401  (a class that is made when anywidget is there)
        """The widget. Raises InputError if anywidget is not installed."""
        if find_spec("anywidget") is None:
            raise InputError(f"the widget needs anywidget, which is not installed: {remedies.extra('jupyter')}")
        import anywidget
        import traitlets

        class Widget(anywidget.AnyWidget):
            _esm = (PACKAGE / "liveview/widget.js").read_text("utf-8")
            html = traitlets.Unicode().tag(sync=True)
            size = traitlets.Tuple().tag(sync=True)
            scene = traitlets.Dict().tag(sync=True)
            moved = traitlets.Dict().tag(sync=True)

        made = Widget(html=self.html, size=(self.size.width, self.size.height), scene=values(self.scene))
        made.observe(lambda change: self._move(change["new"]), "moved")
        return made

    def _move(self, moved: dict[str, Any]) -> None:
        """Follow what the user has moved. Where the scene does not allow that, the view goes back.

        The message comes from the browser: of other parameters, nothing is read.
        """
        if not moved:
            return
        try:
            self._show(_moved(self.scene, moved))
        except InputError:
            self.widget.scene = {}
            self.widget.scene = {**values(self.scene), "back": True}
        self.widget.moved = {}  # else the widget would not report the same movement again

    def _repr_mimebundle_(self, **options: Any) -> Any:  # noqa: ANN401  (as Jupyter declares it)
        if find_spec("anywidget"):
            return self.widget._repr_mimebundle_(**options)
        size = f'width="{self.size.width}" height="{self.size.height}"'
        return {
            "text/html": f'<iframe {size} style="border: 0" title="The live view of a scene" '
            f'srcdoc="{escape(self.html)}"></iframe>'
        }

    def save(self, path: str | Path) -> Path:
        """Write the page to an .html file and return its path. Raises InputError if it cannot be written."""
        output = files.checked_output(path, [".html"], inputs=input_files([self.scene]))
        save(self.html.encode(), output)
        return output


def html(scene: Scene) -> str:
    """Return the page that shows a scene's live view. Raises what `volumes` and `values` raise."""
    failures = languages.tables({})["en"]["failures"]
    kept = stored(volumes(pieces(scene)))
    data = {"scene": values(scene), "volumes": kept, "label": _label(scene), "failures": failures}
    laws = to_live([scene])
    modules = script("liveview/main.js", "liveview/readout.js", laws=laws)  # povgen/measure/browser.py calls readout.js
    return to_html("liveview/page", data, modules, laws, MOUNTAINS)


def _moved(scene: Scene, moved: dict[str, Any]) -> Scene:
    """Return the scene after what a user has moved: of a room, `alphas` are those of its windows. Raises InputError."""
    changes = {name: moved[name] for name in MOVABLE & moved.keys()}
    alphas = moved.get("alphas")
    if isinstance(scene, Room) and isinstance(alphas, list) and len(alphas) == len(scene.window):
        turned = zip(scene.window, alphas, strict=True)
        changes = {"window": [window if x is None else window.replace(alpha=x) for window, x in turned]}
    return scene.replace(**changes)


def _label(scene: Scene) -> str:
    """Return what a screen reader says of the view."""
    if isinstance(scene, Room):
        things = ", ".join(name for name in scene.things if name not in scene.named_openings)
        sheets = ", ".join(sheet.title for sheet in scene.sheets)
        return f"A room with {things or 'no objects'}; windows with: {sheets or 'none'}. Arrow keys move the eye."
    objects = ", ".join(map(str, pieces(scene))) or scene.name
    sheets = ", then ".join(sheet.title for sheet in scene.sheets)
    return f"{objects}, seen through: {sheets}. Arrow keys move the eye; with Shift they change alpha."


def _checked(scene: object) -> Scene:
    """Return a scene that the live view can show. Raises InputError."""
    found = checked_scene(scene)
    checked_class(found, "the live view")
    values(found)
    return found


def live(scene: Scene, width: int = 640, height: int = 480) -> Live:
    """Return the scene's live view, which the browser draws. Its width and height in Jupyter are in pixels.

    Raises InputError for anything but a scene of povgen's own classes: the view does not know what another class
    shows. Raises InputError for `fresnel`: the live view follows one ray a pixel, which does not split. Raises
    InputError for sheets with errors of building, and for a width or height outside 32 to 7680. Raises PovrayError if
    POV-Ray, which measures the shapes of pieces, fails.
    """
    size = _Size(width=width, height=height)
    checked = _checked(scene)
    volumes(pieces(checked))  # a piece that POV-Ray refuses is an error now
    return Live(checked, size)
