"""`povgen chart` with few and small pictures, and the charts of docs/speed.md."""

import csv
import shutil

import charts as benchmark
import numpy as np
import pytest
from click.testing import CliRunner
from conftest import PROJECT

from povgen import Chess, to_pov
from povgen.cli.app import app
from povgen.errors import InputError
from povgen.measure import speed
from povgen.measure.targets import other_targets, series_targets, targets
from povgen.sheets import OTHER

TABLES = PROJECT / "docs" / "chart"


@pytest.fixture
def small(monkeypatch):
    for name, value in {
        "SIZES": ((80, 60),),
        "SAMPLINGS": ("off", "2x"),
        "GL_SAMPLINGS": ("off", "4x"),
        "LIVE_RAYS": (1, 16),
        "CONVERGED": "1,0.001,5",
        "ROUNDS": 1,
    }.items():
        monkeypatch.setattr(speed, name, value)


def table(file):
    _, *rows = csv.reader(file.open())
    return rows


@pytest.mark.parametrize("live", [False, pytest.param(True, marks=pytest.mark.release)])
def test_the_command_writes_charts_and_tables(live, small, tmp_path, monkeypatch):
    def no_browser():
        raise InputError("no Chromium")

    if not live:
        monkeypatch.setattr(speed, "chromium", no_browser)
    done = CliRunner().invoke(app, ["chart", "-o", str(tmp_path)])
    assert done.exit_code == 0 and ("without the live view: no Chromium" in done.output) == (not live), done.output
    names = {"frames.csv", "machine.txt", "frames-80x60.png", "frames-80x60.svg"}
    assert {path.name for path in tmp_path.iterdir()} == names
    rows = {(row[0], row[1]): [*map(float, row[4:])] for row in table(tmp_path / "frames.csv")}
    assert len(rows) == 2 * 2 * (2 + live) and all(seconds > 0 for seconds, *_ in rows.values())
    error = {name: rms for name, (_, rms, _) in rows.items()}
    for sheet in ("detailed", "ideal"):
        plain = error[sheet, "off"]
        assert error[sheet, "2x"] < plain
        for renderer, one, many in (("gl", "off", "4x"), ("live", "1 ray", "16 rays"))[: 1 + live]:
            assert error[f"{renderer} {sheet}", one] == pytest.approx(plain, rel=0.1)
            assert error[f"{renderer} {sheet}", many] < 0.6 * plain


def test_picture_error():
    scene, white = Chess(), np.full((60, 80, 3), 255, np.uint8)
    assert speed.picture_error(white, white, scene) == (0, 0)
    rms, flip = speed.picture_error(white, white // 255 * 0, scene)
    assert rms == 1 and flip > 0.9
    outside = white.copy()
    outside[:5] = 0  # not in the window
    assert speed.picture_error(outside, white, scene) == (0, 0)


def test_prisms_by_hand_are_povgens():
    ours = speed.sample(to_pov(Chess()), "off", (160, 120))[1]
    assert {*benchmark.baselines()} == {"intersections", "prisms"}
    for name, macro in benchmark.baselines().items():
        theirs = speed.sample(to_pov(Chess(), sheet_macro=macro), "off", (160, 120))[1]
        assert speed.picture_error(theirs, ours, Chess())[0] < 0.02, name


def test_the_charts_of_the_page_are_drawn_from_their_tables(tmp_path):
    for file in TABLES.glob("*.csv"):
        shutil.copy(file, tmp_path)
    benchmark.draw(tmp_path)
    drawn = {path.name for path in tmp_path.glob("*.png")}
    assert drawn == {"prisms.png", "beyond.png", "workers.png"} | {path.name for path in TABLES.glob("frames-*.png")}


@pytest.mark.release
def test_what_the_page_measures(monkeypatch, tmp_path):
    for name, value in {
        "MAIN_SIZE": (80, 60),
        "SMALL": (240, 180),  # in fewer pixels some squares behind the sheet of kind axis are too small to be found
        "FLICKER_SAMPLINGS": ("off", "3x"),
        "FLICKER_ANGLES": (66,),
        "PRISM_COUNTS": (50, 200),
        "WORKER_COUNTS": (16,),
        "ROUNDS": 1,
        # one or two places of each kind; `povgen verify` measures more of them
        "targets": lambda sheet, _, **values: targets(sheet, 2, **values),
        "series_targets": lambda sheet, windows, _, **values: series_targets(sheet, windows, 2, **values),
        "other_targets": lambda: {sheet: scenes[:2] for sheet, scenes in other_targets().items()},
    }.items():
        monkeypatch.setattr(benchmark, name, value)
    off, finer = (float(flicker) for _, flicker in benchmark.flicker())
    assert 0 < finer < 0.5 * off
    (*_, ideal), (*_, few), (*_, many) = benchmark.prisms()
    assert ideal < 0.05 < many and few == pytest.approx(4 * many, rel=0.2)
    rows = [*benchmark.beyond()]
    assert {name for kind, name, *_ in rows if kind == "other ideal sheets"} == {*OTHER}
    for kind, _, cpu, error in rows:
        assert cpu > 0 and (0.1 < error < 12 if kind == "detailed" else error < 0.1)
    ((_, wall, busy, _),) = benchmark.workers()
    assert wall > 0 and 0 < busy < 1.2
