"""The file of the teaching page, and its address."""

import re

from conftest import PROJECT
from playwright.sync_api import expect


def test_the_page_is_one_small_file(demo_file):
    assert demo_file.stat().st_size < 1_300_000
    text = demo_file.read_text("utf-8").partition("<!-- povgen record")[0]
    assert "http" not in text.replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")
    assert text.count('src="data:image/webp') == 1
    assert not re.search(r'(src|href)="(?!data:|\$\{)', text)
    assert all(path.read_text() in text for path in (PROJECT / "povgen" / "page").glob("*.css"))


def test_back_and_forward(page):
    page.evaluate("keepAddress()")
    for sheet, alpha in (("detailed", 10), ("ideal", 20), ("detailed", 30)):
        page.evaluate("(sheet) => { change({ sheet }); keepAddress(); }", sheet)
        page.locator("#number-alpha").fill(str(alpha))
        page.wait_for_function("(alpha) => location.hash.includes(`alpha=${alpha}&`)", arg=alpha)
    for go, alpha in ((page.go_back, 20), (page.go_back, 10), (page.go_forward, 20)):
        go()
        page.wait_for_function("(alpha) => state.alpha === alpha", arg=alpha)
        page.evaluate("draw()")
        expect(page.locator("#number-alpha")).to_have_value(str(alpha))
    page.locator("#tab-measure").click()
    page.wait_for_function("location.hash.includes('&panel=measure')")
    for go, seen in ((page.go_back, False), (page.go_forward, True)):
        go()
        page.wait_for_function("(measuring) => session.measuring === measuring", arg=seen)
        expect(page.locator("#measure")).to_be_visible(visible=seen)
