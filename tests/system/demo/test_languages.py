"""The languages of the teaching page."""

import pytest
from conftest import some
from playwright.sync_api import expect

from demo.conftest import centre, opened, show
from povgen.liveview.languages import tables
from povgen.page.address import ALL_KINDS

# The names and other hidden texts of what is shown, with a Latin word.
HIDDEN = """[...document.querySelectorAll("*")].filter((part) => (part.closest("select") ?? part).checkVisibility())
  .flatMap((part) => [part.ariaLabel, part.title, part.getAttribute("aria-valuetext"),
    part.matches(".hidden-text:not([role=status]), option, output") && part.textContent])
  .filter((text) => text && /[A-Za-z]{3}/.test(text))"""


@pytest.mark.parametrize(
    ("locale", "language"), some([("de-AT", "de"), ("ar-EG", "ar"), ("nl-NL", "en")], 1, several=True)
)
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
    page.locator("#number-z1").fill("0,1")
    expect(page.locator("#sentence")).to_contain_text("0,581")


def test_from_right_to_left_the_picture_and_numbers_stay(page):
    boxes = """() => ["#stage", "#slider-alpha", "#number-alpha", "#row-alpha .symbol"].map((part) =>
      document.querySelector(part).getBoundingClientRect().x)"""
    show(page, L=[-0.3, -0.85], position=True)
    place = centre(page, "#predicted")
    stage, slider, field, symbol = page.evaluate(boxes)
    assert stage < symbol < slider < field
    page.get_by_label("Language").select_option("ar")
    page.wait_for_function("document.documentElement.dir === 'rtl'")
    page.evaluate("draw()")
    stage, slider, field, symbol = page.evaluate(boxes)
    assert field < slider < symbol < stage
    assert centre(page, "#predicted") == pytest.approx(place, abs=0.01)
    assert page.evaluate("getComputedStyle($('number-Lx')).direction") == "ltr"
    place = "\u22120.30, \u22120.85"
    assert f"\u2068{place}\u2069" in page.evaluate("(place) => say('pole.at', { place })", place)
    said = page.evaluate("describe(moment())")
    assert "\u20680.3\u2069" in said and "\u2068α = 66.0°\u2069" in said
    page.locator("#number-alpha").fill("−٤٥٫٥ درجة")
    assert page.evaluate("state.alpha") == -45.5
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.evaluate("change({ sheet: 'glens' }); draw()")
    assert {*page.evaluate(HIDDEN)} <= {"صورة POV-Ray", *(table["name"] for table in tables(ALL_KINDS).values())}
