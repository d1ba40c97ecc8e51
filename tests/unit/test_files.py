"""Output folders, and what a full disk is."""

import errno
import os
from types import SimpleNamespace

import numpy as np
import pytest

from povgen import files
from povgen.errors import message_of
from povgen.video import encode

PICTURES = [np.zeros((32, 32, 3), np.uint8)] * 2


@pytest.mark.parametrize(("before", "made", "after"), [([], [], []), ([], ["a"], ["a"]), (["b"], [], ["b"])])
def test_an_output_folder_after_an_error(before, made, after, tmp_path):
    """It is removed if nothing was there and nothing was made."""
    folder = tmp_path / "figures"
    if before:
        folder.mkdir()
        (folder / before[0]).touch()
    with pytest.raises(KeyboardInterrupt), files.output_folder(folder) as yielded:
        assert yielded == folder and folder.is_dir()
        for name in made:
            (folder / name).touch()
        raise KeyboardInterrupt
    assert sorted(os.listdir(folder) if folder.exists() else []) == after


def test_a_full_disk(monkeypatch, tmp_path):
    for left, full in ((15, True), (16, False)):
        monkeypatch.setattr(os, "statvfs", lambda folder, left=left: SimpleNamespace(f_bavail=left, f_frsize=4096))
        assert files.is_full(tmp_path) == full


def test_no_room_in_a_temporary_folder(tmp_path):
    with pytest.raises(OSError) as raised, files.temporary_folder(tmp_path):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert message_of(raised.value) == f"{tmp_path}: No space left on device"


@pytest.mark.parametrize("full", [True, False])
def test_an_encoder_that_fails(full, monkeypatch, tmp_path):
    """The disk is blamed if it is full."""
    failing = tmp_path / "failing"
    failing.write_text("#!/bin/sh\nexit 3\n")
    failing.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(failing))
    monkeypatch.setattr(encode, "is_full", lambda folder: full)
    with pytest.raises(OSError) as raised:
        encode.encode(PICTURES, tmp_path / "a.mp4", 10)
    failed = f"the encoder {failing} failed, with status 3"
    assert message_of(raised.value) == (f"{tmp_path}/a.mp4: No space left on device" if full else failed)
