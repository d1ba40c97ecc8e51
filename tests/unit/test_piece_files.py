"""A user's file with a piece: its letters, the names that it declares, and where its errors are."""

import pytest

from povgen import Chess, InputError, to_pov
from povgen.inputs.pieces import PieceFile, declared
from povgen.scene import sdl

PIECE = "#declare Piece = sphere { 0.5*y, 0.5 }\n"


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


def test_the_names_that_a_piece_declares():
    text = (
        "#declare A = 1; # local b = array[1] {2} #macro M(P) #declare C[0] = 1; #end #for (K, 0, 1) #end // #declare D"
    )
    assert declared(text) == ["A", "C", "K", "M", "b"]
    assert declared('#declare A = "#declare B \\" #declare C"; /* #declare D = 1 */ #declare E = 2;') == ["A", "E"]
    source = to_pov(Chess(piece=[PieceFile("own.inc", PIECE + text + "\n"), "king"], x=[-1, 1]))
    before, after = source.split(text)
    for name in ("A", "C", "K", "M", "b", "Piece"):
        assert f"\n#ifdef ({name}) #undef {name} #end\n" in after.partition("// ----")[0]
    assert "#declare" not in before.replace("#declare OwnPiece_1 = union {\n#declare Piece", "")  # no names yet


def test_a_line_of_a_users_file_is_found_in_any_text():
    own = PieceFile("own\x1b.inc", PIECE + "// ---- Not a template (x.pov.j2) ----\nsphere { 0 }\n")
    for source in (to_pov(Chess(piece=own)), sdl.to_crossings(own, (9, 9, 9), 0.5, "data.txt")):
        lines = source.split("\n")
        assert sdl.origin_of(["king", own], source, lines.index("sphere { 0 }") + 1) == (r"'own\x1b.inc'", 3)
        name = sdl.origin_of([own], source, len(lines) - 1)[0]
        assert name in ("chess.pov.j2", "probes/crossings.pov.j2")
