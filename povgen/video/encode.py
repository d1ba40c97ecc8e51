"""Encode frames as movies and pictures. No other module encodes."""

import errno
import logging
import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import imageio.v2
import imageio.v3 as iio
import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

from povgen.errors import InputError
from povgen.files import is_full

logging.getLogger("imageio_ffmpeg").setLevel(logging.ERROR)  # povgen reports errors itself
# Some players show untagged video in wrong colours.
BT709 = (
    "-vf scale=out_color_matrix=bt709:out_range=tv,"
    "setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709:range=tv"
)
FASTEST_GIF = 50  # frames a second; browsers show faster GIFs more slowly
# Seconds. A GIF stores the duration of a picture in 16 bits, in hundredths of a second. Equal successive pictures are
# written once, with the sum of their durations. If all are equal, this sum is the whole movie.
LONGEST_GIF = 655.35
GIF_BYTES = 2**25  # of the pictures of a GIF that are in memory at once; Pillow needs several times as much
LONGEST_TAG = 4000  # characters; an argument of ffmpeg has at most 128 KiB
# A keyframe every 6 frames lets players seek to any frame at once.
FORMATS = {
    ".mp4": ("libx264", f"-crf 18 -preset slow -g 6 -bf 0 {BT709} -movflags +faststart"),
    ".webm": ("libvpx-vp9", f"-crf 24 -b:v 0 -g 6 -row-mt 1 -deadline good -cpu-used 2 {BT709}"),
    ".gif": ("gif", ""),
}


def encode(pictures: Iterable[NDArray[np.uint8]], output: Path, rate: float, tags: dict[str, str]) -> None:
    """Write pictures, (height, width, 3) bytes, as H.264 (.mp4), VP9 (.webm) or GIF, at `rate` frames a second.

    Tags longer than LONGEST_TAG are cut. Raises OSError if the file is incomplete.
    """
    tags = {key: f"{x[:LONGEST_TAG]}..." if len(x) > LONGEST_TAG else x for key, x in tags.items()}
    if output.suffix == ".gif":
        return _save_gif(iter(pictures), output, rate, " ".join(tags.values()))
    codec, settings = FORMATS[output.suffix]
    metadata = [word for key, value in tags.items() for word in ("-metadata", f"{key}={value}")]
    options: dict[str, Any] = {"pixelformat": "yuv420p", "macro_block_size": 2, "ffmpeg_log_level": "quiet"}
    options |= {"quality": None, "output_params": [*settings.split(), *metadata]}
    writer = imageio.v2.get_writer(output, fps=rate, codec=codec, **options)
    written = found = 0
    try:
        for picture in pictures:
            written += 1
            try:
                writer.append_data(picture)
            except OSError:  # the encoder has stopped
                break
    finally:
        writer.close()  # waits for ffmpeg; the writer's `with` does not wait after an error
    with suppress(RuntimeError):  # raised if the file is no movie; ffmpeg's exit status is not available
        found = imageio_ffmpeg.count_frames_and_secs(str(output))[0]
    if found != written or not written:
        if is_full(output.parent):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(output))
        raise OSError(f"the encoder {imageio_ffmpeg.get_ffmpeg_exe()} failed: it wrote {found} of {written} frames")


def _save_gif(pictures: Iterator[NDArray[np.uint8]], output: Path, rate: float, comment: str) -> None:
    """Write pictures as a GIF.

    Pillow holds all pictures of a GIF in memory. Therefore it writes GIFs of a few pictures, which are joined here.
    """
    written = 0
    with output.open("wb") as file:
        for first in pictures:
            few = [first, *islice(pictures, max(GIF_BYTES // first.nbytes, 1) - 1)]
            durations = gif_durations(len(few), rate, written)
            header: dict[str, Any] = {} if written else {"loop": 0, "comment": comment.encode()}
            duration = durations if len(durations) > 1 else durations[0]
            gif = iio.imwrite("<bytes>", few, plugin="pillow", extension=".gif", duration=duration, **header)
            file.write(_without_header(gif) if written else gif[:-1])
            written += len(few)
        file.write(b";")


def _without_header(gif: bytes) -> bytes:
    """Return what is between a GIF's header and its last byte. The first picture gets the header's table of colours."""
    size = gif[10] & 0b111  # the table has 2^(size + 1) colours, of 3 bytes each
    start = 13 + (3 << size + 1)
    image = start + 8  # after the picture's duration
    flags = bytes([gif[image + 9] | 0b10000000 | size])  # it has a table of its own, of this size
    return gif[start : image + 9] + flags + gif[13:start] + gif[image + 10 : -1]


def gif_durations(frames: int, rate: float, before: int = 0) -> list[int]:
    """Return each frame's duration in milliseconds, at `rate` frames a second, after `before` other frames.

    A GIF's times are whole hundredths of a second. Each frame's start is rounded, and not its duration, so rounding
    errors do not add up.
    """
    times = [round(100 * n / rate) for n in range(before, before + frames + 1)]
    return [10 * (end - start) for start, end in pairwise(times)]


def check_gif(frames: int, rate: float) -> None:
    """Raise InputError if a GIF cannot show so many frames at the right times, at `rate` frames a second."""
    if rate > FASTEST_GIF or frames / rate > LONGEST_GIF:
        raise InputError(
            f"a GIF of {frames} frames, {rate:.4g} a second, {frames / rate:.5g} s long: "
            f"allowed: up to {FASTEST_GIF} frames a second and up to {LONGEST_GIF} s"
        )


def png(picture: NDArray[np.uint8]) -> bytes:
    """Return a picture, (height, width, 3) bytes, as the bytes of a PNG file."""
    return iio.imwrite("<bytes>", picture, extension=".png")
