"""Points of rooms are seen where they are predicted, in both renderers."""

import numpy as np
import pytest

from povgen import InputError, Room, Sphere, Window, render

SIZE = 160, 120


def rooms(rng, count):
    """Yield rooms with a small ball behind random windows, and the only image of it."""
    while count:
        kinds = rng.choice(["ideal", "mirror", "lens", "refraction", "axis"], 3)
        windows = [
            Window(
                sheet=kind, alpha=rng.uniform(-90, 90), focal_length=5, ratio=0.8, frame=bool(rng.integers(2)),
                x=x, z=rng.uniform(-1, 1), yaw=rng.uniform(-30, 30), pitch=rng.uniform(-20, 20), width=1.8,
            )
            for kind, x in zip(kinds, (-2, 0, 2), strict=True)
        ]  # fmt: skip
        ball = Sphere(x=rng.uniform(-2, 2), y=rng.uniform(-0.4, 0.4), z=rng.uniform(1, 3), radius=0.06, color="red")
        try:
            room = Room([*windows, ball], background="black")
        except InputError:  # two windows cross
            continue
        images = room.images(ball.point)
        if len(images) == 1 and images[0].windows and abs(images[0].position) < 2.2:
            count -= 1
            yield room, images[0].position


@pytest.mark.parametrize("renderer", ["gl", pytest.param("povray", marks=pytest.mark.release)])
def test_a_ball_is_seen_where_it_is_predicted(renderer, rng):
    seen = 0
    for room, position in rooms(rng, 5):
        picture = render(room, renderer=renderer, size=SIZE, quality="draft").astype(int)
        red = picture[..., 0] - picture[..., 1:].max(-1)
        y, x = np.nonzero(red > 60)
        if not len(x):
            continue  # in the shadow of a frame
        found = (x.mean() + 0.5 - SIZE[0] / 2 - 1j * (y.mean() + 0.5 - SIZE[1] / 2)) * 5 / SIZE[1]
        assert abs(found - position) < 1.5 * 5 / SIZE[1]
        seen += 1
    assert seen >= 4
