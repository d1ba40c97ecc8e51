"""The one place where frames are encoded."""

import logging
from collections.abc import Iterable
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import imageio.v2
import imageio.v3 as iio
import imageio_ffmpeg
import numpy as np

from povgen.errors import InputError

logging.getLogger("imageio_ffmpeg").setLevel(logging.ERROR)  # povgen says what went wrong
# Untagged video is shown with the wrong colours by some players.
BT709 = (
    "-vf scale=out_color_matrix=bt709:out_range=tv,"
    "setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709:range=tv"
)
FASTEST_GIF = 50  # frames a second; faster ones are shown slower
# Seconds. A GIF holds a pause in 16 bits, as hundredths of a second, and equal pictures in succession are written once,
# with the sum of their pauses: at worst that is the whole movie.
LONGEST_GIF = 655.35
# A keyframe every 6 frames: players seek to any frame at once, as a slider needs.
FORMATS = {
    ".mp4": ("libx264", f"-crf 18 -preset slow -g 6 -bf 0 {BT709} -movflags +faststart"),
    ".webm": ("libvpx-vp9", f"-crf 24 -b:v 0 -g 6 -row-mt 1 -deadline good -cpu-used 2 {BT709}"),
    ".gif": ("gif", ""),
}


def encode(pictures: Iterable[np.ndarray], output: Path, rate: float, tags: dict[str, str]) -> None:
    """Write pictures, (height, width, 3) bytes, as H.264 (.mp4), VP9 (.webm) or GIF, `rate` of them a second.

    Raises OSError where the file does not come out whole.
    """
    if output.suffix == ".gif":
        pictures = list(pictures)
        # times in a GIF are whole hundredths of a second
        times = [round(100 * n / rate) for n in range(len(pictures) + 1)]
        pauses = [10 * (end - start) for start, end in pairwise(times)]
        comment = " ".join(tags.values()).encode()
        options: dict[str, Any] = {"extension": ".gif", "duration": pauses, "loop": 0, "comment": comment}
        output.write_bytes(iio.imwrite("<bytes>", pictures, plugin="pillow", **options))
        return
    codec, settings = FORMATS[output.suffix]
    metadata = [word for key, value in tags.items() for word in ("-metadata", f"{key}={value}")]
    writer = imageio.v2.get_writer(
        output,
        fps=rate,
        codec=codec,
        quality=None,
        pixelformat="yuv420p",
        macro_block_size=2,
        ffmpeg_log_level="quiet",
        output_params=[*settings.split(), *metadata],
    )
    written = found = 0
    try:
        for picture in pictures:
            written += 1
            try:
                writer.append_data(picture)
            except OSError:  # the encoder has gone
                break
    finally:
        writer.close()  # which waits for ffmpeg, as its `with` does not after an error
    with suppress(RuntimeError):  # ffmpeg's exit status is not to be had; this is raised for what is no movie
        found = imageio_ffmpeg.count_frames_and_secs(str(output))[0]
    if found != written or not written:
        raise OSError(f"the encoder wrote {found} of {written} frames (is the disk full?)")


def check_gif(frames: int, rate: float) -> None:
    """Raises InputError for what a GIF cannot show at the right times: so many frames, `rate` of them a second."""
    if rate > FASTEST_GIF or frames / rate > LONGEST_GIF:
        raise InputError(
            f"a GIF of {frames} frames, {rate:.4g} a second, {frames / rate:.5g} s long: "
            f"allowed: up to {FASTEST_GIF} frames a second and up to {LONGEST_GIF} s"
        )


def png(picture: np.ndarray) -> bytes:
    """A picture, (height, width, 3) bytes, as a PNG file's."""
    return iio.imwrite("<bytes>", picture, extension=".png")


def webp(picture: np.ndarray) -> bytes:
    """A picture, (height, width, 3) bytes, as a WebP file's: a fraction of a PNG's size, and as it is to the eye."""
    return iio.imwrite("<bytes>", picture, plugin="pillow", extension=".webp", quality=90)
