"""Other machines: the workers of a Dask scheduler in place of the processes here. The one place that knows Dask.

A scene's text goes out, a PNG's bytes come back: a worker has povgen and POV-Ray, and no file in common with others.
"""

import asyncio
import concurrent.futures
import logging
import re
import warnings
from collections.abc import Coroutine
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

from povgen import __version__
from povgen.errors import InputError, PovrayError, TransientError
from povgen.files import temporary_folder
from povgen.rendering import povray
from povgen.settings import Rendering

try:
    import distributed
except ImportError:
    raise InputError(
        "a scheduler is spoken to with Dask, which is not installed: pip install 'povgen[cluster]'"
    ) from None

PATIENCE = 5.0  # seconds until the scheduler answers, and then until it has a worker
PULSE = 5.0  # seconds from one question to the scheduler, whether all is well, to the next
SILENT = 5  # such questions in succession without news: the scheduler, or the worker, is given up
# Frames under way for each thread of the workers: one is rendered while the next waits its turn at the scheduler.
AHEAD = 2


class Cluster:
    """A scheduler's workers, to be entered with `with`: each runs POV-Ray in as many threads as it was given.

    A worker of which the scheduler hears nothing any more is dismissed, and the others render its frames.

    Raises InputError for what is no address, PovrayError where no scheduler answers, where it has no workers, or where
    a worker has not the povgen and the POV-Ray that are here: the message names it.
    """

    def __init__(self, scheduler: str):
        if not re.fullmatch(r"(tcp|tls)://[^\s/]+:[0-9]{1,5}", scheduler):
            raise InputError(f"scheduler = {scheduler!r}: allowed: its address, such as tcp://192.0.2.1:8786")
        self._scheduler = scheduler
        self._no_workers = f"scheduler {scheduler}: it has no workers"
        self._versions = versions()
        self._over: concurrent.futures.Future[str] = concurrent.futures.Future()  # why nothing is waited for any more
        self._dismissed: set[str] = set()
        self._client = _connected(scheduler)
        self._watching = self._start(self._watch())
        try:
            self.frames = AHEAD * self._result(self._threads())  # to ask for at once
            self._check()
        except BaseException:
            self.__exit__()
            raise

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        self._watching.cancel()
        with suppress(Exception), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._client.close(timeout=1)

    def run(self, source: str, rendering: Rendering, folder: Path) -> Path:
        """As povray.Runner.run, on a worker. Where a worker is lost, another does its frame.

        Raises PovrayError, which names the worker where POV-Ray failed; TransientError where several workers were lost.
        """
        future = self._client.submit(frame, self._versions, source, rendering, pure=False)
        try:
            png = self._result(self._client.gather(future, asynchronous=True))
        except PovrayError:
            raise
        except distributed.scheduler.KilledWorker as lost:
            number, last = lost.allowed_failures + 1, lost.last_worker.address
            raise TransientError(f"workers lost while they rendered it: {number}, the last {last}") from None
        except Exception as error:
            raise PovrayError(f"scheduler {self._scheduler}: {_line(error)}") from None
        finally:
            future.release()
        picture = folder / rendering.file
        picture.write_bytes(png)
        return picture

    def stop(self) -> None:
        """Wait for no frame any more. A POV-Ray that runs on a worker ends with its frame."""
        self._end("POV-Ray was stopped")

    def _end(self, why: str) -> None:
        with suppress(concurrent.futures.InvalidStateError):  # it has ended before
            self._over.set_result(why)

    def _start(self, coroutine: Coroutine) -> concurrent.futures.Future:
        loop: Any = self._client.loop  # tornado's, around asyncio's
        return asyncio.run_coroutine_threadsafe(coroutine, loop.asyncio_loop)

    def _result(self, coroutine: Coroutine) -> Any:
        """What the coroutine returns. Raises PovrayError, which tells why, where all ends before that."""
        result = self._start(coroutine)
        concurrent.futures.wait([result, self._over], return_when=concurrent.futures.FIRST_COMPLETED)
        if not result.done():
            raise PovrayError(self._over.result())
        try:
            return result.result()
        except (concurrent.futures.CancelledError, distributed.CancelledError, OSError):
            raise PovrayError(f"scheduler {self._scheduler}: the connection was lost") from None

    async def _watch(self) -> None:
        """Ask the scheduler again and again which workers it has heard of; give up what is silent for too long."""
        unanswered = alone = 0  # questions in succession, without an answer, and without news of any worker
        heard: dict[str, float] = {}  # when the scheduler heard of each worker, by its own clock
        silent: dict[str, int] = {}  # answers in succession without news of each worker
        while True:
            pause = asyncio.create_task(asyncio.sleep(PULSE))
            try:
                now = {name: worker["last_seen"] for name, worker in (await self._workers(PULSE)).items()}
                silent = {name: silent[name] + 1 if heard.get(name) == seen else 0 for name, seen in now.items()}
                heard, unanswered, alone = now, 0, 0 if 0 in silent.values() else alone + 1
                for name in [name for name, times in silent.items() if times >= SILENT]:
                    await self._dismiss(name)
            except Exception:  # whatever it is: the scheduler does not answer as it should
                unanswered += 1
            if unanswered == SILENT:
                return self._end(f"scheduler {self._scheduler}: it has not answered for {SILENT * PULSE:g} s")
            if alone == SILENT:
                return self._end(self._no_workers)
            await pause

    async def _workers(self, seconds: float) -> dict[str, dict[str, Any]]:
        """What the scheduler knows of its workers, by their addresses. Raises TimeoutError."""
        return (await asyncio.wait_for(self._client.scheduler.identity(), seconds))["workers"]

    async def _dismiss(self, worker: str) -> None:
        """Have the scheduler forget a worker, as Dask does itself after its worker-ttl: others get its frames."""
        if worker not in self._dismissed:
            self._dismissed.add(worker)
            silence = f"worker {worker}: nothing was heard of it for {SILENT * PULSE:g} s"
            logging.getLogger("povgen").warning(f"povgen: warning: {silence}; it is dismissed, others do its frames")
        forgotten = self._client.scheduler.unregister(address=worker, stimulus_id="povgen")
        await asyncio.wait_for(forgotten, PULSE)

    async def _threads(self) -> int:
        """How many threads the workers have, as soon as there is a worker."""
        try:
            async with asyncio.timeout(PATIENCE):
                while not (workers := await self._workers(PATIENCE)):
                    await asyncio.sleep(0.1)
        except TimeoutError:
            raise PovrayError(self._no_workers) from None
        return sum(worker["nthreads"] for worker in workers.values())

    def _check(self) -> None:
        told = self._result(self._client.run(check, self._versions, on_error="return", asynchronous=True))
        faults = [(worker, told[worker]) for worker in sorted(told) if told[worker] and worker not in self._dismissed]
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
        named = kind(f"worker {distributed.get_worker().address}: {error}")
        named.line = getattr(error, "line", None)
        raise named from None


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
        try:
            return distributed.Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except OSError as error:
            raise PovrayError(f"scheduler {scheduler}: {_line(error)}") from None


def _line(error: BaseException) -> str:
    return str(error).partition("\n")[0] or type(error).__name__
