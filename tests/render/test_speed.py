"""What `povgen chart` measures, in small."""

import csv

import numpy as np
import pytest
from conftest import PROJECT
from typer.testing import CliRunner

from povgen import Chess, to_pov
from povgen.cli.app import app
from povgen.errors import InputError
from povgen.measure import speed

BASELINES = PROJECT / "benchmarks"


def test_the_command_writes_charts_and_tables(tmp_path, monkeypatch):
    small = {
        "SIZES": ((64, 48), (80, 60)),
        "MAIN": (80, 60),
        "SMALL": (320, 240),
        "SAMPLINGS": ("off", "2,0.9,1", "box 2"),
        "BY_HAND": ("off",),
        "CONVERGED": "1,0.001,5",
        "COUNTS": (50, 200),
        "WORKERS": (16,),
        "ROUNDS": 1,
    }
    for name, value in small.items():
        monkeypatch.setattr(speed, name, value)
    done = CliRunner().invoke(app, ["chart", "-o", str(tmp_path), "--baselines", str(BASELINES)])
    assert done.exit_code == 0, done.output
    charts = ("frames-64x48", "frames-80x60", "prisms", "workers")
    files = {f"{name}.{kind}" for name in charts for kind in ("png", "svg")}
    assert {path.name for path in tmp_path.iterdir()} == files | {
        *("frames.csv", "prisms.csv", "workers.csv", "machine.txt")
    }
    rows = list(csv.DictReader((tmp_path / "frames.csv").open()))
    assert len(rows) == 2 * 2 * 3 + 2
    error = {(r["method"], r["antialias"], r["height"]): float(r["RMS"]) for r in rows}
    assert error["detailed", "box 2", "60"] < error["detailed", "off", "60"]
    assert error["intersections", "off", "60"] == pytest.approx(error["detailed", "off", "60"], abs=0.02)
    cost = {(r["method"], r["antialias"], r["height"]): float(r["CPU s"]) for r in rows}
    assert all(seconds > 0 for seconds in cost.values())
    (ideal, few, many) = csv.DictReader((tmp_path / "prisms.csv").open())
    assert float(ideal["position error (px)"]) < 0.05 < float(many["position error (px)"])
    assert float(few["position error (px)"]) == pytest.approx(4 * float(many["position error (px)"]), rel=0.2)
    (movie,) = csv.DictReader((tmp_path / "workers.csv").open())
    assert 0 < float(movie["fraction of cores busy"]) < 1.2


def test_picture_error():
    scene, white = Chess(), np.full((60, 80, 3), 255, np.uint8)
    assert speed.picture_error(white, white, scene) == (0, 0)
    rms, flip = speed.picture_error(white, white // 255 * 0, scene)
    assert rms == 1 and flip > 0.9
    outside = white.copy()
    outside[:5] = 0  # beside the window
    assert speed.picture_error(outside, white, scene) == (0, 0)


def test_the_front():
    points = [speed.Point("m", name, (1, 1), "", [cpu], rms) for name, cpu, rms in
              (("a", 1, 0.5), ("b", 2, 0.6), ("c", 3, 0.1), ("d", 0.5, 0.9), ("e", 3.5, 0.1))]  # fmt: skip
    assert [point.sampling for point in speed.front(points, "rms")] == ["d", "a", "c"]


def test_peers_are_the_same_prisms(tmp_path):
    text = to_pov(Chess())
    ours = speed.sample(text, "off", (160, 120))[1]
    for name, by_hand in speed.rewrites(BASELINES).items():
        theirs = speed.sample(by_hand(text), "off", (160, 120))[1]
        assert speed.picture_error(theirs, ours, Chess())[0] < 0.02, name
    with pytest.raises(InputError, match="no .inc file"):
        speed.rewrites(tmp_path)
