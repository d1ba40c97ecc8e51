"""Fill in the templates: a scene's text for POV-Ray, the live view's HTML and shaders, captions of figures.

Only this module uses Jinja2.
"""

import re
import sys
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from mimetypes import guess_type
from pathlib import Path
from shlex import quote
from typing import NamedTuple

from jinja2 import Environment, FileSystemBytecodeCache, FileSystemLoader, StrictUndefined, select_autoescape
from jinja2.bccache import Bucket

from povgen import limits
from povgen.errors import InputError
from povgen.files import own_folder
from povgen.inputs.fields import rgb
from povgen.inputs.mesh import TALLEST
from povgen.inputs.pictures import mountains
from povgen.inputs.pieces import FILE_RADIUS, PieceFile
from povgen.objects import OBJECTS
from povgen.objects.scene_object import SceneObject
from povgen.objects.window import Window
from povgen.optics.prism import Prism
from povgen.optics.profile import Profile
from povgen.scene import cells, laws, materials
from povgen.scene.presets import PEDESTAL_EDGE, AxialScene, checked_axial
from povgen.scene.room import Room
from povgen.scene.scene import Scene, checked_scene
from povgen.scene.survey import Survey, max_trace_level
from povgen.scene.traced_rays import HOLD_OUT
from povgen.settings import Sampling
from povgen.sheets import SHEETS
from povgen.sheets.layered import Layered
from povgen.sheets.prisms import PrismPair, Prisms
from povgen.version import __version__

TEMPLATES = own_folder("templates")
PACKAGE = Path(__file__).parents[1]  # whose folders have the texts of pages, shaders and captions
COMPILED = TEMPLATES / "__pycache__"
COMMENT = re.compile(r"^ *//.*\n|^ +|  //.*$", re.M)


class _Compiled(FileSystemBytecodeCache):
    """Compiled templates, stored beside their source, if this process may write there."""

    def get_source_checksum(self, source: str) -> str:
        # The checksum depends on when this module was changed: its options and filters are part of a compiled template.
        return super().get_source_checksum(f"{Path(__file__).stat().st_mtime_ns} {source}")

    def dump_bytecode(self, bucket: Bucket) -> None:
        if not sys.dont_write_bytecode:
            with suppress(OSError):
                COMPILED.mkdir(exist_ok=True)
                super().dump_bytecode(bucket)


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader([TEMPLATES, PACKAGE]),
        bytecode_cache=_Compiled(str(COMPILED), f"%s.{sys.implementation.cache_tag}"),
        undefined=StrictUndefined,
        autoescape=select_autoescape(["html.j2"]),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    compact = {"sort_keys": False, "ensure_ascii": False, "separators": (",", ":")}  # a page is UTF-8
    environment.policies["json.dumps_kwargs"] = compact
    environment.filters["number"] = lambda x: f"{float(x):.15g}"
    environment.filters["repr"] = repr
    environment.filters["sdl_name"] = _sdl_name
    environment.filters["zip"] = zip
    environment.filters["bare"] = bare
    environment.tests["file"] = lambda piece: isinstance(piece, PieceFile)
    environment.filters["floats"] = materials.floats
    environment.filters["interpolated"] = materials.interpolated
    formula = {head.partition("(")[0]: text for head, text in materials.FORMULAS.items()}
    environment.globals.update(
        version=__version__,
        raw=lambda name: (PACKAGE / name).read_text("utf-8"),  # unchanged: braces in a script are not Jinja's
        rgb=rgb,
        parameter=_parameter,
        materials=materials,
        mountains=mountains,
        formula=formula,
        objects={kind.drawn_as or kind.kind: kind.glsl for kind in OBJECTS.values() if kind.glsl},  # for shaders
        reach=FILE_RADIUS,
        top=TALLEST,
    )
    return environment


