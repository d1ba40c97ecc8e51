"""A value that is not allowed is refused: exit status 2, one or two lines that name it, and no file is touched."""

import re
import shlex
import sys
import warnings

import imageio_ffmpeg
import pytest
from conftest import PROJECT, picture, povgen, refused, run_povgen
from PIL import Image

from povgen import Chess, InputError, MovieSpec, Rendering, Spheres, fonts, info, movie, remedies, to_pov
from povgen.errors import PovrayError
from povgen.liveview.view import Live
from povgen.measure import charts
from povgen.page import page
from povgen.record import check_unasked
from povgen.rendering import auto, povray
from povgen.scene.sdl import to_html
from povgen.scene.spec import MOVIES
from povgen.scene.survey import Survey
from povgen.sheets import PARAMETERS, SHEETS, USED_BY
from povgen.video import build, still

SPEC = """
title = "A movie"
scene = "chess"
frame_rate = 10
frames = 5
[fixed]
z1 = 2
[[sweep]]
parameter = "alpha"
start = 0
stop = 180
"""


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--alpha", "nan"], ["alpha", "nan", "finite"]),
        (["--alpha", "six"], ["alpha = 'six': should be a number (ray-rotation"]),
        (["--z1", "0.05"], ["z1", "0.05", "knight", "0.58"]),
        (["--z1", "1", "--z1", "2", "--x", "0"] + ["--x", "1"] * 2, ["2 values of z1", "3 values of x"]),
        (["--z2", "0.1"], ["z2", "0.1", "0.16"]),
        (["--z1", "2,3"], ["z1 = '2,3': should be a number", "; give --z1 once for each value\n"]),
        (["--piece", "dog"], ["piece", "dog", "king"]),
        (["--eye", "0,-1.65"], ["eye = 0,-1.65", "under the floor", "Y > -1.65"]),
        (["--line", "0,0"], ["'line': unknown in the scene chess; allowed: ", "x", "eye"]),
        (["--size", "321x240"], ["size", "321x240", "even"]),
        (["--antialias", "5x"], ["antialias = '5x': should be off, 1.5x, 2x, 3x, 4x or three numbers"]),
        (["--predicted-image", "--sheet", "single"], ["predicted_image", "single", "detailed"]),
        (
            ["--predicted-image", "--z1", "6", "--alpha", "180", "--sheet", "ideal"],
            ["predicted_image", "alpha = 180", "infinity"],
        ),
        (["-o", "x.jpg"], ["x.jpg", ".png"]),
        (["-o", "nowhere/x.png"], ["nowhere/x.png", "No such file"]),
        (["-o", ".PNG"], ["output = '.PNG': an ending without a name; allowed: NAME.PNG"]),
        (["--colour", "red"], ["No such option", "--colour"]),
    ],
)
def test_frame(options, words, tmp_path):
    (tmp_path / "frame.png").write_bytes(b"kept")
    message = refused(["frame", "chess", *options], tmp_path)
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('title = "A movie"\n', "", ["title", "missing"]),
        ("frame_rate = 10", "frame_rate = 10\nframerate = 3", ["framerate", "frame_rate"]),
        ('scene = "chess"', 'scene = "circus"', ["scene", "circus", "spheres"]),
        ("stop = 180", "stop = 0", ["stop", "start"]),
        ('parameter = "alpha"', 'parameter = "eye"', ["eye = 0.0: allowed: a pair, X,Y (in a TOML file [X, Y])"]),
        ("z1 = 2", "alpha = 2", ["alpha", "swept"]),
        ("stop = 180", "stop = 1800", ["spec.toml: frame 5 of 5: alpha = 1800", "360"]),
        ('title = "A movie"', 'title = "A\\u0000movie"', ["title", "one line"]),
        ("[[sweep]]", "[sweep]", ["sweep", "should be a list", "table [[sweep]], with two brackets"]),
    ],
)
def test_spec(old, new, words, tmp_path):
    assert old in SPEC
    (tmp_path / "spec.toml").write_text(SPEC.replace(old, new))
    (tmp_path / "spec.mp4").write_bytes(b"kept")
    message = refused(["movie", "spec.toml"], tmp_path)
    assert "spec.toml" in message and all(word in message for word in words), message


