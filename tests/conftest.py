import os
import time

import numpy as np
import pytest
from hypothesis import settings

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


@pytest.fixture
def rng():
    """The same numbers in each test, whatever ran before it."""
    return np.random.default_rng(2009)
