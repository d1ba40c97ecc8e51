"""Bundles of rays through all that a scene can have: ends, spots, where pencils converge; and wrong units."""

import tracemalloc

import numpy as np
import pytest
from conftest import refusal

from povgen import Bundle, Chess, Spheres
from povgen.optics import rays, series
from povgen.optics.shares import shares
from povgen.optics.trace import End
from povgen.scene import camera
from povgen.sheets import IDEAL

WINDOWS = [
    {"sheet": "detailed"},
    {"sheet": "single", "prisms": 30},
    {"sheet": "ideal", "alpha": 50, "window": ["alpha=75,z=2", "sheet=lens,focal_length=5,z=3"], "z2": 8},
    {"sheet": "ideal", "alpha": 50, "window": "alpha=75,z=2,sheet=detailed", "z2": 8},
    *({"sheet": kind.name, **values} for kind in IDEAL.values() for values in kind.examples),
]


@pytest.mark.parametrize("values", WINDOWS, ids=lambda values: f"{values['sheet']}-{len(values)}")
def test_light_takes_the_path_of_the_cameras_rays(values):
    scene = Chess(**values, eye=(0.3, -0.2))
    rays = scene.rays((40, 30))
    there = scene.trace(rays)
    assert there.shape == (30, 40) and there.designed.sum() > 100
    leaving = there[there.designed]
    back = scene.trace(Bundle(leaving.position, -leaving.direction))
    assert back.designed.all()
    np.testing.assert_allclose(back.at(-scene.z2), scene.E, atol=1e-9)
    np.testing.assert_allclose(back.direction, -rays[there.designed].direction, atol=1e-9)


def test_a_ray_for_each_pixel():
    scene = Chess(sheet="none", eye=(0.5, -0.3), z2=5)
    rays = scene.rays((8, 6))
    assert (scene.rays("8x6").direction == rays.direction).all()
    np.testing.assert_allclose(rays.at(0), scene.camera.pixels((8, 6)))
    np.testing.assert_allclose(np.linalg.norm(rays.direction, axis=-1), 1)
    assert (rays.position == (0.5, -0.3, -5)).all()
    inside, direction = camera.rays(scene, (8, 6))
    assert (rays.direction[inside] == direction).all()


def test_a_spot_is_that_of_its_pencil():
    """Also if its rays are traced in several parts."""
    scene = Chess(sheet="lens")
    light = scene.trace(scene.pencil((0.1, 0, 5), rays.CHUNK + 9, seed=4))
    spot = scene.spot((0.1, 0, 5), 2, rays.CHUNK + 9, seed=4)
    assert np.allclose(spot.points, light[light.designed].at(2))


def test_a_bundle_keeps_its_own_numbers():
    start, along = np.zeros((2, 3)) - (0, 0, 3), np.ones((2, 3))
    bundle = Bundle(start, along)
    start[0], along[0] = 9, 9
    assert (bundle.position == (0, 0, -3)).all() and bundle.direction[0] == pytest.approx(bundle.direction[1])
    pixels = Chess().rays((4, 4))
    pixels.position[0, 0, 0] = 1
    assert pixels.position[..., 0].sum() == 1
    for bundle, same in ((pixels, pixels[:]), (Chess().trace(pixels), Chess().trace(pixels))):
        assert bundle == same and bundle != Chess(alpha=1).trace(pixels) and bundle != bundle[:3] and bundle != 3
        assert len(bundle) == 4 and repr(bundle[:3]) == str(bundle[:3]) == f"<{type(bundle).__name__}: 3 x 4 rays>"


@pytest.mark.filterwarnings("error")
def test_one_ray_and_no_rays():
    for scene in (Chess(), Chess(sheet="ideal")):
        one = scene.trace(Bundle((0.1, 0.02, -5), (0, 0.1, 1)))
        assert one.shape == () and one.designed == scene.trace(Bundle([(0.1, 0.02, -5)], (0, 0.1, 1))).designed[0]
    none = Chess().spot((0, 0, 3), 3, count=1, middle=1.49 + 1.49j, radius=1e-9)  # it meets the frame
    assert none.share == 0 and np.isnan(none.rms) and np.isnan(none.centre)
    assert none == Chess().spot((0, 0, 3), 3, count=1, middle=1.49 + 1.49j, radius=1e-9) and len(none) == 0
    some = Chess().spot((0, 0, 3), 3, count=20)
    assert some != none and repr(some) == f"<Spot: {len(some.points)} points at z = 3, rms {some.rms:.3g} tiles>"


