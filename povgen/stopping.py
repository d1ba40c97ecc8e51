"""Stop povgen at a signal. Then no process is started any more, and no process and no unfinished file is left.

This module is loaded first, before anything slow, so it imports little itself.
"""

import _thread
import fcntl
import os
import select
import shutil
import signal
import sys
import time
from contextlib import suppress
from threading import RLock
from typing import Any, TextIO

SIGNALS = (signal.SIGHUP, signal.SIGINT, signal.SIGTERM)
LONGEST = 1.5  # seconds that the work has to end after the signal; after 3 times LONGEST, povgen ends in any case
MESSAGE = b"povgen: stopped; the same command goes on from the frames that are finished\n"

# Held while a process is started or a work folder is made. It is reentrant because the signal handler takes it in the
# main thread, which may hold it already.
lock = RLock()
processes: set[Any] = set()  # POV-Rays that run, of type subprocess.Popen, which is slow to load
folders: set[str] = set()  # work folders; whoever made one removes it, or this module if that takes too long
_number = 0  # of the signal; 0 before it came
_raised = False  # whether the handler has raised its exception, or is to raise none


def asked() -> bool:
    """Whether a signal has asked povgen to stop. The answer cannot change while the caller holds the lock."""
    return bool(_number)


def check() -> None:
    """Raise KeyboardInterrupt if a signal has asked povgen to stop."""
    if _number:
        raise KeyboardInterrupt


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
            signal.signal(number, _raise)


def answers() -> TextIO:
    """Return the file into which a process that `parallel.python` started writes its answers, one a line.

    When nobody can read them any more, because povgen has been killed, the process ends, whatever it computes.
    """
    number = int(sys.argv[1])
    _thread.start_new_thread(_end_with_reader, (number,))
    return os.fdopen(number, "w", 1, encoding="utf-8")


def _end_with_reader(number: int) -> None:
    waiting = select.poll()
    waiting.register(number, select.POLLHUP)  # always reported by Linux; macOS wants it named
    waiting.poll()
    os._exit(1)


def off_signals() -> None:
    """Give the signals back their default action: they end the process without a message."""
    for number in SIGNALS:
        if signal.getsignal(number) is _raise:
            signal.signal(number, signal.SIG_DFL)


def _watch(reads: int) -> None:
    """Stop when a signal comes, even if the main thread waits for a lock: then Python does not call the handler."""
    while (number := os.read(reads, 1)[0]) not in SIGNALS:
        pass
    _stop(number)


def _raise(number: int, frame: object) -> None:
    """Handle a signal, in the main thread."""
    global _raised
    if not _raised:
        _raised = True
        _stop(number)
        sys.unraisablehook = _ignore  # the exception is lost if Python called the handler within a destructor
        raise KeyboardInterrupt


def _ignore(_: object) -> None:
    """Print nothing of what is lost while povgen ends. `_end_in_time` ends it in any case."""


def _stop(number: int) -> None:
    global _number
    with lock:
        if _number:  # povgen is stopping already
            return
        _number = number
    # not threading.Thread: its start is not reentrant, and the handler may have interrupted one
    _thread.start_new_thread(_end_in_time, ())
    _kill_children()


def _end_in_time() -> None:
    """End povgen after a while: the exception may be lost, as in a destructor, or the work may not be interruptible."""
    time.sleep(LONGEST)
    _kill_children()
    _thread.start_new_thread(_remove_folders_and_end, ())
    time.sleep(2 * LONGEST)  # on a busy machine removal takes a while, and on a disk that does not answer it never ends
    _end()


def _remove_folders_and_end() -> None:
    _remove_folders()
    _end()


def _remove_folders() -> None:
    while left := [folder for folder in list(folders) if os.path.lexists(folder)]:
        for folder in left:
            shutil.rmtree(folder, ignore_errors=True)  # the loop tries again if a thread has just written there


def _kill_children() -> None:
    """Kill povgen's child processes, POV-Rays and the encoder, so that no thread waits for them.

    Only Linux lists the children. Elsewhere the encoder ends by itself, at the end of its input.
    """
    for process in list(processes):
        with suppress(OSError):  # whatever the system says, povgen ends
            process.kill()
    for thread in os.listdir("/proc/self/task") if os.path.isdir("/proc/self/task") else []:
        # the thread has ended, or the kernel does not list children
        with suppress(OSError), open(f"/proc/self/task/{thread}/children") as children:
            for child in children.read().split():
                with suppress(ProcessLookupError):  # it has ended
                    os.kill(int(child), signal.SIGKILL)


def leave() -> None:
    """End the process without waiting for threads. The exit status is 128 plus the signal's number."""
    global _raised
    _raised = True
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # closed or missing
            stream.flush()
    _remove_folders()
    _end()


def _end() -> None:
    # Write only if that cannot block. Without a stderr its number may belong to another file.
    with suppress(OSError, ValueError, AttributeError):  # closed or missing
        number = sys.stderr.fileno()
        if select.select([], [number], [], 0)[1]:
            os.write(number, MESSAGE)
    os._exit(128 + _number)
