"""What a class does with the page: in high contrast, with questions, with settings of its own, and with movies."""

import re

import numpy as np
from conftest import sentence
from playwright.sync_api import expect

from demo.conftest import show
from povgen.page.address import KINDS


def test_a_choice_is_seen_in_high_contrast(page):
    """There the user's colours replace the page's: a background that is not kept is the same for all choices."""
    page.emulate_media(forced_colors="active")
    page.evaluate("session.pinned = 'alpha'; mark('alpha'); draw()")
    colours = """(each) => [document.querySelector(each)].map(getComputedStyle)
        .map(({ backgroundColor, color }) => [backgroundColor, color])[0]"""
    for chosen, other in {
        "#sheet input:checked + span": "#sheet input:not(:checked) + span",
        "#orientation input:checked + span": "#orientation input:not(:checked) + span",
        "[role=tab][aria-selected=true]": "[role=tab][aria-selected=false]",
        "#presets [aria-pressed=true]": "#presets [aria-pressed=false]",
        ".symbol[value=alpha]": ".symbol[value=z1]",
    }.items():
        (ground, ink), (plain, _) = (page.evaluate(colours, each) for each in (chosen, other))
        assert ground != plain and ground != ink, chosen
    # a slider's track has a colour of the user's, and the drawings keep their own paper
    assert page.evaluate("getComputedStyle($('slider-z1')).forcedColorAdjust") == "none"
    assert page.evaluate("getComputedStyle($('space-turn')).backgroundColor") == "rgb(255, 254, 251)"


def test_the_coordinates_of_P_say_their_origin(page):
    row, P = page.locator("[data-quantity=P] dd"), page.locator("#value-P")
    for values, text, origin in (
        ({}, "0.178 − 0.220 i", "if L = 0 and E = 1"),
        ({"E": [0, -0.85]}, "–", "if L = 0 and E = 1"),  # L is there
        ({"sheet": "axis"}, "–", "in tiles from the window’s middle"),
    ):
        show(page, **values)
        assert P.text_content() == text or values.get("sheet")
        assert row.inner_text().endswith(origin)


# ---- What is in the window ----

LENSLETS = {"sheet": "lenslets", "alpha": 180, "ratio": 2, "z1": 12}
SERIES = {"windows": 2, "alpha": 120, "alpha2": 120}
SCENES = [
    *({}, {"E": [9, 1]}, {"E": [0, 10], "alpha": 180}, {"L": [4, -0.85]}, {"L": [1.9, 0]}, {"z1": 60}),
    *({"sheet": "none", "L": [4, 0]}, {"sheet": "single", "L": [4, 0]}, {"sheet": "single", "z1": 20}),
    *(LENSLETS | {"E": [1.5, 0.5]}, {"sheet": "mirror", "alpha": 90, "z1": 6, "E": [-1.4, 1]}),
    *({"sheet": "axis", "alpha": 180}, *({"sheet": sheet} for sheet in KINDS)),
    *(SERIES, SERIES | {"L": [3, -0.85]}),
    *({"alpha": 180, "z1": 6} | {"E": E} for E in ([0, 0], [1.5, 0.5], [0, -1.2])),
]


def drawn(page, width=64, height=48):
    """Return what the live view shows in the window: SKY 0, FLOOR 1, -1, or from 2 the number of the object.

    After 2, the piece, there is its pedestal. Window frames are left out.
    """
    shown, windows = page.evaluate(
        """([width, height]) => {
          Object.assign(view.scene, moment().scene);
          return [[...readout(view, width, height).shown].filter((_, k) => k % 4 === 0), moment().windows.length];
        }""",
        [width, height],
    )
    shown = np.array(shown)
    shown = np.where((shown >= 2) & (shown < 2 + windows), np.nan, np.where(shown > 2, shown - windows, shown))
    x, y = np.meshgrid(*((np.arange(n) - (n - 1) / 2) * 3.7 / height for n in (width, height)))
    return set(shown[(np.maximum(abs(x), abs(y)) < 0.97 * 1.5).ravel()])


