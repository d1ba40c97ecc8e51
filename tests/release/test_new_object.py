"""A new kind of object is one file: both renderers draw it, TOML, Python, captions and the ray files know it."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import povgen
from povgen.scene.sdl import TEMPLATES
from povgen.scene.spec import MOVIES

DOCS = Path(__file__).parents[2] / "docs"

PAGE = (DOCS / "adding.md").read_text()
ELLIPSOID = re.search("cat > povgen/objects/ellipsoid.py <<'END'\n(.*?)\nEND\n", PAGE, re.DOTALL)[1]
DRAWN = """
import json, sys
import numpy as np
from povgen import Room, live, render
from povgen.video.captions import captions
from povgen.settings import Rendering
ellipsoids = ["kind=ellipsoid,name=hat,x=-1,y=-0.6,z=2,pitch=20", "kind=ellipsoid,x=1.2,height=1.5"]
room = Room(window="alpha=60,x=-1.3,width=2.4", object=ellipsoids)
gl, pov = (render(room, size=(96, 72), antialias="off", renderer=name).astype(int) for name in ("gl", "povray"))
green = [int(((each[..., 1] > each[..., 0] + 25) & (each[..., 1] > each[..., 2] + 10)).sum()) for each in (gl, pov)]
live(room).save("room.html")
toml = "[[object]]\\nkind = 'ellipsoid'\\nname = 'hat'\\nheight = 2\\n"
open("room.toml", "w").write(toml)
loaded = Room.load("room.toml").with_numbers({"hat.height": 3}).things["hat"].height
said = str(captions([room], Rendering(caption="full")))
print(json.dumps([float((abs(gl - pov).max(-1) < 15).mean()), green, loaded, said]))
"""


def test_a_new_kind_of_object_is_one_file(tmp_path):
    shutil.copytree(Path(povgen.__file__).parent, tmp_path / "povgen", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in (TEMPLATES, MOVIES):
        shutil.copytree(folder, tmp_path / folder.name)
    (tmp_path / "povgen" / "objects" / "ellipsoid.py").write_text(ELLIPSOID)
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", DRAWN], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert not done.returncode, done.stderr
    same, (gl, pov), height, said = json.loads(done.stdout.splitlines()[-1])
    assert same > 0.99 and gl > 150 and abs(gl - pov) < 20
    assert height == 3 and "ellipsoid" in said
    assert "reach_ellipsoid" in (tmp_path / "room.html").read_text()
    listed = subprocess.run(
        [sys.executable, "-m", "povgen", "frame", "room", "--object", "kind=ellipsoid,radius=0"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert listed.returncode == 2 and "radius = '0'" in listed.stderr
