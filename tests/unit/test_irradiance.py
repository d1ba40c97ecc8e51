"""The irradiance on a screen behind windows, against closed forms."""

import numpy as np
import pytest
from PIL import Image

from povgen import Bundle, Card, Chess, InputError, Room, Window, irradiance
from povgen.optics import equations

FEW = {"count": 200_000, "size": (24, 24)}


def centres(found):
    left, right, bottom, top = found.extent
    height, width = found.error.shape[:2]
    x, y = ((np.arange(n) + 0.5) / n for n in (width, height))
    return left + (right - left) * x + 1j * (top + (bottom - top) * y[:, None])


@pytest.mark.parametrize(("sheet", "alpha"), [("none", 0), ("ideal", 66), ("ideal", -120)])
@pytest.mark.parametrize("way", [1, -1])
def test_a_point_shines_by_the_law_of_cos_cubed_at_the_place_of_eq_7(sheet, alpha, way):
    """Light from L to a point Q of the screen passes the window at P, where an eye at Q would see L."""
    L, z1, z2 = 0.3 + 0.2j, 2, 3
    found = irradiance(Chess(sheet=sheet, alpha=alpha), (L.real, L.imag, way * z1), -way * z2, **FEW)
    turn = np.radians(way * alpha)  # light that runs away from the eye is turned the other way
    P = equations.apparent_position(L, centres(found), z1, z2, turn)
    depth = equations.depth(z1, z2, turn)
    law = z1 / np.hypot(z1, abs(P - L)) ** 3 * abs(1 - z2 / depth) ** 2
    inside = np.maximum(abs(P.real), abs(P.imag)) < 1.3
    off = (found.total - law)[inside] / found.error[inside]
    assert inside.sum() > 200 and abs(off.mean()) < 0.25 and off.std() == pytest.approx(1, abs=0.15)
    assert not found.stray.any()


def test_power_is_conserved():
    scene = Chess(alpha=90, prisms=30)
    far = {"extent": (-1e3, 1e3) * 2, "count": 80_000, "size": (24, 24)}
    ways = [irradiance(scene, (0, 0.4, 2), z, **far) for z in (-2, 3)]
    x, y = np.array([-1.5, 1.5]), np.array([-1.9, 1.1])
    z = 2 - scene.depth / 2
    corner = np.arctan(x * y[:, None] / z / np.sqrt(x**2 + y[:, None] ** 2 + z**2))
    solid_angle = corner[0, 0] - corner[0, 1] - corner[1, 0] + corner[1, 1]
    for found in ways:
        assert found.entering == pytest.approx(solid_angle, rel=0.005)
        area = (2e3 / 24) ** 2
        assert found.total.sum() * area == pytest.approx(found.leaving, rel=1e-3)  # little light runs along the screen
    # the same from rays in all directions
    random = np.random.default_rng(3)
    dz, turn = -random.uniform(size=100_000), random.uniform(0, 2 * np.pi, 100_000)
    across = np.sqrt(1 - dz**2)
    ends = scene.trace(Bundle((0, 0.4, 2), np.stack((across * np.cos(turn), across * np.sin(turn), dz), -1))).end
    for end, found in enumerate(ways):  # through, and back
        assert found.leaving == pytest.approx(2 * np.pi * (ends == end).mean(), rel=0.03)
    assert ways[0].designed.sum() > 0 < ways[0].stray.sum() and not ways[1].designed.any()
    white = irradiance(scene.replace(fresnel=True, glass="N-SF11"), (0, 0.4, 2), 3, **far)
    assert white.leaving > 1.5 * ways[1].leaving  # partial reflections send light back
    black = irradiance(scene.replace(tops="black"), (0, 0.4, 2), -2, **far)
    assert black.stray.sum() < 0.4 * ways[0].stray.sum() and np.array_equal(black.designed, ways[0].designed)
    some = [
        irradiance(scene.replace(tops=tops, window=f"tops={other},z=1"), (0, 0.4, 3), -2, **far).stray.sum()
        for tops, other in (("clear", "clear"), ("black", "clear"), ("clear", "black"), ("black", "black"))
    ]
    assert some[0] > 1.5 * max(some[1:3]) > min(some[1:3]) > 1.5 * some[3] > 0


