"""The teaching page in a real Chromium, drawn without a GPU. Where WebGL 2 does not work, these tests fail."""

import re
from io import BytesIO

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from conftest import (
    BEYOND,
    COARSE,
    PROJECT,
    SHARP,
    WORK,
    opened,
    povgen,
    refused,
    scene_of,
    show,
)
from PIL import Image
from playwright.sync_api import expect

from povgen import InputError, Spheres, live
from povgen.liveview import page as teaching
from povgen.liveview.page import KINDS, demo
from povgen.optics import paraxial, rotation

pytestmark = [pytest.mark.xdist_group("demo"), pytest.mark.timeout(600)]
SIZES = {"laptop": (1280, 720), "phone": (390, 844), "phone sideways": (844, 390), "projector": (1920, 1080)}


def numbers(page):
    """Return the numbers that the page shows."""
    page.evaluate("draw()")
    texts = {name: page.locator(f"#value-{name}").text_content() for name in ("r", "P", "nu", "M")}
    return {name: number(text) for name, text in texts.items()}


def number(text):
    """Return the real or complex number that the page shows as text."""
    text = text.replace("−", "-").strip("° ").replace("∞", "inf").replace("undefined", "nan")
    text = re.sub(
        r" × 10([⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)", lambda m: "e" + m[1].translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")), text
    )
    return complex(text.replace(" ", "").replace("i", "j")) if "i" in text.removeprefix("inf") else float(text)


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


def pixels(png):
    with Image.open(BytesIO(png)) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def picture(page, display=SHARP):
    """Return the stage's pixels, when the picture has been drawn."""
    page.evaluate(display)
    page.wait_for_function("view.converged()")
    return pixels(page.locator("#stage").screenshot())


# ---- The equations ----

NOT_A_NUMBER = r"NaN|Infinity|null|undefined(?!<| at E)|\[object"


@pytest.mark.parametrize("values", BEYOND, ids=lambda values: values["sheet"])
def test_no_number_is_missing_beyond_the_paper(page, values):
    show(page, **values)
    assert not re.search(NOT_A_NUMBER, page.evaluate("document.querySelector('main').outerHTML"))


def test_light_that_passes_nowhere_is_said(page):
    show(page, sheet="axis", alpha=180)
    expect(page.locator("#sentence")).to_contain_text("No light passes: the window is black.")
    expect(page.locator("#value-P")).to_have_text("–")


def test_light_beside_the_second_window_is_said(page):
    """There the prediction does not hold: povgen's own scene says that the light does not pass."""
    for x, passes in ((0.3, True), (2.2, False)):
        show(page, windows=2, alpha=0, alpha2=0, d=2, image=True, position=True, L=[x, -0.85])
        scene = scene_of(page)
        assert scene.visible(scene.L, 2) == passes and abs(page.evaluate("moment().place[0]")) < 1.5
        said = "passes beside the second window" in page.locator("#sentence").text_content()
        assert said == page.locator("#image.hidden").count() == page.locator(".mark.unsure:not(.halo)").count()


def test_the_pole_of_two_windows_is_said(page):
    show(page, windows=2, alpha=120, alpha2=120, d=2, z1=2, z2=2, caption=True)
    expect(page.locator("#sentence")).to_contain_text("The pole: one point of the knight fills the whole window")
    expect(page.locator("#value-P")).to_have_text("∞")
    expect(page.locator(".caption")).to_contain_text("M = ∞")
    show(page, z2=2.1)
    expect(page.locator("#sentence")).to_contain_text("Near the pole")
    expect(page.locator("#overlay .say").first).to_contain_text("tiles of the knight fill the window")


def test_the_equations_of_two_windows_of_prisms_are_given_too(page):
    show(page, windows=2, sheet="detailed", prisms=40, alpha=120, alpha2=120, d=2, z2=8)
    expect(page.locator("#value-nu")).to_have_text("−1.6°")
    expect(page.locator("#about-nu")).to_have_text("for 40 prisms; the equation gives 0.0°")
    expect(page.locator("#about-M")).to_have_text("for 40 prisms; the equation gives 1.333")
    expect(page.locator("#of-prisms")).to_have_text(
        "Z, the image and the diagram are for ideal sheets.", use_inner_text=True
    )


def test_a_question_about_an_image_does_not_give_its_answer(page):
    page.evaluate("openQuestion(9)")
    page.evaluate("draw()")
    expect(page.locator("#sentence")).not_to_contain_text("image")
    page.evaluate("reveal()")
    expect(page.locator("#sentence")).to_contain_text("the image is 2 tiles in front")


def test_an_axis_is_typed(page):
    """The field holds 0 on the way to 0.5. Then the axis is not lost."""
    show(page, sheet="axis", alpha=20, axis=[0, 0, 1])
    expect(page.locator("#sentence")).to_contain_text("That is the paper’s window")
    page.locator("#number-axisz").press_sequentially("0.5")
    page.locator("#number-axisz").fill("")
    page.locator("#number-axisz").press_sequentially("0.5")
    assert page.evaluate("state.axis") == [0, 0, 0.5]
    show(page, axis=[0, 0, 0])
    assert page.evaluate("state.axis") == [0, 0, 0.5]
    expect(page.locator("#sentence")).to_contain_text("a = (0, 0, 0) has no direction: it stays as it was.")


