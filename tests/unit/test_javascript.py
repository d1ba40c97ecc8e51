"""The scripts of the pages, without a browser: their equations, geometry, text and state are those of povgen."""

import json
import os
import re
import shutil
import subprocess
import sys
from graphlib import CycleError
from pathlib import Path

import numpy as np
import pytest
from conftest import BEYOND, MODULES, Node, mirrored_position, scene_of, seen_through_other_sheets, sentence

import povgen
from povgen import Chess, InputError, Spheres
from povgen.liveview import scripts
from povgen.liveview.page import KINDS
from povgen.liveview.values import values as live_values
from povgen.optics import paraxial, rotation, series
from povgen.optics.prism import Prism
from povgen.scene import warnings
from povgen.scene.laws import to_live
from povgen.scene.models import SCENES
from povgen.scene.spec import MOVIES
from povgen.settings import Rendering


@pytest.fixture
def page(node):
    """The page's modules, with the state that the page opens with."""
    node.evaluate("fromHash('')")
    return node


# ---- The equations ----

ALPHAS = np.radians(np.linspace(-360, 360, 49))
ALPHAS = np.unique([*ALPHAS, *(np.nextafter(s * np.pi, d) for s in (-1, 1) for d in (-9, 9)), np.pi - 1e-6, 1 - np.pi])
RATIOS = np.unique([*np.geomspace(1e-3, 1e3, 7), 1, np.nextafter(1, 0), np.nextafter(1, 2), 1 + 1e-9])


def compare(given, wanted):
    """Compare numbers from the page, complex ones as pairs, with Python's to 1e-12, and infinite ones exactly."""
    given = np.array(given, float)
    given = given[:, 0] + 1j * given[:, 1] if given.ndim == 2 else given
    finite = np.isfinite(wanted)
    assert np.array_equal(given[~finite], wanted[~finite])
    assert (abs(given[finite] - wanted[finite]) <= 1e-12 * abs(wanted[finite])).all()


def test_equations_are_those_of_rotation(page):
    r, alpha = (grid.ravel() for grid in np.meshgrid(RATIOS, ALPHAS))
    grid = [*zip(r.tolist(), alpha.tolist(), strict=True)]
    given = page.evaluate(
        """(grid) => Object.fromEntries(["P", "oneMinusP", "M", "nu"].map(
            (name) => [name, grid.map((numbers) => equations[name](...numbers))]))""",
        grid,
    )
    assert np.isinf(rotation.P(r, alpha)).sum() == 2  # r = 1, alpha = pi and -pi
    compare(given["P"], rotation.P(r, alpha))
    compare(given["oneMinusP"], rotation.one_minus_P(r, alpha))
    compare(given["M"], rotation.M(r, alpha))
    assert np.array(given["nu"]) == pytest.approx(rotation.nu(r, alpha), abs=1e-12, nan_ok=True)


class Prisms(Prism):
    """Prisms of many pitches, in an array."""

    def __post_init__(self):
        pass


