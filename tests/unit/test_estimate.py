"""What povgen says of the time that rendering takes, before it begins."""

from itertools import accumulate

import pytest
from conftest import povgen, refused

from povgen import Chess, PovrayError, Rendering
from povgen.errors import TransientError
from povgen.rendering import estimate
from povgen.rendering.parallel import cores
from povgen.scene.sdl import to_pov

COST = estimate.Cost(start=0.5, text=0.1, picture=0.2, ray=1e-5)


@pytest.mark.parametrize("renderer", ["povray", "gl"])
def test_what_is_measured(renderer, monkeypatch):
    """Small pictures of the scenes take a known time. Nothing is kept in the cache."""
    spent, sizes = [COST.start], []

    def render(scene, text, runner, rendering):
        assert rendering.renderer == renderer and rendering.antialias is None and rendering.timeout == 7
        assert text == "ViewHeight/720"
        sizes.append(rendering.size)
        spent.append(COST.picture + COST.ray * rendering.size[0] * rendering.size[1])
        if renderer == "gl" and len(sizes) > 2:  # the processes have been started
            spent[-1] -= COST.picture

    monkeypatch.setattr(estimate, "_cpu", lambda runner: [*accumulate(spent)][-1])
    monkeypatch.setattr(estimate, "_render", render)
    scenes = [Chess(alpha=alpha, sheet="ideal") for alpha in (1, 2)]

    def written(scene):
        spent.append(COST.text)
        return "ViewHeight/image_height"

    assert written(scenes[0]) in to_pov(Chess(sheet="law", law="x, abs(y), z")) and spent.pop()
    monkeypatch.setattr(estimate, "renderer_of", lambda *a: (written, Stopped(), 1))
    assert estimate.measured(scenes, Rendering(renderer=renderer, timeout=7)) == pytest.approx(COST)
    assert sizes == [size for size in estimate.SIZES[: 3 if renderer == "gl" else 2] for _ in scenes]


class Stopped:
    def run(self, *_):
        raise PovrayError("POV-Ray was stopped")

    def stop(self):
        pass


def test_the_error_of_a_small_picture_names_its_frame(monkeypatch):
    monkeypatch.setattr(estimate, "renderer_of", lambda *a: (str, Stopped(), 1))
    with pytest.raises(PovrayError, match="^POV-Ray was stopped\n  in the frame with alpha = 1.0, sheet = 'ideal'$"):
        estimate.measured([Chess(alpha=1, sheet="ideal")], Rendering())


def test_what_costs_more(monkeypatch):
    """The numbers of rays are those that docs/chart/frames.csv leads to."""
    monkeypatch.setattr(estimate, "measured", lambda scenes, rendering: COST)

    def cpu(scenes, **options):
        return estimate.estimate(scenes, Rendering(size=(640, 480), **options)).cpu - COST.start

    one = cpu([Chess()], antialias="off")
    assert cpu([Chess(alpha=alpha) for alpha in (1, 2, 3)], antialias="off") == pytest.approx(3 * one)
    assert cpu([Chess()] * 3, antialias="off") == pytest.approx(one)  # a movie's picture that stays is rendered once
    assert cpu([Chess()], antialias="off", stereo="pair") == pytest.approx(2 * one)
    for sheet, width, antialias, measured in (
        ("detailed", 320, "1,0.1,3", 7.7),
        ("ideal", 640, "1,0.1,3", 2.3),
        ("ideal", 640, "1,0.3,2", 1.23),
        ("detailed", 320, "1,0.3,2", 3.5),
    ):
        found, off = (
            estimate.rays([Chess(sheet=sheet)], Rendering(antialias=each, size=(width, width * 3 // 4)))
            for each in (antialias, "off")
        )
        assert found / off == pytest.approx(measured, rel=0.3), (sheet, antialias)
    mixed, sampling = [Chess(), Chess(sheet="none")], Rendering(size=(640, 480))
    assert estimate.rays(mixed, sampling) == 2 * estimate.rays(mixed[:1], sampling)  # all have that of the prisms


def test_a_time_in_words():
    found = [estimate.duration(seconds) for seconds in (0.04, 2.4, 9.6, 34, 59, 90, 599, 3599, 4000, 5e6)]
    assert found == "0.04 s, 2 s, 10 s, 30 s, 60 s, 1.5 min, 10 min, 60 min, 1.1 h, 1400 h".split(", ")


def test_what_a_dry_run_says(tmp_path, monkeypatch):
    for scenes, size, said in (
        ([Chess()], (480, 360), "a picture of 480x360 pixels, about 8 CPU seconds: "),
        ([Chess(alpha=n % 4) for n in range(24)], (64, 48), "24 frames, 4 of them different, of 64x48 pixels, "),
    ):
        text = estimate.describe(scenes, Rendering(size=size), estimate.Estimate(8, 90))
        assert text.startswith(said) and text.endswith(f": about 1.5 min on {cores()} cores if none is in the cache")
    monkeypatch.setattr(estimate, "measured", lambda *_: COST)  # test_records.py measures
    status, out, err = povgen(["movie", "vary-alpha", "--frames", "4", "--size", "64x48", "--dry-run"], tmp_path)
    assert (
        status == 0 and out.startswith("4 frames of 64x48 pixels, about ") and not err and not list(tmp_path.iterdir())
    )
    assert "--sheet auto, which renders" in refused(
        ["frame", "chess", "--dry-run", "--sheet", "auto", "--tolerance", "1px"], tmp_path
    )


def test_what_is_long(monkeypatch):
    """Small pictures are rendered only if the pictures may take a minute."""
    measured = []
    monkeypatch.setattr(estimate, "measured", lambda scenes, rendering: measured.append(len(scenes)) or COST)
    many = [Chess(alpha=alpha) for alpha in range(100)]
    assert estimate.if_long(many, Rendering()).startswith("100 frames of 960x720 pixels") and measured == [3]
    assert estimate.if_long([Chess()], Rendering(quality="draft")) is None and measured == [3]
    assert estimate.if_long([Chess()], Rendering(quality="high")) is None and measured == [3, 1]

    def fail(*_):
        raise TransientError("POV-Ray was killed")

    monkeypatch.setattr(estimate, "measured", fail)
    assert estimate.if_long(many, Rendering()) is None  # the pictures themselves can succeed
