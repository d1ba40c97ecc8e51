"""The documentation: links lead to files, commands exist, blocks of code run, make targets make the pictures."""

import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from contextlib import suppress
from functools import cache
from pathlib import Path
from textwrap import dedent

import gallery  # docs/gallery.py
import imageio.v3 as iio
import nbformat
import notebook  # docs/notebook.py
import numpy as np
import pytest
import reference  # docs/reference.py
from conftest import PROJECT, povgen
from nbclient import NotebookClient

from povgen import Bundle, Chess, Eye, InputError, MovieSpec, Room, Window, info, mtf, results
from povgen.cli.app import COMMANDS
from povgen.cli.report import SYMPTOMS
from povgen.measure.measured import px
from povgen.optics.equations import apparent_position

PAGES = [
    *(PROJECT / f"{name}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG", "CODE_OF_CONDUCT", "SECURITY")),
    *sorted((PROJECT / "docs").glob("*.md")),
    PROJECT / "docs" / "figures" / "README.md",
]
BLOCK = r"^```(\w+)\n(.*?)^```"  # of code: its language and its text


@pytest.fixture
def environment(tmp_path):
    """povgen's programs on the path, as after `. .venv/bin/activate`."""
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "IPYTHONDIR": str(tmp_path)}


def name(path):
    return path.relative_to(PROJECT).as_posix()


def headings(page):
    """Return the anchors of a page's headings, as GitHub makes them."""
    found = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in found}


def blocks(page):
    return re.findall(BLOCK, page.read_text(), re.M | re.S)


def smaller(code):
    """Return code that renders smaller pictures, and fewer for a movie, with nothing else changed."""
    code = re.sub(r"(povgen movie .*--quality draft)", r"\1 --frames 4", code)
    code = code.replace('quality="high"', 'quality="high", size=(96, 72)').replace("(640, 480)", "(96, 72)")
    code = code.replace("--quality draft", "--quality draft --size 96x72").replace("STEPS = 10", "STEPS = 2")
    code = code.replace("10_000_000", "1_000_000")  # rays
    code = code.replace('"quality": "draft"', '"quality": "draft", "size": (96, 72)').replace(
        "(3840, 2160)", "(96, 54)"
    )
    return code.replace('quality="draft"', 'quality="draft", size=(96, 72)')


def commands(page):
    """Yield the shell commands of a page: indented lines, lines of bash blocks, and `code`."""
    text = page.read_text().replace("\\\n", "")  # a backslash continues a line
    indented = re.findall(r"^ {4}((?:povgen|make|time make) .*)$", text, re.M)
    written = [
        line for kind, block in re.findall(BLOCK, text, re.M | re.S) if kind == "bash" for line in block.splitlines()
    ]
    prose = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    inline = re.findall(r"`((?:povgen|make|time make) [^`]*)`", prose)
    for line in [*indented, *(line for line in written if re.match(r"(povgen|make) ", line)), *inline]:
        yield shlex.split(line.partition(" | ")[0], comments=True)


def links(page):
    return re.findall(r"\]\(([^)\s]+)\)", re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page):
    ours = tuple(tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["urls"].values())
    for link in (each for each in links(page) if not each.startswith(ours)):
        target, _, anchor = link.partition("#")
        path = (page.parent / target).resolve() if target else page
        assert "://" not in link and path.exists() and path.is_relative_to(PROJECT), link
        assert not anchor or anchor in headings(path), link
    named = re.findall(r"`((?:tests|benchmarks|povgen|docs|templates)/[\w/.-]+\.\w+)`", page.read_text())
    missing = [file for file in named if not (PROJECT / file).exists()]
    assert not missing or page.stem in ("adding", "CONTRIBUTING", "CHANGELOG")  # files to be made


def test_the_code_names_pages_and_headings_that_exist():
    """In comments and in messages. An address of docs/troubleshooting.md is made by `remedies.page`."""
    files = [path for kind in ("py", "js", "toml", "j2") for path in (PROJECT / "povgen").rglob(f"*.{kind}")]
    code = "\n".join(path.read_text() for path in files)
    named = set(re.findall(r"\b(docs/[\w/.-]+\.(?:md|csv|py))(?:#([\w-]+))?", code))
    named |= {("docs/troubleshooting.md", symptom) for symptom in re.findall(r"""remedies\.page\(["']([\w-]+)""", code)}
    named |= {("docs/troubleshooting.md", symptom) for symptom in SYMPTOMS.values()}
    assert len(named) > 15
    for page, anchor in named:
        assert (PROJECT / page).exists() and (not anchor or anchor in headings(PROJECT / page)), (page, anchor)