def test_what_is_beyond_the_paper_is_chosen(page):
    """Each choice shows its own controls, and what the sheet does."""
    choose = page.get_by_label("Beyond the paper’s window")
    names = {each.name for kind in KINDS.values() for each in kind.parameters}
    assert choose.locator("option").count() == 2 + len(KINDS)
    for name, kind in KINDS.items():
        choose.select_option(label=kind.choice)
        assert page.evaluate("state.sheet") == name
        own = {each.name: each for each in kind.parameters}
        for each in names:
            places = page.locator(f"#slider-{each}, #number-{each}, #number-{each}x, #number-{each}y, #number-{each}z")
            assert places.count() >= 2
            for place in places.all():
                expect(place).to_be_visible(visible=each in own)
        for each in own.values():
            row = page.locator(f"[data-quantity={each.name}]")
            expect(row).to_contain_text(each.symbol)
            expect(row).to_contain_text(each.label or each.about)
        expect(page.locator("#sentence")).to_contain_text(kind.sentence.partition("{")[0])
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
    page.get_by_role("radio", name="ideal sheet").check(force=True)
    expect(choose).to_have_value("none")


def test_the_complex_depth_is_drawn_to_scale(page):
    show(page, windows=2, alpha=90, alpha2=0, d=2, z1=3, z2=4, diagram="paper")
    z2, d, z1 = page.evaluate(
        """["z2", "d", "z1"].map((name) => document.querySelector(`#diagram line.q-${name}`))
           .map((line) => ["x1", "y1", "x2", "y2"].map((name) => Number(line.getAttribute(name))))"""
    )
    assert d[:2] == pytest.approx([z2[0] + (z1[1] - d[1]) * 2, z2[1]], abs=0.1)  # z2 = 2 d, along the real axis
    assert d[2] == pytest.approx(d[0], abs=0.1) and z1[0] == pytest.approx(d[0], abs=0.1)  # both downwards


def test_numbers_are_those_of_the_scene(page):
    """What the page shows is what Python computes for the same scene, in the corners as well."""
    cases = [
        {},
        {"sheet": "detailed", "alpha": -120, "z1": 3.3, "E": [0.3, 0.4]},
        {"sheet": "detailed", "prisms": 20, "alpha": 170, "z1": 5},
        {"sheet": "detailed", "prisms": 1},
        {"alpha": 180, "z1": 6},
        {"alpha": 360, "z1": 5000, "z2": 150},
        {"alpha": -33, "z1": 0.001, "z2": 0.001, "piece": "king"},
        {"sheet": "none", "E": [-10, 10], "L": [10, 8]},
        {"scene": "spheres", "alpha": 90, "z1": 24},
        {"scene": "spheres", "sheet": "detailed", "alpha": 140, "prisms": 30, "L": [0.5, -0.7]},
    ]
    for values in cases:
        page.evaluate("fromHash('')")
        show(page, **values)
        scene, found = scene_of(page), numbers(page)
        z1 = page.evaluate("moment().z1")
        assert z1 in [pytest.approx(each) for each in scene.distances]
        alpha = 0 if scene.sheet == "none" else np.radians(scene.alpha)
        r = scene.z2 / z1
        assert found["r"] == pytest.approx(r, rel=5e-4)
        wanted = complex(rotation.P(r, alpha))
        assert found["P"] == wanted if np.isinf(wanted) else abs(found["P"] - wanted) <= 1e-3 * max(1, abs(wanted))
        nu, M = (0, rotation.M(r, 0)) if scene.sheet == "none" else scene.nu_and_M(z1)
        if np.isnan(nu):
            assert np.isnan(found["nu"])
        else:
            assert (found["nu"] - nu + 180) % 360 - 180 == pytest.approx(0, abs=0.051)
        assert found["M"] == pytest.approx(M, rel=5.1e-4)
        place = complex(scene.apparent_position(scene.L, z1))
        assert np.isinf(place) or complex(*page.evaluate("moment().place")) == pytest.approx(place, rel=1e-9, abs=1e-12)
        text = page.evaluate("document.querySelector('main').outerHTML")
        assert not re.search(NOT_A_NUMBER, text), values


# ---- The picture ----


def test_it_opens_on_the_ideal_sheet_with_the_whole_piece(page):
    assert page.evaluate("[state.sheet, state.alpha, player.playing, state.scene]") == ["ideal", 66, False, "chess"]
    expect(page.locator("#sentence")).to_have_text(
        "The knight appears turned by 15.0° counter-clockwise, and 0.851 times as large as if it stood in the window."
    )
    # every point of the piece's predicted image is in the window, and there the picture shows the piece
    piece, predicted = piece_and_prediction(page)
    assert (piece & predicted).sum() > 0.92 * (piece | predicted).sum() > 500
    y, x = np.nonzero(predicted)
    half = 1.5 / 3.7 * 120
    assert max(abs(x - 79.5).max(), abs(y - 59.5).max()) < half


@pytest.mark.parametrize("name", KINDS)
def test_other_sheets_show_the_piece_where_it_is_predicted(page, name):
    page.get_by_label("Beyond the paper’s window").select_option(name)
    show(page)
    piece, predicted = piece_and_prediction(page)
    y, x = np.indices(piece.shape)
    inside = np.maximum(abs(x - 79.5), abs(y - 59.5)) < 1.45 / 3.7 * 120
    assert (piece & predicted & inside).sum() > 0.8 * ((piece | predicted) & inside).sum() > 300


