import os
import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from io import BytesIO, TextIOWrapper
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from povgen.cli import app

PROJECT = Path(__file__).parents[1]

# The same cases at each run. A machine that is busy makes no case wrong: hangs are found by pytest-timeout.
settings.register_profile("povgen", deadline=None, derandomize=True, database=None)
settings.load_profile("povgen")


@pytest.fixture(autouse=True, scope="session")
def cache(tmp_path_factory):
    """Every run renders anew, each frame once: no frame of an earlier version of the code is compared with."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(shared / "cache"))
        yield


def wait_for(condition, seconds=60):
    """Return what the condition gives, as soon as that is true; fail where it never is."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)
    return found


def tree(folder):
    """All that is in a folder: what it is, its mode, and what it holds or leads to."""
    return {
        path: (
            path.lstat().st_mode,
            os.readlink(path) if path.is_symlink() else path.read_bytes() if path.is_file() else None,
        )
        for path in folder.rglob("*")
    }


def povgen(arguments, folder):
    """Run the command line in a folder: exit status, output, errors."""
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


def refused(arguments, folder):
    before = sorted((path.name, path.read_bytes()) for path in folder.rglob("*") if path.is_file())
    status, out, err = povgen(arguments, folder)
    assert status == 2, err
    assert 1 <= len(err.strip().splitlines()) <= 2 and not out
    assert "Traceback" not in err
    assert sorted((path.name, path.read_bytes()) for path in folder.rglob("*") if path.is_file()) == before
    return err


@pytest.fixture
def rng():
    """The same numbers in each test, whatever ran before it."""
    return np.random.default_rng(2009)
