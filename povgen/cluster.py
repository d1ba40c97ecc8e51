"""Other machines: the workers of a Dask scheduler in place of the processes here. The one place that knows Dask.

A scene's text goes out, a PNG's bytes come back: a worker has povgen and POV-Ray, and no file in common with others.
"""

import asyncio
import logging
import re
import warnings
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread

from povgen import __version__, povray
from povgen.errors import ChanceError, InputError, PovrayError
from povgen.output import temporary_folder
from povgen.rendering import Rendering

try:
    import distributed
except ImportError:
    raise InputError(
        "a scheduler is spoken to with Dask, which is not installed: pip install 'povgen[cluster]'"
    ) from None

PATIENCE = 5.0  # seconds until the scheduler answers, and then until it has a worker
LOST = 60.0  # seconds without any worker in mid-movie
# Frames under way for each thread of the workers: one is rendered while the next waits its turn at the scheduler.
AHEAD = 2


class Cluster:
    """A scheduler's workers, to be entered with `with`: each runs POV-Ray in as many threads as it was given.

    Raises InputError for what is no address, PovrayError where no scheduler answers, where it has no workers, or where
    a worker has not the povgen and the POV-Ray that are here: the message names it.
    """

    def __init__(self, scheduler: str):
        if not re.fullmatch(r"(tcp|tls)://[^\s/]+:[0-9]{1,5}", scheduler):
            raise InputError(f"scheduler = {scheduler!r}: allowed: its address, such as tcp://192.0.2.1:8786")
        self._scheduler = scheduler
        self._versions = versions()
        self._waiting: set[distributed.Future] = set()
        self._stopped = Event()
        self._client = _connected(scheduler)
        try:
            self._wait_for_workers(PATIENCE)
            self._check()
            self.frames = AHEAD * sum(self._client.nthreads().values())  # to ask for at once
        except BaseException:
            self.__exit__()
            raise

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        with suppress(Exception), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._client.close(timeout=1)

    def run(self, source: str, rendering: Rendering, folder: Path) -> Path:
        """As povray.Runner.run, on a worker. Where a worker is lost, another does its frame.

        Raises PovrayError, which names the worker where POV-Ray failed; ChanceError where worker after worker was lost.
        """
        try:
            png = self._png(source, rendering)
        except PovrayError:
            raise
        except distributed.scheduler.KilledWorker as lost:
            number, last = lost.allowed_failures + 1, lost.last_worker.address
            raise ChanceError(f"workers lost while they rendered it: {number}, the last {last}") from None
        except (distributed.CancelledError, OSError):
            gone = f"scheduler {self._scheduler}: the connection was lost"
            raise PovrayError("POV-Ray was stopped" if self._stopped.is_set() else gone) from None
        except Exception as error:
            raise PovrayError(f"scheduler {self._scheduler}: {_line(error)}") from None
        picture = folder / rendering.file
        picture.write_bytes(png)
        return picture

    def stop(self) -> None:
        """Cancel every frame that is waited for. A POV-Ray that runs on a worker ends with its frame."""
        self._stopped.set()
        with suppress(Exception):
            self._client.cancel(list(self._waiting))

    def _png(self, source: str, rendering: Rendering) -> bytes:
        future = self._client.submit(frame, self._versions, source, rendering, pure=False)
        self._waiting.add(future)
        if self._stopped.is_set():
            future.cancel()
        try:
            while True:
                with suppress(TimeoutError):
                    return future.result(LOST)
                self._wait_for_workers(LOST)
        finally:
            self._waiting.discard(future)

    def _wait_for_workers(self, seconds: float) -> None:
        try:
            self._client.wait_for_workers(1, timeout=seconds)
        except TimeoutError:
            raise PovrayError(f"scheduler {self._scheduler}: it has no workers") from None

    def _check(self) -> None:
        told = self._client.run(check, self._versions, on_error="return")
        faults = [(worker, fault) for worker, fault in sorted(told.items()) if fault is not None]
        if faults:
            worker, fault = faults[0]
            others = f" ({len(faults)} of {len(told)} workers cannot be used)" if len(faults) > 1 else ""
            raise PovrayError(f"worker {worker}: {_line(fault)}{others}")


def versions() -> str:
    """What must be the same everywhere, so that frames look alike and all understand each other."""
    return f"povgen {__version__}, POV-Ray {povray.version()}, Dask {distributed.__version__}"


def check(wanted: str) -> None:
    """Raises PovrayError on a worker that has other versions than those wanted."""
    own = versions()
    if own != wanted:
        raise PovrayError(f"it has {own}; wanted, as here: {wanted}")


def frame(wanted: str, source: str, rendering: Rendering) -> bytes:
    """A scene's picture as a PNG file's bytes, made on a worker. Raises PovrayError, which names the worker."""
    try:
        check(wanted)  # it may have come after the others were asked
        with temporary_folder() as folder:
            return povray.run(source, rendering, folder).read_bytes()
    except (PovrayError, OSError) as error:
        kind = type(error) if isinstance(error, PovrayError) else PovrayError
        raise kind(f"worker {distributed.get_worker().address}: {error}") from None


def _connected(scheduler: str) -> distributed.Client:
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)  # povgen says what went wrong
    answers: list[object] = []

    async def ask() -> str:
        arguments = distributed.Security().get_connection_args("client")
        async with distributed.rpc(scheduler, timeout=PATIENCE, connection_args=arguments) as there:
            return (await there.versions())["packages"]["distributed"]

    def asked() -> None:
        try:
            answers.append(asyncio.run(asyncio.wait_for(ask(), PATIENCE)))
        except Exception as error:
            answers.append(error)

    # Dask's client would wait for ever for a server that accepts connections and says nothing. In a thread, for here
    # may be a notebook, whose event loop runs already.
    thread = Thread(target=asked, daemon=True)
    thread.start()
    thread.join()
    (answer,) = answers
    if isinstance(answer, Exception):
        raise PovrayError(f"scheduler {scheduler}: no Dask scheduler answers ({_line(answer)})")
    if answer != distributed.__version__:
        raise PovrayError(f"scheduler {scheduler}: it has Dask {answer}; wanted, as here: {distributed.__version__}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of other versions of other packages there
        return distributed.Client(scheduler, timeout=PATIENCE, set_as_default=False)


def _line(error: BaseException) -> str:
    return str(error).partition("\n")[0] or type(error).__name__
