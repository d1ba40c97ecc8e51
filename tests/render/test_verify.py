"""The checks of `povgen verify` at reduced size, that they can fail, and the limits that the maps found."""

import csv
import json

import numpy as np
import pytest
from conftest import povgen, refused

from povgen.measure import (
    probes,
    rounding,
    stability,
    verify,
    verify_gl,
    verify_ideal,
    verify_light,
    verify_prisms,
    verify_series,
)
from povgen.measure.measured import Measured
from povgen.measure.stability_map import RENDERED, StabilityMap
from povgen.measure.targets import SERIES, targets
from povgen.optics import equations
from povgen.optics.trace import End
from povgen.rendering import gl_runner
from povgen.scene import camera, survey
from povgen.sheets import OTHER

SIZE = (320, 240)
SMALL = (160, 120)
# each check with few scenes, in pictures of a given size
REDUCED = {
    "positions": lambda size: verify_ideal.ideal_positions(8, size),
    "directions": verify_ideal.ideal_directions,
    "piece": verify_ideal.chess_pieces,
    "horizon": verify_ideal.horizon,
    "real image": verify_ideal.real_image,
    "alpha = 0": verify_ideal.nothing_changed,
    "every pixel": lambda size: verify_prisms.every_pixel((100, 1000), (35,), 2, size),
    "finite prisms": lambda size: verify_prisms.finite_prisms((25, 400), 3, size),
    "paraxial prediction": lambda size: verify_prisms.paraxial_prediction(4, size),
    "other prisms": lambda size: verify_prisms.other_prisms(((1.7, 40),), (35,), 4, size),
    "other sheets": verify_ideal.other_sheets,
    "series positions": lambda size: verify_series.series_positions(4, size),
    "series directions": verify_series.series_directions,
    "series image": verify_series.series_image,
    "series pixels": lambda size: verify_series.series_pixels((100,), SERIES[1::2], size),
    "series prediction": lambda size: verify_series.series_prediction(3, size),
    "errors of building": lambda size: verify_prisms.errors_of_building(verify_prisms.BUILDS, size),
    "hyperbola": verify_prisms.hyperbola,
    "designed fraction": lambda size: verify_prisms.designed_fraction((66,), size),
}
# pictures that are large enough for the bounds; SMALL if not named
SIZES = dict.fromkeys(["other sheets", "real image", "hyperbola", "other prisms", "paraxial prediction"], (240, 180))
SIZES |= {"series image": (480, 360), "series prediction": SIZE}
# of POV-Ray's pictures: larger ones, where each pixel is checked
RENDERED_SIZES = SIZES | dict.fromkeys(
    ["directions", "alpha = 0", "every pixel", "other prisms", "series directions", "series pixels"]
    + ["errors of building", "designed fraction"],
    SIZE,
)


@pytest.mark.parametrize("name", REDUCED)
def test_bounds_hold(name):
    figures = list(REDUCED[name](RENDERED_SIZES.get(name, SMALL)))
    assert figures and all(figure.holds for figure in figures), figures


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
            found = scene.trace(camera.along(scene, direction), survey.max_trace_level(scene))
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


def changed(scene, name):
    """The scene half a degree of alpha off, or in checks of lengths with another length."""
    if name in ("hyperbola", "finite prisms"):
        change = {"L": scene.L + 0.05}
    elif name in ("real image", "series image"):
        change = {"z2": 0.98 * scene.z2}
    else:
        change = {"alpha": scene.alpha + 0.5}
    return scene.model_copy(update=change)


@pytest.mark.parametrize("name", REDUCED)
def test_bounds_hold_for_exact_probes_and_fail_for_other_scenes(name, monkeypatch):
    size = SIZES.get(name, SMALL)
    monkeypatch.setattr(probes, "decoded", exact)
    figures = list(REDUCED[name](size))
    assert figures and all(figure.holds for figure in figures), figures
    monkeypatch.setattr(probes, "decoded", lambda scenes, size: exact([changed(s, name) for s in scenes], size))
    assert not all(figure.holds for figure in REDUCED[name](size))


@pytest.mark.parametrize(
    ("check", "size"),
    [
        (verify_light.black_tops, SIZE),
        (verify_light.partial_reflection, SMALL),
        (verify_light.reflected_light, SMALL),
    ],
)
def test_what_real_glass_does(check, size, monkeypatch):
    assert all(figure.holds for figure in check(size))
    # other prisms than those of the reference
    to_pov = probes.to_pov
    monkeypatch.setattr(probes, "to_pov", lambda scene: to_pov(scene.model_copy(update={"index": 1.55})))
    assert not all(figure.holds for figure in check(SMALL))


