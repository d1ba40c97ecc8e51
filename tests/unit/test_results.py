"""Tables of many scenes: their columns, their numbers, and the processes that compute them."""

import errno
import json
import math
import os
import subprocess
import sys

import numpy as np
import pandas
import pytest
import xarray

from povgen import Chess, Eye, InputError, Room, Sphere, Spheres, Window, info, results, stopping
from povgen.inputs import mesh
from povgen.measure import results as module
from povgen.objects import OBJECTS
from povgen.optics import equations, series
from povgen.rendering import parallel, survey_cache
from povgen.rendering.parallel import worker_count
from povgen.scene import survey
from povgen.scene.quantities import unit
from povgen.scene.scene import of_record
from povgen.scene.spec import swept_numbers
from povgen.sheets import SHEETS

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


def test_the_uncertainty_says_where_predictions_fail():
    """Near the pole, prisms show the object where the equations do not say."""
    table = results([Chess(alpha=alpha, z1=7, z2=7) for alpha in (66, 178)], "x", "seen_x", "uncertainty")
    usual, near_pole = table["uncertainty"]
    assert abs(table["x"] - table["seen_x"])[0] < usual < 0.02
    assert np.isnan(table["seen_x"][1]) and near_pole > abs(table["x"][1])
    assert results(Chess(sheet="ideal", alpha=178, z1=7, z2=7), "uncertainty")["uncertainty"] == [0]
    assert np.isnan(results(Chess(sheet="ideal", alpha=180, z1=7, z2=7), "uncertainty")["uncertainty"]).all()


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
    table = results(scene, "designed", fresnel=(False, True), progress=False)
    assert 0.7 < table["designed"][1] / table["designed"][0] < 0.9  # partial reflections at the faces of two prisms
    twist = Chess(sheet="twist", twist=300, alpha=0, z1=20)  # its law is not linear: nothing is blurred by that
    for values in ({}, {"pupil": [0.1]}):
        names = "x", "seen_x", "y", "seen_y", "prism_blur"
        x, seen_x, y, seen_y, blur = (results(twist, *names, **values, progress=False)[name][0] for name in names)
        assert [seen_x, seen_y, blur] == pytest.approx([x, y, 0], abs=1e-3)
    dark = Chess(sheet="law", law="x, y, -z")
    assert np.isnan(results([dark], "closest", progress=False)["closest"][0])


