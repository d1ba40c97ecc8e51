"""Rendering on other machines, with a real scheduler and workers that are killed, cut off or unfit; and shards."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import SimpleNamespace

import distributed
import imageio_ffmpeg
import numpy as np
import pytest
from conftest import povgen, refused, wait_for
from forked import Dask

from povgen import Chess, InputError, MovieSpec, PovrayError, Rendering, remedies, render, results, to_pov
from povgen.errors import TransientError
from povgen.files import PREFIX
from povgen.rendering import auto, cache, cluster, frames, povray
from povgen.rendering.cluster import Cluster

pytestmark = pytest.mark.xdist_group("cluster")  # the shared scheduler is started once
BIN = Path(sys.executable).parent
COUNT = 8
SPEC = (
    f'title = "x"\nscene = "chess"\nframe_rate = 10\nframes = {COUNT}\n[fixed]\nsheet = "none"\n'
    '[[sweep]]\nparameter = "z2"\nstart = 4\nstop = 6\n'
)
SCENES = MovieSpec.parse(SPEC, "x").scenes("standard")
SMALL = Rendering(size=(64, 48)).suited(prisms=False)
MOVIE = [BIN / "povgen", "movie", "z2.toml", "--size", "64x48"]
# root may make networks, unless it is a container's
CAN_UNSHARE = os.geteuid() == 0 and shutil.which("ip") and not subprocess.run(["unshare", "--net", "true"]).returncode
NAMESPACES = pytest.mark.skipif(not CAN_UNSHARE, reason="this user may not make networks"), pytest.mark.release


class Machines:
    """Processes with a folder each, here or each in a network namespace that is connected to the client's."""

    def __init__(self, folder: Path, network: str = "loopback"):
        self.folder, self.network, self.processes = folder, network, {}
        self.client = folder / "client"
        self.client.mkdir(parents=True)
        (self.client / "z2.toml").write_text(SPEC)
        if network == "namespaces":
            self.ip("netns", "add", self.space("client"))
            self.ip("-n", self.space("client"), "link", "set", "lo", "up")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.processes.values():
            process.kill()
            process.wait()
        if self.network == "namespaces":
            for path in Path("/run/netns").glob(self.space("*")):
                self.ip("netns", "delete", path.name)

    def ip(self, *arguments):
        subprocess.run(["ip", *arguments], check=True)

    def space(self, name):
        return f"povgen-{os.getpid()}-{name}"

    def command(self, name, command):
        return ["ip", "netns", "exec", self.space(name), *command] if self.network == "namespaces" else command

    def start(self, name, command, **environment):
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        own = {"HOME": folder, "TMPDIR": folder, "POVGEN_CACHE": folder / "cache"}
        own = {name: str(value) for name, value in own.items()}
        if command[0] == BIN / "dask" and "PYTHONPATH" not in environment:  # which decides what Python loads
            self.processes[name] = Dask(command[1:], folder, {**os.environ, **own, **environment}, folder / "log")
            return
        with open(folder / "log", "w") as log:
            self.processes[name] = subprocess.Popen(
                command, cwd=folder, env={**os.environ, **own, **environment}, stdout=log, stderr=log
            )

    def scheduler(self, **environment):
        place = "0.0.0.0" if self.network == "namespaces" else "127.0.0.1"
        file = self.folder / "scheduler" / "file"
        command = [
            BIN / "dask",
            "scheduler",
            "--host",
            place,
            "--port",
            "0",
            "--no-dashboard",
            "--scheduler-file",
            file,
        ]
        self.start("scheduler", self.command("client", command), **environment)
        wait_for(lambda: file.exists() and file.read_text())
        self.port = json.loads(file.read_text())["address"].rpartition(":")[2]
        self.address = f"tcp://127.0.0.1:{self.port}"

    def worker(self, name, threads=2, **environment):
        theirs, own, hide = self.address, "127.0.0.1", []
        if self.network == "namespaces":
            number, client, space = len(self.processes), self.space("client"), self.space(name)
            theirs, own = f"tcp://10.77.{number}.1:{self.port}", f"10.77.{number}.2"
            self.ip("netns", "add", space)
            self.ip("-n", client, "link", "add", name, "type", "veth", "peer", "name", "cable", "netns", space)
            for of, link, address in ((client, name, f"10.77.{number}.1"), (space, "cable", own)):
                self.ip("-n", of, "address", "add", f"{address}/24", "dev", link)
                self.ip("-n", of, "link", "set", link, "up")
            # the client's folder is not there for the worker
            hide = ["sh", "-c", 'mount -t tmpfs none "$0" && exec "$@"', self.client]
        options = ["--host", own, "--name", name, "--nthreads", str(threads), "--no-nanny", "--no-dashboard"]
        self.start(name, self.command(name, [*hide, BIN / "dask", "worker", theirs, *options]), **environment)

    def cut(self, name):
        """Cut the worker's cable: no message says that it is gone."""
        self.ip("-n", self.space(name), "link", "set", "cable", "down")

    def kill(self, name):
        self.processes[name].kill()

    @contextmanager
    def frozen(self, name):
        self.processes[name].send_signal(signal.SIGSTOP)
        yield
        self.processes[name].send_signal(signal.SIGCONT)

    def addresses(self, *names):
        """Return the workers' addresses as soon as the scheduler knows them."""
        logs = [self.folder / name / "log" for name in names]
        wait_for(lambda: all("Registered to:" in log.read_text() for log in logs))
        return [re.search(r"Start worker at: +(\S+)", log.read_text())[1] for log in logs]

    def movie(self, *arguments, run=subprocess.Popen, **options):
        return run(
            self.command("client", [*MOVIE, "--scheduler", self.address, *arguments]),
            cwd=self.client,
            env={**os.environ, "POVGEN_CACHE": str(self.client / "cache")},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
            **options,
        )

    def kill_as_it_renders(self, lost, worker):
        """Kill a process as soon as the worker has begun to render."""
        wait_for(lambda: list((self.folder / worker).glob(f"{PREFIX}*/*")))
        self.kill(lost)

    def finished(self):
        return {path: path.stat().st_mtime_ns for path in self.client.glob("cache/??/*.png")}


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    """A scheduler and a worker with the same versions as the client."""
    with Machines(tmp_path_factory.mktemp("shared")) as machines:
        machines.scheduler()
        machines.worker("fit", threads=4)
        machines.addresses("fit")
        yield machines


