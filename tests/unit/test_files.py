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


def disk(monkeypatch, **values):
    there = {"f_bavail": 10**6, "f_frsize": 4096, "f_files": 10**6, "f_favail": 10**5} | values
    monkeypatch.setattr(os, "statvfs", lambda folder: SimpleNamespace(**there))


@pytest.mark.parametrize(
    ("values", "full"),
    [
        ({"f_bavail": 15}, True),
        ({"f_favail": 0}, True),
        ({"f_favail": 0, "f_files": 0}, False),  # a file system without a limit
    ],
)
def test_a_full_disk(values, full, monkeypatch, tmp_path):
    disk(monkeypatch, **values)
    assert files.is_full(tmp_path) == full


@pytest.mark.parametrize(
    ("left", "number", "said"),
    [
        (9, errno.ENOSPC, "No space left on device"),
        (0, errno.ENOSPC, "no inodes left, "),
    ],
)
def test_no_room_in_a_temporary_folder(left, number, said, monkeypatch, tmp_path):
    disk(monkeypatch, f_favail=left)
    with pytest.raises(OSError) as raised, files.temporary_folder(tmp_path):
        raise OSError(number, os.strerror(number))
    assert message_of(raised.value).startswith(f"{tmp_path}: {said}")


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
