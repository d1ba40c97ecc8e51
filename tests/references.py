"""Converged pictures to judge others by. Those of `make test` are kept in tests/data, because they take long to render.

`python tests/references.py` renders them again.
"""

from functools import cache
from pathlib import Path

import imageio.v3 as iio

from povgen import Chess, to_pov
from povgen.measure import speed

DATA = Path(__file__).with_name("data")
KEPT = {Chess(): (160, 120), Chess(alpha=150, z2=9): (160, 120), Chess(alpha=50): (120, 90)}  # scenes and sizes


def file(scene):
    return DATA / f"chess-{scene.alpha:g}.png"


@cache
def rendered(scene, size):
    """Return the picture with 36 rays a pixel: its error is a small part of the tolerances."""
    return speed.sample(to_pov(scene), "1,0.001,6", size)[1]


def converged(scene, size):
    return iio.imread(file(scene)) if KEPT.get(scene) == size else rendered(scene, size)


if __name__ == "__main__":
    for scene, size in KEPT.items():
        iio.imwrite(file(scene), rendered(scene, size))
