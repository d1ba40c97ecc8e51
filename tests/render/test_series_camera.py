"""Ideal windows in series: the camera's mesh has no flat triangle, and every pixel shows what its ray meets."""

import re

import numpy as np
import pytest
from conftest import some

from povgen import Rendering, to_pov
from povgen.measure import probes
from povgen.measure.probes import Directions
from povgen.optics import apparent
from povgen.rendering import povray

FRAME = "// ---- The window frame (window_frame.pov.j2) ----"


def windows_at_random(count, rng):
    """Scenes of 2 to 5 ideal windows. Half of the angles are multiples of 15 degrees, so that edges meet in a point."""
    for _ in range(count):
        windows = rng.integers(2, 6)
        steps = rng.choice([0.001, 15], windows)
        alphas = steps * np.round(rng.uniform(-180, 180, windows) / steps)
        z = np.cumsum(rng.uniform(0.3, 4, windows - 1))
        yield Directions(
            sheet="ideal",
            alpha=alphas[0],
            window=[{"alpha": alpha, "z": place} for alpha, place in zip(alphas[1:], z, strict=True)],
            z2=rng.uniform(2, 9),
            eye=rng.integers(0, 2) * rng.uniform(-2, 2, 2),
            view=rng.choice([1.0, 3.85]),  # near: the window fills the picture
            grid=8,
        )


@pytest.mark.parametrize("count", some([60, 500], 1))
def test_no_triangle_of_the_cameras_mesh_is_flat(count, rng, tmp_path):
    """POV-Ray divides by its area in the UV square. Only triangles in windows are made here, from one cell."""
    check = "#local Area = abs(vcross(Pixel(B) - Pixel(A), Pixel(C) - Pixel(A)).z);"
    check += ' #if (Area < 1e-13) #error "a flat triangle" #end #declare Triangles = Triangles + 1;'
    texts = ["#version 3.7; #declare Triangles = 0;"]
    for scene in windows_at_random(count, rng):
        text = re.sub("//.*", "", to_pov(scene.replace(grid=1)).partition("// ---- Coded colours")[0])
        text = re.sub(r"#ifndef \(\w+\)(.*?) #end", r"\1", text)  # the parameters are this scene's
        text, found = re.subn(r"#macro MeshTriangle\(A, B, C, W\)", rf"\g<0> {check}", text)
        text = text.replace("CellsOutsideWindow(Lower, Upper)", "")
        assert found == 1
        texts.append(re.sub(r"camera \{.*", "", text))
        texts += [f"#undef {name}" for name in re.findall(r"#declare (Law\w+) = function", text)]
    texts.append(f'camera {{ location -z }} #if (Triangles < {10 * count}) #error "few triangles" #end')
    povray.run("\n".join(texts), Rendering(size=(320, 240), antialias="off"), tmp_path)


def seen_through(scene, P):
    """Return the slopes at which rays from the eye to P leave the last window that they pass, and which are in doubt.

    A ray passes a window inside the back of the frame before, the front of this frame, and the plane of the sheet.
    """
    half, depth = scene.aperture / 2, scene.depth / 2
    slope = (P - scene.E) / scene.z2
    planes = [before for before, *_ in apparent.follow(slope, scene.E, scene.elements)]
    seen, passes, doubtful = slope, np.ones(P.shape, bool), np.zeros(P.shape, bool)
    back = planes[0]
    for plane, alpha in zip(planes, scene.alphas, strict=True):
        crossed = [back, plane - depth * slope, plane]
        room = half - np.max([np.maximum(abs(at.real), abs(at.imag)) for at in crossed], axis=0)
        doubtful |= abs(room) < 1e-6
        passes &= room >= 0
        slope = slope * np.exp(-1j * np.radians(alpha))
        seen = np.where(passes, slope, seen)
        back = plane + depth * slope
    return seen, doubtful


def shown(scenes, monkeypatch, size=(64, 48)):
    """Yield what the pixels' colours say: the directions of their rays behind all windows. There are no frames."""
    monkeypatch.setattr(probes, "to_pov", lambda scene: to_pov(scene).partition(FRAME)[0])
    yield from zip(scenes, probes.decoded(scenes, size), strict=True)


@pytest.mark.parametrize("count", some([12, 100], 1))
def test_every_pixel_shows_the_direction_of_its_ray(count, rng, monkeypatch):
    for scene, decoded in shown(list(windows_at_random(count, rng)), monkeypatch):
        assert not np.isnan(decoded).any(), scene
        seen, doubtful = seen_through(scene, scene.camera.pixels((64, 48)))
        expected = np.stack((seen.real, seen.imag, np.ones(seen.shape)), -1)
        expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
        off = np.linalg.norm(decoded - expected, axis=-1)[~doubtful]
        assert off.max() < 0.03, scene  # the camera interpolates between the corners of coarse cells
        assert np.median(off) < 1e-3


def test_windows_in_which_all_rays_cross_one_point(monkeypatch):
    """In the plane of the second window, opposite the eye. A mesh there would have no area."""
    values = {"sheet": "ideal", "alpha": 180, "z2": 4, "window": "alpha=70,z=4"}
    scenes = [Directions(eye=eye, grid=1, **values) for eye in ((0, 0), (0.3, -0.2))]
    for scene, decoded in shown(scenes, monkeypatch):
        seen, doubtful = seen_through(scene, scene.camera.pixels((64, 48)))
        direction = np.stack((seen.real, seen.imag, np.ones(seen.shape)), -1)
        direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
        assert np.linalg.norm(decoded - direction, axis=-1)[~doubtful].max() < 0.03
