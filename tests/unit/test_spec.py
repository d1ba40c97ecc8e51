"""A movie's spec: the values of the swept parameters, and the paper's three movies."""

import re

import numpy as np
import pytest
from conftest import ALPHA_MOVIE, picture

from povgen import Chess, InputError, MovieSpec
from povgen.rendering.views import fitted
from povgen.scene.presets import SCENES
from povgen.scene.spec import MOVIES, Sweep, swept_numbers
from povgen.settings import QUALITIES
from povgen.sheets import PARAMETERS

HEAD = 'title = "A movie"\nscene = "chess"\nframe_rate = 12.5\nframes = 13\n'
PROFILE = "path = [2, 1]\noutline = [{ corners = [[0.1, 0], [0.9, 0], [0.5, 1], [0.1, 0]] }]"


def swept(text, scene="chess", quality="standard", **values):
    """Return the values of the first swept parameter in the scenes of a movie."""
    texts = text.split()
    movie = MovieSpec.of_sweeps(scene, texts, values)
    return [getattr(each, texts[0].partition("=")[0].replace("-", "_")) for each in movie.scenes(quality)]


def test_spec_values():
    alphas = {quality: [scene.alpha for scene in ALPHA_MOVIE.scenes(quality)] for quality in QUALITIES}
    assert alphas["standard"] == pytest.approx(np.arange(0, 181, 15))
    assert [len(alphas[quality]) for quality in ("draft", "standard", "high", "hd")] == [11, 13, 30, 30]
    log = [scene.z1 for scene in MovieSpec.load("vary-z1").replace(ease=False, hold=0).scenes("standard")]
    assert len(log) == 65 and log[0] == pytest.approx(1.2) and log[64] == pytest.approx(12)
    assert np.ptp(np.diff(np.log(log))) < 1e-12


@pytest.mark.parametrize("loop", [False, True])
def test_the_ends_are_held(loop):
    """For half a second each, in every quality. The way back, if there is one, begins and ends with these pictures."""
    spec = ALPHA_MOVIE.replace(hold=0.5, loop=loop)
    for quality in QUALITIES:
        alphas = [scene.alpha for scene in spec.scenes(quality)]
        held, there = round(0.5 * spec.rate(quality)), ALPHA_MOVIE.count(quality)
        assert len(alphas) == spec.count(quality) and held > 3
        assert alphas[: held + 2] == [0] * (held + 1) + alphas[held + 1 : held + 2] and alphas[held + 1] > 0
        last = there + held - 1
        assert alphas[last : last + held + 1] == [180] * (held + 1) and alphas[last - 1] < 180
        assert len(alphas) == last + held + 1 + (there - 2) * loop


@pytest.mark.parametrize("loop", [False, True])
def test_a_value_halfway_is_held_too(loop):
    spec = MovieSpec.load("imaging-gap").replace(loop=loop)
    for quality in QUALITIES:
        gaps = [scene.window[0].z for scene in spec.scenes(quality)]
        held = round(spec.hold * spec.rate(quality))
        there = gaps[: gaps.index(4) + held + 1]
        assert len(gaps) == spec.count(quality) == len(there) + loop * (len(there) - 2 - 2 * held)
        assert there == sorted(there) and gaps.count(2) == (held + 1) * (1 + loop)
        assert abs(there.index(2) + held / 2 - len(there) / 2) <= 1
    eased = MovieSpec.of_sweeps("chess", ["z1=1:16:log"], {}).sweep[0].replace(via=2).in_frames(9)
    assert eased == pytest.approx([*2.0 ** np.linspace(0, 1, 5), *2.0 ** np.linspace(1, 4, 5)[1:]])


