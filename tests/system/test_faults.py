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
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from conftest import POVGEN, povgen, refused, tree, wait_for

from povgen import MovieSpec, PovrayError, Rendering, files, movie, stopping, to_pov
from povgen.rendering import cache, frames, povray
from povgen.video import encode, still

COUNT = 12
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


def test_killed_at_any_moment(place):
    """While it is loaded, and after each second frame: at a random moment of rendering, storing or making folders."""
    moments = random.Random(20)
    for count in (None, None, *range(0, COUNT, 2)):
        before = finished(place)
        process = start(place, "--workers", "2")
        if count is not None:
            wait_for(lambda count=count: len(finished(place)) >= count and any(place.glob("cache/.povgen-*")))
        time.sleep(moments.uniform(0, 0.5))
        process.kill()
        process.communicate()
        wait_for(lambda: not processes(place))  # POV-Ray ends with povgen
        assert before.items() <= finished(place).items()  # nothing was rendered again
    left = finished(place)
    assert start(place).wait() == 0
    assert left.items() <= finished(place).items() and len(finished(place)) == COUNT
    assert {path.name for path in place.iterdir()} == {"a.mp4", "cache", "z2.toml"}
    assert not list(place.glob("cache/.povgen-*")), "folders of the killed are left"

    undisturbed = MovieSpec.parse(SPEC, "x").scenes("standard")
    for scene in undisturbed:
        (killed,) = (path for path in finished(place) if path.name == cache.frame_path(to_pov(scene), SMALL).name)
        assert np.array_equal(still.render(scene, size=(64, 48)), frames.read_png(killed))


def test_folders_of_the_killed_are_removed(tmp_path):
    """Leftovers of each stage: povgen was killed before or after it marked the folder, or while it removed it."""
    for number, content in enumerate([{}, {"lock": b""}, {"lock": files.MARK}, {"lock": files.MARK, "a.pov": b"a"}]):
        left = tmp_path / f"{files.WORK_PREFIX}left000{number}"
        left.mkdir(mode=0o700)
        for name, data in content.items():
            (left / name).write_bytes(data)
    with files.work_folder(tmp_path) as first, files.work_folder(tmp_path) as second:
        assert sorted(tmp_path.iterdir()) == sorted([first, second])
        assert not files.leftover_sizes(tmp_path)
    assert not list(tmp_path.iterdir())


def test_what_is_not_povgens_stays(tmp_path):
    """Folders, links and FIFOs with names like work folders: none is removed or written to, and none blocks."""
    other, place = tmp_path / "other", tmp_path / "place"
    for folder in (place / ".povgen-notes", place / ".povgen-abcdefg1", place / ".povgen-abcdefg2", other):
        folder.mkdir(parents=True)
        (folder / "t").write_text("x")
    (place / ".povgen-abcdefg2" / "lock").touch(mode=0o600)  # and more than that
    (place / ".povgen-abcdefg2").chmod(0o700)
    for name, lock in (("abcdefg3", b"my own lock"), ("abcdefg4", files.MARK + b" and more")):
        (place / f".povgen-{name}").mkdir(mode=0o700)
        (place / f".povgen-{name}" / "lock").write_bytes(lock)
    (place / ".povgen-abcdefg5").mkdir(mode=0o755)
    (place / ".povgen-abcdefg6").mkdir(mode=0o700)
    os.mkfifo(place / ".povgen-abcdefg6" / "lock")
    (place / ".povgen-abcdefg7").symlink_to(other)
    os.mkfifo(place / ".povgen-abcdefg8")
    (place / ".povgen-abcdefg9").mkdir(mode=0o700)
    (other / "lock").write_bytes(files.MARK)
    (place / ".povgen-abcdefg9" / "lock").symlink_to(other / "lock")
    before = tree(tmp_path)
    files.save(b"new", place / "a.pov")
    assert files.remove_leftovers(place) == 0 and not files.leftover_sizes(place)
    (place / "a.pov").unlink()
    assert tree(tmp_path) == before


