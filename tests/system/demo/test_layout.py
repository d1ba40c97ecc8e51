"""How the teaching page looks on screens of every size, at both levels and in every language."""

import pytest
from axe_playwright_python.sync_playwright import Axe
from conftest import AXE, FAULTS, some
from playwright.sync_api import expect

from demo.conftest import bounds, opened, show, touch
from povgen.liveview.languages import tables
from povgen.page.address import ALL_KINDS, KINDS

SIZES = some([(1280, 720), (390, 844), (899, 580), (640, 360), (844, 390), (320, 568), (1920, 1080)], 2)
LANGUAGES = ["en", "ar", *sorted({*tables(ALL_KINDS)} - {"en", "ar"})]
SERIES = [
    {"windows": 2, "sheet": "lens", "sheet2": "ideal"},
    {"windows": 2, "sheet": "axis", "sheet2": "detailed"},
    {"windows": 2, "sheet": "lenslets", "sheet2": "twist"},
]
STATES = [
    {"caption": True, "position": True, "image": True},
    {"sheet": "detailed"},
    {"scene": "spheres", "sheet": "axis"},
    {"windows": 2, "diagram": "paper"},
    {"pupil": 0.3},
    {"question": 6},
    {"alpha": 180, "z1": 5.9, "L": [0.3, -0.85]},
    *SERIES,
    *({"sheet": sheet} for sheet in KINDS),
    {"level": "simple"},
    {"level": "simple", "sheet": "detailed", "light": "prism"},
    {"level": "simple", "large": True, "light": "pencil"},
    {"level": "simple", "light": "aim"},
    {"level": "simple", "windows": 2},
]
# What is cut off: words in places that are too narrow, and selects whose longest option does not fit.
CUT = """() => [
  ...[...document.querySelectorAll("dl div, button, legend, label, label > span, .player, #sentence")]
    .filter((part) => part.scrollWidth > part.clientWidth + 1 && part.checkVisibility()
      && getComputedStyle(part).display !== "inline" && !part.matches(".hidden-text, .handle")),
  ...[...document.querySelectorAll("select")].filter((part) => part.checkVisibility()).filter((part) => {
    const wide = part.parentNode.appendChild(part.cloneNode(true));
    wide.style.width = "auto";
    const least = wide.offsetWidth;
    wide.remove();
    return part.offsetWidth < least;
  })].map((part) => part.outerHTML.slice(0, 80))"""
# What a page shows that is cut by the window's border, or by the page's if no part is given, or lies over something
# else; and letters that are smaller than this part of the window's height. The small picture lies over the light.
COVERED = """(part = 0) => {
  const faults = [], sees = (each) => each.checkVisibility({ visibilityProperty: true });
  const high = part ? innerHeight : document.documentElement.scrollHeight;
  const named = "button, select, input, .choice label, .slider label, p[id], #prediction label, #stage, #space-turn";
  const hidden = "#stage > *, .choice input, .on-focus, .hidden-text, p:empty, .handle, .title";
  const parts = [...document.querySelectorAll(named)].filter((each) => sees(each) && !each.closest(hidden));
  const boxes = parts.map((each) => each.getBoundingClientRect());
  const name = (each) => each.id || each.textContent.trim() || each.outerHTML;
  parts.forEach((a, n) => {
    const { left, right, top, bottom } = boxes[n];
    if (Math.min(left, top) < 0 || right > innerWidth || bottom > high) faults.push(`${name(a)} is cut`);
    parts.slice(n + 1).forEach((b, k) => {
      const other = boxes[n + 1 + k];
      if (a.contains(b) || b.contains(a) || (a.id === "stage" && b.id === "space-turn")) return;
      const across = Math.min(right, other.right) - Math.max(left, other.left);
      const down = Math.min(bottom, other.bottom) - Math.max(top, other.top);
      if (Math.min(across, down) > 1) faults.push(`${name(a)} is over ${name(b)}`);
    });
  });
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let text; (text = texts.nextNode()); ) {
    const within = text.parentElement, size = parseFloat(getComputedStyle(within).fontSize);
    if (!text.data.trim() || !sees(within) || within.closest("option, .hidden-text, .title, .on-focus")) continue;
    if (size < part * innerHeight - 0.01) faults.push(`${size} px: ${text.data}`);
  }
  return faults;
}"""
# By how many pixels the page is higher than the screen, and the panel's content higher than the panel.
EXCESS = """() => [document.documentElement.scrollHeight - innerHeight,
  ((panel) => panel.scrollHeight - panel.clientHeight)(document.querySelector(".panel"))]"""