def test_every_page_can_be_reached_from_the_readme():
    reached, to_read = set(), [PAGES[0]]
    while to_read:
        page = to_read.pop()
        reached.add(page)
        found = {(page.parent / link.partition("#")[0]).resolve() for link in links(page)}
        to_read += [path for path in found - reached if path.suffix == ".md"]
    assert reached == set(PAGES)


@cache
def options(command):
    """Return the options that a command's own help lists."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "200")
        status, text, _ = povgen([command, "--help"], PROJECT)
    assert status == 0
    return set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", text))


@pytest.mark.parametrize("page", [page for page in PAGES if page.stem != "CHANGELOG"], ids=name)  # it has old ones too
def test_commands_exist(page):
    for first, *rest in commands(page):
        if first == "povgen":
            used = {word.partition("=")[0] for word in rest if re.match("--?[a-z]", word)}
            assert used <= (options(rest[0]) if rest[0] in COMMANDS else {"--help", "--version"}), rest


def test_make_knows_the_targets():
    """All in one dry run, which reads the whole Makefile."""
    lines = [line for page in PAGES if page.stem != "CHANGELOG" for line in commands(page) if line[0] != "povgen"]
    targets = {word for line in lines for word in line if word not in ("make", "time") and "=" not in word}
    done = subprocess.run(["make", "--dry-run", *targets], cwd=PROJECT, capture_output=True, text=True)
    assert len(targets) > 10 and done.returncode == 0, done.stderr


def test_every_command_is_documented():
    assert {rest[0] for page in PAGES for first, *rest in commands(page) if first == "povgen"} >= set(COMMANDS)


# The seminar's blocks run as a notebook, below.
# test_adding_adds and test_the_notebook_runs run the others
QUICK = ("README", "beyond", "errata")  # seconds
WITH_BLOCKS = [p for p in PAGES if "python" in dict(blocks(p)) and p.name not in ("adding.md", "seminar.md")]


@pytest.mark.parametrize(
    "page",
    [page if page.stem in QUICK else pytest.param(page, marks=pytest.mark.release) for page in WITH_BLOCKS],
    ids=name,
)
def test_a_pages_blocks_run(page, tmp_path, environment):
    """The blocks of a page run in their order, in one Python session and one folder."""
    script = tmp_path / "session.py"
    code = "".join(_as_python(kind, block) for kind, block in blocks(page) if kind in ("python", "bash"))
    script.write_text(smaller(code))
    done = subprocess.run([sys.executable, script], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr and "nan" not in done.stdout
    assert all(block in done.stdout for kind, block in blocks(page) if kind == "text")  # what a page says is printed


def _as_python(kind, block):
    if kind == "python":
        return block
    return f"import subprocess\nsubprocess.run(['bash', '-euo', 'pipefail', '-c', {block!r}], check=True)\n"


@pytest.mark.release
def test_the_examples_of_usage_run(tmp_path):
    usage, own = ((PROJECT / "docs" / f"{name}.md").read_text() for name in ("usage", "own"))
    (declaration,) = re.findall(r"(?s)( {4}#declare Piece.*?\n {4}\}\n)", own)
    (tmp_path / "mine.inc").write_text(dedent(declaration))
    (section,) = re.findall(r"(?ms)^## Examples\n(.*?)^More commands", usage)
    lines = [shlex.split(line, comments=True)[1:] for line in section.splitlines() if "    povgen" in line]
    assert len(lines) == 8
    for line in lines:
        line = [word.replace("3840x2160", "384x216") for word in line]
        small = [*["--size", "64x48"] * ("--size" not in line), *["--frames", "2"] * (line[0] == "movie")]
        assert povgen([*line, *small, "--quiet"], tmp_path) == (0, "", "")
    assert {path.name: len(iio.imread(path)) for path in tmp_path.glob("*.mp4")} == {"chess.mp4": 2, "eye.mp4": 2}
    pictures = {path.stem: iio.imread(path).shape for path in tmp_path.glob("*.png")}
    small = dict.fromkeys(("two", "glass", "mine"), (48, 64, 3))
    assert pictures == small | {"4k": (216, 384, 3), "piece": (48, 64, 4), "pair": (48, 128, 3)}


def test_movies_are_specs():
    """The movie of docs/adding.md: the eye moves away, and a note says what it sees at first."""
    page = (PROJECT / "docs" / "adding.md").read_text()
    (text,) = re.findall(r"(?ms)near-and-far\.toml <<'END'\n(.*?)^END$", page)
    movie = MovieSpec.parse(text, "adding.md")
    said = list(zip((scene.z2 for scene in movie.scenes("draft")), movie.texts("draft"), strict=True))
    first, last = said[0], said[-1]
    assert first == (pytest.approx(3), "the eye is near: the king turns more") and last == (pytest.approx(12), "")


@pytest.mark.release
@pytest.mark.timeout(900)  # it renders movies and makes a package
def test_adding_adds(tmp_path, environment):
    """The commands of docs/adding.md run in a copy of the project."""
    unwanted = shutil.ignore_patterns(
        ".git", ".venv", "build", "chart", "figures", "*.mp4", "*.png", "__pycache__", ".*_cache"
    )
    shutil.copytree(PROJECT, tmp_path / "povgen", symlinks=True, ignore=unwanted)
    environment["PYTHONPATH"] = str(tmp_path / "povgen")
    for kind, block in blocks(PROJECT / "docs" / "adding.md"):
        done = subprocess.run(
            [*(["bash", "-euo", "pipefail"] if kind == "bash" else [sys.executable]), "-c", smaller(block)],
            cwd=tmp_path / "povgen",
            env=environment,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stdout + done.stderr
    listed = subprocess.run(["povgen", "list"], env=environment, capture_output=True, text=True).stdout
    assert "spire" in listed and "ellipsoid" in listed and "near-and-far" in listed
    room = [
        "povgen",
        "frame",
        "room",
        "--object=kind=ellipsoid,z=2",
        "--window=alpha=60",
        "--size=96x72",
        "--antialias=off",
    ]
    for name in ("gl", "povray"):
        subprocess.run([*room, "--renderer", name, "-o", tmp_path / f"{name}.png"], env=environment, check=True)
    gl, pov = (iio.imread(tmp_path / f"{name}.png").astype(int) for name in ("gl", "povray"))
    assert (abs(gl - pov).max(-1) < 15).mean() > 0.99 and (gl[..., 1] > gl[..., 0] + 25).sum() > 50  # it is green
    subprocess.run(["povgen", "demo", "-o", tmp_path / "page.html"], env=environment, check=True)
    assert '<option value="cylinder" data-say="kinds.cylinder.choice"></option>' in (tmp_path / "page.html").read_text()


def test_the_notebook_is_the_seminar():
    kept = nbformat.read(PROJECT / "docs" / "seminar.ipynb", 4)
    nbformat.validate(kept)
    made = notebook.notebook(notebook.SEMINAR.read_text())
    assert kept == made, "run make docs/seminar.ipynb"
    code = [block for kind, block in blocks(notebook.SEMINAR) if kind in ("python", "bash")]
    assert all(any(block.strip() in cell.source for cell in made.cells) for block in code)


@pytest.mark.release
def test_the_notebook_runs(tmp_path, environment, monkeypatch):
    made = notebook.notebook(notebook.SEMINAR.read_text())
    for cell in made.cells:
        cell.source = smaller(cell.source)
    monkeypatch.setenv("PATH", environment["PATH"])
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    NotebookClient(made, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [out for cell in made.cells for out in cell.get("outputs", [])]
    assert sum("image/png" in out.data for out in outputs if out.output_type == "display_data") > 10
    printed = "".join(out.text for out in outputs if out.output_type == "stream")
    assert "designed path" in printed and "nan" not in printed and "Traceback" not in printed


def _parallax():
    """Return by how many degrees the views of two eyes differ vertically."""
    scenes = [Chess(sheet="ideal", alpha=90, z1=2, z2=6, eye=(x, 0)) for x in (-0.2, 0.2)]
    left, right = (complex(scene.apparent_position(scene.L, 2)) for scene in scenes)
    return (math.degrees((left - right).imag / 6),)


def _shares(scene):
    return [100 * column[0] for column in results(scene, "designed", "stray").values()]


TWO = Room([Window(alpha=180, width=1), Window(name="right", alpha=180, x=2, width=1)], eye=Eye(z=-6))


def _polarised():
    """Return the parts of unpolarised light along z that pass parallel and crossed polarisers, on the designed path."""
    rays = Chess(alpha=66, prisms=60).trace(Bundle([(k / 99, k / 77, 1) for k in range(50)], (0, 0, -1)), path=True)
    return abs(rays.jones[rays.designed][0, :, 0]) ** 2 / 2


def _possible_error():
    """Return the possible error of the default scene, px, and the alpha at which it is 3 px."""
    alpha = np.arange(10, 13, 0.5)
    errors = results(Chess(), "uncertainty", alpha=(66, *alpha))["uncertainty"] * px(1)
    return errors[0], np.interp(-3, -errors[1:], alpha)


# for a page: a sentence with places for numbers, and what povgen prints there
STATED = {
    "usage": ("0.4 tiles apart, z1 = 2 and z2 = 6, they differ by {}°", _parallax),
    "tutorial": ("The near knight turns by ν = {}° only", lambda: results(Chess(alpha=90, z1=2), "nu")["nu"]),
    "credits": (
        "Equation 7 gives ({}, {})",
        lambda: [(p := apparent_position(0.6, 0, 2, 6, math.pi / 2)).real, p.imag],
    ),
    "accuracy": ("In the default chess scene the sum is {} px; it is above 3 px for |α| < {}°", _possible_error),
    "light": ("parallel polarisers pass {} of the power, crossed ones {}.", _polarised),
    "sheets": ("at z2 = 60, {} % are designed and {} % stray", lambda: _shares(Chess(z2=60))),
    "examples": ("where the default prisms have {} % and {} %", lambda: _shares(Chess())),
    "rays": ("# () {}+0.00j, ('right',) {}+0.00j", lambda: [image.position.real for image in TWO.images((1.2, 0, 2))]),
    "tolerances": (
        "# cycles per degree: {}, {}, {}",
        lambda: mtf(Chess(prisms=1000, alpha=90, z1=10, z2=10, pupil=0.04), [2, 5, 10]),
    ),
}


@pytest.mark.parametrize("page", STATED)
def test_a_page_states_what_povgen_prints(page):
    words, computed = STATED[page]
    text = " ".join((PROJECT / "docs" / f"{page}.md").read_text().split())
    (stated,) = re.findall(re.escape(words).replace(r"\{\}", r"([\d.]+)"), text)
    stated = [stated] if isinstance(stated, str) else stated
    for number, value in zip(stated, computed(), strict=True):
        assert float(number) == pytest.approx(value, abs=0.6 * 10.0 ** -len(number.partition(".")[2]))


def test_the_room_of_the_page():
    """In TOML, in Python and in the picture it is the same."""
    page = PROJECT / "docs" / "rooms.md"
    shell, python = (next(block for kind, block in blocks(page) if kind == name) for name in ("bash", "python"))
    (text,) = re.findall(r"(?s)<<'END'\n(.*?)^END$", shell, re.M)
    spec = MovieSpec.parse(text, page.name)
    names = {}
    exec(python.partition("assert")[0], names)
    assert names["room"] == Room(**spec.fixed) == Room.from_file(PROJECT / "docs/rooms/room.png")
    assert {scene.with_numbers({"right.pitch": 20}) for scene in spec.scenes("draft")} == {names["room"]}


def test_the_gallery_is_made_from_its_files():
    """The scenes of the commands are those that the site shows."""
    assert gallery.PAGE.read_text("utf-8") == gallery.page(), "run make docs/gallery.md"
    assert {each["file"] for each in gallery.pictures().values()} == {
        path.name for path in (PROJECT / "docs" / "gallery").iterdir() if path.suffix in (".png", ".webp")
    }
    for name, each in gallery.pictures().items():
        assert name == Path(each["file"]).stem and re.match("`povgen [a-z]+", each["shows"].lstrip()), name


def test_the_reference_is_made_from_the_code():
    assert reference.PAGE.read_text("utf-8") == reference.page(), "run make docs/reference.md"


def test_records_name_no_folder_of_the_machine():
    files = [path for path in (PROJECT / "docs").rglob("*") if path.suffix in (".png", ".svg", ".csv", ".webp")]
    commands = {}
    for path in files:
        with suppress(InputError):  # others than povgen made it
            commands[path] = info(path).command or ""
    assert len(commands) > 40
    assert not [path for path, command in commands.items() if " /" in command]
