"""The scripts of the pages, without a browser: their equations, geometry, text and state are those of povgen."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import (
    BEYOND,
    Node,
    picture,
    scene_of,
    seen_through_other_sheets,
    sentence,
    some,
)

from povgen import Chess, InputError, Spheres, results
from povgen.liveview import scripts
from povgen.liveview.languages import tables
from povgen.liveview.values import values as live_values
from povgen.objects.box import Box
from povgen.objects.card import Card
from povgen.objects.floor import Floor
from povgen.objects.pedestal import Pedestal
from povgen.objects.piece import Piece
from povgen.objects.ruler import Ruler
from povgen.objects.sphere import Sphere
from povgen.objects.text import Text
from povgen.objects.window import Window
from povgen.optics import equations, ghosts, series, trace
from povgen.optics.prism import Prism
from povgen.optics.profile import confocal, dove
from povgen.optics.rays import Bundle
from povgen.optics.trace import End
from povgen.page import items
from povgen.page.address import ALL_KINDS, KEPT, KINDS
from povgen.scene import shader, survey, warnings
from povgen.scene.eye_and_windows import VIEW
from povgen.scene.laws import to_live
from povgen.scene.presets import pieces
from povgen.scene.quantities import QUANTITIES
from povgen.scene.room import Eye, Room
from povgen.settings import Rendering
from povgen.sheets import SHEETS


@pytest.fixture
def page(node):
    """The page's modules, with the state that the page opens with."""
    node.evaluate("fromHash('')")
    return node


# ---- Rays ----


@pytest.mark.parametrize("towards", [1, -1])
@pytest.mark.parametrize(
    ("sheet", "prisms"), [*((sheet, n) for sheet in ("single", "detailed") for n in (1, 7, 100)), ("lenticular", 100)]
)
def test_rays_through_prisms_are_those_of_python(page, sheet, prisms, towards):
    """All ends, faces, places and directions of random rays, also of rays far from the axis."""
    scene = Chess(sheet=sheet, prisms=prisms, alpha=66, z1=100, z2=100)
    random = np.random.default_rng(1)
    count, frame = 400, 26.0 / prisms + 0.3
    start = np.column_stack((random.uniform(-2, 2, (count, 2)), np.full(count, -40.0 * towards)))
    through = np.column_stack((random.uniform(-1.7, 1.7, (count, 2)), np.zeros(count)))
    sheets = scene.sheets[0].glass
    if sheet != "lenticular":
        sheets = [replace(layer, shape=dove(layer.shape)) for layer in sheets]
    wanted = trace.trace(start, through - start, tuple(sheets), scene.aperture, frame=frame)
    values = {"sheet": sheet, "prisms": prisms, "alpha": 66}
    if sheet == "lenticular":
        values |= {name: scene.sheets[0].values[name] for name in ("ratio", "f_number", "lenses")}
    page.evaluate("(values) => change(values)", values)
    found = page.evaluate(
        """({ rays, frame }) => rays.map(
            ([from, towards]) => passage(moment().windows[0], from, towards, { frame }))""",
        {"rays": np.stack((start, through - start), 1).tolist(), "frame": frame},
    )
    ends = np.array([trace.End[ray["end"].upper()] for ray in found])
    assert (ends == wanted.end).mean() > 0.995  # a ray may pass an edge on either side of it
    same = ends == wanted.end
    assert {trace.End.THROUGH, trace.End.FRAME} <= {*ends} and wanted.designed.sum() > 40
    several = zip(found, wanted.faces, wanted.count, strict=True)
    same &= [[step["face"] for step in ray["steps"]] == list(faces[:count]) for ray, faces, count in several]
    assert same.mean() > 0.995
    assert [ray["designed"] for ray, ok in zip(found, same, strict=True) if ok] == wanted.designed[same].tolist()
    for name, values in (("place", wanted.position), ("direction", wanted.direction)):
        assert np.array([ray[name] for ray in found])[same] == pytest.approx(values[same], abs=1e-6)


@pytest.mark.parametrize(
    "values",
    [
        {"z2": 1.2},
        {"windows": 2, "sheet2": "none", "alpha": 30, "d": 2.5, "z2": 2.5},
        {"windows": 2, "sheet": "lens", "focal_length": 0.5, "sheet2": "ideal", "d": 2},
        {"windows": 2, "sheet": "detailed", "sheet2": "same", "prisms": 30, "d": 3, "z2": 3},
    ],
)
def test_rays_end_where_those_of_python_end(page, values):
    """Also on the frames of two windows, and beside them."""
    page.evaluate("(values) => change(values)", values)
    scene, faces = scene_of(page), page.evaluate("moment().scene.faces")
    towards = np.column_stack((np.random.default_rng(2).uniform(-1.64, 1.64, (800, 2)), np.full(800, scene.z2)))
    found = page.evaluate(
        "(rays) => { const now = moment(); return rays.map((ray) => traced(now, [0, 0, -now.z2], ray)); }",
        towards.tolist(),
    )
    wanted = scene.trace(Bundle(np.broadcast_to([0, 0, -scene.z2], towards.shape), towards), faces)
    kinds = {End.THROUGH: "designed", End.BACK: "back", End.BESIDE: "beside"}
    said = [kinds.get(end, "lost") for end in wanted.end]
    said = [
        "stray" if kind == "designed" and not way else kind for kind, way in zip(said, wanted.designed, strict=True)
    ]
    same = np.array([ray["kind"] for ray in found]) == said
    assert same.mean() > 0.98  # here light that the second window sends back ends there
    framed = same & (wanted.end == End.FRAME)
    last = np.array([ray["points"][-1] for ray in found])
    assert framed.sum() > 80 and all(ray["frame"] for ray, ends in zip(found, framed, strict=True) if ends)
    assert np.linalg.norm(last - wanted.position, axis=-1)[framed].max() < 1e-6
    ways = [np.array(ray["points"]) for ray in found if ray["frame"] == "wall"]
    assert all(abs(way[:, :2]).max() < scene.aperture / 2 + 1e-9 for way in ways)  # none is behind the wall


