"""Ways to compare what probes show with the equations and the exact ray trace. `verify` has the table of checks.

A way takes scenes and a picture size, and returns numbers. The first of them have bounds; others stand in the text.
"""

from collections.abc import Callable, Iterator, Sequence
from math import degrees, pi, radians
from typing import Any, NamedTuple

import numpy as np

from povgen import limits
from povgen.measure import probes
from povgen.measure.irradiance import irradiance
from povgen.measure.measured import px, rms
from povgen.measure.probes import Directions, Floats, Light, Mask, PiecePositions, Positions, Size, White
from povgen.measure.targets import located, unit
from povgen.optics import equations
from povgen.optics.ghosts import Ghost, field
from povgen.optics.polarisation import transmission
from povgen.optics.profile import confocal
from povgen.optics.rays import Bundle, Traced
from povgen.optics.trace import End
from povgen.scene import camera, survey
from povgen.scene.presets import AxialScene

Numbers = Sequence[float]
SCREEN, PIXELS = 6.0, 48  # the side of the screen of `screens`, tiles and pixels
Way = Callable[[Sequence[Any], Size], Numbers]


class WindowRays(NamedTuple):
    """The rays from the eye to the pixels that show the window."""

    inside: Mask  # (height, width): the pixels
    direction: Floats  # (n, 3): unit vectors from the eye
    traced: Traced  # by the exact ray trace, as far as POV-Ray follows rays
    leaves: Mask  # (n,): rays that leave the sheets before POV-Ray ends them


def window_rays(scene: AxialScene, size: Size) -> WindowRays:
    """Trace the rays to the pixels of the window."""
    inside, direction = camera.rays(scene, size)
    most = survey.max_trace_level(scene)
    traced = scene.trace(scene.camera.along(direction), most)
    return WindowRays(inside, direction, traced, (traced.end <= End.BACK) & (traced.count < most))


# ---- Ideal sheets ----


def positions(scenes: Sequence[Positions], size: Size) -> Numbers:
    """Return the greatest distance, px, of an apparent position from `Scene.apparent_position`, and for one window that
    rotates light also the greatest error of nu, degrees, and of M, percent."""
    off = [
        (px(abs(seen.position - scene.apparent_position(scene.L, scene.z1))), *_turn_and_scale(scene, seen.a))
        for scene, seen in located(scenes, size)
    ]
    place, turn, scale = np.max(off, axis=0)  # numpy's max keeps NaN
    return place, turn, scale


def directions(scenes: Sequence[Directions], size: Size) -> Numbers:
    """Return the greatest angle, radians, between what a pixel shows and the direction that ideal windows rotate."""
    worst = []
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        rays = window_rays(scene, size)
        through = rays.traced.end == End.THROUGH
        off = np.linalg.norm(unit(decoded[rays.inside][through]) - rays.traced.direction[through], axis=1)
        worst.append(np.nan_to_num(off, nan=np.inf).max())
    return (np.max(worst),)


def pieces(scenes: Sequence[PiecePositions], size: Size) -> Numbers:
    """Return the greatest error of nu, degrees, and of M, percent, of chess pieces."""
    seen = zip(scenes, probes.decoded(scenes, size), strict=True)
    off = [_turn_and_scale(scene, about_eye(scene, decoded, size)) for scene, decoded in seen]
    turn, scale = np.max(off, axis=0)
    return turn, scale


def _turn_and_scale(scene: Positions | PiecePositions, a: complex) -> Numbers:
    """Return the errors of nu, degrees, and of M, percent, of an object that appears turned and scaled by `a`."""
    r, alpha = scene.z2 / scene.z1, radians(scene.alpha)
    turn = degrees(abs(np.angle(a * np.exp(-1j * equations.nu(r, alpha)))))
    return turn, 100 * abs(abs(a) / equations.M(r, alpha) - 1)