def test_positions_are_those_of_rotation_and_paraxial(page):
    rng = np.random.default_rng(3)
    L, E = (rng.uniform(-2, 2, 500) + 1j * rng.uniform(-2, 2, 500) for _ in range(2))
    z1, z2 = (rng.choice([0.5, 2, 6, *np.geomspace(0.3, 3000, 9)], 500) for _ in range(2))
    alpha, prism = rng.choice(ALPHAS, 500), Prisms(rng.choice([2.4 / 25, 2.4 / 100, 2.4 / 1600], 500), base_angle=40)
    lengths = zip(prism.slab_shift, prism.separation, strict=True)
    grid = [
        ([L.real, L.imag], [E.real, E.imag], *map(float, rest), {"slab_shift": shift, "separation": separation})
        for L, E, *rest, (shift, separation) in zip(L, E, z1, z2, alpha, lengths, strict=True)
    ]
    compare(
        page.evaluate("(grid) => grid.map((numbers) => equations.ideal(...numbers.slice(0, 5)))", grid),
        rotation.apparent_position(L, E, z1, z2, alpha),
    )
    compare(
        page.evaluate("(grid) => grid.map((numbers) => equations.prisms(...numbers))", grid),
        paraxial.apparent_position(L, E, z1, z2, alpha, prism),
    )
    turned = page.evaluate(
        """(grid) => grid.map(([L, E, ...numbers]) => equations.turned(...numbers))
           .map(({ nu, M }) => [Number.isNaN(nu) ? null : nu, M])""",
        grid,
    )
    nu, M = paraxial.nu_and_M(z1, z2, alpha, prism)
    assert np.array([given for given, _ in turned], float) == pytest.approx(nu, abs=1e-12, nan_ok=True)
    compare([given for _, given in turned], M)
    apart = z1 != z2
    compare(
        page.evaluate(
            "(grid) => grid.map(([L, E, z1, z2, , prism]) => equations.mirrored(L, E, z1, z2, prism))",
            [each for each, ok in zip(grid, apart, strict=True) if ok],
        ),
        np.array(mirrored_position(L, E, z1, z2, prism))[apart],
    )


def test_equations_of_windows_in_series_are_those_of_rotation_and_paraxial(page):
    rng = np.random.default_rng(4)
    prism = Prism(2.4 / 100, index=1.7, base_angle=40)
    lengths = {"slab_shift": prism.slab_shift, "separation": prism.separation}
    for windows in (2, 3):
        for _ in range(20):
            z1, z2, *d = rng.uniform(0.5, 8, windows + 1)
            alpha, *turns = rng.uniform(-3, 3, windows)
            behind = [*zip(d, turns, strict=True)]
            L, E = rng.uniform(-2, 2, (2, 2)).tolist()
            Z, P, thick, turned = page.evaluate(
                """([L, E, z1, z2, alpha, prism, behind]) => [
                  equations.depth(z1, z2, alpha, behind), equations.ideal(L, E, z1, z2, alpha, behind),
                  equations.prisms(L, E, z1, z2, alpha, prism, behind),
                  equations.turned(z1, z2, alpha, prism, behind)]""",
                [L, E, z1, z2, alpha, lengths, behind],
            )
            compare([Z], np.array([rotation.depth(z1, z2, alpha, behind)]))
            L, E = complex(*L), complex(*E)
            compare([P], np.array([rotation.apparent_position(L, E, z1, z2, alpha, behind)]))
            compare([thick], np.array([paraxial.apparent_position(L, E, z1, z2, alpha, prism, behind)]))
            nu, M = paraxial.nu_and_M(z1, z2, alpha, prism, behind)
            assert [turned["nu"], turned["M"]] == pytest.approx([nu, M], rel=1e-12)