def test_the_whole_frame_is_shown_as_in_povgens_pictures(page):
    """Also where the frame is deep, and where the eye is near it or beside it. The page shows twice VIEW at most."""
    for values in ({}, {"prisms": 12}, {"prisms": 8, "E": [3, 0.5]}, {"prisms": 8, "E": [0, 3]}, {"z2": 0.8}):
        page.evaluate("(values) => { fromHash(''); change(values); }", {"sheet": "detailed"} | values)
        shown = scene_of(page)
        assert shown.view == pytest.approx(shown.default_view()) and (shown.view > VIEW) == bool(values), values
    page.evaluate("change", {"z2": 0.2, "prisms": 100})
    assert scene_of(page).view == 2 * VIEW


def test_the_ray_to_the_eye_starts_at_the_object(page):
    """Its path, extended, passes the object at a distance of at most a fifth of the pitch."""
    miss = "() => { const now = moment(); return minus(at(bundle(now)[0], now.z1), [...now.L, now.z1]); }"
    for prisms in (12, 20, 100):
        page.evaluate("change", {"sheet": "detailed", "prisms": prisms})
        assert np.linalg.norm(page.evaluate(miss)) < 0.2 * 3 / prisms


def test_the_light_in_the_window_is_that_of_results(page):
    """To two points, with rounding to one. Without prisms, there are no shares to say."""
    for values in (
        {},
        {"prisms": 5, "z1": 6},
        {"z2": 1.5},
        {"prisms": 238, "alpha": 39, "z2": 2.48, "E": [-0.54, -0.1]},  # 1024 or 5000 rays would not do
        {"sheet": "single", "prisms": 20},
        {"windows": 2, "alpha2": 120, "d": 10},  # rays that miss the second window are lost
    ):
        page.evaluate("(values) => { fromHash(''); change(values); }", {"sheet": "detailed"} | values)
        found, scene = page.evaluate("lightInWindow(moment())"), scene_of(page)
        wanted = [QUANTITIES[name].of(scene) for name in ("designed", "stray")]
        assert [found["designed"], found["stray"]] == pytest.approx(wanted, abs=0.015), values
    page.evaluate("fromHash('')")
    assert page.evaluate("lightInWindow(moment())") is None
    page.evaluate("change", {"windows": 2, "sheet": "lens", "sheet2": "detailed"})
    light = "(focal_length) => { change({ focal_length }); return lightInWindow(moment()); }"
    assert page.evaluate(light, 4)["designed"] > page.evaluate(light, -0.5)["designed"] + 0.1  # found anew


@pytest.mark.parametrize("degrees", [30, 70, 80, 87])
@pytest.mark.parametrize("ratio", [0.2, 0.7])
def test_light_that_is_nearly_parallel_to_the_sheet_passes(page, ratio, degrees):
    slope = np.tan(np.radians(degrees))
    ray = page.evaluate(
        """([ratio, slope]) => {
          change({ sheet: "refraction", ratio, alpha: 0, windows: 1 });
          return traced(moment(), [slope / 100, 0, 0.01], [-slope, 0, -1]);
        }""",
        [ratio, slope],
    )
    sine = ratio * np.sin(np.radians(degrees))
    assert ray["kind"] == "designed"
    assert ray["direction"][0] / ray["direction"][2] == pytest.approx(sine / np.sqrt(1 - sine**2), rel=1e-5)


def test_rays_meet_where_the_equations_say(page):
    """At the pole in the eye; with alpha = 180 degrees 2 tiles before the window; with 66 degrees nowhere."""
    meets = "(values) => { fromHash(''); change({ light: 'pencil', ...values }); return meeting(bundle(moment())); }"
    assert page.evaluate(meets, {"alpha": 180, "z1": 6, "L": [0, 0]}) == pytest.approx([0, 0, -6], abs=1e-9)
    assert page.evaluate(meets, {"alpha": 180, "z1": 2, "L": [0.3, 0]}) == pytest.approx([0.3, 0, -2], abs=1e-9)
    assert page.evaluate(meets, {"sheet": "none", "z1": 2, "L": [0.3, 0]}) == pytest.approx([0.3, 0, 2], abs=1e-9)
    assert page.evaluate(meets, {"alpha": 66}) is None
    prisms = page.evaluate(meets, {"sheet": "detailed", "alpha": 180, "z1": 5, "prisms": 400, "L": [0, 0]})
    assert prisms == pytest.approx([0, 0, -5], abs=0.1)


# ---- The equations ----


def test_equations_are_those_of_rotation(page):
    """Also close to the pole and at it."""
    ratios, degrees = [1e-3, 0.7, np.nextafter(1, 0), 1, 1 + 1e-9, 40], [-360, -180, -100, 0, 66, 180 - 1e-5, 180]
    r, alpha = (grid.ravel() for grid in np.meshgrid(ratios, np.radians(degrees)))
    assert np.isinf(equations.P(r, alpha)).sum() == 2
    for name in ("P", "M", "nu"):
        script = f"(grid) => grid.map((numbers) => equations.{name}(...numbers))"
        found = np.array(page.evaluate(script, np.stack((r, alpha), 1).tolist()))
        found = found.view(complex)[:, 0] if name == "P" else found
        np.testing.assert_allclose(found, getattr(equations, name)(r, alpha), rtol=1e-12, atol=1e-12)


