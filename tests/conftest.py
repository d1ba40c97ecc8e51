import pytest


@pytest.fixture(autouse=True, scope="session")
def cache(tmp_path_factory):
    """Every run renders anew: no frame of an earlier version of the code is compared with."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield
