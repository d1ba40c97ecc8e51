"""What a user's file with a piece may contain: objects and declarations, nothing that reaches the rest of the scene."""

import os
import re
from pathlib import Path

import pytest

from povgen import Chess, InputError, files, to_pov
from povgen.scene import pieces, sdl
from povgen.scene.pieces import INCLUDES, PieceFile, declared

PIECE = "#declare Piece = sphere { 0.5*y, 0.5 }\n"


def refused(text):
    with pytest.raises(ValueError) as error:
        declared(PIECE + text)
    return str(error.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        # the union's brace is closed, or would be when POV-Ray skips or repeats a part
        ("} fog { distance 9 } union {", "line 2: '}', but nothing is open"),
        ("#if (0) { #end fog { distance 9 } union { #if (0) } #end", "line 2: '#end', but '{' is open"),
        ("#if (1) } #else { #end", "'}', but '#if' is open"),
        ("{ #else }", "'#else', but '{' is open"),
        ("#switch (1) #case (0) { #case (1) } #end", "'#case', but '{' is open"),
        ("#macro Close() } #end Close() fog { distance 9 } union {", "'}', but '#macro' is open"),
        ("#macro Condition() 1) #end #if (Condition()", "')', but '#macro' is open"),  # POV-Ray goes on after '#macro'
        ("#for (I, 0, 1) sphere { 0, #break 1 } #end", "'#break' inside brackets"),
        ("#for (I, 0, 1) union { #if (I) #break #end }", "'#break' inside brackets"),
        ("#if (1) #break #end", "'#break' inside brackets, or outside"),
        ("( ]", "']', but '(' is open"),
        ("#end", "'#end', but nothing is open"),
        # something that is no token for POV-Ray hides a brace, or a brace hides in what is one
        ('#debug "\\\\" } //"', "'}', but nothing"),
        ("/* /* */ { */ }", "'}', but nothing"),
        ("/*/ */ } */", "'}', but nothing"),
        ("{ // }\n", "'{' is not closed"),
        ('{ "}" ', "line 2: '{' is not closed"),
        ('"\n', "a string that does not end"),
        ("/* /* */\n", "line 2: a comment that does not end"),
        ("1e5light_source { 0, 1 }", "'light_source'"),
        # texts that POV-Ray writes and reads
        ('#fopen F "a.inc" write #write (F, "}") #include "a.inc"', "'#fopen', which could change the rest"),
        ('#include "data.txt"', "'#include'; allowed, outside all brackets: chars.inc, "),
        ('#include concat("colors", ".inc")', "'#include'; allowed"),
        ('#macro Again() #include "math.inc" #end', "'#include'; allowed"),  # its offsets could end the macro
        ('#include "shapes.inc" HF_Square(F, no, no, <9, 9>, no, "a.inc", 0, 1)', "'HF_Square', which could"),
        ('#include "shapes.inc" Parse_String("} fog { distance 9 } union {")', "'Parse_String', which could"),
        # what works in a union, and beyond it
        ("light_source { 9, 1 }", "line 2: 'light_source', which could change the rest of the scene"),
        ("light_group { sphere { 0, 1 } }", "'light_group'"),
        ("#default { finish { ambient 1 } }", "'#default'"),
        ("# \tdefault { finish { ambient 1 } }", "'#default'"),
        ("#declare OwnPiece_2 = sphere { 0, 1 }", "'OwnPiece_2'"),
        # declarations whose names would not be found, as with `deprecated`
        ('#declare deprecated "old" Tile = 3;', "'#declare' without a name and '='"),
        ("#declare (A, B) = 3;", "'#declare' without a name"),
        ("#local Table.Entry = 3;", "'#local' without a name"),
        # '#' and what it belongs to
        ("##declare A = 1; if (0) { #end", "'#', which"),
        ("# /* */ if (0) { #end", "'#', which"),
        ("#if1 (0) { #end", "'#if1', which"),
        ("if (0)", "'if' without '#'"),
    ],
)
def test_a_text_that_reaches_further_is_refused(text, said):
    assert said in refused(text)


def test_control_characters_are_refused(tmp_path):
    """`povgen pov` would print them, and POV-Ray's messages repeat parts of the text."""
    for character in "\0\x07\x1b\x7f\x9b":
        (tmp_path / "own.inc").write_text(PIECE + f"// {character}[31m\n")
        with pytest.raises(InputError, match="line 2: the control character ") as error:
            Chess(piece=tmp_path / "own.inc")
        assert str(error.value).isprintable()


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
def test_letters_of_older_editors(encoding, tmp_path):
    text = PIECE + "// K\u00f6nig \u2013 \u201eroi\u201c\n"
    (tmp_path / "own.inc").write_text(text, encoding)
    assert Chess(piece=tmp_path / "own.inc").piece.text == text


