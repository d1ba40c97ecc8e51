"""The .pov text: legible, only what the scene shows, frames that differ only in their parameters."""

import os
import re
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from povgen import Chess, PovrayError, Rendering, Spheres, to_pov
from povgen.inputs.pieces import PIECES
from povgen.measure.probes import Directions, PiecePositions, Positions
from povgen.rendering import povray
from povgen.rendering.frames import read_png
from povgen.scene import materials, sdl
from povgen.scene.sdl import TEMPLATES, Mosaic
from povgen.scene.survey import Survey

FOUND = Survey(20, 0.5)  # no ray is traced for the trace level, which is only a number in the text
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
    return re.sub(r"//.*", "", to_pov(scene, mosaic, found=FOUND))


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
    folders = [Path(base) for base in ("/usr/share", "/usr/local/share")]
    if files := [file for folder in folders for file in folder.glob("povray*/include/*.inc")]:
        declared, local = names_in(files)
        assert {"Red", "Reorient_Trans"} <= declared and "Up" in local
        assert not (values | macros) & declared
        assert not macros & local


@pytest.mark.parametrize("sheet", SHEETS)
def test_frames_differ_only_in_their_parameters(sheet):
    first, second = to_pov(Chess(alpha=10, z1=2, sheet=sheet, x=1, eye=(0.3, 0.67))), to_pov(Chess(z1=3, sheet=sheet))
    assert first != second and body(first) == body(second)
    first, second = to_pov(Spheres(alpha=10, z1=(2, 3), sheet=sheet)), to_pov(Spheres(z1=(2, 3), z2=5, sheet=sheet))
    spheres = re.compile(r"^  \{ .* \},?$", re.M)
    assert first != second and spheres.sub("", body(first)) == spheres.sub("", body(second))


def test_parameters_name_their_unit():
    for scene in scenes():
        for line in to_pov(scene, found=FOUND).splitlines():
            lengths = "Z1|Z2|Window|Rim|FrameDepth|ViewHeight|EyeX|EyeY|LX|LY|PieceX|FloorY|FootRadius|Pedestal|SeenUp"
            line = re.sub(r"^#ifndef \(\w+\) +", "", line)
            if re.match(rf"#declare ({lengths})\b", line):
                assert line.endswith("tiles")
            if re.match(r"#declare (Alpha|BaseAngle)\b", line):
                assert "degrees" in line


# within other parts, whose name a line of theirs is told by
WITHIN = {
    f"{name}.pov.j2"
    for name in (
        "header",
        "command",
        "glass",
        "frame_section",
        "frame_side",
        "prism_pair",
        "prism_shape",
        "prism_sheet",
    )
}


def test_every_part_begins_with_its_name():
    for path in TEMPLATES.rglob("*.pov.j2"):
        name = path.relative_to(TEMPLATES).as_posix()
        if name not in WITHIN:
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


def test_templates_are_compiled_once(own_templates, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    text, folder = written(), own_templates / "__pycache__"
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert before and written() == text
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
        text = to_pov(Chess(z1=8, z2=10, window=[{"z": 2, "alpha": 120}, {"z": 4, **last}]), found=FOUND)
        assert text.count("Shape(Window, 100, 1.5, 45, 1, 0.01, 0)") == 2


OBJECTS = "box|cone|cylinder|difference|light_source|mesh|object|plane|sky_sphere|sphere|union"


@pytest.mark.release
@pytest.mark.parametrize(
    "scene",
    [
        Chess(),
        Spheres(sheet="ideal", window="alpha=120,z=2", z1=(1, 3)),
        Chess(sheet="single", background="white", z1=1),
    ],
    ids=lambda scene: f"{scene.name}-{scene.sheet}",
)
def test_every_object_changes_the_picture(scene, tmp_path):
    """Without it the picture differs, or the text has an error, because a macro returns it."""
    text = to_pov(scene)
    found = [*re.finditer(rf"^( *)(?:{OBJECTS}) \{{(?: [^\n]*\}}$|\n.*?^\1\}}$)", text, re.M | re.S)]

    def picture(n, text):
        (tmp_path / f"{n}").mkdir()
        return read_png(povray.run(text, Rendering(size=(320, 240), antialias="off"), tmp_path / f"{n}"))

    def matters(n):
        try:
            return (picture(n, text[: found[n].start()] + text[found[n].end() :]) != whole).any()
        except PovrayError:
            return True

    whole = picture("whole", text)
    with ThreadPoolExecutor(4) as pool:
        needed = pool.map(matters, range(len(found)))
        assert len(found) > 4 and not [each[0] for each, is_needed in zip(found, needed, strict=True) if not is_needed]