def test_warnings_of_python_are_not_shown(tmp_path, monkeypatch):
    def warning(*_):
        warnings.warn("of a library", stacklevel=1)
        raise InputError("nothing else")

    monkeypatch.setattr(sys, "warnoptions", [])
    monkeypatch.setattr(MovieSpec, "load", warning)
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        assert refused(["movie", "vary-z1"], tmp_path) == "povgen: nothing else\n"
    assert not shown


def test_spec_with_scenes_own_words(tmp_path):
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
    assert "UTF-8" in refused(["movie", "binary.toml"], tmp_path)
    assert "vary-alpha" in refused(["movie", "no-such-movie"], tmp_path)
    (tmp_path / "spec.toml").write_text(SPEC)
    assert ".webm" in refused(["movie", "spec.toml", "-o", "movie.avi"], tmp_path)
    (tmp_path / "fast.toml").write_text(SPEC.replace("frame_rate = 10", "frame_rate = 60"))
    assert "60 a second" in refused(["movie", "fast.toml", "-o", "x.gif"], tmp_path)
    (tmp_path / "slow.toml").write_text(SPEC.replace("= 10", "= 0.1").replace("frames = 5", "frames = 66"))
    assert "a GIF of 66 frames, 0.1 a second, 660 s long: " in refused(["movie", "slow.toml", "-o", "x.GIF"], tmp_path)
    assert "predicted_image" in refused(["movie", "spheres", "--predicted-image"], tmp_path)
    assert ".pov" in refused(["pov", "chess", "-o", "scene.txt"], tmp_path)


@pytest.fixture
def unmeasured(monkeypatch):
    """With --sheet auto, a refusal must come before anything is measured."""
    monkeypatch.setattr(auto, "choose", lambda *_: pytest.fail("measured"))


PIECE = "#declare Piece = sphere { 0.4*y, 0.4 }\n"
SWEEP = ["chess", "--sweep", "alpha=0:9"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["pov", "chess", "--piece", "link.pov", "-o", "king.pov"],
        ["pov", "chess", "--piece", "king", "--piece", "hard.pov", "--x", "0", "--x", "1", "-o", "king.pov"],
        ["frame", "chess", "--piece", "p.png", "-o", "p.png", "--sheet", "auto", "--tolerance", "1px"],
        ["demo", "--piece", "mine-spheres.mp4", "-o", "mine.html", "--movies"],
        ["movie", "a.mp4"],
        ["movie", "a.toml", "-o", "b.mp4"],
        ["movie", *SWEEP, "--piece", "b.mp4", "-o", "b.mp4", "--sheet", "auto", "--tolerance", "1px"],
        ["movie", "vary-z1", "-o", "own.mp4"],
    ],
)
def test_an_output_that_is_an_input(arguments, unmeasured, tmp_path):
    """Also through links, and for a piece that a movie's file names."""
    folder = tmp_path / "here"
    folder.mkdir()
    for name in ("king.pov", "p.png", "mine.html", "mine-spheres.mp4", "b.mp4"):
        (folder / name).write_text(PIECE)
    (folder / "link.pov").symlink_to("king.pov")
    (folder / "hard.pov").hardlink_to(folder / "king.pov")
    (folder / "own.mp4").symlink_to(MOVIES / "vary-z1.toml")
    (folder / "a.mp4").write_text(SPEC)
    (folder / "a.toml").write_text(SPEC.replace("z1 = 2", "piece = 'b.mp4'"))
    assert re.search("output = '.*': povgen reads this file; allowed: another file\n$", refused(arguments, folder))


def test_a_movie_from_standard_input_is_not_written_over_it(tmp_path):
    (tmp_path / "a.mp4").write_text(SPEC)
    with (tmp_path / "a.mp4").open() as spec:
        done = run_povgen("movie", "-", "-o", "a.mp4", cwd=tmp_path, status=2, stdin=spec)
    assert "output = 'a.mp4': povgen reads this file" in done.stderr
    assert (tmp_path / "a.mp4").read_text() == SPEC


