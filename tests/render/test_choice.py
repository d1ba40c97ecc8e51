"""`--sheet auto`: the choice keeps the tolerance, and the next cheaper candidate does not. Both are rendered."""

import csv
import sys

import numpy as np
import pytest
from conftest import PROJECT, povgen, refused
from PIL import Image
from references import KEPT, converged, rendered

from povgen import Chess, Rendering, Spheres, cheapest, render, to_pov
from povgen.errors import InputError, PovrayError
from povgen.inputs.pieces import PieceFile
from povgen.measure import speed
from povgen.measure.probes import APERTURE, VIEW
from povgen.rendering import gl_runner, povray
from povgen.rendering.auto import GL_PRISM_SAMPLINGS, IDEAL_SAMPLINGS, PRISM_SAMPLINGS, RENDERERS, Tolerance, choose
from povgen.settings import QUALITIES

CHART = PROJECT / "docs" / "chart" / "frames.csv"
SIZE = (240, 180)  # of the pictures in which positions are found
STANDARD = Rendering(size=(320, 240))
SMALL = Rendering(size=(160, 120))
PROBED = {"aperture": APERTURE, "view": VIEW}  # as in the probes
LADDER = [
    *(("ideal", sampling) for sampling in IDEAL_SAMPLINGS),
    *(("detailed", sampling) for sampling in PRISM_SAMPLINGS),
]


def picture_error(scene, sheet, antialias):
    """Mean FLIP of a picture, rendered, against the converged one through the scene's prisms."""
    text = to_pov(scene.model_copy(update={"sheet": sheet}))
    return speed.picture_error(speed.sample(text, antialias, SMALL.size)[1], converged(scene, SMALL.size), scene)[1]


@pytest.mark.release
@pytest.mark.parametrize("scene", KEPT)
def test_kept_pictures_are_those_that_povray_renders(scene):
    """If a scene looks otherwise now: `python tests/references.py` renders them again."""
    size = KEPT[scene]
    assert abs(converged(scene, size).astype(float) - rendered(scene, size)).mean() < 0.5


def test_the_cheapest_sheet_that_keeps_positions_is_chosen():
    for scene, tolerance, sheet in (
        (Chess(**PROBED), 0.8, "detailed"),
        (Chess(**PROBED), 4, "ideal"),
        (Chess(prisms=1000, **PROBED), 0.8, "ideal"),
        (Chess(alpha=0, **PROBED), 4, "none"),
    ):
        assert choose([scene], STANDARD, Tolerance(px=tolerance))[0].sheet == sheet, scene
    tall, narrow = Chess(alpha=90, prisms=300, z1=3), Rendering(size=(60, 96))  # whose default view is higher
    found = [choose([each], narrow, Tolerance(px=4))[0].px for each in (tall, tall.fitted((60, 96)))]
    assert found[0] == found[1] > 0


@pytest.mark.release
@pytest.mark.parametrize(
    ("scene", "tolerance"),
    [
        (Chess(), 0.09),
        (Chess(alpha=175, prisms=138, z1=2.7, piece="pawn"), 0.28),  # prisms and pixels make moire
        (Chess(z2=3, prisms=50), 0.35),  # more stray light, which the ideal sheet does not show
    ],
    ids=str,
)
def test_only_the_choice_keeps_the_picture(scene, tolerance):
    chosen, _ = choose([scene], SMALL, Tolerance(flip=tolerance))
    error = picture_error(scene, chosen.sheet, chosen.antialias)
    assert error <= tolerance and abs(chosen.flip - error) < 0.2 * error
    place = LADDER.index((chosen.sheet, chosen.antialias))
    assert not place or picture_error(scene, *LADDER[place - 1]) > tolerance


def test_a_movie_gets_one_choice_that_holds_in_every_frame():
    scenes = [Chess(alpha=alpha, **PROBED) for alpha in (0, 90, 180)]
    chosen, why = choose(scenes, STANDARD, Tolerance(px=3.5))
    alone = [choose([scene], STANDARD, Tolerance(px=3.5))[0].px for scene in scenes]
    assert chosen.sheet == "ideal" and chosen.px == max(alone) > min(alone)
    assert chosen.sheet in why and chosen.antialias in why
    spheres, _ = choose([Spheres()], STANDARD, Tolerance(px=0.01))
    assert spheres.sheet == "detailed"


@pytest.mark.parametrize("sampling", ["1.5x", pytest.param("3x", marks=pytest.mark.release)])
def test_the_error_of_a_reduced_picture_is_estimated(sampling):
    """From blocks that are reduced one by one."""
    chosen, _ = choose([Chess(alpha=150, z2=9)], SMALL, Tolerance(px=0.01, flip=0.9), sampling)
    error = picture_error(Chess(alpha=150, z2=9), chosen.sheet, sampling)
    assert chosen.antialias == sampling and abs(chosen.flip - error) < 0.25 * error


