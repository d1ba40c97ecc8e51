"""`povgen chart` with few and small pictures."""

import csv
import os
import re
import shutil

import numpy as np
import pytest
from conftest import PROJECT, refused
from typer.testing import CliRunner

from povgen import Chess, MovieSpec, to_pov
from povgen.cli.app import app
from povgen.errors import InputError
from povgen.measure import charts, plotting, speed
from povgen.measure.targets import other_targets, series_targets, targets
from povgen.sheets import OTHER

BASELINES = PROJECT / "benchmarks"


def test_the_command_writes_charts_and_tables(tmp_path, tmp_path_factory, monkeypatch):
    spec = MovieSpec.load("vary-alpha")
    small = {
        "SIZES": ((64, 48), (80, 60)),
        "MAIN_SIZE": (80, 60),
        "SMALL": (240, 180),  # in fewer pixels some squares behind the sheet of kind axis are too small to be found
        "SAMPLINGS": ("off", "2x"),
        "BASELINE_SAMPLINGS": ("off",),
        "GL_SAMPLINGS": ("off", "4x"),
        "LIVE_RAYS": (1, 16),
        "CONVERGED": "1,0.001,5",
        "FLICKER_SAMPLINGS": ("off", "3x"),
        "FLICKER_ANGLES": (66,),
        "PRISM_COUNTS": (50, 200),
        "WORKER_COUNTS": (16,),
        "MOVIE": spec.model_copy(update={"frames": 3}),
        "ROUNDS": 1,
        # one or two places of each kind; `povgen verify` measures more of them
        "targets": lambda sheet, _, **values: targets(sheet, 2, **values),
        "series_targets": lambda sheet, windows, _, **values: series_targets(sheet, windows, 2, **values),
        "other_targets": lambda: {sheet: scenes[:2] for sheet, scenes in other_targets().items()},
    }
    for name, value in small.items():
        monkeypatch.setattr(speed, name, value)
    folder = tmp_path_factory.mktemp("baselines")
    for file in BASELINES.glob("*.inc"):
        shutil.copy(file, folder)
    (folder / "other.csv").write_text(f"{','.join(charts.FRAMES_HEAD)}\nMitsuba,4 rays,80,60,2.5,0.3,0.4,0.4\n")
    done = CliRunner().invoke(app, ["chart", "-o", str(tmp_path), "--baselines", str(folder)])
    assert done.exit_code == 0, done.output
    names = ("frames-64x48", "frames-80x60", "prisms", "beyond", "workers")
    files = {f"{name}.{kind}" for name in names for kind in ("png", "svg")}
    assert {path.name for path in tmp_path.iterdir()} == files | {
        *(
            "frames.csv",
            "flicker.csv",
            "prisms.csv",
            "beyond.csv",
            "workers.csv",
            "machine.txt",
            "field.png",
            "curl.png",
            "curl.csv",
        ),
        *("charts.html", "polarisation.png", "diffraction.png", "polarisation.csv", "diffraction.csv", "field.csv"),
    }
    rows = list(csv.DictReader((tmp_path / "frames.csv").open()))
    assert len(rows) == 2 * 2 * 2 + 2 + 2 * (2 * 2 * 2) + 1
    assert [*rows[-1].values()] == ["Mitsuba", "4 rays", "80", "60", "2.5", "0.3", "0.4", "0.4"]
    error = {(r["method"], r["antialias"], r["height"]): float(r["RMS"]) for r in rows}
    assert error["detailed", "2x", "60"] < error["detailed", "off", "60"]
    assert error["intersections", "off", "60"] == pytest.approx(error["detailed", "off", "60"], abs=0.02)
    for sheet in ("detailed", "ideal"):
        assert error[f"live {sheet}", "16 rays", "60"] < 0.6 * error[f"live {sheet}", "1 ray", "60"]
        assert error[f"live {sheet}", "1 ray", "60"] == pytest.approx(error[sheet, "off", "60"], rel=0.1)
        assert error[f"gl {sheet}", "4x", "60"] < 0.6 * error[f"gl {sheet}", "off", "60"]
        assert error[f"gl {sheet}", "off", "60"] == pytest.approx(error[sheet, "off", "60"], rel=0.1)
    cost = {(r["method"], r["antialias"], r["height"]): float(r["CPU s"]) for r in rows}
    assert all(seconds > 0 for seconds in cost.values())
    off, finer = (float(row["flicker"]) for row in csv.DictReader((tmp_path / "flicker.csv").open()))
    assert 0 < finer < 0.5 * off
    (ideal, few, many) = csv.DictReader((tmp_path / "prisms.csv").open())
    assert float(ideal["position error (px)"]) < 0.05 < float(many["position error (px)"])
    assert float(few["position error (px)"]) == pytest.approx(4 * float(many["position error (px)"]), rel=0.2)
    rows = list(csv.DictReader((tmp_path / "beyond.csv").open()))
    off = {(row["kind"], row["windows or sheet"]): float(row["position error (px)"]) for row in rows}
    assert {name for kind, name in off if kind == "other ideal sheets"} == {*OTHER}
    for (kind, _), error in off.items():
        assert 0.1 < error < 12 if kind == "detailed" else error < 0.1
    assert all(float(row["CPU s"]) > 0 for row in rows)
    (movie,) = csv.DictReader((tmp_path / "workers.csv").open())
    assert 0 < float(movie["fraction of cores busy"]) < 1.2


