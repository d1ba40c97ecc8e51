"""Dispersion: none on the designed path, by exact arithmetic and in the ray trace; coloured stray light."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from povgen.optics.prism import Prism
from povgen.optics.trace import End, pair, trace

WINDOW = 2.4
BK7 = {"F": 1.52238, "d": 1.51680, "C": 1.51432}  # refractive indices of Schott's data sheet


def rational_unit(*tangents):
    """Return a vector of rational numbers with the length 1, from stereographic coordinates."""
    size = sum(t * t for t in tangents)
    return [2 * t / (1 + size) for t in tangents] + [(1 - size) / (1 + size)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


RATIONAL = st.fractions(Fraction(1, 50), Fraction(4, 5), max_denominator=100)


@given(RATIONAL, RATIONAL, RATIONAL, st.fractions(Fraction(1, 10), 4, max_denominator=50))
def test_the_designed_path_keeps_the_direction_for_every_index(x, y, facet, m):
    """In rational numbers, so without any rounding: light leaves in the mirrored direction, whatever the index.

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


def test_stray_light_is_coloured_and_the_designed_path_is_not():
    """The same rays in the lines F and C, through prisms of one shape."""
    prism, n, z2 = Prism(WINDOW / 100, BK7["d"]), 50, 6.0
    x, y = WINDOW / 2 * (2 * (np.indices((n, n)) + 0.4).reshape(2, -1) / n - 1)
    direction = np.column_stack((x, y, np.full(n * n, z2)))
    found = []
    for line in ("F", "C"):
        glass = prism.with_length_kept(index=BK7[line])
        assert glass.length == pytest.approx(prism.length) and glass.height == prism.height
        found.append(trace([[0, 0, -z2]], direction, pair(np.radians(66), glass), WINDOW))
    first, second = found
    same = (first.faces == second.faces).all(1) & (first.end == End.THROUGH) & (second.end == End.THROUGH)
    apart = np.linalg.norm(first.direction - second.direction, axis=1)
    both = first.designed & second.designed
    assert both.mean() > 0.55 and apart[both].max() < 1e-14
    aside = np.linalg.norm((first.position - second.position)[both], axis=1)
    assert aside.max() == pytest.approx(0.0081 * prism.pitch, rel=0.01)
    stray = apart[same & ~first.designed]
    assert len(stray) > 300 and np.median(stray) == pytest.approx(7.6e-3, abs=0.3e-3)
