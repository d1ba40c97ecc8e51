"""The command that a .pov names makes the picture that povgen makes."""

import re
import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import povgen, refused, some

from povgen import Chess, InputError, Room, Spheres, Window, render, to_pov, to_sheets
from povgen.inputs.pictures import used
from povgen.rendering import frames, light

EMPTY = Chess(sheet="none")


def drawn(source, folder, file="scene.pov", more=()):
    """Run the command in the source's header, with more options, and return its picture."""
    (folder / file).write_text(source)
    for name, content in used(source).items():
        (folder / name).write_bytes(content)
    (command,) = re.findall(r"^//   (povray .*)$", source, flags=re.M)
    subprocess.run([*shlex.split(command), "-D", "+Oown.png", *more], cwd=folder, check=True, capture_output=True)
    return frames.read_png(folder / "own.png")


def test_the_command_in_the_header_makes_povgens_picture(tmp_path):
    scene = EMPTY
    options = {"size": (64, 48), "antialias": "2,0.1,3"}
    assert (drawn(to_pov(scene, **options), tmp_path) == render(scene, **options)).all()
    reduced = {"antialias": "1.5x", "size": (64, 48)}
    source = to_pov(scene, **reduced)
    large = drawn(source, tmp_path)
    assert "povgen averages the light of this picture, which is 1.5 times as wide" in source
    assert large.shape == (72, 96, 3) and (light.reduced(large, (64, 48)) == render(scene, **reduced)).all()
    assert "1.5 times as wide" in to_pov(Chess())
    with pytest.raises(InputError, match="size = 3"):
        to_pov(scene, size=3)


def test_a_narrow_room_with_its_rays(tmp_path):
    """The text and the rays are those of a view that is as wide as the default is high."""
    (tmp_path / "room.toml").write_text("[[window]]\nsheet = 'ideal'\n[[object]]\nkind = 'floor'")
    command = ["pov", "room.toml", "--size=32x64", "-o", "own.pov"]
    files = []
    for more in ([], ["--eye", "view=10"]):
        assert povgen([*command, *more], tmp_path)[0] == 0
        files.append([path.read_text().partition("// povgen record")[0] for path in sorted(tmp_path.glob("own*"))])
    assert files[0] == files[1] and len(files[0]) == 3


@pytest.mark.parametrize("file", some(["it's mine.pov", "a=b[0].pov"], 1))
def test_the_command_names_the_file(file, tmp_path):
    options = ["--sheet", "none", "--size", "32x32", "--antialias", "off"]
    assert povgen(["pov", "chess", *options, "-o", file], tmp_path)[0] == 0
    source = (tmp_path / file).read_text()
    (tmp_path / file).unlink()
    assert drawn(source, tmp_path, file).shape == (32, 32, 3)


def test_the_header_names_no_file_that_povray_cannot_open(tmp_path):
    said = "// POV-Ray cannot open this file by its name: copy it to scene.pov.\n"
    assert said not in to_pov(EMPTY)
    for file in ("é.pov", '".pov', "a\nsphere { 0, 1 }.pov"):
        assert povgen(["pov", "chess", "--sheet", "none", "-o", file], tmp_path)[0] == 0
        header, found, rest = (tmp_path / file).read_text().rpartition("// povgen record")[0].partition(said)
        assert found and header.count("\n") == header.count("\n//") + 1 and header + rest == to_pov(EMPTY)


PRISMS = {"prisms": 30, "index": 1.7, "base_angle": 40, "gap": 0.05, "aspect": 0.9, "aperture": 3.6}
SAME = {"view": 5, "z2": 7, "eye": (0.3, 0.1), "alpha": 100}


@pytest.mark.parametrize(
    ("scene", "other"),
    some(
        [
            (Chess(view=4), SAME | PRISMS | {"z1": 4, "x": 0.2, "pedestal": 0.5}),
            (Chess(sheet="axis", z1=4), {"axis": (0.2, 1, 0.1), "z2": 8, "alpha": 15}),
            (Spheres(z1=(2, 8), sheet="ideal"), {"line": (0.3, 0.4), "alpha": 100, "view": 5, "aperture": 3.6}),
            (Chess(window="z=2,prisms=40,alpha=50", z2=8), {"alpha": 100, "z1": 4, "z2": 9}),
        ],
        2,
        several=True,
    ),
    ids=["prisms", "law", "ideal", "windows"],
)
def test_parameters_can_be_declared_on_the_command_line(scene, other, tmp_path):
    """The text of one scene, with the parameters of another, makes the picture of the other."""
    options = {"size": (64, 48), "antialias": "off"}
    other = scene.replace(**other)
    free = dict(re.findall(r"^#ifndef \((\w+)\) +#declare \w+ += (.*?); #end", to_pov(other), flags=re.M))
    own = to_pov(scene, **options)
    declared = [f"Declare={name}={value}" for name, value in free.items() if f"#ifndef ({name})" in own]
    assert len(declared) >= 6
    found, wanted = drawn(own, tmp_path, more=declared), render(other, **options)
    assert (found == wanted).all(-1).mean() > 0.995 and (wanted != render(scene, **options)).any(-1).mean() > 0.3


