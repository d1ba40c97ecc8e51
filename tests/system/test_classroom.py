"""What a class does with the page: on small screens, in high contrast, with questions, and with settings of its own."""

import numpy as np
import pytest
from playwright.sync_api import expect
from test_demo import file, page, shared, show  # noqa: F401 (the shared page and its fixtures)

from povgen.optics import rotation

pytestmark = [pytest.mark.xdist_group("demo"), pytest.mark.timeout(600)]

SMALL = [(800, 600), (853, 683), (640, 620), (899, 580), (360, 640)]
# Of each visible control: whether it is on top at its centre, and whether it is a target of 24 px; of each text: its size.
CONTROLS = """() => {
  const found = [];
  for (const control of document.querySelectorAll("button, input, select, summary")) {
    if (!control.checkVisibility() || control.disabled) continue;
    control.scrollIntoView({ block: "nearest" });
    const name = control.id || control.getAttribute("aria-label") || control.value || control.outerHTML;
    const { x, y, width, height } = control.getBoundingClientRect();
    const top = document.elementFromPoint(x + width / 2, y + height / 2);
    const parts = [control, ...(control.labels ?? [])];
    if (!parts.some((part) => part.contains(top))) found.push(`${name} is under ${top?.outerHTML.slice(0, 60)}`);
    const side = Math.max(...parts.map((part) => part.getBoundingClientRect()).map((box) => Math.min(box.width, box.height)));
    if (side < 23.9) found.push(`${name} is ${side} px`);
  }
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode()); ) {
    const part = node.parentElement;
    const size = parseFloat(getComputedStyle(part).fontSize);
    if (node.data.trim() && part.checkVisibility() && size < 12) found.push(`${size} px: ${node.data}`);
  }
  const { scrollWidth } = document.documentElement;
  if (scrollWidth > innerWidth) found.push(`${scrollWidth} px wide`);
  return found;
}"""


def sentence(page):
    page.evaluate("draw()")
    return page.locator("#sentence").text_content()


@pytest.mark.parametrize("size", [*SMALL, (320, 568), (900, 560), (1280, 720)], ids=lambda size: f"{size[0]}x{size[1]}")
def test_each_control_is_on_top_and_large_enough(page, size):
    page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
    page.evaluate("document.querySelector('details').open = false")
    for values in (
        {"caption": True, "position": True, "image": True},
        {"windows": 2, "diagram": "paper"},
        {"scene": "spheres", "sheet": "axis"},
        {"question": 4},
    ):
        page.evaluate("fromHash('')")
        show(page, **values)
        assert page.evaluate(CONTROLS) == [], values
    box, height = page.locator("#stage").bounding_box(), size[1]
    assert box["height"] < 0.75 * height and page.locator("#stage-box").evaluate("(box) => box.clientHeight") < height


def test_a_choice_is_seen_in_high_contrast(page):
    """There the user's colours replace the page's, and a background that is not kept is the same for all choices."""
    page.emulate_media(forced_colors="active")
    page.evaluate("pinned = 'alpha'; mark('alpha'); draw()")
    pairs = {
        "#sheet input:checked + span": "#sheet input:not(:checked) + span",
        "[role=tab][aria-selected=true]": "[role=tab][aria-selected=false]",
        "#presets [aria-pressed=true]": "#presets [aria-pressed=false]",
        ".symbol[value=alpha]": ".symbol[value=z1]",
        "#orientation input:checked + span": "#orientation input:not(:checked) + span",
    }
    colours = (
        "(each) => [document.querySelector(each)].map(getComputedStyle).map((s) => [s.backgroundColor, s.color])[0]"
    )
    for chosen, other in pairs.items():
        (ground, ink), (plain, _) = (page.evaluate(colours, each) for each in (chosen, other))
        assert ground != plain and ground != ink, chosen
    thumb = page.evaluate("getComputedStyle($('slider-z1'), '::-webkit-slider-thumb').backgroundColor")
    canvas = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert page.evaluate("getComputedStyle($('slider-z1')).forcedColorAdjust") == "none" and thumb != canvas
    page.emulate_media(forced_colors="none")
    page.evaluate("pinned = ''; mark('')")


