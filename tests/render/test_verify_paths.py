"""What `povgen verify` measures of traced paths, fits and parts holds, and can fail."""

import pytest
from conftest import some

from povgen import Chess, Floor, Piece, Room, Window, fit
from povgen.measure import part, verify_paths

ERRORS = {"facets": 0.5, "pitches": 0.02, "turn": 1, "tilt_x": 3, "far_tilt_y": -2, "seed": 3}
TILTED = Window(
    sheet="detailed", prisms=30, alpha=70, outline="round", height=2, x=0.3, z=1, yaw=30, pitch=9, roll=5, frame=False
)
WEDGES = {"sheet": "profile", "profile": "wedges", "arrangement": "single", "periods": 20, "z1": 4}
SCENES = [
    Chess(prisms=30, alpha=50, z1=3, error=ERRORS),
    Room([TILTED, Piece(z=5, y=-1), Floor(y=-2)]),
    Chess(**WEDGES),
    Chess(prisms=30, sheet="single"),
]


def test_bounds_hold():
    found = [*verify_paths.checks()]
    assert len(found) == 5 and all(measured.holds for measured in found), found


def test_bounds_fail_for_other_scenes(monkeypatch):
    trace = Chess.trace
    with monkeypatch.context() as patch:
        patch.setattr(Chess, "trace", lambda scene, *given, **more: trace(scene.replace(gap=0.19), *given, **more))
        assert not verify_paths.diffraction(Chess(sheet="single", prisms=6, gap=0.2)).holds
    assert not verify_paths.polarisers(Chess(prisms=300, alpha=66, z2=150, view=0.5, base_angle=44)).holds
    monkeypatch.setattr(verify_paths, "PHOTOGRAPHS", 60)
    monkeypatch.setattr(verify_paths, "fit", lambda *given, noise: fit(*given, noise=noise / 2))
    assert not any(measured.holds for measured in verify_paths.intervals(Chess(sheet="ideal", alpha=66, z1=3, z2=7)))


@pytest.mark.parametrize("scene", some(SCENES, 1), ids=["errors", "room", "wedges", "single"])
def test_a_part_makes_the_picture_of_the_scene(scene):
    assert verify_paths.solids(scene).holds


def test_another_part_does_not(monkeypatch):
    right = part.part
    monkeypatch.setattr(part, "part", lambda scene, *given: right(scene.replace(alpha=55), *given))
    assert not verify_paths.solids(SCENES[0]).holds