def test_the_command(tmp_path, monkeypatch):
    """Status 0 and all figures where bounds hold, 1 where one does not; nothing measured for what cannot be."""
    from typer.testing import CliRunner

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
    files = ["--json", str(tmp_path / "x.json"), "--html", str(tmp_path / "x.html")]
    done = CliRunner().invoke(app, ["verify", *files])
    assert done.exit_code == 1 and "FAILS" in done.output
    page = (tmp_path / "x.html").read_text()
    assert "<td>a thing</td><td>0.5 px</td><td>≤ 1 px</td><td>ok</td>" in page
    assert page.count('<tr class="FAILS">') == 1 and "&lt;nowhere&gt;" in page
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
        (["--html", "x.txt"], ["x.txt", ".html"]),
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


def test_a_limit_is_where_the_ordinate_crosses_the_tolerance():
    measured = StabilityMap("name", "title", "finding", "x", "y", 1.0, "")
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


@pytest.mark.parametrize(
    ("measure", "options", "right"),
    [
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
        (stability.prism_count, {"counts": (300,), "size": SIZE}, lambda y: y["wrong pixels"] == [0]),
        (stability.gap_width, {"gaps": (1e-6, 1e-2)}, lambda y: y["N = 100"][0] > 10 and y["N = 100"][1] < 0.1),
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
)
def test_maps_show_where_methods_fail(measure, options, right):
    found = next(measure(**options))
    series = {name: [y for other, _, y in found.rows if other == name] for name, _, _ in found.rows}
    assert right(series), series


def test_distance_map_is_that_of_the_exact_trace():
    angles, distance = stability.field_angle((6,), SIZE)
    assert all(0 <= y <= 100 for _, _, y in angles.rows + distance.rows)
    assert len([name for name, *_ in angles.rows if name.endswith(RENDERED)]) * 2 == len(angles.rows)
    rendered = {row[:2]: row[2] for row in angles.rows}
    for (name, angle), y in rendered.items():
        if not name.endswith(RENDERED):
            assert rendered[name + RENDERED, angle] == pytest.approx(y, abs=0.5)


def test_maps_are_drawn_and_tabled(tmp_path):
    from povgen.measure.stability_chart import save_maps

    found = []
    maps = [*stability.grid(stability.OFF_AXIS[1:2], SIZE), *stability.trace_level((64, 48))]
    save_maps(maps, tmp_path, found.append)
    assert {path.name for path in tmp_path.iterdir()} == {
        *("grid.csv", "grid.png", "trace-level.csv", "trace-level.png")
    }
    rows = list(csv.reader((tmp_path / "grid.csv").open()))
    error = "worst error (px)"
    assert rows[0] == ["series", "predicted upper bound of the error (px)", error]
    assert len(rows) == 5 and {limit.sheet for limit in found} == {"ideal", "detailed", "single"} and len(found) == 11
    assert all(limit.holds for limit in found if limit.sheet == "ideal")


@pytest.mark.parametrize(("rising", "bounds", "shaded"), [(True, (3, 5), (3, 100)), (False, (3, 5), (1, 5))])
@pytest.mark.parametrize("shape", ["lines", "range"])
def test_values_beyond_the_strictest_limit_are_shaded(shape, rising, bounds, shaded, tmp_path):
    from povgen.measure.plotting import drawn
    from povgen.measure.stability_chart import draw_map

    measured = StabilityMap("name", "title", "finding", "x", "y", 1.0, "x", shape=shape)
    for n, bound in enumerate(bounds):
        measured.add(f"N = {n}", 1, 0.1)
        measured.add(f"N = {n}", 100, 2 + n)
        measured.limit("ideal", f"N = {n}", bound, rising=rising)
    with drawn(8, 5, tmp_path / "map.png") as figure:
        ax = figure.subplots()
        draw_map(ax, measured)
        (span,) = ax.patches
        left, right = ax.get_xlim()
        across = span.get_patch_transform().transform(span.get_path().vertices)[:, 0]
        assert (across.min(), across.max()) == pytest.approx(
            (max(shaded[0], left), right) if rising else (left, shaded[1])
        )
        texts = [text.get_text() for text in ax.texts]
        assert ("povgen refuses above 3" if rising else "povgen refuses below 5") in texts


def test_the_range_of_series_is_drawn_with_its_mean(tmp_path):
    from povgen.measure.plotting import drawn
    from povgen.measure.stability_chart import draw_map

    measured = StabilityMap("name", "title", "finding", "x", "y", 10.0, "", shape="range")
    for name, values in {"a": (1, 2), "b": (3, 6), f"a{RENDERED}": (1.5, 2), f"b{RENDERED}": (3.5, 6)}.items():
        for x, y in enumerate(values):
            measured.add(name, x, y)
    with drawn(8, 5, tmp_path / "map.png") as figure:
        ax = figure.subplots()
        draw_map(ax, measured)
        (band,) = ax.collections
        mean, pictures, *_ = ax.lines
        assert mean.get_ydata() == pytest.approx([2, 4]) and pictures.get_ydata() == pytest.approx([2.5, 4])
        assert {y for _, y in band.get_paths()[0].vertices} == {1, 2, 3, 6}


def test_what_exceeds_a_bound_is_shaded(tmp_path):
    from povgen.measure.plotting import drawn
    from povgen.measure.stability_chart import draw_map

    measured = StabilityMap("name", "title", "finding", "x", "y", 2.5, "xy", shape="bound")
    for x, y in ((0.1, 0.3), (1, 1.2), (10, 10.4), (100, 101)):
        measured.add("some scene", x, y)
    measured.limit("ideal", "some scene", 2)  # the tolerance is 0.5 more
    with drawn(8, 5, tmp_path / "map.png") as figure:
        ax = figure.subplots()
        draw_map(ax, measured)
        points, shaded = ax.collections
        assert (points.get_facecolors()[:, :3] == 1).all(1).tolist() == [False, False, True, True]  # beyond the limit
        exceeds = [shaded.get_paths()[0].contains_point(point) for point in points.get_offsets()]
    assert exceeds == [False, False, False, True]


def test_rounding_decides_for_few_rays():
    """Of all rays, not of those that differ: else `verify` would excuse whatever POV-Ray does."""
    for scene, most in ((probes.Directions(), 0.006), (probes.Directions(prisms=1000, z2=2), 0.25)):
        _, direction = camera.rays(scene, (48, 36))
        assert rounding.decided_by_rounding(scene, direction).mean() < most


@pytest.mark.parametrize("prisms", [50, 200])
def test_the_paraxial_prediction_fails_where_moire_bands_are_wide(prisms, monkeypatch):
    """docs/accuracy.md: below |alpha| = 800 deg/N it leaves much of eq. 7's error, above it little."""
    monkeypatch.setattr(probes, "decoded", exact)
    left = []
    for alpha in (0, 400 / prisms, 800 / prisms):
        scenes = targets("detailed", 6, seed=3, E=0j, alphas=(alpha, alpha), prisms=prisms)
        thin, thick = verify_prisms.errors(scenes, SIZE)
        left.append(thick / thin)
    assert left[0] > 0.8 and left[1] > 0.2 and left[2] < 0.1, left


def test_the_index_of_glass_turns_no_ray_on_the_designed_path():
    """docs/sheets.md: what a millionth more of it, as the far sheet has in POV-Ray, does to rays."""
    scene = probes.Directions(z2=2)
    _, direction = camera.rays(scene, SIZE)
    before = scene.trace(camera.along(scene, direction))
    changed = scene.model_copy(update={"index": scene.index * (1 + 1e-6)})
    # of the same length
    changed = changed.model_copy(update={"aspect": scene.prism.length / changed.prism.length})
    after = changed.trace(camera.along(changed, direction))
    leaves = before.end <= End.BACK
    same = leaves & (before.faces == after.faces).all(1) & (before.end == after.end)
    turned = np.linalg.norm(before.direction - after.direction, axis=1)
    assert turned[same & before.designed].max() < 1e-12 and (same | ~before.designed).all()
    assert 1e-5 < np.quantile(turned[same & ~before.designed], 0.99) < 1e-4 and (leaves & ~same).mean() < 1e-3


# ---- the ideal sheet's camera


# ---- the limits are in force


def test_warnings_are_said_once_and_not_with_quiet(tmp_path):
    frame = ["frame", "chess", "--alpha", "1", "--size", "64x48", "--antialias", "1,0.5,1"]
    status, _, errors = povgen(frame, tmp_path)
    assert status == 0 and errors.count("warning") == 1 and "within 8 degrees" in errors
    assert not povgen([*frame, "--quiet"], tmp_path)[2]
