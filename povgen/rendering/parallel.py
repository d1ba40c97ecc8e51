"""The number of POV-Rays that run at once, threads that wait for them, and processes that run a module of povgen."""

import os
import pickle
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager, suppress
from numbers import Integral
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from typing import Any, Protocol, TypeVar

from povgen import stopping
from povgen.errors import InputError, TransientError, shown
from povgen.settings import Rendering

# POV-Ray sleeps about 0.65 s during each frame, even if the frame costs nothing. This many keep a core busy.
POVRAYS_PER_CORE = 8

Item = TypeVar("Item")
Result = TypeVar("Result")


class Runner(Protocol):
    """Renders scenes' texts: `povray.Runner` and `gl_runner.Runner` on this machine, `cluster.Cluster` on others."""

    def run(self, source: str, rendering: Rendering, folder: Path) -> Path:
        """Render a scene's text in a work folder and return the picture's path. Raises PovrayError."""

    def stop(self) -> None:
        """End each `run` at once with PovrayError, and start nothing more. Processes on this machine are killed."""


def cores() -> int:
    """Return the number of processor cores that povgen may use."""
    if hasattr(os, "sched_getaffinity"):  # not on macOS
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def cpu_seconds() -> float:
    """Return the CPU seconds so far of this process and of its finished children."""
    return sum(usage.ru_utime + usage.ru_stime for usage in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))


def worker_count(value: object) -> int | None:
    """Return the number of workers that a user gave, or None if the user gave None. Raises InputError."""
    if isinstance(value, Integral) and not isinstance(value, bool):
        value = int(value)  # numpy's
    text = shown(value).strip("'")
    if value is not None and not (re.fullmatch("[0-9]{1,9}", text) and 1 <= int(text) <= 256):
        raise InputError(f"workers = {shown(value)}: allowed: a whole number from 1 to 256")
    return None if value is None else int(text)


def checked_scheduler(value: object) -> str | None:
    """Return the address of a Dask scheduler that a user gave, or None if the user gave None. Raises InputError."""
    address = r"(?:tcp|tls)://(?:[^\s/:\[\]]+|\[[^\s/\[\]]+\]):([0-9]{1,5})"
    found = re.fullmatch(address, value) if isinstance(value, str) else None
    if value is not None and not (found and 0 < int(found[1]) < 2**16):
        raise InputError(f"scheduler = {shown(value)}: allowed: its address, such as tcp://192.0.2.1:8786")
    return None if value is None else str(value)


def default_workers() -> int:
    """Return how many POV-Rays run at once if --workers does not say."""
    return POVRAYS_PER_CORE * cores()


def python(module: str, **environment: str) -> "subprocess.Popen[bytes]":
    """Start a Python process that runs a module of povgen, and return it with a pipe as its standard input.

    Its `stdout` has the process's `stopping.answers`. `environment` are further environment variables. If a signal
    stops povgen, the process is killed.
    """
    folders = [str(Path(__file__).parents[2]), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    path = os.pathsep.join(os.path.abspath(each) for each in folders)  # the process has another working directory
    with stopping.lock:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", module],
            cwd="/",
            env={**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", **environment},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        stopping.processes.add(process)
    return process


def end(process: "subprocess.Popen[bytes]") -> None:
    """End a process that `python` started."""
    process.kill()
    process.wait()
    with stopping.lock:
        stopping.processes.discard(process)


def tried(work: Callable[[], Result], allowed: str = "") -> Result:
    """Return what `work` returns. If it raises TransientError, it is called once more, because chance may be the cause.

    Raises TransientError if that fails too. `allowed` is added to the message.
    """
    with suppress(TransientError):
        return work()
    try:
        return work()
    except TransientError as fault:
        raise TransientError(f"{fault}, 2 times{allowed}") from None


def computed(
    function: Callable[[Item], Result], items: Sequence[Item], count: int, done: Callable[[], object] = lambda: None
) -> dict[int, Result]:
    """Return what a function returns for each item, by the item's number, computed by `count` Python processes.

    `done` is called after each item. Those of a process that fails or does not start are left out.
    """
    found: dict[int, Result] = {}

    def ask(process: Any, numbers: range) -> None:  # noqa: ANN401  (subprocess.Popen)
        with suppress(EOFError, OSError, pickle.UnpicklingError), process.stdout:  # the process has ended
            with process.stdin:
                pickle.dump((function, [items[number] for number in numbers]), process.stdin)
            while process.stdout.readline() not in (stopping.BEGIN, b""):
                pass
            for number in numbers:
                found[number] = pickle.load(process.stdout)
                done()

    with ExitStack() as opened:
        pool = opened.enter_context(ThreadPoolExecutor(count))
        asked = []
        for number in range(count):
            try:
                process = python(__name__)
                opened.callback(end, process)  # before the pool ends: its threads wait for the process
                asked.append(pool.submit(ask, process, range(number, len(items), count)))
            except (OSError, RuntimeError):  # such as the limit of processes, which counts threads too
                break
        wait(asked)
    return found


def main() -> None:
    """Read a pickled function and its items from the standard input. Answer with a pickled result for each item."""
    answers = stopping.answers()
    function, items = pickle.load(sys.stdin.buffer)
    for item in items:
        pickle.dump(function(item), answers.buffer)
        answers.buffer.flush()


@contextmanager
def thread_pool(runner: Runner, workers: int | None = None) -> Iterator[ThreadPoolExecutor]:
    """Yield a pool of threads that call `runner.run`. At the end, cancel what waits and stop what runs."""
    pool = ThreadPoolExecutor(workers or default_workers())
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        runner.stop()
        pool.shutdown()


if __name__ == "__main__":
    main()
