"""The locator: it finds an object among stray light, and through prisms that cut the object into slices."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from povgen.measure import probes
from povgen.measure.probes import locate

SIZE = (320, 240)
A = 0.7 * np.exp(0.5j)


def looked_at(place=0.4 - 0.3j, a=A, b=0.1j, radius=0.3):
    """Pixels of a picture and what they tell: an object of that radius, seen at `place` as a d + b conj(d)."""
    pixels = probes.Directions().camera.pixels(SIZE).ravel()
    off = pixels - place
    size = abs(a) ** 2 - abs(b) ** 2
    decoded = (np.conj(a) * off - b * np.conj(off)) / size
    return pixels, np.where(abs(decoded) < 1.4 * radius, decoded, np.nan)


def test_nothing_is_located_where_nothing_is_seen():
    pixels, decoded = looked_at()
    assert locate(pixels, np.full_like(decoded, np.nan), 0.3) is None
    few = np.where(abs(decoded) < 0.3, np.nan, decoded)
    few[:11] = 0.1  # 12 pixels are needed
    assert locate(pixels, few, 0.3) is None
    row = pixels.imag == pixels.imag[len(pixels) // 2]
    assert locate(pixels[row], decoded[row] * 0 + pixels[row].real, 3) is None


ANGLE = st.floats(-np.pi, np.pi)


@given(
    place=st.complex_numbers(max_magnitude=0.7),
    scale=st.floats(0.7, 2),
    rotation=ANGLE,
    astigmatism=st.floats(0, 0.3),  # |b/a|; prisms of finite size make b. More leaves too few pixels across
    axis=ANGLE,
    radius=st.floats(0.15, 0.5),
    gap=st.floats(0, 0.5),  # of each slice, in which nothing is seen
    slices=ANGLE,  # across which direction the object is cut
    stray=st.floats(0, 0.5),  # pixels of stray light, in units of those of the object
    side=st.floats(-2.5, 1),  # stray light is to the right of this x only
    seed=st.integers(0, 10**6),
)
def test_any_affine_image_is_located(place, scale, rotation, astigmatism, axis, radius, gap, slices, stray, side, seed):
    """A pixel's colours have 16 bits, so each place is decoded to one step. The fit is no worse than a single pixel."""
    random = np.random.default_rng(seed)
    a, b = scale * np.exp(1j * rotation), astigmatism * scale * np.exp(1j * axis)
    pixels, decoded = looked_at(place, a, b, radius)
    pitch = 4.5 * (pixels[1] - pixels[0]).real
    decoded[(pixels * np.exp(-1j * slices)).real / pitch % 1 < gap] = np.nan
    beside = np.flatnonzero(pixels.real > side)
    at = random.choice(beside, min(len(beside), int(stray * (abs(decoded) < radius).sum())), replace=False)
    decoded[at] = radius * np.sqrt(random.random(len(at))) * np.exp(2j * np.pi * random.random(len(at)))
    step = radius / 0.49 / 65535  # as in probes/*.pov.j2: half of the range of a colour is 0.49
    decoded = step * (np.round(decoded.real / step) + 1j * np.round(decoded.imag / step))
    seen = locate(pixels, decoded, radius)
    assert abs(seen.position - place) < step * (abs(a) + abs(b))
    # two pixels a radius apart give a and b to two steps in a radius
    assert abs(seen.a - a) + abs(seen.b - b) < 2 * step / radius * (abs(a) + abs(b)) ** 2 / (abs(a) - abs(b))
