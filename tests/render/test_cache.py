"""The cache: which folder it may use, which files count as a frame, and what is removed."""

import errno
import io
import json
import multiprocessing
import os
import pwd
import re
import shutil
import signal
import stat
import struct
import subprocess
import tempfile
import time
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import platformdirs
import pytest
from conftest import POVGEN, povgen, refused, tree
from PIL import Image

from povgen import Chess, InputError, Rendering, Spheres, files, movie, optics, sheets, to_pov
from povgen.rendering import cache, frames, surveys
from povgen.scene import survey
from povgen.video import encode, still

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

    def run(self, source, rendering, folder):
        self.ran += 1
        (folder / rendering.file).write_bytes(file(COLOURS))
        return folder / rendering.file

    def stop(self):
        pass


def rendered(scene=SCENE):
    """Return the frame, and whether it had to be rendered."""
    runner = StandIn()
    ((png,),) = frames.render_all([scene], SMALL, runner=runner)
    return frames.read_png(png), bool(runner.ran)


# ---- whose folder


@pytest.mark.parametrize("content", ["uk/holiday.png", "a", "CACHEDIR.TAG", f"ab/{'ab' * 32}.png"])
def test_a_folder_that_is_not_a_cache_is_refused(content, tmp_path, place):
    """By every command, and no file in it is touched."""
    (place / content).parent.mkdir(parents=True)
    (place / content).write_bytes(b"Signature: 8a477f597d28d172789f06886806bc55\n")
    before = tree(tmp_path)
    for work in (
        rendered,
        cache.check,
        cache.work_folder,
        lambda: still.render(SCENE),
        lambda: movie("spheres", "a.gif"),
    ):
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
    os.mkfifo(place / "ab" / f"{'ab' * 32}.png")
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
        with pytest.raises(InputError, match="POVGEN_CACHE = .*: another user's folder, to which every user can write"):
            rendered()


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
    for spoil in (lambda: own.chmod(0o755), lambda: own.rename(tmp_path / "a") and own.symlink_to(tmp_path / "a")):
        spoil()
        with pytest.raises(PermissionError, match="other users can use it.*POVGEN_CACHE"):
            rendered()


# ---- what counts as kept


def png_of(width, height, depth, colour, data, interlace=0):
    def chunk(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, interlace)
    pixels = b"" if data is None else chunk(b"IDAT", data)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + pixels + chunk(b"IEND", b"")


WRONG = {
    "another size": file(COLOURS[:32]),
    "grey": file(COLOURS[..., 0]),
    "transparent": file(np.dstack((COLOURS, COLOURS[..., :1]))),
    "a palette": png_of(32, 34, 8, 3, b""),
    "16 bits": png_of(32, 34, 16, 2, zlib.compress(bytes(34 * (1 + 6 * 32)))),
    "a bomb": png_of(30000, 30000, 8, 2, zlib.compress(bytes(10**6))),
    "no PNG": b"GIF89a" + bytes(1000),
    # these have the right checksums
    "pixels that are no data": png_of(32, 34, 8, 2, b"pixels"),
    "too few pixels": png_of(32, 34, 8, 2, zlib.compress(bytes(33 * (1 + 3 * 32)))),
    "an unknown filter": png_of(32, 34, 8, 2, zlib.compress(34 * (b"\t" + bytes(3 * 32)))),
    "no pixels": png_of(32, 34, 8, 2, None),
    "no parts": file(COLOURS)[:8],
    "a wrong checksum": file(COLOURS)[:-1] + b"x",
    "interlaced": png_of(32, 34, 8, 2, zlib.compress(bytes(34 * (1 + 3 * 32))), interlace=1),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_frame_that_cannot_be_this_one_is_rendered_again(wrong):
    rendered()
    kept = cache.frame_path(to_pov(SCENE), SMALL)
    kept.write_bytes(WRONG[wrong])
    for again in (True, False):
        picture, ran = rendered()
        assert np.array_equal(picture, COLOURS) and ran == again


def test_a_file_larger_than_any_frame_is_not_read():
    rendered()
    kept = cache.frame_path(to_pov(SCENE), SMALL)
    with kept.open("ab") as opened:
        opened.truncate(2**40)
    picture, ran = rendered()
    assert ran and np.array_equal(picture, COLOURS) and kept.stat().st_size < 2**20


@pytest.mark.parametrize("what", ["a folder", "a FIFO", "a link", "a shelf that is a file", "a shelf that is a link"])
def test_what_is_in_a_frames_place_stays(what, tmp_path):
    """The frame is returned and not stored: what is there is not povgen's."""
    with cache.work_folder():
        kept = cache.frame_path(to_pov(SCENE), SMALL)
    if "shelf" not in what:
        kept.parent.mkdir()
    (tmp_path / "other").mkdir()
    {
        "a folder": kept.mkdir,
        "a FIFO": lambda: os.mkfifo(kept),
        "a link": lambda: kept.symlink_to(tmp_path / "other" / "a.png"),
        "a shelf that is a file": lambda: kept.parent.write_bytes(b"x"),
        "a shelf that is a link": lambda: kept.parent.symlink_to(tmp_path / "other"),
    }[what]()
    before = tree(tmp_path)
    for _ in range(2):
        picture, ran = rendered()
        assert ran and np.array_equal(picture, COLOURS)
    assert tree(tmp_path) == before


@pytest.mark.parametrize("number", [errno.EPERM, errno.EROFS])
def test_a_frame_that_cannot_be_changed_is_used(number, monkeypatch):
    """It is another user's, or on a read-only disk."""
    rendered()

    def refused(*given, **options):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "utime", refused)
    assert not rendered()[1]


