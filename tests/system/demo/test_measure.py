"""Measuring on the page's picture: the protractor, the ruler, the table and its curves."""

import re

import pytest
from conftest import NAMES
from playwright.sync_api import expect

from demo.conftest import centre, opened, show


@pytest.fixture
def measure(page):
    page.locator("#tab-measure").click()
    page.evaluate("draw()")
    return page


def put(page, name, target):
    """Move a point of the protractor to a place of the window, tiles."""
    stage, box = (page.locator(part).bounding_box() for part in ("#stage", f"#point-{name}"))
    tile = stage["height"] / 3.7
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    x, y = stage["x"] + stage["width"] / 2 + tile * target[0], stage["y"] + stage["height"] / 2 - tile * target[1]
    page.mouse.move(x, y)
    page.mouse.up()
    page.evaluate("draw()")


def write_down(page, put=False):
    if put:
        page.evaluate("$('put-on').click(); draw()")
    page.get_by_role("button", name="Write down").click()
    page.evaluate("draw()")


def test_the_protractor_measures_angle_and_length(measure):
    before = measure.evaluate("({ ...state })")
    for name, place in (("A", (0, 0)), ("B", (0, 1)), ("C", (-1, 1))):
        put(measure, name, place)
    said = measure.locator("#readings")
    expect(said).to_contain_text("Angle 45.0°")  # to the left is counter-clockwise
    expect(said).to_contain_text("AC = 1.41 tiles")
    measure.locator("#point-C").press("Shift+ArrowRight")
    measure.evaluate("draw()")
    expect(said).to_contain_text("Angle 42.0°")
    assert measure.evaluate("({ ...state })") == before  # neither eye nor object has moved
    measure.evaluate("$('reset').click(); draw()")
    foot = complex(*measure.evaluate("moment().place"))
    assert centre(measure, "#point-A") == pytest.approx(foot, abs=0.01)  # as at first
    measure.evaluate(
        """() => {  // the browser takes the drag back, and scrolls instead
          for (const [type, clientX] of [["pointerdown", 0], ["pointermove", 50], ["pointercancel", 50]])
            $("point-A").dispatchEvent(new PointerEvent(type, { pointerId: 1, isPrimary: true, clientX }));
          draw();
        }"""
    )
    assert centre(measure, "#point-A") == pytest.approx(foot, abs=0.01)
    expect(said).to_be_empty()


def test_what_is_measured_lies_on_the_curve(measure):
    """A class that puts the points on the foot and the top of the piece measures nu and M to the line's width."""
    for alpha in (30, 90):
        show(measure, alpha=alpha, z1=4)
        tall = measure.evaluate("Math.max(...outlineOf('knight').flat().map(([, y]) => y))")
        foot, top = measure.evaluate(
            "(tall) => [[0, 0], [0, tall]].map((d) => apparentPosition(moment(), plus(state.L, d)))", tall
        )
        put(measure, "A", foot)
        put(measure, "B", (foot[0], foot[1] + 0.5))
        put(measure, "C", top)
        write_down(measure)
    found = measure.evaluate("rows.map(({ nu, M }) => [Number(nu), Number(M)])")
    for n, alpha in enumerate((30, 90)):
        show(measure, alpha=alpha)
        nu, M = measure.evaluate("[moment().nu * 180 / Math.PI, moment().M]")
        assert found[n] == [pytest.approx(nu, abs=1.5), pytest.approx(M, rel=0.05)]
    expect(measure.locator("#plot-nu .mark")).to_have_count(2)
    distance = """(n) => {
      const curve = $("plot-nu").querySelector(".curve"), mark = $("plot-nu").querySelectorAll(".mark")[n];
      const [x, y] = ["cx", "cy"].map((name) => Number(mark.getAttribute(name)));
      let least = 1e9;
      for (let k = 0; k <= 800; k++) {
        const point = curve.getPointAtLength((k / 800) * curve.getTotalLength());
        least = Math.min(least, Math.hypot(point.x - x, point.y - y));
      }
      return least;
    }"""
    assert max(measure.evaluate(distance, n) for n in range(2)) < 4


