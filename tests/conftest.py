"""Helpers of several test files, and fixtures that every test may use."""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import BytesIO, TextIOWrapper
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import settings

from povgen import InputError, MovieSpec, Spheres
from povgen.cli import app
from povgen.optics import paraxial
from povgen.optics.prism import Prism
from povgen.optics.trace import pair
from povgen.page.address import KINDS
from povgen.scene.presets import SCENES

PROJECT = Path(__file__).parents[1]
ALPHA_MOVIE = MovieSpec.parse(
    """
title = "Title with \\"quotes\\" and α"
scene = "chess"
frame_rate = 12.5
frames = 13
[fixed]
sheet = "ideal"
[[sweep]]
parameter = "alpha"
start = 0
stop = 180
""",
    "test",
)
# of a movie that renders fast
SPEC = """
title = "x"
scene = "chess"
frame_rate = 10
frames = 8
[fixed]
sheet = "none"
[[sweep]]
parameter = "z2"
start = 4
stop = 6
"""
POVGEN = Path(sys.executable).with_name("povgen")  # the program
NAMES = "void Object.assign(window, povgen, ...Object.values(povgen))"  # makes a page's modules and exports global

AXE = {
    "runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"],  # rules of a page
    "resultTypes": ["violations"],  # the list of all elements without a fault would take longer than the rules
}

# Each visible control has to be on top at its centre and a target of 24 px. Each text has to have 12 px,
# and to fit into its place if it is not cut off on purpose.
FAULTS = """() => {
  const faults = [];
  for (const control of document.querySelectorAll("button, input, select, summary")) {
    if (!control.checkVisibility() || control.disabled || control.matches(".on-focus:not(:focus)")) continue;
    control.scrollIntoView({ block: "nearest" });
    const name = control.id || control.value || control.outerHTML;
    const { x, y, width, height } = control.getBoundingClientRect();
    const top = document.elementFromPoint(x + width / 2, y + height / 2);
    const parts = [control, ...(control.labels ?? [])];
    if (!parts.some((part) => part.contains(top))) faults.push(`${name} is under ${top?.outerHTML.slice(0, 60)}`);
    const sides = parts.map((part) => part.getBoundingClientRect()).map((box) => Math.min(box.width, box.height));
    if (Math.max(...sides) < 23.9) faults.push(`${name} is ${Math.max(...sides)} px`);
  }
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let text; (text = texts.nextNode()); ) {
    const size = parseFloat(getComputedStyle(text.parentElement).fontSize);
    if (text.data.trim() && text.parentElement.checkVisibility() && size < 12) faults.push(`${size} px: ${text.data}`);
  }
  for (const part of document.querySelectorAll("body *:not(svg, svg *, input, select, option, .handle)")) {
    const { clientWidth, scrollWidth } = part;
    if (!part.checkVisibility() || !clientWidth || scrollWidth <= clientWidth + 1) continue;
    const tooWide = `${scrollWidth - clientWidth} px too wide: ${part.outerHTML.slice(0, 80)}`;
    if (getComputedStyle(part).overflowX === "visible") faults.push(tooWide);
  }
  const { scrollWidth } = document.documentElement;
  return scrollWidth > innerWidth ? [...faults, `${scrollWidth} px wide`] : faults;
}"""

# Each run has the same cases. They have no deadline, because a busy machine is no fault; pytest-timeout finds hangs.
settings.register_profile("povgen", deadline=None, derandomize=True, database=None)
settings.load_profile("povgen")


# files whose tests share what takes long to make: they run in one process
TOGETHER = "choice cluster figures javascript laws lesson live movies package records site tolerances".split()


@pytest.hookimpl(tryfirst=True)  # before pytest selects tests by their marks
def pytest_collection_modifyitems(items):
    """Mark tests by their files.

    A test of a browser or a cluster that fails is run once more: it depends on other programs. The end of the run names
    it as RERUN. The tests of the page share two browsers, because each takes long to start and to draw its first page.
    """
    for item in items:
        path = item.path.relative_to(PROJECT / "tests")
        folder, name = path.parent.name, path.stem.removeprefix("test_")
        if folder == "release":
            item.add_marker("release")
        if folder in ("demo", "fuzz") or name in TOGETHER:
            group = ("demo a-l", "demo m-z")[name >= "m"] if folder == "demo" else "fuzz" if folder == "fuzz" else name
            item.add_marker(pytest.mark.xdist_group(group))
        if folder == "demo" or name in ("live", "cluster", "firefox"):
            item.add_marker(pytest.mark.flaky(reruns=1))
            item.add_marker(pytest.mark.timeout(600))


def pytest_ignore_collect(collection_path, config):
    """Without the mark release, what only `make test-release` runs is not even imported."""
    name = collection_path.name
    return True if name in ("release", "test_site.py") and config.option.markexpr == "not release" else None


def pytest_terminal_summary(terminalreporter):
    """Say why tests were run once more."""
    for report in terminalreporter.stats.get("rerun", ()):
        terminalreporter.write_line(f"RERUN {report.nodeid}\n{report.longreprtext}")


