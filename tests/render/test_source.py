"""The command that a .pov names makes the picture that povgen makes."""

import re
import subprocess

from povgen import Chess, render, to_pov
from povgen.rendering import frames


def test_the_command_in_the_header_makes_povgens_picture(tmp_path):
    scene = Chess(sheet="none")
    (tmp_path / "scene.pov").write_text(to_pov(scene))
    (command,) = re.findall(r"^//   (povray .*)$", to_pov(scene), flags=re.M)
    subprocess.run([*command.split(), "-D", "+Oown.png"], cwd=tmp_path, check=True, capture_output=True)
    assert (frames.read_png(tmp_path / "own.png") == render(scene)).all()
