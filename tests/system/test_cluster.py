"""Rendering on other machines, with a real scheduler and workers that are killed, cut off or unfit; and shards."""

import asyncio
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
from conftest import SPEC, povgen, refused, wait_for

from povgen import Chess, InputError, MovieSpec, PovrayError, Rendering, remedies, render, results, to_pov
from povgen.errors import TransientError
from povgen.files import PREFIX
from povgen.rendering import cache, cluster, frames, povray
from povgen.rendering.cluster import Cluster

BIN = Path(sys.executable).parent
COUNT = 8  # frames of SPEC
SCENES = MovieSpec.parse(SPEC, "x").scenes("standard")
SMALL = Rendering(size=(64, 48)).suited(prisms=False)
MOVIE = [BIN / "povgen", "movie", "z2.toml", "--size", "64x48"]


class Machines:
    """A client, a scheduler and workers, which are processes with a folder each."""

    def __init__(self, folder: Path):
        self.folder, self.processes = folder, {}
        self.client = folder / "client"
        self.client.mkdir(parents=True)
        (self.client / "z2.toml").write_text(SPEC)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.processes.values():
            process.kill()
            process.wait()

    def start(self, name, arguments, **environment):
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        own = {"HOME": str(folder), "TMPDIR": str(folder), "POVGEN_CACHE": str(folder / "cache")}
        with open(folder / "log", "w") as log:
            self.processes[name] = subprocess.Popen(
                [BIN / "dask", *arguments], cwd=folder, env={**os.environ, **own, **environment}, stdout=log, stderr=log
            )

    def scheduler(self, **environment):
        file = self.folder / "scheduler" / "file"
        place = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", file]
        self.start("scheduler", ["scheduler", *place, "--no-dashboard"], **environment)
        wait_for(lambda: file.exists() and file.read_text())
        self.address = json.loads(file.read_text())["address"]

    def worker(self, name, threads=2, **environment):
        options = ["--host", "127.0.0.1", "--name", name, "--nthreads", str(threads), "--no-nanny", "--no-dashboard"]
        self.start(name, ["worker", self.address, *options], **environment)

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
            [*MOVIE, "--scheduler", self.address, *arguments],
            cwd=self.client,
            env={**os.environ, "POVGEN_CACHE": str(self.client / "cache")},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
            **options,
        )

    def kill_as_it_renders(self, lost):
        """Kill a process as soon as the worker has begun to render."""
        wait_for(lambda: list((self.folder / "worker").glob(f"{PREFIX}*/*")))
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


@pytest.mark.release
@pytest.mark.parametrize("number", [signal.SIGKILL, pytest.param(signal.SIGSTOP, marks=pytest.mark.release)])
def test_a_worker_lost_in_mid_movie(number, tmp_path):
    """Only its frames are rendered again. The frames are the same as frames from this machine."""
    with Machines(tmp_path) as machines:
        machines.scheduler(DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL="4s")
        machines.worker("one")
        machines.worker("two")
        machines.addresses("one", "two")
        process = machines.movie("--quiet")
        wait_for(lambda: len(machines.finished()) >= 2)
        before = machines.finished()
        machines.processes["one"].send_signal(number)
        printed = process.communicate(timeout=200)
        assert process.returncode == 0 and printed == ("", ""), printed
        assert before.items() <= machines.finished().items()
        assert imageio_ffmpeg.count_frames_and_secs(str(machines.client / "z2.mp4"))[0] == COUNT
        kept = {path.name: path for path in machines.finished()}
        assert len(kept) == COUNT
        for scene, (own,) in zip(SCENES, frames.render_all(SCENES, SMALL), strict=True):
            theirs = kept[cache.frame_path(to_pov(scene), SMALL).name]
            assert np.array_equal(frames.read_png(own), frames.read_png(theirs))
        assert not (machines.folder / "two" / "cache").exists()
        wait_for(lambda: not list(machines.folder.glob("two/povgen-*")))  # it may finish a frame that came otherwise


UNFIT = {  # for each worker: a module that it finds, its text, and what is said of it
    "other": (
        "sitecustomize",
        "from povgen import version\nversion.__version__ = '0.0.9'\n",
        "it has povgen 0.0.9, POV-Ray",
    ),
    "none": ("povgen", "raise ModuleNotFoundError(\"No module named 'povgen'\")\n", "No module named 'povgen'"),
}