@pytest.mark.parametrize(
    ("sheets", "row"),
    some(
        [
            ("sheet=ideal,alpha=40", "  { Alpha_2, %g }\n"),
            ("sheet=mirror,alpha=20", "  { Alpha_2, %g }\n"),
            ("sheet=lens", "  { 0, %g }\n"),
        ],
        1,
        several=True,
    ),
)
def test_the_places_of_windows_are_stated_once(sheets, row, tmp_path):
    """Edited in the text, a window stands elsewhere for the camera, too. The array's alphas are the laws' own."""
    options = {"size": (64, 48), "antialias": "off"}
    near, far = (Chess(sheet="lens", window=f"z={z},{sheets}", view=4, z1=3) for z in (1, 3))
    own = to_pov(near, **options)
    assert own.count(row % 1) == 1
    found, wanted = drawn(own.replace(row % 1, row % 3), tmp_path, more=["Declare=Cells=100"]), render(far, **options)
    assert (abs(found.astype(int) - wanted).max(-1) < 9).mean() > 0.97
    assert (wanted != render(near, **options)).any(-1).mean() > 0.1


@pytest.mark.parametrize(
    "arrangements",
    some([("single", "pair"), ("pair", "single"), ("single", "single")], 1),
)
def test_windows_of_one_profile_in_any_arrangement(arrangements):
    """POV-Ray stops at a name that is not declared."""
    first, second = arrangements
    scene = Chess(sheet="profile", arrangement=first, window=f"z=2,arrangement={second}", z1=3)
    assert render(scene, size=(32, 32), antialias="off").std() > 10
    assert to_sheets(scene).count("#declare SheetsApart") == ("pair" in arrangements)


def test_the_sheets_in_a_scene_of_ones_own(tmp_path):
    """docs/own.md: the scene shows through the sheets what it shows without them, but turned."""
    status, source, _ = povgen(["pov", "chess", "--part", "sheets", "--prisms", "60", "-o", "sheets.inc"], tmp_path)
    assert (status, source) == (0, "")
    page = Path(__file__).parents[2] / "docs" / "own.md"
    (scene,) = re.findall(r"(?s)```pov\n(.*?)```", page.read_text())
    header = "//   povray +Iscene.pov +W96 +H72 -A\n"
    shown = [drawn(f"{header}{text}", tmp_path).astype(int) for text in (scene, scene.replace("object { Sheets", "//"))]
    changed = abs(shown[0] - shown[1]).max(-1) > 30
    inside = np.zeros((72, 96), bool)
    inside[17:55, 29:67] = True
    assert changed[inside].mean() > 0.5 > 0.02 > changed[:, :15].mean() + changed[:, -15:].mean()
    assert (shown[0][inside].mean(-1) < 20).mean() < 0.1, "TraceLevel is not obeyed"


def test_two_parts_in_a_scene_have_their_own_parameters(tmp_path):
    """What the scene declares before an #include counts for all that follow."""
    for file, scene in (("one.inc", Chess(alpha=30, prisms=30)), ("two.inc", Chess(alpha=50, prisms=40, index=1.6))):
        seen = (
            '#declare Seen = concat(Seen, str(Alpha, 0, 0), ",", str(Prisms, 0, 0), ",", str(GlassIndex, 0, 1), " ");'
        )
        (tmp_path / file).write_text(f"{to_sheets(scene)}\n{seen}\n")
    both = '#include "one.inc" #include "two.inc"'
    right = "30,30,1.5 50,40,1.6 7,30,1.5 7,40,1.6 "
    check = f'#if (strcmp(Seen, "{right}")) #error Seen #end camera {{ location -z }}'
    header = '//   povray +Iscene.pov +W4 +H4\n#version 3.7; #declare Seen = "";'
    drawn(f"{header} {both} #declare Alpha = 7; {both} {check}", tmp_path)


def test_parts_that_cannot_be(tmp_path):
    with pytest.raises(
        InputError, match="sheet = 'ideal' has no glass; allowed: 'detailed', 'single', 'lenticular', 'profile'$"
    ):
        to_sheets(Chess(window="z=2", sheet="ideal"))
    with pytest.raises(InputError, match="part = 'sheets' is not for Room"):
        to_sheets(Room([Window(sheet="detailed")]))
    for options, said in (
        (["--part", "frame"], "part = 'frame': allowed: sheets"),
        (["--part", "sheets", "--size", "64x48"], "part = 'sheets', size: the picture is not povgen's"),
        (["--part", "sheets", "-o", "a.pov"], ".inc"),
        (["--part", "sheets", "--sheet", "none"], "sheet = 'none' has no glass"),
    ):
        assert said in refused(["pov", "chess", *options], tmp_path)


@pytest.mark.parametrize("option", [{"stereo": "pair"}, {"caption": "full"}, {"overlay": True}, {"timeout": 9}])
def test_to_pov_refuses_what_its_header_cannot_promise(option):
    with pytest.raises(InputError, match="unknown; allowed: quality, size, antialias$"):
        to_pov(EMPTY, **option)


def test_what_only_povgen_draws_is_no_option_of_pov(tmp_path):
    assert "--caption" in refused(["pov", "chess", "--caption=full"], tmp_path)
    assert "size = '3x3'" in refused(["pov", "chess", "--size", "3x3"], tmp_path)
