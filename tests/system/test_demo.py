"""The teaching page in a real Chromium: equations, frame, diagram, numbers, controls."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from conftest import POVGEN, PROJECT, refused
from playwright.sync_api import expect, sync_playwright

from povgen import Chess, InputError, MovieSpec
from povgen.optics import paraxial, rotation
from povgen.optics.prism import Prism
from povgen.scene import prediction
from povgen.scene.models import VIEW, Scene
from povgen.teach.page import SHEETS, demo, scenes
from povgen.video import still

pytestmark = pytest.mark.xdist_group("demo")  # one process makes the page
SIZE = (96, 72)
HOSTILE = 'The <b>knight\'s</b> & "ride" </script><script>window.broken = 1</script> {{ 7 * 7 }}'
# alpha = 180 degrees with z1 = z2 is the pole, in the last frame of SPHERES and the middle one of POLE
ALPHA, Z1, SPHERES, POLE, Z2 = 1, 2, 3, 4, 5
MOVIES = {
    ALPHA: ("chess", {"z1": 2}, "alpha", 0, 180, 5),
    Z1: ("chess", {"alpha": 90, "piece": "king"}, "z1", 0.7, 60, 3),
    SPHERES: ("spheres", {}, "alpha", 0, 180, 3),
    POLE: ("chess", {"alpha": 180}, "z1", 3, 9, 3),
    Z2: ("spheres", {"alpha": -50}, "z2", 3, 9, 3),
}
CHROMIUM = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
).split()


def spec(scene, fixed, parameter, start, stop, count, title=HOSTILE):
    sweep = {"parameter": parameter, "start": start, "stop": stop}
    return MovieSpec(title=title, scene=scene, frame_rate=2.5, frames=count, fixed=fixed, sweep=[sweep])


SPECS = {number: spec(*movie) for number, movie in MOVIES.items()}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Make the page of all movies, in a folder whose name has to be quoted in a URL."""
    count = []
    folder = tmp_path_factory.mktemp("demo") / "a démo #1"
    page = demo(SPECS.values(), folder, size=SIZE, antialias="off", done=lambda: count.append(1))
    assert len(count) == 2 * sum(movie[-1] for movie in MOVIES.values())
    return page


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        yield playwright.chromium.launch(executable_path=shutil.which("chromium"), args=CHROMIUM)


@pytest.fixture(scope="module")
def shared(browser, made):
    """The page, and a list of its errors and of its requests outside of its folder."""
    faults = []
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.set_default_timeout(10_000)
    page.on("console", lambda message: faults.append(message.text))
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("requestfailed", lambda request: faults.append(request.url))
    page.on("request", lambda request: request.url.startswith(made.parent.as_uri()) or faults.append(request.url))
    page.goto(made.as_uri())
    yield page, faults
    page.close()


@pytest.fixture
def page(shared):
    """The shared page, as it is when it has just been opened. The test fails if the page has an error."""
    page, faults = shared
    page.set_viewport_size({"width": 1280, "height": 720})
    page.evaluate(
        """() => {
          for (const movie of data.movies) Object.assign(movie, { at: 0, chosen: "z₁ = z₂" });
          state.movie = null;
          openTab(0);
          through("detailed");
          predict(true);
          document.activeElement.blur();
          scrollTo(0, 0);
        }"""
    )
    loaded(page)
    yield page
    assert not faults


def loaded(page):
    page.wait_for_function("Object.values(state.movie.images).flat().every((image) => image.complete)")


def opened(page, number):
    page.keyboard.press(str(number))
    loaded(page)


# Everything that depends on the frame, read at once: nothing may change later.
READ = """() => {
  const text = (name) => document.getElementById(`value-${name}`).textContent;
  const middle = (id) => {
    const box = document.getElementById(id)?.getBoundingClientRect();
    return box && [box.x + box.width / 2, -(box.y + box.height / 2)];
  };
  const box = document.getElementById("frame").getBoundingClientRect();
  return {
    ...Object.fromEntries(["alpha", "z1", "z2", "r", "P", "nu", "M"].map((name) => [name, text(name)])),
    file: document.getElementById("shown").getAttribute("src"),
    alt: document.getElementById("shown").alt,
    explanation: document.getElementById("explanation").textContent,
    diagram: document.getElementById("diagram").getAttribute("aria-label"),
    spoken: document.getElementById("slider").getAttribute("aria-valuetext"),
    corners: ["L", "E", "P"].map(middle),
    predicted: middle("predicted"),
    middle: middle("frame"),
    tile: box.height / VIEW,
    frame: box.width / box.height,
    arrows: document.querySelectorAll("svg .arrow").length,
  };
}""".replace("VIEW", str(VIEW))
MOVE = f"(n) => {{ slider.value = n; slider.dispatchEvent(new Event('input')); return ({READ})(); }}"


