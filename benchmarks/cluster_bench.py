"""How many worker cores one client can supply on a Dask cluster, as a table and as JSON: `make cluster-bench`.

Scheduler, client and workers run on this machine. Each worker runs on one core only, as if it were a machine of one
core. CPU seconds are what the operating system reports of a process.
"""

import json
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from statistics import median
from unittest.mock import patch

import distributed
from rich.console import Console
from rich.table import Table

from povgen import MovieSpec, Rendering, movie, to_pov
from povgen.files import temporary_folder
from povgen.measure import speed
from povgen.rendering import parallel
from povgen.scene import survey
from povgen.settings import of_movie

DASK = Path(sys.executable).with_name("dask")
THREADS = parallel.POVRAYS_PER_CORE
ROUNDS = 3


def spec(count: int) -> MovieSpec:
    """Return the paper's first movie, through prisms, with `count` different frames."""
    return MovieSpec.load("vary-alpha").model_copy(update={"frames": count, "hold": 0})


@contextmanager
def started(*command: object, core: int | None = None) -> Iterator[None]:
    hold = [] if core is None else ["taskset", "--cpu-list", str(core)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([*hold, DASK, *map(str, command), "--no-dashboard"], **quiet)
    try:
        yield
    finally:
        process.kill()
        process.wait()


@contextmanager
def running(workers: int) -> Iterator[str]:
    """Start a cluster, and yield its address."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    with ExitStack() as stack:
        local = ("--host", "127.0.0.1")
        stack.enter_context(started("scheduler", *local, "--port", address.rpartition(":")[2]))
        for core in sorted(os.sched_getaffinity(0))[:workers]:
            worker = ("worker", address, *local, "--no-nanny", "--nthreads", THREADS)
            stack.enter_context(started(*worker, core=core))
        with distributed.Client(address, timeout=60, set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=60)
        yield address


def own_cpu(who: int) -> float:
    usage = getrusage(who)
    return usage.ru_utime + usage.ru_stime


def own_seconds(count: int, workers: int) -> tuple[float, float]:
    """Return the CPU seconds of client and encoder for each frame of a movie."""
    with (
        temporary_folder() as folder,
        patch.dict(os.environ, POVGEN_CACHE=str(folder / "cache")),
        running(workers) as address,
    ):
        movie(spec(2), folder / "first.mp4", scheduler=address, quality="draft")  # workers import their modules
        survey.known.clear()  # forget the first movie's ray traces of these scenes
        client, encoder = own_cpu(RUSAGE_SELF), own_cpu(RUSAGE_CHILDREN)
        movie(spec(count), folder / "movie.mp4", scheduler=address)
        return (own_cpu(RUSAGE_SELF) - client) / count, (own_cpu(RUSAGE_CHILDREN) - encoder) / count


def povray_cpu(quality: str) -> float:
    """Return POV-Ray's CPU seconds for a frame of the movie: the median of five."""
    rendering = Rendering(**of_movie({"quality": quality}))
    texts = [to_pov(scene) for scene in spec(5).scenes("standard")]
    return median(speed.sample(text, rendering.sampling, rendering.size)[0] for text in texts)


def main() -> None:
    cores = len(os.sched_getaffinity(0))
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 65
    costs = {quality: povray_cpu(quality) for quality in ("standard", "high")}
    client, encoder = (median(each) for each in zip(*(own_seconds(count, cores) for _ in range(ROUNDS)), strict=True))
    found = {f"POV-Ray, {quality}, CPU s a frame": seconds for quality, seconds in costs.items()} | {
        "client, CPU s a frame": client,
        "encoder, CPU s a frame": encoder,
        "worker cores that one client can supply": costs["standard"] / client,
        "worker cores that an encoder on one core can serve": costs["standard"] / encoder,
    }
    title = f"{speed.machine()}, Dask {distributed.__version__}"
    table = Table("a movie, quality standard if not stated", f"{count} frames", title=title)
    for name, value in found.items():
        table.add_row(name, f"{value:.3g}")
    Console(width=None if sys.stdout.isatty() else 120).print(table)
    figures = {"machine": speed.machine(), "dask": distributed.__version__, "movie": found}
    Path("build/cluster.json").write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
