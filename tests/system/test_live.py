"""The live view in a real Chromium, drawn without a GPU. Where WebGL 2 does not work, these tests fail."""

import numpy as np
import pytest
from conftest import NAMES, refused

import povgen
from povgen import Chess, InputError, Spheres
from povgen.liveview.values import values
from povgen.measure import live
from povgen.measure.browser import View
from povgen.measure.probes import Directions
from povgen.measure.targets import other_targets

pytestmark = [pytest.mark.xdist_group("live"), pytest.mark.timeout(600)]
SIZE = (160, 120)
PATIENCE = 240_000  # ms, of what waits for a browser that draws without a GPU on a busy machine


@pytest.fixture(scope="module")
def prisms(browser):
    return View(browser, Directions(sheet="detailed"))


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The page of a chess scene, as a user opens it."""
    return povgen.live(Chess(sheet="ideal")).save(tmp_path_factory.mktemp("live") / "a view #1.html")


@pytest.fixture
def page(browser, file):
    """The opened page. The test fails if the page has an error, or asks for anything but itself."""
    faults, requests = [], []
    opened = browser.new_page(viewport={"width": 160, "height": 120})
    opened.set_default_timeout(PATIENCE)
    opened.on("console", lambda message: faults.append(message.text))
    opened.on("pageerror", lambda error: faults.append(str(error)))
    opened.on("request", lambda request: requests.append(request.url))
    opened.goto(file.as_uri())
    opened.evaluate(NAMES)
    opened.evaluate("view.ready")
    yield opened
    assert not faults and requests == [file.as_uri()]
    opened.close()


# ---- Accuracy: the checks of `povgen verify --live` at reduced size ----


def test_directions_agree_with_the_ray_trace(prisms):
    figures = list(live.directions(prisms, live.PRISM_SCENES, SIZE))
    assert len(figures) == 2 and all(figure.holds for figure in figures), figures


def test_directions_disagree_with_another_glass(prisms, monkeypatch):
    """The check can fail: the shader's index is wrong by a thousandth."""
    monkeypatch.setattr(
        "povgen.measure.browser.values", lambda scene: values(scene) | {"index": 1.0015 * scene.index, "alpha": 66.1}
    )
    assert not any(figure.holds for figure in live.directions(prisms, ({},), SIZE))


def test_positions_agree_with_the_predictions(browser):
    view = View(browser, Directions(sheet="ideal"), other_targets()["law"])
    figures = list(live.positions(view, 6, (320, 240)))
    assert len(figures) == 3 and all(figure.holds for figure in figures), figures


@pytest.mark.parametrize(
    "scene",
    [
        Chess(sheet="none", piece=("knight", "king"), x=(0, 0.6), z1=(2, 3)),
        Spheres(sheet="ideal", eye=(0.2, 0.1)),
        Chess(sheet="detailed", alpha=50),
        Chess(sheet="detailed", tops="black"),
        Chess(sheet="axis", axis=(0.3, 1, 0.2), alpha=15),
        Chess(sheet="ideal", alpha=50, window=("alpha=75,z=2", "alpha=20,z=4,sheet=detailed"), z2=8, eye=(0.6, 0.1)),
    ],
    ids=["none", "spheres", "detailed", "black tops", "axis", "ideal windows before prisms"],
)
def test_pictures_agree_with_povray(browser, monkeypatch, scene):
    monkeypatch.setattr(live, "SMALL", (320, 240))
    monkeypatch.setattr(live, "PICTURE", SIZE)
    monkeypatch.setattr(live, "CONVERGED", "1,0.001,6")
    figures = list(live.pictures(browser, scene.sheet, [scene]))
    assert len(figures) == 2 and all(figure.holds for figure in figures), figures


