"""Two renders at once, in two threads or two processes, do not disturb each other."""

import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
import pytest
from PIL import Image

from povgen import Chess, InputError, PovrayError, Rendering, movie, render, save
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


def test_in_threads(expected, tmp_path):
    with ThreadPoolExecutor(len(SCENES)) as pool:
        pictures = pool.map(lambda scene: render(scene, **SMALL), SCENES)
        assert all((a == b).all() for a, b in zip(pictures, expected, strict=True))


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


def test_movies_in_threads(expected, tmp_path):
    """They have the same output. Each file is complete; the last one stays."""
    with ThreadPoolExecutor(2) as pool:
        ends = [pool.submit(movie, SCENES[n:], tmp_path / "a.gif", frame_rate=10, **SMALL) for n in (0, 1)]
        assert all(end.result().path == tmp_path / "a.gif" for end in ends)
    with Image.open(tmp_path / "a.gif") as image:
        assert sum(duration(image)) in (300, 400)
    assert not list(tmp_path.glob(".povgen-*"))


def duration(image):
    """Return the duration of each picture. Equal successive pictures are stored once."""
    for n in range(image.n_frames):
        image.seek(n)
        yield image.info["duration"]


def test_only_so_many_frames_wait_in_the_pool(monkeypatch):
    """Finished frames that wait for the first one do not count."""
    submitted = []

    class Pool:
        def submit(self, *_):
            submitted.append(Future())
            return submitted[-1]

    def wait(running, return_when):
        """The last one ends first."""
        unfinished = [frame for frame in submitted if not frame.done()]
        assert set(running) == set(unfinished)
        assert len(unfinished) == 2 or len(submitted) == len(SCENES) and len(unfinished) == 1
        unfinished[-1].set_result(b"")

    monkeypatch.setattr(frames, "wait", wait)
    found = [frame for _, frame in frames._finished(SCENES, Rendering(), povray.Runner(), Pool(), 2)]
    assert found == submitted and len(found) == len(SCENES)


def test_in_processes(expected, tmp_path):
    code = "from povgen import Chess, save; save(Chess(sheet='none', x={}), '{}.png', size=(48, 36), antialias='off')"
    processes = [
        subprocess.Popen([sys.executable, "-c", code.format(scene.x, n)], cwd=tmp_path)
        for n, scene in enumerate(SCENES)
    ]
    assert [process.wait(100) for process in processes] == [0] * len(SCENES)
    for n, picture in enumerate(expected):
        assert (np.asarray(Image.open(tmp_path / f"{n}.png")) == picture).all()
    assert (save(SCENES[0], tmp_path / "0.png", **SMALL)).is_file()
