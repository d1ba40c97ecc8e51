"""Shares of the rays that meet a window."""

from dataclasses import astuple

import numpy as np
import pytest

from povgen.optics.prism import Prism
from povgen.optics.shares import shares
from povgen.optics.trace import Face, Sheet, pair, trace

WINDOW = 2.4


def found(index=1.5, base_angle=45.0, aspect=1.0, n=110):
    """Trace rays from z2 = 6 to the whole window: alpha = 66 degrees, 100 prisms."""
    prism = Prism(WINDOW / 100, index, base_angle, aspect=aspect)
    random = np.random.default_rng(66)
    x, y = WINDOW / 2 * (2 * (np.indices((n, n)) + random.uniform(size=(2, n, n))).reshape(2, -1) / n - 1)
    direction = np.column_stack((x, y, np.full(n * n, 6.0)))
    return trace([[0, 0, -6]], direction, pair(np.radians(66), prism), WINDOW, prism)


@pytest.mark.parametrize(
    ("shape", "designed"),
    [
        ((1.5, 45, 1), 0.596),
        ((1.5, 35, 1), 0.623),
        ((1.5, 60, 1), 0.459),
        ((1.7, 40, 1), 0.664),
        ((1.5, 45, 0.9), 0.605),
    ],
)
def test_the_share_on_the_designed_path(shape, designed):
    rays = found(*shape)
    glass, black = shares(rays), shares(rays, black_tops=True)
    assert glass.designed == black.designed == pytest.approx(designed, abs=0.015)
    for each in (glass, black):
        assert sum(astuple(each)) == pytest.approx(1)
    assert glass.absorbed == 0 < black.absorbed
    for name in ("stray", "back", "frame", "unfinished"):
        assert getattr(black, name) <= getattr(glass, name)


def test_black_tops_take_most_of_the_stray_light():
    rays = found()
    glass, black = shares(rays), shares(rays, black_tops=True)
    assert glass.stray == pytest.approx(0.30, abs=0.015)
    assert black.stray == pytest.approx(0.082, abs=0.01)


def test_rays_meet_tops_from_inside_and_from_the_gap():
    """By hand: a ray that the base reflects up to the top of a long prism, and one that runs down through the gap."""
    prism = Prism(WINDOW / 10, gap=0.2, aspect=1.5)
    sheet = (Sheet(0.0, 0.0),)
    base = -WINDOW / 2 + prism.gap * prism.pitch / 2 + 5 * prism.pitch  # of a prism in the middle
    inside = trace([[0, base + 0.1 * prism.height, -1]], [[0, 0, 1]], sheet, WINDOW, prism)
    assert list(inside.faces[0, :3]) == [Face.NEAR, Face.BASE, Face.TOP]
    width, edge = prism.pitch - prism.height, prism.top_length / 2  # at z = -edge it is in the middle of the gap
    slope = -width / 2 / edge
    start = base + prism.height + width / 2 + slope * (edge - 1)
    gap = trace([[0, start, -1]], [[0, slope, 1]], sheet, WINDOW, prism)
    assert gap.faces[0, 0] == Face.TOP
    assert shares(inside, True).absorbed == shares(gap, True).absorbed == 1
    assert shares(inside).absorbed == shares(gap).absorbed == 0
