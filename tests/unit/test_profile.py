"""Profiles: what a user can state wrongly, and the general ray trace against the special one and against formulas."""

from math import radians

import numpy as np
import pytest

from povgen import Chess
from povgen.optics import paraxial
from povgen.optics.faces import GlassSheet
from povgen.optics.prism import Prism
from povgen.optics.profile import confocal, dove, lenticulars, wedges
from povgen.optics.trace import End, pair, trace
from povgen.sheets.profile import ProfileFile

LENS = """
index = 1.6
path = [1, 2]

[[outline]]
corners = [[0, 0], [1, 0]]
radii = [1]

[[outline]]  # the other way round: glass is found on its other side
corners = [[1, 2], [0, 2]]
radii = [2]
"""
PRISM = "path = [2, 1]\noutline = [{ corners = [[0.1, 0], [0.9, 0], [0.5, 1], [0.1, 0]] }]"

# a block of glass with one bulging face, {}, and a hole in it
HOLE = (
    "path = [1, 2]\noutline = [{{ corners = [[0, 0], [1, 0]] }}, {{ corners = {} }}, "
    "{{ corners = [[0.45, 0.3], [0.5, 0.25], [0.55, 0.3], [0.5, 0.35], [0.45, 0.3]] }}]"
)


def read(text):
    return ProfileFile("lens.toml", text).profile


def fan(n, slope=0.25, seed=1):
    random = np.random.default_rng(seed)
    direction = np.column_stack((random.uniform(-slope, slope, (n, 2)), np.ones(n)))
    origin = np.column_stack((random.uniform(-0.3, 0.3, (n, 2)), np.full(n, -2.0)))
    return origin, direction / np.linalg.norm(direction, axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("index = 1.5", "outline: missing"),
        (LENS.replace("path = [1, 2]", "path = [1, 3]"), "path: edge 3; allowed: 1 to 2"),
        (LENS.replace("[1, 0]]", "[1, 0.1]]"), r"begins at \[0, 0\] and ends at \[1, 0.1\]; allowed: the same"),
        (LENS.replace("radii = [1]", "radii = [0.4]"), "edge 1: radius = 0.4; allowed: 0, or 0.5 to 10000 periods"),
        (LENS.replace("[[1, 2], [0, 2]]\nradii = [2]", "[[1, 0.3], [0, 0.3]]\nradii = [-0.5]"), "edges 1 and 2 cross"),
        (PRISM.replace("[0.5, 1]", "[0.9, 0]"), r"outline 1, edge 2: begins and ends at \[0.9, 0\]"),
        (PRISM.replace("[0.9, 0]", "[1.1, 0]"), "edge 1: u from 0.1 to 1.1 periods; allowed: 0 to 1"),
        (PRISM.replace("[0.5, 1]", "[0.5, 0]"), "outline 1: glass or air on both sides"),
        (HOLE.format("[[0, 0.1], [1, 0.1]], radii = [0.5]"), "outline 3: between another outline's arc and"),
        (LENS.split("[[outline]]  #")[0], "^1 outlines that continue in the next period; allowed: an even"),
    ],
)  # fmt: skip
def test_a_wrong_profile_is_refused(text, message):
    with pytest.raises(ValueError, match=message) as error:
        read(text)
    assert "\n" not in str(error.value)


def test_a_profile_in_another_unit_of_length_without_a_gap_and_with_slanted_arcs():
    text = LENS
    for old, new in (
        ("[1, 0]]", "[0.4, 0]]"),
        ("[[1, 2], [0, 2]]", "[[0.4, 0.8], [0, 0.8]]"),
        ("[1]", "[0.4]"),
        ("[2]", "[0.8]"),
    ):
        text = text.replace(old, new)
    same, scaled = read(LENS), read("period = 0.4\ngap = 0.004\n" + text)
    np.testing.assert_allclose([edge.start for edge in scaled.edges], [edge.start for edge in same.edges], atol=1e-12)
    assert scaled.length == pytest.approx(same.length, rel=1e-12) and scaled.gap == pytest.approx(same.gap)
    assert read("gap = 0\n" + LENS).gap == 0
    bulging = read(PRISM.replace("}]", ", radii = [0, 2, -3] }]")).edges
    assert [np.hypot(*np.subtract(edge.centre, edge.end)) for edge in bulging[1:]] == pytest.approx([2, 3])


def test_the_constructors_refuse_what_does_not_fit():
    for make, message in (
        (lambda: confocal(ratio=0.4), "semicircle"),
        (lambda: wedges(80), "angle = 80; allowed: 1 to 60"),
        (lambda: confocal(mismatch=-0.91), "mismatch = -0.91; allowed: -0.9 or more"),
        (lambda: confocal(index=1.0), "index = 1; allowed: above 1"),
    ):
        with pytest.raises(ValueError, match=message):
            make()


@pytest.mark.parametrize("mismatch", [-0.45, -0.6, -0.9])
def test_light_meets_every_lens_of_a_small_pitch(mismatch):
    """Light that passed between two of the lenses would be in air inside the block, and end at the window's frame."""
    shape, y = confocal(mismatch=mismatch), np.linspace(-5, 5, 2001)
    origin = np.column_stack((0 * y, y, np.full(len(y), -shape.half - 0.1)))
    rays = trace(origin, [[0, 0.02, 1]], (GlassSheet(0, 0, shape),), 61.0)
    assert not (rays.end == End.FRAME).any()