@pytest.mark.parametrize("tolerance", [0.25, pytest.param(0.12, marks=pytest.mark.release)])
def test_the_renderer_is_chosen_too(tolerance, monkeypatch):
    """POV-Ray, which takes longer, renders nothing for this."""
    with monkeypatch.context() as patch:
        patch.setattr(povray.Runner, "run", lambda *_: pytest.fail("POV-Ray was started"))
        chosen, why = choose([Chess()], SMALL, Tolerance(flip=tolerance), renderers=RENDERERS)

    def error(antialias):
        picture = render(Chess(), renderer="gl", size=SMALL.size, antialias=antialias)
        return speed.picture_error(picture, converged(Chess(), SMALL.size), Chess())[1]

    assert (chosen.renderer, chosen.sheet) == ("gl", "detailed") and why.startswith("renderer gl, sheet detailed, ")
    found = error(chosen.antialias)
    assert found <= tolerance and abs(chosen.flip - found) < 0.2 * found
    place = GL_PRISM_SAMPLINGS.index(chosen.antialias)
    assert not place or error(GL_PRISM_SAMPLINGS[place - 1]) > tolerance


def test_the_choice_in_python(monkeypatch):
    scene, options = cheapest(Chess(prisms=300), "2px", size=(160, 120), antialias="off")
    assert (scene.sheet, options) == ("ideal", {"size": (160, 120), "antialias": "off", "renderer": "povray"})
    assert cheapest(Chess(sheet="ideal"), "0.001px", antialias=(1, 0.3, 2))[0].sheet == "detailed"
    assert cheapest(Chess(alpha=0), "5px", quality="draft")[0].sheet == "none"
    movie, options = cheapest([Chess(prisms=1000, alpha=alpha) for alpha in (0, 66)], "2px")  # as the command does
    assert [scene.sheet for scene in movie] == ["ideal", "ideal"] and options["antialias"] == "off"
    monkeypatch.setattr("povgen.rendering.auto._gl_can_draw", lambda *_: True)
    assert cheapest(Chess(), "5px", renderer="auto")[1] == {"antialias": "off", "renderer": "gl"}
    monkeypatch.setattr("povgen.rendering.auto._gl_can_draw", lambda *_: False)
    assert cheapest(Chess(), "5px", renderer="auto")[1]["renderer"] == "povray"
    with pytest.raises(InputError, match="tolerance = '1': not a tolerance"):
        cheapest(Chess(), "1")


def test_a_trial_keeps_the_time_limit():
    with pytest.raises(PovrayError, match="took longer than 0.01 s"):
        cheapest(Chess(), "0.2flip", size=SMALL.size, timeout=0.01)


def test_povray_is_chosen_where_gl_cannot_draw(monkeypatch):
    def renderer(**values):
        return choose([Chess(**values)], SMALL, Tolerance(px=0.01), renderers=RENDERERS)[0].renderer

    assert renderer() == "gl" and renderer(fresnel=True) == "povray"
    flat = PieceFile("flat.inc", "#declare Piece = polygon { 4, 0.3*x, 0.3*y, -0.3*x, 0.3*x };")
    assert renderer(piece=flat) == "povray"
    with monkeypatch.context() as patch:
        patch.setattr(gl_runner, "find_spec", lambda _: None)  # moderngl is not installed
        gl_runner.device.cache_clear()
        assert renderer() == "povray"
    gl_runner.device.cache_clear()


def test_flip_is_needed_for_pictures_alone(monkeypatch):
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    with pytest.raises(InputError, match=r"install .*\[charts\]"):
        choose([Chess()], SMALL, Tolerance(flip=0.2))
    assert choose([Chess()], SMALL, Tolerance(px=0.1))[0].sheet == "detailed"


def test_the_command(tmp_path):
    arguments = ["frame", "chess", "--sheet", "auto", "--tolerance", "9px", "--size", "64x48"]
    status, _, errors = povgen(arguments, tmp_path)
    assert status == 0 and errors.startswith("povgen: sheet ideal, antialias ")
    assert len(errors.splitlines()) == 1 and (tmp_path / "frame.png").is_file()
    status, _, errors = povgen([*arguments, "--renderer", "auto"], tmp_path)
    assert status == 0 and errors.startswith("povgen: renderer gl, sheet ideal, antialias off")
    with Image.open(tmp_path / "frame.png") as picture:
        own = render(Chess(sheet="ideal"), renderer="gl", size=(64, 48), antialias="off")
        assert (np.asarray(picture) == own).all()
    for arguments, word in (
        (["frame", "chess", "--renderer", "auto"], "with --sheet auto"),
        (["frame", "chess", "--sheet", "auto"], "--tolerance"),
        (["frame", "chess", "--tolerance", "1px"], "--sheet auto"),
        (["frame", "chess", "--sheet", "auto", "--tolerance", "0.0001flip", "--size", "32x32"], "nearest"),
        (["frame", "chess", "--sheet", "auto", "--tolerance", "1px", "--antialias", "3,0.77,1"], "antialias"),
    ):
        assert word in refused(arguments, tmp_path)


def test_qualities_lie_on_the_pareto_front():
    """No sampling that was measured costs less and has a smaller error, by RMS or by FLIP.

    Costs that differ by less than 15 % count as equal: this is the noise (docs/speed.md).
    """
    table = [row for row in csv.DictReader(CHART.open()) if row["height"] == "240"]
    for method in ("detailed", "ideal"):
        rows = [row for row in table if row["method"] == method]
        for quality in QUALITIES:
            sampling = Rendering(quality=quality).suited(prisms=method == "detailed").sampling
            (own,) = (row for row in rows if row["antialias"] == sampling)
            cheaper = [row for row in rows if float(row["CPU s"]) < 0.85 * float(own["CPU s"])]
            assert any(all(float(row[error]) > float(own[error]) for row in cheaper) for error in ("RMS", "FLIP")), own
