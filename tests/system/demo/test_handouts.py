"""What a lesson takes away from the page, how it looks, and the user's own room."""

import base64
import re
import zlib
from io import BytesIO
from itertools import pairwise

import numpy as np
import pytest
from conftest import NAMES
from PIL import ExifTags, Image
from playwright.sync_api import expect

from demo.conftest import COARSE, DRAWN, WORK, Faults, bounds, picture, pixels, show


@pytest.fixture
def share(page):
    page.get_by_role("button", name="More").click()
    return page


def test_the_link_is_copied_or_shown(share):
    show(share, alpha=33)
    share.evaluate("() => { navigator.clipboard.writeText = async () => { throw Error(); }; }")
    share.get_by_role("button", name="Copy link").click()
    expect(share.locator("#copied")).to_have_text("Copy it from here:")
    link = share.locator("#link-text").input_value()
    assert link.startswith("file:") and "alpha=33&" in link
    share.evaluate("() => { navigator.clipboard.writeText = async (text) => { window.copied = text; }; }")
    share.get_by_role("button", name="Copy the HTML").click()
    expect(share.locator("#copied")).to_have_text(
        re.compile("^Copied. It leads to this file, which lies on your computer only.")
    )
    frame = share.evaluate("window.copied")
    assert frame.startswith("<iframe src=") and "?embed&amp;hide=header,panel#" in frame and "alpha=33" in frame
    share.get_by_role("button", name="What do red and cyan glasses show?").click()
    share.keyboard.press("Escape")
    expect(share.locator("#what-depth")).to_be_hidden()
    expect(share.locator("#share")).to_be_visible()  # Escape closes one thing
    expect(share.locator("#qr-open")).to_be_hidden()  # a file has no address that others can open
    share.evaluate("delete window.copied")


def test_the_code_of_the_link_is_large_and_moves_nothing(browser, demo_file):
    page = browser.new_page(viewport={"width": 1000, "height": 640})
    page.route("**/*", lambda route: route.fulfill(path=demo_file))
    page.goto("http://povgen.test/#alpha=33")
    page.get_by_role("button", name="More").click()
    [before] = bounds(page, "#stage")
    page.get_by_role("button", name="QR code of the link").click()
    [code, after] = bounds(page, "#qr svg", "#stage")
    assert code["height"] > 500 and after == before
    page.keyboard.press("Escape")
    expect(page.locator("#qr")).to_be_hidden()
    page.close()


