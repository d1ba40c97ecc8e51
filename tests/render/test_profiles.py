"""Sheets of lenses and of other profiles: POV-Ray and OpenGL against the ray trace, and a profile from a file."""

import numpy as np
import pytest

from povgen import Chess, InputError, render, save
from povgen.measure import compare, probes, verify_gl
from povgen.measure.verify import MISMATCHED, PROFILES
from povgen.settings import Rendering
from povgen.video import overlay

SMALL = (160, 120)


FIRST = [several[0] for several in (PROFILES | MISMATCHED).values()]


@pytest.mark.parametrize("values", FIRST, ids=["lenses", "thin", "mismatched"])
def test_povray_agrees_with_the_ray_trace(values):
    designed, leaving = compare.pixels([probes.Directions(**values)], SMALL)
    assert designed > 99.9 and leaving > 99


def test_the_shader_agrees_with_the_ray_trace():
    scenes = [*FIRST[:2], {"sheet": "detailed", "alpha": 60, "window": "z=2,sheet=lenticular"}]
    assert all(measured.holds for measured in verify_gl.directions(scenes, SMALL, least=98.5))


def test_a_profile_from_a_file_shows_what_its_own_sheet_shows(tmp_path):
    """The default lenses, written into a file, give the same picture. A wrong file is one line."""
    file = tmp_path / "lenses.toml"
    lens = "corners = [[0, {0}], [2, {0}]]\nradii = [2]\n"
    z = 4 + 3**0.5  # the lenses' edges, in units in which the period is 2, from the middle
    text = "period = 2\ngap = 0.02\npath = [1, 2]\n"
    file.write_text(text + "".join(f"[[outline]]\n{lens.format(side * z)}" for side in (-1, 1)))
    options = {"size": SMALL, "antialias": "off"}
    own = render(Chess(sheet="profile", profile=file), **options)
    same = render(Chess(sheet="lenticular"), **options)
    assert np.mean(np.any(own != same, axis=-1)) < 0.01
    file.write_text(file.read_text().replace("radii = [2]", "radii = [0.5]", 1))
    with pytest.raises(InputError, match="edge 1: radius = 0.25; allowed: 0, or 0.5 to 10000 periods") as error:
        Chess(sheet="profile", profile=file)
    assert "\n" not in str(error.value)


def test_windows_of_different_kinds_in_one_scene():
    """Dove prisms, lenses and another profile in series: POV-Ray agrees with the ray trace on the designed path."""
    window = ("z=1.5,sheet=lenticular,alpha=40,lenses=60", "z=3,sheet=profile,profile=wedges,arrangement=single")
    scene = probes.Directions(sheet="detailed", alpha=60, prisms=60, window=window, z2=8)
    designed, leaving = compare.pixels([scene], SMALL)
    assert designed > 99 and leaving > 97


def test_a_record_has_the_profile(tmp_path):
    """A picture is made again without the profile's file."""
    file = tmp_path / "wedge.toml"
    outlines = "[{ corners = [[0, 0], [1, 0]] }, { corners = [[0, 0.2], [0.9, 0.4], [1, 0.2]] }]"
    file.write_text(f"path = [1, 2]\noutline = {outlines}\n")
    scene = Chess(sheet="profile", profile=file, window={"z": 2, "profile": file}, arrangement="single")
    save(scene, tmp_path / "a.png", size=(32, 32), antialias="off")
    file.unlink()
    assert Chess.from_file(tmp_path / "a.png") == scene


def test_ghosts_are_seen_where_they_are_predicted():
    scene = probes.Positions(sheet="lenticular", f_number=6, alpha=40, z1=1.5, L=0.05 - 0.3j)
    own, ghosts, count = compare.ghosts([scene], (400, 250))
    assert own < 3 and ghosts < 2 and count == 2


@pytest.mark.parametrize(("f_number", "share"), [(6, 0.16), (8, 0.27)])
def test_ghosts_of_all_orders_are_found(f_number, share):
    """Position and share are those of another ray tracer."""
    scene = Chess(sheet="lenticular", f_number=f_number)
    found = {ghost.orders: ghost for ghost in scene.ghosts(*scene.objects[0])}
    assert {(-1, -1), (-1, -2)} <= found.keys() and abs(found[-1, -2].share - share) < 0.04
    assert f_number == 6 or abs(found[-1, -2].position - (-0.07 - 0.42j)) < 0.01


def test_no_ghost_is_marked_where_its_light_shows_other_points():
    scene = Chess(sheet="lenticular", f_number=20, z2=2)
    assert [ghost.orders for ghost in scene.ghosts(*scene.objects[0])] == [(-6, -7)]


def test_ghosts_are_marked():
    lenses = Chess(sheet="lenticular", f_number=4)
    assert len(overlay.ghosts(lenses)) == 1 and not overlay.ghosts(Chess())
    texts = [text for text, _ in overlay.legend(lenses, Rendering(overlay=True))]
    assert "predicted ghosts" in texts and "predicted ghosts" not in [
        text for text, _ in overlay.legend(Chess(), Rendering(overlay=True))
    ]