def test_who_does_not_see_the_picture_measures_too(measure):
    show(measure, alpha=90, z1=2, caption=True)
    expect(measure.locator("#sentence")).to_be_empty()  # it would say the result
    expect(measure.locator("#overlay .caption")).not_to_contain_text("ν")
    expect(measure.locator("#plot-nu .curve")).to_have_attribute("d", "")
    measure.get_by_role("button", name="Put A, B and C on the piece").press("Enter")
    measure.evaluate("draw()")
    write = measure.get_by_role("button", name="Write down")
    before = write.bounding_box()
    measure.evaluate("document.activeElement.blur()")
    assert write.bounding_box() == before  # a click that takes the focus hits it
    write.press("Enter")
    expect(measure.locator("#spoken")).to_have_text("Row 1: ν = 18.4°, M = 0.95")
    assert measure.evaluate("document.activeElement.id") == "write-down"
    measure.evaluate("draw()")
    for change in ("", "change({ z1: 3 }); ", "$('put-on').click(); change({ z1: 2 }); "):
        measure.evaluate(
            f"{change}draw(); $('write-down').click()"
        )  # the points are not where they would be placed now
        expect(measure.locator("#spoken")).to_contain_text("First drag A, B and C onto the piece.")
        assert measure.evaluate("rows.length") == 1
        expect(measure.locator("#readings")).to_have_text(re.compile("^$" if change else "Angle 18.4°"))
    expect(measure.locator("#sentence")).to_be_empty()
    measure.get_by_role("button", name="Show the answer").press("Enter")
    expect(measure.locator("#sentence")).to_contain_text("turned by 18.4°")
    expect(measure.locator("#overlay .caption")).to_contain_text("ν = 18.4°")
    measure.evaluate("$('put-on').click(); draw()")
    show(measure, alpha=91)
    expect(measure.locator("#sentence")).to_be_empty()
    expect(measure.locator("#spoken")).to_contain_text("First drag A, B and C onto the piece.")  # anew
    show(measure, alpha=90)
    label = measure.locator("#plot-nu").get_attribute("aria-label")
    assert label == "ν over α. By the equation, ν is now 18.4°. Measured points: 1."
    assert {"30", "α / °", "ν / °"} <= {*measure.locator("#plot-nu text").all_text_contents()}


def test_what_is_to_be_done_for_the_next_row_is_said(measure):
    write_down(measure, put=True)
    measure.evaluate("draw()")
    expect(measure.locator("#move-first")).to_have_text(re.compile(r"^Row 1: ν = 15\.0°"))
    show(measure, alpha=30)
    expect(measure.locator("#move-first")).to_have_text(re.compile("^First drag A, B and C"))


def test_beginners_have_one_size(measure):
    """It is compared with the size without sheets, also in the table and the curve. The table keeps M."""
    show(measure, alpha=180, z1=2, level="simple")
    write_down(measure, put=True)
    expect(measure.locator("#readings")).to_contain_text(
        "AC would be 1.14 tiles. The piece appears 2.00 times as large."
    )
    expect(measure.locator("#spoken")).to_have_text("Row 1: ν = 0.0°, size = 2.00")
    expect(measure.locator("#plot-M")).to_have_accessible_name(re.compile("^size over α. By .* size is now 2.00."))
    field = measure.get_by_label("size in row 1")
    expect(field).to_have_value("2.00")
    field.fill("1,6")
    assert measure.evaluate("rows[0].M") == "1.2"
    expect(measure.locator(".symbol[value=M]")).to_have_text(re.compile("^Mark in the picture: size"))
    show(measure, level="expert")
    expect(measure.get_by_label("M in row 1")).to_have_value("1.2")
    measure.evaluate("$('put-on').click(); draw()")
    expect(measure.locator("#readings")).to_contain_text("= 1.50, compared with the size in the window.")
    show(measure, alpha=90, z1=6, level="simple")
    write_down(measure, put=True)
    expect(measure.locator("#readings")).to_contain_text("The piece appears 1.41 times as large")
    expect(measure.get_by_label("size in row 2")).to_have_value("1.41")  # not twice the rounded M
    assert measure.evaluate("csv()").split("\r\n")[1:] == ["ideal,,180,2,6,0,1.2,1.6", "ideal,,90,6,6,45,0.71,1.41"]


def test_a_row_is_filled_by_hand_saved_and_removed(measure):
    show(measure, alpha=60, z1=2)
    expect(measure.get_by_role("button", name="Write down")).to_be_disabled()  # what was found before is no measurement
    write_down(measure, put=True)
    expect(measure.get_by_role("button", name="Write down")).to_be_disabled()
    show(measure, sheet="single", z2=5)
    write_down(measure, put=True)
    show(measure, sheet="detailed", z2=6)
    write_down(measure, put=True)
    cells = "[...$('rows').rows].map((row) => [...row.cells].slice(0, 3).map(({ textContent }) => textContent))"
    wanted = [["ideal sheet", "–", "60"], ["one sheet", "100", "–"], ["two sheets", "100", "60"]]
    assert measure.evaluate(cells) == wanted
    for _ in range(2):
        measure.get_by_role("button", name="Remove row 2").click()
    measure.get_by_label("ν in row 1").fill("14,5")
    measure.get_by_label("M in row 1").fill("")
    assert measure.evaluate("csv()") == "sheets,N,alpha,z1,z2,nu,M,size\r\nideal,,60,2,6,14.5,,"
    measure.evaluate("choose('de')")
    # as its spreadsheets read it
    assert measure.evaluate("csv()") == "sheets;N;alpha;z1;z2;nu;M;size\r\nideal;;60;2;6;14,5;;"
    measure.evaluate("choose('en'); draw()")
    with measure.expect_download() as download:
        measure.get_by_role("button", name="Save CSV").click()
    assert download.value.suggested_filename == "povgen.csv"
    expect(measure.locator("#spoken")).to_have_text("Saved: povgen.csv")
    measure.get_by_role("button", name="Remove row 1").click()
    assert measure.evaluate("rows.length") == 0
    expect(measure.locator("#save-csv")).to_be_disabled()