def test_python_writes_no_output_over_an_input(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("p.png", "p.mp4", "p.html"):
        (tmp_path / name).write_text(PIECE)
    (tmp_path / "a.mp4").write_text(SPEC)
    scenes = {name: Chess(piece=name) for name in ("p.png", "p.mp4", "p.html")}
    shown = Live(scenes["p.html"], None)
    for write in (
        lambda: still.save(scenes["p.png"], "p.png"),
        lambda: movie([Chess(), scenes["p.mp4"]], "p.mp4"),
        lambda: movie("a.mp4", "a.mp4"),
        lambda: shown.save("p.html"),
    ):
        with pytest.raises(InputError, match="povgen reads this file; allowed: another file"):
            write()
    assert {path.read_text() for path in tmp_path.iterdir()} == {PIECE, SPEC}


@pytest.mark.parametrize(
    ("arguments", "file"),
    [
        (["frame", "chess", "--sheet", "auto", "--tolerance", "1px"], "frame.png"),
        (["movie", *SWEEP], "chess.mp4"),
        (["movie", *SWEEP, "--frames", "9", "-o", "a%d.png"], "a5.png"),
        (["demo", "-o", "a.html", "--movies"], "a-spheres.mp4"),
        (["tolerance", "chess", "-o", "lab.png"], "lab.csv"),
        (["figure", "3", "1", "-o", "."], "figure1.svg"),
    ],
)
def test_a_file_that_nobody_named_is_not_written_over(arguments, file, unmeasured, tmp_path, monkeypatch):
    """Unless povgen wrote it. It may be a link to a file that is not there yet."""
    monkeypatch.setattr(povray.Runner, "run", lambda *_: pytest.fail("rendered"))
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).symlink_to(tmp_path / "elsewhere")
    text = f"{file!r} exists, and povgen did not write it; allowed: another output\n"
    assert refused(arguments, tmp_path) == f"povgen: output: {text}"
    (tmp_path / file).unlink()
    Image.new("RGB", (32, 32)).save(tmp_path / file, "png")
    assert refused(arguments, tmp_path) == f"povgen: output: {text}"


def test_a_file_of_povgens_is_written_over(tmp_path):
    line = ["frame", "chess", "--sheet=none", "--size=32x32", "--quiet"]
    assert povgen(line, tmp_path) == povgen(line, tmp_path) == (0, "", "")
    movies = ["movie", "chess", "--sweep=z1=2:3", "--frames=2", *line[2:], "-o"]
    for name in ("chess.mp4", "%d.png"):
        assert povgen([*movies, name], tmp_path) == povgen(movies[:-1], tmp_path) == (0, "", "")
    (tmp_path / "a.csv").write_text("time,volts\n")
    with pytest.raises(InputError, match="a.csv' exists"):
        check_unasked([tmp_path / "a.csv"])
    (tmp_path / "a.html").write_text(to_html("page/index", page.data({}), "", [], page.MOUNTAINS, fonts.encoded()))
    check_unasked([tmp_path / name for name in ("a.html", "missing")])
    (tmp_path / "figure1.md").write_text("![A ray](figure1.png)\n")
    check_unasked([tmp_path / "figure1.md"])
    docs = PROJECT / "docs"  # what earlier commands wrote
    check_unasked([*docs.glob("tolerances/*.csv"), *docs.glob("stability/*.csv")])
    check_unasked((docs / "chart" / name for name in charts.FILES), docs / "chart/frames.csv")


