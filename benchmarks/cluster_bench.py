"""What rendering on a Dask cluster costs, as a table and as JSON: `make cluster-bench`.

Scheduler, client and workers run on this machine. Each worker runs on one core only, as if it were a machine of one
core. CPU seconds are what the operating system reports of a process.
"""

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from statistics import median
from threading import Thread
from unittest.mock import patch

import distributed
from rich.console import Console
from rich.table import Table

from povgen import MovieSpec, Rendering, movie, to_pov
from povgen.files import temporary_folder
from povgen.measure import speed
from povgen.rendering import frames, parallel
from povgen.rendering.cluster import Cluster
from povgen.scene import survey
from povgen.video import still

DASK = Path(sys.executable).with_name("dask")
THREADS = parallel.POVRAYS_PER_CORE
ROUNDS = 3
LONG, ALONE = 600, 100  # numbers of frames that cost nothing: submitted together, and one after the other
# code that replaces a worker's povray.run: it returns a finished picture
STAND_IN = """
from pathlib import Path
from povgen.rendering import povray
PICTURE = Path({!r}).read_bytes()
def run(source, rendering, folder):
    path = folder / rendering.file
    path.write_bytes(PICTURE)
    return path
povray.run = run
"""


def spec(count: int) -> MovieSpec:
    """Return the paper's first movie, through prisms, with `count` frames."""
    return MovieSpec.load("vary-alpha").model_copy(update={"frames": count})


