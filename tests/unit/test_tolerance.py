"""`--sheet auto`: tolerances, and the blocks of the window that a trial renders."""

import numpy as np
import pytest

from povgen import Chess, Rendering
from povgen.errors import InputError
from povgen.rendering.auto import MAX_SHARE, MOSAIC_SIDES, Tolerance, choose, mosaic
from povgen.scene.camera import window

SIZE = (320, 240)
STANDARD = Rendering(size=SIZE)


@pytest.mark.parametrize("size", [(64, 48), (640, 480)], ids=str)
def test_a_trial_renders_little_and_all_over_the_window(size):
    scene = Chess(x=0.3, eye=(0, 0.27))
    part = mosaic(scene, size)
    rows, columns = window(scene, size)
    y, x = np.array(part.blocks)[..., 1], np.array(part.blocks)[..., 0]
    assert rows.start <= y.min() and y.max() + part.side <= rows.stop
    assert columns.start <= x.min() and x.max() + part.side <= columns.stop
    height, width = rows.stop - rows.start, columns.stop - columns.start
    assert y.size * part.side**2 <= max(MAX_SHARE * height * width, MOSAIC_SIDES[0] ** 2)
    assert (
        y.size * part.side**2 <= MOSAIC_SIDES[1] ** 2
        and y.max() - y.min() > height / 4
        and x.max() - x.min() > width / 4
    )
    assert mosaic(scene, size) == part


def test_nothing_is_tried_where_nothing_is_seen():
    hidden = Chess(eye=(0, 7.67), z2=0.3)
    assert mosaic(hidden, SIZE) is None
    assert choose([hidden], STANDARD, Tolerance(flip=0.01))[0].antialias == "off"


@pytest.mark.parametrize(
    "text",
    ["1", "-1px", "0px", "1px,2px", "nanpx", "1px,", "٣px", None],
)
def test_tolerances_that_are_none(text):
    with pytest.raises(InputError, match="1px,0.2flip"):
        Tolerance.parse(text)


def test_tolerances():
    assert Tolerance.parse("0.5px") == Tolerance(px=0.5)
    assert Tolerance.parse("2px, .1flip") == Tolerance(px=2, flip=0.1)
