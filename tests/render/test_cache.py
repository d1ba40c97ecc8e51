"""The cache: which folder it may use, which files count as a frame, and what is removed."""

import errno
import io
import multiprocessing
import os
import pwd
import shutil
import stat
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import platformdirs
import pytest
from conftest import povgen, refused, tree
from PIL import Image

from povgen import Chess, InputError, Rendering, Spheres, files, movie, optics, sheets, to_pov
from povgen.errors import TransientError
from povgen.rendering import cache, frames, surveys
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


@pytest.mark.release
def test_several_make_a_cache_at_once(place):
    def work(ready, outcomes):
        try:
            for number in range(30):
                os.environ["POVGEN_CACHE"] = f"{place}/{number}"
                ready.wait(200)
                rendered()
            outcomes.put("done")
        except BaseException as error:
            outcomes.put(repr(error))

    fork = multiprocessing.get_context("fork")
    ready, outcomes = fork.Barrier(3), fork.Queue()
    workers = [fork.Process(target=work, args=(ready, outcomes)) for _ in range(3)]
    for worker in workers:
        worker.start()
    assert [outcomes.get(timeout=200) for _ in workers] == ["done"] * 3
    for worker in workers:
        worker.join()


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
    user = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: user + 1)
    own.rename(tmp_path / f"povgen-{user + 1}")
    with pytest.raises(InputError, match="another user's folder"):
        rendered()


# ---- what counts as kept


@pytest.mark.parametrize("damage", ["truncated", "a bit turned", "empty", "another file", "of another size"])
def test_a_damaged_frame_is_rendered_again(damage):
    rendered()
    kept = cache.frame_path(to_pov(SCENE), SMALL)
    whole = kept.read_bytes()
    middle = len(whole) // 2
    kept.write_bytes(
        {
            "truncated": whole[:-20],
            "a bit turned": whole[:middle] + bytes([whole[middle] ^ 16]) + whole[middle + 1 :],
            "empty": b"",
            "another file": b"GIF89a" + whole,
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


def test_what_is_in_a_frames_place_stays(place):
    """povgen says what it cannot write."""
    cache.made()
    cache.frame_path(to_pov(SCENE), SMALL).mkdir(parents=True)
    before = tree(place)
    with pytest.raises(OSError, match="Is a directory"):
        rendered()
    assert tree(place) == before


@pytest.mark.parametrize("number", [errno.EPERM, errno.EROFS])
def test_a_frame_that_cannot_be_changed_is_used(number, monkeypatch):
    """It is another user's, or on a read-only disk."""
    rendered()

    def refused(*given, **options):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "utime", refused)
    assert not rendered()[1]


# ---- how long it is kept


def test_a_time_of_use_that_is_to_come_protects_nothing():
    scenes = [Chess(sheet="none", z1=z1) for z1 in (2, 3, 4)]
    list(frames.render_all(scenes, SMALL, runner=StandIn()))
    places = [cache.frame_path(to_pov(scene), SMALL) for scene in scenes]
    for path, hours in zip(places, (-2, 1000, -1), strict=True):
        os.utime(path, (time.time() + 3600 * hours, path.stat().st_mtime))
    assert [path for _, _, path in cache.by_last_use()] == [places[1], places[0], places[2]]
    assert cache.trim(2 * places[0].stat().st_size) == [places[1]]


def test_a_file_of_another_user_does_not_count_as_removed(monkeypatch, place):
    """The limit is kept as far as this user's files allow."""
    for n in range(4):
        rendered(SCENE.replace(view=3 + n))
    files = [path for _, _, path in cache.by_last_use()]
    sizes = [path.stat().st_size for path in files]
    unlink = Path.unlink

    def of_others(path, **more):
        if path == files[0]:
            raise PermissionError
        unlink(path, **more)

    monkeypatch.setattr(Path, "unlink", of_others)
    assert cache.trim(sum(sizes) - 1) == [files[1]]


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


def test_a_cache_on_a_read_only_disk(monkeypatch, tmp_path):
    """To remove a file fails with another error than without permission."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    list(frames.render_all([Chess(sheet="none")], SMALL, runner=StandIn()))

    def read_only(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", read_only)
        status, out, err = povgen(["cache", "clear"], tmp_path)
        assert status == 1 and out.startswith("removed 0 frames") and "files that could not be removed: 1" in err
        patch.setattr(os, "access", lambda *_: False)
        patch.setattr(os, "statvfs", lambda _: SimpleNamespace(f_flag=os.ST_RDONLY))
        with pytest.raises(OSError, match="Read-only file system"):
            cache.made()
    assert povgen(["cache", "clear"], tmp_path)[:2] == (
        0,
        f"removed 1 frame, 0 ray traces and pieces from {tmp_path}/cache\n",
    )


def test_a_frame_that_is_rendered_again_while_the_cache_is_cleared_could_be_removed(monkeypatch, tmp_path):
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    list(frames.render_all([Chess(sheet="none")], SMALL, runner=StandIn()))
    trim = cache.trim

    def again(most):
        removed = trim(most)
        list(frames.render_all([Chess(sheet="none")], SMALL, runner=StandIn()))
        return removed

    monkeypatch.setattr(cache, "trim", lambda most: again(most) if most < 0 else trim(most))
    assert povgen(["cache", "clear"], tmp_path)[0] == 0


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
            assert not ran and surveys.found(scene) == found
        return len(traced)

    assert again() == 0
    whole = kept.read_bytes()
    kept.write_bytes(whole.replace(b"trace_level", b"trace_bevel"))
    assert again() == 1 and kept.read_bytes() == whole and again() == 0
    monkeypatch.setattr(surveys, "_code_of_trace", lambda: "another")
    assert again() == 1


def test_warnings_need_no_rays_again(monkeypatch, capsys):
    from povgen.cli.report import warn

    scene = Chess(z2=2, prisms=31)
    rendered(scene)
    monkeypatch.setattr(survey, "of_inputs", lambda given: pytest.fail("traced again"))
    warn({}, [scene], SMALL)
    assert "z2 = 2" in capsys.readouterr().err


# ---- outputs


@pytest.mark.parametrize("made", ["data", "file"])
def test_an_output_keeps_its_mode(made, tmp_path):
    def saved(name):
        (tmp_path / "made").write_bytes(b"new")
        files.save(b"new" if made == "data" else tmp_path / "made", tmp_path / name)
        assert (tmp_path / name).read_bytes() == b"new"
        return stat.S_IMODE((tmp_path / name).stat().st_mode)

    for mode in (0o600, 0o640, 0o664, 0o755):
        (tmp_path / f"{mode}").write_bytes(b"old")
        (tmp_path / f"{mode}").chmod(mode)
        assert saved(f"{mode}") == mode
    umask = os.umask(0o027)
    try:
        assert saved("new") == 0o640
    finally:
        os.umask(umask)


def test_an_output_that_cannot_be_written_stays(tmp_path, monkeypatch):
    """As on a full disk. No unfinished file is left."""
    (tmp_path / "a").write_bytes(b"old")

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", full)
        with pytest.raises(OSError, match=r"No space.*/a'"):
            files.save(b"new", tmp_path / "a")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("a", b"old")]


def test_a_survey_belongs_to_all_code_that_makes_it(tmp_path, monkeypatch):
    """A survey is made anew after a change in any module of povgen.optics or povgen.sheets."""
    checksum = surveys._code_of_trace.__wrapped__
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