def test_what_killed_povgens_left_is_counted_and_removed(tmp_path, monkeypatch):
    """In the cache and among temporary files. The folders of a povgen that still runs stay."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    script = (
        "from povgen import files; from povgen.rendering import cache; import os, pathlib, signal\n"
        "with cache.work_folder() as one, files.temporary_folder() as two:\n"
        "    (one / 'deep').mkdir(); (one / 'deep' / 'movie.mp4').write_bytes(bytes(300_000))\n"
        "    (two / 'frame.png').write_bytes(bytes(50_000))\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", script], env=environment)
    with cache.work_folder() as own, files.temporary_folder() as another:
        subprocess.run([sys.executable, "-c", script], env=environment)
        assert [size // 10_000 for size in cache.leftover_sizes()] == [30, 5]
        printed = [povgen(["cache", what], tmp_path)[1] for what in ("info", "clear")]
        assert "\n2 folders that killed povgens left, 0.000 GiB\n" in printed[0]
        assert "\nremoved 2 folders that killed povgens left\n" in printed[1]
        assert not cache.leftover_sizes() and own.is_dir() and another.is_dir()
    subprocess.run([sys.executable, "-c", script], env=environment)
    with cache.work_folder(), files.temporary_folder():  # the next povgen removes them, too
        assert not cache.leftover_sizes()
    assert {path.name for path in tmp_path.iterdir()} == {"cache"}


def test_work_folders_made_at_once(tmp_path):
    """Each looks for leftovers while the others make their folders. No folder in use is removed."""

    def use(number):
        for _ in range(100):
            with files.work_folder(tmp_path) as folder:
                (folder / "part").write_text(str(number))
                assert (folder / "part").read_text() == str(number)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(use, range(8)))
    assert not list(tmp_path.iterdir())


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


@pytest.mark.xdist_group("stopped")  # of which frames are rendered once
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


@pytest.mark.parametrize("number, status", [(signal.SIGHUP, 129), (signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("while_", ["rendering", "encoding"])
def test_stopped(place, number, status, while_, rendered):
    if while_ == "encoding":  # of frames that are there, slowly
        shutil.copytree(rendered, place / "cache")
        process = start(place, *LARGE, "-o", "a.webm")
        wait_for(lambda: any(b"ffmpeg" in command and b"webm" in command for command in processes(place).values()))
        time.sleep(0.3)
    else:
        process = start(place, "--workers", "1")
        wait_for(lambda: len(finished(place)) >= 3)
    stop(process, number)
    assert process.returncode == status
    assert not processes(place)
    assert {path.name for path in place.iterdir()} == {"cache", "z2.toml"}
    assert not list(place.glob("cache/.povgen-*"))


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


@pytest.mark.parametrize("module", [False, True], ids=["povgen", "python -m povgen"])
def test_stopped_while_it_is_loaded(module, place):
    for moment in (0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3):
        process = start(place, command=[sys.executable, "-m", "povgen"] if module else [POVGEN])
        wait_for(lambda process=process: catches(process))
        time.sleep(moment)
        stop(process)


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
        assert not processes(place)
        assert not [path for path in place.rglob("*") if "povgen-" in path.name]


@pytest.mark.parametrize("pause", [0, 0.9])
def test_stopped_though_the_exception_is_lost(pause, tmp_path):
    """As in a destructor, or in code that catches every exception. On a busy machine, folders are removed slowly."""
    program = f"""if True:
        import shutil
        import time
        remove = shutil.rmtree
        shutil.rmtree = lambda *args, **options: (time.sleep({pause}), remove(*args, **options))
        from pathlib import Path
        from povgen import files, stopping
        stopping.on_signals()
        with files.work_folder(Path.cwd()) as folder:
            while True:
                try:
                    (folder / "part").touch()
                    time.sleep(600)
                except BaseException:
                    pass
    """
    process = subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: list(tmp_path.glob("*/part")))
    stop(process, signal.SIGTERM)
    assert not list(tmp_path.iterdir())


def test_stopped_within_a_destructor():
    """Python loses the exception there, and would print a traceback."""
    program = """if True:
        import os, signal, time
        from povgen import stopping
        stopping.on_signals()

        class Interrupted:
            def __del__(self):
                os.kill(os.getpid(), signal.SIGTERM)
                time.sleep(0.1)

        Interrupted()
        time.sleep(600)
    """
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=200)
    assert done.returncode == 128 + signal.SIGTERM and done.stderr.encode() == stopping.MESSAGE


def test_stopped_though_the_main_thread_waits(tmp_path):
    """For a lock, with the signal delivered to another thread. Then Python calls no handler."""
    program = """if True:
        import signal, threading, time
        from povgen import stopping
        stopping.on_signals()

        def interrupted():
            time.sleep(0.5)
            signal.pthread_kill(threading.get_ident(), signal.SIGTERM)
            time.sleep(600)

        threading.Thread(target=interrupted, daemon=True).start()
        lock = threading.Lock()
        lock.acquire()
        lock.acquire()
    """
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, timeout=200)
    assert done.returncode == 128 + signal.SIGTERM and done.stderr.startswith("povgen: stopped")


def test_nothing_is_started_once_povgen_stops(tmp_path, monkeypatch):
    monkeypatch.setattr(povray.stopping, "_number", signal.SIGINT)
    with pytest.raises(PovrayError, match="POV-Ray was stopped"):
        povray.run("", SMALL, tmp_path)
    assert not (tmp_path / "1" / SMALL.file).stat().st_size
    with pytest.raises(KeyboardInterrupt), files.work_folder(tmp_path / "1"):
        pass
    assert not list(tmp_path.glob("1/.povgen-*"))


def test_an_ignored_signal_is_ignored(place):
    """As under nohup, or for a command that a script starts with &."""
    process = start(place, handler=signal.SIG_IGN)
    wait_for(lambda: catches(process))
    process.send_signal(signal.SIGINT)
    assert process.wait(200) == 0


@pytest.mark.parametrize("fault, said", [(signal.SIGKILL, "killed by signal 9"), (signal.SIGSTOP, "longer than 5 s")])
def test_a_frame_that_fails_leaves_the_others(place, fault, said, monkeypatch):
    """One frame's POV-Ray is killed, or hangs, at each try."""
    monkeypatch.setenv("POVGEN_CACHE", str(place / "cache"))
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


