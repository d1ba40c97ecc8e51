"""The .pov text: legible, only what the scene shows, frames that differ in their parameters alone."""

import re
import subprocess

import pytest

from povgen import Chess, Spheres, render, to_pov
from povgen.measure.probes import Directions, PiecePositions, Positions
from povgen.rendering import frames
from povgen.scene.models import PIECES
from povgen.scene.sdl import TEMPLATES, template_of

SHEETS = ("detailed", "ideal", "single", "none")


def scenes():
    for sheet in SHEETS:
        yield Spheres(sheet=sheet)
        for piece in PIECES:
            yield Chess(sheet=sheet, piece=piece)
        yield Directions(sheet=sheet)
        yield Positions(sheet=sheet, z1=3)
        yield PiecePositions(sheet=sheet)
    yield Chess(predicted_image=True)
    yield Chess(predicted_image=True, sheet="ideal", offset=(0.5, -1))


def body(text):
    """The text without its parameter block."""
    return re.sub(r"^#declare \w+ += .*;  // .*$", "", text, flags=re.M)


@pytest.mark.parametrize("scene", list(scenes()), ids=lambda s: f"{s.name}-{s.sheet}-{getattr(s, 'piece', '')}")
def test_everything_declared_is_used(scene):
    code = re.sub(r"//.*", "", to_pov(scene))
    for kind, name in re.findall(r"#(declare|macro|local)\s+(\w+)", code):
        uses = len(re.findall(rf"\b{name}\b", code))
        assert uses > 1, f"{kind} {name} is not used"
    assert "#include" not in code


def test_no_sheet_where_there_is_none():
    assert "ior" not in to_pov(Chess(sheet="none"))
    assert "ior" not in to_pov(Chess(sheet="ideal"))
    assert "mesh_camera" not in to_pov(Chess(sheet="detailed"))
    assert "Alpha" not in to_pov(Chess(sheet="none"))


@pytest.mark.parametrize("sheet", SHEETS)
def test_frames_differ_in_parameters_alone(sheet):
    assert to_pov(Chess(alpha=10, z1=2, sheet=sheet, offset=(1, -2))) != to_pov(Chess(z1=3, sheet=sheet))
    assert body(to_pov(Chess(alpha=10, z1=2, sheet=sheet, offset=(1, -2)))) == body(to_pov(Chess(z1=3, sheet=sheet)))
    assert (
        body(to_pov(Spheres(alpha=10, z2=5, sheet=sheet))).split("Spheres    =")[0]
        == (body(to_pov(Spheres(sheet=sheet))).split("Spheres    =")[0])
    )


def test_parameters_name_their_unit():
    for scene in scenes():
        for line in to_pov(scene).splitlines():
            if re.match(r"#declare (Z1|Z2|Window|Rim|Depth|EyeX|EyeY|FloorY)\b", line):
                assert line.endswith("tiles")
            if re.match(r"#declare (Alpha|BaseAngle|Nu)\b", line):
                assert "degrees" in line


def test_a_line_is_traced_to_its_template():
    text = to_pov(Chess(piece="king"))
    lines = text.splitlines()
    for part, template in (
        ("mesh {", "sheets.pov.j2"),
        ("// the cross", "pieces/king.pov.j2"),
        ("checker", "floor.pov.j2"),
    ):
        number = next(n for n, line in enumerate(lines, 1) if part in line)
        assert template_of(text, number) == template


def test_every_part_begins_with_its_name():
    for path in TEMPLATES.rglob("*.pov.j2"):
        name = path.relative_to(TEMPLATES).as_posix()
        if name not in ("header.pov.j2",):
            assert re.search(rf"^// ---- .* \({re.escape(name)}\) ----$", path.read_text(), flags=re.M), name


def test_pieces_are_those_that_have_a_template():
    assert {path.name.removesuffix(".pov.j2") for path in (TEMPLATES / "pieces").glob("*.j2")} == {*PIECES, "turned"}


def test_the_command_in_the_header_makes_povgens_picture(tmp_path):
    scene = Chess(sheet="none")
    (tmp_path / "scene.pov").write_text(to_pov(scene))
    (command,) = re.findall(r"^//   (povray .*)$", to_pov(scene), flags=re.M)
    subprocess.run([*command.split(), "-D", "+Oown.png"], cwd=tmp_path, check=True, capture_output=True)
    assert (frames.read(tmp_path / "own.png") == render(scene)).all()
