"""The checks of `povgen verify` at reduced size, that they can fail, and the limits that the maps found."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from conftest import povgen, refused, some

from povgen.measure import compare, probes, stability, verify, verify_gl
from povgen.measure.measured import Measured
from povgen.measure.plotting import Figure, name_lines
from povgen.measure.stability_map import RENDERED, StabilityMap, draw_map, save_maps
from povgen.measure.targets import targets
from povgen.optics import equations
from povgen.optics.trace import End
from povgen.rendering import gl_runner
from povgen.scene import camera, survey
from povgen.sheets import OTHER

SIZE = (320, 240)
SMALL = (160, 120)
# The ways of measuring, each with how many scenes of a check are measured, and the size of the pictures. Of two sizes,
# the second is that of POV-Ray's pictures, where each pixel is checked.
WAYS = {
    "positions": (6, SMALL),
    "directions": (2, SMALL, SIZE),
    "pieces": (5, SMALL),
    "horizon": (5, SMALL),
    "parallax": (6, (240, 180)),
    "pixels": (2, SMALL, SIZE),
    "prediction": (4, (240, 180)),
    "power_law": (24, SMALL),
    "ghosts": (1, (400, 250)),
    "screens": (3, SMALL),
    "field_of_view": (3, SMALL),
    "designed_fraction": (2, SMALL, SIZE),
}
# pictures that are large enough for the bounds of lines with these words
LARGER = {"sheet ": (240, 180), "2 windows: image": (480, 360), "windows of 2x100": SIZE}
BRIGHTNESS = ("black_tops", "partial_reflection", "reflected_light")
ALL = [(way, every) for every in (False, True) for way in sorted(WAYS, key=("power_law", "pixels").count)]


def reduced(way, every, rendered=False):
    """The first check of a way, or all, with few scenes and small pictures."""
    count, *sizes = WAYS[way]
    found = [check for check in verify.table() if check.way.__name__ == way]
    for check in found if every else found[:1]:
        usual = sizes[-1 if rendered else 0]
        size = next((larger for words, larger in LARGER.items() if words in check.lines[0][0]), usual)
        step = 2 if way == "parallax" else 1  # pairs of eyes
        count = min(3 if "windows of 2x100" in check.lines[0][0] else count, len(check.scenes))
        taken = [*range(len(check.scenes))][: count * step] if way != "power_law" else range(0, len(check.scenes), 3)
        yield replace(check, scenes=[check.scenes[n] for n in taken], size=size)


RENDER = ("positions", "directions", "pieces", "pixels")  # in every run of the tests; else with the release


@pytest.mark.parametrize(
    ("way", "every"),
    [
        pytest.param(way, every, marks=[pytest.mark.release] * (every or way not in RENDER))
        for way in WAYS
        for every in (False, True)
        if way not in ("ghosts", "screens", "field_of_view")
    ],
)
def test_bounds_hold(way, every):
    figures = [measured for check in reduced(way, every, rendered=True) for measured in check.measured()]
    assert figures and all(measured.holds for measured in figures), figures


def exact(scenes, size):
    """Decode probes as `probes.decoded` does, but without POV-Ray: by exact rotation or the exact ray trace.

    The chess piece is a slanted board, which is as good to fit.
    """
    for scene in scenes:
        inside, direction = camera.rays(scene, size)
        if scene.sheet in ("ideal", "none", *OTHER):
            position = np.array([scene.E.real, scene.E.imag, -scene.z2]) + direction * scene.z2 / direction[:, 2:]
            ends = np.zeros(len(direction), bool)
            for place, alpha in zip(scene.places, scene.alphas, strict=True):
                position = position + direction * (place - position[:, 2:]) / direction[:, 2:]
                if scene.sheet in OTHER:
                    direction = scene.sheets[0].bend(direction, position[:, 0] + 1j * position[:, 1])
                if scene.sheet == "ideal":
                    direction = equations.rotate(direction, np.radians(alpha))
                leaves = position + direction * scene.depth / 2 / direction[:, 2:]
                ends |= abs(leaves[:, :2]).max(1) > scene.aperture / 2
        else:
            found = scene.trace(scene.camera.along(direction), survey.max_trace_level(scene))
            position, direction = found.position, found.direction
            ends = found.end > End.BACK
            if isinstance(scene, probes.Positions):
                ends = found.end != End.THROUGH
        if isinstance(scene, probes.Directions):
            seen = np.array(direction)
        else:
            slant = 0.5 if isinstance(scene, probes.PiecePositions) else 0
            offset = position - (scene.L.real, scene.L.imag, scene.places[-1] + scene.z1)
            along = (slant * offset[:, 0] - offset[:, 2]) / (direction[:, 2] - slant * direction[:, 0])
            seen = offset + along[:, None] * direction
            ends |= abs(seen[:, :2]).max(1) > (0.4 if slant else scene.extent)
        seen[ends] = np.nan
        decoded = np.full((*inside.shape, 3), np.nan)
        decoded[inside] = seen
        yield decoded


def other(check, scenes):
    """Other scenes than the check expects."""
    wrong = ({name: getattr(scene, name) + step for name, step in check.wrong.items()} for scene in scenes)
    return [scene.replace(**values) for scene, values in zip(scenes, wrong, strict=True)]


@pytest.mark.parametrize(("way", "every"), some(ALL, len(WAYS) // 2, several=True))
def test_bounds_hold_for_exact_probes_and_fail_for_other_scenes(way, every, monkeypatch):
    for check in reduced(way, every):
        monkeypatch.setattr(probes, "decoded", exact)
        figures = list(check.measured())
        assert figures and all(measured.holds for measured in figures), figures
        with monkeypatch.context() as patch:
            patch.setattr(probes, "decoded", lambda scenes, size, check=check: exact(other(check, scenes), size))
            if way in ("ghosts", "screens"):  # which render nothing
                trace, wrong = probes.Positions.trace, partial(other, check)
                patch.setattr(
                    probes.Positions, "trace", lambda scene, *a, t=trace, w=wrong, **k: t(*w([scene]), *a, **k)
                )
            assert way == "field_of_view" or not all(measured.holds for measured in check.measured()), figures


@pytest.mark.parametrize(
    "way", [pytest.param(way, marks=[pytest.mark.release] * (way != "partial_reflection")) for way in BRIGHTNESS]
)
def test_what_real_glass_does(way, monkeypatch):
    check = next(check for check in verify.table("detailed") if check.way.__name__ == way)
    small = replace(check, size=SIZE if way == "black_tops" else SMALL)
    assert all(measured.holds for measured in small.measured())
    to_pov = probes.to_pov
    monkeypatch.setattr(probes, "to_pov", lambda scene: to_pov(other(check, [scene])[0]))
    assert not all(measured.holds for measured in replace(check, size=SMALL).measured())


def test_the_command(tmp_path, monkeypatch):
    """Status 0 and all figures where bounds hold, 1 where one does not; nothing measured for what cannot be."""
    from click.testing import CliRunner

    from povgen.cli.app import app

    made = [
        Measured("ideal", "a thing", 0.5, 1.0, "px"),
        Measured("ideal", "more", 2, 1, "%", least=True),
    ]
    monkeypatch.setattr(verify, "checks", lambda sheet: iter(made))
    done = CliRunner().invoke(app, ["verify", "--json", str(tmp_path / "x.json")])
    assert done.exit_code == 0 and "a thing" in done.output and "FAILS" not in done.output
    figures = json.loads((tmp_path / "x.json").read_text())["figures"]
    assert [figure["value"] for figure in figures] == [0.5, 2] and all(figure["holds"] for figure in figures)
    made.append(Measured("ideal", "<nowhere>", float("nan"), 1))
    done = CliRunner().invoke(app, ["verify", "--json", str(tmp_path / "x.json")])
    assert done.exit_code == 1 and done.output.count("FAILS") == 1 and "0.5 px" in done.output
    assert json.loads((tmp_path / "x.json").read_text())["figures"][2]["value"] is None
    monkeypatch.setattr(verify_gl, "checks", lambda: iter(made[:2]))
    done = CliRunner().invoke(app, ["verify", "--gl", "--json", str(tmp_path / "x.json")])
    assert done.exit_code == 0 and "a thing" in done.output
    assert json.loads((tmp_path / "x.json").read_text())["versions"]["OpenGL by"] == gl_runner.device()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--sheet", "single"], ["sheet", "single", "ideal or detailed"]),
        (["--json", "x.txt"], ["x.txt", ".json"]),
        (["-o", "maps"], ["output", "maps", "--stability"]),
        (["--stability", "-o", "no/where"], ["no/where", "No such file"]),
        (["--gl", "--sheet", "ideal"], ["gl: measured alone; allowed without --sheet, --stability and --live"]),
        (["--gl", "--live"], ["gl: measured alone"]),
        (["--live", "--stability"], ["live: measured alone; allowed without --sheet and --stability"]),
    ],
)
def test_bad_options_are_refused(options, words, tmp_path):
    message = refused(["verify", *options], tmp_path)
    assert all(word in message for word in words), message


def test_of_many_series_those_are_drawn_whose_levels_are_spread_evenly():
    measured = StabilityMap("name", "title", "x", "y", 1.0, "x", finding="finding", dot="the level")
    for n in (3, 7, 1, 9, 5, 0, 8, 2, 6, 4):
        measured.rows += [(f"{n}", 1, 2), (f"{n}", 20, 0.5), (f"{n}{RENDERED}", 3, 1), (f"{n}{RENDERED}", 5 + n, 0.8)]
    ax = Figure().subplots()
    draw_map(ax, measured)
    assert [text.get_text() for text in ax.texts] == ["the level", "0", "4", "9", "allowed: 1"]
    assert [line.get_xdata()[0] for line in ax.lines if len(line.get_xdata()) == 1] == [5, 9, 14]
    assert ax.get_title(loc="left") + ax.get_title() == "finding in these 10 scenes (3 shown)"


def test_names_are_beside_their_lines_and_hide_nothing():
    ax, x = Figure(figsize=(6, 4)).subplots(), np.linspace(0, 1, 300)
    lines = {"rising": x, "falling": 1 - x, "level": 0.5 + 0 * x}
    for name, y in lines.items():
        ax.plot(x, y, label=name)
    name_lines(ax, ("dot", [(0.5, 0.9)], "black"))
    boxes = {text.get_text(): text.get_window_extent().padded(2) for text in ax.texts}
    assert [*boxes] == ["dot", *lines]
    for name, box in boxes.items():
        assert box.count_overlaps(boxes.values()) == 1, name
        for other, y in lines.items():
            places = ax.transData.transform(np.column_stack((x, y)))
            assert not any(box.contains(*place) for place in places), (name, other)
            assert other != name or any(box.padded(15).contains(*place) for place in places), name


def test_a_limit_is_where_the_ordinate_crosses_the_tolerance():
    measured = StabilityMap("name", "title", "x", "y", 1.0)
    for x, y in ((1, 0.2), (3, 0.5), (5, 1.5), (7, 0.1)):
        measured.add("series", x, y)
    measured.limit("ideal", "series", 3.9)
    measured.limit("ideal", "series", 4.1)
    measured.limit("ideal", "series", 6.1, rising=False)
    assert [limit.value for limit in measured.limits] == pytest.approx([4, 4, 7 - 2 * 0.9 / 1.4])
    assert [limit.holds for limit in measured.limits] == [True, False, True]
    measured.add("never", 1, float("nan"))
    measured.add("never", 2, 0.0)
    measured.limit("ideal", "never", 1)
    assert not measured.limits[-1].holds
    logarithmic = StabilityMap("name", "title", "x", "y", 1.0, "xy", rows=[("a", 1, 0.01), ("a", 1000, 10)])
    assert logarithmic.crossing("a", rising=True) == pytest.approx(100)
    for x in (1, 9):
        measured.add("always", x, 0.5)
    measured.limit("ideal", "always", 9)
    assert measured.limits[-1].value == 9


@pytest.mark.parametrize(
    ("measure", "options", "right"),
    some(
        [
            (stability.prism_count, {"counts": (300,), "size": SMALL}, lambda y: y["wrong pixels"] == [0]),
            (
                stability.pole,
                {"conditions": (3, 1e7), "size": SMALL},
                lambda y: y["eye near the axis"][0] < 0.05 and np.isnan(y["eye near the axis"]).any(),
            ),
            (
                stability.prediction,
                {"conditions": (1, 8), "size": SMALL},
                lambda y: y["α → 180°"][0] < 0.3 < 2 < y["α → 180°"][-1],
            ),
            (
                stability.gap_width,
                {"gaps": (1e-6, 1e-2)},
                lambda y: y["N = 100"][0] > 10 and y["N = 100"][1] < 0.1,
            ),
            (
                stability.aliasing,
                {"counts": (12, 100), "size": (96, 72)},
                lambda y: y["single pixels"][0] < 0.19 < y["single pixels"][1],
            ),
            (
                stability.moire,
                {"products": (0, 500, 3000)},
                lambda y: y["N = 100"][0] > 2 > y["N = 100"][1] > 1.35 > y["N = 100"][2] == 1,
            ),
        ],
        1,
        several=True,
    ),
)
def test_maps_show_where_methods_fail(measure, options, right):
    found = next(measure(**options))
    series = {name: [y for other, _, y in found.rows if other == name] for name, _, _ in found.rows}
    assert right(series), series


@pytest.mark.release
def test_distance_map_is_that_of_the_exact_trace():
    angles, distance = stability.field_angle((6,), SIZE)
    assert all(0 <= y <= 100 for _, _, y in angles.rows + distance.rows)
    assert len([name for name, *_ in angles.rows if name.endswith(RENDERED)]) * 2 == len(angles.rows)
    rendered = {row[:2]: row[2] for row in angles.rows}
    for (name, angle), y in rendered.items():
        if not name.endswith(RENDERED):
            assert rendered[name + RENDERED, angle] == pytest.approx(y, abs=0.5)


@pytest.mark.parametrize("all_maps", [False, pytest.param(True, marks=pytest.mark.release)])
def test_maps_are_drawn_and_tabled(all_maps, tmp_path):
    trace_level = stability.trace_level((64, 48)) if all_maps else ()
    found = []
    maps = [*stability.grid(stability.OFF_AXIS[1:2], SMALL), *trace_level]
    save_maps(maps, tmp_path, found.append)
    names = ["grid", "trace-level"][: 1 + all_maps]
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.{kind}" for name in names for kind in ("csv", "png")}
    head, *rows = (tmp_path / "grid.csv").read_text().splitlines()
    error = "worst error (px)"
    assert head == f"series,error that povgen states (px),{error}"
    assert len(rows) == 5 and rows[-1].startswith("# povgen record") and len(found) == (11 if all_maps else 1)
    assert all(limit.holds for limit in found if limit.sheet == "ideal")


@pytest.mark.parametrize("prisms", [50, pytest.param(200, marks=pytest.mark.release)])
def test_the_paraxial_prediction_fails_where_moire_bands_are_wide(prisms, monkeypatch):
    """docs/accuracy.md: below |alpha| = 800 deg/N it leaves much of eq. 7's error, above it little."""
    monkeypatch.setattr(probes, "decoded", exact)
    left = []
    for alpha in (0, 400 / prisms, 800 / prisms):
        scenes = targets("detailed", 6, seed=3, E=0j, alphas=(alpha, alpha), prisms=prisms)
        thin, thick = compare.errors(scenes, (240, 180) if prisms == 50 else SIZE)
        left.append(thick / thin)
    assert left[0] > 0.8 and left[1] > 0.2 and left[2] < 0.1, left


