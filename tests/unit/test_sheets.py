"""Kinds of sheets: their laws against independent formulas, the grammar of laws, and what is derived from them."""

import ast
from pathlib import Path

import numpy as np
import pytest
from conftest import refusal
from hypothesis import given
from hypothesis import strategies as st

from povgen import Bundle, Chess, InputError
from povgen.objects import sheet_fields
from povgen.optics.trace import End
from povgen.scene.laws import to_pov
from povgen.sheets import IDEAL, OTHER, PARAMETERS, SHEETS, USED_BY
from povgen.sheets.law_grammar import Law

DIRECTION = st.tuples(*[st.floats(-1, 1)] * 2, st.floats(0.1, 1)).map(np.array)
ANGLE = st.floats(-360, 360)
PLACE = st.builds(complex, st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))


def sheet(name, **values):
    """A sheet with these values, and defaults."""
    return SHEETS[name]({each.name: each.default for each in SHEETS[name].parameters} | values)


def transverse(direction):
    """x + iy of a direction (..., 3), its length being 1."""
    unit = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    return unit[..., 0] + 1j * unit[..., 1], unit[..., 2]


def agrees(bent, t, z):
    """Whether a unit direction has this transverse part and this z, up to its length; NaN if z is not above 0."""
    if not z > 1e-6:
        return np.isnan(bent).all() or z > 0
    expected = np.array([t.real, t.imag, z]) / np.hypot(abs(t), z)
    return np.allclose(bent, expected, rtol=0, atol=1e-10)


@given(DIRECTION, ANGLE, st.floats(0.1, 10))
def test_laws_of_the_same_everywhere(direction, degrees, ratio):
    t, z = transverse(direction)
    turn = np.exp(1j * np.radians(degrees))
    assert agrees(sheet("ideal", alpha=degrees).bend(direction), t / turn, z)
    assert agrees(sheet("mirror", alpha=degrees).bend(direction), np.conj(t) * turn, z)
    assert agrees(sheet("lenslets", alpha=degrees, ratio=ratio).bend(direction), t / (ratio * turn), z)
    sine = t / (ratio * turn)
    assert agrees(
        sheet("refraction", alpha=degrees, ratio=ratio).bend(direction), sine, np.sqrt(max(0, 1 - abs(sine) ** 2))
    )
    assert agrees(sheet("none").bend(direction), t, z)


@given(DIRECTION, ANGLE, st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: max(map(abs, axis)) > 0.001))
def test_rotation_about_an_axis(direction, degrees, axis):
    """By the product of quaternions. The eye's ray is turned by -alpha."""

    def product(p, q):
        scalar = p[0] * q[0] - p[1:] @ q[1:]
        return np.array([scalar, *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])

    half, unit = -np.radians(degrees) / 2, np.array(axis) / np.linalg.norm(axis)
    q = np.array([np.cos(half), *np.sin(half) * unit])
    turned = product(product(q, np.array([0, *direction])), q * [1, -1, -1, -1])[1:]
    t, z = transverse(turned)
    assert agrees(sheet("axis", alpha=degrees, axis=axis).bend(direction), t, z)


@given(st.floats(0.3, 20), st.floats(-20, 20).filter(lambda f: abs(f) > 0.2), st.floats(0.3, 20), PLACE, PLACE)
def test_a_lens_and_a_glens_image(a, f, g, point, place):
    """Rays from a point at the distance a meet at the distance b, with f/a + g/b = 1."""
    for one, far in ((sheet("glens", focal_length=f, object_focal_length=g), g), (sheet("lens", focal_length=f), f)):
        if abs(1 - f / a) < 1e-3:  # the image is at infinity
            continue
        b = far / (1 - f / a)
        image, other = (P + b * one.slope((P - point) / a, P) for P in (place, 0j))
        assert image == pytest.approx(other, abs=1e-9 * (1 + abs(b)) * (1 + 20 / a) * (1 + abs(f / far)))