def resize(page, size):
    page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_each_control_is_in_sight_on_top_and_large_enough(page, size):
    """On large screens, nothing has to be scrolled. For beginners there are fewer controls."""
    (width, height), counts = size, {}
    resize(page, size)
    for values in STATES:
        page.evaluate("fromHash('')")
        show(page, **values)
        assert page.evaluate(FAULTS) == [], values
        page.evaluate("scrollTo(0, 0)")
        if values.get("level") != "simple":
            assert page.evaluate(CUT) == [], values
            if min(width / 1280, height / 720) >= 1 and "sheet2" in values:
                assert max(page.evaluate(EXCESS)) <= 1, values
            if not values.get("large"):
                stage = page.locator("#stage").bounding_box()
                assert stage["width"] / stage["height"] == pytest.approx(4 / 3, abs=0.01)
                assert width - stage["width"] > 250 or stage["height"] < 0.5 * height  # room beside or below it
        count = (
            "[...document.querySelectorAll('button, input, select')].filter((each) => each.checkVisibility()).length"
        )
        counts.setdefault(str(values), page.evaluate(count))
    assert counts["{'level': 'simple'}"] < 0.85 * counts["{'sheet': 'detailed'}"]
    # without Playwright's wait for frames: on a busy machine Chromium at times drew none after a change of size
    page.evaluate("$('tab-measure').click()")
    show(page, level="expert")
    page.evaluate("$('put-on').click(); draw(); $('write-down').click(); draw()")
    assert page.evaluate(FAULTS) == []
    page.evaluate("rows.splice(0); session.measuring = false")
    page.evaluate("change({ alpha: 60 }); $('share-open').click(); $('present').click()")  # without the lesson
    stage = page.locator("#stage").bounding_box()
    assert stage["width"] >= min(0.9 * width, 0.75 * height)
    assert stage["x"] >= 0 and stage["x"] + stage["width"] <= width


@pytest.mark.parametrize("language", some(LANGUAGES, 1))
def test_for_a_projector_nothing_is_covered_and_all_letters_are_large(page, language):
    """With the slider that matters for the sheet, and the buttons that choose it."""
    page.evaluate("change({ alpha: 60 }); $('share-open').click(); $('present').click()")  # without the lesson
    assert page.evaluate("document.activeElement.id") == "lesson-next"  # a space does not end it
    for size in ((1024, 768), (1280, 720), (1920, 1080)):
        resize(page, size)
        for values, slider in (
            ({"alpha": 180, "light": "pencil", "large": True}, "alpha"),
            ({"sheet": "detailed", "position": True, "caption": True}, "alpha"),
            ({"sheet": "single", "light": "prism", "large": True}, None),
            ({"sheet": "lens", "level": "expert"}, "focal_length"),
            ({"question": 1, "large": True}, None),
        ):
            page.evaluate("(language) => { fromHash(''); player.reset(); choose(language); }", language)
            show(page, **values)
            page.evaluate("draw()")  # when all sentences have their lengths
            assert page.evaluate(COVERED, 1 / 40) == [], (size, values)
            sliders = page.locator("input[type=range]:visible").evaluate_all("(all) => all.map(({ id }) => id)")
            assert sliders == ([f"slider-{slider}"] if slider else [])
            expect(page.locator("#play")).to_be_visible(visible=slider == "alpha")  # what it moves
            for part in ("#leave", "#sentence", "#sheet"):
                expect(page.locator(part)).to_be_visible()
            shown = page.locator("#space-turn" if "large" in values else "#stage").bounding_box()
            assert shown["height"] > 0.33 * size[1], (size, values)
        page.evaluate("work.answers.near = { given: '1', first: false, shown: true }; draw(); draw()")
        hidden = page.evaluate(
            "(({ scrollHeight, clientHeight }) => scrollHeight - clientHeight)(document.querySelector('.panel'))"
        )
        assert hidden <= 1, size
        page.evaluate("work.answers = {}; work.votes = { near: [[7, 12, 5], [15, 6, 3]] }; rewriteQuestion()")
        page.evaluate("draw(); $('votes').hidden = false; draw()")
        assert page.evaluate(COVERED, 1 / 40) == [], size
        page.evaluate("work.votes = {}; $('votes').hidden = true; rewriteQuestion()")


