"""The view of the light in space, and the two levels of the page."""

import re

import numpy as np
import pytest
import ray_field as field
from playwright.sync_api import expect

from demo.conftest import bounds, show, touch

SAYS = "#light-says"


def drawn(page, kind):
    """Return how many rays of a kind the view shows."""
    return page.locator(f"#space .ray.{kind}").count()


def test_at_the_pole_all_rays_of_L_reach_the_eye(page):
    show(page, light="pencil", alpha=180, z1=6, L=[0, 0])
    expect(page.locator(SAYS)).to_contain_text("reach the eye, so L alone fills the window: the pole")
    assert drawn(page, "path.designed, #space .ray.designed") == 25
    # in one call: the view may be drawn anew between two
    middles = """[".pupil", "circle.image"].map((part) => {
      const { left, right } = document.querySelector(`#space ${part}`).getBoundingClientRect();
      return (left + right) / 2;
    })"""
    expect(page.locator("#space-turn")).to_have_accessible_description(
        re.compile(r"the plane of E: opposite the window’s middle\. Their mean distance from it there: 0.00 tiles\.$")
    )
    eye, image = page.evaluate(middles)
    assert abs(eye - image) < 8
    show(page, alpha=66, z1=2)
    expect(page.locator(SAYS)).to_contain_text("L has no image")
    expect(page.locator("#space circle.image")).to_have_count(0)
    show(page, sheet="none")
    expect(page.locator(SAYS)).to_contain_text(
        "No sheet turns them: they run straight on and move apart. So L has no image"
    )


@pytest.mark.parametrize(
    ("values", "words", "dashed"),
    [
        ({"alpha": 180, "z1": 2}, "They meet 2 tiles in front of the window: a real image", 0),
        ({"windows": 2, "alpha": 120, "alpha2": 120, "z1": 2, "d": 2, "z2": 8}, "2 tiles in front of the first", 0),
        ({"sheet": "lens", "focal_length": 4, "z1": 2}, "meet 4 tiles behind the window: a virtual image", 25),
    ],
)
def test_an_image_is_where_the_rays_meet(page, values, words, dashed):
    """A lens of focal length 4 shows what is 2 behind it 4 behind it: 1/4 = 1/2 - 1/4."""
    show(page, light="pencil", L=[0, 0.1], **values)
    expect(page.locator(SAYS)).to_contain_text(words)
    expect(page.locator("#space .virtual")).to_have_count(dashed)


def test_stray_light_has_its_own_colour_and_can_be_hidden(page):
    show(page, light="pencil", sheet="detailed")
    good, stray = drawn(page, "designed"), drawn(page, "stray")
    assert good > 3 and stray > 3
    colours = page.evaluate(
        "['designed', 'stray'].map((kind) => getComputedStyle(document.querySelector(`#space path.${kind}`)).stroke)"
    )
    assert colours[0] != colours[1]
    page.locator("#show-stray").uncheck()
    page.evaluate("draw()")
    assert (drawn(page, "designed"), drawn(page, "stray")) == (good, 0)


def test_one_prism_numbers_refraction_reflection_refraction(page):
    page.get_by_label("Rays in space").select_option("one prism")
    page.evaluate("draw()")
    assert page.locator("#space text.number").all_text_contents() == ["1", "2", "3"]
    expect(page.locator(SAYS)).to_contain_text("2: total reflection")


def test_a_ray_through_a_chosen_point_says_what_the_eye_sees_there(page):
    page.get_by_label("Rays in space").select_option("ray through a point")
    show(page, alpha=0, W=[0, 0.2])
    says, ring = page.locator(SAYS), page.locator("#aim-picture")
    expect(says).to_contain_text("the eye sees: knight.")
    assert drawn(page, "designed") == 1
    stage = page.locator("#stage").bounding_box()
    tile, x, y = stage["height"] / 3.7, *(stage[a] + stage[b] / 2 for a, b in (("x", "width"), ("y", "height")))
    page.mouse.click(x - 1.2 * tile, y - 1.2 * tile)
    page.evaluate("draw()")
    assert page.evaluate("state.W") == pytest.approx([-1.2, 1.2], abs=0.02)
    expect(says).to_contain_text("the eye sees: sky.")
    for _ in range(10):
        ring.press("Shift+ArrowDown")
    page.evaluate("draw()")
    assert page.evaluate("state.W") == pytest.approx([-1.2, -1.3], abs=0.02)
    expect(says).to_contain_text("the eye sees: the floor.")
    assert "W=-1.1" in page.evaluate("toHash()")


