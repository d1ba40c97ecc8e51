"""A movie's spec: the values of the swept parameter, and the paper's three movies."""

import numpy as np
import pytest
from conftest import ALPHA_MOVIE

from povgen import MovieSpec


def test_spec_values():
    assert ALPHA_MOVIE.sweep.values("paper") == pytest.approx(np.arange(0, 181, 15))
    assert len(ALPHA_MOVIE.sweep.values("draft")) == 4 and len(ALPHA_MOVIE.sweep.values("high")) == 37
    log = MovieSpec.load("vary-z1").sweep.values("paper")
    assert len(log) == 61 and log[0] == pytest.approx(0.6) and log[60] == pytest.approx(60)
    assert np.ptp(np.diff(np.log(log))) < 1e-12
    # a movie lasts as long at each quality
    for quality in ("draft", "paper", "high"):
        steps = len(ALPHA_MOVIE.sweep.values(quality)) - 1
        assert steps / ALPHA_MOVIE.rate(quality) == pytest.approx(12 / 12.5)


def test_own_movies_are_the_papers():
    alpha, z1, spheres = (MovieSpec.load(name) for name in ("vary-alpha", "vary-z1", "spheres"))
    assert [(s.alpha, s.z1, s.z2) for s in alpha.scenes("paper")][::30] == [(0, 2, 6), (90, 2, 6), (180, 2, 6)]
    assert {(s.alpha, s.z2) for s in z1.scenes("paper")} == {(90, 6)}
    for scene in spheres.scenes("paper"):
        assert scene.distances == tuple(2.0**n * 6 for n in range(-5, 6)) and scene.prisms == 100