def test_on_a_phone_the_picture_stays_in_sight_and_on_a_notebook_the_buttons_of_a_question(page):
    resize(page, (390, 844))
    page.evaluate("scrollTo(0, 10000)")
    expect(page.locator("#stage")).to_be_in_viewport(ratio=1)
    show(page, alpha=120)
    page.evaluate("choose('fr'); draw(); $('diagram-box').scrollIntoView({ block: 'center' })")
    at_eye = (
        "[$('eye-diagram').getBoundingClientRect()].map((at) => document.elementFromPoint(at.x + 20, at.y + 20).id)"
    )
    assert page.evaluate(at_eye) == ["eye-diagram"]  # and not the choice of the diagram's orientation
    page.evaluate("choose('en'); draw()")
    resize(page, (1280, 650))
    show(page, question=2)
    expect(page.locator("#next")).to_be_in_viewport(ratio=1)


def test_a_finger_that_scrolls_from_a_slider_and_two_on_the_picture_change_nothing(browser, demo_file):
    page, faults = opened(browser, demo_file, "#z1=2.345", has_touch=True)
    assert page.evaluate("say('page.hint')") == "Drag the object, or beside it to move your eye"  # by no keys
    upright, sideways = (390, 844), (740, 360)
    for size in (sideways, upright):
        resize(page, size)
        action = "['stage', 'eye-picture'].map((id) => getComputedStyle($(id)).touchAction)"
        assert page.evaluate(action) == ["pan-y pinch-zoom", "auto"]  # nobody sees that the eye is held
    # two fingers on the picture enlarge the page: what the first one has begun to drag is as it was
    window = page.context.new_cdp_session(page)
    for hash_, y, begun in (
        ("#z1=2", 150, 40),
        ("#z1=2", 130, 15),
        ("#light=aim", 150, 60),
        ("#scene=spheres", 130, 15),
    ):
        page.evaluate("(hash) => { fromHash(hash); draw(); scrollTo(0, 250); }", hash_)
        before = page.evaluate("({ ...state, top: scrollY })")
        moved = ([(195 - x, y), (195 + x, y)] for x in (begun, 75, 110))
        touch(page, [(195 - begun, y)], [(190 - begun, y)], *moved)
        assert page.evaluate("({ ...state, top: scrollY })") == before, hash_
        assert page.evaluate("visualViewport.scale") > 1.2
        window.send("Emulation.setPageScaleFactor", {"pageScaleFactor": 1})
    page.evaluate("fromHash('#z1=2.345')")
    page.evaluate("change({ compare: 'none' })")
    for size, slider, across, down, changes in (
        (upright, "slider-z1", 20, 0, True),
        (upright, "slider-z1", 0, 0, True),
        *((upright, "slider-z1", 0, -20, False), (sideways, "slider-z1", 0, -20, False)),  # the page scrolls
        (sideways, "curtain", 0, -20, False),
    ):
        resize(page, size)
        page.evaluate("(slider) => { draw(); scrollTo(0, slider === 'curtain' ? 0 : 200); }", slider)
        box = page.locator(f"#{slider}").bounding_box()
        x, y = box["x"] + (150 if down else 10), box["y"] + box["height"] / 2
        before, top = page.evaluate("[[state.z1, session.curtain], scrollY]")
        touch(page, *([(x + k * across, y + k * down)] for k in range(6 if across or down else 1)))
        if down:
            page.wait_for_function("(top) => scrollY > top", arg=top)
        assert (page.evaluate("[state.z1, session.curtain]") != before) == changes
    assert not faults
    page.close()


