import os

import numpy as np
import pytest


@pytest.fixture(autouse=True, scope="session")
def cache(tmp_path_factory):
    """Every run renders anew, each frame once: no frame of an earlier version of the code is compared with."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(shared / "cache"))
        yield


@pytest.fixture
def rng():
    """The same numbers in each test, whatever ran before it."""
    return np.random.default_rng(2009)
