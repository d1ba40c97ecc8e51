"""`povgen chart` with few and small pictures, and the charts of docs/speed.md."""

import shutil

import charts as benchmark
import numpy as np
import pytest
from click.testing import CliRunner
from conftest import PROJECT

from povgen import Chess, to_pov
from povgen.cli.app import app
from povgen.measure import charts, speed
from povgen.measure.plotting import table_rows

TABLES = PROJECT / "docs" / "chart"


@pytest.fixture
def small(monkeypatch):
    for name, value in {
        "SIZES": ((80, 60),),
        "SAMPLINGS": ("off", "2x"),
        "GL_SAMPLINGS": ("off", "4x"),
        "CONVERGED": "1,0.001,5",
        "ROUNDS": 1,
    }.items():
        monkeypatch.setattr(speed, name, value)
    monkeypatch.setattr(benchmark, "LIVE_RAYS", (1, 16))


@pytest.mark.parametrize("live", [False, pytest.param(True, marks=pytest.mark.release)])
def test_charts_and_tables(live, small, tmp_path, monkeypatch):
    """Those of the command, or with the points of the live view, as docs/speed.md has them."""
    if live:
        monkeypatch.setattr(benchmark, "baselines", dict)
        charts.save_frames(benchmark.frames(), tmp_path)
        (tmp_path / "machine.txt").write_text(speed.machine())
    else:
        done = CliRunner().invoke(app, ["chart", "-o", str(tmp_path)])
        assert done.exit_code == 0, done.output
    names = {"frames.csv", "machine.txt", "frames-80x60.png", "frames-80x60.svg"}
    assert {path.name for path in tmp_path.iterdir()} == names
    rows = {(row[0], row[1]): [*map(float, row[4:])] for row in table_rows(tmp_path / "frames.csv")}
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
    assert {*benchmark.baselines()} == {"intersections"}
    for name, macro in benchmark.baselines().items():
        theirs = speed.sample(to_pov(Chess(), sheet_macro=macro), "off", (160, 120))[1]
        assert speed.picture_error(theirs, ours, Chess())[0] < 0.02, name


@pytest.mark.release
def test_the_charts_of_the_page_are_drawn_from_their_tables(tmp_path):
    for file in (*TABLES.glob("*.csv"), TABLES / "machine.txt"):
        shutil.copy(file, tmp_path)
    benchmark.draw(tmp_path)
    drawn = {path.name for path in tmp_path.glob("*.png")}
    assert drawn == {"prisms.png", "beyond.png", "workers.png"} | {path.name for path in TABLES.glob("frames-*.png")}