def test_charts_are_drawn_again_from_their_tables(tmp_path):
    tables = PROJECT / "docs" / "chart"
    (tmp_path / "again").mkdir()
    for name in ("empty.csv", "other.csv", "holiday.png"):  # no files of this measurement
        (tmp_path / "again" / name).write_bytes(b"\xff" * (name != "empty.csv"))
    done = CliRunner().invoke(app, ["chart", "--from", str(tables), "-o", str(tmp_path / "again")])
    assert done.exit_code == 0, done.output
    for table in ("frames.csv", "flicker.csv", "prisms.csv", "beyond.csv", "workers.csv"):
        assert (tmp_path / "again" / table).read_text() == (tables / table).read_text()
        assert table == "flicker.csv" or any((tmp_path / "again").glob(table.replace(".csv", "*.png")))
    for table in ("frames.csv", "flicker.csv"):
        shutil.copy(tables / table, tmp_path)
    head, *rows = (tables / "prisms.csv").read_text().splitlines()
    for wrong in (
        (head,),
        (),
        rows,
        (head, "ideal,many,1,1"),
        *((head, f"ideal,9,{x},1") for x in ("nan", "1e400", "-1")),
    ):
        (tmp_path / "prisms.csv").write_text("\n".join(wrong))
        with pytest.raises(InputError, match=r"prisms.csv': allowed: a table that povgen chart wrote"):
            charts.read_tables(tmp_path)
    for name, missing in (("prisms.csv", "detailed,"), ("beyond.csv", "ideal,1,")):
        folder = tmp_path / name.replace(".", "-")
        shutil.copytree(tables, folder, ignore=shutil.ignore_patterns("*.png", "*.svg"))
        lines = (tables / name).read_text().splitlines()
        (folder / name).write_text("\n".join(line for line in lines if not line.startswith(missing)))
        with pytest.raises(InputError, match=r"^tables in '.*': rows are missing; allowed: tables that povgen chart"):
            charts.read_tables(folder)
    with pytest.raises(InputError, match=r"none/frames.csv': No such file or directory; allowed: a table"):
        charts.read_tables(tmp_path / "none")
    page = (tmp_path / "again" / "charts.html").read_text()
    assert (
        page.count("data:image/png;base64,") == 10 and page.count("<details>") == 6
    )  # diffraction.csv ... are too long
    assert "<td>1,0.9,2</td>" in page and not re.search("(src|href)=.?(http|//)", page)


