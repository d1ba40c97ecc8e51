"""Movies read back from their files."""

import subprocess

import imageio.v2
import imageio.v3 as iio
import imageio_ffmpeg
import numpy as np
import pytest
from conftest import ALPHA_MOVIE, povgen
from hypothesis import example, given
from hypothesis import strategies as st
from PIL import Image

from povgen import Chess, InputError, info, movie
from povgen.record import Record
from povgen.video import encode, still

SIZE = (96, 72)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("movies")


@pytest.fixture(scope="module", params=["mp4", "webm"])
def made(request, folder):
    return movie(ALPHA_MOVIE, folder / f"a movie.{request.param}", size=SIZE, caption="none", workers=8).path


def test_count_size_codec_rate_and_colour(made):
    assert imageio_ffmpeg.count_frames_and_secs(str(made)) == (13, pytest.approx(13 / 12.5, abs=0.02))
    meta = iio.immeta(made, plugin="FFMPEG")
    assert meta["size"] == SIZE and meta["fps"] == 12.5
    assert meta["codec"].startswith({"mp4": "h264", "webm": "vp9"}[made.suffix[1:]])
    assert "yuv420p" in meta["pix_fmt"] and "bt709" in meta["pix_fmt"]


def test_a_decoded_frame_is_its_png(made):
    scenes = ALPHA_MOVIE.scenes("standard")
    with imageio.v2.get_reader(made, format="FFMPEG") as reader:
        for n in (0, 7, 12):
            png = still.render(scenes[n], size=SIZE)
            decoded = reader.get_data(n)
            assert np.sqrt(((decoded.astype(float) - png) ** 2).mean()) < 9  # of 255, for lossy halved chroma


@pytest.mark.parametrize(("suffix", "plugin"), [(".mp4", "FFMPEG"), (".webm", "FFMPEG"), (".webp", "pillow")])
def test_colours_come_back(suffix, plugin, tmp_path):
    """A movie is made with the colour matrix of its tags. Another matrix would change pure green by 30 of 255."""
    colours = np.array([(230, 20, 20), (20, 230, 20), (20, 20, 230), (128, 128, 128)], np.uint8)
    picture = np.repeat(np.repeat(colours[np.newaxis], 32, axis=1), 64, axis=0)
    encode.encode([picture, picture[:, ::-1], picture], tmp_path / f"movie{suffix}", 10)
    decoded = iio.imread(tmp_path / f"movie{suffix}", plugin=plugin, index=2)
    for n, colour in enumerate(colours):
        assert abs(decoded[32, 32 * n + 16].astype(int) - colour).max() < 8


def test_what_stands_still_does_so_in_an_mp4_file(tmp_path, rng):
    """A keyframe of another quality every 6 frames would change fine structure, most of all before something moves."""
    noise = rng.integers(60, 200, (96, 128, 3), np.uint8)
    encode.encode([noise] * 20 + [np.roll(noise, n, 0) for n in range(9)], tmp_path / "movie.mp4", 10)
    frames = iio.imread(tmp_path / "movie.mp4", plugin="FFMPEG").astype(float)
    changes = abs(np.diff(frames, axis=0)).mean((1, 2, 3))
    assert changes[:19].max() < 0.5 < changes[20:].min()  # of 255


def test_a_movie_says_what_moves_unless_told_otherwise(folder):
    """The caption is below the picture. An even height, because a movie stores pixels in blocks of 2x2."""
    shapes = {}
    for kind, options in {
        "gif": {},
        "full.gif": {"caption": "full"},
        "none.gif": {"caption": "none"},
        "%d.png": {},
    }.items():
        movie(ALPHA_MOVIE, folder / f"said.{kind}", size=SIZE, **options)
        first = folder / f"said.{kind}".replace("%d", "1")
        shapes[kind] = iio.imread(first, index=0, plugin="pillow").shape[:2]
    width, height = SIZE
    assert shapes["%d.png"] == shapes["none.gif"] == (height, width)
    assert height < min(shapes["gif"][0], shapes["full.gif"][0]) and shapes["gif"][0] % 2 == 0
    assert info(folder / "said.1.png").rendering.caption is None
    assert info(folder / "said.gif").rendering.caption == "short"