def test_a_piece_of_ones_own(browser, tmp_path):
    file = tmp_path / "ball.inc"
    file.write_text("#declare Piece = sphere { 0.4*y, 0.4 }\n")
    scene = Chess(piece=str(file), sheet="none")
    view = View(browser, scene)
    # the ball, and no sky: 3 is OBJECT in objects.glsl
    shown = view.readout(SIZE)["shown"][..., 0] == 3
    y, x = np.argwhere(shown).mean(0)
    across = 0.8 / 8 * 6 / scene.view * SIZE[1]  # seen from 6 tiles before the sheets, 2 behind them
    assert shown.sum() == pytest.approx(np.pi / 4 * across**2, rel=0.08)
    assert x == pytest.approx(SIZE[0] / 2 - 0.5, abs=0.3)
    view.page.close()


# ---- The page ----


def canvas(page):
    """Return the canvas's pixels, as the user sees them."""
    from io import BytesIO

    from PIL import Image

    with Image.open(BytesIO(page.locator("canvas").screenshot())) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def at_rest(page):
    page.wait_for_function("view.converged()", timeout=PATIENCE)
    page.wait_for_function("!view.pending && !view.asked", timeout=PATIENCE)


def test_the_page_shows_the_scene_and_follows_it(page):
    at_rest(page)
    before = canvas(page)
    shown = page.evaluate("([w, h]) => { const l = light(view, w, h, 64); return [...l.slice(0, 4)]; }", list(SIZE))
    assert before.std() > 30 and shown[3] == 64
    page.evaluate("view.set({ alpha: -66 })")
    assert not page.evaluate("view.converged()")
    at_rest(page)
    after = canvas(page)
    changed = abs(after - before).max(-1) > 30
    height, width = changed.shape
    assert changed[height // 4 : height // 2, width // 3 : -width // 3].mean() > 0.3  # in the window
    assert changed[:, : width // 8].mean() < 0.01  # beside it
    page.evaluate("view.set({ sheet: 'detailed', prisms: 40 })")
    page.evaluate("view.set({ sheet: 'ideal', alpha: 66 })")
    at_rest(page)
    assert abs(canvas(page) - before).max() <= 1  # nothing of the way is left


def test_a_transparent_background_shows_the_page(page):
    page.evaluate("PACE.RAYS = 1")
    page.evaluate("view.set({ background: 'white', sheet: 'none' })")
    at_rest(page)
    before = canvas(page)
    page.evaluate("view.set({ background: 'transparent' })")
    at_rest(page)
    after = canvas(page)
    shows_page = abs(after - (0x15, 0x18, 0x1C)).max(-1) <= 1  # the page's own colour
    white = before.min(-1) == 255
    assert 0.2 < shows_page.mean() < 0.6 and white[shows_page].all()
    assert shows_page[white].mean() > 0.9  # highlights are white, too
    assert abs(after - before)[~white].max() <= 1


def test_the_canvas_has_the_displays_pixels(browser, file):
    context = browser.new_context(viewport={"width": 120, "height": 90}, device_scale_factor=2)
    page = context.new_page()
    page.goto(file.as_uri())
    page.evaluate(NAMES)
    page.evaluate("view.ready")
    assert page.evaluate("[view.canvas.width, view.canvas.height]") == [240, 180]
    page.set_viewport_size({"width": 100, "height": 80})
    page.wait_for_function("view.canvas.width === 200 && view.canvas.height === 160")
    at_rest(page)
    assert canvas(page).std() > 30
    context.close()


def test_a_slow_picture_gets_fewer_pixels_and_then_all(page):
    """Each frame takes too long: then the next has fewer pixels, and the picture at rest is made of strips."""
    at_rest(page)
    before = canvas(page)
    page.evaluate("PACE.SLOW = PACE.FAST = 0.001")
    page.evaluate(
        """() => new Promise((done) => {
          const move = (n) => {
            view.set({ alpha: n });
            if (n < 106 && view.scale > 0.5) requestAnimationFrame(() => move(n + 1));
            else done();
          };
          move(66);
        })"""
    )
    assert page.evaluate("view.scale") <= 0.5
    page.evaluate("PACE.RAYS = 1")
    page.wait_for_function("view.row > 0 && view.row < view.canvas.height", polling=1)
    page.evaluate("PACE.RAYS = 64; view.set({ alpha: 66 })")  # while a strip is being drawn
    at_rest(page)
    assert abs(canvas(page) - before).max() <= 1


def test_at_rest_nothing_is_drawn(page):
    at_rest(page)
    page.evaluate(
        """() => {
          window.drawn = 0;
          const draw = view.gl.drawArrays.bind(view.gl);
          view.gl.drawArrays = (...values) => { drawn += 1; draw(...values); };
        }"""
    )
    page.wait_for_timeout(400)
    assert page.evaluate("drawn") == 0
    page.evaluate("PACE.RAYS = 1; view.budget = 1e6; view.set({ alpha: 20 })")
    at_rest(page)
    assert page.evaluate("drawn") == 2  # one ray a pixel, and the sum on the canvas


def first_picture(page):
    """Wait until the page shows a picture with one ray a pixel, and return it."""
    page.evaluate("PACE.RAYS = 1; view.budget = 1e9; view.again()")
    at_rest(page)
    return canvas(page)


def test_a_lost_context_is_said_and_comes_back(page):
    before = first_picture(page)
    page.evaluate("window.loss = view.gl.getExtension('WEBGL_lose_context'); loss.loseContext()")
    page.wait_for_function("document.getElementById('message').textContent.includes('starts again')")
    assert not page.evaluate("view.converged()")
    page.evaluate("view.set({ alpha: 66 })")  # does nothing, and fails not
    page.evaluate("loss.restoreContext()")
    page.wait_for_function("document.getElementById('message').textContent === ''")
    at_rest(page)
    assert abs(canvas(page) - before).max() <= 1


def test_a_context_that_the_browser_keeps_comes_back_in_sight(page):
    """A browser that stops a view, because it needs its context for others, need not restore it."""
    before = first_picture(page)
    page.evaluate("document.body.append(Object.assign(document.createElement('div'), { style: 'height: 9999px' }))")
    page.evaluate("view.gl.getExtension('WEBGL_lose_context').loseContext()")
    page.wait_for_function("document.getElementById('message').textContent.includes('out of sight and back')")
    page.evaluate("scrollTo(0, 9999)")
    page.wait_for_function("!view.inSight")
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_function("document.getElementById('message').textContent === ''")
    at_rest(page)
    assert abs(canvas(page) - before).max() <= 1
    assert page.evaluate("view.canvas === document.getElementById('view')")
    page.set_viewport_size({"width": 96, "height": 72})  # the new canvas's size is followed, too
    page.wait_for_function("view.canvas.width === 96 && view.canvas.height === 72")


def test_a_view_that_is_out_of_sight_for_a_moment_is_drawn_again(page):
    """In sight again before the browser has said that the context is lost."""
    before = first_picture(page)
    moment = """() => {
      view.inSight = false;
      view.hold();
      view.inSight = true;
      view.hold();
      return view.gl.isContextLost();
    }"""
    assert page.evaluate(moment)
    at_rest(page)
    assert abs(canvas(page) - before).max() <= 1
    page.evaluate(
        """view.canvas.addEventListener("webglcontextrestored", () => (view.inSight = false), { capture: true })"""
    )
    assert page.evaluate(moment)  # and out of sight again before it is restored
    page.wait_for_function("!view.inSight && view.lost")
    assert page.inner_text("#message") == ""


def test_of_18_views_those_in_sight_hold_a_context(browser):
    page = browser.new_page(viewport={"width": 160, "height": 200})
    page.set_default_timeout(PATIENCE)
    warnings = []
    page.on("console", lambda message: warnings.append(message.text))
    view = povgen.live(Spheres(sheet="none"), 96, 72)._repr_html_()
    page.set_content(f"<div style='margin-bottom: 150px'>{view}</div>" * 18)
    frames = page.frames[1:]
    for frame in frames:
        frame.evaluate(NAMES)
        frame.evaluate("PACE.RAYS = 1")
    last = len(frames) - 1
    for top, seen in ((0, {0}), (1e9, {last}), (0, {0})):
        page.evaluate("(top) => scrollTo(0, top)", top)
        for number, frame in enumerate(frames):
            holds = "view.gl && !view.gl.isContextLost()"
            frame.wait_for_function(holds if number in seen else f"!({holds})")
            assert frame.inner_text("#message") == ""
    assert [frame.evaluate("Boolean(view.gl)") for frame in frames] == [number in (0, last) for number in range(18)]
    assert first_picture(frames[0]).std() > 10 and not warnings
    page.close()


def test_without_decompression_the_page_says_so(browser, file):
    page = browser.new_page()
    page.set_default_timeout(PATIENCE)
    page.add_init_script("delete window.DecompressionStream")
    page.goto(file.as_uri())
    page.evaluate(NAMES)
    page.wait_for_function("document.getElementById('message').textContent.includes('DecompressionStream')")
    page.evaluate("view.ready")  # whoever waits for it does not wait for ever
    page.close()


def test_16_bit_numbers_do_where_32_bit_textures_are_missing(page, browser, file):
    at_rest(page)
    other = browser.new_page(viewport={"width": 160, "height": 120})
    other.add_init_script(
        """const all = WebGL2RenderingContext.prototype.getExtension;
        WebGL2RenderingContext.prototype.getExtension = function (name) {
          return name === "EXT_color_buffer_float" ? null : all.call(this, name);
        };"""
    )
    other.goto(file.as_uri())
    other.evaluate(NAMES)
    other.evaluate("view.ready")
    at_rest(other)
    assert other.evaluate("view.context.format === view.gl.RGBA16F")
    off = abs(canvas(other) - canvas(page))
    assert off.max() <= 6 and off.mean() < 0.5
    other.close()


def test_without_webgl_the_page_says_so(browser, file):
    page = browser.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(file.as_uri())
    page.wait_for_function("document.getElementById('message').textContent.includes('needs WebGL 2')")
    page.close()


def test_bench_says_the_frames_a_second(browser, file):
    page = browser.new_page(viewport={"width": 64, "height": 48})
    page.goto(f"{file.as_uri()}?bench")
    page.evaluate(NAMES)
    page.wait_for_function(
        "document.getElementById('message').textContent.includes('frames a second')", timeout=120_000
    )
    times = page.evaluate("bench(view, 3)")  # what a page that has the view in it can call
    assert len(times) == 3 and min(times) > 0
    page.close()


def test_the_page_is_one_small_file(file):
    assert file.stat().st_size < 250_000
    text = file.read_text("utf-8")
    assert "src=" not in text and "http" not in text.replace("http-equiv", "")


def test_a_notebook_shows_the_view(browser):
    """Jupyter puts `_repr_html_` into its page."""
    page = browser.new_page()
    page.set_content(f"<p>A notebook</p>{povgen.live(Spheres(sheet='none'), 96, 72)._repr_html_()}")
    frame = page.frames[1]
    frame.evaluate(NAMES)
    frame.wait_for_function("view.gl")
    assert frame.evaluate("[view.canvas.width, view.canvas.height]") == [96, 72]
    at_rest(frame)
    assert canvas(frame).std() > 10
    page.close()


def test_the_view_is_verified_alone(tmp_path):
    message = refused(["verify", "--live", "--sheet", "ideal"], tmp_path)
    assert message.strip() == "povgen: live: the live view is measured alone; allowed without --sheet and --stability"


def test_only_scenes_are_shown():
    with pytest.raises(InputError, match="scene = 'chess': should be a scene"):
        povgen.live("chess")
