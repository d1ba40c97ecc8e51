"""The command povgen check: one fault has one remedy, and what needs the faulty part is not blamed."""

import errno
import os

import pytest
from conftest import povgen

from povgen.cli import checkup
from povgen.errors import PovrayError
from povgen.rendering import povray


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


def test_no_folder_for_temporary_files(tmp_path, monkeypatch):
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path))
    monkeypatch.setattr(checkup, "temporary_folder", failing(full))
    faults, untested, (remedy,) = checked(tmp_path)
    assert (faults, untested) == (["temporary files"], ["frame", "encoder"]) and "TMPDIR" in remedy


def test_a_cache_that_is_refused(tmp_path, monkeypatch):
    """The message itself says what is allowed."""
    monkeypatch.setenv("POVGEN_CACHE_SIZE", "much")
    assert checked(tmp_path) == (["cache"], [], [])


def test_a_bad_encoder(tmp_path, monkeypatch):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/bin/false")
    faults, untested, (remedy,) = checked(tmp_path)
    assert (faults, untested) == (["encoder"], []) and "IMAGEIO_FFMPEG_EXE" in remedy


@pytest.mark.parametrize("part", checkup.PARTS, ids=lambda part: part.name)
def test_what_a_part_needs_is_tested_before_it(part):
    names = [each.name for each in checkup.PARTS]
    assert set(part.needs) <= set(names[: names.index(part.name)])