def test_a_chart_names_its_lines_beside_their_ends():
    """Names beside the chart are in the lines' order, and do not overlap."""
    with plotting.style():
        ax = plotting.Figure(figsize=(6, 4)).subplots()
        for name, end in (("low", 0.1), ("middle", 0.11), ("high", 0.12)):
            ax.plot([1, 0], [end, 0.5], label=name)  # the end is where x is greatest
        ax.set_ylim(0, 1)
        plotting.name_lines(ax)
    heights = [text.get_position()[1] for text in ax.texts]
    assert [text.get_text() for text in ax.texts] == ["low", "middle", "high"]
    assert min(np.diff(heights)) * 4 * 72 * 0.77 > 0.95 * 10 * 1.25 and heights[1] == pytest.approx(0.11, abs=0.01)


def test_without_opengl_or_a_browser_they_are_not_measured(monkeypatch):
    def without(what):
        raise InputError(f"no {what}")

    monkeypatch.setattr(speed, "SIZES", ((64, 48),))
    monkeypatch.setattr(speed, "SAMPLINGS", ("off",))
    monkeypatch.setattr(speed, "CONVERGED", "1,0.001,2")
    monkeypatch.setattr(speed, "ROUNDS", 1)
    monkeypatch.setattr(speed, "chromium", lambda: without("Chromium"))
    monkeypatch.setattr(speed, "Drawn", lambda scene: without("OpenGL"))
    said = []
    points = speed.measure_samplings({}, said.append)
    assert said[:2] == ["without the renderer gl: no OpenGL", "without the live view: no Chromium"]
    assert [point.method for point in points] == ["detailed", "ideal"]


