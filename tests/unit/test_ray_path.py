"""The whole path of rays: corners, optical length, polarisation and phases."""

import numpy as np
import pytest
from PIL import Image

from povgen import Bundle, Card, Chess, Eye, InputError, Room, Sphere, Window, draw
from povgen.measure import plotting
from povgen.optics.polarisation import reflection, transmission
from povgen.optics.ray_path import IDEAL
from povgen.optics.trace import End

PRISMS = Chess(alpha=66, prisms=20)


def straight(traced):
    """Return the unit directions of the parts between corners."""
    step = np.diff(traced.corners, axis=-2)
    with np.errstate(invalid="ignore"):  # a part without a length
        return step / np.linalg.norm(step, axis=-1, keepdims=True)


@pytest.mark.parametrize("values", [{}, {"sheet": "lenticular"}, {"window": "z=2,alpha=30", "z1": 3}])
def test_every_corner_obeys_snells_law_and_the_path_is_that_of_the_trace(values):
    scene = PRISMS.replace(**values)
    rays = scene.rays((24, 18))
    found, plain = scene.trace(rays, path=True), scene.trace(rays)
    assert np.array_equal(found.position, plain.position) and np.array_equal(found.end, plain.end)
    number = np.isfinite(found.corners[..., 0]).sum(-1)
    assert (number == found.count + 2).all() and not plain.corners.size
    there = np.take_along_axis(found.corners, (number - 1)[..., None, None], -2)[..., 0, :]
    assert np.array_equal(there, found.position)
    way, media = straight(found), found.media
    before, after, n1, n2 = way[..., :-1, :], way[..., 1:, :], media[..., :-1, None], media[..., 1:, None]
    bends = (found.met[..., 1:-1] > 0) & np.isfinite(after[..., 0])
    normal = np.where(n1 == n2, after - before, n2 * after - n1 * before)
    across = np.cross(n1 * before, normal) - np.cross(n2 * after, normal)
    assert bends.any() and abs(across[bends]).max() < 1e-9
    inside = found.designed
    assert (media[inside][:, 1] > 1.4).all() and (media[inside][:, 0] == 1).all()


def test_the_field_is_that_of_the_designed_path():
    rays = PRISMS.rays((40, 30))
    found = PRISMS.trace(rays, path=True)
    assert np.isfinite(found.jones[found.designed]).all()
    back = PRISMS.trace(rays, partial=np.random.default_rng(1), path=True)  # reflected rays have a field, too
    assert np.isfinite(back.jones[back.reflected]).all()


def test_light_that_a_face_reflects_from_outside_has_the_index_of_that_face():
    """Sheets of two glasses: the light that the first reflects never reaches the second."""
    two = [Window(sheet="single", prisms=9, glass=glass, z=z) for glass, z in (("N-BK7", 0), ("SF11", 3))]
    room = Room(two, eye=Eye(z=-7))
    d = np.array([0, np.sin(0.3), np.cos(0.3)])
    rays = Bundle(np.stack((np.zeros(2000), np.linspace(-1, 1, 2000), np.full(2000, -2.0)), -1), d)
    found = room.trace(rays, partial=np.random.default_rng(3), path=True)
    back = found[(found.count == 1) & (found.windows == [0] + [-1] * (found.windows.shape[-1] - 1)).all(-1)]
    cosine = abs((back.direction - d) @ d) / np.linalg.norm(back.direction - d, axis=-1)
    s, p = reflection(1, room.openings[0].sheet.glass[0].shape.index, cosine)
    assert len(back) > 5
    assert transmission(back.jones) == pytest.approx((abs(s) ** 2 + abs(p) ** 2) / 2)


