"""How povgen stops at a signal: no process is started any more, and none is left behind, nor any unfinished file.

This module is loaded first, before anything slow, so it imports little itself.
"""

import _thread
import os
import select
import signal
import sys
import time
from contextlib import suppress
from threading import RLock

LONGEST = 1.5  # seconds after the signal; then povgen ends in any case
MESSAGE = b"povgen: stopped; the same command goes on from the frames that are finished\n"

# Held while a process is started or a work folder is made. It is reentrant because the signal handler takes it in the
# main thread, which may hold it already.
lock = RLock()
folders: set[str] = set()  # work folders; whoever made one removes it, or this module if that takes too long
_number = 0  # of the signal; 0 before it came


def asked() -> bool:
    """Whether a signal has asked povgen to stop. The answer cannot change while the caller holds the lock."""
    return bool(_number)


def check() -> None:
    """Raise KeyboardInterrupt if a signal has asked povgen to stop."""
    if _number:
        raise KeyboardInterrupt


def on_signals() -> None:
    """Stop at SIGHUP, SIGINT and SIGTERM from now on, unless the signal is ignored, as under nohup or a shell's &."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)


def off_signals() -> None:
    """Give the signals back their default action: they end the process without a message."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is _stop:
            signal.signal(number, signal.SIG_DFL)


def _stop(number: int, frame: object) -> None:
    global _number
    if _number:  # povgen is stopping already
        return
    with lock:
        _number = number
    # not threading.Thread: its start is not reentrant, and this handler may have interrupted one
    _thread.start_new_thread(_end_in_time, ())
    _kill_children()
    raise KeyboardInterrupt


def _end_in_time() -> None:
    """End povgen after a while: the exception may be lost, as in a destructor, or the work may not be interruptible."""
    time.sleep(LONGEST)
    _kill_children()
    _thread.start_new_thread(_remove_folders, ())
    time.sleep(LONGEST / 5)
    _end()


def _remove_folders() -> None:
    import shutil

    while left := [folder for folder in list(folders) if os.path.lexists(folder)]:
        for folder in left:
            shutil.rmtree(folder, ignore_errors=True)  # the loop tries again if a thread has just written there


def _kill_children() -> None:
    """Kill povgen's child processes, POV-Rays and the encoder, so that no thread waits for them."""
    for thread in os.listdir("/proc/self/task"):
        with suppress(OSError), open(f"/proc/self/task/{thread}/children") as children:
            for child in children.read().split():
                with suppress(ProcessLookupError):
                    os.kill(int(child), signal.SIGKILL)


def leave() -> None:
    """End the process without waiting for threads. The exit status is 128 plus the signal's number."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # closed or missing
            stream.flush()
    _remove_folders()
    _end()


def _end() -> None:
    # Write only if that cannot block. Without a stderr its number may belong to another file.
    with suppress(OSError, ValueError, AttributeError):
        number = sys.stderr.fileno()
        if select.select([], [number], [], 0)[1]:
            os.write(number, MESSAGE)
    os._exit(128 + _number)
