"""Movies without a file: povgen movie SCENE --sweep NAME=START:STOP."""

import imageio_ffmpeg
import pytest
from conftest import povgen, refused

from povgen import MovieSpec, Rendering, Scene, info
from povgen.cli.report import warn

TINY = ["--sheet", "none", "--size", "64x48", "--antialias", "off"]


def test_a_movie_without_a_file(tmp_path):
    sweeps = ["--sweep", "eye=-1,0:1,0", "--sweep", "index=1.3:2"]
    status, out, _ = povgen(
        ["movie", "chess", *sweeps, "--frames", "3", "--frame-rate", "5", "--ease", "--loop", *TINY], tmp_path
    )
    assert (status, out) == (0, "wrote chess.mp4\n")
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "chess.mp4")) == (4, pytest.approx(0.8, abs=0.02))
    made = info(tmp_path / "chess.mp4")
    assert made.title == "chess, eye from -1,0 to 1,0, index from 1.3 to 2" and made.frames[1]["index"] == 1.65


def test_a_spec_with_another_number_of_frames(tmp_path):
    status, _, err = povgen(["movie", "vary-z1", "--frames", "2", "--hold", "0.1", "-o", "a.gif", *TINY], tmp_path)
    assert status == 0 and "a.gif: 2/2 frames" in err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["chess", "--sweep", "alpha"], ["sweep = 'alpha': allowed: NAME=START:STOP"]),
        (["chess", "--sweep", "alpha=0:9", "--alpha", "3"], ["alpha = '3': also swept; allowed: one value or a sweep"]),
        (["chess", "--sweep", "prisms=1.2:1.4"], ["prisms: all values equal after rounding, nothing would"]),
        (["chess", "--sweep", "alpha=0:9,z1=2:3"], ["stop = '9,z1=2': ", "; give --sweep once for each value\n"]),
        (["chess", "--frames", "5"], ["chess: a scene, no movie spec; allowed: with sweeps"]),
        (
            ["vary-z1", "--sweep", "alpha=0:9"],
            ["not with the movie 'vary-z1'; allowed: with a scene: chess or spheres"],
        ),
    ],
)
def test_what_cannot_be_is_refused(options, words, tmp_path):
    message = refused(["movie", *options], tmp_path)
    assert all(word in message for word in words), message


def test_what_changes_nothing_or_cannot_be_trusted_is_said(tmp_path):
    """A number of a room's window, and the overlay that a movie's file states."""
    sweep = '[[sweep]]\nparameter = "{}"\nstart = {}\nstop = {}\n'
    (tmp_path / "room.toml").write_text('[[window]]\nname = "left"\n' + sweep.format("left.prisms", 10, 90))
    movie = 'title = "a"\nscene = "chess"\noverlay = true\n[fixed]\nalpha = 178\nprisms = 15\n'
    (tmp_path / "movie.toml").write_text(movie + sweep.format("z1", 5.8, 5.9))
    small = ["--frames", "2", "--size", "64x48", "--renderer", "gl", "-o", "a.gif"]
    for file, warning in (("room", "left.prisms: no effect with sheet = ideal"), ("movie", "overlay: at alpha = 178")):
        code, _, said = povgen(["movie", f"{file}.toml", *small], tmp_path)
        assert code == 0 and f"povgen: warning: {warning}" in said
    code, _, said = povgen(["live", "chess", "--predicted-image", "-o", "a.html"], tmp_path)
    assert code == 0 and "predicted_image = true: no effect in the live view" in said


def test_a_movie_again_keeps_one_scale(tmp_path):
    small = ["--renderer", "gl", "--antialias", "off", "-o"]
    scene = ["movie", "chess", "--z1", "6", "--sweep", "prisms=10:100", "--frames", "3"]
    first = [*scene, "--size", "64x48", *small, "a/%d.png"]
    assert povgen(first, tmp_path)[0] == 0
    assert povgen([*first[:-1], "a.gif"], tmp_path)[0] == 0
    assert povgen(["movie", "--from", "a.gif", "--aperture", "4", *small, "b/%d.png"], tmp_path)[0] == 0
    views = [{Scene.from_file(tmp_path / name / f"{n}.png").view for n in (1, 2, 3)} for name in "ab"]
    assert len(views[0]) == len(views[1]) == 1 and views[0] != views[1]


def test_a_sweep_of_prisms_warns_once(capsys):
    """Not once for each frame with too many prisms for its pixels."""
    spec = MovieSpec.of_sweeps("chess", ["prisms=10:1000:log"], {"frames": 6, "fixed": {"z1": 4}})
    warn({}, spec.scenes("standard"), Rendering(size=(96, 72), antialias="off"))
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("povgen: warning: prisms = 63: ")
    assert line.endswith("is noise; docs/troubleshooting.md#noise (in 4 of 6 frames)")
