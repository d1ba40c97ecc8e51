"""Stop povgen at a signal: it ends at once, and no process, no work folder and no unfinished file is left.

This module is loaded first, before anything slow, so it imports little itself.
"""

import _thread
import fcntl
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import RLock
from typing import Any, TextIO

SIGNALS = (signal.SIGHUP, signal.SIGINT, signal.SIGTERM)
# Seconds for the two steps of the end: until nobody starts a process, and until everything is removed. Together they
# are less than 2.
TO_LOCK, TO_REMOVE = 0.4, 1.4
MESSAGE, GOES_ON = b"povgen: stopped", b"; the same command goes on from the frames that are finished"
BEGIN = b"\0povgen\n"  # the line before the answers of a process
SHOW_CURSOR = b"\x1b[?25h"  # a progress bar hides it

lock = RLock()  # held while a process is started; at the end, nobody gets it any more
keeps_frames = False  # whether frames are rendered into the cache
processes: set[Any] = set()  # POV-Rays and Pythons that run, of type subprocess.Popen, which is slow to load
_unfinished: dict[str, Callable[[str], object]] = {}  # paths, and the functions that remove them


@contextmanager
def removed(path: str | os.PathLike[str], remove: Callable[[str], object]) -> Iterator[None]:
    """Call `remove` with this path at the end of the context, or if a signal ends povgen before.

    What is not there, or cannot be removed, stays as it is.
    """
    name = os.fspath(path)
    _unfinished[name] = remove
    try:
        yield
    finally:
        with suppress(OSError):
            remove(name)
        del _unfinished[name]


def on_signals() -> None:
    """Stop at SIGHUP, SIGINT and SIGTERM from now on, unless the signal is ignored, as under nohup or a shell's &."""
    ends = os.pipe()
    # not 0, 1 or 2, which may be free: other code takes them for the standard files
    reads, writes = (fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 3) for end in ends)
    for end in ends:
        os.close(end)
    os.set_blocking(writes, False)
    signal.set_wakeup_fd(writes, warn_on_full_buffer=False)  # Python writes each signal's number there at once
    _thread.start_new_thread(_watch, (reads,))
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _wait)


def _wait(number: int, frame: object) -> None:
    """Handle a signal, in the main thread: do nothing more, until `_watch` ends the process."""
    while True:
        time.sleep(60)


def _watch(reads: int) -> None:
    """Wait for a signal, in a thread, and end the process. The exit status is 128 plus the signal's number."""
    while (number := os.read(reads, 1)[0]) not in SIGNALS:
        pass
    lock.acquire(timeout=TO_LOCK)  # the main thread may hold it, and waits in `_wait`
    _kill_children()
    end = time.monotonic() + TO_REMOVE
    while (left := [each for each in reversed(_unfinished.items()) if os.path.lexists(each[0])]) and (
        time.monotonic() < end  # other threads may write there meanwhile
    ):
        for path, remove in left:
            with suppress(OSError):
                remove(path)
    # Write only if that cannot block. Without a stderr its number may belong to another file.
    with suppress(OSError, ValueError, AttributeError):  # closed or missing
        stderr = sys.stderr.fileno()
        if select.select([], [stderr], [], 0)[1]:
            os.write(stderr, SHOW_CURSOR * os.isatty(stderr) + MESSAGE + GOES_ON * keeps_frames + b"\n")
    os._exit(128 + number)


def _kill_children() -> None:
    """Kill povgen's child processes: renderers, Pythons and the encoder.

    Only Linux lists the children. Elsewhere the encoder ends by itself, at the end of its input.
    """
    for process in list(processes):
        with suppress(OSError):
            process.kill()
    for thread in os.listdir("/proc/self/task") if os.path.isdir("/proc/self/task") else []:
        # the thread has ended, or the kernel does not list children
        with suppress(OSError), open(f"/proc/self/task/{thread}/children") as children:
            for child in children.read().split():
                with suppress(ProcessLookupError):  # it has ended
                    os.kill(int(child), signal.SIGKILL)


def answers() -> TextIO:
    """Return the file for the answers of a process that `parallel.python` started: its standard output.

    The answers follow the line BEGIN; Python's own start can print something before it. What else is printed later is
    discarded. When nobody can read answers any more, because povgen has been killed, the process ends, whatever it
    computes.
    """
    number = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    _thread.start_new_thread(_end_with_reader, (number,))
    file = os.fdopen(number, "w", 1, encoding="utf-8")
    file.write(f"\n{BEGIN.decode()}")
    return file


def _end_with_reader(number: int) -> None:
    waiting = select.poll()
    waiting.register(number, select.POLLHUP)  # always reported by Linux; macOS wants it named
    waiting.poll()
    os._exit(1)
