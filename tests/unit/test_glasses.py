"""Glasses by name: the catalogue's indices, and scenes whose prisms have them."""

import pickle
import re

import numpy as np
import pytest
from conftest import refusal

from povgen import Chess, InputError, MovieSpec, to_pov
from povgen.optics.glasses import GLASSES, index
from povgen.scene.shader import uniforms
from povgen.scene.survey import Survey
from povgen.sheets import USED_BY
from povgen.video.caption_texts import facts

# n of the yellow line d and Abbe's number, as Schott's data sheets state them; of the others, as their papers do
STATED = {
    "BK7": (1.51680, 64.17),
    "N-BK7": (1.51680, 64.17),
    "N-K5": (1.52249, 59.48),
    "N-FK51A": (1.48656, 84.47),
    "N-BAK4": (1.56883, 55.98),
    "N-SK16": (1.62041, 60.32),
    "F2": (1.62004, 36.37),
    "N-F2": (1.62005, 36.43),
    "SF5": (1.67270, 32.21),
    "N-SF5": (1.67271, 32.25),
    "N-BAF10": (1.67003, 47.11),
    "N-LAK8": (1.71300, 53.83),
    "SF10": (1.72825, 28.41),
    "N-SF10": (1.72828, 28.53),
    "SF11": (1.78472, 25.76),
    "N-SF11": (1.78472, 25.68),
    "SF6": (1.80518, 25.43),
    "N-SF6": (1.80518, 25.36),
    "N-LASF9": (1.85025, 32.17),
    "N-SF66": (1.92286, 20.88),
    "fused-silica": (1.45846, 67.8),
    "CaF2": (1.43384, 95.1),
    "water": (1.33340, 55.8),
}


@pytest.mark.parametrize("glass", GLASSES)
def test_the_catalogue(glass):
    F, d, C = (index(glass, wavelength * 1e-9) for wavelength in (486.1327, 587.5618, 656.2725))
    if glass in STATED:
        assert (d, (d - 1) / (F - C)) == (
            pytest.approx(STATED[glass][0], abs=1.5e-5),
            pytest.approx(STATED[glass][1], abs=0.006 if glass.isupper() else 0.11),
        )
    else:  # plastics, of which a sample's n differs in the third digit
        assert d == pytest.approx({"PMMA": 1.491, "polycarbonate": 1.585}[glass], abs=1e-3)


@pytest.mark.parametrize(
    ("given", "glass"),
    [("n-sf11", "N-SF11"), ("sf11", "SF11"), ("NBK7", "N-BK7"), ("bk7", "BK7"), ("Fused Silica", "fused-silica")],
)
def test_the_names_of_glasses_in_any_case(given, glass):
    assert index(given, 5e-7) == index(glass, 5e-7)
    scene = Chess(glass=given, window=f"z=2,glass={given}")
    assert scene == Chess(glass=glass, window=f"z=2,glass={glass}") and scene.glass == scene.window[0].glass == glass


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("bak4", "unknown; did you mean N-BAK4?"),  # the glass that has replaced it
        ("N-LAK9", "unknown; did you mean N-LAK8?"),
        ("wood", f"unknown; allowed: {', '.join(GLASSES)}"),
    ],
)
def test_an_unknown_glass_is_refused_with_a_near_name(given, message):
    assert refusal(lambda: Chess(glass=given)).startswith(
        f"glass = '{given}': {message} (glass of the prisms or lenses"
    )
    assert refusal(lambda: index(given, 5e-7), ValueError) == f"glass = '{given}': {message}"


