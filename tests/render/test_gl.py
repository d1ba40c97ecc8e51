"""The renderer gl: its pictures against POV-Ray's, its rays against the ray trace, and its processes."""

import json
import multiprocessing
import os
import signal
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from io import BytesIO

import numpy as np
import pytest
from conftest import povgen as run
from conftest import refusal, refused, some, wait_for
from PIL import Image
from references import converged

import povgen
from povgen import Chess, InputError, PovrayError, Spheres, remedies
from povgen.errors import TransientError
from povgen.inputs.pictures import mountains
from povgen.measure import verify_gl
from povgen.measure.opengl import OpenGLView
from povgen.measure.probes import Directions
from povgen.optics.profile import Profile
from povgen.optics.trace import End
from povgen.rendering import cache, frames, gl, gl_runner, gl_scene, light
from povgen.rendering.views import check_gl
from povgen.rendering.volumes import volumes
from povgen.scene.presets import pieces
from povgen.settings import Rendering

SIZE = (160, 120)
SMALL = Rendering(renderer="gl", size=(64, 48), antialias="2x")
PLAIN = Chess(sheet="none")


@pytest.fixture
def text():
    return gl_scene.to_text(PLAIN, volumes(pieces(PLAIN)))


@pytest.fixture
def runner():
    started = gl_runner.Runner()
    yield started
    started.stop()


@pytest.fixture
def drawer(monkeypatch):
    """A function that returns a drawer with tiles of this side."""

    def made(side):
        monkeypatch.setattr(gl, "TILE", side)
        return gl.Drawer()

    return made


# ---- What it draws ----


@pytest.mark.parametrize("sheet", ["none", "ideal", "detailed"])
def test_the_points_that_pixels_show_are_on_the_spheres(sheet):
    """Where the rays of `Scene.trace` meet the first sphere."""
    scene = Spheres(sheet=sheet, z1=(2, 5), line=(-0.15, 0.1), prisms=40, view=1)
    found, traced = povgen.points(scene, SIZE), scene.trace(scene.rays(SIZE))
    nearest = np.full(SIZE[::-1], np.inf)
    for (L, z1), radius in zip(scene.objects, scene.radii, strict=True):
        offset = traced.position - (L.real, L.imag, z1)
        half = (offset * traced.direction).sum(-1)
        square = half**2 - (offset**2).sum(-1) + radius**2
        nearest = np.minimum(nearest, np.where(square > 1e-4, -half - np.sqrt(np.maximum(square, 0)), np.inf))
    meets = np.isfinite(nearest) & (traced.end == 0)
    expected = traced.position + np.where(meets, nearest, 0)[..., None] * traced.direction
    off = np.linalg.norm(found - expected, axis=-1)[meets]
    assert meets.sum() > 100 and (off < 2e-3).mean() > 0.99
    assert np.isnan(found).any() and found.shape == (120, 160, 3)


def test_points_of_what_is_no_scene_are_refused():
    for call, words in (
        (lambda: povgen.points(3, SIZE), "scene = 3"),
        (lambda: povgen.points(PLAIN, (3, 3)), "size = (3, 3)"),
        (lambda: povgen.points(PLAIN.replace(fresnel=True), SIZE), "fresnel = true"),
        (lambda: povgen.render(Directions(), renderer="gl"), "the renderer gl does not know this class"),
    ):
        assert words in refusal(call)


def holding(figures, count):
    """Check that there are so many measured values, all within their bounds."""
    figures = list(figures)
    assert len(figures) == count and all(figure.holds for figure in figures), figures


