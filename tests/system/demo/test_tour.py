"""The guided start of the page."""

import base64
import re

import numpy as np
import pytest
from conftest import NAMES, PROJECT
from PIL import Image
from playwright.sync_api import expect

from demo.conftest import pixels

END = "tour.passed = 100"  # of the present step


@pytest.fixture
def tour(page):
    """The page, with its guided start. It moves only when the test says so."""
    page.evaluate("OPENING.level = 'simple'; fromHash('#alpha=30'); draw()")
    page.get_by_role("button", name="Guided start").click()
    page.evaluate("tour.paused = true")
    return page


def test_it_begins_by_itself_and_waits_for_who_uses_the_keyboard(browser, demo_file):
    page = browser.new_page(reduced_motion="no-preference")
    page.goto(demo_file.as_uri())
    page.wait_for_function("povgen.tour.tour.step >= 0 && (povgen.tour.tour.passed = -1000)")  # its intro does not end
    expect(page.locator("#spoken")).to_have_text(
        re.compile("^The guided start runs. Escape leaves it. The same knight twice")
    )
    page.keyboard.press("Tab")
    expect(page.get_by_role("button", name="Go on")).to_be_focused()
    expect(page.locator("#spoken")).to_have_text(re.compile("^Paused, step 1 of 10. "))
    expect(page.locator("#poster")).to_have_count(0)
    page.evaluate(NAMES)
    assert page.evaluate("tour.passed = 0; tour.show(); draw(); view.scene.piece") == ["knight", "knight"]
    page.wait_for_function("!view.behind")
    shown = base64.b64decode(page.evaluate("still(view, 240, 180).toDataURL().split(',')[1]"))
    with Image.open(PROJECT / "povgen/page/poster.webp") as poster:
        assert abs(pixels(shown) - np.asarray(poster.convert("RGB").resize((240, 180)))).mean() < 8
    page.evaluate("tour.passed = -1000")  # a busy machine is slow: the step does not end meanwhile
    page.keyboard.press("Enter")
    expect(page.locator("#spoken")).to_have_text("The guided start goes on.")
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.evaluate("draw()")
    assert page.evaluate("[tour.step, view.scene.piece]") == [0, "knight"]
    expect(page.locator("#tour-text")).to_contain_text("A window stands on a floor")
    expect(page.locator("#view")).to_have_attribute("aria-label", re.compile("^A knight seen without sheets"))
    expect(page.locator("#spoken")).to_have_text(re.compile("Nothing is in the window"))
    assert page.evaluate("location.hash") == ""  # the address does not follow
    page.keyboard.press("Escape")
    assert page.evaluate("povgen.state.state.sheet") == "ideal"  # as it was
    start = page.get_by_role("button", name="Guided start")
    for leave in (lambda: None, page.get_by_role("button", name="Leave").click):
        leave()
        expect(start).to_be_focused()
        expect(page.locator("#sentence")).to_be_visible()
        expect(page.locator("#spoken")).to_have_text("The guided start has ended.")
        start.press("Enter")
    page.evaluate("tour.go(8)")
    page.reload()
    page.wait_for_function("povgen.tour.tour.step === 8 && povgen.tour.tour.asked")
    page.evaluate(NAMES)
    page.evaluate("tour.leave(); choose('de', true); draw()")
    expect(page.locator("#spoken")).to_be_empty()  # what was spoken in another language
    page.close()


def test_it_begins_for_a_projector_too_and_a_remote_control_leads_on(browser, demo_file):
    page = browser.new_page(reduced_motion="no-preference")
    page.goto(f"{demo_file.as_uri()}#sheet=none")
    page.evaluate("povgen.look.present(true)")
    page.goto(demo_file.as_uri())
    for key, step in (("PageDown", 0), ("PageDown", 1), ("PageUp", 0)):
        page.wait_for_function("povgen.tour.tour.step >= 0")
        page.keyboard.press(key)
        assert page.evaluate("[povgen.tour.tour.step, povgen.tour.tour.intro]") == [step, False]
    expect(page.locator("#leave")).to_be_visible()
    expect(page.locator("#tour-text")).to_be_visible()
    expect(page.locator(".panel")).to_be_hidden()  # it has no room
    page.close()


def test_it_does_not_begin_for_who_has_begun(browser, demo_file):
    """Before the picture is ready. It is when the piece that it shows has been read, not all."""
    begin = "$('tab-measure').click(); window.poster = getComputedStyle($('poster')).display"
    begin += "; view.ready.then(() => (window.read = Object.keys(view.shapes.fields).length))"
    page = browser.new_page(reduced_motion="no-preference")
    page.add_init_script(f"addEventListener('DOMContentLoaded', () => {{ {NAMES}; {begin}; }})")
    page.goto(demo_file.as_uri())
    found = page.evaluate("view.ready.then(() => [tour.step, Boolean(view.gl), read, poster])")
    assert found == [-1, True, 1, "none"]
    page.close()


