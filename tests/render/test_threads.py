"""One picture gets all cores: POV-Ray's threads change neither pixels nor the cache."""

import shutil

import pytest
from conftest import povgen, some

from povgen import Chess, Rendering, Spheres, movie, to_pov
from povgen.rendering import frames, povray
from povgen.rendering.frames import read_png

# POV-Ray gives a thread a block of 32x32 pixels at a time. These sizes are no multiples of it.
SIZES = (66, 50), (102, 74)
PIECES = {
    "pigment { granite }": 4,
    "finish { crand 0.3 }": 1,
    "texture { T_Stone1 }": 1,  # the file that declares it has crand
    "hollow interior { media { emission 1 } }": 1,
    "pigment { granite } } isosurface { function { y } contained_by { sphere { 0, 0.1 } } evaluate 1, 2, 0.9": 1,
    "} object { Supertorus(0.2, 0.1, 1, 1, 0.01, 0)": 1,
}


@pytest.fixture
def threads(monkeypatch, tmp_path):
    """The numbers of threads of the POV-Rays that were started. The cache is empty."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    command, started = povray.command, []

    def noted(binary, rendering, threads=1):
        if binary == povray.binary():  # otherwise it is part of a key
            started.append(threads)
        return command(binary, rendering, threads)

    monkeypatch.setattr(povray, "command", noted)
    return started


def drawn(scene, rendering, threads, folder):
    folder.mkdir(parents=True)
    return read_png(povray.Runner(threads).run(to_pov(scene), rendering, folder)).copy()


@pytest.mark.parametrize("antialias", some(["1,0.1,2", "off", "1,0.9,3", "2,0.1,2", "1.5x", "2x"], 1))
@pytest.mark.parametrize("sheet", some(["detailed", "ideal"], 1))
def test_the_same_pixels(sheet, antialias, tmp_path, threads):
    scenes = Chess(sheet=sheet, alpha=66), Spheres(sheet=sheet, alpha=120, z2=2)
    for n, (scene, size) in enumerate(zip(scenes, SIZES, strict=True)):
        rendering = Rendering(size=size, antialias=antialias)
        one, several = (drawn(scene, rendering, count, tmp_path / f"{n}-{count}") for count in (1, 3))
        assert (one == several).all()
    assert threads == [1, 3, 1, 3]


@pytest.mark.parametrize(("part", "expected"), PIECES.items())
def test_a_piece_whose_pixels_depend_on_their_order(part, expected, tmp_path, threads):
    """POV-Ray has one thread: with several, crand and media differed from run to run, evaluate with 8."""
    text = f"union {{ sphere {{ 0.5*y, 0.4 {part} }} }}"
    files = ("colors.inc", "stones.inc") if "Stone" in part else ("shapes.inc",)
    includes = "".join(f'#include "{file}"\n' for file in files)
    (tmp_path / "piece.inc").write_text(f"{includes}#declare Piece = {text}\n")
    drawn(Chess(sheet="none", piece=tmp_path / "piece.inc"), Rendering(size=(32, 32)), 4, tmp_path / "drawn")
    assert threads == [expected]


@pytest.mark.parametrize(("eyes", "each"), [("none", 4), ("pair", 2)])
def test_one_picture_gets_all_cores(eyes, each, threads, monkeypatch):
    monkeypatch.setattr(frames, "cores", lambda: 4)
    rendering = Rendering(size=(64, 48), antialias="off", stereo=eyes)
    scene = Chess(sheet="none")
    list(frames.render_all([scene], rendering))
    assert threads == [each] * (4 // each)
    monkeypatch.setattr(frames, "cores", lambda: 1)  # the frames are found in the cache
    list(frames.render_all([scene], rendering))
    assert len(threads) == 4 // each


def test_a_movie_has_one_thread_for_each_frame(threads, monkeypatch):
    monkeypatch.setattr(frames, "cores", lambda: 2)
    scenes = [Chess(sheet="none", x=x) for x in (0, 0.5, 1)]
    list(frames.render_all(scenes, Rendering(size=(32, 32), antialias="off")))
    assert threads == [1, 1, 1]


@pytest.mark.parametrize("renderer", ["povray", "gl"])
def test_a_shard_fails_if_the_cache_does_not_keep_its_frames(renderer, tmp_path, monkeypatch):
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("POVGEN_CACHE_SIZE", "0")
    sweep = ["movie", "chess", "--sweep=alpha=0:90", "--frames=4", "--sheet=ideal", "--size=32x32", "--antialias=off"]
    status, out, err = povgen([*sweep, "--shard=1/2", f"--renderer={renderer}"], tmp_path)
    assert (status, out) == (1, "")
    assert "povgen: shard 1/2: frames that the cache does not keep: 2; allowed: a larger cache" in err


def test_a_shard_has_the_sampling_of_the_whole_movie(tmp_path, monkeypatch):
    """Its frames are those that the movie takes from the cache."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    small = {"size": (32, 32), "quality": "high"}
    movie([Chess(sheet="ideal", alpha=10), Chess(prisms=20, alpha=10)], tmp_path / "a.gif", **small)
    shutil.rmtree(tmp_path / "cache")
    line = ["movie", "--from", "a.gif", "--quality=high", "--size=32x32"]
    for part in ("1/2", "2/2"):
        assert povgen([*line, f"--shard={part}"], tmp_path)[0] == 0
    monkeypatch.setattr(povray.Runner, "run", lambda *_: pytest.fail("a frame was rendered again"))
    assert povgen([*line, "-o", "b.gif"], tmp_path)[0] == 0


@pytest.mark.parametrize(("memory", "expected"), [(8 << 30, 64), (64 << 20, 1)])
def test_threads_fit_into_memory(memory, expected, monkeypatch, tmp_path, threads):
    with monkeypatch.context() as patch:
        patch.setattr(povray, "max_memory", lambda *_: memory)
        runner = povray.Runner(512)
    runner.run(to_pov(Chess(sheet="none")), Rendering(size=(32, 32), antialias="off"), tmp_path)
    assert threads == [expected]
