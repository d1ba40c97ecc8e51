"""Any command line and any spec: povgen obeys (exit status 0), or refuses in one line (2) and touches no file.

Thousands of cases are made from povgen's own commands, options and models, so that new ones are tried as well. They run
in this process. Only POV-Ray and other slow parts are replaced.
"""

import inspect
import io
import itertools
import json
import os
import re
import shutil
import signal
import sys
import tempfile
import types
import typing
import warnings
from concurrent.futures import Future
from contextlib import redirect_stderr, redirect_stdout, suppress
from functools import cache
from importlib import import_module
from math import ceil
from pathlib import Path
from unittest import mock

import annotated_types
import imageio.v3 as iio
import numpy as np
import pytest
import typer
from hypothesis import HealthCheck, Phase, assume, example, given, settings
from hypothesis import strategies as st

from povgen import Chess, InputError, MovieSpec, to_pov
from povgen.cli import app
from povgen.cli.options import with_options
from povgen.scene.models import SCENES
from povgen.scene.pieces import PIECES
from povgen.scene.sdl import Mosaic
from povgen.scene.spec import Sweep
from povgen.settings import Rendering
from povgen.sheets import OTHER, PARAMETERS

pytestmark = pytest.mark.xdist_group("fuzz")  # in one process, because `place` takes long
PATIENCE = 60  # seconds for a case, on a slow and busy machine; most take milliseconds
ran = 0  # cases


def cases(count):
    """Run a test on `count` cases, the same each time. It fails if more than half of them were not run."""

    def counted(test):
        fuzz = settings(
            max_examples=count,
            deadline=None,
            derandomize=True,
            database=None,
            phases=(Phase.explicit, Phase.generate, Phase.shrink),
            suppress_health_check=list(HealthCheck),
        )(test)

        def run():
            before = ran
            fuzz()
            assert ran - before >= count / 2, f"only {ran - before} of {count} cases were run"

        return run

    return counted


# What can be tried: commands with their parameters, and fields of models.


COMMANDS = sorted(app.COMMANDS)


@cache
def parameters(command):
    """Return a command's parameters by name: the type (str, Path, bool, list) and the option, '' for an argument."""
    found = {}
    function = import_module(f"povgen.cli.commands.{command}").command
    for name, parameter in inspect.signature(with_options(function)).parameters.items():
        kind, info = typing.get_args(parameter.annotation)
        kinds = typing.get_args(kind) if typing.get_origin(kind) is types.UnionType else [kind]
        kind = typing.get_origin(kinds[0]) or kinds[0]
        is_option = isinstance(info, typer.models.OptionInfo)
        found[name] = kind, (info.param_decls or [f"--{name}"])[-1] if is_option else ""
    return found


OPTIONS = [(command, name) for command in COMMANDS for name in parameters(command)]
FIELDS = {name: field for model in (*SCENES.values(), Rendering) for name, field in model.model_fields.items()}


def bounds_in(metadata):
    """Return a field's bounds by name: ge, gt, le or lt."""
    parts = itertools.chain.from_iterable([data, *getattr(data, "metadata", [])] for data in metadata)
    classes = {name: getattr(annotated_types, name.capitalize()) for name in ("ge", "gt", "le", "lt")}
    return {name: getattr(x, name) for x in parts for name, kind in classes.items() if isinstance(x, kind)}


def right(kind, metadata=()):
    """Return a strategy for values that a field allows."""
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Annotated:
        return right(parts[0], [*metadata, *parts[1:]])
    if origin in (typing.Union, types.UnionType):
        return st.one_of([right(part, metadata) for part in parts if part is not type(None)])
    if origin is typing.Literal:
        return st.sampled_from(parts)
    if origin is tuple:
        if parts[-1] is ...:
            return st.lists(right(parts[0]), min_size=1, max_size=4).map(tuple)
        return st.tuples(*(right(part) for part in parts))
    if kind in (int, float):
        bounds = bounds_in(metadata)
        low, high = bounds.get("ge", bounds.get("gt")), bounds.get("le", bounds.get("lt"))
        if kind is int:
            ends = [end for end in (low, high) if end is not None]
            return st.integers(low, high) | st.sampled_from(ends) if ends else st.integers()
        return st.floats(
            low, high, exclude_min="gt" in bounds, exclude_max="lt" in bounds, allow_nan=False, allow_infinity=False
        )
    return {bool: st.booleans(), str: TEXTS}.get(kind, TEXTS)


# Values: right, nearly right, and wrong.