@pytest.mark.release
def test_unfit_workers_are_named(shared):
    """Nothing is rendered, though one worker is fit."""
    for name, (module, text, _) in UNFIT.items():
        (shared.folder / name).mkdir(exist_ok=True)
        (shared.folder / name / f"{module}.py").write_text(text)
        shared.worker(name, PYTHONPATH=".")
    left = dict(zip(UNFIT, shared.addresses(*UNFIT), strict=True))
    try:
        for others in (" (2 of 3 workers cannot be used)", ""):
            done = shared.movie("--quiet", run=subprocess.run)
            assert done.returncode == 1 and done.stdout == "" and not shared.finished()
            (named,) = (name for name, address in left.items() if f"worker {address}: " in done.stderr)
            assert UNFIT[named][2] in done.stderr
            assert done.stderr.endswith(f"{others}\n") and done.stderr.count("\n") == 1
            shared.kill(named)
            shared.processes[named].wait()
            del left[named]
    finally:
        for name in left:
            shared.kill(name)
            shared.processes[name].wait()


@pytest.mark.parametrize("frozen", [False, True])
@pytest.mark.release
def test_stopped(shared, frozen):
    """Without waiting for the scheduler, which may be frozen."""
    shutil.rmtree(shared.client / "cache", ignore_errors=True)
    process = shared.movie("--workers", "4")
    wait_for(lambda: len(shared.finished()) >= 2)
    with shared.frozen("scheduler") if frozen else nullcontext():
        process.send_signal(signal.SIGINT)
        message = process.communicate(timeout=200)[1]
    assert process.returncode == 128 + signal.SIGINT, message
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


def test_results_may_be_long_on_their_way(shared, monkeypatch):
    """Longer than the time after which `stop` is noticed; all are sent together."""
    monkeypatch.setattr(cluster, "POLL", 0.1)
    with Cluster(shared.address, None) as there, ThreadPoolExecutor(8) as pool:
        send = there._client._gather_remote

        async def slow(*arguments):
            await asyncio.sleep(0.35)
            return await send(*arguments)

        monkeypatch.setattr(there._client, "_gather_remote", slow)
        assert [*pool.map(lambda n: there.call(abs, -n), range(16))] == [*range(16)]


def test_pictures_and_results_of_many_scenes(shared, tmp_path, monkeypatch):
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    options = {"size": (64, 48), "progress": False}
    with monkeypatch.context() as away:
        away.setattr("povgen.rendering.povray.Runner", None)
        away.setattr("povgen.measure.results._computed", None)
        pictures = render(SCENES[:3], scheduler=shared.address, **options)
        table = results(SCENES, "M", "x", scheduler=shared.address, progress=False)
        swept = results(Chess(), "nu", alpha=(0, 90), scheduler=shared.address, progress=False).to_xarray()
        wrong = "^worker tcp:.*it has .*; wanted, as on this machine: nix$"
        away.setattr(cluster, "versions", lambda _: "nix")
        with pytest.raises(PovrayError, match=wrong):
            Cluster(shared.address)
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "own"))
    assert all(np.array_equal(*both) for both in zip(pictures, render(SCENES[:3], **options), strict=True))
    own = results(SCENES, "M", "x", progress=False)
    assert list(table) == ["z2", "M", "x"]
    assert swept.nu.dims == ("alpha",) and swept.nu[0] == 0 < swept.nu[1]
    for name in own:
        np.testing.assert_allclose(table[name], own[name], 1e-12)


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
    ("lost", "said"),
    [("worker", "lost while they computed it: 1, the last tcp:"), ("scheduler", "connection was lost")],
)
@pytest.mark.release
def test_workers_or_the_scheduler_lost(lost, said, tmp_path):
    large = Rendering(size=(2400, 1800))  # takes long
    with Machines(tmp_path) as machines:
        machines.scheduler(DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="0")
        machines.worker("worker")
        machines.addresses("worker")
        with Cluster(machines.address) as there:
            threading.Thread(target=machines.kill_as_it_renders, args=(lost,)).start()
            with pytest.raises(PovrayError, match=said) as fault:
                there.run(to_pov(Chess()), large, tmp_path)
            assert isinstance(fault.value, TransientError) == (lost == "worker") and "\n" not in str(fault.value)


def test_no_scheduler(monkeypatch, tmp_path):
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        for port in (1, silent.getsockname()[1]):  # where nobody listens, and where nobody answers
            with pytest.raises(PovrayError, match=f"scheduler tcp://127.0.0.1:{port}: no Dask scheduler answers"):
                Cluster(f"tcp://127.0.0.1:{port}")


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


@pytest.mark.release
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

    for part in ("4/3", "1/0", "-1/3", "1", "1/3/5", "1.5/3"):
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