def test_the_index_of_glass_turns_no_ray_on_the_designed_path():
    """docs/sheets.md: what a millionth more of it, as the far sheet has in POV-Ray, does to rays."""
    scene = probes.Directions(z2=2)
    _, direction = camera.rays(scene, SIZE)
    before = scene.trace(scene.camera.along(direction))
    changed = scene.model_copy(update={"index": scene.index * (1 + 1e-6)})
    # of the same length
    changed = changed.model_copy(update={"aspect": scene.prism.length / changed.prism.length})
    after = changed.trace(changed.camera.along(direction))
    leaves = before.end <= End.BACK
    same = leaves & (before.faces == after.faces).all(1) & (before.end == after.end)
    turned = np.linalg.norm(before.direction - after.direction, axis=1)
    assert turned[same & before.designed].max() < 1e-12 and (same | ~before.designed).all()
    assert 1e-5 < np.quantile(turned[same & ~before.designed], 0.99) < 1e-4 and (leaves & ~same).mean() < 1e-3


def test_warnings_are_said_once_and_not_with_quiet(tmp_path):
    frame = ["frame", "chess", "--alpha", "1", "--size", "64x48", "--antialias", "1,0.5,1"]
    status, _, errors = povgen(frame, tmp_path)
    assert status == 0 and errors.count("warning") == 1 and "within 8 degrees" in errors
    assert not povgen([*frame, "--quiet"], tmp_path)[2]