# ---- Numbers ----


def test_a_small_number_keeps_the_minus_of_its_exponent(page):
    texts = {5e-7: "5 × 10⁻⁷", -5e-7: "−5 × 10⁻⁷", 1.25e-10: "1.25 × 10⁻¹⁰", 3e21: "3 × 10²¹", -0.5: "−0.5"}
    assert page.evaluate("(numbers) => numbers.map(brief)", [*texts]) == [*texts.values()]
    assert page.evaluate("[size(1e-8), rough(-2e-9), fixed(-1e6, 2), fixed(-0.001, 1)]") == [
        "1.000 × 10⁻⁸", "−2 × 10⁻⁹", "−1.00 × 10⁶", "0.0",
    ]  # fmt: skip
    show(page, alpha=180, z1=6 * (1 + 1e-7))  # M = 10^7: 3 tiles / M are seen
    assert "3 × 10⁻⁷ tiles wide fills the window" in sentence(page)


def test_fields_take_fractions_and_units(page):
    read = {
        "30°": 30, "30 °": 30, "−12,5 degrees": -12.5, "1/2": 0.5, "-3 / 4": -0.75, "2 tiles": 2, "1e-3": 1e-3, "1,5/2": 0.75,
        "1/0": None, "1/": None, "/2": None, "1/2/3": None, "": None, " ": None, "tiles": None, "1.000,5": None, "3 knights": None,
    }  # fmt: skip
    found = page.evaluate("(texts) => texts.map(readNumber).map((x) => (Number.isFinite(x) ? x : null))", [*read])
    assert dict(zip(read, found, strict=True)) == read
    page.locator("#number-alpha").fill("30°")
    page.locator("#number-z1").fill("5/2")
    assert page.evaluate("[state.alpha, state.z1]") == [30, 2.5]


def test_the_coordinates_of_P_say_their_origin(page):
    row = page.locator("[data-quantity=P] dd")
    expect(row).to_contain_text("0.178 − 0.220 i")
    assert (
        row.inner_text().replace("\n", " ").endswith("where light from L to E crosses the sheets, if L = 0 and E = 1")
    )
    show(page, sheet="axis")
    assert row.inner_text().endswith("in tiles from the window’s middle")
    for E, text in (([0, -0.85], "–"), ([0, -0.8499], "0.178 − 0.220 i")):
        show(page, sheet="ideal", E=E)
        expect(page.locator("#value-P")).to_have_text(text)
    expect(page.locator("#value-nu")).to_have_text("15.0°")  # it does not depend on L and E
    assert not page.locator("dl, footer").get_by_text("*").count()  # of a conjugate


# ---- What is in the window ----

SCENES = [
    {}, {"E": [9, 1]}, {"E": [0, 10], "alpha": 180}, {"E": [0, 8], "alpha": 20}, {"L": [4, -0.85]}, {"L": [1.9, 0]}, {"L": [0.5, -0.8]},
    {"sheet": "none", "L": [4, 0]}, {"sheet": "none", "L": [-1, 1]}, {"sheet": "single", "L": [4, 0]}, {"sheet": "single", "z1": 20},
    {"sheet": "lenslets", "alpha": 180, "ratio": 2, "z1": 12}, {"sheet": "lenslets", "alpha": 180, "ratio": 2, "z1": 12, "E": [1.5, 0.5]},
    {"sheet": "mirror", "alpha": 90, "z1": 6}, {"sheet": "mirror", "alpha": 90, "z1": 6, "E": [-1.4, 1]}, {"sheet": "mirror", "L": [3, 1]},
    {"sheet": "axis", "alpha": 60}, {"sheet": "axis", "alpha": 180}, {"sheet": "refraction", "alpha": 180, "ratio": 0.7, "z1": 4.2},
    {"windows": 2, "alpha": 120, "alpha2": 120, "L": [3, -0.85]}, {"windows": 2, "alpha": 120, "alpha2": 120}, {"z1": 40},
    {"alpha": 180, "z1": 6}, {"alpha": 180, "z1": 6, "E": [1.5, 0.5]}, {"alpha": 180, "z1": 6, "E": [0, -1.2]},
]  # fmt: skip