SDL = [
    '"} #include "/etc/passwd" //',
    '66; #debug "x"',
    "66 #declare Z2 = 1;",
    "1} sphere { 0, 1 }",
    "*/ #end #while (1) #end /*",
    "// \n#error",
    "knight.pov.j2",
    "pieces/knight",
    "../../x",
    "{{ 7*7 }}",
    "{% include 'header.pov.j2' %}",
    "knight king",
    "detailed\n",
    "$(touch x)",
    "; touch x",
    "`touch x`",
    "%s%n{0}",
]
NUMBERS = [
    *("nan", "inf", "-inf", "+nan", "-0", "0", "00", "-1", "1e308", "-1e308", "1e309", "5e-324", "-5e-324", "1e-400"),
    *("1_000", "0x10", "0b1", "1e", ".5", "5.", "+5", "--5", "1,5", "1.5.2", "1/2", "½", "١٢", "１２", "Ⅻ", "²"),
    *(" 66", "66 ", "\t66\n", "6 6", "\u00a066", "66\u200b", "−66", "infinity", "Infinity", "NaN", "None", "true"),
    *("9" * 400, "9" * 5000, "1" + "0" * 5000 + "px", "9" * 100_000, "0." + "0" * 400 + "1", "1e" + "9" * 30),
    *("0,-1,2", ",", ",,", "0,", ",-1", "nan,-1", "0,nan", "1e308,-1e308", "0;-1", "0 -1", "1,0.5,2.0", "1,1e-3,9"),
    *("64x", "x64", "64x64x64", "64×64", "64X48", "-64x64", "64.0x64", "1e2x64", "64 x 48", "7681x64", "63x64", "x"),
    *("1px", "1px,0.2flip", "1PX", "px", "0px", "-1px", "1px,1px", "1px 1flip", "nanpx", "1/2", "0/1", "2/1", "1/0"),
]
WORDS = [
    *("", " ", "\n", "-", "--", "-o", "--help", ".", "..", "/", "~", "*", "?", "#", "=", "'", '"', "\\", "%", "&"),
    *("auto", "off", "OFF", "none", "Detailed", "KNIGHT", "chess ", "Chess", "draft\0"[:-1], "spec.toml", "x.png"),
    *(
        "kept.png",
        "kept.mp4",
        "folder.mp4",
        "folder",
        "no/x.png",
        "spec.toml/x.mp4",
        "x.png/",
        ".png",
        "x.PNG",
        "x.gif",
    ),
    *(
        "x" * 300,
        "x" * 300 + ".png",
        "x/" * 3000 + "x.mp4",
        "\u202e.png",
        "\x1b[31m.mp4",
        "a\nb.png",
        "ß.webm",
        "\udcff",
    ),
    *(
        "\udcff.png",
        "\udcff.mp4",
        "[/red].mp4",
        "%d.png",
        "-.png",
        "é" * 200 + ".mp4",
        "\x7f",
        "\u2028",
        "\ud83d\ude00"[:0],
    ),
    *(
        "tcp://x",
        "tcp://192.0.2.1:8786",
        "tls://[::1]:99999",
        "http://192.0.2.1:1",
        "baselines",
        "binary",
        "1",
        "7",
        "6",
    ),
]
ELSEWHERE = ["/proc/x.png", "/proc/x.mp4", "/proc/x", "/nonexistent/x.png", "/dev/full", "/dev/null", "/dev/zero"]
CHARACTERS = st.characters(exclude_categories=["Cs"], exclude_characters="\0")  # no argument has a NUL
TEXTS = st.sampled_from(NUMBERS) | st.sampled_from(WORDS) | st.sampled_from(SDL) | st.text(CHARACTERS)
TEXTS |= st.floats().map(repr) | st.integers().map(str) | st.sampled_from(ELSEWHERE)
SOME = {  # right values for what is no field of a model
    "scene": st.sampled_from([*SCENES]),
    "sweep": st.sampled_from(["alpha=5:9", "z1=1:2:log", "eye=-1,0:1,0:cosine", "prisms=50:60", "gap=0.01:0.02"]),
    "frames": st.integers(2, 5).map(str),
    "frame_rate": st.floats(0.1, 120).map(repr),
    "spec": st.sampled_from(["spec.toml", "chess", "vary-alpha", "spheres", "-"]),
    "what": st.sampled_from(["info", "clear"]),
    "numbers": st.sampled_from("123456"),
    "workers": st.integers(1, 256).map(str),
    "part": st.sampled_from(["1/1", "1/2", "3/3", "9/9"]),
    "tolerance": st.sampled_from(["1px", "5px", "0.5flip", "100px,1flip"]),
    "json": st.just("x.json"),
    "baselines": st.just("baselines"),
    "output": st.sampled_from(
        ["x.png", "x.mp4", "x.gif", "x.webm", "x.pov", "x.html", "x", "kept.png", "kept.mp4", "folder"]
    ),
    "piece": st.sampled_from([*PIECES]),
    "color": st.sampled_from(["red", "#c87529", "#00f", "hsl(0, 100%, 50%)"]),
    "size": st.sampled_from(["32x32", "64x48", "48x64"]),
    "quality": st.sampled_from(["draft", "standard"]),
    "sheet": st.sampled_from(["none", "ideal", "single", "detailed", "auto", *OTHER]),
    "window": st.sampled_from(["alpha=120,z=2", "alpha=-50,z=0.9,sheet=detailed", "z=4,alpha=3,sheet=ideal"]),
}


