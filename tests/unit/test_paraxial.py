"""The prediction for prisms of finite size: eq. 7 in the limit, and the exact ray trace."""

import numpy as np
import pytest
from conftest import glass

from povgen.optics import apparent
from povgen.optics.prism import Prism
from povgen.optics.trace import pair, trace

# index, base angle (degrees) and aspect: the defaults, BK7, and others that differ in each
SHAPES = [
    (1.5, 45, 1),
    (1.7, 40, 1),
    (1.5, 60, 1),
    (2, 45, 0.9),
]


@pytest.mark.parametrize("behind", [(), [(2.0, 0.3)]])
@pytest.mark.parametrize("alpha", [3.135, 3.0, 1.0])
def test_an_object_at_infinite_z1_appears_at_infinity(alpha, behind):
    """Where |A| = |B|, or where there is no such z1, |A| is least."""
    alpha, prism = alpha - sum(turn for _, turn in behind), Prism(0.05)
    windows = glass(6, alpha, prism, behind)
    found = apparent.infinite_z1(windows)
    A, B = apparent.depths(found, windows)
    if not len(found):
        A, B = apparent.depths(np.linspace(0, 100, 1000), windows)
        assert alpha == 1 or behind
        assert (abs(A) > abs(B)).all()
    elif abs(abs(A) - abs(B)).max() < 1e-9:
        assert len({*found}) == len(found) > 0
    else:
        beside = [apparent.depths(found + step, windows)[0] for step in (-0.01, 0.01)]
        assert (abs(A) > abs(B)).all() and (abs(A) < np.abs(beside)).all()


@pytest.mark.parametrize("z1", [5.98, 6.0, 6.03, 3.0])
def test_an_object_at_infinite_alpha_appears_at_infinity(z1):
    prism = Prism(0.05)
    alpha = complex(apparent.infinite_alpha(z1, 6, prism))
    A, B = apparent.depths(z1, glass(6, np.array([alpha.real, -alpha.real]), prism))
    assert (alpha.imag == 0) == (z1 > 5)
    assert abs(A) == pytest.approx(abs(B)) if z1 > 5 else (abs(A) > abs(B)).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_slab_shift_is_that_of_glass_along_the_prism(shape, rng):
    """Rays with a small slope along the ridges leave at a shift from their straight continuation."""
    index, base_angle, aspect = shape
    window = 2.4
    prism = Prism(window / 20, index, base_angle, aspect=aspect)
    slope = 1e-4
    y = rng.uniform(-0.5, 0.5, 5000)
    origin = np.column_stack((np.zeros(5000), y, np.full(5000, -3.0)))
    direction = np.tile([slope, 0, 1.0], (5000, 1))
    sheets = pair(0.0, prism)[1:]
    rays = trace(origin, direction, sheets, window)
    straight = (rays.position[:, 2] + 3) * slope
    shift = (straight - rays.position[:, 0])[rays.designed] / slope
    assert shift == pytest.approx(prism.slab_shift, rel=1e-6)
