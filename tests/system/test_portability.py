"""Systems without util-linux, without Landlock, without /proc: povgen works, and says which protection is missing."""

import os
import shutil
import signal
import subprocess
import sys
from threading import Thread

import pytest
from conftest import povgen, wait_for

from povgen import PovrayError, Rendering, stopping
from povgen.rendering import parallel, povray, sandbox

TINY = Rendering(size=(32, 32), antialias="off", timeout=20)
SCENE = "#version 3.7;\n{}\ncamera {{ location -3*z look_at 0 }}\nsphere {{ 0, 1 pigment {{ rgb 1 }} }}\n"
FRAME = ["frame", "chess", "--sheet=none", "--size=64x48", "--quiet"]


@pytest.fixture
def few_programs(tmp_path, monkeypatch):
    """A PATH with POV-Ray and a shell, but without util-linux."""
    (tmp_path / "bin").mkdir()
    for name in ("povray", "sh"):
        (tmp_path / "bin" / name).symlink_to(shutil.which(name))
    known = (povray.binary, povray.version, povray.has_util_linux)
    for function in known:
        function.cache_clear()
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    yield tmp_path / "bin"
    for function in known:
        function.cache_clear()


def run(tried, folder, rendering=TINY):
    (folder / "work").mkdir()
    return povray.run(SCENE.format(tried), rendering, folder / "work")


def test_check_says_that_util_linux_is_missing(few_programs, tmp_path):
    assert povgen([*FRAME, "-o", "a.png"], tmp_path) == (0, "", "") and (tmp_path / "a.png").is_file()
    status, out, err = povgen(["check"], tmp_path)
    assert status == 0, out + err
    (line,) = [line for line in out.splitlines() if "limits" in line]
    assert (
        "set by a shell, because setpriv and prlimit (util-linux) are missing" in line
        and "if povgen is killed, POV-Ray runs on" in line
    )
    assert "memory" not in line  # the shell limits it


def test_a_shell_that_cannot_limit_memory(few_programs, tmp_path):
    """As on macOS."""
    (few_programs / "sh").unlink()
    (few_programs / "sh").write_text('#!/bin/sh\ncase "$2" in "ulimit -v"*) exit 1;; esac\nexec /bin/sh "$@"\n')
    (few_programs / "sh").chmod(0o700)
    assert "POV-Ray's memory is not limited" in povgen(["check"], tmp_path)[1]


def test_a_setpriv_that_cannot_do_it(few_programs):
    for name in ("setpriv", "prlimit"):
        (few_programs / name).write_text("#!/bin/sh\nexit 1\n")
        (few_programs / name).chmod(0o700)
    assert not povray.has_util_linux()


def test_the_shells_limits(few_programs, tmp_path, monkeypatch):
    monkeypatch.setattr(povray, "MAX_MEMORY", 512 << 20)
    monkeypatch.setattr(povray, "MAX_FILE", 1 << 20)
    with pytest.raises(PovrayError, match="line 2: out of memory: its limit is 512 MiB"):
        run("#declare A = array[100000000]; #for (I, 0, 99999999) #declare A[I] = <I, I, I>; #end", tmp_path)
    shutil.rmtree(tmp_path / "work")
    with pytest.raises(PovrayError, match="for a file, 1 MiB, is exceeded"):
        run('#fopen F "data.txt" write #while (1) #write(F, "0123456789") #end', tmp_path)
    start, _ = povray._starter(0.2, 1, 1 << 30)
    ended = subprocess.run([*start, "/bin/sh", "-c", "while :; do :; done"], timeout=100)
    assert -ended.returncode in (signal.SIGKILL, signal.SIGXCPU)  # after 1 s of CPU time


def test_the_sandbox_without_util_linux(few_programs, tmp_path):
    if not sandbox.version():
        pytest.skip("this kernel has no Landlock")
    (tmp_path / "secret.txt").write_text('"hidden"\n')
    with pytest.raises(PovrayError, match="no file .* that it may read"):
        run('#fopen F "../../secret.txt" read #read(F, S) #error S', tmp_path)


def test_without_landlock(tmp_path, monkeypatch):
    monkeypatch.setattr(sandbox, "version", lambda: 0)
    monkeypatch.setattr(sandbox, "_libc", lambda: pytest.fail("no system call without Landlock"))
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    assert povgen([*FRAME, "-o", "a.png"], tmp_path)[0] == 0
    status, out, _ = povgen(["check"], tmp_path)
    assert status == 0 and "sandbox: none: this system has no Landlock" in out


def test_another_system(few_programs, tmp_path, monkeypatch):
    """Nothing of Linux alone is used: Landlock's system calls, O_PATH, sched_getaffinity."""
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.delattr(os, "O_PATH", raising=False)
    monkeypatch.setattr(sandbox, "_libc", lambda: pytest.fail("a number of Linux's means another system call"))
    assert sandbox.version() == 0 and parallel.cores() == os.cpu_count()
    assert povgen([*FRAME, "-o", "a.png"], tmp_path)[0] == 0


def test_povray_is_killed_where_the_system_does_not_list_children(few_programs, tmp_path, monkeypatch):
    """By the handling of signals. Here it is called alone: it would end this process."""
    errors = []

    def work():
        try:
            run("#while (1) #end", tmp_path)
        except PovrayError as error:
            errors.append(str(error))

    monkeypatch.setattr(os.path, "isdir", lambda path: False)
    monkeypatch.setattr(stopping, "processes", set())  # drawing processes of other tests live on
    thread = Thread(target=work)
    thread.start()
    met = set()
    for _ in range(povray.TRIES):
        met.update(wait_for(lambda: stopping.processes - met))
        stopping._kill_children()
    thread.join(60)
    assert "killed by signal 9" in errors[0] and not stopping.processes
