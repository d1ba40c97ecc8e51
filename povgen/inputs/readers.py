"""Reads a user's files in processes of their own, whose memory and time are limited: `python -m povgen.inputs.MODULE`.

MODULE is mesh_reader or picture_reader. The file's bytes come by standard input. On standard output, MARK is followed
by a line of JSON and by bytes. The line can have the file's `fault` alone. If the exit status is not 0, there is no
answer: the file needs too much time or memory.
"""

import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

PATIENCE = 120  # seconds
MARK = b"\0povgen\n"  # Python's own start can print something first


def run(module: str, what: str, data: bytes, *arguments: str) -> tuple[dict[str, Any], bytes]:
    """Return what this module finds in a file of the kind `what` with these bytes. Raises ValueError, with the fault.

    Also raises it after PATIENCE seconds.
    """
    path = [str(Path(__file__).parents[2]), *filter(None, sys.path)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-P", "-m", f"povgen.inputs.{module}", *arguments]
    try:
        done = subprocess.run(
            command, input=data, capture_output=True, timeout=PATIENCE, cwd="/", env=environment, check=True
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"should be a {what} that is read within {PATIENCE} s") from None
    except subprocess.CalledProcessError:
        raise ValueError(f"should be a {what} that needs less time and memory") from None
    line, _, content = done.stdout.partition(MARK)[2].partition(b"\n")
    answer = json.loads(line)
    if "fault" in answer:
        raise ValueError(answer["fault"])
    return answer, content


def serve(read: Callable[[bytes], tuple[dict[str, Any], bytes]], memory: int, seconds: int) -> None:
    """Read standard input, and write the answer, with these limits of the address space, in bytes, and CPU time.

    macOS has no limit of the address space.
    """
    for kind, most in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, seconds)):
        hard = resource.getrlimit(kind)[1]
        with suppress(ValueError):  # macOS refuses that of the address space
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    content = b""
    try:
        answer, content = read(sys.stdin.buffer.read())
    except ValueError as fault:
        answer = {"fault": str(fault)}
    sys.stdout.buffer.write(MARK + json.dumps(answer).encode() + b"\n" + content)


@contextmanager
def faults(whole: str) -> Iterator[None]:
    """Raise ValueError, with what a file should be, in place of the errors of any kind that a damaged file causes."""
    try:
        yield
    except MemoryError:
        raise ValueError("should be a file that needs less memory") from None
    except Exception as error:
        known = type(error) is ValueError and str(error).startswith(("should ", "needs "))
        raise ValueError(str(error) if known else f"should be a whole {whole}") from None