@pytest.mark.parametrize(
    "address", ["", "tcp://x", "http://127.0.0.1:80", "tcp://127.0.0.1:65536", "tcp://::1:8786", 5]
)
def test_an_address_that_is_none(address, unmeasured, tmp_path):
    """It is refused before anything is measured or rendered."""
    with pytest.raises(InputError, match=re.escape(f"scheduler = {address!r}: allowed: its address, such as tcp://")):
        movie("vary-z1", tmp_path / "a.mp4", scheduler=address)
    command = ["movie", "vary-z1", "--sheet", "auto", "--tolerance", "1px", "--scheduler", str(address)]
    assert "scheduler" in refused(command, tmp_path)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--shard", "1/3", "-o", "a.mp4"], "shard = '1/3', output = 'a.mp4': a shard makes no movie; allowed: one of"),
        (["--shard", "1/3", "--scheduler", "tcp://a:1"], "shard = '1/3', scheduler = 'tcp://a:1': a shard makes no"),
        (["--shard", "4/3"], "shard = '4/3': allowed: i/n"),
    ],
)
def test_options_that_a_shard_does_not_take(options, words, unmeasured, tmp_path):
    assert words in refused(["movie", "vary-z1", "--sheet", "auto", "--tolerance", "1px", *options], tmp_path)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["frames", "chess"], ["command = 'frames': unknown; allowed: list, pov, frame, movie, "]),
        (["figure", "1-6"], ["number = '1-6'", "1, 2, 3, 4, 5 or 6, with spaces between"]),
        (["verify", "--json", "x.txt"], ["json = 'x.txt'", ".json"]),
        (["demo", "--quality", "high"], ["quality = high: only movies are rendered; allowed: with --movies\n"]),
        (["demo", "--piece", "a,b"], ["piece = 'a,b'", "; give --piece once for each value\n"]),
        (
            ["demo", "--add", "none.toml"],
            ["none.toml: no question, tour or lesson: No such file", "allowed: a TOML file\n"],
        ),
        (["cache", "empty"], ["'empty'", "info or clear"]),
    ],
)
def test_other_commands(arguments, words, tmp_path):
    message = refused(arguments, tmp_path)
    assert all(word in message for word in words), message


LAW = ["--sheet=law", "--law=x - k*X*z, y, z", "--parameter=k=0.3", "--parameter=m=0.2"]


@pytest.mark.parametrize(
    ("options", "unused"),
    [
        (
            ["--ratio", "2", "--prisms", "9"],
            ["ratio = 2: no effect with sheet = detailed; it is for lenslets, lenticular or refraction"],
        ),
        (
            ["--sheet", "ideal", "--prisms", "9"],
            ["prisms = 9: no effect with sheet = ideal; it is for detailed or single"],
        ),
        (["--sheet", "ideal", "--window", "alpha=9,z=2,sheet=detailed", "--prisms", "99"], []),
        (["--sheet", "none", "--alpha", "9", "--tops", "black"], ["alpha = 9: no effect", "tops = black: no effect"]),
        (["--focus=5"], ["focus: no effect with pupil = 0"]),
        (["--focus=5", "--pupil=0.1", "--sheet=ideal"], []),
        (["--sheet=ideal", "--window=z=2,index=2"], ["window 2: index: no effect with sheet = ideal"]),
        (["--sheet=law", "--law=x,y,z", "--parameter=k=1"], ["parameter: k: no effect, because no law"]),
        ([*LAW, "--window=z=1,law=x, y - m*Y*z, z"], []),  # windows share the scene's numbers
        ([*LAW, "--window=z=1"], ["parameter: m: no effect"]),
    ],
)
def test_options_without_effect(options, unused, tmp_path):
    status, _, err = povgen(["pov", "chess", *options], tmp_path)
    said = [line for line in err.splitlines() if "no effect" in line]
    assert status == 0 and len(said) == len(unused)
    assert all(text in line for text, line in zip(unused, said, strict=True)), said


def test_a_sky_without_effect(tmp_path):
    Image.new("RGB", (64, 32)).save(tmp_path / "sky.png")
    for background, count in (("black", 1), ("sky", 0)):
        status, _, err = povgen(["pov", "chess", "--sky", "sky.png", "--background", background], tmp_path)
        assert status == 0 and err.count("sky: no effect with background = black") == count