# A number of frames that is right, and takes long.
LONG = re.compile(r"[\"']?\s*\+?0*[0-9_]{2,5}(\.0*)?\s*[\"']?")


def text_of(value):
    """Return a value as it is written on the command line."""
    return (
        ",".join(map(text_of, value)) if isinstance(value, tuple) else value if isinstance(value, str) else repr(value)
    )


def rights(name):
    if name in SOME:
        return SOME[name]
    return right(FIELDS[name].annotation, FIELDS[name].metadata).map(text_of) if name in FIELDS else TEXTS


@st.composite
def words(draw, command, name, values):
    """Draw a parameter, as words of a command line."""
    kind, option = parameters(command)[name]
    if kind is bool:
        return [draw(st.sampled_from(option.split("/")))]
    value = draw(values)
    assume(name != "frames" or not LONG.fullmatch(value))
    if kind is Path or name == "spec":
        assume(value in ELSEWHERE or (WORK / value).is_relative_to(WORK) and value.count("..") < 3)
    if not option:
        return [value]
    return [f"{option}={value}"] if draw(st.booleans()) and option.startswith("--") else [option, value]


@st.composite
def lines(draw, command, of=None):
    """Draw a command line, mostly right, often with one wrong value. With `of`: with any value of that parameter."""
    line = [command]
    for name, (_, option) in parameters(command).items():
        if name == of:
            for _ in range(draw(st.sampled_from([1, 1, 1, 2]))):
                line += draw(words(command, name, TEXTS if draw(st.integers(0, 4)) else rights(name)))
        elif name == "size" or not option or (of is None and draw(st.integers(0, 3)) == 0):
            wrong = of is None and draw(st.integers(0, 9)) == 0
            line += draw(words(command, name, TEXTS if wrong else rights(name)))
        elif name == "sheet" and of is not None:
            line += [option, "ideal"]
    if of is None and draw(st.integers(0, 19)) == 0:
        line.insert(draw(st.integers(1, len(line))), draw(TEXTS))
    return line


# How a case is run.

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


def skeleton(source):
    """Return the lines of a scene's text, without their numbers and without the options of the header's command."""
    source = re.sub(r"(?m)^(//   povray)( [-+][\w.]+)+$", r"\1", source)
    source = re.sub(r"(?<=[a-zA-Z0-9])_\d+\b", "", source)  # of several pieces
    source = re.sub(r"(?<![\w.])-?\d+(\.\d+)?(e[+-]\d+)?\b", "#", source)
    return {re.sub(" +", " ", line).replace("},", "}") for line in source.split("\n")}


@cache
def skeletons():
    """Return the lines of all scenes, of every sheet, piece and switch, without their numbers."""
    found = set()
    for model in SCENES.values():
        choices = {
            name: [False, True] if field.annotation is bool else typing.get_args(field.annotation)
            for name, field in model.model_fields.items()
            if field.annotation is bool or typing.get_origin(field.annotation) is typing.Literal
        }
        if "piece" in model.model_fields:
            choices |= {"piece": [*PIECES], "pedestal": [0, 0.8]}
        for values in itertools.product(*choices.values()):
            with suppress(InputError):  # some do not go together
                scene = model(**dict(zip(choices, values, strict=True)))
                found |= skeleton(to_pov(scene))
        for sheet, *others in (("ideal", None, "ideal", "detailed"), ("detailed", None), ("none", None)):
            windows = [{"alpha": 30, "z": n, "sheet": other} for n, other in enumerate(others, 1)]
            more = {"predicted_image": True} if "piece" in model.model_fields and sheet != "none" else {}
            for pedestal in (0, 0.8)[: 1 + ("piece" in model.model_fields)]:
                options = more | ({"pedestal": pedestal} if "piece" in model.model_fields else {})
                found |= skeleton(to_pov(model(sheet=sheet, window=windows, z1=2, **options)))
    for sheet in ("detailed", "ideal", "none"):
        found |= skeleton(to_pov(Chess(sheet=sheet), Mosaic((64, 48), 8, [[(0, 0)]])))
    for antialias in ("off", "2x"):  # the header's words differ
        found |= skeleton(to_pov(Chess(), antialias=antialias))
    return found


def rendered(source, rendering, folder):
    """Replace POV-Ray: check the scene's text and return a black picture."""
    assert not skeleton(source) - skeletons()
    width, height = (min(pixels, 64) for pixels in rendering.size)
    picture = folder / rendering.file
    iio.imwrite(picture, np.zeros((height, width, 3), np.uint8))
    return picture


