"""What a person calls in Python: an array, an image, a file, and a movie that plays in Jupyter."""

import io
import json
import os
from base64 import b64decode
from contextlib import contextmanager, nullcontext
from types import SimpleNamespace

import imageio_ffmpeg
import numpy as np
import pytest
from conftest import some
from PIL import Image

from povgen import Chess, InputError, Movie, Rendering, movie, render, save, show
from povgen.video import still

SCENE = Chess(sheet="none")
SMALL = {"size": (32, 32), "antialias": "off"}
SCENES = [SCENE.replace(x=x) for x in (0, 0.5, 1)]


def test_the_same_picture_as_array_image_and_file(tmp_path):
    array = render(SCENE, **SMALL, caption="full")
    assert array.shape[1:] == (32, 3) and len(array) > 32 and array.dtype == np.uint8
    image = show(SCENE, **SMALL, caption="full")
    assert isinstance(image, Image.Image) and (np.asarray(image) == array).all()
    path = save(SCENE, str(tmp_path / "a.png"), **SMALL, caption="full")
    assert path == tmp_path / "a.png" and (np.asarray(Image.open(path)) == array).all()
    assert os.listdir(tmp_path) == ["a.png"]


def test_the_pictures_of_several_scenes_are_those_of_each(capsys):
    """Also if scenes through prisms need another antialiasing than the others."""
    scenes = [SCENE, Chess(prisms=20), Chess(sheet="none", background="transparent")]
    several = render((scene for scene in scenes), quality="standard", size=(32, 32), caption="full")
    assert capsys.readouterr().err == "".join(f"pictures: {n}/3 pictures\n" for n in (1, 2, 3))
    for picture, scene in zip(several, scenes, strict=True):
        alone = render(scene, quality="standard", size=(32, 32), caption="full")
        assert picture.shape == alone.shape and (picture == alone).all() and picture.flags.writeable
    assert render([]) == [] and not capsys.readouterr().err


def test_a_png_file_of_every_frame(tmp_path, caplog):
    caplog.set_level("WARNING", "povgen")  # a movie with --quiet, of another test, has changed it
    (tmp_path / "new").mkdir()
    for output in ("new/a%03d.png", "other/%d.png"):
        made = movie(iter(SCENES), tmp_path / output, **SMALL, progress=False)
        assert made == Movie(tmp_path / output) and made._repr_html_() is None
    assert sorted(os.listdir(tmp_path / "new")) == ["a001.png", "a002.png", "a003.png"]
    assert sorted(os.listdir(tmp_path / "other")) == ["1.png", "2.png", "3.png"]
    for number, scene in enumerate(SCENES, 1):
        with Image.open(tmp_path / "other" / f"{number}.png") as image:
            assert (np.asarray(image) == render(scene, **SMALL)).all()
    assert not caplog.text
    movie(SCENES[:2], tmp_path / "other" / "%d.png", **SMALL, progress=False)
    assert "3.png was there before: it is not a frame of this movie" in caplog.text
    assert len(os.listdir(tmp_path / "other")) == 3


def test_a_failed_sequence_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(still, "render_all", lambda *_: (_ for _ in [[0][1]]))
    with pytest.raises(IndexError):
        movie(SCENES, tmp_path / "new" / "%d.png", **SMALL, progress=False)
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize(("workers", "at_once"), [(None, 6), (2, 2)])
def test_as_many_frames_at_once_as_the_cluster_takes(workers, at_once, tmp_path, monkeypatch):
    """Unless the user says how many."""

    def render_all(scenes, rendering, workers, *_):
        raise InputError(f"{workers} at once")

    monkeypatch.setattr("povgen.rendering.cluster.Cluster", lambda *_: nullcontext(SimpleNamespace(frames=6)))
    monkeypatch.setattr(still, "render_all", render_all)
    with pytest.raises(InputError, match=f"^{at_once} at once$"):
        movie([SCENE], tmp_path / "a.gif", workers=workers, scheduler="tcp://192.0.2.1:8786", progress=False)