@given(ANGLE, st.floats(0.1, 100), PLACE, PLACE)
def test_the_view_rotator_turns_a_plane_as_a_whole(degrees, distance, place, slope):
    rotator = sheet("view-rotator", alpha=degrees, view_distance=distance)
    seen = place + distance * rotator.slope(slope, place)
    straight = (place + distance * slope) * np.exp(-1j * np.radians(degrees))
    assert seen == pytest.approx(straight, abs=1e-9 * (1 + distance))
    scene = Chess(sheet="view-rotator", alpha=degrees, view_distance=2, z1=2, eye=(0.3, -0.2))
    direct = Chess(sheet="none", z1=2, eye=(0.3, -0.2))
    where = direct.apparent_position(place * np.exp(1j * np.radians(degrees)), 2)
    assert scene.apparent_position(place, 2) == pytest.approx(where, abs=1e-9)


@given(ANGLE, ANGLE, PLACE, PLACE)
def test_a_twist_rotates_light_by_another_angle_in_each_place(degrees, twist, place, slope):
    angle = np.radians(degrees + twist * abs(place))
    bent = sheet("twist", alpha=degrees, twist=twist).slope(slope, place)
    assert bent == pytest.approx(slope * np.exp(-1j * angle), abs=1e-9)


def test_light_that_does_not_pass():
    """Rotation about x tilts light up to 90 degrees; a denser medium reflects light beyond the critical angle."""
    directions = np.array([[0, np.sin(t), np.cos(t)] for t in np.radians([-89, -31, -29, 29, 31, 89])])
    passing = np.isfinite(sheet("axis", alpha=60, axis=(1, 0, 0)).bend(directions)[:, 0])
    assert passing.tolist() == [True, True, True, True, False, False]
    angles = np.radians([0, 30, 41, 43, 80])
    light = np.stack((np.sin(angles), 0 * angles, np.cos(angles)), -1)
    assert (
        np.isfinite(sheet("refraction", alpha=0, ratio=1 / 1.5).bend(light)[:, 0]).tolist() == [True] * 3 + [False] * 2
    )


# ---- The grammar


@pytest.mark.parametrize(
    ("text", "x"),
    [
        ("x + 2*y - -z/4, y, z", lambda x, y, z: x + 2 * y + z / 4),
        ("-(x - y) - (x - (y - z)), y, z", lambda x, y, z: -(x - y) - (x - (y - z))),
        ("sqrt(abs(x)) + min(x, y)*max(x, y), y, z", lambda x, y, z: np.sqrt(abs(x)) + min(x, y) * max(x, y)),
        ("pow(z, 3) + sin(x)*cos(y) + 1e-3, y, z", lambda x, y, z: z**3 + np.sin(x) * np.cos(y) + 1e-3),
        ("-+-x - -+-+-y, y, z", lambda x, y, z: x + y),
        ("x,\n  y,\n  z + 0*X*Y", lambda x, y, z: x),
    ],
)
def test_the_grammar(text, x):
    law = Law(text)
    d = np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9])
    bent = law.bend(d, 0.4 + 0.1j, {})
    expected = np.array([x(*d), d[1], d[2]])
    np.testing.assert_allclose(bent, expected / np.linalg.norm(expected), rtol=1e-14)
    again = Law(str(law))
    assert str(again) == str(law) and again == law and hash(again) == hash(law)
    assert not any("--" in each or "//" in each for each in law.expressions())
    assert law.uses_place == ("X" in text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x, y", "2 expressions; allowed: three"),
        (
            "x, y^2, z",
            "'y^2' at character 4; allowed: decimal numbers (0, or 1e-30 to 1e+30), + - * / ( ), x, y, z, X, Y, k",
        ),
        ("x*2e30, y, z", "'2e30' at character 3; allowed: decimal numbers (0, or 1e-30 to 1e+30), "),
        ("x, y, z + q", "'q' at character 11"),
        ("__import__('os').system('ls'), y, z", "at character 1"),
        ("0x10*x, y, z", "'0x10' at character 1"),
        ("x + 1_000, y, z", "'1_000' at character 5"),
        ("x), (y), (z", "'), (y), (z' at character 2"),
        (" x,\n y,\n é + q*z", "'é' at character 10"),
        ("x, 'a\nb', z", "at character 4"),
        ("x, y, z\0", "allowed:"),
        ("+".join(["x"] * 200) + ", y, z", "nested in more than 100 levels; allowed: up to 100"),
        ("x" * 1001, "1001 characters; allowed: up to 1000"),
    ],
)
def test_what_is_not_in_the_grammar_is_refused(text, words):
    assert words in refusal(lambda: Law(text, ["k"]), ValueError)


