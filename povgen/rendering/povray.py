"""Starting POV-Ray: the command line, the files that POV-Ray is allowed to use, limits of memory and time, and errors.

No other module starts POV-Ray. sandbox.py enforces which files POV-Ray reads, writes and runs.
"""

import errno
import logging
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from itertools import count
from pathlib import Path
from threading import Thread
from typing import IO, NamedTuple

import numpy as np
import platformdirs

from povgen import files, remedies, stopping
from povgen.errors import PovrayError, TransientError, one_line, shown
from povgen.inputs import pictures
from povgen.inputs.pieces import PieceFile
from povgen.rendering import light, sandbox
from povgen.rendering.parallel import tried
from povgen.scene import traced_rays
from povgen.scene.sdl import origin_of
from povgen.settings import Rendering

SCENE = "scene.pov"
FATAL = "fatal.log"
DATA = "data.txt"  # for what a scene writes; besides, the sandbox allows only the files of its render
# If the system's configuration is stricter than this one, POV-Ray obeys the system's. Release 3.7.0.10 obeys the ban on
# shell commands, but not always the restrictions on files. Therefore POV-Ray also runs in a sandbox.
CONFIG = """\
[File I/O Security]
restricted
[Shellout Security]
forbidden
[Permitted Paths]
read* = %INSTALLDIR%/include
read* = /usr/share/fonts
read+write = .
"""
OLDEST = (3, 7)
# Limits for one POV-Ray process. If povgen's own limits (ulimit) are lower, they apply.
MAX_MEMORY = 8 << 30  # bytes of address space
# POV-Ray processes that run at once share this machine's memory. Each gets at least these bytes: for itself, for each
# pixel, and for each picture of sky or floor. Measured: two sheets of 3000 prisms need 160 MiB, a picture of 1920x1080
# at antialias = 2x 384 MiB, one of 7680x4320 1 GiB, and with a sky of light of 8192x4096 pixels up to 1 GiB.
LEAST_MEMORY, PIXEL_MEMORY, PICTURE_MEMORY = 256 << 20, 32, 768 << 20
THREAD_MEMORY = 1 << 27  # bytes of address space for each thread: its stack, and what malloc reserves for it
MAX_FILE = 1 << 30  # bytes in each file that it writes
MAX_MESSAGES = 1 << 16  # bytes of its messages that are read
# Messages of POV-Ray and its libraries when memory is exhausted, and messages that probably have this cause.
NO_MEMORY = re.compile("out of memory|bad_alloc|cannot allocate memory|failed to map segment", re.IGNORECASE)
UNCLEAR = re.compile("Cannot parse input|Uncategorized error")
# A piece from a user's file can use these. Then a pixel depends on the pixels that its thread rendered before: crand
# (also in stones1.inc) and media take random numbers, and evaluate (also in Supertorus of shapes.inc) changes an
# isosurface's gradient.
ORDER_MATTERS = re.compile(r"\b(crand|evaluate|media|Supertorus|stones1?\.inc)\b")
MISSING = re.compile("File '(.*?)' line ([0-9]+): Possible Parse Error: Cannot find file '(.*?)', even after trying")
RENDERED = re.compile(rb"\rRendered (\d+) of ([1-9]\d*) pixels \(\d+%\)")  # what it says with +V
CRASHES = (signal.SIGABRT, signal.SIGBUS, signal.SIGSEGV)
# What POV-Ray is allowed to read, where it exists, besides its work folder, its own program and its libraries.
READ = [Path(base, "povray-3.7") for base in ("/usr/share", "/usr/local/share")]
READ += [Path("/etc/povray"), Path("/usr/local/etc/povray"), Path("/etc/ld.so.cache")]
READ += [Path("/usr/share/fonts")]  # for text; on Debian, also POV-Ray's own fonts are there
READABLE = "allowed: the fonts and pictures of POV-Ray's package, fonts by their path in /usr/share/fonts, files in "
# the folders of the system's libraries, where ldd does not say which of them POV-Ray loads
RUN = [Path("/lib"), Path("/lib64"), Path("/usr/lib"), Path("/usr/lib64"), Path("/usr/local/lib")]