def test_the_teachers_panel_has_a_lesson_and_prints_its_tasks(browser, demo_file):
    page = browser.new_page(viewport={"width": 1000, "height": 640}, locale="de")
    page.route("**/*", lambda route: route.fulfill(path=demo_file))
    page.goto("http://povgen.test/#language=de&sheet=ideal&alpha=90&level=expert")
    page.evaluate("povgen.picture.view.ready.then(() => {})")
    own = '[["a?", "", "", "", "b", "c"]]'
    page.evaluate("(own) => { location.hash += `&own=${povgen.scramble.scrambled(own)}`; }", own)
    page.wait_for_function("povgen.questions.ownQuestions().length === 1")
    page.evaluate("povgen.kept.work.answers.far = { given: '0', first: false, shown: true }")
    panel = page.get_by_role("dialog", name="Für Lehrkräfte")
    for link, shown in {
        "Wo das Licht sich trifft: vor dem Fenster, ohne Schirm": {"alpha": 180, "light": "pencil", "show": "large"},
        "Die Berge sind sehr weit weg. Um welchen Winkel drehen sie sich bei α = 66°?": {"question": "far"},
    }.items():
        page.get_by_role("button", name="Für Lehrkräfte").click()
        panel.get_by_role("link", name=link).click()
        expect(panel).to_be_hidden()
        expect(page.locator("#ask" if "question" in shown else "#sentence")).to_be_focused()
        hash_ = page.evaluate("location.hash")
        assert all(f"{name}={value}" in hash_ for name, value in shown.items())
        assert page.evaluate("[povgen.state.state.level, povgen.questions.ownQuestions().length]") == ["expert", 1]
    assert page.evaluate("povgen.questions.isAsked()")  # although its answer was shown before
    page.go_back()
    page.wait_for_function("povgen.state.state.question < 0 && povgen.state.state.light === 'pencil'")
    page.evaluate("povgen.look.present(true)")
    lesson = page.get_by_role("group", name="Vorführen")
    lesson.get_by_role("button", name="Stunde: weiter").click()  # from where the page has gone back to
    page.wait_for_function("povgen.questions.isAsked()")
    lesson.get_by_role("button", name="Stunde: weiter").click()
    page.wait_for_function("povgen.state.state.alpha === 90")
    page.reload()
    expect(lesson).to_have_text(re.compile(r"Stunde\s+12/16"))
    expect(page.locator("input[type=range]:visible")).to_have_id("slider-z1")  # what the step is about
    assert page.evaluate("povgen.player.player.preset.parameter") == "z1"  # which Play moves
    expect(
        page.get_by_text("so weit hinter dem Fenster wie Ihr Auge davor: Der Springer dreht sich um die Hälfte von α")
    ).to_be_visible()
    at = page.locator("#lesson-next").bounding_box()["x"]
    page.keyboard.press("PageUp")
    page.wait_for_function("povgen.questions.isAsked()")
    expect(lesson).to_have_text(re.compile(r"Stunde\s+11/16"))
    assert page.locator("#lesson-next").bounding_box()["x"] == pytest.approx(at, abs=1)
    expect(page.locator("#next")).to_be_hidden()
    expect(page.locator("#lesson-name")).to_be_hidden()
    changed = "povgen.address.fromHash('#level=expert&light=prism&view=side'); povgen.data.draw()"
    page.evaluate(changed)
    assert "&view=side" in page.evaluate("povgen.address.toHash()")
    page.wait_for_function(
        "location.hash.includes('light=prism')"
    )  # the page's own change of the address leads nowhere
    expect(lesson).to_have_text(re.compile(r"Stunde\s+11/16"))
    page.keyboard.press("PageUp")  # the step comes back
    page.wait_for_function("povgen.questions.isAsked()")
    page.evaluate(changed)
    page.evaluate("document.getElementById('present').click()")
    page.keyboard.press("PageDown")  # the lesson goes on where it was
    expect(lesson).to_have_text(re.compile(r"Stunde\s+12/16"))
    page.evaluate("povgen.address.fromHash('#level=expert&alpha=60'); document.getElementById('present').click()")
    expect(lesson).to_have_text(re.compile(r"Stunde\s+12/16"))  # what has been set stays
    page.wait_for_function("location.hash.includes('alpha=60')")
    page.evaluate("povgen.address.fromHash('#level=expert'); document.getElementById('present').click()")
    page.wait_for_function("povgen.state.state.sheet === 'none'")
    expect(lesson).to_have_text(re.compile(r"Stunde\s+1/16"))  # where nothing has been set, it begins
    page.evaluate("location.hash = 'question=near&language=de'")  # a link of docs/lesson.md
    expect(lesson).to_have_text(re.compile(r"Stunde\s+5/16"))
    # one beside the lesson keeps its place
    page.evaluate("location.hash = 'sheet=ideal&alpha=180&z1=1&prisms=12&language=de'")
    page.wait_for_function("povgen.state.state.z1 === 1")
    expect(page.locator("input[type=range]:visible")).to_have_id("slider-z1")
    expect(page.locator("#lesson-name")).to_be_hidden()
    expect(lesson).to_have_text(re.compile(r"Stunde\s+5/16"))
    page.keyboard.press("ArrowLeft")  # back to it
    page.wait_for_function("povgen.questions.isAsked()")
    expect(lesson).to_have_text(re.compile(r"Stunde\s+5/16"))
    page.keyboard.press("ArrowLeft")
    expect(lesson).to_have_text(re.compile(r"Stunde\s+4/16"))
    page.get_by_role("button", name="Beenden").click()
    page.evaluate("povgen.readout.STILL.MOST = 0; povgen.picture.view.ready.then(() => {})")
    page.evaluate("window.print = () => { window.printed = true; }")
    page.evaluate(
        """async () => {
          povgen.state.change({ sheet: "ideal", alpha: 90, depth: true, large: true, compare: "none", image: true });
          povgen.data.draw();
          await povgen.picture.otherView().ready;
        }"""
    )
    page.get_by_role("button", name="Für Lehrkräfte").click()
    panel.get_by_role("button", name="Aufgabenblatt drucken").click()
    page.wait_for_function("window.printed")
    page.emulate_media(media="print")
    assert page.locator("#tasks li").count() == 4 and page.locator("main").is_hidden()
    assert page.locator("#task-setting").inner_text().startswith("Ein Springer, gesehen durch: ")
    parts = ("#task-code svg", "#task-picture", "#task-name", "#tasks h1", "#task-asks", "#task-list", "#task-back")
    [code, picture, name, title, asking, asked, back] = bounds(page, *parts)
    assert asking["bottom"] < asked["top"] < back["top"] < picture["top"]  # what answers is on another page
    assert page.locator("#task-back").evaluate("(back) => getComputedStyle(back).breakBefore") == "page"
    assert code["width"] > 100 and picture["width"] > 300 and name["width"] > 300 and title["height"] < 40

    def task(name):
        address = page.evaluate(f"document.getElementById('task-{name}').src")
        return pixels(base64.b64decode(address.split(",")[1]))

    shown, free = task("picture"), task("free")
    [other] = bounds(page, "#task-free")
    assert other["width"] == pytest.approx(picture["width"], abs=1)  # on the same scale, for comparison
    assert shown.shape == free.shape and abs(shown - free).mean() > 5
    red, green, _ = np.moveaxis(shown[-60:], 2, 0)  # of the floor
    assert shown.shape[1] == 960 and np.percentile(abs(red - green), 99) < 60  # not for glasses, and not small
    right = abs(shown - free)[:, 500:]
    assert np.median(right) < 3  # right of the curtain there are no sheets
    assert (abs(shown[:, :460] - [255, 77, 240]).max(-1) < 60).sum() > 100  # the outline of the predicted image
    assert page.locator(".measured:visible").count() == 2
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.locator("#tasks").is_hidden()
    page.emulate_media(media="screen")
    page.evaluate("povgen.state.change({ sheet: 'single', z1: 12, scene: 'spheres' }); window.printed = false")
    own = "{ own: { ask: 'a?', why: '', choices: ['b', 'c'] }, before: povgen.state.OPENING, after: {} }"
    page.evaluate(f"povgen.questions.setOwn([{own}])")
    page.get_by_role("button", name="Für Lehrkräfte").click()
    panel.get_by_role("button", name="Aufgabenblatt drucken").click()
    page.wait_for_function("window.printed")
    page.emulate_media(media="print")
    assert page.locator(".measured:visible").count() == 0  # it has no angle
    expect(page.locator("#tasks li")).to_have_text(["a?☐ b☐ c"])
    assert abs(task("asks") - free).mean() < 1 < abs(task("free") - free).mean()  # it asks, whatever the page shows
    page.close()