def test_a_loop_perpendicular_to_the_rays_does_not_close(page):
    """Its gap is that of povgen's chart; and at each of its points, light of L is perpendicular to it."""
    show(page, light="field", alpha=66, z1=field.Z1)
    turns = np.linspace(0, 2 * np.pi, 241)
    front = field.wave_front(0.6, turns)
    gap = page.evaluate("perpendicularLoop(moment()).gap")
    assert gap == pytest.approx(front[0] - front[-1], rel=1e-6)
    angles = page.evaluate(
        """() => {
          const now = moment(), { points } = perpendicularLoop(now), object = [...now.L, now.z1];
          const unit = (v) => v.map((x) => x / Math.hypot(...v));
          return [10, 100, 200].map((k) => {
            const step = unit(points[k + 1].map((x, n) => x - points[k - 1][n])), w = -points[k][2];
            // L's ray through this point: where it crosses the sheet
            const share = quotient([now.z1, 0], times(turn(now.alpha), depthAt(now, w)));
            const P = plus(now.L, times(minus(points[k], now.L), share));
            const { direction } = traced(now, object, [...minus(P, now.L), -now.z1]);
            return unit(direction).reduce((sum, x, n) => sum + x * step[n], 0);
          });
        }""".replace("depthAt(now, w)", "equations.depth(now.z1, w, now.alpha)")
    )
    assert angles == pytest.approx([0, 0, 0], abs=1e-3)
    expect(page.locator(SAYS)).to_contain_text(f"its end is {gap:.3g} tiles away from its start")
    assert drawn(page, "designed") == 24 and page.locator("#space .gap").count() == 1
    expect(page.locator(SAYS)).not_to_contain_text("Only rays through the window")
    show(page, L=[1.3, -0.85])
    assert 0 < drawn(page, "designed") < 24
    expect(page.locator(SAYS)).to_contain_text("Only rays through the window are drawn.")
    show(page, alpha=180)
    expect(page.locator(SAYS)).to_contain_text("it closes: this light has wave fronts")
    expect(page.locator("#space .gap")).to_have_count(0)
    show(page, sheet="single")
    expect(page.locator(SAYS)).to_contain_text("is drawn for ideal sheets")


def test_the_view_is_turned_by_keys_dragging_and_buttons(page):
    def eye():
        page.evaluate("draw()")
        [box] = bounds(page, "#space .pupil")
        return np.array([box["x"], box["y"]])

    view = page.locator("#space-turn")
    before, state = eye(), page.evaluate("({ ...state })")
    view.press("ArrowRight")
    view.press("ArrowRight")
    turned = eye()
    assert abs(turned - before).max() > 1
    view.press("+")
    assert page.evaluate("session.zoom") > 1
    view.press("0")
    box = view.bounding_box()
    page.mouse.move(box["x"] + 20, box["y"] + 20)
    page.mouse.down()
    page.mouse.move(box["x"] + 80, box["y"] + 30)
    page.mouse.up()
    assert abs(eye() - turned).max() > 1
    page.get_by_role("button", name="side").click()
    assert page.evaluate("session.camera") == [0, 0]
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch(page, *([(x - 10 * k, y), (x + 10 * k, y)] for k in (1, 2, 3)))
    assert page.evaluate("[session.zoom, session.camera]") == [pytest.approx(3), [0, 0]]
    page.mouse.move(x, y)
    page.mouse.wheel(0, -100)
    page.wait_for_function("session.zoom > 3.1")
    page.get_by_role("button", name="side").click()
    assert page.evaluate("session.zoom") == 1
    assert page.evaluate("({ ...state })") == state  # and nothing else has changed


@pytest.mark.parametrize(
    ("camera", "axis"),
    [("side", "y"), ("corner", "y"), ("above", "x")],
)
def test_the_eye_and_the_object_can_be_dragged(page, camera, axis):
    """Each follows the pointer: along z, and up or aside, whichever is seen better."""
    show(page, large=True, z1=4, z2=6)
    # the view takes its new size after a frame
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))")
    page.evaluate(f"session.camera = CAMERAS.{camera}; draw()")
    for what, depth in (("L", "z1"), ("E", "z2")):
        before, part = page.evaluate("({ ...state })"), f"#space .hold[data-moves={what}]"
        [found] = bounds(page, part)
        x, y = found["x"] + found["width"] / 2, found["y"] + found["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.evaluate("draw()")
        [start] = bounds(page, part)  # while it is held: until then, the view can take another size
        page.mouse.move(x + 40, y - 15)
        page.evaluate("draw()")
        [end] = bounds(page, part)
        page.mouse.up()
        assert (end["x"] - start["x"], end["y"] - start["y"]) == pytest.approx((40, -15), abs=1)
        after = page.evaluate("({ ...state })")
        assert (after[depth] - before[depth]) * (1 if what == "L" else -1) > 0.1
        assert [k for k, x in zip("xy", before[what], strict=True) if x != after[what]["xy".index(k)]] == [axis]
        assert {**after, what: 0, depth: 0} == {**before, what: 0, depth: 0}


def test_the_view_takes_the_place_of_the_picture(page):
    page.get_by_role("checkbox", name="large").check()
    page.evaluate("draw()")
    space, stage = (page.locator(part).bounding_box() for part in ("#space-turn", "#stage"))
    assert space["width"] > 2.5 * stage["width"] > 0
    assert page.evaluate("new URLSearchParams(toHash().slice(1)).get('show')") == "stray,large"
    page.get_by_role("tab", name="Questions").click()
    page.get_by_role("tab", name="Measure").click()
    assert not page.evaluate("draw(), state.large")  # the picture is measured
    page.get_by_role("tab", name="Explore").click()
    page.get_by_role("checkbox", name="large").check()
    page.get_by_role("checkbox", name="large").uncheck()
    page.evaluate("draw()")
    assert page.locator("#stage").bounding_box()["width"] > page.locator("#space-turn").bounding_box()["width"]
