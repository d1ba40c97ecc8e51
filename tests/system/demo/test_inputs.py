"""Sliders, numbers and dragging on the teaching page."""

import re

import numpy as np
import pytest
from conftest import scene_of
from playwright.sync_api import expect

from demo.conftest import bounds, centre, drag, show
from povgen.optics import equations


def test_sliders_of_other_sheets(page):
    """A focal length has both signs, and a lens is weak in the middle of the slider. An angle is linear."""
    choose = page.get_by_label("Kind of window")
    choose.select_option("glens")
    slider, ends = page.locator("#slider-focal_length"), []
    for place in (-1000, -1, 0, 1, 500, 1000):
        slider.fill(str(place))
        ends.append(page.evaluate("state.focal_length"))
        expect(page.locator("#number-focal_length")).to_have_value(f"{ends[-1]:.4g}")
    assert ends == pytest.approx([-0.1, -100, 100, 100, 10**0.5, 0.1], rel=0.01)
    show(page, focal_length=-2)
    assert float(slider.input_value()) == pytest.approx(-1000 * np.log(50) / np.log(1000), abs=0.5)
    expect(slider).to_have_attribute("aria-valuetext", "−2 tiles")
    expect(page.locator("#scrub-value")).to_have_text("z₁ = 2")  # no alpha: the other movie
    choose.select_option("twist")
    page.locator("#slider-twist").fill("-45")
    assert page.evaluate("state.twist") == -45
    expect(page.locator("#slider-twist")).to_have_attribute("aria-valuetext", "−45.0°/tile")
    expect(page.locator("#scrub-value")).to_have_text("α = 0.0°")


def test_numbers_are_typed_and_sliders_moved(page):
    page.locator("#number-alpha").fill("90")
    P, nu, M = (each(3, np.pi / 2) for each in (equations.P, equations.nu, equations.M))
    numbers = {"r": "3.000", "P": f"{P.real:.3f} − {-P.imag:.3f} i", "nu": f"{np.degrees(nu):.1f}°", "M": f"{M:.4g}"}
    for name, text in numbers.items():
        expect(page.locator(f"#value-{name}")).to_have_text(text)
    assert page.evaluate("$('slider-alpha').value") == "90"
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
    assert page.evaluate("state.alpha") == 90


def test_an_eye_with_a_pupil_is_focused(page):
    """Best by itself, until someone chooses the distance. Beginners see the pupil's picture, but not its sliders."""
    best, focus = page.get_by_label("best focus"), page.locator("#number-focus")
    expect(focus).to_be_hidden()
    page.get_by_label("p: diameter of the eye’s pupil").fill("0.3")
    expect(focus).to_have_value("7.303")  # 1 / Re(1/Z)
    expect(best).to_be_checked()
    show(page, alpha=180, z1=12)  # its image is behind the eye
    expect(focus).to_have_value("∞")
    show(page, z1=2)
    page.get_by_label("s: the eye is focused at").press("ArrowRight")
    expect(best).not_to_be_checked()
    assert page.evaluate("[moment().focus, 1 / moment().scene.inverse_focus]") == [4.02, pytest.approx(4.02)]
    best.press("Space")
    assert page.evaluate("[state.focus, moment().focus]") == ["best", pytest.approx(4)]
    best.press("Space")
    assert page.evaluate("state.focus") == pytest.approx(4)
    focus.fill("2000")
    expect(page.locator("#sentence")).to_contain_text("s is at most 1000.")
    show(page, level="simple")
    expect(page.locator("#row-pupil")).to_be_hidden()
    page.locator("#reset").click()
    assert page.evaluate("(draw(), [state.pupil, state.focus, view.scene.pupil])") == [0, "best", 0]


def test_what_is_changed_is_said(page):
    show(page, sheet="detailed")
    for name, typed, value, said in (
        ("alpha", "400", 40, ""),
        ("z1", "0.1", 0.1, "z₁ is at least 0.581: the piece would touch the frame."),
        ("z1", "2,5", 2.5, ""),
        ("prisms", "10.4", 10, "N is a whole number."),
        ("alpha", "12 or so", 40, "“12 or so” is not a number."),
        ("alpha", "3 tiles", 40, "“3 tiles”: α is in degrees."),
        ("alpha", "45deg", 45, ""),
        ("alpha", "−", 45, ""),
        ("alpha", "0x10", 45, "“0x10” is not a number."),
        ("prisms", "12 tiles", 10, "“12 tiles”: N has no unit."),
        ("Ey", "1°", None, "“1°”: y of E is in tiles."),
        ("Ey", "-5", None, "y of E is at least −1.6: the floor is below."),
    ):
        field = page.locator(f"#number-{name}")
        field.fill(typed)
        field.blur()
        page.evaluate("draw()")
        text = page.locator("#sentence").text_content()
        assert said in text if said else not re.search("at least|at most|number|“", text), text
        if value is not None:
            assert page.evaluate("({ ...state })")[name] == value
    page.locator("#number-alpha").press("ArrowDown")
    assert page.evaluate("state.alpha") == 44
    # in the event of the key, before the page is drawn: a screen reader speaks it then
    said = """([name, value]) => {
      const slider = $(`slider-${name}`);
      slider.value = value;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      return slider.getAttribute("aria-valuetext");
    }"""
    assert page.evaluate(said, ["alpha", 21]) == "21.0°"
    show(page, sheet="ideal", E=[0, 0])
    assert page.evaluate(said, ["z1", 0]) == "0.581 tiles"  # the least there
    first, what = page.evaluate("heard(moment())")
    assert first.startswith("z₁ is at least 0.581") and what.startswith("The knight appears turned by ")


