"""Whether something is known that does what a law says, judged from the law alone.

The law is applied to random rays. What it does to the transverse part of a unit direction, or to the slope, says which
parts can do it: Dove prisms mirror the transverse part, so that sheets of them can make every orthogonal map; a lens or
a wedge adds to the slope; confocal arrays of lenses multiply it.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

RAYS, PLACES = 40, 12
ENOUGH = 1e-4  # by so much a map may differ from what is meant: laws have numbers of four decimals
EXACT = 1e-9  # a greater difference is stated
STEEP = 0.6  # the greatest slope of the rays


class Buildable(NamedTuple):
    """What can do what a sheet does, and why."""

    parts: (
        str  # optical elements: straight prisms, prisms that change with the place, a lens, lenslets, or nothing known
    )
    reason: str
    page: str  # of the documentation

    def __str__(self) -> str:
        return f"{self.parts}: {self.reason} ({self.page})"


NOTHING = "nothing known"
PRISMS_PAGE = "docs/sheets.md#real-prisms---sheet-detailed"
LAWS_PAGE = "docs/beyond.md#other-ideal-sheets"


class _Within:
    """Says whether a difference is small enough, and keeps the worst one that is."""

    worst = 0.0

    def __call__(self, off: float) -> bool:
        if small := off < ENOUGH:
            self.worst = max(self.worst, float(off))
        return small


def judged(bend: Callable[..., Any], half: float) -> Buildable:
    """Return what can do what a law does. `half` is half the side of its window, tiles.

    `bend` takes unit directions (..., 3) and places (...), x + iy in tiles, and returns unit directions (..., 3), NaN
    where no light passes (`Ideal.bend`). The law's numbers may be rounded to four decimals; the reason then says so.
    """
    within = _Within()
    found = _judged(bend, half, within)
    if within.worst < EXACT or found.parts == NOTHING:
        return found
    return found._replace(reason=f"{found.reason}; the law differs from this by up to {within.worst:.1g}")


def _judged(bend: Callable[..., Any], half: float, within: _Within) -> Buildable:
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-half, half, (2, PLACES, 1))
    slope = STEEP * np.sqrt(rng.uniform(size=(1, RAYS))) * np.exp(2j * np.pi * rng.uniform(size=(1, RAYS)))
    before = np.stack((slope.real, slope.imag, np.ones((1, RAYS))), -1)
    before = np.broadcast_to(before / np.linalg.norm(before, axis=-1, keepdims=True), (PLACES, RAYS, 3))
    after = bend(before, np.broadcast_to(x + 1j * y, (PLACES, RAYS)))
    if not np.isfinite(after).any():
        return Buildable(NOTHING, "no light passes", LAWS_PAGE)
    passes = np.isfinite(after[..., 0]).all()
    turns, off = _linear(before[..., :2], after[..., :2])
    kept = np.nanmax(abs(after[..., 2] - before[..., 2]))
    if within(max(kept, off)):
        return _prisms(turns, within)
    maps, off = _linear(before[..., :2] / before[..., 2:], after[..., :2] / after[..., 2:], shifted=True)
    if passes and within(off):
        return _lenses(maps, _curl(bend, x[:, 0] + 1j * y[:, 0], 1e-5 * half), within)
    said = (
        "it keeps the component of a direction along the normal, but is not linear"
        if kept < ENOUGH
        else (
            "it is linear neither in the directions' transverse part, as prisms are, nor in the slope, as lenses are; "
            "near the normal lenslets come close to a law that is smooth there"
        )
    )
    return Buildable(NOTHING, said, LAWS_PAGE)


def _linear(before: Any, after: Any, shifted: bool = False) -> tuple[Any, float]:  # noqa: ANN401
    """Return the linear maps (places, 2, 2 or 3) of vectors to vectors (places, rays, 2), and how far off they are."""
    maps, off = [], 0.0
    for one, other in zip(before, after, strict=True):
        there = np.isfinite(other[:, 0])
        if there.sum() > 5:
            basis = np.column_stack((one, np.ones(len(one)))) if shifted else one
            found, *_ = np.linalg.lstsq(basis[there], other[there], rcond=None)
            maps.append(found.T)
            off = max(off, float(abs(basis[there] @ found - other[there]).max()))
    return np.array(maps), off


def _curl(bend: Callable[..., Any], places: Any, step: float) -> float:  # noqa: ANN401
    """Return the greatest curl of the slopes behind the sheet, as a field over places (n,), of light along z."""
    steps = np.array([step, -step, 1j * step, -1j * step])[:, None]
    behind = bend(np.broadcast_to([0.0, 0, 1], (4, len(places), 3)), places + steps)
    slopes = behind[..., :2] / behind[..., 2:]
    by_x, by_y = (slopes[0] - slopes[1]) / (2 * step), (slopes[2] - slopes[3]) / (2 * step)
    return float(abs(by_x[:, 1] - by_y[:, 0]).max())


def _prisms(turns: Any, within: _Within) -> Buildable:  # noqa: ANN401
    """Return what makes these orthogonal maps of the transverse part, (places, 2, 2), one for each place."""
    mirrors = np.linalg.det(turns) < 0
    one = "a sheet of Dove prisms mirrors" if mirrors.all() else "two sheets of Dove prisms turn"
    if not within(np.ptp(turns, axis=0).max()):
        said = f"{one} light by an angle that depends on the place: their ridges have to curve, or to come in patches"
        return Buildable("prisms that change with the place", said, LAWS_PAGE)
    if within(abs(turns[0] - np.eye(2)).max()):
        return Buildable("straight prisms", "it changes nothing, and needs none", PRISMS_PAGE)
    return Buildable("straight prisms", f"{one} light in this way, the same everywhere", PRISMS_PAGE)


def _lenses(maps: Any, curl: float, within: _Within) -> Buildable:  # noqa: ANN401
    """Return what makes these maps (places, 2, 3) of slopes: a matrix and a shift, one for each place.

    The curl is the greatest of the shift, as a field of slopes over the sheet.
    """
    if not within(np.ptp(maps[..., :2], axis=0).max()):
        return Buildable(NOTHING, "it multiplies the slope by a factor that depends on the place", LAWS_PAGE)
    matrix, shift = maps[0, :, :2], maps[:, :, 2]
    left, sizes, right = np.linalg.svd(matrix)
    if sizes[1] < ENOUGH:
        return Buildable(NOTHING, "it maps different slopes to one", LAWS_PAGE)
    parts, reasons = [], []
    if not within(abs(sizes - 1).max()):
        parts.append("lenslets")
        positive = abs(left @ right - np.eye(2)).max() < ENOUGH
        concave = ", by a positive factor if one array is concave" if positive else ""
        reasons.append(f"confocal arrays of lenses multiply the slope{concave}")
    # a factor -1 belongs to the lenses: it is the sign of their focal lengths
    if not within(min(abs(left @ right - sign * np.eye(2)).max() for sign in ((1, -1) if parts else (1,)))):
        parts.append("straight prisms")
        reasons.append("sheets of Dove prisms turn or mirror it")
    if not within(abs(shift).max()):
        if curl > 1e-6:
            parts.append("wedges that change with the place")
            reasons.append(
                "what it adds to the slope has a curl, which no surface makes: small wedges do, piece by piece"
            )
        else:
            parts.append("a wedge" if within(np.ptp(shift, axis=0).max()) else "a lens")
            reasons.append("what it adds to the slope has no curl: one surface makes it, for small angles")
    return Buildable(" and ".join(parts), "; ".join(reasons), LAWS_PAGE)
