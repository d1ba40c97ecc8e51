"""Squares at known positions behind the sheets, and where they appear."""

from collections.abc import Iterator, Sequence
from math import radians
from typing import Any

import numpy as np

from povgen.measure import probes
from povgen.measure.probes import ApparentObject, Complexes, Floats, Positions, Size
from povgen.optics import apparent, equations
from povgen.scene import camera
from povgen.scene.windows import FurtherWindow
from povgen.sheets import OTHER

Series = tuple[float, dict[str, Any]]  # alpha of the first window, and a second window
SERIES: tuple[Series, ...] = (
    (120, {"alpha": 120, "z": 2}),
    (50, {"alpha": 75, "z": 1}),
    (40, {"alpha": -100, "z": 0.6}),
    # prisms of another shape behind the first
    (60, {"alpha": 75, "z": 1.2, "prisms": 40, "index": 1.7, "base_angle": 40, "gap": 0.05}),
)


NOT_FOUND = ApparentObject(complex("nan"), complex("nan"), complex("nan"))


def targets(
    sheet: str, count: int, seed: int, E: complex, alphas: tuple[float, float] = (0, 180), **values: float
) -> list[Positions]:
    """Return squares at random distances that appear at random positions in the window, magnified less than 10 times.

    |alpha| lies between `alphas`, degrees. `E` is the eye, x + iy in tiles. Each square appears 0.6 tiles wide.
    `values` are other parameters of all scenes.
    """
    random = np.random.default_rng(seed)
    scenes: list[Positions] = []
    while len(scenes) < count:
        alpha, z1, z2 = random.uniform(-180, 180), np.exp(random.uniform(np.log(1), np.log(30))), random.uniform(3, 8)
        alpha = np.copysign(alphas[0] + abs(alpha) / 180 * (alphas[1] - alphas[0]), alpha)
        position = complex(*random.uniform(-0.8, 0.8, 2))
        M = equations.M(z2 / z1, radians(alpha))
        if M < 10:
            L = equations.object_position(position, E, z1, z2, radians(alpha))
            scene = Positions(sheet=sheet, alpha=alpha, z1=z1, z2=z2, L=L, eye=E, extent=0.3 / M, **values)
            scenes.append(scene)
    return scenes


def series_targets(sheet: str, windows: int, count: int, seed: int, E: complex, **values: float) -> list[Positions]:
    """Return squares behind random windows, in the same way as `targets`. `windows` is the number of windows.

    The eye sees each square's centre well inside every window. Each square appears 0.5 tiles wide, magnified less than
    4 times.
    """
    random = np.random.default_rng(seed)
    scenes: list[Positions] = []
    while len(scenes) < count:
        angles = random.uniform(8, 150, windows) * random.choice([-1, 1], windows)
        places = np.cumsum(random.uniform(0.6, 1.6, windows - 1))
        window = tuple(FurtherWindow(alpha=alpha, z=z) for alpha, z in zip(angles[1:], places, strict=True))
        z1, z2, P = random.uniform(1, 6), random.uniform(4, 8), complex(*random.uniform(-0.5, 0.5, 2))
        scene = Positions(sheet=sheet, alpha=angles[0], window=window, z1=z1, z2=z2, eye=E, **values)
        L = equations.object_position(P, E, z1, z2, radians(scene.alpha), scene.behind)
        thin = [(distance, sheet.thin) for (distance, _), sheet in zip(scene.elements, scene.sheets, strict=True)]
        crossed = np.array([place for place, *_ in apparent.follow((P - E) / z2, E, thin)])
        M = z2 / abs(equations.depth(z1, z2, radians(scene.alpha), scene.behind))
        if M < 4 and np.maximum(abs(crossed.real), abs(crossed.imag)).max() < 0.7:
            scenes.append(scene.replace(L=L, extent=0.25 / M))
    return scenes


def other_targets() -> dict[str, list[Positions]]:
    """Return squares that appear at 0.2 + 0.3i behind each of the other ideal sheets."""
    found: dict[str, list[Positions]] = {}
    for sheet, kind in OTHER.items():
        found[sheet] = []
        for values in kind.examples:
            for E in (0j, 0.3 - 0.2j):
                scene = Positions(sheet=sheet, z1=2, z2=5, eye=E, extent=0.1, **values)
                *_, P, slope = apparent.follow((0.2 + 0.3j - E) / scene.z2, E, scene.elements)[-1]
                found[sheet].append(scene.replace(L=P + 2 * slope))
    return found


def located(scenes: Sequence[Positions], size: Size) -> Iterator[tuple[Positions, ApparentObject]]:
    """Yield each scene and where its square appears, or NOT_FOUND (NaN) if too little of the square is visible."""
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        inside, _ = camera.rays(scene, size)
        yield (
            scene,
            probes.locate(scene.camera.pixels(size)[inside], transverse(decoded[inside]), scene.extent) or NOT_FOUND,
        )


def transverse(decoded: Floats) -> Complexes:
    """Return x + iy of decoded vectors (..., 3)."""
    return np.asarray(decoded[..., 0] + 1j * decoded[..., 1], np.complex128)


def unit(direction: Floats) -> Floats:
    return np.asarray(direction / np.linalg.norm(direction, axis=-1, keepdims=True))