def test_the_eye_follows_a_phone_that_is_tilted(page):
    """If its right edge goes back, the eye is to its left; if its upper edge comes nearer, above its middle."""
    page.evaluate("$('tilt').click()")
    tilt = """([beta, gamma]) => new Promise((done) => {
      dispatchEvent(new DeviceOrientationEvent("deviceorientation", { beta, gamma }));
      requestAnimationFrame(() => done(state.E));
    })"""
    assert page.evaluate(tilt, [40, 5]) == [0, 0]
    assert page.evaluate(tilt, [46, 15]) == pytest.approx([-0.5, 0.3])
    page.evaluate("tour.start(); tour.paused = true")  # it moves the eye itself
    assert page.evaluate(tilt, [80, 15]) == [0, 0]
    page.evaluate("tour.leave()")
    page.evaluate("$('tilt').click()")
    assert page.evaluate(tilt, [80, 15]) == pytest.approx([-0.5, 0.3])
    page.evaluate("$('tilt').click()")  # and no event comes
    expect(page.locator("#copied")).to_have_text("This device does not say how it is tilted.")
    assert page.locator("#tilt").get_attribute("aria-pressed") == "false"


@pytest.mark.parametrize("size", [(740, 360), (390, 760)], ids=str)
def test_on_a_phone_what_is_shown_stays_beside_the_sliders(page, size):
    resize(page, size)
    page.evaluate("fromHash('')")
    for large in (False, True):
        show(page, large=large, light="pencil", level="simple")
        page.locator("#row-z2").scroll_into_view_if_needed()
        assert page.evaluate("scrollY") > 40
        for part in ("#space-turn" if large else "#stage", "#row-z1", "#row-z2"):
            expect(page.locator(part)).to_be_in_viewport(ratio=0.99)
    if size[0] > size[1]:
        assert page.locator("header").bounding_box()["height"] < 45  # one row
    else:  # a challenge needs what is said, too
        page.evaluate("fromHash('#question=quarter'), draw(), $('row-z2').scrollIntoView({ block: 'end' })")
        page.wait_for_function("scrollY > 40")
        for part in ("#stage", "#sentence", "#ask", "#row-alpha", "#row-z2"):
            expect(page.locator(part)).to_be_in_viewport(ratio=0.99)
        said, asked = (page.locator(part).bounding_box() for part in (".said", "#ask"))
        assert said["y"] + said["height"] <= asked["y"]