def test_a_killed_povray_is_tried_again(place, monkeypatch):
    monkeypatch.setenv("POVGEN_CACHE", str(place / "cache"))
    met, start = [], subprocess.Popen.__init__

    def struck(process, *arguments, **options):
        start(process, *arguments, **options)
        if "+Iscene.pov" in process.args:  # a POV-Ray that renders
            met.append(process)
            if len(met) in (1, 3, 5):  # the first try of three frames
                process.kill()

    monkeypatch.setattr(subprocess.Popen, "__init__", struck)
    movie(place / "z2.toml", place / "a.mp4", size=(64, 48), workers=1)
    monkeypatch.undo()
    assert imageio_ffmpeg.count_frames_and_secs(str(place / "a.mp4"))[0] == COUNT and len(met) == COUNT + 3


def crowded(place, limit, script):
    """Run a shell script. `small` is a file system with a limit, such as size=40k, and `grow` makes it larger."""
    (place / "small").mkdir()
    mount = f'mount -t tmpfs -o {limit} tmpfs small; grow() {{ mount -o remount,size=100m "$PWD/small"; }}; '
    whole = ["unshare", "--mount", "--map-root-user", "sh", "-c", f'{mount} povgen() {{ {POVGEN} "$@"; }}; {script}']
    return subprocess.run(whole, cwd=place, capture_output=True, text=True, timeout=200, env=os.environ)