def test_positions_behind_other_sheets_are_those_of_python(page):
    """Also where the ray along the normal does not pass, and where two paths have just become one.

    Also where the path that is the nearest to the middle of the first window misses the second one.
    """
    marks = Spheres(sheet="axis", axis=(0, -0.7, -0.6), alpha=180, z2=1, eye=(0, -1.5), line=(0, 2.6), z1=3)
    cases, wanted = [], []
    for scene, points, _ in seen_through_other_sheets(np.random.default_rng(9), 25):
        cases += [(scene, L, scene.z1, 0.0) for L in points]
        wanted += [*scene.apparent_position(points, scene.z1)]
    twists = [{"sheet": "twist", "twist": 54, "alpha": 86}, {"sheet": "twist", "twist": 54, "alpha": -87, "z": 3.8}]
    series = Spheres(**twists[0], window=twists[1:], z1=2, z2=3.4, eye=(0.8, 0.3))
    cases.append((series, 1.0169 + 2.1397j, 2.0, 0.0))
    wanted.append(complex(series.apparent_position(1.0169 + 2.1397j, 2)))
    assert series.visible(1.0169 + 2.1397j, 2) and abs(wanted[-1]) > 1.5
    cases.append((marks, marks.L, marks.z1, marks.radii[0]))
    given = page.evaluate(
        "(cases) => cases.map(([scene, near, ...values]) => crossing(...values, presets.windows(scene), near))",
        [[scene.model_dump(), near, [L.real, L.imag], scene.eye, z1, scene.z2] for scene, L, z1, near in cases],
    )
    assert len(given) > 300 and np.isfinite(wanted).all()
    place = complex(*given.pop())
    assert abs(place - complex(marks.apparent_position(marks.L, 3, near=marks.radii[0]))) < 0.03
    assert np.array(given) @ [1, 1j] == pytest.approx(np.array(wanted), rel=1e-7, abs=1e-7)


IDEAL_KINDS = ["none", "ideal", *KINDS]


def states(rng, number):
    """Yield the page's values of one or two windows, with the parameters of examples of their kinds."""
    yield from BEYOND
    for k in range(number):
        second = ["same", "single", "detailed", *IDEAL_KINDS]
        first = [*IDEAL_KINDS, "detailed"][k % (len(IDEAL_KINDS) + 1)]
        values = {"windows": 2, "sheet": first, "sheet2": rng.choice(second[:3] if first == "detailed" else second)}
        if k % 7 == 0:
            values |= {
                "windows": 1,
                "sheet": rng.choice(["ideal", "detailed", "single"]),
                "prisms": int(rng.integers(9, 200)),
            }
        for kind in (first, values["sheet2"]):
            values |= KINDS[kind].examples[0] if kind in KINDS else {}
        alpha, alpha2 = rng.uniform(-40, 40, 2)
        z1, z2, d = np.exp(rng.uniform(np.log([0.8, 1, 0.4]), np.log([8, 9, 4])))
        E, L = rng.uniform(-0.5, 0.5, (2, 2))
        given = {"alpha": alpha, "alpha2": alpha2, "z1": z1, "z2": z2, "d": d, "E": [*E], "L": [*L], "scene": "chess"}
        yield {"prisms": 60} | given | values | {"sheet": str(values["sheet"]), "sheet2": str(values["sheet2"])}


@pytest.mark.parametrize("number", some([7, 28], 1))
def test_positions_behind_any_windows_are_those_of_python(page, number):
    """So are nu, M and the errors behind prisms. Its sentences have no gap, and its address keeps all."""
    rng, found, glass = np.random.default_rng(11), [], 0
    for values in states(rng, number):
        page.evaluate("fromHash('')")
        page.evaluate("change", values)
        scene = scene_of(page)
        number = page.evaluate("moment().objects.indexOf(moment().z1)")
        (L, z1), radius = scene.objects[number], scene.radii[number]
        wanted = complex(scene.apparent_position(L, z1, near=radius))
        place, link = page.evaluate("[moment().place, toHash()]")
        page.evaluate("(link) => { fromHash(''); fromHash(link); }", link)
        assert page.evaluate("toHash()") == link
        text = page.evaluate("[describe(moment()), ...caption(moment())].join()")
        assert not re.search(r"NaN|Infinity|null|undefined|\[object|\{", text), text
        place = complex(*place)
        found.append(np.isfinite(wanted))
        if not found[-1]:
            assert not np.isfinite(place), values
            continue
        exact = np.isfinite(scene.apparent_position(L, z1))
        assert place == pytest.approx(wanted, rel=1e-6 if exact else 0.1, abs=1e-6 if exact else 0.1), values
        error = page.evaluate("moment().glass ? possibleError(moment()) : 0")
        assert bool(error) == scene.has_prisms
        if error and exact:
            glass += 1
            assert error == pytest.approx(warnings.possible_error(scene, L, z1, radius), rel=1e-3), values
        if scene.rotates:
            nu, M = scene.nu_and_M(z1)
            given = page.evaluate("(({ nu, M }) => [nu, M])(moment())")
            assert [np.exp(1j * given[0]), given[1]] == [pytest.approx(np.exp(1j * np.radians(nu))), pytest.approx(M)]
    assert np.mean(found) > 0.8 and glass > 1


def test_focus_and_blur_of_a_pupil_are_those_of_python(page):
    """Where the eye is focused best, and what blur remains there or elsewhere. A link keeps both."""
    rng, scenes, found = np.random.default_rng(5), [], []
    pole = {"alpha": 180, "z1": 6, "z2": 6}
    for k, values in enumerate([pole, *states(rng, 21), pole]):
        focus = "best" if k % 3 else round(rng.uniform(1, 20), 3)
        page.evaluate("fromHash('')")
        page.evaluate("change", values | {"scene": "chess", "pupil": 0.3, "focus": focus})
        link = page.evaluate("toHash()")
        page.evaluate("(link) => { fromHash(''); fromHash(link); }", link)
        scenes.append(scene_of(page))
        assert [scenes[-1].pupil, scenes[-1].focus] == [0.3, focus], link
        found.append(page.evaluate("((now) => [1 / now.best, pupilBlur(now, 1 / now.focus)])(moment())"))
    wanted = results(scenes, "best_focus", "pupil_blur", progress=False)
    assert found[-1] == [pytest.approx(np.nan, nan_ok=True)] * 2 and page.evaluate("moment().focus") == 6  # the window
    assert np.isnan(wanted["best_focus"]).sum() == 2 and np.isinf(wanted["best_focus"]).any()
    best, blur = np.transpose(found)
    assert best == pytest.approx(wanted["best_focus"], rel=1e-5, nan_ok=True)
    assert np.degrees(blur) * 60 == pytest.approx(wanted["pupil_blur"], rel=1e-5, abs=1e-4, nan_ok=True)