@pytest.mark.parametrize(
    "scene",
    some(
        [
            Chess(sheet="detailed", alpha=50),
            Chess(sheet="none", piece=("knight", "king"), x=(0, 0.6), z1=(2, 3)),
            Chess(alpha=50, window="z=2,alpha=20,prisms=60,index=1.7,tops=black", z2=8),
            Spheres(sheet="ideal", eye=(0.2, 0.1)),
            Chess(sheet="single", tops="black", prisms=30),
            Chess(sheet="axis", axis=(0.3, 1, 0.2), alpha=15),
            Chess(sheet="law", law="x - k*X*z, y, z", parameter={"k": 0.1}),
            Chess(
                sheet="ideal", alpha=50, window=("alpha=75,z=2", "alpha=20,z=4,sheet=detailed"), z2=8, eye=(0.6, 0.1)
            ),
        ],
        1,
    ),
    ids=["detailed", "none", "other prisms in series", "spheres", "black tops", "axis", "law", "ideal before prisms"],
)
def test_pictures_agree_with_povray(scene, monkeypatch):
    rendered = verify_gl.rendered
    monkeypatch.setattr(
        verify_gl,
        "rendered",
        lambda scenes, size, *sampling: [converged(scene, size)] if sampling else rendered(scenes, size),
    )
    kind = "detailed" if scene.has_prisms else scene.sheet
    # the squares of the distant floor differ in more of a small picture's pixels: the camera of ideal sheets
    # interpolates its rays
    shown = (320, 240) if scene.ideal and scene.has_prisms else SIZE
    found = [*verify_gl.pictures(kind, [scene], shown, (120, 90))]
    if scene.ideal and scene.has_prisms and found[0].value > 97:
        # light that comes back from the prisms is bent again by the ideal sheets, but not by POV-Ray's camera
        del found[0]
    holding(found, 1 if scene.ideal and scene.has_prisms else 2)


@pytest.mark.parametrize("every", some([4, 1], 1))
def test_directions_agree_with_the_ray_trace(every):
    # in smaller pictures a few rays more or less decide
    holding(verify_gl.directions(verify_gl.PRISM_SCENES[::every], (320, 240)), 2)


TWO = [
    povgen.Window(sheet="detailed", alpha=66, x=-0.5, yaw=20, pitch=10, name="near"),
    povgen.Window(sheet="single", prisms=60, outline="round", width=3, height=2.5, x=0.4, z=3.5, yaw=-25, name="far"),
]


@pytest.mark.parametrize(
    "scene",
    [
        Chess(),
        Chess(error={"turn": 1, "tilt_x": 2, "far_tilt_y": 1, "index": 0.01}),
        Chess(sheet="ideal", window="z=2,alpha=20,sheet=single,tops=black", z2=8),
        povgen.Room(TWO, eye=povgen.Eye(z=-8)),
        Chess(sheet="lenticular"),
        Chess(sheet="profile", profile="lenticulars"),
    ],
    ids=["pair", "errors", "ideal before single", "room", "lenses", "profile"],
)
def test_rays_of_ones_own_agree_with_the_ray_trace(scene, rng):
    """As well as the ray trace agrees with itself for rays that start 1e-7 tiles aside: lenses part them."""
    z, half = [opening.pose.z for opening in scene.openings], 10_000
    aim = rng.uniform((-1.7, -1.7, 0), (1.7, 1.7, 0), (2, half, 3)) + [[[0, 0, min(z)]], [[0, 0, max(z)]]]
    away = rng.uniform((-4, -4, 7), (4, 4, 9), (2, half, 3)) * [[[1, 1, -1]], [[1, 1, 1]]]
    aside = 1e-7 * rng.normal(size=aim.shape)
    exact, beside = (scene.trace(povgen.Bundle(start, -away), 40) for start in (aim + away, aim + away + aside))
    found = scene.trace(povgen.Bundle(aim + away, -away), 40, device="gl")

    def off(other, name):
        return np.linalg.norm(getattr(other, name) - getattr(exact, name), axis=-1)

    def differing(other):
        same = (other.orders == exact.orders).all(-1) & (other.windows[..., 0] == exact.windows[..., 0])
        for name in ("end", "count", "designed", "last"):
            same &= getattr(other, name) == getattr(exact, name)
        # the outer lenses end at the frame: rounding decides whether a ray goes on to the next border
        unsure = (exact.end == End.FRAME) & isinstance(scene.layered[0].shape, Profile)
        same &= (off(other, "direction") < 1e-3) & ((off(other, "position") < 1e-3) | unsure)
        return 1 - same.mean()

    ends = {*exact.end.flat}
    assert {End.THROUGH, End.FRAME, End.BESIDE} <= ends and ends & {End.BACK, End.ABSORBED}
    assert differing(found) < 1.3 * differing(beside) + 0.001
    designed = exact.designed & found.designed
    assert designed.mean() > 0.03
    assert off(found, "position")[designed].max() < 1e-5
    assert off(found, "direction")[designed].max() < 1e-4
    assert found.faces.shape == (2, half, 0) and not found.reflected.any() and (found.light == 1).all()


