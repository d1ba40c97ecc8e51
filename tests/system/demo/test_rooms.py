"""Rooms in the teaching page: from a file, an example or a link."""

import re

import numpy as np
from conftest import PROJECT
from playwright.sync_api import expect

from povgen import Room
from povgen.liveview.values import values
from povgen.page.rooms import EXAMPLES

ROOM = """
title = "my room"  # a movie's
frame_rate = 10
background = "white"
eye = { x = 1, z = -9, view = 6.0 }
[[window]]
x = -1.7
alpha = 90
[[window]]
name = "tilted"
sheet = "detailed"
x = 1.7
yaw = 25
alpha = -300.5
prisms = 40
outline = "round"
frame = false
[[object]]
kind = "piece"
piece = "rook"
x = -1.7
y = -1
z = 2
color = "peru"
[[object]]
kind = "sphere"
x = 1.7
z = 2
[[object]]
kind = 'text'
text = "α \\"povgen\\""
y = 2.1
z = -1
pitch = 20
[[object]]
kind = "box"
width = 0.5
roll = -30
z = 4
[[object]]
kind = "piece"
x = 2.6
y = -1.2
z = 4
[[object]]
kind = "ruler"
y = -1.5
z = 1_0e-1
[[object]]
kind = "pedestal"
y = -2
x = -1.7
z = 2
height = 1
[[object]]
kind = "floor"
y = -2
"""


def choose(page, tmp_path, text):
    file = tmp_path / "a room.toml"
    file.write_text(text, "utf-8")
    page.locator("#rooms-file").set_input_files(file)
    return file


def test_a_room_of_a_file_is_described_printed_and_kept_in_a_link(page, tmp_path):
    page.evaluate("change({ alpha: 20 }), draw(), keepAddress()")
    choose(page, tmp_path, ROOM)
    page.wait_for_function("roomView()?.gl")
    page.locator("#rooms-window").select_option("tilted")
    page.locator("#rooms-yaw").fill("20")
    page.evaluate("draw()")
    said = page.locator("#rooms-says").text_content()
    assert "tilted: two sheets, α = −300.5°, turned by 20.0° and tilted by 0.0°, at (1.7, 0, 0)" in said
    assert "rook (−1.7, −1, 2)" in said and '“α "povgen"”' in said
    expect(page.locator("#rooms-choice option:checked")).to_have_text("my room")
    page.locator("#rooms-area").press("ArrowRight")
    expect(page.locator("#rooms-eye")).to_have_text(re.compile(r"^Your eye is at \(1\.05, "))
    page.evaluate("window.print = () => { window.printed = $('rooms-printed').naturalWidth; }")
    page.locator("#rooms-print").click()
    page.wait_for_function("window.printed > 100")
    page.emulate_media(media="print")
    for part, seen in (("#rooms-printed", True), ("#rooms-says", True), ("main", False), ("#rooms-yaw", False)):
        expect(page.locator(part)).to_be_visible(visible=seen)
    assert page.locator("#rooms-says").bounding_box()["height"] > 20  # not clipped
    page.emulate_media(media="screen")
    link = page.evaluate("keepAddress(), location.hash")
    page.locator("#rooms .close").click()
    page.wait_for_function("!session.room")
    assert page.evaluate("[state.alpha, toHash().includes('alpha=20')]") == [20, True]
    page.evaluate("(link) => { fromHash(link); draw(); }", link)
    expect(page.locator("#rooms")).to_be_visible()
    assert page.evaluate("[session.moved['tilted.yaw'], state.alpha]") == [20, 20]
    page.keyboard.press("Escape")
    expect(page.locator("#rooms")).to_be_hidden()


FILES = [*sorted((PROJECT / "docs/rooms").glob("*.toml")), *sorted(EXAMPLES.glob("*.toml"))]


