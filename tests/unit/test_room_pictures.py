"""What is written and drawn on pictures of rooms: captions, marks of predicted places."""

import numpy as np
import pytest

from povgen.objects.box import Box
from povgen.objects.floor import Floor
from povgen.objects.pedestal import Pedestal
from povgen.objects.piece import Piece
from povgen.objects.sphere import Sphere
from povgen.objects.text import Text
from povgen.objects.window import Window
from povgen.scene.room import Eye, Room
from povgen.scene.scene import object_images
from povgen.settings import Rendering
from povgen.video import overlay
from povgen.video.caption_texts import captions

SIZE = 640, 480
LEFT, RIGHT = Window(name="left", alpha=90, x=-1.75), Window(alpha=40, x=1.75, sheet="detailed")
KNIGHT, SPHERE = Piece(x=-1.6, y=-0.85, z=2.5), Sphere(name="ball", x=3.9, radius=0.3)
ROOM = Room(
    [Floor(y=-1.65), LEFT, RIGHT, Pedestal(x=-1.6, y=-1.65, z=2.5), KNIGHT, SPHERE, Text(text="90", y=2.2)],
    eye=Eye(y=0.5, z=-9, view=7),
)


def said(*rooms, **options):
    return [[*each.texts] for each in captions(rooms, Rendering(**options))]


def test_a_caption_says_what_stands_there():
    short = ["2 windows: ideal α = 90°, detailed α = 40°", "knight, sphere, text"]
    assert said(ROOM, caption="short") == [short]
    assert said(ROOM, caption="full", note="Question 1") == [
        [*short, "eye at (0, 0.5, -9), looks at (0, 0, 0)", "Question 1"]
    ]
    assert said(ROOM.replace(pupil=0.3), caption="full")[0][3:] == ["pupil = 0.3 tiles"]
    lines = {
        "no window": [],
        "1 window: law k = 0.3": [Window(sheet="law", law="x + k*z, y, z", parameter={"k": 0.3})],
        "3 windows: mirror line at 20°, 2 × empty": [
            Window(sheet="mirror", alpha=40),
            *(Window(sheet="none", x=x) for x in (4, 8)),
        ],
        "2 windows: ideal α = -30°": [Window(alpha=-30, x=x) for x in (0, 4)],
        "6 windows": [Window(alpha=x, x=4 * x) for x in range(6)],
        "1 window: refraction index behind/in front = 0.7, light turned by 20°": [
            Window(sheet="refraction", ratio=0.7, alpha=20)
        ],
    }
    assert [said(Room(windows), caption="short") for windows in lines.values()] == [[[line]] for line in lines]
    assert said(Room([Box(), Box(z=3), KNIGHT]), caption="short") == [["no window", "2 boxes, knight"]]


def test_a_movies_caption_says_what_changes():
    movie = [
        Room([LEFT.replace(alpha=alpha), KNIGHT.replace(yaw=20 * alpha)], eye=Eye(x=x, z=-9, view=4 + x))
        for alpha, x in ((10, 0), (12.5, 0.25))
    ]
    assert said(*movie, caption="short") == [
        ["left: α = 10.0°", "piece1: yaw = 200°", "eye: x = 0.00 tiles", "eye: view = 4.00 tiles"],
        ["left: α = 12.5°", "piece1: yaw = 250°", "eye: x = 0.25 tiles", "eye: view = 4.25 tiles"],
    ]
    assert said(Room([SPHERE]), Room([SPHERE.replace(x=1), Window(z=-1)]), caption="short")[1] == [
        "ball: x = 1.0 tiles"
    ]
    many = [Room([Sphere(x=i + k / 10, z=3, radius=0.2) for i in range(20)]) for k in (0, 1)]
    assert said(*many, caption="short") == [["20 numbers change"]] * 2
    for values, lines in {
        ("pupil", 0.0, 0.4): ["pupil = 0.00 tiles", "pupil = 0.40 tiles"],
        ("focus", 3, "best"): ["focus = 3 tiles", "focus = best"],
        ("wavelength", 450, 600): ["wavelength = 450 nm", "wavelength = 600 nm"],
    }.items():
        movie = [Room([Window(glass="N-BK7"), KNIGHT], **{values[0]: value}) for value in values[1:]]
        assert [texts[0] for texts in said(*movie, caption="short")] == lines


def dots(picture, colour):
    """Return the place in the picture's plane of the dots of this colour: x + iy, their mean, tiles."""
    y, x = np.nonzero((picture == colour[:3]).all(-1))
    return (x.mean() + 0.5 - SIZE[0] / 2 - 1j * (y.mean() + 0.5 - SIZE[1] / 2)) * 7 / SIZE[1]


def test_marks_are_where_the_eye_sees_the_objects():
    rendering = Rendering(overlay=True)
    legend = overlay.legend(ROOM, rendering)
    assert legend == [overlay.THROUGH, overlay.DIRECTLY]
    made = overlay.annotated(np.full((*SIZE[::-1], 3), 60, np.uint8), ROOM, rendering)
    knight, ball, text = (images for _, images in object_images(ROOM))
    assert [len(knight), len(ball), len(text)] == [1, 1, 1]
    picture = made[len(made) - SIZE[1] :]
    assert dots(picture, overlay.P_COLOUR) == pytest.approx(knight[0].position, abs=0.02)
    both = (ball[0].position + text[0].position) / 2
    assert dots(picture, overlay.POINT_COLOUR) == pytest.approx(both, abs=0.02)
    assert text[0].corners[-1] == pytest.approx([0, 2.2 - ROOM.object[-1].size[1] / 2, 0])
    assert overlay.legend(ROOM, Rendering(caption="full")) == []


def test_it_is_said_what_has_no_image():
    hidden = Room([Window(alpha=90), KNIGHT.replace(x=0, y=-2), Sphere(z=-20), Sphere(z=-1), Pedestal(z=-9, y=-3)])
    texts = ["1 window: ideal α = 90°", "knight, 2 spheres", "not seen: foot of knight, middle of sphere1"]
    assert said(hidden, caption="short", overlay=True) == [texts]
    assert said(hidden, overlay=True) == [texts[-1:]] and said(hidden, caption="short") == [texts[:-1]]
    assert said(ROOM, overlay=True) == [[]]
    assert said(Room([LEFT, Floor(y=-2)]), overlay=True) == said(Room(), overlay=True) == [[]]
    many = Room([Sphere(name=f"ball{n}", z=-20 - n, radius=0.3) for n in range(9)])
    names = [f"middle of ball{n}" for n in range(3)]
    assert said(many, overlay=True) == [[f"not seen: {', '.join(names)}, 6 others"]]
