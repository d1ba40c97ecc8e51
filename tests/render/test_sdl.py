"""The .pov text: legible, only what the scene shows, frames that differ only in their parameters."""

import os
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from povgen import Chess, Spheres, to_pov
from povgen.measure.probes import Directions, PiecePositions, Positions
from povgen.scene import materials, sdl
from povgen.scene.pieces import PIECES
from povgen.scene.sdl import TEMPLATES, Mosaic, origin_of

SHEETS = ("detailed", "ideal", "single", "none", "axis", "refraction", "lenslets", "mirror", "lenticular", "profile")


def scenes():
    for sheet in SHEETS:
        yield Spheres(sheet=sheet)
        for piece in PIECES if sheet == "ideal" else ["knight"]:
            yield Chess(sheet=sheet, piece=piece)
        yield Directions(sheet=sheet)
        yield Positions(sheet=sheet, z1=3)
        yield PiecePositions(sheet=sheet)
    for scene in (Spheres, Chess):
        yield scene(alpha=50, window="alpha=75,z=2")
        yield scene(sheet="none", window="alpha=75,z=2")
        yield scene(sheet="ideal", window=["alpha=75,z=2", "alpha=75,z=4,sheet=detailed"])
    yield Positions(sheet="ideal", z1=3, window=["alpha=75,z=2", "alpha=75,z=4"])
    yield Chess(predicted_image=True)
    yield Chess(fresnel=True, tops="black")
    yield Chess(predicted_image=True, sheet="ideal", x=0.5, eye=(0, -0.33))


def body(text):
    """Return the text without its parameter block."""
    return re.sub(r"^(#ifndef \(\w+\) +)?#declare \w+ += .*;( #end)?  // .*$", "", text, flags=re.M)


def code_of(scene, mosaic=None):
    return re.sub(r"//.*", "", to_pov(scene, mosaic))


@pytest.mark.parametrize(
    "scene",
    list(scenes()),
    ids=lambda s: f"{s.name}-{'-'.join(sheet.name for sheet in s.sheets)}-{getattr(s, 'piece', '')}",
)
def test_everything_declared_is_used(scene):
    code = re.sub(r"#ifndef \(\w+\)", "", code_of(scene))
    for kind, name in re.findall(r"#(declare|macro|local)\s+(\w+)", code):
        uses = len(re.findall(rf"\b{name}\b", code))
        assert uses > 1, f"{kind} {name} is not used"
    assert "#include" not in code


# For a system without POV-Ray's include files: names that they declare, and words that others are likely to declare
SOME_NAMES = set(
    "Axes Black Blue Cube Dark Edge Far Glass Gray Green Height Index Length Light Lower Orange Past Points Ray Red "
    "Shiny Sphere Start Texture Up Upper Violet White".split()
)


def names_in(files):
    """Return the global names of POV-Ray's include files, and the names of their local variables."""
    text = "\n".join(file.read_text("latin-1") for file in files)
    declared = set(re.findall(r"#\s*(?:declare|macro)\s+(\w+)", text))
    local = set(re.findall(r"#\s*local\s+(\w+)", text))
    for arguments in re.findall(r"#\s*macro\s+\w+\s*\(([^)]*)\)", text):
        local |= set(re.findall(r"\w+", arguments))
    return declared, local


def test_no_name_is_also_one_of_povrays_include_files():
    """A name of ours that they declare would change its meaning. A macro's name would break their local variables."""
    mosaic = Mosaic((320, 240), 16, [[(0, 0)]])
    code = "".join(code_of(scene, part) for scene in scenes() for part in (None, mosaic))
    values, macros = (set(re.findall(rf"#{kind}\s+(\w+)", code)) for kind in ("declare", "macro"))
    assert len(values) > 40 and len(macros) > 10
    assert not (values | macros) & SOME_NAMES
    folders = [Path(base) for base in ("/usr/share", "/usr/local/share")]
    if files := [file for folder in folders for file in folder.glob("povray*/include/*.inc")]:
        declared, local = names_in(files)
        assert {"Red", "Reorient_Trans"} <= declared and "Up" in local
        assert not (values | macros) & declared
        assert not macros & local


def test_another_macro_for_the_sheets():
    macro = "#macro Sheet(Angle, Centre) sphere { Tile*Centre*z, Tile*Pitch rotate Angle*z } #end"
    own, other = to_pov(Chess()), to_pov(Chess(), sheet_macro=macro)
    assert macro in other and "interior {" in own and "interior {" not in other
    assert own.startswith(other[: other.index(macro)])
    assert own.endswith(other[other.index(macro) + len(macro) :].lstrip())


def test_no_sheet_where_there_is_none():
    assert "ior" not in to_pov(Chess(sheet="none"))
    assert "ior" not in to_pov(Chess(sheet="ideal"))
    assert "mesh_camera" not in to_pov(Chess(sheet="detailed"))
    assert "Alpha" not in to_pov(Chess(sheet="none"))


