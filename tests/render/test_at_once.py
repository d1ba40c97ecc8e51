"""Two renders at once, in two threads or two processes, do not disturb each other."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from povgen import Chess, InputError, PovrayError, Rendering, render
from povgen.errors import TransientError
from povgen.rendering import frames, povray

SMALL = {"size": (48, 36), "antialias": "off"}
SCENES = [Chess(sheet="none", x=x) for x in (0, 0, 0.5, 1)]  # the first two have the same file in the cache


@pytest.fixture
def expected(tmp_path, monkeypatch):
    """The pictures of the scenes, one after the other. The cache is empty again when the test starts."""
    with monkeypatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(tmp_path / "before"))
        pictures = [render(scene, **SMALL) for scene in SCENES]
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    assert (pictures[0] != pictures[2]).any()
    return pictures


def test_a_failure_in_one_thread(expected, tmp_path, monkeypatch):
    """A render that fails, and one that is refused, end no other thread's POV-Ray."""
    command = povray.command
    monkeypatch.setattr(
        povray,
        "command",
        lambda *given: [*command(*given), *["+Iother.pov"] * (given[1].timeout == 9)],
    )
    with ThreadPoolExecutor(8) as pool:
        right = [pool.submit(render, scene, **SMALL) for scene in SCENES]
        wrong = [pool.submit(render, SCENES[2], **SMALL, timeout=9) for _ in range(2)]
        refused = pool.submit(render, SCENES[0], size=(1, 1))
        assert all((a.result() == b).all() for a, b in zip(right, expected, strict=True))
        for future in wrong:
            with pytest.raises(PovrayError):
                future.result()
        with pytest.raises(InputError):
            refused.result()


def test_scenes_with_and_without_prisms_fail_on_their_own(monkeypatch, tmp_path):
    """POV-Ray is killed for the scene with prisms. The others are still rendered."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path))
    monkeypatch.setattr(povray.Runner, "run", failing(povray.Runner.run))
    scenes = [SCENES[0], Chess(x=0.3), SCENES[2]]
    with pytest.raises(TransientError, match="killed"):
        render(scenes, **SMALL)
    assert frames.missing(scenes, Rendering(**SMALL)) == 1


def failing(run):
    def run_or_fail(runner, source, *given):
        if "Prism" in source:
            raise TransientError("killed")
        return run(runner, source, *given)

    return run_or_fail
