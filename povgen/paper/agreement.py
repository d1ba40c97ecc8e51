"""Measure how well the paper's figures agree with its equations. The captions of the figures print these numbers.

Points in space are (x, y, z): x to the right, y up, z away from the eye. Points in the plane of the sheets are complex.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, degrees, log10, radians, remainder
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen.measure import compare, probes
from povgen.measure.measured import SMALL, px, rms
from povgen.measure.probes import Directions, PiecePositions, Positions
from povgen.measure.targets import located
from povgen.optics import equations, trace
from povgen.optics.faces import GlassSheet
from povgen.optics.prism import Prism
from povgen.scene.presets import AxialScene, Chess, Spheres

Reals = NDArray[np.float64]
Complexes = NDArray[np.complexfloating[Any, Any]]  # of any precision, as numpy's types say of products


def power_of_ten(value: float) -> int:
    """Return the exponent of the smallest power of ten that is not below a value. Rounding errors count as 1e-15."""
    return ceil(log10(max(value, 1e-15)))


# ---- Figure 1 ----


@dataclass(frozen=True)
class RayThroughSheet:
    """A ray that crosses a single sheet. Lengths are in units of the prisms' pitch."""

    path: Reals  # (n, 3): the start, the point on each face, the end
    crossing: Reals  # (3,): where the ray would meet z = 0 without the sheet
    straight: Reals  # (3,): where the ray would end without the sheet
    mirrored: Reals  # (3,): where the ray would end if the plane through `crossing` mirrored it
    angle_error: float  # degrees between the real and the mirrored direction
    shift: float  # distance between the ends of the real and the mirrored path

    @property
    def angle_error_power(self) -> int:
        return power_of_ten(self.angle_error)


def ray_through_sheet(prisms: int, distance: float) -> RayThroughSheet:
    """Trace a ray from z = distance to z = -distance through a sheet whose prisms are 1 apart."""
    start, slope = np.array([-1.0, -0.97, distance]), np.array([0.2, 0.25, -1.0])
    sheet = (GlassSheet(0.0, 0.0, Prism(1.0)),)
    # a trace of at most n faces ends on the n-th
    rays = [trace.trace(start[None], slope[None], sheet, prisms, most=most) for most in (1, 2, 3, 60)]
    out = rays[-1].direction[0] / -rays[-1].direction[0][2]
    path = [start, *(ray.position[0] for ray in rays)]
    path.append(path[-1] + (distance + path[-1][2]) * out)
    crossing, reflected = start + distance * slope, equations.mirror(slope, 0.0)
    mirrored = crossing + distance * reflected
    sine, cosine = np.linalg.norm(np.cross(out, reflected)), np.dot(out, reflected)
    return RayThroughSheet(
        path=np.array(path),
        crossing=crossing,
        straight=crossing + distance * slope,
        mirrored=mirrored,
        angle_error=degrees(np.arctan2(sine, cosine)),
        shift=float(np.linalg.norm(path[-1] - mirrored)),
    )


# ---- Figure 2 ----


@dataclass(frozen=True)
class MirroredTwice:
    """A picture that is mirrored about the vertical, and then about an axis at alpha/2 to the vertical."""

    pictures: tuple[Reals, Reals, Reals]  # unchanged, mirrored once, mirrored twice: (n, n, 3), 0 to 255
    axes: tuple[complex, complex]  # directions of the two axes
    difference: float  # RMS between the last picture and the first rotated by alpha, in a disc; white is 1

    @property
    def difference_power(self) -> int:
        return power_of_ten(self.difference)


def mirror_twice(picture: NDArray[np.uint8], scene: AxialScene, alpha: float, side: int) -> MirroredTwice:
    """Mirror a part of a scene's picture twice, sampled at side x side points. The angle alpha is in radians."""
    step = (np.arange(side) + 0.5) / side * 2 - 1
    point = step - 1j * step[:, None]
    vertical, oblique = 1j, 1j * np.exp(-0.5j * alpha)  # clockwise, as the paper draws it
    once = vertical**2 * point.conj()
    twice = vertical**2 * (oblique**2 * point.conj()).conj()
    sources = point, once, twice, point * np.exp(1j * alpha)
    # the middle of the piece is at about -0.24j
    unchanged, mirrored, turned, expected = (_colours_at(picture, scene, -0.24j + 0.7 * source) for source in sources)
    difference = np.sqrt(np.mean((turned - expected)[abs(point) < 1] ** 2)) / 255
    return MirroredTwice((unchanged, mirrored, turned), (vertical, complex(oblique)), float(difference))


