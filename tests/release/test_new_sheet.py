"""A new kind of sheet, with parameters that no other has, is one file: also on the teaching page."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import MODULES, Node

import povgen
from povgen.scene.sdl import TEMPLATES
from povgen.scene.spec import MOVIES

# A kind with parameters that no other has: a lens along x only, which also shifts all light.
CYLINDER = """
from povgen.sheets.law_grammar import Law
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
from povgen.liveview import scripts
from povgen.page import page
from povgen.scene.laws import to_live
from povgen.inputs.pieces import PIECES
from povgen.scene.sdl import to_html
from povgen import fonts
data, laws = page.data({name: name for name in PIECES}), to_live()
place = Chess(sheet="cylinder", power=-0.3, shift=(-1, 0.25, 0), z1=3, eye=(0.4, -0.3)).apparent_position(-0.85j, 3)
html = to_html("page/index", data, scripts.script("page/main.js", laws=laws), laws, page.MOUNTAINS, fonts.encoded())
print(json.dumps([data, scripts.script(*sys.argv[1:], laws=laws), html, [place.real, place.imag]]))
"""


def test_a_new_kind_of_sheet_is_one_file(tmp_path):
    """It is in the page's choice, with its sliders and fields; the page's numbers are Python's."""
    shutil.copytree(Path(povgen.__file__).parent, tmp_path / "povgen", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in (TEMPLATES, MOVIES):
        shutil.copytree(folder, tmp_path / folder.name)
    (tmp_path / "povgen" / "sheets" / "cylinder.py").write_text(CYLINDER)
    command = [sys.executable, "-c", EMITTED, *MODULES]
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert not done.returncode, done.stderr
    data, script, html, place = json.loads(done.stdout)
    assert '<option value="cylinder" data-say="kinds.cylinder.choice"></option>' in html
    for part in ("slider-power", "number-power", "number-shiftx", "number-shifty", "number-shiftz"):
        assert f'id="{part}"' in html
    node = Node(data, script)
    node.evaluate("chooseBeyond", "cylinder")
    assert node.evaluate("[state.power, state.shift]") == [0.2, [0.5, 0, 0.1]]
    assert node.evaluate("chosenBeyond()") == "cylinder"
    assert node.evaluate("marked(say('kinds.cylinder.choice'))") == "cylinder lens &lt;1>"
    node.evaluate("change", {"power": -0.3, "shift": [-1, 0.25, 0], "z1": 3, "E": [0.4, -0.3]})
    assert node.evaluate("moment().place") == pytest.approx(place, abs=1e-9)
    link = node.evaluate("toHash()")
    assert "sheet=cylinder" in link and "power=-0.3&shift=-1,0.25,0&" in link
    caption = node.evaluate("caption(moment())")
    assert caption[:3] == ["cylinder lens <1>", "power = −0.3", "shift = (−1, 0.25, 0)"]
    assert node.evaluate("explanation(moment())").startswith("The sheet bends light towards a vertical line. ")
    node.evaluate("change", {"power": 7})
    assert "power is at most 3." in node.evaluate("explanation(moment())")
    node.close()
