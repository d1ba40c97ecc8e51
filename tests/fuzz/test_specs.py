"""Specs: tables of keys and values, which are TOML."""

import json

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fuzz.conftest import SPEC, cases, tried_spec
from fuzz.values import CHARACTERS, LONG, SDL, SOME, TEXTS, right
from povgen import MovieSpec
from povgen.scene.presets import SCENES
from povgen.scene.spec import Sweep

LITERALS = [
    *("nan", "inf", "0", "-0.0", "1e308", "1e400", "5e-324", "9" * 400, "0x" + "f" * 5000, "10001", "true", "null"),
    *("1979-05-27", "07:32:00", "[]", "[1]", "[[1]]", "[1, 2, 3]", "[true, -1]", "[nan, -1]", '["0", "-1"]', "[{}]"),
    *("[1" + ", 1" * 60 + "]", "[" * 2000, "{}", "{a = 1}", "{a = {b = {c = []}}}", "{a=" * 500, '{"" = 1}'),
    *('""', '"\\u0000"', '"\\u202e"', "'''a\nb'''", '"unclosed', "", "= 1", "#"),
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
        values = SOME[name] if name in ("object", "window", "eye") else values
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


@cases(30)
@given(st.lists(st.sampled_from(PLACES), min_size=1, max_size=4, unique=True).flatmap(specs))
def test_specs(text):
    tried_spec(text)


@cases(15)
@given(st.data())
def test_what_is_no_toml(data):
    text = SPEC.encode()
    start, end = sorted(data.draw(st.integers(0, len(text))) for _ in range(2))
    new = data.draw(
        st.binary(max_size=5) | st.sampled_from([b"", b"\0", b"\r", b"\xff", b"[", b'"""', b"\xef\xbb\xbf"])
    )
    made = data.draw(st.just(text[:start] + new + text[end:]) | st.binary(max_size=300))
    tried_spec(made)


@cases(20)
@given(st.sampled_from(PLACES), st.sampled_from(SDL))
def test_no_sdl_in_specs(place, payload):
    """Except in the title and the note, which do not reach POV-Ray."""
    table, name = place
    spec = {table: dict(keys) for table, keys in BASE.items()}
    if name == "alpha":
        spec["sweep"]["parameter"] = '"z2"'
    if table in SCENES:
        spec[""]["scene"] = quoted(table)
    spec["fixed" if table in SCENES else table][name] = quoted(payload)
    assert tried_spec(toml(spec))[0] == (0 if name in ("title", "note") and payload.isprintable() else 2)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("z1 = 2", "z1 = 0x" + "f" * 9000, ["z1 = a very long int"]),
        ("z1 = 2", "z1." + "a." * 3000 + "a = 1", ["z1 = a very long dict"]),
        ("z1 = 2", "eye = [true, -1]", ["eye = [True, -1]", "true or false"]),
        ("frames = 2", "frames = 10001", ["frames"]),
        ('"A movie"', '"A\\u2028movie"', ["title", "one line"]),
        ("[[sweep]]", "#" * 20_000, ["no movie spec: longer than"]),
    ],
    ids=lambda value: str(value)[:20],
)
def test_found_in_specs(old, new, words):
    status, _, said = tried_spec(SPEC.replace(old, new))
    assert status == 2 and all(word in said for word in words), said
