"""Windows in series, compared with the equations and the exact ray trace."""

from collections.abc import Iterator
from math import radians

import numpy as np

from povgen.measure import probes
from povgen.measure.measured import HD, SMALL, Measured, px
from povgen.measure.probes import Directions, Floats, Mask, Size
from povgen.measure.targets import SERIES, Series, located, series_targets, unit
from povgen.measure.verify_ideal import image_distance
from povgen.measure.verify_prisms import errors, pixel_checks
from povgen.optics import series
from povgen.scene import camera
from povgen.scene.scenes import Scene


def series_positions(count: int = 12, size: Size = HD) -> Iterator[Measured]:
    """Compare the apparent positions of objects behind 2 and 3 ideal windows with the complex depth."""
    for windows in (2, 3):
        scenes = [*series_targets("ideal", windows, count - count // 2, seed=11, E=0j)]
        scenes += series_targets("ideal", windows, count // 2, seed=12, E=0.3 - 0.2j)
        off = [
            px(abs(seen.position - scene.apparent_position(scene.L, scene.z1))) for scene, seen in located(scenes, size)
        ]
        what = f"{windows} windows: apparent position against the complex depth, {count} scenes, worst"
        yield Measured("ideal", what, np.max(off), 0.1, "px")


def series_directions(size: Size = HD) -> Iterator[Measured]:
    """Compare the direction that each pixel shows through all of 2 and 3 ideal windows with the rotated direction."""
    worst = 0.0
    for alpha, window, E in (
        (120, SERIES[0][1:], 0j),
        (50, [{"alpha": 75, "z": 1}, {"alpha": -40, "z": 2}], 0.3 - 0.2j),
    ):
        scene = Directions(sheet="ideal", alpha=alpha, window=window, eye=E)
        (decoded,) = probes.decoded([scene], size)
        inside, direction = camera.rays(scene, size)
        through, turned = through_ideal(scene, direction)
        off = np.linalg.norm(unit(decoded[inside][through]) - turned[through], axis=1)
        worst = max(worst, np.nan_to_num(off, nan=np.inf).max())
    yield Measured("ideal", "2 and 3 windows: direction against the rotations, worst pixel", worst, 1e-4, "rad")


def through_ideal(scene: Scene, direction: Floats) -> tuple[Mask, Floats]:
    """Return which of the eye's rays pass all windows and their frames, and their directions behind the windows.

    `direction` is (n, 3), and the results are (n,) and (n, 3). Rays within 1e-6 tiles of an edge do not pass.
    """
    slope = (direction[:, 0] + 1j * direction[:, 1]) / direction[:, 2]
    at, z, through, half = scene.E + scene.z2 * slope, 0.0, np.ones(len(slope), bool), scene.aperture / 2 - 1e-6
    for place, alpha in zip(scene.places, scene.alphas, strict=True):
        at = at + (place - z) * slope
        before, after = slope, slope * np.exp(-1j * radians(alpha))
        for point in (at - scene.depth / 2 * before, at, at + scene.depth / 2 * after):
            through &= np.maximum(abs(point.real), abs(point.imag)) < half
        slope, z = after, place
    turned = np.column_stack((slope.real, slope.imag, np.ones(len(slope))))
    return through, unit(turned)


def series_image(size: Size = HD) -> Iterator[Measured]:
    """Measure the image distance of two windows, by the parallax between two eyes."""
    off = []
    for first, second, gap in ((120, 120, 2.0), (150, 100, 1.5), (40, -100, 2.0)):
        z1, W = series.imaged_plane(radians(first), [(gap, radians(second))])
        measured = image_distance(size, alpha=first, window=[{"alpha": second, "z": gap}], z1=z1)
        off.append(100 * abs(measured - W) / abs(W))
    yield Measured("ideal", "2 windows: image distance by parallax, worst of 3", np.max(off), 0.2, "%")


def series_pixels(
    counts: tuple[int, ...] = (100,), scenes: tuple[Series, ...] = SERIES, size: Size = SMALL
) -> Iterator[Measured]:
    """Compare the direction that every pixel shows through 4 sheets with the exact ray trace, stray light included."""
    for count in counts:
        probed = [Directions(sheet="detailed", prisms=count, alpha=alpha, window=window) for alpha, *window in scenes]
        yield from pixel_checks(f"2 windows of 2x{count}, {len(scenes)} scenes", probed, size)


def series_prediction(count: int = 12, size: Size = SMALL) -> Iterator[Measured]:
    """Measure the error of the paraxial prediction for 2 and 3 windows, as a fraction of the complex depth's error."""
    for windows in (2, 3):
        thin, thick = errors(series_targets("detailed", windows, count, seed=5, E=0j), size)
        what = f"{windows} windows of 2x100: paraxial prediction's error ({px(thick):.2f} px) / the complex depth's"
        yield Measured("detailed", what, thick / thin, 0.1)