@pytest.mark.parametrize(
    "sheet",
    [pytest.param(sheet, marks=() if sheet in ("detailed", "lenticular") else pytest.mark.release) for sheet in SHEETS],
)
def test_which_options_have_an_effect(sheet):
    """An option has no effect, as the warning says, if it leaves all but the comments of the scene's text as it is."""

    def text(**values):
        source = to_pov(Chess(sheet=sheet, **values), found=Survey(20, 0.5))
        return [line.partition("//")[0] for line in source.splitlines()]

    other = {
        "law": "x, y, z*2", "parameter": {"k": 2}, "focal_length": 5, "object_focal_length": 7, "twist": 9,
        "view_distance": 3, "glass": "F2", "design_wavelength": 500,
        "prisms": 50, "index": 1.6, "base_angle": 40, "gap": 0.1, "aspect": 1.1, "tops": "black", "fresnel": True,
        "axis": (1, 0, 0), "ratio": 2, "alpha": 9, "error": {"pitch" if sheet == "lenticular" else "turn": 0.05},
        "lenses": 50, "f_number": 4, "profile": "dove", "periods": 50, "arrangement": "single",
    }  # fmt: skip
    assert other.keys() <= {*USED_BY, "fresnel"}
    for name in USED_BY.keys() - other.keys():  # of a sheet that has been added
        parameter = PARAMETERS[name][0]
        other[name] = parameter.most if parameter.default != parameter.most else parameter.least
    for name, value in other.items():
        used = Chess(sheet=sheet).has_prisms if name == "fresnel" else sheet in USED_BY[name]
        also = {"glass": "F2"} if name == "design_wavelength" else {}
        assert (text(**also) != text(**also, **{name: value})) == used, name


def test_quiet_says_nothing_of_options_without_effect(tmp_path):
    line = ["frame", "chess", "--sheet=none", "--tops=black", "--size=32x32", "--quality=draft"]
    assert povgen(line, tmp_path)[2].count("no effect") == 1
    assert not povgen([*line, "--quiet"], tmp_path)[2]


def test_the_list_states_defaults(tmp_path):
    listed = povgen(["list"], tmp_path)[1]
    listed = " ".join(listed.split())
    assert "--prisms Dove prisms across the window in each sheet, 1 to 3000 (default 100) --" in listed
    assert (
        "the default spheres move with it (default 6) --" in listed
        and "axis turns light by alpha about the axis" in listed
    )


def test_the_help_is_short_and_fits_a_terminal(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = povgen(["frame", "-h"], tmp_path)[1]
    lines = text.splitlines()
    assert text == povgen(["frame", "--help"], tmp_path)[1]
    assert max(map(len, lines)) <= 80 and len(lines) <= 145
    others = "Parameters of other sheets, which povgen list explains:"
    headings = ["Options:", "The sheets:", others, "The picture:", "The eye:", "The objects:"]
    assert "--focal-length" in lines[lines.index(others) + 1]
    assert [line for line in lines if line in headings] == headings


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (["figure", "1"], "matplotlib"),
        (["verify", "--live"], "playwright"),
    ],
)
def test_without_an_extra(arguments, extra, tmp_path, monkeypatch):
    """Neither a folder nor the frame of a table is left."""
    loaded = [name for name in sys.modules if name.partition(".")[0] == extra]
    ours = [name for name in sys.modules if name.startswith(("povgen.measure.", "povgen.paper."))]
    for name in (*loaded, *ours):
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, extra, None)
    for name in ours:
        package, _, module = name.rpartition(".")
        monkeypatch.delattr(sys.modules[package], module, raising=False)
    message = refused(arguments, tmp_path)
    assert f"with {extra}, which is not installed: {remedies.pip()} install -e {remedies.CHECKOUT}[" in message.replace(
        "'", ""
    ) and not list(tmp_path.iterdir())