def test_what_a_pupil_blurs_is_said(page):
    """Through sheets that turn light by 0 or 180 degrees there is a sharp focus, otherwise never."""
    assert "pupil" not in sentence(page, alpha=90) + page.evaluate("toHash()")
    for alpha, focus, said in (
        (0, "best", "The eye is focused at 8 tiles: its pupil does not blur the knight."),
        (180, "best", "The eye is focused at 4 tiles: its pupil does not blur the knight."),
        (180, 6, "its pupil blurs each point of the knight by 29.4′ (arcminutes, RMS), but not at 4 tiles."),
        (90, "best", "by 18.0′ (arcminutes, RMS), and no focus makes it sharp."),
        (-90, 6, "by 19.0′ (arcminutes, RMS), and no focus makes it sharp."),
    ):
        assert said in sentence(page, alpha=alpha, pupil=0.3, focus=focus)
    eye = "((each) => [each.pupil, each.inverse_focus])(otherScene(moment()))"  # to the right of the curtain
    assert page.evaluate(eye) == [0.3, 1 / 6]
    assert {"p = 0.3", "s = 6"} <= {*page.evaluate("caption(moment())")}


def test_a_caption_has_the_size_that_the_level_explains(page):
    for level, wanted in (("simple", ["ν = 15.0°", "size = 1.13"]), ("expert", ["r = 3", "ν = 15.0°", "M = 0.851"])):
        found = page.evaluate("(level) => { change({ level }); return caption(moment()); }", level)
        assert found[-len(wanted) :] == wanted


def test_no_ideal_sheet_stands_behind_prisms(page):
    """The second window then has prisms, too, and the page says so."""
    text = sentence(page, windows=2, sheet="lens", sheet2="ideal")
    assert "Behind prisms" not in text
    assert "Behind prisms there can be no ideal sheet" in sentence(page, sheet="detailed")
    assert [sheet.name for sheet in scene_of(page).sheets] == ["detailed", "detailed"]
    page.evaluate("change", {"sheet2": "single"})
    assert [sheet.name for sheet in scene_of(page).sheets] == ["detailed", "single"]
    page.evaluate("fromHash", "#windows=2&sheet=detailed&sheet2=axis")
    assert [sheet.name for sheet in scene_of(page).sheets] == ["detailed", "detailed"]


@pytest.mark.parametrize(("given", "kept"), [("270", -90), ("-360", 0), ("180", 180), ("-180", -180), ("190", -170)])
def test_an_angle_of_a_link_is_the_same_one_within_half_a_turn(node, given, kept):
    node.evaluate("fromHash", f"#sheet=ideal&alpha={given}")
    assert node.evaluate("[state.alpha, session.refusals]") == [kept, []]


def unlike(given, wanted):
    """Return the names of the uniforms that differ: a list of numbers is compared flat, as the shaders take it."""
    flat = {name: (np.ravel(given[name]).astype(float), np.ravel(wanted[name]).astype(float)) for name in given}
    return [name for name, (a, b) in flat.items() if a.shape != b.shape or not np.allclose(a, b, 1e-12, 1e-12)]


def rooms(path):
    """Return rooms with every kind of object and sheet, a picture, turned windows, a tilted eye; and an empty one."""
    sheets = [{"sheet": name, **kind.examples[0], "width": 0.9} for name, kind in SHEETS.items() if name != "law"]
    turned = {"yaw": 20, "pitch": -30, "roll": 200}
    return [
        Room(),
        Room([Floor(y=-2, file=f"{path},width=3"), Sphere(x=3), Window(width=2, frame=False)], eye=Eye(y=5, look_y=-3)),
        Room(
            [Window(x=3 * k, outline="round", **own, **turned) for k, own in enumerate(sheets)], eye=Eye(z=-90, roll=8)
        ),
        Room(
            [
                *(kind(x=4 * k - 9, z=9, **turned) for k, kind in enumerate((Piece, Box, Pedestal, Text, Ruler))),
                *(Card(x=4 * k - 9, z=19, file=path) for k in range(2)),
                Window(sheet="detailed", prisms=20, width=2, height=1, tops="black", glass="BK7", y=3),
                Window(sheet="none", y=-3),
            ],
            eye=Eye(x=0.1, y=30, z=0.2, look_z=0.2, look_x=0.1, view=7, above=0.4),
            background="white",
            wavelength=500,
            pupil=0.1,
            focus=20,
        ),
    ]


