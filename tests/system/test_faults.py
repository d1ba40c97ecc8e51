"""Faults with the real POV-Ray: killed and hung processes, full disks, damaged files. No finished frame is lost."""

import os
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from conftest import POVGEN, wait_for

from povgen import MovieSpec, PovrayError, Rendering, movie, stopping, to_pov
from povgen.rendering import cache, frames, povray
from povgen.video import encode, still

COUNT = 8
SPEC = (
    f'title = "x"\nscene = "chess"\nframe_rate = 10\nframes = {COUNT}\n[fixed]\nsheet = "none"\n'
    '[[sweep]]\nparameter = "z2"\nstart = 4\nstop = 6\n'
)
# whether this user may mount file systems; in many containers no user may
CAN_MOUNT = not subprocess.run(["unshare", "--mount", "--map-root-user", "true"], capture_output=True).returncode
SMALL = Rendering(size=(64, 48)).suited(prisms=False)
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


@pytest.mark.release
def test_killed_at_any_moment(place):
    """While it is loaded, and after each second frame: at a random moment of rendering, storing or making folders."""
    moments = random.Random(20)
    (place / "tmp").mkdir()
    for count in (None, None, *range(0, COUNT, 2)):
        before = finished(place)
        process = start(place, "--workers", "2", TMPDIR=str(place / "tmp"))
        if count is not None:
            wait_for(lambda count=count: len(finished(place)) >= count and any(place.glob("tmp/povgen-*")))
        time.sleep(moments.uniform(0, 0.5))
        process.kill()
        process.communicate()
        wait_for(lambda: not processes(place))  # POV-Ray ends with povgen
        assert before.items() <= finished(place).items()  # nothing was rendered again
    left = finished(place)
    assert start(place).wait() == 0
    assert left.items() <= finished(place).items() and len(finished(place)) == COUNT
    assert {path.name for path in place.iterdir()} == {"a.mp4", "cache", "tmp", "z2.toml"}

    undisturbed = MovieSpec.parse(SPEC, "x").scenes("standard")
    for scene in undisturbed:
        killed = cache.read(place / "cache" / cache.frame_path(to_pov(scene), SMALL).relative_to(cache.folder()))
        assert np.array_equal(still.render(scene, size=(64, 48)), frames.read_png(killed))


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


def test_ctrl_c_before_povgen_handles_signals_ends_it_without_a_word():
    code = (
        "import os, signal, sys\n"
        "class Stop:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'povgen.stopping': os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Stop())\n"
        "from povgen.__main__ import main\n"
        "main()"
    )
    stopped = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert (stopped.returncode, stopped.stdout + stopped.stderr) == (-signal.SIGINT, b"")