def test_without_ffmpeg_a_movie_is_refused_before_a_frame_is_rendered(tmp_path, monkeypatch):
    """As after pip install --no-binary imageio-ffmpeg, on a system without ffmpeg. GIFs need no ffmpeg."""
    monkeypatch.delenv("IMAGEIO_FFMPEG_EXE", raising=False)
    monkeypatch.setattr("imageio_ffmpeg._utils._get_ffmpeg_exe", lambda: None)
    monkeypatch.setattr("povgen.rendering.povray.Runner.run", lambda *_: pytest.fail("a frame was rendered"))
    for arguments in (["movie", "vary-z1"], ["demo", "--movies"]):
        assert "allowed without it: .gif" in refused(arguments, tmp_path)
    build.checked_movie(tmp_path / "a.gif", 10, 10, Rendering(), [])


@pytest.mark.parametrize("program", ["/missing", "/bin/false"])
def test_an_ffmpeg_that_cannot_be_started_is_refused_before_a_frame_is_rendered(program, tmp_path, monkeypatch):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", program)
    monkeypatch.setattr("povgen.rendering.povray.Runner.run", lambda *_: pytest.fail("a frame was rendered"))
    said = refused(["movie", "vary-z1"], tmp_path)
    assert said.startswith(f"povgen: IMAGEIO_FFMPEG_EXE = '{program}': no ffmpeg that can be started; allowed: ")


@pytest.mark.parametrize(
    ("lacks", "ending", "others"),
    [
        ("libx264", ".mp4", ".webm, .webp"),
        pytest.param("libvpx-vp9", ".webm", ".mp4, .webp", marks=pytest.mark.release),
        pytest.param("libwebp_anim", ".webp", ".mp4", marks=pytest.mark.release),
    ],
)
def test_an_ffmpeg_without_the_encoder_is_refused_before_a_frame_is_rendered(
    lacks, ending, others, tmp_path, monkeypatch
):
    """As the ffmpeg of Fedora, which has no encoder for H.264."""
    program = tmp_path / "ffmpeg"
    program.write_text(
        f'#!/bin/sh\nfor word in "$@"; do [ "$word" = {lacks} ] && exit 8; done\n'
        f'exec {shlex.quote(imageio_ffmpeg.get_ffmpeg_exe())} "$@"\n'
    )
    program.chmod(0o700)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(program))
    monkeypatch.setattr("povgen.rendering.povray.Runner.run", lambda *_: pytest.fail("a frame was rendered"))
    said = refused(["movie", "vary-z1", "-o", f"a{ending}"], tmp_path)
    assert f"output = *{ending}: {program} has no working encoder {lacks}: unset IMAGEIO_FFMPEG_EXE" in said
    assert f"allowed with this ffmpeg: {others}" in said and ".gif, frames/%04d.png" in said
    assert [path.name for path in tmp_path.iterdir()] == ["ffmpeg"]


@pytest.mark.parametrize(("kind", "most"), [("mp4", "16384x16384"), ("webp", "16383x16383")])
def test_a_movie_too_large_for_its_format_is_refused_before_a_frame_is_rendered(kind, most, tmp_path, monkeypatch):
    monkeypatch.setattr("povgen.rendering.gl_runner.Runner.run", lambda *_: pytest.fail("a frame was rendered"))
    monkeypatch.setattr("povgen.rendering.estimate.measured", lambda *_: (0, 0, 0, 0))
    wide = ["movie", "vary-z1", "--renderer=gl", "--size=8200x32", "--antialias=off", "-o", f"a.{kind}"]
    for more in ([], ["--dry-run"]):
        said = refused([*wide, "--stereo=pair", *more], tmp_path)
        assert said == f"povgen: {kind}: pictures of 16400x32 pixels; allowed: up to {most}\n"
    high = [*wide, "--size=32x12000", "--side-view", "--dry-run"]
    assert f"pictures of 32x18000 pixels; allowed: up to {most}" in refused(high, tmp_path)
    assert povgen([*wide, "--dry-run"], tmp_path)[0] == 0 == povgen([*wide[:-1], "a.gif", "--dry-run"], tmp_path)[0]


