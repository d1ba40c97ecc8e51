"""Compute the mountains on the horizon, a panorama of all azimuths: `... -o FILE`, a .jpg or .webp file.

Its middle is straight ahead. Its columns are equal steps of the azimuth. Its rows are equal steps of the sine of the
angle above the horizon, from `LOW` to `HIGH`. The contrast is low, because what is seen before it matters more.
"""

from argparse import ArgumentParser
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from povgen.inputs import hdr
from povgen.scene.materials import COLOUR_MAPS, PANORAMA, SUN

Numbers = NDArray[np.float64]

LOW, HIGH = float(PANORAMA["low"]), float(PANORAMA["high"])
SEED = 31
LATTICE = 256  # side of the table of random numbers
DISTANCES = np.geomspace(4.0, 22.0, 900)  # km, of the points of the ground that are asked
FINER = 2  # points computed along each side of a pixel
COLUMNS_AT_ONCE = 256

HAZE = np.array([0.66, 0.74, 0.80])  # the colour of the floor far away
CLEAR = 38.0  # km, after which haze covers 63 % of what is seen
SKY_LIGHT = np.array([0.30, 0.40, 0.56])
SUNLIGHT = np.array([1.0, 0.90, 0.74])
CLOUD = np.array([0.90, 0.92, 0.95])
SNOW, ROCK, MEADOW = (np.array(c) for c in ([0.93, 0.94, 0.96], [0.40, 0.37, 0.35], [0.25, 0.29, 0.22]))


