"""Helpers of several test files, and fixtures that every test may use."""

import os
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
    x, y, z = scene.bend(np.stack(((P - scene.E).real, (P - scene.E).imag, np.full(len(P), scene.z2)), -1)).T
    with np.errstate(invalid="ignore"):  # NaN: no light passes
        return P + scene.distances[0] * (x + 1j * y) / z


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
