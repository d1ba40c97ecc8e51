"""What a process that povgen starts may do: a sandbox made with Landlock, which is part of the Linux kernel.

A thread in a sandbox, and every process that it starts, can read, write and run only what is named. povgen
makes one in a thread of its own for each POV-Ray.
"""

import ctypes
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from threading import Thread
from typing import TypeVar

Result = TypeVar("Result")

# linux/landlock.h, and the numbers of its system calls, which are the same on every architecture
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
EXECUTE, WRITE_FILE, READ_FILE, READ_DIR, TRUNCATE = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 1 << 14
RIGHTS = {1: (1 << 13) - 1, 2: (1 << 14) - 1, 3: (1 << 15) - 1, 5: (1 << 16) - 1}  # on files, since each version
ABSTRACT_SOCKETS_AND_SIGNALS, NETWORK = 3, 3
PR_SET_NO_NEW_PRIVS = 38

_libc = ctypes.CDLL(None, use_errno=True)


class _Ruleset(ctypes.Structure):
    _fields_ = [(name, ctypes.c_uint64) for name in ("files", "network", "scoped")]


class _PathBeneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = [("allowed", ctypes.c_uint64), ("parent", ctypes.c_int32)]


def version() -> int:
    """Landlock's version in this kernel; 0 where it has none."""
    return max(0, _libc.syscall(CREATE_RULESET, None, 0, 1))


def within(
    work: Callable[[], Result], *, read: Iterable[Path] = (), run: Iterable[Path] = (), write: Iterable[Path] = ()
) -> Result:
    """Call `work` in a sandbox, in a thread of its own.

    It may read, run or write only these files, or what is in these folders. What may be run may be read; what may be
    written may be all but run. There is no TCP. Without Landlock there is no sandbox. Raises what `work` raises, and
    OSError where the kernel refuses.
    """
    outcome: dict = {}

    def confined() -> None:
        try:
            _confine(read, run, write)
            outcome["result"] = work()
        except BaseException as error:
            outcome["error"] = error

    thread = Thread(target=confined)
    thread.start()
    thread.join()
    if "error" in outcome:
        raise outcome["error"]
    return outcome["result"]


def _confine(read: Iterable[Path], run: Iterable[Path], write: Iterable[Path]) -> None:
    abi = version()
    if not abi:
        return
    every = RIGHTS[max(number for number in RIGHTS if number <= abi)]
    rules = _Ruleset(every, NETWORK if abi >= 4 else 0, ABSTRACT_SOCKETS_AND_SIGNALS if abi >= 6 else 0)
    size = 8 if abi < 4 else 16 if abi < 6 else 24
    ruleset = _checked(_libc.syscall(CREATE_RULESET, ctypes.byref(rules), ctypes.c_size_t(size), 0))
    try:
        look = READ_FILE | READ_DIR
        for paths, rights in ((read, look), (run, look | EXECUTE), (write, every & ~EXECUTE)):
            for path in paths:
                _allow(ruleset, path, rights)
        _checked(_libc.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))
        _checked(_libc.syscall(RESTRICT_SELF, ruleset, 0))
    finally:
        os.close(ruleset)


def _allow(ruleset: int, path: Path, rights: int) -> None:
    try:
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except FileNotFoundError:  # not on this system
        return
    try:
        if not path.is_dir():
            rights &= EXECUTE | WRITE_FILE | READ_FILE | TRUNCATE  # the others are a folder's
        rule = _PathBeneath(rights, place)
        _checked(_libc.syscall(ADD_RULE, ruleset, 1, ctypes.byref(rule), 0))
    finally:
        os.close(place)


def _checked(status: int) -> int:
    if status < 0:
        raise OSError(ctypes.get_errno(), f"Landlock: {os.strerror(ctypes.get_errno())}")
    return status