def test_each_step_follows_the_one_before_and_the_end_is_the_beginning(tour):
    assert tour.evaluate("state.alpha") == 66
    texts = []
    for n in range(10):
        tour.evaluate("tour.paused = false")
        tour.wait_for_function("(n) => tour.step === n && (tour.paused = true)", arg=n)
        tour.evaluate("draw()")
        texts.append(tour.locator("#tour-text").text_content())
        expect(tour.locator("#tour-count")).to_have_text(f"{n + 1} of 10")
        tour.evaluate(END)
    tour.evaluate("view.drawn = view.context.program('picture'); tour.paused = false")  # as if it were drawn
    tour.wait_for_function("tour.passed > 100")  # the last step waits
    tour.get_by_role("button", name="Done").click()
    assert len({*texts}) == 10
    assert tour.evaluate("state.alpha") == 30  # as it was
    assert 60 <= (seconds := tour.evaluate("tour.seconds()")) <= 90, seconds


def test_a_step_that_someone_has_gone_to_waits_at_its_end(tour):
    tour.evaluate("tour.paused = false")
    tour.get_by_role("button", name="Next").click()
    tour.evaluate(END)
    tour.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))")
    assert tour.evaluate("tour.step") == 1
    tour.get_by_role("button", name="Go on").click()
    tour.wait_for_function("tour.step === 2")
    expect(tour.get_by_role("button", name="Pause")).to_be_visible()


def test_what_the_steps_say_is_what_they_show(tour):
    tour.evaluate("tour.go(3); tour.passed = 9; tour.show()")
    assert tour.evaluate("[state.sheet, state.alpha]") == ["detailed", 66]
    tour.evaluate("tour.go(5); tour.passed = 12; tour.show(); draw()")
    mountains, knight = tour.evaluate("[state.alpha, moment().nu * 180 / Math.PI]")
    assert mountains == 120 and 0 < knight < 30
    for passed, least, most in ((0, 0, 6), (15, 40, 50)):  # near, and far
        tour.evaluate("(passed) => { tour.go(6); tour.passed = passed; tour.show(); draw(); }", passed)
        assert least < tour.evaluate("moment().nu * 180 / Math.PI") < most
        assert tour.evaluate("moment().place") == pytest.approx([0.3, -0.3])  # where the ray crosses the window
        expect(tour.locator("#space .straight")).to_have_count(1)
    tour.evaluate("tour.go(7); tour.passed = 9; tour.show(); draw()")
    assert tour.evaluate("[state.alpha, Math.round(moment().nu), moment().M / bare(moment()) > 1.9]") == [180, 0, True]
    tour.evaluate("tour.go(8); draw()")
    expect(tour.locator("#light-says")).to_contain_text("They meet 2 tiles in front of the window")
    for aside in (0, 0.4):  # each point's image is straight opposite it: the image is upright
        tour.evaluate("(aside) => change({ L: [aside, aside - 0.85] })", aside)
        assert tour.evaluate("meeting(bundle(moment()))") == pytest.approx([aside, aside - 0.85, -2])


def test_who_goes_from_step_to_step_sees_and_hears_where_each_one_ends(tour):
    button, spoken = tour.get_by_role("button", name="Next"), tour.locator("#spoken")
    for text, seen in (
        ("(?!.*exchanges)This is one prism", ""),  # the light is shown in place of the picture
        ("A hundred such prisms", "One sheet exchanges sky and floor."),
        ("A second sheet mirrors again", "The knight appears turned by 1[0-9.]+° counter-clockwise"),
    ):
        button.press("Enter")
        tour.evaluate("draw()")
        expect(spoken).to_have_text(re.compile(f"^{text}.*{seen}"))
    tour.get_by_role("button", name="Previous").click()
    expect(tour.locator("#tour-text")).to_have_text(re.compile("^A hundred such prisms"))


def test_it_begins_at_the_level_of_experts_too(page):
    more = page.get_by_role("button", name="More")
    more.click()
    page.get_by_role("button", name="Guided start").click()
    expect(more).to_have_attribute("aria-expanded", "false")
    expect(page.get_by_role("button", name="Next")).to_be_focused()
    assert page.evaluate("[tour.step, state.level]") == [0, "expert"]
    page.keyboard.press("Escape")
    expect(more).to_be_focused()


