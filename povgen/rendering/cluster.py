"""Rendering on other machines, by the workers of a Dask scheduler. No other module uses Dask.

A worker gets a scene's text and the pictures that the text names. It returns the bytes of a PNG file or of a frame of
light. It needs povgen, Dask and no shared files. To render, it also needs POV-Ray, or for the renderer gl the same
drawing device as this machine.
"""

import asyncio
import concurrent.futures
import logging
import socket
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import urlsplit

from povgen import remedies
from povgen.errors import InputError, PovrayError, TransientError
from povgen.files import temporary_folder
from povgen.inputs import pictures
from povgen.rendering import gl_runner, povray
from povgen.rendering.frames import drawn_by
from povgen.settings import Rendering
from povgen.version import __version__

try:
    import distributed
except ImportError:
    raise InputError(f"--scheduler needs Dask, which is not installed: {remedies.extra('cluster')}") from None

Result = TypeVar("Result")

PATIENCE = 5.0  # seconds to wait for the scheduler's answer, and then again for its first worker
POLL = 0.5  # seconds after which `stop` is noticed
AHEAD = 2  # frames sent out for each thread of the workers: one is rendered while the next waits at the scheduler


class Cluster:
    """The workers of a scheduler, as a context manager. Each worker renders one frame in each of its threads.

    Dask removes a worker that is lost, and other workers render its frames.

    `scheduler` is an address as `checked_scheduler` returns it. `renderer` is what the workers need: povray, gl, or
    None. `frames` is the number of frames to be sent out at once. Raises PovrayError if no scheduler answers, if it has
    no workers, or if a worker has another version of povgen, of the renderer or of Dask than this machine. The message
    names that worker. Raises also what `versions` raises.
    """

    def __init__(self, scheduler: str, renderer: str | None = "povray") -> None:
        self._renderer = renderer
        self._scheduler = scheduler
        self._versions = versions(renderer)
        self._stopped = False
        self._client: Any = _connected(scheduler)  # Dask's types do not cover what is used here
        try:
            with suppress(TimeoutError):
                self._client.wait_for_workers(1, timeout=PATIENCE)
            threads = sum(self._client.nthreads().values())
            if not threads:
                raise PovrayError(f"scheduler {scheduler}: it has no workers")
            self.frames = AHEAD * threads  # to be sent out at once
            self._check()
        except BaseException:
            self.__exit__()
            raise

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        # of any kind: the scheduler may have gone, and the frames are finished or given up
        with suppress(Exception), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._client.close(timeout=1)

    def run(self, source: str, rendering: Rendering, folder: Path) -> Path:
        """Do what a renderer's Runner.run does, on a worker. If that worker is lost, another renders the frame.

        Raises PovrayError, which names the worker if POV-Ray failed there, and TransientError if several workers were
        lost.
        """
        picture = folder / rendering.file
        picture.write_bytes(self.call(render, source, rendering, pictures.used(source)))
        return picture

    def call(self, function: Callable[..., Result], *arguments: object) -> Result:
        """Return what a function of povgen returns on a worker.

        If that worker is lost, another one calls it. Raises as `run`.
        """
        future = self._client.submit(call, self._versions, self._renderer, function, *arguments, pure=False)

        async def result() -> Result:
            found: Result = await future
            return found

        # future.result(timeout) would, at its end, also end the transfer of all results that are on their way together
        waiting = asyncio.run_coroutine_threadsafe(result(), self._client.loop.asyncio_loop)
        try:
            while not self._stopped:
                if concurrent.futures.wait([waiting], POLL).done:
                    return waiting.result()
            raise PovrayError("the work was stopped")
        except PovrayError:
            raise
        except distributed.scheduler.KilledWorker as lost:
            number, last = lost.allowed_failures + 1, lost.last_worker.address
            raise TransientError(f"workers lost while they computed it: {number}, the last {last}") from None
        except (distributed.CancelledError, OSError):
            raise PovrayError(f"scheduler {self._scheduler}: the connection was lost") from None
        except Exception as error:
            raise PovrayError(f"scheduler {self._scheduler}: {_first_line(error)}") from None
        finally:
            waiting.cancel()
            future.release()

    def stop(self) -> None:
        """Wait for no more frames. A POV-Ray that runs on a worker finishes its frame."""
        self._stopped = True

    def _check(self) -> None:
        """Raise PovrayError if a worker has other versions than this machine."""
        answers = self._client.run(check, self._versions, self._renderer, on_error="return")
        if faults := [(name, fault) for name, fault in sorted(answers.items()) if fault]:
            worker, fault = faults[0]
            others = f" ({len(faults)} of {len(answers)} workers cannot be used)" if len(faults) > 1 else ""
            raise PovrayError(f"worker {worker}: {_first_line(fault)}{others}")