def test_a_message_names_another_folder_only_where_it_helps(monkeypatch):
    for number, helps in ((errno.EROFS, True), (errno.EMFILE, False)):

        def refused(*given, number=number, **options):
            raise OSError(number, os.strerror(number))

        monkeypatch.setattr(Path, "mkdir", refused)
        with pytest.raises(OSError, match=re.escape(os.strerror(number))) as fault:
            cache.work_folder()
        assert (cache.HINT in fault.value.strerror) == helps


# ---- how long it is kept


def test_a_time_of_use_that_is_to_come_protects_nothing():
    scenes = [Chess(sheet="none", z1=z1) for z1 in (2, 3, 4)]
    list(frames.render_all(scenes, SMALL, runner=StandIn()))
    places = [cache.frame_path(to_pov(scene), SMALL) for scene in scenes]
    for path, hours in zip(places, (-2, 1000, -1), strict=True):
        os.utime(path, (time.time() + 3600 * hours, path.stat().st_mtime))
    assert [path for _, _, path in cache.by_last_use()] == [places[1], places[0], places[2]]
    assert cache.trim(2 * len(file(COLOURS))) == [places[1]]


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


def test_a_home_folder_in_the_caches_name(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("POVGEN_CACHE", "~/own")
    assert cache.folder() == tmp_path / "own"


def test_a_cache_of_no_size_delivers(monkeypatch, tmp_path):
    """Frames are rendered, from Python as well, and none is kept."""
    monkeypatch.setenv("POVGEN_CACHE_SIZE", "0")
    done = subprocess.run(
        [POVGEN, "frame", "chess", "--prisms", "9", "--size", "32x34", "--quiet", "-o", "z.png"], cwd=tmp_path
    )
    picture = still.render(Chess(prisms=9), size=(32, 34))
    assert done.returncode == 0 and np.array_equal(frames.read_png(tmp_path / "z.png"), picture)
    assert still.as_file(Chess(sheet="none"))
    assert not cache.by_last_use()


def test_a_cache_that_is_cleared_at_any_moment(monkeypatch):
    """A frame that another povgen has removed is rendered again."""
    keep = cache.store
    monkeypatch.setattr(cache, "store", lambda *given: keep(*given) and bool(cache.trim(-1)))
    scenes = [Chess(sheet="none", z1=z1) for z1 in (2, 3, 4)]
    found = [frames.read_png(png) for (png,) in frames.render_all(scenes, SMALL, runner=StandIn())]
    assert np.array_equal(found, [COLOURS] * 3)


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
            cache.work_folder()
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


class Removing(StandIn):
    """Removes the cache before or after it has rendered, the first few times."""

    def __init__(self, place, when, times):
        self.place, self.when, self.times = place, when, times

    def run(self, source, rendering, folder):
        if self.when == "before" and self.ran < self.times:
            shutil.rmtree(self.place)
        picture = super().run(source, rendering, folder)
        if self.when == "after" and self.ran <= self.times:
            os.rename(picture, self.place.parent / "picture")
            shutil.rmtree(self.place)
        return picture


@pytest.mark.parametrize("when", ["before", "after"])
def test_a_cache_that_is_removed_while_a_frame_is_rendered(when, place):
    runner = Removing(place, when, 2)
    ((png,),) = frames.render_all([SCENE], SMALL, runner=runner)
    assert np.array_equal(frames.read_png(png), COLOURS) and runner.ran == 3
    assert not rendered()[1]
    with pytest.raises(FileNotFoundError) as removed:
        list(frames.render_all([Chess(sheet="none", z1=3)], SMALL, runner=Removing(place, when, 99)))
    assert removed.value.strerror == "removed while povgen used it"


def test_a_frame_whose_shelf_is_removed_is_delivered(monkeypatch, place):
    store = cache.store
    monkeypatch.setattr(cache, "store", lambda *given: shutil.rmtree(place) or store(*given))
    assert np.array_equal(rendered()[0], COLOURS)


def test_a_cache_that_is_removed_while_a_movie_is_encoded(monkeypatch, tmp_path, place, caplog):
    encoded, own = [], encode.encode
    caplog.set_level("WARNING", "povgen")  # a movie with --quiet, of another test, has changed it

    def removed(pictures, output, *others):
        pictures = list(pictures)
        encoded.append(len(pictures))
        if len(encoded) == 1:
            shutil.rmtree(place)
        own(pictures, output, *others)

    monkeypatch.setattr(encode, "encode", removed)
    movie([Chess(sheet="none", z1=z1) for z1 in (2, 3)], tmp_path / "a.gif", size=(32, 32), antialias="off")
    assert encoded == [2, 2] and "the cache was removed" in caplog.text
    with Image.open(tmp_path / "a.gif") as made:
        assert made.n_frames == 2


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
    text = kept.read_text()
    checksum, values = text.split("\n")
    cache.store_values("another key", {"trace_level": 5, "designed": 0.1})
    (another,) = (path for _, _, path in cache.by_last_use() if path.suffix == ".values" and path != kept)
    for damaged in (
        "",
        text[:20],
        checksum,
        values,
        "[" * 99999,
        f"{checksum}\n" + json.dumps({"trace_level": 5, "designed": 0.1}),
        text + " ",
        another.read_text(),
    ):
        kept.write_text(damaged)
        assert again() == 1 and kept.read_text() == text and again() == 0
    with kept.open("a") as opened:
        opened.truncate(2**40)
    assert again() == 1 and kept.read_text() == text
    monkeypatch.setattr(surveys, "_code_of_trace", lambda: "another")
    assert again() == 1


def test_warnings_need_no_rays_again(monkeypatch, capsys):
    from povgen.cli.report import warn

    scene = Chess(z2=2, prisms=31)
    rendered(scene)
    monkeypatch.setattr(survey, "of_inputs", lambda given: pytest.fail("traced again"))
    warn({}, [scene], SMALL)
    assert "z2 = 2" in capsys.readouterr().err


@pytest.mark.parametrize("fault", [None, "ends", "hangs", "does not start"])
def test_surveys_of_many_scenes_are_made_by_several_processes(fault, monkeypatch):
    """They are those that this process makes. Those of a process that fails are made here."""
    started, start = [], surveys.python

    def python(name):
        if started and fault == "does not start":
            raise OSError(errno.EAGAIN, "no more processes")
        started.append(start("no_module" if started and fault == "ends" else name))
        if fault == "hangs":
            started[-1].send_signal(signal.SIGSTOP)
        return started[-1]

    monkeypatch.setattr(surveys, "cores", lambda: 2)
    monkeypatch.setattr(surveys, "python", python)
    monkeypatch.setattr(surveys, "EACH", 8)
    if fault == "hangs":
        monkeypatch.setattr(surveys, "START", 0.1)
        monkeypatch.setattr(surveys, "SECONDS", 0.01)
    scenes = [
        *(Chess(alpha=alpha) for alpha in range(8)),
        *(Chess(sheet="lenticular", f_number=8, alpha=alpha) for alpha in range(4)),
        *(Chess(sheet="law", law="x - k*X*z, y, z", parameter={"k": k}, window="z=1,sheet=detailed") for k in range(4)),
        Chess(sheet="ideal"),
    ]
    scenes[-2].apparent_position(0j, 1)
    made = [survey._traced(survey.inputs(scene)) for scene in scenes[:-1]]
    monkeypatch.setattr(survey, "known", {})
    surveys.make([*scenes[:1], *scenes])
    assert len(started) == 1 + (fault != "does not start")
    assert all(process.poll() is not None for process in started)
    assert len(survey.known) == {None: 16, "hangs": 0}.get(fault, 8)
    if not fault:
        monkeypatch.setattr(survey, "_traced", lambda given: pytest.fail("traced again"))
    assert [surveys.found(scene, store=True) for scene in scenes] == [*made, None]
    survey.known.clear()
    surveys.make(scenes)  # they are in the cache
    assert not survey.known and len(started) == 1 + (fault != "does not start")


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


def test_a_movie_is_encoded_in_the_cache(monkeypatch, tmp_path, place):
    """A killed povgen's unfinished movie is counted there. The finished movie gets the mode of the file it replaces."""
    seen, own = [], encode.encode
    monkeypatch.setattr(encode, "encode", lambda *given: seen.append(given[1]) or own(*given))
    (tmp_path / "out").mkdir()
    target = tmp_path / "out" / "a.gif"
    target.touch(mode=0o600)
    movie([Spheres(), Spheres(alpha=50)], target, size=(32, 32), antialias="off", quality="draft")
    assert seen[0].parent.parent == place and stat.S_IMODE(target.stat().st_mode) == 0o600
    assert target.read_bytes().startswith(b"GIF89a") and os.listdir(tmp_path / "out") == ["a.gif"]
    assert not list(place.glob(f"{files.WORK_PREFIX}*"))


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