def test_a_frame_rate_that_a_quality_makes_too_low(tmp_path, monkeypatch):
    monkeypatch.setattr("povgen.rendering.estimate.measured", lambda *_: (0, 0, 0, 0))
    line = ["movie", "chess", "--sweep", "alpha=0:180", "--frame-rate=0.1", "--dry-run"]
    assert "frame_rate = 0.1: 0.07969 frames a second at quality = 'draft'; allowed: 0.1 to 120" in refused(
        [*line, "--quality=draft"], tmp_path
    )
    assert povgen([*line, "--quality=standard"], tmp_path)[0] == 0


def test_the_number_in_the_name_of_pictures(tmp_path):
    for name in ("f%4d.png", "f%s.png", "f%04d%d.png", "%f.png"):
        assert "such as f%04d.png, for a PNG file of every frame" in refused(["movie", "vary-z1", "-o", name], tmp_path)


def test_a_sweep_without_effect_is_named(tmp_path):
    line = ["movie", "chess", "--sweep=index=1.3:2", "--frames=3", "--sheet=none", "--size=32x32", "--shard=3/3"]
    assert "povgen: warning: index: no effect" in povgen(line, tmp_path)[2]


@pytest.mark.parametrize(("law", "what"), [("x, y, z/0", "0.0"), ("x/(k - 1), y, z", "k - 1.0")])
def test_a_law_that_divides_by_zero_is_refused(law, what, tmp_path):
    assert Chess(sheet="law", law="x/(1/k), y/(1 + 1/k), z", parameter={"k": 0}).sheets[0].law  # by infinity
    said = refused(["pov", "chess", "--sheet=law", f"--law={law}", "--parameter=k=1"], tmp_path)
    assert f"law = '{law}': '{what}' is 0; allowed: to divide by other numbers" in said
    assert povgen(["pov", "chess", "--sheet=law", "--law=x/k, y/z, z", "--parameter=k=2"], tmp_path)[0] == 0


def test_a_chart_does_not_replace_a_picture_that_the_scene_shows(tmp_path):
    path = picture(tmp_path)
    said = refused(["tolerance", "chess", "--sky", path, "-o", path], tmp_path)
    assert said.startswith(f"povgen: output = {path!r}: povgen reads this file")


def test_what_tolerance_cannot_do_is_said_before_it_traces(tmp_path, monkeypatch):
    from povgen.measure import tolerance

    monkeypatch.setattr(tolerance, "sensitivities", lambda *_: pytest.fail("it traced"))
    (tmp_path / "errors.csv").mkdir()  # where the chart's table would be
    assert "errors.csv" in refused(["tolerance", "chess", "-o", "errors.png"], tmp_path)


def test_the_seed_of_random_builds(tmp_path, monkeypatch):
    from povgen.measure import tolerance

    def drawn(scene, spread):
        raise InputError(f"the seed is {spread.seed}")

    monkeypatch.setattr(tolerance, "random_builds", drawn)
    assert "the seed is 5" in refused(["tolerance", "chess", "--deviation", "turn=0.1", "--seed", "5"], tmp_path)
    assert "seed = 5: no random builds; allowed: with --deviation" in refused(
        ["tolerance", "chess", "--seed", "5"], tmp_path
    )


def test_no_folder_is_left_without_povray(tmp_path, monkeypatch):
    def missing(*_):
        raise PovrayError("POV-Ray is not installed")

    monkeypatch.setattr(povray.Runner, "run", missing)
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    status, out, err = povgen(["figure", "2"], tmp_path)
    assert (status, out) == (1, "") and "POV-Ray is not installed" in err
    assert [path.name for path in tmp_path.iterdir()] in (["cache"], [])


def test_a_title_is_text_in_the_metadata(tmp_path):
    title = "-α−é 😀 <b>&\"'</b> {{ 7*7 }} %s \\ ; = # $HOME `id` title=x"
    spec = MovieSpec.parse(
        SPEC.replace("[fixed]", "[fixed]\nsheet = 'none'").replace("frames = 5", "frames = 2"), "spec"
    )
    spec = spec.model_copy(update={"title": title})
    for kind in (".mp4", ".webm", ".gif"):
        movie(spec, tmp_path / f"movie{kind}", size=(32, 32), antialias="off")
    data = (tmp_path / "movie.mp4").read_bytes()
    start = data.index(b"\xa9nam") + 4  # an atom of the size, "data", the type and the language, and the text
    size = int.from_bytes(data[start : start + 4], "big")
    assert data[start + 16 : start + size].decode() == title
    assert title.encode() in (tmp_path / "movie.webm").read_bytes()
    assert info(tmp_path / "movie.gif").title == title