def versions(renderer: str | None) -> str:
    """Return as text what all machines must have in common: povgen's and Dask's version, and what renders.

    What renders is POV-Ray's version for povray, the drawing device for gl, and left out for None. Raises PovrayError
    or InputError if this machine lacks the renderer.
    """
    drawn = f"{drawn_by(renderer)}, " if renderer else ""
    return f"povgen {__version__}, {drawn}Dask {distributed.__version__}"


def check(wanted: str, renderer: str | None) -> None:
    """Check a worker, on that worker. Raises PovrayError if it has other versions than wanted."""
    own = versions(renderer)
    if own != wanted:
        raise PovrayError(f"it has {own}; wanted, as on this machine: {wanted}")


def render(source: str, rendering: Rendering, shown: dict[str, bytes]) -> bytes:
    """Render a scene's text, on a worker, and return the bytes of its PNG file, or of a frame of light.

    `shown` are the pictures that the text names, by their names.
    """
    files = [pictures.kept(name, content) for name, content in shown.items()]
    with temporary_folder() as folder:
        if rendering.renderer == "gl":
            picture = gl_runner.Runner().run(source, rendering, folder).read_bytes()
        else:  # a worker renders in each of its threads
            at_once = distributed.get_worker().state.nthreads
            picture = povray.run(source, rendering, folder, at_once).read_bytes()
    del files  # `run` needs them until here
    return picture


def call(wanted: str, renderer: str | None, function: Callable[..., Result], *arguments: object) -> Result:
    """Call a function, on a worker, and return what it returns. Raises PovrayError, which names the worker."""
    try:
        # this worker may have joined after the others were checked
        check(wanted, renderer)
        return function(*arguments)
    except Exception as error:  # of any kind: this worker's code may be another
        kind = type(error) if isinstance(error, PovrayError) else PovrayError
        what = str(error) if isinstance(error, (InputError, PovrayError, OSError)) else repr(error)
        named = kind(f"worker {distributed.get_worker().address}: {what}")
        named.line = getattr(error, "line", None)
        raise named from None


def ask(scheduler: str) -> None:
    """Raise PovrayError if no scheduler with this Dask's version answers."""
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)  # povgen says what went wrong

    async def version() -> str:
        arguments = distributed.Security().get_connection_args("client")
        async with distributed.rpc(scheduler, timeout=PATIENCE, connection_args=arguments) as there:
            return str((await there.versions())["packages"]["distributed"])

    # asyncio.run is called in a new thread: in a notebook, an event loop already runs in the calling thread
    try:
        with concurrent.futures.ThreadPoolExecutor(1) as thread:
            there = thread.submit(asyncio.run, asyncio.wait_for(version(), PATIENCE)).result()
    except Exception as error:
        raise PovrayError(f"scheduler {scheduler}: no Dask scheduler answers ({_cause(scheduler, error)})") from None
    if there != (here := distributed.__version__):
        raise PovrayError(f"scheduler {scheduler}: it has Dask {there}; wanted, as on this machine: {here}")


def _connected(scheduler: str) -> distributed.Client:
    """Return a client of the scheduler. Raises PovrayError if no scheduler with this Dask's version answers."""
    ask(scheduler)  # Dask's client would wait for ever if a server accepts the connection and does not answer
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about other versions of other packages
        try:
            return distributed.Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except OSError as error:
            raise PovrayError(f"scheduler {scheduler}: {_first_line(error)}") from None


def _cause(scheduler: str, error: BaseException) -> str:
    """Return why no scheduler answers: what the system says of its address, or otherwise what Dask says."""
    try:
        address = urlsplit(scheduler)
        socket.create_connection((address.hostname, address.port or 0), PATIENCE).close()
    except OSError as refused:
        return refused.strerror or str(refused)
    except ValueError:  # no address can be like this
        pass
    return _first_line(error)


def _first_line(error: BaseException) -> str:
    return str(error).partition("\n")[0] or type(error).__name__