def test_positions_behind_other_sheets_are_those_of_python(page):
    """Also where the ray along the normal does not pass, and where two paths have just become one."""
    marks = Spheres(sheet="axis", axis=(0, -0.7, -0.6), alpha=180, z2=1, eye=(0, -1.5), line=(0, 2.6), z1=3)
    linear = [Spheres(sheet=sheet, ratio=1.3, alpha=100, eye=(0.3, 0.2)) for sheet in KINDS]
    cases = [(scene, L, 2.0, 0.0) for scene in linear for L in (0.3 - 1j, 2 + 1j)]
    cases += [
        (scene, L, scene.z1, 0.0)
        for scene, points, _ in seen_through_other_sheets(np.random.default_rng(9))
        for L in points
    ]
    wanted = [complex(scene.apparent_position(L, z1)) for scene, L, z1, _ in cases]
    cases.append((marks, marks.L, marks.z1, marks.radii[0]))
    given = page.evaluate(
        "(cases) => cases.map(([scene, near, ...values]) => crossing(...values, sheets.windows(scene)[0], near))",
        [[scene.model_dump(), near, [L.real, L.imag], scene.eye, z1, scene.z2] for scene, L, z1, near in cases],
    )
    assert len(given) > 1000 and np.isfinite(wanted).all()
    place = complex(*given.pop())
    assert abs(place - complex(marks.apparent_position(marks.L, 3, near=marks.radii[0]))) < 0.03
    assert np.array(given) @ [1, 1j] == pytest.approx(np.array(wanted), rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("scene", SCENES)
def test_what_the_script_derives(page, scene):
    """The script's prisms, frame and spheres are povgen's."""
    for given in (
        {},
        {"prisms": 7, "index": 1.8, "base_angle": 38, "gap": 0.2},
        {"sheet": "single", "aspect": 1.2, "z2": 1},
        {"prisms": 3000, "aperture": 1, "z2": 150},
        {"sheet": "ideal", "window": ("alpha=20,z=3", "alpha=5,z=7,sheet=detailed"), "prisms": 40},
    ):
        made = SCENES[scene](**{"z2": 12, **given})
        names = ("prism", "tile", "depth", "distances", "spheres", "pieces")
        script = "([names, scene]) => names.map((name) => geometry[name](scene))"
        prism, tile, depth, distances, spheres, pieces = page.evaluate(script, [names, live_values(made)])
        for name in ("pitch", "height", "length", "separation", "slab_shift"):
            assert prism[name] == pytest.approx(getattr(made.prism, name), rel=1e-12)
        windows = page.evaluate("(scene) => sheets.windows(scene)", live_values(made))
        for window, (z, sheet) in zip(windows, made.windows, strict=True):
            assert (window["z"], window["sheet"]) == (z, sheet.name)
            assert {name: window["values"][name] for name in sheet.values} == dict(sheet.values)
        assert tile == made.tile
        assert depth == pytest.approx(made.depth, rel=1e-12)
        assert distances == pytest.approx(made.distances, rel=1e-12)
        if scene == "spheres":
            expected = [(made.places[-1] + z1, made.radius(z1)) for z1 in made.distances]
            assert [(s["centre"][2], s["radius"]) for s in spheres] == [pytest.approx(pair) for pair in expected]
        else:
            feet = [(L.real, L.imag, made.places[-1] + z1) for L, z1 in made.objects]
            assert [p["foot"] for p in pieces] == [pytest.approx(foot) for foot in feet]


def test_questions_are_answered_by_the_equations(page):
    right = page.evaluate("QUESTIONS.map((question) => question.answer())")

    def nu(z1, alpha):
        return np.degrees(rotation.nu(6 / z1, np.radians(alpha)))

    angles = np.linspace(0, 180, 180_001)
    image = [complex(rotation.apparent_position(-1j, x, 2, 6, np.pi)).real for x in (0, 1)]
    assert rotation.mirror(np.array([0.1, 0.2, -1]), 0)[1] < 0 < nu(2, 66) and nu(1e9, 66) == pytest.approx(66)
    assert nu(12, 90) > nu(2, 90) and image[1] < image[0] and np.isinf(rotation.P(1, np.pi))
    numeric = [6, rotation.M(3, np.pi) / rotation.M(3, 0), angles[np.argmax(nu(2, angles))]]
    assert nu(6, 90) == pytest.approx(45)
    _, W = series.imaged_plane(np.radians(120), [(2, np.radians(120))])
    assert right == pytest.approx([2, 0, 2, 0, numeric[0], numeric[1], 2, numeric[2], 2, -W], abs=0.06)


# ---- The state ----


@pytest.mark.parametrize("values", BEYOND, ids=lambda values: values["sheet"])
def test_what_is_beyond_the_paper_is_povgens(page, values):
    """Positions, nu and M, and the address."""
    page.evaluate("change", values)
    scene, z1 = scene_of(page), page.evaluate("moment().z1")
    assert len(scene.sheets) == values.get("windows", 1)
    place = complex(*page.evaluate("moment().place"))
    assert place == pytest.approx(complex(scene.apparent_position(scene.L, z1)), rel=1e-9, abs=1e-9)
    if values["sheet"] in ("ideal", "detailed", "none"):
        found = page.evaluate("(({ nu, M }) => [nu * 180 / Math.PI, M])(moment())")
        assert [np.exp(1j * np.radians(found[0])), found[1]] == [
            pytest.approx(np.exp(1j * np.radians(scene.nu_and_M(z1)[0])), abs=1e-9),
            pytest.approx(scene.nu_and_M(z1)[1], rel=1e-9),
        ]
    link = page.evaluate("toHash()")
    page.evaluate("fromHash('')")
    page.evaluate("fromHash", link)
    assert page.evaluate("toHash()") == link and complex(*page.evaluate("moment().place")) == pytest.approx(place)
    text = page.evaluate("[describe(moment()), ...caption(moment())].join()")
    assert not re.search(r"NaN|Infinity|null|undefined|\[object", text)


def test_the_pages_ranges_are_those_of_the_scenes(page):
    """The page allows no value that povgen refuses."""
    ranges = page.evaluate("RANGES")
    for model in (Chess, Spheres):
        for name in ("alpha", "z2", "prisms"):
            for value, beyond in zip(ranges[name], (-1, 1), strict=True):
                outside = value + beyond * max(1, abs(value)) * (0 if name == "z2" and beyond < 0 else 1)
                if outside != value:
                    with pytest.raises(InputError):
                        model(**{name: outside})
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
    [
        "#",
        "#alpha=",
        "#alpha=1e999&z1=NaN&L=1&E=a,b",
        "#scene=house&sheet=3&piece=__proto__",
        "#%E0%A4%A",
        "#question=99",
    ],
)
def test_nonsense_in_an_address_is_ignored(page, link):
    page.evaluate("(link) => fromHash(link)", link)
    assert page.evaluate("({ ...state })") == page.evaluate("({ ...OPENING })")