def test_a_movement_is_recorded(share):
    picture(share)
    share.get_by_role("button", name="Record a movement").click()
    for alpha in (10, 20, 30):
        show(share, alpha=alpha)
        share.evaluate(DRAWN)
        share.wait_for_function("view.count > 0")
    with share.expect_download() as got:
        share.get_by_role("button", name="Stop and save").click()
    file = got.value
    assert "alpha=30" in file.suggested_filename and file.suggested_filename.endswith((".webm", ".mp4"))
    assert file.path().stat().st_size > 1000


def test_a_frame_leaves_out_what_is_hidden(browser, demo_file):
    """And nothing moves by itself."""
    page = browser.new_page(viewport=WORK, reduced_motion="no-preference")
    faults = Faults().watch(page, demo_file.parent.as_uri())
    page.goto(f"{demo_file.as_uri()}?embed&hide=header,panel")
    page.evaluate(NAMES)
    page.evaluate("view.ready.then(() => {})")
    assert page.evaluate("view.gl && tour.step") == -1
    for part, seen in (("header", False), (".panel", False), ("footer", False), ("#stage", True), ("#sentence", True)):
        expect(page.locator(part)).to_be_visible(visible=seen)
    for width, height in ((800, 640), (1200, 700), (400, 600)):  # the first is that of the copied frame
        page.set_viewport_size({"width": width, "height": height})
        assert page.locator("#stage").bounding_box()["width"] > 0.5 * width
        assert page.evaluate("document.documentElement.scrollHeight <= innerHeight + 1")
    for width, height in ((800, 640), (1200, 700)):
        page.set_viewport_size({"width": width, "height": height})
        show(page, large=True)
        light, says, sentence, player = bounds(page, "#space-turn", "#light-says", "#sentence", ".player")
        assert light["height"] > 0.5 * height
        assert light["bottom"] < says["top"] and says["bottom"] < sentence["top"] and player["bottom"] < height
    assert not faults
    page.close()


