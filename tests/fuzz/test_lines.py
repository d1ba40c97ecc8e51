"""Command lines: of each command, with each option."""

from pathlib import Path

import pytest
from conftest import Stream
from hypothesis import given
from hypothesis import strategies as st

from fuzz.conftest import SPEC, cases, tried
from fuzz.values import COMMANDS, OPTIONS, SDL, lines, parameters

# arguments of commands; another one is a scene's name
NEEDED = {"spec": "spec.toml", "what": "info", "numbers": "1", "file": "recorded.png"}


@cases(20)
@given(st.sampled_from(COMMANDS).flatmap(lines))
def test_command_lines(line):
    tried(line, SPEC.encode())


@cases(40)
@given(st.sampled_from(OPTIONS).flatmap(lambda place: lines(place[0], of=place[1])))
def test_options(line):
    """One option with right and wrong values."""
    tried(line, SPEC.encode())


@cases(20)
@given(
    st.sampled_from([place for place in OPTIONS if parameters(place[0])[place[1]][0] is not bool]), st.sampled_from(SDL)
)
def test_no_sdl_in_options(place, payload):
    command, name = place
    kind, option = parameters(command)[name]
    line = [command]
    for other, (_, word) in parameters(command).items():
        if other == name:
            line += [option, payload] if option else [payload]
        elif not word:
            line.append(NEEDED.get(other, "chess"))
    line += ["--size=32x32"] if "size" in parameters(command) and name != "size" else []
    status, _, said = tried(line, SPEC.encode())
    # a folder may have any name; a note does not reach POV-Ray
    assert status == 2 or kind is Path or (name == "note" and payload.isprintable()), (payload, said)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (
            ["movie", "spec.toml", "-o", "folder.mp4"],
            ["output = 'folder.mp4': it exists and cannot be written to; allowed"],
        ),
        (["movie", "spec.toml", "--workers", "9" * 5000], ["workers", "1 to 256"]),
        (["movie", "/dev/zero"], ["longer than", "allowed"]),
        (["movie", "a\nb\x1b[31m\u202e.toml"], [r"a\nb\x1b[31m\u202e.toml: no movie spec"]),
        (["frame", "--" + "x" * 100_000], ["No such option", "..."]),
    ],
    ids=lambda value: " ".join(value)[:40],
)
def test_found_in_command_lines(line, words):
    status, _, said = tried(line)
    assert status == 2 and said.count("allowed") < 2 and all(word in said for word in words), said


def test_names_of_files_are_not_markup(monkeypatch):
    """And they may be no valid text."""
    monkeypatch.setattr(Stream, "terminal", True)
    names = {"[bold]x.gif": "[bold]x.gif", "\udcff.gif": r"\udcff.gif", "\x1b[31m\x9b1m\n.gif": r"\x1b[31m\x9b1m\n.gif"}
    for name, shown in names.items():
        status, out, err = tried(["movie", "spec.toml", "--size=32x32", f"--output={name}"])
        assert status == 0 and shown in err and f"wrote {shown}\n" == out