def test_how_rays_end():
    scene = Chess(sheet="refraction", ratio=0.3, window="sheet=none,z=8", z2=4)
    targets = np.array([0.1, 0.6, 1.4, 2.0])  # straight on; beside window 2; totally reflected; beside both
    found = scene.trace(Bundle((0, 0, -4), np.column_stack((targets, 0 * targets, 0 * targets + 4))))
    assert [*found.end] == [End.THROUGH, End.BESIDE, End.BLOCKED, End.BESIDE]
    assert [*found.designed] == [True, False, False, False] and not found.faces.size
    share = shares(found)
    assert (share.designed, share.beside, share.blocked, share.frame) == (0.25, 0.5, 0.25, 0)
    oblique = scene.trace(Bundle((-6.4, 0, -4), [[1.52 + 6.4, 0, 4], [1.3 + 6.4, 0, 4]]))  # meets the frame's inside
    assert [*oblique.end] == [End.FRAME, End.BLOCKED]


@pytest.mark.parametrize("values", [{"sheet": "none"}, {"sheet": "ideal", "alpha": 0}, {"prisms": 1000}])
@pytest.mark.parametrize("side", [1, -1])
def test_light_may_start_inside_the_frame(values, side):
    """Such a ray is not extended backwards. In front of the opening it would be beside the window."""
    scene = Chess(**values)
    start = 0.8 * side * scene.depth / 2
    found = scene.trace(Bundle((1.4, 0, start), [[-1, 0, -0.2 * side], [1, 0, -0.5 * side]]))
    assert found.end[0] != End.FRAME == found.end[1]
    if "sheet" in values:
        assert found.end[0] == End.THROUGH and found.at(0.0)[0] == pytest.approx(1.4 - abs(start) / 0.2)


@pytest.mark.filterwarnings("error")
def test_light_for_which_a_law_has_no_inverse_is_blocked_without_a_warning():
    scene = Chess(sheet="law", law="0, 0, 1")
    assert [*scene.trace(Bundle((0, 0, 3), [[0.1, 0, -1], [0, 0, -1]])).end] == [End.BLOCKED, End.THROUGH]


@pytest.mark.parametrize(("degrees", "ratio"), [(70, 0.7), (86, 0.2), (89, 0.99), (89.8, 0.1)])
def test_light_that_is_nearly_parallel_to_the_sheet_passes(degrees, ratio, rng):
    """By Snell's law it leaves at an angle whose sine is `ratio` times as large."""
    around = np.exp(1j * rng.uniform(-np.pi, np.pi, 40))
    slope = np.tan(np.radians(degrees)) * around
    way = np.column_stack((slope.real, slope.imag, np.ones(40)))
    light = Chess(sheet="refraction", alpha=0, ratio=ratio).trace(Bundle(1e-3 * way, -way))  # from inside the frame
    assert (light.end == End.THROUGH).all()
    sine = ratio * np.sin(np.radians(degrees))
    np.testing.assert_allclose(light.slope, sine / np.sqrt(1 - sine**2) * around, rtol=1e-9)


@pytest.mark.parametrize(("ratio", "alpha"), [(0.7, 0), (0.2, 0), (0.1, 30)])
def test_the_eye_sees_what_stands_far_aside_behind_a_refracting_sheet(ratio, alpha, rng):
    """Light up to 86 degrees from the normal, where the sheet's slope grows steeply with that of the eye's ray."""
    scene = Chess(sheet="refraction", alpha=alpha, ratio=ratio, z1=0.6, z2=6, eye=(0.2, 0.1))
    sine = ratio * np.sin(np.radians(rng.uniform(60, 86, 200)))
    slope = sine / np.sqrt(1 - sine**2) * np.exp(1j * rng.uniform(-np.pi, np.pi, 200))
    P = 0.2 + 0.1j + scene.z2 * slope
    L = P + scene.z1 * scene.sheets[0].slope(slope, P)
    np.testing.assert_allclose(scene.apparent_position(L, scene.z1), P, rtol=1e-8)