def test_for_a_projector_a_question_is_beside_the_picture(page):
    """And there is a pointer. Escape closes one thing after the other."""
    page.evaluate("openQuestion(0)")
    page.set_viewport_size({"width": 1280, "height": 720})
    size = "parseFloat(getComputedStyle($('ask')).fontSize)"
    small = page.evaluate(size)
    page.get_by_role("button", name="More").click()
    page.keyboard.press("Escape")
    expect(page.get_by_role("button", name="Present")).to_be_hidden()
    page.get_by_role("button", name="More").click()
    page.get_by_role("button", name="Present").click()
    expect(page.locator("#lesson-next")).to_be_focused()
    assert page.evaluate(size) > max(24, 1.3 * small)
    for part, seen in (("#ask", True), ("#reveal", True), ("#stage", True), (".slider", False), (".player", False)):
        expect(page.locator(part).first).to_be_visible(visible=seen)
    picture, question = (page.locator(part).bounding_box() for part in ("#stage", "#ask"))
    assert question["x"] > picture["x"] + picture["width"] - 1 and picture["width"] > 400
    page.mouse.move(300, 300)
    expect(page.locator("#pointer")).to_be_visible()
    expect(page.locator("#pointer")).to_be_hidden(timeout=6000)  # the mouse rests
    page.evaluate("$('delete-work').showPopover()")
    page.mouse.move(310, 300)
    for presenting in (True, False):
        page.keyboard.press("Escape")
        expect(page.locator("#pointer")).to_be_visible(visible=presenting)
    expect(page.locator("#delete-work")).to_be_hidden()


def test_dark_is_the_users_choice(page):
    ground = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(ground)
    page.emulate_media(color_scheme="dark")
    page.wait_for_function("document.documentElement.dataset.look === 'dark'")
    dark = page.evaluate(ground)
    page.emulate_media(media="print")
    assert page.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--pane')") == "#eef3f6"
    page.emulate_media(media="screen")
    page.evaluate("$('dark').click()")
    assert page.evaluate(ground) == light != dark
    page.emulate_media(color_scheme="light")
    page.wait_for_function("document.documentElement.dataset.look === 'light'")


def test_the_page_is_printed_with_its_picture(page):
    picture(page)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    page.wait_for_function("$('print-picture').complete && $('print-picture').naturalWidth > 0")
    expect(page.locator("#print-picture")).to_be_visible()
    expect(page.locator("#reset")).to_be_hidden()
    expect(page.locator("#sentence")).to_be_visible()
    page.emulate_media(media="screen")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert not page.locator("#print-picture").get_attribute("src")


FRAME, PANE = b".7882 .6471 .4824 rg", b".9333 .9529 .9647 rg"  # colours of the view of the light, and of the diagram


@pytest.mark.parametrize("landscape", [False, True])
def test_what_is_printed_is_neither_covered_nor_cut(page, landscape):
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 1047 if landscape else 718, "height": 718 if landscape else 1047})
    show(page, light="pencil", large=True, level="simple")
    boxes = bounds(page, "h1", "#stage", "#space-turn", "#light-says", "#sentence", "#row-alpha", "dl")
    assert all(box["height"] > 10 for box in boxes)
    assert all(a["bottom"] <= b["top"] + 1 for a, b in pairwise(boxes))
    page.emulate_media(media="null")
    page.set_viewport_size({"width": 1280, "height": 720})
    show(page, large=False, level="expert")
    printed = page.pdf(format="A4", landscape=landscape, margin=dict.fromkeys(("top", "bottom"), "10mm"))
    streams = re.findall(rb"/FlateDecode.*?stream\r?\n(.*?)endstream", printed, re.S)
    pages = [zlib.decompress(stream) for stream in streams]
    for colour in (FRAME, PANE):
        assert sum(colour in text for text in pages) == 1  # what is cut is on two pages