def about_eye(scene: PiecePositions, decoded: Floats, size: Size) -> complex:
    """Return the factor from positions on a piece to their apparent positions, relative to E, at the piece's axis.

    A piece is as deep as it is wide, and its farther parts appear turned by more. Therefore the complex factor is
    fitted as a polynomial of the depth, of degree 3 or, far away, less.
    """
    inside, direction = camera.rays(scene, size)
    if scene.sheet == "detailed":  # stray light shows other places of the piece
        inside[inside] = scene.trace(scene.camera.along(direction)).designed
    inside &= ~np.isnan(decoded[..., 0])
    x, y, depth = decoded[inside].T
    from_eye = scene.L + x + 1j * y - scene.E
    powers = [power for power in range(4) if (0.5 / scene.z1) ** power > 1e-3]  # far away, depth matters less
    basis = from_eye[:, None] * depth[:, None] ** powers
    target = scene.camera.pixels(size)[inside] - scene.E
    return complex(probes.fitted(basis, target)[0][0])


def horizon(scenes: Sequence[Directions], size: Size) -> Numbers:
    """Return the greatest difference, degrees, of the angle by which the horizon appears turned from alpha."""
    off = np.array([horizon_angle(scene, size) - radians(scene.alpha) for scene in scenes])
    return (degrees(np.max(abs((off + pi) % (2 * pi) - pi))),)


def horizon_angle(scene: Directions, size: Size) -> float:
    """Return the angle, radians, by which the horizon appears turned. The fit drops stray light.

    The horizon appears as a line through E.
    """
    (decoded,) = probes.decoded([scene], size)
    inside, _ = camera.rays(scene, size)
    inside &= ~np.isnan(decoded[..., 0])
    slope = decoded[inside][:, 1] / decoded[inside][:, 2]
    position = scene.camera.pixels(size)[inside]
    (x, y), _ = probes.fitted(np.column_stack((position.real, position.imag)), slope, rounds=8)
    return float(np.arctan2(y, x) - pi / 2)  # the horizon is perpendicular to the slope's gradient


def parallax(scenes: Sequence[Positions], size: Size) -> Numbers:
    """Return the greatest error, percent, of the image distance by the parallax between two eyes: pairs of scenes.

    The lines of sight from two eyes to the object cross in the image: z tiles behind the plane z = 0. The measured z is
    complex, and its imaginary part is 0 if they cross.
    """
    off, seen = [], [each for _, each in located(scenes, size)]
    for one, other, left, right in zip(scenes[::2], scenes[1::2], seen[::2], seen[1::2], strict=True):
        z2_over_distance = 1 - (left.position - right.position) / (one.E - other.E)
        expected, _ = one.image_plane([one.L], one.z1)
        off.append(100 * abs(one.z2 / z2_over_distance - one.z2 - expected) / abs(expected))
    return (np.max(off),)


# ---- Sheets of glass ----


def pixels(scenes: Sequence[Directions], size: Size) -> Numbers:
    """Return the percentages of pixels that show the direction of the ray trace within 1e-3 rad.

    The first is of the pixels on the designed path, the second of all whose rays leave.
    """
    designed, agree = [], []
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        rays = window_rays(scene, size)
        off = np.nan_to_num(np.linalg.norm(decoded[rays.inside] - rays.traced.direction, axis=1), nan=np.inf)
        designed.append((off < 1e-3)[rays.leaves & rays.traced.designed])
        agree.append((off < 1e-3)[rays.leaves])
    return 100 * np.concatenate(designed).mean(), 100 * np.concatenate(agree).mean()


def prediction(scenes: Sequence[Positions], size: Size) -> Numbers:
    """Return the paraxial prediction's error as a fraction of eq. 7's error, and the prediction's error in px."""
    thin, thick = errors(scenes, size)
    return thick / thin, px(thick)


def errors(scenes: Sequence[Positions], size: Size) -> tuple[float, float]:
    """Return the errors of eq. 7 and of the scenes' paraxial predictions, RMS over the scenes, in tiles.

    For windows in series, the complex depth takes the place of eq. 7.
    """
    thin, thick = [], []
    for scene, seen in located(scenes, size):
        ideal = equations.apparent_position(scene.L, scene.E, scene.z1, scene.z2, radians(scene.alpha), scene.behind)
        thin.append(abs(seen.position - ideal))
        thick.append(abs(seen.position - scene.apparent_position(scene.L, scene.z1)))
    return rms(thin), rms(thick)