def test_what_the_window_shows_is_what_the_live_view_draws(page):
    """The sentence says that nothing of the knight is seen exactly where no pixel of the window shows it."""
    half, pitch = 1.5, 3.7 / 60
    x, y = np.meshgrid((np.arange(80) - 39.5) * pitch, (np.arange(60) - 29.5) * pitch)
    window = (np.maximum(abs(x), abs(y)) < 0.97 * half).ravel()
    for values in SCENES:
        page.evaluate("fromHash('')")
        show(page, **values)
        found = set(page.evaluate("[...contents(moment())]"))
        drawn = page.evaluate("[...view.readout(80, 60).shown].filter((_, k) => k % 4 === 0)")
        seen = {round(each) for each in np.array(drawn)[window]}  # objects.glsl: SKY, FLOOR, WINDOW_FRAME, OBJECT
        assert ("thing" in found) == (3 in seen), values
        assert ("floor" in found, bool(found & {"sky", "mountains"}), "dark" in found) == (
            1 in seen,
            0 in seen,
            -1 in seen,
        ), values
        text = sentence(page)
        absent = any(said in text for said in ("Nothing of the knight", "The knight is not there", "No light passes"))
        assert absent == (3 not in seen), (values, text)
        assert "No path" not in text or "thing" in found
        if absent:
            assert not any(said in text for said in ("The knight appears", "The knight has", "seen as it is", "floats"))


def test_a_sphere_that_is_not_in_the_window_is_said(page):
    for values, seen in (({}, True), ({"z1": 0.2, "L": [3, 3]}, False), ({"z1": 24, "L": [3, 0]}, True)):
        page.evaluate("fromHash('')")
        show(page, scene="spheres", **values)
        scene = page.evaluate("moment()")
        place = rotation.apparent_position(complex(*scene["L"]), 0, scene["z1"], scene["z2"], scene["alpha"])
        assert seen == (max(abs(place.real), abs(place.imag)) < 1.5)
        text = sentence(page)
        assert ("Nothing of the sphere at z₁ = " in text) != seen and ("The sphere at z₁" in text) == seen
    assert "which shows other spheres, " in (show(page, z1=0.2, L=[3, 3]) or sentence(page))


def test_imaging_sheets_at_their_pole_say_what_is_seen(page):
    lens = {"sheet": "lenslets", "alpha": 180, "ratio": 2}
    for values, said, P, drawn in (
        (
            {**lens, "z1": 12},
            "The pole: one point of the knight fills",
            "∞",
            "one point of the knight fills the window",
        ),
        (
            {**lens, "z1": 11.5},
            "Near the pole: a part of the knight’s plane",
            "(0.00, −20.40)",
            "0.12 tiles of the knight",
        ),
        (
            {**lens, "z1": 12, "E": [1.5, 0.5]},
            "The knight is not there: the window shows the floor",
            "∞",
            "nothing of the",
        ),
        (
            {"sheet": "mirror", "alpha": 90, "z1": 6},
            "in a line at 45.0°, through the point straight",
            "∞",
            "one line of the",
        ),
    ):
        page.evaluate("fromHash('')")
        show(page, **values)
        assert said in sentence(page) and "No path" not in sentence(page)
        expect(page.locator("#value-P")).to_have_text(P)
        expect(page.locator("#overlay .say")).to_contain_text(drawn)
    show(page, z1=5)
    assert "The pole" not in sentence(page) and page.locator("#overlay .say").count() == 0


