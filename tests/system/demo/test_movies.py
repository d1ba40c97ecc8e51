"""The movies of the teaching page: its own and POV-Ray's."""

import imageio.v2 as imageio
import numpy as np
import pytest
from playwright.sync_api import expect

from demo.conftest import opened, show
from povgen.page import page as teaching
from povgen.page.page import demo


def test_presets_play_loop_stop_and_scrub(page):
    show(page, sheet="none")
    page.get_by_role("button", name="vary z₁").click()
    assert page.evaluate("[state.sheet, state.alpha, player.playing]") == ["ideal", 90, True]
    page.wait_for_function("state.z1 > 1.3 && ($('play').click(), true)")
    z1 = page.evaluate("state.z1")
    assert 1.2 < z1 < 12
    page.locator("#scrub").fill("500")
    assert page.evaluate("state.z1") == pytest.approx(14.4**0.5)  # midway between 1.2 and 12 by ratio
    page.evaluate("draw()")
    expect(page.locator("#scrub-value")).to_have_text("z₁ = 3.79")
    show(page, z1=20)  # it is not in the movie
    expect(page.locator("#scrub-value")).to_be_empty()
    page.get_by_role("button", name="Stop").click()
    assert page.evaluate("[state.z1, player.playing]") == [1.2, False]
    page.evaluate("player.seek(0.99)")
    page.get_by_role("button", name="Play").click()
    expect(page.locator("#spoken")).to_have_text("Play: z₁ from 1.2 tiles to 12 tiles")
    page.wait_for_function("!player.playing")
    assert page.evaluate("state.z1") == 12
    page.get_by_label("Loop").check()
    page.evaluate("player.seek(0.99)")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("state.z1 < 15")
    page.keyboard.press("3")
    assert page.evaluate("state.scene") == "spheres"
    page.evaluate("player.pause(); draw()")
    show(page, scene="chess", sheet="none")
    assert page.evaluate("player.preset.name") == "vary-alpha"
    page.get_by_role("button", name="Play").click()
    assert page.evaluate("[state.sheet, player.playing]") == ["ideal", True]


def test_reduced_motion(page):
    page.emulate_media(reduced_motion="reduce")
    page.get_by_role("button", name="vary α").click()
    assert page.evaluate("[player.playing, state.alpha]") == [False, 0]
    page.evaluate("openQuestion(1); reveal()")
    assert page.evaluate("state.alpha") == 66  # at once


def grey(spec, file, **options):
    """Write a movie of as many grey frames as POV-Ray would render."""
    with imageio.get_writer(file, fps=spec.rate("draft"), macro_block_size=2) as movie:
        for _ in range(spec.count("draft")):
            movie.append_data(np.full((48, 64, 3), 99, np.uint8))


def test_povrays_movie_is_shown_at_the_same_value(browser, tmp_path, monkeypatch):
    """And a piece of one's own with a hostile name is only a name."""
    monkeypatch.setattr(teaching, "MOVIES", ("vary-alpha",))
    monkeypatch.setattr(teaching.build, "movie", grey)
    own = tmp_path / "<b>'&\"<i>.inc"
    own.write_text("#declare Piece = sphere { 0.4*y, 0.4 }\n")
    options = {"quality": "draft", "size": (64, 48), "antialias": "off", "progress": False}
    file = demo(tmp_path / "page #1.html", pieces=[own], movies=True, **options)
    assert {path.name for path in tmp_path.iterdir()} == {own.name, "page #1.html", "page #1-vary-alpha.mp4"}
    page, faults = opened(browser, file, "#scene=chess&sheet=ideal&alpha=60")
    button = page.get_by_role("button", name="POV-Ray’s picture")
    page.evaluate("change({ compare: 'none' })")  # there is no curtain before a movie
    button.click()
    page.wait_for_function("$('video').currentTime > 0 && !$('video').seeking")
    assert page.evaluate("[state.sheet, state.alpha, state.compare]") == ["detailed", 60, "off"]
    where = page.evaluate("$('video').currentTime / $('video').duration")
    assert where == pytest.approx((60 / 180 * 48 + 0.5) / 49, abs=0.01)  # frame 16 of 49
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
    page.close()


def test_slow_playback_takes_four_times_as_long(page):
    """The step between two frames that are 200 ms apart."""
    step = """(slow) => {
      $("slow").checked = slow;
      player.seek(0);
      Object.assign(player, { playing: true, since: 1000 });
      player.tick(1200);
      player.playing = $("slow").checked = false;
      return player.part();
    }"""
    assert page.evaluate(step, False) == pytest.approx(4 * page.evaluate(step, True), rel=0.02) != 0
