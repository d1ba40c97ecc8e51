"""The one place where POV-Ray is started."""

import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from threading import Lock

from povgen.errors import PovrayError
from povgen.rendering import Rendering
from povgen.source import template_of

SCENE = "scene.pov"
FATAL = "fatal.log"
# POV-Ray takes the stricter of this and the system's own. (Its release 3.7.0.10 obeys the ban on shell-outs but not
# always the one on files: what keeps a scene harmless is that only checked numbers and names get into it.)
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

_running: set[subprocess.Popen] = set()
_lock = Lock()


def command(binary: str, rendering: Rendering) -> list[str]:
    """POV-Ray's command line for the scene in its work folder: one thread, no display, messages kept apart."""
    width, height = rendering.size
    if rendering.antialias is None:
        sampling = ["-A"]
    else:
        method, threshold, depth = rendering.antialias
        # without jitter the same scene gives the same pixels
        sampling = [f"+AM{method}", f"+A{threshold:g}", f"+R{depth}", "-J"]
    return [
        *(binary, f"+I{SCENE}", f"+O{rendering.file}", *rendering.format, f"+W{width}", f"+H{height}", *sampling),
        *("+WT1", "-D", "-P", "-V", "-GA", f"+GF{FATAL}"),
    ]


@cache
def binary() -> str:
    """POV-Ray's executable. Raises PovrayError where there is none."""
    found = shutil.which("povray")
    if found is None:
        raise PovrayError("POV-Ray is not installed: no 'povray' on the PATH. On Debian: apt-get install povray")
    return found


@cache
def version() -> str:
    """POV-Ray's version, such as '3.7.0.10.unofficial'. Raises PovrayError if it is too old or does not say."""
    try:
        process = subprocess.run([binary(), "--version"], capture_output=True, text=True, errors="replace", timeout=60)
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
        except _Chance as fault:
            if attempt == TRIES:
                raise PovrayError(f"{fault}, {TRIES} times") from None
    raise AssertionError


class _Chance(PovrayError):
    """A fault that may not come again."""


def _run(source: str, rendering: Rendering, folder: Path) -> Path:
    config = folder / ".povray" / "3.7" / "povray.conf"
    config.parent.mkdir(parents=True)
    config.write_text(CONFIG)
    (folder / SCENE).write_text(source)
    # POV-Ray looks for its configuration in HOME
    environment = {"HOME": str(folder), "PATH": "/usr/bin:/bin", "LC_ALL": "C"}
    with _lock:
        process = subprocess.Popen(
            command(binary(), rendering),
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        _running.add(process)
    try:
        _, messages = process.communicate(timeout=rendering.timeout)
    except subprocess.TimeoutExpired:
        raise _Chance(f"POV-Ray took longer than {rendering.timeout:g} s (--timeout) and was stopped") from None
    finally:
        process.kill()
        process.wait()
        with _lock:
            stopped = process not in _running
            _running.discard(process)
    if stopped:
        raise PovrayError("POV-Ray was stopped")
    if process.returncode < 0:
        raise _Chance(f"POV-Ray was killed by signal {-process.returncode}")
    if process.returncode or not (folder / rendering.file).is_file():
        failure = _failure(source, folder, messages.decode(errors="replace"))
        # said on a machine that is overloaded
        raise (_Chance if "Timed out waiting for worker thread" in failure else PovrayError)(failure)
    return folder / rendering.file


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
    if place is None:
        last = [line.strip() for line in messages.splitlines() if line.strip()][-2:]
        return "POV-Ray failed: " + (" ".join(last) or "it left no message")
    line = int(place[2])
    message = " ".join(fatal[fatal.rindex("Error:") + len("Error:") :].split()) if "Error:" in fatal else "failed"
    return f"POV-Ray: {place[1]}, line {line} (from {template_of(source, line)}): {message}"
