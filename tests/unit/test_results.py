"""Tables of many scenes: their columns, their numbers, and the processes that compute them."""

import errno
import math
import os
import subprocess
import sys

import numpy as np
import pytest

from povgen import Chess, InputError, Spheres, results, stopping
from povgen.inputs import mesh
from povgen.optics import equations, series
from povgen.rendering import parallel, survey_cache
from povgen.rendering import results as module
from povgen.rendering.parallel import worker_count
from povgen.scene import survey

SCENES = [Chess(sheet="ideal", alpha=alpha, z1=z1) for alpha in (0, 66, 180) for z1 in (2, 6)]


def test_a_mirrored_picture_has_no_angle_and_one_at_infinity_no_place():
    scenes = [Chess(sheet="mirror", alpha=0, z1=z1, pedestal=1.65) for z1 in (2, 6, 12)]
    found = results([*scenes, Chess(sheet="lens", focal_length=1.5)], "seen_nu", "seen_M", "x", "y", workers=1)
    assert np.isnan(found["seen_nu"]).tolist() == [False, True, True, True]
    width, height = 6 / (6 + 12), 6 / (12 - 6)
    assert found["seen_M"][:3] == pytest.approx([(0.75 + 1.5) / 2, np.inf, (width + height) / 2])
    for name in ("x", "y"):
        assert np.isnan(found[name]).tolist() == [False, False, False, True]
    assert results([Chess(sheet="ideal", alpha=180, z1=6)], "seen_M", "M", workers=1)["seen_M"] == [np.inf]


def test_the_columns_are_what_differs_and_the_quantities():
    table = results(SCENES, "M", "nu", "visible", progress=False)
    assert list(table) == ["alpha", "z1", "M", "nu", "visible"] and {len(column) for column in table.values()} == {6}
    assert all(column.dtype == float for column in table.values())
    r, alpha = 6 / table["z1"], np.radians(table["alpha"])
    np.testing.assert_allclose(table["M"], equations.M(r, alpha))
    np.testing.assert_allclose(np.radians(table["nu"]), equations.nu(r, alpha), atol=1e-12)
    assert np.isnan(table["nu"]).tolist() == [False] * 5 + [True] and table["visible"].tolist() == [1] * 5 + [0]


def test_columns_of_all_kinds_of_parameters():
    scenes = [
        Chess(sheet="none", eye=(0.5, 1), x=(0, 1)),
        Chess(sheet="law", parameter={"k": 2}, window="alpha=30,z=2,sheet=axis,axis=0,1,0"),
        Spheres(sheet="none", z1=3, fresnel=True),
    ]
    table = results((scene for scene in scenes), "x", progress=False)
    assert table["scene"].tolist() == ["chess", "chess", "spheres"] and table["sheet"].tolist() == [
        "none",
        "law",
        "none",
    ]
    assert table["eye_x"].tolist() == [0.5, 0, 0] and table["x_2"][0] == 1 and np.isnan(table["x_2"][1:]).all()
    assert table["window2_alpha"][1] == 30 and table["window2_z"][1] == 2 and table["parameter_k"][1] == 2
    assert [table[f"window2_axis_{name}"][1] for name in "xyz"] == [0, 1, 0] and "window2_axis_1" not in table
    assert table["piece"].tolist() == ["knight", "knight", ""] and table["fresnel"].tolist() == [False, False, True]
    assert "background" not in table and "z1" in table


def test_what_the_ray_trace_finds():
    scene = Chess(alpha=120, z1=2)
    table = results([scene], "designed", "stray", "closest", "spot", progress=False)
    assert table["designed"][0] == pytest.approx(survey.survey(scene).designed, abs=0.03)
    assert 0.2 < table["stray"][0] < 1 - table["designed"][0]
    ideal = results([scene.replace(sheet="ideal")], "closest", "spot", "designed", progress=False)
    W = series.image_depth(2, np.radians(120))
    assert ideal["closest"][0] == pytest.approx(W.real) and ideal["designed"][0] > 0.9
    assert table["closest"][0] == pytest.approx(W.real, abs=0.1)
    assert 0.5 < table["spot"][0] / ideal["spot"][0] < 1  # the designed path has smaller angles
    black = results([scene.replace(tops="black")], "stray", progress=False)
    assert black["stray"][0] < 0.5 * table["stray"][0]
    dark = Chess(sheet="law", law="x, y, -z")
    assert np.isnan(results([dark], "closest", progress=False)["closest"][0])


