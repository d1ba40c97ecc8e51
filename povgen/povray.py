"""The one place where POV-Ray is started."""

import errno
import os
import re
import shutil
import signal
import subprocess
from functools import cache
from pathlib import Path
from threading import RLock

from povgen import fence
from povgen.errors import ChanceError, PovrayError
from povgen.rendering import Rendering
from povgen.source import template_of

SCENE = "scene.pov"
FATAL = "fatal.log"
# POV-Ray takes the stricter of this and the system's own. (Its release 3.7.0.10 obeys the ban on shell-outs but not
# always the one on files: the fence does not depend on it.)
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
MEMORY = 8 << 30  # bytes that a POV-Ray may address
LARGEST = 1 << 30  # bytes of a file that it may write
# What POV-Ray may read and run, beside its own program, where a system has them.
READ = [Path(base, "povray-3.7") for base in ("/usr/share", "/usr/local/share")]
READ += [Path("/etc/povray"), Path("/usr/local/etc/povray"), Path("/etc/ld.so.cache")]
RUN = [Path("/lib"), Path("/lib64"), Path("/usr/lib"), Path("/usr/lib64"), Path("/usr/local/lib")]

_running: set[subprocess.Popen] = set()
_lock = RLock()  # a signal's handler may call stop() anywhere


def command(binary: str, rendering: Rendering) -> list[str]:
    """POV-Ray's command line for the scene in its work folder: one thread, no display, messages kept apart."""
    return [
        *(binary, f"+I{SCENE}", f"+O{rendering.file}", *rendering.picture_options),
        # a large picture stays in memory: POV-Ray would swap it to a place outside the fence
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


def _limits() -> list[str]:
    """What runs a command so that it ends with the thread that started it, and takes no more than its share."""
    limits = [f"--as={MEMORY}", f"--fsize={LARGEST}", "--core=0"]
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
    """Render a scene's text in a work folder of its own; returns the picture in it, which is whole.

    Tries again where POV-Ray was killed, hung or did not get going: the fault may not be the scene's. Raises
    PovrayError if POV-Ray is missing, refuses the scene, or fails so each time.
    """
    for attempt in range(1, TRIES + 1):
        try:
            return _run(source, rendering, folder.resolve() / str(attempt))
        except ChanceError as fault:
            if attempt == TRIES:
                raise ChanceError(f"{fault}, {TRIES} times") from None
    raise AssertionError("no tries")


def _run(source: str, rendering: Rendering, folder: Path) -> Path:
    config = folder / ".povray" / "3.7" / "povray.conf"
    config.parent.mkdir(parents=True)
    config.write_text(CONFIG)
    (folder / SCENE).write_text(source)
    limits = _limits()
    programs = [Path(program).resolve() for program in (limits[0], limits[3], binary())]
    status, messages = fence.within(
        lambda: _process([*limits, *command(binary(), rendering)], folder, rendering.timeout),
        read=READ,
        run=[*programs, *RUN],
        write=[folder, Path(os.devnull)],
    )
    if status == -signal.SIGXFSZ:
        raise PovrayError(f"POV-Ray was stopped: it may write {LARGEST >> 20} MiB to a file, and wanted more")
    if status < 0:
        raise ChanceError(f"POV-Ray was killed by signal {-status}")
    if status or not (folder / rendering.file).is_file():
        width, height = rendering.size
        # POV-Ray does not say so; other frames that failed may have left room since, for a picture at the most
        if shutil.disk_usage(folder).free < 2**16 + 3 * width * height:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))
        failure = _failure(source, folder, messages.decode(errors="replace"))
        # said on a machine that is overloaded
        raise (ChanceError if "Timed out waiting for worker thread" in failure else PovrayError)(failure)
    return folder / rendering.file


def _process(arguments: list[str], folder: Path, timeout: float) -> tuple[int, bytes]:
    """POV-Ray's exit status, below 0 the signal that killed it, and its messages."""
    # POV-Ray looks for its configuration in HOME
    environment = {"HOME": str(folder), "PATH": "/usr/bin:/bin", "LC_ALL": "C", "TMPDIR": str(folder)}
    with _lock:
        process = subprocess.Popen(
            arguments,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        _running.add(process)
    try:
        _, messages = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        raise ChanceError(f"POV-Ray took longer than {timeout:g} s (--timeout) and was stopped") from None
    finally:
        process.kill()
        process.wait()
        with _lock:
            stopped = process not in _running
            _running.discard(process)
    if stopped:
        raise PovrayError("POV-Ray was stopped")
    return process.returncode, messages


def stop() -> None:
    """End every POV-Ray that runs."""
    with _lock:
        for process in _running:
            process.kill()
        _running.clear()


def _failure(source: str, folder: Path, messages: str) -> str:
    """POV-Ray's own message with its line and the template that the line came from."""
    log = folder / FATAL
    fatal = log.read_text(errors="replace") if log.is_file() else ""
    place = re.match(r"File: (.*?)  Line: (\d+)\n", fatal)
    memory = f"out of memory: it may take {MEMORY >> 20} MiB"
    if place is None:
        if "Cannot parse input" in messages:  # which has a place but where there is no memory to tell it
            return f"POV-Ray failed, probably {memory}"
        last = [line.strip() for line in messages.splitlines() if line.strip()][-2:]
        return "POV-Ray failed: " + (" ".join(last) or "it left no message")
    line = int(place[2])
    message = " ".join(fatal[fatal.rindex("Error:") + len("Error:") :].split()) if "Error:" in fatal else "failed"
    if message == "std::bad_alloc":
        message = memory
    return f"POV-Ray: {place[1]}, line {line} (from {template_of(source, line)}): {message}"