def smooth(low: float, high: float, x: Numbers) -> Numbers:
    """Return 0 below `low`, 1 above `high`, and a smooth step between."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


class Noise:
    """Smooth random numbers from 0 to 1 on a plane: those of a table at whole coordinates, interpolated between."""

    def __init__(self, seed: int) -> None:
        table = np.random.default_rng(seed).random((LATTICE, LATTICE))
        self.table = np.pad(table, (0, 1), "wrap")  # one more row and column

    def __call__(self, x: Numbers, z: Numbers) -> Numbers:
        i, j = (np.floor(t).astype(np.int32) for t in (x, z))
        u, v = (t * t * t * (t * (6 * t - 15) + 10) for t in (x - i, z - j))
        place = (i % LATTICE) * (LATTICE + 1) + j % LATTICE
        a, b, c, d = (self.table.take(place + step) for step in (0, 1, LATTICE + 1, LATTICE + 2))
        near = a + u * (c - a)
        return near + v * (b + u * (d - b) - near)

    def sum(self, x: Numbers, z: Numbers, octaves: int) -> Numbers:
        """Return a mean of the noise and ever finer and weaker ones, about 0 to 1."""
        found, weight = np.zeros_like(x), 0.5
        for _ in range(octaves):
            found += weight * self(x, z)
            x, z, weight = 1.62 * x - 1.18 * z + 17.3, 1.18 * x + 1.62 * z - 5.7, weight / 2
        return found

    def ridges(self, x: Numbers, z: Numbers, octaves: int) -> Numbers:
        """Return heights from 0 to about 1 with sharp ridges, on which there are finer ridges."""
        found, weight, above = np.zeros_like(x), 0.55, np.ones_like(x)
        for _ in range(octaves):
            ridge = (1 - abs(2 * self(x, z) - 1)) ** 2 * above
            found += weight * ridge
            above = np.clip(1.6 * ridge, 0, 1)
            x, z, weight = 1.62 * x - 1.18 * z + 17.3, 1.18 * x + 1.62 * z - 5.7, weight * 0.5
        return found


NOISE = Noise(SEED)


def ground(x: Numbers, z: Numbers) -> Numbers:
    """Return the height of the ground in km, at x km to the right and z km straight ahead of the eye."""
    bend = 0.9 * NOISE.sum(x / 5 + 40, z / 5, 3), 0.9 * NOISE.sum(x / 5, z / 5 + 70, 3)
    far = np.hypot(x, z)
    massif = 0.75 + 0.7 * smooth(0.3, 0.65, NOISE.sum(x / 7 + 9, z / 7 + 3, 2))
    rising = smooth(4.5, 13, far)
    hills = 0.10 * smooth(4, 6, far) * NOISE.sum(x / 1.5, z / 1.5, 5)
    return hills + 1.9 * massif * rising * NOISE.ridges(x / 3.6 + bend[0], z / 3.6 + bend[1], 9)


def lit(x: Numbers, z: Numbers, height: Numbers) -> Numbers:
    """Return the colours of points of the ground (..., 3), in linear light, without haze."""
    step = 0.015  # km
    slope_x, slope_z = ((ground(x + dx, z + dz) - height) / step for dx, dz in ((step, 0), (0, step)))
    normal = np.stack([-slope_x, np.ones_like(x), -slope_z], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    sun = np.array([float(part) for part in SUN["direction"].split(",")])
    facing = np.clip(normal @ (sun / np.linalg.norm(sun)), 0, 1)[..., None]
    rough = NOISE.sum(3 * x, 3 * z, 3)
    snow = smooth(0.75, 1.15, height + 0.5 * rough - 0.25) * smooth(0.50, 0.68, normal[..., 1] + 0.3 * rough)
    meadow = smooth(0.75, 0.45, height) * smooth(0.5, 0.7, normal[..., 1])
    surface = ROCK + meadow[..., None] * (MEADOW - ROCK)
    surface = surface + snow[..., None] * (SNOW - surface)
    return surface * (SUNLIGHT * facing + SKY_LIGHT * (0.6 + 0.4 * normal[..., 1:2]))


def clear_sky(sine: Numbers) -> Numbers:
    """Return the colours of the sky (n, 3), without clouds."""
    colours = {float(at): [float(c) for c in text.split(",")] for at, text in COLOUR_MAPS["SkyPigment"].items()}
    return np.stack([np.interp(sine, [*colours], [c[k] for c in colours.values()]) for k in range(3)], -1)


def sky(azimuth: Numbers, sine: Numbers) -> Numbers:
    """Return the colours of the sky (sine, azimuth, 3): thin clouds in streaks, fewer near both ends of the rows."""
    away = np.sqrt(1 - sine**2) / (sine + 0.06)  # of a layer of clouds, in units of its height
    x, z = away[:, None] * np.sin(azimuth), away[:, None] * np.cos(azimuth)
    bend = 0.8 * NOISE.sum(x / 2 + 11, z / 2, 3)
    clouds = NOISE.sum(0.35 * x + 0.9 * z + bend, 2.2 * z - 1.1 * x + bend, 6)
    cover = 0.5 * smooth(0.47, 0.85, clouds) * (smooth(0.06, 0.16, sine) * smooth(HIGH, 0.7 * HIGH, sine))[:, None]
    blue = clear_sky(sine)[:, None]
    return blue + cover[..., None] * (CLOUD - blue)


def columns(azimuth: Numbers, sine: Numbers) -> Numbers:
    """Return the colours of all rows of some columns (sine, azimuth, 3)."""
    x, z = DISTANCES[:, None] * np.sin(azimuth), DISTANCES[:, None] * np.cos(azimuth)
    rise = np.maximum.accumulate(ground(x, z) / DISTANCES[:, None], axis=0)
    asked = sine / np.sqrt(1 - sine**2)
    met = np.stack([np.searchsorted(each, asked) for each in rise.T], -1)  # (sine, azimuth): the first point as high
    found = sky(azimuth, sine)
    row, column = np.nonzero(met < len(DISTANCES))
    k = np.maximum(met[row, column], 1)
    low, high = rise[k - 1, column], rise[k, column]
    far = DISTANCES[k - 1] + np.clip((asked[row] - low) / (high - low), 0, 1) * (DISTANCES[k] - DISTANCES[k - 1])
    x, z = far * np.sin(azimuth[column]), far * np.cos(azimuth[column])
    height = ground(x, z)
    mist = 1 - np.exp(-far / CLEAR)
    mist = mist + (1 - mist) * np.exp(-np.maximum(height, 0) / 0.22)  # it is denser near the ground
    colours = lit(x, z, height)
    found[row, column] = colours + mist[:, None] * (HAZE - colours)
    return found


def panorama(width: int) -> Image.Image:
    """Return the picture, with this many columns."""
    height = round(width * (HIGH - LOW) / (2 * np.pi))
    sine = HIGH + (LOW - HIGH) * (np.arange(FINER * height) + 0.5) / (FINER * height)
    azimuth = 2 * np.pi * ((np.arange(FINER * width) + 0.5) / (FINER * width) - 0.5)
    parts = np.split(azimuth, range(COLUMNS_AT_ONCE, len(azimuth), COLUMNS_AT_ONCE))
    light = np.concatenate([columns(part, sine) for part in parts], axis=1)
    light = light.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3))
    return Image.fromarray(hdr.as_bytes(np.clip(light, 0, 1).astype(np.float32)))


def main() -> None:
    """Write the picture."""
    parser = ArgumentParser()
    parser.add_argument("-o", dest="output", type=Path, required=True)
    parser.add_argument("--width", type=int, default=5120, help="pixels")
    parser.add_argument("--quality", type=int, default=88, help="of the file, 0 to 100")
    given = parser.parse_args()
    panorama(given.width).save(given.output, quality=given.quality, method=6, optimize=True, subsampling=0)


if __name__ == "__main__":
    main()
