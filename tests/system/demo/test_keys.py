"""Keys, accessibility and layout of the teaching page."""

import re

import pytest
from axe_playwright_python.sync_playwright import Axe
from conftest import AXE
from playwright.sync_api import expect

from demo.conftest import heard, show

SIZES = {"laptop": (1280, 720), "phone": (390, 844), "phone sideways": (844, 390), "projector": (1920, 1080)}


def test_keys_and_their_off_switch(page):
    for key, test in (
        ("p", "state.sheet === 'detailed'"), ("p", "state.sheet === 'ideal'"), ("o", "state.position"),
        ("c", "state.circles"), ("i", "state.image"), ("q", "state.question === 0"), ("q", "state.question === -1"),
        (" ", "player.playing"),
        (" ", "!player.playing"),
    ):  # fmt: skip
        page.keyboard.press(key)
        assert page.evaluate(test), key
    page.evaluate("Object.defineProperty(document, 'fullscreenEnabled', { value: false, configurable: true })")
    page.evaluate("void (document.documentElement.requestFullscreen = () => Promise.reject(new TypeError('refused')))")
    page.keyboard.press("f")  # nothing is shown in full screen, and nothing fails
    page.evaluate("delete document.fullscreenEnabled; delete document.documentElement.requestFullscreen")
    show(page, sheet="ideal")
    for control, key in (
        ("#number-alpha", "p"),
        ("#piece", "p"),
        ("#reset", " "),
        ("#loop", " "),
        ("#tab-explore", " "),
    ):
        page.locator(control).focus()
        page.keyboard.press(key)
        assert page.evaluate("[state.sheet, player.playing]") == ["ideal", False], control
    assert page.evaluate("$('loop').checked")  # the control has had its key
    page.evaluate("document.querySelector('details').open = true")
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


def test_the_focus_is_not_lost_at_the_end_of_a_presentation(page):
    for end in ("Enter", "Escape"):
        page.get_by_role("button", name="More").press("Enter")
        page.get_by_role("button", name="Present").press("Enter")
        expect(page.locator("#leave")).to_be_focused()
        page.keyboard.press(end)
        expect(page.get_by_role("button", name="More")).to_be_focused()


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (800, 600), (640, 360), (360, 640)])
def test_a_presentation_shows_the_picture_on_every_screen(page, width, height):
    page.set_viewport_size({"width": width, "height": height})
    page.evaluate("$('present').click()")
    stage = page.locator("#stage").bounding_box()
    page.evaluate("$('leave').click()")
    assert (
        stage["width"] >= min(0.9 * width, 0.75 * height) and stage["x"] >= 0 and stage["x"] + stage["width"] <= width
    )


