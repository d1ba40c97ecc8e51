"""Reads an EXR file in a process with limits of memory and time: `python -m povgen.scene.exr_reader FILE`.

OpenEXR can write messages to standard output, too. After them come a zero byte and the light, (height, width, 3), in
numpy's format. The exit status is 0 for success, NO_OPENEXR if OpenEXR is not installed, NO_COLOURS for a file without
the channels R, G and B, and TOO_LARGE for more than MAX_PIXELS pixels. Any other status means a damaged file, or one
that needs too much time or memory.
"""

import resource
import sys
from contextlib import suppress
from io import BytesIO

NO_OPENEXR, NO_COLOURS, TOO_LARGE = 3, 4, 5
MAX_MEMORY = 3 << 30  # bytes of address space
MAX_TIME = 60  # seconds of CPU time
MAX_PIXELS = 1 << 25


def main() -> int:
    """Read the file and write its light. Return the exit status."""
    for limit, most in ((resource.RLIMIT_AS, MAX_MEMORY), (resource.RLIMIT_CPU, MAX_TIME)):
        hard = resource.getrlimit(limit)[1]
        resource.setrlimit(limit, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    import numpy as np

    try:
        import OpenEXR
    except ImportError:
        return NO_OPENEXR
    with OpenEXR.File(sys.argv[1], header_only=True) as file:
        windows = [file.header()[name] for name in ("dataWindow", "displayWindow")]
    (across, down), (width, height) = ((high - low + 1).astype(int) for low, high in windows)
    if max(across * down, width * height) > MAX_PIXELS:
        return TOO_LARGE
    with OpenEXR.File(sys.argv[1], separate_channels=True) as file:
        channels = file.channels()
        if not {"R", "G", "B"} <= channels.keys():
            return NO_COLOURS
        stored = np.dstack([np.asarray(channels[name].pixels, np.float32) for name in "RGB"]).reshape(down, across, 3)
    # the picture is the display window; it is black where the file has no pixels
    light = np.zeros((height, width, 3), np.float32)
    left, top = (windows[0][0] - windows[1][0]).astype(int)
    (x0, x1), (y0, y1) = np.clip((left, left + across), 0, width), np.clip((top, top + down), 0, height)
    light[y0:y1, x0:x1] = stored[y0 - top : y1 - top, x0 - left : x1 - left]
    output = BytesIO()  # numpy cannot always write to a pipe
    np.save(output, light, allow_pickle=False)
    sys.stdout.buffer.write(b"\0" + output.getvalue())  # after what OpenEXR may have written
    return 0


if __name__ == "__main__":
    status = 1
    with suppress(Exception):  # OpenEXR's, for a damaged file
        status = main()
    sys.exit(status)