def test_rows_are_in_the_plots_and_in_the_pages_language(measure):
    for z1 in (2.5, 50):
        show(measure, z1=z1)
        write_down(measure, put=True)
    measure.evaluate("draw()")
    outside = """[...document.querySelectorAll(".plots .mark")].filter((mark) =>
      Number(mark.getAttribute("cx")) > mark.ownerSVGElement.clientWidth)"""
    assert measure.evaluate(f"{outside}.length") == 0
    assert "50" in measure.locator("#plot-M text").all_text_contents()
    fields = "[...$('rows').rows[0].cells].slice(1).map((cell) => cell.firstChild.value || cell.textContent)"
    before = measure.evaluate(fields)
    measure.locator("#language").select_option("de")
    measure.evaluate("draw()")
    assert measure.evaluate(fields) == [text.replace(".", ",") for text in before] != before
    expect(measure.get_by_label("ν in Zeile 1")).to_be_visible()


def test_work_survives_the_page(browser, demo_file):
    page, faults = opened(browser, demo_file, "#sheet=ideal", reduced_motion="reduce")
    made = """[".kept:not([hidden])", "#rows tr", "#prediction .right"]
      .map((each) => document.querySelectorAll(each).length)"""
    page.locator("#tab-measure").click()
    page.get_by_role("button", name="Put A, B and C").press("Enter")
    write = page.get_by_role("button", name="Write down")
    expect(write).to_be_enabled()  # a key would not wait for that
    write.press("Enter")
    page.get_by_label("M in row 1").fill("0,9")
    page.locator("#measure").get_by_label("Name:").fill("Ada")
    page.evaluate("draw(); fromHash('#question=near'); draw()")
    page.get_by_role("radio", name="counter-clockwise").check()
    page.locator("#reveal").click()
    page.get_by_role("button", name="Votes of the class").click()
    page.locator("#votes input").first.fill("12")
    page.evaluate("endGlide(); draw(); keepAddress()")

    def again(hash_=""):
        if hash_:
            page.goto("about:blank")
            page.goto(demo_file.as_uri() + hash_)
        else:
            page.reload()
        page.evaluate(NAMES)
        page.evaluate("draw()")
        return page.evaluate(made)

    assert again("#question=near") == [2, 1, 0]  # the next class is asked anew
    assert page.evaluate("work.answers.near") == {"given": "0", "first": True, "shown": False}
    page.get_by_role("radio", name="counter-clockwise").check()
    page.locator("#reveal").click()
    assert again() == [2, 1, 1]
    kept = "[state.alpha, rows[0].M, work.votes.near[0][0], $('questions').querySelector('.student').value]"
    assert page.evaluate(kept) == [66, "0,9", 12, "Ada"]  # as with the answer
    expect(page.locator("#answer")).to_contain_text("Yes: counter-clockwise.")
    expect(page.locator("#votes")).to_be_visible()
    page.locator("#again").click()
    page.get_by_role("radio", name="not turn").check()
    page.locator("#reveal").click()
    marks = (
        "[...document.querySelectorAll('#prediction label')].map((part) => getComputedStyle(part, '::after').content)"
    )
    assert page.evaluate(marks) == ['"✓"', '"✗"', "none"]
    page.evaluate("openQuestion(-1); draw(); keepAddress()")
    again()
    page.keyboard.press("q")  # the address would follow later
    assert page.evaluate("[QUESTIONS[state.question].name, draw(), keepAddress()][0]") == "near"  # that was open
    page.evaluate("povgen.look.present(true)")
    expect(page.get_by_role("button", name="Votes of the class")).to_be_visible()
    page.evaluate("povgen.look.present(false)")
    page.locator("#questions .kept").get_by_role("button", name="Delete").click()
    page.get_by_role("button", name="Keep them").click()
    assert page.evaluate("isEmpty()") is False
    page.locator("#questions .kept").get_by_role("button", name="Delete").click()
    page.locator("#delete-all").click()
    expect(page.locator("#tab-questions")).to_be_focused()
    expect(page.locator("#answer")).to_be_empty()
    expect(page.locator("#reveal")).to_be_visible()
    assert again() == [0, 0, 0] and page.evaluate("work.student") == ""

    page.evaluate("void (Storage.prototype.setItem = () => { throw Error(); })")  # as in private windows
    page.locator("#reveal").click()
    expect(page.locator("#questions .kept")).to_contain_text("This browser keeps nothing")
    with page.expect_event("dialog") as asked:
        page.evaluate("setTimeout(() => location.reload())")
    assert asked.value.type == "beforeunload"
    assert not faults
    page.close()