def test_a_disc_and_a_card_shine_as_the_cosine_and_a_card_in_its_colours(tmp_path):
    scene, far = Chess(sheet="none", aperture=1), {"extent": (-1, 1, -1, 1), **FEW}
    disc = irradiance(scene, (0, 0, 40), -4, diameter=0.1, **far)
    assert disc.total[10:14, 10:14].mean() == pytest.approx(1 / 44**2, rel=0.02)
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[0] = (255, 0, 0), (0, 255, 0)  # above, left and right
    Image.fromarray(pixels).save(tmp_path / "card.png")
    card = Card(file=tmp_path / "card.png", z=2, width=2)
    with pytest.raises(InputError, match="diameter = 2: allowed: 0 or more, and 0 for a card"):
        irradiance(Chess(), card, -1, diameter=2)
    for sheet, z in (("none", -2), ("ideal", -1)):  # a pinhole camera exchanges the sides; at 180 degrees they stay
        hole = Room([Window(sheet=sheet, alpha=180, width=0.2)])
        found = irradiance(hole, card, z, **far)
        red, green = (np.argwhere(found.total[..., k] > found.total.max() / 2).mean(0) - 11.5 for k in (0, 1))
        assert (np.sign([red, green]) == ([[1, 1], [1, -1]] if sheet == "none" else [[-1, -1], [-1, 1]])).all()
        assert not found.total[..., 2].any()
    with pytest.raises(InputError, match="none of its light enters a window"):
        irradiance(hole, card.replace(yaw=180), -2, **far)


def test_windows_side_by_side_and_one_behind_another_count_once():
    point, screen = (0, 0, 2), {"extent": (-9, 9, -9, 9), **FEW}

    def entering(*windows):
        return irradiance(
            Room([Window(sheet="none", height=2, **each) for each in windows]), point, -2, **screen
        ).entering

    left, right = {"x": -0.6, "width": 0.9}, {"x": 0.7, "width": 1}
    assert entering(left, right) == pytest.approx(entering(left) + entering(right), rel=0.01)
    assert entering({"width": 2}, {"width": 2, "z": -1}) == pytest.approx(entering({"width": 2}), rel=0.01)


IN_SERIES = Chess(sheet="ideal", alpha=0, window="alpha=0,z=2")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"source": (0, 0)}, r"source = \(0, 0\): allowed: 3 numbers"),
        ({"source": (0, 0, 0)}, "inside the sheets"),
        ({"extent": (1, -1, 0, 1)}, "left < right"),
        ({"diameter": -1}, "diameter = -1: allowed: 0 or more"),
        (
            {"scene": Room([Window(sheet="none", yaw=60)]), "source": (0, 0, 3), "z": -1},
            "z = -1: within a window's frame",
        ),
        ({"z": 0.1}, "z = 0.1: within a window's frame; allowed: 0.15 tiles or more"),
        ({"scene": Chess(sheet="ideal"), "source": (0, 0, 0.1)}, "none of its light enters a window"),
        ({"scene": IN_SERIES, "source": (0, 0, 1)}, "source: z = 1: between or beside the windows"),
        ({"scene": IN_SERIES, "source": (2, 0, 2)}, "source: z = 2: between or beside the windows"),
        ({"scene": IN_SERIES, "source": (0, 0, 5), "z": 1}, "z = 1: between the windows; allowed: all windows on one"),
        ({"scene": Chess(polariser=0, analyser=90)}, "polariser, analyser: light is unpolarised here"),
        ({"count": 0}, "count = 0"),
        ({"size": (0, 9)}, "size"),
        ({"z": np.nan}, "z, diameter, extent"),
        ({"scene": Room()}, "no windows"),
        ({"scene": 3}, "should be a scene"),
    ],
)
def test_wrong_values_are_refused(values, words):
    given = {"scene": Chess(), "source": (0, 0, 2), "z": -1, "count": 10} | values
    with pytest.raises(InputError, match=words):
        irradiance(given.pop("scene"), given.pop("source"), given.pop("z"), **given)


def test_equal_maps_are_equal():
    one, same, other = (irradiance(Chess(sheet="ideal"), (0, 0, 2), -1, **FEW, seed=seed) for seed in (1, 1, 2))
    assert one == same and one != other and repr(one).startswith("Irradiance of ")
