"""Several windows in a scene: what they may be, what the eye sees through them, and sweeps of their numbers."""

import numpy as np
import pytest
from conftest import refusal

from povgen import Chess, InputError, MovieSpec, Spheres, limits, to_pov
from povgen.liveview.values import values as live_values
from povgen.measure import probes
from povgen.optics import apparent, series, trace
from povgen.scene import survey
from povgen.scene.scene import is_empty
from povgen.scene.windows import FurtherWindow
from povgen.settings import Rendering
from povgen.sheets import OTHER
from povgen.video import caption_texts, overlay, piece_outline

TWO = {"alpha": 120, "window": [{"alpha": 120, "z": 2}], "z2": 8}
MIXED = {"sheet": "ideal", "window": ["alpha=-30,z=1.5", "alpha=70,z=3,sheet=detailed"]}


def test_a_window_is_text_a_table_or_a_window():
    for window in ("alpha=-50,z=2", " z = 2, alpha = -50", {"alpha": -50, "z": 2}, FurtherWindow(alpha=-50, z=2)):
        for given in (window, [window]):
            scene = Chess(window=given)
            assert scene.window == (FurtherWindow(alpha=-50, z=2),)
            assert (scene.alphas, scene.places, scene.behind) == ((66, -50), (0, 2), ((2, pytest.approx(-0.872665)),))
    assert [sheet.name for sheet in Chess(**MIXED).sheets] == ["ideal", "ideal", "detailed"]
    assert len(Chess(**MIXED).ideal) == 2 and is_empty(Chess(sheet="none", window="z=1,alpha=3"))


def test_a_windows_text_can_have_several_numbers_of_a_table():
    scene = Chess(sheet="none", window="z=1,sheet=law,law=k*x,m*y,z,parameter=k=2,parameter=m=3")
    assert scene.window[0].parameter == {"k": 2, "m": 3}
    for text in ("z=1,z=2", "z=1,parameter=k=1,parameter=k=2", "z=1,alpha=3,alpha=3"):
        with pytest.raises(InputError):
            Chess(sheet="none", window=text)


def test_windows_have_parameters_of_their_own():
    """What a window does not state is that of the first one."""
    given = [
        "z=1,sheet=lenslets,ratio=0.5",
        "z=2,sheet=axis,axis=0,1,0.5,alpha=9",
        "z=3,sheet=law,law=x,y,z*k,parameter=k=2",
    ]
    scene = Chess(sheet="refraction", ratio=0.8, alpha=20, window=given)
    assert [(z, sheet.name, dict(sheet.values)) for z, sheet in zip(scene.places, scene.sheets, strict=True)] == [
        (0, "refraction", {"alpha": 20, "ratio": 0.8}),
        (1, "lenslets", {"alpha": 20, "ratio": 0.5}),
        (2, "axis", {"alpha": 9, "axis": (0, 1, 0.5)}),
        (3, "law", {"law": "x,y,z*k", "parameter": {"k": 2}}),
    ]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"window": "alpha=120"}, "window = 'alpha=120': z: missing (distance from the first window"),
        ({"window": "alpha=1,z=0.3"}, "window 2, z = 0.3: its frame would touch that of the window before, at z = 0"),
        ({"window": [f"alpha=1,z={n}" for n in range(1, 6)]}, "should have at most 4 values"),
        (
            {"window": "z=90,index=4,base_angle=75,aspect=1.9,prisms=1", "aperture": 9, "z2": 100},
            "window 2, prisms = 1: with this shape of the prisms",
        ),
        ({"window": "alpha=1,z=2,sheet=ideal"}, "window: prisms or lenses stand in front of an ideal sheet"),
        ({"sheet": "ideal", "window": "z=90", "z1": 4950}, "z1 = 4950: beyond POV-Ray's range behind z = 90; allowed"),
    ],
)
def test_windows_that_cannot_be_are_refused(values, words):
    assert words in refusal(lambda: Chess(**values))


@pytest.mark.parametrize("sheet", ["ideal", "none"])
def test_predictions_follow_the_light_through_all_windows(sheet, rng):
    seen = count = 0
    for _ in range(20):
        windows = [
            {"alpha": rng.uniform(-180, 180), "z": z} for z in np.cumsum(rng.uniform(0.5, 3, rng.integers(1, 5)))
        ]
        scene = Spheres(
            sheet=sheet, alpha=rng.uniform(-180, 180), window=windows, z1=3, z2=rng.uniform(2, 9), eye=(0.3, -0.2)
        )
        L = rng.uniform(-4, 4, (20, 2)) @ (1, 1j)
        P, visible = scene.seen(L, 3)
        rays = scene.trace(scene.camera.through(P))
        assert (visible == rays.designed).all()
        assert rays.at(scene.places[-1] + 3)[visible] == pytest.approx(L[visible], abs=1e-9)
        seen, count = seen + visible.sum(), count + len(L)
        nu, M = scene.nu_and_M(3)
        step = scene.apparent_position(L + 1e-6, 3) - P
        assert step / 1e-6 == pytest.approx(M * np.exp(1j * np.radians(nu)), rel=1e-5)
    assert 0.05 < seen / count < 0.95


