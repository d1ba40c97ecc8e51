"""Two windows of any sheets, on the teaching page in a real browser."""

import re

import numpy as np
import pytest
from conftest import scene_of
from playwright.sync_api import expect

from demo.conftest import centre, show
from demo.test_equations import NOT_A_NUMBER

LENS = {"windows": 2, "sheet": "lens", "sheet2": "ideal", "focal_length": 4, "alpha2": 60}
GLASS = {"windows": 2, "sheet": "axis", "sheet2": "detailed", "alpha": 10, "axis": [0, 1, 0], "alpha2": 40}

# For each pixel in the predicted outline: whether it shows the knight.
KNIGHT_IN_OUTLINE = """() => {
  const [width, height] = [128, 96], scale = stage.clientHeight / height;
  Object.assign(view.scene, moment().scene);
  const { shown } = readout(view, width, height);
  return [...Array(width * height).keys()].filter((k) => {
    const [x, y] = [(k % width) + 0.5 - width / 2, height / 2 - Math.floor(k / width) - 0.5];
    return $("image").isPointInFill(new DOMPoint(x * scale, y * scale));
  }).map((k) => shown[4 * k] === 3);
}"""


def choose(page, first, second):
    page.get_by_label("Kind of window").select_option("series")
    page.locator("#of-sheet").select_option(first)
    page.locator("#of-sheet2").select_option(second)


def test_a_choice_of_two_sheets_shows_their_sliders(page):
    names = ["alpha", "alpha2", "d", "prisms", "focal_length", "ratio", "twist", "number-axisx"]
    for first, second, wanted in (
        ("ideal", "same", {"alpha", "alpha2", "d"}),
        ("lens", "ideal", {"focal_length", "alpha2", "d"}),
        ("axis", "detailed", {"alpha", "number-axisx", "alpha2", "d", "prisms"}),
        ("detailed", "single", {"alpha", "alpha2", "d", "prisms"}),
    ):
        choose(page, first, second)
        expect(page.locator("#beyond")).to_have_value("series")
        for name in names:
            place = page.locator(f"#{name}" if "-" in name else f"#slider-{name}")
            expect(place).to_be_visible(visible=name in wanted)
        both = {"ideal", "same"} == {first, second}
        expect(page.locator("#value-Z")).to_be_visible(visible=both)
        expect(page.locator("#value-nu")).to_be_visible(visible=both)
        expect(page.locator("#orientation")).to_be_visible(visible=both)
        assert not re.search(NOT_A_NUMBER, page.evaluate("document.querySelector('main').outerHTML"))
        assert [sheet.name for sheet in scene_of(page).sheets] == [first, first if second == "same" else second]


def test_a_sheet_begins_with_its_own_values(page):
    """So about an axis it is not dark, in either window; Undo brings the user's own values back."""
    choose(page, "ideal", "same")
    page.locator("#number-alpha2").fill("77")
    choose(page, "ideal", "axis")
    assert page.evaluate("[state.alpha, state.alpha2, state.axis]") == [120, 20, [0, 1, 0]]
    page.locator("#undo").click()
    assert page.evaluate("[state.sheet2, state.alpha2]") == ["same", 77]


@pytest.mark.parametrize("values", [LENS, GLASS], ids=["lens", "axis"])
def test_the_picture_and_the_mark_are_where_python_says(page, values):
    show(page, **values, E=[0.2, 0.1], position=True)
    scene, z1 = scene_of(page), page.evaluate("moment().z1")
    place = complex(scene.apparent_position(scene.L, z1))
    assert abs(place - scene.L) > 0.1
    assert abs(centre(page, "#predicted") - place) < 0.02
    shown = page.evaluate(KNIGHT_IN_OUTLINE)
    assert len(shown) > 100 and np.mean(shown) > (0.6 if scene.has_prisms else 0.9)
    assert "thing" in page.evaluate("[...contents(moment())]")
    for text in (page.locator("#sentence").text_content(), page.evaluate("describe(moment())")):
        assert "First window: The sheet" in text and "Second window: " in text