def new_folder():
    """Make the folder in which cases work."""
    shutil.rmtree(ROOT, ignore_errors=True)
    WORK.mkdir(parents=True)
    os.chdir(WORK)
    for name in ("folder", "folder.mp4", "baselines", "binary"):
        (WORK / name).mkdir()
    (WORK / "spec.toml").write_text(SPEC)
    (WORK / "baselines" / "one.inc").write_text("#macro Sheet() #end\n")
    (WORK / "binary" / "one.inc").write_bytes(b"\xff")
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


@pytest.fixture(scope="module", autouse=True)
def place(tmp_path_factory):
    """A deep folder, so that .. stays in it, and fast replacements of slow parts."""
    global ROOT, WORK
    from povgen.cli import checkup
    from povgen.liveview import page
    from povgen.measure import charts, glass, live, speed, stability, verify
    from povgen.measure.measured import Measured
    from povgen.rendering import cluster, frames, povray
    from povgen.scene import spec
    from povgen.teach import figures
    from povgen.video import build, encode

    started = Path.cwd()
    own = spec.MOVIES
    ROOT = tmp_path_factory.mktemp("fuzz") / "root"
    WORK = ROOT.joinpath(*"abcdefgh")
    movies = tmp_path_factory.mktemp("movies")
    for path in own.glob("*.toml"):
        (movies / path.name).write_text(re.sub(r"frames = \d+", "frames = 2", path.read_text()))

    def encoded(pictures, output, rate, tags):
        assert 0 < rate < 1000 and all(picture.shape[2] == 3 for picture in pictures)
        output.write_text(json.dumps(tags))

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("POVGEN_CACHE", str(ROOT / "cache"))
        patch.setattr(spec, "MOVIES", movies)
        patch.setattr(page, "MOVIES", ("vary-z1",))
        patch.setattr(page, "volumes", lambda pieces, **options: {})
        patch.setattr(povray.Runner, "run", staticmethod(rendered))
        patch.setattr(frames, "is_whole", lambda png, size: True)  # though smaller than was asked for
        patch.setattr(encode, "encode", encoded)
        patch.setattr(cluster, "_connected", lambda _: mock.MagicMock())
        patch.setattr(cluster.Cluster, "_start", lambda _, coroutine: coroutine.close() or Future())
        patch.setattr(cluster.Cluster, "_threads", mock.MagicMock())
        patch.setattr(cluster.Cluster, "_result", lambda *_: 1)  # of _threads
        patch.setattr(cluster.Cluster, "_check", lambda _: None)
        patch.setattr(cluster.Cluster, "run", staticmethod(rendered))
        patch.setattr(verify, "checks", lambda sheet: [Measured(sheet or "ideal", "error", 0.5, 1)])
        patch.setattr(live, "checks", lambda: [Measured("ideal", "live error", 0.5, 1)])
        patch.setattr(stability, "maps", lambda sheet: [])
        patch.setattr(charts, "save_maps", lambda maps, folder, add: (folder / "maps").write_text("maps"))
        for name in ("measure_samplings", "measure_prism_counts", "measure_beyond", "measure_workers"):
            patch.setattr(speed, name, lambda *_: [])
        for name in ("save_frames", "save_prism_counts", "save_beyond", "save_workers"):
            patch.setattr(charts, name, lambda *_: None)
        patch.setattr(glass, "save_charts", lambda folder: None)
        patch.setattr(figures, "save_figure", lambda number, folder, rendering: [folder / "figure.png"])
        patch.setattr(checkup, "faults", lambda report: [])
        assert build.encode is encode and page.build is build
        skeletons()  # takes longer than a case may
        yield
    os.chdir(started)


@pytest.fixture(autouse=True)
def new_place(place):
    """Remove the files of earlier tests. The fewer files there are, the faster they are compared."""
    new_folder()


class Stream(io.TextIOWrapper):
    terminal = False

    def isatty(self):
        return self.terminal


def povgen(line, stdin=b""):
    """Run the command line and return exit status, output and errors. Fail if it hangs or ends in another way."""

    def hangs(*_):
        raise AssertionError(f"no end: {line}")

    out = Stream(io.BytesIO(), "utf-8", errors="strict")  # as Python has it on most systems
    err = Stream(io.BytesIO(), "utf-8", errors="backslashreplace")
    kept = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM)}
    signal.signal(signal.SIGALRM, hangs)
    own = os.dup(0)
    with tempfile.TemporaryFile() as file:
        file.write(stdin)
        file.seek(0)
        os.dup2(file.fileno(), 0)
    timer = signal.setitimer(signal.ITIMER_REAL, PATIENCE)  # another may be set, for the whole test
    try:
        with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)  # numpy's, of numbers that are none
                patch.setattr(sys, "argv", ["povgen", *line])
                with pytest.raises(SystemExit) as done:
                    app.main()
    finally:
        os.dup2(own, 0)
        os.close(own)
        for number, handler in kept.items():
            signal.signal(number, handler)
        signal.setitimer(signal.ITIMER_REAL, *timer)
    for stream in (out, err):
        stream.flush()
    texts = [stream.buffer.getvalue().decode() for stream in (out, err)]
    return done.value.code or 0, *texts