def test_a_file_that_has_nothing_to_read_yet_is_refused(tmp_path, monkeypatch):
    """Such as /proc/kmsg, a regular file that is read like a pipe."""
    os.mkfifo(tmp_path / "log")
    writes = os.open(tmp_path / "log", os.O_RDWR)
    monkeypatch.setattr(files.stat, "S_ISREG", lambda mode: True)
    try:
        with pytest.raises(InputError, match="should be a name or a file that can be read at once"):
            Chess(piece=tmp_path / "log")
    finally:
        os.close(writes)


@pytest.mark.parametrize(
    "text",
    [
        "union { #for (I, 0, 9) sphere { I*x, #if (I > 4) 1 #else 2 #end } #if (I = 5) #break #end #end }",
        '#switch (N) #case (1) sphere { 0, 1 } #break #range (2, 4) box { 0, 1 } #else #debug "}" #end',
        "#macro Ring(R, T) torus { R, T translate <0, max(R, T), 0> } #end object { Ring(1, 0.1) }",
        "#while (clock < 1) #macro Own() #break #end #end",
        '#version 3.6; /* } /* { */ " */ // }\n#undef Own #ifdef (Own) #error "no \\"}" #end #ifndef (Own) #end',
        "#declare Place = array[2] { <1, 2.5e-3, .5>, y } #local f = function(x, y) { x*y }",
        '#include "math.inc" # include "shapes.inc"\ntext { ttf "timrom.ttf" "{" 0.1, 0 pigment { rgb 1 } }',
        "sphere { 0, 1 texture { pigment { rgb 1 } } interior { ior 1.5 media { emission 1 } } no_shadow }",
    ],
)
def test_what_a_piece_may_contain(text):
    assert "Piece" in declared(PIECE + text)


def test_the_names_that_a_piece_declares():
    text = (
        "#declare A = 1; # local b = array[1] {2} #macro M(P) #declare C[0] = 1; #end #for (K, 0, 1) #end // #declare D"
    )
    assert declared(text) == ["A", "C", "K", "M", "b"]
    source = to_pov(Chess(piece=[PieceFile("own.inc", PIECE + text + "\n"), "king"], x=[-1, 1]))
    before, after = source.split(text)
    for name in ("A", "C", "K", "M", "b", "Piece"):
        assert f"\n#ifdef ({name}) #undef {name} #end\n" in after.partition("// ----")[0]
    assert "#declare" not in before.replace(
        "#declare OwnPiece_1 = union {\n#declare Piece", ""
    )  # no names that it knows


def test_a_hostile_text_is_checked_in_a_moment():
    """A time proportional to the square of the length would be longer than a test may take."""
    for part in ('"\\', "# ", "/*", "//\n", "1"):
        text = (part * 2**20)[: 2**20]
        try:
            assert declared(text) == []
        except ValueError as error:
            assert len(str(error)) < 200
    with pytest.raises(ValueError, match="'#' *, which"):
        declared("#" + " " * 2**20)


def allowed_in(text):
    """Return a text without its comments, and without the macros that a piece may not use."""
    found, depth = [], 0
    tokens = [token for _, token in pieces._tokens(text)]
    for token, after in zip(tokens, [*tokens[1:], ""], strict=True):
        if depth or token == "#macro" and pieces.REFUSED.fullmatch(after):
            depth += (pieces.ENDS.get(token) == "#end") - (token == "#end")
        else:
            found.append(token)
    return " ".join(found)


def test_povrays_files_contain_only_declarations():
    """Those that a piece may include, and those that they include."""
    folders = [folder for base in ("/usr/share", "/usr/local/share") for folder in Path(base).glob("povray*/include")]
    waiting, known = [*INCLUDES], set()
    while waiting:
        name = waiting.pop()
        known.add(name)
        for file in [folder / name for folder in folders]:
            text = allowed_in(file.read_text("latin-1"))
            waiting += set(re.findall(r'#include "(.*?)"', text)) - known
            text = re.sub(r'#include ".*?"|\bdeprecated once ".*?"', "", text)
            # a choice: POV-Ray reads one of the two braces
            declared(re.sub(r"#if \( \w+ \) merge { #else union { #end", "union {", text))
    assert not folders or {"strings.inc", "shapes_old.inc"} <= known


def test_a_line_of_a_users_file_is_found_in_any_text():
    own = PieceFile("own\x1b.inc", PIECE + "// ---- Not a template (x.pov.j2) ----\nsphere { 0 }\n")
    for source in (to_pov(Chess(piece=own)), sdl.to_crossings(own, (9, 9, 9), 0.5, "data.txt")):
        lines = source.split("\n")
        assert sdl.origin_of(["king", own], source, lines.index("sphere { 0 }") + 1) == (r"'own\x1b.inc'", 3)
        name = sdl.origin_of([own], source, len(lines) - 1)[0]
        assert name in ("chess.pov.j2", "probes/crossings.pov.j2")
