"""Output folders, and what a full disk is."""

import errno
import os
from types import SimpleNamespace

import numpy as np
import pytest

from povgen import files, stopping
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


def test_an_empty_folder_of_the_user_stays(tmp_path):
    with pytest.raises(ValueError), files.output_folder(tmp_path):
        raise ValueError
    assert tmp_path.is_dir()


def disk(monkeypatch, **values):
    there = {"f_bavail": 10**6, "f_frsize": 4096, "f_files": 10**6, "f_favail": 10**5} | values
    monkeypatch.setattr(os, "statvfs", lambda folder: SimpleNamespace(**there))


@pytest.mark.parametrize(
    ("values", "full"),
    [
        ({}, False),
        ({"f_bavail": 15}, True),
        ({"f_bavail": 16}, False),
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
        (9, errno.EDQUOT, "Disk quota exceeded"),
        (0, errno.EFBIG, "File too large"),
    ],
)
def test_no_room_in_a_work_folder(left, number, said, monkeypatch, tmp_path):
    disk(monkeypatch, f_favail=left)
    with pytest.raises(OSError) as raised, files.work_folder(tmp_path):
        raise OSError(number, os.strerror(number))
    assert message_of(raised.value).startswith(f"{tmp_path}: {said}")


def test_a_work_folder_that_is_interrupted_as_it_is_made_is_known(monkeypatch, tmp_path):
    """A signal's handler raises its exception at any moment. povgen then removes the folders that it knows."""
    make = os.mkdir

    def interrupted(*arguments, **options):
        make(*arguments, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "mkdir", interrupted)
    with pytest.raises(KeyboardInterrupt), files.work_folder(tmp_path):
        pass
    (folder,) = tmp_path.iterdir()
    assert str(folder) in stopping.folders
    stopping.folders.discard(str(folder))


def test_of_two_files_the_written_one_is_named():
    error = OSError(errno.ENOSPC, "No space left on device", "/dev/null", None, "link")
    assert message_of(error) == "link: No space left on device"


@pytest.mark.parametrize("full", [True, False])
@pytest.mark.parametrize("written", ["", "RIFF", "RIFF\\010\\0\\0\\0WEBPANMF"])
@pytest.mark.parametrize("kind", ["mp4", "webm", "webp"])
def test_an_encoder_that_fails(full, written, kind, monkeypatch, tmp_path):
    """The disk is blamed if it is full. The file may be cut off anywhere."""
    failing = tmp_path / "failing"
    failing.write_text(
        f'#!/bin/sh\nfor output; do :; done\n[ "$output" = - ] || printf \'{written}\' > "$output"\nexit 1\n'
    )
    failing.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(failing))
    monkeypatch.setattr(encode, "is_full", lambda folder: full)
    with pytest.raises(OSError) as raised:
        encode.encode(PICTURES, tmp_path / f"a.{kind}", 10, {})
    failed = f"the encoder {failing} failed: it wrote 0 of 2 frames"
    assert message_of(raised.value) == (f"{tmp_path}/a.{kind}: No space left on device" if full else failed)
