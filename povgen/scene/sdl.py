"""Templates: a scene becomes the text that POV-Ray reads, movies become a page. Only this module uses Jinja2."""

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from shlex import quote
from types import NoneType
from typing import NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

from povgen import limits
from povgen.errors import InputError, shown
from povgen.files import own_folder
from povgen.scene import cells, laws, materials
from povgen.scene.models import PEDESTAL_EDGE, Scene, checked_scene
from povgen.scene.pieces import PieceFile
from povgen.scene.survey import Survey, max_trace_level
from povgen.settings import Sampling
from povgen.version import __version__

TEMPLATES = own_folder("templates")


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
    environment.filters["zip"] = zip
    environment.tests["file"] = lambda piece: isinstance(piece, PieceFile)
    environment.filters["floats"] = materials.floats
    environment.filters["interpolated"] = materials.interpolated
    formula = {head.partition("(")[0]: text for head, text in materials.FORMULAS.items()}
    environment.globals.update(version=__version__, raw=_raw, materials=materials, formula=formula)
    return environment


def _raw(name: str) -> str:
    """Return the text of a file in templates/ unchanged: braces in a script are not Jinja's."""
    return (TEMPLATES / name).read_text("utf-8")


class Mosaic(NamedTuple):
    """Blocks of a picture's pixels. They are rendered side by side, instead of the whole picture."""

    size: tuple[int, int]  # width and height of the whole picture, pixels
    side: int  # width and height of a block, pixels
    blocks: Sequence[Sequence[tuple[int, int]]]  # rows of blocks: column and row of each block's upper left pixel


def to_pov(
    scene: Scene,
    mosaic: Mosaic | None = None,
    sheet_macro: str | None = None,
    file: str = "scene.pov",
    found: Survey | None = None,
    **options: object,
) -> str:
    """Return the scene in POV-Ray's language. Texts of two frames of a movie differ only in declared parameters.

    The header has POV-Ray's command for the picture, from a file of this name. Options are size, quality and
    antialias, as of `Rendering`.
    With a mosaic, the camera sees only the mosaic's blocks. `sheet_macro` is SDL text that replaces povgen's macro
    `Sheet(Angle, Centre)`; it may use all that sheets.pov.j2 declares before the macro.
    `found` is the scene's survey. Without it, rays are traced.
    Raises InputError if an option is not allowed, and for a transparent background, because povgen composes that from
    two scenes.
    """
    if checked_scene(scene).background == "transparent":
        raise InputError(
            "background = 'transparent': povgen composes this picture from one in front of black and one in front of "
            "white; allowed: 'sky', 'black' or 'white'"
        )
    for name, value, kinds, allowed in (
        ("mosaic", mosaic, (Mosaic, NoneType), "a Mosaic"),
        ("sheet_macro", sheet_macro, (str, NoneType), "text"),
        ("file", file, str, "text"),
        ("found", found, (Survey, NoneType), "a Survey"),
    ):
        if not isinstance(value, kinds):
            raise InputError(f"{name} = {shown(value)}: should be {allowed}")
    shown_by = cells.template(scene)
    sampling = Sampling(**options).suited(scene.has_prisms)
    return (
        _environment()
        .get_template(f"{scene.name}.pov.j2")
        .render(
            scene=scene,
            mosaic=mosaic,
            edge=PEDESTAL_EDGE,
            sheet_macro=sheet_macro,
            input=_input(file),
            options=" ".join(sampling.picture_options),
            supersampling=sampling.supersampling,
            camera=shown_by,
            laws=laws.to_pov(scene) if shown_by else [],
            cells=cells.camera_cells(scene) if shown_by else None,
            trace_level=max_trace_level(scene, found),
            least_light=limits.LEAST_LIGHT,
            solid="merge" if getattr(scene, "predicted_image", False) else "union",
        )
    )


def to_crossings(piece: str | PieceFile, grid: tuple[int, int, int], limit: float, crossings: str) -> str:
    """Return a scene that makes POV-Ray write, to the file `crossings`, where grid lines cross a piece's surface.

    `grid`: the number of points along x, y and z. What is farther than `limit` (tiles) from the axis is left out.
    """
    template = _environment().get_template("probes/crossings.pov.j2")
    return template.render(piece=piece, grid=grid, limit=limit, crossings=crossings)


def to_html(page: str, data: Mapping[str, object], script: str, texts: Sequence[laws.Text]) -> str:
    """Return a page of the live view, `live/page` or `demo/index`, with its styles. Its script reads `data`.

    `texts` are the laws that its shaders know.
    """
    return _environment().get_template(f"{page}.html.j2").render(data=data, script=script, laws=texts)


def to_javascript(texts: Sequence[laws.Text]) -> str:
    """Return the module live/laws.js: the laws that the page's scripts know."""
    return _environment().get_template("live/laws.js.j2").render(laws=texts)


def _input(file: str) -> str:
    """Return POV-Ray's option, as a shell takes it, for its input file; no text if it cannot open the name."""
    if re.fullmatch(r"[\w.-]+", file, re.ASCII):
        return f"+I{file}"
    return quote(f'+I"{file}"') if re.fullmatch("[ !#-~]+", file) else ""


def to_caption(number: int, data: dict[str, object]) -> str:
    """Return the caption of a figure of the paper, in Markdown. `data` is what the figure's drawing returns."""
    return _environment().get_template(f"figures/figure{number}.md.j2").render(data)


def origin_of(pieces: Iterable[str | PieceFile], source: str, line: int) -> tuple[str, int | None]:
    """Return where a line, counted from 1, of a text with these pieces (`to_pov`, `to_crossings`) comes from.

    This is a user's file (`PieceFile`) and the line there, or a template and None. Each template's text begins with its
    name.
    """
    for piece in pieces:
        if isinstance(piece, PieceFile):
            first = source.partition(f"union {{\n{piece.text}object {{ Piece }}\n}}\n")[0].count("\n") + 2
            last = first + piece.text.count("\n") - 1
            if first <= line <= last + 2:  # the last two lines use `Piece` and end the union
                return repr(piece.path), min(line, last) - first + 1
    name = "header.pov.j2"
    for text in source.split("\n")[:line]:  # POV-Ray ends a line only there
        if text.startswith("// ---- ") and text.endswith(") ----"):
            name = text[text.rindex("(") + 1 : -len(") ----")]
    return name, None
