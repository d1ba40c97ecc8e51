"""The languages of the teaching page."""

import pytest
from playwright.sync_api import expect

from demo.conftest import centre, opened, show
from povgen.liveview.languages import tables
from povgen.page.page import ALL_KINDS

# A language in which each word of three or more letters is "жжж".
STRANGE = """() => {
  const strange = (part, name) => typeof part === "string"
    ? (["locale", "dir", "typed"].includes(name) ? part
      : part.replace(/(\\{[^}]*\\}|<[^>]*>)|\\p{L}{3,}/gu, (all, kept) => kept ?? "жжж"))
    : Array.isArray(part) ? part.map(strange)
    : Object.fromEntries(Object.entries(part).map(([name, each]) => [name, strange(each, name)]));
  data.languages.strange = { ...strange(data.languages.en), locale: "ru" };
  choose("strange");
  fillPage();
  $("spoken").textContent = "";
}"""
# The words of the page that are not from the table. Names of quantities are the same in all languages.
WORDS = """() => {
  const texts = [document.title];
  for (const part of document.querySelectorAll("body, body *")) {
    if (part.matches("script, style, noscript, noscript *, #language option") || part.closest("[hidden]")) continue;
    const said = ["aria-label", "title", "aria-valuetext", "alt", "placeholder"];
    texts.push(...said.map((name) => part.getAttribute(name) ?? ""));
    texts.push(...[...part.childNodes].filter((node) => node.nodeType === 3).map((node) => node.textContent));
  }
  const names = "alpha arg sin cos arctan".split(" ");
  names.push(...Object.keys(data.parameters).flatMap((name) => name.split("_")));
  return [...new Set(texts.join(" ").match(/[A-Za-z]{3,}/g) ?? [])].filter((word) => !names.includes(word));
}"""
STATES = [
    {},
    {"position": True, "circles": True, "image": True, "caption": True, "sheet": "detailed"},
    {"alpha": 180, "z1": 6},
    {"alpha": 180, "z1": 5.8},
    {"alpha": 180},
    {"alpha": 180, "z1": 6, "E": [1.5, 0.5]},
    {"E": [0, -1.4]},
    {"scene": "spheres", "caption": True, "position": True},
    {"scene": "spheres", "sheet": "single", "alpha": 180, "z1": 6},
    {"sheet": "single"},
    {"sheet": "single", "z1": 6},
    {"sheet": "single", "z1": 9},
    {"sheet": "none"},
    {"sheet": "detailed", "prisms": 4, "caption": True},
    {"windows": 2, "alpha": 120, "alpha2": 120, "d": 2, "caption": True, "diagram": "paper"},
    {"windows": 2, "sheet": "none", "sheet2": "lens"},
    {"windows": 2, "alpha": 0, "alpha2": 0, "d": 2, "L": [2.2, -0.85]},
    {"sheet": "axis", "alpha": 180},
    {"alpha": 400, "z1": 0.001, "z2": 0.001, "L": [0, -20], "prisms": 2.5, "axis": [0, 0, 0]},
    {"L": [5, 0]},
]


def test_all_words_are_from_the_table(page):
    page.evaluate(STRANGE)
    try:
        for values in [*STATES, *({"sheet": kind, "caption": True} for kind in ALL_KINDS)]:
            page.evaluate("fromHash('')")
            show(page, **values)
            page.evaluate("$('view').setAttribute('aria-label', describe(moment()))")
            assert not page.evaluate(WORDS), values
        for n in range(page.evaluate("QUESTIONS.length")):
            page.evaluate("(n) => { openQuestion(n); draw(); }", n)
            assert not page.evaluate(WORDS), n
            page.evaluate("reveal(); endGlide(); draw()")
            assert not page.evaluate(WORDS), n
    finally:
        page.evaluate("choose('en'); revealed.clear(); fillPage()")


