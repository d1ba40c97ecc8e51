"""Starts the processes that read a user's files (`mesh_reader`, `picture_reader`), and limits their memory and time."""

import os
import resource
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

PATIENCE = 120  # seconds


def run(module: str, argument: str, what: str, data: bytes | None = None) -> subprocess.CompletedProcess[bytes]:
    """Run one of these modules, which reads a file of the kind `what`. Raises ValueError after PATIENCE seconds.

    `data` is the process's standard input. Without `data`, the result has nothing of what the process writes.
    """
    path = [str(Path(__file__).parents[2]), *filter(None, sys.path)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-P", "-m", f"povgen.scene.{module}", argument]
    output = subprocess.DEVNULL if data is None else subprocess.PIPE
    try:
        return subprocess.run(
            command,
            input=b"" if data is None else data,
            stdout=output,
            stderr=output,
            timeout=PATIENCE,
            cwd="/",
            env=environment,
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"should be a {what} that is read within {PATIENCE} s") from None


def limit(memory: int, seconds: int) -> None:
    """Limit this process's address space, in bytes, and its CPU time. macOS has no limit of the address space."""
    for kind, most in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, seconds)):
        hard = resource.getrlimit(kind)[1]
        with suppress(ValueError):  # macOS refuses that of the address space
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
