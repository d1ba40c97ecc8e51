"""Encode frames as movies and pictures. No other module encodes."""

import errno
import os
import struct
import subprocess
import zlib
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from povgen import remedies, stopping
from povgen.errors import InputError
from povgen.files import is_full, temporary_folder
from povgen.record import MAX_FRAMES, Record, in_png, into_movie, png_of
from povgen.rendering import light
from povgen.version import __version__

# Some players show untagged video in wrong colours.
EVEN = "-vf scale=ceil(iw/2)*2:ceil(ih/2)*2"  # the encoders need even numbers of pixels
BT709 = (
    f"{EVEN}:out_color_matrix=bt709:out_range=tv,"
    "setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709:range=tv"
)
REMEDY = f"{remedies.pip()} install --force-reinstall imageio-ffmpeg, or {remedies.system('ffmpeg')}"
NEED_NO_FFMPEG = ".gif, frames/%04d.png"
REC709 = 0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329  # x and y of red, green, blue and white: those of sRGB
FASTEST_GIF = 50  # frames a second; browsers show faster GIFs more slowly
# Seconds. A GIF stores the duration of a picture in 16 bits, in hundredths of a second. Equal successive pictures are
# written once, with the sum of their durations. If all are equal, this sum is the whole movie.
LONGEST_GIF = 655.35
MOST_GIF = 2 * 10**9  # pixels; Pillow holds one byte for each in memory
# The codec, the format of pixels that it is given, and its options. A keyframe every 6 frames lets players seek to any
# frame at once. One quantiser for all frames of H.264: otherwise fine stripes that stand still change at keyframes.
# libwebp itself makes YUV of the colours of a WebP file.
FORMATS = {
    ".mp4": ("libx264", "yuv420p", f"-qp 21 -g 6 -bf 0 {BT709} -movflags +faststart"),
    ".webm": ("libvpx-vp9", "yuv420p", f"-crf 24 -b:v 0 -g 6 -row-mt 1 -deadline good -cpu-used 2 {BT709}"),
    ".webp": ("libwebp_anim", "bgra", f"{EVEN} -compression_level 6 -loop 0"),
    ".gif": ("gif", "", ""),
}
LARGEST = {".mp4": 16384, ".webp": 16383}  # pixels of a side, for these encoders


def encode(
    pictures: Iterable[NDArray[np.uint8]],
    output: Path,
    rate: float,
    record: Record | None = None,
) -> None:
    """Write pictures, (height, width, 3) bytes, as H.264 (.mp4), VP9 (.webm), animated WebP or GIF.

    `rate` is in frames a second. A GIF and a WebP file have the record alone, other files also have tags, such as
    the title. Raises InputError if the pictures are too large for the encoder, and OSError if the file is incomplete.
    """
    if output.suffix == ".gif":
        return _save_gif(pictures, output, rate, bytes(record) if record else b"")
    codec, pixels, settings = FORMATS[output.suffix]
    ffmpeg, pictures, returned = imageio_ffmpeg.get_ffmpeg_exe(), iter(pictures), 0
    first = next(pictures)
    height, width, _ = first.shape
    check_size(output.suffix, width, height)  # with the strips of text
    given = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {rate!r} -i -"
    metadata = []
    if record:
        about = f"povgen {__version__}, {record.renderer}. 'povgen info FILE' prints how it was made."
        metadata = ["-metadata", f"title={record.title}", "-metadata", f"description={about}"]
    options = [*f"-an -c:v {codec} -pix_fmt {pixels} {settings}".split(), *metadata]
    # -xerror: older releases of ffmpeg end with status 0 when the disk becomes full
    command = [ffmpeg, *"-y -loglevel quiet -xerror".split(), *given.split(), *options, str(output)]
    with stopping.lock:
        process = subprocess.Popen(command, stdin=subprocess.PIPE)
    assert process.stdin
    try:
        with suppress(BrokenPipeError), process.stdin:  # the encoder has stopped
            for picture in chain([first], pictures):
                process.stdin.write(np.ascontiguousarray(picture).data.cast("B"))
        returned = process.wait()
    finally:
        process.kill()
        process.wait()
    if returned:
        if is_full(output.parent):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(output))
        raise OSError(f"the encoder {ffmpeg} failed, with status {returned}")
    if record:
        into_movie(output, record)


def _save_gif(pictures: Iterable[NDArray[np.uint8]], output: Path, rate: float, comment: bytes) -> None:
    """Write pictures as a GIF. Pillow holds them in memory, one byte a pixel."""
    images = map(Image.fromarray, pictures)
    durations = gif_durations(MAX_FRAMES, rate)
    next(images).save(output, save_all=True, append_images=images, duration=durations, loop=0, comment=comment)


