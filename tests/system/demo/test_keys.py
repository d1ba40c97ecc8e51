"""Keys of the teaching page, where the focus is, and what is spoken."""

import re

from playwright.sync_api import expect

from demo.conftest import heard, show


def test_keys_and_their_off_switch(page):
    for key, test in (
        ("p", "state.sheet === 'detailed'"), ("p", "state.sheet === 'ideal'"), ("o", "state.position"),
        ("c", "state.circles"), ("i", "state.image"), ("q", "state.question === 0"), ("q", "state.question === -1"),
        ("l", "state.large"), ("l", "!state.large"),
        (" ", "player.playing"),
        (" ", "!player.playing"),
    ):  # fmt: skip
        page.keyboard.press(key)
        assert page.evaluate(test), key
    for on in (True, False):
        page.keyboard.press("f")
        page.wait_for_function("(on) => Boolean(document.fullscreenElement) === on", arg=on)
    show(page, sheet="ideal")
    for control, key in (("#number-alpha", "p"), ("#piece", "p"), ("#loop", " ")):
        page.locator(control).focus()
        page.keyboard.press(key)
        assert page.evaluate("[state.sheet, player.playing]") == ["ideal", False], control
    assert page.evaluate("$('loop').checked")  # the control has had its key
    page.evaluate("document.querySelector('footer details').open = true")
    page.get_by_label("Single keys are shortcuts").uncheck()
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("p")
    assert page.evaluate("state.sheet") == "ideal"


def test_everything_is_reached_by_the_tab_key(page):
    wanted = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, summary")].filter((control) =>
             control.checkVisibility() && !control.disabled && control.tabIndex >= 0
             && !control.closest("details:not([open]) > :not(summary)") 
             && (control.type !== "radio" || control.checked)).length"""
    )
    page.evaluate("window.reached = new Set(); addEventListener('focusin', (event) => reached.add(event.target))")
    page.evaluate("document.querySelector('#scene input:checked').focus()")
    for _ in range(wanted + 3):
        page.keyboard.press("Tab")
    assert page.evaluate("reached.size") >= wanted > 30


def test_the_focus_stays_where_something_opens_or_moves(page):
    page.get_by_role("button", name="Skip to the panels").press("Enter")
    expect(page.locator("#tab-explore")).to_be_focused()
    page.locator("#show-large").press(" ")
    page.evaluate("draw()")
    expect(page.locator("#show-large")).to_be_focused()
    page.locator("#show-large").press(" ")
    page.get_by_role("button", name="What is a sheet?").press("Enter")
    expect(page.locator("#what-sheet")).to_be_focused()  # so it is spoken
    page.keyboard.press("Escape")
    expect(page.get_by_role("button", name="What is a sheet?")).to_be_focused()
    page.locator("#tab-questions").press("Enter")
    page.evaluate("draw()")
    page.locator("#tab-questions").press("Tab")
    page.locator("#level").press("Tab")
    expect(page.locator("#prediction input").first).to_be_focused()
    page.locator("#reveal").press("Tab")
    expect(page.locator("#question-count")).to_be_focused()
    page.keyboard.press("Tab")
    expect(page.locator("#next")).to_be_focused()  # the first question has none before it
    expect(page.locator("#prediction")).to_have_accessible_name(page.locator("#ask").text_content())


def test_the_picture_is_described_in_words(page):
    """Where things are, what is seen, and why the object turns less than what is far away."""
    page.evaluate("openQuestion(1); draw()")
    label = page.evaluate("describe(moment())")
    assert "mountains" not in label and label.endswith("the description comes with the answer.")
    page.evaluate("openQuestion(-1); draw()")
    assert page.evaluate("describe(moment())") == (
        "A knight seen through the ideal sheet. α = 66.0°, z₁ = 2 and z₂ = 6 tiles. "
        "The object L is 0.85 tiles down from the window’s middle, the eye E opposite the window’s middle. "
        "Seen in the window, L is 0.187 tiles to the right and 0.698 tiles down from the window’s middle. "
        "The mountains, which are far away, appear turned by 66.0° counter-clockwise. The sheets turn the direction of "
        "each ray, but do not change the place where it crosses them: the nearer a thing is behind them, the less "
        "the turned line of sight has moved to the side there, and the less the thing turns. "
        "The knight appears turned by 15.0° counter-clockwise, and 1.13 times as large as without the sheets."
    )
    show(page, alpha=0)
    assert "mountains" not in page.evaluate("describe(moment())")


def test_the_light_and_the_curtain_are_spoken(page):
    spoken = page.locator("#spoken")
    page.locator("#light").select_option("pencil")
    expect(spoken).to_have_text(re.compile("25 rays from L[.] "))
    page.locator("#light").select_option("aim")
    expect(spoken).to_have_text(re.compile("Through it the eye sees: .*[.]$"))
    ring = page.locator("#aim-picture")
    expect(ring).to_have_accessible_name(re.compile("^Ring, 0.5 tiles to the right and 0.5 tiles up from"))
    before = spoken.text_content()
    for _ in range(5):
        ring.press("Shift+ArrowLeft")
    expect(spoken).not_to_have_text(before)
    page.locator("#compare").select_option("none")
    expect(page.locator("#curtain")).to_be_visible()
    page.locator("#curtain").press("ArrowLeft")
    expect(page.locator("#curtain")).to_have_attribute("aria-valuetext", "ideal sheet: 49%, no sheet: 51%")


def test_a_live_region_is_written_only_if_it_changes(page):
    page.get_by_role("tab", name="Measure").click()
    page.evaluate("draw()")
    expect(page.locator("#readings")).to_be_empty()  # no point has been placed
    written = heard(page, "readings")
    page.evaluate("draw(); draw()")
    assert written() == []
    page.locator("#point-C").press("ArrowRight")
    page.evaluate("draw(); draw()")
    assert len(written()) == 1
    expect(page.locator("#plot-nu")).to_have_accessible_name("ν over α. No points are measured yet.")
    page.get_by_role("tab", name="Explore").click()