def test_a_law_of_ones_own_in_a_scene():
    scene = Chess(sheet="law", law="x - k*X*z, y, z", parameter=["k=0.25"])
    cylinder = scene.sheets[0]
    assert cylinder.slope(0.1 + 0.2j, 0.4 + 0.3j) == pytest.approx(0.2j)
    assert scene == Chess(sheet="law", law="x - k*X*z, y, z", parameter={"k": 0.25})
    with pytest.raises(InputError, match=r"^law = 'x, y, z \+ q': 'q' at character 11; allowed: decimal"):
        Chess(sheet="law", law="x, y, z + q")
    with pytest.raises(InputError, match="^window 2, law = 'x': 1 expressions"):
        Chess(sheet="ideal", window={"z": 2, "sheet": "law", "law": "x"})
    for name in ("x", "sin", "2k", "é", "__proto__"):
        with pytest.raises(InputError, match="allowed: a name of letters, digits and _ that begins with a letter, but"):
            Chess(sheet="law", law="x, y, z", parameter={name: 1})
    with pytest.raises(InputError, match="should have each name once"):
        Chess(sheet="law", law="x, y, z*k", parameter=["k=1", " k = 2"])


def test_laws_of_ones_own_in_series_have_numbers_of_their_own():
    first, second = (
        {"law": "x - k_2*X*z, y, z", "parameter": {"k_2": 0.1}},
        {"law": "x, k*y, z", "parameter": {"k": 0.3}},
    )
    found = [
        each for law in to_pov(Chess(sheet="law", **first, window=[{"z": 2, **second}])) for each in law.parameters
    ]
    assert [(each.name, each.value) for each in found] == [("Own_k_2", 0.1), ("Own2_k", 0.3)]


def test_a_division_by_0_is_infinite_as_in_the_other_languages():
    law = Law("min(1/0, 2)*x, min(1/(k - k), 2)*y, z", ["k"])
    assert law.bend([1, 1, 1], 0, {"k": 3}) == pytest.approx(np.array([2, 2, 1]) / 3)
    assert np.isnan(Law("1/0*x, y, z").bend([1, 1, 1], 0, {})).all()


# ---- What is derived


def test_constants_are_the_parts_without_a_ray():
    law = Law("(cos(alpha) - 1)*X + sin(alpha)*y, x*(cos(alpha) - 1)/k, z*2", ["alpha", "k"])
    assert law.constants() == ["cos(alpha) - 1.0", "sin(alpha)", "k"]
    assert law.with_constants() == ["c0 * X + c1 * y", "x * c0 / c2", "z * 2.0"]


def test_kinds_that_share_a_parameter_agree():
    for several in PARAMETERS.values():
        assert len({(p.default if p.kind != "table" else 0, p.least, p.most, p.unit, p.kind) for p in several}) == 1
    assert set(USED_BY["alpha"]) > {"detailed", "ideal", "axis"} and USED_BY["twist"] == ("twist",)
    assert {"lens", "glens", "twist", "view-rotator", "law"} < set(OTHER) < set(IDEAL)


def test_type_checkers_know_every_parameter():
    tree = ast.parse(Path(sheet_fields.__file__).read_text("utf-8"))
    [declared] = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef) and node.name == "_Parameters"]
    types = {"number": "float", "whole number": "int", "direction": "tuple", "table": "dict"}
    assert {each.target.id: ast.unparse(each.annotation).split(" | ")[0].split("[")[0] for each in declared.body} == {
        name: types.get(first.kind, "str") for name, (first, *_) in PARAMETERS.items()
    }


@pytest.mark.parametrize("name", SHEETS)
def test_every_kind_says_what_it_is(name):
    kind = SHEETS[name]
    assert kind.title and kind.does and not kind.does.endswith(".") and kind.__doc__
    for values in kind.examples:
        assert set(values) <= {each.name for each in kind.parameters}
        Chess(sheet=name, **values)


