"""Sheets of lenses and of other profiles, compared with the exact ray trace and with predictions."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from povgen.measure.measured import SMALL, Measured, px
from povgen.measure.probes import Directions, Positions, Size
from povgen.measure.verify_prisms import pixel_shares, within_the_trace
from povgen.optics.ghosts import Ghost, field
from povgen.optics.profile import confocal
from povgen.optics.rays import Bundle
from povgen.optics.trace import End

# Kinds of sheets, and values of their parameters. The f-numbers are 2.8 or more: of rays through steeper lenses, a few
# percent graze the end of an arc, and rounding decides their path.
PROFILES: tuple[tuple[str, tuple[dict[str, Any], ...]], ...] = (
    (
        "confocal lenticular arrays",
        (
            {"sheet": "lenticular"},
            {"sheet": "lenticular", "alpha": 120, "ratio": 0.7, "f_number": 4, "eye": (0.3, 0.2)},
            {"sheet": "lenticular", "lenses": 400, "f_number": 5, "alpha": 180},
        ),
    ),
    (
        "thin lenticulars, wedges, Dove prisms as a profile",
        (
            {"sheet": "profile", "alpha": 35},
            {"sheet": "profile", "profile": "wedges", "arrangement": "single"},
            {"sheet": "profile", "profile": "dove", "alpha": 90},
        ),
    ),
)

# Errors of building, which the renderer gl does not show
MISMATCHED: tuple[str, tuple[dict[str, Any], ...]] = (
    "lenticular arrays of different pitch",
    (
        {"sheet": "lenticular", "error": {"pitch": 0.05, "far_pitch": -0.03}, "eye": (0.3, 0.2)},
        {"sheet": "lenticular", "error": {"pitch": 0.001}},
    ),
)


def every_pixel(size: Size = SMALL) -> Iterator[Measured]:
    """Compare the direction that every pixel shows with the exact ray trace, stray light and ghosts included."""
    for kind, several in (*PROFILES, MISMATCHED):
        *shares, _ = pixel_shares([Directions(**values) for values in several], size)
        yield from within_the_trace(kind, shares, (99.9, 99))


STRONG = 4  # f-number; below it, spherical aberration blurs ghosts
# f-number, alpha in degrees, and z1 in tiles of lenses whose ghosts are compared
GHOSTS = ((3, 66, 2), (4, 66, 2), (6, 40, 1.5), (6, 40, 3))


def ghosts(scenes: tuple[tuple[float, float, float], ...] = GHOSTS, rays: int = 400_000) -> Iterator[Measured]:
    """Compare the predicted positions of ghosts, and of the object itself, with the ray trace.

    Nothing is rendered. The rays are those from the eye that end near the object and that, in each sheet, leave by the
    lens that is predicted for the ghost. A linear function of their place on the object is fitted to their place in the
    window. The field of view is compared with the formula n p/(4 f) for its greatest slope: n is the refractive index,
    p the pitch and f the focal length.
    """
    own: list[float] = []
    others: dict[bool, list[float]] = {}  # through weak and through strong lenses
    for f_number, alpha, z1 in scenes:
        scene = Positions(sheet="lenticular", f_number=f_number, alpha=alpha, z1=z1, L=0.05 - 0.3j)
        place = np.random.default_rng(1).uniform(-1, 1, (rays, 2)) * scene.aperture / 2
        direction = np.column_stack((place, np.full(rays, scene.z2)))
        found = scene.trace(Bundle(np.array([0, 0, -scene.z2]), direction))
        P, off = place @ (1, 1j), found.at(z1) - scene.L
        near = (found.end == End.THROUGH) & (abs(off) < 0.15)
        itself = Ghost((0, 0), complex(scene.apparent_position(scene.L, z1)), 1.0)
        for ghost in (itself, *scene.ghosts(scene.L, z1)):
            taken = near & (found.orders == ghost.orders).all(1)
            basis = np.column_stack((np.ones(taken.sum()), off[taken].real, off[taken].imag))
            (seen, *_), *_ = np.linalg.lstsq(basis, P[taken], rcond=None)
            errors = others.setdefault(f_number < STRONG, []) if any(ghost.orders) else own
            errors.append(px(abs(seen - ghost.position)))
    yield Measured("detailed", f"lenses: {len(own)} objects against the ray trace, worst", max(own), 3, "px")
    for strong, errors in others.items():
        kind, most = (f"below {STRONG}, spherical aberration", 10) if strong else (f"{STRONG} or more", 5)
        what = f"lenses of f-number {kind}: {len(errors)} ghosts against the ray trace, worst"
        yield Measured("detailed", what, max(errors), most, "px")
    fields = [field(confocal(f_number=f)) / (1.5 / (4 * f)) - 1 for f in (3.0, 6.0, 12.0)]
    what = "lenses: slope up to which the designed path has most light, against n p/(4 f), worst of 3"
    yield Measured("detailed", what, 100 * max(map(abs, fields)), 5, "%")