@pytest.fixture
def talking(tmp_path, monkeypatch):
    """Python prints something whenever it starts."""
    (tmp_path / "sitecustomize.py").write_text("print('hello', flush=True)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)


def test_other_processes_find_the_same(monkeypatch, capsys, talking):
    alone = results(SCENES, "M", "seen_x", progress=False, workers=1)
    monkeypatch.setattr(module, "PATIENCE", 0)
    together = results(SCENES, "M", "seen_x", workers=2)
    assert list(together) == list(alone)
    for name in alone:  # numpy rounds differently with another number of threads
        np.testing.assert_allclose(together[name], alone[name], rtol=1e-12, atol=1e-12)
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
    scenes = [Chess(sheet="ideal", alpha=alpha) for alpha in (0, 2, 5)]
    table = results(scenes, "x", workers=2, progress=False)
    assert table["x"][1] == 7 and table["x"][::2].tolist() == [results(each, "x")["x"][0] for each in scenes[::2]]


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


def test_many_scenes_at_once_are_those_one_by_one():
    """Whatever kind of sheets and of scene."""
    rng, quantities = np.random.default_rng(5), ("x", "y", "nu", "M", "visible")
    linear = [name for name in SHEETS if Chess(sheet=name).sheets[0].transfer is not None]
    kinds = [{"sheet": name} for name in linear] + [
        {"error": {"turn": 1, "far_tilt_x": 2}},
        {"window": "z=3,sheet=detailed", "sheet": "ideal"},
        {"window": ["z=2,alpha=20", "z=4,sheet=single"], "prisms": 30},
        {"sheet": "axis", "window": "z=2.5,sheet=detailed", "axis": (0, 0, 1)},
    ]
    assert len(linear) > 8
    for kind in kinds:
        scene = [Chess(x=0.3, eye=(0.6, -0.2), **kind), Spheres(z1=(3, 6), z2=4, **kind)][rng.integers(2)]
        z1, alpha, z2 = rng.uniform(1, 5, 2), [0, 180, *rng.uniform(-360, 360, 2)], rng.uniform(3, 9, 2)
        every = [scene.replace(z1=b, alpha=a, z2=c) for b in z1 for a in alpha for c in z2]
        expected = np.array(module.values_of(every, quantities)).T
        found = results(scene, *quantities, z1=z1, alpha=alpha, z2=z2, progress=False)
        assert list(found) == ["alpha", "z2", "z1", *quantities]
        np.testing.assert_allclose([found[name] for name in quantities], expected, 1e-12, 1e-12, err_msg=str(scene))
        for name in ("z1", "alpha", "z2"):
            assert found[name].tolist() == [getattr(each, name) for each in every]
    for scene in (Chess(), Spheres(sheet="ideal")):  # the default of alpha is a whole number
        for name in ("z1", "z2"):
            one_by_one = results([scene.replace(**{name: x}) for x in (7, 9)], "nu", "M", progress=False)
            found = results(scene, "nu", "M", progress=False, **{name: (7, 9)})
            assert found["nu"] == pytest.approx(one_by_one["nu"]) and found["M"] == pytest.approx(one_by_one["M"])


def test_lists_of_values():
    scene = Chess(sheet="ideal", prisms=30)
    table = results(
        scene, "nu", "designed", alpha=(30, 60), eye=[(0, 0), (1, 0), (1, 1)], glass=["BK7"], progress=False
    )
    assert list(table) == ["alpha", "glass", "eye_x", "eye_y", "nu", "designed"] and len(table["nu"]) == 6
    assert (
        table["eye_x"].tolist() == [0, 1, 1] * 2 and (table["nu"][:3] == results(scene, "nu", alpha=[30])["nu"]).all()
    )
    two = scene.replace(z1=[2, 3], window="alpha=30,z=1")
    parts = results(two, "x", "nu", eye_x=[0.5], z1_2=(4, 5), window2_alpha=[40])  # the names of columns
    whole = results(scene.replace(window="alpha=40,z=1"), "x", "nu", eye=[(0.5, 0)], z1=[(2, 4), (2, 5)])
    assert list(parts) == ["eye_x", "z1_2", "window2_alpha", "x", "nu"] and parts["z1_2"].tolist() == [4, 5]
    assert parts["x"].tolist() == whole["x"].tolist() and parts["nu"].tolist() == whole["nu"].tolist()
    for wrong in ("eye_1", "eye_xy", "z1_x", "z1_02", "window_1"):
        with pytest.raises(InputError, match="unknown"):
            results(two, "nu", **{wrong: [1]})
    changed = Chess(sheet="ideal", window="z=0.35,alpha=30").with_numbers({"aperture": 5, "window2_z": 0.6})
    assert changed.window[0].z == 0.6  # both at once: the first one alone is refused
    spheres = results(Spheres(sheet="ideal"), "x", z2=(4, 5))  # which move with the eye
    assert spheres["x"].tolist() == [results(Spheres(sheet="ideal", z2=z2), "x")["x"][0] for z2 in (4, 5)]
    assert list(results(scene, "x", x=(0, 0.5), z1=[3])) == ["z1", "scene_x", "x"]
    outlined = Chess(sheet="ideal", predicted_image=True)
    for wrong, says in [
        ({"alpha": (0, 400)}, "alpha = 400"),
        ({"z1": (0.1, 2)}, "z1 = 0.1: the knight would touch"),
        ({"z2": (0.1, 2)}, "z2 = 0.1: the eye"),
        ({"alpha": (0, np.nan)}, "alpha = nan"),
        ({"alpha": (0, "a")}, "alpha = 'a'"),
        ({"alpha": (True, False)}, "alpha = True"),
        ({"alpha": 3}, "alpha = 3: should be a list"),
        ({"alpha": []}, "alpha: no values"),
        ({"alfa": (1, 2)}, "'alfa': unknown in the scene chess"),
        ({"alpha": range(1000), "z1": range(1, 1000)}, "alpha, z1: 999000 scenes or more"),
        ({"alpha": (0, 180, 300), "z1": [6]}, "appears at infinity"),
    ]:
        with pytest.raises(InputError, match=says):
            results(outlined, "nu", **wrong)
    with pytest.raises(InputError, match="should be a scene"):
        results([scene], "nu", alpha=(1, 2))


def test_a_thousand_predictions_are_made_at_once(monkeypatch):
    asked, whole = [], Chess.nu_and_M
    monkeypatch.setattr(Chess, "nu_and_M", lambda scene, z1: asked.append(z1) or whole(scene, z1))
    alpha = np.linspace(0, 170, 1000)
    found = results(Chess(), "nu", "M", alpha=alpha)
    assert len(asked) == 2 and len({*found["nu"]}) == 1000
    results([Chess(alpha=each) for each in alpha[:3]], "nu")
    assert len(asked) == 5


def test_a_dataset(tmp_path, monkeypatch):
    scene = Chess(prisms=30)
    table = results(scene, "designed", "nu", prisms=(30, 10, 20), glass=("BK7", "N-SF11"), progress=False)
    table.to_xarray().to_netcdf(tmp_path / "study.nc")
    with xarray.open_dataset(tmp_path / "study.nc") as data:
        assert dict(data.sizes) == {"prisms": 3, "glass": 2} and data.prisms.values.tolist() == [30, 10, 20]
        p = float(data.designed.sel(prisms=10, glass="N-SF11"))
        assert p == table["designed"][3] and data.designed_error.attrs["units"] == "1"
        assert float(data.designed_error.sel(prisms=10, glass="N-SF11")) == pytest.approx(np.sqrt(p * (1 - p) / 10_000))
        assert data.designed.attrs["ancillary_variables"] == "designed_error" and "nu_error" not in data
        assert data.nu.attrs == {
            "units": "degrees",
            "long_name": "angle by which it appears turned; NaN unless all sheets only rotate light",
        }
        (stated,) = json.loads(data.attrs["record"]).values()
        record = info(tmp_path / "study.nc")
        assert record.stated == stated
        assert of_record(record) == [scene.replace(glass="BK7")] and "povgen cite" in record.cite
        assert record.command.startswith("povgen.results(Chess(prisms=30), 'designed', 'nu', prisms=(30, 10, 20)")
        assert "Local light-ray rotation" in data.attrs["references"] and data.attrs["source"].startswith("povgen 0.")
    assert pandas.DataFrame(table).to_dict("list") == {name: column.tolist() for name, column in table.items()}
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(InputError, match="to_xarray needs xarray, which is not installed: .*pip install"):
        table.to_xarray()


def test_the_dimensions_of_a_dataset():
    """The lists of values, and the columns along them; without lists one dimension."""
    scene, eyes = Chess(sheet="ideal", fresnel=False), [(0, 0), (1, 0), (1, 1)]
    data = results(scene, "x", z2=(30, 6), x=(1, 0), eye=eyes, progress=False).to_xarray()
    assert data.x.dims == ("z2", "scene_x", "eye") and data.scene_x.dims == ("scene_x",)
    assert data.eye_x.values.tolist() == [0, 1, 1] and data.eye_y.dims == ("eye",)
    units = dict.fromkeys(("z2", "scene_x", "eye_x", "eye_y", "x"), "tiles")
    assert {name: each.attrs["units"] for name, each in data.variables.items()} == units
    assert data.z2.values.tolist() == [30, 6] and {"z2", "scene_x", "eye_x"} <= {*data.coords}
    shown = scene.replace(x=1, eye=(1, 1))
    assert float(data.x[1, 0, 2]) == pytest.approx(shown.apparent_position(shown.L, 2).real)
    aside = results(scene, "nu", x=[(0, 1), (1, 2)], z1=[(2, 3)], window=[(), "z=2"], progress=False).to_xarray()
    assert dict(aside.sizes) == {"x": 2, "z1": 1, "window": 2} and aside.x_2.dims == ("x",)
    named = results(scene, "x", "nu", x=[(0, 1), (1, 2)], z1=[(2, 3)], progress=False).to_xarray()
    assert named.x_2.dims == ("scene_x",) and named.x.dims == ("scene_x", "z1")  # x is also a quantity
    assert aside.z1_2.dims == ("z1",) and aside.window2_z.dims == ("x", "z1", "window")
    room = Room([Window(name="left"), Sphere(z=2)])
    turned = results(room, "x", **{"left.alpha": (0, 9), "eye.x": (0, 1)}, progress=False).to_xarray()
    assert turned.x.dims == ("left_alpha", "eye_x") and turned.left_alpha.values.tolist() == [0, 9]
    scenes = [scene, scene.replace(z2=7), Spheres(sheet="ideal", z1=2, error={"tilt_x": 1})]
    odd = results(scenes, "M", progress=False).to_xarray()
    assert dict(odd.sizes) == {"scene": 3} and odd.z2.dims == ("scene",) and "z2" in odd.coords
    assert odd.scene.values.tolist() == ["chess"] * 2 + ["spheres"] and odd.error_tilt_x.attrs["units"] == "degrees"
    window = {"z": 2, "sheet": "law", "law": "x, y + focus*z, z"}
    turning = [
        Chess(sheet="axis", alpha=20, axis=(x, 1, 0), window={**window, "parameter": {"focus": x}}) for x in (0, 1)
    ]
    plain = results(turning, "M", progress=False).to_xarray()
    assert "units" not in {**plain.axis_x.attrs, **plain.window2_parameter_focus.attrs}  # as x and focus have
    assert results(scene, "M").to_xarray().M.shape == (1,) and results([], "M").to_xarray().M.shape == (0,)


def test_numbers_of_windows_behind_the_first_one():
    scene = Chess(sheet="ideal", z1=3, window="alpha=40,z=2")
    found = results(scene, "x", "y", window2_alpha=(10, 20), z1=(3, 4), progress=False)
    scenes = [scene.replace(window=f"alpha={alpha},z=2", z1=z1) for alpha in (10, 20) for z1 in (3, 4)]
    expected = results(scenes, "x", "y", progress=False)
    assert found["window2_alpha"].tolist() == [10, 10, 20, 20] and found["z1"].tolist() == [3, 4, 3, 4]
    assert (found["x"] == expected["x"]).all() and (found["y"] == expected["y"]).all()
    assert dict(found.to_xarray().sizes) == {"window2_alpha": 2, "z1": 2}
    for name, words in (("window3_z", "window3_z: there is no window 3"), ("window2_colour", "'colour': unknown")):
        with pytest.raises(InputError, match=words):
            results(scene, "x", **{name: [4]})


def test_rooms():
    """A window on the axis, and the same window and eye moved aside; a window that tilts."""
    chess = Chess(sheet="ideal", z1=3, x=0.4, eye=(0.2, 0.1), pupil=0.1)
    (place, z1), eye = chess.objects[0], Eye(x=1, look_x=1, aside=0.2, above=0.1)
    window = Window(name="left", x=1, width=3)
    room = Room([window, Sphere(x=1 + place.real, y=place.imag, z=z1)], eye=eye, pupil=0.1)
    names = ("x", "y", "visible", "best_focus", "pupil_blur")
    expected, found = results(chess, *names, alpha=(0, 40, 90)), results(room, *names, **{"left.alpha": (0, 40, 90)})
    assert list(found) == ["left_alpha", *names] and found["left_alpha"].tolist() == [0, 40, 90]
    for name in names:
        np.testing.assert_allclose(found[name], expected[name], 1e-6, 1e-8, err_msg=name)
    turned = [room.with_numbers({"left.yaw": yaw, "eye.y": yaw / 50}) for yaw in (0, 10, 170)]
    table = results(turned, "x", "visible", progress=False)
    assert list(table) == ["left_yaw", "eye_y", "x", "visible"] and len({*table["x"]}) == 3
    data = table.to_xarray()
    assert data.left_yaw.attrs["units"] == "degrees" and data.eye_y.attrs["units"] == "tiles"
    nothing = results(room.replace(object=()), *names, progress=False)
    assert nothing["visible"] == [0] and np.isnan([nothing[name] for name in names if name != "visible"]).all()


def test_every_length_and_angle_of_a_room_has_its_unit():
    plain = {"prisms", "index", "gap", "aspect", "ratio", "lenses", "f_number", "periods"}
    for kind in (Eye, Window, *OBJECTS.values()):
        assert {name for name in swept_numbers(kind) if not unit(f"left_{name}")} <= plain, kind


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
