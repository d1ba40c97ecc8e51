"""Measure Mitsuba 3 for the charts of docs/speed.md: the same mesh of prisms, several numbers of rays a pixel.

The argument is the Python that has Mitsuba. The output is a table with the columns of docs/chart/frames.csv. Mitsuba's
scene has no piece, and boxes for the window's frame, so its pictures are compared with its own converged picture.
"""

import csv
import json
import subprocess
import sys
from math import ceil, cos, floor, radians, sin
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from charts import MAIN_SIZE

from povgen import Chess
from povgen.measure import speed
from povgen.measure.charts import FRAMES_HEAD
from povgen.measure.probes import Size
from povgen.rendering.light import Picture
from povgen.scene import survey

VARIANTS = ("llvm_ad_rgb", "scalar_rgb")  # the first one needs a recent LLVM
RAYS = (1, 4, 16)  # a pixel
CONVERGED = 81


def triangles(scene: Chess) -> list[list[list[float]]]:
    """Return povgen's mesh: the near sheet and the far sheet, each a list of triangles of three corners, tiles."""
    prism, half = scene.prism, scene.aperture / 2
    base, top = prism.length / 2, prism.top_length / 2
    found = []
    for angle, side in ((radians(scene.alpha / 2), -1), (0.0, 1)):
        reach = half * (abs(cos(angle)) + abs(sin(angle))) + scene.rim / 2
        faces = []
        for k in range(floor((half - reach) / prism.pitch), ceil((half + reach) / prism.pitch)):
            low = k * prism.pitch - half + prism.pitch * prism.gap / 2
            high = low + prism.height
            for ya, za, yb, zb in (
                (low, -base, low, base),
                (low, -base, high, -top),
                (low, base, high, top),
                (high, -top, high, top),
            ):
                a, b, c, d = (-reach, ya, za), (reach, ya, za), (reach, yb, zb), (-reach, yb, zb)
                faces += [a, b, c, a, c, d]
        corners = np.array(faces)
        x, y = corners[:, 0].copy(), corners[:, 1].copy()
        corners[:, 0], corners[:, 1] = cos(angle) * x - sin(angle) * y, sin(angle) * x + cos(angle) * y
        corners[:, 2] += side * prism.separation / 2
        found.append(corners.reshape(-1, 9).round(9).tolist())
    return found


class Mitsuba(NamedTuple):
    """One of Mitsuba's variants, and the Python that runs it."""

    python: str
    variant: str

    def sample(self, size: Size, rays: int) -> tuple[float, Picture]:
        """Return the CPU seconds of povgen's default scene, and the picture. Raises CalledProcessError."""
        scene = Chess()
        values = {"window": scene.aperture, "view": scene.view, "z2": scene.z2, "floor": scene.floor_y}
        given = json.dumps({**values, "sheets": triangles(scene)})
        numbers = map(str, (survey.max_trace_level(scene), *size, rays))
        with TemporaryDirectory() as folder:
            program, file = Path(__file__).with_name("mitsuba_baseline.py"), Path(folder) / "picture.npy"
            command = [self.python, program, self.variant, *numbers, file]
            done = subprocess.run(command, input=given, stdout=subprocess.PIPE, text=True, check=True)
            return float(done.stdout), np.load(file)


def fastest(python: str) -> Mitsuba:
    """Return the variant that takes least CPU time, of those that work here."""
    seconds = {}
    for variant in VARIANTS:
        try:
            seconds[variant] = Mitsuba(python, variant).sample(speed.SIZES[0], 1)[0]
        except subprocess.CalledProcessError:
            print(f"{variant} does not work here", file=sys.stderr)
    return Mitsuba(python, min(seconds, key=lambda variant: seconds[variant]))


def main() -> None:
    mitsuba, size = fastest(sys.argv[1]), MAIN_SIZE
    converged = mitsuba.sample(size, CONVERGED)[1]
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(FRAMES_HEAD)
    for rays in RAYS:
        seconds, picture = mitsuba.sample(size, rays)
        errors = speed.picture_error(picture, converged, Chess())
        values = (f"{value:.4g}" for value in (seconds, *errors))
        table.writerow([f"Mitsuba {mitsuba.variant}", f"{rays} ray{'s' * (rays > 1)}", *size, *values])


if __name__ == "__main__":
    main()
