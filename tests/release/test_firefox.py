"""The teaching page in Debian's Firefox: it draws what Chromium draws, and its controls are in reach."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from axe_playwright_python.base import AXE_SCRIPT
from conftest import AXE, FAULTS, NAMES

from povgen.measure.browser import chromium
from povgen.page.page import demo

ENVIRONMENT = Path(sys.prefix)
SIZE = {"width": 1280, "height": 720}
SETTINGS = (
    "#sheet=ideal",
    "#sheet=detailed&N=20&language=de",
    "#sheet=detailed&alpha=120&level=expert&position=1&image=1&caption=1",
    "#sheet=lenticular&level=expert&language=fr",
    "#windows=2&alpha=40&z1=3&level=expert",
    "#scene=spheres&sheet=single&language=es",
    "#sheet=ideal&question=sky&language=ar",
)
VIOLATIONS = f"axe.run({json.dumps(AXE)}).then(({{ violations }}) => violations.map(({{ id }}) => id))"
pytestmark = pytest.mark.timeout(600)


class Firefox:
    """A page of Firefox, on a screen in memory. It has the methods of firefox.mjs."""

    def __init__(self):
        driver = Path(__file__).with_name("firefox.mjs")
        screen = ["xvfb-run", "--auto-servernum", "--server-args", "-screen 0 1600x1200x24"]
        program = shutil.which("firefox-esr")
        node = [ENVIRONMENT / "bin" / "node", driver, ENVIRONMENT / "lint" / "node_modules", program]
        self.process = subprocess.Popen([*screen, *node], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def __getattr__(self, name):
        def call(*arguments):
            print(json.dumps([name, *arguments]), file=self.process.stdin, flush=True)
            return json.loads(self.process.stdout.readline())

        return call


@pytest.fixture(scope="module")
def page_file(tmp_path_factory):
    return demo(tmp_path_factory.mktemp("page") / "demo.html", progress=False)


@pytest.fixture(scope="module")
def firefox():
    started = Firefox()
    started.setViewport(SIZE)
    yield started
    started.process.stdin.close()  # so that it ends
    assert started.process.wait(60) == 0


@pytest.fixture(scope="module")
def chrome():
    with chromium() as browser:
        yield browser.new_page(viewport=SIZE)


def opened(page, address):
    """Open the page at an address. Return its texts, the object that each pixel shows (K,), and its light (K, 4)."""
    page.goto("about:blank")
    page.goto(address)
    page.evaluate(NAMES)
    page.evaluate(AXE_SCRIPT)
    page.evaluate("tour.leave(); PACE.RAYS = 1; draw(); view.ready.then(draw)")
    texts = page.evaluate("[...document.querySelectorAll('#sentence, [id^=value-]')].map((part) => part.textContent)")
    objects = page.evaluate("[...readout(view, 160, 120).shown].filter((_, k) => k % 4 === 0)")
    return texts, np.array(objects), np.reshape(page.evaluate("[...light(view, 160, 120, 4)]"), (-1, 4)) / 4


@pytest.mark.parametrize("hash_", SETTINGS)
def test_firefox_shows_what_chromium_shows(firefox, chrome, page_file, hash_):
    address = page_file.as_uri() + hash_
    texts, objects, light = opened(firefox, address)
    expected_texts, expected_objects, expected_light = opened(chrome, address)
    assert texts == expected_texts and texts[0]
    assert (objects == expected_objects).mean() > 0.995 and len(set(objects)) > 2
    assert abs(light - expected_light).mean() < 0.005 < light[:, :3].std()
    for width, height in ((1280, 720), (390, 844)):
        firefox.setViewport({"width": width, "height": height})
        firefox.evaluate("draw()")
        assert firefox.evaluate(f"({FAULTS})()") == []
        assert firefox.evaluate(VIOLATIONS) == []
    firefox.setViewport(SIZE)
    assert firefox.said() == []


def test_the_keys_move_a_slider(firefox, page_file):
    firefox.goto(page_file.as_uri() + "#level=simple")
    firefox.evaluate(NAMES + "; tour.leave(); draw()")
    before = firefox.evaluate("$('sentence').textContent")
    for _ in range(40):
        firefox.press("Tab")
        if firefox.evaluate("document.activeElement.id") == "slider-alpha":
            break
    firefox.press("ArrowRight")
    assert firefox.evaluate("state.alpha") == 66.5
    firefox.evaluate("draw()")
    assert firefox.evaluate("$('sentence').textContent") != before
    assert firefox.said() == []