@pytest.fixture(autouse=True, scope="session")
def cache(tmp_path_factory):
    """A cache for this run, which all its processes share. So no frame of an earlier version of the code is used."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(shared / "cache"))
        yield


def some(values, first, several=False):
    """Return parameters of a test, of which `make test` takes the first ones, and `make test-release` the others.

    If `several`, the test has several parameters, and each value is a tuple of them.
    """
    later = ((each if several else (each,)) for each in values[first:])
    return [*values[:first], *(pytest.param(*each, marks=pytest.mark.release) for each in later)]


def wait_for(condition, seconds=200):
    """Call the condition until its result is true, and return the result. Fail after some seconds."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, f"the condition is not true after {seconds} s"
        time.sleep(0.01)
    return found


def tree(folder):
    """Return the mode of everything in a folder, and the content of files and the targets of links."""
    return {
        path: (
            path.lstat().st_mode,
            os.readlink(path) if path.is_symlink() else path.read_bytes() if path.is_file() else None,
        )
        for path in folder.rglob("*")
    }


class Stream(TextIOWrapper):
    """A standard stream of the command line, which is a terminal or not."""

    terminal = False

    def isatty(self):
        return self.terminal


def povgen(arguments, folder, stdin=b""):
    """Run the command line in this process and in a folder. Return its exit status, its output and its errors."""
    out, err = (Stream(BytesIO(), "utf-8", errors=errors) for errors in ("strict", "backslashreplace"))
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    own = os.dup(0)
    with tempfile.TemporaryFile() as given:
        given.write(stdin)
        given.seek(0)
        os.dup2(given.fileno(), 0)
    try:
        with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
            patch.chdir(folder)
            patch.setattr(sys, "argv", ["povgen", *arguments])
            with pytest.raises(SystemExit) as done:
                app.main()
    finally:
        os.dup2(own, 0)
        os.close(own)
        for number, handler in handlers.items():
            signal.signal(number, handler)
    texts = []
    for stream in (out, err):
        stream.flush()
        texts.append(stream.buffer.getvalue().decode())
    return done.value.code or 0, *texts


def refusal(call, error=InputError):
    """Return the one line in which a call is refused."""
    with pytest.raises(error) as raised:
        call()
    assert "\n" not in str(raised.value)
    return str(raised.value)


def run_povgen(*arguments, cwd, status=0, **options):
    """Run the program in a folder. Check its exit status; return the completed process with its output as text."""
    done = subprocess.run([POVGEN, *arguments], cwd=cwd, capture_output=True, text=True, timeout=200, **options)
    assert done.returncode == status, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done


def refused(arguments, folder):
    """Check that the command line refuses the arguments in one or two lines and changes no file. Return its message."""
    before = sorted((path.name, path.read_bytes()) for path in folder.rglob("*") if path.is_file())
    status, out, err = povgen(arguments, folder)
    assert status == 2, err
    assert 1 <= len(err.strip().splitlines()) <= 2 and not out
    assert "Traceback" not in err
    assert sorted((path.name, path.read_bytes()) for path in folder.rglob("*") if path.is_file()) == before
    return err


def seen_through_other_sheets(rng, scenes=100, rays=20):
    """Yield scenes with random sheets that rotate about an axis or refract, and points that the eye sees through them.

    The points (n,) are where rays from the eye end. They come with the places P (n,) where these rays cross the sheet.
    """
    for k in range(scenes):
        z1, z2, ratio = np.exp(rng.uniform(np.log([0.3, 0.3, 0.1]), np.log([100, 30, 10])))
        eye, alpha = rng.choice([0, 1.5, 9]) * rng.uniform(-1, 1, 2), rng.choice([180, rng.uniform(-360, 360)])
        values = {"axis": rng.uniform(-1, 1, 3), "ratio": ratio, "eye": tuple(eye), "alpha": alpha}
        scene = Spheres(sheet=("axis", "refraction")[k % 2], z1=z1 + 0.3, z2=z2 + 0.1, **values)
        P = rng.uniform(-1.5, 1.5, (rays, 2)) @ [1, 1j]
        L = landing(scene, P)
        yield scene, L[np.isfinite(L)], P[np.isfinite(L)]


def landing(scene, P):
    """Return where rays from the eye through points P (n,) of another ideal sheet meet the first object's plane."""
    return P + scene.distances[0] * scene.sheets[0].slope((P - scene.E) / scene.z2, P)  # NaN: no light passes


def glass(z2, alpha, prism, behind=()):
    """Return windows of prisms as in `optics.apparent`: `behind` as in equations.depth, one shape or one for each."""
    turns, distances = [alpha, *(turn for _, turn in behind)], [z2, *(d for d, _ in behind)]
    shapes = [prism] * len(turns) if isinstance(prism, Prism) else prism
    pairs = [SimpleNamespace(transfer=paraxial.transfer(pair(turn, p))) for turn, p in zip(turns, shapes, strict=True)]
    return [*zip(distances, pairs, strict=True)]