def number(text):
    """Return the real or complex number that the page shows as text."""
    text = text.replace("−", "-").replace(" tiles", "").strip("° ").replace("∞", "inf").replace("undefined", "nan")
    text = re.sub(
        r" × 10([⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)", lambda m: "e" + m[1].translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")), text
    )
    return complex(text.replace(" ", "").replace("i", "j")) if "i" in text.removeprefix("inf") else float(text)


def check(shown, movie, scene: Scene, n, chosen=0):
    """Compare everything that the page shows with the scene and with the equations in Python."""
    z1 = scene.distances[chosen]
    r, alpha = scene.z2 / z1, np.radians(scene.alpha)
    P, nu, M = rotation.P(r, alpha), np.degrees(rotation.nu(r, alpha)), rotation.M(r, alpha)
    assert re.fullmatch(rf"frames/{movie}-{scene.name}-{scene.sheet}-{n:03}-[0-9a-f]{{8}}\.webp", shown["file"])
    assert number(shown["alpha"]) == pytest.approx(scene.alpha, abs=0.0501)
    for name, value in (("z1", z1), ("z2", scene.z2), ("r", r), ("M", M)):
        assert number(shown[name]) == pytest.approx(value, rel=5.01e-4), name
    assert number(shown["nu"]) == pytest.approx(nu, abs=0.0501, nan_ok=True)
    if np.isinf(P):
        assert shown["P"] == shown["M"] == "∞" and shown["nu"] == "undefined"
        assert shown["corners"][2] is None and "infinitely far away" in shown["alt"]
    else:
        assert abs(number(shown["P"]) - P) <= 1e-3 * max(1, abs(P))
        # what is seen: of prisms as large as these
        nu, M = scene.nu_and_M(z1)
        said = re.search(r"rotated by ν = (\S+) and M = (\S+( × \S+)?) times", shown["alt"])
        assert number(said[1]) == pytest.approx(nu, abs=0.0501, nan_ok=True)
        assert number(said[2]) == pytest.approx(M, rel=5.01e-4)
        if scene.sheet == "detailed":
            assert shown["explanation"].endswith(f"Through these prisms: ν = {said[1]}, M = {said[2]}.")
    assert shown["spoken"].endswith(f": P = {shown['P']}, ν = {shown['nu']}, M = {shown['M']}")
    assert f"r = {shown['r']}" in shown["diagram"] and f"ν = {shown['nu']}" in shown["diagram"]
    assert ("infinitely fine" in shown["alt"]) == (scene.sheet == "ideal")

    L, E, drawn = (corner and complex(*corner) for corner in shown["corners"])
    if drawn:
        assert abs((drawn - L) / (E - L) - P) * abs(E - L) < 0.5  # pixels
    else:
        assert abs(P - 0.5) > 0.5  # out of the picture

    seen = scene.apparent_position(scene.L, z1)
    width, height = scene.view * shown["frame"], scene.view
    inside = abs(seen.real) < width / 2 - 0.08 and abs(seen.imag) < height / 2 - 0.08
    assert (shown["predicted"] is not None) == inside
    if inside:
        assert abs(complex(*shown["predicted"]) - complex(*shown["middle"]) - shown["tile"] * seen) < 0.5  # pixels
    beyond = [drawn is None and np.isfinite(P), not inside and np.isfinite(P) and np.isfinite(seen)]
    assert shown["arrows"] == sum(map(int, beyond))


# ---- The equations ----

