"""Shares of the rays that meet a window."""

import re
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest

from povgen import Chess
from povgen.optics.faces import Face, GlassSheet
from povgen.optics.prism import Prism
from povgen.optics.shares import shares
from povgen.optics.trace import End, pair, trace
from povgen.scene import quantities
from povgen.scene.quantities import QUANTITIES

DOCS = Path(__file__).parents[2] / "docs"
WINDOW = 2.4


def words_of(page):
    """Return a page's text in one line."""
    return " ".join((DOCS / page).read_text().split())


def found(n=110, partial=None, most=60, **shape):
    """Trace rays from the eye to the whole window of the default scene, with prisms of another shape."""
    scene = Chess(**shape)
    x, y = scene.aperture * (
        (np.indices((n, n)) + np.random.default_rng(66).uniform(size=(2, n, n))).reshape(2, -1) / n - 0.5
    )
    direction = np.column_stack((x, y, np.full(n * n, scene.z2)))
    sheets = pair(np.radians(scene.alpha), scene.prism)
    return trace([[0, 0, -scene.z2]], direction, sheets, scene.aperture, most, partial=partial)


def test_the_docs_state_the_shares_of_the_default_scene(monkeypatch):
    monkeypatch.setattr(quantities, "RAYS", 20_000)
    quantities._shares.cache_clear()
    page = (DOCS / "beyond.md").read_text()
    number = r"([\d.]+)"
    rows = re.findall(
        rf"^\| {number} \| {number}° \| {number} \| {number} % \| {number} % \| {number} % \|$", page, re.M
    )
    assert len(rows) == 3
    for row in rows:
        index, base_angle, aspect, *stated = map(float, row)
        scene = Chess(index=index, base_angle=base_angle, aspect=aspect)
        glass, black = (quantities._shares(scene.replace(tops=tops)) for tops in ("clear", "black"))
        assert 100 * np.array([glass.designed, glass.stray, black.stray]) == pytest.approx(stated, abs=1.3), row
        assert black.designed == glass.designed and glass.absorbed == 0 < black.absorbed
        assert sum(astuple(glass)) == pytest.approx(1) == sum(astuple(black))
    default = quantities._shares(Chess())
    lost = (default.back, default.frame, default.unfinished)
    stated = re.search(
        r"In the default scene ([\d.]+) % are designed, ([\d.]+) % stray and (\d+) % lost: (\d+) % come back, (\d+) % "
        r"meet the frame, and (\d+) % meet more than 60 faces",
        words_of("sheets.md"),
    )
    measured = 100 * np.array([default.designed, default.stray, sum(lost), *lost])
    assert measured == pytest.approx([*map(float, stated.groups())], abs=1.3)


def test_edges_of_a_profile_are_no_black_tops():
    profile = {"z": 4, "sheet": "profile", "profile": "lenticulars", "periods": 50}
    designed = [QUANTITIES["designed"].of(Chess(tops=tops, prisms=30, window=[profile])) for tops in ("clear", "black")]
    assert designed[0] == designed[1] > 0.05


def test_the_docs_state_the_light_by_reflections_of_the_default_scene():
    rays = found(partial=np.random.default_rng(2), most=250)
    white = rays.end <= End.BACK
    (stated,) = re.findall(r"(\d+) % of it by partial reflections", words_of("beyond.md"))
    assert 100 * rays.reflected[white].mean() == pytest.approx(int(stated), abs=1.5)
    (bright,) = re.findall(r"frameless window has ([\d.]+) of the surroundings' brightness", words_of("beyond.md"))
    assert white.mean() == pytest.approx(float(bright), abs=0.01)


def test_rays_meet_tops_from_inside_and_from_the_gap():
    """By hand: a ray that the base reflects up to the top of a long prism, and one that runs down through the gap."""
    prism = Prism(WINDOW / 10, gap=0.2, aspect=1.5)
    base = -WINDOW / 2 + prism.gap * prism.pitch / 2 + 5 * prism.pitch  # of a prism in the middle
    up = [0, base + 0.1 * prism.height, -1], [0, 0, 1]
    width, edge = prism.pitch - prism.height, prism.top_length / 2  # at z = -edge it is in the middle of the gap
    slope = -width / 2 / edge
    start = base + prism.height + width / 2 + slope * (edge - 1)
    down = [0, start, -1], [0, slope, 1]
    designed = [0, base + 0.9 * prism.height, -1], [0, 0, 1]
    starts, ways = zip(up, down, designed, strict=True)
    clear, black = (
        trace(starts, ways, (GlassSheet(0.0, 0.0, replace(prism, black=black)),), WINDOW) for black in (False, True)
    )
    assert list(clear.faces[0, :3]) == [Face.NEAR, Face.BASE, Face.TOP] and clear.faces[1, 0] == Face.TOP
    assert [*clear.end] == [End.THROUGH] * 3 and [*black.end] == [End.ABSORBED] * 2 + [End.THROUGH]
    assert black.position[:2, 1] == pytest.approx([base + prism.height] * 2)
    assert black.direction[1] == pytest.approx(np.array(ways[1]) / np.hypot(1, slope))
    assert shares(black).absorbed == 2 / 3 and shares(clear).absorbed == 0
    sheet = (GlassSheet(0.0, 0.0, replace(prism, black=True)),)
    split = trace(starts, ways, sheet, WINDOW, partial=np.random.default_rng(1))
    assert [*split.end[:2]] == [End.ABSORBED] * 2 and split.light[1] == 1 and not split.reflected[1]


def test_what_a_black_top_absorbs_has_no_field():
    scene = Chess(sheet="single", tops="black", prisms=20, eye=(0.3, 1), z2=2)
    rays = scene.trace(scene.rays((24, 24)), path=True)
    absorbed = rays.end == End.ABSORBED
    assert absorbed.sum() > 50 and (rays.jones[absorbed] == 0).all()