@pytest.mark.parametrize(
    "values",
    [
        {},
        {
            "window": [
                "alpha=-50,z=1.5,prisms=90,index=1.7,base_angle=40,gap=0.05",
                "alpha=20,z=3,prisms=300,aspect=1.1",
            ]
        },
        {"window": "sheet=single,z=1"},
        {"sheet": "ideal", "window": "alpha=75,z=2,prisms=200,sheet=detailed"},
    ],
    ids=["one", "of other shapes", "a single sheet", "behind an ideal window"],
)
def test_what_the_exact_trace_shows_is_visible(rng, values):
    scene = probes.Directions(**{"sheet": "detailed", "prisms": 200, "alpha": 120, "z2": 8, **values})
    P = rng.uniform(-1.2, 1.2, 4000) + 1j * rng.uniform(-1.2, 1.2, 4000)
    rays = scene.trace(scene.camera.through(P))
    on = rays.designed
    L = rays.at(scene.places[-1] + 3)[on]
    assert 500 < on.sum() and scene.visible(L, 3).mean() > 0.95
    pitch = max(sheet.pitch for sheet in scene.layered)
    assert np.sqrt((abs(scene.apparent_position(L, 3) - P[on]) ** 2).mean()) < 2 * pitch


def test_captions_and_curves_are_of_all_windows():
    scene = Chess(sheet="ideal", **TWO)
    facts = caption_texts.facts(scene)
    assert facts == {
        "alpha": "120° in each window",
        "z": "0, 2 tiles",
        "z1": "2 tiles",
        "z2": "8 tiles",
        "nu": "0.0°",
        "M": "1.33",
    }
    ((parts, colour),) = overlay.loci(scene)
    assert colour == overlay.ALPHA_COLOUR and len(overlay.legend(scene, Rendering(overlay=True))) == 3
    curve = np.concatenate(parts)
    assert abs(curve - overlay.positions(scene)[0]).min() < 0.01  # the blue curve runs through the yellow dot
    assert caption_texts.facts(scene.replace(alpha=60))["alpha"] == "60°, 120°"


def rays_to(scene, number, count, rng):
    """Rays from the eye to a window (0: the first)."""
    half = scene.aperture / 2
    thin = [(distance, sheet.thin) for (distance, _), sheet in zip(scene.elements, scene.sheets, strict=True)]

    def crossed(slope):
        return np.array([place for place, *_ in apparent.follow(slope, scene.E, thin)])

    there = rng.uniform(-half, half, count) + 1j * rng.uniform(-half, half, count)
    P = crossed((there - scene.E) / (crossed(1)[number] - scene.E))
    P = P[:, (np.maximum(abs(P[: number + 1].real), abs(P[: number + 1].imag)) < half).all(0)]
    return scene.camera.through(P[0])


FAR = "alpha=66,z=25,sheet=detailed"


@pytest.mark.parametrize(
    ("values", "seen"),
    [
        ({"alpha": 50, "window": "alpha=75,z=2"}, [0, 1]),
        ({"alpha": 80, "window": ["alpha=-80,z=3", FAR], "sheet": "ideal", "eye": (0.4, -0.3), "z2": 15}, [2]),
    ],
)
def test_the_trace_level_leaves_few_pixels_of_each_window_of_prisms_black(values, seen, rng):
    """Of the pixels that show this window. Few rays reach one that is far behind others."""
    scene = probes.Directions(**{"sheet": "detailed", **values})
    level = survey.max_trace_level(scene)
    assert level == live_values(scene)["faces"] > 3 * sum(sheet.layers for sheet in scene.sheets)
    for number in seen:
        found = scene.trace(rays_to(scene, number, 6000, rng), max_faces=255)
        reached = found.count > 0
        lost = (found.end != trace.End.FRAME) & (found.count >= level)
        assert reached.sum() > 1000 and lost.sum() / reached.sum() <= limits.MAX_LOST_FRACTION


def test_the_trace_level_never_cuts_the_designed_path():
    """Not even if no ray of the survey reaches the prisms, because no light passes another window."""
    hidden = Chess(sheet="axis", alpha=180, window="alpha=66,z=2,sheet=detailed")
    assert survey.survey(hidden) == survey.Survey(7, 0.0)
    aside = Chess(sheet="ideal", alpha=90, window="alpha=66,z=60,sheet=detailed", eye=(9, 0), z2=3)
    assert survey.survey(aside).trace_level > 20  # the eye sees the second window beside the first


HEAD = 'title = "A movie"\nscene = "chess"\nframes = 3\n'