def test_a_movies_file_has_the_drawings_that_its_spec_asks_for(folder):
    spec = ALPHA_MOVIE.replace(overlay=True, side_view=True, note="a note").with_fixed({"sheet": "ideal"})
    expected = {
        "a.gif": (True, True, "a note"),
        "plain.gif": (False, False, ""),
        "side.gif": (False, True, "a note"),
        "%d.png": (False, False, ""),
    }
    given = {"plain.gif": {"caption": "none"}, "side.gif": {"overlay": False}}
    for name, drawn in expected.items():
        movie(spec, folder / f"drawn.{name}", size=SIZE, **given.get(name, {}))
        rendering = info(folder / f"drawn.{name.replace('%d', '1')}").rendering
        assert (rendering.overlay, rendering.side_view, rendering.note) == drawn


def test_notes_of_the_frames(tmp_path):
    """Each frame has its own, in one place of equal size; a scene that stays is drawn for each of its notes."""
    scenes = [Chess(sheet="none", z1=z1) for z1 in (2, 2, 3)]
    options = {"size": SIZE, "progress": False}
    options["notes"] = ["", "x_1 = 1_0", "α"]
    movie(scenes, tmp_path / "%d.png", caption="none", **options)
    first, second, third = (iio.imread(tmp_path / f"{n}.png") for n in (1, 2, 3))
    height = SIZE[1]
    assert np.array_equal(first[:height], second[:height]) and not np.array_equal(first[:height], third[:height])
    below = [picture[height:] for picture in (first, second, third)]
    assert [(strip > 60).any() for strip in below] == [False, True, True] and not np.array_equal(*below[1:])
    assert [info(tmp_path / f"{n}.png").rendering.note for n in (1, 2, 3)] == options["notes"]
    made = movie(scenes, tmp_path / "a.gif", caption="none", **options)
    assert [*info(made).notes] == options["notes"]
    assert povgen(["movie", "--from", "a.gif", "-o", "b.gif", "--quiet"], tmp_path) == (0, "", "")
    assert np.array_equal(iio.imread(tmp_path / "b.gif"), iio.imread(made.path)) and info(tmp_path / "b.gif").notes
    assert povgen(["movie", "--from", "a.gif", "-o", "%d.png", "--note", "y", "--quiet"], tmp_path) == (0, "", "")
    assert [info(tmp_path / f"{n}.png").rendering.note for n in (1, 2, 3)] == ["y"] * 3
    for wrong, words in (
        (lambda: movie(scenes, tmp_path / "a.gif", notes=["x"]), "notes: 1 texts for 3 frames; allowed: one for each"),
        (lambda: movie(scenes, tmp_path / "a.gif", notes=["\n"] * 3), "notes = "),
        (lambda: movie(scenes, tmp_path / "%d.exr", notes=["x"] * 3), "notes are drawn with 8 bits"),
        (lambda: movie("vary-alpha", tmp_path / "a.gif", notes=["x"] * 3), "a spec, which states its own; allowed: "),
    ):
        with pytest.raises(InputError, match=words):
            wrong()


def test_notes_of_a_spec_are_for_a_movie_without_a_given_caption(tmp_path):
    spec = ALPHA_MOVIE.replace(frames=3, exact_frames=True, notes=[{"text": "x", "stop": 0.2}])
    for name, options in (("a.gif", {}), ("b.gif", {"caption": "full"}), ("c.gif", {"note": "y"}), ("%d.png", {})):
        movie(spec, tmp_path / name, size=SIZE, progress=False, **options)
    assert [info(tmp_path / name).notes for name in ("a.gif", "b.gif", "c.gif", "1.png")] == [("x", "", ""), (), (), ()]
    assert info(tmp_path / "c.gif").rendering.note == "y"


def test_mp4_starts_at_once_and_seeks_to_any_frame(folder):
    data = movie(ALPHA_MOVIE, folder / "seek.mp4", size=SIZE).path.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")
    stss = data.index(b"stss")
    keyframes = np.frombuffer(data, ">u4", int.from_bytes(data[stss + 8 : stss + 12]), stss + 12)
    assert keyframes[0] == 1 and max(np.diff([*keyframes, 14])) <= 6  # they are counted from 1


