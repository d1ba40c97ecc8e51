"""What can be tried: commands with their parameters, fields of models, and values, right and wrong."""

import itertools
import re
import types
import typing
from functools import cache
from importlib import import_module
from pathlib import Path

import annotated_types
import click
from hypothesis import assume
from hypothesis import strategies as st

from povgen.cli import app
from povgen.inputs.pieces import PIECES
from povgen.objects import OBJECTS
from povgen.scene.presets import SCENES
from povgen.settings import Rendering
from povgen.sheets import OTHER

COMMANDS = sorted(app.COMMANDS)


@cache
def parameters(command):
    """Return a command's parameters by name: the type (str, Path or bool) and the option, '' for an argument."""
    found = {}
    for parameter in import_module(f"povgen.cli.commands.{command}").command.params:
        kind = Path if parameter.type.name == "Path" else bool if parameter.type is click.BOOL else str
        names = [max(names, key=len) for names in (parameter.opts, parameter.secondary_opts) if names]
        found[parameter.name] = kind, "/".join(names) if isinstance(parameter, click.Option) else ""
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
    *('"} #include "/etc/passwd" //', '66; #debug "x"', "66 #declare Z2 = 1;", "1} sphere { 0, 1 }"),
    *("*/ #end #while (1) #end /*", "// \n#error", "knight.pov.j2", "pieces/knight", "../../x", "knight king"),
    *("{{ 7*7 }}", "{% include 'header.pov.j2' %}", "detailed\n", "$(touch x)", "; touch x", "`touch x`", "%s%n{0}"),
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
    *("auto", "off", "OFF", "none", "Detailed", "KNIGHT", "chess ", "Chess", "spec.toml", "x.png", "x.PNG", "x.gif"),
    *("kept.png", "kept.mp4", "folder.mp4", "folder", "no/x.png", "spec.toml/x.mp4", "x.png/", ".png", "ß.webm"),
    *("x" * 300, "x" * 300 + ".png", "x/" * 3000 + "x.mp4", "\u202e.png", "\x1b[31m.mp4", "a\nb.png", "\udcff"),
    *("\udcff.mp4", "[/red].mp4", "%d.png", "-.png", "é" * 200 + ".mp4", "\x7f", "\u2028", "1", "7"),
    *("tcp://x", "tcp://192.0.2.1:8786", "tls://[::1]:99999", "http://192.0.2.1:1"),
]
ELSEWHERE = ["/proc/x.png", "/proc/x.mp4", "/proc/x", "/nonexistent/x.png", "/dev/full", "/dev/null", "/dev/zero"]
CHARACTERS = st.characters(exclude_categories=["Cs"], exclude_characters="\0")  # no argument has a NUL
TEXTS = st.sampled_from(NUMBERS) | st.sampled_from(WORDS) | st.sampled_from(SDL) | st.text(CHARACTERS)
TEXTS |= st.floats().map(repr) | st.integers().map(str) | st.sampled_from(ELSEWHERE)
SOME = {  # right values for what is no field of a model
    "scene": st.sampled_from([*SCENES, "room.toml"]),
    "sweep": st.sampled_from(["alpha=5:9", "z1=1:2:log", "eye=-1,0:1,0", "prisms=50:60", "eye.x=1:2", "b.z=9:10"]),
    "frames": st.integers(2, 5).map(str),
    "frame_rate": st.floats(0.1, 120).map(repr),
    "spec": st.sampled_from(["spec.toml", "chess", "vary-alpha", "spheres", "-", "room", "room.toml"]),
    "what": st.sampled_from(["info", "clear"]),
    "numbers": st.sampled_from("123456"),
    "workers": st.integers(1, 256).map(str),
    "part": st.sampled_from(["1/1", "1/2", "3/3", "9/9", "sheets"]),
    "tolerance": st.sampled_from(["1px", "5px", "0.5flip", "100px,1flip"]),
    "json": st.just("x.json"),
    "html": st.just("x.html"),
    "output": st.sampled_from("x.png x.exr x.mp4 x.gif x.pov x.html x.stl x kept.png folder".split()),
    "source": st.sampled_from(["recorded.png", "recorded.gif"]),
    "file": st.sampled_from(["recorded.png", "recorded.gif"]),
    "piece": st.sampled_from([*PIECES]),
    "color": st.sampled_from(["red", "#c87529", "#00f", "hsl(0, 100%, 50%)"]),
    "bits": st.sampled_from(["8", "16", "32"]),
    "size": st.sampled_from(["32x32", "64x48", "48x64"]),
    "quality": st.sampled_from(["draft", "standard"]),
    "sheet": st.sampled_from(["none", "ideal", "single", "detailed", "auto", *OTHER]),
    "window": st.sampled_from(["alpha=120,z=2", "alpha=-50,z=0.9,sheet=detailed", "z=4,yaw=30,name=a", "x=4,pitch=9"]),
    "object": st.sampled_from([*(f"kind={kind},z=9,y=-5,name=b" for kind in OBJECTS), "kind=text,text=a,x=7,roll=30"]),
    "eye": st.sampled_from(["0.5,-0.3", "x=1,z=-9,view=4", "y=8,look_y=1,roll=-30,aside=0.1"]),
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
        assume(value in ELSEWHERE or not Path(value).is_absolute() and value.count("..") < 3)
    if not option:
        return [value]
    return [f"{option}={value}"] if draw(st.booleans()) and option.startswith("--") else [option, value]


@st.composite
def lines(draw, command, of=None):
    """Draw a command line, mostly right, often with one wrong value. With `of`: with any value of that parameter."""
    line = [command]
    given = parameters(command)
    # --from replaces the scene or the spec
    again = "source" in given and (of == "source" or of is None and draw(st.integers(0, 9)) == 0)
    unused = {"scene", "spec"} if again and draw(st.integers(0, 9)) else {} if again else {"source"}
    for name, (_, option) in given.items():
        if name in unused:
            continue
        if name == of or name == "source":
            for _ in range(draw(st.sampled_from([1, 1, 1, 2])) if name == of else 1):
                line += draw(words(command, name, TEXTS if name == of and draw(st.integers(0, 4)) else rights(name)))
        elif name == "size" or not option or (of is None and draw(st.integers(0, 3)) == 0):
            wrong = of is None and draw(st.integers(0, 9)) == 0
            line += draw(words(command, name, TEXTS if wrong else rights(name)))
        elif name == "sheet" and of is not None:
            line += [option, "ideal"]
    if of is None and draw(st.integers(0, 19)) == 0:
        line.insert(draw(st.integers(1, len(line))), draw(TEXTS))
    return line