def test_what_rays_on_the_device_cannot_do_is_refused():
    rays = Chess().rays((8, 6))
    for scene, values, words in (
        (Chess(), {"path": True}, "keeps no path"),
        (Chess(), {"partial": np.random.default_rng(1)}, "splits no rays"),
        (Chess(error={"facets": 0.1}), {}, "equal prisms"),
        (Chess(sheet="lenticular", error={"pitch": 0.01}), {}, "one pitch"),
    ):
        with pytest.raises(InputError, match=words):
            scene.trace(rays, device="gl", **values)
    with pytest.raises(InputError, match="device = 'cuda': allowed: 'numpy' or 'gl'"):
        Chess().trace(rays, device="cuda")


def test_windows_without_sheets_before_prisms_leave_light_as_it_is():
    for windows in (("z=3,sheet=detailed",), ("z=1.5", "z=3,sheet=detailed"), ("z=1.5", "z=3", "z=4.5,sheet=single")):
        holding(verify_gl.directions([{"sheet": "none", "prisms": 30, "window": windows}], SIZE), 2)


def test_directions_disagree_with_another_glass(monkeypatch):
    """The check can fail: the shader's index is wrong by a thousandth."""
    true = OpenGLView.set
    monkeypatch.setattr(
        OpenGLView, "set", lambda view, scene: true(view, scene.replace(index=1.0015 * scene.index, alpha=66.1))
    )
    assert not any(figure.holds for figure in verify_gl.directions(({},), SIZE))


def test_positions_agree_with_the_predictions():
    holding(verify_gl.positions(6, (240, 180)), 3)


@pytest.mark.parametrize("outline", ["rectangle", "round"])
def test_light_ends_at_the_wall_of_a_frame_not_at_the_face_behind_it(outline):
    room = povgen.Room([povgen.Window(sheet="detailed", prisms=8, yaw=10, outline=outline)], eye=povgen.Eye(view=4))
    traced, points = room.trace(room.rays(SIZE), path=True), povgen.points(room, SIZE)
    within = (traced.end == End.FRAME) & (traced.count > 0)
    (opening,) = room.openings
    x, y, z = opening.pose.own(traced.position[within], traced.direction[within])[0].T
    width, height, is_round = opening.outline
    side = np.hypot(x / width, y / height) if is_round else np.maximum(abs(x) / width, abs(y) / height)
    np.testing.assert_allclose(side, 0.5, rtol=1e-12)
    assert len(z) > 100 and (abs(z) < opening.deep.frame / 2).all()
    near = np.linalg.norm(points[within] - traced.position[within], axis=-1) < 1e-4
    assert near.mean() > 0.95  # pictures follow fewer faces
    last = np.isfinite(traced.corners[..., 0]).sum(-1)[within] - 1
    assert (traced.corners[within][range(len(z)), last] == traced.position[within]).all()


@pytest.mark.parametrize(
    ("values", "yaw"),
    [
        ({"sheet": "refraction", "ratio": 0.5, "alpha": 40}, 120),  # the eye is beyond the critical angle
        ({"sheet": "refraction", "ratio": 10}, 180),  # most light is totally reflected
        ({"sheet": "lens", "focal_length": 0.1}, 180),
    ],
)
def test_an_ideal_sheet_seen_from_behind_bends_light_as_the_trace_does(values, yaw):
    room = povgen.Room([povgen.Window(**values, yaw=yaw, width=2, height=2, frame=False)], eye=povgen.Eye(view=2.2))
    traced, read = room.trace(room.rays((48, 48))), OpenGLView(room).readout((48, 48))
    passes, meets = traced.end <= End.BACK, traced.windows[..., 0] == 0
    assert ((read["shown"][..., 0] >= 0) == passes)[meets].all() and (passes & meets).sum() > 500
    assert np.linalg.norm(read["ray"][..., :3] - traced.direction, axis=-1)[passes].max() < 1e-4


@pytest.mark.release
def test_costs_are_measured_against_povrays():
    detailed, ideal = verify_gl.costs((64, 48), 1)
    assert 0 < ideal.value and 0 < detailed.value < 5


def test_a_piece_of_ones_own(tmp_path):
    file = tmp_path / "ball.inc"
    file.write_text("#declare Piece = sphere { 0.4*y, 0.4 }\n")
    scene = Chess(piece=str(file), sheet="none")
    shown = OpenGLView(scene).readout(SIZE)["shown"][..., 0] == verify_gl.WINDOW_FRAME + len(scene.openings)
    x = np.argwhere(shown).mean(0)[1]
    across = 0.8 / 8 * 6 / scene.view * SIZE[1]  # seen from 6 tiles before the sheets, 2 behind them
    assert shown.sum() == pytest.approx(np.pi / 4 * across**2, rel=0.08)
    assert x == pytest.approx(SIZE[0] / 2 - 0.5, abs=0.3)
    assert povgen.render(scene, renderer="gl", size=(64, 48), antialias="off").std() > 20