@pytest.fixture
def talking(tmp_path, monkeypatch):
    """Python prints something whenever it starts."""
    (tmp_path / "sitecustomize.py").write_text("print('hello', flush=True)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)


def test_other_processes_find_the_same(monkeypatch, capsys, talking):
    alone = results(SCENES, "M", "x", progress=False, workers=1)
    monkeypatch.setattr(module, "PATIENCE", 0)
    together = results(SCENES, "M", "x", workers=2)
    assert list(together) == list(alone) and all(
        np.array_equal(together[name], alone[name], equal_nan=True) for name in alone
    )
    assert capsys.readouterr().err.splitlines() == [f"results: {n}/6 scenes" for n in range(1, 7)]


@pytest.mark.filterwarnings("error")  # such as of a pipe that is not closed
@pytest.mark.parametrize("fault", [None, "ends", "does not start"])
def test_items_of_a_process_that_fails_are_left_out(fault, monkeypatch):
    started, start = [], parallel.python

    def python(name):
        if started and fault == "does not start":
            raise OSError(errno.EAGAIN, "no more processes")
        started.append(start("no_module" if started and fault == "ends" else name))
        return started[-1]

    monkeypatch.setattr(parallel, "python", python)
    done = []
    found = parallel.computed(math.sqrt, [1, 4, 9, 16, 25], 2, lambda: done.append(1))
    assert found == ({0: 1, 2: 3, 4: 5} if fault else {0: 1, 1: 2, 2: 3, 3: 4, 4: 5}) and len(done) == len(found)
    assert all(process.poll() is not None for process in started)


def test_what_no_other_process_computes_is_computed_here(monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", 0)
    monkeypatch.setattr(module, "computed", lambda *_: {1: [7.0]})
    table = results(SCENES, "M", workers=2, progress=False)
    assert table["M"][1] == 7 and np.array_equal(np.delete(table["M"], 1), np.delete(results(SCENES, "M")["M"], 1))


class Mine(Chess):
    """A scene that other processes do not know."""


def test_scenes_of_ones_own(monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", 0)
    monkeypatch.setattr(module, "computed", None)
    assert results([Mine(), Mine(alpha=3)], "M", workers=2, progress=False)["alpha"].tolist() == [66, 3]


def test_a_parameter_with_the_name_of_a_quantity():
    scenes = [Chess(x=x, sheet="ideal") for x in (0, 0.5)]
    table = results(scenes, "x", "nu", progress=False)
    assert list(table) == ["scene_x", "x", "nu"] and table["scene_x"].tolist() == [0, 0.5]
    assert table["x"].tolist() == [scene.apparent_position(scene.objects[0][0], 2).real for scene in scenes]
    assert results(scenes, "nu", progress=False)["x"].tolist() == [0, 0.5]


def test_a_number_of_workers_can_be_numpys():
    assert [worker_count(each) for each in (np.int64(2), 2, "2", None)] == [2, 2, 2, None]
    with pytest.raises(InputError, match="workers = "):
        worker_count(np.bool_(True))


def test_surveys_of_many_scenes_are_made_by_several_processes(talking, monkeypatch):
    """They are those that this process makes. What Python prints at its start is none, and no mesh."""
    scenes = [
        *(Chess(alpha=alpha, prisms=10) for alpha in (10, 20)),
        Chess(sheet="lenticular", f_number=8),
        Chess(sheet="law", law="x - k*X*z, y, z", parameter={"k": 1}, window="z=3,sheet=detailed,prisms=10"),
    ]
    monkeypatch.setattr(survey_cache.cache, "load_values", lambda _: None)
    monkeypatch.setattr(survey_cache, "EACH", 2)
    monkeypatch.setattr(survey_cache, "cores", lambda: 2)
    monkeypatch.setattr(survey, "known", {})
    survey_cache.make([Chess(sheet="ideal"), *scenes[:1], *scenes])
    assert {given: survey._traced(given) for given in map(survey.inputs, scenes)} == survey.known
    triangle = b"solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid\n"
    assert "1 of" not in mesh.text_and_note(triangle, "stl", "", 0.3)[1]


def test_a_process_ends_when_nobody_reads_its_answers():
    code = "from povgen import stopping\nprint('{', file=stopping.answers())\nprint('a driver')\nwhile True: pass"
    process = subprocess.Popen([sys.executable, "-c", f"print('a start', flush=True)\n{code}"], stdout=subprocess.PIPE)
    assert [process.stdout.readline() for _ in range(4)] == [b"a start\n", b"\n", stopping.BEGIN, b"{\n"]
    assert process.poll() is None
    process.stdout.close()  # as the kernel does for a process that is killed
    assert process.wait(60) == 1