def test_each_part_of_a_sweep_has_its_own_ease():
    sweep = Sweep(parameter="alpha", start=0, via=100, stop=200, ease=["start", "stop"])
    way = np.linspace(0, 1, 5)
    expected = [*100 * (1 - np.cos(np.pi / 2 * way)), *(100 + 100 * np.sin(np.pi / 2 * way))[1:]]
    assert sweep.in_frames(9) == sweep.in_frames(9, "both") == pytest.approx(expected)
    assert np.argmax(np.diff(sweep.in_frames(9))) in (3, 4)  # it passes the middle at its greatest speed
    plain = sweep.replace(ease="none", via=None)
    assert plain.in_frames(5, "both") == pytest.approx(200 * way)
    two = MovieSpec(title="x", scene="chess", frames=5, ease=True, sweep=[plain, Sweep.parse("z1=1:3")])
    found = np.array([(scene.alpha, scene.z1) for scene in two.scenes("standard")])
    assert found == pytest.approx(np.column_stack((200 * way, 2 - np.cos(np.pi * way))))


NOTES = '[[notes]]\ntext = "first"\nstop = 0.3\n[[notes]]\ntext = "then"\nstart = 0.3\nstop = 0.6\n'


def test_notes_of_parts_of_a_movie():
    """They follow the way, also while it is held and back; of two at one time the later one counts."""
    start = HEAD.replace("frames = 13", "frames = 11\nexact_frames = true")
    swept = '[[sweep]]\nparameter = "alpha"\nstart = 0\nstop = 180\n'
    spec = MovieSpec.parse(start + swept + NOTES, "notes")
    way = ["first"] * 3 + ["then"] * 4 + [""] * 4
    assert spec.texts("standard") == way and spec.replace(notes=()).texts("standard") == []
    loop = spec.replace(hold=0.2, loop=True, note="else", frame_rate=10)
    way = [text or "else" for text in way]
    assert loop.texts("standard") == way[:1] * 2 + way + way[-1:] * 2 + way[-2:0:-1]
    assert len(loop.texts("draft")) == len(loop.scenes("draft")) == loop.count("draft")
    for table, words in (
        ("text = 3", "[[notes]] text = 3: "),
        ('text = "a"\nstart = 0.5\nstop = 0.4', "[[notes]] stop = 0.4: before start = 0.5; allowed: from start to 1"),
        ('text = "a"\nstop = 1.5', "[[notes]] stop = 1.5: should be less than or equal to 1"),
    ):
        with pytest.raises(InputError, match=re.escape(words)):
            MovieSpec.parse(start + swept + "[[notes]]\n" + table, "notes")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"start": 1, "stop": 3, "ease": ["start", "stop"]}, "ease = ('start', 'stop'): two words; allowed: one, or "),
        ({"start": 1, "stop": 3, "via": 3}, "via = 3: equal to start or stop; allowed: any other value"),
        ({"start": 1, "stop": 3, "via": -1, "spacing": "log"}, "-1 to 3 contains 0; allowed: all values above"),
        (
            {"values": [1, 2], "via": 3},
            "values: given with start, stop, via, spacing or ease; allowed: values, or start",
        ),
    ],
)
def test_a_value_halfway_that_cannot_be_is_refused(values, words):
    with pytest.raises(InputError, match=re.escape(words)):
        MovieSpec(title="a", scene="chess", sweep=[{"parameter": "z1", **values}])


def test_a_complex_number_is_a_point():
    for E in (1 + 1j, np.complex64(1 + 1j), "1,1", (1, 1)):
        assert Sweep(parameter="eye", start=E, stop=0j).ends == ((1, 1), (0, 0))


@pytest.mark.parametrize("spec", [ALPHA_MOVIE, ALPHA_MOVIE.model_copy(update={"loop": True})])
def test_a_movie_lasts_as_long_at_each_quality(spec):
    for quality in ("draft", "standard"):
        steps = len(spec.scenes(quality)) - (0 if spec.loop else 1)
        assert steps / spec.rate(quality) == pytest.approx((24 if spec.loop else 12) / 12.5)
        assert spec.count(quality) == len(spec.scenes(quality))
    # these have 30 frames a second, whatever the movie's frame rate is
    for quality in ("high", "hd"):
        assert spec.rate(quality) == 30 and abs(28.8 - (len(ALPHA_MOVIE.scenes(quality)) - 1)) < 0.5


