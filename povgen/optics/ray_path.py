"""The whole path of rays: their corners, the optical path length, and what the faces do to the light's field.

Arrays begin with the shape of a bundle. `corners` (..., k, 3) are where a ray starts, each face and each ideal sheet
that it meets, and where it ends; NaN after the end. `media` (..., k - 1) are the refractive indices of the straight
parts between them. `glass` (..., k) are those of the glass whose face is at each corner; 1 where there is none. `met`
(..., k) says what is at each corner: the number of a face, IDEAL, or 0 at the start and end.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from povgen.optics.equations import Complexes
from povgen.optics.faces import Floats, Indices
from povgen.optics.polarisation import axes, reflection

IDEAL = -1  # an ideal sheet in `met`
MOST = 10**7  # corners of a bundle, for each of which 40 bytes are needed


class Steps(NamedTuple):
    """Where rays in a window meet faces: `trace.trace` writes into these arrays."""

    place: Floats  # (n, most, 3)
    behind: Floats  # (n, most): the refractive index behind the face
    glass: Floats  # (n, most): that of the face's glass

    @classmethod
    def empty(cls, n: int, most: int) -> "Steps":
        """Return steps for n rays of at most so many faces. Raises ValueError for more than MOST in all."""
        if n * most > MOST:
            raise ValueError(f"path = True: {n} rays of up to {most} faces; allowed: up to {MOST} faces in all")
        return cls(np.empty((n, most, 3)), np.empty((n, most)), np.empty((n, most)))


class Event(NamedTuple):
    """Rays that meet something."""

    ray: Indices  # their numbers, (n,)
    place: Floats  # (n, 3)
    behind: Floats  # the refractive index behind it, (n,)
    glass: Floats  # that of its glass, (n,)
    met: Indices  # (n,)


def assembled(start: Floats, end: Floats, events: Sequence[Event]) -> tuple[Floats, Floats, Floats, Indices]:
    """Return corners (n, k, 3), media (n, k - 1), glass and `met` (n, k) of rays, whose events are in their order."""
    first = np.arange(len(start)), start, np.ones(len(start)), np.ones(len(start)), np.zeros(len(start), int)
    last = first[0], end, *first[2:]
    ray, place, index, glass, met = (np.concatenate(each) for each in zip(first, *events, last, strict=True))
    order = np.argsort(ray, kind="stable")
    count = np.bincount(ray, minlength=len(start))
    number = np.arange(len(ray)) - np.repeat(np.cumsum(count) - count, count)
    shape = len(start), max(count, default=2)
    corners, media = np.full((*shape, 3), np.nan), np.full(shape, np.nan)
    sides, found = np.ones(shape), np.zeros(shape, int)
    for array, values in ((corners, place), (media, index), (sides, glass), (found, met)):
        array[ray[order], number] = values[order]
    beyond = np.isnan(corners[:, 1:, 0])
    return corners, np.where(beyond, np.nan, media[:, :-1]), sides, found


def length(corners: Floats, media: Floats, met: Indices) -> Floats:
    """Return the optical path length of rays from start to end, in the unit of the corners.

    It is NaN for rays that pass an ideal sheet: no glass is there to say how long their path is.
    """
    parts = media * np.linalg.norm(np.diff(corners, axis=-2), axis=-1)
    return np.where((met == IDEAL).any(-1), np.nan, np.nansum(parts, axis=-1))


@np.errstate(invalid="ignore", divide="ignore")
def jones(corners: Floats, media: Floats, glass: Floats, met: Indices) -> Complexes:
    """Return the Jones matrices (..., 2, 2) of rays: what the faces that they meet do to the light's field.

    Axes and phases are those of `polarisation`. The square of an amplitude is a power. The phase of the path in glass
    is left out. At a face that reflects a part of the light, the amplitude is that of the ray's own branch. NaN for
    rays that pass an ideal sheet.
    """
    shape, k = met.shape[:-1], met.shape[-1]
    corners, media = corners.reshape(-1, k, 3), media.reshape(-1, k - 1)
    glass, met = glass.reshape(-1, k), met.reshape(-1, k)
    now = _way(corners[:, 0], corners[:, 1], np.nan)
    field = axes(now).astype(complex)
    for n in range(1, k - 1):
        i = np.flatnonzero(met[:, n] > 0)
        after = _way(corners[i, n], corners[i, n + 1], now[i])
        field[i] = _met(field[i], now[i], after, media[i, n - 1], media[i, n], glass[i, n])
        now[i] = after
    found = np.swapaxes(axes(now), -1, -2) @ field
    return np.where((met == IDEAL).any(-1)[:, None, None], np.nan, found).reshape(*shape, 2, 2)


def _way(start: Floats, end: Floats, before: Floats | float) -> Floats:
    """Return unit vectors (n, 3). A part without a length, as where a ray ends on a face, has the one `before`."""
    size = np.linalg.norm(end - start, axis=-1, keepdims=True)
    return np.where(size > 1e-12, (end - start) / size, before)


def _met(field: Complexes, k: Floats, after: Floats, n1: Floats, n2: Floats, glass: Floats) -> Complexes:
    """Return the fields (n, 3, 2) of rays behind a face that turns their directions from `k` to `after` (n, 3).

    n1 and n2 (n,) are the indices before and behind it, and `glass` is that of its glass.
    """
    reflects = n1 == n2
    normal = np.where(reflects[:, None], after - k, n2[:, None] * after - n1[:, None] * k)
    # along the normal, s is any direction across it
    s, other = np.cross(k, normal), np.where(abs(k[..., :1]) < 0.7, [1.0, 0, 0], [0, 1.0, 0])  # not parallel to k
    s = np.where(np.linalg.norm(s, axis=-1, keepdims=True) > 1e-12, s, np.cross(k, other))
    s = s / np.linalg.norm(s, axis=-1, keepdims=True)
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    outside = np.where(reflects, np.where(n1 > 1, 1.0, glass), n2)
    amplitudes = reflection(n1, outside, np.clip(abs((k * normal).sum(-1)), 0, 1))
    changed = np.zeros_like(field)
    for r, before, behind in zip(amplitudes, (s, np.cross(k, s)), (s, np.cross(after, s)), strict=True):
        r = np.where(reflects, r, np.sqrt(np.maximum(1 - abs(r) ** 2, 0)))
        changed = changed + (r[:, None] * behind)[..., None] * (before[..., None] * field).sum(-2, keepdims=True)
    return changed


def table(corners: Floats, media: Floats, met: Indices) -> dict[str, NDArray[Any]]:
    """Return a table with a row for each corner, as a dictionary of arrays, such as pandas.DataFrame takes.

    `ray` is the number of the ray in the flat bundle, `corner` that of the corner, `x`, `y` and `z` its place in tiles,
    `index` the refractive index behind it (NaN at the end), and `face` what is there, as in `met`.
    """
    there = np.isfinite(corners[..., 0]).reshape(-1, corners.shape[-2])
    ray, corner = np.nonzero(there)
    x, y, z = corners.reshape(-1, corners.shape[-2], 3)[there].T
    behind = np.concatenate((media, np.full((*media.shape[:-1], 1), np.nan)), -1).reshape(there.shape)[there]
    face = met.reshape(there.shape)[there]
    return {"ray": ray, "corner": corner, "x": x, "y": y, "z": z, "index": behind, "face": face}
