"""The one place where POV-Ray is started."""

import errno
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
from functools import cache
from pathlib import Path

from povgen import stopping
from povgen.errors import PovrayError, TransientError
from povgen.rendering import sandbox
from povgen.settings import Rendering

SCENE = "scene.pov"
FATAL = "fatal.log"
# POV-Ray takes the stricter of this and the system's own. (Its release 3.7.0.10 obeys the ban on shell-outs but not
# always the one on files: the sandbox does not depend on it.)
CONFIG = """\
[File I/O Security]
restricted
[Shellout Security]
forbidden
[Permitted Paths]
read* = %INSTALLDIR%/include
read+write = .
"""
OLDEST = (3, 7)
TRIES = 2
# What a POV-Ray may take, unless povgen itself may take less.
MEMORY = 8 << 30  # bytes that it may address
LARGEST = 1 << 30  # bytes of a file that it may write
# What it says, or a library for it, where it gets no memory; and where that is the likely reason.
NO_MEMORY = re.compile("out of memory|bad_alloc|cannot allocate memory|failed to map segment", re.IGNORECASE)
UNCLEAR = re.compile("Cannot parse input|Uncategorized error")
CRASHES = (signal.SIGABRT, signal.SIGBUS, signal.SIGSEGV)
# What POV-Ray may read and run, beside its own program, where a system has them.
READ = [Path(base, "povray-3.7") for base in ("/usr/share", "/usr/local/share")]
READ += [Path("/etc/povray"), Path("/usr/local/etc/povray"), Path("/etc/ld.so.cache")]
RUN = [Path("/lib"), Path("/lib64"), Path("/usr/lib"), Path("/usr/lib64"), Path("/usr/local/lib")]


def command(binary: str, rendering: Rendering) -> list[str]:
    """POV-Ray's command line for the scene in its work folder: one thread, no display, messages kept apart."""
    return [
        *(binary, f"+I{SCENE}", f"+O{rendering.file}", *rendering.picture_options),
        # a large picture stays in memory: POV-Ray would swap it to a place outside the sandbox
        *("+WT1", f"+MI{MEMORY >> 20}", "-D", "-P", "-V", "-GA", f"+GF{FATAL}"),
    ]


@cache
def binary(name: str = "povray") -> str:
    """An executable, by default POV-Ray's. Raises PovrayError where there is none."""
    found = shutil.which(name)
    if found is None:
        package = "povray" if name == "povray" else "util-linux"
        what = "POV-Ray is not installed" if name == "povray" else "POV-Ray cannot be started"
        raise PovrayError(f"{what}: no {name!r} on the PATH. On Debian: apt-get install {package}")
    return str(Path(found).absolute())  # it is started in other folders than the current one


def memory() -> int:
    """How many bytes a POV-Ray may address."""
    return min(MEMORY, _own(resource.RLIMIT_AS), _own(resource.RLIMIT_DATA))


def largest() -> int:
    """How many bytes of a file it may write."""
    return min(LARGEST, _own(resource.RLIMIT_FSIZE))


def _own(limit: int) -> int:
    """The limit that povgen itself runs under: it cannot give more than it has."""
    soft, _ = resource.getrlimit(limit)
    return sys.maxsize if soft == resource.RLIM_INFINITY else soft


def _mebibytes(count: int) -> str:
    return f"{count / 2**20:.6g} MiB"


def _limits() -> list[str]:
    """What runs a command so that it ends with the thread that started it, and takes no more than its share."""
    limits = [f"--as={memory()}", f"--fsize={largest()}", "--core=0"]
    return [binary("setpriv"), "--pdeathsig", "KILL", binary("prlimit"), *limits, "--"]


@cache
def version() -> str:
    """POV-Ray's version, such as '3.7.0.10.unofficial'. Raises PovrayError if it is too old or does not say."""
    try:
        # POV-Ray does not end where the current folder has been removed
        process = subprocess.run(
            [binary(), "--version"], cwd="/", capture_output=True, text=True, errors="replace", timeout=60
        )
    except subprocess.TimeoutExpired:
        raise PovrayError(f"{binary()} --version does not end") from None
    found = re.search(r"POV-Ray (\d+)\.(\d+)\S*", process.stdout + process.stderr)
    if found is None:
        raise PovrayError(f"{binary()} does not say which POV-Ray it is; povgen needs 3.7 or newer")
    if (int(found[1]), int(found[2])) < OLDEST:
        raise PovrayError(f"{found[0]} is too old; povgen needs 3.7 or newer")
    return found[0].removeprefix("POV-Ray ")


def run(source: str, rendering: Rendering, folder: Path) -> Path:
    """Render one scene's text, as a Runner of its own."""
    runner = Runner()
    try:
        return runner.run(source, rendering, folder)
    finally:
        runner.stop()


