"""The live view in a real Chromium, drawn without a GPU. Where WebGL 2 does not work, these tests fail."""

import shutil
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import NAMES, picture, some, wait_for

import povgen
from povgen import Chess, InputError, Spheres
from povgen.liveview import view
from povgen.measure import verify_live
from povgen.measure.browser import View, chromium
from povgen.measure.opengl import OpenGLView
from povgen.objects.floor import Floor
from povgen.objects.piece import Piece
from povgen.objects.sphere import Sphere
from povgen.objects.text import Text
from povgen.objects.window import Window
from povgen.scene.room import Eye, Room
from povgen.scene.survey import max_trace_level

SIZE = (160, 120)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The page of a chess scene, as a user opens it."""
    return povgen.live(Chess(sheet="ideal")).save(tmp_path_factory.mktemp("live") / "a view #1.html")


@pytest.fixture
def page(browser, file):
    """The opened page. The test fails if the page has an error, or asks for anything but itself."""
    faults, requests = [], []
    opened = browser.new_page(viewport={"width": 160, "height": 120})
    opened.on("console", lambda message: faults.append(message.text))
    opened.on("pageerror", lambda error: faults.append(str(error)))
    opened.on("request", lambda request: requests.append(request.url))
    opened.goto(file.as_uri())
    opened.evaluate(NAMES)
    # At rest, not 64. The view has begun with these, and begins anew after a change.
    opened.evaluate("PACE.RAYS = 4; view.ready.then(() => [65, 66].forEach((alpha) => view.set({ alpha })))")
    yield opened
    assert not faults and requests == [file.as_uri()]
    opened.close()


# ---- What the shaders draw is tested by OpenGL: tests/render/test_gl.py. The browser draws the same. ----


PRISMS, IDEAL, *OTHERS = verify_live.SCENES


@pytest.mark.parametrize("scene", some([IDEAL, PRISMS, *OTHERS], 1), ids=lambda scene: f"{scene.name} {scene.sheet}")
def test_the_view_draws_the_same_as_opengl(browser, scene):
    view = View(browser, scene)
    figures = list(verify_live.same([(view, OpenGLView(scene))], (80, 60)))
    view.page.close()
    assert len(figures) == 3 and all(figure.holds for figure in figures), figures


ROOM = Room(
    [
        Window(x=-1.7, alpha=90),
        Window(x=1.7, yaw=25, alpha=60, sheet="detailed", prisms=40, outline="round", frame=False, name="tilted"),
        Piece(x=-1.7, y=-1, z=2),
        Sphere(x=1.7, z=2),
        Text(text="povgen", y=2.1, z=-1, pitch=20),
        Floor(y=-2),
    ],
    eye=Eye(x=1, z=-9, view=6),
)


def test_the_view_shows_a_room_as_opengl_and_its_eye_moves(browser):
    view = View(browser, ROOM)
    view.page.evaluate("povgen.scheduling.PACE.RAYS = 1")  # at rest, in place of 64
    figures = list(verify_live.same([(view, OpenGLView(ROOM))], (48, 36)))
    assert all(figure.holds for figure in figures), figures
    view.page.set_viewport_size({"width": 400, "height": 300})
    view.page.mouse.move(200, 200)
    view.page.mouse.down()
    view.page.mouse.move(100, 150)
    view.page.mouse.up()
    view.page.get_by_label("window1").fill("-30")
    eye, alpha = view.page.evaluate("(({ eye, windows }) => [eye, windows[0].values.alpha])(povgen.main.view.scene)")
    before = ROOM.camera
    step = np.array([-100, 50]) * 6 / 300 @ [before.right, before.up]  # tiles
    assert [eye["x"], eye["y"], eye["z"]] == pytest.approx(before.eye + step) and alpha == -30
    moved = povgen.live(ROOM)
    moved._move({"eye": eye, "other": 1})
    moved._move({"alphas": [alpha, 60]})
    then = moved.scene
    assert then.window[0].alpha == -30 and then.window[1] == ROOM.window[1] and then.object == ROOM.object
    view.page.evaluate("(faces) => povgen.main.view.set({ faces })", max_trace_level(then))
    ours, theirs = OpenGLView(then).readout((48, 36)), view.readout((48, 36))
    assert (abs(ours["ray"] - theirs["ray"]).max(-1) < 1e-4).mean() > 0.999
    for wrong in ({"eye": {"z": 0}}, {"eye": 5}, {"alphas": ["x", 3]}, {"alphas": 3}):
        moved._move(wrong)  # inside a window, or nonsense
        assert moved.scene == then
    view.page.close()


@pytest.mark.release
def test_the_view_shows_pictures_as_opengl(browser, tmp_path):
    path = picture(tmp_path)
    scene = Chess(sheet="ideal", sky=path, floor=path, view=6)
    view = View(browser, scene)
    figures = list(verify_live.same([(view, OpenGLView(scene))], (80, 60)))
    view.page.close()
    assert all(figure.holds for figure in figures), figures


# ---- The page ----


def canvas(page):
    """Return the canvas's pixels, as the user sees them."""
    from io import BytesIO

    from PIL import Image

    with Image.open(BytesIO(page.locator("canvas").screenshot())) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def at_rest(page):
    page.wait_for_function("view.converged() && !view.pending && !view.asked")