def test_own_movies_are_the_papers():
    alpha, z1, spheres = (MovieSpec.load(name) for name in ("vary-alpha", "vary-z1", "spheres"))
    found = [(s.alpha, s.z1, s.z2) for s in alpha.scenes("standard")]
    assert [found[0], found[len(found) // 2], found[-1]] == [(0, 2, 6), (pytest.approx(90), 2, 6), (180, 2, 6)]
    assert {(s.alpha, s.z2) for s in z1.scenes("standard")} == {(90, 6)}
    for scene in spheres.scenes("standard"):
        assert scene.distances == tuple(2.0**n * 6 for n in range(-5, 6)) and scene.prisms == 100


def test_the_eye_moves_sideways():
    spec = MovieSpec.parse(
        HEAD + 'loop = true\nease = true\n[[sweep]]\nparameter = "eye"\nstart = [-1, 0.5]\nstop = [1, 0.5]\n',
        "eye",
    )
    eyes = [scene.eye for scene in spec.scenes("standard")]
    assert eyes[0] == (-1, 0.5) and eyes[12] == (1, 0.5) and eyes[6] == pytest.approx((0, 0.5))
    assert eyes[13:] == eyes[11:0:-1]  # back, without the two ends
    x = np.array(eyes[:13])[:, 0]
    assert x == pytest.approx(-np.cos(np.linspace(0, np.pi, 13)))
    assert swept("line=-1,0:1,1", "spheres", frames="3") == [(-1, 0), (0, 0.5), (1, 1)]


def test_several_parameters_and_explicit_values():
    both = MovieSpec.of_sweeps("chess", ["alpha=0:180", "z1=1:16:log"], {"frames": 5, "fixed": {"z2": 8}})
    assert [(s.alpha, round(s.z1, 9), s.z2) for s in both.scenes("standard")] == [
        *((0, 1, 8), (45, 2, 8), (90, 4, 8), (135, 8, 8), (180, 16, 8))
    ]
    tables = '[[sweep]]\nparameter = "prisms"\nvalues = [10, 50.4, 20]\n'
    listed = MovieSpec.parse(HEAD.replace("frames = 13\n", "") + tables, "values")
    for quality in QUALITIES:  # a list has the same frames at each quality
        assert [scene.prisms for scene in listed.scenes(quality)] == [10, 50, 20]
        assert listed.rate(quality) == 12.5 and listed.count(quality) == 3


def test_every_number_of_a_scene_can_be_swept():
    assert swept_numbers(SCENES["chess"]) == {
        **dict.fromkeys(("alpha", "z2", "prisms", "index", "base_angle", "gap", "aspect", "aperture", "view"), 1),
        **{
            "eye": 2,
            "look": 2,
            "pupil": 1,
            "focus": 1,
            "polariser": 1,
            "analyser": 1,
            "z1": 1,
            "x": 1,
            "pedestal": 1,
            "wavelength": 1,
        },
        **{name: 1 for name, (each, *_) in PARAMETERS.items() if each.kind.endswith("number")},
    }
    assert swept_numbers(SCENES["spheres"])["line"] == 2


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "eye=0,0:0,-2 alpha=0:90",
            "frame 65 of 65, alpha = 90: eye = 0,-2: the eye would be under the floor",
        ),
        ("piece=1:2", "parameter = 'piece': cannot be swept; allowed: alpha, prisms, index"),
        ("alpha=1,2:3,4", "alpha = (1.0, 2.0): allowed: a number"),
        ("alpha=0:90 alpha=0:9", "parameter = 'alpha': swept more than once"),
        ("alpha=0:9:cubic", "spacing = 'cubic': unknown (spacing of the values: linear or log)"),
        ("eye=0,1:1,1:log", "spacing = 'log': not for points; allowed: linear"),
    ],
)
def test_what_cannot_be_is_refused(text, words):
    with pytest.raises(InputError) as error:
        swept(text)
    assert words in str(error.value) and len(str(error.value).splitlines()) == 1 and "[[" not in str(error.value)


