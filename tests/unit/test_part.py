"""`povgen part`: sheets as closed solids. tests/render/test_part_pictures.py compares what they do to light."""

import sys
from importlib import import_module
from math import asin, sin, tau

import numpy as np
import pytest
import trimesh
from conftest import povgen, refusal, refused, some

from povgen import Chess, Piece, Room, Window, part, results
from povgen.measure.part import CIRCLE, solids

FAR = {"z1": 9}
ERRORS = {"facets": 0.5, "pitches": 0.02, "turn": 1, "tilt_x": 3, "far_tilt_y": -2, "separation": 0.1, "seed": 3}
ROUND = {"outline": "round", "width": 3, "height": 2, "x": 1, "y": 2, "yaw": 30, "pitch": 10, "roll": 5}
SCENES = {
    "prisms": Chess(prisms=20, alpha=50),
    "single": Chess(sheet="single", prisms=10, **FAR),
    "lenticular": Chess(sheet="lenticular", lenses=8, alpha=40, error={"pitch": 0.01}, **FAR),
    "profile": Chess(sheet="profile", profile="lenticulars", periods=7, **FAR),
    "errors": Chess(prisms=30, alpha=50, error=ERRORS, **FAR),
    "room": Room([Window(sheet="detailed", prisms=15, **ROUND), Window(sheet="none", x=-5), Piece(z=9)]),
}


def read(path):
    """Return a file's solids as one mesh, with equal vertices joined."""
    mesh = trimesh.load(path, force="mesh")
    mesh.merge_vertices()
    return mesh


@pytest.mark.parametrize("frame", some([True, False], 1))
@pytest.mark.parametrize("name", SCENES)
def test_every_solid_and_every_file_is_closed(name, frame, tmp_path):
    found = solids(SCENES[name], frame)
    ends = [""] if frame or name == "single" else ["-near", "-far"]
    assert [*found] == [f"window1{end}" for end in ends]
    for solid in found.values():
        mesh = solid.to_mesh64()
        made = trimesh.Trimesh(mesh.vert_properties, mesh.tri_verts, process=False)
        assert made.is_watertight and made.is_volume
        if frame:  # it holds every prism
            assert sum(piece.volume() > 0 for piece in solid.decompose()) == 1  # others are closed air
    volume = sum(solid.volume() for solid in found.values())
    for kind, unit in (("stl", 50), ("obj", 50), ("glb", 0.05)):  # a tile
        mesh = read(part(SCENES[name], tmp_path / f"part.{kind}", 50, frame))
        assert mesh.is_watertight and mesh.is_volume
        assert mesh.volume == pytest.approx(volume * unit**3, rel=1e-5)


def test_the_volume_of_dove_prisms_and_of_lenses():
    scene = SCENES["single"]
    prism = scene.sheets[0].shape
    area = prism.height * (prism.length + prism.top_length) / 2
    assert solids(scene)["window1"].volume() == pytest.approx(10 * area * 3, rel=1e-6)
    lenses = SCENES["lenticular"].replace(alpha=0, error={}).sheets[0].shape
    edge = lenses.edges[0]
    angle = 2 * asin(edge.chord / 2 / edge.radius)
    segment = edge.radius**2 * (angle - sin(angle)) / 2  # of a circle; one on either face, with 1 in place of a period
    block = abs(lenses.edges[1].start[1] - edge.start[1])
    expected = 8 * lenses.pitch**2 * (block + 2 * segment) * 3
    for solid in solids(SCENES["lenticular"].replace(alpha=0, error={})).values():
        assert solid.volume() == pytest.approx(expected, rel=1e-4)


def test_a_sheet_ends_at_its_window(tmp_path):
    mesh = read(part(SCENES["prisms"], tmp_path / "part.stl"))
    assert abs(mesh.bounds[:, :2]).max() == pytest.approx(150)  # 3 tiles of 100 mm
    near, far = (solid.bounding_box() for solid in solids(SCENES["prisms"]).values())
    assert near[5] < 0 < far[2] and mesh.bounds[1, 2] == pytest.approx(-100 * near[2])  # z is to the eye
    scene = SCENES["room"]
    (opening, _) = scene.openings
    points = np.concatenate([solid.to_mesh64().vert_properties for solid in solids(scene).values()])
    own = (points - opening.pose.place) @ opening.pose.axes.T
    reach = np.hypot(own[:, 0] / 1.5, own[:, 1])
    assert 1 - (tau / CIRCLE) ** 2 / 8 < reach.max() < 1 + 1e-9


def test_the_command_writes_what_python_does(tmp_path):
    assert povgen(["part", "chess", "--prisms", "9", "-o", "a.obj", "--tile", "20", "--frame"], tmp_path)[0] == 0
    other = part(Chess(prisms=9), tmp_path / "b.obj", 20, True)
    texts = [path.read_text().partition("# povgen record")[0] for path in (tmp_path / "a.obj", other)]
    assert texts[0] == texts[1] and "o window1\n" in texts[0]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--sheet", "ideal"], ["sheet = 'ideal' has no glass; allowed: 'detailed', "]),
        (["--sheet", "none"], ["sheet = 'none' has no glass"]),
        (["--sheet", "mirror", "--window", "z=2,sheet=detailed"], ["sheet = 'mirror' has no glass"]),
        (["--tile", "0"], ["tile = '0'", "0.01 to 100000"]),
        (["-o", "a.step"], ["output = 'a.step'", ".stl, .obj, .glb"]),
    ],
)
def test_what_is_refused(options, words, tmp_path):
    said = refused(["part", "chess", "-o", "a.stl", *options], tmp_path)
    assert len(said.splitlines()) == 1 and all(word in said for word in words), said


def test_wrong_types_are_refused(tmp_path):
    assert "scene = 3" in refusal(lambda: part(3, tmp_path / "a.stl"))
    assert "frame = 'no'" in refusal(lambda: part(Chess(), tmp_path / "a.stl", frame="no"))


def test_verify_runs_without_the_packages(monkeypatch):
    for name in ("trimesh", "manifold3d"):
        monkeypatch.setitem(sys.modules, name, None)
    for name in ("part", "verify_paths"):
        monkeypatch.delitem(sys.modules, f"povgen.measure.{name}", raising=False)
    rows = import_module("povgen.measure.verify_paths").checks()
    assert next(rows).what.startswith("diffraction")


def test_the_light_that_the_page_about_tolerances_states():
    plan = Chess(prisms=300, alpha=90, z1=10, z2=10)
    built = plan.replace(gap=0.1)
    table = results([plan, built, *(built.replace(error={"facets": x}) for x in (0.05, 0.1))], "designed", "blur")
    np.testing.assert_allclose(table["designed"], [0.66, 0.62, 0.62, 0.62], atol=0.005)
    np.testing.assert_allclose(np.degrees(table["blur"] / 10) * 60, [1.8, 1.7, 3.6, 6.9], atol=0.06)
    rays = built.pencil((0, 0, 10), 20_000)
    left, most = (built.trace(rays, partial=rng).designed.sum() for rng in (np.random.default_rng(1), None))
    assert left / most == pytest.approx(0.81, abs=0.006)
