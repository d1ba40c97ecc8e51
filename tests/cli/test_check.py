"""The command povgen check: one fault has one remedy, and what needs the faulty part is not blamed."""

import errno
import os
import subprocess
import sys

from conftest import PROJECT, povgen

from povgen.cli import checkup
from povgen.errors import InputError, PovrayError
from povgen.rendering import gl_runner, povray


def failing(error):
    def fail(*_):
        raise error

    return fail


def checked(folder):
    """Return the names of the faulty parts, of those that were not tested, and the printed remedies."""
    status, out, _ = povgen(["check"], folder)
    remedies = [line for line in out.splitlines() if line.startswith("       remedy: ")]
    named = [line.split(": ")[0].split(maxsplit=1) for line in out.splitlines() if line not in remedies]
    faults, untested = ([name for word, name in named if word == kind] for kind in ("FAULT", "-"))
    assert status == bool(faults) and len(named) == len(checkup.PARTS)
    return faults, untested, remedies


def test_without_povray(tmp_path, monkeypatch):
    for name in ("version", "run"):
        monkeypatch.setattr(povray, name, failing(PovrayError("POV-Ray is not installed")))
    faults, untested, remedies = checked(tmp_path)
    assert (faults, untested) == (["POV-Ray"], ["frame"])
    assert remedies == ["       remedy: install it: apt-get install povray"]


def test_without_moderngl_nothing_is_faulty(tmp_path, monkeypatch):
    """The line says what is missing, and how to install it."""
    missing = InputError("renderer = 'gl' needs moderngl, which is not installed: pip install 'povgen[gl]'")
    monkeypatch.setattr(gl_runner, "device", failing(missing))
    assert checked(tmp_path) == ([], ["renderer gl"], [])


def test_without_povray_the_renderer_gl_draws(tmp_path, monkeypatch):
    """Its own pieces and scenes need no POV-Ray. A user's piece does, and the message says so."""
    (tmp_path / "mine.inc").write_text("#declare Piece = sphere { 0.5*y, 0.4 }\n")
    missing = failing(PovrayError("POV-Ray is not installed"))
    for name in ("version", "run", "binary"):
        monkeypatch.setattr(povray, name, missing)
    frame = ["frame", "chess", "--size", "64x48", "--quiet"]
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    for more in (["--piece", "king"], ["--sheet", "ideal", "--predicted-image", "--caption=full", "--overlay"]):
        assert povgen([*frame, *more, "--renderer", "gl"], tmp_path) == (0, "", "")
    assert povgen(["demo", "--quiet"], tmp_path) == (0, "", "")
    page = (tmp_path / "demo.html").read_text("utf-8")
    assert (
        "&#34;" not in page[page.index("<body") : page.index("<script", page.index("<body"))]
    )  # a macro's argument that became text
    status, _, message = povgen([*frame, "--renderer", "gl", "--piece", "mine.inc"], tmp_path)
    assert status == 1 and "POV-Ray is not installed" in message
    assert "the shape of the piece 'mine.inc' is measured by POV-Ray" in message


def test_windows_is_told_of_its_linux(tmp_path):
    code = "import sys; sys.platform = 'win32'; import povgen.__main__ as started; started.main()"
    done = subprocess.run([sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True)
    assert done.returncode == 1 and "Windows Subsystem for Linux" in done.stderr and "Traceback" not in done.stderr


def test_no_folder_for_temporary_files(tmp_path, monkeypatch):
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path))
    make = checkup.temporary_folder
    monkeypatch.setattr(checkup, "temporary_folder", lambda parent=None: make(parent) if parent else failing(full)())
    faults, untested, (remedy,) = checked(tmp_path)
    assert (faults, untested) == (["temporary files"], ["frame", "encoder"]) and "TMPDIR" in remedy


def test_a_bad_encoder(tmp_path, monkeypatch):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/bin/false")
    faults, untested, (remedy,) = checked(tmp_path)
    assert (faults, untested) == (["encoder"], []) and "IMAGEIO_FFMPEG_EXE" in remedy