# ---- Questions ----


def revealed(page, n, answer=None):
    """Open a question, answer it, and go to its end."""
    page.emulate_media(reduced_motion="reduce")
    page.evaluate("(n) => { openQuestion(n); draw(); }", n)
    if answer is not None:
        choices = page.locator("#prediction input")
        choices.nth(answer).check() if isinstance(answer, int) else choices.fill(answer)
    page.evaluate("reveal(); draw()")


def test_an_answer_is_shown_from_its_premise(page):
    """Whatever a class has changed after the question was asked."""
    for n in range(page.evaluate("QUESTIONS.length")):
        page.emulate_media(reduced_motion="reduce")
        page.evaluate("(n) => openQuestion(n)", n)
        wanted = page.evaluate(
            "({ before, after }) => ({ ...before, ...(after.call ? after() : after) })",
            page.evaluate_handle(f"QUESTIONS[{n}]"),
        )
        show(page, scene="spheres", sheet="mirror", alpha=-17, z1=1.5, z2=3, E=[1, 1], L=[0.5, 0.3], piece="king")
        page.evaluate("reveal()")
        assert page.evaluate("(names) => pick(state, ...names)", [*wanted]) == pytest.approx(wanted)


def test_a_verdict_stays_and_try_again_asks_anew(page):
    for n, wrong, right in ((1, 1, 0), (4, "9 tiles", "6")):
        revealed(page, n, wrong)
        answer, inputs = page.locator("#answer"), page.locator("#prediction input")
        expect(answer).to_contain_text("No: ")
        assert all(inputs.nth(k).is_disabled() for k in range(inputs.count()))
        page.evaluate(
            "$('prediction').querySelectorAll('input').forEach((input) => { input.checked = false; input.value = '6'; })"
        )
        show(page, alpha=10)
        expect(answer).to_contain_text("No: ")
        page.get_by_role("button", name="Try again").click()
        expect(answer).to_be_empty()
        assert page.evaluate("[state.alpha, document.activeElement.id]") == [
            page.evaluate(f"QUESTIONS[{n}].before.alpha"),
            "ask",
        ]
        inputs.nth(right).check() if isinstance(right, int) else inputs.fill(right)
        page.get_by_role("button", name="Reveal").click()
        expect(answer).to_contain_text("Yes: ")
        expect(page.locator("#prediction input:checked, #prediction .field")).to_have_count(1)


def test_no_sentence_gives_an_answer_away_or_contradicts_it(page):
    for n in range(page.evaluate("QUESTIONS.length")):
        page.evaluate("(n) => openQuestion(n)", n)
        for values in ({}, page.evaluate(f"(({{ after }}) => (after.call ? after() : after))(QUESTIONS[{n}])")):
            show(page, **values)
            assert sentence(page) == "What is seen is said with the answer."
            expect(page.locator("#overlay .say")).to_have_count(0)
    show(page, z2=1000)  # what is not allowed is said
    assert sentence(page).endswith("z₂ is at most 150.")
    revealed(page, 2)
    assert sentence(page).startswith(
        "The mountains appear turned by 66.0° counter-clockwise. The knight appears turned by 15.0°"
    )
    revealed(page, 6)
    assert "floats 2 tiles in front" in sentence(page)
    revealed(page, 8)
    expect(page.locator("#answer")).to_contain_text("You see only wood")
    seen = page.evaluate("[...view.readout(80, 60).shown].filter((_, k) => k % 4 === 0)")
    assert set(np.array(seen).reshape(60, 80)[10:50, 20:60].ravel()) == {3}  # wood


# ---- Settings, history, movies ----