def gif_durations(frames: int, rate: float) -> list[int]:
    """Return each frame's duration in milliseconds, at `rate` frames a second.

    A GIF's times are whole hundredths of a second. Each frame's start is rounded, and not its duration, so rounding
    errors do not add up.
    """
    times = [round(100 * n / rate) for n in range(frames + 1)]
    return [10 * (end - start) for start, end in pairwise(times)]


def check_size(ending: str, width: int, height: int) -> None:
    """Raise InputError if a movie's file with this ending (.mp4) cannot have pictures of this size in pixels."""
    most = LARGEST.get(ending, width + height)
    if max(width, height) > most:
        raise InputError(f"{ending[1:]}: pictures of {width}x{height} pixels; allowed: up to {most}x{most}")


def check_gif(frames: int, rate: float, pixels: int = 0) -> None:
    """Raise InputError if a GIF cannot show so many frames at the right times, at `rate` frames a second.

    Also raise it if their pixels, `pixels` in each frame, would need too much memory.
    """
    if frames * pixels > MOST_GIF:
        raise InputError(
            f"a GIF of {frames} frames of {pixels} pixels: allowed: up to {MOST_GIF} pixels in all, or a WebP file"
        )
    if rate > FASTEST_GIF or frames / rate > LONGEST_GIF:
        raise InputError(
            f"a GIF of {frames} frames, {rate:.4g} a second, {frames / rate:.5g} s long: "
            f"allowed: up to {FASTEST_GIF} frames a second and up to {LONGEST_GIF} s"
        )


def check_encoder(ending: str) -> None:
    """Raise InputError if there is no ffmpeg that can write a movie's file with this ending (.mp4).

    GIFs and PNG files need none.
    """
    named = os.environ.get("IMAGEIO_FFMPEG_EXE")
    try:
        imageio_ffmpeg.get_ffmpeg_version()
    except RuntimeError:
        raise InputError(
            f"a movie needs ffmpeg, which is not installed: {REMEDY}; allowed without it: {NEED_NO_FFMPEG}"
        ) from None
    except (OSError, subprocess.SubprocessError):  # only IMAGEIO_FFMPEG_EXE is not tested by imageio_ffmpeg itself
        raise InputError(
            f"IMAGEIO_FFMPEG_EXE = {named!r}: no ffmpeg that can be started; "
            f"allowed: the path of an ffmpeg; {NEED_NO_FFMPEG} need none"
        ) from None
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    if not _can_write(ending, ffmpeg):
        others = [kind for kind in FORMATS if kind not in (ending, ".gif") and _can_write(kind, ffmpeg)]
        raise InputError(
            f"output = *{ending}: {ffmpeg} has no working encoder {FORMATS[ending][0]}: "
            f"{'unset IMAGEIO_FFMPEG_EXE' if named else REMEDY}; "
            f"allowed with this ffmpeg: {', '.join([*others, NEED_NO_FFMPEG])}; {remedies.page('no-encoder')}"
        )


@cache
def _can_write(ending: str, ffmpeg: str) -> bool:
    """Whether this ffmpeg, which is imageio's, writes movies with this ending: it is tried."""
    with temporary_folder() as folder:
        try:
            encode([np.zeros((32, 32, 3), np.uint8)], folder / f"trial{ending}", 10)
        except OSError as error:
            if error.errno:  # of the disk
                raise
            return False
    return True


def png(picture: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """Return a picture, (height, width, 3) numbers of 8 or 16 bits, as the bytes of a PNG file."""
    if picture.dtype == np.uint8:
        return iio.imwrite("<bytes>", picture, extension=".png")
    # Pillow writes no colours of 16 bits
    height, width, _ = picture.shape
    rows = picture.astype(">u2").view(np.uint8).reshape(height, 6 * width)
    filtered = np.empty((height, 1 + 6 * width), np.uint8)
    filtered[:, 0] = 2  # each row is the difference to the row above
    filtered[0, 1:], filtered[1:, 1:] = rows[0], rows[1:] - rows[:-1]
    header = struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)
    return png_of([(b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes())), (b"IEND", b"")])


def exr(picture: NDArray[np.float32], record: Record) -> bytes:
    """Return a picture of light, (height, width, 3), as the bytes of an EXR file of 32-bit numbers.

    Raises OSError if the disk for temporary files is full.
    """
    library = light.exr()
    header = {
        "type": library.scanlineimage,
        "compression": library.ZIP_COMPRESSION,
        "chromaticities": REC709,
        "software": f"povgen {__version__}",
        "povgen": bytes(record).decode(),
    }
    with temporary_folder() as folder:
        path = folder / "light.exr"
        try:
            library.File(header, {"RGB": np.ascontiguousarray(picture)}).write(str(path))
        except RuntimeError as error:  # OpenEXR's, of a full disk; its message names the file
            raise OSError(str(error)) from None
        return path.read_bytes()


# for each ending in `record.PICTURES`
PICTURES: dict[str, Callable[[NDArray[Any], Record], bytes]] = {
    ".png": lambda picture, record: in_png(png(picture), record),
    ".exr": exr,
}