def test_what_the_window_shows_is_what_the_live_view_draws(page):
    """The sentence says that nothing of the knight is in the window exactly where no pixel of the window shows it."""
    for values in SCENES:
        page.evaluate("fromHash('')")
        text, seen = sentence(page, **values), drawn(page)
        absent = any(words in text for words in ("Nothing of the knight", "The knight is not there", "No light passes"))
        found = set(page.evaluate("[...contents(moment())]"))
        assert absent == (2 not in seen) == ("thing" not in found), (values, text)
        if absent:
            assert not any(
                words in text for words in ("knight appears", "knight has", "seen as it is", "floats", "No path")
            )
            wanted = 1 in seen, 0 in seen, -1 in seen
            assert wanted == ("floor" in found, bool(found & {"sky", "mountains"}), "dark" in found), values
            assert ("the floor" in text, "sky" in text or "mountains" in text, "black" in text) == wanted, text


# ---- Questions ----


def ends(page):
    """Return what the page shows at the end of each question."""
    return page.evaluate("QUESTIONS.map(end)")


def test_a_verdict_stays_and_try_again_asks_anew(page):
    page.emulate_media(reduced_motion="reduce")
    inputs, answer = page.locator("#prediction input"), page.locator("#answer")

    def predict(choice):
        inputs.nth(choice).check() if isinstance(choice, int) else inputs.fill(choice)
        page.locator("#reveal").click()

    for n, wrong, right, reason in (
        (1, 2, 0, "if the sheets turned the light clockwise. It turns by 15.0° only"),
        (5, "9 tiles", "12/2", "Too far: farther from the sheets than your eye"),
        (6, "2.11", "2.1", "It is smaller"),  # 2, within 0.1
    ):
        page.evaluate("(n) => { openQuestion(n); draw(); }", n)
        if n == 5:
            predict("six")
            expect(answer).to_have_text("Type a number first.")
            predict("45 cm")
            expect(answer).to_have_text("“45 cm”: only “tiles” can follow the number.")
        predict(wrong)
        assert page.evaluate("document.activeElement.id") == "next"  # the button that had the focus is gone
        expect(answer).to_contain_text("No: ")
        expect(answer).to_contain_text(reason)
        assert all(each.is_disabled() for each in inputs.all())
        show(page, alpha=10)
        expect(answer).to_contain_text("No: ")
        page.get_by_role("button", name="Try again").click()
        expect(answer).to_be_empty()
        assert page.evaluate("state.alpha === QUESTIONS[state.question].before.alpha")
        predict(right)
        expect(answer).to_contain_text("Yes: ")
    page.evaluate("openQuestion(1); draw()")  # with its answer
    expect(answer).to_contain_text("Yes: ")
    assert inputs.first.is_checked() and page.evaluate("state.alpha === end(QUESTIONS[1]).alpha")
    outline = page.get_by_role("button", name="Predict by drawing")
    expect(outline).to_be_visible()
    page.evaluate("openQuestion(8); draw()")
    expect(outline).to_be_hidden()  # one point fills the window
    page.evaluate("openQuestion(3); draw()")
    expect(outline).to_be_hidden()  # the mountains have none
    spoken = page.evaluate("reveal(); endGlide(); heard(moment())")
    assert len([text for text in spoken if "mountains" in text]) == 1
    page.evaluate("for (const n of [0, 14, 20]) { openQuestion(n); reveal(); }")  # without a prediction
    page.evaluate("openQuestion(4); draw()")
    predict(0)
    expect(page.get_by_role("status").filter(has_text="1 of 4 right at the first try")).to_be_visible()
    # as the lesson does, after the light was shown in place of the picture
    page.evaluate("session.explored = { ...OPENING, large: true }; fromHash('#question=parallax'); draw()")
    predict(0)
    page.get_by_role("button", name="Try again").click()
    assert page.evaluate("[state.large, isAsked()]") == [False, True]


def test_no_sentence_gives_an_answer_away_or_contradicts_it(page):
    page.emulate_media(reduced_motion="reduce")
    for n, end in enumerate(ends(page)):
        page.evaluate("(n) => openQuestion(n)", n)
        for values in ({}, end):
            said = "The knight appears" if n >= 20 else "Predict first: the description comes with the answer."
            assert sentence(page, **values).startswith(said)
    page.evaluate("openQuestion(19)")
    assert sentence(page, z2=1000).endswith("answer. z₂ is at most 150.")
    assert sentence(page, windows=1, sheet="ideal", z1=0.1).endswith("the piece would touch the frame.")

    page.evaluate("openQuestion(2); reveal()")
    assert "floats 2 tiles in front" in sentence(page)


# ---- Settings, history, movies ----