def test_a_room_has_ideal_sheets_and_prisms_on_one_path():
    room = Room(
        [Window(alpha=40, yaw=20), Window(sheet="detailed", prisms=30, z=2, pitch=10, width=4, height=4)],
        eye=Eye(z=-7, view=1),
    )
    found = room.trace(room.rays((6, 4)), path=True)
    passed = found[found.designed]
    assert len(passed) and (passed.met[:, 1] == IDEAL).all() and np.isnan(passed.length).all()
    assert np.isnan(passed.jones).all()
    (sheet, _) = room.openings
    assert abs((passed.corners[:, 1] - sheet.pose.place) @ sheet.pose.axes[2]).max() < 1e-9
    table = passed.table()
    assert len(table["x"]) == np.isfinite(passed.corners[..., 0]).sum() and table["face"].min() == IDEAL
    with pytest.raises(ValueError, match="paths were not kept"):
        _ = room.trace(room.rays((6, 4))).length
    with pytest.raises(InputError, match="up to 10000000 faces"):
        PRISMS.trace(PRISMS.rays((600, 600)), path=True)


def test_a_drawing_in_space_has_the_windows_the_objects_and_the_rays(tmp_path):
    things, rays = [Window(alpha=40, x=-2), Sphere(z=2), Window(x=2, yaw=30), Sphere(x=2, z=2)], [[[0, 0, 1]]]
    rooms = [Room(things[:n]) for n in (2, 4)]
    lines = [
        draw(each, tmp_path / "a.svg", each.trace(Bundle((0, 0, -6), rays), path=True)).read_text().count("<path")
        for each in rooms
    ]
    assert lines[1] - lines[0] >= 2  # an outline, and the edges of a box in one line
    found = PRISMS.trace(PRISMS.pencil((0, 0, 2), 5), path=True)
    few, many = (draw(PRISMS, tmp_path / f"{k}.svg", found[:k]).read_text() for k in (1, 5))
    assert many.count("<path") - few.count("<path") >= 4
    for rays in (PRISMS.trace(PRISMS.rays((3, 2))), PRISMS.rays((3, 2))):
        with pytest.raises(InputError, match="paths were not kept"):
            draw(PRISMS, tmp_path / "b.svg", rays)
    Image.new("RGB", (64, 32)).save(tmp_path / "card.png")
    with pytest.raises(InputError, match="povgen reads this file"):
        draw(Room([Window(), Card(file=tmp_path / "card.png", z=3)]), tmp_path / "card.png")
    with pytest.raises(InputError, match="azimuth, elevation = nan, 20: allowed: finite"):
        draw(PRISMS, tmp_path / "b.svg", azimuth=np.nan)


def drawing(monkeypatch, scene, **options):
    """Return the axes of a drawing, and the points of its lines by their colours."""
    figures = []
    monkeypatch.setattr(plotting, "save_drawing", lambda figure, *_, **__: figures.append(figure))
    draw(scene, "a.svg", **options)
    figures[0].draw_without_rendering()
    axes = figures[0].axes[0]
    lines = [(line.get_color(), np.transpose(line.get_data())) for line in axes.lines]
    return axes, {colour: [points for each, points in lines if each == colour] for colour, _ in lines}


TWO = Room([Window(x=-1.7), Window(name="b", x=1.7, yaw=30)], eye=Eye(y=1, z=-8))


