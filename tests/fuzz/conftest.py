"""How a case is run: in a folder of its own, without POV-Ray, and what every case must fulfil."""

import io
import os
import re
import shutil
import warnings
from pathlib import Path
from unittest import mock

import imageio.v3 as iio
import numpy as np
import pytest
from conftest import Stream, povgen
from hypothesis import HealthCheck, Phase, settings
from PIL import Image

from fuzz.values import FIELDS, OPTIONS, SDL
from povgen import Chess, MovieSpec, Spheres
from povgen.record import Record, in_png
from povgen.scene.spec import Sweep
from povgen.version import __version__

ran = 0  # cases


def cases(few):
    """Run a test on `few` cases, the same each time, and for a release on 48 times as many.

    It fails if more than half of them were not run.
    """

    def counted(test):
        def run(count):
            fuzz = settings(
                max_examples=count,
                deadline=None,
                derandomize=True,
                database=None,
                phases=(Phase.explicit, Phase.generate, Phase.shrink),
                suppress_health_check=list(HealthCheck),
            )(test)
            before = ran
            fuzz()
            assert ran - before >= count / 2, f"only {ran - before} of {count} cases were run"

        return pytest.mark.parametrize("count", [few, pytest.param(48 * few, marks=pytest.mark.release)])(run)

    return counted


ROOT = Path("/")  # of all that cases may touch; set by the fixture, as is WORK, the folder that they work in
WORK = Path("/a/b/c")
SPEC = """\
title = "A movie"
scene = "chess"
frame_rate = 10
frames = 2
[fixed]
z1 = 2
sheet = "ideal"
[[sweep]]
parameter = "alpha"
start = 5
stop = 9
"""
ROOM = """\
title = "A room"
frames = 2
[eye]
z = -8
[[window]]
name = "a"
[[object]]
kind = "sphere"
name = "b"
z = 5
[[sweep]]
parameter = "a.pitch"
start = 5
stop = 9
"""


def recorded():
    """Return a picture and a movie with records, by their names."""
    values = {"povgen": __version__, "renderer": "a device", "rendering": {"size": (32, 32)}}
    frames = [{"scene": scene.name, **scene.model_dump(mode="json")} for scene in (Chess(sheet="ideal"), Spheres())]
    data = [io.BytesIO(), io.BytesIO()]
    Image.new("RGB", (32, 32)).save(data[0], "PNG")
    movie = bytes(Record(frames=frames, frame_rate=4, **values))
    Image.new("RGB", (32, 32)).save(data[1], "GIF", comment=movie)
    picture = in_png(data[0].getvalue(), Record(frames=frames[:1], **values))
    return {"recorded.png": picture, "recorded.gif": data[1].getvalue()}


def is_safe(source):
    """Return whether no payload is in a scene's text."""
    return not any(text in source for text in SDL if set(text) & {*"#${;"})


def rendered(source, rendering, folder):
    """Replace both renderers: check POV-Ray's text and return a black picture, a PNG file whatever its name."""
    assert is_safe(source)
    width, height = (min(pixels, 64) for pixels in rendering.size)
    picture = folder / rendering.file
    picture.write_bytes(iio.imwrite("<bytes>", np.zeros((height, width, 3), np.uint8), extension=".png"))
    return picture


RECORDED = recorded()


def new_folder():
    """Make the folder in which cases work."""
    shutil.rmtree(ROOT, ignore_errors=True)
    WORK.mkdir(parents=True)
    os.chdir(WORK)
    for name in ("folder", "folder.mp4"):
        (WORK / name).mkdir()
    (WORK / "spec.toml").write_text(SPEC)
    (WORK / "room.toml").write_text(ROOM)
    for name, data in RECORDED.items():
        (WORK / name).write_bytes(data)
    for name in ("kept.png", "kept.mp4", "kept.pov", "movie.mp4", "frame.png"):
        (WORK / name).write_bytes(b"kept")


def files():
    """Return all files and folders, with what changes if they are written to."""
    found = {}
    for folder, folders, names in os.walk(ROOT):
        for name in (*folders, *names):
            status = os.lstat(os.path.join(folder, name))
            changed = None if name in folders else (status.st_mtime_ns, status.st_size, status.st_ino)
            found[os.path.join(folder, name)] = changed
    return found