def test_the_shaders_are_given_the_same_as_by_povgen(tmp_path, monkeypatch):
    """The uniforms and constants of povgen/liveview/values.js are those of povgen/scene/shader.py."""
    monkeypatch.setattr(survey, "survey", lambda _: survey.Survey(20, 0.5))  # no rays: Python alone counts faces
    places = [[0.1, 0.2, 0.3, 0.01]] * 2
    own = {"law": "x - k*X*z, y + sqrt(k)*y, z", "parameter": {"k": 0.3}}
    scenes = [
        Chess(),
        Chess(piece=("queen", "king", "queen"), x=(-1, 0, 1), z1=(2, 3, 4), color=("red", "#123456", "white")),
        Chess(
            sheet="single",
            tops="black",
            prisms=7,
            gap=0.2,
            aspect=1.1,
            eye=(0.5, 0.2),
            pedestal=0,
            pupil=0.2,
            look=(0.3, -0.1),
        ),
        Chess(sky=picture(tmp_path), floor=f"{picture(tmp_path)},width=3"),
        Chess(sheet="axis", axis=(0.3, 1, 0.2), alpha=15, window="alpha=30,z=4,sheet=detailed"),
        Chess(sheet="law", z2=9, **own),
        Chess(sheet="lenticular", ratio=0.8, f_number=4, window="z=2,sheet=profile,profile=wedges,arrangement=single"),
        Chess(sheet="single", window=("z=2,sheet=detailed,prisms=30,index=1.7", "z=9,tops=black,gap=0.1"), z2=12),
        Spheres(z1=tuple(np.linspace(1, 40, 14)), background="black", line=(0.2, 0.1)),
        Spheres(sheet="ideal", window=("alpha=20,z=3", "alpha=5,z=7,sheet=detailed"), prisms=2500, z2=12),
        Chess(
            glass="BK7",
            wavelength=450,
            aspect=0.9,
            z2=9,
            window=("z=3,sheet=lenticular,glass=N-SF11,design_wavelength=500", "z=6,sheet=lenticular,index=1.6"),
        ),
        *(Chess(**{"sheet": name, **kind.examples[0]}) for name, kind in SHEETS.items()),
        *rooms(picture(tmp_path)),
    ]
    started = Node(None, scripts.script("liveview/values.js", laws=to_live(scenes)))
    for scene in scenes:
        names = [*pieces(scene)]
        shapes = {"names": names, "grid": [72, 160, 72], "places": places[: len(names)]}
        script = "([scene, shapes]) => [uniforms(scene, shapes), defines(scene, shapes)]"
        found, constants = started.evaluate(script, [live_values(scene), shapes])
        wanted = shader.uniforms(scene, names, shapes["places"])
        # the page knows more laws than this scene's own
        several = [(found.pop("kind"), to_live(scenes)), (wanted.pop("kind"), to_live([scene]))]
        ours, theirs = ([laws[k].name for k in kind if k >= 0] for kind, laws in several)
        assert ours == theirs and found.keys() == wanted.keys()
        assert unlike(found, wanted) == [], scene
        text = "".join(f"#define {k} {v}\n" for k, v in shader.defines(scene, names, shapes["grid"]).items())
        assert text == constants
    started.close()


ADDED = {
    "7-mine.toml": """
start = "https://povgen.test/demo.html#sheet=ideal&alpha=90&z1=3&level=simple&show=stray"
end = "z1=6"
answer = "change.nu"
tolerance = 1
unit = "degrees"
[fr]
ask = "Combien ?"
why = "De {start.nu} à {end.nu}."
""",
    "walk.toml": """
[[tour]]
shows = "sheet=single"
seconds = 5
[en]
title = "A walk"
steps = ["Look."]
""",
    "gallery.toml": """
[[lesson]]
shows = ["sheet=none"]
asks = ["mine", "sky"]
[en]
title = "A gallery"
steps = ["Nothing"]
""",
}


def test_a_file_adds_a_question_a_tour_and_a_lesson(tmp_path):
    """A language that a file does not have is replaced."""
    for name, text in ADDED.items():
        (tmp_path / name).write_text(text, "utf-8")
    started = Node.of_page(added=[tmp_path / name for name in ADDED])
    started.evaluate("choose('es')")
    name, asked, answer, why = started.evaluate(
        "[QUESTIONS.at(-1)].map((mine) => [mine.name, ask(mine), mine.answer(), why(mine)])[0]"
    )
    nu = [np.degrees(equations.nu(6 / z1, np.pi / 2)) for z1 in (3, 6)]
    assert (name, asked, answer) == ("mine", "Combien ?", pytest.approx(nu[1] - nu[0]))
    assert why == f"De {nu[0]:.1f}° à {nu[1]:.1f}°.".replace(".", ",").replace("°,", "°.")
    assert started.evaluate("fromHash('#question=mine'), [state.z1, state.alpha]") == [3, 90]
    words = "[data.tours.at(-1).name, entry('tours.walk.title'), data.lessons.at(-1).steps[0].asks]"
    assert started.evaluate(words) == ["walk", "A walk", ["mine", "sky"]]
    started.close()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ADDED["7-mine.toml"].replace("alpha=", "alpa="), "'alpa': unknown setting; allowed: scene, sheet, "),
        (ADDED["7-mine.toml"].replace("z1=6", "z1=6000"), "'z1=6000': allowed: from 0.01 to 5000"),
        (ADDED["7-mine.toml"].replace("answer", "anwser"), "'anwser': unknown; did you mean answer?"),
        (ADDED["7-mine.toml"].replace('answer = "change.nu"', ""), "no answer, or more than one; allowed: "),
        (ADDED["7-mine.toml"].replace("tolerance = 1", ""), "a number is asked for; allowed: with tolerance and unit"),
        (ADDED["7-mine.toml"].replace("{end.nu}", "{end.mu}"), "[fr]: 'end.mu' is unknown; allowed: "),
        (ADDED["7-mine.toml"].replace("[fr]", "[it]"), "[it]: no language of the page; allowed: ar, de, "),
        (ADDED["7-mine.toml"] + 'choices = ["a", "b"]', "2 choices; allowed: 3, for more, as much, and less"),
        (ADDED["7-mine.toml"].replace('answer = "change.nu"', "match = true"), "allowed: with alpha and z1"),
        (ADDED["walk.toml"].replace('["', '["Go.", "'), "[en]: steps: 2 texts; allowed: 1, one for each step"),
        (ADDED["gallery.toml"] + 'names = ["a", "b"]', "names: 2 texts; allowed: 1, one for each setting"),
        (ADDED["gallery.toml"], "asks: 'mine' is unknown; allowed: sky, "),
    ],
)
def test_a_fault_of_a_file_is_one_line(tmp_path, text, message):
    (tmp_path / "file.toml").write_text(text, "utf-8")
    with pytest.raises(InputError, match=re.escape(message)) as raised:
        items.load([tmp_path / "file.toml"], ["knight"])
    assert "file.toml: " in str(raised.value) and "\n" not in str(raised.value)


def test_the_page_computes_what_questions_ask_for(page):
    """A question's file can name no other quantity."""
    known = page.evaluate("[Object.keys(povgen.questions.QUANTITIES), Object.keys(povgen.questions.MOMENTS)]")
    assert known == [items.QUANTITIES, items.MOMENTS]