def test_a_folder_with_the_name_of_a_movie_does_not_hide_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "vary-alpha").mkdir()
    assert MovieSpec.load("vary-alpha") == MovieSpec.load(MOVIES / "vary-alpha.toml")


def test_mountains_are_no_file_beside_the_toml_file(tmp_path):
    text = HEAD + '[fixed]\nsky = "mountains"\n[[sweep]]\nparameter = "z1"\nstart = 4\nstop = 6\n'
    assert MovieSpec.parse(text, "a.toml", tmp_path).scenes("draft")[0].sky is None


def test_files_are_sought_beside_the_toml_file(tmp_path, monkeypatch):
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs/own.inc").write_text("#declare Piece = sphere { 0, 0.5 }")
    (tmp_path / "specs/own.toml").write_text(PROFILE)
    text = '[[sweep]]\nparameter = "z1"\nstart = 4\nstop = 6\n[fixed]\n'
    window = '[[window]]\nz = 3\nsheet = "profile"\nprofile = "own.toml"\n'
    (tmp_path / "specs/a.toml").write_text(HEAD + text + 'piece = ["own.inc", "king"]\nx = [0, 1]\n' + window)
    monkeypatch.chdir(tmp_path)
    (scene, *_) = MovieSpec.load("specs/a.toml").scenes("draft")
    assert scene.piece[0].path == "specs/own.inc" and scene.piece[1] == "king"
    assert scene.window[0].profile.path == "specs/own.toml"
    (tmp_path / "specs/a.toml").write_text(HEAD + text + 'piece = "none.inc"\n')
    assert MovieSpec.load("specs/a.toml", {"piece": "pawn"}).scenes("draft")[0].piece == "pawn"
    with pytest.raises(InputError, match="piece = 'specs/none.inc'"):
        MovieSpec.load("specs/a.toml")


@pytest.mark.parametrize(
    ("text", "outside"),
    [
        ('[fixed]\npiece = ["../own.inc", "king"]\nx = [0, 1]', "own.inc"),
        ('[fixed]\nsky = "link.png"', "picture.png"),
        ('[fixed]\nsheet = "law"\npiece = "../own.inc"', None),
    ],
)
def test_a_file_outside_the_folder_of_the_toml_file_is_named(text, outside, tmp_path, monkeypatch, caplog):
    """Somebody else's TOML file can name a private file, perhaps by a link. The movie's record would contain it."""
    picture(tmp_path)
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs/link.png").symlink_to(tmp_path / "picture.png")
    for folder in (tmp_path, tmp_path / "specs"):
        (folder / "own.inc").write_text("#declare Piece = sphere { 0, 0.5 }")
    (tmp_path / "specs/a.toml").write_text(HEAD + f'[[sweep]]\nparameter = "z1"\nstart = 4\nstop = 6\n{text}')
    monkeypatch.chdir(tmp_path)
    caplog.set_level("WARNING", "povgen")  # a movie with --quiet, of another test, has changed it
    MovieSpec.load("specs/a.toml", {"piece": "pawn"} if "law" in text else {})
    said = f"specs/a.toml names a file outside its folder, {str(tmp_path / str(outside))!r}"
    assert [said in message for message in caplog.messages] == [True] * (outside is not None)


def test_a_whole_number_of_a_window_is_rounded():
    spec = MovieSpec.of_sweeps("chess", ["window2_prisms=20:100"], {"fixed": {"window": "z=5"}, "frames": 4})
    assert [scene.window[0].prisms for scene in spec.scenes("standard")] == [20, 47, 73, 100]
    with pytest.raises(InputError, match="window2_prisms: all values equal after rounding"):
        MovieSpec.of_sweeps("chess", ["window2_prisms=20:20.3"], {"fixed": {"window": "z=5"}})