@pytest.mark.parametrize("what", ["rendering", "encoding", "encoding a GIF"] if CAN_MOUNT else [])
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


@pytest.mark.parametrize("limit", ["size=32k", "size=9m,nr_inodes=9"] if CAN_MOUNT else [])
def test_check_with_too_little_room_for_temporary_files(place, limit):
    done = crowded(place, limit, "TMPDIR=$PWD/small; export TMPDIR; povgen check; ls -A small")
    assert done.stdout.count("FAULT") == done.stdout.count("remedy: ") == 1, done.stdout
    assert f"FAULT  temporary files: {place}/small" in done.stdout and "TMPDIR" in done.stdout
    assert ("no inodes left" in done.stdout) == ("inodes" in limit)
    assert done.stdout.endswith("encoder: not tested, because it needs: temporary files\n")  # nothing is left there


@pytest.mark.parametrize("damage", ["truncated", "a bit turned", "empty", "another file"])
def test_a_damaged_frame_is_rendered_again(damage, monkeypatch, tmp_path):
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path))
    (scene, *_) = MovieSpec.parse(SPEC, "x").scenes("standard")
    still.as_file(scene, SMALL)
    frame = cache.frame_path(to_pov(scene), SMALL)
    data = frame.read_bytes()
    middle = len(data) // 2
    frame.write_bytes(
        {
            "truncated": data[:-20],
            "a bit turned": data[:middle] + bytes([data[middle] ^ 16]) + data[middle + 1 :],
            "empty": b"",
            "another file": b"GIF89a" + data,
        }[damage]
    )
    again = still.as_file(scene, SMALL)
    assert np.array_equal(frames.read_png(again), frames.read_png(data))
    assert frames.is_whole(frame.read_bytes(), SMALL.size)


def test_two_at_once(place, monkeypatch):
    """Two movies with the same cache and output, while another process clears the cache again and again."""
    both = [start(place) for _ in range(2)]
    monkeypatch.setenv("POVGEN_CACHE", str(place / "cache"))
    while any(process.poll() is None for process in both):
        cache.trim(-1)
        cache.remove_leftovers()
        time.sleep(0.1)
    for process in both:
        assert process.wait() == 0, process.stderr.read()
    assert imageio_ffmpeg.count_frames_and_secs(str(place / "a.mp4"))[0] == COUNT
    assert not list(place.glob("cache/.povgen-*")) and not list(place.glob(".povgen-*"))


def test_the_cache_keeps_to_its_size(place, monkeypatch):
    monkeypatch.setenv("POVGEN_CACHE", str(place / "cache"))
    scenes = MovieSpec.parse(SPEC, "x").scenes("standard")
    pictures = [png for (png,) in frames.render_all(scenes, SMALL)]
    first = [cache.frame_path(to_pov(scene), SMALL) for scene in scenes[:-1]]
    for path, picture in zip(first[:4], pictures, strict=False):
        assert cache.read(path, 10**6) == picture  # used again
    size = sum(path.stat().st_size for path in first[:5])
    monkeypatch.setenv("POVGEN_CACHE_SIZE", str(size / 2**30))
    list(frames.render_all(scenes[:1], SMALL))
    kept = set(finished(place))
    assert set(first[:4]) <= kept and len(kept) <= 6 and sum(path.stat().st_size for path in kept) <= size
    assert povgen(["cache", "info"], place)[1].startswith(f"{len(kept)} frames, 0 ray traces and pieces, 0.000 of ")
    assert povgen(["cache", "clear"], place)[1].startswith(f"removed {len(kept)} frames")
    assert not finished(place)
    monkeypatch.setenv("POVGEN_CACHE_SIZE", "much")
    assert "POVGEN_CACHE_SIZE = 'much': allowed" in refused(MOVIE, place)