@pytest.mark.parametrize("sheet", SHEETS)
def test_frames_differ_only_in_their_parameters(sheet):
    first, second = to_pov(Chess(alpha=10, z1=2, sheet=sheet, x=1, eye=(0.3, 0.67))), to_pov(Chess(z1=3, sheet=sheet))
    assert first != second and body(first) == body(second)
    first, second = to_pov(Spheres(alpha=10, z1=(2, 3), sheet=sheet)), to_pov(Spheres(z1=(2, 3), z2=5, sheet=sheet))
    spheres = re.compile(r"^  \{ .* \},?$", re.M)
    assert first != second and spheres.sub("", body(first)) == spheres.sub("", body(second))


def test_parameters_name_their_unit():
    for scene in scenes():
        for line in to_pov(scene).splitlines():
            lengths = "Z1|Z2|Window|Rim|FrameDepth|ViewHeight|EyeX|EyeY|LX|LY|PieceX|FloorY|FootRadius|Pedestal|SeenUp"
            line = re.sub(r"^#ifndef \(\w+\) +", "", line)
            if re.match(rf"#declare ({lengths})\b", line):
                assert line.endswith("tiles")
            if re.match(r"#declare (Alpha|BaseAngle)\b", line):
                assert "degrees" in line


def test_the_origin_of_a_line():
    scene = Chess(piece="king")
    text = to_pov(scene)
    lines = text.splitlines()
    for part, template in (
        ("interior {", "sheets.pov.j2"),
        ("// the cross", "pieces/king.pov.j2"),
        ("checker", "floor.pov.j2"),
    ):
        number = next(n for n, line in enumerate(lines, 1) if part in line)
        assert origin_of(scene, text, number) == (template, None)


def test_every_part_begins_with_its_name():
    for path in TEMPLATES.rglob("*.pov.j2"):
        name = path.relative_to(TEMPLATES).as_posix()
        if name != "header.pov.j2":
            assert re.search(rf"^// ---- .* \({re.escape(name)}\) ----$", path.read_text(), flags=re.M), name


@pytest.fixture
def own_templates(tmp_path, monkeypatch):
    """A copy of the templates, from which scenes are written in this test, and which is not compiled yet."""
    folder = shutil.copytree(TEMPLATES, tmp_path / "templates", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(sdl, "TEMPLATES", folder)
    monkeypatch.setattr(sdl, "COMPILED", folder / "__pycache__")
    sdl._environment.cache_clear()
    yield folder
    sdl._environment.cache_clear()


def written():
    """Return a scene's text from templates that no process has loaded yet."""
    sdl._environment.cache_clear()
    return to_pov(Spheres())


@pytest.mark.parametrize("writes", [True, False])
def test_templates_are_compiled_once(writes, own_templates, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", not writes)
    text, folder = written(), own_templates / "__pycache__"
    assert folder.exists() == writes
    if writes:
        before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
        assert written() == text
        assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == before
        os.utime(Path(shutil.copy(sdl.__file__, own_templates)), (0, 0))
        monkeypatch.setattr(sdl, "__file__", str(own_templates / "sdl.py"))  # the module that compiles has changed
        assert written() == text
        assert not {path.stat().st_mtime_ns for path in folder.iterdir()} & {*before.values()}
    template = own_templates / "spheres.pov.j2"
    template.write_text(template.read_text() + "// changed\n")
    assert written() == text + "// changed\n"


def test_no_folder_for_compiled_templates(own_templates, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (own_templates / "__pycache__").symlink_to("missing")  # nobody can write there, not even root
    assert written().startswith("//")


def test_pieces_are_those_that_have_a_template():
    assert {path.name.removesuffix(".pov.j2") for path in (TEMPLATES / "pieces").glob("*.j2")} == {*PIECES, "turned"}


def test_formulas_and_colour_maps_in_glsl():
    assert materials.floats("2*pi*x2 + 13*A - 1.5*sin(17) + 1e-6") == "2.0*pi*x2 + 13.0*A - 1.5*sin(17.0) + 1e-6"
    glsl = {"vec3": lambda *colour: np.array(colour), "mix": lambda a, b, t: a + t * (b - a), "clamp": np.clip}
    for colours in materials.COLOUR_MAPS.values():
        places = [float(place) for place in colours]
        rgb = np.array([[float(part) for part in colour.split(",")] for colour in colours.values()])
        expression = materials.interpolated(colours)
        for value in np.linspace(-0.1, 1.1, 49):
            wanted = [np.interp(value, places, rgb[:, k]) for k in range(3)]
            assert eval(expression, glsl | {"value": value}) == pytest.approx(wanted, abs=1e-12)


def test_windows_of_equal_prisms_with_another_alpha_have_their_shapes():
    """They stand before a window of other prisms, or of lenses."""
    for last in ({"prisms": 50}, {"sheet": "lenticular"}):
        text = to_pov(Chess(z1=8, z2=10, window=[{"z": 2, "alpha": 120}, {"z": 4, **last}]))
        assert text.count("  { 100, 1.5, 45, 1, 0.01, 0, 2 }") == 2