def power_law(scenes: Sequence[Positions], size: Size) -> Numbers:
    """Return |k + 1| if the error of eq. 7 falls as the number of prisms to the power k."""
    counts = sorted({scene.prisms for scene in scenes})
    thin = [errors([scene for scene in scenes if scene.prisms == count], size)[0] for count in counts]
    return (abs(np.polyfit(np.log(counts), np.log(thin), 1)[0] + 1),)


def ghosts(scenes: Sequence[Positions], size: Size) -> Numbers:
    """Return the greatest distance, px, of the objects from their predictions, and of their ghosts through lenses.

    The third number is how many ghosts there are. Nothing is rendered: as many rays are traced as a picture of this
    size has pixels. They are those from the eye that end near the object and that, in each sheet, leave by the lens
    that is predicted for the ghost. A linear function of their place on the object is fitted to their place in the
    window.
    """
    own: list[float] = []
    others: list[float] = []
    for scene in scenes:
        place = np.random.default_rng(1).uniform(-1, 1, (size[0] * size[1], 2)) * scene.aperture / 2
        direction = np.column_stack((place, np.full(len(place), scene.z2)))
        found = scene.trace(Bundle(np.array([0, 0, -scene.z2]), direction))
        P, off = place @ (1, 1j), found.at(scene.z1) - scene.L
        near = (found.end == End.THROUGH) & (abs(off) < 0.15)
        itself = Ghost((0, 0), complex(scene.apparent_position(scene.L, scene.z1)), 1.0)
        for ghost in (itself, *scene.ghosts(scene.L, scene.z1)):
            taken = near & (found.orders == ghost.orders).all(1)
            basis = np.column_stack((np.ones(taken.sum()), off[taken].real, off[taken].imag))
            (seen, *_), *_ = np.linalg.lstsq(basis, P[taken], rcond=None)
            (others if any(ghost.orders) else own).append(px(abs(seen - ghost.position)))
    return max(own), max(others), len(others)


def screens(scenes: Sequence[Positions], size: Size) -> Numbers:
    """Compare the irradiance on a screen at the eye's distance, by light of a point at L, with the law of cos^3.

    Light from L to a point of the screen passes the window at P of eq. 7, and the area of the window is enlarged as P
    says. Return how much the RMS of the differences, divided by their standard errors, differs from 1, and how much the
    power that enters differs from the window's solid angle, percent. The worst of the scenes.
    """
    half, off, power = SCREEN / 2, [], []
    middles = half * ((np.arange(PIXELS) + 0.5) * 2 / PIXELS - 1)
    Q = middles - 1j * middles[:, None]
    for scene in scenes:
        L, z1 = scene.L, scene.z1
        found = irradiance(scene, (L.real, L.imag, z1), -scene.z2, extent=(-half, half) * 2, size=(PIXELS, PIXELS))
        alpha = radians(scene.sheets[0].values.get("alpha", 0))
        P = equations.apparent_position(L, Q, z1, scene.z2, alpha)
        enlarged = abs(1 - scene.z2 / equations.depth(z1, scene.z2, alpha)) ** 2
        law = z1 / np.hypot(z1, abs(P - L)) ** 3 * enlarged
        inside = np.maximum(abs(P.real), abs(P.imag)) < 0.8 * scene.aperture / 2
        off.append(abs(rms((found.total - law)[inside] / found.error[inside]) - 1))
        x, y = (np.array([-0.5, 0.5]) * scene.aperture - part for part in (L.real, L.imag))
        z = z1 - scene.depth / 2
        corner = np.arctan(x * y[:, None] / (z * np.sqrt(x**2 + y[:, None] ** 2 + z**2)))
        power.append(100 * abs(found.entering / (corner[0, 0] - corner[0, 1] - corner[1, 0] + corner[1, 1]) - 1))
    return max(off), max(power)


