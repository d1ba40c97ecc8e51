"""The laws of ideal sheets mean the same in numpy, POV-Ray, JavaScript and GLSL, also of several sheets in series."""

import re
import subprocess

import numpy as np
import pytest
from conftest import Node, some

from povgen import Chess, to_pov
from povgen.measure.opengl import OpenGLView
from povgen.measure.probes import Directions, decoded
from povgen.optics import apparent
from povgen.scene import camera
from povgen.sheets import IDEAL, OTHER

SIZE = (120, 90)
SCENES = [Directions(sheet=name, eye=(0.4, -0.3), **values) for name in IDEAL for values in IDEAL[name].examples]
IDS = [f"{scene.sheet}-{n}" for n, scene in enumerate(SCENES)]
# the first windows are ideal sheets of any kinds
SERIES = [
    Directions(sheet="lens", focal_length=5, window="z=1.2,sheet=axis,axis=0,1,0.4,alpha=20", eye=(0.3, 0.1)),
    Directions(sheet="none", window=["z=1,sheet=ideal,alpha=40", "z=2.2,sheet=refraction,ratio=0.8,alpha=20"]),
    Directions(sheet="law", law="x - k*X*z, y, z", parameter={"k": 0.2}, window="z=1,sheet=twist,twist=20,alpha=0"),
]


@pytest.fixture(scope="module")
def node():
    started = Node.of_page(SCENES)
    yield started
    started.close()


@pytest.fixture(scope="module")
def view():
    return OpenGLView(SCENES[0])


def directions(rng, count=60):
    """Unit directions (n, 3) with z > 0, and places."""
    d = rng.normal(size=(count, 3)) * (1, 1, 2)
    d[:, 2] = abs(d[:, 2])
    return d / np.linalg.norm(d, axis=1, keepdims=True), rng.uniform(-1.5, 1.5, (count, 2)) @ [1, 1j]


@pytest.mark.parametrize("scene", SCENES, ids=IDS)
def test_numpy_and_javascript(scene, node, rng):
    d, place = directions(rng)
    expected = scene.sheets[0].slope((d[:, 0] + 1j * d[:, 1]) / d[:, 2], place)
    rays = [[[x / z, y / z], [at.real, at.imag]] for (x, y, z), at in zip(d.tolist(), place, strict=True)]
    script = "([scene, rays]) => rays.map((ray) => sheets.bending(presets.windows(scene)[0])(...ray))"
    given = node.evaluate(script, [scene.model_dump(), rays])
    found = np.array([complex(*pair) if pair else np.nan for pair in given])
    assert np.array_equal(np.isnan(found), np.isnan(expected)) and np.isfinite(found).sum() > 10
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-11)


def test_numpy_and_pov_ray(rng, tmp_path):
    """One POV-Ray writes what the functions in the texts of all scenes give."""
    d, place = directions(rng, 20)
    scenes = [scene for scene in SCENES if scene.sheet != "none"]
    lines = [f'#version 3.7; #fopen File "{tmp_path}/found" write']
    for scene in scenes:
        text = to_pov(scene).partition("// ---- Ideal sheets")[0]
        lines.append(re.sub(r"#ifndef \(\w+\)(.*?) #end", r"\1", text))  # the parameters are this scene's
        for (x, y, z), at in zip(d, place, strict=True):
            arguments = f"({x:.17g}, {y:.17g}, {z:.17g}, {at.real:.17g}, {at.imag:.17g})"
            lines += [f'#write (File, str(Law1{part}{arguments}, 0, 15), "\\n")' for part in "XYZ"]
        lines += [f"#undef Law1{part}" for part in "XYZ"]
    (tmp_path / "scene.pov").write_text("\n".join([*lines, "#fclose File", "camera { location 0 }"]))
    run = subprocess.run(
        ["povray", "+Iscene.pov", "-D", "-F", "+W64", "+H48", "-GA"], cwd=tmp_path, capture_output=True
    )
    assert run.returncode == 0, run.stderr[-500:]
    found = np.array((tmp_path / "found").read_text().split(), float).reshape(len(scenes), -1, 3)
    for scene, bent in zip(scenes, found / np.linalg.norm(found, axis=2, keepdims=True), strict=True):
        expected = scene.sheets[0].bend(d, place)
        passes = np.isfinite(expected[:, 0])
        assert ((bent[:, 2] > 1e-6) == passes).all() and passes.sum() > 3, scene.sheet
        np.testing.assert_allclose(bent[passes], expected[passes], atol=1e-11, err_msg=scene.sheet)


@pytest.mark.parametrize("scene", SCENES, ids=IDS)
def test_numpy_and_the_graphics_processor(scene, view):
    inside, direction = camera.rays(scene, SIZE)
    view.set(scene)
    found = view.readout(SIZE)["ray"][inside][:, :3].astype(float)
    place = scene.camera.pixels(SIZE)[inside]
    expected = scene.sheets[0].bend(direction, place)
    passes = np.isfinite(expected[:, 0]) & (expected[:, 2] > 1e-3)
    assert passes.sum() > 500
    np.testing.assert_allclose(found[passes], expected[passes], atol=3e-4 if scene.sheet in ("twist", "law") else 5e-6)


def through(scene, direction):
    """Which rays pass all windows and their frames, their directions and places behind the last one."""
    slope = (direction[:, 0] + 1j * direction[:, 1]) / direction[:, 2]
    followed = apparent.follow(slope, scene.E, scene.elements)
    half, passes = scene.aperture / 2 - 0.01, np.ones(len(slope), bool)
    for P, before, Q, after in followed:
        for point in (P - scene.depth / 2 * before, P, Q + scene.depth / 2 * after):
            passes &= np.maximum(abs(point.real), abs(point.imag)) < half
    *_, place, behind = followed[-1]
    bent = np.stack((behind.real, behind.imag, np.ones(len(behind))), -1)
    return passes, bent / np.linalg.norm(bent, axis=1, keepdims=True), place


@pytest.mark.parametrize(
    "scene",
    some(SERIES, 1),
    ids=lambda s: s.sheet,
)
def test_sheets_in_series(scene, view):
    """POV-Ray's pictures and the shader show in every pixel the direction that the laws give."""
    inside, direction = camera.rays(scene, SIZE)
    passes, expected, _ = through(scene, direction)
    assert passes.sum() > 300
    (colours,) = decoded([scene], SIZE)
    seen = colours[inside][passes]
    seen /= np.linalg.norm(seen, axis=1, keepdims=True)
    off = np.linalg.norm(seen - expected[passes], axis=1)
    assert np.quantile(np.nan_to_num(off, nan=9), 0.99) < 2e-3, np.quantile(off, [0.5, 0.9, 0.99, 1])
    view.set(scene)
    ray = view.readout(SIZE)["ray"][inside][passes][:, :3]
    assert abs(ray - expected[passes]).max() < 5e-4


@pytest.mark.parametrize("sheet", OTHER)
def test_prisms_behind_any_ideal_sheet(sheet):
    """The survey's rays meet the prisms, and the prediction is that of matrices or of the search."""
    scene = Chess(sheet=sheet, alpha=30, ratio=1.2, window="z=1.5,sheet=detailed,alpha=20", z1=3)
    text = to_pov(scene)
    assert "Sheet(Windows[W][0]/2" in text
    seen = complex(scene.apparent_position(scene.L, 3))
    *_, P, slope = apparent.follow((seen - scene.E) / scene.z2, scene.E, scene.elements)[-1]
    assert P + 3 * slope == pytest.approx(scene.L, abs=1e-6)