def test_the_light_has_the_room_that_is_free_and_letters_are_large(page):
    """On a phone, also in the guided start, and beside a question. The buttons and the sliders stay where they are."""
    resize(page, (1280, 800))
    show(page, question=1, level="simple")
    assert page.locator("#space-turn").bounding_box()["height"] > 150
    resize(page, (1366, 768))
    page.evaluate("work.answers.parallax = { given: '0', first: false, shown: true }; work.rows.length = 0")
    show(page, question=2, level="simple")
    page.evaluate("draw()")
    assert page.locator("#space-turn").bounding_box()["height"] > 80
    expect(page.locator("#show-large")).to_be_in_viewport(ratio=1)
    resize(page, (1280, 720))
    page.evaluate("choose('fr'); work.answers.pole = { given: '1', first: false, shown: true }")
    show(page, question=8, level="expert")
    page.evaluate("draw()")
    assert max(page.evaluate(EXCESS)) <= 1
    resize(page, (1366, 768))
    page.evaluate("choose('en'); openQuestion(-1); draw()")
    page.evaluate("work.answers = {}; change({ level: 'expert' }); $('tab-measure').click(); draw()")
    expect(page.locator("#move-first")).to_be_visible()
    for _ in range(4):  # rows
        page.evaluate("$('put-on').click(); draw(); $('write-down').click(); draw(); draw()")
    expect(page.locator("#plot-nu")).to_be_in_viewport(ratio=1)
    for part in ("#space-turn", "#show-large"):  # the graphs need the room
        expect(page.locator(part)).to_be_hidden()
    page.evaluate("rows.splice(0); session.measuring = false; $('number-alpha').focus(); draw()")
    dimmed = "[...document.querySelectorAll('#space .q')].filter((part) => getComputedStyle(part).opacity < 1).length"
    assert page.evaluate(dimmed) == 0  # while a number is typed, nothing looks disabled
    resize(page, (390, 844))
    show(page, question=1)
    expect(page.locator("#prediction label").last).to_be_in_viewport(ratio=1)
    show(page, question=-1, level="expert")
    assert page.locator("#space-turn").bounding_box()["height"] > 200
    small = """() => [...document.querySelectorAll("body :not(svg *, sub, sup, option, .on-focus, .hidden-text)")]
      .filter((each) => each.checkVisibility() && [...each.childNodes].some(({ data }) => data?.trim()))
      .filter((each) => parseFloat(getComputedStyle(each).fontSize) < 14.5).map((each) => each.outerHTML)"""
    assert page.evaluate(small) == []
    sliders = []
    for alpha in (0, 66):  # the sentence has two lines, and three
        show(page, alpha=alpha)
        sliders += bounds(page, "#row-alpha")
    assert sliders[0] == sliders[1]
    page.evaluate("tour.start(); draw()")
    text, shows, *buttons = bounds(page, "#tour-text", ".shows", "#tour-next", "#tour-leave")
    assert shows["top"] - text["bottom"] < 40
    for step in (5, 8, 9):
        page.evaluate("(step) => { tour.go(step); tour.paused = !tour.paused; draw(); }", step)
        assert bounds(page, "#tour-next", "#tour-leave") == buttons


def test_a_question_scrolls_its_panel_but_not_the_page(page):
    resize(page, (900, 560))
    show(page, question=1)
    page.get_by_role("button", name="Predict by drawing").click()
    height, panel = page.evaluate(EXCESS)
    assert height <= 0 < panel


@pytest.mark.parametrize("language", some(LANGUAGES, 2))
def test_each_language_fits(page, language):
    """A small phone, the header of a small notebook in one row, and the table of measurements."""
    page.evaluate("(language) => { choose(language); change({ level: 'simple' }); draw(); }", language)
    resize(page, (320, 256))  # 1280 x 1024, four times as large
    aids = "(shown) => { $('drawing').hidden = $('votes').hidden = !shown; draw(); draw(); scrollTo(0, 0); }"
    for values in ({"question": 1}, {}, {"level": "simple", "large": True, "light": "pencil"}):
        page.evaluate("fromHash('')")
        show(page, **values)
        page.evaluate(aids, "question" in values)
        assert page.evaluate(COVERED) + page.evaluate(CUT) == [], values
        assert page.evaluate("document.documentElement.scrollWidth") <= 320
    assert page.locator("#space-turn").bounding_box()["height"] > 0.6 * 256
    resize(page, (1280, 800))
    middle = "(parts) => parts.map((part) => part.getBoundingClientRect()).map((at) => (at.top + at.bottom) / 2)"
    places = page.locator(".title, #tour-start, .tools").evaluate_all(middle)
    assert len(places) == 3 and max(places) - min(places) < 2
    page.evaluate("$('tab-measure').click(); draw(); $('put-on').click(); draw(); $('write-down').click(); draw()")
    for size in ((360, 740), (640, 360)):
        resize(page, size)
        table, panel = (page.locator(part).bounding_box() for part in ("#measure table", "#measure"))
        assert table["width"] <= panel["width"] + 1, size