@pytest.mark.parametrize(
    ("suffix", "count", "alike", "rate"),
    [
        (".webp", 9, 3, 0.7),
        (".webp", 5, 5, 10),
        (".gif", 9, 2, 50),
        (".gif", 20, 20, 20 / encode.LONGEST_GIF),
    ],
)
def test_a_file_keeps_its_times_and_its_record(suffix, count, alike, rate, tmp_path):
    """Equal successive pictures are written once, and last as long as all of them. One WebP picture has no time."""
    shades = [np.full((32, 48, 3), 20 * (n // alike) % 250, np.uint8) for n in range(count)]
    record = Record(povgen="1", renderer="b" * (600 + count), rendering={}, frames=[{}])
    encode.encode(shades, tmp_path / f"a{suffix}", rate, record)
    assert info(tmp_path / f"a{suffix}") == record
    with Image.open(tmp_path / f"a{suffix}") as made:
        assert made.n_frames == -(-count // alike)
        durations = [made.seek(n) or made.load() and made.info.get("duration") for n in range(made.n_frames)]
        if suffix == ".gif":
            assert sum(durations) == 10 * round(100 * count / rate)
        else:
            assert made.n_frames == 1 or made.info["loop"] == 0 and abs(sum(durations) - 1000 * count / rate) < 2


@given(frames=st.integers(1, 1000), rate=st.floats(0.1, encode.FASTEST_GIF))
@example(frames=3, rate=encode.FASTEST_GIF)
@example(frames=1000, rate=30)
def test_a_gifs_frames_last_as_long_as_its_movie(frames, rate):
    """Each frame starts within half of a hundredth of a second of its time. So rounding errors do not add up."""
    durations = encode.gif_durations(frames, rate)
    starts = np.cumsum([0, *durations]) / 1000
    assert len(durations) == frames and all(duration % 10 == 0 for duration in durations)
    assert np.abs(starts - np.arange(frames + 1) / rate).max() <= 0.005 + 1e-9
    # browsers show a frame of 10 ms or less for 100 ms
    assert min(durations) >= 20


@given(frames=st.integers(1, 10**6), rate=st.floats(0.01, 1000))
def test_a_gif_that_cannot_keep_its_times_is_refused(frames, rate):
    fits = rate <= encode.FASTEST_GIF and frames / rate <= encode.LONGEST_GIF
    if fits:
        encode.check_gif(frames, rate)
        assert sum(encode.gif_durations(frames, rate)) // 10 < 2**16  # a GIF stores a duration in 16 bits
    else:
        with pytest.raises(InputError, match="a GIF of"):
            encode.check_gif(frames, rate)


def test_a_gif_that_needs_too_much_memory_is_refused():
    encode.check_gif(1000, 10, 10**6)
    with pytest.raises(InputError, match="a GIF of 3000 frames of 1000000 pixels: allowed: up to"):
        encode.check_gif(3000, 10, 10**6)


@pytest.mark.parametrize("size", [(9, 7), (24, 40)])
def test_a_gif_shows_the_pictures(size, tmp_path, rng):
    """Parts that change, and up to 256 colours."""
    colours = rng.integers(0, 256, (9, 3), np.uint8)
    pictures = colours[rng.integers(0, 9, size)][np.newaxis].repeat(8, 0)
    for number, picture in enumerate(pictures):
        picture[number : number + 2, 3:5] = 30 * number
    record = Record(povgen="1", renderer="b" * 600, rendering={}, frames=[{}])
    encode.encode(iter(pictures), tmp_path / "a.gif", 7, record)
    shown = [iio.imread(tmp_path / "a.gif", index=n, plugin="pillow")[..., :3] for n in range(len(pictures))]
    assert np.array_equal(shown, pictures)
    with Image.open(tmp_path / "a.gif") as gif:
        assert (gif.n_frames, gif.info["loop"], gif.info["comment"]) == (8, 0, bytes(record))
        durations = [gif.seek(n) or gif.info["duration"] for n in range(8)]
    assert durations == encode.gif_durations(8, 7) and (tmp_path / "a.gif").read_bytes().endswith(b"\0;")
    read = subprocess.run(
        [
            imageio_ffmpeg.get_ffmpeg_exe(),
            "-v",
            "error",
            "-i",
            tmp_path / "a.gif",
            *"-f rawvideo -pix_fmt rgb24 -".split(),
        ],
        capture_output=True,
    )  # another program reads the same
    assert (read.stderr, read.stdout) == (b"", pictures.tobytes())
