"""The checks of `povgen verify` at reduced size, that they can fail, and the limits that the maps found."""

import csv
import json
import subprocess

import numpy as np
import pytest
from conftest import POVGEN

from povgen.measure import probes, stability, verify
from povgen.measure.stability import Map
from povgen.optics import prism
from povgen.optics.trace import End

SIZE = (320, 240)
REDUCED = {
    "positions": lambda: verify.ideal_positions(8, SIZE),
    "directions": lambda: verify.ideal_directions(SIZE),
    "piece": lambda: verify.piece((640, 480)),
    "horizon": lambda: verify.horizon(SIZE),
    "real image": lambda: verify.real_image((640, 480)),
    "alpha = 0": lambda: verify.nothing_changed(SIZE),
    "every pixel": lambda: verify.every_pixel((100, 1000), (35,), 4, SIZE),
    "finite prisms": lambda: verify.finite_prisms((25, 100, 400), 4, SIZE),
    "paraxial prediction": lambda: verify.paraxial_prediction(4, SIZE),
    "hyperbola": lambda: verify.hyperbola(SIZE),
    "designed fraction": lambda: verify.designed_fraction((66,), SIZE),
}


@pytest.mark.parametrize("name", REDUCED)
def test_bounds_hold(name):
    figures = list(REDUCED[name]())
    assert figures and all(figure.holds for figure in figures), figures


@pytest.mark.parametrize("name", REDUCED)
def test_bounds_fail_for_another_scene(name, monkeypatch):
    """Half a degree in alpha turns every check red, but for three that are of lengths."""
    render = probes.frames

    def other(scene):
        if name in ("hyperbola", "finite prisms"):
            change = {"L": scene.L + 0.05}
        elif name == "real image":
            change = {"z2": 0.98 * scene.z2}
        else:
            change = {"alpha": scene.alpha + 0.5}
        return scene.model_copy(update=change)

    monkeypatch.setattr(probes, "frames", lambda scenes, size: render([other(s) for s in scenes], size))
    assert not all(figure.holds for figure in REDUCED[name]())