# ---- The kinds of sheets ----

# A kind with parameters that no other has: a lens along x only, which also shifts all light.
CYLINDER = """
from povgen.sheets.law import Law
from povgen.sheets.sheet import Ideal, Parameter

class Cylinder(Ideal):
    name = "cylinder"
    title = "cylinder lens <1>"
    does = "bends light towards a vertical line"
    source = "a test"
    parameters = (
        Parameter("power", "power of the lens, -3 to 3", 0.2, -3, 3),
        Parameter("shift", "shift of the light as X,Y,Z", (0.5, 0.0, 0.1), -1, 1, kind="direction"),
    )
    law = Law("x - power*X*z + shift_x*z/9, y + shift_y*z/9, z + 0*shift_z", ["power", "shift_x", "shift_y", "shift_z"])
"""
# What the page is made of, and where Python says that the knight is seen.
EMITTED = """
import json, sys
from povgen import Chess
from povgen.liveview import page, scripts
from povgen.scene.laws import to_live
from povgen.scene.pieces import PIECES
from povgen.scene.sdl import to_html
data, laws = page.data({name: name for name in PIECES}), to_live()
place = Chess(sheet="cylinder", power=-0.3, shift=(-1, 0.25, 0), z1=3, eye=(0.4, -0.3)).apparent_position(-0.85j, 3)
html = to_html("demo/index", data, scripts.script("demo/main.js", laws=laws), laws)
print(json.dumps([data, scripts.script(*sys.argv[1:], laws=laws), html, [place.real, place.imag]]))
"""