def test_questions_are_answered_by_the_equations(page):
    right = page.evaluate(
        "Object.fromEntries(QUESTIONS.filter(({ goal }) => !goal).map(({ name, answer }) => [name, answer()]))"
    )

    def nu(z1, alpha):
        return np.degrees(equations.nu(6 / z1, np.radians(alpha)))

    angles = np.linspace(0, 180, 180_001)
    image = [complex(equations.apparent_position(-1j, x, 2, 6, np.pi)).real for x in (0, 1)]
    assert equations.mirror(np.array([0.1, 0.2, -1]), 0)[1] < 0 < nu(2, 66) and nu(1e9, 66) == pytest.approx(66)
    assert nu(12, 90) > nu(2, 90) and image[1] < image[0] and np.isinf(equations.P(1, np.pi))
    numeric = [6, equations.M(3, np.pi) / equations.M(3, 0), angles[np.argmax(nu(2, angles))]]
    assert nu(6, 90) == pytest.approx(45)
    _, W = series.imaged_plane(np.radians(120), [(2, np.radians(120))])
    asked = ["sky", "near", "far", "away", "half", "upright", "parallax", "most", "pole", "series"]
    wanted = [2, 0, 2, 0, numeric[0], numeric[1], 2, numeric[2], 2, -W]
    assert [right.pop(name) for name in asked] == pytest.approx(wanted, abs=0.06)
    # alpha mirrored, z2 halved, 1/z1 + 1/b = 1/f, and two mirrors, which turn light by twice their angle
    assert equations.M(6 / 2, -1) == equations.M(6 / 2, 1) and nu(2, -66) == pytest.approx(-nu(2, 66))
    assert equations.M(3 / 2, np.pi) > equations.M(6 / 2, np.pi)
    reach = [Prism(2.4 / prisms).reach for prisms in (20, 100)]
    field = np.degrees(np.arctan([ghosts.field(confocal(f_number=f_number)) for f_number in (3, 6)]))
    assert field[1] < 0.6 * field[0]
    assert right.pop("match") == {"alpha": 120, "z1": 4}
    assert right == pytest.approx(
        {
            "prisms": reach[0] / reach[1],
            "single": 1,
            "circles": np.degrees(equations.nu(1, np.radians(60))),
            "negative": 0,
            "nearer": 0,
            "law": 1 / (1 / 4 - 1 / 8),
            "tolerance": 2,
            "lenses": field[0],
            "slower": 2,
        },
        abs=0.2,
    )


def test_only_experts_read_formulas_in_answers(page):
    said = """(level) => { state.level = level; return QUESTIONS.filter(({ expert }) => !expert).map(why); }"""
    simple, expert = page.evaluate(said, "simple"), page.evaluate(said, "expert")
    assert len(simple) == 15 and not [text for text in simple if re.search(r"[PMrZν] =|[zs]₂/|arctan", text)]
    assert "ν = arctan(z₁/z₂)" in expert[4]


# ---- The state ----


def test_the_pages_ranges_are_those_of_the_scenes(page):
    """The page allows no value that povgen refuses."""
    ranges = page.evaluate("RANGES")
    assert ranges["alpha"] == ranges["alpha2"] == [-180, 180]  # any other angle is one of these
    for values in ({"z1": 1e-9, "z2": 1e-9}, {"z1": 1e9, "z2": 1e9}, {"L": [99, 99], "E": [-99, -99]}, {"prisms": 1e9}):
        for scene in ("chess", "spheres"):
            page.evaluate("fromHash('')")
            page.evaluate("change", {"scene": scene, "sheet": "detailed", **values})
            scene_of(page)


def test_a_link_reopens_what_one_sees(page):
    page.evaluate(
        """() => {
          change({ scene: "spheres", sheet: "detailed", alpha: -33.25, z2: 7.5, prisms: 250 });
          change({ L: [0.3, 0.1], E: [-0.2, 0.4] });
          Object.assign(state, { circles: true, caption: true, diagram: "paper" });
        }"""
    )
    before, link = page.evaluate("[state, toHash()]")
    assert link.startswith("#scene=spheres&sheet=detailed&alpha=-33.25&")
    page.evaluate("fromHash('')")
    page.evaluate("fromHash", link)
    assert page.evaluate("state") == before


@pytest.mark.parametrize(
    "link",
    ["#alpha=1e999&z1=NaN&L=1&E=a,b", "#scene=house&piece=__proto__", "#%E0%A4%A", "#question=teapot"],
)
def test_nonsense_in_an_address_is_ignored(page, link):
    page.evaluate("(link) => fromHash(link)", link)
    assert page.evaluate("({ ...state })") == page.evaluate("({ ...OPENING })")


def test_a_linked_question_is_the_one_that_the_tab_opens(page):
    """It has the prisms and the curtain of its own, not those of the address."""
    page.evaluate("fromHash('#prisms=1&compare=single&question=half')")
    assert page.evaluate("[state.prisms, state.compare]") == [100, "off"]
    assert page.evaluate("[state.question, session.lastQuestion]") == [5, 5]
    page.evaluate("fromHash('#question=upright')")
    assert page.evaluate("QUESTIONS[state.question].name") == "upright"


def test_object_and_eye_are_outside_the_frames_on_both_sides_of_the_curtain(page):
    """Few prisms are deep."""
    depths, values = "[moment().z1, moment().z2]", {"prisms": 1, "z1": 0.6, "z2": 1}
    sentence(page, sheet="detailed", **values)
    deep = page.evaluate(depths)
    sentence(page, sheet="ideal")
    assert page.evaluate(depths) == [0.6, 1]
    assert "the piece would touch" in sentence(page, compare="detailed")
    assert page.evaluate(depths) == deep


# ---- The kinds of sheets ----