def test_a_file_states_the_same_as_for_povgen(page, tmp_path):
    page.evaluate("fonts()")
    (tmp_path / "room.toml").write_text(ROOM, "utf-8")
    script = "(text) => { const room = roomOf(text); return drawing(room).scene(room); }"
    for file in (tmp_path / "room.toml", *FILES):
        found, wanted = page.evaluate(script, file.read_text("utf-8")), values(Room.load(file))
        for name in ("background", "eye", "floor_y", "rim", "pupil"):
            assert found[name] == (wanted[name] | {"name": "eye"} if name == "eye" else wanted[name]), (file, name)
        for name in ("windows", "objects"):
            for one, other in zip(found[name], wanted[name], strict=True):
                for part in {"place", "axes", "half", "depth", "numbers", "colour"} & {*other}:
                    near = 0.01 if part == "numbers" else 1e-9  # the browser measures the width of a text
                    np.testing.assert_allclose(one[part], other[part], rtol=near, atol=1e-9, err_msg=f"{file} {part}")
                for part in {"kind", "sheet", "round", "framed"} & {*other}:
                    assert one[part] == other[part], file
                for parameter, value in other.get("values", {}).items():
                    assert one["values"].get(parameter, value) == value, (file, parameter)


FAULTY = {
    "# nothing": "The file states no room; allowed: [eye], [[window]], [[object]]",
    "[eye]\nz = -8\nview = \n": "line 3 is not TOML: view =",
    "[[window]]\nalpha = 400": "window1.alpha = 400 is not allowed; allowed: -360 to 360",
    "[[window]]\nname = 'w'\nsheet = 'idea'": 'window1.sheet = "idea" is not allowed; allowed: detailed, ideal',
    "[[window]]\nprisms = 2.5": "window1.prisms = 2.5 is not allowed; allowed: 1 to 3000",
    "[[window]]\nsheet = 'axis'\naxis = [0, 0, 0]": "window1.axis = [0,0,0] is not allowed; allowed: [x, y, z], -1",
    "[[window]]\nsheet = 'lenticular'\nf_number = 1": 'window1.sheet = "lenticular" is not allowed',
    "[[window]]\nframe = 1": "window1.frame = 1 is not allowed; allowed: true, false",
    "[[window]]\nglass = 'BK7'": "window1.glass: the page does not know it; allowed: alpha, prisms",
    "[[object]]\nkind = 'card'": 'kind = "card" is not allowed; allowed: box, floor, pedestal',
    "[[object]]\nkind = 'sphere'\ncolor = 'redd'": 'sphere1.color = "redd" is not allowed; allowed: #c87529',
    "[[object]]\nkind = 'piece'\npiece = 'a.stl'": 'piece1.piece = "a.stl" is not allowed; allowed: pawn, rook',
    "[[object]]\nkind = 'box'\nname = 'Eye'": "name = eye: two things have it",
    "window = 3": "window = 3 is not allowed; allowed: [[window]]",
    "pupil = 0.1": 'focus = "best" is not allowed; allowed: 0.01 to 1000000',
    "scene = 'chess'": 'scene = "chess" is not allowed; allowed: room',
    "[[window]]\n" * 21: "[[window]] = 21 is not allowed; allowed: 0 to 20",
    "#" * 2**15: "text = 32768 bytes is not allowed; allowed: 16384 bytes",
}


def test_a_faulty_file_is_refused_in_a_line(page, tmp_path):
    """What is wrong, its value, and what is allowed. The room before stays."""
    page.evaluate("session.room = 'two'; draw()")
    for text, said in FAULTY.items():
        choose(page, tmp_path, text)
        expect(page.locator("#rooms-message")).to_contain_text(f"a room.toml: {said}")
    assert page.evaluate("[session.room, $('rooms-choice').value]") == ["two", "two"]
    expect(page.locator("#rooms-look")).to_contain_text("lean to opposite sides")
    page.locator("#rooms-alpha").fill("70")
    expect(page.locator("#rooms-look")).to_contain_text("what is far appears turned by the whole angle α")
    page.locator("#rooms-reset").press("Enter")
    expect(page.locator("#rooms-choice")).to_be_focused()  # the button has nothing to do now
    expect(page.locator("#rooms-look")).to_contain_text("lean to opposite sides")
    choose(page, tmp_path, '[[object]]\nkind = "sphere"')
    expect(page.locator("#rooms-look")).to_be_empty()  # there is no window
    page.keyboard.press("Escape")
    expect(page.locator("#rooms")).to_be_hidden()
    page.evaluate("fromHash('#room=scrambledandcut'), draw()")
    expect(page.locator("#rooms-message")).to_have_text("The link to this room is not complete.")
    page.keyboard.press("Escape")
    expect(page.locator("#rooms")).to_be_hidden()