def test_the_page_shows_the_scene_and_follows_it(page):
    at_rest(page)
    before = canvas(page)
    shown = page.evaluate("([w, h]) => { const l = light(view, w, h, 4); return [...l.slice(0, 4)]; }", list(SIZE))
    assert before.std() > 30 and shown[3] == 4
    assert not page.evaluate("view.set({ alpha: -66 }), view.converged()")
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
    page = browser.new_page(viewport={"width": 120, "height": 90}, device_scale_factor=2)
    page.goto(file.as_uri())
    page.evaluate(NAMES)
    page.evaluate("PACE.RAYS = 1; view.ready")
    assert page.evaluate("[view.canvas.width, view.canvas.height]") == [240, 180]
    page.set_viewport_size({"width": 100, "height": 80})
    page.wait_for_function("view.canvas.width === 200 && view.canvas.height === 160")
    at_rest(page)
    assert canvas(page).std() > 30
    page.close()


def test_a_slow_picture_gets_fewer_pixels_and_then_all(page):
    """Each frame takes too long: then the next has fewer pixels, and the picture at rest is made of strips."""
    at_rest(page)
    before = canvas(page)
    page.evaluate("PACE.SLOW = PACE.FAST = 0.001")
    scale, row, height = page.evaluate(
        """() => new Promise((done) => {
          const rest = () => {
            const scale = view.scale;
            view.refine = () => {
              delete view.refine;
              view.refine();
              done([scale, view.row, view.canvas.height]);
              view.set({ alpha: 66 });  // while a strip is being drawn
            };
          };
          const move = (n) => {
            view.set({ alpha: n });
            if (n < 166 && view.scale > 0.5) requestAnimationFrame(() => move(n + 0.1));
            else rest();
          };
          move(66.5);
        })"""
    )
    assert scale <= 0.5 and 0 < row < height
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
    next_frame = "(n) => (n ? requestAnimationFrame(() => next(n - 1)) : done(drawn))"
    assert page.evaluate(f"new Promise((done) => {{ const next = {next_frame}; next(9); }})") == 0
    page.evaluate("PACE.RAYS = 1; view.budget = 1e6; view.set({ alpha: 20 })")
    at_rest(page)
    assert page.evaluate("drawn") == 2  # one ray a pixel, and the sum on the canvas


@pytest.mark.release
def test_a_chromium_that_does_not_start(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: "/bin/false")

    def start():
        with chromium():
            pass

    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match="/bin/false does not start: "):
        pool.submit(start).result()  # in a thread of its own: this one may have a browser