def test_a_camera_that_does_not_start_shows_and_is_unplugged(page):
    page.evaluate("$('room').hidden = false")
    page.evaluate(
        """async () => {
          const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
          window.filming = setInterval(() => pen.fillRect(0, 0, 9, 9), 50);
          navigator.mediaDevices.getUserMedia = async () => (window.made = canvas.captureStream());
          $("camera-video").play = async () => { throw new DOMException("refused", "NotAllowedError"); };
          $("camera").click();
        }"""
    )
    expect(page.locator("#room-message")).not_to_have_text("")
    assert page.evaluate("[$('camera').getAttribute('aria-pressed'), made.active]") == ["false", False]
    page.evaluate(
        """() => {
          window.shown = 0;
          view.setSky = (picture) => { shown++; LiveView.prototype.setSky.call(view, picture); };
          delete $("camera-video").play;
          $("camera").click();
        }"""
    )
    page.wait_for_function("$('camera').getAttribute('aria-pressed') === 'true'")
    expect(page.locator("#room-message")).to_have_text("")
    # the next picture waits until this one has been drawn
    page.wait_for_function("shown > 0")
    assert page.evaluate("new Promise((done) => setTimeout(() => done(shown), 300))") == 1
    page.evaluate("view.stale = false")
    page.wait_for_function("shown > 1")
    page.evaluate("made.getTracks()[0].dispatchEvent(new Event('ended'))")
    assert page.evaluate("$('camera').getAttribute('aria-pressed')") == "false"
    page.evaluate("clearInterval(filming); delete view.setSky; $('no-room').click(); $('room').hidden = true")


def colours_beside(page):
    """Return the colours that are seen to the left of the window, above the horizon and below it."""
    page.evaluate("draw()")
    room = picture(page, COARSE)
    height, width, _ = room.shape
    pixels = [room[int(part * height), width // 20] for part in (0.2, 0.65)]
    names = {0: "red", 2: "blue"}
    return [names[int(p.argmax())] if p.max() > 200 and np.median(p) < 60 else "floor" for p in pixels]


def test_a_photo_is_seen_behind_the_window(page, tmp_path):
    show(page, sheet="none", z1=2)
    before = picture(page)
    page.get_by_role("button", name="More").click()
    page.get_by_role("button", name="Your room").click()
    data, exif = BytesIO(), Image.Exif()
    upright = Image.new("RGB", (30, 40), (250, 10, 10))
    upright.paste((10, 10, 250), (0, 20, 30, 40))
    exif[ExifTags.Base.Orientation] = 6  # as a phone that is held upright writes it
    upright.transpose(Image.Transpose.ROTATE_90).save(data, "JPEG", exif=exif, quality=100, subsampling=0)
    page.locator("#photo").set_input_files({"name": "room.jpg", "mimeType": "image/jpeg", "buffer": data.getvalue()})
    page.wait_for_function("Boolean(view.sky)")
    assert colours_beside(page) == ["red", "floor"]
    page.get_by_role("checkbox", name="floor").uncheck()
    assert colours_beside(page) == ["red", "blue"]
    page.evaluate("tour.start(true); draw()")
    assert page.evaluate("[view.sky, session.floor]") == [None, True]  # it speaks of mountains
    page.evaluate("tour.leave(); draw()")
    assert page.evaluate("[Boolean(view.sky), session.floor]") == [True, False]
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_role("button", name="Your room").click()
    page.get_by_role("button", name="Your room").click()
    stage, slider = bounds(page, "#stage", "#room-turn")
    assert 0 <= stage["top"] < stage["bottom"] < slider["top"] < slider["bottom"] < 844
    page.set_viewport_size(WORK)
    for name, value, seen in (
        ("turned", 180, ["blue", "red"]),
        ("turned", 0, ["red", "blue"]),
        ("up", 50, ["blue"] * 2),
    ):
        page.get_by_label(name, exact=True).fill(str(value))
        assert colours_beside(page) == seen, (name, value)
    page.get_by_label("it shows all around").check()
    page.locator("#photo").set_input_files({"name": "no.png", "mimeType": "image/png", "buffer": b"no"})
    expect(page.locator("#room-message")).to_have_text("This file is not a picture that the browser can read.")
    page.get_by_role("button", name="Mountains").click()
    expect(page.get_by_label("it shows all around")).not_to_be_checked()
    page.get_by_role("button", name="Your room").click()
    page.get_by_role("button", name="More").click()
    assert np.abs(picture(page) - before).mean() < 1
