"""What the tests of the teaching page share: one Chromium, one page, and what a hand does with it."""

from io import BytesIO

import numpy as np
import pytest
from conftest import NAMES, started_browser
from PIL import Image
from playwright.sync_api import expect

expect.set_options(timeout=120_000)  # ms: a busy machine is no fault
WORK = {"width": 1000, "height": 640}  # a small canvas costs less
COARSE, SHARP = (f"window.devicePixelRatio = {ratio}; view.resize()" for ratio in (0.2, 1))
STILL = "view.later = () => {}"  # most tests are not about the live view
DRAWN = "if (Object.hasOwn(view, 'later')) { delete view.later; view.again(); }"


@pytest.fixture(scope="package")
def browser():
    """The Chromium of all tests in this folder. Its pages have few rays: those of a coarse display."""
    with started_browser("window.devicePixelRatio = 0.2") as started:
        yield started


@pytest.fixture(scope="package")
def demo_file(tmp_path_factory):
    """The teaching page, in a folder whose name has to be quoted in a URL."""
    from povgen.page.page import demo

    return demo(tmp_path_factory.mktemp("demo") / "a démo #1.html", progress=False)


class Faults(list):
    """What the console says, and the requests for anything but the page's own files."""

    def watch(self, page, folder):
        # Chromium says so when it copies a canvas out of SwiftShader
        page.on("console", lambda message: "GPU stall due to ReadPixels" in message.text or self.append(message.text))
        page.on("pageerror", lambda error: self.append(str(error)))
        page.on("request", lambda request: request.url.startswith((folder, "data:")) or self.append(request.url))
        return self


def opened(browser, file, hash_="", **options):
    """Open the teaching page, without its guided start."""
    page = browser.new_page(viewport=WORK, **options)
    page.add_init_script("if (navigator.xr) navigator.xr.isSessionSupported = async () => true")
    faults = Faults().watch(page, file.parent.as_uri())
    page.goto(file.as_uri() + hash_)
    page.evaluate(NAMES)
    page.evaluate("tour.leave(); OPENING.level = 'expert'; change({ level: 'expert' }); draw()")
    page.evaluate("PACE.RAYS = 1; STILL.MOST = 0; view.ready")
    page.evaluate("view.loading.then(() => {})")  # not what it results in, which is large
    return page, faults


@pytest.fixture(scope="package")
def shared_page(browser, demo_file):
    page, faults = opened(browser, demo_file)
    assert page.evaluate("Boolean(view.gl)"), "no WebGL 2"
    page.evaluate("view.ready.then(draw)")
    yield page, faults
    page.close()


@pytest.fixture
def page(shared_page):
    """The teaching page, as it is when it has just been opened. The test fails if the page has an error.

    The live view is drawn only for tests that ask for its `picture`: to draw it takes longer than all else.
    """
    page, faults = shared_page
    page.evaluate(STILL)
    page.evaluate(COARSE)
    page.set_viewport_size(WORK)
    page.emulate_media(media="screen", color_scheme="light", reduced_motion="no-preference", forced_colors="none")
    page.evaluate(
        """() => {
          player.pause();
          tour.leave();
          localStorage.clear();
          take();
          endGlide();  // of an earlier test, on a busy machine
          PACE.RAYS = 1;
          OPENING.level = "expert";
          choose("en");
          present(false);
          if (document.documentElement.dataset.look === "dark") $("dark").click();
          $("teach").close();
          for (const each of document.querySelectorAll(":popover-open")) each.hidePopover();
          player.preset = data.presets[0];
          state.question = -1;
          session.lastQuestion = 0;
          session.curtain = 0.5;
          fromHash("");
          $("loop").checked = false;
          $("shortcuts").checked = true;
          for (const each of document.querySelectorAll("details")) each.open = false;
          for (const each of document.querySelectorAll("[aria-expanded]")) {
            if (!$(each.getAttribute("aria-controls")).hidden) each.click();
          }
          session.pinned = "";
          mark("");
          document.activeElement.blur();
          scrollTo(0, 0);
          draw();
        }"""
    )
    yield page
    assert not faults
    faults.clear()


def show(page, **values):
    """Change the page's state and draw it."""
    page.evaluate("(values) => { change(values); draw(); }", values)


def heard(page, *live):
    """Listen to live regions. Return a function that returns all texts that have been written there since."""
    page.evaluate(
        """(live) => {
          window.written = [];
          for (const id of live) {
            const observer = new MutationObserver(() => written.push($(id).textContent));
            observer.observe($(id), { childList: true, characterData: true, subtree: true });
          }
        }""",
        live,
    )
    return lambda: page.evaluate("written")


def bounds(page, *selectors):
    """Return the elements' boxes, in one call: another frame of the picture replaces what is drawn over it."""
    boxes = "(selectors) => selectors.map((each) => document.querySelector(each).getBoundingClientRect().toJSON())"
    return page.evaluate(boxes, selectors)


def centre(page, selector):
    """Return the centre of an element, in tiles from the window's centre."""
    page.locator(selector).wait_for()  # what is drawn over the picture follows with its next frame
    box, stage = bounds(page, selector, "#stage")
    x, y = (box[a] + box[b] / 2 - stage[a] - stage[b] / 2 for a, b in (("x", "width"), ("y", "height")))
    return complex(x, -y) / stage["height"] * 3.7


def drag(page, start, step, box="#stage", tiles=None):
    """Drag by the mouse, from a place and by a step in tiles from the middle of a box."""
    area = page.locator(box).bounding_box()
    tile = tiles or area["height"] / 3.7
    ends = [start, start + step / 2, start + step]
    x, y = area["x"] + area["width"] / 2, area["y"] + area["height"] / 2
    for n, place in enumerate(ends):
        page.mouse.move(x + tile * place.real, y - tile * place.imag)
        if not n:
            page.mouse.down()
    page.mouse.up()
    page.evaluate("draw()")


def touch(page, *places):
    """Put fingers on the page, move them, and lift them. Each place has a point of each finger."""
    session = page.context.new_cdp_session(page)
    for n, points in enumerate(places):
        fingers = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(points)]
        session.send("Input.dispatchTouchEvent", {"type": "touchMove" if n else "touchStart", "touchPoints": fingers})
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    session.detach()


def pixels(png):
    with Image.open(BytesIO(png)) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def picture(page, display=SHARP):
    """Return the stage's pixels, when the picture has been drawn. It is drawn again when the state changes."""
    page.evaluate(display)
    page.evaluate(DRAWN)
    page.wait_for_function("view.converged()")
    return pixels(page.locator("#stage").screenshot())
