"""The picture of the teaching page: what it shows, what is drawn over it, how it is saved and lost."""

from base64 import b64decode
from io import BytesIO

import numpy as np
import pytest
from conftest import scene_of, some
from PIL import Image
from playwright.sync_api import expect

from demo.conftest import COARSE, WORK, centre, picture, pixels, show
from povgen.optics import apparent
from povgen.page.address import KINDS


def test_it_opens_on_the_ideal_sheet_with_the_whole_piece(page):
    assert page.evaluate("[state.sheet, state.alpha, player.playing, state.scene]") == ["ideal", 66, False, "chess"]
    expect(page.locator("#sentence")).to_have_text(
        "The knight appears turned by 15.0° counter-clockwise, and 1.13 times as large as without the sheets."
    )
    # every point of the piece's predicted image is in the window, and there the picture shows the piece
    piece, predicted = piece_and_prediction(page)
    assert (piece & predicted).sum() > 0.92 * (piece | predicted).sum() > 500
    y, x = np.nonzero(predicted)
    half = 1.5 / 3.7 * 120
    assert max(abs(x - 79.5).max(), abs(y - 59.5).max()) < half


def test_a_piece_is_drawn_when_its_shape_has_been_read(page):
    picture(page, COARSE)
    page.evaluate("window.kept = view.shapes.fields; void (view.shapes.fields = kept.slice(0, 1))")
    show(page, piece="king")
    frames = "(count) => { let n = 0; const tick = () => ++n < count ? requestAnimationFrame(tick) : done(); tick(); }"
    page.evaluate(f"() => new Promise((done) => ({frames})(5))")
    assert page.evaluate("[view.unread, view.stale]") == [page.evaluate("view.shapes.names.indexOf('king')"), True]
    page.evaluate("void (view.shapes.fields = kept)")
    page.wait_for_function("view.converged()")


@pytest.mark.parametrize("name", some([*KINDS], 1))
def test_other_sheets_show_the_piece_where_it_is_predicted(page, name):
    page.get_by_label("Kind of window").select_option(name)
    show(page)
    assert picture(page, COARSE).std() > 10
    piece, predicted = piece_and_prediction(page)
    y, x = np.indices(piece.shape)
    inside = np.maximum(abs(x - 79.5), abs(y - 59.5)) < 1.45 / 3.7 * 120
    assert (piece & predicted & inside).sum() > 0.8 * ((piece | predicted) & inside).sum() > 300


@pytest.mark.parametrize("prisms", some([True, False], 1))
def test_two_windows_show_the_piece_where_it_is_predicted(page, prisms):
    first = {"sheet": "axis", "sheet2": "detailed", "alpha": 10, "axis": [0, 1, 0], "alpha2": 40}
    lens = {"sheet": "lens", "sheet2": "ideal", "focal_length": 4, "alpha2": 60}
    show(page, windows=2, E=[0.2, 0.1], position=True, **first if prisms else lens)
    assert picture(page, COARSE).std() > 10
    scene = scene_of(page)
    place = complex(scene.apparent_position(scene.L, page.evaluate("moment().z1")))
    assert abs(place - scene.L) > 0.1 and abs(centre(page, "#predicted") - place) < 0.02
    piece, predicted = piece_and_prediction(page)
    assert (piece & predicted).sum() > (0.6 if prisms else 0.9) * predicted.sum() > 100
    for text in (page.locator("#sentence").text_content(), page.evaluate("describe(moment())")):
        assert "First window: The sheet" in text and "Second window: " in text


def piece_and_prediction(page):
    """Return where the picture shows the piece, and where its image is predicted, as masks (120, 160)."""
    shown = page.evaluate("[...readout(view, 160, 120).shown].filter((_, k) => k % 4 === 0)")
    piece = np.reshape(shown, (120, 160))[::-1] == 2 + page.evaluate("moment().windows.length")
    inside = page.evaluate(
        """() => {
          const scale = stage.clientHeight / 120;
          return Array.from({ length: 120 * 160 }, (_, k) =>
            $("image").isPointInFill(new DOMPoint((k % 160 - 79.5) * scale, (Math.floor(k / 160) - 59.5) * scale)));
        }"""
    )
    return piece, np.reshape(inside, (120, 160))


