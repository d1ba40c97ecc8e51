"""Systems without util-linux, without Landlock, without /proc: povgen works, and says which protection is missing."""

import os
import shutil
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
    """A PATH with POV-Ray, but without util-linux."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "povray").symlink_to(shutil.which("povray"))
    known = (povray.binary, povray.version, povray.util_linux)
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


@pytest.mark.release
def test_check_says_that_util_linux_is_missing(few_programs, tmp_path):
    assert povgen([*FRAME, "-o", "a.png"], tmp_path) == (0, "", "") and (tmp_path / "a.png").is_file()
    status, out, err = povgen(["check"], tmp_path)
    assert status == 0, out + err
    (line,) = [line for line in out.splitlines() if "limits" in line]
    assert "setpriv and prlimit (util-linux) are missing: memory" in line
    assert "if povgen is killed, POV-Ray runs on" in line


def test_a_setpriv_that_cannot_do_it(few_programs):
    for name in ("setpriv", "prlimit"):
        (few_programs / name).write_text("#!/bin/sh\nexit 1\n")
        (few_programs / name).chmod(0o700)
    assert not povray.util_linux()


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
    for _ in range(2):  # it is tried twice
        met.update(wait_for(lambda: stopping.processes - met))
        stopping._kill_children()
    thread.join(60)
    assert "killed by signal 9" in errors[0] and not stopping.processes
