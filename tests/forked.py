"""Processes of Dask's program, forked from one that has loaded it: to load it takes longer than most tests."""

import multiprocessing
import os
import sys

FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    ["distributed.cli.dask_scheduler", "distributed.cli.dask_worker", "povgen.rendering.cluster"]
)


class Dask:
    """A process that runs `dask` with these arguments, as subprocess.Popen would."""

    def __init__(self, arguments, folder, environment, log):
        log.touch()
        self._process = FORKS.Process(target=_run, args=([*map(str, arguments)], folder, environment, log))
        self._process.start()

    def send_signal(self, number):
        os.kill(self._process.pid, number)

    def kill(self):
        self._process.kill()

    def wait(self, seconds=None):
        self._process.join(seconds)
        return self._process.exitcode


def _run(arguments, folder, environment, log):
    import dask.config
    from dask.__main__ import main

    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    with open(log, "w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    dask.config.refresh()
    sys.argv = ["dask", *arguments]
    main()