@pytest.mark.parametrize("alpha", [0, 40, 66, 180, -100])
def test_where_a_pencil_converges(alpha):
    """At the distance Re W, and at |Im W| times the spread of the slopes: see optics/series.py."""
    scene, z1 = Chess(sheet="ideal", alpha=alpha), 2
    light = scene.trace(scene.pencil((0.1, -0.2, z1), 500, middle=0.3j, radius=0.5))
    W = series.image_depth(z1, np.radians(alpha))
    seen = light.convergence()
    assert light.designed.all() and seen.z == pytest.approx(W.real, abs=1e-12)
    spread = np.sqrt((abs(light.slope - light.slope.mean()) ** 2).mean())
    assert seen.rms == pytest.approx(abs(W.imag) * spread, abs=1e-12)
    if alpha in (0, 180):
        assert (seen.x, seen.y) == pytest.approx((0.1, -0.2), abs=1e-12)
    for z in (seen.z - 0.1, seen.z + 0.1):
        assert scene.spot((0.1, -0.2, z1), z, 500, 0.3j, 0.5).rms > seen.rms


@pytest.mark.parametrize("sheet", ["ideal", "detailed"])
def test_some_of_the_rays_are_those_that_numpy_takes(sheet):
    """Also if the last axis of the rays has the length of a vector."""
    scene = Chess(sheet=sheet)
    for every in (scene.rays((3, 4)), scene.trace(scene.rays((3, 4)))):
        for which in (0, (..., 0), (slice(None), [0, 2]), every.slope.real > 0, []):
            some = every[which]
            np.testing.assert_allclose(some.slope, every.slope[which], rtol=1e-15)
            assert some.shape == every.slope[which].shape and some.position.shape == (*some.shape, 3)
        with pytest.raises(IndexError):
            every[0, 0, 0]


def test_a_lens_makes_parallel_rays_of_its_focus():
    scene = Chess(sheet="lens", focal_length=4)
    light = scene.trace(scene.pencil((0, 0, 4), 100))
    assert light.convergence().z == np.inf and light.convergence().rms > 0.5
    assert scene.trace(scene.pencil((0, 0, -6), 100)).convergence().z == pytest.approx(12)  # 1/6 + 1/12 = 1/4


@pytest.mark.parametrize(
    "sheet", [{"sheet": "ideal", "alpha": 66}, {"sheet": "law", "law": "x+0.3*z, y, z"}, {"sheet": "lenslets"}]
)
@pytest.mark.parametrize("slope", [0, 4 - 3j])
@pytest.mark.parametrize("way", [1, -1])
def test_parallel_rays_stay_parallel_however_steep(sheet, slope, way, rng):
    """Rays towards the eye are bent by a search, which is less exact."""
    middle = np.column_stack((rng.uniform(-0.5, 0.5, (200, 2)), np.zeros(200)))
    direction = np.array([complex(slope).real, complex(slope).imag, 1.0])
    light = Chess(**sheet).trace(Bundle(middle - 6 * way * direction, way * direction))
    assert light.designed.all() and light.convergence().z == np.inf


def test_no_rays_have_no_spot():
    scene = Chess(sheet="ideal")
    for call in (
        lambda: rays.spot([scene.trace(rays.joined([]))], 1),
        lambda: rays.spot([], 1),
        lambda: shares(scene.trace(rays.joined([]))),
    ):
        with pytest.raises(ValueError, match="0 rays; allowed: one or more"):
            call()
    with pytest.raises(ValueError, match="1 rays; allowed: two or more"):
        scene.pencil((0, 0, 2), 1).convergence()


def test_a_spot_through_prisms_shrinks_with_them():
    spots = [Chess(alpha=180, prisms=N).spot((0.1, 0.2, 2), -2, 2000, 0.1, 0.4) for N in (50, 100, 200)]
    sizes = np.array([spot.rms for spot in spots])
    assert np.log2(sizes[:-1] / sizes[1:]) == pytest.approx(1, abs=0.25)
    assert abs(spots[-1].centre - (0.1 + 0.2j)) < 0.02 and 0.4 < spots[-1].share < 0.8
    stray = Chess(alpha=180, prisms=200).spot((0.1, 0.2, 2), -2, 2000, 0.1, 0.4, stray=True)
    assert stray.share > spots[-1].share + 0.05 and stray.rms > 3 * spots[-1].rms