def field_of_view(scenes: Sequence[AxialScene], size: Size) -> Numbers:
    """Compare the slope up to which lenses' designed path has most light with n p/(4 f). Return the worst, percent.

    n is the refractive index, p the pitch and f the focal length.
    """
    slopes = [field(confocal(f_number=scene.f_number)) / (scene.index / (4 * scene.f_number)) for scene in scenes]
    return (100 * max(abs(slope - 1) for slope in slopes),)


def designed_fraction(scenes: Sequence[Directions], size: Size) -> Numbers:
    """Return the greatest difference of the two fractions of `fractions`, and the least and greatest field angle."""
    found = list(fractions(scenes, size)) or [(np.nan,) * 4]
    angles = [angle for _, angle, *_ in found]
    return max(abs(rendered - exact) for *_, rendered, exact in found), min(angles), max(angles)


def fractions(scenes: Sequence[Directions], size: Size) -> Iterator[tuple[float, float, float, float]]:
    """Yield alpha, field angle, and two fractions of pixels that show light turned by alpha: rendered, and traced.

    Angles are in degrees. Pixels are grouped by field angle, in rings 5 degrees wide. The field angle is that of the
    ring's middle. Rings of 500 pixels or fewer are left out.
    """
    for scene, decoded in zip(scenes, probes.decoded(scenes, size), strict=True):
        rays = window_rays(scene, size)
        turned = equations.rotate(rays.direction, radians(scene.alpha))
        rendered = np.linalg.norm(decoded[rays.inside] - turned, axis=1) < 1e-3
        exact = (np.linalg.norm(rays.traced.direction - turned, axis=1) < 1e-3) & rays.leaves
        exact &= rays.traced.end == End.THROUGH
        rings = np.degrees(np.arccos(rays.direction[:, 2])) // 5
        for ring in np.unique(rings):
            shown = rings == ring
            if shown.sum() > 500:
                yield scene.alpha, float(5 * ring + 2.5), rendered[shown].mean(), exact[shown].mean()


# ---- Light ----


def black_tops(scenes: Sequence[Directions], size: Size) -> Numbers:
    """Return how many percent of the pixels are black as in the ray trace, and how many are black."""
    (scene,), (decoded,) = scenes, probes.decoded(scenes, size)
    rays = window_rays(scene, size)
    black = rays.traced.end == End.ABSORBED
    known = rays.leaves | black
    agree = (np.isnan(decoded[rays.inside][:, 0]) == black)[known]
    return 100 * agree.mean(), 100 * black[known].mean()


def partial_reflection(scenes: Sequence[Light], size: Size) -> Numbers:
    """Compare the brightness of light on the designed path with the Fresnel equations, if faces also reflect light.

    Return the difference that 99 % of the pixels do not exceed, the difference of the means of this brightness and of
    that of polarised light, and both means.
    """
    (scene,) = scenes
    inside, direction = camera.rays(scene, size)
    traced = scene.trace(scene.camera.along(direction), partial=np.random.default_rng(1), path=True)
    clear = (probes.brightness(scene.replace(fresnel=False), size)[inside] > 0.99) & traced.designed
    seen = probes.brightness(scene, size)[inside][clear]
    off = np.quantile(abs(seen - traced.light[clear]), 0.99)
    polarised = transmission(traced.jones[clear]).mean()
    return float(off), abs(seen.mean() - polarised), seen.mean(), polarised


def reflected_light(scenes: Sequence[White], size: Size) -> Numbers:
    """Compare the window's mean brightness with the ray trace, for partial reflection and white surroundings.

    Return the difference, the brightness, and how many percent of the light has been partially reflected.
    """
    (scene,) = scenes
    inside, direction = camera.rays(scene, size)
    seen = probes.brightness(scene, size)[inside].mean()
    repeated = np.tile(direction, (100_000 // len(direction) + 1, 1))
    # through more faces than POV-Ray follows: its max_trace_level should cost no light
    most = 2 * limits.MAX_FACES
    found = scene.trace(scene.camera.along(repeated), most, partial=np.random.default_rng(1))
    followed = (found.end <= End.BACK) & (found.light >= limits.LEAST_LIGHT)
    return abs(seen - followed.mean()), seen, 100 * found.reflected[followed].mean()