@pytest.mark.parametrize(("locale", "language"), [("de-AT", "de"), ("ar-EG", "ar"), ("nl-NL", "en")])
def test_the_browser_chooses_the_language(browser, demo_file, locale, language):
    page, faults = opened(browser, demo_file, locale=locale)
    table = tables(ALL_KINDS)[language]
    assert page.evaluate("[document.documentElement.lang, document.documentElement.dir]") == [language, table["dir"]]
    expect(page.locator("#reset")).to_have_text(table["page"]["reset"])
    page.evaluate("draw(); keepAddress()")
    assert "language" not in page.evaluate("location.hash")  # who gets the link has a browser with its own language
    assert not faults
    page.close()


def test_the_language_is_changed_and_kept_in_the_address(page):
    try:
        page.get_by_label("Language").select_option("de")
        expect(page.locator("#reset")).to_have_text("Zurücksetzen")
        expect(page.locator("#sentence")).to_have_text(
            "Der Springer erscheint um 15,0° gegen den Uhrzeigersinn gedreht und 1,13-mal so groß wie ohne die Platten."
        )
        expect(page.locator("#piece option").first).to_have_text("Bauer")
        page.locator("#number-z1").fill("2,5")
        assert page.evaluate("state.z1") == 2.5 and "language=de" in page.evaluate("toHash()")
        page.evaluate("openQuestion(1); draw()")
        expect(page.locator("#ask")).to_contain_text("In welchem Sinn dreht sich der Springer?")
        page.evaluate("fromHash('#language=fr'); draw()")
        expect(page.locator("#reset")).to_have_text("Réinitialiser")
        page.evaluate("fromHash('#piece=queen'); draw()")
        expect(page.locator("#sentence")).to_contain_text("La dame paraît tournée de 15,0°")
        page.locator("#number-alpha").fill("181")
        expect(page.locator("#sentence")).to_contain_text("180°")
        said = ["own-message", "copied", "room-message"]
        page.evaluate("(said) => said.forEach((id) => ($(id).textContent = 'Copié.'))", said)
        page.locator("#language").select_option("en")
        page.evaluate("draw()")
        expect(page.locator("#sentence")).not_to_contain_text("180°.")
        assert page.evaluate("(said) => said.map((id) => $(id).textContent)", said) == [""] * 3
    finally:
        page.evaluate("choose('en'); draw()")


def test_a_prediction_is_kept_in_another_language(page):
    try:
        page.evaluate("openQuestion(1); draw()")
        page.locator("#prediction input").nth(1).check()
        page.evaluate("choose('de'); draw()")
        expect(page.locator("#prediction input").nth(1)).to_be_checked()
        page.evaluate("openQuestion(5); draw()")
        expect(page.locator("#prediction input")).to_have_value("")
        page.locator("#prediction input").fill("2,5")
        page.evaluate("choose('fr'); draw()")
        expect(page.locator("#prediction input")).to_have_value("2,5")
        page.locator("#prediction input").fill("2,6")  # it can be changed
        page.evaluate("draw()")
        expect(page.locator("#prediction input")).to_have_value("2,6")
        page.evaluate("fromHash('#question=half&language=es'); draw()")  # another question
        expect(page.locator("#prediction input")).to_have_value("")
    finally:
        page.evaluate("choose('en'); draw()")


def test_from_right_to_left_the_picture_and_numbers_stay(page):
    boxes = """() => ["#stage", "#slider-alpha", "#number-alpha", "#row-alpha .symbol"].map((part) =>
      document.querySelector(part).getBoundingClientRect().x)"""
    show(page, L=[-0.3, -0.85], position=True)
    place = centre(page, "#predicted")
    stage, slider, field, symbol = page.evaluate(boxes)
    assert stage < symbol < slider < field
    try:
        page.get_by_label("Language").select_option("ar")
        page.wait_for_function("document.documentElement.dir === 'rtl'")
        page.evaluate("draw()")
        stage, slider, field, symbol = page.evaluate(boxes)
        assert field < slider < symbol < stage
        assert centre(page, "#predicted") == pytest.approx(place, abs=0.01)
        assert page.evaluate("getComputedStyle($('number-Lx')).direction") == "ltr"
        place = "\u22120.30, \u22120.85"
        assert f"\u200e{place}\u200e" in page.evaluate("(place) => say('pole.at', { place })", place)
        assert "\u200e0.3\u200e" in page.evaluate("describe(moment())")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    finally:
        page.evaluate("choose('en'); draw()")
