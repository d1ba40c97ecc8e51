"""What is right is done, and nothing but numbers and known names gets into a scene."""

import re
from math import ceil

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.conftest import cases, tried
from fuzz.values import FIELDS, NUMBERS, rights, text_of
from povgen.scene.scenes import SCENES
from povgen.sheets import PARAMETERS

pytestmark = pytest.mark.xdist_group("fuzz")  # in one process, because `place` takes long


@cases(30)
@given(st.data())
def test_what_is_right_is_done(data):
    scene = data.draw(st.sampled_from([*SCENES]))
    given = {
        "alpha": data.draw(st.floats(-360, 360)),
        "z2": data.draw(st.floats(5, 150)),
        "prisms": data.draw(st.integers(100, 3000)),
        "index": data.draw(st.floats(1.3, 4)),
        "base_angle": data.draw(st.floats(45, 60)),
        "gap": data.draw(st.floats(1e-3, 0.5)),
        "aspect": data.draw(st.floats(1, 1.5)),
        "aperture": data.draw(st.floats(2, 5)),
        "view": data.draw(st.floats(0.1, 100)),
        "z1": data.draw(st.floats(5, 2500)),
        "eye": data.draw(st.tuples(st.floats(-10, 10), st.floats(-1, 10))),
        "sheet": data.draw(st.sampled_from(["detailed", "ideal", "single", "none"])),
    }
    if scene == "chess":
        given["piece"] = data.draw(rights("piece"))
        given["x"] = data.draw(st.floats(-10, 10))
        given["pedestal"] = data.draw(st.just(0.0) | st.floats(0, 10))
    else:
        given["line"] = data.draw(st.tuples(st.floats(-10, 10), st.floats(-10, 10)))
    status, source, said = tried(
        ["pov", scene, *(f"--{name.replace('_', '-')}={text_of(x)}" for name, x in given.items())]
    )
    assert status == 0, said
    stated = dict(zip(("EyeX", "EyeY"), given["eye"], strict=True))
    stated |= {"Z2": given["z2"], "Window": given["aperture"], "ViewHeight": given["view"]}
    if given["sheet"] in ("detailed", "single"):
        stated |= {"GlassIndex": given["index"], "BaseAngle": given["base_angle"]}
        stated |= {"AirGap": given["gap"], "Aspect": given["aspect"], "Prisms": given["prisms"]}
    if scene == "chess":
        stated |= {"Z1": given["z1"], "PieceX": given["x"]}
        stated |= {"Pedestal": given["pedestal"]} if given["pedestal"] else {}
    else:
        stated |= dict(zip(("LX", "LY"), given["line"], strict=True))
    for parameter, value in stated.items():
        assert re.search(rf"#declare {parameter} += {re.escape(f'{value:.15g}')};", source), parameter


BOUNDS = {
    **{"alpha": (-360, 360), "z2": (0, 150), "prisms": (1, 3000), "z1": (0, 5000), "x": (-10, 10)},
    **{"index": (1.1, 4), "base_angle": (15, 75), "gap": (0.001, 0.5), "aspect": (0, 2)},
    **{
        "aperture": (0.5, 10),
        "pedestal": (0, 10),
        "view": (0.1, 100),
        "wavelength": (180, 10000),
        "timeout": (0, 1e6),
        "eye_distance": (0, 5),
        **{name: (each.least, each.most) for name, (each, *_) in PARAMETERS.items() if "number" in each.kind},
    },
}


@cases(120)
@given(st.data())
def test_numbers(data):
    """An accepted value is a number, as Python reads it, within the bounds that the help states."""
    name = data.draw(st.sampled_from([name for name, field in FIELDS.items() if field.annotation in (int, float)]))
    low, high = BOUNDS[name]
    numbers = st.floats(-2 * high, 2 * high).map(repr) | st.integers(-5, 2 * ceil(high)).map(str)
    text = data.draw(st.sampled_from(NUMBERS) | numbers)
    line = ["frame", "chess", "--sheet=none", "--size=32x32", f"--{name.replace('_', '-')}={text}"]
    line += ["--stereo=pair"] * (name == "eye_distance") + ["--glass=BK7"] * ("wavelength" in name)
    if tried(line)[0] == 0:
        assert low <= float(text) <= high