def same_as_here(machines):
    """Whether the frames from the workers are the same as frames from this machine."""
    kept = {path.name: path for path in machines.finished()}
    places = [kept[cache.frame_path(to_pov(scene), SMALL).name] for scene in SCENES]
    own = frames.render_all(SCENES, SMALL)
    same = [
        np.array_equal(frames.read_png(png), frames.read_png(path)) for (png,), path in zip(own, places, strict=True)
    ]
    return all(same) and len(kept) == COUNT


@pytest.mark.parametrize("network", ["loopback", pytest.param("namespaces", marks=NAMESPACES)])
def test_a_worker_lost_in_mid_movie(network, tmp_path):
    """The worker is killed, or its machine is cut off. Only its frames are rendered again."""
    with Machines(tmp_path, network) as machines:
        machines.scheduler(DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL="4s")
        machines.worker("one")
        machines.worker("two")
        machines.addresses("one", "two")
        process = machines.movie("--quiet")
        wait_for(lambda: len(machines.finished()) >= 2)
        before = machines.finished()
        machines.kill("one") if network == "loopback" else machines.cut("one")
        printed = process.communicate(timeout=200)
        assert process.returncode == 0 and printed == ("", ""), printed
        assert before.items() <= machines.finished().items()
        assert imageio_ffmpeg.count_frames_and_secs(str(machines.client / "z2.mp4"))[0] == COUNT
        assert same_as_here(machines)
        assert not (machines.folder / "two" / "cache").exists() and not list(machines.folder.glob("two/povgen-*"))


UNFIT = {
    "no-povray": ({"PATH": "/nowhere"}, "POV-Ray is not installed"),
    "other-povray": ({"PATH": "."}, "POV-Ray 3.8.0, Dask .*; wanted, as on this machine: povgen"),
    "other-povgen": ({"PYTHONPATH": "."}, "it has povgen 0.0.9, POV-Ray"),
    "no-povgen": ({"PYTHONPATH": "."}, "No module named 'povgen'"),
}


def start_unfit(machines, name):
    folder = machines.folder / name
    folder.mkdir()
    (folder / "povray").write_text("#!/bin/sh\necho POV-Ray 3.8.0\n")
    (folder / "povray").chmod(0o755)
    if name == "other-povgen":
        (folder / "sitecustomize.py").write_text("from povgen import version\nversion.__version__ = '0.0.9'\n")
    if name == "no-povgen":
        (folder / "povgen.py").write_text("raise ModuleNotFoundError(\"No module named 'povgen'\")\n")
    machines.worker(name, **UNFIT[name][0])