@pytest.mark.parametrize(
    ("renderer", "factor"),
    some([("gl", "1e-19"), ("povray", "*".join(6 * ["1e-30"])), ("gl", "1e20")], 2, several=True),
)
def test_the_length_of_a_laws_direction_does_not_matter(renderer, factor):
    made = [
        povgen.render(scene, size=SIZE, antialias="off", renderer=renderer)
        for scene in (
            Chess(sheet="law", law="x, y - 0.3*Y*z, z"),
            Chess(sheet="law", law=f"x*{factor}, (y - 0.3*Y*z)*{factor}, z*{factor}"),
        )
    ]
    assert made[0].std() > 30 and np.mean(np.abs(np.subtract(*made, dtype=float)).max(-1) > 8) < 0.01


@pytest.mark.parametrize(
    ("law", "drawn"),
    [
        ("x*1e-30*1e-30, y*1e-30*1e-30, z*1e-30*1e-30", False),
        ("x*1e30*1e30, y*1e30*1e30, z*1e30*1e30", False),
        ("x + X*z*1e-30*1e-30*1e30*1e30, y, z", False),  # a wrong direction, not black
        ("x*1e-19*1e-18, y*1e-19*1e-18, z*1e-19*1e-18", True),
        ("x*k, y*k, z*k", True),  # only a product of parameters, computed in Python
        ("x*X/abs(X), y, 0 - z", True),  # no light, with 64 bits neither
    ],
)
def test_a_law_that_32_bits_cannot_hold_is_refused(law, drawn):
    scene = Chess(sheet="law", law=law.replace("k", "(k*k/k/k)"), parameter={"k": 1e-30} if "k" in law else {})
    if drawn:
        check_gl(scene)
    else:
        with pytest.raises(InputError, match="32-bit numbers; allowed: parts of 1e-38 to 3e38, or --renderer povray"):
            check_gl(scene)


@pytest.mark.parametrize("renderer", ["gl", "povray"])
@pytest.mark.parametrize(("law", "passes"), [("z*7e5, z*7e5, z", True), ("z*7.2e5, z*7.2e5, z", False)])
def test_light_nearly_parallel_to_a_sheet_is_blocked(renderer, law, passes):
    """Where z of the new unit direction is 1e-6."""
    picture = povgen.render(Chess(sheet="law", law=law), size=(32, 32), antialias="off", renderer=renderer)
    assert (picture[16, 16].max() > 0) == passes


def test_what_is_no_longer_drawn_is_freed(text, drawer, monkeypatch):
    """Of each readout a framebuffer with three textures, and of each sky but the last one a texture."""
    used, scene, freed = drawer(64), json.loads(text) | {"pictures": {}}, []
    collect = used.gl.gc
    monkeypatch.setattr(used.gl, "gc", lambda: freed.append(collect()))
    for k in range(5):
        used.readout({**scene, "pictures": {"sky": png(k)}}, (64, 48))
    assert sum(freed) == 4 + 5 * 4  # the last sky is still kept
    for k in range(gl.PROGRAMS + 2):
        used.readout({**scene, "shader": f"{scene['share']}\n// {k}"}, (64, 48))
    assert len(used.programs) == gl.PROGRAMS


def png(k):
    file = BytesIO()
    Image.new("RGB", (8, 8), (k, 0, 0)).save(file, "PNG")
    return file.getvalue()


def test_every_thread_is_given_the_points_of_a_picture():
    found = povgen.points(PLAIN, SIZE)
    with ThreadPoolExecutor(2) as pool:
        for each in pool.map(lambda _: povgen.points(PLAIN, SIZE), range(4)):
            np.testing.assert_array_equal(each, found)


@pytest.mark.filterwarnings("ignore:.*fork")
def test_a_process_forked_after_drawing_is_given_points_too():
    found = povgen.points(PLAIN, SIZE)
    with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as pool:
        np.testing.assert_array_equal(pool.submit(povgen.points, PLAIN, SIZE).result(), found)


