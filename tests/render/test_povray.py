"""The runner, with real POV-Ray: its command line, the frames in the cache, and the message for each failure."""

import os
import stat
import threading
from pathlib import Path

import numpy as np
import pytest
from conftest import wait_for

from povgen import Chess, PovrayError, Rendering, to_pov
from povgen.rendering import cache, frames, povray
from povgen.settings import of_movie
from povgen.video import still

TINY = Rendering(size=(32, 32), antialias="off")
EMPTY = Chess(sheet="none")


def test_command():
    assert povray.command("povray", Rendering(size="640x480", antialias="2,0.1,3")) == [
        *("povray", "+Iscene.pov", "+Oframe.png", "+FN8", "+W640", "+H480", "+AM2", "+A0.1", "+R3", "-J"),
        *("+WT1", "+MI8192", "-D", "-P", "-V", "-GD", "-GF", "-GR", "-GS", "+GFfatal.log"),
    ]
    assert "-A" in povray.command("povray", TINY)


@pytest.mark.release
def test_a_picture_larger_than_povray_keeps_in_memory_by_itself(tmp_path):
    """POV-Ray would swap a picture above 128 MB to a file outside the sandbox."""
    large = Rendering(size=(3200, 2400), antialias="off")
    assert frames.read_png(povray.run("camera { location 0 }", large, tmp_path)).shape == (2400, 3200, 3)


def test_progress_never_goes_back():
    """POV-Ray's threads can report out of order."""
    reader, writer = os.pipe()
    said = [f"\rRendered {number} of 100 pixels ({number}%)".encode() for number in (40, 30, 100)]
    found = []

    def part(share):
        found.append(share)
        if said:
            os.write(writer, said.pop(0))
        else:
            os.close(writer)

    os.write(writer, said.pop(0))
    povray._read_last(os.fdopen(reader, "rb"), bytearray(), part)
    assert found == pytest.approx([0.4, 0, 0.6])


def test_qualities():
    names = ("draft", "standard", "high", "hd")
    assert [Rendering(quality=q).size for q in names] == [(320, 240), (960, 720), (960, 720), (1920, 1080)]
    assert [Rendering(quality=q).sampling for q in names] == ["1.5x", "1.5x", "2x", "2x"]
    assert [Rendering(quality=q).suited(prisms=False).sampling for q in names] == ["1,0.1,2"] * 2 + ["1,0.1,3"] * 2
    # a standard movie, with its many frames, has smaller ones than a picture
    sizes = [of_movie({"quality": q, "bits": 8})["size"] for q in names]
    assert sizes == [(320, 240), (424, 318), (960, 720), (1920, 1080)]
    assert of_movie({"size": (64, 48)}) == {"size": (64, 48)} and of_movie({}) == {"size": (424, 318)}
    assert Rendering(antialias="2x").suited(prisms=False).sampling == "2x"
    assert Rendering(quality="draft", size="64x48").size == (64, 48)


def test_a_frame_is_rendered_once(monkeypatch):
    first, kept = still.as_file(EMPTY, TINY), cache.frame_path(to_pov(EMPTY), TINY)
    written = kept.stat().st_mtime_ns
    monkeypatch.setattr(povray.Runner, "run", lambda *_: pytest.fail("rendered again"))
    # no sheet, no alpha: the same text
    again = still.as_file(EMPTY.model_copy(update={"alpha": 5.0}), TINY)
    assert all(np.array_equal(frames.read_png(again), frames.read_png(png)) for png in (first, kept))
    assert kept.stat().st_mtime_ns == written
    with pytest.raises(BaseException, match="rendered again"):
        still.as_file(EMPTY, Rendering(size=(34, 32), antialias="off"))


def test_a_fault_in_the_scene(monkeypatch):
    def broken(scene, found=None):
        return to_pov(scene, sheet_macro="#macro Sheet(Angle, Centre) shpere { 0, 1 } #end")

    monkeypatch.setattr(frames, "to_pov", broken)
    scene = Chess(sheet="single", piece="pawn", z1=3.25)
    with pytest.raises(PovrayError) as failure:
        still.as_file(scene, TINY)
    message = str(failure.value)
    line = next(n for n, text in enumerate(broken(scene).splitlines(), 1) if "shpere" in text)
    assert f"scene.pov, line {line}: " in message and "\n  from sheets.pov.j2, in the frame with " in message
    assert "shpere" in message and "z1 = 3.25" in message and "piece = 'pawn'" in message