def test_a_pupil_blurs_what_has_no_image(page):
    """In best focus the piece is sharp at 180 degrees, and blurred at 90."""
    page.evaluate("PACE.RAYS = 32")
    for alpha, blurred in ((180, False), (90, True)):
        show(page, alpha=alpha, z1=3, pupil=0)
        piece = np.kron(piece_and_prediction(page)[0], np.ones((4, 4), bool))
        edges = [sharpness(page, piece), sharpness(page, piece, pupil=0.4)]
        assert (edges[1] < 0.6 * edges[0]) if blurred else (edges[1] > 0.85 * edges[0]), (alpha, edges)


def sharpness(page, piece, **values):
    """Return the RMS difference of neighbouring pixels within the piece."""
    show(page, **values)
    shown = Image.fromarray(picture(page, COARSE).astype(np.uint8)).convert("L").resize((640, 480))
    steps = np.diff(np.asarray(shown).astype(float), axis=1)
    return np.sqrt((steps[piece[:, 1:]] ** 2).mean())


def test_switches_draw_on_the_picture(page):
    show(page, sheet="none", scene="spheres")
    page.evaluate("$('hint').hidden = true")
    plain = picture(page, COARSE)
    for name, colour in (("position", (255, 231, 74)), ("caption", (255, 255, 255))):
        page.locator(f"#show-{name}").check()
        page.evaluate("draw()")
        drawn = picture(page, COARSE)
        assert ((abs(drawn - colour).max(-1) < 30) & (abs(plain - colour).max(-1) > 60)).sum() > 20, name
        page.locator(f"#show-{name}").uncheck()
        page.evaluate("draw()")
        assert abs(picture(page, COARSE) - plain).max() < 20
    show(page, scene="chess", sheet="ideal")
    for name, selector in (("circles", "path.of-alpha:not(.aid, .halo)"), ("image", "path.image:not(.hidden)")):
        expect(page.locator(f"#overlay {selector}")).to_have_count(0)
        page.locator(f"#show-{name}").check()
        expect(page.locator(f"#overlay {selector}")).to_have_count(1)
    page.locator("#show-position").check()
    page.set_viewport_size({"width": 1280, "height": 720})
    page.evaluate("draw()")
    stage = page.locator("#stage").bounding_box()
    entries = [entry.bounding_box() for entry in page.locator("#overlay .entry").all()]
    assert len(entries) == 6 and entries[0]["x"] > stage["x"]
    assert entries[5]["x"] + entries[5]["width"] < stage["x"] + stage["width"]
    # the key is above the window's frame, whose outer half is 1.65 tiles, and whose front is 0.15 tiles nearer
    above = stage["height"] / 2 - 1.65 * 6 / 5.85 * page.evaluate("tilePixels()")
    assert max(entry["y"] + entry["height"] for entry in entries) < stage["y"] + above


def test_the_predicted_position_is_marked(page):
    page.locator("#show-position").check()
    for values in (
        {},
        {"alpha": 150, "z1": 3, "E": [0.2, 0.1]},
        {"sheet": "detailed", "alpha": -60},
        {"scene": "spheres", "sheet": "ideal"},
    ):
        show(page, **values)
        scene = scene_of(page)
        wanted = complex(scene.apparent_position(scene.L, page.evaluate("moment().z1")))
        assert abs(centre(page, "#predicted") - wanted) < 0.01
    expect(page.locator("#overlay .mark:not(.halo):not(.chosen)")).to_have_count(
        page.evaluate("moment().objects.length") - 1
    )


def test_paths_are_parted_at_infinity(page):
    """Paths are interrupted at infinity. Every other point of a path is close to a predicted position."""
    for prisms, offset, kind in ((20, 0.1 + 0.05j, "q-z1"), (300, 0.004 + 0.003j, "q-z1"), (20, 0.1 + 0.05j, "of-r")):
        show(page, sheet="detailed", prisms=prisms, alpha=180, z1=3, circles=True, L=[offset.real, offset.imag])
        scene = scene_of(page)
        text = page.locator(f"#overlay path.{kind}:not(.halo)").get_attribute("d")
        tile = page.evaluate("tilePixels()")
        lines = [np.array([part.split() for part in line.split("L")], float) for line in text.split("M")[1:]]
        steps = np.geomspace(1e-7, 1, 30_000)
        alpha, z1 = np.pi, scene.z2 * np.exp(np.concatenate((-8 * steps, 8 * steps)))
        poles = apparent.infinite_z1(scene.elements)
        z1 = np.concatenate((z1, *(pole + s * steps for pole in poles for s in (-1, 1))))
        if kind == "of-r":
            z1 = scene.z1
            poles = np.append(apparent.infinite_alpha(z1, scene.z2, scene.prism).real, np.pi)
            alpha = np.concatenate([s * pole + t * 3 * steps for pole in poles for s in (-1, 1) for t in (-1, 1)])
            alpha = np.append(alpha, np.linspace(-np.pi, np.pi, 30_000))
        true = scene.apparent_position(scene.L, z1, np.degrees(alpha))
        true = np.unique(np.round(200 * true[abs(true) < 3]) / 200)
        for line in lines:
            x, y = line.T / tile
            part = np.linspace(0, 1, 5)[:, None]
            drawn = (x - 1j * y)[:-1] * (1 - part) + (x - 1j * y)[1:] * part
            for place in drawn[abs(drawn) < 2.4][::7]:
                assert abs(true - place).min() < 0.02