def library() -> Path:
    """Return the folder of the user's own fonts and pictures, which the text of a piece can name. It can be missing."""
    with suppress(RuntimeError):  # platformdirs raises it for a user without a home
        return platformdirs.user_data_path("povgen")
    return Path(os.devnull)


def library_files() -> list[str]:
    """Return the path, size and time of each file in `library` and its folders: a picture depends on them."""
    found = sorted((path, path.stat()) for path in library().rglob("*") if path.is_file())
    return [f"{path} {status.st_size} {status.st_mtime_ns}" for path, status in found]


class Band(NamedTuple):
    """A picture of single rays, one for each pixel: what `Rendering` is for other pictures."""

    size: tuple[int, int]
    timeout: float
    is_light: bool
    supersampling: float = 1

    @property
    def file(self) -> str:
        """The name of POV-Ray's picture."""
        return "rays.exr" if self.is_light else "rays.ppm"

    @property
    def picture_options(self) -> list[str]:
        """POV-Ray's options for the file format, linear light, and the size."""
        kind = ["+FE"] if self.is_light else ["+FP16", "File_Gamma=1"]
        return [*kind, f"+W{self.size[0]}", f"+H{self.size[1]}", "-A"]


def command(binary: str, rendering: Rendering | Band, threads: int = 1) -> list[str]:
    """Return POV-Ray's command line for the scene in its work folder: no display, errors in a file."""
    return [
        *(binary, f"+I{SCENE}", f"+O{rendering.file}", *rendering.picture_options),
        # +MI: a large picture stays in memory; otherwise POV-Ray would write it to a file outside the sandbox
        # Of its messages, only warnings, and errors in a file: a warning names a file that it cannot read.
        *(f"+WT{threads}", f"+MI{MAX_MEMORY >> 20}", "-D", "-P", "-V", "-GD", "-GF", "-GR", "-GS", f"+GF{FATAL}"),
    ]


@cache
def binary() -> str:
    """Return the path of POV-Ray. Raises PovrayError if it is not installed."""
    found = shutil.which("povray")
    if found is None:
        remedy = f"{remedies.system('povray')}; without it only --renderer gl draws"
        raise PovrayError(f"POV-Ray is not installed: no 'povray' on the PATH; {remedy}")
    return os.path.abspath(found)  # the program is started in other folders


