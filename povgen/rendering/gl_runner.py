"""The processes that draw with the graphics library: gl.py."""

import json
import os
import re
import signal
import subprocess
from collections import defaultdict
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from itertools import dropwhile, takewhile
from pathlib import Path
from threading import Event, Timer
from typing import Any

from povgen import remedies, stopping
from povgen.errors import InputError, PovrayError, TransientError, one_line
from povgen.inputs import pictures
from povgen.rendering.parallel import cores, end, python, tried
from povgen.settings import Rendering

SCENE = "scene.json"
START = 60.0  # seconds in which a process is ready to draw
# On a graphics processor, more processes make a movie little faster (docs/speed.md), and each needs its memory.
ON_GPU = 4
# in the names of devices that draw without a graphics processor
WITHOUT_GPU = re.compile("llvmpipe|softpipe|swrast|software|swiftshader|basic render|gdi generic", re.IGNORECASE)
# signals that a fault of the process itself causes; others come from outside
CRASHES = {signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGILL, signal.SIGFPE}
CODE = Path(__file__).with_name("gl.py")  # that draws
POVRAY = "allowed: renderer = 'povray'"
Process = subprocess.Popen[bytes]
Answer = tuple[Process, dict[str, Any]]  # a process, and the line with which it answers
# Processes that wait for the next picture of a runner that draws one at once: to start one takes longer than to draw.
# They end with this Python. A Python that was forked, which has another number, has its own.
_waiting: defaultdict[int, list[Process]] = defaultdict(list)


@cache
def device() -> str:
    """Return the name of the device that draws, and OpenGL's version. Raises what `Runner` and its `device` raise."""
    return Runner().device()


def at_once() -> int:
    """Return how many pictures are drawn at once if --workers does not say. Raises what `device` raises."""
    return cores() if WITHOUT_GPU.search(device()) else min(ON_GPU, cores())