def _parameter(name: str, value: float, about: str, free: bool = True) -> str:
    """Return the line that declares a parameter. If `free`, it can be set on POV-Ray's command line instead.

    All that depends on a free parameter must be computed in POV-Ray's text.
    """
    declaration = f"#declare {name:10} = {float(value):.15g};"
    if free:
        declaration = f"{f'#ifndef ({name})':20} {declaration} #end"
    return f"{declaration}  // {about}"


class Mosaic(NamedTuple):
    """Blocks of a picture's pixels. They are rendered side by side, instead of the whole picture."""

    size: tuple[int, int]  # width and height of the whole picture, pixels
    side: int  # width and height of a block, pixels
    # rows of blocks: column and row of each block's upper left pixel, counted from 0
    blocks: Sequence[Sequence[tuple[int, int]]]


def to_pov(
    scene: Scene,
    mosaic: Mosaic | None = None,
    sheet_macro: str | None = None,
    file: str = "scene.pov",
    found: Survey | None = None,
    rays: str = "",
    **options: object,
) -> str:
    """Return the scene in POV-Ray's language. Frames of a movie differ only in the values of `#declare` lines.

    The header has POV-Ray's command, with `file` as the .pov file's name. `povgen pov -o` also writes the pictures that
    the text names: without that of the mountains, there is sky alone. Options are the fields size, quality and
    antialias of `Rendering`. With a mosaic, the camera sees only the mosaic's blocks. `sheet_macro` is text in
    POV-Ray's language (SDL) that replaces povgen's macro `Sheet(Angle, Centre)`; it may use all that sheets.pov.j2
    declares before the macro. `found` is the scene's survey (`povgen.scene.survey.survey`), if it is known already. If
    it is None, rays are traced. `rays` begins the names of the files of a room's rays, of which the text reads that
    with the number Leg.

    Raises InputError if an option is not allowed, and for a transparent background, because povgen composes such a
    picture from two scenes.
    """
    if checked_scene(scene).background == "transparent":
        raise InputError(
            "background = 'transparent': povgen composes this picture from one in front of black and one in front of "
            "white; allowed: 'sky', 'black' or 'white'"
        )
    sampling = Sampling(**options).suited(scene.has_prisms)
    if isinstance(scene := scene.fitted(sampling.size), Room):
        return _room(scene, max_trace_level(scene, found), sampling, file, rays)
    assert isinstance(scene, AxialScene)
    shown_by = cells.template(scene)
    first = scene.sheets[0]
    built = first.glass if isinstance(first, PrismPair) and not first.is_exact else ()
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
            jumps=cells.jumps(scene),
            jump=cells.JUMP,
            glass=_shapes(scene),
            profiles=_profiles(scene),
            trace_level=max_trace_level(scene, found),
            free=_is_exact(scene),  # sheets with errors of building are computed in Python, not in POV-Ray's text
            built=built,
            single=first.single if isinstance(first, PrismPair) else [],
            part="",
            least_light=limits.LEAST_LIGHT,
        )
    )


def _room(scene: Room, trace_level: int, sampling: Sampling, file: str, rays: str) -> str:
    """Return a room in POV-Ray's language."""
    own = [*dict.fromkeys(each.shape for each in scene.object if isinstance(each.shape, PieceFile))]
    things = {name: each for name, each in scene.things.items() if isinstance(each, SceneObject) and each.glsl}

    def rendered(text: str, each: SceneObject, name: str = "") -> str:
        return _environment().from_string(text).render(each=each, n=_sdl_name(name), own=own).rstrip("\n")

    camera = scene.camera
    return (
        _environment()
        .get_template("room.pov.j2")
        .render(
            scene=scene,
            rays=scene.rays_file and (rays or scene.rays_file.name),
            legs=rays,
            size=sampling.size,
            own=own,
            input=_input(file),
            options=" ".join(sampling.picture_options),
            supersampling=sampling.supersampling,
            trace_level=trace_level,
            least_light=limits.LEAST_LIGHT,
            floor=next((each for each in scene.object if each.kind == "floor"), None),
            along=[a - b for a, b in zip(camera.middle, camera.eye, strict=True)],
            hold_out=HOLD_OUT,
            windows=[(name, each) for name, each in scene.things.items() if isinstance(each, Window)],
            glass=[sheet for sheet in scene.sheets if isinstance(sheet, Prisms)],
            profiles=_profiles(scene),
            declarations=dict.fromkeys(rendered(text, each) for each in things.values() for text in each.declarations),
            objects=[(name, each, rendered(each.sdl, each, name)) for name, each in things.items()],
        )
    )