def test_arrow_keys_choose_the_next_sphere(page):
    show(page, scene="spheres")
    distances = sorted(page.evaluate("moment().objects"))
    before = distances.index(page.evaluate("moment().z1"))
    page.locator("#slider-z1").focus()
    for key, aside in (("ArrowLeft", -1), ("ArrowRight", 0), ("ArrowUp", 1)):
        page.keyboard.press(key)
        assert page.evaluate("moment().z1") == distances[before + aside]


def test_few_large_prisms_push_eye_and_object_away(page):
    show(page, sheet="detailed", prisms=1)
    scene = scene_of(page)
    assert scene.z2 > scene.depth / 2 > 10 and scene.z1 > scene.depth / 2
    for reason in ("z₁ is at least", "z₂ is at least"):
        expect(page.locator("#sentence")).to_contain_text(reason)
    show(page, prisms=100)
    assert page.evaluate("[moment().z1, moment().z2]") == [2, 6]
    expect(page.locator("#about-nu")).to_have_text("for 100 prisms; ideal sheet: 15.0°")


@pytest.mark.parametrize("level", ["simple", "expert"])
def test_one_sheet_has_no_angle_and_two_sizes(page, level):
    show(page, sheet="single", z1=2, z2=6, level=level)
    expect(page.locator("#value-nu")).to_have_text("no angle: the light is mirrored")
    expect(page.locator("#about-nu")).to_be_empty()
    expect(page.locator("#value-bare")).to_have_text("width × 1, height × 2")
    expect(page.locator("#about-bare")).to_be_hidden()


@pytest.mark.parametrize("sheet", ["none", "single", "ideal", "detailed", "lens", "refraction"])
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
    P = equations.P(3, np.radians(66))
    for turned in ("picture", "paper"):
        page.locator(f"#orientation input[value={turned}]").check(force=True)
        L, E, seen = (complex(*place) for place in page.evaluate(places))
        assert (seen - L) / (E - L) == pytest.approx(P, abs=0.01)
        direction = complex(*page.evaluate("minus(state.E, state.L)")) if turned == "picture" else 1
        assert np.angle((E - L) / direction) == pytest.approx(0, abs=1e-6)
    expect(page.locator("#eye-diagram")).to_be_hidden()


@pytest.mark.parametrize("alpha", [0, 90])
@pytest.mark.parametrize("height", [1.2, -0.7])
def test_the_whole_piece_and_its_pedestal_can_be_dragged(page, alpha, height):
    """Also where its outline has a gap, and by a finger in every direction: there the page does not scroll."""
    show(page, alpha=alpha, z1=6)
    point = f"""() => {{
      const now = moment(), at = apparentPosition({{ ...now, L: plus(now.L, [0.15, {height}]) }});
      const [x, y] = onStage(at), box = stage.getBoundingClientRect();
      return [box.left + box.width / 2 + x, box.top + box.height / 2 + y];
    }}"""
    x, y = page.evaluate(point)
    before = page.evaluate("[...state.L, ...state.E]")
    assert page.evaluate("([x, y]) => getComputedStyle(document.elementFromPoint(x, y)).touchAction", [x, y]) == (
        "pinch-zoom"
    )
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 12)
    page.mouse.up()
    after = page.evaluate("[...state.L, ...state.E]")
    assert after[:2] != before[:2] and after[2:] == before[2:]
    show(page, light="aim", W=[-1, -1])
    page.mouse.click(*page.evaluate(point))  # there the ray is to cross the window
    assert (
        abs(
            page.evaluate(
                "abs(minus(state.W, apparentPosition({ ...moment(), L: plus(state.L, [0.15, HEIGHT]) })))".replace(
                    "HEIGHT", str(height)
                )
            )
        )
        < 0.05
    )


def test_a_swipe_that_scrolls_the_page_moves_nothing(page):
    places = page.evaluate(
        """() => [stage, $("space-turn")].map((part) => {
          const box = part.getBoundingClientRect(), at = [box.left + 60, box.top + 60];
          const place = () => JSON.stringify([state.E, session.camera]);
          const send = (type, step) => part.dispatchEvent(new PointerEvent(type,
            { pointerId: 1, isPrimary: true, bubbles: true, clientX: at[0], clientY: at[1] + step, buttons: 1 }));
          part.setPointerCapture = () => {};
          const before = place();
          send("pointerdown", 0);
          send("pointermove", 8);
          const moved = place();
          send("pointercancel", 8);
          delete part.setPointerCapture;
          return [before, moved, place()];
        })"""
    )
    assert all(before == after != moved for before, moved, after in places)


def test_arrow_keys_move_eye_and_object(page):
    page.locator("#eye-picture").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowUp")
    page.locator("#object-diagram").focus()
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("[...state.E, state.L[0]]") == pytest.approx([0.05, 0.25, -0.05])
    for handle in page.locator(".handle").all():
        expect(handle).to_have_role("application")  # a screen reader gives it the arrow keys
    page.evaluate("draw()")
    expect(page.locator("#eye-picture")).to_have_attribute(
        "aria-label", "Eye E, 0.05 tiles to the right and 0.25 tiles up from the window’s middle: arrow keys move it"
    )
