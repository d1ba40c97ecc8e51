"""The one place where frames are encoded."""

import os
from collections.abc import Iterable
from pathlib import Path

import imageio.v2
import imageio.v3 as iio

from povgen.errors import InputError

# Untagged video is shown with the wrong colours by some players.
BT709 = (
    "-vf scale=out_color_matrix=bt709:out_range=tv,"
    "setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709:range=tv"
)
# A keyframe every 6 frames: players seek to any frame at once, as a slider needs.
FORMATS = {
    ".mp4": ("libx264", f"-crf 18 -preset slow -g 6 -bf 0 {BT709} -movflags +faststart"),
    ".webm": ("libvpx-vp9", f"-crf 24 -b:v 0 -g 6 -row-mt 1 -deadline good -cpu-used 2 {BT709}"),
    ".gif": None,
}


def checked_output(path: Path, suffixes: Iterable[str]) -> Path:
    """The path, if a file of one of these kinds can be written there; nothing is written yet. Raises InputError."""
    if path.suffix.lower() not in suffixes:
        raise InputError(f"output = {str(path)!r}: not a kind that povgen writes; allowed: {', '.join(suffixes)}")
    if path.is_dir():
        raise InputError(f"output = {str(path)!r}: it is a folder; allowed: a file's name")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise InputError(f"output = {str(path)!r}: its folder does not exist or cannot be written to")
    return path


def encode(frames: Iterable[Path], output: Path, rate: float, tags: dict[str, str]) -> None:
    """Write frames (PNG files of one size) as H.264 (.mp4), VP9 (.webm) or GIF, `rate` of them a second."""
    images = (iio.imread(frame)[..., :3] for frame in frames)
    if output.suffix == ".gif":
        # times in a GIF are whole hundredths of a second
        pace = round(100 / rate) * 10
        iio.imwrite(
            output, list(images), plugin="pillow", duration=pace, loop=0, comment=" ".join(tags.values()).encode()
        )
        return
    codec, options = FORMATS[output.suffix]
    metadata = [word for key, value in tags.items() for word in ("-metadata", f"{key}={value}")]
    with imageio.v2.get_writer(
        output,
        fps=rate,
        codec=codec,
        quality=None,
        pixelformat="yuv420p",
        macro_block_size=2,
        output_params=[*options.split(), *metadata],
    ) as writer:
        for image in images:
            writer.append_data(image)