@pytest.mark.parametrize(("kind", "start"), [("mp4", "<video"), ("webm", "<video"), ("webp", "<img"), ("gif", "<img")])
def test_a_movie_of_scenes_plays_in_jupyter(kind, start, tmp_path):
    made = movie(SCENES, tmp_path / f"a.{kind}", frame_rate=10, **SMALL)
    assert made == Movie(tmp_path / f"a.{kind}") and os.fspath(made) == str(made.path)
    assert made._repr_html_().startswith(start)
    data = b64decode(made._repr_html_().split("base64,")[1].split('"')[0])
    assert data == open(made, "rb").read()
    if kind in ("gif", "webp"):
        with Image.open(io.BytesIO(data)) as image:
            assert (image.n_frames, image.load() and image.info["duration"]) == (3, 100)
    else:
        assert imageio_ffmpeg.count_frames_and_secs(str(made.path)) == (3, pytest.approx(0.3, abs=0.02))


def test_a_movie_is_found_from_another_folder_and_may_be_gone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = movie([SCENE], "a&b.gif", **SMALL)
    monkeypatch.chdir("/")
    assert made == Movie(tmp_path / "a&b.gif") and made._repr_html_().startswith("<img")
    made.path.unlink()
    with pytest.raises(InputError, match="a&b.gif': No such file or directory; allowed: a movie's file$"):
        made._repr_html_()


def test_another_frame_rate_of_a_spec(tmp_path):
    options = {"quality": "draft", "size": (32, 32)}
    toml = tmp_path / "a.toml"
    toml.write_text(
        'title = "a"\nscene = "chess"\nframe_rate = 4\nframes = 9\nfixed = { sheet = "none" }\n'
        '[[sweep]]\nparameter = "z1"\nstart = 2\nstop = 3\n'
    )
    made = movie(toml, tmp_path / "a.gif", frame_rate=40, **options)
    with Image.open(made.path) as image:  # four fifths of the 8 steps, and of the rate
        assert (image.n_frames, image.info["duration"]) == (7, 30)


def test_the_progress_in_a_script(tmp_path, capsys):
    movie(SCENES, tmp_path / "a.gif", **SMALL)
    assert capsys.readouterr().err == "".join(f"a.gif: {n}/3 frames\n" for n in (1, 2, 3))
    movie(SCENES, tmp_path / "a.gif", **SMALL, progress=False)
    assert capsys.readouterr() == ("", "")


def test_a_picture_shows_its_progress_unless_told_otherwise(tmp_path, monkeypatch):
    picture, quiet = still.as_file(SCENE, Rendering(**SMALL)), []
    monkeypatch.setattr(still, "as_file", lambda *_, **options: quiet.append(options["quiet"]) or picture)
    for options in ({}, {"progress": False}):
        save(SCENE, tmp_path / "a.png", **SMALL, **options)
    assert quiet == [False, True]


@pytest.mark.parametrize(
    ("renderer", "options", "pictures"),
    some(
        [("povray", {}, 1), ("gl", {"size": (1500, 1100)}, 1), ("povray", {"stereo": "pair", "size": (640, 240)}, 2)],
        2,
        several=True,
    ),
)
def test_the_parts_of_a_picture(renderer, options, pictures, monkeypatch, tmp_path):
    """They come one after another, and together are the whole picture."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    found = []

    @contextmanager
    def parts(what, total, quiet):
        assert (what, total, quiet) == ("chess", pictures, False)
        yield found.append

    monkeypatch.setattr(still, "parts", parts)
    rendering = Rendering(**{"size": (320, 240), "antialias": "off", "renderer": renderer, **options})
    still.as_file(Chess(prisms=20), rendering, quiet=False)
    assert len(found) > pictures and sum(found) == pytest.approx(pictures) and min(found) >= 0


NOTEBOOK = """
from povgen import Chess, movie
movie([Chess(sheet="none", x=x) for x in (0, 1)], "a.mp4", size=(32, 32), antialias="off")
"""


def test_a_movie_in_a_notebook(tmp_path):
    import nbclient
    import nbformat

    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(NOTEBOOK)])
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = json.dumps(notebook.cells[0].outputs)
    assert "<progress" in shown and "max='2'" in shown and "value='2'" in shown
    assert "<video controls loop src=" in shown and "ipywidgets" not in shown