class Runner:
    """Processes that draw, which can be stopped together. There is one for each picture that is drawn at once.

    If it draws one picture at once, its process then waits for the next runner.
    """

    def __init__(self, at_once: int = 1, part: Callable[[float], None] | None = None) -> None:
        """Prepare to draw `at_once` pictures at once. Raises InputError if moderngl is not installed.

        `part` is called while a picture is drawn, with the fraction of it that has been drawn since the last call.
        """
        if find_spec("moderngl") is None:
            raise InputError(
                f"renderer = 'gl' needs moderngl, which is not installed: {remedies.extra('gl')}; {POVRAY}"
            )
        self._part = part
        self._threads = max(1, cores() // at_once)
        self._own: list[Process] = []  # those that wait and end with this runner
        self._idle = _waiting[os.getpid()] if at_once == 1 else self._own
        self._busy: set[Process] = set()
        self._stopped = False
        self.cpu_seconds: list[float] = []  # of each picture; that of a process's first one includes its start

    def run(self, source: str, rendering: Rendering, folder: Path) -> Path:
        """Draw a scene from a text of `gl_scene.to_text`, in a work folder, and return the picture's path.

        If the process crashes or hangs, another process tries once more. Raises InputError if this system cannot draw.
        Raises PovrayError if the process was stopped or refuses the scene. Raises OSError if the disk is full. Raises
        TransientError if both tries fail.
        """
        picture = folder / ("frame.light" if rendering.is_light else rendering.file)
        kind, wide_filter = "light" if rendering.is_light else "png", rendering.supersampling > 1
        asked = {"size": rendering.size, "rays": rendering.rays, "wide_filter": wide_filter, "kind": kind}
        self.draw(source, picture, rendering.timeout, asked)
        return picture

    def draw(self, source: str, target: Path, timeout: float, asked: Mapping[str, object]) -> None:
        """Draw a scene into a file, as `run` does. `asked` has the other keys that `gl.main` reads."""
        folder = target.parent
        (folder / SCENE).write_text(source, "utf-8")
        for name, png in pictures.used(source).items():
            (folder / name).write_bytes(png)
        request = {"scene": str(folder / SCENE), "target": str(target), **asked}

        def drawn() -> Answer:
            process = self._taken()
            return process, self._answer(process, timeout, request)

        answer = self._idle_after(drawn)
        if answer.get("errno"):
            raise OSError(answer["errno"], answer["error"], str(folder))
        if "error" in answer:
            raise PovrayError(f"renderer gl: {one_line(answer['error'])}")
        self.cpu_seconds.append(answer["cpu_seconds"])

    def device(self) -> str:
        """Return the name of the device that draws, and OpenGL's version.

        Raises InputError if this system cannot draw, TransientError if two processes crash or hang, and PovrayError if
        they were stopped.
        """
        answer = self._idle_after(self._started)
        return f"{answer['device']}, OpenGL {answer['version']}"

    def stop(self) -> None:
        """Kill every process of this runner, and start no more."""
        with stopping.lock:
            self._stopped = True
            busy = list(self._busy)
        for process in busy:
            self._end(process)
        with suppress(IndexError):  # another thread may take the last one
            while True:
                with self._own.pop() as process:  # no thread reads from its pipes
                    end(process)

    def _idle_after(self, work: Callable[[], Answer]) -> dict[str, Any]:
        """Return a process's answer; the process then waits for the next picture. Try twice if it crashes or hangs."""
        process, answer = tried(work, f"; {POVRAY}")
        with stopping.lock:
            self._check()  # it was stopped after the answer, and so was the process
            self._busy.discard(process)
            self._idle.append(process)
        return answer

    def _taken(self) -> Process:
        with stopping.lock, suppress(IndexError):
            self._check()
            while (process := self._idle.pop()).poll() is not None:  # it was killed while it had nothing to draw
                self._end(process)
            self._busy.add(process)
            return process
        return self._started()[0]

    def _started(self) -> Answer:
        with stopping.lock:
            self._check()
            # the number of threads of llvmpipe, Mesa's driver that draws without a GPU
            process = python("povgen.rendering.gl", LP_NUM_THREADS=str(self._threads))
            self._busy.add(process)
        answer = self._answer(process, START)
        if "error" in answer:
            self._end(process)
            if answer["no_memory"]:
                raise InputError(f"renderer = 'gl': too little memory to start it; {POVRAY}")
            raise InputError(
                f"renderer = 'gl': no OpenGL by EGL: {one_line(answer['error'])}; {remedies.system('gl')}; {POVRAY}; "
                f"{remedies.page('no-opengl')}"
            )
        return process, answer

    def _answer(self, process: Process, timeout: float, asked: dict[str, Any] | None = None) -> dict[str, Any]:
        """Return the line with which a process answers. Raises TransientError, and ends the process, if none comes."""
        assert process.stdin and process.stdout
        late = Event()

        def end_late() -> None:
            late.set()
            process.kill()

        timer = Timer(timeout, end_late)
        with suppress(RuntimeError):  # at the limit of threads there is no limit of time
            timer.start()
        try:
            if asked:
                with suppress(OSError):  # it has ended
                    process.stdin.write(json.dumps(asked).encode() + b"\n")
                    process.stdin.flush()
            # Python's own start can print something; the last line of a process that crashes may be cut off
            own = process.stdout if asked else dropwhile(lambda line: line != stopping.BEGIN, process.stdout)
            lines = takewhile(lambda line: line.endswith(b"\n"), own)
            for answer in map(json.loads, filter(lambda line: line.startswith(b"{"), lines)):
                if "part" not in answer:
                    return dict(answer)
                if self._part:
                    self._part(answer["part"])
        finally:
            timer.cancel()
        self._end(process)
        self._check()
        if late.is_set():
            limit = "(--timeout; a larger one is allowed)" if asked else "to start"
            raise TransientError(f"the drawing process took longer than {timeout:g} s {limit} and was stopped")
        status = process.returncode
        if status >= 0:
            raise TransientError(f"the drawing process ended with status {status}")
        crash = ": the graphics driver crashed" if -status in CRASHES else ", perhaps because memory is short"
        raise TransientError(f"the drawing process was killed by signal {-status}{crash}")

    def _end(self, process: Process) -> None:
        end(process)
        with stopping.lock:
            self._busy.discard(process)

    def _check(self) -> None:
        if self._stopped:
            raise PovrayError("the drawing was stopped")
