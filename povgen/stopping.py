"""The state 'stopping': a signal asks for it, and no new process gets past it. Loaded first, so it loads little."""

import _thread
import os
import select
import signal
import sys
import time
from contextlib import suppress
from threading import RLock

LONGEST = 1.5  # seconds until povgen ends, whatever is still under way
MESSAGE = b"povgen: stopped; the same command goes on from the frames that are finished\n"

# Held while a process is started, or a folder for unfinished files is made. The handler takes it in the main thread,
# which may hold it already.
lock = RLock()
folders: set[str] = set()  # for unfinished files: removed by what made them, or here if that takes too long
_number = 0


def asked() -> bool:
    """Whether a signal has asked povgen to stop. Who holds the lock knows that it stays so."""
    return bool(_number)


def check() -> None:
    """Raise KeyboardInterrupt where a signal has asked povgen to stop."""
    if _number:
        raise KeyboardInterrupt


def on_signals() -> None:
    """Stop at SIGHUP, SIGINT and SIGTERM from now on, unless they are ignored, as nohup and a shell's & have it."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)


def off_signals() -> None:
    """Let the signals end what is left of the process, with no word."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is _stop:
            signal.signal(number, signal.SIG_DFL)


def _stop(number: int, frame: object) -> None:
    global _number
    if _number:  # it is ending
        return
    with lock:
        _number = number
    # not a threading.Thread: the handler may have interrupted the start of one, which is not reentrant
    _thread.start_new_thread(_end_in_time, ())
    _kill_children()
    raise KeyboardInterrupt


def _end_in_time() -> None:
    """For an exception that was lost, as in a destructor, or work that cannot be interrupted."""
    time.sleep(LONGEST)
    _kill_children()
    _thread.start_new_thread(_remove_folders, ())
    time.sleep(LONGEST / 5)
    _end()


def _remove_folders() -> None:
    import shutil

    while left := [folder for folder in list(folders) if os.path.lexists(folder)]:
        for folder in left:
            shutil.rmtree(folder, ignore_errors=True)  # again, if a thread has just written there


def _kill_children() -> None:
    """End what runs for povgen, POV-Rays and the encoder, so that nothing is waited for."""
    for thread in os.listdir("/proc/self/task"):
        with suppress(OSError), open(f"/proc/self/task/{thread}/children") as children:
            for child in children.read().split():
                with suppress(ProcessLookupError):
                    os.kill(int(child), signal.SIGKILL)


def leave() -> None:
    """End with the word 'stopped' and a status of 128 and the signal's number, and wait for no thread."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # closed, or none
            stream.flush()
    _remove_folders()
    _end()


def _end() -> None:
    # written only if that cannot block; without a stderr its number may be another file's
    with suppress(OSError, ValueError, AttributeError):
        number = sys.stderr.fileno()
        if select.select([], [number], [], 0)[1]:
            os.write(number, MESSAGE)
    os._exit(128 + _number)
