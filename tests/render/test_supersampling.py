"""Pictures that POV-Ray renders larger and povgen reduces."""

import numpy as np
import pytest

from povgen import InputError, Rendering, Spheres, settings, to_pov
from povgen.inputs import hdr
from povgen.rendering import cache, light, povray

SIZE = (96, 72)


def test_light_is_averaged():
    """Half the light of white is 188 in sRGB: the mean of the bytes would be 128."""
    checker = np.indices((64, 96)).sum(0)[..., None] % 2 * np.full(3, 255, np.uint8)
    assert (abs(light.reduced(checker.astype(np.uint8), (48, 32))[2:-2, 2:-2].astype(int) - 188) <= 1).all()
    every = np.arange(256, dtype=np.uint8).repeat(3).reshape(16, 16, 3)
    assert (hdr.encoded(light.linear(every)).round() == every).all()


@pytest.mark.parametrize(("antialias", "far"), [("1.5x", 2), ("2x", 2), ("3x", 3), ("4x", 4)])
def test_the_weights_are_those_of_the_filter(antialias, far):
    """A bright old pixel counts for the new ones around it: linearly less, to 0 `far` old pixels away."""
    factor = Rendering(antialias=antialias).supersampling
    columns, rows = (round(factor * side) for side in SIZE)
    for x, y in ((45, 40), (46, 41), (47, 42)):
        picture = np.zeros((rows, columns), np.float32)
        picture[y, x] = 1
        down, across = (
            np.maximum(0, 1 - abs((np.arange(side) + 0.5) * factor - place - 0.5) / far)
            / np.maximum(0, 1 - abs((np.arange(side)[:, None] + 0.5) * factor - np.arange(old) - 0.5) / far).sum(1)
            for side, place, old in ((SIZE[1], y, rows), (SIZE[0], x, columns))
        )
        np.testing.assert_allclose(light._reduced(picture, SIZE), np.outer(down, across), atol=1e-6)


def test_the_cache_distinguishes_it_from_the_large_picture():
    text = to_pov(Spheres(sheet="none"))
    large, reduced = Rendering(size=(192, 144), antialias="off"), Rendering(size=SIZE, antialias="2x")
    assert povray.command("povray", large) == povray.command("povray", reduced)
    assert cache.frame_path(text, large) != cache.frame_path(text, reduced)


def test_the_cache_distinguishes_filters(monkeypatch):
    text, rendering = to_pov(Spheres(sheet="none")), Rendering(antialias="1.5x")
    before = cache.frame_path(text, rendering)
    monkeypatch.setattr(settings, "FILTER", "a box")
    assert cache.frame_path(text, rendering) != before


def test_the_largest_picture():
    assert Rendering(size=(3840, 2160), antialias="2x").picture_options[1:3] == ["+W7680", "+H4320"]
    for size, antialias, allowed in (((7680, 4320), "2x", "22.25"), ((7680, 7680), "1.5x", "39.55")):
        with pytest.raises(InputError, match=f"too large for antialias = '{antialias}'; allowed: up to {allowed} mil"):
            Rendering(size=size, antialias=antialias)
    assert Rendering(size=(7680, 7680), antialias="off").sampling == "off"