# What the view of the light shows that is not inside it, by at least 2 px.
OUTSIDE = """() => {
  const box = document.getElementById("space-turn").getBoundingClientRect();
  const named = ":is(text, .object.q, .pedestal, .frame, .eye, .pupil, .dot, circle.image, .glass, .number)";
  const shown = [...document.querySelectorAll(`#space ${named}`)];
  return [shown.length > 5 ? [] : ["too little"], ...shown.filter((part) => {
    const { left, right, top, bottom } = part.getBoundingClientRect();
    return left < box.left + 2 || right > box.right - 2 || top < box.top + 2 || bottom > box.bottom - 2;
  }).map((part) => part.outerHTML.slice(0, 60))].flat();
}"""


@pytest.mark.parametrize("language", some(LANGUAGES, 1))
@pytest.mark.parametrize("size", some([(1280, 800), (320, 568), (844, 390), (2560, 1440)], 1), ids=str)
def test_all_that_the_view_of_the_light_names_is_inside_it(page, size, language):
    resize(page, size)
    page.evaluate("(language) => choose(language)", language)
    for values in (
        {"z1": 40, "z2": 60},
        {"light": "pencil", "alpha": 180, "z1": 6},
        {"scene": "spheres"},
        {"windows": 2, "E": [-3, 1], "large": True},
        {"light": "prism"},
        {"light": "aim", "W": [-1.4, 1.4]},
        {"light": "field"},
    ):
        for camera in ("corner", "side", "above"):
            page.evaluate("(camera) => { fromHash(''); session.camera = CAMERAS[camera]; }", camera)
            show(page, level="simple", **values)
            page.evaluate("draw()")  # when all sentences have their lengths
            assert page.evaluate(OUTSIDE) == [], (values, camera)


@pytest.mark.parametrize(
    ("size", "values", "presses"),
    [
        (
            (1280, 720),
            {"position": True, "circles": True, "image": True, "caption": True, "diagram": "paper", "pupil": 0.3},
            [],
        ),
        ((390, 844), {"question": 3, "sheet": "none"}, ["aids", "dark"]),
        *(
            pytest.param(*each, marks=pytest.mark.release)
            for each in (
                ((844, 390), {"scene": "spheres", "sheet": "single"}, []),
                ((1280, 720), {"sheet": "lenticular"}, ["dark", "dark", "share-open", "room-open"]),
                ((1280, 720), {"light": "aim"}, ["share-open", "present", "leave"]),
                ((1280, 720), {"question": 1}, ["ar", "aids"]),
                ((390, 844), {}, ["teach-open"]),
            )
        ),
    ],
    ids=str,
)
def test_axe_finds_no_fault(page, size, values, presses):
    """Of the page as it opens, and after each press: of a button, of all aids of a question, of another language."""
    resize(page, size)
    page.evaluate("document.querySelectorAll('details').forEach((each) => (each.open = true))")
    show(page, **values)
    press = """(name) => {
      if (name === "aids") for (const each of document.querySelectorAll("#aids [aria-controls]")) each.click();
      else if (name === "ar") choose(name);
      else $(name).click();
      draw();
    }"""
    for name in [None, *presses]:
        if name:
            page.evaluate(press, name)
        found = Axe().run(page, options=AXE).response["violations"]
        assert not [(fault["id"], [node["html"][:120] for node in fault["nodes"]]) for fault in found], name