# Names of what may be at fault, and ways to say what is allowed.
NAMED = {*FIELDS, *MovieSpec.model_fields, *Sweep.model_fields, *(name for _, name in OPTIONS), "shard", "option"}
NAMED |= {"argument", "standard input", "toml", "movie", "missing", "x", "'"}
ALLOWED = r"allowed|\(.+\)|should|missing|No such|Missing|requires|unexpected|not TOML|does not take|magnified|Invalid"


def tried(line, stdin=b""):
    """Run a case, check what every case must fulfil, and return exit status, output and errors."""
    global ran
    before = files()
    status, out, err = povgen(line, stdin)
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
        asked = [WORK / name for name in ("frame.png", "movie.mp4", "demo.html", "stability", "chart", "figures")]
        asked += [ROOT / "cache", *(WORK / f"{Path(word).stem}.mp4" for word in line if line[0] == "movie")]
        asked += [Path(os.path.normpath(WORK / word.partition("=")[2])) for word in line if "=" in word]
        asked += [Path(os.path.normpath(WORK / word)) for word in line[1:]]
        asked += [page.with_name(f"{page.stem}-vary-z1.mp4") for page in asked if line[0] == "demo" and page.stem]
        others = {path for path in changed if not any(Path(path).is_relative_to(place) for place in asked)}
        assert not others, others
        assert not list(ROOT.rglob(".povgen-*"))
        if line[0] == "pov":
            for path in changed:
                assert skeleton(Path(path).read_text()) <= skeletons()
        new_folder()
    if out and status == 0 and line[0] == "pov" and "--help" not in line:
        assert skeleton(out) <= skeletons()
    return status, out, err


@pytest.mark.parametrize("command", COMMANDS)
def test_command_lines(command):
    @cases(120 if "alpha" in parameters(command) else 30 if parameters(command) else 10)
    @given(lines(command))
    def fuzz(line):
        tried(line, SPEC.encode())

    fuzz()


@pytest.mark.parametrize(("command", "name"), OPTIONS)
def test_every_option(command, name):
    """Each option with right and wrong values."""

    @cases(9)
    @given(lines(command, of=name))
    def fuzz(line):
        tried(line, SPEC.encode())

    fuzz()


# Specs: tables of keys and values, which are TOML.

LITERALS = [
    *("nan", "+nan", "inf", "-inf", "0", "-0", "-0.0", "1e308", "-1e308", "1e400", "5e-324", "1e-400", "1_000", "007"),
    *("9" * 400, "9" * 5000, "0x" + "f" * 5000, "0o7", "0b11", "0x10", "10001", "+5", ".5", "5."),
    *("true", "false", "True", "null", "None", "1979-05-27", "1979-05-27T07:32:00Z", "07:32:00", "1979-02-30"),
    *("[]", "[1]", "[[1]]", "[1, 2, 3]", "[true, -1]", "[0, true]", "[nan, -1]", "[1e308, -1e308]", "[0, -5e-324]"),
    *('["0", "-1"]', "[1, [2]]", "[1979-05-27]", "[0x" + "f" * 5000 + "]", "[1" + ", 1" * 60 + "]", "[{}]"),
    *("{}", "{a = 1}", "{a = {b = {c = []}}}", "{a.b.c = 1}", "{a = 1, a = 2}", '{"" = 1}', "[" * 2000, "{a=" * 500),
    *(
        '""',
        '"\\u0000"',
        '"\\ud800"',
        '"\\U00110000"',
        '"\\u202e"',
        "'''a\nb'''",
        '"unclosed',
        "'it's'",
        "",
        "= 1",
        "#",
    ),
]


def quoted(text):
    return json.dumps(text, ensure_ascii=False)


WRONG = st.sampled_from(LITERALS) | TEXTS.map(quoted) | st.floats().map(repr) | st.integers().map(str)
KEYS = st.sampled_from(
    ["", "a", "a.b", "a.a.a", '"a b"', '"\\n"', "é", "sweep", "fixed", "title", "alpha.x", "__class__", "[x]"]
)
KEYS |= st.text(CHARACTERS).map(quoted)
BASE = {
    "": {"title": '"A movie"', "scene": '"chess"', "frame_rate": "10", "frames": "2"},
    "fixed": {"sheet": '"ideal"'},
    "sweep": {"parameter": '"alpha"', "start": "5", "stop": "9"},
}
PLACES = [("", name) for name in MovieSpec.model_fields] + [("sweep", name) for name in Sweep.model_fields]
PLACES += [(scene, name) for scene, model in SCENES.items() for name in model.model_fields]


