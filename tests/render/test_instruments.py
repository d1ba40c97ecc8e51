"""Instruments: what a frame says is what is there, and stray light does not move what is located."""

import numpy as np
import pytest

from povgen import Rendering, to_pov
from povgen.measure import probes
from povgen.measure.probes import Directions, Piece, Positions, locate
from povgen.optics import prism, rotation
from povgen.optics.trace import End
from povgen.rendering import povray
from povgen.scene import prediction

SIZE = (320, 240)


def test_directions_to_16_bits():
    scene = Directions(sheet="none", E=0.4 - 0.2j)
    (told,) = probes.frames([scene], SIZE)
    inside, direction = probes.rays(scene, SIZE)
    told = told[inside]
    free = ~np.isnan(told[:, 0])  # the frame's inner walls hide some
    assert free.mean() > 0.95
    assert np.linalg.norm(told - direction, axis=1)[free].max() < 1e-4


def test_positions_to_16_bits():
    scene = Positions(sheet="none", z1=3, L=0.5 + 0.2j, extent=0.4)
    (told,) = probes.frames([scene], SIZE)
    pixels = probes.pixels(SIZE)
    on = ~np.isnan(told[..., 0])
    there = pixels[on] * 9 / 6 - scene.L
    assert abs(told[on][:, 0] + 1j * told[on][:, 1] - there).max() < 1e-4
    expected = (abs((pixels * 1.5 - scene.L).real) < 0.4) & (abs((pixels * 1.5 - scene.L).imag) < 0.4)
    assert (on == expected).mean() > 0.999


def test_a_piece_tells_places_on_it():
    scene = Piece(sheet="none", piece="king", z1=3)
    (told,) = probes.frames([scene], SIZE)
    on = ~np.isnan(told[..., 0])
    x, y, z = told[on].T
    seen = scene.E + (scene.L + x + 1j * y - scene.E) * scene.z2 / (scene.z2 + scene.z1 + z)
    assert abs(seen - probes.pixels(SIZE)[on]).max() < 1e-3
    assert y.min() >= -1e-3 and 1.5 < y.max() < 2 and abs(x).max() < 0.45


def test_apparent_place_of_what_is_seen_through_prisms():
    """Stray light of real prisms; eq. 7, for infinitely fine ones, is off by three pixels of 1280x960."""
    scene = Positions(sheet="detailed", alpha=120, z1=2, L=0.5 + 0.2j, extent=0.4)
    (told,) = probes.frames([scene], SIZE)
    inside, _ = probes.rays(scene, SIZE)
    told = told[inside][:, 0] + 1j * told[inside][:, 1]
    seen = locate(probes.pixels(SIZE)[inside], told, scene.extent)
    pixel = 3.85 / 960
    assert abs(seen.place - scene.apparent_position(scene.L, scene.z1)) < 0.5 * pixel
    ideal = rotation.apparent_position(scene.L, 0, 2, 6, np.radians(120))
    assert 2.5 * pixel < abs(seen.place - ideal) < 4 * pixel


def test_a_ray_that_misses_an_edge_does_not_end_povray():
    """With glass alike to the last digit POV-Ray counts no face of such a ray and runs out of its stack."""
    scene = Directions(sheet="detailed", prisms=1600, alpha=164.25621174099547, z2=6.242736035399125)
    next(probes.frames([scene], (640, 480)))


def test_what_povray_says_of_an_instrument(monkeypatch):
    """A failing POV-Ray is reported, not measured."""
    monkeypatch.setattr(povray, "command", lambda *_: ["/bin/false"])
    with pytest.raises(povray.PovrayError):
        next(probes.frames([Directions(sheet="none")], SIZE))


@pytest.mark.parametrize("sheet", ["detailed", "single"])
def test_few_prisms_are_those_of_the_ray_trace(sheet):
    """The fewer the prisms, the deeper the sheets: up to 20 tiles, eight times as deep as the window is wide."""
    alphas = (66, 0, -120, 180, 35)
    scenes = []
    for prisms in range(1, 13):
        deep = prism.thickness(Directions.window / prisms, 2 if sheet == "detailed" else 1)
        values = {"alpha": alphas[prisms % 5], "z2": 0.6 * deep + 1, "E": 0.1j * (prisms % 3)}
        scenes.append(Directions(sheet=sheet, prisms=prisms, **values))
    stray = []
    for scene, told in zip(scenes, probes.frames(scenes, (160, 120)), strict=True):
        inside, direction = probes.rays(scene, (160, 120))
        found = probes.traced(scene, direction)
        off = np.linalg.norm(told[inside] - found.direction, axis=1)
        shown = (found.end <= End.BACK) & (found.count < prediction.max_trace_level(scene))
        assert found.designed.sum() > 500 and (off[found.designed] < 1e-3).all(), scene
        stray.extend(off[shown & ~found.designed] < 1e-3)
        ended = found.end == End.FRAME
        assert ended.sum() > 100 and np.isnan(off[ended]).mean() > 0.99, scene
    assert len(stray) > 1000 and np.mean(stray) > 0.998


@pytest.mark.parametrize(
    ("size", "E"),
    [((124, 240), 0), ((96, 240), 0), ((96, 240), 8j), ((32, 400), -3 + 2j), ((32, 7680), 0)]
    + [((400, 32), 8j), ((7680, 32), 0), ((7680, 32), 0.5 - 0.5j)],
)
def test_the_ideal_sheet_in_a_picture_of_any_shape(size, E):
    """Narrower than the window, or much wider; in its first row and last column POV-Ray's camera is off."""
    scenes = [Directions(sheet=sheet, alpha=alpha, E=E) for sheet, alpha in (("none", 0), ("ideal", 0), ("ideal", 66))]
    none, ideal, turned = (told[1:, :-1] for told in probes.frames(scenes, size))
    pixel = Directions.view_height / size[1]
    seen = ~np.isnan(none[..., 0])
    assert (np.isnan(ideal[..., 0]) == seen).mean() < 2e-3  # what the frame hides
    off = np.linalg.norm(ideal - none, axis=-1)[seen & ~np.isnan(ideal[..., 0])]
    assert off.max() < 0.15 * pixel / 6 + 5e-5  # interpolation, and 16 bits

    inside, direction = probes.rays(scenes[2], size)
    expected = np.full((*inside.shape, 3), np.nan)
    expected[inside] = rotation.rotate(direction, np.radians(66))
    off = np.linalg.norm(turned - expected[1:, :-1], axis=-1)
    assert np.nanmax(off) < 1e-4
    assert (~np.isnan(off)).sum() > 0.8 * inside.sum()  # the frame hides the rest


@pytest.mark.parametrize("size", [(32, 32), (32, 7680), (7680, 32), (96, 240)])
def test_no_uv_at_which_povray_writes_outside_its_memory(size, tmp_path):
    """POV-Ray keeps a table of triangles for each tenth of U and of V, and takes int(10 U) as its index unchecked."""
    code = to_pov(Directions(sheet="ideal", E=3 + 8j))
    check = """#macro Pixel(Point)
      #local UV = Unchecked(Point);
      #if (min(UV.u, UV.v) <= -0.1 | max(UV.u, UV.v) >= 1.1) #error "a UV outside" #end
      UV
    #end
    """
    code = code.replace("#macro Pixel(Point)", check + "#macro Unchecked(Point)")
    assert "Unchecked" in code
    povray.run(code, Rendering(size=size, antialias="off"), tmp_path)