class Runner:
    """Runs the POV-Rays of one render: what stops them stops no other render's."""

    def __init__(self) -> None:
        self._running: set[subprocess.Popen] = set()
        self._stopped = False

    def run(self, source: str, rendering: Rendering, folder: Path) -> Path:
        """Render a scene's text in a work folder of its own; returns the picture in it, which is whole.

        Tries again where POV-Ray was killed, hung or did not get going: the fault may not be the scene's. Raises
        PovrayError if POV-Ray is missing, refuses the scene, fails so each time, or was stopped.
        """
        for attempt in range(1, TRIES + 1):
            try:
                return self._run(source, rendering, folder.resolve() / str(attempt))
            except TransientError as fault:
                if attempt == TRIES:
                    raise TransientError(f"{fault}, {TRIES} times") from None
        raise AssertionError("no tries")

    def stop(self) -> None:
        """End every POV-Ray that runs; none is started from now on."""
        with stopping.lock:
            self._stopped = True
            for process in self._running:
                process.kill()

    def _run(self, source: str, rendering: Rendering, folder: Path) -> Path:
        config = folder / ".povray" / "3.7" / "povray.conf"
        for part in (folder, folder / ".povray", config.parent):
            part.mkdir(exist_ok=True)  # one by one: a work folder that has been removed is not made again
        config.write_text(CONFIG)
        (folder / SCENE).write_text(source)
        # POV-Ray writes every block of pixels there, 20 bytes a pixel, for a render that is to be continued
        (folder / rendering.file).with_suffix(".pov-state").symlink_to(os.devnull)
        limits = _limits()
        programs = [Path(program).resolve() for program in (limits[0], limits[3], binary())]
        status, messages = sandbox.within(
            lambda: self._process([*limits, *command(binary(), rendering)], folder, rendering.timeout),
            read=READ,
            run=[*programs, *RUN],
            write=[folder, Path(os.devnull)],
        )
        if status or not (folder / rendering.file).is_file():
            raise _failure(rendering, folder, status, messages.decode(errors="replace"))
        return folder / rendering.file

    def _process(self, arguments: list[str], folder: Path, timeout: float) -> tuple[int, bytes]:
        """POV-Ray's exit status, below 0 the signal that killed it, and its messages."""
        # POV-Ray looks for its configuration in HOME
        environment = {"HOME": str(folder), "PATH": "/usr/bin:/bin", "LC_ALL": "C", "TMPDIR": str(folder)}
        with stopping.lock:
            self._check()
            process = subprocess.Popen(
                arguments,
                cwd=folder,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
            )
            self._running.add(process)
        try:
            _, messages = process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            raise TransientError(f"POV-Ray took longer than {timeout:g} s (--timeout) and was stopped") from None
        finally:
            process.kill()
            process.wait()
            with stopping.lock:
                self._running.discard(process)
        self._check()
        return process.returncode, messages

    def _check(self) -> None:
        if self._stopped or stopping.asked():
            raise PovrayError("POV-Ray was stopped")


def _failure(rendering: Rendering, folder: Path, status: int, messages: str) -> Exception:
    """Why POV-Ray made no picture: its own message with its line."""
    log = folder / FATAL
    fatal = log.read_text(errors="replace") if log.is_file() else ""
    place = re.match(r"File: (.*?)  Line: (\d+)\n", fatal)
    said = " ".join(fatal[fatal.rindex("Error:") + len("Error:") :].split()) if "Error:" in fatal else ""
    out_of_memory = f"out of memory: it may take {_mebibytes(memory())}"

    def refused(message: str) -> PovrayError:
        error = PovrayError(f"POV-Ray: {place[1]}, line {place[2]}: {message}" if place else f"POV-Ray: {message}")
        error.line = int(place[2]) if place else None
        return error

    if NO_MEMORY.search(said + messages):
        return refused(out_of_memory)
    if status == -signal.SIGXFSZ:
        return PovrayError(f"POV-Ray was stopped: it may write {_mebibytes(largest())} to a file, and wanted more")
    if status < 0:
        perhaps = f", perhaps {out_of_memory}" if -status in CRASHES else ""
        return TransientError(f"POV-Ray was killed by signal {-status}{perhaps}")
    width, height = rendering.size
    # POV-Ray does not say so; other frames that failed may have left room since, for a picture at the most
    if shutil.disk_usage(folder).free < 2**16 + 3 * width * height:
        return OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))
    if place is not None:
        return refused(said or "failed")
    if UNCLEAR.search(messages):  # which has a place but where there is no memory to tell it
        return PovrayError(f"POV-Ray failed, probably {out_of_memory}")
    last = [line.strip() for line in messages.splitlines() if line.strip()][-2:]
    failed = "POV-Ray failed: " + (" ".join(last) or "it left no message")
    # said on a machine that is overloaded
    return (TransientError if "Timed out waiting for worker thread" in failed else PovrayError)(failed)