def test_a_movie_with_a_value_halfway_has_three_frames_or_more():
    sweep = {"parameter": "alpha", "start": 0, "stop": 10, "via": 90}
    spec = MovieSpec(title="a", scene="chess", sweep=[sweep], frames=2, exact_frames=True)
    with pytest.raises(InputError, match="2 frames, none of them at via; allowed: frames = 3 or more"):
        spec.scenes("draft")
    assert [scene.alpha for scene in spec.replace(frames=3).scenes("draft")] == [0, 90, 10]


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        ("values = [1, 2, 3]", "values: 3 and 13 frames"),
        ("values = [1, 2, 3]\nstart = 1", "values: given with start"),
        ("start = true\nstop = 2", "start = True: should not be true or false"),
    ],
)
def test_a_table_that_is_none(sweep, words):
    with pytest.raises(InputError) as error:
        MovieSpec.parse(HEAD + f'[[sweep]]\nparameter = "z1"\n{sweep}\n', "a.toml")
    assert str(error.value).startswith("a.toml: [[sweep]]") and words in str(error.value)


def test_a_frame_in_the_middle_that_cannot_be_is_refused():
    pole = {"frames": 5, "fixed": {"alpha": 180, "sheet": "ideal", "predicted_image": True}}
    spec = MovieSpec.of_sweeps("chess", ["z1=3:9"], pole)
    with pytest.raises(InputError, match="frame 3 of 5, z1 = 6: predicted_image = true: at alpha = 180, z1 = 6 and z2"):
        spec.scenes("standard")


def test_a_title_has_up_to_200_characters():
    values = {"scene": "chess", "sweep": [Sweep.parse("alpha=0:1")]}
    assert len(MovieSpec(title="é" * 200, **values).title) == 200
    for title in ("é" * 201, ""):
        with pytest.raises(InputError, match="^title = .*: is not allowed .* up to 200 characters"):
            MovieSpec(title=title, **values)


def test_too_many_frames_at_a_quality():
    slow = MovieSpec.of_sweeps("chess", ["alpha=0:180"], {"frames": 10000, "frame_rate": 0.1})
    with pytest.raises(InputError, match="quality = 'hd': 2999701 frames, with loop and hold; allowed: up to 30000"):
        slow.scenes("hd")


def test_the_ends_of_a_range_are_exact():
    for spacing, start, ease in (("log", 0.1, "none"), ("linear", -350.7, "both")):
        found = Sweep(parameter="alpha", start=start, stop=360, spacing=spacing).in_frames(7, ease)
        assert (found[0], found[-1]) == (start, 360)
        middle = (start * 360) ** 0.5 if spacing == "log" else (start + 360) / 2
        assert found[3] == pytest.approx(middle) and (found[1] - start < (360 - start) / 8) == (
            ease == "both" or spacing == "log"
        )


def test_a_movie_keeps_its_scale():
    """Its view is the largest that a frame needs, unless it is given."""
    spec = MovieSpec.of_sweeps("chess", ["prisms=10:100"], {"frames": 3})
    for size, scene in (((64, 48), Chess(prisms=10)), ((48, 64), *fitted([Chess(prisms=10)], (48, 64)))):
        assert {each.view for each in fitted(spec.scenes("standard"), size)} == {scene.view}
    assert {each.view for each in fitted(spec.with_fixed({"view": 3}).scenes("standard"), (48, 64))} == {3}


def test_there_and_back_in_one_sweep():
    way = Sweep(parameter="alpha", start=0, via=90, stop=0)
    movie = MovieSpec(title="a", scene="chess", sweep=[way], frames=3, hold=0)
    assert [scene.alpha for scene in movie.scenes("standard")] == [0, 90, 0]