def test_the_widget_follows_python_and_python_the_user(browser):
    """The two ends of a widget, with this test in the place of the notebook."""
    seen = povgen.live(Chess(sheet="ideal"), 160, 120)
    page = browser.new_page()
    page.evaluate(
        """async ([code, values]) => {
          window.told = {};
          window.model = {
            get: (name) => values[name], set: (name, value) => (values[name] = value),
            save_changes: () => (told.saved = values.moved), on: (event, action) => (told[event] = action),
          };
          const { default: widget } = await import("data:text/javascript;base64," + btoa(code));
          widget.render({ model, el: document.body });
        }""",
        [seen.widget._esm, {name: getattr(seen.widget, name) for name in ("html", "size", "scene")}],
    )
    page.wait_for_function("frames[0]?.povgen?.main")
    frame = page.frames[1]
    frame.evaluate("povgen.main.view.ready")
    page.mouse.move(80, 60)
    page.mouse.down()
    page.mouse.move(110, 60)
    page.wait_for_function("told.saved")
    seen.widget.moved = page.evaluate("told.saved")
    assert seen.scene.eye == pytest.approx((30 * seen.view / 120, 0))
    page.evaluate("model.set('scene', { eye: [0, 0], piece: 'x' }); told['change:scene']()")
    frame.wait_for_function("povgen.main.view.scene.piece === 'x'")
    assert frame.evaluate("povgen.main.view.scene.eye[0]") > 0  # the pointer still holds the view
    page.mouse.move(80, 110)
    page.wait_for_function("told.saved.eye[1] < -1")
    seen.widget.moved = {"eye": [0, -9]}  # below the floor
    page.evaluate("(scene) => { model.set('scene', scene); told['change:scene'](); }", seen.widget.scene)
    frame.wait_for_function("povgen.main.view.scene.eye[1] === 0")  # though the pointer holds it
    page.mouse.up()
    page.keyboard.press("Shift+ArrowRight")
    page.wait_for_function("told.saved.alpha === 67")
    seen.alpha = 90
    page.evaluate("(scene) => { model.set('scene', scene); told['change:scene'](); }", seen.widget.scene)
    frame.wait_for_function("povgen.main.view.scene.alpha === 90")
    label = frame.get_by_role("application").get_attribute("aria-label")
    assert label.startswith("knight, seen through: infinitely fine sheet.")
    page.close()


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
    wait_for(lambda: abs(canvas(page) - before).max() <= 1)  # a smaller picture comes first


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
    wait_for(lambda: abs(canvas(page) - before).max() <= 1)  # a smaller picture comes first
    assert page.evaluate("view.canvas === document.getElementById('view')")
    page.set_viewport_size({"width": 96, "height": 72})  # the new canvas's size is followed, too
    page.wait_for_function("view.canvas.width === 96 && view.canvas.height === 72")


def without_widget(monkeypatch):
    """Return what a notebook shows of a scene if anywidget is not installed."""
    monkeypatch.setattr(view, "find_spec", lambda _: None)
    return povgen.live(Spheres(sheet="none"), 96, 72)._repr_mimebundle_()["text/html"]


@pytest.mark.release
def test_of_18_views_those_in_sight_hold_a_context(browser, monkeypatch):
    page = browser.new_page(viewport={"width": 160, "height": 200})
    warnings = []
    page.on("console", lambda message: warnings.append(message.text))
    page.set_content(f"<div style='margin-bottom: 150px'>{without_widget(monkeypatch)}</div>" * 18)
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


@pytest.mark.parametrize(
    ("lacks", "said"),
    [
        ("delete window.DecompressionStream", "DecompressionStream"),
        ("HTMLCanvasElement.prototype.getContext = () => null", "needs WebGL 2"),
    ],
)
def test_what_the_browser_lacks_is_said(browser, file, lacks, said):
    page = browser.new_page()
    page.add_init_script(lacks)
    page.goto(file.as_uri())
    page.evaluate(NAMES)
    page.wait_for_function("(said) => document.getElementById('message').textContent.includes(said)", arg=said)
    page.evaluate("view.ready")  # whoever waits for it does not wait for ever
    page.close()


@pytest.mark.release
def test_16_bit_numbers_do_where_32_bit_textures_are_missing(page, browser, file):
    small = {"width": 64, "height": 48}  # many rays, for the sums
    page.set_viewport_size(small)
    page.evaluate("PACE.RAYS = 64; view.again()")
    at_rest(page)
    other = browser.new_page(viewport=small)
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
    assert off.max() <= 6 and off.mean() < 1  # Mesa cuts the sums off, SwiftShader rounds them: 0.8, and less than 0.5
    other.close()


def test_the_page_is_one_small_file(file):
    assert file.stat().st_size < 450_000  # half of it are the mountains
    text, mark, _ = file.read_text("utf-8").rpartition("<!-- povgen record ")
    assert mark and "src=" not in text and "http" not in text.replace("http-equiv", "")


def test_a_notebook_shows_the_view(browser, monkeypatch):
    """Jupyter puts this HTML into its page."""
    page = browser.new_page()
    page.set_content(f"<p>A notebook</p>{without_widget(monkeypatch)}")
    frame = page.frames[1]
    frame.evaluate(NAMES)
    frame.evaluate("PACE.RAYS = 1")
    frame.wait_for_function("view.gl")
    assert frame.evaluate("[view.canvas.width, view.canvas.height]") == [96, 72]
    at_rest(frame)
    assert canvas(frame).std() > 10
    page.close()


def test_only_scenes_are_shown():
    with pytest.raises(InputError, match="scene = 'chess': should be a scene"):
        povgen.live("chess")