def test_settings_that_a_movie_replaces_come_back(page):
    undo = page.get_by_role("button", name="Undo")
    for press in ("vary α", "vary z₁", "spheres", "Reset"):
        page.evaluate("fromHash('')")
        expect(undo).to_be_hidden()
        show(page, sheet="none", z1=3.5, z2=4, E=[0.3, 0.1], piece="king", prisms=30)
        before = page.evaluate("({ ...state })")
        page.emulate_media(reduced_motion="reduce")
        page.get_by_role("button", name=press).click()
        text = sentence(page)
        assert "Your " in text and text.endswith(" are replaced.")
        assert all(name in text for name in ("z₂", "E", "N", "piece", "sheets")), text
        undo.click()
        assert page.evaluate("({ ...state })") == before
        expect(undo).to_be_hidden()
        assert "replaced" not in sentence(page)
    page.evaluate("fromHash('')")
    page.get_by_role("button", name="vary z₁").click()
    assert "replaced" not in sentence(page)  # nothing was the user's own


def test_each_window_keeps_its_own_settings(page):
    show(page, sheet="detailed", alpha=100, z2=3, z1=2.5)
    choose = page.get_by_label("Beyond the paper’s window")
    choose.select_option("series")
    assert "Your α, z₁ and z₂ are replaced." in sentence(page)
    show(page, d=3, alpha2=40)
    choose.select_option("none")
    assert page.evaluate("[state.windows, state.sheet, state.alpha, state.z2, state.z1]") == [
        1,
        "detailed",
        100,
        3,
        2.5,
    ]
    choose.select_option("series")
    assert page.evaluate("[state.windows, state.d, state.alpha2]") == [2, 3, 40]


def test_a_drag_of_a_slider_is_one_entry_of_the_history(page):
    page.evaluate("keepAddress()")
    entries = page.evaluate("history.length")
    box = page.locator("#slider-alpha").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    for part in (0.6, 0.7, 0.8):
        page.mouse.move(box["x"] + part * box["width"], box["y"] + box["height"] / 2)
        page.evaluate("keepAddress()")  # as after a rest
    page.mouse.up()
    page.evaluate("keepAddress()")
    assert page.evaluate("history.length") == entries + 1
    assert page.evaluate("state.alpha > 90 && location.hash === toHash()")


def test_a_movie_does_not_run_on_in_a_hidden_tab(page):
    page.evaluate("LiveView.RAYS = 0")
    jump = """(event) => {
      player.choose(data.presets[0]);
      player.since -= 3000;  // no frame for 3 s
      if (event) document.dispatchEvent(new Event(event));
      player.tick(performance.now());
      player.pause();
      return player.part();
    }"""
    assert page.evaluate(jump, "visibilitychange") < 0.2 < page.evaluate(jump, None)
    page.evaluate("LiveView.RAYS = 1")


def test_the_ring_round_a_handle_is_seen_on_the_picture(page):
    show(page, position=True)
    ring = "(id) => { const { borderColor, boxShadow } = getComputedStyle($(id)); return [borderColor, boxShadow !== 'none']; }"
    for handle, shadow in (("eye-picture", True), ("eye-diagram", False)):
        page.locator(f"#{handle}").hover()
        colour, shaded = page.evaluate(ring, handle)
        assert (colour == "rgba(255, 255, 255, 0.9)") == shadow == shaded, handle
    show(page, position=False)
    page.locator("#eye-picture").hover()
    assert page.evaluate(ring, "eye-picture") == ["rgba(0, 0, 0, 0)", False]


def test_buttons_say_what_they_do(page):
    names = ["alpha", "z1", "z2", "N", "L", "E"]
    for name in names:
        button = page.get_by_role("button", name=f"Mark {name} in the picture", exact=True)
        button.click()
        expect(button).to_have_attribute("aria-pressed", "true")
        button.click()
    for name in ("r", "P", "nu", "M"):
        expect(page.get_by_role("button", name=f"Mark {name} in the picture: ")).to_have_count(1)
    unnamed = """[...document.querySelectorAll("button")].filter((button) => !button.textContent.trim() && !button.ariaLabel)"""
    assert page.evaluate(f"{unnamed}.length") == 0
