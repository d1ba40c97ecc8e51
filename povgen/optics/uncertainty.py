"""By how far a prediction for prisms of finite size can be wrong. Signs are as in `apparent`. Lengths are in tiles."""

from typing import NamedTuple

import numpy as np

from povgen.optics import apparent, paraxial
from povgen.optics.equations import Complexes, Floats

# The errors hold for apparent radii in this range, tiles. A radius outside it counts as the nearer limit.
RADII = (0.05, 0.25)
# The least apparent radius of an object that averages the displacements over a period, in periods
OWN = 1.0  # of the prisms in one sheet
BANDS = 0.6  # of the dark bands (moire) that two sheets make together
FALL = 0.15  # radians: at a field angle greater by this, much less light takes the designed path
OTHER_RAY = 1.2  # factor for errors of slopes, because they depend on the ray, and the object's rays differ
_ROUNDS = 30  # iterations, at most, to find the ray that reaches the object
_STEP = 1e-6  # of the slopes of neighbouring rays


class Layer(NamedTuple):
    """A sheet of prisms that a ray crosses, and its spatial frequency as the eye sees it."""

    # The spatial frequency in the first window's plane: there, for the eye, a step d leads across Im(k d) prisms.
    # So 1/|k| is the apparent pitch. The step i conj(k) leads straight across the prisms.
    k: complex
    n: float  # refractive index of its glass
    does: paraxial.SmallAngles  # what the sheet does to light at small angles
    tangent: float  # of the angle between the ray and the normal, in front of the sheet's window
    blur: float  # RMS difference of slopes behind it from their mean: for this ray, but at least `does.blur`


def layers(P: complex, E: complex, windows: apparent.Windows) -> list[Layer]:
    """Return every sheet of prisms or lenses that the ray from the eye E through P crosses.

    P lies in the first window's plane.
    """
    found = []
    z2 = windows[0][0]
    for (place, slope, *_), (_, window) in zip(_neighbours(P, E, windows), windows, strict=True):
        ray = np.zeros((5, 3))  # two columns: how the ray changes with the slope at the eye; and the ray itself
        ray[:4, :2] = np.vstack((_derivative(place), _derivative(slope)))
        ray[:, 2] = place[0].real, place[0].imag, slope[0].real, slope[0].imag, 1
        z = 0.0
        for sheet in window.glass:
            ray, z = paraxial.free(sheet.centre - z) @ ray, sheet.centre
            across = np.array([-np.sin(sheet.angle), np.cos(sheet.angle)]) @ ray[:2, :2] / (z2 * sheet.shape.pitch)
            does = paraxial.small_angles(sheet.shape)
            own_slope = complex(ray[2, 2], ray[3, 2]) * np.exp(-1j * sheet.angle)
            place = float(np.array([-np.sin(sheet.angle), np.cos(sheet.angle)]) @ ray[:2, 2])
            blur = np.fmax(does.blur, paraxial.mean_slope(sheet.shape, own_slope, place)[1])
            k, index = complex(across[1], across[0]), sheet.shape.index
            found.append(Layer(k, index, does, float(abs(slope[0])), float(blur)))
            ray = paraxial.layer(sheet) @ ray
    return found