@pytest.fixture(scope="package", autouse=True)
def place(tmp_path_factory):
    """A deep folder, so that .. stays in it, and fast replacements of slow parts."""
    global ROOT, WORK
    from povgen.cli.commands import check
    from povgen.liveview import view
    from povgen.measure import charts, part, results, speed, stability, stability_map, verify, verify_gl, verify_live
    from povgen.measure.measured import Measured
    from povgen.page import page
    from povgen.paper import figures
    from povgen.rendering import cluster, frames, gl_runner, gl_scene, light, povray
    from povgen.scene import quantities, spec
    from povgen.video import build, encode

    started = Path.cwd()
    own = spec.MOVIES
    ROOT = tmp_path_factory.mktemp("fuzz") / "root"
    WORK = ROOT.joinpath(*"abcdefgh")
    movies = tmp_path_factory.mktemp("movies")
    for path in own.glob("*.toml"):
        (movies / path.name).write_text(re.sub(r"frames = \d+", "frames = 3", path.read_text()))

    def encoded(pictures, output, rate, record):
        assert 0 < rate < 1000 and all(picture.shape[2] == 3 for picture in pictures)
        output.write_text(str(record.title))

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(ROOT / "cache"))
        patch.setattr(spec, "MOVIES", movies)
        patch.setattr(page, "MOVIES", ("vary-z1",))
        for module in (page, view):
            patch.setattr(module, "volumes", lambda pieces, **options: {})
        patch.setattr(povray.Runner, "run", staticmethod(rendered))
        patch.setattr(gl_runner.Runner, "run", staticmethod(rendered))
        patch.setattr(gl_runner, "device", lambda: "a device")
        patch.setattr(gl_scene, "to_text", lambda *_, **__: "a scene")
        patch.setattr(frames, "volumes", lambda *_, **__: {})
        patch.setattr(frames, "is_whole", lambda *_: True)  # though smaller than was asked for
        patch.setattr(light, "unpacked", lambda *_: np.zeros((48, 64, 3), np.float32))
        patch.setattr(encode, "encode", encoded)
        patch.setattr(encode, "check_encoder", lambda ending: None)
        patch.setattr(quantities, "RAYS", 500)
        patch.setattr(results, "PATIENCE", np.inf)  # no other process: it takes longer to start than most cases
        client = mock.MagicMock(nthreads=lambda: {"a worker": 1})
        patch.setattr(cluster, "_connected", lambda _: client)
        patch.setattr(cluster.Cluster, "_check", lambda _: None)
        patch.setattr(cluster.Cluster, "run", staticmethod(rendered))
        patch.setattr(verify, "checks", lambda sheet: [Measured(sheet or "ideal", "error", 0.5, 1)])
        for module in (verify_gl, verify_live):
            patch.setattr(module, "checks", lambda: [Measured("ideal", "another error", 0.5, 1)])
        patch.setattr(stability, "maps", lambda sheet: [])
        patch.setattr(stability_map, "save_maps", lambda maps, folder, add: (folder / "maps").write_text("maps"))
        patch.setattr(speed, "measure_samplings", lambda *_: [])
        patch.setattr(charts, "save_frames", lambda *_: None)
        patch.setattr(part, "_solid", lambda *_: part.Manifold.cube())
        patch.setattr(figures, "save_figure", lambda number, folder, *_: [folder / "figure.png"])
        patch.setattr(check, "faults", lambda report: [])
        assert build.encode is encode and page.build is build
        yield
    quantities.traced_image.cache_clear()
    os.chdir(started)


@pytest.fixture(autouse=True)
def new_place(place):
    """Remove the files of earlier tests. The fewer files there are, the faster they are compared."""
    new_folder()


# Names of what may be at fault, and ways to say what is allowed.
NAMED = {*FIELDS, *MovieSpec.model_fields, *Sweep.model_fields, *(name for _, name in OPTIONS), "shard", "option"}
NAMED |= {"argument", "standard input", "toml", "movie", "missing", "x", "'"}
ALLOWED = r"allowed|\(.+\)|should|missing|No such|Missing|requires|unexpected|not TOML|does not take|magnified|Invalid"
ALLOWED += "|did you mean"


def tried(line, stdin=b""):
    """Run a case, check what every case must fulfil, and return exit status, output and errors."""
    global ran
    before = files()
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)  # numpy's, of numbers that are none
        status, out, err = povgen(line, WORK, stdin)
    ran += 1
    after = files()
    changed = {path for path in before.keys() | after.keys() if before.get(path) != after.get(path)}
    assert "Traceback" not in err
    assert status in (0, 2), (status, err)
    # a terminal gets povgen's own colours, and no other characters that it would obey
    assert Stream.terminal or all(text.isprintable() for text in (out + err).split("\n")), (out, err)
    if status == 2:
        *said, message = err.splitlines()  # a choice or warnings may come first
        assert all(text.startswith("povgen: ") for text in said), err
        assert message.startswith("povgen: ") and message.isprintable() and len(message) < 1100, message
        assert any(name in message.lower() for name in NAMED) and re.search(ALLOWED, message), message
        assert not changed, changed
        assert not out
    elif changed:
        asked = [
            WORK / name
            for name in ("frame.png", "movie.mp4", "demo.html", "live.html", "stability", "chart", "figures")
        ]
        asked += [
            ROOT / "cache",
            *(WORK / f"{Path(word.rpartition('=')[2]).stem}.mp4" for word in line if line[0] == "movie"),
        ]
        asked += [Path(os.path.normpath(WORK / word.partition("=")[2])) for word in line if "=" in word]
        asked += [Path(os.path.normpath(WORK / word)) for word in line[1:]]
        asked += [page.with_name(f"{page.stem}-vary-z1.mp4") for page in asked if line[0] == "demo" and page.stem]
        others = {path for path in changed if not any(Path(path).is_relative_to(place) for place in asked)}
        assert not others, others
        assert not list(ROOT.rglob(".povgen-*"))
        assert line[0] != "pov" or all(is_safe(Path(path).read_text()) for path in changed)
        new_folder()
    assert line[0] != "pov" or is_safe(out)
    return status, out, err


def tried_spec(data):
    """Try a spec as a file or, if its length is even, from standard input."""
    if isinstance(data, str):
        data = data.encode(errors="surrogateescape")
    (WORK / "spec.toml").write_bytes(data)
    try:
        source = ["-", "spec.toml"][len(data) % 2]
        return tried(["movie", source, "--quiet", "--size", "32x32", "-o", "x.gif"], data)
    finally:
        (WORK / "spec.toml").write_text(SPEC)