def test_the_picture_is_described_in_words(page):
    """Where things are, what is seen, and why the object turns less than what is far away."""
    page.evaluate("openQuestion(1); draw()")
    label = page.evaluate("describe(moment())")
    assert "mountains" not in label and label.endswith("the description comes with the answer.")
    page.evaluate("openQuestion(-1); draw()")
    assert page.evaluate("describe(moment())") == (
        "A knight seen through the ideal sheet. α = 66.0°, z₁ = 2 and z₂ = 6 tiles. "
        "The object L is 0.85 tiles down from the window’s middle, the eye E opposite the window’s middle. "
        "The mountains, which are far away, appear turned by 66.0° counter-clockwise. The sheets turn the direction of "
        "each ray, but not the place where it crosses them: the nearer a thing is behind them, the less far aside "
        "the turned line of sight has come there, and the less the thing turns. "
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
    page.locator("#curtain").press("ArrowLeft")
    expect(page.locator("#curtain")).to_have_attribute("aria-valuetext", "ideal sheet: 49%, no sheet: 51%")


def test_a_live_region_is_written_only_if_it_changes(page):
    page.get_by_role("tab", name="Measure").click()
    page.evaluate("draw()")
    written = heard(page, "readings")
    page.evaluate("draw(); draw()")
    assert written() == []
    page.locator("#point-C").press("ArrowRight")
    page.evaluate("draw(); draw()")
    assert len(written()) == 1
    expect(page.locator("#plot-nu")).to_have_accessible_name("ν over α. No points are measured yet.")
    page.get_by_role("tab", name="Explore").click()


def test_axe_finds_no_fault(page):
    faults = {}
    for name, (size, values) in {
        "opening": ("laptop", {}),
        "drawings": ("laptop", {"position": True, "circles": True, "image": True, "caption": True, "diagram": "paper"}),
        "question": ("phone", {"question": 3, "sheet": "none"}),
        "spheres": ("phone sideways", {"scene": "spheres", "sheet": "single"}),
        "series": ("laptop", {"windows": 2, "position": True, "diagram": "paper"}),
        "axis": ("phone", {"sheet": "axis"}),
        "lenses": ("laptop", {"sheet": "lenticular"}),
        "chosen ray": ("laptop", {"light": "aim"}),
        "field of rays": ("laptop", {"light": "field", "large": True}),
    }.items():
        page.set_viewport_size(dict(zip(("width", "height"), SIZES[size], strict=True)))
        page.evaluate("fromHash('')")
        page.evaluate("document.querySelector('details').open = true")
        show(page, **values)
        found = Axe().run(page, options=AXE).response["violations"]
        faults |= {f"{name}: {fault['id']}": [node["html"][:120] for node in fault["nodes"]] for fault in found}
    page.evaluate("fromHash('')")
    page.set_viewport_size(dict(zip(("width", "height"), SIZES["laptop"], strict=True)))
    for names in (
        ["dark"] * 2,
        ["share-open"] * 2,
        ["room-open"] * 2,
        ["share-open", "present", "leave"],
    ):  # from one to the next
        for name in names:
            page.evaluate("(name) => { $(name).click(); draw(); }", name)
            found = Axe().run(page, options=AXE).response["violations"]
            faults |= {f"{name}: {fault['id']}": [node["html"][:120] for node in fault["nodes"]] for fault in found}
    aids = "() => { for (const button of document.querySelectorAll('#aids [aria-controls]')) button.click(); draw(); }"
    for language in ("en", "ar"):
        page.evaluate("(language) => { choose(language); openQuestion(1); draw(); }", language)
        page.evaluate(aids)
        found = Axe().run(page, options=AXE).response["violations"]
        faults |= {f"{language}: {fault['id']}": [node["html"][:120] for node in fault["nodes"]] for fault in found}
        page.evaluate(aids)
    page.evaluate("choose('en'); openQuestion(-1); draw()")
    assert not faults


@pytest.mark.parametrize("size", SIZES)
def test_nothing_is_cut_off(page, size):
    width, height = SIZES[size]
    page.evaluate("document.querySelector('details').open = false")
    page.set_viewport_size({"width": width, "height": height})
    for values in (
        {},
        {"sheet": "detailed"},
        {"scene": "spheres"},
        {"sheet": "single"},
        {"alpha": 180, "z1": 6},
        {"windows": 2, "diagram": "paper"},
        {"sheet": "axis"},
        {"question": 6},
    ):
        page.evaluate("fromHash('')")
        show(page, **values)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        if size in ("laptop", "projector"):
            assert page.evaluate("document.documentElement.scrollHeight") <= height
            if "question" in values:
                page.set_viewport_size({"width": width, "height": 650})
                expect(page.locator("#next")).to_be_in_viewport(ratio=1)
                page.set_viewport_size({"width": width, "height": height})
            assert (
                page.evaluate("((panel) => panel.scrollHeight - panel.clientHeight)(document.querySelector('.panel'))")
                <= 1
            )
        cut = """[...document.querySelectorAll("dl div, button, legend, label, .player, #sentence")]
          .filter((part) => part.scrollWidth > part.clientWidth + 1 && part.checkVisibility()
            && getComputedStyle(part).display !== "inline" && !part.matches(".hidden-text, .handle"))
          .map((part) => part.outerHTML)"""
        assert page.evaluate(cut) == []
        narrow = """[...document.querySelectorAll("select")].filter((part) => part.checkVisibility()).filter((part) => {
          const wide = part.parentNode.appendChild(part.cloneNode(true));
          wide.style.width = "auto";
          const least = wide.offsetWidth;
          wide.remove();
          return part.offsetWidth < least;
        }).map((part) => part.id)"""
        assert page.evaluate(narrow) == []
        box = page.locator("#stage").bounding_box()
        assert box["width"] / box["height"] == pytest.approx(4 / 3, abs=0.01)
        assert box["width"] * box["height"] > (0.3 if size != "phone" else 0.25) * width * height


def test_on_a_phone_the_picture_stays_in_sight(page):
    page.set_viewport_size({"width": 390, "height": 844})
    page.evaluate("scrollTo(0, 10000)")
    expect(page.locator("#stage")).to_be_in_viewport(ratio=1)