@pytest.mark.parametrize(
    ("glass", "wavelength", "message"),
    [
        ("BK7", -5e-7, "wavelength of .{1,9} nm: outside the formula of BK7; allowed: 300 to 2500 nm"),
        ("BK7", [5e-7], "wavelength = .{1,60}: allowed: one number, metres"),
        ("x" * 10_000, 5e-7, "glass = .{1,60}: unknown; allowed: BK7, N-BK7, .*, water"),
    ],
    ids=range(3),
)
def test_what_has_no_index_is_an_error_of_one_line(glass, wavelength, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        index(glass, wavelength)


def test_a_glass_is_an_index():
    scene = Chess(glass="BK7")
    assert to_pov(scene) == to_pov(Chess(index=scene.index)) != to_pov(Chess())
    assert scene.index == index("BK7", 587.6e-9)
    assert uniforms(scene, ["knight"], [(0, 0, 0, 1)])["glassIndices"] == [scene.index] * 2
    assert scene.replace(wavelength=450).index > scene.index and scene.replace(glass="none").index == 1.5
    assert scene.replace(wavelength=450).replace(index=1.7) == Chess(index=1.7)
    assert Chess(index=1.7).replace(glass="BK7") == scene
    other = Chess(glass="BK7", wavelength=450, window="z=2,glass=N-SF11").replace(index=1.7)
    assert (other.glass, other.wavelength, other.index) == ("none", 450, 1.7)
    assert other.replace(index=1.4, window=()) == Chess(index=1.4)  # the new windows count
    for copy in (Chess(**scene.model_dump()), pickle.loads(pickle.dumps(scene))):
        assert copy == scene and copy.replace(wavelength=450) == scene.replace(wavelength=450)


def test_windows_can_have_glass_of_their_own():
    scene = Chess(glass="BK7", wavelength=500, window=["z=2", "z=3,index=1.7", "z=4,glass=N-SF11"], z2=8)
    n, other = (index(glass, 500e-9) for glass in ("BK7", "N-SF11"))
    assert [sheet.values["index"] for sheet in scene.sheets] == [n, n, 1.7, other]
    assert facts(scene)["n"] == f"{n:.4f} (BK7), {other:.4f} (N-SF11) at 500.0 nm"
    assert scene.replace(wavelength=600).sheets[3].values["index"] == pytest.approx(index("N-SF11", 600e-9), abs=1e-12)


def built(scene):
    """Return the numbers of what is built, the indices, and the lines of the .pov text that depend on no index."""
    shapes = [layer.shape for sheet in scene.sheets for layer in sheet.glass]
    edges = [edge for shape in shapes for edge in getattr(shape, "edges", ())]
    numbers = [scene.depth, *(x for edge in edges for x in (*edge.start, *edge.end, edge.radius, edge.period))]
    numbers += [x for shape in shapes for x in (shape.pitch, shape.length)]
    given = uniforms(scene, ["knight"], [[0] * 4], found=Survey(20, 0.5))
    indices = [shape.index for shape in shapes] + given.pop("glassIndices")
    numbers += [x for name in sorted(given) for x in np.ravel(given[name])]
    text = (line.partition("//")[0] for line in to_pov(scene, found=Survey(20, 0.5)).splitlines())
    lines = [line for line in text if not re.search(r"Index|Aspect|^ *Shape\(", line)]
    return np.array(numbers, float), np.array(indices), lines


@pytest.mark.parametrize("name", USED_BY["glass"])
@pytest.mark.parametrize(
    ("values", "glasses"),
    [
        ({}, ["BK7"]),
        ({"design_wavelength": 486, "aspect": 0.9, "f_number": 4}, ["BK7"]),
        ({"window": ("z=3,design_wavelength=650", "z=6,glass=N-SF11")}, ["BK7", "N-SF11"]),
        ({"sheet": "none", "glass": "none", "window": "z=3,sheet={},glass=N-SF11"}, ["N-SF11"]),
    ],
    ids=str,
)
def test_sheets_are_made_once_for_light_of_every_colour(name, values, glasses):
    """The ray trace, the shaders and the .pov text have one shape, and the indices of each wavelength."""
    values = {"sheet": name, "glass": "BK7", "z2": 9, **values}
    values = {key: value.format(name) if isinstance(value, str) else value for key, value in values.items()}
    scene = Chess(**values)
    planned, _, planned_lines = built(scene)
    for w in (400, 1000):
        shape, indices, lines = built(scene.replace(wavelength=w))
        assert lines == planned_lines
        assert shape == pytest.approx(planned, rel=1e-12, abs=1e-12)
        assert {*indices.round(9)} - {1.5} == {round(index(glass, w * 1e-9), 9) for glass in glasses}


def test_a_design_wavelength_is_that_of_an_index():
    """Sheets made for 486 nm, in light of 486 nm, are those of the index for 486 nm."""
    blue = {"glass": "BK7", "design_wavelength": 486, "wavelength": 486}
    for sheet in USED_BY["glass"]:
        scene = Chess(sheet=sheet, **blue)
        assert scene.sheets[0].shape == Chess(sheet=sheet, index=scene.index).sheets[0].shape
        assert scene.sheets[0].shape != Chess(sheet=sheet, **blue | {"design_wavelength": 600}).sheets[0].shape
    plain = Chess(**blue, window="z=2,glass=none").sheets[1]  # without a glass, it has the index that is usual
    assert plain.shape == Chess().sheets[0].shape


@pytest.mark.parametrize(("f_number", "minutes"), [(3, 16.2), (6, 5.7)])
def test_lenses_turn_light_of_each_colour_differently(f_number, minutes):
    """The RMS change of directions from F to C on the designed path, as another program's ray trace finds it."""
    scene = Chess(sheet="lenticular", glass="BK7", f_number=f_number)
    assert scene.sheets[0].shape.edges[0].radius == pytest.approx(f_number / 3 * 1.02215, abs=1e-5)
    F, C = (scene.replace(wavelength=w).trace(scene.rays((200, 150))) for w in (486.1327, 656.2725))
    both = F.designed & C.designed
    change = np.linalg.norm((F.direction - C.direction)[both], axis=1)
    assert 60 * np.degrees(np.sqrt(np.mean(change**2))) == pytest.approx(minutes, abs=0.15)


def test_a_new_index_replaces_the_glass_of_a_window_and_of_a_movie():
    scene = Chess(window=["z=2,glass=BK7", "z=3,index=1.6"])
    glass, plain = scene.window
    assert Chess(window=[glass.replace(index=1.7), plain.replace(glass="BK7")]) == Chess(
        window=["z=2,index=1.7", "z=3,glass=BK7"]
    )
    spec = MovieSpec(
        title="a", scene="chess", fixed={"glass": "BK7"}, sweep=[{"parameter": "alpha", "start": 10, "stop": 90}]
    )
    assert spec.with_fixed({"index": "1.7"}).fixed == {"index": 1.7}
    blue = spec.with_fixed({"wavelength": 450})
    assert blue.with_fixed({"index": "1.7"}).fixed == {"index": 1.7}
    assert blue.with_fixed({"glass": "none"}).fixed == {"glass": "none"}
    assert blue.with_fixed({"index": "1.7", "window": "z=2,glass=BK7"}).fixed["wavelength"] == 450


def test_a_wavelength_can_be_swept():
    spec = MovieSpec.of_sweeps("chess", ["wavelength=400:700"], {"frames": 4, "fixed": {"glass": "N-SF11"}})
    assert [scene.index for scene in spec.scenes("standard")] == [
        index("N-SF11", x * 1e-9) for x in (400, 500, 600, 700)
    ]
    with pytest.raises(InputError, match="frame 1 of 4: wavelength = 400: needs a glass; allowed: with one"):
        spec.replace(fixed={}).scenes("standard")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"glass": "BK7", "index": 1.6}, "index = 1.6, glass = 'BK7': allowed: one of them"),
        ({"wavelength": 500}, "wavelength = 500: needs a glass; allowed: with one, such as glass = BK7"),
        (
            {"glass": "BK7", "z2": 9, "window": "z=2,index=1.6,design_wavelength=500"},
            "window 2, design_wavelength = 500: needs a glass; allowed: with one, such as glass = BK7",
        ),
        (
            {"glass": "N-SF11", "wavelength": 400, "aspect": 0.3},
            "aspect = 0.3: the slanted facets of prisms with index = 1.78471 and base_angle = 45 would cross; "
            "allowed: 0.5685 < aspect < 2",
        ),
        (
            {"window": "z=2,glass=PMMA", "wavelength": 400},
            "window 2, wavelength of 400 nm: outside the formula of PMMA; allowed: 436.8 to 1052 nm",
        ),
    ],
)
def test_what_cannot_be_is_refused(values, message):
    assert refusal(lambda: Chess(**values)) == message


def test_the_caption_says_n_only_of_a_named_glass():
    assert "n" not in facts(Chess()) and "n" not in facts(Chess(glass="BK7", sheet="ideal"))
    assert facts(Chess(glass="BK7"))["n"] == "1.5168 (BK7) at 587.6 nm"
    blue = Chess(glass="BK7", design_wavelength=500, wavelength=600)
    assert facts(blue)["n"] == "1.5163 (BK7, made for 500 nm) at 600.0 nm"