FAR = [
    Chess(alpha=5e-324, sheet="ideal", predicted_image=True),
    Chess(alpha=180, z1=6.000000000000001, sheet="ideal", predicted_image=True),
    Chess(prisms=1, z1=150, z2=150),
    Chess(prisms=3000, z1=4000, z2=150, x=-10, eye=(0, -1.6499999999999997)),
    Spheres(z1=(5000,) * 50, sheet="ideal"),
    Chess(index=1.1, base_angle=75, view=0.1, eye=(10, 10), z1=3),
    Chess(prisms=1, aperture=10, gap=0.5, z1=150, z2=150, view=100),
    Chess(sheet="ideal", aperture=10, z2=0.52, view=100, eye=(10, 10), pedestal=10, predicted_image=True),
    Spheres(sheet="ideal", aperture=0.5, z2=150, view=0.1, eye=(10, -10)),
]


@pytest.mark.release
@pytest.mark.parametrize("scene", FAR)
def test_the_ends_of_what_is_allowed(scene):
    rendering = Rendering(size=(32, 32), antialias="off", caption="full", overlay=True, timeout=200)
    assert still.as_file(scene, rendering).startswith(b"\x89PNG")


def test_a_window_that_its_frame_hides(tmp_path):
    """POV-Ray hangs if the camera of the ideal sheet is inside out. The camera has few cells here, to be fast."""
    few, count = re.subn("(Cells +=) [0-9]+", r"\1 10", to_pov(Chess(z2=0.2, eye=(0, 8.67), sheet="ideal")))
    assert count == 1 and povray.run(few, Rendering(size=(32, 32), antialias="off"), tmp_path).is_file()


def test_no_memory_for_povgen_itself(monkeypatch, tmp_path):
    def fails(*_):
        raise MemoryError

    monkeypatch.setattr(MovieSpec, "scenes", fails)
    status, out, err = povgen(["movie", "vary-alpha"], tmp_path)
    assert (status, out) == (1, "") and err.startswith("povgen: no memory or no thread is left for povgen itself")
    assert len(err.splitlines()) == 1 and not list(tmp_path.iterdir())


def test_a_flag_in_a_spec_is_taken_back(tmp_path):
    """--no-predicted-image overrides the spec. The shard has no frames, so nothing is rendered."""
    (tmp_path / "spec.toml").write_text(SPEC.replace("z1 = 2", "z1 = 2\npredicted_image = true"))
    single = ["movie", "spec.toml", "--sheet", "single", "--shard", "9/9"]
    assert "predicted_image = true" in refused(single, tmp_path)
    assert povgen([*single, "--no-predicted-image"], tmp_path)[0] == 0
    warned = povgen(["pov", "chess", "--predicted-image"], tmp_path)[2]
    assert "predicted_image = true: no effect in a .pov file" in warned


def test_a_spec_with_a_byte_order_mark(tmp_path):
    (tmp_path / "spec.toml").write_text(SPEC, encoding="utf-8-sig")
    assert MovieSpec.load(tmp_path / "spec.toml") == MovieSpec.parse(SPEC, "spec")


def test_what_to_cite_is_what_citation_cff_says(tmp_path):
    status, out, _ = povgen(["cite"], tmp_path)
    said = (PROJECT / "CITATION.cff").read_text("utf-8")
    for name in ("version", "doi", "family-names", "title", "journal", "volume", "year"):
        for value in re.findall(rf'^ *-? *{name}: "?(.*?)"?$', said, re.M):
            assert value in out or value == "povgen", value
    assert status == 0 and out.count("@") == out.count("\n  year = {20") == 2