def _sdl_name(name: str) -> str:
    """Return a name as povgen writes it in POV-Ray's language, where names in small letters are reserved."""
    return f"{name[:1].upper()}{name[1:]}_"


def to_sheets(scene: Scene) -> str:
    """Return the scene's sheets of prisms or lenses in POV-Ray's language, as a text to #include in another scene.

    Parameters with #ifndef are #local: another such text in the same scene has its own values.

    Raises InputError for a room, if a window has an ideal sheet or no sheet, and if sheets are not built exactly
    (option `error`).
    """
    scene = checked_axial(scene, "part = 'sheets'")
    if scene.ideal:
        allowed = ", ".join(repr(name) for name, kind in SHEETS.items() if issubclass(kind, Layered))
        raise InputError(f"part = 'sheets': sheet = {scene.ideal[0].name!r} has no glass; allowed: {allowed}")
    if not _is_exact(scene):
        raise InputError("error: not with part = 'sheets'; allowed: no errors of building")
    glass, level = _shapes(scene), max_trace_level(scene)
    values = {"glass": glass, "profiles": _profiles(scene), "trace_level": level, "least_light": limits.LEAST_LIGHT}
    absent: dict[str, object] = {"laws": [], "cells": None, "sheet_macro": None, "built": (), "single": []}
    template = _environment().get_template("part.pov.j2")
    text = template.render(values, **absent, scene=scene, free=True, part="sheets")
    return re.sub(r"^(#ifndef \(\w+\) +)#declare", r"\1#local", text, flags=re.MULTILINE)


def _is_exact(scene: Scene) -> bool:
    return all(sheet.is_exact for sheet in scene.sheets)


def _shapes(scene: Scene) -> list[Prisms]:
    """Return the sheets of prisms: of several with equal layers, shape and tops, only the last one."""
    found = {
        (sheet.layers, sheet.shape, sheet.values["tops"]): sheet for sheet in scene.sheets if isinstance(sheet, Prisms)
    }
    return list(found.values())


class ProfileWindow(NamedTuple):
    """A window whose sheets have a `Profile` as their cross-section: lenses, and all other shapes but Dove prisms."""

    window: int  # counted from 0
    sheet: Layered
    shape: Prism | Profile
    suffix: str  # the end of its parameters' names in the text
    near: Prism | Profile | None = None  # the profile of the near sheet, if it differs from `shape`

    @property
    def periods(self) -> str:
        """The name that the number of periods has in the text."""
        return self.sheet.counted.capitalize() + self.suffix


def _profiles(scene: Scene) -> list[ProfileWindow]:
    """Return the windows whose sheets have a profile. Windows with equal profiles have the same suffix."""
    found: list[ProfileWindow] = []
    suffixes: dict[tuple[str, Profile], str] = {}
    for number, sheet in enumerate(scene.sheets):
        if isinstance(sheet, Layered) and not isinstance(shape := sheet.shape, Prism):
            suffix = suffixes.setdefault((sheet.counted, shape), f"_{len(suffixes) + 1}" if suffixes else "")
            shapes = [] if sheet.is_exact else [built.shape for built in sheet.glass]
            near, far = shapes or (None, shape)
            found.append(ProfileWindow(number, sheet, far, suffix, near))
    return found


def to_crossings(piece: str | PieceFile, grid: tuple[int, int, int], limit: float, crossings: str) -> str:
    """Return a scene with which POV-Ray finds the points where grid lines cross a piece's surface.

    POV-Ray writes the points to the file `crossings`. `grid` is the number of grid points along x, y and z. What is
    farther than `limit`, in tiles, from the piece's axis is left out.
    """
    template = _environment().get_template("probes/crossings.pov.j2")
    return template.render(piece=piece, grid=grid, limit=limit, crossings=crossings)