def test_tiles_are_the_whole_picture(drawer):
    scene = json.loads(gl_scene.to_text(Chess(), volumes(pieces(Chess()))))
    scene["pictures"] = {"mountains": mountains().content}
    whole = drawer(256).picture(scene, (150, 130), 5)
    assert np.array_equal(drawer(64).picture(scene, (150, 130), 5), whole)


def test_a_pixel_is_the_mean_of_a_finer_picture():
    """With the wide filter, which the reduced picture has too. A picture's rays fill its pixels, and no more."""
    scene = Chess(sheet="ideal")
    fine = povgen.render(scene, renderer="gl", size=(384, 288), antialias="off")
    made = povgen.render(scene, renderer="gl", size=(96, 72), antialias="4x")
    off = abs(made.astype(int) - light.reduced(fine, (96, 72))).max(-1)
    assert (off > 8).mean() < 0.01


# ---- As an option ----


def test_transparent_stereo_caption_and_overlay():
    options = {"renderer": "gl", "size": (96, 72), "antialias": "off"}
    sky = povgen.render(Chess(sheet="ideal"), **options)
    clear = povgen.render(Chess(sheet="ideal", background="transparent"), **options)
    solid = clear[..., 3] == 255
    assert 0.3 < solid.mean() < 0.9 and (clear[..., 3][~solid] == 0).all()
    assert np.array_equal(clear[solid][:, :3], sky[solid])
    pair = povgen.render(Chess(sheet="ideal"), stereo="pair", **options)
    left = povgen.render(Chess(sheet="ideal", eye=(-0.1, 0)), **options)
    assert np.array_equal(pair[:, :96], left) and not np.array_equal(pair[:, 96:], left)
    marked = povgen.render(Chess(sheet="ideal"), caption="full", overlay=True, **options)
    assert marked.shape[1:] == (96, 3) and len(marked) > 72


def test_a_movie_on_the_command_line_and_its_cache(tmp_path, monkeypatch):
    command = ["movie", "spheres", "--sweep", "alpha=0:90", "--frames", "4", "--size", "64x48", "-o", "a.mp4"]
    assert run([*command, "--renderer", "gl"], tmp_path)[0] == 0
    assert (tmp_path / "a.mp4").stat().st_size > 1000
    monkeypatch.setattr(gl_runner.Runner, "run", lambda *_: pytest.fail("rendered again"))
    assert run([*command, "--renderer", "gl"], tmp_path)[0] == 0
    monkeypatch.undo()


def test_the_renderers_have_frames_of_their_own_in_the_cache(monkeypatch):
    ours, theirs = (cache.frame_path("text", SMALL.replace(renderer=name)) for name in ("gl", "povray"))
    monkeypatch.setattr(gl_runner, "device", lambda: "another device")
    assert len({ours, theirs, cache.frame_path("text", SMALL)}) == 3


def test_what_it_cannot_show_is_refused(tmp_path):
    assert "--renderer povray" in refused(["frame", "chess", "--fresnel", "--renderer", "gl"], tmp_path)
    assert "renderer" in refused(["frame", "chess", "--renderer", "opengl"], tmp_path)


def test_without_moderngl_or_egl_the_remedy_is_said(tmp_path, monkeypatch):
    frame = ["frame", "chess", "--sheet", "none", "--renderer", "gl", "--size", "64x48"]
    monkeypatch.setenv("GLCONTEXT_LINUX_LIBEGL", "libmissing.so")
    gl_runner.device.cache_clear()
    assert "apt-get install libegl1" in refused(frame, tmp_path)
    monkeypatch.setattr(gl_runner, "find_spec", lambda name: None)
    message = refused(frame, tmp_path)
    assert remedies.extra("gl") in message and "allowed: renderer = 'povray'" in message
    assert "-      renderer gl: " in run(["check"], tmp_path)[1]


def test_check_names_the_device(tmp_path):
    device = gl_runner.device()
    assert f"ok     renderer gl: {device}" in run(["check"], tmp_path)[1] and "OpenGL" in device


# ---- The processes ----


@pytest.mark.parametrize(
    ("name", "count"),
    [("llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5", 16), ("NVIDIA H200/PCIe/SSE2, OpenGL 3.3.0 NVIDIA 580", 4)],
)
def test_a_graphics_processor_is_given_few_pictures_at_once(monkeypatch, name, count):
    monkeypatch.setattr(gl_runner, "device", lambda: name)
    monkeypatch.setattr(gl_runner, "cores", lambda: 16)
    assert gl_runner.at_once() == count