def piece_and_prediction(page):
    """Return where the picture shows the piece, and where its image is predicted, as masks (120, 160)."""
    shown = page.evaluate("[...readout(view, 160, 120).shown].filter((_, k) => k % 4 === 0)")
    piece = np.reshape(shown, (120, 160))[::-1] == 3  # OBJECT in objects.glsl
    inside = page.evaluate(
        """() => {
          const scale = stage.clientHeight / 120;
          return Array.from({ length: 120 * 160 }, (_, k) =>
            $("image").isPointInFill(new DOMPoint((k % 160 - 79.5) * scale, (Math.floor(k / 160) - 59.5) * scale)));
        }"""
    )
    return piece, np.reshape(inside, (120, 160))


def test_sliders_of_other_sheets(page):
    """A focal length has both signs, and a lens is weak in the middle of the slider. An angle is linear."""
    choose = page.get_by_label("Beyond the paper’s window")
    choose.select_option("glens")
    slider, ends = page.locator("#slider-focal_length"), []
    for place in (-1000, -1, 0, 1, 500, 1000):
        slider.fill(str(place))
        ends.append(page.evaluate("state.focal_length"))
        expect(page.locator("#number-focal_length")).to_have_value(f"{ends[-1]:.4g}")
    assert ends == pytest.approx([-0.1, -100, 100, 100, 10**0.5, 0.1], rel=0.01)
    show(page, focal_length=-2)
    assert float(slider.input_value()) == pytest.approx(-1000 * np.log(50) / np.log(1000))
    expect(slider).to_have_attribute("aria-valuetext", "−2.000 tiles")
    expect(page.locator("#scrub-value")).to_have_text("z₁ = 2")  # no alpha: the other movie
    choose.select_option("twist")
    page.locator("#slider-twist").fill("-45")
    assert page.evaluate("state.twist") == -45
    expect(page.locator("#slider-twist")).to_have_attribute("aria-valuetext", "−45.0°/tile")
    expect(page.locator("#scrub-value")).to_have_text("α = 0.0°")


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
        poles = paraxial.infinite_z1(scene.z2, alpha, scene.prism).real
        z1 = np.concatenate((z1, *(pole + s * steps for pole in poles for s in (-1, 1))))
        if kind == "of-r":
            z1 = scene.z1
            poles = np.append(paraxial.infinite_alpha(z1, scene.z2, scene.prism).real, np.pi)
            alpha = np.concatenate([s * pole + t * 3 * steps for pole in poles for s in (-1, 1) for t in (-1, 1)])
            alpha = np.append(alpha, np.linspace(-np.pi, np.pi, 30_000))
        true = paraxial.apparent_position(scene.L, scene.E, z1, scene.z2, alpha, scene.prism)
        true = np.unique(np.round(200 * true[abs(true) < 3]) / 200)
        for line in lines:
            x, y = line.T / tile
            part = np.linspace(0, 1, 5)[:, None]
            drawn = (x - 1j * y)[:-1] * (1 - part) + (x - 1j * y)[1:] * part
            for place in drawn[abs(drawn) < 2.4][::7]:
                assert abs(true - place).min() < 0.02