@pytest.fixture
def forgotten():
    """Forget which POV-Ray this process has found, before and after the test."""
    for known in (povray.binary, povray.version):
        known.cache_clear()
    yield
    for known in (povray.binary, povray.version):
        known.cache_clear()


def test_no_binary(monkeypatch, tmp_path, forgotten):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(PovrayError, match="apt-get install povray"):
        povray.version()


def test_an_older_version(monkeypatch, tmp_path, forgotten):
    (tmp_path / "povray").write_text("#!/bin/sh\necho POV-Ray 3.6.1\n")
    (tmp_path / "povray").chmod(stat.S_IRWXU)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(PovrayError, match="3.6.1 is too old"):
        povray.version()


@pytest.mark.parametrize("kills", [1, 2])
def test_killed(kills, tmp_path):
    """After the first kill POV-Ray is started again. After the last one the error says so."""

    runner = povray.Runner()

    def kill():
        met = set()
        for _ in range(kills):
            (process,) = wait_for(lambda: runner._running - met)
            process.kill()
            met.add(process)

    killer = threading.Thread(target=kill)
    killer.start()
    if kills == 1:
        assert frames.read_png(runner.run(to_pov(Chess()), Rendering(quality="draft"), tmp_path)).shape == (240, 320, 3)
    else:
        with pytest.raises(PovrayError, match="killed by signal 9, 2 times"):
            runner.run(to_pov(Chess()), Rendering(quality="high"), tmp_path)
    killer.join()


def test_what_povgen_stops_is_not_tried_again(tmp_path):
    """The runner then starts no other POV-Ray either."""
    runner = povray.Runner()

    def stop():
        wait_for(lambda: runner._running)
        runner.stop()

    stopper = threading.Thread(target=stop)
    stopper.start()
    with pytest.raises(PovrayError, match="was stopped"):
        runner.run(to_pov(Chess()), Rendering(quality="high"), tmp_path)
    stopper.join()
    assert len(list(tmp_path.iterdir())) == 1
    (tmp_path / "later").mkdir()
    with pytest.raises(PovrayError, match="was stopped"):
        runner.run(to_pov(EMPTY), TINY, tmp_path / "later")
    assert not (tmp_path / "later" / "1" / TINY.file).stat().st_size


def test_a_machine_so_busy_that_povray_does_not_start(monkeypatch, tmp_path):
    """POV-Ray 3.7 fails with this message then. It is started again, because the scene is not at fault."""
    fake = 'case $PWD in */1) echo "$0" >&2; exit 1 ;; *) cp scene.pov frame.png ;; esac'
    message = "Timed out waiting for worker thread startup"
    monkeypatch.setattr(povray, "command", lambda *_: ["/bin/sh", "-c", fake, message])
    monkeypatch.setattr(povray, "libraries", lambda *_: [*povray.RUN, Path("/usr/bin"), Path("/bin")])
    assert povray.run("scene", TINY, tmp_path).read_text() == "scene"


def test_a_frame_that_fails_stops_a_movie_and_leaves_nothing(monkeypatch, tmp_path):
    from povgen import MovieSpec, movie

    spec = MovieSpec.load("vary-alpha").replace(fixed={"sheet": "none"}, ease=False, frames=4)
    good = frames.to_pov
    monkeypatch.setattr(
        frames, "to_pov", lambda scene, found=None: good(scene) + ("shpere {}" if scene.alpha > 90 else "")
    )
    output = tmp_path / "movie.mp4"
    output.write_bytes(b"kept")
    with pytest.raises(PovrayError, match="alpha = 120"):
        movie(spec, output, size=(32, 32))
    assert output.read_bytes() == b"kept" and os.listdir(tmp_path) == ["movie.mp4"]