def to_html(
    page: str,
    data: Mapping[str, object],
    script: str,
    texts: Sequence[laws.Text],
    panorama: Path,
    fonts: Mapping[str, str] | None = None,
    poster: str = "",
) -> str:
    """Return a page of the live view, `liveview/page` or `page/index`, with its styles. Its script reads `data`.

    `texts` are the laws that its shaders know, and `panorama` is the file of the mountains. `page/index` has `fonts`:
    text, bold and symbols as base64; and a `poster`, a WebP picture as base64, if it has one.
    """
    template = _environment().get_template(f"{page}.html.j2")
    mountains = f"data:{guess_type(panorama.name)[0]};base64,{b64encode(panorama.read_bytes()).decode()}"
    return template.render(data=data, script=script, laws=texts, fonts=fonts, poster=poster, mountains=mountains)


def bare(text: str) -> str:
    """Return a script or a shader without comments and indents. Behind code, two spaces are before a comment."""
    return COMMENT.sub("", text)


def to_javascript(texts: Sequence[laws.Text]) -> str:
    """Return the module liveview/laws.js: the laws that the page's scripts know."""
    return _environment().get_template("liveview/laws.js.j2").render(laws=texts)


def to_glsl(main: str, texts: Sequence[laws.Text] = ()) -> str:
    """Return one of the live view's fragment shaders, liveview/`main`.glsl with all that it includes.

    The caller adds the lines before it, #version and #define. `texts` are the laws that the shader knows.
    """
    if main in ("display", "share"):
        parts = [main]
    elif main == "rays":
        parts = ["windows", "prisms", main]
    else:
        parts = ["windows", "materials", "objects", "prisms", "laws", "view", main]
    return "\n".join(_environment().get_template(f"liveview/{part}.glsl").render(laws=texts) for part in parts)


def _input(file: str) -> str:
    """Return POV-Ray's option for its input file, quoted for a shell; '' if POV-Ray cannot open a file of this name."""
    if re.fullmatch(r"[\w.-]+", file, re.ASCII):
        return f"+I{file}"
    return quote(f'+I"{file}"') if re.fullmatch("[ !#-~]+", file) else ""


def to_caption(number: int, data: dict[str, object]) -> str:
    """Return the caption of a figure of the paper, in Markdown. `data` is what the figure's drawing returns."""
    return _environment().get_template(f"paper/captions/figure{number}.md.j2").render(data)


def origin_of(pieces: Iterable[str | PieceFile], source: str, line: int) -> tuple[str, int | None]:
    """Return the origin of a line of a text for POV-Ray: a user's file and the line in it, or a template and None.

    `source` is the result of `to_pov` or `to_crossings` for these pieces. The path of a user's file is returned as
    `repr` shows it. The line is that in `PieceFile.text`, which for a mesh is not the file's own text. Lines are
    counted from 1. The text of each template begins with a comment that names it.
    """
    for piece in pieces:
        if isinstance(piece, PieceFile):
            before, _, after = source.partition(f"union {{\n{piece.text}object {{ Piece }}\n}}\n")
            first = before.count("\n") + 2
            last = first + piece.text.count("\n") - 1
            # after the file's text: two lines that use `Piece` and end the union, and lines that check the piece's size
            check = 0 if piece.is_mesh else after.partition("\nOwnPieceCheck(")[0].count("\n") + 2
            if first <= line <= last + 2 + check:
                return repr(piece.path), min(line, last) - first + 1
    name = "header.pov.j2"
    for text in source.split("\n")[:line]:  # POV-Ray ends a line at no other character
        if text.startswith("// ---- ") and text.endswith(") ----"):
            name = text[text.rindex("(") + 1 : -len(") ----")]
    return name, None
