"""No more than a scene needs: every object of a .pov changes the picture."""

import re
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from povgen import Chess, Rendering, Spheres, to_pov
from povgen.rendering import frames, povray
from povgen.scene.models import PIECES

RENDERING = Rendering(size=(320, 240), antialias="off")
OBJECT = (
    r"sphere|cylinder|cone|torus|lathe|prism|box|object|plane|light_source|sky_sphere|blob|superellipsoid|mesh|union|merge|"
    r"intersection|difference"
)


def objects(text):
    """Where the objects of a scene's text begin and end, those within others too, and each line that makes a sheet."""
    code = re.sub(r"//.*", lambda comment: " " * len(comment[0]), text)
    for match in re.finditer(rf"\b({OBJECT})\s*\{{", code):
        depth, end = 1, match.end()
        while depth:
            depth += {"{": 1, "}": -1}.get(code[end], 0)
            end += 1
        if not re.search(r"(#declare|#macro)\s[^\n]*$", code[: match.start()]) and not code[
            : match.start()
        ].rstrip().endswith(("mesh_camera { 1 3", "clipped_by {", "bounded_by {")):
            yield match.start(), end
    for match in re.finditer(r"^ *(Sheet\((0|Alpha)|Through\(Lower|Past\(-Corner).*$", code, flags=re.M):
        yield match.span()


def picture(text):
    with tempfile.TemporaryDirectory() as folder:
        return frames.read_png(povray.run(text, RENDERING, Path(folder)))


def unneeded(scene):
    """The objects without which the picture is the same."""
    text = to_pov(scene)
    whole = picture(text)
    parts = list(objects(text))
    assert len(parts) > 5

    def matters(part):
        return (picture(text[: part[0]] + text[part[1] :]) != whole).any()

    with ThreadPoolExecutor(8) as pool:
        return [text[slice(*part)] for part, needed in zip(parts, pool.map(matters, parts), strict=True) if not needed]


@pytest.mark.parametrize("piece", PIECES)
def test_every_object_changes_the_picture(piece):
    assert not unneeded(Chess(sheet="none", piece=piece, z1=1))


@pytest.mark.parametrize(
    "scene",
    [
        Chess(),
        Spheres(sheet="single", z1=(1, 3)),
        Chess(sheet="ideal", predicted_image=True),
        Spheres(sheet="none", alpha=0, z1=(1, 3)),
        Spheres(sheet="ideal"),
    ],
    ids=lambda scene: f"{scene.name}-{scene.sheet}",
)
def test_every_object_changes_the_picture_through_sheets(scene):
    assert not unneeded(scene)


def test_an_object_that_is_not_needed_is_found():
    text = to_pov(Chess(sheet="none"))
    hidden = "sphere { Tile*<0, -50, 5>, 1 }"
    parts = [text[slice(*part)] for part in objects(text + hidden)] + [hidden]
    assert hidden in parts
    assert np.array_equal(picture(text + hidden), picture(text))
