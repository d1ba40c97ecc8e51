"""No object of a .pov is superfluous: each of them changes the picture."""

import re
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import pytest
from conftest import some

from povgen import Chess, Rendering, Spheres, to_pov
from povgen.rendering import frames, povray
from povgen.scene.pieces import PIECES

RENDERING = Rendering(size=(320, 240), antialias="off")
OBJECT = (
    r"sphere|cylinder|cone|torus|lathe|prism|box|object|plane|light_source|sky_sphere|mesh|union|merge|"
    r"intersection|difference"
)


def objects(text):
    """Return where each object of a scene's text begins and ends, and each line of the ideal sheet's camera mesh.

    Objects inside other objects count. The object that a macro returns does not: without it the text has an error.
    """
    code = re.sub(r"//.*", lambda comment: " " * len(comment[0]), text)
    macros = [match.span() for match in re.finditer(r"#macro \w+\(.*?^#end", code, flags=re.M | re.S)]
    found = []
    for match in re.finditer(rf"\b({OBJECT})\s*\{{", code):
        depth, end = 1, match.end()
        while depth:
            depth += {"{": 1, "}": -1}.get(code[end], 0)
            end += 1
        before = code[: match.start()]
        macro = next((start for start, stop in macros if start < match.start() < stop), None)
        returned = macro is not None and before[macro:].count("{") == before[macro:].count("}")
        declared = re.search(r"#declare\s[^\n]*$", before)
        part = before.rstrip().endswith(("mesh_camera { 1 3", "clipped_by {"))
        if not (returned or declared or part):
            found.append((match.start(), end))
    return found + [
        match.span() for match in re.finditer(r"^ *Cells(In|Outside)Window\((-?(Window|View)|W\)).*$", code, re.M)
    ]


def picture(text):
    with tempfile.TemporaryDirectory() as folder:
        return frames.read_png(povray.run(text, RENDERING, Path(folder)))


SCENES = [
    *(Chess(sheet="none", piece=piece, z1=1) for piece in PIECES),
    Chess(),
    Spheres(sheet="single", z1=(1, 3)),
    Chess(sheet="ideal", predicted_image=True),
    Spheres(sheet="none", alpha=0, z1=(1, 3)),
    Spheres(sheet="ideal"),
    Spheres(sheet="refraction", ratio=0.2, z1=(1, 3)),
    Spheres(sheet="ideal", window="alpha=120,z=2", z1=(1, 3)),
]


@cache
def parts_by_scene():
    """Return where the objects of each scene's text are that no earlier scene has."""
    known, found = set(), []
    for text in map(to_pov, SCENES):
        found.append([part for part in objects(text) if text[slice(*part)] not in known])
        known |= {text[slice(*part)] for part in objects(text)}
    return found


def unneeded(text, parts):
    """Return the objects that can be removed without a change of the picture."""
    whole = picture(text)

    def matters(part):
        return (picture(text[: part[0]] + text[part[1] :]) != whole).any()

    with ThreadPoolExecutor(8) as pool:
        return [text[slice(*part)] for part, needed in zip(parts, pool.map(matters, parts), strict=True) if not needed]


@pytest.mark.parametrize("number", some([*range(len(SCENES))], 1))
def test_every_object_changes_the_picture(number):
    """An object that several scenes have is removed from the first of them."""
    text, parts = to_pov(SCENES[number]), parts_by_scene()[number]
    assert len(objects(text)) > 4 and not (parts and unneeded(text, parts))


def test_an_object_that_is_not_needed_is_found():
    text = to_pov(Chess(sheet="none"))
    hidden = "sphere { Tile*<0, -50, 5>, 1 }"
    parts = [part for part in objects(text + hidden) if (text + hidden)[slice(*part)] == hidden]
    assert unneeded(text + hidden, parts) == [hidden]