def mirrored_position(L, E, z1, z2, prism):
    """Return where light from L to E crosses z = 0, the middle plane of a single sheet whose ridges lie along x.

    A line along z appears as a hyperbola.
    """
    D = np.subtract(L, E)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = D.real / (np.add(z2, z1) - prism.slab_shift) + 1j * np.divide(D.imag, np.subtract(z2, z1))
        return np.add(E, np.multiply(z2, slope))


@pytest.fixture
def rng():
    """A generator of the same random numbers for each test."""
    return np.random.default_rng(2009)


@contextmanager
def started_browser(script=""):
    """Start a Chromium whose pages wait long, and run a script first.

    One that draws without a GPU, on a busy machine, is no fault. Where EGL works, Mesa draws in less CPU time than
    SwiftShader, which Chromium takes otherwise.
    """
    from povgen.measure import browser

    others = [each for each in browser.ARGUMENTS if not each.startswith("--use-angle")]
    egl = "--use-angle=gl-egl --ignore-gpu-blocklist --disable-gpu-compositing".split()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("EGL_PLATFORM", "surfaceless")
        patch.setattr(browser, "ARGUMENTS", [*others, *egl])
        with browser.chromium() as started:
            new_page = started.new_page

            def waiting(**options):
                page = new_page(**options)
                page.set_default_timeout(120_000)  # ms
                page.add_init_script(script)
                return page

            started.new_page = waiting
            yield started


@pytest.fixture(scope="module")
def browser():
    """The Chromium of a module's tests."""
    with started_browser() as started:
        yield started


# ---- The page's scripts ----


# The modules of the page whose exports are global names in Node.
EXPORTED = "apparent equations text address state moment questions qr rays trace"
MODULES = [
    "liveview/geometry.js",
    "liveview/sheets.js",
    "liveview/presets.js",
    *(f"page/{name}.js" for name in EXPORTED.split()),
]


class Node:
    """Evaluates JavaScript as Playwright's pages do, with the exports of the page's modules, in Playwright's Node."""

    def __init__(self, data, script):
        import playwright

        program = Path(playwright.__file__).with_name("driver") / "node"
        self.process = subprocess.Popen(
            [program, Path(__file__).with_name("evaluate.mjs")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.send(data)
        self.send(script)

    @classmethod
    def of_page(cls, scenes=(), added=()):
        """Return one with the modules of the teaching page, which also know the laws of scenes, and added files."""
        from povgen.inputs.pieces import PIECES
        from povgen.liveview import scripts
        from povgen.page import page
        from povgen.scene.laws import to_live

        data = page.data({name: name for name in PIECES}, added=added)
        return cls(data, scripts.script(*MODULES, laws=to_live(scenes)))

    def send(self, data):
        self.process.stdin.write(json.dumps(data) + "\n")
        self.process.stdin.flush()

    def evaluate(self, script, argument=None):
        """Return an expression's value, or what a function returns for the argument."""
        self.send({"script": script, "argument": re.sub(r"\bNone\b", "null", json.dumps(argument))})
        text = self.process.stdout.readline()
        return json.loads(re.sub(r'"number (-?\w+)"', r"\1", text)).get("found")

    def close(self):
        self.process.stdin.close()
        assert self.process.wait(10) == 0


@pytest.fixture(scope="module")
def node():
    started = Node.of_page()
    yield started
    started.close()


# ---- The teaching page ----


def sentence(page, **values):
    """Change the page's state, and return what the page will say of it. It draws nothing, which costs less."""
    return page.evaluate("(values) => { change(values); return explanation(moment()); }", values)


def scene_of(page):
    """Return the scene that the page shows, as one of povgen's."""
    values = page.evaluate("moment().scene")
    scene = SCENES[values["name"]]
    return scene(**{name: values[name] for name in scene.model_fields.keys() & values.keys() - {"color"}})


BEYOND = [
    *({"sheet": name, "E": [0.4, -0.3], **values} for name, kind in KINDS.items() for values in kind.examples),
    {"scene": "spheres", "sheet": "mirror", "alpha": -10, "z1": 12},
    {"windows": 2, "sheet": "ideal", "alpha": 50, "alpha2": 75, "d": 1.5, "E": [0.4, -0.3]},
    {"windows": 2, "sheet": "detailed", "alpha": 50, "alpha2": -120, "d": 0.01, "prisms": 30},
    {"windows": 2, "sheet": "none", "alpha": 50, "alpha2": 75, "d": 3},
]


def picture(folder, size=(64, 32)):
    """Make a picture whose red grows from left to right, and whose green grows downwards. Return its path."""
    from PIL import Image

    columns, rows = size
    red, green = np.linspace(0, 255, columns), np.linspace(0, 255, rows)
    colours = np.stack([*np.meshgrid(red, green), np.full((rows, columns), 90)], -1)
    Image.fromarray(np.uint8(colours)).save(folder / "picture.png")
    return str(folder / "picture.png")