@pytest.mark.parametrize("prism", [Prism(0.03), Prism(0.05, 1.7, 40, 0.05, 0.9), Prism(0.1)])
def test_the_general_trace_agrees_with_that_of_prisms(prism):
    origin, direction = fan(4000)
    special = trace(origin, direction, pair(1.15, prism), 2.4)
    general = trace(origin, direction, pair(1.15, dove(prism)), 2.4)
    assert (special.faces == general.faces).all() and (special.end == general.end).all()
    assert (special.designed == general.designed).all() and special.designed.mean() > 0.2
    out = special.end <= End.BACK  # a ray that meets the frame has no exact place
    np.testing.assert_allclose(general.position[out], special.position[out], atol=1e-10)
    np.testing.assert_allclose(general.direction[out], special.direction[out], atol=1e-10)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("shape", [confocal, lenticulars])
def test_confocal_lenses_multiply_the_slope_and_ghosts_add_to_it(shape, ratio):
    """For weak lenses, and m cells between entry and exit: slope' = -(f2/f1) slope + m p/f1, for rays from the eye."""
    f_number = 60.0
    lens = shape(ratio, f_number, **({"sheet": 1.0} if shape is lenticulars else {}))
    focal = f_number * ratio * (1 / lens.index if shape is confocal else 1)
    origin, direction = fan(4000, 0.03)
    rays = trace(origin, direction, (GlassSheet(0.0, 0.0, lens.scaled(0.01)),), 2.4)
    through = rays.end == End.THROUGH
    order = rays.orders[through, 0]
    assert (
        through.mean() > 0.95 and {-1, 0, 1} <= {*order} and (rays.designed == through & (rays.orders[:, 0] == 0)).all()
    )
    before, after = (d[through, 1] / d[through, 2] for d in (direction, rays.direction))
    np.testing.assert_allclose(after, -before / ratio + order / focal, atol=3e-4)
    along = direction[through, 0] / direction[through, 2], rays.direction[through, 0] / rays.direction[through, 2]
    np.testing.assert_allclose(*along, atol=1e-4)


def test_a_wedge_turns_light_along_z_by_snells_law():
    rays = trace([[0, 0.001, -1]], [[0, 0, 1]], (GlassSheet(0.0, 0.0, wedges(20, 1.5).scaled(0.1)),), 1.0)
    assert rays.designed[0]
    turned = np.arcsin(1.5 * np.sin(radians(20))) - radians(20)
    assert np.arctan2(rays.direction[0, 1], rays.direction[0, 2]) == pytest.approx(turned, abs=1e-12)


def test_a_single_surface_focuses_where_geometry_says():
    """A hollow and a bulging arc: light along z at the height h of a circle is refracted by Snell's law, exactly."""
    for radius, sign in ((0.8, 1), (-0.8, -1)):
        lens = read(LENS.replace("radii = [1]", f"radii = [{radius}]").replace("radii = [2]", "radii = [0]"))
        h = 0.2
        rays = trace([[0, 0.5 + h, -3]], [[0, 0, 1]], (GlassSheet(0.0, 0.0, lens),), 20.0)
        hits = h / 0.8
        inside = np.arcsin(hits) - np.arcsin(hits / 1.6)  # the angle to z within the glass
        assert np.arcsin(rays.direction[0, 1]) == pytest.approx(-sign * np.arcsin(1.6 * np.sin(inside)), abs=1e-12)


def test_the_matrix_of_a_profile_is_that_of_prisms():
    does, prism = paraxial.small_angles(dove(Prism(0.1))), Prism(0.1)
    assert does.factor == pytest.approx(-1, abs=1e-9) and abs(does.deviation) < 1e-9 and does.blur < 1e-9
    assert does.slab_shift == pytest.approx(prism.slab_shift, rel=0.01)
    assert does.reach == pytest.approx(prism.reach, rel=0.02) and abs(does.shift) < 0.05 * prism.reach


def test_the_matrix_of_lenses_is_that_of_paraxial_optics():
    """Confocal lenses of equal focal lengths f in glass mirror the slope at their middle plane.

    Along the ridges they are a slab of the thickness 2 f, which shifts light by 2 f (1 - 1/n) times the slope.
    """
    f, pitch = 20.0, 0.02
    does = paraxial.small_angles(confocal(f_number=f).scaled(pitch))
    assert does.factor == pytest.approx(-1, abs=2e-3)
    assert abs(does.deviation) < 1e-9
    assert does.slab_shift == pytest.approx(pitch * 2 * f * (1 - 1 / 1.5), rel=0.01)
    assert abs(does.shift) < 0.15 * pitch and abs(does.offset) < 1e-9
    unequal = paraxial.small_angles(confocal(2.0, f).scaled(pitch))
    assert unequal.factor == pytest.approx(-0.5, abs=2e-3)


@pytest.mark.parametrize("values", [{"ratio": 0.8}, {"ratio": 1.0}])
def test_a_pair_of_lenticular_sheets_obeys_its_law(values):
    """Light on the designed path of weak lenses has the slope of the infinitely fine sheets, on average over a lens."""
    scene = Chess(sheet="lenticular", alpha=50, **{"f_number": 8, **values})
    lens, law = scene.sheets[0], scene.sheets[0].thin
    s = np.repeat([0.02 + 0.01j, -0.01 + 0.03j, 0.03j], 3000)
    place = np.random.default_rng(1).uniform(-0.5, 0.5, (len(s), 2)) * (1, 1)
    direction = np.column_stack((s.real, s.imag, np.ones(len(s))))
    rays = trace(np.column_stack((place, np.full(len(s), -3.0))), direction, lens.glass, 3.0)
    slope = (rays.direction[:, 0] + 1j * rays.direction[:, 1]) / rays.direction[:, 2]
    for value in np.unique(s):
        assert abs(slope[rays.designed & (s == value)].mean() - law.slope(value)) < 2e-3
    assert lens.rotates == (values["ratio"] == 1) and rays.designed.mean() > 0.2
