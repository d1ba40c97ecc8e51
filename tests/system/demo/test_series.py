"""Two windows of any sheets, on the teaching page in a real browser."""

import re

from conftest import scene_of
from playwright.sync_api import expect

from demo.test_equations import NOT_A_NUMBER


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
    assert page.evaluate("[state.alpha, state.alpha2, state.axis]") == [120, 15, [0, 1, 0]]
    page.locator("#undo").click()
    assert page.evaluate("[state.sheet2, state.alpha2]") == ["same", 77]
