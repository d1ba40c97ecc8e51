"""What is right is done, and nothing but numbers and known names gets into a scene."""

import re
from math import ceil

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.conftest import cases, tried
from fuzz.values import FIELDS, NUMBERS, rights, text_of
from povgen.sheets import PARAMETERS

pytestmark = pytest.mark.xdist_group("fuzz")  # in one process, because `place` takes long


RIGHT = {  # ranges in which all values go together
    **{"alpha": st.floats(-360, 360), "z2": st.floats(5, 150), "z1": st.floats(5, 2500), "view": st.floats(0.1, 100)},
    **{"prisms": st.integers(100, 3000), "index": st.floats(1.3, 4), "base_angle": st.floats(45, 60)},
    **{"gap": st.floats(1e-3, 0.5), "aspect": st.floats(1, 1.5), "aperture": st.floats(2, 5)},
    **{"piece": rights("piece"), "x": st.floats(-10, 10), "pedestal": st.floats(0.1, 10)},
}
STATED = {"z1": "Z1", "z2": "Z2", "aperture": "Window", "view": "ViewHeight", "x": "PieceX", "pedestal": "Pedestal"}
STATED |= {"index": "GlassIndex", "base_angle": "BaseAngle", "gap": "AirGap", "aspect": "Aspect", "prisms": "Prisms"}


@cases(30)
@given(st.fixed_dictionaries(RIGHT))
def test_what_is_right_is_done(given):
    options = [f"--{name.replace('_', '-')}={text_of(value)}" for name, value in given.items()]
    status, source, said = tried(["pov", "chess", *options])
    assert status == 0, said
    for name, parameter in STATED.items():
        assert re.search(rf"#declare {parameter} += {re.escape(f'{given[name]:.15g}')};", source), parameter


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