@pytest.mark.parametrize(
    ("view", "names", "upright"),
    [((-90, 0), "zy", (1, 1)), ((-90, 90), "zx", (1, -1)), ((180, 0), "xy", (1, 1)), ((90, 0), "zy", (-1, 1))],
)
def test_a_view_along_an_axis_has_numbers_where_they_belong(view, names, upright, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    axes, lines = drawing(monkeypatch, TWO, azimuth=view[0], elevation=view[1], width=84)
    assert (axes.get_xlabel(), axes.get_ylabel()) == tuple(f"{name} (tiles)" for name in names)
    ends = axes.get_xlim(), axes.get_ylim()
    assert tuple(np.sign(np.diff(ends)[:, 0])) == upright
    for drawn, opening in zip(lines[plotting.PRISMS], TWO.openings, strict=True):
        assert drawn == pytest.approx(opening.edge[:, ["xyz".index(name) for name in names]])
    low, high = np.sort(ends).T
    rays = lines[plotting.IDEAL] + lines[plotting.GREY]
    ends = TWO.trace(TWO.rays((11, 8))).end
    leave = np.isin(ends, (End.THROUGH, End.BACK, End.BESIDE)).sum()
    assert len(rays) == 88 and sum(((ray[-1] < low) | (ray[-1] > high)).any() for ray in rays) == leave > 60
    assert axes.get_position().width * axes.get_position().height > 0.5  # of the drawing


def test_a_slanted_view_is_to_scale(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    axes, lines = drawing(monkeypatch, TWO, azimuth=-60, elevation=20)
    a, e = np.radians((-60, 20))
    to_reader = np.array((-np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)))
    for drawn, opening in zip(lines[plotting.PRISMS], TWO.openings, strict=True):
        for flat, edge in zip(np.diff(drawn, axis=0), np.diff(opening.edge, axis=0), strict=True):
            assert np.linalg.norm(flat) == pytest.approx(np.linalg.norm(np.cross(edge, to_reader)))
    named = {"", "x", "y", "z", "arrows: 1 tile", "eye", "window 1", "b", "other rays", "designed path"}
    assert {text.get_text() for text in axes.texts} == named and not axes.axison


def test_a_drawing_names_what_it_shows_and_has_the_sections_of_few_prisms(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    scene = Chess(sheet="single", prisms=3, z1=4)
    axes, lines = drawing(monkeypatch, scene, azimuth=-90, elevation=0)
    assert [text.get_text() for text in axes.texts] == ["eye", "sheet", "knight", "other rays", "designed path"]
    sections = [patch.get_xy() for patch in axes.patches]
    assert len(sections) == 3 and plotting.PRISMS not in lines  # an upright line would hide the light in them
    for low, section in zip((-1.5, -0.5, 0.5), sections, strict=True):
        assert np.ptp(section[:, 0]) == pytest.approx(scene.prism.length)
        assert section[:, 1].min() == pytest.approx(low + 0.005) and np.ptp(section[:, 1]) == pytest.approx(0.99)
    light = scene.trace(scene.pencil((0.2, 0.3, 4), 20), path=True)
    axes, lines = drawing(monkeypatch, scene, traced=light, azimuth=-90, elevation=0, title="Stray light")
    assert "Stray light" in (axes.get_title("left"), axes.get_title())
    assert [text.get_text() for text in axes.texts][:2] == ["point", "sheet"]  # no ray comes from the eye
    low, high = axes.get_ylim()
    assert max(abs(ray[:, 1]).max() for ray in lines[plotting.GREY]) > 100 > 6 > high - low  # stray light leaves it
    axes, lines = drawing(monkeypatch, Chess(sheet="single", prisms=13, z1=4))
    assert len(lines[plotting.PRISMS]) == 1 and not axes.patches


def behind_prisms(theta, count=6000):
    """Return a plane wave's phase behind prisms, tiles, of exp(ik(phase + direction . place)), rays and a prism."""
    scene = Chess(sheet="single", prisms=8, gap=0.05)
    d = np.array([0, np.sin(theta), np.cos(theta)])
    start = np.stack((np.zeros(count), np.linspace(-1.4999, 1.4999, count), np.full(count, -4.0)), -1)
    found = scene.trace(Bundle(start, d), path=True)
    found, start = found[found.designed], start[found.designed]
    return start @ d + found.length - (found.position * found.direction).sum(-1), found, scene.prism


@pytest.mark.parametrize("theta", [0, 0.05])
def test_the_wave_front_is_whole_within_a_prism_and_jumps_between_prisms(theta):
    """A prism reverses the slope across its ridges (docs/sheets.md): its neighbour's part is 2 p sin(theta) ahead."""
    phase, found, prism = behind_prisms(theta)
    cell = np.floor((found.position[:, 1] + 1.5) / prism.pitch)
    parts = [phase[cell == k] for k in np.unique(cell)]
    assert len(parts) > 4 and max(map(np.ptp, parts)) < 1e-12
    jumps = np.diff([part.mean() for part in parts])
    assert jumps == pytest.approx(np.full(len(jumps), 2 * prism.pitch * np.sin(theta)), abs=1e-12)