def test_the_numbers_of_a_window_are_swept():
    tables = "[[window]]\nalpha = 120\nz = 2\n[[window]]\nalpha = 30\nz = 5\n"
    sweeps = '[[sweep]]\nparameter = "window2_z"\nstart = 1\nstop = 3\n'
    sweeps += '[[sweep]]\nparameter = "window3_alpha"\nstart = 0\nstop = 90\n'
    spec = MovieSpec.parse(HEAD + sweeps + tables, "a.toml")
    found = [[(window.alpha, window.z) for window in scene.window] for scene in spec.scenes("standard")]
    assert found == [[(120, 1), (0, 5)], [(120, 2), (45, 5)], [(120, 3), (90, 5)]]
    line = MovieSpec.of_sweeps("chess", ["window2-alpha=0:90"], {"frames": 2, "fixed": {"window": "alpha=1,z=2"}})
    assert [scene.window[0].alpha for scene in line.scenes("standard")] == [0, 90]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[window]]\nalpha = 1\n", "a.toml: window = {'alpha': 1}: z: missing"),
        (
            "[[window]]\nalpha = 1\nz = 2\n[fixed]\nwindow = 3\n",
            "window: stated twice, also in the table [fixed]; allowed: only",
        ),
        (
            "[[window]]\nalpha = 1\nz = 2\n[[window]]\nalpha = 1\nz = 2.5\n",
            "frame 3 of 3, window2_z = 3: window 3, z = 2.5",
        ),
    ],
)
def test_a_sweep_of_a_window_that_cannot_be_is_refused(text, words):
    sweep = '[[sweep]]\nparameter = "window2_z"\nstart = 1\nstop = 3\n'
    assert words in refusal(lambda: MovieSpec.parse(HEAD + sweep + text, "a.toml"))


def test_own_movies_of_windows_image():
    for scene in (*MovieSpec.load("imaging").scenes("draft"), MovieSpec.load("imaging-gap").scenes("standard")[0]):
        z1, W = series.imaged_plane(np.radians(scene.alpha), scene.behind)
        assert z1 == pytest.approx(scene.window[0].z) == pytest.approx(-W)
    gaps = [scene.window[0].z for scene in MovieSpec.load("imaging-gap").scenes("standard")]
    assert gaps[0] < 2 < gaps[-1] and 2 in gaps


def test_one_window_is_the_scene_as_it_is():
    for sheet in ("detailed", "ideal"):
        assert to_pov(Chess(sheet=sheet, window=[])) == to_pov(Chess(sheet=sheet))
        assert "Windows" not in to_pov(Chess(sheet=sheet)) and "Windows" in to_pov(Chess(sheet=sheet, **TWO))


def test_nu_and_M_where_nothing_is_turned():
    z1 = np.array([2.0, 3.0])
    nu, M = Chess(sheet="ideal", alpha=40, window="sheet=none,z=2").nu_and_M(z1)
    wanted = Chess(sheet="ideal", alpha=40).nu_and_M(2 + z1)
    assert nu == pytest.approx(wanted[0]) and M == pytest.approx(wanted[1])
    assert {"nu", "M"} < caption_texts.facts(Chess(sheet="ideal", window="sheet=none,z=2")).keys()
    nu, M = Chess(sheet="none", window="alpha=20,z=2").nu_and_M(z1)
    assert (nu == 0).all() and M == pytest.approx(6 / (8 + z1))
    for sheet in ("single", *OTHER):  # what an object looks like there is more than an angle and a size
        assert np.isnan(Chess(sheet=sheet).nu_and_M(z1)).all() and np.isnan(Chess(sheet=sheet).nu_and_M(2)).all()


@pytest.mark.parametrize(
    "windows", [{"alpha": 120, "window": "alpha=120,z=2", "z2": 2}, {"alpha": 180, "window": "alpha=0,z=2", "z2": 4}]
)
def test_a_predicted_image_at_the_pole_of_windows_is_refused(windows):
    with pytest.raises(InputError, match="the piece appears at infinity"):
        Chess(sheet="ideal", z1=2, predicted_image=True, **windows)
    assert Chess(sheet="ideal", z1=2.1, predicted_image=True, **windows)


def test_the_predicted_image_of_prisms_at_infinity_has_no_outline():
    """Prisms have their pole at another z1 than the ideal sheet. There an object is infinite in one direction only."""
    scene = Chess(alpha=180, prisms=20, z1=6, predicted_image=True)
    assert np.isfinite(scene.apparent_position(scene.L, 6))
    at = apparent.infinite_z1(scene.elements)[0]
    for z1 in (at, np.nextafter(at, 9)):
        try:
            beside = scene.replace(z1=z1, x=0.5)
        except InputError as error:
            assert "the piece appears at infinity" in str(error)
        else:
            assert not piece_outline.outlines(beside, 0.01).size


@pytest.mark.parametrize(("alpha", "second", "d", "z1", "z2"), [(120, 120, 2, 2, 2), (180, 0, 2, 2, 4)])
def test_the_pole_of_windows_in_series_is_infinite(alpha, second, d, z1, z2):
    """Z = 0: rounding errors of the sum are no answer. A little beside the pole the answer is finite."""
    scene = Chess(sheet="ideal", alpha=alpha, window=f"alpha={second},z={d}", z1=z1, z2=z2)
    nu, M = scene.nu_and_M(z1)
    assert np.isnan(nu) and np.isinf(M) and np.isinf(scene.apparent_position(scene.L, z1))
    assert scene.replace(z2=z2 + 1e-6).nu_and_M(z1)[1] == pytest.approx(z2 * 1e6, rel=1e-3)
