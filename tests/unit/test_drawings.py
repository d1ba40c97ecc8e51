"""Overlays, captions and side views are those that are kept in tests/data."""

import drawings
import imageio.v3 as iio
import pytest


@pytest.mark.parametrize("name", drawings.SCENES)
def test_a_drawing_is_the_one_that_is_kept(name):
    made, kept = drawings.drawn(name), iio.imread(drawings.file(name), mode="RGB")
    assert made.shape == kept.shape
    off = abs(made.astype(int) - kept).max(-1)
    assert (off > 60).sum() < 12  # antialiased edges differ between versions of the font library