@contextmanager
def started(*command: object, core: int | None = None) -> Iterator[subprocess.Popen]:
    hold = [] if core is None else ["taskset", "--cpu-list", str(core)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([*hold, DASK, *map(str, command), "--no-dashboard"], **quiet)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def running(workers: int, *options: object) -> Iterator[tuple[str, int]]:
    """Start a cluster. Yield its address and its scheduler's process id."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    with ExitStack() as stack:
        local = ("--host", "127.0.0.1")
        scheduler = stack.enter_context(started("scheduler", *local, "--port", address.rpartition(":")[2]))
        for core in sorted(os.sched_getaffinity(0))[:workers]:
            worker = ("worker", address, *local, "--no-nanny", "--nthreads", THREADS, *options)
            stack.enter_context(started(*worker, core=core))
        with distributed.Client(address, timeout=60, set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=60)
        yield address, scheduler.pid


class Counted:
    """A relay to an address, which counts the bytes in both directions."""

    def __init__(self, address: str):
        self.to = ("127.0.0.1", int(address.rpartition(":")[2]))
        self.server = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self.server.getsockname()[1]}"
        self.out = self.back = 0
        Thread(target=self.serve, daemon=True).start()

    def serve(self) -> None:
        while True:
            here, there = self.server.accept()[0], socket.create_connection(self.to)
            Thread(target=self.relay, args=(here, there, "out"), daemon=True).start()
            Thread(target=self.relay, args=(there, here, "back"), daemon=True).start()

    def relay(self, source: socket.socket, target: socket.socket, name: str) -> None:
        while data := source.recv(1 << 16):
            setattr(self, name, getattr(self, name) + len(data))
            target.sendall(data)
        target.shutdown(socket.SHUT_WR)


def cpu(process: int) -> float:
    """Return the CPU seconds so far of another process."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def own_cpu(who: int) -> float:
    usage = getrusage(who)
    return usage.ru_utime + usage.ru_stime


def whole_movie(count: int, workers: int) -> tuple[float, float, float]:
    """Return the wall seconds of a movie, and the CPU seconds of client and encoder for each of its frames."""
    with (
        temporary_folder() as folder,
        patch.dict(os.environ, POVGEN_CACHE=str(folder / "cache")),
        running(workers) as (address, _),
    ):
        movie(spec(2), folder / "first.mp4", scheduler=address, quality="draft")  # workers import their modules
        survey.of_inputs.cache_clear()  # forget the first movie's ray traces of these scenes
        client, encoder, start = own_cpu(RUSAGE_SELF), own_cpu(RUSAGE_CHILDREN), time.monotonic()
        movie(spec(count), folder / "movie.mp4", scheduler=address)
        wall = time.monotonic() - start
        return wall, (own_cpu(RUSAGE_SELF) - client) / count, (own_cpu(RUSAGE_CHILDREN) - encoder) / count


def for_nothing(quality: str, workers: int) -> dict[str, float]:
    """Measure a frame that costs POV-Ray nothing: seconds alone and among many, CPU seconds, bytes."""
    scenes, rendering = spec(LONG).scenes("standard"), Rendering(quality=quality)
    with temporary_folder() as folder, patch.dict(os.environ, POVGEN_CACHE=str(folder / "cache")):
        picture = folder / "picture.png"
        picture.write_bytes(still.as_file(scenes[LONG // 2], rendering))
        (folder / "stand_in.py").write_text(STAND_IN.format(str(picture)))
        with running(workers, "--preload", folder / "stand_in.py") as (address, scheduler):
            counted = Counted(address)
            with Cluster(counted.address) as cluster:
                texts = [to_pov(scene) for scene in scenes]  # this also traces each scene's rays; the results are kept
                alone = []
                for text in texts[:ALONE]:
                    start = time.monotonic()
                    cluster.run(text, rendering, folder)
                    alone.append(time.monotonic() - start)
                out, back, scheduling, start = counted.out, counted.back, cpu(scheduler), time.monotonic()
                for _ in frames.render_all(scenes, rendering, cluster.frames, runner=cluster):
                    pass
                wall = time.monotonic() - start
                scheduling = (cpu(scheduler) - scheduling) / LONG
                few = [to_pov(scene) for scene in spec(5).scenes("standard")]
                povray = median(speed.sample(text, rendering.sampling, rendering.size)[0] for text in few)
                return {
                    "text, bytes": len(texts[0].encode()),
                    "picture, bytes": picture.stat().st_size,
                    "out, bytes": (counted.out - out) / LONG,
                    "back, bytes": (counted.back - back) / LONG,
                    "alone, s": median(alone),
                    "among many, s": wall / LONG,
                    "scheduler, CPU s": scheduling,
                    "POV-Ray, CPU s": povray,
                    "cores that keep the scheduler busy": povray / scheduling,
                }


def main() -> None:
    cores = len(os.sched_getaffinity(0))
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 17
    console = Console(width=None if sys.stdout.isatty() else 120)
    costs = {quality: for_nothing(quality, cores) for quality in ("draft", "standard", "high")}
    table = Table(
        "a frame that costs POV-Ray nothing", *costs, title=f"{speed.machine()}, Dask {distributed.__version__}"
    )
    for name in costs["standard"]:
        table.add_row(
            name, *(f"{cost[name]:.3g}" if cost[name] < 100 else f"{cost[name]:.0f}" for cost in costs.values())
        )
    console.print(table)

    rounds = [(whole_movie(count, 1), whole_movie(count, cores)) for _ in range(ROUNDS)]
    client, encoder = (median(each[1][n] for each in rounds) for n in (1, 2))
    povray = costs["standard"]["POV-Ray, CPU s"]
    found = {
        "1 worker, wall s": median(one[0] for one, _ in rounds),
        f"{cores} workers, wall s": median(more[0] for _, more in rounds),
        "speed-up": median(one[0] / more[0] for one, more in rounds),
        "client, CPU s a frame": client,
        "encoder, CPU s a frame": encoder,
        "cores that keep the client busy": povray / client,
        "cores that keep an encoder of one core busy": povray / encoder,
    }
    table = Table("a movie of quality standard", f"{count} frames")
    for name, value in found.items():
        table.add_row(name, f"{value:.3g}")
    console.print(table)
    figures = {"machine": speed.machine(), "dask": distributed.__version__, "for nothing": costs, "movie": found}
    Path("build/cluster.json").write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