def test_settings_that_a_movie_replaces_come_back(page):
    page.emulate_media(reduced_motion="reduce")
    undo = page.get_by_role("button", name="Undo")
    own = {"sheet": "none", "z1": 3.5, "z2": 4, "E": [0.3, 0.1], "piece": "king", "prisms": 30, "circles": True}
    for press in ("vary α", "vary z₁", "Reset"):
        page.evaluate("fromHash('#view=side')")
        show(page, **own)
        expect(undo).to_be_hidden()
        before = page.evaluate("({ ...state })")
        page.get_by_role("button", name=press).click()
        if press == "Reset":
            assert page.evaluate("[state.sheet, state.z1, state.circles]") == ["ideal", 2, False]
            assert page.evaluate("session.camera") == page.evaluate("povgen.state.CAMERAS.corner")
        undo.click()
        assert page.evaluate("({ ...state })") == before
        expect(undo).to_be_hidden()


def test_each_window_keeps_its_own_settings(page):
    choose = page.get_by_label("Kind of window")
    sentence(page, sheet="detailed", alpha=100, z2=3, z1=2.5)
    choose.select_option("series")
    expect(page.locator("#undo")).to_be_visible()
    sentence(page, d=3, alpha2=40)
    choose.select_option("none")
    wanted = {"windows": 1, "sheet": "detailed", "alpha": 100, "z2": 3, "z1": 2.5}
    assert page.evaluate("(names) => pick(state, ...names)", [*wanted]) == wanted
    choose.select_option("series")
    assert page.evaluate("[state.windows, state.d, state.alpha2]") == [2, 3, 40]


def test_a_drag_of_a_slider_adds_no_entry_to_the_history(page):
    """Also where a frame forbids to replace the entry. Another sheet does add one."""
    show(page, sheet="detailed")
    page.evaluate("keepAddress()")  # now the last entry is the present one
    entries = page.evaluate("history.length")
    box = page.locator("#slider-alpha").bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 2, y)
    page.mouse.down()
    for part in (0.6, 0.7, 0.8):
        page.mouse.move(box["x"] + part * box["width"], y)
        page.evaluate("keepAddress()")  # as after a rest
    page.mouse.up()
    page.evaluate("keepAddress()")
    assert page.evaluate("state.alpha > 90 && location.hash === toHash()")
    page.evaluate("void (history.replaceState = () => { throw new DOMException('', 'SecurityError'); })")
    show(page, alpha=12.5)
    page.evaluate("keepAddress(); delete history.replaceState")
    page.wait_for_function("location.hash.includes('alpha=12.5&')")
    assert page.evaluate("history.length") == entries
    show(page, sheet="none")
    page.evaluate("keepAddress()")
    assert page.evaluate("history.length") == entries + 1


def test_a_movie_does_not_run_on_in_a_hidden_tab(page):
    part = """(event) => {
      player.choose(data.presets[0]);
      player.since -= 3000;  // no frame for 3 s
      if (event) document.dispatchEvent(new Event(event));
      player.tick(performance.now());
      player.pause();
      return player.part();
    }"""
    assert page.evaluate(part, "visibilitychange") < 0.2 < page.evaluate(part, None)


def test_the_button_says_whether_it_checks_an_answer(page):
    page.evaluate("openQuestion(0); draw()")
    button = page.locator("#reveal")
    expect(button).to_have_text("Reveal the answer")
    page.locator("#prediction input").first.check()
    expect(button).to_have_text("Check my answer")
    page.evaluate("choose('de'); draw()")
    expect(button).to_have_text("Meine Antwort prüfen")
    page.evaluate("choose('en'); openQuestion(5); draw()")  # it asks for a number
    button.click()
    expect(page.locator("#answer")).to_have_text(re.compile("^6 tiles"))


def test_present_says_alpha_where_no_slider_does(page):
    show(page, alpha=70, sheet="ideal")
    page.evaluate("present(true); player.preset = data.presets.find(({ name }) => name === 'vary-z1'); draw()")
    expect(page.locator("#alpha-now")).to_have_text("α = 70.0°")
    expect(page.locator("#alpha-now")).to_be_visible()
    page.evaluate("player.preset = data.presets[0]; draw()")
    expect(page.locator("#alpha-now")).to_be_hidden()
    # "near" asks about another one
    for question, visible in {"parallax": True, "near": False, "quarter": True}.items():
        page.evaluate("(question) => { fromHash(`#question=${question}`); draw(); }", question)
        expect(page.locator("#alpha-now")).to_be_visible(visible=visible)