def test_the_memory_of_a_spot_is_that_of_its_points():
    scene, peaks = Spheres(sheet="ideal"), []
    for count in (80_000, 240_000):
        tracemalloc.start()
        spot = scene.spot((0, 0, -6), 5, count, radius=0.5)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert len(spot.points) == count and spot.share == 1
    assert peaks[1] - peaks[0] < 80 * 160_000  # bytes; all rays at once would need more than 160 a ray


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: s.rays("16384x16384"), "size = 16384x16384: allowed: up to 40000000 rays at once"),
        (lambda s: s.pencil((0, 0, 2e6)), "in tiles"),  # micrometres
        (lambda s: s.pencil((0, 0, 0)), "between the windows; allowed: z < 0 or z > 0"),
        (lambda s: s.pencil((0, 0, 2), 10**9), "count = 1000000000: allowed: a whole number from 1 to 40000000"),
        (lambda s: s.pencil((0, 0, 2), radius=0), "radius = 0"),
        (lambda s: s.spot((0, 0, 2), 2, 10**9), "count = 1000000000: allowed: a whole number from 1 to 100000000"),
        (lambda s: s.spot((0, 0, 3), np.inf), "z = inf: allowed: a finite number"),
        (lambda s: s.trace(np.zeros((3, 3))), "rays: ndarray; allowed: a Bundle"),
        (lambda s: s.trace(s.pencil((0, 0, 2)), partial=3), "partial = 3: allowed: a numpy.random.Generator"),
        (lambda s: s.trace(s.pencil((0, 0, 2)), max_faces=0), "max_faces = 0"),
        (lambda s: s.trace(Bundle((0, 0, 0), (0, 0, 1))), "ray 0 from"),  # in glass
        (lambda s: s.apparent_position(0.5, 2, alpha=90 + 1j), "alpha is complex; allowed: real numbers"),
        (lambda s: s.nu_and_M([1, np.inf]), "z1 = inf; allowed: finite"),
        (lambda s: s.visible(0.5, 2, near=-1), "near = -1; allowed: 0 or more"),
    ],
)
def test_wrong_values_are_refused(call, words):
    assert words in refusal(lambda: call(Chess(sheet="detailed", prisms=20)))


@pytest.mark.parametrize(
    ("position", "direction", "words"),
    [
        ((0, 0, -6), (0, 0), "direction: an array of the shape (2,); allowed: (..., 3)"),
        ((0, 0, -6), (0, 0, 0), "direction: 0, 0, 0; allowed: a direction with a length"),
        ((0, 0, np.nan), (1, 0, 1), "position: not finite"),
        ((0, 0, 1j), (0, 0, 1), "position: allowed: an array of real numbers"),
        (np.zeros((2, 3)), np.ones((3, 3)), "position and direction: the shapes (2, 3) and (3, 3) do not broadcast"),
    ],
)
def test_bundles_that_cannot_be_are_refused(position, direction, words):
    assert words in refusal(lambda: Bundle(position, direction), ValueError)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("sheet", ["ideal", "detailed", "none", "lens", "refraction", "twist", "lenticular"])
def test_positions_broadcast_and_what_is_infinitely_far_aside_is_unknown(sheet):
    scene = Chess(sheet=sheet)
    for L in (np.inf, -np.inf * 1j, np.nan):
        position, visible = scene.seen(L, 2)
        assert np.isnan(position) and not visible and scene.ghosts(L, 2) == []
    for alpha, near, shape in (([10, 20], 0, (3, 2)), (None, [0, 0.1], (3, 2)), ([], 0, (3, 0)), (5, 0, (3, 1))):
        assert scene.apparent_position(np.zeros((3, 1)), 2, alpha, near).shape == shape
        assert [x.shape for x in scene.seen(np.zeros((3, 1)), 2, alpha, near)] == [shape, shape]
    assert np.shape(scene.apparent_position(0, 2)) == ()
    P = scene.apparent_position(0.1, [np.nan, 2])
    assert np.isnan(P[0]) and np.isfinite(P[1])
    assert np.isnan(scene.apparent_position(0.2, 2, [30, np.inf])[1]) == (sheet not in ("none", "lens"))
