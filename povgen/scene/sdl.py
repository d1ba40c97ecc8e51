"""Templates: a scene becomes the text that POV-Ray reads, movies become a page. Only this module uses Jinja2."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

from povgen import __version__
from povgen.errors import InputError
from povgen.scene import prediction
from povgen.scene.models import Chess, Scene, checked_scene
from povgen.scene.pieces import PieceFile
from povgen.settings import Rendering

TEMPLATES = Path(__file__).parents[1] / "templates"


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        undefined=StrictUndefined,
        autoescape=select_autoescape(["html.j2"]),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["number"] = lambda x: f"{float(x):.15g}"
    environment.filters["repr"] = repr
    environment.tests["file"] = lambda piece: isinstance(piece, PieceFile)
    environment.globals.update(version=__version__, raw=_raw)
    return environment


def _raw(name: str) -> str:
    """Return the text of a file in templates/ unchanged: braces in a script are not Jinja's."""
    return (TEMPLATES / name).read_text("utf-8")


class Mosaic(NamedTuple):
    """Blocks of a picture's pixels. They are rendered side by side, instead of the whole picture."""

    size: tuple[int, int]  # width and height of the whole picture, pixels
    side: int  # width and height of a block, pixels
    blocks: Sequence[Sequence[tuple[int, int]]]  # rows of blocks: column and row of each block's upper left pixel


def to_pov(scene: Scene, mosaic: Mosaic | None = None, sheet_macro: str | None = None, **options: object) -> str:
    """Return the scene in POV-Ray's scene description language. Two frames of a movie differ only in their parameters.

    The header names the command for the picture. Its options are those of `Rendering`: size, quality and antialias.
    With a mosaic, the camera sees only the mosaic's blocks. `sheet_macro` is SDL text that replaces povgen's macro
    `Sheet(Angle, Centre)`; it may use all that sheets.pov.j2 declares before the macro.
    Raises InputError if an option is not allowed, and for a transparent background, because povgen composes that from
    two scenes.
    """
    if scene.background == "transparent":
        raise InputError(
            "background = 'transparent': povgen composes this picture from one in front of black and one in front of "
            "white; allowed: 'scene', 'black' or 'white'"
        )
    return (
        _environment()
        .get_template(f"{checked_scene(scene).name}.pov.j2")
        .render(
            scene=scene,
            mosaic=mosaic,
            sheet_macro=sheet_macro,
            options=" ".join(Rendering(**options).picture_options),
            cells=prediction.camera_cells(scene) if scene.sheet == "ideal" else None,
            trace_level=prediction.max_trace_level(scene),
            solid="merge" if getattr(scene, "predicted_image", False) else "union",
        )
    )


def to_crossings(piece: str | PieceFile, grid: tuple[int, int, int], limit: float, file: str) -> str:
    """Return the text with which POV-Ray writes to a file where lines cross a piece's surface.

    The grid's points are numbered along x, y and z. What is farther than `limit` (tiles) from the axis is left out.
    """
    template = _environment().get_template("probes/crossings.pov.j2")
    return template.render(piece=piece, grid=grid, limit=limit, file=file)


def to_live(data: Mapping[str, object]) -> str:
    """Return the page that shows the live view alone. `data`: the scene's values, and the shapes of its pieces."""
    return _environment().get_template("live/page.html.j2").render(data=data)


def to_html(page: Mapping[str, object]) -> str:
    """Return the teaching page, with its styles and script. The script reads `page` (`teach.page`)."""
    return _environment().get_template("demo/index.html.j2").render(page=page)


def to_caption(number: int, data: dict[str, Any]) -> str:
    """Return the caption of a figure of the paper, in Markdown. `data` is what the figure's drawing returns."""
    return _environment().get_template(f"figures/figure{number}.md.j2").render(data)


def origin_of(scene: Scene, source: str, line: int) -> tuple[str, int | None]:
    """Return where a line, counted from 1, of the scene's text (`to_pov`) comes from.

    This is a user's file (`PieceFile`) and the line there, or a template and None. Each template's text begins with its
    name.
    """
    pieces = [standing.piece for standing in scene.pieces] if isinstance(scene, Chess) else []
    for piece in pieces:
        if isinstance(piece, PieceFile):
            before, _, _ = source.partition(f"// ---- A piece from {piece.path!r} ----\n{piece.text}")
            first = before.count("\n") + 2
            if first <= line < first + piece.text.count("\n"):
                return repr(piece.path), line - first + 1
    name = "header.pov.j2"
    for text in source.split("\n")[:line]:  # POV-Ray ends a line only there
        if text.startswith("// ---- ") and text.endswith(") ----"):
            name = text[text.rindex("(") + 1 : -len(") ----")]
    return name, None
