"""Calls from Python: errors of one line, copies, and what help() says."""

import copy
import inspect
import os
import pickle
import pydoc
import re
from itertools import repeat

import numpy as np
import pytest
from conftest import picture

import povgen
from povgen import (
    Chess,
    Eye,
    InputError,
    Movie,
    MovieSpec,
    PovrayError,
    Rendering,
    Room,
    Sphere,
    Spheres,
    Window,
    live,
    movie,
    render,
    results,
    save,
    show,
    to_pov,
)
from povgen.page.page import demo
from povgen.scene.scene import Scene
from povgen.scene.spec import Sweep
from povgen.settings import Options
from povgen.validation import Model

MOVIE = {"title": "a", "scene": "chess", "sweep": [{"parameter": "alpha", "start": 0, "stop": 1}]}


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Chess(alhpa=3), ["'alhpa': unknown in the scene chess; did you mean alpha?"]),
        (lambda: Chess(self=3), ["'self': unknown in the scene chess; allowed: alpha, prisms, "]),
        (lambda: Chess(alpha="x" * 999), ["alpha = 'xxx", "number"]),
        (lambda: Chess(z1=True), ["z1 = True", "true or false"]),
        (lambda: Chess(piece=("pawn", "king")), ["two pieces, at x = 0, z1 = 2 and at x = 0, z1 = 2, "]),
        (lambda: Chess(piece=["knight", "nix"]), ["piece = ['knight', 'nix']: 'nix' should be"]),
        (lambda: Chess(piece=b"knight"), ["piece = ", "name or a file"]),
        (lambda: Chess(66), ["66: a value without a name"]),
        (lambda: setattr(Chess(), "alpha", 3), ["alpha = 3: ", ".replace(alpha=...)"]),
        (lambda: Spheres(z1=[]), ["z1 = []"]),
        (lambda: Rendering(size=(1, 1)), ["size = (1, 1)", "32"]),
        (lambda: MovieSpec(title="a"), ["missing"]),
        (lambda: MovieSpec(**MOVIE | {"sweep": [{"parameter": "alpha", "start": "x"}]}), ["}: start = 'x': should"]),
        (lambda: MovieSpec.load(3), ["3: no movie spec"]),
        (lambda: MovieSpec.parse(b"", "a"), ["a: not TOML: b''; allowed: text"]),
        (lambda: MovieSpec.of_sweeps("chess", [3], {}), ["sweep = 3", "NAME=START:STOP"]),
        (lambda: to_pov(Scene()), ["should be a scene", "Chess(...)"]),
        (lambda: demo("page.html", pieces=["nix.inc"]), ["piece = 'nix.inc': should be a name or a file"]),
        (lambda: live(Spheres()).save("a.txt"), ["output = 'a.txt'", ".html"]),
        (lambda: live(Spheres(), width='x" onload=alert(1)'), ["width = 'x\" onload", "32 to 7680 pixels"]),
        (lambda: live(Spheres(), height=0), ["height = 0", "32 to 7680 pixels"]),
        (lambda: live(type("Mine", (Chess,), {})()), ["scene = Mine(", "Chess(...) or Spheres(...)"]),
        (lambda: setattr(live(Chess()), "fresnel", True), ["fresnel = true: the live view follows one ray a pixel"]),
        (lambda: Chess(eye={1, 2}), ["eye = {1, 2}: should be in order"]),
        (lambda: Rendering(size=frozenset((64, 48))), ["size = frozenset({", "should be in order"]),
        (lambda: movie(repeat(Chess()), "a.mp4"), ["more than 30000 scenes; allowed: up to 30000"]),
        (lambda: movie([Chess()], "a.mp4", progress="no"), ["progress = 'no': should be true or false"]),
        (lambda: save(Chess(), "a.png", progress="no"), ["progress = 'no': should be true or false"]),
        (lambda: Movie("x"), ["path = 'x'", ".mp4, .webm, .webp, .gif"]),
        (lambda: Movie("gone.mp4")._repr_html_(), ["path = 'gone.mp4': No such file"]),
        (lambda: render("chess"), ["scene = 'chess'", "Chess(...)"]),
        (lambda: show(Chess(), sise=(32, 32)), ["'sise': unknown", "size"]),
        (lambda: save(Chess(), "a.jpg"), ["output = 'a.jpg'", ".png"]),
        (lambda: movie(3, "a.mp4"), ["spec = 3"]),
        (lambda: movie([], "a.mp4"), ["no scenes"]),
        (lambda: movie([Chess()], "a.avi"), ["a.avi", ".mp4"]),
        (lambda: movie([Chess()], "a.mp4", frame_rate=0), ["frame_rate = 0", "120"]),
        *(
            (lambda workers=workers: movie([Chess()], "a.mp4", workers=workers), [f"workers = {workers!r}", "256"])
            for workers in (0, "x", True)
        ),
        (lambda: movie([Chess()], "a.png"), ["output = 'a.png': one picture", "a%04d.png"]),
        (lambda: render([Chess()], workers=0), ["workers = 0", "256"]),
        (lambda: render(Chess(), stereo="pair", eye_distance=0), ["eye_distance = 0"]),
        (lambda: render(Chess(), stereo="both"), ["stereo = 'both'"]),
        (lambda: render(Chess(eye=(9, 0)), stereo="pair", eye_distance=3), ["eye = "]),
        (lambda: results([Chess()]), ["no quantity; allowed: x, y, nu, M"]),
        (lambda: results([Chess()], "nix"), ["quantity = 'nix'; allowed: x, y"]),
        (lambda: results(None, "nu"), ["scene = None: should be a scene"]),
        (lambda: results([Chess()], "M", scheduler="x"), ["scheduler = 'x'"]),
    ],
)
def test_an_error_has_one_line_and_nothing_is_written(call, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as raised:
        call()
    message = str(raised.value)
    assert all(word in message for word in words), message
    assert len(message.splitlines()) == 1 and "pydantic" not in message
    assert (raised.value.__suppress_context__ or not raised.value.__context__) and not os.listdir(tmp_path)


@pytest.mark.parametrize(
    "make",
    [
        lambda values: Chess(**values),
        lambda values: Chess().replace(**values),
        lambda values: Chess().model_copy(update=values),
    ],
    ids=["Chess", "replace", "model_copy"],
)
def test_all_ways_to_make_a_model_check_it(make):
    assert make({"alpha": "90"}) == Chess(alpha=90)
    with pytest.raises(InputError, match="^alpha = '400': should be less than or equal to 360 .*$"):
        make({"alpha": "400"})


@pytest.mark.parametrize("model", [Chess, Spheres, Rendering, MovieSpec, Sweep])
def test_no_parameter_takes_anything(model):
    required = MOVIE if model is MovieSpec else {"parameter": "alpha", "start": 0, "stop": 1} if model is Sweep else {}
    for name, field in model.model_fields.items():
        for wrong in [object(), *([True, [True]] if field.annotation is not bool else [])]:
            with pytest.raises(InputError, match=f"^{name} = "):
                model(**{**required, name: wrong})


@pytest.mark.parametrize("several", [np.array([2, 3, 4]), range(2, 5), (2, 3, 4), [np.float64(2), "3", 4]])
def test_one_value_for_each_object(several):
    assert Chess(z1=several).z1 == Spheres(z1=several).z1 == Chess(z1=2, x=several).x == (2, 3, 4)
    assert Chess(z1=np.array([2])).z1 == Chess(z1=np.float64(2)).z1 == Spheres(z1=[2]).z1 == 2
    assert Spheres(z1=several).distances == Chess(z1=several).distances == (2, 3, 4) and Spheres(z1=2).distances == (2,)


def test_a_copy_with_changes():
    scene = Chess(alpha=66, z1="3")
    assert scene.replace(alpha=90) == Chess(alpha=90, z1=3) and scene.alpha == 66
    assert scene.replace() == scene and type(Spheres().replace(z1=2)) is Spheres
    assert Rendering(quality="high").replace(caption="full") == Rendering(quality="high", caption="full")
    assert Rendering(quality="high").replace(quality="draft") == Rendering(quality="draft")  # its size as well
    assert Rendering(size=(64, 48)).replace(quality="high").size == (64, 48)
    for copied in (pickle.loads(pickle.dumps(scene)), scene.model_copy()):
        assert copied == scene


@pytest.mark.parametrize(
    "function", [povgen.Bundle, povgen.fit, povgen.irradiance, povgen.mtf, Chess.seen, Chess.spot, Room.images]
)
def test_help_names_types_in_short(function):
    assert "numpy." not in str(inspect.signature(function))


@pytest.mark.parametrize("model", [Chess, Spheres, Rendering, MovieSpec])
def test_help_names_each_parameter(model):
    assert issubclass(model, Model)
    text, signature = pydoc.plain(pydoc.render_doc(model)), inspect.signature(model)
    assert list(signature.parameters) == list(model.model_fields)
    for name, field in model.model_fields.items():
        (line,) = [line for line in text.splitlines() if re.match(rf"[ |]*- `{name}\b", line)]
        assert line.endswith(field.description)
        assert field.is_required() == (signature.parameters[name].default is inspect.Parameter.empty)
    assert "Annotated" not in str(signature)


def test_the_signature_has_types_and_defaults():
    for model in (Chess, type("Mine", (Chess,), {})):  # before and after the first model of a class is made
        assert "(*, alpha: float = 66" in str(inspect.signature(model))
        assert model() and "(*, alpha: float = 66" in str(inspect.signature(model))
    assert "- `alpha = 66`: ray-rotation angle alpha, -360 to 360 degrees" in Chess.__doc__
    assert "- `z2 = 6`: distance from the sheets to the eye" in Chess.__doc__


def test_a_live_view_and_its_scene():
    seen = live(Chess())
    widget = seen.widget
    seen.alpha = 90
    assert seen.scene == Chess(alpha=90) and seen.alpha == widget.scene["alpha"] == 90
    page = widget.html
    widget.moved = {"eye": [1, 0.5]}
    assert seen.scene.eye == (1, 0.5) and widget.scene["eye"] == (1, 0.5) and widget.html is page
    widget.moved = {"eye": [100, 0]}  # a browser's message is not trusted
    assert seen.scene.eye == (1, 0.5) and widget.scene["eye"] == (1, 0.5) and widget.scene["back"]
    seen.piece = "king"
    assert widget.html != page and widget.scene["piece"] == "king"  # the new page asks for the scene
    seen.scene = Spheres()
    assert widget.scene["name"] == "spheres" and seen.z2 == Spheres().z2
    with pytest.raises(AttributeError):
        _ = seen.nothing


@pytest.mark.parametrize("has_widget", [True, False])
def test_a_live_view_does_not_keep_a_refused_change(has_widget, tmp_path):
    """POV-Ray refuses the piece."""
    seen, bad = live(Chess()), tmp_path / "bad.inc"
    bad.write_text("#declare Piece = sphere { }")
    before = dict(seen.widget.trait_values()) if has_widget else {}
    for name, value in (("piece", bad), ("scene", Chess(piece=bad))):
        with pytest.raises(PovrayError, match="bad.inc"):
            setattr(seen, name, value)
        assert seen.scene == Chess() and seen.html
    assert not has_widget or seen.widget.trait_values() == before


def test_a_browser_sets_only_what_a_user_moves(tmp_path):
    """A message with other parameters could make povgen read a file."""
    path = picture(tmp_path)
    seen = live(Chess())
    for moved in ({"sky": path}, {"floor": path, "alpha": 68}, {"piece": str(tmp_path / "none")}, {"nothing": []}):
        seen.widget.moved = moved
    assert seen.scene == Chess(alpha=68) and not seen.widget.moved


def test_a_live_view_can_be_copied():
    view = live(Spheres(z1=3))
    for made in (copy.copy(view), copy.deepcopy(view), pickle.loads(pickle.dumps(view))):
        assert made.scene == view.scene and made.z1 == 3


def test_scenes_with_tables_can_be_copied():
    scene = Chess(sheet="law", law="k*x, y, z", parameter={"k": 0.3})
    copies = copy.deepcopy(scene), pickle.loads(pickle.dumps(scene)), Chess(**dict(scene)), Chess(**scene.model_dump())
    for made in copies:
        assert made == scene and hash(made) == hash(scene) and made.parameter == {"k": 0.3}


def test_equal_values_have_equal_hashes():
    law = {"sheet": "law", "law": "k*x + m*y, y, z"}
    sweep = {"title": "a", "scene": "chess", "sweep": [{"parameter": "z1", "start": 2, "stop": 3}]}
    for one, other in (
        (Chess(**law, parameter={"k": 1, "m": 0.0}), Chess(**law, parameter={"m": -0.0, "k": 1.0})),
        (MovieSpec(**sweep, fixed={"alpha": 90, "x": [0, 1]}), MovieSpec(**sweep, fixed={"x": [0, 1], "alpha": 90.0})),
        (Chess(alpha=0.0).sheets[0], Chess(alpha=-0.0).sheets[0]),
    ):
        assert one == other and len({one, other}) == 1
    assert len({hash(Chess(error={"turn": n / 100})) for n in range(20)}) > 15


def test_repr_shows_what_differs_from_the_default():
    assert repr(Chess()) == str(Chess()) == repr(Chess(alpha=66)) == "Chess()"
    assert repr(Chess(alpha="90", sheet="ideal")) == "Chess(alpha=90.0, sheet='ideal')"
    assert repr(live(Chess(alpha=90))) == "live(Chess(alpha=90.0))"
    assert repr(Rendering(quality="high")) == "Rendering(quality='high')"
    window = Chess(window="alpha=120,z=2", x=[0, 1])
    assert repr(window) == "Chess(window=({'alpha': 120.0, 'z': 2.0},), x=(0.0, 1.0))"


def test_the_options_for_type_checkers_are_those_of_a_rendering():
    assert set(Options.__annotations__) == set(Rendering.model_fields)


def test_a_path_in_the_users_home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "ball.inc").write_text("#declare Piece = sphere { 0.4*y, 0.4 }\n")
    (tmp_path / "a.toml").write_text('title = "a"\nscene = "chess"\n[[sweep]]\nparameter = "z1"\nstart = 2\nstop = 3\n')
    assert MovieSpec.load("~/a.toml").title == "a" and Chess(piece="~/ball.inc").piece.path == str(
        tmp_path / "ball.inc"
    )
    assert Movie("~/a.mp4").path == tmp_path / "a.mp4" and live(Chess(sheet="none")).save("~/a.html").exists()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Room(3), "things = 3: allowed: a list of objects and windows"),
        (lambda: Room([Sphere(name="sphere2"), Sphere(x=5)]), "name = 'sphere2': two things have it"),
        (lambda: Room(eye=Eye(z=1e-200)), "where the eye is"),  # the square of this distance is 0
        (lambda: Room(Window(sheet="detailed", error={"tilt_x": 1})), "error: only for a single window, of chess"),
    ],
)
def test_what_a_room_cannot_be(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_a_notebook_proposes_povgens_own_names():
    for model in (Chess(), Rendering()):
        names = {name for name in dir(model) if not name.startswith("_")}
        assert {"replace", "model_dump", "size" if isinstance(model, Rendering) else "alpha"} <= names
        assert not names & {"model_construct", "parse_obj", "schema", "copy", "json", "dict"}