def _colours_at(picture: NDArray[np.uint8], scene: AxialScene, point: Complexes) -> Reals:
    """Return the picture's colours at points of the plane z = 0, interpolated between pixels."""
    tile = picture.shape[0] / scene.view
    x = picture.shape[1] / 2 + point.real * tile - 0.5
    y = picture.shape[0] / 2 - point.imag * tile - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - left)[..., None], (y - top)[..., None]
    above, below = (picture[top + n, left] * (1 - fx) + picture[top + n, left + 1] * fx for n in (0, 1))
    colours: Reals = above * (1 - fy) + below * fy
    return colours


# ---- Figures 3 and 4 ----


@dataclass(frozen=True)
class PieceAgreement:
    """The rotation nu (degrees) and the magnification M of a chess piece about the eye."""

    alpha: float  # degrees
    z1: float
    nu: float
    nu_predicted: float  # eq. 8, corrected
    M: float
    M_predicted: float  # eq. 9, corrected


def pieces(scenes: Sequence[Chess]) -> list[PieceAgreement]:
    """Measure each scene's piece in a frame in which the piece's colours are coordinates."""
    coded = [PiecePositions(**scene.model_dump(exclude={"predicted_image", "direct_image"})) for scene in scenes]
    found = []
    for scene, frame in zip(coded, probes.decoded(coded, SMALL), strict=True):
        a = compare.about_eye(scene, frame, SMALL)
        r, alpha = scene.z2 / scene.z1, radians(scene.alpha)
        nu, M = degrees(equations.nu(r, alpha)), float(equations.M(r, alpha))
        found.append(PieceAgreement(scene.alpha, scene.z1, degrees(np.angle(a)), nu, abs(a), M))
    return found


def horizon_angle(alpha: float) -> float:
    """Measure the angle by which two sheets of prisms rotate the horizon. Both angles are in degrees."""
    measured = degrees(compare.horizon_angle(Directions(sheet="detailed", alpha=alpha), SMALL))
    return alpha + remainder(measured - alpha, 360)


# ---- Figure 5 ----


@dataclass(frozen=True)
class TracedThroughP:
    """The light that reaches E from P, traced backwards, in coordinates with L = 0 and E = 1."""

    prisms: int
    alpha: float  # degrees: the mean rotation of the rays
    distance: float  # from L to the mean point where the rays start


def trace_through_P(alpha: float, z1: float, z2: float) -> TracedThroughP:
    """Trace rays from E through fine prisms near P, back to the plane of L, with L = 0 and E = 1.

    alpha is in radians. z1 and z2 are in units of |E - L|.
    """
    window = 4.0
    prism = Prism(window / 3000)
    place = complex(equations.P(z2 / z1, alpha))
    # A prism shifts a ray one way or the other. The mean over several prisms is not shifted.
    spread = np.random.default_rng(5).uniform(-1, 1, (4000, 2)) * prism.pitch
    direction = np.column_stack((place.real + spread[:, 0] - 1, place.imag + spread[:, 1], np.full(len(spread), z2)))
    rays = trace.trace(np.array([[1.0, 0, -z2]]), direction, trace.pair(alpha, prism), window)
    x, y, z = rays.position[rays.designed].T
    dx, dy, dz = rays.direction[rays.designed].T
    before, after = direction[rays.designed] @ (1, 1j, 0), dx + 1j * dy
    start = x + 1j * y + after / dz * (z1 - z)
    return TracedThroughP(3000, degrees(np.angle(before / after).mean()), float(abs(start.mean())))


# ---- Figure 6 ----


@dataclass(frozen=True)
class SpheresAgreement:
    """Measured against predicted positions. Errors are RMS, in pixels of a picture of 1280x960."""

    targets: int
    located: int
    paraxial_error: float  # from the prediction for prisms of this size
    fine_error: float  # from eq. 7, which is for infinitely small prisms


def spheres(scenes: Sequence[Spheres]) -> SpheresAgreement:
    """Locate a coded square that replaces each sphere. Scenes with alpha = 0 are left out, because of moire."""
    targets = [
        Positions(
            sheet="detailed",
            alpha=scene.alpha,
            z1=z1,
            L=scene.L,
            extent=0.15 * (1 + z1 / scene.z2),
            aperture=scene.aperture,
            view=scene.view,
        )
        for scene in scenes
        for z1 in scene.distances
        if scene.alpha
    ]
    paraxial, fine = [], []
    for target, seen in located(targets, (320, 240)):
        if np.isfinite(seen.position):
            L, E, z1, z2 = target.L, target.E, target.z1, target.z2
            right = equations.apparent_position(L, E, z1, z2, radians(target.alpha))
            paraxial.append(px(abs(seen.position - target.apparent_position(L, z1)), target.view))
            fine.append(px(abs(seen.position - right), target.view))
    return SpheresAgreement(len(targets), len(fine), rms(paraxial), rms(fine))