def test_the_picture_can_be_saved_with_its_numbers(page):
    show(page, sheet="none", z1=3)
    page.evaluate(SHARP)
    page.wait_for_function("view.converged()")
    with page.expect_download() as download:
        page.locator("#save").click()
    assert "sheet=none" in download.value.suggested_filename and "z1=3" in download.value.suggested_filename
    saved = pixels(download.value.path().read_bytes())
    canvas = page.evaluate("[view.canvas.height, view.canvas.width]")
    assert list(saved.shape[:2]) == canvas
    shown = picture(page)
    height = canvas[0]
    half = (slice(height // 2), slice(canvas[1]))
    assert abs(saved[half] - shown[half]).mean() < 10  # the same picture, but for a fraction of a pixel
    assert (saved[-height // 20 :].min(-1) > 250).sum() > 50  # with a white caption
    assert page.evaluate("state.caption") is False


def test_a_lost_context_is_said_and_comes_back(page):
    show(page, sheet="none")
    before = picture(page)
    page.evaluate("window.loss = view.gl.getExtension('WEBGL_lose_context'); loss.loseContext()")
    expect(page.locator("#message")).to_contain_text("starts again")
    show(page, alpha=90)  # does nothing, and fails not
    page.evaluate("loss.restoreContext()")
    expect(page.locator("#message")).to_be_hidden()
    assert abs(picture(page) - before).max() <= 2


def test_without_webgl_the_page_says_so(browser, demo_file):
    page = browser.new_page(viewport=WORK)
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(demo_file.as_uri())
    expect(page.locator("#message")).to_contain_text("needs WebGL 2")
    expect(page.locator("#hint")).to_be_hidden()
    expect(page.locator("#value-nu")).to_have_text("15.0°")  # the rest of the page works
    page.close()


# ---- Sliders, numbers, dragging ----


def test_numbers_are_typed_and_sliders_moved(page):
    page.get_by_label("the light is turned by").last.fill("90")
    assert numbers(page)["nu"] == pytest.approx(np.degrees(rotation.nu(3, np.pi / 2)), abs=0.051)
    assert page.evaluate("$('slider-alpha').value") == "90"
    for name, typed, kept in (
        ("z1", "1e9", 5000),
        ("z2", "-3", 0.161),
        ("prisms", "400.2", 400),
        ("alpha", "-400", -360),
    ):
        page.locator("#sheet input[value=detailed]").check()
        field = page.locator(f"#number-{name}")
        field.fill(typed)
        field.blur()
        page.evaluate("draw()")
        scene_of(page)  # povgen allows it
        assert float(field.input_value()) == pytest.approx(kept, rel=0.2 if name == "z2" else 1e-9)
    page.locator("#slider-z2").focus()
    before = page.evaluate("moment().z2")
    page.keyboard.press("End")
    page.evaluate("draw()")
    assert page.evaluate("state.z2") == 150 != before
    show(page, z2=6)
    for field, value in (("Lx", 0.5), ("Ly", -0.4), ("Ex", -0.3), ("Ey", 0.2)):
        page.locator(f"#number-{field}").fill(str(value))
    assert page.evaluate("[...state.L, ...state.E]") == [0.5, -0.4, -0.3, 0.2]
    page.locator("#number-alpha").fill("")  # while someone types
    assert page.evaluate("state.alpha") == -360


def test_what_is_changed_is_said(page):
    show(page, sheet="detailed")
    for name, typed, value, said in (
        ("alpha", "400", 360, "α is at most 360°."),
        ("z1", "0.1", 0.1, "z₁ is at least 0.581: the piece would touch the frame."),
        ("z1", "2,5", 2.5, ""),
        ("prisms", "10.4", 10, "N is a whole number."),
        ("alpha", "12 or so", 360, "“12 or so” is not a number."),
        ("Ex", "−0,3", -0.3, ""),
        ("Ey", "-5", None, "y of E is at least −1.6: the floor is below."),
    ):
        field = page.locator(f"#number-{name}")
        field.fill(typed)
        field.blur()
        page.evaluate("draw()")
        text = page.locator("#sentence").text_content()
        assert said in text if said else not re.search("at least|at most|number", text), text
        if value is not None:
            assert page.evaluate("({ ...state, Ex: state.E[0] })")[name] == value
    page.locator("#number-alpha").press("ArrowDown")
    assert page.evaluate("state.alpha") == 359


def test_arrow_keys_choose_the_next_sphere(page):
    show(page, scene="spheres")
    distances = sorted(page.evaluate("moment().objects"))
    before = distances.index(page.evaluate("moment().z1"))
    page.locator("#slider-z1").focus()
    for key, aside in (("ArrowLeft", -1), ("ArrowRight", 0), ("ArrowUp", 1)):
        page.keyboard.press(key)
        assert page.evaluate("moment().z1") == distances[before + aside]
    page.locator("#number-z1").fill("1e4")
    page.evaluate("draw()")
    expect(page.locator("#sentence")).to_contain_text("No sphere is at z₁")


def test_few_large_prisms_push_eye_and_object_away(page):
    show(page, sheet="detailed", prisms=1)
    scene = scene_of(page)
    assert scene.z2 > scene.depth / 2 > 10 and scene.z1 > scene.depth / 2
    for reason in ("z₁ is at least", "z₂ is at least"):
        expect(page.locator("#sentence")).to_contain_text(reason)
    show(page, prisms=100)
    assert page.evaluate("[moment().z1, moment().z2]") == [2, 6]
    expect(page.locator("#about-nu")).to_have_text("for 100 prisms; the equation gives 15.0°")


@pytest.mark.parametrize("sheet", ["none", "single", "ideal", "detailed", *sorted({*KINDS} - {"axis", "twist"})])
def test_the_image_follows_the_pointer(page, sheet):
    show(page, sheet=sheet, alpha=120)
    start, step = centre(page, "#object-picture"), 0.4 + 0.2j
    drag(page, start, step)
    assert centre(page, "#object-picture") == pytest.approx(start + step, abs=0.02)
    assert page.evaluate("state.E") == [0, 0]
    scene = scene_of(page)  # the pedestal is higher or lower
    assert complex(scene.apparent_position(scene.L, scene.z1)) == pytest.approx(start + step, abs=0.02)
    expect(page.locator("#hint")).to_be_hidden()


def test_the_piece_itself_is_dragged_and_beside_it_the_eye(page):
    head = centre(page, "#object-picture") + 0.8j * np.exp(1j * np.radians(15))
    drag(page, head, 0.3)
    assert page.evaluate("state.E") == [0, 0] != page.evaluate("state.L[0]")
    drag(page, -1.4 + 1.2j, 0.5 - 0.1j)
    assert complex(*page.evaluate("state.E")) == pytest.approx(0.5 - 0.1j, abs=0.02)


def test_parallax(page):
    """At alpha = 180 degrees the image moves against the eye, more than the window: it floats before the window."""
    show(page, alpha=180, image=True)
    before = centre(page, "#object-picture")
    assert "floats 2 tiles in front of the window" in page.locator("#sentence").text_content()
    drag(page, -1.4 + 1.2j, 0.5)
    moved = centre(page, "#object-picture") - before
    assert moved == pytest.approx(-0.25, abs=0.02)


def test_spheres_are_chosen_by_dragging(page):
    show(page, scene="spheres", alpha=120)
    scene = scene_of(page)
    z1 = scene.distances[4]
    start = complex(scene.apparent_position(scene.L, z1))
    drag(page, start, 0.2j)
    assert page.evaluate("moment().z1") == z1
    scene = scene_of(page)
    assert complex(scene.apparent_position(scene.L, z1)) == pytest.approx(start + 0.2j, abs=0.02)


def test_the_diagram_can_be_dragged_and_turned(page):
    for name, handle in (("L", "#object-diagram"), ("E", "#eye-diagram")):
        page.evaluate("draw()")
        tile = page.evaluate("session.diagramMap.tile")
        spot, box = bounds(page, handle, "#diagram-box")
        x, y = spot["x"] + spot["width"] / 2, spot["y"] + spot["height"] / 2
        start = complex(x - box["x"] - box["width"] / 2, box["y"] + box["height"] / 2 - y) / tile
        before = complex(*page.evaluate(f"state.{name}"))
        drag(page, start, 0.15 + 0.1j, "#diagram-box", tile)
        assert complex(*page.evaluate(f"state.{name}")) == pytest.approx(before + 0.15 + 0.1j, abs=0.02)
    places = """() => { draw(); return ["L", "E", "P"].map((name) => {
      const dot = document.querySelector(`#diagram .dot.q-${name}`);
      return [dot.cx.baseVal.value, -dot.cy.baseVal.value];
    }); }"""
    P = rotation.P(3, np.radians(66))
    for turned in ("picture", "paper"):
        page.locator(f"#orientation input[value={turned}]").check(force=True)
        L, E, seen = (complex(*place) for place in page.evaluate(places))
        assert (seen - L) / (E - L) == pytest.approx(P, abs=0.01)
        direction = complex(*page.evaluate("minus(state.E, state.L)")) if turned == "picture" else 1
        assert np.angle((E - L) / direction) == pytest.approx(0, abs=1e-6)
    expect(page.locator("#eye-diagram")).to_be_hidden()


def test_arrow_keys_move_eye_and_object(page):
    page.locator("#eye-picture").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowUp")
    page.locator("#object-diagram").focus()
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("[...state.E, state.L[0]]") == pytest.approx([0.05, 0.25, -0.05])
    page.evaluate("draw()")
    expect(page.locator("#eye-picture")).to_have_attribute(
        "aria-label", "Eye E at 0.05, 0.25 tiles: arrow keys move it"
    )


# ---- Movies ----


def test_presets_play_loop_stop_and_scrub(page):
    page.evaluate("PACE.RAYS = 0")
    show(page, sheet="none")
    page.get_by_role("button", name="vary z₁").click()
    assert page.evaluate("[state.sheet, state.alpha, player.playing]") == ["ideal", 90, True]
    page.wait_for_function("state.z1 > 0.7")
    page.get_by_role("button", name="Pause").click()
    z1 = page.evaluate("state.z1")
    assert 0.6 < z1 < 60
    page.locator("#scrub").fill("500")
    assert page.evaluate("state.z1") == pytest.approx(6)  # midway between 0.6 and 60 by ratio
    page.evaluate("draw()")
    expect(page.locator("#scrub-value")).to_have_text("z₁ = 6")
    page.locator("#scrub").fill("501.3")  # any value, not steps
    assert page.evaluate("state.z1") == pytest.approx(0.6 * 100**0.5013)
    page.get_by_role("button", name="Stop").click()
    assert page.evaluate("[state.z1, player.playing]") == [0.6, False]
    page.evaluate("player.seek(0.99)")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("!player.playing")
    assert page.evaluate("state.z1") == 60
    page.get_by_label("Loop").check()
    page.evaluate("player.seek(0.99)")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("state.z1 < 20")
    page.keyboard.press("3")
    assert page.evaluate("state.scene") == "spheres"
    page.evaluate("player.pause(); draw(); PACE.RAYS = 1")
    show(page, scene="chess")
    assert page.evaluate("player.preset.name") == "vary-alpha"


def test_reduced_motion(page):
    page.emulate_media(reduced_motion="reduce")
    page.get_by_role("button", name="vary α").click()
    assert page.evaluate("[player.playing, state.alpha]") == [False, 0]
    page.evaluate("openQuestion(1); reveal()")
    assert page.evaluate("state.alpha") == 66  # at once


def test_povrays_movie_is_shown_at_the_same_value(browser, tmp_path, monkeypatch):
    """And a piece of one's own with a hostile name is only a name."""
    monkeypatch.setattr(teaching, "MOVIES", ("vary-alpha",))
    own = tmp_path / "<b>'&\"<i>.inc"
    own.write_text("#declare Piece = sphere { 0.4*y, 0.4 }\n")
    options = {"quality": "draft", "size": (64, 48), "antialias": "off", "progress": False}
    file = demo(tmp_path / "page.html", pieces=[own], movies=True, **options)
    assert {path.name for path in tmp_path.iterdir()} == {own.name, "page.html", "page-vary-alpha.mp4"}
    page, faults = opened(browser, file, "?bench#scene=chess&sheet=ideal&alpha=60")
    expect(page.locator("#message")).to_contain_text("frames a second", timeout=60_000)
    button = page.get_by_role("button", name="POV-Ray’s picture")
    button.click()
    page.wait_for_function("$('video').currentTime > 0 && !$('video').seeking")
    assert page.evaluate("[state.sheet, state.alpha]") == ["detailed", 60]
    where = page.evaluate("$('video').currentTime / $('video').duration")
    assert where == pytest.approx((60 / 180 * 15 + 0.5) / 16, abs=0.01)  # frame 5 of 16
    page.evaluate("player.seek(1)")
    page.wait_for_function("$('video').currentTime > 0.9 * $('video').duration")
    expect(button).to_have_attribute("aria-pressed", "true")
    page.locator("#number-z1").fill("4")  # the movie has another z1
    expect(button).to_have_attribute("aria-pressed", "false")
    expect(page.locator("#video")).to_be_hidden()
    assert not faults
    name = page.locator("#piece option").last
    expect(name).to_have_text("<b>'&\"<i>")
    page.locator("#piece").select_option(index=6)
    page.wait_for_function("view.converged()")
    (tmp_path / "page-vary-alpha.mp4").unlink()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.reload()
    expect(page.locator("#message")).to_contain_text("needs WebGL 2")
    expect(page.locator("#video")).to_be_hidden()  # the movie is gone
    page.close()


# ---- Words, marks, questions ----


def test_the_pole_is_said_in_words_view_and_diagram(page):
    for values, words, seen in (
        ({"alpha": 180, "z1": 6}, "The pole: one point", "one point of the knight fills the window"),
        ({"alpha": 180, "z1": 5.8}, "Near the pole", "0.1 tiles of the knight fill the window"),
        ({"alpha": 180, "z1": 6, "E": [1.5, 0.5]}, "The knight is not there", "nothing of the knight is seen"),
        ({"E": [0, -1.4]}, "of the pedestal, one point", "one point of the pedestal fills the window"),
        ({"scene": "spheres", "alpha": 180, "z1": 6}, "The sphere is not there", "nothing of the sphere is seen"),
        ({"L": [0, -1.4]}, "The pole: one point of the sphere", "one point of the sphere fills the window"),
    ):
        show(page, **values)
        expect(page.locator("#sentence")).to_contain_text(words)
        expect(page.locator("#overlay .say")).to_have_text(seen)
    page.evaluate("fromHash('#alpha=180&z1=6')")
    show(page)
    expect(page.locator("#diagram")).to_contain_text("P is infinitely far away")
    expect(page.locator("#value-nu")).to_have_text("undefined")
    show(page, z1=3)
    expect(page.locator("#overlay .say")).to_have_count(0)
    show(page, sheet="single", z1=6)
    expect(page.locator("#sentence")).to_contain_text("one height fills the window from top to bottom")


@pytest.mark.parametrize("name", ["alpha", "z1", "z2", "L", "E", "r", "P", "nu", "M"])
def test_a_quantity_is_marked_in_picture_diagram_and_sketch(page, name):
    row = page.locator(f"[data-quantity={name}]")
    where = {"L": "#sketch", "E": "#sketch", "z1": "#sketch", "z2": "#sketch"}.get(name, "#overlay")
    marked = [page.locator(f"{drawing} .marked") for drawing in (where, "#overlay", "#diagram")]
    expect(marked[0]).to_have_count(0)
    row.hover()
    for found in marked:
        assert found.count() > 0
    page.mouse.move(5, 5)
    expect(marked[0]).to_have_count(0)
    row.locator("button, input").first.focus()
    assert marked[1].count() > 0
    page.evaluate("document.activeElement.blur()")
    expect(marked[1]).to_have_count(0)


def test_a_screen_reader_hears_new_numbers_when_they_rest(page):
    spoken = page.locator("#spoken")
    show(page, alpha=90)
    show(page, alpha=100)
    expect(spoken).to_contain_text("A knight seen through the ideal sheet. α = 100.0°")
    page.locator("#eye-picture").press("ArrowRight")
    expect(spoken).to_contain_text("the eye E at 0.05, 0.00.")
    names = page.evaluate("['slider-alpha', 'number-alpha', 'slider-z1'].map((id) => $(id).getAttribute('aria-label'))")
    assert len(set(names)) == 3 and all("alpha" in name or "z1" in name for name in names)
    expect(page.locator("#view")).to_have_attribute("aria-label", spoken.text_content())
    assert spoken.get_attribute("role") == "status"


def test_questions_are_predicted_and_revealed(page):
    page.get_by_role("tab", name="Questions").click()
    count = page.evaluate("QUESTIONS.length")
    assert count >= 6
    page.emulate_media(reduced_motion="reduce")
    for n in range(count):
        expect(page.locator("#question-count")).to_have_text(f"Question {n + 1} of {count}")
        expect(page.locator("#answer")).to_be_empty()
        choices = page.locator("#prediction input[type=radio]")
        right = page.evaluate(f"QUESTIONS[{n}].answer()")
        wrong = n % 2
        if choices.count():
            choices.nth((right + wrong) % choices.count()).check()
        else:
            for nonsense in ("", "six"):
                page.locator("#prediction input").fill(nonsense)
                page.get_by_role("button", name="Reveal").click()
                expect(page.locator("#answer")).to_have_text("Type a number first.")
            page.locator("#prediction input").fill(str(right * (1 + 0.08 * wrong)).replace(".", ","))
        page.get_by_role("button", name="Reveal").click()
        assert page.evaluate("document.activeElement.id") == ("next" if n + 1 < count else "previous")
        expect(page.locator("#answer")).to_contain_text("No: " if wrong else "Yes: ")
        for name, value in page.evaluate(
            f"(() => {{ const {{ after }} = QUESTIONS[{n}]; return after.call ? after() : after; }})()"
        ).items():
            assert page.evaluate(f"state.{name}") == value
        if n + 1 < count:
            page.get_by_role("button", name="Next").click()
            assert page.evaluate("document.activeElement.id") == "ask"
    page.get_by_role("tab", name="Explore").click()
    expect(page.locator("#diagram")).to_be_visible()


def test_an_input_ends_the_movement_to_the_answer(page):
    page.evaluate("openQuestion(6); reveal()")  # the eye moves
    page.locator("#number-z1").fill("3")
    assert page.evaluate("[state.z1, ...state.E, session.gliding]") == [3, 0.8, 0, None]


def test_what_was_explored_comes_back_after_the_questions(page):
    show(page, scene="spheres", alpha=12, z2=7, E=[0.3, 0.1])
    before = page.evaluate("({ ...state })")
    page.get_by_role("tab", name="Questions").click()
    assert page.evaluate("[state.scene, state.sheet, state.alpha]") == ["chess", "none", 0]
    page.get_by_role("tab", name="Explore").click()
    assert page.evaluate("({ ...state })") == before


def test_a_link_to_a_question_does_not_show_its_answer(page):
    page.evaluate("revealed.clear(); fromHash('#question=2&alpha=66')")
    assert page.evaluate("[state.question, state.alpha]") == [1, 0]
    show(page)
    expect(page.locator("#answer")).to_be_empty()


def test_play_and_reset(page):
    show(page, scene="spheres", sheet="none")
    page.evaluate("draw(); PACE.RAYS = 0")
    page.get_by_role("button", name="Play").click()
    assert page.evaluate("[state.sheet, player.playing]") == ["ideal", True]
    page.keyboard.press("2")
    page.get_by_role("button", name="Reset").click()
    assert page.evaluate("[state.scene, state.alpha, player.preset.name]") == ["chess", 66, "vary-alpha"]
    show(page, scene="spheres", alpha=3)
    page.get_by_role("button", name="Reset").click()
    assert page.evaluate("[state.scene, state.alpha, player.preset.scene]") == ["spheres", 66, "spheres"]
    page.evaluate("PACE.RAYS = 1")


def test_full_screen(page):
    button = page.get_by_role("button", name="Full screen")
    for on in ("true", "false"):
        button.click()
        expect(button).to_have_attribute("aria-pressed", on)


# ---- The address ----


def test_back_and_forward(page):
    page.evaluate("keepAddress()")
    for alpha in (10, 20, 30):
        page.locator("#number-alpha").fill(str(alpha))
        page.wait_for_function("(alpha) => location.hash.includes(`alpha=${alpha}&`)", arg=alpha)
    for go, alpha in ((page.go_back, 20), (page.go_back, 10), (page.go_forward, 20)):
        go()
        page.wait_for_function("(alpha) => state.alpha === alpha", arg=alpha)
        page.evaluate("draw()")
        expect(page.locator("#number-alpha")).to_have_value(str(alpha))


# ---- Keys, accessibility, layout ----


def test_keys_and_their_off_switch(page):
    for key, test in (
        ("p", "state.sheet === 'detailed'"), ("p", "state.sheet === 'ideal'"), ("o", "state.position"),
        ("c", "state.circles"), ("i", "state.image"), ("q", "state.question === 0"), ("q", "state.question === -1"),
        (" ", "player.playing"),
        (" ", "!player.playing"),
    ):  # fmt: skip
        page.keyboard.press(key)
        assert page.evaluate(test), key
    show(page, sheet="ideal")
    for control, key in (
        ("#number-alpha", "p"),
        ("#piece", "p"),
        ("#reset", " "),
        ("#loop", " "),
        ("#tab-explore", " "),
    ):
        page.locator(control).focus()
        page.keyboard.press(key)
        assert page.evaluate("[state.sheet, player.playing]") == ["ideal", False], control
    assert page.evaluate("$('loop').checked")  # the control has had its key
    page.evaluate("document.querySelector('details').open = true")
    page.get_by_label("Single keys are shortcuts").uncheck()
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("p")
    assert page.evaluate("state.sheet") == "ideal"


def test_everything_is_reached_by_the_tab_key(page):
    wanted = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, summary")].filter((control) =>
             control.checkVisibility() && !control.disabled && control.tabIndex >= 0
             && !control.closest("details:not([open]) > :not(summary)") 
             && (control.type !== "radio" || control.checked)).length"""
    )
    page.evaluate("window.reached = new Set(); addEventListener('focusin', (event) => reached.add(event.target))")
    page.evaluate("document.querySelector('#scene input:checked').focus()")
    for _ in range(wanted + 3):
        page.keyboard.press("Tab")
    assert page.evaluate("reached.size") >= wanted > 30


def test_axe_finds_no_fault(page):
    options = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}
    faults = {}
    for name, (size, values) in {
        "opening": ("laptop", {}),
        "drawings": ("laptop", {"position": True, "circles": True, "image": True, "caption": True, "diagram": "paper"}),
        "question": ("phone", {"question": 3, "sheet": "none"}),
        "spheres": ("phone sideways", {"scene": "spheres", "sheet": "single"}),
        "series": ("laptop", {"windows": 2, "position": True, "diagram": "paper"}),
        "axis": ("phone", {"sheet": "axis"}),
    }.items():
        page.set_viewport_size(dict(zip(("width", "height"), SIZES[size], strict=True)))
        page.evaluate("fromHash('')")
        page.evaluate("document.querySelector('details').open = true")
        show(page, **values)
        found = Axe().run(page, options=options).response["violations"]
        faults |= {f"{name}: {fault['id']}": [node["html"][:120] for node in fault["nodes"]] for fault in found}
    assert not faults


@pytest.mark.parametrize("size", SIZES)
def test_nothing_is_cut_off(page, size):
    width, height = SIZES[size]
    page.evaluate("PACE.RAYS = 0; document.querySelector('details').open = false")
    page.set_viewport_size({"width": width, "height": height})
    for values in (
        {},
        {"sheet": "detailed"},
        {"scene": "spheres"},
        {"sheet": "single"},
        {"alpha": 180, "z1": 6},
        {"windows": 2, "diagram": "paper"},
        {"sheet": "axis"},
        {"question": 6},
    ):
        page.evaluate("fromHash('')")
        show(page, **values)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        if size in ("laptop", "projector"):
            assert page.evaluate("document.documentElement.scrollHeight") <= height
            if "question" in values:
                page.set_viewport_size({"width": width, "height": 650})
                expect(page.locator("#next")).to_be_in_viewport(ratio=1)
                page.set_viewport_size({"width": width, "height": height})
            assert (
                page.evaluate("((panel) => panel.scrollHeight - panel.clientHeight)(document.querySelector('.panel'))")
                <= 1
            )
        cut = """[...document.querySelectorAll("dl div, button, legend, label, .player, #sentence")]
          .filter((part) => part.scrollWidth > part.clientWidth + 1 && part.checkVisibility()
            && getComputedStyle(part).display !== "inline" && !part.matches(".hidden-text, .handle"))
          .map((part) => part.outerHTML)"""
        assert page.evaluate(cut) == []
        narrow = """[...document.querySelectorAll("select")].filter((part) => part.checkVisibility()).filter((part) => {
          const wide = part.parentNode.appendChild(part.cloneNode(true));
          wide.style.width = "auto";
          const least = wide.offsetWidth;
          wide.remove();
          return part.offsetWidth < least;
        }).map((part) => part.id)"""
        assert page.evaluate(narrow) == []
        box = page.locator("#stage").bounding_box()
        assert box["width"] / box["height"] == pytest.approx(4 / 3, abs=0.01)
        assert box["width"] * box["height"] > (0.35 if size != "phone" else 0.25) * width * height
    page.evaluate("PACE.RAYS = 1")


def test_on_a_phone_the_picture_stays_in_sight(page):
    page.set_viewport_size({"width": 390, "height": 844})
    page.evaluate("scrollTo(0, 10000)")
    expect(page.locator("#stage")).to_be_in_viewport(ratio=1)


# ---- The file ----


def test_the_page_is_one_small_file(demo_file):
    assert demo_file.stat().st_size < 1_000_000
    text = demo_file.read_text("utf-8")
    assert "http" not in text.replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert all(path.read_text() in text for path in (PROJECT / "templates" / "demo").glob("*.css"))


def test_a_page_has_one_global_name(browser, demo_file, tmp_path):
    page = browser.new_page()
    (tmp_path / "empty.html").touch()
    names = []
    for file in (tmp_path / "empty.html", demo_file, live(Spheres(sheet="none")).save(tmp_path / "view.html")):
        page.goto(file.as_uri())
        names.append(set(page.evaluate("Object.keys(window)")))
    assert names[1] - names[0] == names[2] - names[0] == {"povgen"}
    page.close()


def test_the_command(tmp_path):
    status, out, _ = povgen(["demo", "-o", "a page.html"], tmp_path)
    assert status == 0 and out == "wrote a page.html\n"
    assert [path.name for path in tmp_path.iterdir()] == ["a page.html"]
    for wrong, said in (
        (["-o", "page"], "output"),
        (["--quality", "high"], "quality = high: only movies are rendered; allowed: with --movies"),
        (["--movies", "--quality", "best"], "quality"),
        (["--movies", "--stereo", "pair"], "stereo"),
        (["--movies", "--workers", "0"], "workers"),
        (["--piece", "nowhere.inc"], "piece"),
    ):
        assert said in refused(["demo", *wrong], tmp_path)


def test_what_cannot_be_is_refused_before_anything_is_rendered(tmp_path, monkeypatch):
    monkeypatch.setattr(teaching, "volumes", None)
    with pytest.raises(InputError, match="quality"):
        demo(tmp_path / "page.html", movies=True, quality="best")
    with pytest.raises(InputError, match="allowed"):
        demo(tmp_path / "page.pdf")
    assert not list(tmp_path.iterdir())
