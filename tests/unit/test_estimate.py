"""What povgen says of the time that rendering takes, before it begins."""

import pytest
from conftest import povgen, refused

from povgen import Chess, MovieSpec, Rendering
from povgen.rendering.estimate import cpu_seconds, describe, duration, is_long

PLAIN = Rendering(size=(640, 480), antialias="off")


def ratio(first, second):
    return cpu_seconds(*first) / cpu_seconds(*second)


def test_what_costs_more():
    """The measured ratios are those of docs/speed.md, 640x480 and 320x240."""
    one = [Chess()], PLAIN
    assert ratio(([Chess(alpha=alpha) for alpha in (1, 2, 3)], PLAIN), one) == pytest.approx(3)
    assert ratio(([Chess()] * 3, PLAIN), one) == pytest.approx(1)  # a movie's picture that stays is rendered once
    assert ratio(one, ([Chess(sheet="ideal")], PLAIN)) == pytest.approx(1.84 / 0.42, rel=0.3)
    assert ratio(one, ([Chess()], PLAIN.model_copy(update={"renderer": "gl"}))) == pytest.approx(10, rel=0.3)
    assert ratio(([Chess(window="z=2")], PLAIN), one) == pytest.approx((1.84 + 1.4) / 1.84, rel=0.3)
    small = {"size": (320, 240)}
    for sheet, antialias, measured in (
        ("detailed", "2x", 1.969 / 0.528),
        ("detailed", "1,0.1,3", 4.064 / 0.528),
        ("ideal", "1,0.1,3", 0.461 / 0.13),
    ):
        scene = Chess(sheet=sheet)
        found = ratio(
            ([scene], Rendering(antialias=antialias, **small)), ([scene], Rendering(antialias="off", **small))
        )
        assert found == pytest.approx(measured, rel=0.3), (sheet, antialias)
    assert ratio(([Chess()], Rendering(stereo="pair")), ([Chess()], Rendering())) == pytest.approx(2)


def test_a_time_in_words():
    found = [duration(seconds) for seconds in (0.04, 2.4, 9.6, 34, 59, 90, 599, 3599, 4000, 5e6)]
    assert found == "0.04 s, 2 s, 10 s, 30 s, 60 s, 1.5 min, 10 min, 60 min, 1.1 h, 1400 h".split(", ")


def test_a_dry_run_renders_nothing(tmp_path):
    for arguments, said in (
        (["movie", "vary-alpha", "--frames", "4", "--size", "64x48"], "4 frames of 64x48 pixels, about "),
        (["movie", "vary-alpha", "--frames", "4", "--hold", "1"], "24 frames, 4 of them different, of 480x360 pixels,"),
        (
            ["movie", "vary-alpha", "--frames", "4", "--loop"],
            "6 frames, 4 of them different, of 480x360 pixels, about ",
        ),
        (["frame", "chess"], "a picture of 480x360 pixels, about "),
        (["frame", "chess", "--size=1920x1080", "--antialias=2,0.1,9"], "a picture of 1920x1080 pixels, about 630 CPU"),
        (["movie", "vary-alpha", "--frames", "4", "--shard", "5/7"], "0 frames of 480x360 pixels, about 0 CPU seconds"),
    ):
        status, out, err = povgen([*arguments, "--dry-run"], tmp_path)
        assert status == 0 and out.startswith(said) and not err and not list(tmp_path.iterdir())
    assert "--sheet auto, which renders" in refused(
        ["frame", "chess", "--dry-run", "--sheet", "auto", "--tolerance", "1px"], tmp_path
    )


def test_the_number_of_frames_is_that_of_the_option():
    for quality in ("draft", "standard", "high", "hd"):
        spec = MovieSpec.of_sweeps("chess", ["alpha=0:90"], {"frames": 7, "exact_frames": True})
        assert len(spec.scenes(quality)) == spec.count(quality) == 7 and spec.rate(quality) == spec.frame_rate


def test_what_is_long():
    assert is_long([Chess(alpha=alpha) for alpha in range(100)], Rendering()) and not is_long([Chess()], Rendering())


def test_the_renderer_gl_is_faster_on_a_gpu():
    assert describe([Chess()], Rendering()).endswith(" cores")
    assert describe([Chess()], Rendering(renderer="gl")).endswith(" cores without a GPU")
