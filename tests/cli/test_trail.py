"""The trail: every file that a command or a function writes says how it was made, and how to cite povgen."""

import ast
import json
import re
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
import trimesh
from conftest import PROJECT, povgen
from PIL import Image
from pytest import approx

from povgen import Chess, InputError, draw, info, live, part
from povgen.citation import CITE, HOME
from povgen.cli.app import COMMANDS, app
from povgen.measure import speed, stability, verify
from povgen.measure.plotting import drawn, save_table
from povgen.measure.stability_map import StabilityMap
from povgen.record import check_unasked, save
from povgen.version import __version__

SMALL = ["--sheet", "none", "--size", "32x32"]
FEW = ["chess", "--prisms", "20", "--gap", "0.1"]
# each command that writes files: the arguments of the runs here, and the files of each run
WRITTEN = {
    "frame": [(["chess", *SMALL, "-o", "a.png"], "a.png"), (["chess", *SMALL, "-o", "a.exr"], "a.exr")],
    "movie": [
        (["chess", *SMALL, "--sweep", "z1=1:2", "--frames", "2", "-o", name], files)
        for name, files in (
            ("a.mp4", "a.mp4"),
            ("a.webm", "a.webm"),
            ("a.webp", "a.webp"),
            ("a.gif", "a.gif"),
            ("%d.png", "1.png 2.png"),
        )
    ],
    "pov": [(["chess", "-o", "a.pov"], "a.pov"), (["chess", "--part", "sheets", "-o", "a.inc"], "a.inc")],
    "live": [(["chess", "-o", "a.html"], "a.html")],
    "demo": [(["-o", "b.html"], "b.html")],
    "part": [([*FEW, "-o", f"a.{kind}"], f"a.{kind}") for kind in ("stl", "obj", "glb")],
    "tolerance": [
        ([*FEW, "-o", "t.svg"], "t.svg t.csv"),
        ([*FEW, "--deviation", "turn=0.1", "--builds", "2", "-o", "u.pdf"], "u.pdf u.csv"),
    ],
    "figure": [(["1", "--pdf", "-o", "."], "figure1.png figure1.svg figure1.pdf")],
    "chart": [(["-o", "."], "frames.csv machine.txt frames-64x48.png frames-64x48.svg")],
    "verify": [
        (["--json", "v.json"], "v.json"),
        (["--stability", "--sheet", "ideal", "-o", "."], "none.csv none.png"),
    ],
}
RUNS = [(name, *run) for name, runs in WRITTEN.items() for run in runs]


@pytest.fixture
def nothing_measured(monkeypatch):
    """The commands that measure for long write their files with a few made-up numbers."""
    point = SimpleNamespace(row=("detailed", "off", 64, 48, 1.0, 0.1, 0.1))
    monkeypatch.setattr(speed, "measure_samplings", lambda *_: [point])
    monkeypatch.setattr(verify, "checks", lambda _: [])
    made = StabilityMap("none", "a map", "x", "y", 1.0, rows=[("a", 1.0, 2.0), ("a", 2.0, 1.0)])
    monkeypatch.setattr(stability, "maps", lambda _: [made])
    monkeypatch.setattr(stability, "MAPS", ["none"])


def test_every_command_that_writes_files_is_here():
    names = {"-o", "--output", "--json"}
    found = {n for n in COMMANDS if names & {o for p in app.get_command(None, n).params for o in p.opts}}
    assert found == {*WRITTEN}


