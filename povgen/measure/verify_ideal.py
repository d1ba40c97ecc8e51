"""Ideal sheets, compared with the equations."""

from collections.abc import Iterator
from math import degrees, pi, radians

import numpy as np

from povgen.measure import probes
from povgen.measure.measured import HD, SMALL, Measured, px
from povgen.measure.probes import Directions, Floats, PiecePositions, Positions, Size
from povgen.measure.targets import located, other_targets, targets, transverse, unit
from povgen.optics import equations
from povgen.scene import camera


def ideal_positions(count: int = 60, size: Size = HD) -> Iterator[Measured]:
    """Compare the apparent positions of objects with eq. 7, and nu and M with eqs. 8 and 9, corrected."""
    scenes = [
        *targets("ideal", count - 2 * (count // 3), seed=7, E=0j),
        *targets("ideal", count // 3, seed=8, E=0.3 - 0.4j),
        *targets("ideal", count // 3, seed=9, E=8.6j),
    ]
    off, turn, scale = [], [], []
    for scene, seen in located(scenes, size):
        r, alpha = scene.z2 / scene.z1, radians(scene.alpha)
        off.append(px(abs(seen.position - scene.apparent_position(scene.L, scene.z1))))
        turn.append(degrees(abs(np.angle(seen.a * np.exp(-1j * equations.nu(r, alpha))))))
        scale.append(100 * abs(abs(seen.a) / equations.M(r, alpha) - 1))
    # numpy's max keeps NaN
    yield Measured("ideal", f"apparent position against eq. 7, {count} scenes, worst", np.max(off), 0.05, "px")
    yield Measured("ideal", "nu of these objects against eq. 8 corrected, worst", np.max(turn), 0.1, "deg")
    yield Measured("ideal", "M of these objects against eq. 9 corrected, worst", np.max(scale), 0.2, "%")


def ideal_directions(size: Size = HD) -> Iterator[Measured]:
    """Compare the direction that each pixel of the window shows with the rotated direction."""
    for E, where in ((0j, "in front of the window"), (0.5 - 0.5j, "to the side"), (8.6j, "far to the side")):
        scenes = [Directions(sheet="ideal", alpha=alpha, eye=E) for alpha in (66, 180)]
        worst = 0.0
        for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
            inside, direction = camera.rays(scene, size)
            turned = equations.rotate(direction, radians(scene.alpha))
            # rays that leave the sheet but miss the window frame's rear opening end at the frame: leave them out
            leaves = direction[:, :2] * scene.z2 / direction[:, 2:] + turned[:, :2] / turned[:, 2:] * scene.depth / 2
            leaves += (E.real, E.imag)
            off = np.linalg.norm(unit(decoded[inside]) - turned, axis=1)
            free = abs(leaves).max(1) < scene.aperture / 2 - 1e-6
            worst = max(worst, np.nan_to_num(off[free], nan=np.inf).max())
        yield Measured("ideal", f"direction against the rotation, eye {where}, worst pixel", worst, 1e-4, "rad")


def chess_pieces(size: Size = HD) -> Iterator[Measured]:
    """Compare how chess pieces appear rotated and magnified about the eye with eqs. 8 and 9, corrected."""
    scenes = [
        PiecePositions(sheet="ideal", alpha=alpha, z1=z1, z2=6, x=0.1, eye=(0, -0.33), piece=name)
        for alpha, z1, name in (
            (25, 3, "pawn"),
            (66, 2, "knight"),
            (90, 6, "queen"),
            (140, 1, "rook"),
            (-66, 4, "king"),
        )
    ]
    turn, scale = 0.0, 0.0
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        a = about_eye(scene, decoded, size)
        r = scene.z2 / scene.z1
        turn = max(turn, abs(np.angle(a * np.exp(-1j * equations.nu(r, radians(scene.alpha))))))
        scale = max(scale, abs(abs(a) / equations.M(r, radians(scene.alpha)) - 1))
    yield Measured(
        "ideal", f"nu of {len(scenes)} chess pieces against eq. 8 corrected, worst", degrees(turn), 0.1, "deg"
    )
    yield Measured("ideal", f"M of {len(scenes)} chess pieces against eq. 9 corrected, worst", 100 * scale, 0.2, "%")


def about_eye(scene: PiecePositions, decoded: Floats, size: Size) -> complex:
    """Return the factor from positions on a piece to their apparent positions, relative to E, at the piece's axis.

    A piece is as deep as it is wide, and its farther parts appear turned by more. Therefore the complex factor is
    fitted as a polynomial of the depth, of degree 3 or, far away, less.
    """
    inside, direction = camera.rays(scene, size)
    if scene.sheet == "detailed":  # stray light shows other places of the piece
        inside[inside] = scene.trace(camera.along(scene, direction)).designed
    inside &= ~np.isnan(decoded[..., 0])
    x, y, depth = decoded[inside].T
    from_eye = scene.L + x + 1j * y - scene.E
    powers = [power for power in range(4) if (0.5 / scene.z1) ** power > 1e-3]  # far away, depth matters less
    basis = from_eye[:, None] * depth[:, None] ** powers
    target = camera.pixels(scene, size)[inside] - scene.E
    return complex(probes.fitted(basis, target)[0][0])


def horizon(size: Size = HD) -> Iterator[Measured]:
    """Compare alpha with the angle by which the horizon appears turned. The horizon appears as a line through E."""
    alphas = (-120, 30, 66, 90, 180)
    off = [horizon_angle(Directions(sheet="ideal", alpha=alpha), size) - radians(alpha) for alpha in alphas]
    worst = np.max(abs((np.array(off) + pi) % (2 * pi) - pi))
    yield Measured("ideal", f"the horizon turned by alpha, worst of {len(alphas)}", degrees(worst), 0.1, "deg")


def horizon_angle(scene: Directions, size: Size) -> float:
    """Return the angle, radians, by which the horizon appears turned. The fit drops stray light."""
    (decoded,) = probes.decoded([scene], size)
    inside, _ = camera.rays(scene, size)
    inside &= ~np.isnan(decoded[..., 0])
    slope = decoded[inside][:, 1] / decoded[inside][:, 2]
    position = camera.pixels(scene, size)[inside]
    (x, y), _ = probes.fitted(np.column_stack((position.real, position.imag)), slope, rounds=8)
    return float(np.arctan2(y, x) - pi / 2)  # the horizon is perpendicular to the slope's gradient


def real_image(size: Size = HD) -> Iterator[Measured]:
    """Measure the image distance at alpha = 180 deg, by the parallax between two eyes.

    The image is as far in front of the sheets as the object is behind them.
    """
    off = [100 * abs(image_distance(size, alpha=180, z1=z1) + z1) / z1 for z1 in (1.0, 2.0, 4.0)]
    yield Measured("ideal", "alpha = 180 deg: image distance -z1 by parallax, worst of 3", np.max(off), 0.2, "%")


def image_distance(size: Size, **values: object) -> complex:
    """Measure how far behind the plane z = 0 the lines of sight from two eyes to an object cross, in tiles.

    The result is complex: the lines cross if its imaginary part is 0. `values` are parameters of the scene.
    """
    eyes = (-0.2 + 0.1j, 0.25 - 0.1j)
    scenes = [Positions(sheet="ideal", L=0.1 + 0.1j, eye=E, extent=0.05, **values) for E in eyes]
    left, right = (seen.position for _, seen in located(scenes, size))
    z2_over_distance = 1 - (left - right) / (eyes[0] - eyes[1])
    return scenes[0].z2 / z2_over_distance - scenes[0].z2


def nothing_changed(size: Size = SMALL) -> Iterator[Measured]:
    """Measure how much a sheet with alpha = 0 changes the position that a pixel shows."""
    scenes = [Positions(sheet=sheet, alpha=0, z1=2, extent=2) for sheet in ("ideal", "none")]
    ideal, none = probes.decoded(scenes, size)
    inside, _ = camera.rays(scenes[0], size)
    change = transverse(ideal - none)[inside & ~np.isnan(none[..., 0])]
    worst = np.nan_to_num(abs(change), nan=np.inf).max(initial=0) * 6 / 8  # projected from z = 2 to the plane z = 0
    worst = worst if len(change) else np.nan
    yield Measured("ideal", "alpha = 0: change of what a pixel shows, worst", px(worst), 0.05, "px")


def other_sheets(size: Size = HD) -> Iterator[Measured]:
    """Compare the apparent positions of objects behind other ideal sheets with `Scene.apparent_position`."""
    for sheet, scenes in other_targets().items():
        off = [px(abs(seen.position - scene.apparent_position(scene.L, 2))) for scene, seen in located(scenes, size)]
        yield Measured(
            "ideal", f"sheet {sheet}: apparent position, {len(scenes)} scenes, worst", np.max(off), 0.1, "px"
        )
