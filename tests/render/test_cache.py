"""The cache: which folder it may use, which files count as a frame, and what is removed."""

import io
import os
import pwd
import shutil
import stat
import tempfile
from pathlib import Path

import numpy as np
import platformdirs
import pytest
from conftest import povgen, refused, tree
from PIL import Image

from povgen import Chess, InputError, Rendering, Spheres, files, movie, optics, sheets, to_pov
from povgen.errors import TransientError
from povgen.rendering import cache, frames, survey_cache
from povgen.scene import survey

SCENE = Chess(sheet="none")
SMALL = Rendering(size=(32, 34), antialias="off")
COLOURS = np.random.default_rng(3).integers(0, 256, (34, 32, 3), np.uint8)


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """A cache of the test's own."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def file(colours, mode=None):
    data = io.BytesIO()
    Image.fromarray(colours, mode).save(data, "PNG")
    return data.getvalue()


class StandIn:
    """Replaces POV-Ray, because these tests are about the cache."""

    ran = 0
    made = None

    def run(self, source, rendering, folder):
        self.ran += 1
        (folder / rendering.file).write_bytes(self.made or file(COLOURS))
        return folder / rendering.file

    def stop(self):
        pass


def rendered(scene=SCENE):
    """Return the frame, and whether it had to be rendered."""
    runner = StandIn()
    ((png,),) = frames.render_all([scene], SMALL, runner=runner)
    return frames.read_png(png), bool(runner.ran)


# ---- whose folder


@pytest.mark.parametrize("content", ["uk/holiday.png", "CACHEDIR.TAG"])
def test_a_folder_that_is_not_a_cache_is_refused(content, tmp_path, place):
    """By every command, and no file in it is touched."""
    (place / content).parent.mkdir(parents=True)
    (place / content).write_bytes(b"Signature: 8a477f597d28d172789f06886806bc55\n")
    before = tree(tmp_path)
    for work in (rendered, cache.made, lambda: movie("spheres", "a.gif")):
        with pytest.raises(InputError, match=r"POVGEN_CACHE = '.*': a folder that holds other things.*; allowed: "):
            work()
    for arguments in (["frame", "chess"], ["demo"], ["figure", "1"], ["cache", "info"], ["cache", "clear"]):
        assert refused(arguments, tmp_path).startswith("povgen: POVGEN_CACHE = ")
    assert tree(tmp_path) == before


@pytest.mark.parametrize("begun", [None, b""])
def test_a_cache_is_marked(begun, place):
    """Also if povgen was killed while it marked it. A marked cache may hold other files, which stay."""
    place.mkdir()
    if begun is not None:
        (place / cache.TAG).write_bytes(begun)
    assert rendered()[1]
    assert (place / cache.TAG).read_text().startswith("Signature: 8a477f597d28d172789f06886806bc55\n")
    name = cache.frame_path(to_pov(SCENE), SMALL).name
    others = "uk/holiday.png", "ab/holiday.png", f"cd/{name}", "note", f"{name[:2]}/{name}.txt"
    for other in map(place.joinpath, others):
        other.parent.mkdir(exist_ok=True)
        other.write_bytes(b"x")
    (place / "ff").symlink_to(place / "uk")
    (place / "uk" / f"{'ff' * 32}.png").write_bytes(b"x")
    (place / "cd" / f"{'cd' * 32}.png").symlink_to(place / "note")
    before = tree(place)
    assert cache.trim(-1) == [place / name[:2] / name]
    del before[place / name[:2] / name]
    assert tree(place) == before


@pytest.mark.parametrize(("mode", "another", "allowed"), [(0o777, 1, False), (0o775, 1, True), (0o777, 0, True)])
def test_another_users_cache(mode, another, allowed, monkeypatch, place):
    """Into one that every user can write to, everyone could put pictures."""
    rendered()
    place.chmod(mode)
    user = os.geteuid() + another
    monkeypatch.setattr(os, "geteuid", lambda: user)
    if allowed:
        assert not rendered()[1]
    else:
        with pytest.raises(InputError, match="POVGEN_CACHE = .*: another user's folder, which others can use"):
            rendered()


def test_a_user_without_a_home(monkeypatch, tmp_path):
    """Nor an entry in the list of users: the cache is among temporary files, for this user alone."""

    def nobody(number):
        raise KeyError(number)

    for name in ("HOME", "XDG_CACHE_HOME", "POVGEN_CACHE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(pwd, "getpwuid", nobody)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    own = tmp_path / f"povgen-{os.geteuid()}"
    assert cache.folder() == own
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: Path("~/.cache", name))  # as releases before 4.4
    assert rendered()[1] and cache.folder() == own and stat.S_IMODE(own.stat().st_mode) == 0o700
    assert not rendered()[1]


# ---- what counts as kept


@pytest.mark.parametrize("damage", ["a bit turned", "empty", "of another size"])
def test_a_damaged_frame_is_rendered_again(damage):
    rendered()
    kept = cache.frame_path(to_pov(SCENE), SMALL)
    whole = kept.read_bytes()
    middle = len(whole) // 2
    kept.write_bytes(
        {
            "a bit turned": whole[:middle] + bytes([whole[middle] ^ 16]) + whole[middle + 1 :],
            "empty": b"",
            "of another size": file(COLOURS[:32]),
        }[damage]
    )
    for again in (True, False):
        picture, ran = rendered()
        assert np.array_equal(picture, COLOURS) and ran == again
    assert kept.read_bytes() == whole


@pytest.mark.parametrize("wrong", [COLOURS[:32], COLOURS[..., 0], None], ids=["another size", "grey", "cut off"])
def test_what_a_renderer_makes_is_checked(wrong):
    """POV-Ray does not say that the disk is full."""
    runner = StandIn()
    runner.made = file(COLOURS)[:-100] if wrong is None else file(wrong)
    with pytest.raises(TransientError, match="the picture is not whole"):
        list(frames.render_all([SCENE], SMALL, runner=runner))
    assert not cache.by_last_use()


# ---- how long it is kept


def test_the_cache_keeps_to_its_size(place, monkeypatch, tmp_path):
    """Frames that were used again are kept. Without any room frames are rendered, and none is kept."""
    scenes = [Chess(sheet="none", z1=2 + n) for n in range(12)]
    list(frames.render_all(scenes, SMALL, runner=StandIn()))
    first = [cache.frame_path(to_pov(scene), SMALL) for scene in scenes[:-1]]
    assert all(map(cache.read, first[:4]))  # used again
    size = sum(path.stat().st_size for path in first[:5])
    monkeypatch.setenv("POVGEN_CACHE_SIZE", str(size / 2**30))
    list(frames.render_all(scenes[:1], SMALL, runner=StandIn()))
    kept = {path for _, _, path in cache.by_last_use()}
    assert {*first[:4]} < kept and len(kept) == 5
    assert povgen(["cache", "info"], place)[1].startswith("5 frames, 0 ray traces and pieces, 0.000 of ")
    assert povgen(["cache", "clear"], place)[1].startswith("removed 5 frames") and not cache.by_last_use()
    monkeypatch.setenv("POVGEN_CACHE_SIZE", "0")
    assert rendered()[1] and not cache.by_last_use()
    monkeypatch.setenv("POVGEN_CACHE_SIZE", "much")
    assert "POVGEN_CACHE_SIZE = 'much': allowed" in refused(["frame", "chess"], tmp_path)


@pytest.mark.parametrize("after", [cache.store, cache.read], ids=["stored", "read"])
def test_a_cache_that_is_removed_at_any_moment(after, place, monkeypatch):
    """A frame that another povgen has removed is rendered again."""
    monkeypatch.setattr(cache, after.__name__, lambda *given: [after(*given), shutil.rmtree(place, True)][0])
    for z1 in (2, 3):
        assert np.array_equal(rendered(SCENE.replace(z1=z1))[0], COLOURS)


# ---- ray traces


def test_rays_are_traced_once(monkeypatch):
    """Surveys are kept until the code that makes them changes."""
    scene = Spheres(prisms=30, z2=7)
    rendered(scene)
    found = survey.survey(scene)
    (kept,) = (path for _, _, path in cache.by_last_use() if path.suffix == ".values")

    def again():
        traced = []
        trace = survey.of_inputs
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(survey, "of_inputs", lambda given: traced.append(given) or trace(given))
            _, ran = rendered(scene)
            assert not ran and survey_cache.found(scene) == found
        return len(traced)

    assert again() == 0
    whole = kept.read_bytes()
    kept.write_bytes(whole.replace(b"trace_level", b"trace_bevel"))
    assert again() == 1 and kept.read_bytes() == whole and again() == 0
    monkeypatch.setattr(survey_cache, "_code_of_trace", lambda: "another")
    assert again() == 1


# ---- outputs


@pytest.mark.parametrize("made", ["data", "file"])
def test_an_output_keeps_its_mode(made, tmp_path):
    def saved(name):
        (tmp_path / "made").write_bytes(b"new")
        files.write(b"new" if made == "data" else tmp_path / "made", tmp_path / name)
        assert (tmp_path / name).read_bytes() == b"new"
        return stat.S_IMODE((tmp_path / name).stat().st_mode)

    for mode in (0o600, 0o640, 0o664, 0o755):
        (tmp_path / f"{mode}").write_bytes(b"old")
        (tmp_path / f"{mode}").chmod(mode)
        assert saved(f"{mode}") == mode


def test_a_survey_belongs_to_all_code_that_makes_it(tmp_path, monkeypatch):
    """A survey is made anew after a change in any module of povgen.optics or povgen.sheets."""
    checksum = survey_cache._code_of_trace.__wrapped__
    before = checksum()
    for package in (optics, sheets):
        copied = shutil.copytree(package.__path__[0], tmp_path / package.__name__)
        monkeypatch.setattr(package, "__path__", [str(copied)])
    assert checksum() == before
    for name in ("optics/trace", "optics/faces", "sheets/layered", "sheets/crossed"):
        with open(tmp_path / f"povgen.{name}.py", "a") as file:
            file.write("# changed")
        assert checksum() != before
        before = checksum()
