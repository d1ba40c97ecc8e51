"""What `povgen verify` measures without pictures holds, and can fail."""

from povgen import Chess, fit
from povgen.measure import verify_paths


def test_bounds_hold():
    found = [*verify_paths.checks()]
    assert len(found) == 4 and all(measured.holds for measured in found), found


def test_bounds_fail_for_other_scenes(monkeypatch):
    trace = Chess.trace
    with monkeypatch.context() as patch:
        patch.setattr(Chess, "trace", lambda scene, *given, **more: trace(scene.replace(gap=0.19), *given, **more))
        assert not verify_paths.diffraction(Chess(sheet="single", prisms=6, gap=0.2)).holds
    assert not verify_paths.polarisers(Chess(prisms=300, alpha=66, z2=150, view=0.5, base_angle=44)).holds
    monkeypatch.setattr(verify_paths, "PHOTOGRAPHS", 60)
    monkeypatch.setattr(verify_paths, "fit", lambda *given, noise: fit(*given, noise=noise / 2))
    assert not any(measured.holds for measured in verify_paths.intervals(Chess(sheet="ideal", alpha=66, z1=3, z2=7)))