def test_lenses_are_predicted(page):
    """The prediction leaves out spherical aberration, and so differs from Python's by less than the picture's blur."""
    for f_number, ratio, alpha in itertools.product((2, 3, 6), (1, 2), (66, 150, -40)):
        values = {"sheet": "lenticular", "alpha": alpha, "f_number": f_number, "ratio": ratio, "z1": 3, "z2": 8}
        page.evaluate("change", values | {"E": [0.3, 0.2]})
        scene = Chess(**values, eye=(0.3, 0.2))
        seen = complex(scene.apparent_position(scene.L, 3))
        assert abs(complex(*page.evaluate("moment().place")) - seen) < 0.08
    page.evaluate("change", {"f_number": 1, "ratio": 0.5})
    assert page.evaluate("state.f_number") == 3  # a lens is at most a semicircle
    assert page.evaluate("fieldOf", {"f_number": 3, "ratio": 1, "index": 1.5}) == pytest.approx(
        ghosts.field(confocal()), abs=0.005
    )


@pytest.mark.parametrize("name", ALL_KINDS)
def test_a_choice_opens_with_the_values_of_its_kind(page, name):
    page.evaluate("chooseBeyond", name)
    kind = ALL_KINDS[name]
    parameters = [each for each in kind.parameters if each.name not in KEPT]
    wanted = {each.name: each.default for each in parameters} | {**kind.opening}
    found = page.evaluate("(names) => names.map((name) => state[name])", [*wanted])
    assert found == [list(value) if isinstance(value, tuple) else value for value in wanted.values()]
    text = page.evaluate("[describe(moment()), ...caption(moment())].join()")
    texts = page.evaluate("(name) => entry(`kinds.${name}`)", name)
    assert texts["choice"] in text and texts["model"] in text and "{" not in text
    for each in parameters:
        assert each.symbol in text


def test_the_image_of_a_sheet_is_where_all_eyes_see_it(page):
    """The apparent positions for two eyes are on the lines from these eyes to the image."""
    for values, W in (
        ({"sheet": "lens", "focal_length": 4, "z1": 2}, 4),
        ({"sheet": "lens", "focal_length": 1, "z1": 2}, -2),
        ({"sheet": "lens", "focal_length": 2, "z1": 2}, np.inf),
        ({"sheet": "glens", "focal_length": 4, "object_focal_length": 6, "z1": 3}, 4),
        ({"sheet": "lenslets", "alpha": 180, "ratio": 2, "z1": 2}, -1),
        ({"sheet": "view-rotator", "alpha": 50, "view_distance": 3, "z1": 3}, 3),
        ({"sheet": "view-rotator", "alpha": 50, "view_distance": 3, "z1": 2}, None),
        ({"sheet": "twist", "alpha": 180}, None),
        ({"windows": 2, "sheet": "lens", "sheet2": "none", "focal_length": 4, "d": 1, "z1": 1}, 4),
        ({"windows": 2, "sheet": "ideal", "sheet2": "lens", "focal_length": 4, "alpha": 180, "d": 1, "z1": 2}, -5),
        ({"windows": 2, "sheet": "lens", "sheet2": "ideal", "focal_length": 4, "alpha2": 60, "d": 1, "z1": 2}, None),
    ):
        page.evaluate("fromHash('')")
        text = sentence(page, **values)
        assert ("image is" in text) == (W is not None), text
        if W is None:
            continue
        if np.isinf(W):
            assert "image is infinitely far away" in text
        else:
            tiles = f"{abs(W)} {'tile' if abs(W) == 1 else 'tiles'}"
            window = "first window" if "windows" in values else "window"
            assert f"image is {tiles} {'behind' if W > 0 else 'in front of'} the {window}" in text
        scene = scene_of(page)
        seen = [complex(scene.replace(eye=(x, 0.1)).apparent_position(scene.L, scene.z1)) for x in (0, 0.5)]
        assert seen[1] - seen[0] == pytest.approx(0.5 * (1 if np.isinf(W) else W / (W + scene.z2)))


def test_where_all_light_passes_at_the_pole_is_said(page):
    """A lens images an eye beside its axis to a point beside the axis."""
    text = sentence(page, sheet="lens", focal_length=3, z1=6, z2=6, E=[0.4, 0])
    assert text.endswith("one point of the knight, at (−0.40, 0.00). This point fills the whole window.")


def test_values_that_a_sheet_does_not_allow_are_said(page):
    for value, kept in ((0.01, 0.1), (-0.01, -0.1), (-0.1, -0.1), (0, 0.1)):
        text = sentence(page, sheet="lens", focal_length=value)
        assert page.evaluate("state.focal_length") == kept
        assert ("|f| is at least 0.1." in text) == (value != kept)
        scene_of(page)
    text = sentence(page, sheet="axis", axis=[0, 1e-4, 0])
    assert "a = (0, 0.0001, 0) has no direction" in text and page.evaluate("state.axis") == [0, 1, 0]


# ---- Words ----


def test_a_small_number_keeps_the_minus_of_its_exponent(page):
    texts = {5e-7: "5 × 10⁻⁷", -5e-7: "−5 × 10⁻⁷", 1.25e-10: "1.25 × 10⁻¹⁰", 3e21: "3 × 10²¹", -0.5: "−0.5"}
    assert page.evaluate("(numbers) => numbers.map(brief)", [*texts]) == [*texts.values()]
    found = page.evaluate("[size(1e-8), rough(-2e-9), fixed(-1e6, 2), fixed(-0.001, 1)]")
    assert found == ["1.000 × 10⁻⁸", "−2 × 10⁻⁹", "−1.00 × 10⁶", "0.0"]
    assert page.evaluate("[size, brief, (x) => fixed(x, 2)].map((text) => text(Infinity))") == ["∞"] * 3
    # M = 10^7, and the window is 3 tiles wide
    assert "only 3 × 10⁻⁷ tiles wide." in sentence(page, alpha=180, z1=6 * (1 + 1e-7))


def test_fields_take_fractions_and_units(page):
    numbers = {"30°": 30, "30 °": 30, "−12,5 degrees": -12.5, "1/2": 0.5, "-3 / 4": -0.75, "2 tiles": 2, "1e-3": 1e-3}
    numbers |= {"45deg": 45, "45 De": 45, "20°/tile": 20, "٤٥٫٥": 45.5, "−۱۲": -12}
    nonsense = ["1/0", "1/", "/2", "1/2/3", "", " ", "tiles", "1.000,5", "3 knights", "0x10", "Infinity", "--1"]
    found = page.evaluate("(texts) => texts.map(readNumber)", [*numbers])
    assert found == [*numbers.values()]
    assert page.evaluate("(texts) => texts.map(readNumber).some(Number.isFinite)", nonsense) is False