@pytest.mark.parametrize(("name", "arguments", "files"), RUNS, ids=[f"{name} {files}" for name, _, files in RUNS])
def test_every_file_has_its_record(name, arguments, files, tmp_path, nothing_measured):
    status, _, said = povgen([name, *arguments], tmp_path)
    assert status == 0, said
    for file in files.split():
        if file.endswith(".stl"):
            assert (tmp_path / file).read_bytes()[:80].rstrip() == f"povgen {__version__}, {HOME}".encode()
            assert "an STL file has no room for a record" in povgen(["info", file], tmp_path)[2]
            continue
        found = json.loads(povgen(["info", file], tmp_path)[1])
        assert found["povgen"] == __version__ and found["cite"] == CITE and HOME in CITE
        assert found["command"] == " ".join(["povgen", name, *arguments])
        assert ("frames" in found) == (name in ("frame", "movie", "part", "tolerance"))
        if "frames" not in found:
            said = povgen(["frame", "--from", file, "-o", "again.png"], tmp_path)
            assert said == (2, "", f"povgen: '{file}': its record has no scene; allowed: a picture or a movie\n")


def test_files_stay_what_they_are(tmp_path):
    """Other programs read them."""
    with drawn(3, 2, *(tmp_path / f"a{kind}" for kind in (".png", ".svg"))) as figure:
        figure.subplots().plot([1, 2])
    assert ElementTree.parse(tmp_path / "a.svg").getroot().tag.endswith("svg")
    with Image.open(tmp_path / "a.png") as image:
        image.load()
        assert image.info["dpi"] == approx((110, 110), abs=0.01)
    save(b"<html>--</html>", tmp_path / "a--b.html")
    assert (tmp_path / "a--b.html").read_text().count("--") == 3  # its own, and the comment's
    save(b'{"a": 1}', tmp_path / "a.json")
    assert json.loads((tmp_path / "a.json").read_text())["a"] == 1
    for kind in ("stl", "obj", "glb"):
        part(Chess(prisms=20, gap=0.1), tmp_path / f"a.{kind}")
    sizes = [trimesh.load(tmp_path / f"a.{kind}", force="mesh").volume for kind in ("stl", "obj", "glb")]
    assert sizes == approx([sizes[0], sizes[0], sizes[0] / 1e9], rel=1e-4)


def test_text_of_a_narrow_drawing_is_legible(tmp_path):
    """It has 7 points, where the usual drawing of 229 mm has 11."""
    for width, shown in ((84, 84 / 25.4 * 11 / 7), (200, 9)):
        text = draw(Chess(prisms=20), tmp_path / "a.svg", width=width).read_text()
        assert f'width="{width}mm"' in text and float(re.search(r'viewBox="0 0 (\S+) ', text)[1]) == approx(72 * shown)


def test_the_call_in_python(tmp_path):
    part(Chess(prisms=20, gap=0.1), tmp_path / "a.obj", tile=20)
    path = str(tmp_path / "a.obj")
    assert info(path).command == f"povgen.part(Chess(prisms=20, gap=0.1), {path!r}, tile=20)"
    assert Chess.from_file(path) == Chess(prisms=20, gap=0.1)  # with all its parameters
    assert povgen(["frame", "--from", "a.obj", "--size", "32x32"], tmp_path) == (0, "wrote frame.png\n", "")
    draw(Chess(prisms=20), tmp_path / "a.pdf", azimuth=-90, elevation=0)
    assert info(tmp_path / "a.pdf").command.endswith("a.pdf', azimuth=-90, elevation=0)")
    live(Chess()).save(tmp_path / "a.html")
    assert info(tmp_path / "a.html").cite == CITE
    save_table(tmp_path / "a.csv", ("a",), [])
    assert info(tmp_path / "a.csv").command is None  # no function of povgen's was called


def test_a_table_of_another_program_stays(tmp_path):
    for name, text in (("a.csv", "x,y\n1,2\n"), ("empty.csv", ""), ("a.md", "povgen record 1 01234567 {}\n")):
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError, match="povgen did not write it"):
            check_unasked([tmp_path / name])
        with pytest.raises(InputError, match="without a record"):
            info(tmp_path / name)


def test_files_are_written_in_one_place():
    """So that a new kind of chart has its record by itself."""
    for path in (PROJECT / "povgen").rglob("*.py"):
        names = {
            alias.name
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.ImportFrom) and node.module == "povgen.files"
            for alias in node.names
        }
        assert "write" not in names or path.name == "record.py", path
