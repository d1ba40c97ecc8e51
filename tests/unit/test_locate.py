"""The locator: it finds an object among stray light, and through prisms that cut the object into slices."""

import numpy as np
import pytest

from povgen.measure import probes
from povgen.measure.probes import locate

SIZE = (320, 240)
A = 0.7 * np.exp(0.5j)


def looked_at(place=0.4 - 0.3j, a=A, b=0.1j, radius=0.3):
    """Pixels of a picture and what they tell: an object of that radius, seen at `place` as a d + b conj(d)."""
    pixels = probes.pixels(SIZE).ravel()
    off = pixels - place
    size = abs(a) ** 2 - abs(b) ** 2
    told = (np.conj(a) * off - b * np.conj(off)) / size
    return pixels, np.where(abs(told) < 1.4 * radius, told, np.nan)


def test_an_object_is_located_to_a_thousandth_of_a_pixel():
    seen = locate(*looked_at(), 0.3)
    assert abs(seen.place - (0.4 - 0.3j)) < 1e-3 * 3.85 / 240
    assert seen.a == pytest.approx(A) and seen.b == pytest.approx(0.1j)
    assert seen.rotation == pytest.approx(0.5) and seen.magnification == pytest.approx(0.7)


def test_ghosts_and_stray_light_do_not_move_it(rng):
    pixels, told = looked_at()
    _, predicted = looked_at(place=-0.8 + 0.7j, a=0.2, b=0)
    told = np.where(np.isnan(told), predicted, told)
    stripes = np.round(pixels.real * 40) % 3 == 0  # prisms cut the object into slices
    told[stripes] = np.nan
    stray = rng.random(len(pixels)) < 0.005  # as many as the object has left
    told[stray] = rng.uniform(-0.3, 0.3, stray.sum()) + 1j * rng.uniform(-0.3, 0.3, stray.sum())
    assert abs(locate(pixels, told, 0.3).place - (0.4 - 0.3j)) < 0.05 * 3.85 / 240
    naive = pixels[abs(told) < 0.3].mean()
    assert abs(naive - (0.4 - 0.3j)) > 0.1  # what a centroid makes of it


def test_nothing_is_located_where_nothing_is_seen():
    pixels, told = looked_at()
    assert locate(pixels, np.full_like(told, np.nan), 0.3) is None
    assert locate(pixels, told + 5, 0.3) is None
    row = pixels.imag == pixels.imag[len(pixels) // 2]
    assert locate(pixels[row], told[row] * 0 + pixels[row].real, 3) is None