def test_the_image_of_two_windows_is_said(page):
    """Where it is, and otherwise for which plane there is one: `series.imaged_plane`."""
    far, _ = series.imaged_plane(np.radians(95), [(2, np.radians(95))])  # its image is behind the eye
    for alpha, alpha2, z1 in ((120, 120, 2), (120, 120, 3), (150, 100, 2), (30, 40, 2), (95, 95, far)):
        page.evaluate("change", dict(windows=2, alpha=alpha, alpha2=alpha2, d=2, z1=z1))
        imaged, W = series.imaged_plane(np.radians(alpha), [(2, np.radians(alpha2))])
        text = page.evaluate("explanation(moment())")
        if abs(imaged - z1) < 1e-9:
            behind = ", behind your eye" if -W > 6 else ""
            assert f"Z is real: the image is {-W:.3g} tiles in front of the first window{behind}." in text
        else:
            assert "Z is not real: the knight has no image." in text
            assert (f"What stands at z₁ = {imaged:.3g} has one." in text) == (imaged > 0)


def test_a_picture_that_two_windows_tear_apart_has_no_angle(page):
    depths = {"d": 37.04, "z1": 27.09, "z2": 26.67}
    angles = {"alpha": 133.95, "alpha2": 124.55}
    text = sentence(page, windows=2, sheet="detailed", prisms=2, **angles, **depths, E=[0, 0], L=[0, 0.0457])
    assert page.evaluate("[moment().nu, moment().nearPole]") == [pytest.approx(np.nan, nan_ok=True), False]
    said = "The prisms are so large that they tear the knight apart: it has no angle."
    assert said in text and not re.search("undefined|can be wrong", text)  # no angle, no error of it
    assert "can be wrong" in sentence(page, level="expert")  # of the place P


DOUBTFUL = [
    {"sheet": "detailed", "alpha": 66, "prisms": 20, "z1": 4},
    {"sheet": "detailed", "alpha": 8, "prisms": 100},
    {"sheet": "detailed", "alpha": 180, "z1": 5.5},
    {"sheet": "single", "z1": 5.5},
    {"sheet": "detailed", "windows": 2, "alpha": 150, "alpha2": 60, "d": 1.5, "prisms": 60, "z1": 5, "E": [0.4, -0.3]},
    {"scene": "spheres", "sheet": "detailed", "alpha": 20, "z1": 3},
    {"sheet": "ideal", "alpha": 180, "z1": 5},
]


@pytest.mark.parametrize("values", DOUBTFUL, ids=str)
def test_a_prediction_that_is_off_by_pixels_is_said_to_be(page, values):
    """The page says so for exactly the scenes for which povgen prints a warning, and by which part of the picture."""
    page.evaluate("change", values)
    scene, chosen = scene_of(page), page.evaluate("moment().objects.indexOf(moment().z1)")
    L, z1 = scene.objects[chosen]
    error = warnings.possible_error(scene, L, z1, scene.radii[chosen]) if scene.sheet != "ideal" else 0
    if error:
        assert page.evaluate("possibleError(moment())") == pytest.approx(error, rel=1e-6)
    warned = error > 3 or "overlay" in dict(warnings.warnings(scene.replace(z1=z1), Rendering(overlay=True)))
    assert page.evaluate("unsure(moment())") == warned
    said = re.search(r"can be wrong by up to (\d+)% of the picture’s width", page.evaluate("explanation(moment())"))
    if warned and scene.sheet == "detailed":
        assert 0 <= int(said[1]) - 100 * error / 1280 < 1
    else:
        assert not said


# ---- Languages ----


@pytest.mark.parametrize(
    ("language", "values", "said"),
    [
        ("de", {"sheet": "none"}, "Im Fenster ist nichts: Der Springer ist"),
        ("fr", {"alpha": 0, "piece": "rook"}, "La tour n’est pas tournée"),
        ("fr", {}, "Le cavalier paraît tourné de 15,0°"),
        ("ar", {}, "وبحجم يعادل \u20681.13\u2069 مرة من الحجم"),
    ],
)
def test_what_is_seen_is_said_as_the_language_does(page, language, values, said):
    page.evaluate("choose", language)
    assert said in sentence(page, **values)
    page.evaluate("choose('en')")


@pytest.mark.parametrize("language", tables(ALL_KINDS))
def test_every_language_says_all(page, language):
    states = [
        *BEYOND,
        {"alpha": 180, "z1": 6},
        {"alpha": 180, "z1": 5.8, "E": [1.5, 0.5]},
        {"scene": "spheres", "sheet": "detailed", "prisms": 5},
        {"sheet": "single", "z1": 9, "piece": "queen"},
        {"alpha": 400, "L": [0, -20], "prisms": 2.5},
    ]
    page.evaluate("choose", language)
    for values in states:
        page.evaluate("fromHash('')")
        page.evaluate("change", values)
        for text in page.evaluate("[describe(moment()), explanation(moment()), ...caption(moment())]"):
            assert text and not re.search(r"[{}]|undefined|null|NaN", text.replace("undefined.", "")), (values, text)
    reasons = """QUESTIONS.filter(({ goal }) => !goal).map((question) => {
      const numbers = question.match ? [0, 1, true] : [0.5, 2, 1].map((x) => x * question.answer());
      const given = choices(question)?.map((_, k) => k) ?? numbers;
      return given.map((each) => reason(question, String(each)));
    })"""
    for found in page.evaluate(reasons):  # each wrong answer has its own, and the right one none
        assert len({*found}) == 3 and found.count("") == 1
    questions = "QUESTIONS.map((question) => [why(question), ...(choices(question) ?? [])]).flat()"
    assert not re.search(r"[{}]|undefined", "".join(page.evaluate(questions)))
    page.evaluate("choose('en')")
