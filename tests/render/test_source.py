"""The command that a .pov names makes the picture that povgen makes."""

import re
import shlex
import subprocess

import pytest
from conftest import povgen, refused

from povgen import Chess, InputError, render, to_pov
from povgen.rendering import frames, light

EMPTY = Chess(sheet="none")


def drawn(source, folder, file="scene.pov"):
    """Run the command in the source's header, and return its picture."""
    (folder / file).write_text(source)
    (command,) = re.findall(r"^//   (povray .*)$", source, flags=re.M)
    subprocess.run([*shlex.split(command), "-D", "+Oown.png"], cwd=folder, check=True, capture_output=True)
    return frames.read_png(folder / "own.png")


def test_the_command_in_the_header_makes_povgens_picture(tmp_path):
    scene = EMPTY
    options = {"size": (64, 48), "antialias": "2,0.1,3"}
    assert (drawn(to_pov(scene, **options), tmp_path) == render(scene, **options)).all()
    assert (drawn(to_pov(scene), tmp_path) == render(scene)).all()
    source = to_pov(scene, antialias="1.5x")
    large = drawn(source, tmp_path)
    assert "povgen averages the light of this picture, which is 1.5 times as wide" in source
    assert large.shape == (540, 720, 3) and (light.reduced(large, (480, 360)) == render(scene, antialias="1.5x")).all()
    assert "1.5 times as wide" in to_pov(Chess())
    with pytest.raises(InputError, match="size = 3"):
        to_pov(scene, size=3)


@pytest.mark.parametrize("options", [["--size", "64x48", "--antialias", "2,0.3,2"], ["--quality", "draft"]])
def test_the_command_makes_the_picture_of_povgen_frame(options, tmp_path):
    scene = ["chess", "--sheet", "ideal", *options]
    status, source, _ = povgen(["pov", *scene], tmp_path)
    assert status == 0 and povgen(["frame", *scene], tmp_path)[0] == 0
    assert (drawn(source, tmp_path) == frames.read_png(tmp_path / "frame.png")).all()


@pytest.mark.parametrize("file", ["mine.pov", "it's mine.pov", "a=b[0].pov"])
def test_the_command_names_the_file(file, tmp_path):
    options = ["--sheet", "none", "--size", "32x32", "--antialias", "off"]
    assert povgen(["pov", "chess", *options, "-o", file], tmp_path)[0] == 0
    source = (tmp_path / file).read_text()
    (tmp_path / file).unlink()
    assert drawn(source, tmp_path, file).shape == (32, 32, 3)


def test_the_header_names_no_file_that_povray_cannot_open(tmp_path):
    said = "// POV-Ray cannot open this file by its name: copy it to scene.pov.\n"
    assert said not in to_pov(EMPTY)
    for file in ("é.pov", '".pov', "a\nsphere { 0, 1 }.pov"):
        assert povgen(["pov", "chess", "--sheet", "none", "-o", file], tmp_path)[0] == 0
        header, found, rest = (tmp_path / file).read_text().partition(said)
        assert found and header.count("\n") == header.count("\n//") + 1 and header + rest == to_pov(EMPTY)


@pytest.mark.parametrize("option", [{"stereo": "pair"}, {"caption": True}, {"overlay": True}, {"timeout": 9}])
def test_to_pov_refuses_what_its_header_cannot_promise(option):
    with pytest.raises(InputError, match="unknown; allowed: quality, size, antialias$"):
        to_pov(EMPTY, **option)


def test_what_only_povgen_draws_is_no_option_of_pov(tmp_path):
    assert "--caption" in refused(["pov", "chess", "--caption"], tmp_path)
    assert "size = '3x3'" in refused(["pov", "chess", "--size", "3x3"], tmp_path)