def literal(value):
    """Return a value in TOML."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(literal, value))}]"
    return quoted(value) if isinstance(value, str) else str(value).lower()


@st.composite
def entries(draw, table, name):
    """Draw a key of a table and a value, right or wrong."""
    model = {"": MovieSpec, "sweep": Sweep}.get(table) or SCENES[table]
    if name in model.model_fields and name not in ("fixed", "sweep") and draw(st.integers(0, 3)) == 0:
        field = model.model_fields[name]
        values = st.integers(2, 5) if name == "frames" else right(field.annotation, field.metadata)
        return name, draw(values.map(literal))
    value = draw(WRONG)
    assume(name != "frames" or not LONG.fullmatch(value))
    return name, value


def toml(spec):
    tables = {"": "", "fixed": "[fixed]\n", "sweep": "[[sweep]]\n"}
    return "".join(
        head + "".join(f"{key} = {value}\n" for key, value in spec[table].items()) for table, head in tables.items()
    )


@st.composite
def specs(draw, places):
    """Draw a spec in which some entries are changed, removed or added."""
    spec = {table: dict(keys) for table, keys in BASE.items()}
    for table, name in places:
        key, value = draw(entries(table, name))
        if table in SCENES:
            spec[""]["scene"] = quoted(table)
            table = "fixed"
        if name == spec["sweep"].get("parameter", "").strip('"'):
            spec["sweep"]["parameter"] = '"z2"'
        if draw(st.integers(0, 9)) == 0:
            spec[table].pop(key, None)
        else:
            spec[table][key] = value
    if draw(st.integers(0, 9)) == 0:
        spec[draw(st.sampled_from([*BASE]))][draw(KEYS)] = draw(WRONG)
    return toml(spec)


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


@pytest.mark.parametrize(("table", "name"), PLACES)
def test_every_key(table, name):
    @cases(16)
    @given(specs([(table, name)]))
    def fuzz(text):
        tried_spec(text)

    fuzz()


@cases(200)
@given(st.lists(st.sampled_from(PLACES), min_size=2, max_size=5, unique=True).flatmap(specs))
def test_specs(text):
    tried_spec(text)


@cases(200)
@given(st.data())
def test_what_is_no_toml(data):
    text = SPEC.encode()
    kind = data.draw(st.sampled_from(["cut", "put", "replace", "bytes", "text"]))
    start, end = sorted(data.draw(st.integers(0, len(text))) for _ in range(2))
    if kind in ("bytes", "text"):
        made = data.draw(
            st.binary(max_size=300)
            if kind == "bytes"
            else st.text(st.characters(exclude_categories=["Cs"])).map(str.encode)
        )
    else:
        new = (
            b""
            if kind == "cut"
            else data.draw(
                st.binary(max_size=5) | st.sampled_from([b"\0", b"\r", b"\xff", b"[", b'"""', b"\xef\xbb\xbf"])
            )
        )
        made = text[:start] + new + text[end if kind != "put" else start :]
    tried_spec(made)


@pytest.mark.parametrize(
    "text",
    [
        SPEC.replace("z1 = 2", "z1." + "a." * 3000 + "a = 1"),
        "a." * 8000 + "a = 1",
        "#" * 20_000,
        "x = 1\n" * 100_000,
        SPEC.replace("z1 = 2", "z1 = 0x" + "f" * 9000),
        SPEC.replace("[fixed]", "[fixed]\nalpha = 0x" + "f" * 9000),
        SPEC.replace("frames = 2", "frames = 10001"),
    ],
    ids=lambda text: text[:20],
)
def test_very_long(text):
    assert tried_spec(text)[0] == 2


# What is right is done, and nothing but numbers and known names gets into a scene.


