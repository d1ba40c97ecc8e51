"""The .pov text: legible, only what the scene shows, frames that differ only in their parameters."""

import re
import sys
from pathlib import Path

import pytest

from povgen import Chess, Spheres, to_pov
from povgen.inputs.pieces import PIECES
from povgen.measure.probes import Directions, PiecePositions, Positions
from povgen.scene import sdl
from povgen.scene.sdl import Mosaic
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


def test_no_folder_for_compiled_templates(tmp_path, monkeypatch, request):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (tmp_path / "compiled").symlink_to("missing")  # nobody can write there, not even root
    monkeypatch.setattr(sdl, "COMPILED", tmp_path / "compiled")
    request.addfinalizer(sdl._environment.cache_clear)
    sdl._environment.cache_clear()
    assert to_pov(Spheres()).startswith("//")


def test_windows_of_equal_prisms_with_another_alpha_have_their_shapes():
    """They stand before a window of other prisms, or of lenses."""
    for last in ({"prisms": 50}, {"sheet": "lenticular"}):
        text = to_pov(Chess(z1=8, z2=10, window=[{"z": 2, "alpha": 120}, {"z": 4, **last}]), found=FOUND)
        assert text.count("Shape(Window, 100, 1.5, 45, 1, 0.01, 0)") == 2