def possible_error(P: complex, E: complex, z1: float, radius: float, windows: apparent.Windows) -> float:
    """Estimate how far, at most, an object at z1 appears from P, its predicted position.

    `radius` is the object's, and z1 its distance behind the last window. At least one window consists of prisms or
    lenses. The result is a distance in the plane of the first window. It is infinite if the object appears at infinity,
    or if the ray through P does not reach it. The error has four parts:

    - A prism displaces light across its ridges, for an aspect of 1 by up to its height. The prediction uses the mean
      displacement over a prism, which is zero. An object that covers only a part of a prism does not show this mean.
      Sheets whose prisms look nearly parallel to the eye make dark bands (moire). In a band their displacements can add
      up. So an object that covers only a part of a band does not show the mean either. This part of the error is
      greatest, and constant, up to an apparent radius of OWN prisms or BANDS bands. For a greater radius it decreases
      as 1/radius^4.
    - Light is shifted along the ridges. The prediction is a shift proportional to the slope. The shift by a slab of
      glass is greater by the fraction (n + 1)/(2 n^2) slope^2.
    - At greater field angles, less light takes the designed path. So if displacements spread the light of an object,
      the centre of this light is nearer to E.
    - Lenses with spherical aberration, oblique facets, and lenses that are not opposite each other turn light on the
      designed path by other angles than the predicted ones, which hold for small slopes. So the mean of this light
      reaches the object from another place than P, which is searched for. The light is also spread.

    OWN, BANDS and FALL are fitted to ray traces: docs/accuracy.md.
    """
    *_, place, slope = _neighbours(P, E, windows)[-1]
    to_object = _derivative(place + z1 * slope)
    if not np.isfinite(to_object).all():
        return np.inf
    z2 = windows[0][0]
    sizes = np.linalg.svd(to_object, compute_uv=False)
    if sizes[1] <= 1e-9 * z2:
        return np.inf
    scale = float(z2 / sizes[1])  # how far the object appears to move if the windows displace light by one unit
    apparent = np.clip(radius * np.mean(z2 / sizes), *RADII)
    glass = layers(P, E, windows)

    def share(frequency: complex, least: float) -> float:
        covered = abs(frequency) * apparent
        return float((least / covered) ** 4) if covered > least else 1.0

    spreads = [scale * layer.does.reach for layer in glass]
    shares = []
    for one, spread in zip(glass, spreads, strict=True):
        bands = [share(one.k + sign * other.k, BANDS) for other in glass if other is not one for sign in (1, -1)]
        shares.append(spread * max([share(one.k, OWN), *bands]))
    beyond = sum(each.does.slab_shift * each.tangent**3 * (each.n + 1) / (2 * each.n**2) for each in glass)
    spread = OTHER_RAY * z1 * sum(each.blur for each in glass)
    L, exact = complex(place[0] + z1 * slope[0]), P
    for _ in range(_ROUNDS):
        miss = L - _end(exact, E, z1, windows)
        if not np.isfinite(miss):
            return np.inf
        step = z2 * np.linalg.solve(to_object, [miss.real, miss.imag])
        exact += complex(*step)
        if np.linalg.norm(step) <= 0.01 * abs(exact - P) + 1e-6 * z2:
            break
    moved = OTHER_RAY * abs(exact - P)
    return max(2 * max(shares), sum(shares)) + scale * (beyond + spread) + moved + max(spreads) ** 2 / (FALL * z2)


def _end(P: complex, E: complex, z1: float, windows: apparent.Windows) -> complex:
    """Return where the ray through P ends, a distance z1 behind the last window.

    Behind each sheet it has the mean slope of the light on the designed path, NaN if there is none.
    """
    s, place = (P - E) / windows[0][0], E
    for distance, window in windows:
        sheets = window.glass
        if not sheets:
            _, _, place, s = apparent.follow(s, place, [(distance, window)])[0]
            continue
        ray, z = np.array([place.real, place.imag, s.real, s.imag, 1]), -distance
        for sheet in sheets:
            ray, z = paraxial.free(sheet.centre - z) @ ray, sheet.centre
            ridges = np.exp(1j * sheet.angle)
            along, across = (complex(*ray[part]) / ridges for part in (slice(2, 4), slice(2)))
            slope = paraxial.mean_slope(sheet.shape, along, across.imag)[0] * ridges
            ray = paraxial.layer(sheet) @ ray
            ray[2:4] = slope.real, slope.imag
        place, s = complex(*(paraxial.free(-z) @ ray)[:2]), complex(*ray[2:4])
    return complex(place + z1 * s)


def _neighbours(P: complex, E: complex, windows: apparent.Windows) -> list[tuple[Complexes, ...]]:
    """Follow the ray through P and four rays whose slopes are a small step to the right, left, up and down."""
    steps = np.array([0, _STEP, -_STEP, 1j * _STEP, -1j * _STEP])
    return apparent.follow((P - E) / windows[0][0] + steps, E, windows)


def _derivative(values: Complexes) -> Floats:
    """Return the Jacobian matrix (2, 2) of `values`, which are points x + iy on the rays of `_neighbours`.

    The variable is the slope at the eye.
    """
    _, right, left, up, down = values
    columns = np.array([right - left, up - down]) / (2 * _STEP)
    return np.array([columns.real, columns.imag])