@cases(80)
@given(st.data())
def test_what_is_right_is_done(data):
    scene = data.draw(st.sampled_from([*SCENES]))
    given = {
        "alpha": data.draw(st.floats(-360, 360)),
        "z2": data.draw(st.floats(5, 150)),
        "prisms": data.draw(st.integers(100, 3000)),
        "index": data.draw(st.floats(1.3, 4)),
        "base_angle": data.draw(st.floats(45, 60)),
        "gap": data.draw(st.floats(1e-3, 0.5)),
        "aspect": data.draw(st.floats(1, 1.5)),
        "aperture": data.draw(st.floats(2, 5)),
        "view": data.draw(st.floats(0.1, 100)),
        "z1": data.draw(st.floats(5, 2500)),
        "eye": data.draw(st.tuples(st.floats(-10, 10), st.floats(-1, 10))),
        "sheet": data.draw(st.sampled_from(["detailed", "ideal", "single", "none"])),
    }
    if scene == "chess":
        given["piece"] = data.draw(rights("piece"))
        given["x"] = data.draw(st.floats(-10, 10))
        given["pedestal"] = data.draw(st.just(0.0) | st.floats(0, 10))
    else:
        given["line"] = data.draw(st.tuples(st.floats(-10, 10), st.floats(-10, 10)))
    status, source, said = tried(
        ["pov", scene, *(f"--{name.replace('_', '-')}={text_of(x)}" for name, x in given.items())]
    )
    assert status == 0, said
    stated = dict(zip(("EyeX", "EyeY"), given["eye"], strict=True))
    stated |= {"Z2": given["z2"], "Window": given["aperture"], "ViewHeight": given["view"]}
    if given["sheet"] in ("detailed", "single"):
        stated |= {"GlassIndex": given["index"], "BaseAngle": given["base_angle"]}
        stated |= {"AirGap": given["gap"], "Aspect": given["aspect"], "Prisms": given["prisms"]}
    if scene == "chess":
        stated |= {"Z1": given["z1"], "PieceX": given["x"]}
        stated |= {"Pedestal": given["pedestal"]} if given["pedestal"] else {}
    else:
        stated |= dict(zip(("LX", "LY"), given["line"], strict=True))
    for parameter, value in stated.items():
        assert re.search(rf"^#declare {parameter} += {re.escape(f'{value:.15g}')};", source, re.M), parameter


BOUNDS = {
    **{"alpha": (-360, 360), "z2": (0, 150), "prisms": (1, 3000), "z1": (0, 5000), "x": (-10, 10)},
    **{"index": (1.1, 4), "base_angle": (15, 75), "gap": (0.001, 0.5), "aspect": (0, 2)},
    **{
        "aperture": (0.5, 10),
        "pedestal": (0, 10),
        "view": (0.1, 100),
        "timeout": (0, 1e6),
        "eye_distance": (0, 5),
        **{name: (each.least, each.most) for name, (each, *_) in PARAMETERS.items() if each.kind == "number"},
    },
}


@pytest.mark.parametrize("name", [name for name, field in FIELDS.items() if field.annotation in (int, float)])
def test_numbers(name):
    """An accepted value is a number, as Python reads it, within the bounds that the help states."""
    low, high = BOUNDS[name]

    @cases(60)
    @given(
        st.sampled_from(NUMBERS) | st.floats(-2 * high, 2 * high).map(repr) | st.integers(-5, 2 * ceil(high)).map(str)
    )
    def fuzz(text):
        line = ["frame", "chess", "--sheet=none", "--size=32x32", f"--{name.replace('_', '-')}={text}"]
        line += ["--stereo=pair"] * (name == "eye_distance")
        if tried(line)[0] == 0:
            assert low <= float(text) <= high

    fuzz()


@pytest.mark.parametrize(
    ("command", "name"), [place for place in OPTIONS if parameters(place[0])[place[1]][0] is not bool]
)
def test_no_sdl_in_options(command, name):
    kind, option = parameters(command)[name]
    for payload in SDL:
        line = [command]
        for other, (_, word) in parameters(command).items():
            if other == name:
                line += [option, payload] if option else [payload]
            elif not word:
                line.append({"spec": "spec.toml", "what": "info", "numbers": "1"}.get(other, "chess"))
        status, _, said = tried(
            [*line, "--size=32x32"] if "size" in parameters(command) and name != "size" else line, SPEC.encode()
        )
        # a folder may have any name
        assert status == 2 or kind is Path, (payload, said)


@pytest.mark.parametrize(("table", "name"), PLACES)
def test_no_sdl_in_specs(table, name):
    """Except in the title, which does not reach POV-Ray."""
    for payload in SDL:
        spec = {table: dict(keys) for table, keys in BASE.items()}
        if name == "alpha":
            spec["sweep"]["parameter"] = '"z2"'
        if table in SCENES:
            spec[""]["scene"] = quoted(table)
        spec["fixed" if table in SCENES else table][name] = quoted(payload)
        assert tried_spec(toml(spec))[0] == (0 if name == "title" and payload.isprintable() else 2)