def test_the_picture_can_be_saved_with_its_numbers(page):
    show(page, sheet="none", z1=3)
    page.evaluate("choose('en', true)")
    shown = picture(page)
    page.evaluate("() => { let ms = 0; performance.now = () => (ms += 3000); }")  # slow: two rays a pixel
    with page.expect_download() as download:
        page.evaluate("$('save').click()")
    page.evaluate("delete performance.now")
    name = download.value.suggested_filename
    assert "sheet=none" in name and "z1=3" in name and "language" not in name
    page.evaluate("choose('en')")
    saved = pixels(download.value.path().read_bytes())
    height, width = saved.shape[:2]
    assert width >= 1600
    canvas = page.evaluate("[view.canvas.width, view.canvas.height]")
    assert width / height == pytest.approx(canvas[0] / canvas[1], rel=1e-3)
    small = np.asarray(Image.fromarray(saved.astype(np.uint8)).resize(shown.shape[1::-1])).astype(int)
    half = slice(len(small) // 2)
    assert abs(small[half] - shown[half]).mean() < 10  # the same picture, but for a fraction of a pixel
    assert (saved[-height // 20 :].min(-1) > 250).sum() > 50  # with a white caption
    assert page.evaluate("state.caption") is False


def test_without_webgl_the_page_says_so(browser, demo_file):
    page = browser.new_page(viewport=WORK)
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(demo_file.as_uri())
    expect(page.locator("#message")).to_contain_text("needs WebGL 2")
    expect(page.locator("#hint")).to_be_hidden()
    expect(page.locator("#value-nu")).to_have_text("15.0°")  # the rest of the page works
    page.get_by_label("Language").select_option("de")
    expect(page.locator("#message")).to_contain_text("braucht WebGL 2")
    page.get_by_role("button", name="Mehr").click()
    for name, seen in {"save": False, "room-open": False, "show-depth": False, "copy-link": True}.items():
        expect(page.locator(f"#{name}")).to_be_visible(visible=seen)
    page.close()


def test_red_and_cyan_glasses_show_depth(page):
    """Red is what the left eye sees, green and blue what the right eye sees."""
    show(page, alpha=180, E=[-0.15, 0])
    left = picture(page, COARSE)
    show(page, E=[0.15, 0])
    right = picture(page, COARSE)
    show(page, E=[0, 0], depth=True)
    both = picture(page, COARSE)
    assert np.abs(both[..., 0] - left[..., 0]).mean() < 3 and np.abs(both[..., 1:] - right[..., 1:]).mean() < 3
    assert np.abs(left - right).mean() > 6
    show(page, depth=False)
    assert page.evaluate("view.scene.eyes") == 0
    # who puts on glasses at a question keeps them
    assert page.evaluate("openQuestion(0), change({ depth: true }), openQuestion(1), openQuestion(-1), state.depth")


HEADSET = """async (apart) => {
  const { canvas, gl, scene: { z2, view: height } } = view, width = (height * canvas.width) / canvas.height, drawn = [];
  const matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  const eyes = [-1, 1].map((side, k) => ({
    transform: { matrix, position: { x: (side * apart) / 2 / (0.3 / 0.063), y: 0, z: 0 } },
    projectionMatrix: [
      (2 * z2) / width, 0, 0, 0, 0, (2 * z2) / height, 0, 0, (-side * apart) / width, 0, -1, -1, 0, 0, 0, 0,
    ],
    viewport: { x: k * (canvas.width >> 1), y: 0, width: canvas.width >> 1, height: canvas.height },
  }));
  const session = {
    updateRenderState() {},
    requestReferenceSpace: async () => "local",
    requestAnimationFrame: (draw) => drawn.push(draw),
    addEventListener: (_, end) => (session.end = end),
  };
  window.XRWebGLLayer = class { framebuffer = null; getViewport = ({ viewport }) => viewport; };
  gl.makeXRCompatible = async () => {};
  navigator.xr.requestSession = async () => session;
  $("headset").click();
  while (!drawn.length) await new Promise((done) => setTimeout(done));
  drawn[0](0, { getViewerPose: () => ({ views: eyes }) });
  const shown = canvas.toDataURL();
  session.end();
  return shown;
}"""


def test_in_a_headset_each_eye_sees_a_picture_of_its_own(page):
    """A session of WebXR that the test plays: its eyes see the picture's rectangle, side by side on the canvas."""
    eyes = []
    for x in (-0.15, 0.15, 0):
        show(page, alpha=180, E=[x, 0])
        picture(page, COARSE)
        eyes.append(decoded(page.evaluate("view.context.repaint(), view.canvas.toDataURL()")))
    shown = decoded(page.evaluate(HEADSET, 0.3))
    middle, away = shown.shape[1] // 2, [[], []]
    for k, half in enumerate((shown[:, :middle], shown[:, middle : 2 * middle])):
        away[k] = [np.abs(blurred(half) - blurred(eye)).mean() for eye in eyes[:2]]
    assert max(away[0][0], away[1][1]) < min(away[0][1], away[1][0]) / 3, away
    picture(page, COARSE)
    again = decoded(page.evaluate("view.context.repaint(), view.canvas.toDataURL()"))
    assert np.abs(again - eyes[2]).mean() < 1  # the page draws again
    page.evaluate(
        """() => {
          view.gl.makeXRCompatible = async () => { throw Error("no graphics"); };
          navigator.xr.requestSession = async () => ({ end: () => (window.ended = true) });
          $("headset").click();
        }"""
    )
    page.wait_for_function("window.ended")  # a session that cannot be drawn is not left open
    expect(page.locator("#copied")).to_have_text("The headset does not start: no graphics")


def decoded(url):
    return np.asarray(Image.open(BytesIO(b64decode(url.split(",")[1]))).convert("RGB")).astype(int)


def blurred(pixels):
    return np.asarray(Image.fromarray(pixels.astype(np.uint8)).resize((24, 18), Image.Resampling.BOX)).astype(int)


def test_another_size_shows_the_picture_until_it_is_drawn_anew(page):
    """A shader may have to be made first."""
    picture(page, COARSE)
    shown = page.evaluate(
        """() => {
          view.again = () => {};
          view.canvas.style.width = "40%";
          view.resize();
          const pen = document.createElement("canvas").getContext("2d");
          pen.drawImage(view.canvas, 0, 0, 1, 1);
          delete view.again;
          view.canvas.style.width = "";
          view.resize();
          return [...pen.getImageData(0, 0, 1, 1).data];
        }"""
    )
    assert min(shown) > 30


def test_a_curtain_shows_two_settings(page):
    """To its left, the picture is that of the ideal sheet; to its right, that without sheets. Keys move it."""
    show(page, sheet="none")
    bare = picture(page)
    show(page, sheet="ideal")
    ideal = picture(page)
    page.get_by_label("compare with").select_option("no sheet")
    page.evaluate("draw()")
    page.wait_for_function("otherView().gl && otherView().converged()")
    both = picture(page)
    height, width, _ = both.shape
    rows = slice(height // 3, 2 * height // 3)
    left, right = slice(width // 4, width // 2 - 8), slice(width // 2 + 8, 3 * width // 4)
    assert np.abs(both[rows, left] - ideal[rows, left]).mean() < 3 < np.abs(ideal[rows, left] - bare[rows, left]).mean()
    assert np.abs(both[rows, right] - bare[rows, right]).mean() < 3
    assert page.locator("#curtain-names span").all_text_contents() == ["ideal sheet", "no sheet"]
    page.locator("#curtain").press("ArrowLeft")
    assert page.evaluate("session.curtain") == 0.49
    # hidden and shown again, it need not make its shaders anew
    page.evaluate("void (window.held = otherView().context)")
    for compare in ("off", "none"):
        show(page, compare=compare)
        page.wait_for_function("(seen) => otherView().inSight === seen", arg=compare != "off")
        assert page.evaluate("otherView().context === held && !held.gl.isContextLost()")
