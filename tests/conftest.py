"""Helpers of several test files, and fixtures that every test may use."""

import json
import os
import re
import subprocess
import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from io import BytesIO, TextIOWrapper
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from povgen import MovieSpec, Spheres
from povgen.cli import app
from povgen.liveview.page import KINDS
from povgen.scene.models import SCENES

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
POVGEN = Path(sys.executable).with_name("povgen")  # the program
WORK = {"width": 1000, "height": 640}  # a small canvas costs less
NAMES = "void Object.assign(window, povgen, ...Object.values(povgen))"  # makes a page's modules and exports global
COARSE, SHARP = (f"window.devicePixelRatio = {ratio}; view.resize()" for ratio in (0.2, 1))

# Each run has the same cases. They have no deadline, because a busy machine is no fault; pytest-timeout finds hangs.
settings.register_profile("povgen", deadline=None, derandomize=True, database=None)
settings.load_profile("povgen")


@pytest.fixture(autouse=True, scope="session")
def cache(tmp_path_factory):
    """A cache for this run, which all its processes share. So no frame of an earlier version of the code is used."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(shared / "cache"))
        yield


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


def povgen(arguments, folder):
    """Run the command line in this process and in a folder. Return its exit status, its output and its errors."""
    out, err = (TextIOWrapper(BytesIO(), "utf-8", errors="backslashreplace") for _ in range(2))
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.chdir(folder)
        patch.setattr(sys, "argv", ["povgen", *arguments])
        with pytest.raises(SystemExit) as done:
            app.main()
    texts = []
    for stream in (out, err):
        stream.flush()
        texts.append(stream.buffer.getvalue().decode())
    return done.value.code or 0, *texts


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


@pytest.fixture(scope="module")
def browser():
    """A Chromium that draws without a GPU."""
    from povgen.measure.browser import chromium

    with chromium() as started:
        yield started


# ---- The page's scripts ----


# The modules of the page whose exports are global names in Node.
EXPORTED = ("aim", "equations", "numbers", "text", "address", "state", "moment", "contents", "questions", "beyond")


MODULES = [f"{path}.js" for path in ("live/geometry", "live/sheets", *(f"demo/{name}" for name in EXPORTED))]


class Node:
    """Evaluates JavaScript as Playwright's pages do, with the exports of the page's modules, in Playwright's Node."""

    def __init__(self, data, script):
        import playwright

        program = Path(playwright.__file__).with_name("driver") / "node"
        self.process = subprocess.Popen(
            [program, Path(__file__).parent / "unit" / "evaluate.mjs"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.send(data)
        self.send(script)

    @classmethod
    def of_page(cls, scenes=()):
        """Return one with the modules of the teaching page, which also know the laws of scenes."""
        from povgen.liveview import page, scripts
        from povgen.scene.laws import to_live
        from povgen.scene.pieces import PIECES

        return cls(page.data({name: name for name in PIECES}), scripts.script(*MODULES, laws=to_live(scenes)))

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


@pytest.fixture(scope="module")
def demo_file(tmp_path_factory):
    """The teaching page, in a folder whose name has to be quoted in a URL."""
    from povgen.liveview.page import demo

    return demo(tmp_path_factory.mktemp("demo") / "a démo #1.html", progress=False)


class Faults(list):
    """What the console says, and the requests for anything but the page's own files."""

    def watch(self, page, folder):
        page.set_default_timeout(60_000)
        page.on("console", lambda message: self.append(message.text))
        page.on("pageerror", lambda error: self.append(str(error)))
        page.on("request", lambda request: request.url.startswith((folder, "data:")) or self.append(request.url))
        return self


def opened(browser, file, hash_="", **options):
    """Open the teaching page, with few rays: those of a coarse display."""
    page = browser.new_page(viewport=WORK, **options)
    faults = Faults().watch(page, file.parent.as_uri())
    page.goto(file.as_uri() + hash_)
    page.evaluate(NAMES)
    page.evaluate("PACE.RAYS = 1; view.ready")
    page.evaluate(COARSE)
    return page, faults


@pytest.fixture(scope="module")
def shared_page(browser, demo_file):
    page, faults = opened(browser, demo_file)
    assert page.evaluate("Boolean(view.gl)"), "no WebGL 2"
    page.evaluate("view.ready.then(draw)")
    yield page, faults
    page.close()


@pytest.fixture
def page(shared_page):
    """The teaching page, as it is when it has just been opened. The test fails if the page has an error."""
    page, faults = shared_page
    page.evaluate(COARSE)
    page.set_viewport_size(WORK)
    page.emulate_media(reduced_motion="no-preference", forced_colors="none")
    page.evaluate(
        """() => {
          player.pause();
          endGlide();  // of an earlier test, on a busy machine
          player.preset = data.presets[0];
          state.question = -1;
          session.lastQuestion = 0;
          fromHash("");
          $("loop").checked = false;
          $("shortcuts").checked = true;
          document.activeElement.blur();
          scrollTo(0, 0);
          draw();
        }"""
    )
    yield page
    assert not faults
    faults.clear()


def show(page, **values):
    """Change the page's state and draw it."""
    page.evaluate("(values) => { change(values); draw(); }", values)


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