def test_a_new_kind_of_sheet_is_one_file(tmp_path):
    """It is in the page's choice, with its sliders and fields; the page's numbers are Python's."""
    shutil.copytree(Path(povgen.__file__).parent, tmp_path / "povgen", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in (scripts.TEMPLATES, MOVIES):
        shutil.copytree(folder, tmp_path / folder.name)
    (tmp_path / "povgen" / "sheets" / "cylinder.py").write_text(CYLINDER)
    command = [sys.executable, "-c", EMITTED, *MODULES]
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert not done.returncode, done.stderr
    data, script, html, place = json.loads(done.stdout)
    assert '<option value="cylinder">cylinder lens &lt;1&gt;</option>' in html
    for part in ("slider-power", "number-power", "number-shiftx", "number-shifty", "number-shiftz"):
        assert f'id="{part}"' in html
    node = Node(data, script)
    node.evaluate("chooseBeyond", "cylinder")
    assert node.evaluate("[state.power, state.shift]") == [0.2, [0.5, 0, 0.1]]
    assert node.evaluate("chosenBeyond()") == "cylinder"
    node.evaluate("change", {"power": -0.3, "shift": [-1, 0.25, 0], "z1": 3, "E": [0.4, -0.3]})
    assert node.evaluate("moment().place") == pytest.approx(place, abs=1e-9)
    link = node.evaluate("toHash()")
    assert "sheet=cylinder" in link and "power=-0.3&shift=-1,0.25,0&" in link
    node.evaluate("fromHash('')")
    node.evaluate("fromHash", link)
    assert node.evaluate("moment().place") == pytest.approx(place, abs=1e-9)
    caption = node.evaluate("caption(moment())")
    assert caption[:3] == ["cylinder lens <1>", "power = −0.3", "shift = (−1, 0.25, 0)"]
    assert node.evaluate("explanation(moment())").startswith(
        "The sheet bends light towards a vertical line. The knight"
    )
    node.evaluate("change", {"power": 7})
    assert "power is at most 3." in node.evaluate("explanation(moment())")
    node.process.stdin.close()
    assert node.process.wait(10) == 0


@pytest.mark.parametrize("name", KINDS)
def test_a_choice_opens_with_the_values_of_its_kind(page, name):
    page.evaluate("chooseBeyond", name)
    kind = KINDS[name]
    wanted = {each.name: each.default for each in kind.parameters} | {**kind.opening}
    found = page.evaluate("(names) => names.map((name) => state[name])", [*wanted])
    assert found == [list(value) if isinstance(value, tuple) else value for value in wanted.values()]
    text = page.evaluate("[describe(moment()), ...caption(moment())].join()")
    assert kind.choice in text and kind.does in text and "{" not in text
    for each in kind.parameters:
        assert each.symbol in text


@pytest.mark.parametrize(
    ("values", "turned"),
    [
        ({"sheet": "refraction", "ratio": 1, "alpha": 40}, 40),
        ({"sheet": "axis", "axis": [0, 0, 0.5], "alpha": -20}, -20),
        ({"sheet": "axis", "axis": [0, 0, 0.5], "alpha": 360}, 0),
        ({"sheet": "twist", "twist": 0, "alpha": 15}, 15),
        ({"sheet": "view-rotator", "alpha": 0}, 0),
        ({"sheet": "lenslets", "ratio": 1, "alpha": 50.01}, 50.01),
        ({"sheet": "lenslets", "ratio": 1.01, "alpha": 50}, None),
        ({"sheet": "lens", "focal_length": 100}, None),
        ({"sheet": "mirror", "alpha": 0}, None),
    ],
    ids=str,
)
def test_a_sheet_that_is_the_papers_says_so(page, values, turned):
    text = sentence(page, **values)
    assert ("That is the paper’s window." in text) == bool(turned)
    assert ("With these values the sheet does nothing." in text) == (turned == 0)


def test_the_image_of_a_sheet_is_where_all_eyes_see_it(page):
    """The apparent positions for two eyes are on the lines from these eyes to the image."""
    for values, W in (
        ({"sheet": "lens", "focal_length": 4, "z1": 2}, 4),
        ({"sheet": "lens", "focal_length": 1, "z1": 2}, -2),
        ({"sheet": "lens", "focal_length": -2, "z1": 2}, 1),
        ({"sheet": "lens", "focal_length": 2, "z1": 2}, np.inf),
        ({"sheet": "glens", "focal_length": 4, "object_focal_length": 6, "z1": 3}, 4),
        ({"sheet": "lenslets", "alpha": 180, "ratio": 2, "z1": 2}, -1),
        ({"sheet": "lenslets", "alpha": 50, "ratio": 2, "z1": 2}, None),
        ({"sheet": "view-rotator", "alpha": 50, "view_distance": 3, "z1": 3}, 3),
        ({"sheet": "view-rotator", "alpha": 50, "view_distance": 3, "z1": 2}, None),
        ({"sheet": "mirror", "alpha": 50}, None),
        ({"sheet": "twist", "alpha": 180}, None),
        ({"sheet": "refraction", "alpha": 0, "ratio": 1.3}, None),
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
            assert f"image is {tiles} {'behind' if W > 0 else 'in front of'} the window" in text
        scene = scene_of(page)
        seen = [complex(scene.replace(eye=(x, 0.1)).apparent_position(scene.L, scene.z1)) for x in (0, 0.5)]
        assert seen[1] - seen[0] == pytest.approx(0.5 * (1 if np.isinf(W) else W / (W + scene.z2)))


def test_where_all_light_passes_at_the_pole_is_said(page):
    """A lens images an eye beside its axis to a point beside the axis."""
    text = sentence(page, sheet="lens", focal_length=3, z1=6, z2=6, E=[0.4, 0])
    assert text.endswith("The pole: one point of the knight fills the whole window, the point at (−0.40, 0.00).")


def test_values_that_a_sheet_does_not_allow_are_said(page):
    for value, kept in ((0.01, 0.1), (-0.01, -0.1), (-0.1, -0.1), (0, 0.1)):
        text = sentence(page, sheet="lens", focal_length=value)
        assert page.evaluate("state.focal_length") == kept
        assert ("|f| is at least 0.1." in text) == (value != kept)
        scene_of(page)
    text = sentence(page, sheet="axis", axis=[0, 1e-4, 0])
    assert "a = (0, 0.0001, 0) has no direction" in text and page.evaluate("state.axis") == [1, 0, 0]


# ---- Words ----


def test_a_small_number_keeps_the_minus_of_its_exponent(page):
    texts = {5e-7: "5 × 10⁻⁷", -5e-7: "−5 × 10⁻⁷", 1.25e-10: "1.25 × 10⁻¹⁰", 3e21: "3 × 10²¹", -0.5: "−0.5"}
    assert page.evaluate("(numbers) => numbers.map(brief)", [*texts]) == [*texts.values()]
    found = page.evaluate("[size(1e-8), rough(-2e-9), fixed(-1e6, 2), fixed(-0.001, 1)]")
    assert found == ["1.000 × 10⁻⁸", "−2 × 10⁻⁹", "−1.00 × 10⁶", "0.0"]
    # M = 10^7, and the window is 3 tiles wide
    assert "only 3 × 10⁻⁷ tiles wide fills the window" in sentence(page, alpha=180, z1=6 * (1 + 1e-7))


def test_fields_take_fractions_and_units(page):
    numbers = {"30°": 30, "30 °": 30, "−12,5 degrees": -12.5, "1/2": 0.5, "-3 / 4": -0.75, "2 tiles": 2, "1e-3": 1e-3}
    nonsense = ["1/0", "1/", "/2", "1/2/3", "", " ", "tiles", "1.000,5", "3 knights"]
    found = page.evaluate("(texts) => texts.map(readNumber)", [*numbers])
    assert found == [*numbers.values()]
    assert page.evaluate("(texts) => texts.map(readNumber).some(Number.isFinite)", nonsense) is False


def test_a_sphere_that_is_not_in_the_window_is_said(page):
    for z1, L, seen in ((6, [-0.25, 0.25], True), (0.2, [3, 3], False), (24, [3, 0], True)):
        text = sentence(page, scene="spheres", z1=z1, L=L)
        now = page.evaluate("(({ z1, z2, alpha }) => ({ z1, z2, alpha }))(moment())")
        place = rotation.apparent_position(complex(*L), 0, **now)
        assert seen == (max(abs(place.real), abs(place.imag)) < 1.5)
        assert seen == ("The sphere at z₁" in text) != ("of the sphere at z₁ = " in text)
    assert "is in the window, which shows other spheres, " in sentence(page, z1=0.2, L=[3, 3])


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


DOUBTFUL = [
    {"sheet": "detailed", "alpha": 66, "prisms": 20, "z1": 4},
    {"sheet": "detailed", "alpha": 8, "prisms": 100},
    {"sheet": "detailed", "alpha": 14, "prisms": 100},
    {"sheet": "detailed", "alpha": 180, "z1": 5.5},
    {"sheet": "detailed", "alpha": 180, "z1": 20, "E": [0.4, -0.3]},
    {"sheet": "single", "z1": 2},
    {"sheet": "single", "z1": 5.5},
    {"sheet": "detailed", "windows": 2, "alpha": 150, "alpha2": 60, "d": 1.5, "prisms": 60, "z1": 5, "E": [0.4, -0.3]},
    {"sheet": "detailed", "windows": 2, "alpha": 150, "alpha2": 60, "d": 1.5, "prisms": 200, "z1": 20},
    {"scene": "spheres", "sheet": "detailed", "alpha": 20, "z1": 3},
    {"sheet": "ideal", "alpha": 180, "z1": 5.97},
    {"sheet": "ideal", "alpha": 180, "z1": 5},
]


@pytest.mark.parametrize("values", DOUBTFUL, ids=str)
def test_a_prediction_that_is_off_by_pixels_is_said_to_be(page, values):
    """The page says so for exactly the scenes for which povgen prints a warning, with the same number of pixels."""
    page.evaluate("change", values)
    scene, chosen = scene_of(page), page.evaluate("moment().objects.indexOf(moment().z1)")
    L, z1 = scene.objects[chosen]
    error = warnings.possible_error(scene, L, z1, scene.radii[chosen]) if scene.sheet != "ideal" else 0
    if error:
        assert page.evaluate("possibleError(moment())") == pytest.approx(error, rel=1e-6)
    warned = error > 3 or "overlay" in dict(warnings.warnings(scene.replace(z1=z1), Rendering(overlay=True)))
    assert page.evaluate("unsure(moment())") == warned
    said = re.search(r"can be wrong by up to ([\d.]+) pixels", page.evaluate("explanation(moment())"))
    if warned and scene.sheet == "detailed":
        assert float(said[1]) == pytest.approx(error, rel=0.05)
    else:
        assert not said


# ---- The scripts as one ----


@pytest.mark.parametrize("folder", ["live", "demo"])
def test_a_page_has_all_modules_of_its_folder_once(folder):
    text = scripts.script(f"{folder}/main.js", laws=to_live())
    for path in (scripts.TEMPLATES / folder).glob("*.js"):
        assert text.count(f"\npovgen.{path.stem} = (") == 1
        own = path.read_text().rpartition('.js";\n')[2].splitlines()
        assert all(line in text for line in own if not line.startswith("export "))
    assert not re.search("^(import|export) ", text, re.M)


def test_an_import_may_have_another_name(tmp_path, monkeypatch):
    monkeypatch.setattr(scripts, "TEMPLATES", tmp_path)
    (tmp_path / "a.js").write_text('import { b as c, d } from "./b.js";\nexport const a = c + d;\n')
    (tmp_path / "b.js").write_text("export const b = 1;\nexport const d = 2;\n")
    assert "const { b: c, d } = povgen.b;\n" in scripts.script("a.js", laws=[])


def test_modules_that_import_each_other_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(scripts, "TEMPLATES", tmp_path)
    (tmp_path / "a.js").write_text('import { b } from "./b.js";\nexport const a = b;\n')
    (tmp_path / "b.js").write_text("export const b = 1;\n")
    assert "const { b } = povgen.b;\nconst a = b;\nreturn { a };" in scripts.script("a.js", laws=[])
    (tmp_path / "b.js").write_text('import { a } from "./a.js";\nexport const b = a;\n')
    with pytest.raises(CycleError):
        scripts.script("a.js", laws=[])
