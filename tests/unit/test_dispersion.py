"""Dispersion: none on the designed path, by exact arithmetic and in the ray trace; coloured stray light."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from povgen.optics import dispersion
from povgen.optics.prism import Prism
from povgen.optics.trace import pair, trace

WINDOW = 2.4


def rational_unit(*tangents):
    """Return a vector of rational numbers with the length 1, from stereographic coordinates."""
    size = sum(t * t for t in tangents)
    return [2 * t / (1 + size) for t in tangents] + [(1 - size) / (1 + size)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


RATIONAL = st.fractions(Fraction(1, 50), Fraction(4, 5), max_denominator=100)


@given(RATIONAL, RATIONAL, RATIONAL, st.fractions(Fraction(1, 10), 4, max_denominator=50))
def test_the_designed_path_keeps_the_direction_for_every_index(x, y, facet, m):
    """In rational numbers, so without any rounding: light leaves along Rk, whatever the index (`dispersion`).

    m is the multiple of the normal that the first refraction adds. The index follows from it.
    """
    k = rational_unit(x, y)
    u, z = rational_unit(facet)
    N = [Fraction(0), -u, z]  # against the outward normal of the facet that light enters by
    glass = [a + m * b for a, b in zip(k, N, strict=True)]
    square = dot(glass, glass)  # of the index: the tangential part is conserved, and this is the length in the glass
    after_base = [glass[0], -glass[1], glass[2]]
    N_exit = [Fraction(0), u, z]
    # the last refraction adds t N_exit such that the length is 1: a quadratic equation, one solution refracts
    half, rest = dot(after_base, N_exit), square - 1
    root = dot(k, N)  # its square is the discriminant, so that the solution is rational
    assert half**2 - rest == root**2
    t = -half + root
    leaves = [a + t * b for a, b in zip(after_base, N_exit, strict=True)]
    assert leaves == [k[0], -k[1], k[2]] and t == -m


def colours(prism, n=50, z2=6.0):
    """Trace the same rays in the lines F and C through sheets of one shape."""
    x, y = WINDOW / 2 * (2 * (np.indices((n, n)) + 0.4).reshape(2, -1) / n - 1)
    direction = np.column_stack((x, y, np.full(n * n, z2)))
    found = []
    for line in (dispersion.F, dispersion.C):
        glass = dispersion.in_colour(prism, float(dispersion.bk7(line)))
        assert glass.length == pytest.approx(prism.length) and glass.height == prism.height
        found.append(trace([[0, 0, -z2]], direction, pair(np.radians(66), glass), WINDOW, glass))
    return found


def test_the_index_of_bk7():
    """Schott's data sheet: n_F, n_d and n_C, and the Abbe number 64.17."""
    n = dispersion.bk7([dispersion.F, dispersion.D, dispersion.C])
    assert n == pytest.approx([1.52238, 1.51680, 1.51432], abs=5e-6)
    assert (n[1] - 1) / (n[0] - n[2]) == pytest.approx(64.17, abs=0.01)


def test_wavelengths_beyond_the_formulas_range_are_refused():
    assert np.isfinite(dispersion.bk7([0.3e-6, 2.5e-6])).all() and np.isnan(dispersion.bk7(np.nan))
    for wrong in (0.29e-6, 2.51e-6, -550e-9, 0.55, [550e-9, 0.55], np.inf):
        with pytest.raises(ValueError, match=r"^wavelength = .*; allowed: 3e-07 to 2.5e-06 metres$"):
            dispersion.bk7(wrong)


def test_stray_light_is_coloured_and_the_designed_path_is_not():
    prism = Prism(WINDOW / 100, float(dispersion.bk7(dispersion.D)))
    first, second = colours(prism)
    apart = dispersion.spread(first, second)
    both = first.designed & second.designed
    assert both.mean() > 0.55 and apart[both].max() < 1e-14
    aside = np.linalg.norm((first.position - second.position)[both], axis=1)
    assert 0.002 * prism.pitch < aside.max() < 0.01 * prism.pitch
    stray = apart[~first.designed & ~np.isnan(apart)]
    assert len(stray) > 300 and np.median(stray) == pytest.approx(7.6e-3, abs=0.3e-3)
    # the same rays in one colour do not differ; rays on different paths are left out
    assert np.nanmax(dispersion.spread(first, first)) == 0
    other = (first.faces != second.faces).any(1)
    assert other.any() and np.isnan(apart[other]).all()
