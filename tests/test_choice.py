"""`--sheet auto`: the choice is within the tolerance, and the next cheaper is not, both rendered and measured."""

import csv
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from povgen import Chess, Rendering, Spheres, rotation, speed, to_pov
from povgen.choice import MEASURED, Tolerance, candidates, choose
from povgen.errors import InputError
from povgen.instruments import Positions
from povgen.rendering import QUALITIES
from povgen.verify import located

pytestmark = pytest.mark.xdist_group("choice")  # what is costly is made once
POVGEN = Path(sys.executable).with_name("povgen")
SIZE = (320, 240)
PAPER = Rendering(size=SIZE)
SMALL = Rendering(size=(160, 120))


@cache
def converged(scene):
    return speed.sample(to_pov(scene), "1,0.001,6", SMALL.size)[1]


def picture_error(scene, candidate):
    """Mean FLIP of a candidate's picture, rendered, against the converged one through the scene's prisms."""
    text = to_pov(scene.model_copy(update={"sheet": candidate.sheet}))
    return speed.picture_error(speed.sample(text, candidate.antialias, SMALL.size)[1], converged(scene), scene)[1]


def position_error(scene, sheet):
    """How far a sheet shows what is at the scene's distances, and far off, from where the prisms do, pixels."""
    worst = 0.0
    for place in (0.7 + 0.7j, 0.1 - 0.8j):
        for z1 in (*scene.distances, 30.0):
            alpha = np.radians(scene.alpha)
            L = rotation.object_position(place, scene.E, z1, scene.z2, alpha)
            shared = dict(alpha=scene.alpha, z1=z1, z2=scene.z2, L=L, extent=0.3 / rotation.M(scene.z2 / z1, alpha))
            shown = [Positions(sheet=kind, prisms=scene.prisms, **shared) for kind in ("detailed", sheet)]
            (_, right), (_, seen) = located(shown, SIZE)
            worst = max(worst, abs(seen.place - right.place))
    return worst * SIZE[1] / scene.view_height


@pytest.mark.parametrize(
    ("scene", "tolerance", "sheet"),
    [
        (Chess(), 0.8, "detailed"),
        (Chess(), 4, "ideal"),
        (Chess(prisms=1000), 0.8, "ideal"),
        (Chess(alpha=0), 4, "none"),
    ],
    ids=str,
)
def test_only_the_choice_keeps_positions(scene, tolerance, sheet):
    chosen, _ = choose([scene], PAPER, Tolerance(px=tolerance))
    assert chosen.sheet == sheet
    assert position_error(scene, sheet) <= tolerance
    cheaper = [candidate.sheet for candidate in candidates([scene], PAPER) if candidate.cpu < chosen.cpu]
    for other in {"ideal": {"none"}, "detailed": {"none", "ideal"}, "none": set()}[sheet]:
        assert other in cheaper
        if other == "ideal":
            assert position_error(scene, other) > tolerance
        else:
            assert scene.alpha % 360  # light is not turned at all


@pytest.mark.parametrize(
    ("scene", "tolerance"),
    [
        *((Chess(), tolerance) for tolerance in (0.125, 0.1, 0.45)),
        *((Chess(alpha=150, z1=4, piece="rook"), tolerance) for tolerance in (0.125, 0.1, 0.45)),
        (Chess(alpha=180), 0.24),  # prisms that lie along the pixels' rows
        (Chess(z2=3), 0.52),  # more stray light
        (Chess(z2=3), 0.44),
    ],
    ids=str,
)
def test_only_the_choice_keeps_the_picture(scene, tolerance):
    chosen, _ = choose([scene], SMALL, Tolerance(flip=tolerance))
    assert picture_error(scene, chosen) <= tolerance
    ranked = candidates([scene], SMALL)
    cheaper = ranked[ranked.index(chosen) - 1]
    assert picture_error(scene, cheaper) > tolerance


def test_a_movie_gets_one_choice_that_holds_in_every_frame():
    scenes = [Chess(alpha=alpha) for alpha in (0, 90, 180)]
    chosen, why = choose(scenes, PAPER, Tolerance(px=3.5))
    alone = [next(c for c in candidates([scene], PAPER) if c.sheet == chosen.sheet) for scene in scenes]
    assert chosen.sheet == "ideal" and chosen.px == max(c.px for c in alone) > min(c.px for c in alone)
    assert chosen.sheet in why and chosen.antialias in why
    spheres, _ = choose([Spheres()], PAPER, Tolerance(px=0.01))
    assert spheres.sheet == "detailed"


@pytest.mark.parametrize(
    "text", ["1", "px", "-1px", "0px", "1px,2px", "1 mm", "nanpx", "1e3px", "", "1px,", "1px;rm", "٣px"]
)
def test_tolerances_that_are_none(text):
    with pytest.raises(InputError, match="1px,0.2flip"):
        Tolerance.parse(text)


def test_tolerances():
    assert Tolerance.parse("0.5px") == Tolerance(px=0.5)
    assert Tolerance.parse("2px, .1flip") == Tolerance(px=2, flip=0.1)


def test_the_command(tmp_path):
    def povgen(*arguments):
        return subprocess.run([POVGEN, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=100)

    done = povgen("frame", "chess", "--sheet", "auto", "--tolerance", "9px", "--size", "64x48")
    assert done.returncode == 0 and done.stderr.startswith("povgen: sheet ideal, antialias ")
    assert len(done.stderr.splitlines()) == 1 and (tmp_path / "frame.png").is_file()
    for arguments, word in (
        (["frame", "chess", "--sheet", "auto"], "--tolerance"),
        (["frame", "chess", "--tolerance", "1px"], "--sheet auto"),
        (["frame", "chess", "--sheet", "auto", "--tolerance", "0.0001flip"], "nearest"),
        (["frame", "chess", "--sheet", "auto", "--tolerance", "1px", "--antialias", "2,0.77,1"], "not measured"),
    ):
        done = povgen(*arguments)
        assert done.returncode == 2 and word in done.stderr and len(done.stderr.splitlines()) <= 2, done


def test_qualities_lie_on_the_front():
    """No sampling that was measured costs less and is nearer to right, by RMS or by FLIP."""
    rows = [row for row in csv.DictReader(MEASURED.open()) if row["method"] == "detailed" and row["height"] == "240"]
    for quality in ("draft", "paper", "high"):
        sampling = QUALITIES[quality]["antialias"]
        (own,) = (row for row in rows if row["antialias"] == sampling)
        cheaper = [row for row in rows if float(row["CPU s"]) < float(own["CPU s"]) and row["antialias"][:3] != "box"]
        assert any(all(float(row[error]) > float(own[error]) for row in cheaper) for error in ("RMS", "FLIP")), quality