# Faults that these tests, and thought, have found.


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (["frame", "chess", "-o", "folder.mp4"], ["output = 'folder.mp4'", "not a kind"]),
        (
            ["movie", "spec.toml", "-o", "folder.mp4"],
            ["output = 'folder.mp4': it exists and cannot be written to; allowed"],
        ),
        (["movie", "spec.toml", "--workers", "9" * 5000], ["workers", "1 to 256"]),
        (["frame", "chess", "--sheet", "auto", "--tolerance", "9" * 100_000], ["tolerance", "allowed"]),
        (["movie", "x" * 5000], ["File name too long", "allowed"]),
        (["movie", "/dev/zero"], ["longer than", "allowed"]),
        (["movie", ""], ["'': no movie spec"]),
        (["movie", "a\nb\x1b[31m\u202e.toml"], [r"a\nb\x1b[31m\u202e.toml: no movie spec"]),
        (["frame", "--" + "x" * 100_000], ["No such option", "..."]),
        (["chart", "--baselines", "nowhere"], ["baselines = 'nowhere'"]),
        (["chart", "--baselines", "binary"], ["baselines = 'binary': not UTF-8"]),
    ],
    ids=lambda value: " ".join(value)[:40],
)
def test_found_in_command_lines(line, words):
    status, _, said = tried(line)
    assert status == 2 and said.count("allowed") < 2 and all(word in said for word in words), said


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("z1 = 2", "z1 = 0x" + "f" * 5000, ["z1 = a very long int"]),
        ("z1 = 2", "z1." + "a." * 2000 + "a = 1", ["z1 = a very long dict"]),
        ("z1 = 2", "alpha = 0x" + "f" * 5000, ["alpha = a very long int", "swept"]),
        ("z1 = 2", "eye = [true, -1]", ["eye = [True, -1]", "true or false"]),
        ('"A movie"', '"A\\u2028movie"', ["title", "one line"]),
        ('"A movie"', '"A\\u0085movie"', ["title", "one line"]),
        ("stop = 9", "stop = 9\nspacing = 'log'\nstart = 1", ["not TOML", "overwrite"]),
        ("[[sweep]]", "#" * 20_000, ["no movie spec: longer than"]),
    ],
    ids=lambda value: str(value)[:20],
)
def test_found_in_specs(old, new, words):
    status, _, said = tried_spec(SPEC.replace(old, new))
    assert status == 2 and all(word in said for word in words), said


def test_small_numbers_do_not_pass_through_0():
    """A product of two such numbers is 0, but a sweep between them is allowed."""
    spec = SPEC.replace("start = 5\nstop = 9", "start = 1e-300\nstop = 1e-200\nspacing = 'log'")
    assert tried_spec(spec)[0] == 0


def test_a_closed_standard_input():
    own = os.dup(0)
    os.close(0)
    try:
        with pytest.raises(InputError, match="standard input: .* Bad file descriptor; allowed"):
            MovieSpec.load("-")
    finally:
        os.dup2(own, 0)
        os.close(own)


def test_a_closed_standard_output(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["povgen", "pov", "chess"])
    monkeypatch.setattr(sys, "stdout", None)
    with pytest.raises(SystemExit) as done:
        app.main()
    assert not done.value.code


def test_names_of_files_are_not_markup(monkeypatch):
    """And they may be no valid text."""
    monkeypatch.setattr(Stream, "terminal", True)
    names = {"[bold]x.gif": "[bold]x.gif", "\udcff.gif": r"\udcff.gif", "\x1b[31m\x9b1m.gif": r"\x1b[31m\x9b1m.gif"}
    for name, shown in names.items():
        status, out, err = tried(["movie", "spec.toml", "--size=32x32", f"--output={name}"])
        assert status == 0 and shown in err and f"wrote {shown}\n" == out


@cases(60)
@given(
    st.sampled_from(NUMBERS) | st.sampled_from(SDL) | st.text(CHARACTERS) | st.floats().map(repr),
    st.sampled_from(COMMANDS),
)
def test_the_size_of_the_cache(text, command):
    """A wrong setting in the environment is refused before any work is done."""
    with pytest.MonkeyPatch.context() as patch:
        try:
            patch.setenv("POVGEN_CACHE_SIZE", text)
        except UnicodeEncodeError:
            assume(False)
        needed = {"scene": "chess", "spec": "spec.toml", "what": "info", "numbers": "1"}
        line = [needed.get(name) for name, (_, option) in parameters(command).items() if not option]
        line += ["--size=32x32"] * ("size" in parameters(command))
        tried([command, *line])


@cases(60)
@given(st.text(st.characters(exclude_categories=["Cc", "Cs", "Zl", "Zp"]), min_size=1, max_size=200))
@example("<b>&\"'</b><script>alert(1)</script>")
@example("{{ 7*7 }}{% raw %}%s %d $HOME `id` \\ ; = # title=x")
@example("-vf" + " " * 100)
def test_a_title_is_text(title):
    """It is in the metadata as it was given, and not in the scene, which `rendered` checks."""
    text = SPEC.replace('"A movie"', quoted(title).replace("\x7f", "\\u007f"))
    written = {}
    with pytest.MonkeyPatch.context() as patch:
        from povgen.video import encode

        patch.setattr(encode, "encode", lambda *given: written.update(given[-1]) or given[1].touch())
        assert tried_spec(text)[0] == 0
    assert written["title"] == title and json.loads(written["comment"])["title"] == title


def test_there_is_much_to_try():
    """The lists from which cases are made are not empty."""
    assert len(OPTIONS) >= 100 and len(PLACES) >= 40 and len(SDL) >= 10, (len(OPTIONS), len(PLACES), len(SDL))