@pytest.mark.parametrize("names", [["other-povgen"], pytest.param([*UNFIT], marks=pytest.mark.release)], ids=len)
def test_unfit_workers_are_named(names, shared):
    """Nothing is rendered, though one worker is fit."""
    for name in names:
        start_unfit(shared, name)
    addresses = dict(zip(names, shared.addresses(*names), strict=True))
    for left in range(len(names), 0, -1):
        done = shared.movie("--quiet", run=subprocess.run)
        assert done.returncode == 1 and done.stdout == "" and not shared.finished()
        (named,) = (name for name, address in addresses.items() if f"worker {address}: " in done.stderr)
        assert re.search(UNFIT[named][1], done.stderr) and len(done.stderr.splitlines()) == 1
        assert left == 1 or f"({left} of {left + 1} workers cannot be used)" in done.stderr
        shared.kill(named)
        shared.processes[named].wait()
        shutil.rmtree(shared.folder / named)


@pytest.mark.release
def test_unfit_workers_that_come_late(tmp_path):
    """Dask ends a worker without povgen. A worker with another version is named when it gets a frame."""
    with Machines(tmp_path) as machines:
        machines.scheduler()
        machines.worker("fit")
        machines.addresses("fit")
        with Cluster(machines.address) as there:
            start_unfit(machines, "no-povgen")
            machines.addresses("no-povgen")
            with ThreadPoolExecutor(8) as pool:  # more than the one that is fit takes at once
                for folder in [tmp_path / str(number) for number in range(8)]:
                    folder.mkdir()
                    pool.submit(there.run, to_pov(SCENES[0]), SMALL, folder)
            assert len(list(tmp_path.glob("*/frame.png"))) == 8
            assert machines.processes["no-povgen"].wait(200) is not None
            start_unfit(machines, "other-povray")
            (address,) = machines.addresses("other-povray")
            machines.kill("fit")
            with pytest.raises(PovrayError, match=f"worker {address}: .*{UNFIT['other-povray'][1]}"):
                there.run(to_pov(SCENES[0]), SMALL, tmp_path)


@pytest.mark.parametrize(
    "number, frozen",
    [
        (signal.SIGINT, False),
        *(pytest.param(*each, marks=pytest.mark.release) for each in ((signal.SIGTERM, False), (signal.SIGINT, True))),
    ],
)
def test_stopped(shared, number, frozen):
    """Without waiting for the scheduler, which may be frozen."""
    shutil.rmtree(shared.client / "cache", ignore_errors=True)
    process = shared.movie("--workers", "4")
    wait_for(lambda: len(shared.finished()) >= 2)
    with shared.frozen("scheduler") if frozen else nullcontext():
        process.send_signal(number)
        message = process.communicate(timeout=200)[1]
    assert process.returncode == 128 + number, message
    assert message.endswith("povgen: stopped; the same command goes on from the frames that are finished\n")
    assert "Traceback" not in message and "distributed" not in message
    assert {path.name for path in shared.client.iterdir()} == {"cache", "z2.toml"}
    with distributed.Client(shared.address, set_as_default=False) as client:
        wait_for(lambda: not client.run_on_scheduler(lambda dask_scheduler: len(dask_scheduler.tasks)))


def test_a_frame_that_fails_names_its_worker_and_leaves_the_others(shared, tmp_path):
    """POV-Ray refuses one frame and takes too long for another. The messages are POV-Ray's own."""
    (address,) = shared.addresses("fit")
    with Cluster(shared.address) as there:
        with pytest.raises(PovrayError, match=f"worker {address}: POV-Ray: scene.pov, line .*") as fault:
            there.run(to_pov(SCENES[0]).replace("camera {", "camera { nonsense", 1), SMALL, tmp_path)
        assert not isinstance(fault.value, TransientError)
        with pytest.raises(TransientError, match=f"worker {address}: POV-Ray took longer than 0.1 s .* 2 times"):
            there.run(to_pov(SCENES[0]), Rendering(size=(64, 48), timeout=0.1), tmp_path)
        assert frames.is_whole(there.run(to_pov(SCENES[0]), SMALL, tmp_path).read_bytes(), SMALL.size)