def test_a_crash_of_the_driver_costs_one_try(text, runner, tmp_path, monkeypatch):
    first = runner.run(text, SMALL, tmp_path).read_bytes()
    answer, crashed = gl_runner.Runner._answer, []

    def crashing(runner, process, timeout, asked=None):
        if asked and not crashed:
            crashed.append(process)
            os.kill(process.pid, signal.SIGSEGV)
        return answer(runner, process, timeout, asked)

    monkeypatch.setattr(gl_runner.Runner, "_answer", crashing)
    assert runner.run(text, SMALL, tmp_path).read_bytes() == first
    assert crashed and crashed[0] not in runner._idle


@pytest.mark.release
@pytest.mark.parametrize(
    ("number", "words"),
    [(signal.SIGSEGV, "signal 11: the graphics driver crashed, 2 times; allowed: renderer = 'povray'"),
     (signal.SIGKILL, "killed by signal 9, perhaps because memory is short, 2 times; allowed")],
)  # fmt: skip
def test_a_process_that_ends_twice(number, words, runner, monkeypatch):
    answer = gl_runner.Runner._answer

    def ended(runner, process, *given):
        process.send_signal(number)
        process.wait()
        return answer(runner, process, *given)

    monkeypatch.setattr(gl_runner.Runner, "_answer", ended)
    with pytest.raises(TransientError, match=words):
        runner.device()


@pytest.mark.release
def test_too_little_memory_is_no_missing_library(runner, tmp_path, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text(
        "import moderngl, resource\n"
        "def create(**_):\n"
        "    pages = int(open('/proc/self/statm').read().split()[0])\n"
        "    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + 2**26,) * 2)\n"
        "    raise Exception('eglInitialize failed')\n"
        "moderngl.create_context = create\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(InputError, match="^renderer = 'gl': too little memory to start it; allowed: renderer = 'pov"):
        runner.device()


@pytest.mark.release
def test_what_a_driver_or_python_writes_is_no_answer(text, tmp_path, monkeypatch):
    """And a relative PYTHONPATH is that of povgen's own working directory."""
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "sitecustomize.py").write_text(
        "print('{hello}', flush=True)\n"
        "import os, moderngl\n"
        "create = moderngl.create_context\n"
        "moderngl.create_context = lambda **given: (os.write(1, b'libGL: hello\\n'), create(**given))[1]\n"
        f"open({str(tmp_path / 'started')!r}, 'w').close()\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", "own", prepend=os.pathsep)
    started = gl_runner.Runner()
    try:
        assert "OpenGL" in started.device() and (tmp_path / "started").exists()
        assert frames.is_whole(started.run(text, SMALL, tmp_path).read_bytes(), SMALL.size)
    finally:
        started.stop()


def test_a_hanging_driver_is_ended(text, runner, tmp_path):
    with pytest.raises(
        PovrayError, match=r"than 0.01 s \(--timeout; a larger one is allowed\) and was stopped, 2 times"
    ):
        runner.run(text, SMALL.replace(timeout=0.01, size=(640, 480)), tmp_path)
    assert not runner._busy


def test_two_pictures_at_once_do_not_disturb_each_other(text, tmp_path):
    runner = gl_runner.Runner(2)
    folders = [tmp_path / str(k) for k in range(6)]
    for folder in folders:
        folder.mkdir()
    with ThreadPoolExecutor(2) as pool:
        pngs = {path.read_bytes() for path in pool.map(lambda folder: runner.run(text, SMALL, folder), folders)}
    assert len(pngs) == 1 and len(runner._own) == 2
    runner.stop()


def test_stopping_ends_a_picture(text, runner, tmp_path):
    errors = []

    def draw():
        try:
            runner.run(text, SMALL.replace(size=(4096, 4096), antialias="4x"), tmp_path)
        except PovrayError as error:
            errors.append(str(error))

    thread = threading.Thread(target=draw)
    thread.start()
    wait_for(lambda: runner._busy and (tmp_path / gl_runner.SCENE).exists())
    runner.stop()
    thread.join()
    assert errors == ["the drawing was stopped"]  # and not that its picture was drawn first


def test_a_wrong_shader_is_an_error_in_one_line(runner, tmp_path):
    broken = json.dumps(
        {"shader": "?", "share": "", "display": "", "uniforms": {}, "volumes": [], "pictures": {}, "grid": []}
    )
    with pytest.raises(PovrayError, match=r"^renderer gl: [^\n]*error[^\n]*$"):
        runner.run(broken, SMALL, tmp_path)