def test_the_command(tmp_path, monkeypatch):
    """Status 0 and all figures where bounds hold, 1 where one does not; nothing measured for what cannot be."""
    from typer.testing import CliRunner

    from povgen.cli.app import app

    made = [
        verify.Measured("ideal", "a thing", 0.5, 1.0, "px"),
        verify.Measured("ideal", "more", 2, 1, "%", least=True),
    ]
    monkeypatch.setattr(verify, "checks", lambda sheet: iter(made))
    done = CliRunner().invoke(app, ["verify", "--json", str(tmp_path / "x.json")])
    assert done.exit_code == 0 and "a thing" in done.output and "FAILS" not in done.output
    figures = json.loads((tmp_path / "x.json").read_text())["figures"]
    assert [figure["value"] for figure in figures] == [0.5, 2] and all(figure["holds"] for figure in figures)
    made.append(verify.Measured("ideal", "nowhere", float("nan"), 1))
    done = CliRunner().invoke(app, ["verify", "--json", str(tmp_path / "x.json")])
    assert done.exit_code == 1 and "FAILS" in done.output
    assert json.loads((tmp_path / "x.json").read_text())["figures"][2]["value"] is None


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--sheet", "single"], ["sheet", "single", "ideal or detailed"]),
        (["--json", "x.txt"], ["x.txt", ".json"]),
        (["-o", "maps"], ["output", "maps", "--stability"]),
        (["--stability", "-o", "no/where"], ["no/where", "No such file"]),
    ],
)
def test_bad_options_are_refused(options, words, tmp_path):
    done = subprocess.run([POVGEN, "verify", *options], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and all(word in done.stderr for word in words), done
    assert not list(tmp_path.iterdir())


def test_a_limit_is_where_the_ordinate_crosses_the_tolerance():
    map = Map("name", "title", "x", "y", 1.0, "")
    for x, y in ((1, 0.2), (3, 0.5), (5, 1.5), (7, 0.1)):
        map.add("series", x, y)
    map.limit("ideal", "series", 3.9)
    map.limit("ideal", "series", 4.1)
    map.limit("ideal", "series", 6.1, rising=False)
    assert [limit.value for limit in map.limits] == pytest.approx([4, 4, 7 - 2 * 0.9 / 1.4])
    assert [limit.holds for limit in map.limits] == [True, False, True]
    map.add("never", 1, float("nan"))
    map.add("never", 2, 0.0)
    map.limit("ideal", "never", 1)
    assert not map.limits[-1].holds


@pytest.mark.parametrize(
    ("measure", "options", "right"),
    [
        (
            stability.pole,
            {"conditions": (3, 1e7), "size": SIZE},
            lambda y: y["eq. 7, α → 180°"][0] < 0.05 and np.isnan(y["eq. 7, z1 → z2"][-1]),
        ),
        (
            stability.prediction,
            {"conditions": (1, 8), "size": SIZE},
            lambda y: y["α → 180°"][0] < 0.3 < 2 < y["α → 180°"][-1],
        ),
        (stability.prism_count, {"counts": (300,), "size": SIZE}, lambda y: y["leak"] == [0]),
        (stability.gap_width, {"gaps": (1e-6, 1e-2)}, lambda y: y["N = 100"][0] > 10 and y["N = 100"][1] < 0.1),
        (
            stability.aliasing,
            {"counts": (12, 100), "size": (160, 120)},
            lambda y: y["pixels"][0] < 0.19 < y["pixels"][1],
        ),
        (stability.moire, {"alphas": (0, 30)}, lambda y: y["N = 100"][0] > 2 > y["N = 100"][1] == 1),
    ],
)
def test_maps_show_where_methods_fail(measure, options, right):
    found = next(measure(**options))
    series = {name: [y for other, _, y in found.rows if other == name] for name, _, _ in found.rows}
    assert right(series), series


def test_distance_map_is_that_of_the_exact_trace():
    angles, distance = stability.field_angle((2, 6), SIZE)
    assert all(0 <= y <= 100 for _, _, y in angles.rows + distance.rows)
    assert len([name for name, *_ in angles.rows if name.endswith(stability.RENDERED)]) * 2 == len(angles.rows)
    rendered = {row[:2]: row[2] for row in angles.rows}
    for (name, angle), y in rendered.items():
        if not name.endswith(stability.RENDERED):
            assert rendered[name + stability.RENDERED, angle] == pytest.approx(y, abs=0.5)


def test_maps_are_drawn_and_tabled(tmp_path):
    from povgen.measure.charts import save_maps

    found = []
    save_maps([*stability.grid(stability.ASIDE[:4], SIZE), *stability.trace_level((64, 48))], tmp_path, found.append)
    assert {path.name for path in tmp_path.iterdir()} == {
        *("grid.csv", "grid.png", "trace-level.csv", "trace-level.png", "stability.png")
    }
    rows = list(csv.reader((tmp_path / "grid.csv").open()))
    assert rows[0] == ["series", "the most that the error should be (px)", "worst error of position (px)"]
    assert len(rows) == 17 and {limit.sheet for limit in found} == {"ideal", "detailed", "single"} and len(found) == 14
    assert all(limit.holds for limit in found if limit.sheet == "ideal")


def test_rounding_decides_for_few_rays():
    """Of all rays, not of those that differ: else `verify` would excuse whatever POV-Ray does."""
    for scene, most in ((probes.Directions(), 0.006), (probes.Directions(prisms=1000, z2=2), 0.25)):
        _, direction = probes.rays(scene, (48, 36))
        assert verify._sensitive(scene, direction).mean() < most


def traced_frames(scenes, size):
    """As `probes.frames` for `Positions`, by the ray trace."""
    for scene in scenes:
        inside, direction = probes.rays(scene, size)
        found = probes.traced(scene, direction, most=20)
        on = found.position + ((scene.z1 - found.position[:, 2]) / found.direction[:, 2])[:, None] * found.direction
        on[found.end != End.THROUGH] = np.nan
        told = np.full((*inside.shape, 3), np.nan)
        told[inside] = on - (scene.L.real, scene.L.imag, scene.z1)
        yield told


@pytest.mark.parametrize("prisms", [50, 200])
def test_the_paraxial_prediction_fails_where_moire_bands_are_wide(prisms, monkeypatch):
    """docs/accuracy.md: below |alpha| = 800 deg/N it leaves much of eq. 7's error, above it little."""
    monkeypatch.setattr(probes, "frames", traced_frames)
    left = []
    for alpha in (0, 400 / prisms, 800 / prisms):
        scenes = verify.targets("detailed", 6, seed=3, E=0j, alphas=(alpha, alpha), prisms=prisms)
        thin, thick = verify.errors(scenes, SIZE)
        left.append(thick / thin)
    assert left[0] > 0.8 and left[1] > 0.2 and left[2] < 0.1, left


def test_the_index_of_glass_turns_no_ray_on_the_designed_path(monkeypatch):
    """docs/sheets.md: what a millionth more of it, as the far sheet has in POV-Ray, does to rays."""
    scene = probes.Directions(z2=2)
    _, direction = probes.rays(scene, SIZE)
    before = probes.traced(scene, direction)
    length = prism.aspect()
    monkeypatch.setattr(prism, "aspect", lambda: length)
    monkeypatch.setattr(prism, "INDEX", prism.INDEX * (1 + 1e-6))
    after = probes.traced(scene, direction)
    leaves = before.end <= End.BACK
    same = leaves & (before.faces == after.faces).all(1) & (before.end == after.end)
    turned = np.linalg.norm(before.direction - after.direction, axis=1)
    assert turned[same & before.designed].max() < 1e-12 and (same | ~before.designed).all()
    assert 1e-5 < np.quantile(turned[same & ~before.designed], 0.99) < 1e-4 and (leaves & ~same).mean() < 1e-3


def test_warnings_are_said_once_and_not_with_quiet(tmp_path):
    base = [POVGEN, "frame", "chess", "--alpha", "1", "--size", "64x48", "--antialias", "1,0.5,1"]
    done = subprocess.run(base, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and done.stderr.count("warning") == 1 and "3 degrees" in done.stderr
    assert not subprocess.run([*base, "--quiet"], cwd=tmp_path, capture_output=True, text=True).stderr