def test_picture_error():
    scene, white = Chess(), np.full((60, 80, 3), 255, np.uint8)
    assert speed.picture_error(white, white, scene) == (0, 0)
    rms, flip = speed.picture_error(white, white // 255 * 0, scene)
    assert rms == 1 and flip > 0.9
    outside = white.copy()
    outside[:5] = 0  # not in the window
    assert speed.picture_error(outside, white, scene) == (0, 0)


def test_the_pareto_front():
    measured = ("a", 1, 0.5), ("b", 2, 0.6), ("c", 3, 0.1), ("d", 0.5, 0.9), ("e", 3.5, 0.1)
    points = [speed.Point("m", name, (1, 1), tuple, [cpu], rms) for name, cpu, rms in measured]
    assert [point.sampling for point in speed.pareto_front(points, "rms")] == ["d", "a", "c"]


def test_baselines_are_the_same_prisms(tmp_path):
    ours = speed.sample(to_pov(Chess()), "off", (160, 120))[1]
    for name, macro in speed.baselines(BASELINES).items():
        theirs = speed.sample(to_pov(Chess(), sheet_macro=macro), "off", (160, 120))[1]
        assert speed.picture_error(theirs, ours, Chess())[0] < 0.02, name
    with pytest.raises(InputError, match="no .inc file"):
        speed.baselines(tmp_path)


def test_a_table_of_another_program_has_the_columns_of_frames(tmp_path):
    assert [point.sampling for point in charts.read_frames(BASELINES / "mitsuba.csv")] == ["1 ray", "4 rays", "16 rays"]
    for text in ("method,CPU s\na,1\n", f"{','.join(charts.FRAMES_HEAD)}\na,b,1,1,?,1,1,1\n"):
        (tmp_path / "own.csv").write_text(text)
        with pytest.raises(InputError, match=r"own.csv': allowed: a table of povgen chart, with the columns method"):
            charts.read_frames(tmp_path / "own.csv")


def test_nothing_of_the_environment_changes_when_the_cache_is_empty(tmp_path, monkeypatch):
    for own in ("own", None):
        monkeypatch.setenv("POVGEN_CACHE", "own")
        if own is None:
            monkeypatch.delenv("POVGEN_CACHE")
        with pytest.raises(KeyError), speed.empty_cache(tmp_path):
            assert os.environ["POVGEN_CACHE"] == str(tmp_path)
            raise KeyError
        assert os.environ.get("POVGEN_CACHE") == own


def test_a_baseline_is_one_macro_that_leaves_the_scenes_names_as_they_are(tmp_path):
    assert {*speed.baselines(BASELINES)} == {"intersections", "prisms"}
    macro = "// by hand\n#macro Sheet(Angle, Centre)\n  #local Reach = 1;\n  sphere { 0, Reach }\n#end\n"
    for text in (macro.replace("local", "declare"), f"#declare Tile = 3;\n{macro}", f"{macro}#macro Slope() 1 #end\n"):
        (tmp_path / "own.inc").write_text(text)
        with pytest.raises(InputError, match=r"own.inc: allowed: a macro Sheet whose names are #local"):
            speed.baselines(tmp_path)
    (tmp_path / "own.inc").write_text(macro)
    assert speed.baselines(tmp_path) == {"own": macro}
    for name in ("ideal", "gl detailed", "nonideal"):  # would be taken for one of povgen's own
        (tmp_path / f"{name}.inc").write_text(macro)
        with pytest.raises(InputError, match=f"{name}.inc: allowed: a name that"):
            speed.baselines(tmp_path)
        (tmp_path / f"{name}.inc").unlink()


def test_titles_say_what_was_measured(tmp_path, monkeypatch):
    figures = []
    monkeypatch.setattr(plotting, "save_drawing", lambda figure, *_: figures.append(figure))

    def point(method, cpu, sampling="2x"):
        return speed.Point(method, sampling, (64, 48), None, [cpu], 0.1, 0.1, 0.1)

    points = [point("detailed", 2), point("gl detailed", 3), point("gl detailed", 9, "5x"), point("ideal", 1)]
    charts.save_frames(points, tmp_path)
    titles = [ax.get_title("left") for ax in figures[-1].axes]
    assert titles == ["Prisms: gl is slower than POV-Ray", "Ideal sheet: error against cost"]
    for dear, costs in ((False, (1, 1.8, 2.6)), (True, (1, 2.1, 2.0))):
        charts.save_beyond([("ideal", str(n), cost, 0.0) for n, cost in enumerate(costs, 1)], tmp_path)
        left, _ = figures[-1].axes
        assert left.get_title("left").startswith("CPU time" if dear else "A further window costs less")
        assert [text.get_text() for text in left.texts][2] == ("2.00 (-0.10)" if dear else "2.60 (+0.80)")
    for errors, costs, titles in (
        ((8, 4), (1, 1.2), ["Twice as many prisms: half the error", "More prisms cost little more CPU time"]),
        ((8, 7), (1, 2.2), ["Error for each number of prisms", "CPU time for each number of prisms"]),
    ):
        rows = [("detailed", n, cost, error) for n, cost, error in zip((50, 100), costs, errors, strict=True)]
        charts.save_prism_counts(rows, tmp_path)
        assert [ax.get_title("left") for ax in figures[-1].axes] == titles
    for busy, title in ((0.9, "Several processes for each core keep the cores busy"), (0.4, "A movie's time by")):
        charts.save_workers([(2, 10.0, 0.5, 2), (4, 8.0, busy, 2)], tmp_path)
        assert figures[-1].axes[0].get_title("left").startswith(title)


@pytest.mark.parametrize("options", [("--from", "--baselines"), ("--from", "--optics"), ("--baselines", "--optics")])
def test_options_of_chart_that_do_not_go_together(options, tmp_path):
    values = {"--from": [str(PROJECT / "docs" / "chart")], "--baselines": [str(BASELINES)]}
    line = [word for option in options for word in (option, *values.get(option, []))]
    assert re.match("povgen: (baselines|optics): with --(from|optics)", refused(["chart", *line], tmp_path))