ALPHAS = np.radians(np.linspace(-360, 360, 49))
ALPHAS = np.unique([*ALPHAS, *(np.nextafter(s * np.pi, d) for s in (-1, 1) for d in (-9, 9)), np.pi - 1e-6, 1 - np.pi])
RATIOS = np.unique([*np.geomspace(1e-3, 1e3, 7), 1, np.nextafter(1, 0), np.nextafter(1, 2), 1 + 1e-9])


def compare(given, wanted):
    """Compare numbers from the page, complex ones as pairs, with Python's to 1e-12, and infinite ones exactly."""
    given = np.array(given, float)
    given = given[:, 0] + 1j * given[:, 1] if given.ndim == 2 else given
    finite = np.isfinite(wanted)
    assert np.array_equal(given[~finite], wanted[~finite])
    assert (abs(given[finite] - wanted[finite]) <= 1e-12 * abs(wanted[finite])).all()


def test_equations_are_those_of_rotation(page):
    r, alpha = (grid.ravel() for grid in np.meshgrid(RATIOS, ALPHAS))
    grid = [*zip(r.tolist(), alpha.tolist(), strict=True)]
    given = page.evaluate(
        """(grid) => Object.fromEntries(["P", "oneMinusP", "M", "nu"].map(
            (name) => [name, grid.map((numbers) => equations[name](...numbers))]))""",
        grid,
    )
    assert np.isinf(rotation.P(r, alpha)).sum() == 2  # r = 1, alpha = pi and -pi
    compare(given["P"], rotation.P(r, alpha))
    compare(given["oneMinusP"], rotation.one_minus_P(r, alpha))
    compare(given["M"], rotation.M(r, alpha))
    assert np.array(given["nu"]) == pytest.approx(rotation.nu(r, alpha), abs=1e-12, nan_ok=True)


def test_positions_are_those_of_rotation_and_paraxial(page):
    rng = np.random.default_rng(3)
    L, E = (rng.uniform(-2, 2, 500) + 1j * rng.uniform(-2, 2, 500) for _ in range(2))
    z1, z2 = (rng.choice([0.5, 2, 6, *np.geomspace(0.3, 3000, 9)], 500) for _ in range(2))
    alpha, prism = rng.choice(ALPHAS, 500), Prism(rng.choice([2.4 / 25, 2.4 / 100, 2.4 / 1600], 500), base_angle=40)
    lengths = zip(prism.slab_shift, prism.separation, strict=True)
    grid = [
        ([L.real, L.imag], [E.real, E.imag], *map(float, rest), {"slab_shift": shift, "separation": separation})
        for L, E, *rest, (shift, separation) in zip(L, E, z1, z2, alpha, lengths, strict=True)
    ]
    compare(
        page.evaluate("(grid) => grid.map((numbers) => equations.ideal(...numbers.slice(0, 5)))", grid),
        rotation.apparent_position(L, E, z1, z2, alpha),
    )
    compare(
        page.evaluate("(grid) => grid.map((numbers) => equations.prisms(...numbers))", grid),
        paraxial.apparent_position(L, E, z1, z2, alpha, prism),
    )
    turned = page.evaluate(
        """(grid) => grid.map(([L, E, ...numbers]) => equations.turned(...numbers))
           .map(({ nu, M }) => [Number.isNaN(nu) ? null : nu, M])""",
        grid,
    )
    nu, M = paraxial.nu_and_M(z1, z2, alpha, prism)
    assert np.array([given for given, _ in turned], float) == pytest.approx(nu, abs=1e-12, nan_ok=True)
    compare([given for _, given in turned], M)


