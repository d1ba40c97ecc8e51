"""Probes: the decoded numbers are those of the scene, and stray light does not move what is located."""

import numpy as np
import pytest
from conftest import some

from povgen import Rendering, to_pov
from povgen.measure import probes
from povgen.measure.probes import APERTURE, VIEW, Directions
from povgen.optics import equations
from povgen.optics.prism import Prism
from povgen.optics.trace import End
from povgen.rendering import povray
from povgen.scene import camera, survey

SIZE = (320, 240)


def test_a_ray_that_misses_an_edge_does_not_end_povray():
    """If both sheets had exactly the same index, POV-Ray would count no face of such a ray and overflow its stack."""
    scene = Directions(sheet="detailed", prisms=1600, alpha=164.25621174099547, z2=6.242736035399125)
    next(probes.decoded([scene], (640, 480)))


def test_prisms_of_any_shape_agree_with_the_ray_trace():
    """At the ends of the ranges, and with eyes at their ends. Sheets of few prisms are deep: up to 20 tiles."""
    shapes = [
        *({"sheet": "single", "prisms": n, "z2": 0.6 * Prism(APERTURE / n).thickness(1) + 1} for n in (1, 5)),
        *({"prisms": n, "z2": 0.6 * Prism(APERTURE / n).thickness(2) + 1, "eye": 0.1j} for n in (1, 4, 12)),
        {"index": 1.1, "base_angle": 75, "z2": 30, "alpha": 20},
        {"index": 4, "base_angle": 15, "aspect": 1.96, "eye": (10, -10)},
        {"aspect": 1.99, "aperture": 10, "view": 16, "eye": (-10, 10)},
        {"error": {"turn": 2, "tilt_x": 3, "tilt_y": -2, "far_tilt_x": -1, "far_tilt_y": 2, "separation": 0.1}},
        {"error": {"index": 0.1, "far_index": -0.05, "base_angle": 5, "far_base_angle": -3, "turn": 1}},
        {"prisms": 30, "error": {"facets": 1, "seed": 5, "tilt_x": 1}},
        {"prisms": 12, "alpha": 30, "z2": 9, "error": {"tilt_x": 9, "far_tilt_y": -9}},
        {"prisms": 30, "error": {"pitches": 0.05, "seed": 2}},
        {"prisms": 41, "aspect": 0.7, "error": {"pitches": 0.03, "facets": 0.3, "tilt_y": 1}},
    ]
    scenes = [Directions(**shape) for shape in shapes]
    for scene, decoded in zip(scenes, probes.decoded(scenes, (160, 120)), strict=True):
        inside, direction = camera.rays(scene, (160, 120))
        level = survey.max_trace_level(scene)
        found = scene.trace(scene.camera.along(direction), level)
        shown = (found.end <= End.BACK) & (found.count < level)
        agrees = np.linalg.norm(decoded[inside] - found.direction, axis=1) < 1e-3
        assert shown.sum() > 2000 and agrees[shown].mean() > 0.998 and agrees[found.designed].all(), scene
        framed = found.end == End.FRAME  # which stays upright where sheets are tilted
        assert not scene.error or np.isnan(decoded[inside][framed]).mean() > 0.999, scene


@pytest.mark.parametrize(
    ("size", "E"),
    some(
        [((96, 240), 8j), ((400, 32), 8j), ((124, 240), 0j), ((96, 240), 0j), ((32, 400), -3 + 2j), ((32, 7680), 0j)]
        + [((7680, 32), 0j), ((7680, 32), 0.5 - 0.5j)],
        2,
        several=True,
    ),
)
def test_the_ideal_sheet_in_a_picture_of_any_shape(size, E):
    """Narrower than the window, or much wider."""
    scenes = [
        Directions(sheet=sheet, alpha=alpha, eye=E) for sheet, alpha in (("none", 0), ("ideal", 0), ("ideal", 66))
    ]
    none, ideal, turned = probes.decoded(scenes, size)
    pixel = VIEW / size[1]
    seen = ~np.isnan(none[..., 0])
    assert (np.isnan(ideal[..., 0]) == seen).mean() < 2e-3  # hidden by the window frame
    off = np.linalg.norm(ideal - none, axis=-1)[seen & ~np.isnan(ideal[..., 0])]
    assert off.max() < 0.15 * pixel / 6 + 5e-5  # interpolation, and 16 bits

    inside, direction = camera.rays(scenes[2], size)
    expected = np.full((*inside.shape, 3), np.nan)
    expected[inside] = equations.rotate(direction, np.radians(66))
    off = np.linalg.norm(turned - expected, axis=-1)
    assert np.nanmax(off) < 1e-4
    assert (~np.isnan(off)).sum() > 0.8 * inside.sum()  # the window frame hides the rest


NEAR = {"z2": 150, "eye": (10, 5), "view": 0.1}  # rays of one pixel differ by 1e-5


@pytest.mark.parametrize(
    "values",
    [
        {"sheet": "lens", "focal_length": 4, "z2": 4},
        {"sheet": "law", "law": "0.3, -0.1, 1"},
        {"sheet": "ideal", "alpha": 40, "window": "alpha=26,z=2", **NEAR},
    ],
)
def test_parallel_rays(values, monkeypatch):
    """POV-Ray takes a triangle for flat whose corners' rays are parallel, and its rays have another direction."""
    _, off = directions_off(Directions(**values), monkeypatch)
    assert off.max() < 5e-5


def directions_off(scene, monkeypatch, size=(64, 48)):
    """Return the places of the window's pixels, and by how much the directions of their rays are wrong."""
    text = to_pov(scene).partition("// ---- The window frame")[0]
    monkeypatch.setattr(probes, "to_pov", lambda _: text)
    (decoded,) = probes.decoded([scene], size)
    inside, direction = camera.rays(scene, size)
    place = scene.camera.pixels(size)[inside]
    for sheet in scene.ideal:
        direction = sheet.bend(direction, place)
    return place, np.linalg.norm(decoded[inside] - direction, axis=-1)


@pytest.mark.parametrize("eye", some([(0.4, -0.3), (0, 0)], 1))
def test_rays_that_jump_are_wrong_within_a_pixel_of_the_jump(eye, monkeypatch):
    """At X = 0, where the law divides by 0, and at a slanting line."""
    law = "X/abs(X)*0.3, (X - 0.7*Y + 0.1)/abs(X - 0.7*Y + 0.1)*0.2 + 0.3*Y, 1"
    place, off = directions_off(Directions(sheet="law", law=law, eye=eye, view=0.5), monkeypatch)  # 3 pixels a cell
    away = np.minimum(abs(place.real), abs(place.real - 0.7 * place.imag + 0.1) / np.hypot(1, 0.7))
    assert off[away > 0.5 / 48].max() < 2e-4


@pytest.mark.parametrize("size", some([(32, 7680), (7680, 32), (32, 32), (96, 240)], 1))
def test_no_uv_at_which_povray_writes_outside_its_memory(size, tmp_path):
    """POV-Ray keeps a table of triangles for each tenth of U and of V. It uses int(10 U) as an index, unchecked."""
    check = """
    #macro Check(UV)
      #if (min(UV.u, UV.v) <= -0.1 | max(UV.u, UV.v) >= 1.1) #error "a UV outside" #end
    #end
    Check(Pixel(-ViewCorner)) Check(Pixel(ViewCorner)) Check(Pixel(WindowLower)) Check(Pixel(WindowUpper))
    """
    scene = to_pov(Directions(sheet="ideal", eye=3 + 8j))
    povray.run(scene + check, Rendering(size=size, antialias="off"), tmp_path)