@pytest.mark.parametrize(
    "number, while_",
    [
        (signal.SIGTERM, "rendering"),
        (signal.SIGINT, "encoding"),
        *(pytest.param(number, "rendering", marks=pytest.mark.release) for number in (signal.SIGHUP, signal.SIGINT)),
        *(pytest.param(number, "encoding", marks=pytest.mark.release) for number in (signal.SIGHUP, signal.SIGTERM)),
    ],
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


def stop(process, number=signal.SIGINT):
    """Stop povgen: it ends by itself, and prints one line."""
    process.send_signal(number)
    message = process.communicate(timeout=200)[1]
    assert message.endswith("povgen: stopped; the same command goes on from the frames that are finished\n"), message
    assert "Traceback" not in message and process.returncode == 128 + number


def catches(process, number=signal.SIGTERM):
    """Whether the process handles the signal yet."""
    (mask,) = re.findall(r"SigCgt:\s*(\w+)", Path(f"/proc/{process.pid}/status").read_text())
    return int(mask, 16) >> (number - 1) & 1


@pytest.mark.parametrize(
    "moment", [0.1, *(pytest.param(moment, marks=pytest.mark.release) for moment in (0, 0.02, 0.05, 0.15, 0.2, 0.3))]
)
def test_stopped_while_it_is_loaded(moment, place):
    process = start(place, command=[sys.executable, "-m", "povgen"] if moment == 0.1 else [POVGEN])
    wait_for(lambda: catches(process))
    time.sleep(moment)
    stop(process)


@pytest.mark.release
@pytest.mark.parametrize(
    "arguments", [["movie", "vary-alpha", "--sheet", "ideal", "--quality", "high", "--quiet"], ["verify"]]
)
def test_stopped_with_much_under_way(arguments, place):
    """All POV-Rays run, and Python prepares more frames."""
    for moment in (0, 0.7):
        process = start(place, arguments=arguments, TMPDIR=str(place))
        wait_for(lambda: any(b"povray" in command for command in processes(place).values()))
        time.sleep(moment)
        stop(process)
        wait_for(lambda: not processes(place))
        assert not [path for path in place.rglob("*") if "povgen-" in path.name]


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
    assert done.returncode == 128 + signal.SIGTERM and done.stderr == stopping.MESSAGE.decode()
    assert not list(tmp_path.iterdir())
    wait_for(lambda: not processes(tmp_path))


def test_an_ignored_signal_is_ignored(place):
    """As under nohup, or for a command that a script starts with &."""
    process = start(place, arguments=["list"], handler=signal.SIG_IGN)
    wait_for(lambda: catches(process))
    process.send_signal(signal.SIGINT)
    assert process.wait(200) == 0


@pytest.mark.parametrize(
    "fault, said",
    [
        (signal.SIGKILL, "killed by signal 9"),
        pytest.param(signal.SIGSTOP, "longer than 5 s", marks=pytest.mark.release),
    ],
)
def test_a_frame_that_fails_leaves_the_others(place, fault, said, monkeypatch):
    """One frame's POV-Ray is killed, or hangs, at each try."""
    monkeypatch.setenv("POVGEN_CACHE", str(place / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    scenes = MovieSpec.parse(SPEC, "x").scenes("standard")
    doomed = f"#declare Z2         = {scenes[4].z2:.15g};"
    over, met = threading.Event(), set()

    def strike():
        while not over.wait(0.02):
            for process in processes(place):
                try:
                    if process not in met and doomed in Path(f"/proc/{process}/cwd/scene.pov").read_text():
                        os.kill(process, fault)
                        met.add(process)
                except OSError:
                    continue

    striker = threading.Thread(target=strike)
    striker.start()
    output = place / "a.mp4"
    output.write_bytes(b"kept")
    try:
        with pytest.raises(PovrayError) as failure:
            movie(place / "z2.toml", output, size=(64, 48), timeout=5)
    finally:
        over.set()
        striker.join()
    message = str(failure.value)
    assert len(met) == povray.TRIES and f"{said}" in message and f"{povray.TRIES} times" in message
    assert f"1 of {COUNT} frames failed" in message and "The other frames are kept." in message
    assert "frame 4" not in message and f"z2 = {scenes[4].z2}" in message
    assert len(finished(place)) == COUNT - 1
    assert output.read_bytes() == b"kept" and not processes(place)


def crowded(place, limit, script):
    """Run a shell script. `small` is a file system with a limit, such as size=40k, and `grow` makes it larger."""
    (place / "small").mkdir()
    mount = f'mount -t tmpfs -o {limit} tmpfs small; grow() {{ mount -o remount,size=100m "$PWD/small"; }}; '
    whole = ["unshare", "--mount", "--map-root-user", "sh", "-c", f'{mount} povgen() {{ {POVGEN} "$@"; }}; {script}']
    return subprocess.run(whole, cwd=place, capture_output=True, text=True, timeout=200, env=os.environ)


@pytest.mark.skipif(not CAN_MOUNT, reason="this user may not mount file systems")
@pytest.mark.parametrize(
    "what", ["encoding", *(pytest.param(what, marks=pytest.mark.release) for what in ("rendering", "encoding a GIF"))]
)
def test_no_room(place, what):
    kind = "gif" if "GIF" in what else "mp4"
    store, output = ("small/cache", f"a.{kind}") if what == "rendering" else ("cache", f"small/a.{kind}")
    command = f"povgen movie z2.toml --size 320x240 --antialias off --quiet -o {output}"
    environment = f"export POVGEN_CACHE={shlex.quote(str(place / store))}"
    done = crowded(
        place,
        "size=200k" if what == "rendering" else "size=40k",
        f"{environment}; echo kept > {output}; {command}; echo status $?; "
        f'echo "is: $(head -c 4 {output})"; '
        f"grow; {command}; echo status $?; cp {output} whole.{kind}; ls -A small; ls {store}/..",
    )
    first, _, second = done.stdout.partition("status 1\n")
    assert first == "" and second.startswith("is: kept") and "status 0" in second, done.stdout + done.stderr
    message = done.stderr.splitlines()
    assert message[0].startswith("povgen: ") and len(message) <= 3, done.stderr
    assert "No space left" in done.stderr or "disk full" in done.stderr
    if kind == "mp4":
        assert imageio_ffmpeg.count_frames_and_secs(str(place / "whole.mp4"))[0] == COUNT
    # what was kept when there was no room was whole: it is there still, as it was
    assert "Traceback" not in done.stderr and ".povgen-" not in second


@pytest.mark.skipif(not CAN_MOUNT, reason="this user may not mount file systems")
@pytest.mark.parametrize("limit", ["size=32k", pytest.param("size=9m,nr_inodes=9", marks=pytest.mark.release)])
def test_check_with_too_little_room_for_temporary_files(place, limit):
    done = crowded(place, limit, "TMPDIR=$PWD/small; export TMPDIR; povgen check; ls -A small")
    assert done.stdout.count("FAULT") == done.stdout.count("remedy: ") == 1, done.stdout
    assert f"FAULT  temporary files: {place}/small" in done.stdout and "TMPDIR" in done.stdout
    assert ("no inodes left" in done.stdout) == ("inodes" in limit)
    assert done.stdout.endswith("encoder: not tested, because it needs: temporary files\n")  # nothing is left there


@pytest.mark.release
def test_two_at_once(place, monkeypatch):
    """Two movies with the same cache and output, while another process clears the cache again and again."""
    both = [start(place) for _ in range(2)]
    monkeypatch.setenv("POVGEN_CACHE", str(place / "cache"))
    while any(process.poll() is None for process in both):
        cache.trim(-1)
        time.sleep(0.1)
    for process in both:
        assert process.wait() == 0, process.stderr.read()
    assert imageio_ffmpeg.count_frames_and_secs(str(place / "a.mp4"))[0] == COUNT
    assert not list(place.rglob(".povgen-*"))