LINEAR = {"ideal", "mirror", "lenslets", "lens", "glens", "view-rotator", "none"}
CURVED = {"axis", "law", "refraction", "twist"}


@pytest.mark.parametrize("name", IDEAL)
def test_matrices_are_those_of_the_laws(name, rng):
    s, P = rng.uniform(-2, 2, (2, 30, 2)) @ [1, 1j]
    for values in IDEAL[name].examples:
        one = sheet(name, **values)
        if name in LINEAR | CURVED and values not in ({"alpha": 180, "ratio": 1}, OTHER["law"].examples[0]):
            assert (one.transfer is not None) == (name in LINEAR)
        if one.transfer is not None:
            X, Y, sx, sy, _ = one.transfer @ np.stack((P.real, P.imag, s.real, s.imag, np.ones(30)))
            np.testing.assert_allclose(X + 1j * Y, P)
            np.testing.assert_allclose(sx + 1j * sy, one.slope(s, P), atol=1e-12)


def test_positions_for_several_angles():
    """Whether the search is needed depends on the angle that is asked for, not on the scene's own."""
    for own in (0, 10, 2):
        scene = Chess(sheet="axis", alpha=own, axis=(0, 1, 0))
        found = scene.apparent_position(0, 2, alpha=[0, 20, 30])
        assert found == pytest.approx([scene.replace(alpha=alpha).apparent_position(0, 2) for alpha in (0, 20, 30)])
        assert scene.visible(0, 2, alpha=[0, 20, 30]).all()


def test_a_law_that_is_linear_only_in_parts_has_no_matrix():
    for law in (
        "x - max(X - 4, 0)*z, y, z",
        "x + abs(y - 3*z) - 3*z + y, y, z",
        "x, y + sqrt(pow(X - 4, 2)) + X - 4, z",
    ):
        one = sheet("law", law=law, parameter={})
        assert one.transfer is None
    # these block light, the last one only far from where the rays that determine a matrix meet the sheet
    for factor in ("((X + 0.5)*(X + 0.5) + Y*Y - 0.09)", "(z - 0.3)", "(1 - X/4)"):
        law = ", ".join(f"{axis}*{factor}" for axis in "xyz")
        assert sheet("law", law=law, parameter={}).transfer is None
    for last in ("2*z", "z*k", "sqrt(k)*z/(4*k)", "-(z*(-k))"):
        law = ", ".join(last.replace("z", axis) for axis in "xyz")
        found = sheet("law", law=law, parameter={"k": 0.25}).transfer
        assert found == pytest.approx(np.eye(5))
    # constants may be computed with any function
    assert sheet("law", law="x - sqrt(max(k, 0))*X*z, y, z", parameter={"k": 0.25}).transfer is not None


def test_the_eye_sees_a_point_through_a_law_that_is_linear_only_in_parts():
    """Light from the far part of a wide window counts, although all rays near its middle go straight on."""
    scene = Chess(sheet="law", law="x - max(X - 4, 0)*z/2, y, z", aperture=10, view=12, z1=2, z2=2)
    P = 4.5  # there the slope becomes less by 0.25
    L = P + scene.z1 * (P / scene.z2 - 0.25)
    assert scene.apparent_position(L, scene.z1) == pytest.approx(P)


def test_light_that_a_law_blocks_is_not_seen():
    """Through a disc that is opaque: where the prediction sees nothing, the ray trace ends."""
    disc = "((X + 0.5)*(X + 0.5) + (Y + 0.7)*(Y + 0.7) - 0.09)"
    scene = Chess(sheet="law", law=f"x*{disc}, y*{disc}, z*{disc}")
    P = -0.5 - 0.7j + np.array([0, 0.29, 0.31, 0.29j, 0.31j])
    seen, visible = scene.seen(P * (scene.z2 + scene.z1) / scene.z2, scene.z1)
    rays = scene.trace(Bundle((0, 0, -scene.z2), np.stack((P.real, P.imag, np.full(5, scene.z2)), -1)))
    assert (rays.end == [End.BLOCKED, End.BLOCKED, 0, End.BLOCKED, 0]).all()
    assert (visible == (rays.end == 0)).all() and (np.isnan(seen) == (rays.end != 0)).all()
    np.testing.assert_allclose(seen[visible], P[visible])