def test_who_moves_something_takes_over(tour):
    """They see the picture again, with the sheet of this step. Who takes over in the view of the light, stays there.

    Who wears glasses, keeps them.
    """
    tour.evaluate(
        "tour.leave(); change({ depth: true, position: true }); tour.start(); tour.paused = true; tour.go(1); draw()"
    )
    assert tour.evaluate("[state.depth, state.position]") == [True, False]
    tour.locator("#number-z1").fill("3")
    assert tour.evaluate("[state.depth, state.position]") == [True, True]
    shown = tour.evaluate("[tour.step, state.z1, state.sheet, state.large, state.light]")
    assert shown == [-1, 3, "single", False, "ray"]
    tour.evaluate("draw()")
    expect(tour.locator("#compare")).to_be_visible()
    tour.get_by_role("button", name="Guided start").click()
    tour.evaluate("tour.go(1); draw()")
    expect(tour.locator("#compare")).to_be_hidden()
    tour.locator("#show-stray").check()
    assert tour.evaluate("[tour.step, state.large, state.light, state.stray]") == [-1, True, "prism", True]
    tour.evaluate("draw()")
    expect(tour.locator("#sentence")).to_be_visible()
    tour.evaluate("fromHash(''); tour.start(); tour.go(1)")  # as by itself
    tour.get_by_role("button", name="More").click()
    assert tour.evaluate("[tour.step, state.sheet]") == [-1, "ideal"]  # Present can begin the lesson
    tour.get_by_role("button", name="More").click()


def test_a_finger_takes_over_when_it_moves_something(tour):
    """A tap, or the beginning of a swipe that scrolls the page, ends nothing."""
    tour.evaluate("tour.paused = true; tour.go(2); draw()")
    step = """(types) => {
      const finger = { pointerId: 1, isPrimary: true, bubbles: true, pointerType: "touch", clientY: 200 };
      for (const [type, x] of types) stage.dispatchEvent(new PointerEvent(type, { ...finger, clientX: 200 + x }));
      draw();
      return tour.step;
    }"""
    assert tour.evaluate(step, [["pointerdown", 0], ["pointermove", 5], ["pointerup", 5], ["click", 5]]) == 2
    assert (
        tour.evaluate(step, [["pointerdown", 0], ["pointermove", 20], ["pointercancel", 20], ["pointermove", 40]]) == 2
    )
    assert tour.evaluate(step, [["pointerdown", 0], ["pointermove", 40], ["pointerup", 40]]) == -1


def test_a_step_waits_until_its_picture_can_be_drawn(tour):
    tour.evaluate("view.drawn = null; tour.go(0); tour.passed = 0; tour.paused = false")
    passed = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(tour.passed))))"
    assert tour.evaluate(passed) == 0
    tour.evaluate("view.drawn = view.context.program('picture')")
    tour.wait_for_function("tour.passed > 0")


def test_a_key_that_does_nothing_leaves_it_running(tour):
    for key in ("h", "F7", "Insert"):
        tour.keyboard.press(key)
    assert tour.evaluate("tour.step") == 0
    tour.keyboard.press("p")  # a shortcut
    assert tour.evaluate("tour.step") == -1


def test_an_address_takes_over(tour):
    tour.evaluate("location.hash = '#question=near'")
    tour.wait_for_function("tour.step < 0")
    assert tour.evaluate("[state.question, session.explored.alpha]") == [1, 30]


def test_the_teachers_panel_begins_with_what_the_page_showed_before(tour):
    """There, keys move nothing behind it."""
    tour.get_by_role("button", name="For teachers").click()
    for key in ("p", "q"):
        tour.keyboard.press(key)
    assert tour.evaluate("[tour.step, state.alpha, state.sheet, state.question]") == [-1, 30, "ideal", -1]
    tour.keyboard.press("Escape")
    expect(tour.get_by_role("dialog")).to_be_hidden()


def test_nothing_goes_on_at_the_end_of_the_last_step(tour):
    tour.evaluate("tour.byHand = true; tour.paused = false; tour.go(tour.steps.length - 1); draw()")
    pause, done = tour.locator("#tour-pause"), tour.get_by_role("button", name="Done")
    expect(pause).to_be_enabled()
    pause.focus()
    tour.evaluate("tour.passed = tour.now.seconds; draw()")
    expect(pause).to_be_disabled()
    expect(done).to_be_focused()
    done.press("Enter")
    assert tour.evaluate("tour.step") == -1


def test_with_reduced_motion_each_step_waits(tour):
    tour.emulate_media(reduced_motion="reduce")
    tour.evaluate("tour.leave(); tour.start(); draw()")
    expect(tour.locator("#tour-pause")).to_be_hidden()
    tour.evaluate("tour.go(3); draw()")
    assert tour.evaluate("state.alpha") == 66  # at once
    frame = "new Promise((done) => requestAnimationFrame(() => done(tour.passed)))"
    assert tour.evaluate("tour.passed") == tour.evaluate(frame) > 0
    tour.get_by_role("button", name="Next").press("Enter")
    assert tour.evaluate("tour.step") == 4