@pytest.mark.parametrize("offset", [(0.1, 0.05), (0.004, 0.003)])
def test_paths_are_parted_at_infinity(page, offset):
    """Paths are interrupted at infinity. Every other point of a path is close to a predicted position."""
    path = """([movie, offset, prism]) => {
      state.movie = { ...state.movie, L: plus(state.movie.E, offset), prism };
      const now = { ...moment(), alpha: Math.PI };
      drawPrediction(now);
      const name = state.movie.sweep === "alpha" ? "of-r" : "of-alpha";
      const lines = document.querySelector(`#overlay path.${name}`).getAttribute("d").split("M").slice(1);
      return [now.z1, now.z2, lines.map((line) => line.split("L").map((point) => point.split(" ").map(Number)))];
    }"""
    for movie, prisms in ((ALPHA, 20), (POLE, 20), (POLE, 300)):
        opened(page, movie)
        page.evaluate(MOVE, 1)
        prism = Prism(2.4 / prisms)
        lengths = {"slab_shift": prism.slab_shift, "separation": prism.separation}
        z1, z2, lines = page.evaluate(path, [movie, offset, lengths])
        steps = np.geomspace(1e-7, 1, 30_000)
        alpha, z = np.pi, z2 * np.exp(np.concatenate((-8 * steps, 8 * steps)))
        poles = paraxial.infinite_z1(z2, alpha, prism).real
        z = np.concatenate((z, *(pole + s * steps for pole in poles for s in (-1, 1))))
        if movie == ALPHA:
            poles, z = np.append(paraxial.infinite_alpha(z1, z2, prism).real, np.pi), z1
            alpha = np.concatenate([s * pole + t * 3 * steps for pole in poles for s in (-1, 1) for t in (-1, 1)])
            alpha = np.append(alpha, np.linspace(-np.pi, np.pi, 30_000))
        E = complex(*page.evaluate("state.movie.E"))
        true = paraxial.apparent_position(E + complex(*offset), E, z, z2, alpha, prism)
        true = np.unique(np.round(200 * true[abs(true) < 3]) / 200)  # half of a hundredth of a tile
        for line in lines:
            x, y = np.transpose(line) / 100
            part = np.linspace(0, 1, 9)[:, None]
            drawn = (x - 1j * y)[:-1] * (1 - part) + (x - 1j * y)[1:] * part
            for place in drawn[abs(drawn) < 2.4][::3]:
                assert abs(true - place).min() < 0.02


# ---- One slider moves all ----


