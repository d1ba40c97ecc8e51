"""The equations of the teaching page: its numbers are povgen's, and what they mean is said."""

import re

import pytest
from conftest import BEYOND, scene_of
from playwright.sync_api import expect

from demo.conftest import show
from povgen.page.address import ALL_KINDS, KEPT

NOT_A_NUMBER = r"NaN|Infinity|null|undefined(?!<|; r = )|\[object"


def test_light_beside_the_second_window_is_said(page):
    """There the prediction does not hold: povgen's own scene says that the light does not pass."""
    for x, passes in ((0.3, True), (2.2, False)):
        show(page, windows=2, alpha=0, alpha2=0, d=2, image=True, position=True, L=[x, -0.85])
        scene = scene_of(page)
        assert scene.visible(scene.L, 2) == passes and abs(page.evaluate("moment().place[0]")) < 1.5
        said = "passes beside the second window" in page.locator("#sentence").text_content()
        assert said == page.locator("#image.hidden").count() == page.locator(".mark.unsure:not(.halo)").count()


def test_the_equations_of_two_windows_of_prisms_are_given_too(page):
    show(page, windows=2, sheet="detailed", prisms=40, alpha=120, alpha2=120, d=2, z2=8)
    expect(page.locator("#value-nu")).to_have_text("−1.6°")
    expect(page.locator("#about-nu")).to_have_text("for 40 prisms; ideal sheet: 0.0°")
    expect(page.locator("#about-M")).to_have_text("for 40 prisms; ideal sheet: 1.333")
    expect(page.locator("#of-prisms")).to_have_text(
        "Z, the image and the diagram are for ideal sheets.", use_inner_text=True
    )


def test_an_axis_is_typed(page):
    """The field holds 0 on the way to 0.5. Then the axis is not lost."""
    show(page, sheet="axis", alpha=20, axis=[0, 0, 1])
    page.locator("#number-axisz").press_sequentially("0.5")
    page.locator("#number-axisz").fill("")
    page.locator("#number-axisz").press_sequentially("0.5")
    assert page.evaluate("state.axis") == [0, 0, 0.5]
    show(page, axis=[0, 0, 0])
    assert page.evaluate("state.axis") == [0, 0, 0.5]
    expect(page.locator("#sentence")).to_contain_text("a = (0, 0, 0) has no direction: it stays as it was.")


def test_what_is_beyond_the_paper_is_chosen(page):
    """Each choice shows its own controls, and what the sheet does. No number is missing."""
    choose = page.get_by_label("Kind of window")
    names = {each.name for kind in ALL_KINDS.values() for each in kind.parameters} - KEPT
    visible = "(names) => names.filter((name) => document.querySelector(`[data-quantity=${name}]`).checkVisibility())"
    assert choose.locator("option").count() == 3 + len(
        ALL_KINDS
    )  # and one window, two behind one another, two side by side
    for name, kind in ALL_KINDS.items():
        texts = page.evaluate("(name) => entry(`kinds.${name}`)", name)
        choose.select_option(label=texts["choice"])
        expect(page.locator("#sentence")).to_contain_text(texts["sentence"].partition("{")[0])
        assert {*page.evaluate(visible, [*names])} == {each.name for each in kind.parameters} - KEPT
        assert page.evaluate("state.sheet") == name
        expect(page.locator("#row-prisms")).to_be_hidden()
    choose.select_option("series")
    expect(page.locator("#slider-d")).to_be_visible()
    expect(page.locator("#sentence")).to_contain_text("2 tiles in front of the first window")
    choose.select_option("series")
    page.locator("#number-alpha2").fill("20")
    page.locator("#number-d").fill("0.1")
    expect(page.locator("#sentence")).to_contain_text("has no image. d is at least 0.311: the windows would touch.")
    expect(choose).to_have_value("series")
    page.get_by_role("radio", name="two sheets").check(force=True)
    expect(page.locator("#row-prisms")).to_be_visible()
    page.get_by_role("radio", name="complex depth").check(force=True)
    expect(page.locator("#diagram")).to_have_attribute("aria-label", re.compile("^The complex depth Z = "))
    page.get_by_role("radio", name="one sheet").check(force=True)
    expect(choose).to_have_value("none")
    expect(page.locator("#slider-d")).to_be_hidden()
    for values in BEYOND:
        show(page, **values)
        assert not re.search(NOT_A_NUMBER, page.evaluate("document.querySelector('main').outerHTML")), values


def test_the_complex_depth_is_drawn_to_scale(page):
    show(page, windows=2, alpha=90, alpha2=0, d=2, z1=3, z2=4, diagram="paper")
    z2, d, z1 = page.evaluate(
        """["z2", "d", "z1"].map((name) => document.querySelector(`#diagram line.q-${name}`))
           .map((line) => ["x1", "y1", "x2", "y2"].map((name) => Number(line.getAttribute(name))))"""
    )
    assert d[:2] == pytest.approx([z2[0] + (z1[1] - d[1]) * 2, z2[1]], abs=0.1)  # z2 = 2 d, along the real axis
    assert d[2] == pytest.approx(d[0], abs=0.1) and z1[0] == pytest.approx(d[0], abs=0.1)  # both downwards
