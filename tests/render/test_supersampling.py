"""Pictures that POV-Ray renders larger and povgen reduces."""

import numpy as np
import pytest

from povgen import InputError, Rendering
from povgen.inputs import hdr
from povgen.rendering import light

SIZE = (96, 72)


def test_light_is_averaged():
    """Half the light of white is 188 in sRGB: the mean of the bytes would be 128."""
    checker = np.indices((64, 96)).sum(0)[..., None] % 2 * np.full(3, 255, np.uint8)
    assert (abs(light.reduced(checker.astype(np.uint8), (48, 32))[2:-2, 2:-2].astype(int) - 188) <= 1).all()
    every = np.arange(256, dtype=np.uint8).repeat(3).reshape(16, 16, 3)
    assert (hdr.encoded(light.linear(every)).round() == every).all()


def test_the_largest_picture():
    assert Rendering(size=(3840, 2160), antialias="2x").picture_options[1:3] == ["+W7680", "+H4320"]
    for size, antialias, allowed in (((7680, 4320), "2x", "22.25"), ((7680, 7680), "1.5x", "39.55")):
        with pytest.raises(InputError, match=f"too large for antialias = '{antialias}'; allowed: up to {allowed} mil"):
            Rendering(size=size, antialias=antialias)
    assert Rendering(size=(7680, 7680), antialias="off").sampling == "off"