def max_memory(at_once: int = 1, pixels: float = 0, pictures_shown: int = 0) -> int:
    """Return how many bytes of address space each of `at_once` POV-Ray processes gets, for a picture of `pixels`.

    `pictures_shown` is how many pictures of sky and floor the scene shows.
    """
    machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    share = max(machine // at_once, LEAST_MEMORY + round(PIXEL_MEMORY * pixels) + PICTURE_MEMORY * pictures_shown)
    return min(MAX_MEMORY, share, _own(resource.RLIMIT_AS), _own(resource.RLIMIT_DATA))


def max_file() -> int:
    """Return how many bytes POV-Ray may write to a file."""
    return min(MAX_FILE, _own(resource.RLIMIT_FSIZE))


def _own(limit: int) -> int:
    """Return povgen's own limit. Processes that povgen starts cannot exceed it."""
    soft, _ = resource.getrlimit(limit)
    return sys.maxsize if soft == resource.RLIM_INFINITY else soft


def _mebibytes(count: int) -> str:
    return f"{count / 2**20:.6g} MiB"


@cache
def util_linux() -> list[str]:
    """Return the paths of setpriv and prlimit, or nothing without them. BusyBox's setpriv cannot do it."""
    found = [os.path.abspath(path) for path in map(shutil.which, ("setpriv", "prlimit")) if path]
    if len(found) < 2:
        return []
    trial = [found[0], "--pdeathsig", "KILL", found[1], "--core=0", "--", found[1], "-V"]
    return found if subprocess.run(trial, cwd="/", capture_output=True, timeout=60).returncode == 0 else []


def _limits(memory: int) -> list[str]:
    """Return the start of a command line that sets limits, by `util_linux`.

    setpriv also kills the command when the thread of povgen that started it ends.
    """
    if not util_linux():
        return []
    setpriv, prlimit = util_linux()
    return [setpriv, "--pdeathsig", "KILL", prlimit, f"--as={memory}", f"--fsize={max_file()}", "--core=0", "--"]


@cache
def libraries(*programs: Path) -> list[Path]:
    """Return the shared libraries that programs load, as ldd lists them; if it cannot, the folders of all libraries."""
    environment = {"PATH": os.environ.get("PATH", ""), "LC_ALL": "C"}  # POV-Ray, too, gets no LD_LIBRARY_PATH
    try:
        done = subprocess.run(["ldd", *programs], cwd="/", env=environment, capture_output=True, text=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return RUN
    return [*map(Path, {*re.findall(r"(/.+) \(0x", done.stdout)})] if done.returncode == 0 else RUN


def warn_of(pieces: Iterable[str | PieceFile]) -> None:
    """Log a warning, once, if POV-Ray is to read the text of a user's piece, and this system has no sandbox."""
    own = [str(piece) for piece in pieces if isinstance(piece, PieceFile) and not piece.is_mesh]
    if own and not sandbox.version():
        text = f"piece = {shown(own[0])}: POV-Ray has no sandbox here (no Landlock); render only what you trust"
        _warn_once(f"{text}; {remedies.page('no-landlock')}")


@cache
def _warn_once(text: str) -> None:
    logging.getLogger("povgen").warning(f"povgen: warning: {one_line(text)}")


@cache
def version() -> str:
    """Return POV-Ray's version, such as '3.7.0.10.unofficial'. Raises PovrayError if it is too old or unknown."""
    try:
        # cwd: POV-Ray hangs if the current folder has been removed
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


def run(source: str, rendering: Rendering, folder: Path, at_once: int = 1) -> Path:
    """Render one scene's text with a new Runner, as `Runner.run` does, and return the picture's path."""
    runner = Runner(at_once=at_once)
    try:
        return runner.run(source, rendering, folder)
    finally:
        runner.stop()


class Runner:
    """The POV-Ray processes of one render, which can be stopped together."""

    def __init__(self, threads: int = 1, part: Callable[[float], None] | None = None, at_once: int = 1) -> None:
        """Each POV-Ray gets this number of threads, or fewer if their memory would exceed POV-Ray's limit.

        `at_once` POV-Ray processes divide this machine's memory.
        `part` is called during a render, from another thread. Its argument is the fraction of the picture, 0 to 1, that
        has been drawn since the last call.
        """
        self._part = part
        self._at_once = at_once
        self._threads = max(1, min(threads, max_memory(at_once) // THREAD_MEMORY))
        self._running: set[subprocess.Popen[bytes]] = set()
        self._stopped = False

    def run(self, source: str, rendering: Rendering | Band, folder: Path) -> Path:
        """Render a scene's text in a work folder and return the picture's path. The picture has `rendering.size`.

        If POV-Ray is killed, takes too long or reports a timeout of its own, it is tried once more, because the scene
        is not always the cause. Raises TransientError, a kind of PovrayError, if both tries fail. Raises another
        PovrayError if POV-Ray is missing, refuses the scene or was stopped. Raises OSError if the disk is full.
        """
        attempts = count(1)
        shown_files = pictures.used(source)
        if rays := next((name for name in shown_files if name.startswith("rays-")), None):
            assert isinstance(rendering, Rendering)
            return self._by_rays(source, rendering, folder.resolve(), shown_files, rays)
        path = tried(lambda: self._run(source, rendering, folder.resolve() / str(next(attempts)), shown_files))
        if rendering.is_light or rendering.supersampling > 1:
            if rendering.is_light:
                return light.from_exr(path, rendering.size)
            light.reduce_file(path, rendering.size)
        return path

    def _by_rays(
        self, source: str, rendering: Rendering, folder: Path, shown_files: dict[str, bytes], rays: str
    ) -> Path:
        """Render a picture from single rays, in bands, and return its path. `rays` is the name of the rays' file."""
        attempts = count(1)
        depth = rendering.antialias[2] if isinstance(rendering.antialias, tuple) else rendering.supersampling
        width, height = (round(depth * pixels) for pixels in rendering.size)
        given = traced_rays.of_file(shown_files[rays])
        found, ends = traced_rays.Found.of(given, (width, height)), []

        def rendered(band: Band, files: dict[str, bytes]) -> Path:
            return tried(lambda: self._run(source, band, folder / str(next(attempts)), files))

        for number, rows, table in found.bands(given.tile):
            # the first row of POV-Ray's picture shows no ray of the table
            band = Band((traced_rays.COLUMNS, rows + 1), rendering.timeout, rendering.is_light)
            picture = rendered(band, {**shown_files, rays: table})
            ends.append(light.read(picture, band.size)[1:].reshape(-1, 3)[:number])
        return light.write(found.picture(np.concatenate(ends)), rendering.size, rendering.is_light, folder)

    def stop(self) -> None:
        """Kill every POV-Ray process of this runner, and start no more."""
        with stopping.lock:
            self._stopped = True
            for process in self._running:
                process.kill()

    def _run(self, source: str, rendering: "Rendering | Band", folder: Path, shown_files: dict[str, bytes]) -> Path:
        config = folder / ".povray" / "3.7" / "povray.conf"
        config.parent.mkdir(parents=True, exist_ok=True)
        config.write_text(f'{CONFIG}read* = "{library()}"\n')
        (folder / SCENE).write_text(source, "utf-8")
        for name, content in shown_files.items():
            (folder / name).write_bytes(content)
        # POV-Ray writes 20 bytes a pixel to this file, to continue an interrupted render. povgen does not need them.
        state = (folder / rendering.file).with_suffix(".pov-state")
        state.unlink(missing_ok=True)
        state.symlink_to(os.devnull)
        written = [folder / name for name in (rendering.file, FATAL, DATA)]
        for file in written:
            file.write_bytes(b"")
        threads = 1 if ORDER_MATTERS.search(source) else self._threads
        width, height = rendering.size
        memory = max_memory(self._at_once, rendering.supersampling**2 * width * height, len(shown_files))
        programs = [Path(program).resolve() for program in (*util_linux(), binary())]
        # it must exist; POV-Ray reads the quotation marks itself
        own_library = [f'+L"{library()}"'] if library().is_dir() else []
        status, messages = sandbox.within(
            lambda: self._process(
                [*_limits(memory), *command(binary(), rendering, threads), *own_library, *["+V"] * bool(self._part)],
                folder,
                rendering.timeout,
            ),
            read=[*READ, library(), folder],
            run=[*programs, *libraries(*programs)],
            write=[*written, Path(os.devnull)],
        )
        if status or not (folder / rendering.file).stat().st_size:
            fewer = "; with fewer --workers it is higher" if memory < max_memory() else ""
            out_of_memory = f"out of memory: its limit is {_mebibytes(memory)}{fewer}"
            raise _failure(rendering, folder, status, messages.decode(errors="replace"), out_of_memory)
        return folder / rendering.file

    def _process(self, arguments: list[str], folder: Path, timeout: float) -> tuple[int, bytes]:
        """Run POV-Ray. Return its exit status, or -n if signal n killed it, and the end of its messages."""
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
            stopping.processes.add(process)
        messages = bytearray()
        reader = Thread(target=_read_last, args=(process.stderr, messages, self._part))
        try:
            reader.start()
            reader.join(timeout)
            if reader.is_alive():
                raise TransientError(f"POV-Ray took longer than {timeout:g} s (--timeout) and was stopped")
            process.wait()
        finally:
            process.kill()
            process.wait()
            if reader.ident:  # it was started
                reader.join()
            with stopping.lock:
                self._running.discard(process)
                stopping.processes.discard(process)
        self._check()
        return process.returncode, bytes(messages)

    def _check(self) -> None:
        if self._stopped:
            raise PovrayError("POV-Ray was stopped")


def _read_last(pipe: IO[bytes], last: bytearray, part: Callable[[float], None] | None = None) -> None:
    """Read a pipe to its end, close it, and add the last MAX_MESSAGES bytes to `last`.

    Call `part` with the fraction of the picture that has been drawn since the last call, as POV-Ray's messages say.
    """
    known = 0.0
    with pipe:
        while block := os.read(pipe.fileno(), MAX_MESSAGES):
            last += block
            if part and (found := RENDERED.findall(last)):
                pixels, all_ = map(int, found[-1])
                after = max(known, pixels / all_)  # threads of POV-Ray can report out of order
                part(after - known)
                known = after
                last[:] = RENDERED.sub(b"", last)
            del last[:-MAX_MESSAGES]


def _failure(rendering: Rendering | Band, folder: Path, status: int, messages: str, out_of_memory: str) -> Exception:
    """Return the error to raise if POV-Ray made no picture, with POV-Ray's message, file and line.

    `out_of_memory` is what the error says if memory is the reason.
    """
    first, last = _ends(folder / FATAL)
    missing = MISSING.search(messages.replace("\n", ""))  # lines are broken before a space, or within a word
    place = missing or re.match(r"File: (.*?)  Line: (\d+)\n", first)
    said = one_line(" ".join(last.rpartition("Error:")[2].split())) if "Error:" in last else ""
    said = said.removeprefix("Parse halted by #error directive: ")

    def refused(message: str) -> PovrayError:
        error = PovrayError(f"POV-Ray: {place[1]}, line {place[2]}: {message}" if place else f"POV-Ray: {message}")
        error.line = int(place[2]) if place and place[1] == SCENE else None
        return error

    if missing:
        return refused(f"no file {one_line(missing[3])!r} that it may read; {READABLE}{str(library())!r}")
    if NO_MEMORY.search(said + messages):
        return refused(out_of_memory)
    if status == -signal.SIGXFSZ:
        return PovrayError(f"POV-Ray was stopped: its limit for a file, {_mebibytes(max_file())}, is exceeded")
    if status < 0:
        perhaps = f", perhaps {out_of_memory}" if -status in CRASHES else ""
        return TransientError(f"POV-Ray was killed by signal {-status}{perhaps}")
    width, height = rendering.size
    # POV-Ray does not report a full disk. Another frame may have failed too, and the removal of its picture freed some
    # space. So the disk also counts as full if the free space is at most that of one picture.
    if files.is_full(folder, 2**16 + round(3 * rendering.supersampling**2 * width * height)):
        return OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))
    if place is not None:
        return refused(said or "failed")
    if UNCLEAR.search(messages):  # there is no line number, probably because memory was exhausted
        return PovrayError(f"POV-Ray failed, probably {out_of_memory}")
    lines = [line.strip() for line in messages.splitlines() if line.strip()][-2:]
    failed = "POV-Ray failed: " + (one_line(" ".join(lines)) or "it left no message")
    # "Timed out ..." is POV-Ray's message on an overloaded machine
    return (TransientError if "Timed out waiting for worker thread" in failed else PovrayError)(failed)


def _ends(log: Path) -> tuple[str, str]:
    """Return the beginning of a file, and its end, or no text if it is missing."""
    if not log.is_file():
        return "", ""
    with log.open("rb") as file:
        first = file.read(MAX_MESSAGES)
        file.seek(max(0, file.seek(0, os.SEEK_END) - MAX_MESSAGES))
        return first.decode(errors="replace"), file.read().decode(errors="replace")


def placed(error: PovrayError, source: str, pieces: Iterable[str | PieceFile], what: str) -> PovrayError:
    """Return an error that also says where the fault is, and in `what`.

    `source` is the text that POV-Ray read, and `pieces` are the pieces in it. If the fault is in a user's file, the
    message names this file and its line, otherwise the template that the line is from.
    """
    name, line = origin_of(pieces, source, error.line) if error.line else ("", None)
    message = str(error)
    if line is not None:
        message, name = message.replace(f"{SCENE}, line {error.line}", f"{name}, line {line}"), ""
    return type(error)(f"{message}\n  {f'from {name}, in' if name else 'in'} {what}")
