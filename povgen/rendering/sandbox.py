"""The sandbox: it enforces what POV-Ray may read, write and run. povray.py decides that (READ, RUN, work folder).

The sandbox is made with Landlock, a part of the Linux kernel. A thread in a sandbox can use only the files and folders
that are named, and so can every process that it starts. povgen starts each POV-Ray from a thread in its own sandbox.
"""

import ctypes
import os
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from functools import cache
from pathlib import Path
from threading import Thread
from typing import TypeVar

Result = TypeVar("Result")

# Rights from linux/landlock.h. The numbers of the system calls are those of x86, ARM, RISC-V, POWER and s390.
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
EXECUTE, WRITE_FILE, READ_FILE, READ_DIR, TRUNCATE = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 1 << 14
# All rights on files, by the version of Landlock that first knew them.
RIGHTS = {1: (1 << 13) - 1, 2: (1 << 14) - 1, 3: (1 << 15) - 1, 5: (1 << 16) - 1}
ABSTRACT_SOCKETS_AND_SIGNALS, NETWORK = 3, 3
PR_SET_NO_NEW_PRIVS = 38


@cache
def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


class _Ruleset(ctypes.Structure):
    _fields_ = [(name, ctypes.c_uint64) for name in ("files", "network", "scoped")]


class _PathBeneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = [("allowed", ctypes.c_uint64), ("parent", ctypes.c_int32)]


def version() -> int:
    """Return Landlock's version in this kernel, or 0 if the kernel has none."""
    if sys.platform != "linux":  # elsewhere the number is that of another system call
        return 0
    return max(0, int(_libc().syscall(CREATE_RULESET, None, 0, 1)))


def within(
    work: Callable[[], Result], *, read: Iterable[Path] = (), run: Iterable[Path] = (), write: Iterable[Path] = ()
) -> Result:
    """Call `work` in a sandbox, in a new thread, and return its result.

    `work` may read, run and write only these files and what is in these folders. What may be run may also be read.
    What may be written may also be read, but not run. In a folder of `write`, files may also be made and removed.
    Landlock 4 and later also block TCP. Without Landlock there is no sandbox. Paths that are missing are ignored.
    Raises what `work` raises, and OSError if the kernel refuses.
    """
    done: Future[Result] = Future()

    def confined() -> None:
        try:
            _confine(read, run, write)
            done.set_result(work())
        except BaseException as error:
            done.set_exception(error)

    Thread(target=confined).start()
    return done.result()


def _confine(read: Iterable[Path], run: Iterable[Path], write: Iterable[Path]) -> None:
    """Put this thread into a sandbox until the thread ends."""
    abi = version()
    if not abi:
        return
    every = RIGHTS[max(number for number in RIGHTS if number <= abi)]
    rules = _Ruleset(every, NETWORK, ABSTRACT_SOCKETS_AND_SIGNALS)
    size = 8 if abi < 4 else 16 if abi < 6 else 24  # bytes: older kernels do not know the last fields of _Ruleset
    ruleset = _checked(_libc().syscall(CREATE_RULESET, ctypes.byref(rules), ctypes.c_size_t(size), 0))
    try:
        look = READ_FILE | READ_DIR
        for paths, rights in ((read, look), (run, look | EXECUTE), (write, every & ~EXECUTE)):
            for path in paths:
                _allow(ruleset, path, rights)
        _checked(_libc().prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))
        _checked(_libc().syscall(RESTRICT_SELF, ruleset, 0))
    finally:
        os.close(ruleset)


def _allow(ruleset: int, path: Path, rights: int) -> None:
    """Add a rule: these rights on a file, or on all that is in a folder. A path that cannot be opened gets no rule."""
    try:
        opened = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        return
    try:
        if not path.is_dir():
            rights &= EXECUTE | WRITE_FILE | READ_FILE | TRUNCATE  # a file has only these
        rule = _PathBeneath(rights, opened)
        _checked(_libc().syscall(ADD_RULE, ruleset, 1, ctypes.byref(rule), 0))
    finally:
        os.close(opened)


def _checked(status: int) -> int:
    if status < 0:
        raise OSError(ctypes.get_errno(), f"Landlock: {os.strerror(ctypes.get_errno())}")
    return status