def test_pictures_and_results_of_many_scenes(shared, tmp_path, monkeypatch):
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    options = {"size": (64, 48), "progress": False}
    with monkeypatch.context() as away:
        away.setattr("povgen.rendering.povray.Runner", None)
        away.setattr("povgen.rendering.results._computed", None)
        pictures = render(SCENES[:3], scheduler=shared.address, **options)
        table = results(SCENES, "M", "x", scheduler=shared.address, progress=False)
        wrong = "^worker tcp:.*it has .*; wanted, as on this machine: nix$"
        with pytest.raises(PovrayError, match=wrong), Cluster(shared.address) as there:
            there.call(cluster.check, "nix", "povray")
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "own"))
    assert all(np.array_equal(*both) for both in zip(pictures, render(SCENES[:3], **options), strict=True))
    own = results(SCENES, "M", "x", progress=False)
    assert list(table) == ["z2", "M", "x"] and all(np.array_equal(table[name], own[name]) for name in own)


@pytest.mark.release
def test_workers_need_only_what_is_used(tmp_path, monkeypatch):
    """Without POV-Ray a worker draws with gl, and computes."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    options = {"size": (64, 48), "antialias": "off", "renderer": "gl", "progress": False}
    with Machines(tmp_path / "machines") as machines:
        machines.scheduler()
        machines.worker("bare", PATH="/nowhere")
        machines.addresses("bare")
        monkeypatch.setattr(povray, "version", lambda: pytest.fail("POV-Ray was asked for"))
        (picture,) = render(SCENES[:1], scheduler=machines.address, **options)
        table = results(SCENES[:1], "M", scheduler=machines.address, progress=False)
        monkeypatch.undo()
        with pytest.raises(PovrayError, match="worker tcp:.*POV-Ray is not installed"):
            render(SCENES[0], scheduler=machines.address, size=(64, 48))
    assert np.array_equal(picture, render(SCENES[0], **options))
    assert table["M"] == results(SCENES[:1], "M", progress=False)["M"]


def test_another_dask_is_named(shared, monkeypatch):
    own = distributed.__version__
    monkeypatch.setattr(distributed, "__version__", "2024.8.0")
    with pytest.raises(PovrayError, match=f"{shared.address}: it has Dask {own}; wanted, as on this machine: 2024.8.0"):
        Cluster(shared.address)


@pytest.mark.parametrize(
    ("lost", "said"), [("worker", "lost while they computed"), ("scheduler", "connection was lost")]
)
def test_workers_or_the_scheduler_lost(lost, said, tmp_path):
    large = Rendering(size=(2400, 1800))  # takes long
    with Machines(tmp_path) as machines:
        machines.scheduler(DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="0")
        machines.worker("worker")
        machines.addresses("worker")
        with Cluster(machines.address) as there:
            threading.Thread(target=machines.kill_as_it_renders, args=(lost, "worker")).start()
            with pytest.raises(PovrayError, match=said) as fault:
                there.run(to_pov(Chess()), large, tmp_path)
            assert isinstance(fault.value, TransientError) == (lost == "worker") and "\n" not in str(fault.value)


def test_no_frame_waits_once_the_work_is_stopped(shared, tmp_path):
    large = Rendering(size=(2400, 1800))  # takes long
    with ThreadPoolExecutor() as pool, Cluster(shared.address) as there:
        waiting = pool.submit(there.run, to_pov(Chess()), large, tmp_path)
        wait_for(lambda: list((shared.folder / "fit").glob(f"{PREFIX}*/*")))
        there.stop()
        with pytest.raises(PovrayError, match="the work was stopped"):
            waiting.result(60)


def test_no_scheduler(monkeypatch, tmp_path):
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        for port in (1, silent.getsockname()[1]):  # where nobody listens, and where nobody answers
            with pytest.raises(PovrayError, match=f"scheduler tcp://127.0.0.1:{port}: no Dask scheduler answers"):
                Cluster(f"tcp://127.0.0.1:{port}")


def test_why_no_scheduler_answers():
    for address, why in (
        ("127.0.0.1:1", "Connection refused"),
        ("10.0.0..1:1", "idna"),
    ):
        with pytest.raises(PovrayError, match=f"no Dask scheduler answers .*({why})"):
            cluster.ask(f"tcp://{address}")


def test_the_scheduler_is_asked_before_a_sheet_is_chosen(tmp_path, monkeypatch):
    monkeypatch.setattr(auto, "choose", lambda *_: pytest.fail("something was rendered"))
    line = ["movie", "chess", "--sweep=alpha=10:90", "--frames=3", "--size=32x32", "--sheet=auto", "--tolerance=1px"]
    status, _, err = povgen([*line, "--scheduler=tcp://127.0.0.1:1"], tmp_path)
    assert status == 1 and "no Dask scheduler answers" in err and "sheet" not in err


def test_a_worker_with_other_code_is_named(monkeypatch):
    monkeypatch.setattr(cluster, "check", lambda *_: None)
    monkeypatch.setattr(distributed, "get_worker", lambda: SimpleNamespace(address="tcp://one:2"))
    with pytest.raises(PovrayError, match="worker tcp://one:2: .*missing 1 required positional argument"):
        cluster.call("", None, lambda x: x)


def test_the_threads_of_a_worker_divide_its_memory(monkeypatch):
    limits = []
    monkeypatch.setattr(distributed, "get_worker", lambda: SimpleNamespace(state=SimpleNamespace(nthreads=3)))
    monkeypatch.setattr(povray, "max_memory", lambda *given: limits.append(given[0]) or 8 << 30)
    assert cluster.render(to_pov(Chess(sheet="none")), SMALL, {}).startswith(b"\x89PNG") and {*limits} == {3}


@pytest.mark.parametrize("answer", [[b""], None, [[1, 2]], ["x"]])
def test_an_answer_of_other_code_is_refused(answer, tmp_path, monkeypatch):
    class Other(Cluster):
        def __init__(self, *_):
            self._scheduler, self.frames = "tcp://one:2", 1

        def call(self, *_):
            return answer

        __exit__ = stop = lambda *_: None

    monkeypatch.setattr(cluster, "Cluster", Other)
    words = f"^scheduler tcp://one:2: a worker answered with a {type(answer).__name__}: its povgen has other code$"
    with pytest.raises(PovrayError, match=words):
        Other().run(to_pov(SCENES[0]), SMALL, tmp_path)
    with pytest.raises(PovrayError, match=words):
        results(SCENES, "M", scheduler="tcp://one:2", progress=False)


def test_no_workers_and_no_address(tmp_path):
    with Machines(tmp_path) as machines:
        machines.scheduler()
        status, out, err = povgen([*MOVIE[1:], "--quiet", "--scheduler", machines.address], machines.client)
        assert (status, out, err) == (1, "", f"povgen: scheduler {machines.address}: it has no workers\n")
        message = refused([*MOVIE[1:], "--quiet", "--scheduler", "127.0.0.1"], machines.client)
        assert "scheduler = '127.0.0.1': allowed: " in message
        assert {path.name for path in machines.client.iterdir()} == {"z2.toml"}


def test_without_dask(tmp_path, monkeypatch):
    (tmp_path / "z2.toml").write_text(SPEC)
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "povgen.rendering.cluster")
    monkeypatch.delattr("povgen.rendering.cluster")
    message = refused([*MOVIE[1:], "--quiet", "--scheduler", "tcp://127.0.0.1:1"], tmp_path)
    assert message == f"povgen: --scheduler needs Dask, which is not installed: {remedies.extra('cluster')}\n"


def test_shards(tmp_path, monkeypatch):
    """Each shard has a cache of its own. The caches are copied into one; then the movie renders nothing more."""
    (tmp_path / "z2.toml").write_text(SPEC)

    def run(cache, *arguments):
        monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / cache))
        return povgen([*MOVIE[1:], *arguments], tmp_path)

    for part in ("0/3", "4/3", "1/0", "-1/3", "1", "a/b", "1/3/5", "1.5/3", "²/3", ""):
        with pytest.raises(InputError, match=f"shard = '{part}': allowed: i/n"):
            frames.shard(SCENES, part)
    message = "povgen: shard = '0/3': allowed: i/n, whole numbers, i from 1 to n\n"
    assert run("all", "--shard", "0/3") == (2, "", message)
    status, _, message = run("all", "--shard", "1/2", "--scheduler", "tcp://127.0.0.1:1")
    assert status == 2 and "one of them" in message
    assert frames.shard(SCENES, "2/3") == SCENES[1::3]
    status, out, err = run("one", "--shard", "1/3")
    assert (status, out) == (0, "rendered shard 1/3: 3 frames\n") and "shard 1/3: 3/3 frames" in err
    assert run("two", "--shard", "2/3")[0] == run("three", "--shard", "3/3")[0] == 0
    assert [len(list(tmp_path.glob(f"{name}/??/*.png"))) for name in ("one", "two", "three")] == [3, 3, 2]
    assert not (tmp_path / "z2.mp4").exists()
    for name in ("one", "two", "three"):
        shutil.copytree(tmp_path / name, tmp_path / "all", dirs_exist_ok=True)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("all/??/*.png")}
    assert len(kept) == COUNT and run("all")[0] == 0
    assert kept == {path: path.stat().st_mtime_ns for path in tmp_path.glob("all/??/*.png")}
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "z2.mp4"))[0] == COUNT
    assert run("one", "--shard", "20/20")[0] == 0  # more shards than frames