@pytest.mark.parametrize("sheet", SHEETS)
@pytest.mark.parametrize("movie", MOVIES)
def test_the_slider_moves_all_at_once_and_both_ways(page, movie, sheet):
    opened(page, movie)
    page.locator(f"#{sheet}").click()
    wanted = scenes(SPECS[movie], "standard")[sheet]
    forth = [*range(len(wanted))]
    for n in [*forth, *forth[::-1], len(wanted) // 2]:
        chosen = wanted[n].distances.index(wanted[n].z2) if movie in (SPHERES, Z2) else 0
        check(page.evaluate(MOVE, n), movie, wanted[n], n, chosen)


def test_keys_step(page):
    wanted = scenes(SPECS[ALPHA], "standard")["detailed"]
    n = 0
    for key, n in (("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", 4), ("ArrowRight", 4), ("Home", 0)):
        page.keyboard.press(key)
        check(page.evaluate(f"({READ})()"), ALPHA, wanted[n], n)
    page.locator("#slider").focus()
    for key, n in (("ArrowRight", 1), ("ArrowUp", 2), ("ArrowLeft", 1), ("End", 4), ("Home", 0)):
        page.keyboard.press(key)
        check(page.evaluate(f"({READ})()"), ALPHA, wanted[n], n)


def test_the_slider_is_dragged(page):
    box = page.locator("#slider").bounding_box()
    page.mouse.move(box["x"] + 12, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, steps=5)
    page.mouse.up()
    check(page.evaluate(f"({READ})()"), ALPHA, scenes(SPECS[ALPHA], "standard")["detailed"][2], 2)


def test_the_frame_is_the_one_that_is_rendered(page):
    style = page.add_style_tag(
        content=f"#frame {{ position: fixed !important; left: 0; top: 0; width: {SIZE[0]}px !important }}"
    )
    page.keyboard.press("o")  # no prediction over it
    for movie in (ALPHA, SPHERES):
        opened(page, movie)
        for sheet, wanted in scenes(SPECS[movie], "standard").items():
            page.locator(f"#{sheet}").click()
            rendered = [still.render(scene, size=SIZE, antialias="off").astype(float) for scene in wanted]
            for n in range(1, len(wanted)):
                page.evaluate(MOVE, n)
                shown = picture(page.locator("#frame").screenshot())
                errors = [np.sqrt(((shown - other) ** 2).mean()) for other in rendered]
                assert errors[n] < 16 and np.argmin(errors) == n  # of 255: lossy, with halved chroma
                assert sorted(errors)[1] > 2 * errors[n]
    style.evaluate("(tag) => tag.remove()")


def picture(png):
    import imageio.v3 as iio

    return iio.imread(png)[..., :3].astype(float)


# ---- Switches ----


def test_prisms_or_ideal_sheet(page):
    page.evaluate(MOVE, 2)
    both = {sheet: made[2] for sheet, made in scenes(SPECS[ALPHA], "standard").items()}
    for press, sheet in (
        (lambda: page.locator("#ideal").click(), "ideal"),
        (lambda: page.keyboard.press("p"), "detailed"),
        (lambda: page.keyboard.press("P"), "ideal"),
        (lambda: page.get_by_role("button", name="2 × 100 prisms").click(), "detailed"),
    ):
        press()
        check(page.evaluate(f"({READ})()"), ALPHA, both[sheet], 2)
        for name in SHEETS:
            expect(page.locator(f"#{name}")).to_have_attribute("aria-pressed", str(name == sheet).lower())


def test_prediction_on_and_off(page):
    switch = page.get_by_role("switch", name="Prediction")
    expect(switch).to_be_checked()
    with_it = page.locator("#frame").screenshot()
    switch.click()
    expect(switch).not_to_be_checked()
    assert page.locator("#overlay *").count() == 0
    without = page.locator("#frame").screenshot()
    assert abs(picture(with_it) - picture(without)).max() > 100  # the lines of the overlay are bright
    page.keyboard.press("o")
    expect(switch).to_be_checked()
    again = page.locator("#frame").screenshot()
    assert abs(picture(with_it) - picture(again)).max() < 20  # Chromium may paint part of it anew, a little otherwise


def test_the_path_and_the_rings_of_a_prediction(page):
    """P lies on its path as alpha changes. The spheres lie on the curve of their alpha."""
    read = """(id) => [
      document.querySelector(`#overlay path.${id}`).getAttribute("d"),
      [...document.querySelectorAll("#overlay .mark")].map((ring) => [ring.cx.baseVal.value, ring.cy.baseVal.value]),
    ]"""

    def distances(kind):
        """The distance of each ring from the path, in hundredths of a tile."""
        path, rings = page.evaluate(read, kind)
        starts, steps = [], []
        for line in path.split("M")[1:]:
            x, y = np.transpose([[float(x) for x in point.split()] for point in line.split("L")])
            starts.append((x + 1j * y)[:-1])
            steps.append(np.diff(x + 1j * y))
        start, step = np.concatenate(starts), np.concatenate(steps)
        found = []
        for x, y in rings:
            with np.errstate(invalid="ignore"):
                part = np.nan_to_num((((x + 1j * y) - start) * step.conj()).real / abs(step) ** 2).clip(0, 1)
            found.append(abs(start + part * step - (x + 1j * y)).min())
        return found

    for sheet in SHEETS:
        opened(page, ALPHA)
        page.locator(f"#{sheet}").click()
        for n in range(4):
            page.evaluate(MOVE, n)
            assert max(distances("of-r")) < 0.5
        opened(page, SPHERES)
        for n in range(2):
            page.evaluate(MOVE, n)
            found = distances("of-alpha")
            assert len(found) == 11 and max(found) < 1


def test_spheres_are_chosen(page):
    opened(page, SPHERES)
    wanted = scenes(SPECS[SPHERES], "standard")["detailed"]
    page.evaluate(MOVE, 1)
    assert page.locator("#diagram .other").count() == 11
    names = page.locator("#sphere option").all_text_contents()
    assert names[0] == "z₁ = 2⁻⁵ z₂" and names[5:7] == ["z₁ = z₂", "z₁ = 2¹ z₂"]
    for n, name in ((3, names[3]), (9, names[9])):
        page.get_by_label("sphere at").select_option(name)
        check(page.evaluate(f"({READ})()"), SPHERES, wanted[1], 1, n)
    opened(page, ALPHA)
    expect(page.locator("#sphere")).to_be_hidden()
    opened(page, SPHERES)  # the page remembers the frame and the sphere
    check(page.evaluate(f"({READ})()"), SPHERES, wanted[1], 1, 9)


# ---- Play ----


@pytest.mark.parametrize("press", ["key", "button"])
def test_play_and_pause(page, press):
    toggle = (lambda: page.keyboard.press("Space")) if press == "key" else page.locator("#play").click
    assert page.evaluate("slider.value") == "0"
    toggle()
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    page.wait_for_function("slider.valueAsNumber >= 2")
    toggle()
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    n = page.evaluate("slider.valueAsNumber")
    check(page.evaluate(f"({READ})()"), ALPHA, scenes(SPECS[ALPHA], "standard")["detailed"][n], n)
    still = page.evaluate(
        """() => new Promise((done) => {
            const start = performance.now();
            const wait = (now) => (now - start > 350 ? done(slider.valueAsNumber) : requestAnimationFrame(wait));
            requestAnimationFrame(wait);
        })"""
    )
    assert still == n
    toggle()
    page.wait_for_function("slider.value === slider.max && !state.playing")
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    toggle()  # from the start again
    page.wait_for_function("slider.valueAsNumber > 0 && slider.value !== slider.max")


def test_it_plays_at_the_movies_rate(page):
    page.keyboard.press("Space")
    seconds = page.evaluate(
        """() => new Promise((done) => {
            let start = 0;
            const wait = (now) => {
              if (!start && slider.valueAsNumber === 1) start = now;
              if (slider.value === slider.max) done((now - start) / 1000);
              else requestAnimationFrame(wait);
            };
            requestAnimationFrame(wait);
        })"""
    )
    # Three steps take 0.4 s each. The first may have been late by a step, for which the page makes up. A busy machine
    # takes longer.
    assert seconds > 0.75


def test_scrubbing_stops_it(page):
    page.keyboard.press("Space")
    page.wait_for_function("slider.valueAsNumber >= 1")
    page.evaluate(MOVE, 3)
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    assert page.evaluate("slider.value") == "3"


# ---- Tabs ----


def test_tabs(page):
    tabs = page.get_by_role("tab")
    assert tabs.all_text_contents() == [
        "Knight, α from 0 to 180°",
        "King, z₁ from 0.7 to 60",
        "Spheres, α from 0 to 180°",
        "Knight, z₁ from 3 to 9",
        "Spheres, z₂ from 3 to 9",
    ]
    tabs.nth(0).focus()
    for key, n in (("ArrowRight", 1), ("ArrowLeft", 0), ("ArrowLeft", 4), ("ArrowRight", 0), ("End", 4), ("Home", 0)):
        page.keyboard.press(key)
        expect(tabs.nth(n)).to_be_focused()
        expect(page.get_by_role("tab", selected=True)).to_have_count(1)
        expect(tabs.nth(n)).to_have_attribute("aria-selected", "true")
        expect(page.get_by_role("tabpanel")).to_have_attribute("aria-labelledby", f"tab-{n + 1}")
    page.keyboard.press("Space")
    page.wait_for_function("slider.valueAsNumber >= 1")
    tabs.nth(1).click()  # stops it; the keys are the slider's then
    loaded(page)
    page.keyboard.press("ArrowRight")
    check(page.evaluate(f"({READ})()"), Z1, scenes(SPECS[Z1], "standard")["detailed"][1], 1)
    assert "king" in page.locator("#shown").get_attribute("alt")


# ---- The pole ----


@pytest.mark.parametrize(("movie", "n"), [(SPHERES, 2), (POLE, 1)])
@pytest.mark.parametrize("sheet", SHEETS)
def test_the_pole(page, movie, n, sheet):
    opened(page, movie)
    page.locator(f"#{sheet}").click()
    shown = page.evaluate(MOVE, n)
    assert (shown["P"], shown["M"], shown["nu"]) == ("∞", "∞", "undefined")
    assert "P is infinitely far" in page.locator("#diagram").text_content()
    expect(page.locator("#explanation")).to_have_text("P is infinitely far away: no light from L reaches E.")
    page.evaluate(MOVE, n - 1)
    assert "infinitely" not in page.locator("#diagram").text_content() + page.locator("#explanation").text_content()


def test_nothing_is_nan(page):
    for movie in MOVIES:
        opened(page, movie)
        for sheet in SHEETS:
            page.locator(f"#{sheet}").click()
            for n in range(MOVIES[movie][-1]):
                page.evaluate(MOVE, n)
                html = page.evaluate("document.querySelector('main').outerHTML")
                assert not re.search(r"NaN|Infinity|null|\[object", html)
                assert len(page.locator("#diagram path.of-r").get_attribute("d")) > 1000


# ---- Text, accessibility, layout ----


def test_a_title_is_text(page, made):
    expect(page.locator("#title")).to_have_text(HOSTILE)
    expect(page.get_by_role("tab").first).to_have_attribute("title", HOSTILE)
    assert page.locator("b").count() == 0
    assert page.evaluate("window.broken") is None
    assert page.locator("script").count() == 2


def test_the_scripts_and_styles_are_included_raw(made):
    """Jinja changes nothing in them, whatever braces they contain."""
    html, folder = made.read_text(), PROJECT / "templates" / "demo"
    files = [*folder.glob("*.js"), folder / "page.css"]
    assert len(files) > 5 and any("{{" in path.read_text() for path in files)
    for path in files:
        assert html.count(path.read_text()) == 1, path


def test_every_control_has_a_name(page):
    opened(page, SPHERES)
    tree = page.context.new_cdp_session(page).send("Accessibility.getFullAXTree")
    nodes = [node for node in tree["nodes"] if not node["ignored"]]
    named = {"button", "tab", "slider", "combobox", "switch", "image", "img", "tabpanel", "tablist", "group", "heading"}
    found = [(node["role"]["value"], node.get("name", {}).get("value", "")) for node in nodes]
    controls = [(role, name) for role, name in found if role in named]
    assert {"button", "tab", "slider", "combobox", "switch", "tabpanel", "tablist"} <= {role for role, _ in controls}
    assert all(name.strip() for _, name in controls), controls
    assert page.locator("math").count() == 7  # formulas are MathML


@pytest.mark.parametrize("width", [360, 700, 900, 1280])
def test_nothing_is_cut_off(page, width):
    page.set_viewport_size({"width": width, "height": 740 if width < 1280 else 720})
    for movie in MOVIES:
        opened(page, movie)
        for n in range(MOVIES[movie][-1]):
            page.evaluate(MOVE, n)
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            cut = """[...document.querySelectorAll("dl div, button, figcaption, .controls, #value")]
              .filter((part) => part.scrollWidth > part.clientWidth + 1).map((part) => part.textContent)"""
            assert page.evaluate(cut) == []
    if width == 1280:
        assert page.evaluate("document.documentElement.scrollHeight") <= 720


def test_on_a_phone_the_slider_stays_in_sight(page):
    page.set_viewport_size({"width": 360, "height": 740})
    for y in (0, 10000):
        page.evaluate("(y) => scrollTo(0, y)", y)
        expect(page.locator("#slider")).to_be_in_viewport(ratio=1)


def test_a_prediction_that_is_off_by_pixels_is_said_to_be(page):
    """The page says so for exactly the scenes for which povgen prints a warning."""
    unsure = "(z1) => { const now = moment(); return unsure({ ...now, z1, r: now.z2 / z1 }); }"
    for movie in (ALPHA, POLE):
        opened(page, movie)
        for sheet, wanted in scenes(SPECS[movie], "standard").items():
            page.locator(f"#{sheet}").click()
            for n, scene in enumerate(wanted):
                page.evaluate(MOVE, n)
                for z1 in (scene.z1, 2, 4, 5, 5.5, 5.8, 5.97, 6.02, 7, 20):
                    if (scene.alpha, z1) != (180, 6):  # the pole, where there is no predicted image
                        predicted = Chess(
                            **scene.model_dump(exclude={"z1", "predicted_image"}), z1=z1, predicted_image=True
                        )
                        warned = "predicted_image" in dict(prediction.warnings(predicted))
                        assert page.evaluate(unsure, z1) == warned
                        if z1 == scene.z1:
                            assert ("wrong by pixels" in page.locator("#explanation").text_content()) == warned


# ---- The folder ----


def test_a_page_takes_the_place_of_another(tmp_path):
    """Frames that only the old page showed are removed. The user's files stay."""
    (tmp_path / "mine.txt").write_text("mine")
    short = spec("spheres", {"prisms": 30, "z1": [1, 3]}, "alpha", 10, 20, 2, title="Short")
    page = demo([short], tmp_path, size=(64, 48), antialias="off")
    first, *others = sorted((tmp_path / "frames").iterdir())
    assert len(others) == 3 and all(path.name in page.read_text() for path in (first, *others))
    # a frame that the user changed, and one that no page of povgen's shows
    mine = {first: b"mine", first.with_name(f"7{others[0].name}"): others[0].read_bytes()}
    for path, data in mine.items():
        path.write_bytes(data)
    demo([short.model_copy(update={"title": "Other"})], tmp_path, size=(48, 48), antialias="off")
    shown = set(re.findall(r"[^/]*[.]webp", page.read_text()))
    assert len(shown) == 4 and {path.name for path in (tmp_path / "frames").iterdir()} - shown == {p.name for p in mine}
    assert all(path.read_bytes() == data for path, data in mine.items())
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert {path.name for path in tmp_path.iterdir()} == {"mine.txt", "index.html", "frames"}


def test_what_cannot_be_is_refused_before_anything_is_rendered(tmp_path, monkeypatch):
    monkeypatch.setattr("povgen.teach.page.render_all", None)
    folder = tmp_path / "page"
    for specs, words in (
        ([], "one or more"),
        (["no-such-movie"], "vary-alpha"),
        ([spec("chess", {"prisms": 5, "sheet": "ideal"}, "alpha", 0, 9, 2, title="Few")], "'Few': z1 = 2"),
        ([spec("chess", {}, "prisms", 10, 99, 2, title="N")], "'N': sweep of prisms: not for the page; allowed"),
        (
            [SPECS[ALPHA].model_copy(update={"loop": True, "title": "O"})],
            "'O': sweep of alpha, there and back: not for",
        ),
    ):
        with pytest.raises(InputError, match=re.escape(words)):
            demo(specs, folder)
        assert not folder.exists()
    with pytest.raises(InputError, match="quality"):
        demo(["vary-alpha"], folder, quality="best")
    folder.mkdir()
    (folder / "index.html").write_text("<p>My homepage</p>")
    with pytest.raises(InputError, match="povgen did not write the index.html there"):
        demo(["vary-alpha"], folder)
    assert [(path.name, path.read_text()) for path in folder.iterdir()] == [("index.html", "<p>My homepage</p>")]
    with pytest.raises(InputError, match="File exists"):
        demo(["vary-alpha"], folder / "index.html")


def test_the_command(tmp_path):
    (tmp_path / "short.toml").write_text(
        'title = "Short"\nscene = "chess"\nframe_rate = 10\nframes = 2\n'
        '[[sweep]]\nparameter = "alpha"\nstart = 10\nstop = 20\n'
    )
    arguments = ["demo", "short.toml", "--quality", "draft", "--size", "64x48", "-o", "a page"]
    done = subprocess.run([POVGEN, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and "wrote a page/index.html" in done.stdout
    assert "4/4 frames" in done.stderr
    assert len(list((tmp_path / "a page" / "frames").glob("1-chess-*.webp"))) == 4
    for wrong in (["nowhere"], ["--quality", "best"], ["--workers", "0"], ["-o", "a page/index.html"]):
        assert len(refused(["demo", *wrong], tmp_path).splitlines()) == 1


def test_a_page_that_fails_leaves_the_other_whole(tmp_path, monkeypatch):
    """The old page survives an error while frames are made, and an error after that."""
    short = spec("spheres", {"prisms": 30, "z1": [1, 3]}, "alpha", 10, 20, 2, title="Short")
    page = demo([short], tmp_path, size=(64, 48), antialias="off")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.*")}
    for what in ("picture", "to_html"):
        with monkeypatch.context() as patch, pytest.raises(ZeroDivisionError):
            patch.setattr(f"povgen.teach.page.{what}", lambda *_: 1 / 0)
            demo([short], tmp_path, size=(48, 48), antialias="off")
        assert {path: path.read_bytes() for path in tmp_path.rglob("*.*")} == before and page in before
