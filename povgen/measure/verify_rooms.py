"""Compare random rooms as both renderers show them, and with the ray trace: a part of `povgen verify --gl`."""

from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from numpy.random import Generator

from povgen.errors import InputError
from povgen.measure.measured import Measured
from povgen.measure.opengl import OpenGLView
from povgen.measure.probes import Size
from povgen.objects import OBJECTS
from povgen.objects.scene_object import SceneObject
from povgen.objects.window import Window
from povgen.optics.equations import Booleans
from povgen.optics.trace import End
from povgen.scene.room import Eye, Room
from povgen.video.still import render

SKY, WINDOW_FRAME = 0, 2  # povgen/liveview/windows.glsl: the frames' numbers, then those of the objects
SAME = 15  # of 255: two pixels whose colours differ by less show the same
SIZE = (160, 120)
SHADOW_RAYS = 13  # through the same point, for soft shadows: each ray tests whether one of the sun's lights is hidden
PRISMS = ("detailed", "single")
IDEAL = ("ideal", "lens", "mirror", "axis", "view-rotator", "refraction")


def checks(count: int = 60, size: Size = SIZE) -> Iterator[Measured]:
    """Measure `count` random rooms."""
    same: list[float] = []
    ideal: list[Booleans] = []
    designed: list[Booleans] = []
    for seed in range(count):
        room = random_room(np.random.default_rng(seed))
        view = OpenGLView(room)
        found = view.picture(size, SHADOW_RAYS, part=0).astype(int)
        same.append((abs(found - render(room, size=size, antialias="off").astype(int)).max(-1) < SAME).mean())
        off, traced = directions(room, view, size)
        passes = (traced.end <= End.BACK) & (traced.windows >= 0).any(-1) & np.isfinite(off)
        (designed if room.has_prisms else ideal).append((off < 1e-3)[passes & traced.designed])
    many = f"{count} random rooms"
    what = f"pixels that show the same as POV-Ray's: {many}"
    yield Measured("gl", what, 100 * sum(same) / count, 99.5, "%", least=True)
    what = "directions within 1e-3 rad of the ray trace"
    for kind, parts, least in (("ideal sheets", ideal, 99.9), ("designed path through prisms", designed, 99.8)):
        yield Measured("gl", f"{what}, {kind}: {many}", 100 * np.concatenate(parts).mean(), least, "%", least=True)


def directions(room: Room, view: OpenGLView, size: Size) -> tuple[Any, Any]:
    """Return the angles (height, width), rad, between the last directions of gl's rays and of the ray trace's.

    Also return the ray trace. Objects are left out. A ray that gl calls lost is off by pi. The angle is NaN where gl
    shows a frame.
    """
    bare = room.replace(object=())
    view.set(bare)
    read = view.readout(size)
    traced = bare.trace(bare.rays(size), 180)
    off = np.linalg.norm(read["ray"][..., :3] - traced.direction, axis=-1)
    what = read["shown"][..., 0]
    return np.where(what == -1, np.pi, np.where(what == SKY, off, np.nan)), traced


def random_room(rng: Generator) -> Room:
    """Return a room of 2 to 6 windows and 3 to 8 objects in random poses, none in another, seen from 9 tiles away."""
    kinds = [IDEAL, (*IDEAL, *PRISMS)][rng.integers(2)]
    room = Room(eye=Eye(z=-9, view=6), background="white")
    for wanted, make in ((rng.integers(2, 7), partial(_window, kinds)), (rng.integers(3, 9), _thing)):
        made = 0
        while made < wanted:
            with suppress(InputError):  # it overlaps another, or the eye
                thing = make(rng)
                name = "window" if isinstance(thing, Window) else "object"
                room = room.replace(**{name: (*getattr(room, name), thing)})
                made += 1
    return room


def _pose(rng: Generator) -> dict[str, float]:
    place, turns = rng.uniform((-2.5, -2, -3), (2.5, 2, 4)), rng.uniform(-60, 60, 3)
    yaw = turns[0] + 180 * rng.integers(2)  # some are seen from behind
    return dict(zip(("x", "y", "z", "yaw", "pitch", "roll"), map(float, (*place, yaw, *turns[1:])), strict=True))


def _window(kinds: tuple[str, ...], rng: Generator) -> Window:
    width, height = rng.uniform(1, 2.2, 2)
    values: dict[str, Any] = {"sheet": rng.choice(kinds), "alpha": rng.uniform(-180, 180), "width": width}
    values |= {"height": height, "outline": rng.choice(["rectangle", "round"]), "frame": bool(rng.integers(2))}
    return Window(**values, prisms=20, **_pose(rng))


def _thing(rng: Generator) -> SceneObject:
    kind = rng.choice(["sphere", "box", "text", "ruler", "pedestal", "piece"])
    values: dict[str, Any] = {"width": 0.8, "height": 0.6, "depth": 0.5} if kind == "box" else {}
    return OBJECTS[kind](**values, **_pose(rng))
