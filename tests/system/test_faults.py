"""Faults with the real POV-Ray: killed and stopped processes. No finished frame is lost."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import POVGEN, SPEC, some, wait_for

from povgen import MovieSpec, Rendering
from povgen.rendering import frames
from povgen.video import encode

COUNT = 8  # frames of SPEC
MOVIE = ["movie", "z2.toml", "--size", "64x48", "-o", "a.mp4"]
LARGE = ["--size", "640x480", "--antialias", "off"]
LARGE_RENDERING = Rendering(size=(640, 480), antialias="off")


@pytest.fixture
def place(tmp_path):
    """A folder with a spec, and a cache of its own."""
    (tmp_path / "z2.toml").write_text(SPEC)
    return tmp_path


def start(place, *more, command=(POVGEN,), arguments=MOVIE, handler=signal.SIG_DFL, **environment):
    return subprocess.Popen(
        [*command, *arguments, *more],
        cwd=place,
        env={**os.environ, "POVGEN_CACHE": str(place / "cache"), **environment},
        stderr=subprocess.PIPE,
        text=True,
        # what runs in the background, or under nohup, ignores them
        preexec_fn=lambda: [signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGHUP)],
    )


def finished(place):
    return {path: path.stat().st_mtime_ns for path in place.glob("cache/??/*.png")}


def processes(place):
    """Return the commands of the processes that run in the folder, by process number. Zombies do not count."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            dead = process.joinpath("stat").read_text().rpartition(")")[2].split()[0] == "Z"
            if Path(os.readlink(process / "cwd")).is_relative_to(place) and not dead:
                found[int(process.name)] = process.joinpath("cmdline").read_bytes()
        except OSError:
            continue
    return found


def test_povray_ends_with_povgen(place):
    """Also if povgen is killed. The frame would take minutes."""
    process = start(place, arguments=["frame", "chess", "--size", "4800x3600"], TMPDIR=str(place))
    wait_for(lambda: any(b"scene.pov" in command for command in processes(place).values()))
    process.kill()
    process.communicate()
    wait_for(lambda: not processes(place), 60)


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """A cache with large frames that are slow to encode: noise, from a replacement for POV-Ray."""

    class Noise:
        def run(self, source, rendering, folder):
            width, height = rendering.size
            colours = np.random.default_rng(1).integers(0, 256, (height, width, 3), np.uint8)
            (folder / rendering.file).write_bytes(encode.png(colours))
            return folder / rendering.file

        def stop(self):
            pass

    folder = tmp_path_factory.mktemp("rendered") / "cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(folder))
        list(frames.render_all(MovieSpec.parse(SPEC, "x").scenes("standard"), LARGE_RENDERING, 1, runner=Noise()))
    return folder


@pytest.mark.parametrize(
    "number, while_",
    some([(signal.SIGTERM, "rendering"), (signal.SIGINT, "encoding"), (signal.SIGHUP, "rendering")], 1, several=True),
)
def test_stopped(place, number, while_, request):
    (place / "tmp").mkdir()
    if while_ == "encoding":  # of frames that are there, slowly
        shutil.copytree(request.getfixturevalue("rendered"), place / "cache")
        process = start(place, *LARGE, "-o", "a.webm", TMPDIR=str(place / "tmp"))
        wait_for(lambda: any(b"ffmpeg" in command and b"webm" in command for command in processes(place).values()))
    else:
        process = start(place, "--workers", "1", TMPDIR=str(place / "tmp"))
        wait_for(lambda: len(finished(place)) >= 3)
    stop(process, number)
    wait_for(lambda: not processes(place))
    assert {path.name for path in place.rglob("*")} - {path.name for path in place.glob("cache/**/*")} == {
        *("cache", "tmp", "z2.toml")
    }
    assert not list(place.glob("cache/**/.povgen-*"))
    if number == signal.SIGTERM and while_ == "rendering":  # the next run renders only the missing frames
        kept = finished(place)
        assert start(place).wait() == 0 and 3 <= len(kept) < COUNT == len(finished(place))
        assert kept.items() <= finished(place).items()


def stop(process, number=signal.SIGINT, frames=True):
    """Stop povgen: it ends by itself, and prints one line, which speaks of frames if there may be some."""
    process.send_signal(number)
    message = process.communicate(timeout=200)[1]
    goes_on = "; the same command goes on from the frames that are finished" if frames else ""
    assert message.endswith(f"povgen: stopped{goes_on}\n"), message
    assert "Traceback" not in message and process.returncode == 128 + number


def catches(process, number=signal.SIGTERM):
    """Whether the process handles the signal yet."""
    (mask,) = re.findall(r"SigCgt:\s*(\w+)", Path(f"/proc/{process.pid}/status").read_text())
    return int(mask, 16) >> (number - 1) & 1


def test_stopped_whatever_its_threads_do(tmp_path):
    """The main thread waits for a lock; others start processes and write files, and one of them gets the signal."""
    program = """if True:
        import contextlib, signal, subprocess, threading
        from povgen import files, stopping
        stopping.on_signals()

        def work():
            with contextlib.suppress(OSError), files.temporary_folder() as folder:  # an error of the removed folder
                for number in range(100):
                    (folder / "part").write_bytes(b"")
                    with stopping.lock:
                        subprocess.Popen(["sleep", "600"])
                    if number == 20:
                        signal.pthread_kill(threading.get_ident(), signal.SIGTERM)

        threading.Thread(target=work, daemon=True).start()
        lock = threading.Lock()
        lock.acquire()
        lock.acquire()
    """
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=200
    )
    assert done.returncode == 128 + signal.SIGTERM and done.stderr == "povgen: stopped\n"
    assert not list(tmp_path.iterdir())
    wait_for(lambda: not processes(tmp_path))


def test_stopped_while_it_is_loaded(place):
    process = start(place)
    wait_for(lambda: catches(process))
    stop(process, frames=False)


def test_an_ignored_signal_is_ignored(place):
    """As under nohup, or for a command that a script starts with &."""
    process = start(place, arguments=["list"], handler=signal.SIG_IGN)
    wait_for(lambda: catches(process))
    process.send_signal(signal.SIGINT)
    assert process.wait(200) == 0
